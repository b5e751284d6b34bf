//! Pictures of what experiments leave.

use haptic_experiment::curves::{CouplerCurves, TheoryCurves, WallCurves};
use haptic_experiment::drive::DriveCurves;
use haptic_experiment::teleoperation::{FeltAt, TeleoperationCurves};
use haptic_experiment::touch::TouchCurves;
use haptic_figure::{
    AxisSpec, Chart, ChartPage, Conditions, FigureError, HeldPanels, Look, Picture, PlaneFigure,
    Scale, Series, TheoryFigure,
};

/// A run beside its closed form.
///
/// # Errors
/// If there is nothing to draw.
pub fn of_theory(curves: &TheoryCurves) -> Result<Picture, FigureError> {
    let tracking = curves.drive.as_ref().map(tracking);
    TheoryFigure {
        title: &curves.title,
        conditions: Conditions {
            tissue: &curves.tissue,
            order: curves.order,
            device: &curves.device,
            scheme: &curves.scheme,
            remark: &curves.remark,
        },
        quantity: curves.quantity.word(),
        label: curves.quantity.label(),
        origin: curves.origin.word(),
        time_s: &curves.time_s,
        values: &curves.values,
        closed_form: &curves.closed_form,
        relative_error: &curves.relative_error,
        held: curves.drive.as_ref().zip(tracking.as_ref()).map(
            |(drive, (label, tracking_error))| HeldPanels {
                time_s: &drive.time_s,
                label,
                tracking_error,
                force_n: &drive.force_n,
            },
        ),
    }
    .draw()
}

/// What a drive left of its error: axis label, values.
fn tracking(drive: &DriveCurves) -> (&'static str, Vec<f64>) {
    let (label, factor) = match drive.unit {
        "m" => ("tracking error / µm", 1e6),
        _ => ("tracking error / mN", 1e3),
    };
    let scaled = drive.tracking_error.iter().map(|error| factor * error);
    (label, scaled.collect())
}

/// The trial of a wall: the position over its place of rest, and the force below.
///
/// # Errors
/// If there is nothing to draw.
pub fn of_wall(curves: &WallCurves) -> Result<Picture, FigureError> {
    of_trial(&Trial {
        what: "wall",
        subtitle: &curves.subtitle,
        run: curves.origin.word(),
        rest_m: curves.expected_deflection_m,
        time_s: &curves.time_s,
        position_m: &curves.position_m,
        object_m: None,
        force_n: &curves.force_n,
    })
}

/// The trial of a coupler: device and object over the device's place of rest, and the force below.
///
/// # Errors
/// If there is nothing to draw.
pub fn of_coupler(curves: &CouplerCurves) -> Result<Picture, FigureError> {
    of_trial(&Trial {
        what: "coupler",
        subtitle: &curves.subtitle,
        run: curves.origin.word(),
        rest_m: curves.expected_deflection_m,
        time_s: &curves.time_s,
        position_m: &curves.position_m,
        object_m: Some(&curves.object_position_m),
        force_n: &curves.force_n,
    })
}

/// A teleoperation: places and forces of both sides, the energy that the line took, and what was felt.
///
/// # Errors
/// If there is nothing to draw.
pub fn of_teleoperation(curves: &TeleoperationCurves) -> Result<Picture, FigureError> {
    let over_time = |values: &[f64], scale: f64| -> Vec<(f64, f64)> {
        let scaled = values.iter().map(|value| scale * value);
        curves.time_s.iter().copied().zip(scaled).collect()
    };
    let [hand, master, slave] =
        [&curves.hand_m, &curves.master_m, &curves.slave_m].map(|m| over_time(m, 1e3));
    let [master_n, slave_n] = [&curves.master_n, &curves.slave_n].map(|n| over_time(n, 1.0));
    let taken = over_time(&curves.taken_j, 1e3);
    let felt = |value: fn(&FeltAt) -> Option<f64>| felt_over_frequency(&curves.felt, value);
    let (run, formula) = (felt(|f| Some(f.felt_n_per_m)), felt(|f| f.formula_n_per_m));
    let touched = felt(|f| Some(f.touched_n_per_m));
    let chart = |caption, y, series: Vec<_>| Chart {
        caption,
        x: AxisSpec::new("time / s", Scale::Linear),
        y: AxisSpec::new(y, Scale::Linear),
        series,
    };
    ChartPage {
        title: "A teleoperation, simulated",
        subtitle: &curves.subtitle,
        columns: 2,
        charts: vec![
            chart(
                "place",
                "place / mm",
                vec![
                    Series::new("hand", &hand, Look::Dashed, 2),
                    Series::new("master", &master, Look::Line, 0),
                    Series::new("slave", &slave, Look::Line, 1),
                ],
            ),
            chart(
                "force on the device",
                "force / N",
                vec![
                    Series::new("master", &master_n, Look::Line, 0),
                    Series::new("slave", &slave_n, Look::Line, 1),
                ],
            ),
            chart(
                "energy taken by the line",
                "energy / mJ",
                vec![Series::new("line", &taken, Look::Line, 3)],
            ),
            felt_chart(&touched, &formula, &run),
        ],
    }
    .draw()
}

/// What was felt as points over frequency; without those of which there is none.
fn felt_over_frequency(felt: &[FeltAt], value: fn(&FeltAt) -> Option<f64>) -> Vec<(f64, f64)> {
    let points = felt.iter();
    points
        .filter_map(|felt| Some((felt.frequency_hz, value(felt)?)))
        .collect()
}

/// Stiffnesses over frequency, of the run and by the formula, if there is one.
fn felt_chart<'a>(
    touched: &'a [(f64, f64)],
    formula: &'a [(f64, f64)],
    run: &'a [(f64, f64)],
) -> Chart<'a> {
    let series = [
        Series::new("slave", touched, Look::Line, 1),
        Series::new("formula", formula, Look::Dashed, 4),
        Series::new("master", run, Look::Markers, 0),
    ];
    let there = series.into_iter();
    Chart {
        caption: "felt by the master, touched by the slave",
        x: AxisSpec::new("frequency / Hz", Scale::Log),
        y: AxisSpec::new("stiffness |F/x| / N·m⁻¹", Scale::Log),
        series: there.filter(|series| !series.points.is_empty()).collect(),
    }
}

/// A touch: the paths over the shape, the depth, and the force of each axis.
///
/// # Errors
/// If there is nothing to draw.
pub fn of_touch(curves: &TouchCurves) -> Result<Picture, FigureError> {
    PlaneFigure {
        title: &format!("A touch, {}", curves.origin.word()),
        subtitle: &curves.subtitle,
        outline_m: &curves.outline_m,
        time_s: &curves.time_s,
        reference_m: [&curves.hand_m[0], &curves.hand_m[1]],
        position_m: [&curves.position_m[0], &curves.position_m[1]],
        depth_m: Some(&curves.depth_m),
        force_n: &curves.force_n,
    }
    .draw()
}

/// A device that is pushed into a wall or a coupler.
struct Trial<'a> {
    what: &'a str,
    subtitle: &'a str,
    /// Simulated or rendered.
    run: &'a str,
    rest_m: Option<f64>,
    time_s: &'a [f64],
    position_m: &'a [f64],
    object_m: Option<&'a [f64]>,
    force_n: &'a [f64],
}

fn of_trial(trial: &Trial<'_>) -> Result<Picture, FigureError> {
    let time = trial.time_s;
    let against_time = |values: &mut dyn Iterator<Item = f64>| -> Vec<(f64, f64)> {
        time.iter().copied().zip(values).collect()
    };
    let position = against_time(&mut trial.position_m.iter().map(|x| 1e3 * x));
    let object = (trial.object_m).map(|object| against_time(&mut object.iter().map(|x| 1e3 * x)));
    let force = against_time(&mut trial.force_n.iter().copied());
    let ends = [time.first(), time.last()].into_iter().flatten();
    let rest: Vec<(f64, f64)> = trial
        .rest_m
        .map(|x| ends.map(|&t| (t, 1e3 * x)).collect())
        .unwrap_or_default();
    let series = |name, points, look, colour| Series {
        name,
        points,
        look,
        colour,
    };
    let run = trial.run;
    let device = if object.is_some() {
        format!("device, {run}")
    } else {
        run.to_owned()
    };
    let mut positions = vec![series(&device, &position, Look::Line, 0)];
    if let Some(object) = &object {
        positions.push(series("object", object, Look::Line, 2));
    }
    if !rest.is_empty() {
        positions.push(series("place of rest", &rest, Look::Dashed, 1));
    }
    let axis = |label| AxisSpec {
        label,
        scale: Scale::Linear,
        range: None,
    };
    let chart = |caption, label, series| Chart {
        caption,
        x: axis("time / s"),
        y: axis(label),
        series,
    };
    ChartPage {
        title: &format!("A trial of a {}, {run}", trial.what),
        subtitle: trial.subtitle,
        columns: 1,
        charts: vec![
            chart("position", "position / mm", positions),
            chart(
                &format!("force of the {}", trial.what),
                "force / N",
                vec![series(&device, &force, Look::Line, 0)],
            ),
        ],
    }
    .draw()
}
