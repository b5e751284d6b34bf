//! Pictures of what experiments leave.

use haptic_experiment::curves::{TheoryCurves, WallCurves};
use haptic_figure::{
    AxisSpec, Chart, ChartPage, Conditions, FigureError, Look, Picture, Scale, Series, TheoryFigure,
};

/// A run beside its closed form.
///
/// # Errors
/// If there is nothing to draw.
pub fn of_theory(curves: &TheoryCurves) -> Result<Picture, FigureError> {
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
    }
    .draw()
}

/// The trial of a wall: the position over its place of rest, and the force below.
///
/// # Errors
/// If there is nothing to draw.
pub fn of_wall(curves: &WallCurves) -> Result<Picture, FigureError> {
    let time = &curves.time_s;
    let against_time = |values: &mut dyn Iterator<Item = f64>| -> Vec<(f64, f64)> {
        time.iter().copied().zip(values).collect()
    };
    let position = against_time(&mut curves.position_m.iter().map(|x| 1e3 * x));
    let force = against_time(&mut curves.force_n.iter().copied());
    let ends = [time.first(), time.last()].into_iter().flatten();
    let rest: Vec<(f64, f64)> = curves
        .expected_deflection_m
        .map(|x| ends.map(|&t| (t, 1e3 * x)).collect())
        .unwrap_or_default();
    let series = |name, points, look, colour| Series {
        name,
        points,
        look,
        colour,
    };
    let run = curves.origin.word();
    let mut positions = vec![series(run, &position, Look::Line, 0)];
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
        title: &format!("A trial of a wall, {run}"),
        subtitle: &curves.subtitle,
        columns: 1,
        charts: vec![
            chart("position", "position / mm", positions),
            chart(
                "force of the wall",
                "force / N",
                vec![series(run, &force, Look::Line, 0)],
            ),
        ],
    }
    .draw()
}
