//! Designs: steps of both controllers over half to double the gain, and as they are run.

use super::{Points, command_axis, over_time, subtitle};
use crate::command::control::plant::NamedPlant;
use crate::command::control::words::decibel;
use haptic_experiment::control::design::{Candidate, ControlAnswer, Trial};
use haptic_figure::{AxisSpec, Chart, ChartPage, FigureError, Look, Picture, Scale, Series};

/// Steps higher than this are of loops that are not stable, and would grow out of any picture.
const HIGHEST: f64 = 4.0;

/// What is drawn of a controller.
struct Curves {
    /// A name and a step for each gain.
    gains: Vec<(String, Points)>,
    output: Points,
    command: Points,
}

impl Curves {
    fn new(trial: &Trial, t: f64) -> Self {
        let gains = trial.robustness.iter().map(|row| {
            let name = format!("gain {:+.0} dB", decibel(row.gain));
            (name, over_time(&row.response.measured, t))
        });
        Self {
            gains: gains.collect(),
            output: over_time(&trial.step.measured, t),
            command: over_time(&trial.step.command, t),
        }
    }

    fn series(&self) -> Vec<Series<'_>> {
        let rows = self.gains.iter().zip([3, 2, 0, 4, 1]);
        rows.map(|((name, points), colour)| Series::new(name, points, Look::Line, colour))
            .collect()
    }

    fn highest(&self) -> f64 {
        let points = self.gains.iter().flat_map(|(_, points)| points);
        points.map(|point| point.1).fold(1.0, f64::max)
    }
}

/// Samples until nothing moves any more, and half as many again.
fn length(trials: &[&Trial]) -> usize {
    let settled = trials.iter().flat_map(|trial| {
        let shapes = trial.robustness.iter().map(|row| row.shape);
        shapes.chain([trial.shape]).map(|shape| shape.settled)
    });
    let samples = trials.first().map_or(0, |trial| trial.step.measured.len());
    let longest = settled.map(|settled| settled.unwrap_or(samples)).max();
    longest
        .map_or(samples, |longest| samples.min(3 * longest / 2))
        .max(2)
}

/// Steps of both controllers over ± 6 dB of gain, and the nominal ones with their commands; `None` for a plant that does not run.
///
/// # Errors
/// If there is nothing to draw.
pub(in crate::command::control) fn draw_design(
    answer: &ControlAnswer,
    plant: &NamedPlant,
) -> Result<Option<Picture>, FigureError> {
    let file = &answer.fractional.file;
    let t = file.sample_time_s;
    let integer = answer.integer.as_ref().ok();
    let candidates = [Some(&answer.fractional), integer];
    let trials = candidates.map(|own| own.and_then(|own| own.trial.as_ref()));
    let [Some(trial), other] = trials else {
        return Ok(None);
    };
    let (own, other) = (
        Curves::new(trial, t),
        other.map(|other| Curves::new(other, t)),
    );
    let trials: Vec<&Trial> = trials.into_iter().flatten().collect();
    let time = AxisSpec::new("time / s", Scale::Linear).between(0.0, length(&trials) as f64 * t);
    let highest = other
        .as_ref()
        .map_or(1.0, Curves::highest)
        .max(own.highest());
    let output = AxisSpec::new("output", Scale::Linear);
    let steps = output.between(0.0, 1.1 * highest.min(HIGHEST));
    let mut outputs = vec![Series::new("PI^λD^μ", &own.output, Look::Line, 0)];
    let mut commands = vec![Series::new("PI^λD^μ", &own.command, Look::Line, 0)];
    if let Some(other) = &other {
        let name = "PID of order 1";
        outputs.push(Series::new(name, &other.output, Look::Dashed, 1));
        commands.push(Series::new(name, &other.command, Look::Dashed, 1));
    }
    let command = command_axis(&own.command, other.as_ref().map(|other| &other.command));
    let others = other.as_ref().map(Curves::series).unwrap_or_default();
    let charts = [
        ("PI^λD^μ, half to double the gain", steps, own.series()),
        ("PID of order 1, half to double the gain", steps, others),
        ("as it is run, with its limits", output, outputs),
        ("command", command, commands),
    ];
    let charts = charts.into_iter().map(|(caption, y, series)| Chart {
        caption,
        x: time,
        y,
        series,
    });
    ChartPage {
        title: "A fractional PID, and the best PID of order 1",
        subtitle: &subtitle(plant, file),
        columns: 2,
        charts: charts.collect(),
    }
    .draw()
    .map(Some)
}

/// Columns of the table of a design.
pub(in crate::command::control) fn design_columns(
    candidate: &Candidate,
    prefix: &str,
) -> Vec<(String, Vec<f64>)> {
    let Some(trial) = &candidate.trial else {
        return Vec::new();
    };
    let mut columns = vec![
        (format!("{prefix}output"), trial.step.measured.clone()),
        (format!("{prefix}command"), trial.step.command.clone()),
    ];
    columns.extend(trial.robustness.iter().map(|row| {
        let name = format!("{prefix}output_gain_{:+.0}db", decibel(row.gain));
        (name, row.response.measured.clone())
    }));
    columns
}
