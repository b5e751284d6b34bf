//! Tests of the public face of `control-tuning`, in one binary.

#![expect(clippy::float_cmp, reason = "exact results are compared exactly")]

mod design;
mod fixture;
mod flat;
mod robustness;
mod tuning;
mod unstable;
