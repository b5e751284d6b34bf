//! The answer as a picture.

use haptic_experiment::question::design::Candidate;
use haptic_experiment::question::design::{Design, DesignReport, Wish};
use haptic_figure::{AxisSpec, Chart, ChartPage, FigureError, Look, Picture, Scale, Series};

/// Draws the wished quantity over the order, and the dissipation that allows it.
pub(super) fn draw(design: &Design, report: &DesignReport) -> Result<Picture, FigureError> {
    let (label, value): (&str, fn(&Candidate) -> Option<f64>) = match design.wish {
        Wish::StiffestWall => ("largest stiffness K / N·m⁻¹", |c| c.stiffness),
        Wish::MostDamping { .. } => ("effective damping / N·s·m⁻¹", |c| {
            c.effective_damping_n_s_per_m
        }),
        Wish::Tissue { .. } => ("largest scale of the specimen", |c| c.largest_scale),
    };
    let beta: fn(&Candidate) -> Option<f64> = |c| c.beta;
    let best = report.best.as_slice();
    let (wished, wished_best) = (points(value, &report.candidates), points(value, best));
    let (betas, beta_best) = (points(beta, &report.candidates), points(beta, best));
    let requirement = match report.gain_margin {
        Some(margin) => format!("stable, gain margin {margin}"),
        None => "passive".to_owned(),
    };
    let axis = |label| AxisSpec {
        label,
        scale: Scale::Linear,
        range: None,
    };
    let series = |name, points, look, colour| Series {
        name,
        points,
        look,
        colour,
    };
    let chart = |label, all, best| Chart {
        caption: "",
        x: axis("order μ"),
        y: axis(label),
        series: vec![
            series("each order", all, Look::Line, 0),
            series("best", best, Look::Markers, 1),
        ],
    };
    ChartPage {
        title: &format!("Design: {}, {requirement}", report.wish),
        subtitle: &subtitle(design, report),
        columns: 2,
        charts: vec![
            chart(label, &wished, &wished_best),
            chart("dissipation β", &betas, &beta_best),
        ],
    }
    .draw()
}

/// The places of a quantity, by rising order.
fn points(value: fn(&Candidate) -> Option<f64>, candidates: &[Candidate]) -> Vec<(f64, f64)> {
    let mut points: Vec<(f64, f64)> = candidates
        .iter()
        .filter_map(|c| Some((c.order, value(c)?)))
        .collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points
}

/// Device and operator in one line.
fn subtitle(design: &Design, report: &DesignReport) -> String {
    format!(
        "m = {} kg · b = {} N·s/m · T = {} s · {} · scheme {}",
        design.device.plant.mass.0,
        design.device.plant.damping.0,
        design.device.plant.sample_time.0,
        report.imperfections.words(),
        report.scheme
    )
}
