//! The command line as a user meets it: the real binary, run as a process.

#![cfg(unix)]
#![expect(clippy::float_cmp, reason = "exact results are compared exactly")]

mod against;
mod analysis;
mod control;
mod data;
mod design;
mod devices;
mod emulated;
mod experiments;
mod faults;
mod first_hour;
mod guide;
mod identify;
mod interrupted;
mod live;
mod log;
mod measure;
mod mistakes;
mod others;
mod pair;
mod picture_file;
mod pins;
mod press;
mod process;
mod public;
mod realtime;
mod refusals;
mod reproduce;
mod sensed;
#[cfg(feature = "serve")]
mod serve;
mod signals;
mod teleoperation;
mod touch;
#[cfg(target_os = "linux")]
mod unwritten;
