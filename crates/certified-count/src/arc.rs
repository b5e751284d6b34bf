//! Functions with bounds over an arc, and counts in arcs.
//!
//! ```text
//! |f(θ) − f(m)| ≤ (h/2)·sup|f′|   on an arc of width h about m:   the image of the arc lies in a disc
//! ```

use crate::bounds::{Bounds, Jet, product};
use crate::circle::{Place, StabilityVerdict, Winding};
use core::f64::consts::PI;
use core::fmt::Debug;
use num_complex::Complex;

/// An arc θ ∈ \[low, high\] of w = e^(−jθ), 0 ≤ low ≤ high ≤ π, with what is known at its middle.
#[derive(Clone, Copy, Debug)]
pub struct Arc {
    /// θ at its beginning, rad; the arc includes it.
    pub low: f64,
    /// θ at its end, rad, at most π: the other half of the circle is conjugate.
    pub high: f64,
    /// w = e^(−jθ) at the middle, about which a function is bounded.
    pub w: Complex<f64>,
    /// v = 1 − w at the middle.
    pub v: Complex<f64>,
    /// |v|² at the low end, the least: |v| grows with θ.
    pub least_square: f64,
    /// |v| at the high end, the largest.
    pub most: f64,
}

impl Arc {
    /// The arc between two angles.
    #[must_use]
    pub fn new(low: f64, high: f64) -> Self {
        let Place { w, v, .. } = Place::new(0.5 * (low + high));
        let size = |theta: f64| 2.0 * libm::sin(0.5 * theta);
        Self {
            low,
            high,
            w,
            v,
            least_square: size(low) * size(low),
            most: size(high),
        }
    }

    /// The angle in the middle.
    #[must_use]
    pub fn middle(&self) -> f64 {
        0.5 * (self.low + self.high)
    }

    /// Angle from the middle to an end.
    #[must_use]
    pub fn half_width(&self) -> f64 {
        0.5 * (self.high - self.low)
    }
}

/// A value and its derivative at the middle of an arc, with bounds over the whole arc.
#[derive(Clone, Copy, Debug)]
pub struct Enclosed {
    /// f and f′ at the middle, to rounding; the bounds say how far they are from the others.
    pub middle: Jet,
    /// Bound of |f|, or of the sum of the sizes of its terms.
    pub size: f64,
    /// Bound of |f′|.
    pub rate: f64,
    /// Bound of |f″|; may be infinite.
    pub bend: f64,
}

impl Enclosed {
    /// Enclosure with the size that value and rate allow, where the derivative in the middle is not known.
    #[must_use]
    pub fn new(value: Complex<f64>, rate: f64, arc: &Arc) -> Self {
        let unknown = Complex::new(f64::NAN, f64::NAN);
        Self::bent(Jet::new(value, unknown), rate, f64::INFINITY, arc)
    }

    /// Enclosure with the size and the rate that these bounds allow.
    #[must_use]
    pub fn bent(middle: Jet, rate: f64, bend: f64, arc: &Arc) -> Self {
        let bounds = Self {
            middle,
            size: f64::INFINITY,
            rate,
            bend,
        };
        bounds.within(arc)
    }

    /// Enclosure with the bounds that follow from the middle, where they are less.
    #[must_use]
    pub fn within(self, arc: &Arc) -> Self {
        let half = arc.half_width();
        // No derivative, no bound.
        let rate = self
            .rate
            .min(self.middle.rate.norm() + product(half, self.bend));
        let size = self.size.min(self.middle.value.norm() + half * rate);
        Self { size, rate, ..self }
    }

    /// Bounds over the whole arc, as an interval.
    #[must_use]
    pub fn bounds(&self, arc: &Arc) -> Bounds {
        Bounds {
            size: self.size,
            rate: self.rate,
            bend: self.bend,
            travel: 2.0 * arc.half_width() * self.rate,
        }
    }

    /// The sum of two functions: their bounds add up too.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            middle: self.middle.plus(other.middle),
            size: self.size + other.size,
            rate: self.rate + other.rate,
            bend: self.bend + other.bend,
        }
    }

    /// The product of two functions, whose bounds follow from those of both.
    #[must_use]
    pub fn times(self, other: Self) -> Self {
        Self {
            middle: self.middle.times(other.middle),
            size: self.size * other.size,
            rate: self.rate * other.size + self.size * other.rate,
            bend: product(self.bend, other.size)
                + 2.0 * product(self.rate, other.rate)
                + product(self.size, other.bend),
        }
    }

    /// The function times a number; the bounds scale with the number's size.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        Self {
            middle: Jet::new(self.middle.value * factor, self.middle.rate * factor),
            size: self.size * factor.abs(),
            rate: self.rate * factor.abs(),
            bend: product(self.bend, factor.abs()),
        }
    }
}

/// A function on the unit circle with its bounds, for a count in another crate than its own.
pub trait Enclosing: Debug + Send + Sync {
    /// Its value at the middle of the arc, and its bounds over the arc.
    fn at(&self, arc: &Arc) -> Enclosed;
}

/// |F| over the sizes of its terms below which it counts as 0.
const ZERO: f64 = 1e-11;
/// The first arc, and the least that is looked at.
const FIRST: f64 = 1e-9;
const NARROWEST: f64 = 1e-13;
/// Arcs at most: some ten times what any loop of the tests takes.
const ARCS_MAX: usize = 200_000;
/// A bound has to be passed by this factor: its rounding errors are less.
const BEYOND: f64 = 1.01;
/// A turn is this near to a whole number of half turns.
const WHOLE: f64 = 1e-3;

/// Verdict on f over an arc.
enum Known {
    Clear,
    /// Not proved: half of it may be.
    Unclear,
    /// 0 within rounding errors.
    Zero,
}

/// Goes from 0 to π in arcs; true if each was proved.
fn walk(mut judge: impl FnMut(&Arc) -> Known) -> bool {
    let (mut theta, mut width) = (0.0, FIRST);
    for _ in 0..ARCS_MAX {
        let next = if theta + width > PI {
            PI
        } else {
            theta + width
        };
        match judge(&Arc::new(theta, next)) {
            Known::Zero => return false,
            _ if width < NARROWEST => return false,
            Known::Unclear => width *= 0.5,
            Known::Clear if next >= PI => return true,
            Known::Clear => {
                theta = next;
                width *= 2.0;
            }
        }
    }
    false
}

/// Counts the zeros of F in |w| ≤ 1 by the turn of its image of the upper half circle. F is real on the real axis.
///
/// ```text
/// zeros = −(1/π)·Σ arg(F(θ_{i+1})/F(θ_i)),   each arc with |F(m)| > (h/2)·sup|F′|, so that each turn is below π
/// ```
pub fn count(f: impl Fn(&Arc) -> Enclosed) -> StabilityVerdict {
    let at = |theta: f64| f(&Arc::new(theta, theta)).middle.value;
    let mut winding = Winding::new(0.0);
    let mut here = at(0.0);
    let is_proved = walk(|arc| {
        let terms = f(arc);
        let (value, rate) = (terms.middle.value, terms.within(arc).rate);
        if terms.size.is_infinite() {
            return Known::Unclear;
        }
        let relative = value.norm() / terms.size;
        winding.meets(relative, arc.middle());
        if relative.is_nan() || relative <= ZERO {
            return Known::Zero;
        }
        if value.norm() <= BEYOND * arc.half_width() * rate {
            return Known::Unclear;
        }
        let end = at(arc.high);
        winding.turned += (end / here).arg();
        here = end;
        Known::Clear
    });
    winding.counted(is_proved, WHOLE)
}

/// True if below + k·above is proved to be 0 nowhere on the circle, whatever k is from `low` to `high`, both above 0.
///
/// ```text
/// min over k of |d + kn| > (h/2)·(sup|d′| + high·sup|n′|)   on each arc,   the least at k = −Re(d·n̄)/|n|², or at an end
/// ```
pub fn is_clear(f: impl Fn(&Arc) -> (Enclosed, Enclosed), [low, high]: [f64; 2]) -> bool {
    walk(|arc| {
        let (below, above) = f(arc);
        let (d, n) = (below.middle.value, above.middle.value);
        let nearest = -(d * n.conj()).re / n.norm_sqr();
        // With n = 0 any k will do.
        let k = if nearest > low {
            nearest.min(high)
        } else {
            low
        };
        let distance = (d + n * k).norm();
        let size = below.size + high * above.size;
        let rate = below.within(arc).rate + high * above.within(arc).rate;
        if size.is_finite() && distance <= ZERO * size || distance.is_nan() {
            return Known::Zero;
        }
        if distance <= BEYOND * arc.half_width() * rate {
            Known::Unclear
        } else {
            Known::Clear
        }
    })
}
