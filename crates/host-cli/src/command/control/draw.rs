//! Pictures of loops: frequency responses and steps.

use super::analyze::decibel;
use super::plant::NamedPlant;
use super::words::{digits, law};
use fractional_control::Response;
use haptic_experiment::control::analysis::{LoopAnalysis, LoopPoint};
use haptic_experiment::control::design::{Candidate, ControlAnswer};
use haptic_experiment::controller_file::ControllerFile;
use haptic_figure::{AxisSpec, Chart, ChartPage, FigureError, Look, Picture, Scale, Series};

type Points = Vec<(f64, f64)>;

const OMEGA: &str = "ω / rad·s⁻¹";

fn over_omega(points: &[LoopPoint], value: impl Fn(&LoopPoint) -> f64) -> Points {
    points
        .iter()
        .map(|point| (point.omega_rad_s, value(point)))
        .collect()
}

/// The ends of a row of points at this height.
fn level(points: &[LoopPoint], height: f64) -> Points {
    let ends = [points.first(), points.last()].into_iter().flatten();
    ends.map(|point| (point.omega_rad_s, height)).collect()
}

/// Plant, controller and sample time in a line each.
fn subtitle(plant: &NamedPlant, file: &ControllerFile) -> String {
    format!(
        "plant {}\ncontroller {} · T = {} s · {}",
        plant.words,
        law(file),
        digits(file.sample_time_s),
        file.scheme
    )
}

/// Bode with margins, sensitivities, and Nyquist's curve near −1.
pub(super) fn draw_loop(
    analysis: &LoopAnalysis,
    plant: &NamedPlant,
    file: &ControllerFile,
) -> Result<Picture, FigureError> {
    let curve = &analysis.curve;
    let gain = over_omega(curve, |point| decibel(point.open.norm()));
    let phase = over_omega(curve, |point| point.phase_rad.to_degrees());
    let sensitivity = over_omega(curve, |point| decibel(point.sensitivity()));
    let complementary = over_omega(curve, |point| decibel(point.complementary()));
    let peaks: Points = [&sensitivity[..], &complementary[..]].concat();
    let zero = level(curve, 0.0);
    // The half turn that is nearest below the crossover, of which the phase keeps its margin.
    let crossover = analysis.margins.phase;
    let at_crossover = crossover.and_then(|crossing| {
        let after = curve
            .iter()
            .find(|point| point.omega_rad_s >= crossing.omega_rad_s)?;
        let half_turn = ((after.phase_rad - crossing.value).to_degrees() / 360.0 - 0.5).round();
        let below = 360.0 * half_turn + 180.0;
        Some((crossing, below, below + crossing.value.to_degrees()))
    });
    let half_turn = level(curve, at_crossover.map_or(-180.0, |(_, below, _)| below));
    let margin: Points = at_crossover
        .map(|(crossing, below, there)| {
            vec![(crossing.omega_rad_s, below), (crossing.omega_rad_s, there)]
        })
        .unwrap_or_default();
    let crossing: Points = crossover
        .map(|crossing| vec![(crossing.omega_rad_s, 0.0)])
        .unwrap_or_default();
    let up: Points = [analysis.margins.gain_up, analysis.margins.gain_down]
        .into_iter()
        .flatten()
        .flat_map(|gain| {
            let place = gain.omega_rad_s;
            [
                (place, 0.0),
                (place, -decibel(gain.value)),
                (f64::NAN, f64::NAN),
            ]
        })
        .collect();
    let nyquist: Points = curve.iter().map(|p| (p.open.re, p.open.im)).collect();
    let circle: Points = (0..=180)
        .map(|k| (2.0 * f64::from(k)).to_radians().sin_cos())
        .map(|(sin, cos)| (cos, sin))
        .collect();
    let omega = AxisSpec::new(OMEGA, Scale::Log);
    // At half the sample rate the hold has a zero, which would be all of the picture.
    let decibels = |label, points: &Points, floor: f64| {
        let highest = points.iter().map(|point| point.1).fold(0.0, f64::max);
        AxisSpec::new(label, Scale::Linear).between(floor, 10.0 * (0.1 * highest).ceil() + 10.0)
    };
    let middle = at_crossover.map_or(-180.0, |(_, below, _)| below);
    let linear = |label| AxisSpec::new(label, Scale::Linear);
    let verdict = match (analysis.verdict.stable, analysis.verdict.unstable_poles) {
        (true, _) => "stable, proved",
        (false, Some(_)) => "unstable, proved",
        (false, None) => "on the boundary",
    };
    let phase_margin = crossover.map_or_else(
        || "phase margin".to_owned(),
        |crossing| format!("phase margin {:.1}°", crossing.value.to_degrees()),
    );
    ChartPage {
        title: &format!("A sampled loop: {verdict}"),
        subtitle: &subtitle(plant, file),
        columns: 2,
        charts: vec![
            Chart {
                caption: "gain of the open loop",
                x: omega,
                y: decibels("|L| / dB", &gain, -60.0),
                series: vec![
                    Series::new("open loop L", &gain, Look::Line, 0),
                    Series::new("", &zero, Look::Dotted, 5),
                    Series::new("gain margin", &up, Look::Broad, 2),
                    Series::new("crossover", &crossing, Look::Markers, 1),
                ],
            },
            Chart {
                caption: "its phase",
                x: omega,
                y: linear("phase / °").between(middle - 180.0, middle + 180.0),
                series: vec![
                    Series::new("open loop L", &phase, Look::Line, 0),
                    Series::new("", &half_turn, Look::Dotted, 5),
                    Series::new(&phase_margin, &margin, Look::Broad, 1),
                ],
            },
            Chart {
                caption: "closed loop",
                x: omega,
                y: decibels("gain / dB", &peaks, -40.0),
                series: vec![
                    Series::new("|S|, errors and disturbances", &sensitivity, Look::Line, 1),
                    Series::new("|T|, reference and noise", &complementary, Look::Line, 2),
                    Series::new("", &zero, Look::Dotted, 5),
                ],
            },
            Chart {
                caption: "L near −1 (the mark)",
                x: linear("Re L").between(-3.0, 2.0),
                y: linear("Im L").between(-2.0, 2.0),
                series: vec![
                    Series::new("open loop L", &nyquist, Look::Line, 0),
                    Series::new("|L| = 1", &circle, Look::Dotted, 5),
                    Series::new("", &[(-1.0, 0.0)], Look::Markers, 1),
                ],
            },
        ],
    }
    .draw()
}

/// Bode of a plant alone.
pub(super) fn draw_plant(points: &[LoopPoint], plant: &NamedPlant) -> Result<Picture, FigureError> {
    let gain = over_omega(points, |point| decibel(point.open.norm()));
    let phase = over_omega(points, |point| point.phase_rad.to_degrees());
    let chart = |caption, label, points| Chart {
        caption,
        x: AxisSpec::new(OMEGA, Scale::Log),
        y: AxisSpec::new(label, Scale::Linear),
        series: vec![Series::new("", points, Look::Line, 0)],
    };
    ChartPage {
        title: "A plant alone",
        subtitle: &format!("plant {}", plant.words),
        columns: 2,
        charts: vec![
            chart("gain", "|G| / dB", &gain),
            chart("phase", "phase / °", &phase),
        ],
    }
    .draw()
}

/// Samples over time.
pub(super) fn over_time(values: &[f64], sample_time_s: f64) -> Points {
    let points = values.iter().enumerate();
    points
        .map(|(n, y)| (n as f64 * sample_time_s, *y))
        .collect()
}

/// A run: output over reference, command below; beside a PID of order 1 where there is one.
pub(super) fn draw_run(
    run: &Response,
    integer: Option<&Response>,
    title: &str,
    subtitle: &str,
    sample_time_s: f64,
) -> Result<Picture, FigureError> {
    let of = |values: &[f64]| over_time(values, sample_time_s);
    let (reference, output, command) = (of(&run.reference), of(&run.measured), of(&run.command));
    let beside = integer.map(|other| (of(&other.measured), of(&other.command)));
    let mut outputs = vec![
        Series::new("reference", &reference, Look::Dotted, 5),
        Series::new("this controller", &output, Look::Line, 0),
    ];
    let mut commands = vec![Series::new("this controller", &command, Look::Line, 0)];
    if let Some((output, command)) = &beside {
        let name = "PID of order 1, same crossover and margin";
        outputs.push(Series::new(name, output, Look::Line, 1));
        commands.push(Series::new(name, command, Look::Line, 1));
    }
    let chart = |caption, y, series| Chart {
        caption,
        x: AxisSpec::new("time / s", Scale::Linear),
        y,
        series,
    };
    ChartPage {
        title,
        subtitle,
        columns: 1,
        charts: vec![
            chart("output", AxisSpec::new("output", Scale::Linear), outputs),
            chart(
                "command",
                command_axis(&command, beside.as_ref().map(|own| &own.1)),
                commands,
            ),
        ],
    }
    .draw()
}

/// The lines of a run's picture.
pub(super) fn run_subtitle(plant: &NamedPlant, file: Option<&ControllerFile>) -> String {
    match file {
        Some(file) => subtitle(plant, file),
        None => format!("plant {}", plant.words),
    }
}

/// Steps of both controllers over ± 6 dB of gain, and the nominal ones with their commands.
pub(super) fn draw_design(
    answer: &ControlAnswer,
    plant: &NamedPlant,
) -> Result<Option<Picture>, FigureError> {
    let Some(trial) = &answer.fractional.trial else {
        return Ok(None);
    };
    let file = &answer.fractional.file;
    let t = file.sample_time_s;
    let integer = answer.integer.as_ref().ok();
    let integer = integer.and_then(|integer| integer.trial.as_ref());
    let steps = |trial: &haptic_experiment::control::design::Trial| -> Vec<(String, Points)> {
        let rows = trial.robustness.iter();
        rows.map(|row| {
            let name = format!("gain {:+.0} dB", decibel(row.gain));
            (name, over_time(&row.response.measured, t))
        })
        .collect()
    };
    let (fractional_steps, integer_steps) = (steps(trial), integer.map(steps).unwrap_or_default());
    // Without limits an unstable loop grows out of any picture.
    let highest = fractional_steps
        .iter()
        .flat_map(|(_, points)| points.iter().map(|point| point.1))
        .fold(1.0, f64::max);
    let top = 1.1
        * highest
            .max(integer.map_or(1.0, |own| 1.0 + own.shape.overshoot))
            .min(4.0);
    let (output, command) = (
        over_time(&trial.step.measured, t),
        over_time(&trial.step.command, t),
    );
    let beside = integer.map(|own| {
        (
            over_time(&own.step.measured, t),
            over_time(&own.step.command, t),
        )
    });
    // As long as anything moves.
    let settled = [Some(trial), integer]
        .into_iter()
        .flatten()
        .flat_map(|trial| {
            let shapes = trial.robustness.iter().map(|row| row.shape);
            shapes.chain([trial.shape]).map(|shape| shape.settled)
        });
    let samples = trial.step.measured.len();
    let longest = settled.map(|settled| settled.unwrap_or(samples)).max();
    let end = longest.map_or(samples, |longest| samples.min(3 * longest / 2));
    let time = AxisSpec::new("time / s", Scale::Linear).between(0.0, end.max(2) as f64 * t);
    let y = AxisSpec::new("output", Scale::Linear).between(0.0, top);
    fn series(steps: &[(String, Points)]) -> Vec<Series<'_>> {
        let colours = [3, 2, 0, 4, 1];
        let rows = steps.iter().zip(colours);
        rows.map(|((name, points), colour)| Series::new(name, points, Look::Line, colour))
            .collect()
    }
    let mut outputs = vec![Series::new("PI^λD^μ", &output, Look::Line, 0)];
    let mut commands = vec![Series::new("PI^λD^μ", &command, Look::Line, 0)];
    if let Some((output, command)) = &beside {
        outputs.push(Series::new("PID of order 1", output, Look::Dashed, 1));
        commands.push(Series::new("PID of order 1", command, Look::Dashed, 1));
    }
    let chart = |caption, y, series| Chart {
        caption,
        x: time,
        y,
        series,
    };
    ChartPage {
        title: "A fractional PID, and the best PID of order 1",
        subtitle: &subtitle(plant, file),
        columns: 2,
        charts: vec![
            chart(
                "PI^λD^μ, half to double the gain",
                y,
                series(&fractional_steps),
            ),
            chart(
                "PID of order 1, half to double the gain",
                y,
                series(&integer_steps),
            ),
            chart(
                "as it is run, with its limits",
                AxisSpec::new("output", Scale::Linear),
                outputs,
            ),
            chart(
                "command",
                command_axis(&command, beside.as_ref().map(|own| &own.1)),
                commands,
            ),
        ],
    }
    .draw()
    .map(Some)
}

/// An axis for commands: without the kick of the first samples, where that is many times the rest.
fn command_axis(command: &Points, beside: Option<&Points>) -> AxisSpec<'static> {
    const KICK: usize = 5;
    let axis = AxisSpec::new("command", Scale::Linear);
    let all = || std::iter::once(command).chain(beside);
    let ends = |skipped: usize| {
        let values = all().flat_map(move |points| points.iter().skip(skipped).map(|p| p.1));
        let values = values.filter(|value| value.is_finite());
        values.fold((0.0, 0.0), |(low, high): (f64, f64), u| {
            (low.min(u), high.max(u))
        })
    };
    let (whole, rest) = (ends(0), ends(KICK));
    let height = 1.1 * (rest.1 - rest.0);
    if height > 0.0 && whole.1 - whole.0 > 3.0 * height {
        axis.between(rest.0 - 0.05 * height, rest.1 + 0.05 * height)
    } else {
        axis
    }
}

/// A record and the function that was found in it.
pub(super) fn draw_identified(
    time_s: &[f64],
    input: &[f64],
    output: &[f64],
    model: &[f64],
    function: &str,
    source: &str,
) -> Result<Picture, FigureError> {
    let of =
        |values: &[f64]| -> Points { time_s.iter().copied().zip(values.iter().copied()).collect() };
    let (input, measured, fitted) = (of(input), of(output), of(model));
    let left: Points = time_s
        .iter()
        .zip(model.iter().zip(output))
        .map(|(t, (model, output))| (*t, model - output))
        .collect();
    let chart = |caption, label, series| Chart {
        caption,
        x: AxisSpec::new("time / s", Scale::Linear),
        y: AxisSpec::new(label, Scale::Linear),
        series,
    };
    ChartPage {
        title: "A transfer function from a record",
        subtitle: &format!("{source}\n{function}"),
        columns: 1,
        charts: vec![
            chart(
                "record and function",
                "input, output",
                vec![
                    Series::new("input", &input, Look::Dotted, 2),
                    Series::new("output, record", &measured, Look::Broad, 3),
                    Series::new("output, function", &fitted, Look::Line, 0),
                ],
            ),
            chart(
                "function less record",
                "difference",
                vec![Series::new("difference", &left, Look::Line, 1)],
            ),
        ],
    }
    .draw()
}

/// Columns of the table of a design.
pub(super) fn design_columns(candidate: &Candidate, prefix: &str) -> Vec<(String, Vec<f64>)> {
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
