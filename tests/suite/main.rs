//! Tests of the crates together and of the repository, in one binary.

mod agreement;
mod dependencies;
mod guide;
mod performance;
mod relaxation;
