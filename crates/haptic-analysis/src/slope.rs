//! Stability under every motion of contact that may pull: one-sided before its memory, or stiffening.
//!
//! ```text
//! f = H(w)·e(x),   e(0) = 0,  e monotone,  its slope from 0 to k;   H = K + B T^(−μ) P(w),   L(w) = H(w)·G(w)
//! proved ⇐ Re{M(1/k + L)} > 0 for 0 < θ ≤ π,   M(w) = 1 − Σ h_i w^i,   i = ±1, ±2, …,  h_i ≥ 0,  Σ h_i ≤ 1,  w = e^(−jθ)
//! provable ⇒ |∠(1/k + L)| < π(1 − 1/P) at θ = 2πp/P, for all whole P ≥ 2 and p ≤ P/2
//! ```
//! For a plant that drifts without the wall, G = w^(d+1)N/(v·Ã), v = 1 − w, the left side times |v|·|Ã|² is as good, and
//! has no pole: near rest it falls like θ, and its slope there is the condition in the limit.
//!
//! - h is found by programmes of least distance over some hundred angles, k by bisection; then the inequality is proved between the
//!   angles by a bound of the second derivative, and an angle at which it fails joins the others.
//! - What rounding may have added to the left side is taken off first.
//! - A programme that finds no good h costs proof, never truth.
//!
//! Sources: J. C. Willems, R. W. Brockett, *Some new rearrangement inequalities having application in stability
//! analysis*, IEEE Trans. Automatic Control 13, 1968; J. Carrasco, M. C. Turner, W. P. Heath, *Zames–Falb multipliers
//! for absolute stability*, European J. Control 28, 2016.

use crate::SampledLoop;
use crate::characteristic::Node;
use crate::curve::{NEAR_REST, bounds_in_v, jet_in_v, size_in_v};
use crate::extremum::Grid;
use crate::margin::Open;
use crate::stability::BOUNDARY;
use certified_count::{AtAngle, Bounds, Jet, LoopTerms, OpenLoop};
use core::f64::consts::PI;
use fracdiff::full_memory::non_negative_least_squares;
use num_complex::Complex;

/// Limits on the slope of contact: factors on the wall (K and B together), of which 1 is the wall itself.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SlopeLimit {
    /// Limit of a linear wall: the loop is stable below this factor; at or above it, contact that is as steep as this everywhere
    /// is unstable. Infinite if no factor takes the loop to the boundary; 0 if even the lightest wall is unstable.
    pub linear: f64,
    /// Upper bound of what any multiplier of this kind can prove: the condition on phases above,
    /// for P up to 24, and up to 400 beside the linear limit. At most `linear`. Some loops, up to eight of a thousand random ones,
    /// are proved to less than 99 % of it, most of these because no multiplier proves more.
    pub provable: f64,
    /// Proved for every motion of every contact that may pull and is nowhere steeper than this:
    /// one-sided before the memory, stiffening, or both. From 1 on, the proof also covers a wall
    /// that receives the position even in front of its surface and has only its force clamped. 0 if
    /// nothing was proved. Never above `provable`; between the two nothing is known.
    pub proved: f64,
    /// Each i and `h_i` > 0 of the multiplier that gives this proof.
    pub multiplier: Vec<(i32, f64)>,
}

/// The i of the multiplier on each side with which a search begins. Most loops need no more.
const LAGS: [i32; 5] = [1, 2, 3, 4, 5];
/// Number of further i, up to two periods of the motion that limits most: they turn the phase of a hand that swings.
const LATE_LAGS: i32 = 12;
/// Those of a last search, where many fast motions bind at once.
const MANY: [i32; 18] = [
    1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12, 14, 17, 20, 24, 28, 34, 40,
];
const LAG_MAX: f64 = 400.0;
/// Sufficient share of the provable limit.
const ENOUGH: f64 = 0.99;
/// A slope that falls below this share of itself at one more angle is worth another programme.
const ENOUGH_AGAIN: f64 = 0.999;
/// The search ends this near to what is provable.
const CAP: f64 = 0.9995;
/// First share of the slope that a proof between the angles may cost.
const ROOM: f64 = 2e-4;
/// Longest period P of which all p are checked, and of which those next to the linear limit.
const PERIODS: [u32; 2] = [24, 400];
/// Angles of the first programme.
const FIRST: usize = 12;
/// Size below which an h is rounding error.
const DUST: f64 = 1e-9;
/// Programmes with more and more angles before a slope is given up.
const EXCHANGES: usize = 60;
/// Slopes tried between the circle criterion and the linear limit.
const BISECTIONS: usize = 12;
/// Proofs begun with one more angle each.
const PROOFS: usize = 60;
/// Largest number of angles in a search.
const ANGLES: usize = 20_000;
/// Rounding errors of M, P and Y together, as a share of their terms' sizes.
const ROUNDING: f64 = 24.0 * f64::EPSILON;

impl SampledLoop<'_> {
    /// Limits on the slope of contact for stability under every motion.
    ///
    /// ```
    /// use fracdiff::{Order, Scheme, Seconds};
    /// use haptic_analysis::{LoopOperator, Nondimensional, SampledLoop};
    ///
    /// let damper = LoopOperator::new(Scheme::Exact, Order::new(1.0)?, Seconds(1e-3), 1e3)?;
    /// let wall = Nondimensional { alpha: 0.01, beta: 0.1, delta: 0.05, gamma: 0.0 };
    /// let limit = SampledLoop::new(wall, &damper, 0)?.slope_limit();
    /// assert!(limit.proved > 0.99 * limit.linear);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    /// - *Covered*: e before the memory, so one-sided contact whose force may pull; or e behind it, as in f = max(0, H·x), the
    ///   same loop with its parts in another order, for k = 1.
    /// - *Not covered*: both at once, max(0, x) before the memory and the clamp behind it. The pull that this clamp takes away is what
    ///   brakes the bounce, and with delay hard hits can grow where contact that may pull is proved.
    /// - Of a device without damping, δ = 0, nothing is proved: without the wall it never comes to
    ///   rest. Nor with so little damping, δ near 1e-14, that rounding decides.
    /// - *Cost*: some 10³ responses of the operator and three linear programmes of 11 unknowns; where those prove less
    ///   than 0.99 of what is provable, forty programmes of up to 37.
    ///
    /// Source: see [`SlopeLimit`].
    #[must_use]
    pub fn slope_limit(&self) -> SlopeLimit {
        let linear = self.linear_limit();
        let binding = self.phase_bound(linear);
        let mut limit = SlopeLimit {
            linear: linear.value,
            provable: binding.value,
            proved: 0.0,
            multiplier: Vec::new(),
        };
        if limit.linear == 0.0 || self.is_blurred() || (self.alpha == 0.0 && self.beta == 0.0) {
            return limit;
        }
        let mut search = Search::new(self);
        for lags in [LAGS.to_vec(), late_lags(binding.theta), MANY.to_vec()] {
            search.turn_by(lags);
            let steepest = search.steepest(limit.proved, limit.provable);
            let found = steepest.and_then(|(slope, taps)| search.proved(slope, taps));
            if let Some((proved, taps)) = found.filter(|(proved, _)| *proved > limit.proved) {
                limit.proved = proved;
                limit.multiplier = taps.0;
            }
            if limit.proved >= ENOUGH * limit.provable {
                break;
            }
        }
        limit
    }

    /// The least k > 0 with 1 + kL = 0 on the circle, if the loop is stable below.
    fn linear_limit(&self) -> AtAngle {
        let none = AtAngle::new(f64::INFINITY, PI);
        let crossings = Open(self).gain_crossings().into_iter();
        let mut least = crossings.fold(none, lower);
        let is_finite = least.value.is_finite();
        let below = if is_finite { 0.5 * least.value } else { 1.0 };
        let lighter = Self {
            alpha: below * self.alpha,
            beta: below * self.beta,
            ..*self
        };
        if !lighter.beside_rest().is_stable() {
            least.value = 0.0;
        }
        least
    }

    /// The plant has a second pole at rest, or one so near to rest that rounding decides where it is.
    fn is_blurred(&self) -> bool {
        let denominator = self.plant().denominator_in_v();
        let clear = BOUNDARY * denominator.iter().map(|c| c.abs()).sum::<f64>();
        if denominator[0] == 0.0 {
            denominator[1].abs() <= clear
        } else {
            denominator[0].abs() <= clear
        }
    }

    /// 1/k > −Re L − |Im L|·cot(π/P) at 2πp/P: there M lies in 1 − the hull of the P-th roots of unity, so that
    /// |∠M| ≤ π/2 − π/P. Of long periods only those next to the linear limit are checked; elsewhere Im L decides. The least such k,
    /// or that limit.
    fn phase_bound(&self, linear: AtAngle) -> AtAngle {
        let [all, most] = PERIODS;
        let short = (2..=all).flat_map(|period| (1..=period / 2).map(move |p| (p, period)));
        let long = (all + 1..=most).flat_map(|period| {
            let p = (0.5 * linear.theta / PI * f64::from(period)) as u32;
            (p.max(1)..=(p + 1).min(period / 2)).map(move |p| (p, period))
        });
        let bounds = short.chain(long).map(|(p, period)| {
            let angle = PI / f64::from(period);
            let theta = 2.0 * angle * f64::from(p);
            let gain = self.loop_gain(theta);
            let against = -gain.re - gain.im.abs() / libm::tan(angle);
            let is_bound = against > 0.0;
            AtAngle::new(
                if is_bound {
                    1.0 / against
                } else {
                    f64::INFINITY
                },
                theta,
            )
        });
        bounds.fold(linear, lower)
    }
}

/// The one of the smaller value; the first of two equal ones.
fn lower(a: AtAngle, b: AtAngle) -> AtAngle {
    if b.value < a.value { b } else { a }
}

/// The first ones, and late ones up to two periods.
fn late_lags(theta: f64) -> Vec<i32> {
    let first = f64::from(LAGS[LAGS.len() - 1]);
    let last = (4.0 * PI / theta).clamp(4.0 * first, LAG_MAX);
    let late = (1..=LATE_LAGS).map(|k| {
        let share = f64::from(k) / f64::from(LATE_LAGS);
        libm::round(first * libm::pow(last / first, share)) as i32
    });
    let mut lags: Vec<i32> = LAGS.into_iter().chain(late).collect();
    lags.dedup();
    lags
}

#[derive(Clone, Debug, Default)]
struct Taps(Vec<(i32, f64)>);

impl Taps {
    /// M(e^(−jθ)), as (1 − Σh) + `Σ h_i(1 − w^i)`, which does not cancel near rest.
    fn jet(&self, theta: f64) -> Jet {
        let at_rest = self.0.iter().fold(1.0, |left, (_, h)| left - h);
        let mut jet = Jet::new(at_rest.max(0.0).into(), 0.0.into());
        for &(i, h) in &self.0 {
            let i = f64::from(i);
            let (sin, cos) = libm::sincos(i * theta);
            let half = libm::sin(0.5 * i * theta);
            jet.value += Complex::new(2.0 * half * half, sin) * h;
            jet.rate += Complex::new(sin, cos) * (h * i);
        }
        jet
    }

    /// |1 − Σh| + `Σ h_i|i|`.
    fn size(&self) -> f64 {
        let terms = self.0.iter();
        terms.fold(1.0, |size, &(i, h)| size + h * f64::from(i.abs() - 1))
    }

    fn bounds(&self, a: &Jet, b: &Jet, width: f64) -> Bounds {
        let (rate, bend) = self.0.iter().fold((0.0, 0.0), |(rate, bend), &(i, h)| {
            let i = f64::from(i.abs());
            (rate + h * i, bend + h * i * i)
        });
        Bounds::from_ends(a, b, width, rate, bend)
    }
}

/// Terms at one angle, without k and h: the inequality is Re{M(W/k + E)} > 0.
#[derive(Clone, Copy, Debug)]
struct Row {
    theta: f64,
    /// W = s|P|² > 0.
    weight: f64,
    /// E = u·Y·P*.
    turned: Complex<f64>,
    /// W and |E| if no term of P and Y took another away.
    sizes: [f64; 2],
}

impl Row {
    fn value(&self, slope: f64) -> Complex<f64> {
        self.turned + self.weight / slope
    }

    /// About the largest coefficient of the row, up to this i.
    fn size(&self, slope: f64, last: f64) -> f64 {
        let value = self.value(slope);
        value.re.abs() + value.im.abs() * (last * self.theta).min(1.0)
    }

    /// The left side of the inequality, less what rounding may have added.
    fn room(&self, multiplier: Complex<f64>, size: f64, slope: f64) -> f64 {
        let [weight, turned] = self.sizes;
        (multiplier * self.value(slope)).re - ROUNDING * size * (weight / slope + turned)
    }

    /// The largest k for this h at this angle.
    fn slope(&self, multiplier: Complex<f64>) -> f64 {
        let against = -(multiplier * self.turned).re;
        if against > 0.0 {
            self.weight * multiplier.re.max(0.0) / against
        } else {
            f64::INFINITY
        }
    }
}

/// One angle with its derivatives.
struct Point {
    terms: LoopTerms<Node>,
    parts: [Jet; 4],
    row: Row,
    /// Among the rows of the programme.
    is_active: bool,
}

struct Search<'a, 'b> {
    subject: &'a SampledLoop<'b>,
    lags: Vec<i32>,
    /// G has a pole at w = 1.
    drifts: bool,
    /// All angles of the search, ascending.
    points: Vec<Point>,
}

impl<'a, 'b> Search<'a, 'b> {
    fn new(subject: &'a SampledLoop<'b>) -> Self {
        Self {
            subject,
            lags: Vec::new(),
            drifts: subject.plant().denominator_in_v()[0] == 0.0,
            points: Vec::new(),
        }
    }

    /// Takes these i from here on. Angles join where the others are too far apart for them.
    fn turn_by(&mut self, lags: Vec<i32>) {
        self.lags = lags;
        let grid = Grid::new(self.last() as usize);
        let later = grid.thetas().iter().filter(|theta| **theta > NEAR_REST);
        let known = self.points.len();
        for theta in core::iter::once(&NEAR_REST).chain(later) {
            let at = |point: &Point| point.theta().total_cmp(theta);
            if self.points[..known].binary_search_by(at).is_err() {
                self.points.push(self.point(*theta));
            }
        }
        self.sort();
        let step = self.points.len().div_ceil(FIRST);
        for (index, point) in self.points.iter_mut().rev().enumerate() {
            point.is_active = index % step == 0;
        }
    }

    fn sort(&mut self) {
        self.points.sort_by(|a, b| a.theta().total_cmp(&b.theta()));
    }

    /// A, or A/v if that drifts, in powers of v.
    fn denominator(&self) -> &[f64] {
        &self.subject.characteristic.plant.denominator_in_v()[usize::from(self.drifts)..]
    }

    fn point(&self, theta: f64) -> Point {
        let terms = Open(self.subject).terms(theta);
        let (node, [plant, feedback]) = (terms.node, terms.parts);
        let parts = if self.drifts {
            // s = |v| = 2 sin(θ/2),  u = |v|/v = −je^(jθ/2)
            let (sin, cos) = libm::sincos(0.5 * theta);
            let size = Jet::new((2.0 * sin).into(), cos.into());
            let turn = Jet::new(Complex::new(sin, -cos), Complex::new(0.5 * cos, 0.5 * sin));
            let plant = jet_in_v(self.denominator(), &node.place);
            [plant.times(node.operator.denominator), feedback, size, turn]
        } else {
            [plant, feedback, Jet::ONE, Jet::ONE]
        };
        let [plant, feedback, near, turn] = parts;
        let near = near.value.re;
        let magnitude = size_in_v(self.denominator(), node.place.size_v)
            * node.operator.denominator.value.norm();
        let fed =
            self.subject.alpha * node.terms.rough[1] + self.subject.beta * node.terms.rough[2];
        // A term that falls towards rest loses no more than its share to rounding.
        let rates = plant.rate.norm() * fed + magnitude * feedback.rate.norm();
        let row = Row {
            theta,
            weight: near * plant.value.norm_sqr(),
            turned: turn.value * feedback.value * plant.value.conj(),
            sizes: [
                near * magnitude * magnitude,
                near * magnitude * fed + theta * rates,
            ],
        };
        Point {
            terms,
            parts,
            row,
            is_active: false,
        }
    }

    fn last(&self) -> f64 {
        f64::from(self.lags[self.lags.len() - 1])
    }

    /// h by least-distance programming; `None` if it finds none that makes all active rows positive.
    ///
    /// ```text
    /// min |x|²,  x ≥ 0,  B·x ≥ 1,    B·x = Re{M(W/k + E)}/size at each angle for  M = x₀ + Σ x_i(1 − w^i),   h_i = x_i/Σx
    /// ```
    /// Source: C. L. Lawson, R. J. Hanson, *Solving Least Squares Problems*, 1974, ch. 23, algorithm LDP.
    fn programme(&self, slope: f64) -> Option<Taps> {
        let lags: Vec<i32> = self.lags.iter().flat_map(|&i| [i, -i]).collect();
        let active = self.points.iter().filter(|point| point.is_active);
        let rows: Vec<Vec<f64>> = active
            .map(|Point { row, .. }| {
                let (value, size) = (row.value(slope), row.size(slope, self.last()));
                let turned = lags.iter().map(|&i| {
                    let (sin, cos) = libm::sincos(0.5 * f64::from(i) * row.theta);
                    2.0 * sin * (value.re * sin - value.im * cos)
                });
                let all = core::iter::once(value.re).chain(turned);
                all.map(|term| term / size).collect()
            })
            .collect();
        let unknowns = lags.len() + 1;
        let bounds = (0..unknowns).map(|index| {
            let mut column = vec![0.0; unknowns + 1];
            column[index] = 1.0;
            column
        });
        let of_rows = rows.iter().map(|row| [row.as_slice(), &[1.0]].concat());
        let columns: Vec<Vec<f64>> = of_rows.chain(bounds).collect();
        let mut target = vec![0.0; unknowns + 1];
        target[unknowns] = 1.0;
        let duals = non_negative_least_squares(columns.clone(), target);
        let mut x = vec![0.0; unknowns];
        for (column, dual) in columns.iter().zip(&duals) {
            for (x, term) in x.iter_mut().zip(column) {
                *x += dual * term;
            }
        }
        // Below zero only by rounding; left in the sum, those above would be more than 1 together, and no multiplier.
        x.iter_mut().for_each(|x| *x = x.max(0.0));
        let sum: f64 = x.iter().sum();
        if sum <= 0.0 {
            return None;
        }
        x.iter_mut().for_each(|x| *x /= sum);
        x.iter_mut().filter(|x| **x < DUST).for_each(|x| *x = 0.0);
        let heights = rows
            .iter()
            .map(|row| row.iter().zip(&x).map(|(a, x)| a * x).sum());
        let least = heights.fold(f64::INFINITY, f64::min);
        let taps = lags.into_iter().zip(x.drain(1..));
        let taps = Taps(taps.filter(|(_, h)| *h > 0.0).collect());
        (least > 0.0).then_some(taps)
    }

    /// h for which the inequality holds in every row with this slope.
    fn taps_for(&mut self, slope: f64) -> Option<Taps> {
        for _ in 0..EXCHANGES {
            let taps = self.programme(slope)?;
            let heights = self.points.iter().map(|Point { row, .. }| {
                let value = (taps.jet(row.theta).value * row.value(slope)).re;
                value / row.size(slope, self.last())
            });
            let heights: Vec<f64> = heights.collect();
            if heights.iter().all(|height| *height > 0.0) {
                return Some(taps);
            }
            // All valleys below zero join.
            let mut has_joined = false;
            for (index, &height) in heights.iter().enumerate() {
                let left = heights[index.saturating_sub(1)];
                let right = heights[(index + 1).min(heights.len() - 1)];
                let point = &mut self.points[index];
                if height <= left.min(right) && height <= 0.0 && !point.is_active {
                    point.is_active = true;
                    has_joined = true;
                }
            }
            if !has_joined {
                return None;
            }
        }
        None
    }

    /// The largest slope of all rows for this h.
    fn slope(&self, taps: &Taps) -> f64 {
        let slopes = self.points.iter();
        let slopes = slopes.map(|Point { row, .. }| row.slope(taps.jet(row.theta).value));
        slopes.fold(f64::INFINITY, f64::min)
    }

    /// The largest slope above one and below the other for which the rows have an h.
    fn steepest(&mut self, least: f64, provable: f64) -> Option<(f64, Taps)> {
        let circle = Taps::default();
        let mut low = self.slope(&circle).max(least);
        let mut high = CAP * provable.min(1e12);
        let mut best = (low > least).then_some((low.min(high), circle));
        let mut next = high;
        for _ in 0..BISECTIONS {
            if low >= ENOUGH_AGAIN * high {
                break;
            }
            match self.taps_for(next) {
                Some(taps) => {
                    low = self.slope(&taps).clamp(next, high);
                    best = Some((low, taps));
                }
                None => high = next,
            }
            next = if low > 1e-3 * high {
                0.5 * (low + high)
            } else {
                libm::sqrt(low.max(1e-12 * high) * high)
            };
        }
        best
    }

    /// A slope not above this for which the inequality is proved at every angle.
    fn proved(&mut self, mut slope: f64, mut taps: Taps) -> Option<(f64, Taps)> {
        let mut room = ROOM;
        for _ in 0..PROOFS {
            let tried = (1.0 - room) * slope;
            let Some(index) = self.fails(tried, &taps) else {
                return Some((tried, taps));
            };
            let point = &mut self.points[index];
            let is_new = !core::mem::replace(&mut point.is_active, true);
            let here = point.row.slope(taps.jet(point.theta()).value);
            self.sort();
            let is_enough = (ENOUGH_AGAIN * slope..tried).contains(&here);
            match (is_new && !is_enough).then(|| self.taps_for(tried)) {
                Some(Some(found)) => taps = found,
                Some(None) | None => slope = slope.min(here),
            }
            room = (1.25 * room).min(0.5);
        }
        None
    }

    /// The index of an angle at which the inequality does not hold, or about which nothing can be proved. All that it takes
    /// to look at join, at the end.
    fn fails(&mut self, slope: f64, taps: &Taps) -> Option<usize> {
        let judged = |point: &Point| {
            let multiplier = taps.jet(point.theta());
            let room = point.row.room(multiplier.value, taps.size(), slope);
            (multiplier, if room > 0.0 { room } else { 0.0 })
        };
        let mut known: Vec<(Jet, f64)> = self.points.iter().map(judged).collect();
        if let Some(index) = known.iter().position(|(_, room)| *room == 0.0) {
            return Some(index);
        }
        let mut todo: Vec<_> = (1..known.len()).map(|right| (right - 1, right)).collect();
        while let Some((left, right)) = todo.pop() {
            let (a, b) = (&self.points[left], &self.points[right]);
            let (near, far) = (a.theta(), b.theta());
            let width = far - near;
            let multiplier = taps.bounds(&known[left].0, &known[right].0, width);
            let bounds = self.bounds(a, b, multiplier, slope);
            let (low, high) = (known[left].1, known[right].1);
            let by_bend = low.min(high) > 0.125 * width * width * bounds.bend;
            if by_bend || low + high > bounds.travel {
                continue;
            }
            // In octaves near rest, where all falls with θ.
            let middle = if far > 4.0 * near {
                libm::sqrt(near * far)
            } else {
                0.5 * (near + far)
            };
            let is_inside = near * (1.0 + 1e-12) < middle && middle < far;
            let point = self.point(middle);
            let last = known.len();
            known.push(judged(&point));
            self.points.push(point);
            if !is_inside || known[last].1 == 0.0 || last > ANGLES {
                return Some(last);
            }
            todo.extend([(left, last), (last, right)]);
        }
        None
    }

    /// Bounds of the left side of the inequality over an interval.
    fn bounds(&self, a: &Point, b: &Point, multiplier: Bounds, slope: f64) -> Bounds {
        let [mut plant, feedback] = Open(self.subject).bounds(&a.terms, &b.terms);
        let (mut size, mut turn) = (Bounds::ONE, Bounds::ONE);
        if self.drifts {
            let (low, high) = (&a.terms.node.place, &b.terms.node.place);
            let [jet_a, jet_b] = [low, high].map(|place| jet_in_v(self.denominator(), place));
            let [_, below] = self
                .subject
                .characteristic
                .operator_bounds(&a.terms.node, &b.terms.node);
            plant = bounds_in_v(self.denominator(), low, high, &jet_a, &jet_b).times(below);
            let width = b.theta() - a.theta();
            let jet = |k: usize, rate: f64, bend: f64| {
                Bounds::from_ends(&a.parts[k], &b.parts[k], width, rate, bend)
            };
            (size, turn) = (jet(2, 1.0, 0.5), jet(3, 0.5, 0.25));
        }
        let lighter = Bounds {
            size: 1.0 / slope,
            ..Bounds::ONE
        };
        let sum = size.times(plant).times(lighter).plus(turn.times(feedback));
        multiplier.times(sum).times(plant)
    }
}

impl Point {
    fn theta(&self) -> f64 {
        self.terms.theta
    }
}
