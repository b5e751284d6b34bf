//! `analyze sensitivity`: how much a loop amplifies at each frequency.

use super::arguments::{Asked, Files, ResolvedLoop, Wall, decibel, logarithmic, refused, resolve};
use super::path::PathResult;
use crate::keys;
use crate::options::Options;
use crate::output::Output;
use clap::Args;
use haptic_experiment::Failure;
use haptic_experiment::parameters::analysis::SENSITIVITY_POINTS;
use haptic_figure::{AxisSpec, Chart, ChartPage, FigureError, Look, Picture, Scale, Series};
use serde::Serialize;

/// Arguments of `analyze sensitivity`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli analyze sensitivity --order 0.5 --mass 65g --damping 3.5 --sample-time 1ms --stiffness 3N/mm --dissipation 100 --out sensitivity"
)]
pub struct SensitivityArguments {
    #[command(flatten)]
    options: Options<keys::Sensitivity>,
    #[command(flatten)]
    files: Files,
}

/// Result of `analyze sensitivity`.
#[derive(Serialize)]
struct Sensitivity {
    order: f64,
    scheme: String,
    #[serde(flatten)]
    asked: Asked,
    #[serde(flatten)]
    path: PathResult,
    peak_db: f64,
    theta_at_peak: f64,
    points: Vec<SensitivityPoint>,
    files: Vec<String>,
}

#[derive(Clone, Copy, Serialize)]
struct SensitivityPoint {
    theta: f64,
    magnitude_db: f64,
}

impl SensitivityArguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A parameter outside its range; a loop that is not stable; files that cannot be written.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let mut place = self.files.look("sensitivity")?;
        let given = self.options.given()?;
        let count = given.count(&SENSITIVITY_POINTS, 2..=100_000)?;
        let resolved = resolve(&given, Wall::Needed)?;
        let sampled = resolved.sampled()?;
        let peak = sampled.sensitivity_peak().map_err(refused)?;
        let points: Vec<SensitivityPoint> = logarithmic(
            1e-3 * std::f64::consts::PI,
            std::f64::consts::PI,
            count as usize,
        )
        .map(|theta| SensitivityPoint {
            theta,
            magnitude_db: decibel(sampled.sensitivity(theta)),
        })
        .collect();
        let files = place.table_and_picture(points.iter(), || draw(&points, &resolved));
        let result = Sensitivity {
            order: resolved.order.get(),
            scheme: resolved.scheme.to_string(),
            asked: resolved.asked,
            path: resolved.path_result(),
            peak_db: decibel(peak.value),
            theta_at_peak: peak.theta,
            points,
            files,
        };
        output.report(&result)?;
        place.close(Ok(()))
    }
}

fn draw(points: &[SensitivityPoint], resolved: &ResolvedLoop) -> Result<Picture, FigureError> {
    let curve: Vec<(f64, f64)> = points.iter().map(|p| (p.theta, p.magnitude_db)).collect();
    let subtitle = format!(
        "order μ = {} · scheme {} · α = {} · β = {} · δ = {:.5} · {}",
        resolved.order,
        resolved.scheme,
        resolved.parameters.alpha,
        resolved.parameters.beta,
        resolved.parameters.delta,
        resolved.path_result().words()
    );
    ChartPage {
        title: "Sensitivity",
        subtitle: &subtitle,
        columns: 1,
        charts: vec![Chart {
            caption: "",
            x: AxisSpec::new("digital frequency θ / rad", Scale::Log),
            y: AxisSpec::new("|S| / dB", Scale::Linear),
            series: vec![Series::new("|1/(1 + GH)|", &curve, Look::Line, 0)],
        }],
    }
    .draw()
}
