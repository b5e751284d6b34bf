//! `control analyze`: the verdict on a loop, its root and its margins; or the poles of a plant.

use super::draw::{draw_loop, draw_plant};
use super::loops::{ControllerArguments, NamedPlant, PlantArguments};
use super::refused;
use crate::files::Files;
use crate::output::Output;
use clap::Args;
use core::f64::consts::PI;
use fractional_control::analysis::{
    AT_REST, Cause, LoopAnalysis, LoopPoint, OtherGain, analyse, curve, poles,
};
use fractional_control::num_complex::Complex;
use fractional_control::{ControllerSetup, Crossing, Margins};
use haptic_experiment::Failure;
use haptic_experiment::control::{in_short, margins};
use haptic_experiment::question::analysis::decibel;
use haptic_quantity::{digits, written};
use serde_json::{Value, json};

/// Judge whether a loop is stable, why and by how much; or list the poles of a plant
///
/// Judges the loop as it runs, with the controller's weights, the hold and the dead time. The
/// verdict is a proof, with its reason; margins say how far a stable loop is from instability. The
/// exit code is 0 for an unstable loop too.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli control analyze --plant '1/(0.8s^2.2+0.5s^0.9+1)' --controller \
                  '20.5+3.7343s^1.15' --sample-time 1ms --out loop"
)]
pub(crate) struct Arguments {
    #[command(flatten)]
    plant: PlantArguments,
    #[command(flatten)]
    controller: ControllerArguments,
    #[command(flatten)]
    files: Files,
}

/// Columns of the table of a loop; the first three those of a plant.
const COLUMNS: [&str; 5] = [
    "omega_rad_s",
    "gain_db",
    "phase_deg",
    "sensitivity_db",
    "complementary_db",
];

fn open(point: &LoopPoint) -> (f64, f64, f64) {
    let gain_db = decibel(point.open.norm());
    (point.omega_rad_s, gain_db, point.phase_rad.to_degrees())
}

impl Arguments {
    pub(super) fn run(self, output: Output) -> Result<(), Failure> {
        let plant = self.plant.resolve()?;
        match self.controller.resolve()? {
            Some(file) => self.judge(&plant, &file, output),
            None => self.alone(&plant, output),
        }
    }

    fn judge(
        &self,
        plant: &NamedPlant,
        file: &ControllerSetup,
        output: Output,
    ) -> Result<(), Failure> {
        let mut outputs = self.files.look("loop", &[])?;
        let analysis: LoopAnalysis = analyse(file, &plant.plant).map_err(refused)?;
        let closed = |point: &LoopPoint| [point.sensitivity(), point.complementary()].map(decibel);
        let rows = analysis
            .curve
            .iter()
            .map(|point| (open(point), closed(point)));
        let picture = || draw_loop(&analysis, plant, file);
        let files = outputs.table_and_picture(&COLUMNS, rows, picture);
        let (judged, proved) = (&analysis.verdict, analysis.coarse.is_none());
        output.report(&json!({
            "plant": plant.words,
            "controller": file.law.to_string(),
            "sample_time_s": file.sample_time_s,
            "scheme": file.scheme.to_string(),
            // Null where nothing is proved.
            "stable": proved.then_some(judged.stable),
            "unstable_poles": judged.unstable_poles.filter(|_| proved),
            "distance": judged.distance,
            "reason": verdict(&analysis),
            // Factor by which the sample time must be shorter for the verdict to hold for the plant; null if it holds already.
            "coarse": analysis.coarse,
            // Null for an unstable loop, where margins have no meaning.
            "margins": (judged.stable && proved).then(|| margins(&analysis.margins)),
            "files": files,
        }))?;
        outputs.close(Ok(()))
    }

    fn alone(&self, plant: &NamedPlant, output: Output) -> Result<(), Failure> {
        if plant.is_measured() {
            return Err(Failure::bad_input(
                "a measured response has no poles: give a transfer function, or use control design",
            ));
        }
        let mut outputs = self.files.look("plant", &[])?;
        let found = poles(&plant.plant);
        let unstable = found.as_ref().and_then(|found| found.unstable_poles);
        let stable = plant.plant.stable_by_itself().is_ok();
        let all = found.as_ref().map_or(&[][..], |found| &found.poles);
        let middle = corner(all);
        let points = curve(1e-3 * middle, 1e3 * middle, |omega| {
            plant.plant.response(omega)
        });
        let (rows, picture) = (points.iter().map(open), || draw_plant(&points, plant));
        let files = outputs.table_and_picture(&COLUMNS[..3], rows, picture);
        output.report(&json!({
            "plant": plant.words,
            "stable": stable,
            "unstable_poles": unstable,
            "commensurate_order": found.as_ref().and_then(|found| found.commensurate_order),
            "reason": match (stable, unstable) {
                (true, _) => "Stable.",
                (false, None | Some(0)) => {
                    "On the boundary: a pole does not decay. Close the loop with --controller."
                }
                (false, Some(_)) => "Unstable. Close the loop with --controller.",
            },
            // Why no poles are listed.
            "poles_reason": match &found {
                None => Some("the orders have no common multiple that is large enough"),
                Some(found) if found.poles.is_empty() => {
                    Some("none on the principal branch: the plant only creeps")
                }
                Some(_) => None,
            },
            "poles": all.iter().map(pole).collect::<Vec<_>>(),
            "files": files,
        }))?;
        outputs.close(Ok(()))
    }
}

/// The place of interest of a plant: the middle of its poles, rad/s.
fn corner(poles: &[Complex<f64>]) -> f64 {
    let logs: Vec<f64> = poles
        .iter()
        .map(|pole| pole.norm().ln())
        .filter(|log| log.is_finite())
        .collect();
    if logs.is_empty() {
        return 1.0;
    }
    (logs.iter().sum::<f64>() / logs.len() as f64).exp()
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
    let end = match ways.is_empty() {
        true => "neither more gain nor more dead time makes it unstable".to_owned(),
        false => format!("unstable at {}", ways.join(", or at ")),
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
        Cause::Stable => stable(&analysis.margins),
        Cause::Boundary | Cause::Cancelled if at_rest(analysis) => {
            "On the boundary: a pole neither decays nor grows within 1e8 samples. \
             An integral may meet a factor s: omit one, or add a proportional part. \
             Else raise the gain or the sample time."
                .to_owned()
        }
        Cause::Boundary => {
            format!("On the boundary: {poles} at {omega} rad/s. Change the gain a little.")
        }
        Cause::Cancelled => format!(
            "On the boundary at any gain: {poles} at {omega} rad/s, where a zero cancels it: move it."
        ),
        Cause::TooLarge => {
            "Not decided: a number is beyond 1e-308 to 1e308. Give the loop in other units."
                .to_owned()
        }
        Cause::NearWhole(order) => format!(
            "Not decided: order {order} is too close to {}. Write the whole order.",
            order.round()
        ),
        Cause::GainTooHigh(OtherGain { edge, end, .. }) => unstable(format!(
            ": too much gain. At {} rad/s the loop inverts errors and makes them {} times as large. Stable {} times the gain.",
            at(&edge),
            digits(1.0 / edge.value, 4),
            where_stable("below", edge.value, end)
        )),
        Cause::GainTooLow(OtherGain { edge, end, .. }) => unstable(format!(
            ": too little gain to hold the plant (at {} rad/s). Stable {} times the gain.",
            at(&edge),
            where_stable("above", edge.value, end)
        )),
        Cause::WrongSign(gain) => unstable(format!(
            ": the sign is wrong. Change the sign of controller or plant{}.",
            match gain {
                1.0 => String::new(),
                gain => format!(", with {} times the gain", digits(gain, 4)),
            }
        )),
        Cause::DeadTime(delay) => unstable(format!(
            ": the dead time is too long. Stable up to {} (at {} rad/s).",
            written("delay_s", delay.value),
            at(&delay)
        )),
        Cause::Shape => {
            let near = analysis.margins.phase.as_ref();
            let near = near.map(|crossover| format!(" (more phase near {} rad/s)", at(crossover)));
            unstable(format!(
                ". Neither gain nor dead time alone makes it stable: change the controller{} or sample faster.",
                near.unwrap_or_default()
            ))
        }
    }
}
