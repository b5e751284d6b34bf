//! Nyquist's count on the grid, for plants with poles anywhere.

use crate::Plant;
use core::f64::consts::PI;
use num_complex::Complex;
use std::vec::Vec;

/// |L| above which the loop is not judged at the highest frequency of the grid, and where dead time turns L by more than [`TURN`] from point
/// to point.
const SMALL: f64 = 0.7;
/// Turn by dead time between two points of the grid, rad.
const TURN: f64 = 1.0;

/// What the poles of the plant add to the count: its denominator A on the grid.
///
/// ```text
/// F = A·(1 + kL) has the poles of the closed loop for zeros and none of its own, so that it is finite at a pole of the plant too
/// stable ⇔ F turns by (α − n)·π/2 from the lowest frequency up,   α the degree of A,   F ~ ω^n at the lowest
/// ```
#[derive(Clone, Debug)]
pub(super) struct Nyquist {
    /// A/|A|.
    directions: Vec<Complex<f64>>,
    /// The turn of A from the highest frequency on, rad.
    rest: f64,
    /// α.
    degree: f64,
    /// d ln|A|/d ln ω at the lowest frequency.
    rise: f64,
    /// ln of the second frequency over the first.
    ratio: f64,
    /// The first point from which on dead time turns L fast.
    fast_from: usize,
}

impl Nyquist {
    pub(super) fn new(plant: &Plant, omegas: &[f64]) -> Self {
        let at = |omega: f64| plant.denominator(omega);
        let ends = omegas.first().zip(omegas.get(1));
        let (rise, ratio) = ends.map_or((0.0, 1.0), |(first, second)| {
            let ratio = libm::log(second / first);
            ((at(*second).0 - at(*first).0) / ratio, ratio)
        });
        Self {
            directions: omegas.iter().map(|omega| at(*omega).1).collect(),
            rest: omegas
                .last()
                .map_or(0.0, |omega| plant.denominator_turn_from(*omega)),
            degree: plant.degree(),
            rise,
            ratio,
            fast_from: omegas
                .windows(2)
                .position(|pair| (pair[1] - pair[0]) * plant.delay_s() > TURN)
                .unwrap_or(omegas.len()),
        }
    }

    /// The largest |L| at the end of the grid, and where dead time turns it fast.
    pub(super) fn end(&self, open: &[Complex<f64>]) -> f64 {
        let from = self.fast_from.min(open.len().saturating_sub(1));
        let sizes = open.iter().skip(from).map(|l| l.norm());
        // What is no number is no small one.
        sizes.fold(0.0, |most, size| if size <= most { most } else { size })
    }

    /// True if the loop is stable at a gain k, as far as the grid tells; `open` is L on it.
    pub(super) fn is_stable(&self, open: &[Complex<f64>], gain: f64) -> bool {
        let (Some(first), Some(second), Some(last)) = (open.first(), open.get(1), open.last())
        else {
            return false;
        };
        // Also not so of what is no number.
        let ends_small = self.end(open) * gain <= SMALL;
        if !ends_small {
            return false;
        }
        // A straight line from point to point turns by less than π; each that passes 0 on the left adds a whole turn.
        let at = |(l, direction): (&Complex<f64>, &Complex<f64>)| (l * gain + 1.0) * direction;
        let mut values = open.iter().zip(&self.directions).map(at);
        let Some(begin) = values.next() else {
            return false;
        };
        let (mut turns, mut from) = (0.0, begin);
        for to in values {
            if (from.im < 0.0) != (to.im < 0.0) {
                let meets = (from.re * to.im - to.re * from.im) / (to.im - from.im);
                if meets < 0.0 {
                    turns += if to.im < 0.0 { 1.0 } else { -1.0 };
                }
            }
            from = to;
        }
        // From the last point on L falls to 0.
        let left = self.rest - (last * gain + 1.0).arg();
        let turn = from.arg() - begin.arg() + 2.0 * PI * turns + left;
        let grows = libm::log((second * gain + 1.0).norm() / (first * gain + 1.0).norm());
        let order = self.rise + grows / self.ratio;
        (turn - 0.5 * PI * (self.degree - order)).abs() < 1.0
    }
}
