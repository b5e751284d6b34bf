//! The command line as a user meets it: the real binary, run as a process.

#![expect(clippy::float_cmp, reason = "exact results are compared exactly")]

mod analysis;
mod control;
mod coupler;
mod data;
mod design;
#[cfg(unix)]
mod devices;
mod drive;
#[cfg(unix)]
mod emulated;
mod experiments;
#[cfg(unix)]
mod export;
mod faults;
mod guide;
mod haply;
mod identify;
mod interrupted;
#[cfg(unix)]
mod killed;
mod live;
mod log;
#[cfg(unix)]
mod measure;
mod picture_file;
mod pins;
mod process;
mod realtime;
mod refusals;
mod rehearsal;
mod reproduce;
mod teleoperation;
mod touch;
#[cfg(target_os = "linux")]
mod unwritten;
