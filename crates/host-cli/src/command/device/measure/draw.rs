//! The motion over the model, and below it what the model does not explain.

use haptic_figure::{AxisSpec, Chart, ChartPage, FigureError, Look, Picture, Scale, Series};

/// Draws time, position read and position of the model, s and m.
///
/// # Errors
/// If there is nothing to draw.
pub(super) fn draw(curve: &[[f64; 3]], words: &str) -> Result<Picture, FigureError> {
    let over_time = |scale: f64, value: fn(&[f64; 3]) -> f64| -> Vec<(f64, f64)> {
        let points = curve.iter();
        points
            .map(|point| (point[0], scale * value(point)))
            .collect()
    };
    let read = over_time(1e3, |point| point[1]);
    let model = over_time(1e3, |point| point[2]);
    let left = over_time(1e6, |point| point[2] - point[1]);
    let time = AxisSpec::new("time / s", Scale::Linear);
    let chart = |caption, y, series| Chart {
        caption,
        x: match (curve.first(), curve.last()) {
            (Some(first), Some(last)) => time.between(first[0], last[0]),
            _ => time,
        },
        y: AxisSpec::new(y, Scale::Linear),
        series,
    };
    ChartPage {
        title: "A device, measured",
        subtitle: words,
        columns: 1,
        charts: vec![
            chart(
                "position read, and of the model",
                "position / mm",
                vec![
                    Series::new("read", &read, Look::Broad, 6),
                    Series::new("model", &model, Look::Dashed, 1),
                ],
            ),
            chart(
                "model less position read",
                "residual / µm",
                vec![Series::new("residual", &left, Look::Line, 0)],
            ),
        ],
    }
    .draw()
}
