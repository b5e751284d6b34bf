//! The stability region in the α–β plane, by D-decomposition.
//!
//! F is linear in α and β, so the places where a zero can cross the unit circle are known in closed form: one curve for 0 < θ < π and two
//! straight lines for w = 1 and w = −1. They cut the quadrant α, β ≥ 0 into cells with one number of unstable poles each. In order:
//!
//! 1. **A box.** A stable F has a logarithm in the disc, and |F| ≤ M there with M linear in α and β.
//!    Every Taylor coefficient of log F is at most 2Λ, Λ = log M (Carathéodory), so the coefficient of
//!    w^(d+1) of F itself, n₁(α + p₀β) apart from the plant's own, is at most that of
//!    exp(2Λw/(1 − w)), a polynomial in log(α + β). A linear function exceeds it from some R on: the
//!    region lies in α + p₀β ≤ R, for every operator. It is never unbounded.
//! 2. **The curve** inside the box, with nothing left out (`decomposition.rs`), and all crossings of
//!    its branches, the lines and the axes (`arrangement.rs`).
//! 3. **The pieces that count.** Crossing the curve to the side that Im P gives removes two unstable
//!    poles, crossing a line one; a piece bounds the region exactly if that side has no unstable pole.
//!    One certified count beside each piece decides. No cell is assumed stable or not: holes and
//!    detached parts come out as further polygons.
//! 4. **Polygons**: the pieces joined, the region on their left; holes run clockwise.
//!
//! Sources: Yu. I. Neimark, *D-partition and robust stability*, Comput. Math. Model. 9, 1998;
//! O. Tokatlı, *Fractional Order Control in Haptics*, §4.3.

use crate::arrangement::{Edge, monotone, pieces};
use crate::arrangement::{Straight, near};
use crate::characteristic::Characteristic;
use crate::decomposition::Decomposition;
use crate::outline::Outline;
use crate::outline::{OutlinePoint, Polygon};
use crate::{AnalysisError, LoopOperator, SampledPlant};
use core::f64::consts::PI;
use fracdiff::parameter::{positive, range};

/// The α, β ≥ 0 for which a loop is stable.
/// ```
/// use fracdiff::{Order, Scheme, Seconds};
/// use haptic_analysis::{LoopOperator, SampledPlant, StabilityRegion};
///
/// let operator = LoopOperator::new(Scheme::Exact, Order::new(1.0)?, Seconds(1e-3), 1e4)?;
/// let plant = SampledPlant::new(0.1, 0.0)?; // δ = bT/m = 0.1
/// let region = StabilityRegion::new(plant, &operator, 0, 1000)?;
/// let area = region.bounded().ok_or("no wall is stable")?;
/// assert!((area.alpha_max - 0.82582).abs() < 1e-5 && region.contains(0.5, 0.8));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum StabilityRegion {
    /// No stable loop with α, β ≥ 0.
    Empty {
        /// R: none was possible beyond α + p₀β = R.
        searched: f64,
    },
    /// A bounded region, perhaps with holes or in several parts.
    Bounded(StableArea),
}

/// A region that is not empty.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct StableArea {
    /// Outer boundaries and holes, the largest first.
    pub polygons: Vec<Polygon>,
    /// Area in the plane of α and β, holes taken away.
    pub area: f64,
    /// The least upper bound of α.
    pub alpha_max: f64,
    /// β where it is reached.
    pub beta_at_alpha_max: f64,
    /// The least upper bound of β.
    pub beta_max: f64,
    /// R: the region was proved to lie within α + p₀β ≤ R, p₀ the direct gain of the operator.
    pub searched: f64,
    /// (p, c) of the line of w = 1: stable loops have α + pβ > c. It may coincide with an axis.
    at_rest: (f64, f64),
}

impl StabilityRegion {
    /// Longest delay, samples: beyond, the box of step 1 leaves the range of `f64`.
    pub const DELAY_MAX: usize = 64;
    /// Smallest order other than 0: below, the curve is indistinguishable from a straight line.
    pub const ORDER_MIN: f64 = 1e-6;

    /// Computes it for a plant, an operator and `delay` samples beside those of the plant, with about `points` points on
    /// the boundary (at least what its shape needs, some hundred).
    ///
    /// - *Accuracy*: points on the curve to about 1e-12, extremes of α and β to 1e-10; parts smaller than about 1e-8 are not seen.
    /// - *Cost*: some 10³ responses of the operator, one certified count a piece (a few dozen), and `points` responses.
    ///
    /// # Errors
    /// δ or γ outside the range of a [`SampledPlant`]; an order between 0 and 1e-6; a direct gain that is not above 0; d above 64, or
    /// [`AnalysisError::Unresolved`] if the pieces do not close to polygons, which means that parts of the boundary come closer to each other
    /// than rounding errors.
    pub fn new(
        plant: SampledPlant,
        operator: &LoopOperator,
        delay: usize,
        points: usize,
    ) -> Result<Self, AnalysisError> {
        let plant = plant.later(delay)?;
        let samples = plant.path().delay_samples();
        let short = samples <= Self::DELAY_MAX as f64;
        let allowed = "from 0 to 64 {}";
        range("delay of a region", samples, short, allowed, "samples")?;
        let order = operator.order().get();
        let kept = order <= 0.0 || order >= Self::ORDER_MIN;
        range("order of a region", order, kept, "0, or from 1e-6 to 2", "")?;
        positive("direct gain of a region", operator.direct_gain(), "")?;
        let characteristic = Characteristic::new(plant, operator);
        let decomposition = Decomposition {
            characteristic,
            direct_gain: operator.direct_gain(),
            reach: reach(&characteristic)?,
        };
        let searched = decomposition.reach;
        let loops = if order == 0.0 {
            polygons(&decomposition)
        } else {
            let edges = edges(&decomposition)?;
            let pieces = pieces(&decomposition, &edges);
            let outline = Outline {
                decomposition: &decomposition,
                circle: characteristic.circle(),
                edges: &edges,
                pieces: &pieces,
            };
            outline.polygons(points)?
        };
        let at_rest = decomposition.line_at_rest().unwrap_or((0.0, 0.0));
        Ok(summary(loops, searched, at_rest))
    }

    /// The area, unless it is empty.
    #[must_use]
    pub fn bounded(&self) -> Option<&StableArea> {
        match self {
            Self::Empty { .. } => None,
            Self::Bounded(area) => Some(area),
        }
    }

    /// True if a loop with these α and β is stable, read from the polygons: right up to their chords, which with 2000 points are within
    /// about 1e-6 of the boundary. Cost: one comparison a point, far less than a verdict, so this is what maps are made from.
    #[must_use]
    pub fn contains(&self, alpha: f64, beta: f64) -> bool {
        let Some(area) = self.bounded() else {
            return false;
        };
        let (p, c) = area.at_rest;
        if alpha + p * beta <= c {
            return false;
        }
        // Even–odd: holes and parts alike.
        let polygons = area.polygons.iter();
        let crossings = polygons.filter(|polygon| polygon.contains(alpha, beta));
        crossings.count() % 2 == 1
    }
}

/// R, see the module's step 1.
fn reach(characteristic: &Characteristic) -> Result<f64, AnalysisError> {
    let Characteristic {
        plant, operator, ..
    } = characteristic;
    let direct = operator.direct_gain();
    // sup |P| over the circle, generously: it enters as a logarithm.
    let (at_nyquist, _) = operator.response_and_rate(PI);
    let largest = at_nyquist.norm() + operator.variation(0.0, PI);
    let passive: f64 = plant.denominator().iter().map(|a| a.abs()).sum();
    let gain = plant.numerator().iter().map(|n| n.abs()).sum::<f64>() * (largest / direct).max(1.0);
    let coefficient = |power: usize| plant.denominator().get(power).map_or(0.0, |a| a.abs());
    // The coefficient of w^p of a stable F, less the plant's own.
    let coefficient = |power: usize, reach: f64| {
        let lambda = libm::log(passive + gain * reach);
        // [w^p] exp(2Λw/(1 − w)) = Σ_{k=1}^{p} C(p − 1, k − 1)(2Λ)^k/k!
        let mut term = 2.0 * lambda;
        let mut sum = 0.0;
        for k in 1..=power {
            sum += term;
            let k = k as f64;
            term *= 2.0 * lambda * (power as f64 - k) / (k * (k + 1.0));
        }
        coefficient(power) + sum
    };
    let power = plant.path().whole_samples() + 1;
    let n = |power: usize| plant.numerator().get(power).copied().unwrap_or(0.0);
    let (n1, n0) = (n(0), n(1));
    let first = largest_root(|reach| coefficient(power, reach) / n1).filter(|_| n1 > 0.0);
    // A force that arrives late in its sample hardly moves the plant before the next: there
    // [w^(p+1)] + c·[w^p] of w^p(n₁ + n₀w)(α + βP), with c = sup|P|/p₀ ≥ |p₁|/p₀, is at least n₀(α + p₀β).
    let late = (plant.path().fraction() > 0.0 && n0 > 0.0 && n1 >= 0.0).then(|| {
        let share = largest / direct;
        largest_root(|reach| {
            (coefficient(power + 1, reach) + share * coefficient(power, reach)) / n0
        })
    });
    let found = [first, late.flatten()].into_iter().flatten();
    found
        .min_by(f64::total_cmp)
        .ok_or(AnalysisError::Unresolved {
            what: "a box that holds the stability region",
            why: if n1 < 0.0 {
                "within a sample a force moves the plant the other way: judge single walls"
            } else {
                "a force hardly moves the plant within a sample"
            },
        })
}

/// The largest R with R ≤ bound(R), from above: every step keeps the region inside.
fn largest_root(bound: impl Fn(f64) -> f64) -> Option<f64> {
    let mut reach: f64 = 1e250;
    for _ in 0..2000 {
        let next = bound(reach);
        if next >= reach || next.is_nan() {
            return None;
        }
        let settled = next > 0.99 * reach;
        reach = next;
        if settled {
            return Some(reach);
        }
    }
    None
}

/// The curve between its extremes, the straight lines and the axes.
fn edges(decomposition: &Decomposition) -> Result<Vec<Edge>, AnalysisError> {
    let trace = decomposition.trace()?;
    let mut edges: Vec<Edge> = (trace.stretches.iter())
        .flat_map(|stretch| monotone(decomposition, stretch))
        .collect();
    let gain = |theta: f64| decomposition.characteristic.node(theta).gain.value.re;
    let mut lines: Vec<(f64, f64, f64, Option<bool>)> = Vec::new();
    let mut rest_on_axis = None;
    if let Some((p, c)) = decomposition.line_at_rest() {
        if p.abs() <= 1e-12 && c.abs() <= 1e-12 {
            // α = 0: the axis itself.
            rest_on_axis = Some(0.0);
        } else {
            lines.push((p, c, 0.0, Some(gain(0.0) > 0.0)));
        }
    }
    if let Some((p, c)) = decomposition.line_at_nyquist() {
        lines.push((p, c, PI, Some(gain(PI) > 0.0)));
    }
    lines.extend(trace.lines.iter().map(|&(p, c, theta)| (p, c, theta, None)));
    let (alpha_end, beta_end) = (
        decomposition.reach,
        decomposition.reach / decomposition.direct_gain,
    );
    for (p, c, theta, stable_side) in lines {
        if let Some(ends) = cut_to_box(p, c, alpha_end, beta_end) {
            edges.push(Edge::Straight(Straight {
                ends,
                normal: [1.0, p],
                offset: c,
                theta: Some(theta),
                stable_side,
            }));
        }
    }
    let axis = |end: [f64; 2], normal, theta| {
        Edge::Straight(Straight {
            ends: [[0.0, 0.0], end],
            normal,
            offset: 0.0,
            theta,
            stable_side: Some(true),
        })
    };
    edges.push(axis([alpha_end, 0.0], [0.0, 1.0], None));
    edges.push(axis([0.0, beta_end], [1.0, 0.0], rest_on_axis));
    Ok(edges)
}

/// The ends of the line α = c − pβ with 0 ≤ β ≤ its end and 0 ≤ α ≤ its end, if it has a length there.
fn cut_to_box(p: f64, c: f64, alpha_end: f64, beta_end: f64) -> Option<[[f64; 2]; 2]> {
    let (mut low, mut high) = (0.0_f64, beta_end);
    if p == 0.0 {
        if !(0.0..=alpha_end).contains(&c) {
            return None;
        }
    } else {
        let (one, other) = (c / p, (c - alpha_end) / p);
        low = low.max(one.min(other));
        high = high.min(one.max(other));
    }
    let ends = [
        [(c - p * low).max(0.0), low],
        [(c - p * high).max(0.0), high],
    ];
    (low < high && !near(ends[0], ends[1])).then_some(ends)
}

fn summary(mut polygons: Vec<Polygon>, searched: f64, at_rest: (f64, f64)) -> StabilityRegion {
    polygons.retain(|polygon| polygon.points.len() > 2);
    polygons.sort_by(|a, b| b.area.total_cmp(&a.area));
    let points = || polygons.iter().flat_map(|polygon| &polygon.points);
    let Some(peak) = points().max_by(|a, b| a.alpha.total_cmp(&b.alpha)).copied() else {
        return StabilityRegion::Empty { searched };
    };
    let beta_max = points().fold(0.0, |most: f64, point| most.max(point.beta));
    StabilityRegion::Bounded(StableArea {
        area: polygons.iter().map(|polygon| polygon.area).sum(),
        polygons,
        alpha_max: peak.alpha,
        beta_at_alpha_max: peak.beta,
        beta_max,
        searched,
        at_rest,
    })
}

/// The strips κ₁ < α + pβ < κ₂ of stable loops, cut to the quadrant.
pub(crate) fn polygons(decomposition: &Decomposition) -> Vec<Polygon> {
    let characteristic = &decomposition.characteristic;
    let (p, _) = characteristic.operator.response_and_rate(0.0);
    let mut edges: Vec<(f64, Option<f64>)> = vec![(0.0, None), (decomposition.reach, None)];
    // w = ±1: κ = −A/S.
    let ends = [
        (decomposition.line_at_rest(), 0.0),
        (decomposition.line_at_nyquist(), PI),
    ];
    edges.extend(
        ends.into_iter()
            .filter_map(|(line, theta)| Some((line?.1, Some(theta)))),
    );
    edges.extend(
        real_crossings(decomposition)
            .into_iter()
            .map(|(kappa, theta)| (kappa, Some(theta))),
    );
    edges.retain(|(kappa, _)| (0.0..=decomposition.reach).contains(kappa));
    // The rest at κ = 0 says more than the axis does.
    edges.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.is_some().cmp(&a.1.is_some())));
    edges.dedup_by(|b, a| b.0 - a.0 <= 1e-12 * a.0.max(1e-3));
    let circle = characteristic.circle();
    let mut strips: Vec<[(f64, Option<f64>); 2]> = Vec::new();
    for pair in edges.windows(2) {
        let kappa = 0.5 * (pair[0].0 + pair[1].0);
        if circle.count([kappa, 0.0], 0.0, false).unstable_poles != Some(0) {
            continue;
        }
        match strips.last_mut() {
            // A crossing that only touches does not bound anything.
            Some(strip) if strip[1].0 >= pair[0].0 => strip[1] = pair[1],
            _ => strips.push([pair[0], pair[1]]),
        }
    }
    strips.iter().map(|strip| polygon(strip, p.re)).collect()
}

fn polygon([low, high]: &[(f64, Option<f64>); 2], p: f64) -> Polygon {
    let corner = |alpha: f64, beta: f64, theta| OutlinePoint { alpha, beta, theta };
    let mut points = vec![
        corner(low.0, 0.0, low.1),
        corner(high.0, 0.0, high.1),
        corner(0.0, high.0 / p, high.1),
    ];
    if low.0 > 0.0 {
        points.push(corner(0.0, low.0 / p, low.1));
    }
    Polygon {
        points,
        area: 0.5 * (high.0 - low.0) * (high.0 + low.0) / p,
    }
}

/// All κ = −A/S that are real, with their angles: zeros of Im(A·S*) in (0, π), none missed.
fn real_crossings(decomposition: &Decomposition) -> Vec<(f64, f64)> {
    let characteristic = &decomposition.characteristic;
    let value = |theta: f64| {
        let node = characteristic.node(theta);
        (node, (node.plant.value * node.gain.value.conj()).im)
    };
    const END: f64 = 1e-6;
    let mut found = Vec::new();
    let mut todo = vec![(END, PI - END)];
    while let Some((low, high)) = todo.pop() {
        let ((a, at_a), (b, at_b)) = (value(low), value(high));
        let bend = (characteristic.plant_bounds(&a, &b))
            .times(characteristic.gain_bounds(&a, &b))
            .bend;
        let width = high - low;
        if at_a * at_b > 0.0 && at_a.abs().min(at_b.abs()) > 0.125 * width * width * bend {
            continue;
        }
        let middle = 0.5 * (low + high);
        if width > 1e-13 && middle > low && middle < high {
            todo.extend([(low, middle), (middle, high)]);
        } else {
            let gain = a.gain.value;
            found.push(((-a.plant.value / gain).re, middle));
        }
    }
    found
}
