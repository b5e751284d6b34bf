//! Keys of every table: the device at a port; and metadata of every log.

use super::kind::Conduct;
use fracdiff::{Scheme, parameter::Shown};
use haptic_document::{
    FileError, Table, parameters as p,
    parameters::{DEVICE, Parameter},
};
use haptic_link::Limits;
use haptic_run::{
    device::DeviceName,
    remote::{RemoteDevice, device_name},
};
use haptic_trial::{
    device_table::{calibration, without},
    safety::Safety,
};
use std::collections::BTreeMap;

/// The device at a port; `None` for the simulated one.
pub(crate) fn remote(table: &Table<'_>) -> Result<Option<RemoteDevice>, FileError> {
    remote_by(table, &p::DEVICE)
}

/// The device at a port that this parameter names.
pub(crate) fn remote_by(
    table: &Table<'_>,
    name: &Parameter,
) -> Result<Option<RemoteDevice>, FileError> {
    let device = table.text(name)?.parse::<DeviceName>();
    let device = device.map_err(|reason| table.fail_at(name.key, reason))?;
    let loop_mode = table.choice(&p::LOOP)?;
    let watchdog_s = table.number_if(&p::WATCHDOG)?;
    if let Some(time) = watchdog_s.filter(|time| (1e3 * time - (1e3 * time).round()).abs() > 1e-6) {
        return Err(table.fail_at(
            "watchdog_s",
            format_args!(
                "watchdog_s = {time} is not a whole number of milliseconds: write 0.005 for 5 ms",
                time = Shown(time)
            ),
        ));
    }
    let late_ticks = table.count_in(&p::LATE_TICKS, 0..=u64::from(u16::MAX))? as u16;
    let most = u64::from(Limits::MAX_AGE_TICKS);
    let max_age_ticks = table.count_in(&p::MAX_AGE_TICKS, 1..=most)? as u16;
    let Some(name) = device.0 else {
        // A file may say them for the device that is given with it.
        let idle = [&p::LOOP, &p::WATCHDOG, &p::LATE_TICKS, &p::MAX_AGE_TICKS];
        return without(
            table,
            idle,
            &format!("on the simulated device: give {DEVICE} too, as serial:PATH"),
        )
        .map(|()| None);
    };
    Ok(Some(RemoteDevice {
        loop_mode,
        watchdog_ms: watchdog_s.map(|time| (1e3 * time).round() as u16),
        late_ticks,
        max_age_ticks,
        calibration: calibration(table)?,
        ..RemoteDevice::new(name)
    }))
}

/// Metadata for the log of a run of this kind, besides its document, or over it where the program decides what really runs.
pub(crate) fn metadata(
    kind: &str,
    conduct: &Conduct,
    scheme: Scheme,
    safety: &Safety,
) -> BTreeMap<String, String> {
    let words = [
        ("experiment", kind.to_owned()),
        ("pace", conduct.pace.to_string()),
        ("scheme", scheme.to_string()),
        ("device", device_name(conduct.remote.as_ref())),
    ];
    let numbers = safety.numbers();
    let numbers = numbers.map(|(key, value)| (key, value.to_string()));
    let all = words.into_iter().chain(numbers);
    all.map(|(key, value)| (key.to_owned(), value)).collect()
}
