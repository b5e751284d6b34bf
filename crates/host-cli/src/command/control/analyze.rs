//! `control analyze`: the verdict on a loop, its root and its margins; or the poles of a plant.

use super::draw::{draw_loop, draw_plant};
use super::loops::{asked, print};
use crate::files::Files;
use crate::options::{Options, keys};
use crate::output::Output;
use clap::Args;
use fractional_control::analysis::LoopPoint;
use haptic_experiment::Failure;
use haptic_question::analysis::decibel;
use haptic_question::control_loop::analysis::AnalysisCurve;

/// Judge whether a loop is stable, why and by how much; or list the poles of a plant
///
/// Judges the loop as it runs, with the controller's weights, the hold and the dead time. The
/// verdict is a proof, with its reason; margins say how far a stable loop is from instability. The
/// exit code is 0 for an unstable loop too.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli control analyze --plant \"1/(0.8s^2.2+0.5s^0.9+1)\" --controller \
                  20.5+3.7343s^1.15 --sample-time 1ms --out loop"
)]
pub(crate) struct Arguments {
    #[command(flatten)]
    asked: Options<keys::ControlAnalyze>,
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
        let asked = asked(self.asked)?;
        let stem = asked.controller.as_ref().map_or("plant", |_| "loop");
        let mut outputs = self.files.look(stem, &[])?;
        let found = asked.analysed()?;
        let files = match &found.curve {
            AnalysisCurve::Loop(analysis) => {
                let closed = |at: &LoopPoint| [at.sensitivity(), at.complementary()].map(decibel);
                let points = analysis.curve.iter();
                let rows = points.map(|point| (open(point), closed(point)));
                outputs.table_and_picture(&COLUMNS, rows, || draw_loop(analysis, &asked))
            }
            AnalysisCurve::Plant(points) => {
                let picture = || draw_plant(points, &asked.plant);
                outputs.table_and_picture(&COLUMNS[..3], points.iter().map(open), picture)
            }
        };
        print(found.report, &files, output)?;
        outputs.close(Ok(()))
    }
}
