//! The command line as a user meets it: the real binary, run as a process.

#![cfg(unix)]
#![expect(clippy::float_cmp, reason = "exact results are compared exactly")]

mod devices;
mod emulated;
mod faults;
mod guide;
mod interrupted;
mod live;
mod log;
mod measure;
mod pair;
mod picture_file;
mod pins;
mod press;
mod process;
mod public;
mod realtime;
mod robots;
mod scenes;
#[cfg(feature = "serve")]
mod serve;
mod signals;
mod teleoperation;
mod touch;
