//! `control analyze`: the verdict on a loop, its root and its margins; or the poles of a plant.

use super::controller::ControllerArguments;
use super::draw::{draw_loop, draw_plant};
use super::plant::{NamedPlant, PlantArguments};
use super::print::{MarginReport, written};
use super::words::{decibel, digits, law, refused, verdict};
use crate::command::analyze::Files;
use crate::output::Output;
use clap::Args;
use fractional_control::ControllerSetup;
use fractional_control::analysis::{LoopAnalysis, LoopPoint, analyse, curve, poles};
use fractional_control::num_complex::Complex;
use haptic_experiment::failure::Failure;
use serde::Serialize;

pub(super) const LONG_ABOUT: &str = "\
Judges the loop that is really run: the controller's weights, the hold, the dead time. The verdict, stable or not, is a proof, and a \
sentence says why it is so; of a stable loop the margins say how far it is from changing. Without a controller: the poles of the plant, and whether \
they decay. An answer is an answer, also that a loop is unstable: the exit code is 0, `stable` in the JSON has it.

JSON: plant, controller, sample_time_s, scheme, stable (null where coarse is a number: nothing is proved), unstable_poles (null on the boundary, and \
there), distance, reason, coarse (how many times as short, at least, the sample time has to be for the verdict to hold for the plant; null where \
it does), margins{crossover_rad_s, \
crossovers, phase_margin_deg, gain_up, gain_up_rad_s, gain_down, gain_down_rad_s, delay_margin_s, sensitivity_peak, \
sensitivity_peak_rad_s, complementary_peak, complementary_peak_rad_s} (null unless stable), files; of a plant alone: plant, stable, unstable_poles, \
commensurate_order, poles[{re, im}], files.";

/// Arguments of `control analyze`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  host-cli control analyze --plant '1/(0.8s^2.2+0.5s^0.9+1)' --controller '20.5+3.7343s^1.15' --sample-time 1ms \
                  --out loop\n  host-cli control analyze --plant plant.toml --controller design/controller.toml\n  \
                  host-cli control analyze --plant '1/(0.8s^2.2+0.5s^0.9+1)'"
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
    poles: Vec<Pole>,
    files: Vec<String>,
}

#[derive(Clone, Copy, Serialize)]
struct Pole {
    re: f64,
    im: f64,
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
        output.print(&report, |out| {
            writeln!(out, "plant       {}", report.plant)?;
            writeln!(
                out,
                "controller  {}, T = {} s, {}",
                law(file),
                report.sample_time_s,
                report.scheme
            )?;
            writeln!(out, "{}", report.reason)?;
            if let Some(margins) = &report.margins {
                margins.print(out)?;
            }
            written(out, &report.files)
        })?;
        place.close(Ok(()))
    }

    fn alone(&self, plant: &NamedPlant, output: Output) -> Result<(), Failure> {
        if plant.is_measured() {
            return Err(Failure::bad_input(
                "a measured response has no poles: give --controller in a design (host-cli control design), or a transfer function",
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
            poles: all
                .unwrap_or_default()
                .iter()
                .map(|pole| Pole {
                    re: pole.re,
                    // A real pole, but for rounding.
                    im: if pole.im.abs() < 1e-12 * pole.norm() {
                        0.0
                    } else {
                        pole.im
                    },
                })
                .collect(),
            files,
        };
        output.print(&report, |out| report.print(out))?;
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

impl PlantReport {
    fn print(&self, out: &mut dyn std::io::Write) -> std::io::Result<()> {
        writeln!(out, "plant  {}", self.plant)?;
        match (self.stable, self.unstable_poles) {
            (true, _) => writeln!(out, "Stable: all that is in it decays.")?,
            (false, None) | (false, Some(0)) => writeln!(
                out,
                "On the boundary: a pole at s = 0 or on the imaginary axis does not decay. Close the loop with --controller."
            )?,
            (false, Some(1)) => writeln!(
                out,
                "Unstable: one pole grows. Close the loop with --controller."
            )?,
            (false, Some(poles)) => writeln!(
                out,
                "Unstable: {poles} poles grow. Close the loop with --controller."
            )?,
        }
        match self.commensurate_order {
            Some(order) if self.poles.is_empty() => writeln!(
                out,
                "No pole on the principal branch (orders are multiples of {}): it only creeps.",
                digits(order)
            )?,
            Some(order) => {
                writeln!(out, "poles (orders are multiples of {}):", digits(order))?;
                for pole in &self.poles {
                    let size = pole.re.hypot(pole.im);
                    write!(
                        out,
                        "  s = {:>12} {} {}j",
                        digits(pole.re + 0.0),
                        if pole.im < 0.0 { "-" } else { "+" },
                        digits(pole.im.abs()),
                    )?;
                    if size > 0.0 {
                        let damping = digits(0.0 - pole.re / size);
                        writeln!(out, "   {} rad/s, damping {damping}", digits(size))?;
                    } else {
                        writeln!(out, "   at rest: it adds up")?;
                    }
                }
            }
            None => writeln!(
                out,
                "Its poles are not listed: the orders are multiples of no common order that is large enough."
            )?,
        }
        written(out, &self.files)
    }
}
