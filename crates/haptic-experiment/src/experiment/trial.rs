//! A device that hits a wall and is pushed into it, as an experiment: its plan and the try-out in virtual time are in [`haptic_judge::trial`].

mod law_there;
mod report;
mod second;

use super::{drive::second_device, kind::Conduct, reading::remote};
use haptic_document::{FileError, Table, parameters as p};
use haptic_link::LoopMode;
use haptic_run::remote::RemoteDevice;
pub(crate) use law_there::{law_of, no_law_there};
pub(crate) use report::{Conducted, OfSample, OffN, Seen, Trial, incomparable, limited};

/// Reads a law on a pushed device, beside the drive that pushes it.
pub(crate) fn conducted<T>(
    table: &Table<'_>,
    drive: Option<&Table<'_>>,
    read: impl FnOnce([Option<LoopMode>; 2]) -> Result<T, FileError>,
) -> Result<Conducted<T>, FileError> {
    let conduct = Conduct::on(remote(table)?);
    let second = match drive.filter(|drive| drive.has(&p::DRIVE_DEVICE)) {
        Some(drive) => second_device(drive, conduct.remote.as_ref())?.map(|device| device.remote),
        None => None,
    };
    let second_at = second
        .as_ref()
        .map(|second: &RemoteDevice| second.loop_mode);
    Ok(Conducted {
        trial: read([conduct.at_port(), second_at])?,
        conduct,
        second,
    })
}
