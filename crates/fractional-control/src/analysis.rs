//! The verdict on a loop, its margins, and the reason of the verdict.

use crate::{
    ControlError, ControllerParameters, ControllerSetup, Crossing, FractionalTransferFunction,
    Margins, Plant, SampledControlLoop, StabilityVerdict, verdict::Judged,
};
use core::f64::consts::PI;
use num_complex::Complex;
use std::vec::Vec;

const POINTS: usize = 600;
/// The curve begins so far below the place of interest.
const BELOW: f64 = 300.0;
/// A gain further from the present one is no cause.
const WITHIN: f64 = 100.0;
/// Slower than this, rad a sample, nothing moves.
pub const AT_REST: f64 = 1e-8;
/// A gain is tried this much beside the one at which the loop meets −1.
const BESIDE: f64 = 0.01;

/// A loop that was judged.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct LoopAnalysis {
    /// The verdict, as a proof for the plant behind its hold; if `coarse` is not `None`, for the rule alone.
    pub verdict: StabilityVerdict,
    /// Margins and peaks: of a stable loop, the way to the boundary; of another they mean nothing.
    pub margins: Margins,
    /// The reason of the verdict.
    pub cause: VerdictCause,
    /// If the plant is sampled by a rule and not exactly ([`HeldPlant::is_exact`](crate::HeldPlant::is_exact)) and nothing is proved of
    /// the plant itself: the least factor by which it must be sampled more often. The verdict then is of the rule.
    pub coarse: Option<f64>,
    /// The open loop L and S = 1/(1 + L) over frequency.
    pub curve: Vec<LoopPoint>,
}

/// Orders nearer than this to a whole number, and different from it: no memory resolves the difference.
const NEAR_WHOLE: f64 = 1e-4;
/// Largest crossover times sample time to which the rule of a fractional plant is trusted.
const RULE_HOLDS_TO: f64 = 0.3;
/// Least factor for a loop whose rule does not stand for its plant.
const TWICE: f64 = 2.0;

/// The reason of a verdict.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum VerdictCause {
    /// Stable: no pole outside the unit circle.
    Stable,
    /// A pole on the unit circle, to within rounding.
    Boundary,
    /// A pole on the unit circle at any gain: a zero cancels it.
    Cancelled,
    /// Not decided: a number of the loop is larger than numbers are.
    TooLarge,
    /// Not decided: this order is next to a whole one, and no memory resolves the difference.
    NearWhole(f64),
    /// Stable at gains that are lower.
    GainTooHigh(OtherGain),
    /// Stable at gains that are higher.
    GainTooLow(OtherGain),
    /// Stable without the dead time; with it, L meets −1 from this one on, s.
    DeadTime(Crossing),
    /// Stable with the opposite sign of the gain, multiplied by this factor.
    WrongSign(f64),
    /// Neither another gain, within a hundred times, nor less dead time makes it stable.
    Shape,
}

/// Gains over the present one at which the loop would be stable.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct OtherGain {
    /// The nearest, at which L meets −1.
    pub edge: Crossing,
    /// The gain beyond at which L meets −1 again, and the loop is lost once more; `None` if it has
    /// none.
    pub end: Option<f64>,
}

/// L, S and T at a frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct LoopPoint {
    /// ω, rad/s; from point to point in equal steps of its logarithm.
    pub omega_rad_s: f64,
    /// L = C·G, the open loop that is really run.
    pub open: Complex<f64>,
    /// Phase of L without jumps, rad.
    pub phase_rad: f64,
}

impl LoopPoint {
    /// |S| = |1/(1 + L)|.
    #[must_use]
    pub fn sensitivity(&self) -> f64 {
        (self.open + 1.0).inv().norm()
    }

    /// |T| = |L/(1 + L)|.
    #[must_use]
    pub fn complementary(&self) -> f64 {
        (self.open / (self.open + 1.0)).norm()
    }
}

/// Judges the loop that is really run.
///
/// # Errors
/// A plant that does not run, parameters outside their range.
pub fn analyse(setup: &ControllerSetup, plant: &Plant) -> Result<LoopAnalysis, ControlError> {
    let sampled = setup.sampled(plant)?;
    analysed(setup, plant, &setup.closed_with(&sampled)?.judged())
}

/// Analyses a loop that is judged already.
///
/// # Errors
/// As [`analyse`].
pub fn analysed(
    setup: &ControllerSetup,
    plant: &Plant,
    judged: &Judged,
) -> Result<LoopAnalysis, ControlError> {
    // Of the plant, as the margins are, and not of the rule that stands for it.
    let open = &judged.of_plant;
    let later =
        |delay_s: f64| later(setup, plant, delay_s).map(|later| later.with_gain(open.gain()));
    let (mut verdict, margins) = (judged.verdict, open.margins_of_plant(&later));
    let drifts = plant.order_at_rest() > 0.0 && adds_up(&setup.law);
    if drifts && verdict.stable {
        // The product hides it: the command grows for ever, though no output does.
        (verdict.stable, verdict.unstable_poles, verdict.theta) = (false, None, 0.0);
    }
    let place = margins.phase.unwrap_or(margins.sensitivity).omega_rad_s;
    let t = setup.sample_time_s;
    let low = (place / BELOW).min(0.01 * PI / t);
    let curve = curve(low, PI / t, |omega| Some(open.open(omega * t)));
    let cause = match curve.len() {
        // NaN cannot be judged.
        POINTS => cause(setup, plant, judged.sampled_loop(), &verdict)?,
        _ => VerdictCause::TooLarge,
    };
    Ok(LoopAnalysis {
        verdict,
        margins,
        cause,
        coarse: judged.of_rule().map(coarse),
        curve,
    })
}

/// The loop whose plant has this much more dead time.
fn later(
    setup: &ControllerSetup,
    plant: &Plant,
    delay_s: f64,
) -> Result<SampledControlLoop, ControlError> {
    let plant = plant.clone().delayed(delay_s)?;
    setup.closed_with(&setup.sampled(&plant)?)
}

/// Least factor by which a loop must be sampled more often, if its rule is not proved to represent its plant.
pub(crate) fn coarse(closed: &SampledControlLoop) -> f64 {
    let slow = |theta: &f64| closed.open(*theta).norm() >= 1.0;
    let step = libm::log(PI / RULE_HOLDS_TO) / POINTS as f64;
    let angles = (0..=POINTS).map(|k| (PI * libm::exp(-step * k as f64)).max(RULE_HOLDS_TO));
    let fastest = angles.into_iter().find(slow).unwrap_or(0.0);
    (fastest / RULE_HOLDS_TO).max(TWICE)
}

/// Responses between two frequencies, in equal steps of the logarithm; unknown ones are omitted.
pub fn curve(
    low: f64,
    high: f64,
    response: impl Fn(f64) -> Option<Complex<f64>>,
) -> Vec<LoopPoint> {
    let ratio = libm::log(high / low) / (POINTS - 1) as f64;
    let omegas = (0..POINTS).map(|k| (low * libm::exp(ratio * k as f64)).min(high));
    let mut points: Vec<LoopPoint> = Vec::new();
    for omega_rad_s in omegas {
        let Some(open) = response(omega_rad_s).filter(|open| open.is_finite()) else {
            continue;
        };
        let phase_rad = match points.last() {
            Some(last) => last.phase_rad + (open / last.open).arg(),
            // A loop lags more often than it leads.
            None if open.arg() > 0.5 * PI + 1e-3 => open.arg() - 2.0 * PI,
            None => open.arg(),
        };
        points.push(LoopPoint {
            omega_rad_s,
            open,
            phase_rad,
        });
    }
    points
}

fn adds_up(law: &ControllerParameters) -> bool {
    match law {
        ControllerParameters::Pid(law) => law.integral != 0.0,
        ControllerParameters::Tid(law) => law.integral != 0.0,
        ControllerParameters::Function(law) => {
            law.denominator().lowest() > law.numerator().lowest()
        }
        ControllerParameters::Crone(_) | ControllerParameters::LeadLag(_) => false,
    }
}

/// An order next to a whole one, but not it, in plant or controller.
fn near_whole(setup: &ControllerSetup, plant: &Plant) -> Option<f64> {
    let orders_of = |function: &FractionalTransferFunction| -> Vec<f64> {
        let terms = function.numerator().terms().iter();
        let terms = terms.chain(function.denominator().terms());
        terms.map(|term| term.order).collect()
    };
    let mut orders = plant.beside_factors().map(orders_of).unwrap_or_default();
    match &setup.law {
        ControllerParameters::Pid(law) => {
            orders.extend([law.integral_order, law.derivative_order]);
        }
        ControllerParameters::Function(function) => orders.extend(orders_of(function)),
        ControllerParameters::Tid(_)
        | ControllerParameters::Crone(_)
        | ControllerParameters::LeadLag(_) => {}
    }
    orders.into_iter().find(|order| {
        let off = (order - order.round()).abs();
        off > 0.0 && off < NEAR_WHOLE
    })
}

/// The first of these gains, at which L meets −1, beyond which the loop is stable, and how many lie before it; they go away from 1.
///
/// Of the loop as it is, or with the other `sign` of its gain, `poles` grow. At each gain no more than two come inside, so of n that grow
/// the loop is not stable before n/2 gains are passed. No verdict is asked for in the first half of these, as a long dead time has
/// thousands of them (half: two near each other may be counted as one).
fn other_gain<'a>(
    closed: &SampledControlLoop,
    sign: f64,
    poles: usize,
    gains: impl Iterator<Item = &'a Crossing>,
) -> Option<(usize, OtherGain)> {
    let within = |gain: &&Crossing| gain.value > 1.0 / WITHIN && gain.value < WITHIN;
    let mut gains = gains.peekable();
    let mut passed = 0;
    let mut sooner = poles.div_ceil(4);
    while let Some(edge) = gains.next_if(within) {
        passed += 1;
        sooner = sooner.saturating_sub(1);
        if sooner > 0 {
            continue;
        }
        let end = gains.peek().map(|next| next.value);
        let falls = edge.value < 1.0;
        let neighbour = edge.value * if falls { 1.0 - BESIDE } else { 1.0 + BESIDE };
        let nearer = if falls { f64::max } else { f64::min };
        // Not beyond the middle between the two, in case they are near each other.
        let tried = end.map_or(neighbour, |end| {
            nearer(neighbour, (edge.value * end).sqrt())
        });
        let verdict = closed.with_gain(sign * tried).verdict();
        if verdict.stable {
            return Some((passed - 1, OtherGain { edge: *edge, end }));
        }
        sooner = verdict.unstable_poles.unwrap_or(1).div_ceil(4);
    }
    None
}

/// Factor on the gain, of opposite sign, with which the loop is stable; the nearest to 1 of those found.
fn with_the_other_sign(closed: &SampledControlLoop) -> Option<f64> {
    let turned = closed.with_gain(-1.0);
    let verdict = turned.verdict();
    if verdict.stable {
        return Some(1.0);
    }
    let (poles, gains) = (verdict.unstable_poles?, turned.gain_crossings());
    let below = gains.iter().rev().filter(|gain| gain.value < 1.0);
    let above = gains.iter().filter(|gain| gain.value > 1.0);
    let found = other_gain(closed, -1.0, poles, below);
    let found = found.or_else(|| other_gain(closed, -1.0, poles, above));
    let (_, OtherGain { edge, end }) = found?;
    // Between both ends, or twice as far.
    Some(match end {
        Some(end) => (edge.value * end).sqrt(),
        None if edge.value < 1.0 => 0.5 * edge.value,
        None => 2.0 * edge.value,
    })
}

/// The reason of a pole on the unit circle.
fn on_the_circle(closed: &SampledControlLoop) -> VerdictCause {
    let stays = |gain: f64| closed.with_gain(gain).verdict().unstable_poles.is_none();
    if [0.9, 1.1].into_iter().all(stays) {
        VerdictCause::Cancelled
    } else {
        VerdictCause::Boundary
    }
}

fn cause(
    setup: &ControllerSetup,
    plant: &Plant,
    closed: &SampledControlLoop,
    verdict: &StabilityVerdict,
) -> Result<VerdictCause, ControlError> {
    if verdict.stable {
        return Ok(VerdictCause::Stable);
    }
    let Some(poles) = verdict.unstable_poles else {
        return Ok(
            near_whole(setup, plant).map_or_else(|| on_the_circle(closed), VerdictCause::NearWhole)
        );
    };
    let gains = closed.gain_crossings();
    let below = gains.iter().rev().filter(|gain| gain.value < 1.0);
    let lower = other_gain(closed, 1.0, poles, below);
    let above = gains.iter().filter(|gain| gain.value > 1.0);
    let higher = other_gain(closed, 1.0, poles, above);
    let ways = [
        lower.map(|(passed, gain)| (passed, VerdictCause::GainTooHigh(gain))),
        higher.map(|(passed, gain)| (passed, VerdictCause::GainTooLow(gain))),
    ];
    // A cure by the next gain precedes the dead time, one by a gain further away follows it.
    let mut ways = ways.into_iter().flatten();
    let next = ways.clone().find(|(passed, _)| *passed == 0);
    match next.map(|(_, cause)| cause) {
        // At rest it feeds errors back upon themselves.
        Some(VerdictCause::GainTooHigh(OtherGain { edge, .. }))
            if edge.omega_rad_s * setup.sample_time_s < 2.0 * AT_REST
                && closed.with_gain(-1.0).verdict().stable =>
        {
            return Ok(VerdictCause::WrongSign(1.0));
        }
        Some(next) => return Ok(next),
        None => {}
    }
    if plant.delay_s() > 0.0
        && let Some(prompt) = plant.without_dead_time()
    {
        let judged = setup.closed_with(&setup.sampled(&prompt)?)?.judged();
        let first = judged.sampled_loop().margins().delay_s;
        let later = |delay_s| later(setup, &prompt, delay_s);
        if judged.verdict.stable
            && let Some(delay) = SampledControlLoop::delay_margin(first, &later).unwrap_or(first)
        {
            return Ok(VerdictCause::DeadTime(delay));
        }
    }
    Ok(match ways.next() {
        Some((_, further)) => further,
        None => with_the_other_sign(closed).map_or(VerdictCause::Shape, VerdictCause::WrongSign),
    })
}

/// Poles of a transfer function alone.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct PoleAnalysis {
    /// q, of which all orders are multiples; `None` if no such value is large enough.
    pub commensurate_order: Option<f64>,
    /// Poles s on the principal branch; empty without q.
    pub poles: Vec<Complex<f64>>,
    /// Poles with Re s > 0; `None` with one on the axis.
    pub unstable_poles: Option<usize>,
}

/// Poles of a function or of matrices, and how many of them do not decay; `None` for a measured
/// response.
#[must_use]
pub fn poles(plant: &Plant) -> Option<PoleAnalysis> {
    if let Some(function) = plant.beside_factors() {
        let commensurate = function.commensurate().ok();
        return Some(PoleAnalysis {
            commensurate_order: commensurate.as_ref().map(|poles| poles.order()),
            poles: commensurate.map(|poles| poles.poles()).unwrap_or_default(),
            unstable_poles: function.unstable_poles(),
        });
    }
    let poles = plant.poles()?;
    let growing = plant.unstable_poles();
    let decays = plant.stable_by_itself().is_ok();
    Some(PoleAnalysis {
        commensurate_order: Some(1.0),
        poles,
        unstable_poles: (growing > 0 || decays).then_some(growing),
    })
}
