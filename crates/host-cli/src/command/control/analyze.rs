//! `control analyze`: the verdict on a loop, its root and its margins; or the poles of a plant.

use super::controller::ControllerArguments;
use super::draw::{draw_loop, draw_plant};
use super::plant::{NamedPlant, PlantArguments};
use super::reports::MarginReport;
use super::words::{decibel, refused, verdict};
use crate::command::analyze::Files;
use crate::output::Output;
use clap::Args;
use fractional_control::ControllerSetup;
use fractional_control::analysis::{LoopAnalysis, LoopPoint, analyse, curve, poles};
use fractional_control::num_complex::Complex;
use haptic_experiment::Failure;
use serde::Serialize;

pub(super) const LONG_ABOUT: &str = "\
Judges the loop as it runs: the controller's weights, the hold, the dead time. The verdict is a proof, with its reason; margins say how \
far a stable loop is from instability. Without a controller: the poles of the plant. The exit code is 0 for an unstable loop too.";

/// Arguments of `control analyze`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli control analyze --plant '1/(0.8s^2.2+0.5s^0.9+1)' --controller '20.5+3.7343s^1.15' --sample-time 1ms \
                  --out loop"
)]
pub struct Arguments {
    #[command(flatten)]
    plant: PlantArguments,
    #[command(flatten)]
    controller: ControllerArguments,
    #[command(flatten)]
    files: Files,
}

/// Result for a loop.
#[derive(Serialize)]
struct LoopReport {
    plant: String,
    controller: String,
    sample_time_s: f64,
    scheme: String,
    /// Null where nothing is proved.
    stable: Option<bool>,
    unstable_poles: Option<usize>,
    distance: f64,
    reason: String,
    /// How many times as short the sample time has to be for the verdict to hold for the plant; null where it does.
    coarse: Option<f64>,
    /// None of an unstable loop: they would mean nothing.
    margins: Option<MarginReport>,
    files: Vec<String>,
}

/// Result for a plant alone.
#[derive(Serialize)]
struct PlantReport {
    plant: String,
    stable: bool,
    unstable_poles: Option<usize>,
    commensurate_order: Option<f64>,
    /// The verdict in words.
    reason: &'static str,
    /// Why no poles are listed.
    poles_reason: Option<&'static str>,
    poles: Vec<Pole>,
    files: Vec<String>,
}

#[derive(Clone, Copy, Serialize)]
struct Pole {
    re: f64,
    im: f64,
    re_unit: &'static str,
    im_unit: &'static str,
    omega_rad_s: f64,
    /// Null at s = 0.
    damping_ratio: Option<f64>,
}

/// A row of the table of a loop.
#[derive(Serialize)]
struct LoopRow {
    omega_rad_s: f64,
    gain_db: f64,
    phase_deg: f64,
    sensitivity_db: f64,
    complementary_db: f64,
}

/// A row of the table of a plant.
#[derive(Serialize)]
struct PlantRow {
    omega_rad_s: f64,
    gain_db: f64,
    phase_deg: f64,
}

impl From<&LoopPoint> for LoopRow {
    fn from(point: &LoopPoint) -> Self {
        Self {
            omega_rad_s: point.omega_rad_s,
            gain_db: decibel(point.open.norm()),
            phase_deg: point.phase_rad.to_degrees(),
            sensitivity_db: decibel(point.sensitivity()),
            complementary_db: decibel(point.complementary()),
        }
    }
}

impl From<&LoopPoint> for PlantRow {
    fn from(point: &LoopPoint) -> Self {
        Self {
            omega_rad_s: point.omega_rad_s,
            gain_db: decibel(point.open.norm()),
            phase_deg: point.phase_rad.to_degrees(),
        }
    }
}

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A plant or controller that is wrong, files that cannot be written.
    pub fn run(self, output: Output) -> Result<(), Failure> {
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
        let mut place = self.files.look("loop")?;
        let analysis: LoopAnalysis = analyse(file, &plant.plant).map_err(refused)?;
        let rows = analysis.curve.iter().map(LoopRow::from);
        let words = file.law.to_string();
        let files = place.table_and_picture(rows, || draw_loop(&analysis, plant, file));
        let report = LoopReport {
            plant: plant.words.clone(),
            controller: words,
            sample_time_s: file.sample_time_s,
            scheme: file.scheme.to_string(),
            stable: analysis.coarse.is_none().then_some(analysis.verdict.stable),
            unstable_poles: (analysis.coarse.is_none())
                .then_some(analysis.verdict.unstable_poles)
                .flatten(),
            distance: analysis.verdict.distance,
            reason: verdict(&analysis),
            coarse: analysis.coarse,
            margins: (analysis.verdict.stable && analysis.coarse.is_none())
                .then(|| (&analysis.margins).into()),
            files,
        };
        output.report(&report)?;
        place.close(Ok(()))
    }

    fn alone(&self, plant: &NamedPlant, output: Output) -> Result<(), Failure> {
        if plant.is_measured() {
            return Err(Failure::bad_input(
                "a measured response has no poles: give a transfer function, or tune to it with host-cli control design",
            ));
        }
        let mut place = self.files.look("plant")?;
        let found = poles(&plant.plant);
        let unstable = found.as_ref().and_then(|found| found.unstable_poles);
        let stable = plant.plant.stable_by_itself().is_ok();
        let all = found.as_ref().map(|found| &found.poles[..]);
        let middle = corner(all.unwrap_or_default());
        let points = curve(1e-3 * middle, 1e3 * middle, |omega| {
            plant.plant.response(omega)
        });
        let rows = points.iter().map(PlantRow::from);
        let files = place.table_and_picture(rows, || draw_plant(&points, plant));
        let report = PlantReport {
            plant: plant.words.clone(),
            stable,
            unstable_poles: unstable,
            commensurate_order: found.as_ref().and_then(|found| found.commensurate_order),
            reason: in_words(stable, unstable),
            poles_reason: match &found {
                None => Some("the orders have no common multiple that is large enough"),
                Some(found) if found.poles.is_empty() => {
                    Some("none on the principal branch: the plant only creeps")
                }
                Some(_) => None,
            },
            poles: all.unwrap_or_default().iter().map(pole).collect(),
            files,
        };
        output.report(&report)?;
        place.close(Ok(()))
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

fn pole(pole: &Complex<f64>) -> Pole {
    let size = pole.norm();
    Pole {
        re: pole.re,
        // A real pole, but for rounding.
        im: if pole.im.abs() < 1e-12 * size {
            0.0
        } else {
            pole.im
        },
        re_unit: "rad/s",
        im_unit: "rad/s",
        omega_rad_s: size,
        damping_ratio: (size > 0.0).then_some(0.0 - pole.re / size),
    }
}

/// What becomes of a plant by itself.
const fn in_words(stable: bool, unstable_poles: Option<usize>) -> &'static str {
    match (stable, unstable_poles) {
        (true, _) => "Stable.",
        (false, None | Some(0)) => {
            "On the boundary: a pole at s = 0 or on the imaginary axis does not decay. Close the loop with --controller."
        }
        (false, Some(_)) => "Unstable. Close the loop with --controller.",
    }
}
