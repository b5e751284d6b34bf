//! Device and host talk over a line in virtual time.

#![expect(clippy::float_cmp, reason = "exact results are compared exactly")]

mod axes;
mod connections;
mod holding;
mod limits;
mod line;
mod mirror;
mod patience;
mod plane;
mod runs;
mod schedules;
mod served;
mod session;
mod shapes;
mod tcp;
mod witness;
