#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![warn(unreachable_pub)]

pub mod advice;
pub mod controller_file;
pub mod device_table;
pub mod drive_verdict;
pub mod ending;
pub mod flat;
pub mod in_hand;
pub mod keys;
pub mod plant_file;
pub mod preflight;
pub mod robot;
pub mod safe_chain;
pub mod safety;
pub mod samples;
pub mod sensor_offset;
pub mod sensors;
pub mod simulate;
pub mod tap;
pub mod tick;

pub use controller_file::{ControllerFile, ControllerOrigin};
pub use plant_file::{DeviceModel, DeviceValues, MeasuredPoints, PlantModel};
pub use safety::{GuardChoice, GuardedDevice, guard_of, speed, workspace};
pub use sensors::{Imperfections, Sensors};
