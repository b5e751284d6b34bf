//! Records searched, numbers that are drawn, and short words, which the tests share.

use control_identification::model_search::{Found, InputOutput, Wanted, candidates, identify};
use fracdiff::Seconds;
use fractional_control::{ControlError, PowerMemory, Rule, StateSpace};
use nalgebra::{DMatrix, DVector, RowDVector};

/// A, b and c.
pub(crate) fn states<const N: usize>(a: [[f64; N]; N], b: [f64; N], c: [f64; N]) -> StateSpace {
    let states = StateSpace::new(
        DMatrix::from_row_slice(N, N, a.as_flattened()),
        DVector::from_column_slice(&b),
        RowDVector::from_row_slice(&c),
    );
    states.expect("matrices that fit")
}

/// A memory for so many seconds.
pub(crate) fn bdf2(tolerance: f64, duration_s: f64) -> PowerMemory {
    PowerMemory::new(Rule::Bdf2, tolerance, duration_s).expect("valid")
}

/// |have − want| < most.
pub(crate) fn near(have: f64, want: f64, most: f64) -> bool {
    (have - want).abs() < most
}

/// The functions that are found for a record of a held input, whatever its dead time or behind a known one.
pub(crate) fn searched(
    record: &InputOutput,
    dead_time: Option<Seconds>,
) -> Result<Vec<Found>, ControlError> {
    let guesses = candidates(record, true, dead_time, Wanted::default());
    identify(record, &guesses, true, Wanted::default(), &|_| ())
}

/// Numbers from 0 to 1, the same in every run: a linear congruence (D. E. Knuth, MMIX).
pub(crate) struct Draw(pub(crate) u64);

impl Draw {
    pub(crate) fn from(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * ((self.0 >> 11) as f64 / (1u64 << 53) as f64)
    }
}
