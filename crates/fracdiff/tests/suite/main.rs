//! Tests of the public face of `fracdiff`, in one binary.

#![expect(clippy::float_cmp, reason = "exact results are compared exactly")]

mod batch;
mod bdf2;
mod full_memory;
mod increments;
mod memory;
mod operators;
mod oracle;
mod owners;
mod portable;
mod properties;
mod refusals;
mod saved;
mod uneven;
mod weights;
