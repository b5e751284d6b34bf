//! Device and host talk over a line in virtual time.

#![expect(clippy::float_cmp, reason = "exact results are compared exactly")]

mod broken;
mod limits;
mod line;
mod schedules;
mod session;
mod witness;
