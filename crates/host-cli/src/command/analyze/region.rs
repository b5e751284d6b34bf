//! `analyze stability-region`: all walls that are stable on a device.

use super::arguments::{Asked, Files, ResolvedLoop, Wall, refused, resolve};
use super::path::PathResult;
use crate::keys;
use crate::options::Options;
use crate::output::Output;
use clap::Args;
use haptic_analysis::{BoundaryPoint, StabilityRegion};
use haptic_experiment::Failure;
use haptic_figure::{AxisSpec, Chart, ChartPage, FigureError, Look, Picture, Scale, Series};
use serde::Serialize;

/// Arguments of `analyze stability-region`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli analyze stability-region --order 1 --mass 65g --damping 3.5 --sample-time 1ms --delay-samples 1 --out region"
)]
pub struct RegionArguments {
    #[command(flatten)]
    options: Options<keys::Loop>,
    #[command(flatten)]
    files: Files,
}

/// Result of `analyze stability-region`.
#[derive(Serialize)]
struct Region {
    order: f64,
    scheme: String,
    #[serde(flatten)]
    asked: Asked,
    delta: f64,
    gamma: f64,
    #[serde(flatten)]
    path: PathResult,
    empty: bool,
    area: f64,
    alpha_max: Option<f64>,
    beta_at_alpha_max: Option<f64>,
    beta_max: Option<f64>,
    /// K of `alpha_max`; null for a loop without units.
    stiffness_max_n_per_m: Option<f64>,
    /// B there.
    dissipation_at_stiffness_max_n_s_mu_per_m: Option<f64>,
    /// Outline of the largest part; others follow in `further_parts`.
    boundary: Vec<Point>,
    further_parts: Vec<Vec<Point>>,
    files: Vec<String>,
}

#[derive(Clone, Copy, Serialize)]
struct Point {
    alpha: f64,
    beta: f64,
}

/// A row of the region's CSV.
#[derive(Serialize)]
struct RegionRow {
    part: usize,
    alpha: f64,
    beta: f64,
    #[serde(rename = "theta_rad")]
    theta: Option<f64>,
}

/// Points on the boundary of a region.
const POINTS: usize = 1000;

impl RegionArguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A parameter outside its range; files that cannot be written.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let mut place = self.files.look("region")?;
        let resolved = resolve(&self.options.given()?, Wall::Sought)?;
        let parameters = resolved.parameters;
        let region = StabilityRegion::new(resolved.plant()?, &resolved.operator, 0, POINTS)
            .map_err(refused)?;
        let mut result = Region {
            order: resolved.order.get(),
            scheme: resolved.scheme.to_string(),
            asked: resolved.asked,
            delta: parameters.delta,
            gamma: parameters.gamma,
            path: resolved.path_result(),
            empty: region.bounded().is_none(),
            area: 0.0,
            alpha_max: None,
            beta_at_alpha_max: None,
            beta_max: None,
            stiffness_max_n_per_m: None,
            dissipation_at_stiffness_max_n_s_mu_per_m: None,
            boundary: Vec::new(),
            further_parts: Vec::new(),
            files: Vec::new(),
        };
        if let Some(area) = region.bounded() {
            result.area = area.area;
            result.alpha_max = Some(area.alpha_max);
            result.beta_at_alpha_max = Some(area.beta_at_alpha_max);
            result.beta_max = Some(area.beta_max);
            if let Some((m, t)) = resolved.units {
                // K = αm/T², B = βm/T^(2−μ)
                result.stiffness_max_n_per_m = Some(area.alpha_max * m / (t * t));
                result.dissipation_at_stiffness_max_n_s_mu_per_m =
                    Some(area.beta_at_alpha_max * m / t.powf(2.0 - result.order));
            }
            let rows = area
                .polygons
                .iter()
                .enumerate()
                .flat_map(|(part, polygon)| {
                    polygon.points.iter().map(move |p| RegionRow {
                        part,
                        alpha: p.alpha,
                        beta: p.beta,
                        theta: p.theta,
                    })
                });
            let mut parts = area.polygons.iter().map(|polygon| outline(&polygon.points));
            result.boundary = parts.next().unwrap_or_default();
            result.further_parts = parts.collect();
            result.files = place.table_and_picture(rows, || draw_region(&result, &resolved));
        }
        output.report(&result)?;
        place.close(Ok(()))
    }
}

fn outline(points: &[BoundaryPoint]) -> Vec<Point> {
    let points = points.iter();
    points
        .map(|p| Point {
            alpha: p.alpha,
            beta: p.beta,
        })
        .collect()
}

fn draw_region(region: &Region, resolved: &ResolvedLoop) -> Result<Picture, FigureError> {
    let outline = |points: &[Point]| -> Vec<(f64, f64)> {
        let closed = points.iter().chain(points.first());
        closed.map(|p| (p.beta, p.alpha)).collect()
    };
    let mut parts = vec![outline(&region.boundary)];
    parts.extend(region.further_parts.iter().map(|part| outline(part)));
    let subtitle = format!(
        "order μ = {} · scheme {} · δ = {:.5} · γ = {:.5} · {}",
        region.order,
        resolved.scheme,
        region.delta,
        region.gamma,
        region.path.words()
    );
    ChartPage {
        title: "Stable walls",
        subtitle: &subtitle,
        columns: 1,
        charts: vec![Chart {
            caption: "",
            x: AxisSpec::new("dissipation β = BT^{2−μ}/m", Scale::Linear),
            y: AxisSpec::new("stiffness α = KT²/m", Scale::Linear),
            series: parts
                .iter()
                .enumerate()
                .map(|(n, part)| {
                    Series::new(if n == 0 { "stable" } else { "" }, part, Look::Area, 0)
                })
                .collect(),
        }],
    }
    .draw()
}
