//! Tests of the public face of `fractional-control`, in one binary.

#![expect(clippy::float_cmp, reason = "exact results are compared exactly")]

mod analysis;
mod any_pole;
mod boundary;
mod controllers;
mod defining_sums;
mod fast_poles;
mod field;
mod fixture;
mod held_loops;
mod implicit;
mod margins;
mod notation;
mod plants;
mod portable;
mod rules;
mod settled;
mod streaming;
mod unstable;
mod windup;
