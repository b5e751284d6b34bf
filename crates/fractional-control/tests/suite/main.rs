//! Tests of the public face of `fractional-control`, in one binary.

#![expect(clippy::float_cmp, reason = "exact results are compared exactly")]

mod analysis;
mod any_pole;
mod autoregression;
mod boundary;
mod controllers;
mod defining_sums;
mod design;
mod drifting_records;
mod fast_poles;
mod field;
mod fixture;
mod flat;
mod growing_records;
mod held_loops;
mod identification;
mod long_records;
mod margins;
mod notation;
mod other_records;
mod plant_campaign;
mod plants;
mod portable;
mod record_campaign;
mod rules;
mod settled;
mod starts;
mod streaming;
mod sums;
mod tuning;
mod unstable;
mod windup;
