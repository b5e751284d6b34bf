//! The boundary curve in the α–β plane: where F(e^(−jθ)) = 0.
//! ```text
//! A + S·(α + βP) = 0,  P = N/D    ⇒    α = X/W,  β = Y/W
//! U = −A·S*,  E = N·D*            X = Im(U*·E),  Y = Im U·|D|²,  W = |S|²·Im E
//! ```
//! (α, β) is a pair of real numbers for a complex equation, so each θ in (0, π) gives one point; at
//! w = ±1 the equation is real and gives a straight line. Inside the curve's way lie its visits to
//! infinity (W = 0); X, Y and W themselves are smooth and have bounded second derivatives.
//!
//! *Nothing is missed*: an interval of θ is dropped only if the signs of X, Y, W and of X + p₀Y − R·W, proved from both ends and a bound of
//! the second derivative, keep (α, β) out of the triangle α, β ≥ 0, α + p₀β ≤ R throughout. All others are halved until the curve turns by
//! less than a tenth of a right angle in each.

use crate::AnalysisError;
use crate::characteristic::{Characteristic, Node};
use crate::curve::Real;
use certified_count::{Bounds, Jet};
use core::f64::consts::PI;

/// Ends of the curve: below this angle (and above π less it) it is within about 1e-12 of the straight line it ends on.
const END: f64 = 1e-6;

/// Intervals narrower than this are taken as they are.
const NARROW: f64 = 1e-11;

/// Largest number of intervals before giving up. A few hundred are common.
const STEPS: usize = 200_000;

/// A point of the curve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    pub(crate) theta: f64,
    pub(crate) point: [f64; 2],
    /// d(α, β)/dθ.
    pub(crate) tangent: [f64; 2],
    /// The sign of W, that is of Im P. Where it is positive, crossing the curve to the left of
    /// increasing θ takes a pair of zeros of F out of the unit disc: two unstable poles fewer.
    pub(crate) leftward: bool,
}

/// X, Y, W at one angle.
#[derive(Clone, Copy, Debug)]
struct Homogeneous {
    node: Node,
    x: Real,
    y: Real,
    w: Real,
}

/// The curve, and the triangle it is traced in.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Decomposition<'a> {
    pub(crate) characteristic: Characteristic<'a>,
    /// p₀ = P(w = 0).
    pub(crate) direct_gain: f64,
    /// R: the region lies within α + p₀β ≤ R.
    pub(crate) reach: f64,
}

#[derive(Clone, Debug, Default)]
pub(crate) struct Trace {
    /// Stretches of the curve, each gap-free, θ increasing.
    pub(crate) stretches: Vec<Vec<Sample>>,
    /// Straight lines α + βp = c of an angle at which P and A/S are real at once: (p, c, θ).
    pub(crate) lines: Vec<(f64, f64, f64)>,
}

impl Decomposition<'_> {
    fn homogeneous(&self, theta: f64) -> Homogeneous {
        let node = self.characteristic.node(theta);
        let product = node.plant.times(node.gain.conj());
        let u = Jet::new(-product.value, -product.rate);
        let (above, below) = (node.operator.numerator, node.operator.denominator);
        let (e, d2) = if self.characteristic.operator.has_denominator() {
            (above.times(below.conj()), below.times(below.conj()))
        } else {
            (above, Jet::ONE)
        };
        let s2 = node.gain.times(node.gain.conj());
        let size = |square: Jet| Real {
            value: square.value.re,
            rate: square.rate.re,
        };
        Homogeneous {
            node,
            x: Real::imaginary_of(u.conj().times(e)),
            y: Real::imaginary_of(u).times(size(d2)),
            w: Real::imaginary_of(e).times(size(s2)),
        }
    }

    /// The curve at one angle; not finite where it passes through infinity.
    pub(crate) fn sample(&self, theta: f64) -> Sample {
        self.homogeneous(theta).sample()
    }

    /// True if the curve provably stays out of the triangle between two angles.
    fn outside(&self, a: &Homogeneous, b: &Homogeneous) -> bool {
        let (na, nb) = (&a.node, &b.node);
        let plant = self.characteristic.plant_bounds(na, nb);
        let gain = self.characteristic.gain_bounds(na, nb);
        let [above, below] = self.characteristic.operator_bounds(na, nb);
        let (e, d2) = if self.characteristic.operator.has_denominator() {
            (above.times(below), below.times(below))
        } else {
            (above, Bounds::ONE)
        };
        let u = plant.times(gain);
        let bend_x = u.times(e).bend;
        let bend_y = u.times(d2).bend;
        let bend_w = gain.times(gain).times(e).bend;
        let width = b.node.theta() - a.node.theta();
        let sign = |a: f64, b: f64, bend: f64| {
            let sag = 0.125 * width * width * bend;
            if a.min(b) > sag {
                1
            } else if a.max(b) < -sag {
                -1
            } else {
                0
            }
        };
        let x = sign(a.x.value, b.x.value, bend_x);
        let y = sign(a.y.value, b.y.value, bend_y);
        if x * y < 0 {
            return true;
        }
        let w = sign(a.w.value, b.w.value, bend_w);
        if w * x < 0 || w * y < 0 {
            return true;
        }
        let far =
            |h: &Homogeneous| h.x.value + self.direct_gain * h.y.value - self.reach * h.w.value;
        let bend = bend_x + self.direct_gain * bend_y + self.reach * bend_w;
        let far = sign(far(a), far(b), bend);
        // α + p₀β > R; or, at infinity itself, both of one sign and W too small for the triangle
        // on its own side, while on the other side both are negative.
        (w != 0 && w == far) || (x != 0 && x == y && x == far)
    }

    /// The parts of the curve that may lie in the triangle.
    pub(crate) fn trace(&self) -> Result<Trace, AnalysisError> {
        let mut trace = Trace::default();
        let mut tracer = Tracer {
            decomposition: self,
            trace: &mut trace,
            open: false,
            steps: 0,
        };
        let delay = self.characteristic.plant.path().whole_samples();
        let degree = self.characteristic.operator.degree().min(256) + delay;
        let first = 40 + 8 * degree;
        let step = PI / first as f64;
        let mut angles = vec![END];
        while let Some(next) = angles
            .last()
            .map(|last| 2.0 * last)
            .filter(|next| *next < step)
        {
            angles.push(next);
        }
        angles.extend((1..first).map(|k| k as f64 * step));
        angles.push(PI - END);
        let mut a = self.homogeneous(angles[0]);
        for &theta in &angles[1..] {
            let b = self.homogeneous(theta);
            tracer.advance(&a, &b);
            a = b;
        }
        if tracer.steps > STEPS {
            return Err(AnalysisError::Unresolved {
                what: "the boundary curve of the stability region",
                why: "it winds more than rounding errors can tell",
            });
        }
        self.attach_ends(&mut trace.stretches);
        Ok(trace)
    }

    /// The curve ends on the straight lines of w = 1 and w = −1.
    fn attach_ends(&self, stretches: &mut [Vec<Sample>]) {
        if let Some(stretch) = stretches.first_mut()
            && let Some(&first) = stretch.first()
            && first.theta <= END
            && let Some((p, c)) = self.line_at_rest()
        {
            // β = β₀ + cθ² for a smooth operator; β₀ = 0 for a device that is a mass alone.
            let beta = first.point[1];
            let limit = beta - 0.5 * first.theta * first.tangent[1];
            let is_origin = c == 0.0 && limit.abs() <= 1e-2 * beta.abs();
            let beta = if is_origin { 0.0 } else { beta };
            let point = [c - p * beta, beta];
            stretch.insert(
                0,
                Sample {
                    theta: 0.0,
                    point,
                    ..first
                },
            );
        }
        if let Some(stretch) = stretches.last_mut()
            && let Some(&last) = stretch.last()
            && last.theta >= PI - END
            && let Some((p, c)) = self.line_at_nyquist()
        {
            let point = [c - p * last.point[1], last.point[1]];
            stretch.push(Sample {
                theta: PI,
                point,
                ..last
            });
        }
    }

    /// F(1) = (n₁ + n₀)(γ + α + βP(1)) = 0: α + βp = c as (p, c). Always there for n₁ + n₀ > 0.
    pub(crate) fn line_at_rest(&self) -> Option<(f64, f64)> {
        self.real_line(0.0)
    }

    /// F(−1) = 0; none where a force of alternating sign does not move the device (δ = 0).
    pub(crate) fn line_at_nyquist(&self) -> Option<(f64, f64)> {
        self.real_line(PI)
    }

    fn real_line(&self, theta: f64) -> Option<(f64, f64)> {
        let node = self.characteristic.node(theta);
        let gain = node.gain.value.re;
        if gain.abs() <= 1e-12 * self.characteristic.plant.numerator_sum() {
            return None;
        }
        let (p, _) = self.characteristic.operator.response_and_rate(theta);
        Some((p.re, -node.plant.value.re / gain))
    }

    /// The angle in (a, b) at which `of` changes sign, for samples that bracket it.
    pub(crate) fn solve(&self, a: &Sample, b: &Sample, value: impl Fn(&Sample) -> f64) -> Sample {
        let (mut low, mut high) = (a.theta, b.theta);
        let (mut at_low, mut at_high) = (value(a), value(b));
        let mut best = if at_low.abs() < at_high.abs() { *a } else { *b };
        let mut least = value(&best).abs();
        // Regula falsi with the Illinois weight; bisection where it is slow.
        for step in 0..80 {
            if high - low <= 4.0 * f64::EPSILON * high || at_low == 0.0 || at_high == 0.0 {
                break;
            }
            let share = if step % 4 == 3 {
                0.5
            } else {
                at_low / (at_low - at_high)
            };
            let theta = low + (high - low) * share.clamp(1e-3, 1.0 - 1e-3);
            let sample = self.sample(theta);
            let value = value(&sample);
            if value.abs() < least {
                (best, least) = (sample, value.abs());
            }
            if value == 0.0 {
                break;
            }
            if (value > 0.0) == (at_low > 0.0) {
                (low, at_low) = (theta, value);
                at_high *= 0.5;
            } else {
                (high, at_high) = (theta, value);
                at_low *= 0.5;
            }
        }
        best
    }
}

impl Homogeneous {
    fn sample(&self) -> Sample {
        let Self { x, y, w, node } = self;
        let point = [x.value / w.value, y.value / w.value];
        Sample {
            theta: node.theta(),
            point,
            // (X/W)′ = (X′ − αW′)/W
            tangent: [
                (x.rate - point[0] * w.rate) / w.value,
                (y.rate - point[1] * w.rate) / w.value,
            ],
            leftward: w.value > 0.0,
        }
    }
}

impl Sample {
    fn is_finite(&self) -> bool {
        let [x, y] = self.point;
        let [dx, dy] = self.tangent;
        x.is_finite() && y.is_finite() && dx.is_finite() && dy.is_finite()
    }
}

struct Tracer<'a, 'b> {
    decomposition: &'a Decomposition<'b>,
    trace: &'a mut Trace,
    /// True if the last interval was kept.
    open: bool,
    steps: usize,
}

impl Tracer<'_, '_> {
    fn advance(&mut self, a: &Homogeneous, b: &Homogeneous) {
        self.steps += 1;
        if self.steps > STEPS {
            return;
        }
        if self.decomposition.outside(a, b) {
            self.open = false;
            return;
        }
        let (from, to) = (a.sample(), b.sample());
        if is_straight(&from, &to) {
            self.keep(from, to);
            return;
        }
        let (low, high) = (a.node.theta(), b.node.theta());
        if high - low > NARROW {
            let middle = self.decomposition.homogeneous(0.5 * (low + high));
            self.advance(a, &middle);
            self.advance(&middle, b);
            return;
        }
        if from.leftward == to.leftward && from.is_finite() && to.is_finite() {
            self.keep(from, to);
            return;
        }
        // W = 0 with a finite α and β: P and A/S are both real, F = 0 on a whole line.
        self.open = false;
        let gain = a.node.gain.value;
        let (p, _) = self
            .decomposition
            .characteristic
            .operator
            .response_and_rate(low);
        let q = -a.node.plant.value / gain;
        if q.im.abs() <= 1e-9 * q.norm() {
            self.trace.lines.push((p.re, q.re, low));
        }
    }

    fn keep(&mut self, from: Sample, to: Sample) {
        if !self.open {
            self.trace.stretches.push(vec![from]);
            self.open = true;
        }
        if let Some(stretch) = self.trace.stretches.last_mut() {
            stretch.push(to);
        }
    }
}

/// True if the curve turns by less than about 0.15 rad between two samples, and does not pass through infinity.
fn is_straight(a: &Sample, b: &Sample) -> bool {
    const COS: f64 = 0.99;
    if a.leftward != b.leftward || !a.is_finite() || !b.is_finite() {
        return false;
    }
    let chord = [b.point[0] - a.point[0], b.point[1] - a.point[1]];
    let along = |u: [f64; 2], v: [f64; 2]| {
        u[0] * v[0] + u[1] * v[1] > COS * libm::hypot(u[0], u[1]) * libm::hypot(v[0], v[1])
    };
    along(a.tangent, b.tangent) && along(a.tangent, chord) && along(b.tangent, chord)
}
