#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]
#![warn(unreachable_pub)]

pub mod controller_file;
pub mod plant_file;
pub mod safety;
pub mod sensors;

pub use controller_file::{ControllerFile, ControllerOrigin};
pub use plant_file::{DeviceModel, DeviceValues, MeasuredPoints, PlantModel};
pub use safety::{GuardChoice, GuardedDevice, guard_of, speed, workspace};
pub use sensors::{Imperfections, Sensors};
