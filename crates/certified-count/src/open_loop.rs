//! Crossings and peaks of an open loop L = B/A, none of which is missed.
//!
//! ```text
//! L is real: Im(A·B̄) = 0,   |L| = 1: |B|² − |A|² = 0,   on an interval of width h:
//! no zero ⇐ |f(a)| + |f(b)| > ∫|f′|, or min(|f(a)|, |f(b)|) > (h²/8)·sup|f″|;   one at most ⇐ |f′(a)| > h·sup|f″|
//! ```
//! An interval of which neither is proved is halved.

use crate::bounds::{Bounds, Jet};
use core::f64::consts::PI;
use num_complex::Complex;

/// A value and the angle, rad/sample, at which it occurs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AtAngle {
    /// The value, without a unit unless its field has one.
    pub value: f64,
    /// The angle θ = ωT of a frequency ω, from 0 to π.
    pub theta: f64,
}

impl AtAngle {
    /// Pair of a value and its angle.
    #[must_use]
    pub const fn new(value: f64, theta: f64) -> Self {
        Self { value, theta }
    }
}

/// A and B of a loop at an angle: L is their ratio, F their sum.
#[derive(Clone, Copy, Debug)]
pub struct LoopTerms<N> {
    /// The angle θ, rad.
    pub theta: f64,
    /// A, and then B.
    pub parts: [Jet; 2],
    /// All else that is known there.
    pub node: N,
}

/// The part of F of which a peak over |F| is looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Peak {
    /// |A/F| = |1/(1 + L)|.
    Sensitivity,
    /// |B/F| = |L/(1 + L)|.
    Complementary,
}

impl Peak {
    fn of<T>(self, [below, above]: [T; 2]) -> T {
        match self {
            Self::Sensitivity => below,
            Self::Complementary => above,
        }
    }
}

impl<N> LoopTerms<N> {
    /// L; infinite at a pole on the circle.
    #[must_use]
    pub fn gain(&self) -> Complex<f64> {
        self.parts[1].value / self.parts[0].value
    }

    fn sum(&self) -> Jet {
        self.parts[0].plus(self.parts[1])
    }

    /// |A| or |B| over |F|.
    #[must_use]
    pub fn share(&self, peak: Peak) -> f64 {
        peak.of(self.parts).value.norm() / self.sum().value.norm()
    }

    /// The derivative of its logarithm.
    fn climb(&self, peak: Peak) -> f64 {
        let (part, sum) = (peak.of(self.parts), self.sum());
        (part.rate / part.value - sum.rate / sum.value).re
    }
}

/// A real function of A and B.
struct Real {
    /// Its value and derivative.
    of: fn(&[Jet; 2]) -> [f64; 2],
    /// The size of what it is the difference of.
    size: fn(&[Jet; 2]) -> f64,
    bounds: fn([Bounds; 2]) -> Bounds,
}

const IMAGINARY: Real = Real {
    of: |[a, b]| {
        let rate = a.rate * b.value.conj() + a.value * b.rate.conj();
        [(a.value * b.value.conj()).im, rate.im]
    },
    size: |[a, b]| a.value.norm() * b.value.norm(),
    bounds: |[a, b]| a.times(b),
};

const EXCESS: Real = Real {
    of: |[a, b]| {
        let rate = b.rate * b.value.conj() - a.rate * a.value.conj();
        [b.value.norm_sqr() - a.value.norm_sqr(), 2.0 * rate.re]
    },
    size: |[a, b]| a.value.norm_sqr() + b.value.norm_sqr(),
    bounds: |[a, b]| a.times(a).plus(b.times(b)),
};

/// Angles at which a search looks, at most.
const LOOKS: usize = 300_000;
/// An interval of less than this share of its angle, at both ends of which f is rounding error, is not halved.
const FLAT: f64 = 1e-3;

/// An open loop on the upper half circle, known at angles and bounded between them. A search that 300 000 angles do not settle, as of bounds that
/// are infinite everywhere, ends with what it has found.
pub trait OpenLoop {
    /// Known at an angle beside A and B.
    type Node: Copy;

    /// A and B at an angle.
    fn terms(&self, theta: f64) -> LoopTerms<Self::Node>;

    /// A and B at an angle with derivatives that tell a rise from a fall, where those of [`terms`](Self::terms) are not numbers.
    fn sloped(&self, theta: f64) -> LoopTerms<Self::Node> {
        self.terms(theta)
    }

    /// Bounds of A and of B between two angles.
    fn bounds(&self, a: &LoopTerms<Self::Node>, b: &LoopTerms<Self::Node>) -> [Bounds; 2];

    /// Crossings nearer to rest than this are not looked for, rad/sample.
    fn least(&self) -> f64 {
        1e-6
    }

    /// Angles with which the search for a peak begins, in order.
    fn angles(&self) -> Vec<f64>;

    /// Angles beside the zeros at which L may be real: those at which it has to be.
    fn ends(&self) -> Vec<f64> {
        vec![0.0, PI]
    }

    /// The width of an interval at this angle that is not halved.
    fn narrow(&self, theta: f64) -> f64 {
        let _ = theta;
        1e-12
    }

    /// Rounding error of f, as a share of what it is the difference of. A loop that rests at |L| = 1 crosses it by rounding only.
    fn noise(&self) -> f64 {
        0.0
    }

    /// Every g > 0 with 1 + g·L = 0 on the circle.
    fn gain_crossings(&self) -> Vec<AtAngle> {
        let mut angles = zeros(self, &IMAGINARY);
        angles.extend(self.ends());
        let crossings = angles.into_iter().filter_map(|theta| {
            let gain = self.terms(theta).gain();
            let value = -1.0 / gain.re;
            let is_real = gain.im.abs() <= 1e-6 * gain.norm();
            (value.is_finite() && value > 0.0 && is_real).then_some(AtAngle::new(value, theta))
        });
        crossings.collect()
    }

    /// The angles at which |L| = 1.
    fn crossovers(&self) -> Vec<f64> {
        zeros(self, &EXCESS)
    }

    /// The peak of |A/F| or |B/F|: the best sample, improved, then proved to be exceeded by no more than this share anywhere, or replaced and
    /// proved again.
    fn peak(&self, peak: Peak, tolerance: f64) -> AtAngle {
        let samples: Vec<_> = self.angles().into_iter().map(|at| self.terms(at)).collect();
        let mut best = AtAngle::new(0.0, 0.0);
        for (index, sample) in samples.iter().enumerate() {
            if sample.share(peak) > best.value {
                let low = samples[index.saturating_sub(1)].theta;
                let high = samples[(index + 1).min(samples.len() - 1)].theta;
                best = improve(self, peak, sample, [low, high]);
            }
        }
        let mut todo: Vec<_> = samples.windows(2).map(|pair| (pair[0], pair[1])).collect();
        for _ in 0..LOOKS {
            let Some((a, b)) = todo.pop() else {
                break;
            };
            let (low, high) = (a.theta, b.theta);
            // A loop that is no number at both ends has no peak between them.
            let is_nothing = a.share(peak).is_nan() && b.share(peak).is_nan();
            if is_nothing
                || stays_below(self, peak, &a, &b, best.value * (1.0 + tolerance))
                || high - low <= self.narrow(high)
            {
                continue;
            }
            let middle = self.terms(0.5 * (low + high));
            if middle.share(peak) > best.value {
                best = improve(self, peak, &middle, [low, high]);
            }
            todo.extend([(a, middle), (middle, b)]);
        }
        best
    }
}

/// All zeros from the least angle to π.
fn zeros<L: OpenLoop + ?Sized>(open: &L, function: &Real) -> Vec<f64> {
    let mut found = Vec::new();
    let mut todo = vec![(open.terms(open.least()), open.terms(PI))];
    let value = |terms: &LoopTerms<L::Node>| (function.of)(&terms.parts)[0];
    let noise = open.noise();
    let is_noise =
        |terms: &LoopTerms<L::Node>| value(terms).abs() < noise * (function.size)(&terms.parts);
    for _ in 0..LOOKS {
        let Some((a, b)) = todo.pop() else {
            break;
        };
        let ([at_a, rate_a], at_b) = ((function.of)(&a.parts), value(&b));
        let (low, high) = (a.theta, b.theta);
        let width = high - low;
        let bounds = open.bounds(&a, &b);
        let Bounds { bend, travel, .. } = (function.bounds)(bounds);
        let crosses = (at_a > 0.0) != (at_b > 0.0);
        let by_bend = at_a.abs().min(at_b.abs()) > 0.125 * width * width * bend;
        let is_clear = !crosses && (by_bend || at_a.abs() + at_b.abs() > travel);
        let is_flat = width < FLAT * high && is_noise(&a) && is_noise(&b);
        let is_nothing = bounds[1].size == 0.0 || at_a.is_nan() && at_b.is_nan();
        if is_clear || is_flat || is_nothing {
            continue;
        }
        // Monotone: one zero or none.
        if rate_a.abs() > width * bend || width <= open.narrow(high) {
            if crosses {
                let is_before = |theta| (value(&open.terms(theta)) > 0.0) == (at_a > 0.0);
                found.push(bisect(low, high, is_before));
            }
            continue;
        }
        let middle = open.terms(0.5 * (low + high));
        todo.extend([(a, middle), (middle, b)]);
    }
    let neighbours = |theta: &f64| [1.0 - FLAT, 1.0 + FLAT].map(|share| open.terms(theta * share));
    found.retain(|theta| noise == 0.0 || !neighbours(theta).iter().any(is_noise));
    found
}

/// A local maximum between two angles, no lower than the sample.
fn improve<L: OpenLoop + ?Sized>(
    open: &L,
    peak: Peak,
    sample: &LoopTerms<L::Node>,
    [low, high]: [f64; 2],
) -> AtAngle {
    let theta = bisect(low, high, |theta| open.sloped(theta).climb(peak) > 0.0);
    let value = open.terms(theta).share(peak);
    if value > sample.share(peak) {
        AtAngle::new(value, theta)
    } else {
        AtAngle::new(sample.share(peak), sample.theta)
    }
}

/// True if |A/F| or |B/F| ≤ `most` is proved for a whole interval: from the paths of both, or because
/// `most`²|F|² − |A|² cannot reach 0 with the second derivative it has.
fn stays_below<L: OpenLoop + ?Sized>(
    open: &L,
    peak: Peak,
    a: &LoopTerms<L::Node>,
    b: &LoopTerms<L::Node>,
    most: f64,
) -> bool {
    let bounds = open.bounds(a, b);
    let (part, whole) = (peak.of(bounds), bounds[0].plus(bounds[1]));
    let least = 0.5 * (a.sum().value.norm() + b.sum().value.norm() - whole.travel);
    if least > 0.0 && part.size <= most * least {
        return true;
    }
    let bend = most * most * whole.times(whole).bend + part.times(part).bend;
    let room = |terms: &LoopTerms<L::Node>| {
        let part = peak.of(terms.parts).value;
        most * most * terms.sum().value.norm_sqr() - part.norm_sqr()
    };
    let width = b.theta - a.theta;
    room(a).min(room(b)) > 0.125 * width * width * bend
}

/// The point at which a condition that holds at the low end ceases to hold.
fn bisect(mut low: f64, mut high: f64, holds: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if holds(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}
