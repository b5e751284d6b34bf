//! Designs: steps of both controllers over half to double the gain, and as they are run.

use super::{Points, command_axis, over_time, subtitle};
use crate::command::control::plant::NamedPlant;
use crate::command::control::words::decibel;
use fractional_control::design::{Candidate, ControlAnswer, Trial};
use haptic_figure::{AxisSpec, Chart, ChartPage, FigureError, Look, Picture, Scale, Series};

/// No panel is higher than this. A step of a loop that is not stable is drawn until it is.
const HIGHEST: f64 = 4.0;
/// A curve that turns more often in its panel is a block of ink.
const TURNS: usize = 60;
/// A turn is a change of direction by more than this share of the height.
const TURN: f64 = 0.03;

/// What is drawn of a controller.
struct Curves {
    /// A name and a step for each gain.
    gains: Vec<(String, Points)>,
    output: Points,
    command: Points,
    is_stable: bool,
}

/// The places at which a curve changes its direction, by more than a little of this height.
fn turns(points: &[(f64, f64)], height: f64) -> Vec<usize> {
    let least = TURN * height;
    let mut found = Vec::new();
    let (mut extreme, mut rises) = (points.first().map_or(0.0, |point| point.1), true);
    for (n, &(_, y)) in points.iter().enumerate() {
        let beyond = if rises { y - extreme } else { extreme - y };
        if beyond > 0.0 {
            extreme = y;
        } else if beyond < -least {
            found.push(n);
            (extreme, rises) = (y, !rises);
        }
    }
    found
}

/// The height of what is seen of a curve: its ends, without the kick of the first samples.
fn height(points: &[(f64, f64)]) -> f64 {
    let (low, high) = points
        .iter()
        .skip(5)
        .fold((0.0, 0.0), |(low, high), point| {
            (f64::min(low, point.1), f64::max(high, point.1))
        });
    high - low
}

impl Curves {
    fn new(trial: &Trial, samples: usize, t: f64) -> Self {
        let seen = |values: &[f64]| over_time(&values[..samples.min(values.len())], t);
        let gains = trial.robustness.iter().map(|row| {
            let name = format!("gain {:+.0} dB", decibel(row.gain));
            let y = &row.response.measured;
            let grown = y.iter().position(|y| !row.stable && y.abs() > HIGHEST);
            (name, seen(&y[..grown.map_or(y.len(), |end| end + 1)]))
        });
        Self {
            gains: gains.collect(),
            output: seen(&trial.step.measured),
            command: seen(&trial.step.command),
            is_stable: trial.verdict.stable,
        }
    }

    /// The output and the command as it is run, unless they grow or turn too often.
    fn as_it_is_run(&self) -> [Option<&Points>; 2] {
        [&self.output, &self.command].map(|points| {
            let is_drawn = self.is_stable && turns(points, height(points)).len() <= TURNS;
            is_drawn.then_some(points)
        })
    }

    /// A step that turns too often to be drawn.
    fn is_ink(points: &Points) -> bool {
        turns(points, height(points).min(HIGHEST)).len() > TURNS
    }

    fn series(&self) -> Vec<Series<'_>> {
        let rows = self.gains.iter().zip([3, 2, 0, 4, 1]);
        rows.filter(|((_, points), _)| !Self::is_ink(points))
            .map(|((name, points), colour)| Series::new(name, points, Look::Line, colour))
            .collect()
    }

    /// The steps that are not drawn.
    fn left_out(&self, of: &str) -> Option<String> {
        let ink = self.gains.iter().filter(|(_, points)| Self::is_ink(points));
        let mut names: Vec<&str> = ink.map(|(name, _)| name.as_str()).collect();
        if self.as_it_is_run().contains(&None) {
            names.push("its own gain in (c) or (d)");
        }
        (!names.is_empty()).then(|| {
            let names = names.join(", ");
            format!("left out: {of} at {names}, which grows or swings too often to be drawn")
        })
    }

    fn highest(&self) -> f64 {
        let drawn = self
            .gains
            .iter()
            .filter(|(_, points)| !Self::is_ink(points));
        let points = drawn.flat_map(|(_, points)| points);
        points.map(|point| point.1).fold(1.0, f64::max)
    }
}

/// Samples until nothing moves any more that is stable, and half as many again; and no more than the first loop as it is run takes for the
/// turns that can be drawn.
fn length(trials: &[&Trial]) -> usize {
    let settled = trials.iter().flat_map(|trial| {
        let stable = trial.robustness.iter().filter(|row| row.stable);
        let run = trial.verdict.stable.then_some(trial.shape);
        let shapes = stable.map(|row| row.shape).chain(run);
        shapes.map(|shape| shape.settled)
    });
    let Some(first) = trials.first() else {
        return 2;
    };
    let samples = first.step.measured.len();
    let longest = settled.map(|settled| settled.unwrap_or(samples)).max();
    let mut length = longest.map_or(samples, |longest| samples.min(3 * longest / 2));
    for signal in [&first.step.measured, &first.step.command] {
        let points = over_time(&signal[..length.min(signal.len())], 1.0);
        // What grows is as high as what is seen of it.
        let ends = turns(&points, height(&points));
        length = ends.get(TURNS).map_or(length, |end| length.min(*end));
    }
    length.max(2)
}

/// Steps of both controllers over ± 6 dB of gain, and the nominal ones with their commands; `None` for a plant that does not run.
///
/// # Errors
/// If there is nothing to draw.
pub(in crate::command::control) fn draw_design(
    answer: &ControlAnswer,
    plant: &NamedPlant,
) -> Result<Option<Picture>, FigureError> {
    let file = &answer.fractional.setup;
    let t = file.sample_time_s;
    let integer = answer.integer.as_ref().ok();
    let candidates = [Some(&answer.fractional), integer];
    let trials = candidates.map(|own| own.and_then(|own| own.trial.as_ref()));
    let [Some(trial), other] = trials else {
        return Ok(None);
    };
    let trials: Vec<&Trial> = trials.into_iter().flatten().collect();
    let samples = length(&trials);
    let (own, other) = (
        Curves::new(trial, samples, t),
        other.map(|other| Curves::new(other, samples, t)),
    );
    let time = AxisSpec::new("time / s", Scale::Linear).between(0.0, samples as f64 * t);
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
        let [output, command] = other.as_it_is_run();
        outputs.extend(output.map(|points| Series::new(name, points, Look::Dashed, 1)));
        commands.extend(command.map(|points| Series::new(name, points, Look::Dashed, 1)));
    }
    let beside = other.as_ref().and_then(|other| other.as_it_is_run()[1]);
    let command = command_axis(&own.command, beside);
    let mut about = vec![subtitle(plant, file)];
    about.extend(own.left_out("PI^λD^μ").filter(|_| own.is_stable));
    about.extend(
        other
            .as_ref()
            .and_then(|other| other.left_out("PID of order 1")),
    );
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
        subtitle: &about.join("\n"),
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

#[cfg(test)]
mod tests {
    use super::*;

    /// cos ωt turns ωt/π times; a ripple below a thirtieth of the height is none.
    #[test]
    fn turns_are_counted_as_they_are_seen() {
        let of = |ripple: f64| -> Points {
            let t = (0..=10_000).map(|n| f64::from(n) * 1e-3);
            t.map(|t| {
                (
                    t,
                    (20.5 * std::f64::consts::PI * t).cos() + ripple * (900.0 * t).cos(),
                )
            })
            .collect()
        };
        // The first turn, from the beginning downwards, is at the second sample.
        assert_eq!(turns(&of(0.0), 2.0).len(), 205);
        assert_eq!(turns(&of(0.01), 2.0).len(), 205);
        assert!(turns(&of(0.2), 2.0).len() > 1000);
        assert!(Curves::is_ink(&of(0.0)));
        let calm: Points = (0..1000)
            .map(|n| (f64::from(n), -(-0.01 * f64::from(n)).exp_m1()))
            .collect();
        assert!(turns(&calm, 1.0).is_empty() && !Curves::is_ink(&calm));
    }

    #[test]
    fn a_loop_that_grows_as_it_is_run_is_left_out_by_name() {
        let step: Points = vec![(0.0, 0.0), (1.0, 1.0)];
        let curves = |is_stable| Curves {
            gains: vec![("gain +0 dB".to_owned(), step.clone())],
            output: step.clone(),
            command: step.clone(),
            is_stable,
        };
        assert_eq!(curves(true).left_out("it"), None);
        let words = curves(false).left_out("it").expect("it grows");
        assert!(
            words.contains("it at its own gain in (c) or (d)"),
            "{words}"
        );
    }
}
