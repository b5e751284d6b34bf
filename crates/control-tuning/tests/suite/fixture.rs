//! Short words for wishes, beside those of `testkit`, which the tests share.

use control_tuning::{Sampling, Specification};
use fracdiff::Seconds;
use fractional_control::Rule;
pub(crate) use testkit::control::*;

pub(crate) fn every(seconds: f64) -> Sampling {
    Sampling {
        sample_time: Seconds(seconds),
        rule: Rule::Bdf2,
    }
}

/// Wishes without that for a flat phase.
pub(crate) fn not_flat(crossover_rad_s: f64, margin_rad: f64) -> Specification {
    Specification {
        iso_damping: false,
        ..Specification::new(crossover_rad_s, margin_rad)
    }
}
