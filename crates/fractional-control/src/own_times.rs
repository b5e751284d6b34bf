//! The states of a plant at times that are not evenly spaced, for an input that is held from each of them to the next.
//!
//! ```text
//! x(t + h) = e^(Ah)x + ∫₀^h e^(As)B ds·u,   h = m·δ + r:   e^(A·2^jδ) for each binary digit j of m, Σ (Ar)^k/k! for the rest
//! ```
//! δ is so short that ‖A‖δ ≤ 1/2, so the sum ends after 14 terms. Both are exact but for rounding, whatever the poles are; a switch behind a
//! dead time is one more time.
//!
//! - *Units*: times in s. *Errors*: none; what grows beyond all numbers is not finite. *Cost*: two steps a sample, each some five products with
//!   A; a table of e^(A·2^jδ) once. *Source*: C. Moler, C. Van Loan, *Nineteen dubious ways to compute the exponential of a matrix, twenty-five
//!   years later*, SIAM Review 45(1), 2003, method 3.

use crate::{ControlError, StateSpace, state_space::begun};
use nalgebra::{DMatrix, DVector};
use std::vec::Vec;

/// ‖A‖δ at most, terms of the sum, and binary digits at most.
const SHORT: f64 = 0.5;
const TERMS: usize = 14;
const DIGITS: i32 = 60;

struct Steps<'a> {
    plant: &'a StateSpace,
    finest: f64,
    /// e^(A·2^jδ) − 1 and what a held input adds.
    doubled: Vec<(DMatrix<f64>, DVector<f64>)>,
    /// Room for a change and for the next term.
    room: [DVector<f64>; 2],
}

impl<'a> Steps<'a> {
    fn new(plant: &'a StateSpace, longest: f64) -> Self {
        let norm = plant.a.norm() * longest / SHORT;
        let digits = if norm > 1.0 {
            (libm::ilogb(norm) + 1).min(DIGITS)
        } else {
            0
        };
        let finest = libm::ldexp(longest, -digits);
        let doubled = (0..=digits).map(|j| plant.motion(libm::ldexp(finest, j)));
        let room = DVector::zeros(plant.a.nrows());
        Self {
            plant,
            finest,
            doubled: doubled.collect(),
            room: [room.clone(), room],
        }
    }

    fn advance(&mut self, x: &mut DVector<f64>, u: f64, h: f64) {
        let [change, next] = &mut self.room;
        let whole = libm::floor(h / self.finest);
        for (j, (moved, fed)) in self.doubled.iter().enumerate() {
            if whole as u64 >> j & 1 == 1 {
                change.gemv(1.0, moved, x, 0.0);
                change.axpy(u, fed, 1.0);
                *x += &*change;
            }
        }
        let rest = h - whole * self.finest;
        if rest <= 0.0 {
            return;
        }
        change.gemv(rest, &self.plant.a, x, 0.0);
        change.axpy(rest * u, &self.plant.b, 1.0);
        for k in 1..TERMS {
            *x += &*change;
            next.gemv(rest / (k + 1) as f64, &self.plant.a, change, 0.0);
            core::mem::swap(change, next);
        }
    }
}

impl StateSpace {
    /// Shows each state at these times, from these first ones on, from rest without any; the input is held, or runs in straight lines, and acts so
    /// much later.
    ///
    /// # Errors
    /// More states than a plant may have, with the one that a straight line adds.
    pub fn run_at(
        &self,
        time_s: &[f64],
        input: &[f64],
        late_s: f64,
        held: bool,
        first: &[f64],
        seen: &mut dyn FnMut(usize, &[f64]),
    ) -> Result<(), ControlError> {
        if !held {
            // The slope of the input feeds the input.
            let pairs = time_s.windows(2).zip(input.windows(2));
            let mut slopes: Vec<f64> = pairs.map(|(t, u)| (u[1] - u[0]) / (t[1] - t[0])).collect();
            slopes.push(0.0);
            let mut begin = first.to_vec();
            begin.resize(self.a.nrows(), 0.0);
            begin.extend(input.first());
            let fed = self.fed_by(0.0, 1.0)?;
            return fed.run_at(time_s, &slopes, late_s, true, &begin, seen);
        }
        let steps = time_s.windows(2).map(|pair| pair[1] - pair[0]);
        let mut steps = Steps::new(self, steps.fold(f64::MIN_POSITIVE, f64::max));
        let mut x = begun(DVector::zeros(self.a.nrows()), first);
        let mut now = time_s.first().copied().unwrap_or(0.0);
        let mut u = 0.0;
        let mut switches = time_s.iter().map(|t| t + late_s).zip(input).peekable();
        for (n, t) in time_s.iter().enumerate() {
            while let Some((at, next)) = switches.next_if(|(at, _)| at < t) {
                steps.advance(&mut x, u, at - now);
                (now, u) = (at, *next);
            }
            steps.advance(&mut x, u, t - now);
            now = *t;
            seen(n, x.as_slice());
        }
        Ok(())
    }
}
