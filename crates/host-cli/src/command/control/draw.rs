//! Pictures of loops: runs and records here, frequency responses and designs below.

mod bode;
mod steps;

use super::plant::NamedPlant;
use super::words::law;
pub(super) use bode::{draw_loop, draw_plant};
use fractional_control::ControllerSetup;
use fractional_control::Response;
use haptic_figure::{AxisSpec, Chart, ChartPage, FigureError, Look, Picture, Scale, Series};
use haptic_quantity::written;
pub(super) use steps::{design_columns, draw_design};

type Points = Vec<(f64, f64)>;

/// Plant, controller and sample time in a line each.
fn subtitle(plant: &NamedPlant, file: &ControllerSetup) -> String {
    format!(
        "plant {}\ncontroller {} · T = {} · {}",
        plant.words,
        law(file),
        written("sample_time_s", file.sample_time_s),
        file.scheme
    )
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
pub(super) fn run_subtitle(plant: &NamedPlant, file: Option<&ControllerSetup>) -> String {
    match file {
        Some(file) => subtitle(plant, file),
        None => format!("plant {}", plant.words),
    }
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
