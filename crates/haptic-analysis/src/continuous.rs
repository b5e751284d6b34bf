//! What a sampled plant was made from, to sample it again behind another delay.

use crate::linear::{Matrices, STATES_MAX};
use nalgebra::{DMatrix, DVector, RowDVector};

/// The plant in continuous time, in units of one sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Continuous {
    /// δ and γ of a mass with damper and hand.
    pub(crate) named: [f64; 2],
    /// Any linear plant instead, its lag among the states.
    pub(crate) linear: Option<Lists>,
}

/// Matrices without an allocation: A by rows, then B and C, of so many states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lists {
    states: usize,
    a: [[f64; STATES_MAX]; STATES_MAX],
    b: [f64; STATES_MAX],
    c: [f64; STATES_MAX],
}

impl Lists {
    /// At most `STATES_MAX` states.
    pub(crate) fn new((a, b, c): &Matrices) -> Self {
        let mut lists = Self {
            states: b.len().min(STATES_MAX),
            a: [[0.0; STATES_MAX]; STATES_MAX],
            b: [0.0; STATES_MAX],
            c: [0.0; STATES_MAX],
        };
        for row in 0..lists.states {
            (lists.b[row], lists.c[row]) = (b[row], c[row]);
            for column in 0..lists.states {
                lists.a[row][column] = a[(row, column)];
            }
        }
        lists
    }

    pub(crate) fn matrices(&self) -> Matrices {
        let n = self.states;
        (
            DMatrix::from_fn(n, n, |row, column| self.a[row][column]),
            DVector::from_column_slice(&self.b[..n]),
            RowDVector::from_row_slice(&self.c[..n]),
        )
    }
}

impl Continuous {
    /// About the radians by which the fastest motion turns within a sample, or more.
    pub(crate) fn turn(&self) -> f64 {
        match &self.linear {
            None => libm::sqrt(self.named[1]),
            Some(lists) => {
                let entries = lists.a.iter().flatten();
                entries.fold(0.0, |most: f64, x| most.max(x.abs()))
            }
        }
    }
}
