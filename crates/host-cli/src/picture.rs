//! Pictures of what experiments leave.

use haptic_experiment::experiment::teleoperation::{FarReport, FeltAt, TeleoperationReport};
use haptic_experiment::judge::Curves;
use haptic_experiment::{Report, TouchReport, TrialReport};
use haptic_figure::{
    AxisSpec, Chart, ChartPage, Conditions, FigureError, HeldPanels, Look, Picture, PlaneFigure,
    Scale, Series, TheoryFigure,
};

/// A run beside its closed form.
pub(crate) fn of_theory(report: &Report, curves: &Curves) -> Result<Picture, FigureError> {
    let (quantity, label) = match report.final_strain {
        Some(_) => ("strain", "strain"),
        None => ("force", "force / N"),
    };
    let (error_label, factor) = match report.final_strain {
        None => ("tracking error / µm", 1e6),
        Some(_) => ("tracking error / mN", 1e3),
    };
    let errors = curves.column("tracking_error").iter();
    let tracking_error: Vec<f64> = errors.map(|error| factor * error).collect();
    TheoryFigure {
        title: &curves.title,
        conditions: Conditions {
            tissue: &report.tissue,
            order: report.order,
            device: &report.run.device,
            scheme: &report.scheme,
            remark: &curves.subtitle,
        },
        quantity,
        label,
        origin: curves.origin.word(),
        time_s: &curves.time_s,
        values: curves.column("values"),
        closed_form: curves.column("closed_form"),
        relative_error: curves.column("relative_error"),
        held: report.drive.as_ref().map(|_| HeldPanels {
            time_s: &curves.time_s,
            label: error_label,
            tracking_error: &tracking_error,
            force_n: curves.column("drive_force_n"),
        }),
    }
    .draw()
}

/// Values in another unit, each at its time.
fn over_time(time_s: &[f64], values: &[f64], scale: f64) -> Vec<(f64, f64)> {
    let scaled = values.iter().map(|value| scale * value);
    time_s.iter().copied().zip(scaled).collect()
}

/// Curves over time.
fn time_chart<'a>(caption: &'a str, y: &'a str, series: Vec<Series<'a>>) -> Chart<'a> {
    Chart {
        caption,
        x: AxisSpec::new("time / s", Scale::Linear),
        y: AxisSpec::new(y, Scale::Linear),
        series,
    }
}

/// One side of a teleoperation: places and forces.
pub(crate) fn of_side(_: &FarReport, curves: &Curves) -> Result<Picture, FigureError> {
    let over_time = |values: &[f64], scale| over_time(&curves.time_s, values, scale);
    let [hand, device] =
        ["reference_m", "position_m"].map(|name| over_time(curves.column(name), 1e3));
    let [force, outside] = ["force_n", "outside_n"].map(|name| over_time(curves.column(name), 1.0));
    let (hand_is, device_is) = (
        Series::new("hand", &hand, Look::Dashed, 2),
        Series::new("device", &device, Look::Line, 0),
    );
    // There is no hand on the side of the slave.
    let has_hand = curves
        .column("reference_m")
        .iter()
        .any(|place| place.is_finite());
    ChartPage {
        title: &curves.title,
        subtitle: &curves.subtitle,
        columns: 1,
        charts: vec![
            time_chart(
                "place",
                "place / mm",
                if has_hand {
                    vec![hand_is, device_is]
                } else {
                    vec![device_is]
                },
            ),
            time_chart(
                "force on the device",
                "force / N",
                vec![
                    Series::new("of the port", &force, Look::Line, 0),
                    Series::new("from outside", &outside, Look::Line, 1),
                ],
            ),
        ],
    }
    .draw()
}

/// A teleoperation: places and forces of both sides, the energy that the line took, and what was felt.
pub(crate) fn of_teleoperation(
    report: &TeleoperationReport,
    curves: &Curves,
) -> Result<Picture, FigureError> {
    let over_time = |values: &[f64], scale| over_time(&curves.time_s, values, scale);
    let [hand, master, slave] =
        ["hand_m", "position_m", "far_position_m"].map(|name| over_time(curves.column(name), 1e3));
    let [master_n, slave_n] =
        ["force_n", "far_force_n"].map(|name| over_time(curves.column(name), 1.0));
    let taken = over_time(curves.column("taken_j"), 1e3);
    let felt = |value: fn(&FeltAt) -> Option<f64>| felt_over_frequency(&report.felt, value);
    let (run, formula) = (felt(|f| Some(f.felt_n_per_m)), felt(|f| f.formula_n_per_m));
    let touched = felt(|f| Some(f.touched_n_per_m));
    ChartPage {
        title: &curves.title,
        subtitle: &curves.subtitle,
        columns: 2,
        charts: vec![
            time_chart(
                "place",
                "place / mm",
                vec![
                    Series::new("hand", &hand, Look::Dashed, 2),
                    Series::new("master", &master, Look::Line, 0),
                    Series::new("slave", &slave, Look::Line, 1),
                ],
            ),
            time_chart(
                "force on the device",
                "force / N",
                vec![
                    Series::new("master", &master_n, Look::Line, 0),
                    Series::new("slave", &slave_n, Look::Line, 1),
                ],
            ),
            time_chart(
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
pub(crate) fn of_touch(_: &TouchReport, curves: &Curves) -> Result<Picture, FigureError> {
    let forces = ["force_x_n", "force_y_n", "force_z_n"].map(|name| curves.column(name).to_vec());
    let axes = forces.iter().filter(|force| !force.is_empty()).count();
    PlaneFigure {
        title: &curves.title,
        subtitle: &curves.subtitle,
        outline_m: &curves.outline_m,
        time_s: &curves.time_s,
        reference_m: ["hand_x_m", "hand_y_m"].map(|name| curves.column(name)),
        position_m: ["x_m", "y_m"].map(|name| curves.column(name)),
        depth_m: Some(curves.column("depth_m")),
        force_n: &forces[..axes],
    }
    .draw()
}

/// The trial of a wall or a coupler: device and object over the device's place of rest, and the force below.
pub(crate) fn of_trial(report: &TrialReport, trial: &Curves) -> Result<Picture, FigureError> {
    let time = &trial.time_s;
    let position = over_time(time, trial.column("position_m"), 1e3);
    let object = Some(trial.column("object_position_m")).filter(|object| !object.is_empty());
    let object = object.map(|object| over_time(time, object, 1e3));
    let force = over_time(time, trial.column("force_n"), 1.0);
    let ends = [time.first(), time.last()].into_iter().flatten();
    let rest: Vec<(f64, f64)> = (report.settling.expected_deflection_m)
        .map(|x| ends.map(|&t| (t, 1e3 * x)).collect())
        .unwrap_or_default();
    let run = trial.origin.word();
    let device = if object.is_some() {
        format!("device, {run}")
    } else {
        run.to_owned()
    };
    let what = if object.is_some() { "coupler" } else { "wall" };
    let mut positions = vec![Series::new(&device, &position, Look::Line, 0)];
    if let Some(object) = &object {
        positions.push(Series::new("object", object, Look::Line, 2));
    }
    if !rest.is_empty() {
        positions.push(Series::new("place of rest", &rest, Look::Dashed, 1));
    }
    let curves = [&position[..], object.as_deref().unwrap_or_default(), &force];
    let shown_s = lively_s(&curves);
    let chart = |caption, label, series| {
        let mut chart = time_chart(caption, label, series);
        chart.x.range = shown_s.map(|end_s| (0.0, end_s));
        chart
    };
    let rest = match (shown_s, time.last()) {
        (Some(_), Some(end_s)) => format!(", until it is nearly at rest; the run lasts {end_s} s"),
        _ => String::new(),
    };
    ChartPage {
        title: &trial.title,
        subtitle: &trial.subtitle,
        columns: 1,
        charts: vec![
            chart(&format!("position{rest}"), "position / mm", positions),
            chart(
                &format!("force of the {what}"),
                "force / N",
                vec![Series::new(&device, &force, Look::Line, 0)],
            ),
        ],
    }
    .draw()
}

/// Motion below this share of the largest is none.
const STILL: f64 = 0.03;
/// Time that is shown beyond the last motion, as a multiple of the time up to it.
const SHOWN: f64 = 1.5;
/// A run that moves for more than this share of its length is shown whole.
const WHOLE: f64 = 0.5;

/// The time up to which to show curves that come to rest early: they do something before it. `None` to show them whole.
fn lively_s(curves: &[&[(f64, f64)]]) -> Option<f64> {
    let end_s = curves.iter().find_map(|curve| curve.last())?.0;
    let last_s = curves.iter().map(|curve| last_motion_s(curve));
    let shown_s = SHOWN * last_s.fold(0.0, f64::max);
    (shown_s > 0.0 && shown_s < WHOLE * end_s).then(|| two_digits_up(shown_s))
}

/// Last time at which a curve is not yet where it ends, s.
fn last_motion_s(curve: &[(f64, f64)]) -> f64 {
    let Some(&(_, rest)) = curve.last() else {
        return 0.0;
    };
    let off = |value: f64| (value - rest).abs();
    let largest = curve.iter().map(|point| off(point.1)).fold(0.0, f64::max);
    let moving = |point: &&(f64, f64)| off(point.1) > STILL * largest;
    curve.iter().rev().find(moving).map_or(0.0, |point| point.0)
}

/// With two digits, not less.
fn two_digits_up(value: f64) -> f64 {
    let unit = 10_f64.powi(value.log10().floor() as i32 - 1);
    // 0.32, not 0.32000000000000006.
    let digits = (value / unit - 1e-9).ceil();
    if unit < 1.0 {
        digits / (1.0 / unit).round()
    } else {
        digits * unit
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(end_s: f64, value: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        let times = (0..=1000).map(|n| end_s * f64::from(n) / 1000.0);
        times.map(|time_s| (time_s, value(time_s))).collect()
    }

    #[test]
    fn a_curve_that_comes_to_rest_early_is_shown_while_it_moves() {
        // e^(−t/0.1) is below 3 % from 0.35 s on.
        let early = curve(5.0, |t| 1.0 - (-t / 0.1).exp());
        let shown_s = lively_s(&[&early]).expect("a part of it");
        assert!((shown_s - 0.53).abs() < 0.011, "{shown_s}");
        // One that moves longer is shown too.
        let later = curve(5.0, |t| (-t / 0.3).exp());
        assert!(lively_s(&[&early, &later]).expect("a part") > 1.5);
    }

    #[test]
    fn what_moves_up_to_its_end_or_not_at_all_is_shown_whole() {
        for whole in [
            curve(5.0, |t| (9.0 * t).sin()),
            curve(5.0, |t| t.exp()),
            curve(5.0, |t| (-t).exp()),
            curve(5.0, |_| 1.0),
            Vec::new(),
        ] {
            assert_eq!(lively_s(&[&whole]), None);
        }
    }
}
