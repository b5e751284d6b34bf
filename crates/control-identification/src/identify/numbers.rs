//! The numbers of a sum of parts that a fit may change, as the parameters of a search.
//!
//! A parameter is an order; of a coefficient the logarithm of its size, or how often it is that of the guess; the dead time in samples, or in s.

use super::record::{Free, FreeNumber, answers_at_once, free_numbers};
use crate::DeadTime;
use fractional_control::{ControlError, FractionalTransferFunction, Term};
use nalgebra::{DMatrix, DVector};

/// Step of a difference to one side, of a coefficient: the modes of a memory do not depend on it, so that only rounding limits it.
const STEP: f64 = 1e-6;
/// Step of a central difference, of an order: the modes of a memory change with it, and with them its error.
const STEP_OF_ORDER: f64 = 1e-4;

#[derive(Clone, Debug)]
pub(super) struct Numbers {
    pub(super) guess: Vec<FractionalTransferFunction>,
    pub(super) freedom: Free,
    /// Each with the part that it is of; the dead time last.
    pub(super) free: Vec<(usize, FreeNumber)>,
}

impl Numbers {
    pub(super) fn new(
        guess: &[FractionalTransferFunction],
        freedom: Free,
        dead_time: DeadTime,
    ) -> Self {
        let of_part = |(n, part): (usize, &FractionalTransferFunction)| {
            let free = free_numbers(part, freedom).into_iter();
            free.map(move |number| (n, number)).collect::<Vec<_>>()
        };
        let mut free: Vec<_> = guess.iter().enumerate().flat_map(of_part).collect();
        if dead_time.is_free() {
            free.push((0, FreeNumber::DeadTime));
        }
        Self {
            guess: guess.to_vec(),
            freedom,
            free,
        }
    }

    /// The parts as they are, with nothing free.
    pub(super) fn fixed(parts: &[FractionalTransferFunction], freedom: Free) -> Self {
        Self {
            guess: parts.to_vec(),
            freedom,
            free: Vec::new(),
        }
    }

    /// The parameters of the guess behind this dead time.
    pub(super) fn begin(&self, late: f64) -> DVector<f64> {
        let values = self.free.iter().map(|(part, number)| {
            let function = &self.guess[*part];
            let (above, below) = (function.numerator().terms(), function.denominator().terms());
            let coefficient = |term: &Term| match self.freedom {
                Free::All => libm::log(term.coefficient.abs()),
                Free::Coefficients | Free::Above => term.coefficient.signum(),
            };
            match *number {
                FreeNumber::NumeratorCoefficient(n) => coefficient(&above[n]),
                FreeNumber::NumeratorOrder(n) => above[n].order,
                FreeNumber::DenominatorCoefficient(n) => coefficient(&below[n]),
                FreeNumber::DenominatorOrder(n) => below[n].order,
                FreeNumber::DeadTime => late,
            }
        });
        DVector::from_iterator(self.free.len(), values)
    }

    /// The dead time of these parameters, if it is free: a search may step below 0.
    pub(super) fn late(&self, parameters: &DVector<f64>) -> Option<f64> {
        let is_free = (self.free.last()).is_some_and(|last| last.1 == FreeNumber::DeadTime);
        is_free.then(|| parameters[self.free.len() - 1].max(0.0))
    }

    /// The parts with these parameters.
    pub(super) fn parts(
        &self,
        parameters: &DVector<f64>,
    ) -> Result<Vec<FractionalTransferFunction>, ControlError> {
        let coefficient = |term: &mut Term, x: f64| {
            let coefficient = term.coefficient;
            term.coefficient = match self.freedom {
                Free::All => libm::exp(x) * coefficient.signum(),
                Free::Coefficients | Free::Above => x * coefficient.abs(),
            };
        };
        let parts = self.guess.iter().enumerate().map(|(part, guess)| {
            let mut above = guess.numerator().terms().to_vec();
            let mut below = guess.denominator().terms().to_vec();
            let free = self.free.iter().zip(parameters.iter());
            for ((_, number), x) in free.filter(|free| free.0.0 == part) {
                match *number {
                    FreeNumber::NumeratorCoefficient(n) => coefficient(&mut above[n], *x),
                    FreeNumber::NumeratorOrder(n) => above[n].order = *x,
                    FreeNumber::DenominatorCoefficient(n) => coefficient(&mut below[n], *x),
                    FreeNumber::DenominatorOrder(n) => below[n].order = *x,
                    FreeNumber::DeadTime => {}
                }
            }
            if answers_at_once(guess) {
                above[0].order = below[0].order;
            }
            FractionalTransferFunction::new(&above, &below)
        });
        parts.collect()
    }

    /// A slope by differences of `left`, which is `here` at these parameters; central of an order.
    pub(super) fn slope(
        &self,
        column: usize,
        parameters: &DVector<f64>,
        here: &DVector<f64>,
        left: impl Fn(&DVector<f64>) -> DVector<f64> + Sync,
    ) -> DVector<f64> {
        let moved = |step: f64| {
            let mut parameters = parameters.clone();
            parameters[column] += step;
            left(&parameters)
        };
        match self.free[column].1 {
            FreeNumber::NumeratorCoefficient(_)
            | FreeNumber::DenominatorCoefficient(_)
            | FreeNumber::DeadTime => (moved(STEP) - here) / STEP,
            FreeNumber::NumeratorOrder(_) | FreeNumber::DenominatorOrder(_) => {
                let (up, down) = rayon::join(|| moved(STEP_OF_ORDER), || moved(-STEP_OF_ORDER));
                (up - down) / (2.0 * STEP_OF_ORDER)
            }
        }
    }

    /// `scale`·(JᵀJ)⁻¹ of the errors of the parameters: relative of coefficients, in s of a dead time that is in `unit_s`; infinite where nothing is said.
    pub(super) fn covariance(
        &self,
        slopes: &DMatrix<f64>,
        scale: f64,
        parameters: &DVector<f64>,
        unit_s: f64,
    ) -> DMatrix<f64> {
        let inverse = (slopes.transpose() * slopes).try_inverse();
        // Of a logarithm the error is relative; of a multiple of the guess it is made so.
        let share = |n: usize| match (self.free[n].1, self.freedom) {
            (FreeNumber::DeadTime, _) => unit_s,
            (_, Free::All) => 1.0,
            (_, Free::Coefficients | Free::Above) => 1.0 / parameters[n].abs(),
        };
        let free = self.free.len();
        DMatrix::from_fn(free, free, |n, k| match &inverse {
            // A variance that is not above 0 is what rounding left of one that is too large.
            Some(inverse) if n != k || inverse[(n, n)] > 0.0 => {
                inverse[(n, k)] * scale * share(n) * share(k)
            }
            _ => f64::INFINITY,
        })
    }

    /// True of parts that run without a rule throughout the fit.
    pub(super) fn runs_exactly(&self, parts: &[FractionalTransferFunction]) -> bool {
        parts.iter().all(|part| self.freedom.runs_exactly(part))
    }
}
