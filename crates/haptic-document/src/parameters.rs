//! Parameters: key, default, range and a line for people, once. Files, options with their help, and the reference of keys are
//! made from tables of them. Each kind of experiment has its own beside it; here are those that several share.
//!
//! KeyTable carry the SI unit of the value. `shown` is the default as a person writes it, and its value is the same (a test
//! holds each against the number).

mod common;
mod controller;
mod kind;
pub mod range;

pub use common::*;
pub use controller::*;
pub use kind::{KeyTable, Parameter, Value, joined};
pub use range::{Range, in_degrees};

use haptic_quantity::Key;
use std::path::Path;

/// Runs although the analysis says no.
pub const FORCE_UNSTABLE: Key = Key("force_unstable");
/// Folder or file for what a command writes.
pub const OUT: Key = Key("out");
/// Leave to write over a file or into a folder that is there.
pub const OVERWRITE: Key = Key("overwrite");
/// Runs by the clock.
pub const REALTIME: Key = Key("realtime");
/// Share of the ticks that may be skipped.
pub const SKIPPED_SHARE: Key = Key("skipped_most");
/// Port at which one side of a teleoperation waits.
pub const LISTEN: Key = Key("listen");
/// Address of its other side.
pub const CONNECT: Key = Key("connect");
/// The core to which a loop is bound.
pub const PIN: Key = Key("pin");
/// Rate of a loop, Hz.
pub const RATE: Key = Key("rate_hz");

/// Files that a document names, as a log of its run has them.
pub const TISSUE_IN_LOG: &str = "tissue_file";
/// The controller of a drive.
pub const CONTROLLER_IN_LOG: &str = "drive.file";
/// Parameters of the device.
pub const DEVICE_IN_LOG: &str = "device_model.file";
/// Parameters of the device of a drive.
pub const DRIVE_DEVICE_IN_LOG: &str = "drive_device_model.file";

/// Parameters that name a file or a folder of files, some of them also by a name that is no path, and where a log has the text.
pub const FILES: [(&str, Option<&str>); 11] = [
    (TISSUE.key, Some(TISSUE_IN_LOG)),
    (AGAINST.key, None),
    (LIBRARY.key, None),
    (CONTROLLER.key, Some(CONTROLLER_IN_LOG)),
    (DEVICE_MODEL.key, Some(DEVICE_IN_LOG)),
    (DRIVE_DEVICE_MODEL.key, Some(DRIVE_DEVICE_IN_LOG)),
    (RESPONSE_FILE.key, None),
    (CAMPAIGN.key, None),
    (LAW.key, None),
    (OTHER_LAW.key, None),
    (PLANT_MODEL.key, None),
];

/// True if this value of the parameter with this key is a path to a file or a folder of files.
#[must_use]
pub fn is_path(key: &str, text: &str) -> bool {
    FILES.iter().any(|file| file.0 == key)
        && match key {
            key if key == TISSUE.key => Path::new(text).extension().is_some_and(|e| e == "toml"),
            key if key.ends_with(DEVICE_MODEL.key) && text == LABORATORY => false,
            _ => !text.is_empty(),
        }
}
