//! The verdict on a loop, its root and its margins; or the poles of a plant alone.

use super::{ControlLoop, LOOP_CONTROLLER};
use crate::words::{in_short, margins};
use core::f64::consts::PI;
use fractional_control::analysis::{
    AT_REST, LoopAnalysis, LoopPoint, OtherGain, VerdictCause, analyse, curve, poles,
};
use fractional_control::num_complex::Complex;
use fractional_control::{ControllerSetup, Crossing, Margins};
use haptic_document::Failure;
use haptic_quantity::{digits, written};
use haptic_trial::advice::refused;
use serde_json::{Value, json};

/// An analysis of a loop, or of a plant alone.
#[derive(Clone, Debug)]
pub struct AnalysedLoop {
    /// Its numbers, with warnings. The keys are a contract of the command line.
    pub report: Value,
    /// L over frequency, or G.
    pub curve: AnalysisCurve,
}

/// The curve of an analysis.
#[derive(Clone, Debug)]
pub enum AnalysisCurve {
    /// Curve of a loop, with the margins on it.
    Loop(Box<LoopAnalysis>),
    /// Curve of a plant that has no controller.
    Plant(Vec<LoopPoint>),
}

impl ControlLoop {
    /// Judges the loop; of a plant alone, finds its poles.
    ///
    /// # Errors
    /// A plant that does not run, or has no poles.
    pub fn analysed(&self) -> Result<AnalysedLoop, Failure> {
        match &self.controller {
            Some(setup) => self.judged(setup),
            None => self.alone(),
        }
    }

    fn judged(&self, setup: &ControllerSetup) -> Result<AnalysedLoop, Failure> {
        let analysis = analyse(setup, &self.plant.plant).map_err(refused)?;
        let (judged, proved) = (&analysis.verdict, analysis.coarse.is_none());
        let report = json!({
            "plant": self.plant.words,
            "controller": setup.law.to_string(),
            "sample_time_s": setup.sample_time_s,
            "scheme": setup.scheme.to_string(),
            // Null where nothing is proved.
            "stable": proved.then_some(judged.stable),
            "unstable_poles": judged.unstable_poles.filter(|_| proved),
            "distance": judged.distance,
            "reason": verdict(&analysis),
            // Factor by which the sample time must be shorter for the verdict to hold for the plant; null if it holds already.
            "coarse": analysis.coarse,
            // Null for an unstable loop, where margins have no meaning.
            "margins": (judged.stable && proved).then(|| margins(&analysis.margins)),
            "warnings": self.warnings,
        });
        let curve = AnalysisCurve::Loop(Box::new(analysis));
        Ok(AnalysedLoop { report, curve })
    }

    fn alone(&self) -> Result<AnalysedLoop, Failure> {
        let plant = &self.plant.plant;
        if self.plant.is_measured() {
            return Err(Failure::bad_input(
                "a measured response has no poles: give a transfer function, or use control design",
            ));
        }
        let found = poles(plant);
        let unstable = found.as_ref().and_then(|found| found.unstable_poles);
        let stable = plant.stable_by_itself().is_ok();
        let all = found.as_ref().map_or(&[][..], |found| &found.poles);
        let middle = corner(
            all.iter()
                .map(|pole| pole.norm())
                .chain(plant.factors().corners()),
        );
        let report = json!({
            "plant": self.plant.words,
            "stable": stable,
            "unstable_poles": unstable,
            "commensurate_order": found.as_ref().and_then(|found| found.commensurate_order),
            "reason": match (stable, unstable) {
                (true, _) => "Stable.".to_owned(),
                (false, None | Some(0)) => format!(
                    "On the boundary: a pole does not decay. Close the loop with {LOOP_CONTROLLER}."
                ),
                (false, Some(_)) => format!("Unstable. Close the loop with {LOOP_CONTROLLER}."),
            },
            // Why no poles are listed.
            "poles_reason": match &found {
                None => Some("the orders have no common multiple that is large enough"),
                Some(found) if found.poles.is_empty() && !plant.factors().is_empty() => {
                    Some("a power of a bracket and diffusion creep without poles")
                }
                Some(found) if found.poles.is_empty() => {
                    Some("none on the principal branch: the plant only creeps")
                }
                Some(_) => None,
            },
            "poles": all.iter().map(pole).collect::<Vec<_>>(),
            "warnings": self.warnings,
        });
        let curve = curve(1e-3 * middle, 1e3 * middle, |omega| plant.response(omega));
        let curve = AnalysisCurve::Plant(curve);
        Ok(AnalysedLoop { report, curve })
    }
}

/// The place of interest of a plant: the middle of these corners, rad/s.
fn corner(corners: impl Iterator<Item = f64>) -> f64 {
    let logs = corners.map(libm::log).filter(|log| log.is_finite());
    let logs: Vec<f64> = logs.collect();
    if logs.is_empty() {
        return 1.0;
    }
    libm::exp(logs.iter().sum::<f64>() / logs.len() as f64)
}

fn pole(pole: &Complex<f64>) -> Value {
    let size = pole.norm();
    json!({
        "re": pole.re,
        // A real pole, but for rounding.
        "im": if pole.im.abs() < 1e-12 * size { 0.0 } else { pole.im },
        "re_unit": "rad/s",
        "im_unit": "rad/s",
        "omega_rad_s": size,
        // Null at s = 0.
        "damping_ratio": (size > 0.0).then_some(0.0 - pole.re / size),
    })
}

fn stable(margins: &Margins) -> String {
    let at = |crossing: &Crossing| format!("(at {} rad/s)", digits(crossing.omega_rad_s, 4));
    let times = |gain: Crossing, words| format!("{} {words} {}", digits(gain.value, 4), at(&gain));
    let up = margins.gain_up.map(|gain| times(gain, "times the gain"));
    let down = margins.gain_down.map(|gain| times(gain, "of the gain"));
    let delay = margins.delay_s.map(|delay| {
        let longer = written("delay_s", delay.value);
        format!("{longer} more dead time {}", at(&delay))
    });
    let ways: Vec<String> = [up, down, delay].into_iter().flatten().collect();
    let nearest = &margins.sensitivity;
    let end = if ways.is_empty() {
        "neither more gain nor more dead time makes it unstable".to_owned()
    } else {
        format!("unstable at {}", ways.join(", or at "))
    };
    format!(
        "Stable, proved. Errors grow at most {} times {}; {end}.",
        digits(nearest.value, 4),
        at(nearest)
    )
}

/// The verdict, its root and the way to the boundary, in sentences.
fn verdict(analysis: &LoopAnalysis) -> String {
    // With a coarse rule the stability boundary and its frequency are known for the model only.
    analysis.coarse.map_or_else(
        || of_the_loop(analysis),
        |times| {
            format!(
                "The loop is {}: too fast for it. Divide the sample time by at least {}.",
                in_short(analysis),
                digits(times, 4)
            )
        },
    )
}

/// True if the loop comes nearest to the boundary where nothing moves.
fn at_rest(analysis: &LoopAnalysis) -> bool {
    analysis.verdict.theta < AT_REST
}

fn of_the_loop(analysis: &LoopAnalysis) -> String {
    let poles = match analysis.verdict.unstable_poles {
        Some(1) => "one pole grows".to_owned(),
        Some(poles) => format!("{poles} poles grow"),
        None => "a pole does not decay".to_owned(),
    };
    // The curve ends at half the sample rate.
    let half = analysis.curve.last().map_or(f64::NAN, |at| at.omega_rad_s);
    let omega = digits(analysis.verdict.theta / PI * half, 4);
    let at = |crossing: &Crossing| digits(crossing.omega_rad_s, 4);
    // The gains for which it is stable.
    let where_stable = |beyond: &str, edge: f64, end: Option<f64>| match end {
        None => format!("{beyond} {}", digits(edge, 4)),
        Some(end) => {
            let [low, high] = [edge.min(end), edge.max(end)].map(|gain| digits(gain, 4));
            format!("between {low} and {high}")
        }
    };
    let unstable = |why: String| format!("Unstable, proved: {poles}{why}");
    match analysis.cause {
        VerdictCause::Stable => stable(&analysis.margins),
        VerdictCause::Boundary | VerdictCause::Cancelled if at_rest(analysis) => {
            "On the boundary: a pole neither decays nor grows within 1e8 samples. \
             An integral may meet a factor s: omit one, or add a proportional part. \
             Else raise the gain or the sample time."
                .to_owned()
        }
        VerdictCause::Boundary => {
            format!("On the boundary: {poles} at {omega} rad/s. Change the gain a little.")
        }
        VerdictCause::Cancelled => format!(
            "On the boundary at any gain: {poles} at {omega} rad/s, where a zero cancels it: move it."
        ),
        VerdictCause::TooLarge => {
            "Not decided: a number is beyond 1e-308 to 1e308. Give the loop in other units."
                .to_owned()
        }
        VerdictCause::NearWhole(order) => format!(
            "Not decided: order {order} is too close to {}. Write the whole order.",
            order.round()
        ),
        VerdictCause::GainTooHigh(OtherGain { edge, end, .. }) => unstable(format!(
            ": too much gain. At {} rad/s the loop inverts errors and makes them {} times as large. Stable {} times the gain.",
            at(&edge),
            digits(1.0 / edge.value, 4),
            where_stable("below", edge.value, end)
        )),
        VerdictCause::GainTooLow(OtherGain { edge, end, .. }) => unstable(format!(
            ": too little gain to hold the plant (at {} rad/s). Stable {} times the gain.",
            at(&edge),
            where_stable("above", edge.value, end)
        )),
        VerdictCause::WrongSign(gain) => unstable(format!(
            ": the sign is wrong. Change the sign of controller or plant{}.",
            match gain {
                1.0 => String::new(),
                gain => format!(", with {} times the gain", digits(gain, 4)),
            }
        )),
        VerdictCause::DeadTime(delay) => unstable(format!(
            ": the dead time is too long. Stable up to {} (at {} rad/s).",
            written("delay_s", delay.value),
            at(&delay)
        )),
        VerdictCause::Shape => {
            let near = analysis.margins.phase.as_ref();
            let near = near.map(|crossover| format!(" (more phase near {} rad/s)", at(crossover)));
            unstable(format!(
                ". Neither gain nor dead time alone makes it stable: change the controller{} or sample faster.",
                near.unwrap_or_default()
            ))
        }
    }
}
