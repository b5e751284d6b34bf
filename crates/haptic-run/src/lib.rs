#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![warn(unreachable_pub)]

mod budget;
pub mod conduct;
pub mod device;
pub mod document;
pub mod fault_recorder;
pub mod folder;
mod identity;
pub mod link_summary;
mod ran;
pub mod realtime;
pub mod record;
pub mod recorder;
pub mod remembered;
pub mod remote;
pub mod schedule;
pub mod signals;
mod supervisor;

pub use conduct::{recorder, run_beside, run_logged};
pub use device::{
    DeviceName, at_port, firmware_digest, firmware_version, lost_board, refused_at_port, trouble,
};
pub use document::read_document;
pub use folder::{FolderRequest, OutputFolder, next_free, write_text};
pub use identity::DeviceIdentity;
pub use link_summary::{RoundTrip, cycles};
pub use ran::{Aligned, DriveRan, Ran};
pub use realtime::RealtimeOptions;
pub use recorder::{Recorder, Stopped};
pub use remembered::{Remembered, loosened};
pub use schedule::Pace;
pub use supervisor::{Supervisor, Watched};
