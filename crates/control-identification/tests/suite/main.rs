//! Tests of the public face of `control-identification`, in one binary.

#![expect(clippy::float_cmp, reason = "exact results are compared exactly")]

mod autoregression;
mod drifting_records;
mod fixture;
mod growing_records;
mod identification;
mod long_records;
mod other_records;
mod plant_campaign;
mod plants_of_records;
mod record_campaign;
mod starts;
mod sums;
