//! `analyze stability`, `stability-region` and `sensitivity`.

use super::arguments::{
    Files, LoopArguments, PathResult, ResolvedLoop, Wall, logarithmic, refused,
};
use crate::output::{Output, fixed, short};
use clap::Args;
use haptic_analysis::StabilityRegion;
use haptic_experiment::failure::Failure;
use haptic_figure::{AxisSpec, Chart, ChartPage, FigureError, Look, Picture, Scale, Series};
use serde::Serialize;
use std::io::{self, Write};

/// Arguments of `analyze stability`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli analyze stability --order 0.5 --mass 65g --damping 3.5 --sample-time 2ms \
                  --stiffness 3N/mm --dissipation 100"
)]
pub struct VerdictArguments {
    #[command(flatten)]
    arguments: LoopArguments,
}

/// Arguments of `analyze stability-region`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli analyze stability-region --order 1 --delta 0.1 --delay-samples 1 --out region"
)]
pub struct RegionArguments {
    #[command(flatten)]
    arguments: LoopArguments,
    #[command(flatten)]
    files: Files,
}

/// Arguments of `analyze sensitivity`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli analyze sensitivity --order 0.5 --alpha 0.1 --beta 0.3 --delta 0.1 --out sensitivity"
)]
pub struct SensitivityArguments {
    #[command(flatten)]
    arguments: LoopArguments,
    /// Number of frequencies
    #[arg(long, default_value_t = 400, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    points: u32,
    #[command(flatten)]
    files: Files,
}

/// Result of `analyze stability`.
#[derive(Serialize)]
struct StabilityVerdict {
    order: f64,
    scheme: String,
    alpha: f64,
    beta: f64,
    delta: f64,
    gamma: f64,
    #[serde(flatten)]
    path: PathResult,
    /// There is no spring at all: the device stays where it is left, and the loop is judged held by a tiny one.
    drifts: bool,
    stable: bool,
    /// Largest |z| of a pole; null if P is irrational or the polynomial too long.
    spectral_radius: Option<f64>,
    /// Poles with |z| > 1, by encirclement; null on the boundary.
    encirclements: Option<usize>,
    /// Factor by which the wall as a whole could grow; null for none, or if unstable.
    gain_margin: Option<f64>,
    /// More delay that the loop could bear, samples; null for any, or if unstable.
    delay_margin_samples: Option<f64>,
    peak_sensitivity_db: Option<f64>,
}

/// Result of `analyze stability-region`.
#[derive(Serialize)]
struct Region {
    order: f64,
    scheme: String,
    delta: f64,
    gamma: f64,
    #[serde(flatten)]
    path: PathResult,
    empty: bool,
    area: f64,
    alpha_max: Option<f64>,
    beta_at_alpha_max: Option<f64>,
    beta_max: Option<f64>,
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

/// Result of `analyze sensitivity`.
#[derive(Serialize)]
struct Sensitivity {
    order: f64,
    scheme: String,
    #[serde(flatten)]
    path: PathResult,
    points: Vec<SensitivityPoint>,
    peak_db: f64,
    theta_at_peak: f64,
    files: Vec<String>,
}

#[derive(Clone, Copy, Serialize)]
struct SensitivityPoint {
    theta: f64,
    magnitude_db: f64,
}

/// Points on the boundary of a region.
const POINTS: usize = 1000;

/// Amplitude ratio in decibel.
fn decibel(magnitude: f64) -> f64 {
    20.0 * magnitude.log10()
}

impl VerdictArguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let resolved = self.arguments.resolve(Wall::Needed)?;
        let parameters = resolved.parameters;
        // Without any spring there is a pole at z = 1, which is no instability.
        let sampled = resolved.sampled()?;
        let (drifts, sampled) = (sampled.drifts(), sampled.held());
        let verdict = sampled.verdict();
        // Only a stable loop has margins; the edge is not stable.
        let margins = if verdict.stable {
            sampled.margins().ok()
        } else {
            None
        };
        let result = StabilityVerdict {
            order: resolved.order.get(),
            scheme: resolved.scheme.to_string(),
            alpha: parameters.alpha,
            beta: parameters.beta,
            delta: parameters.delta,
            gamma: parameters.gamma,
            path: resolved.path_result(),
            drifts,
            stable: verdict.stable,
            spectral_radius: verdict.spectral_radius,
            encirclements: verdict.unstable_poles,
            gain_margin: margins
                .and_then(|margins| margins.gain_up)
                .map(|at| at.value),
            delay_margin_samples: margins.and_then(|margins| margins.delay).map(|at| at.value),
            peak_sensitivity_db: margins.map(|margins| decibel(margins.sensitivity.value)),
        };
        output.print(&result, |out| print_verdict(out, &result))
    }
}

/// The result as a person reads it.
fn print_verdict(out: &mut dyn Write, result: &StabilityVerdict) -> io::Result<()> {
    writeln!(
        out,
        "{}: order {}, scheme {}, alpha {}, beta {}, delta {}, gamma {}, {}",
        match (result.stable, result.encirclements) {
            (true, _) => "stable",
            (false, Some(_)) => "unstable",
            (false, None) => "on the boundary",
        },
        result.order,
        result.scheme,
        short(result.alpha),
        short(result.beta),
        short(result.delta),
        short(result.gamma),
        result.path.words()
    )?;
    if result.drifts {
        writeln!(
            out,
            "  without any spring: the device stays where it is left; judged with one of 1e-4 beta"
        )?;
    }
    if let Some(poles) = result.encirclements.filter(|poles| *poles > 0) {
        writeln!(out, "  unstable poles    {poles}")?;
    }
    if let Some(radius) = result.spectral_radius {
        writeln!(out, "  spectral radius   {}", fixed(radius, 9))?;
    }
    if result.stable {
        let or_any =
            |value: Option<f64>| value.map_or_else(|| "any".to_owned(), |value| fixed(value, 6));
        writeln!(
            out,
            "  gain margin       {} times the wall",
            or_any(result.gain_margin)
        )?;
        writeln!(
            out,
            "  delay margin      {} samples more",
            or_any(result.delay_margin_samples)
        )?;
    }
    if let Some(peak) = result.peak_sensitivity_db {
        writeln!(out, "  sensitivity peak  {peak:.3} dB")?;
    }
    Ok(())
}

impl RegionArguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A parameter outside its range; files that cannot be written.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let resolved = self.arguments.resolve(Wall::Sought)?;
        let parameters = resolved.parameters;
        let region = StabilityRegion::new(resolved.plant()?, &resolved.operator, 0, POINTS)
            .map_err(refused)?;
        let mut result = Region {
            order: resolved.order.get(),
            scheme: resolved.scheme.to_string(),
            delta: parameters.delta,
            gamma: parameters.gamma,
            path: resolved.path_result(),
            empty: region.is_empty(),
            area: 0.0,
            alpha_max: None,
            beta_at_alpha_max: None,
            beta_max: None,
            boundary: Vec::new(),
            further_parts: Vec::new(),
            files: Vec::new(),
        };
        if let Some(area) = region.bounded() {
            result.area = area.area;
            result.alpha_max = Some(area.alpha_max);
            result.beta_at_alpha_max = Some(area.beta_at_alpha_max);
            result.beta_max = Some(area.beta_max);
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
            let mut parts = area.polygons.iter().map(|polygon| {
                let points = polygon.points.iter();
                points
                    .map(|p| Point {
                        alpha: p.alpha,
                        beta: p.beta,
                    })
                    .collect::<Vec<_>>()
            });
            result.boundary = parts.next().unwrap_or_default();
            result.further_parts = parts.collect();
            result.files = self
                .files
                .write("region", rows, || draw_region(&result, &resolved))?;
        }
        output.print(&result, |out| print_region(out, &result, resolved.units))
    }
}

/// The result as a person reads it.
fn print_region(out: &mut dyn Write, result: &Region, units: Option<(f64, f64)>) -> io::Result<()> {
    if result.empty {
        return writeln!(
            out,
            "empty: no wall of this order is stable on this device (delta {}, {})",
            short(result.delta),
            result.path.words()
        );
    }
    writeln!(out, "area               {:.9}", result.area)?;
    if let (Some(alpha), Some(at), Some(beta)) =
        (result.alpha_max, result.beta_at_alpha_max, result.beta_max)
    {
        writeln!(out, "largest alpha      {alpha:.9} at beta {at:.9}")?;
        writeln!(out, "largest beta       {beta:.9}")?;
        if let Some((m, t)) = units {
            let stiffness = alpha * m / (t * t);
            let unit = m / t.powf(2.0 - result.order);
            writeln!(
                out,
                "stiffest wall      {} N/m at B = {} N·s^μ/m",
                fixed(stiffness, 6),
                fixed(at * unit, 6)
            )?;
        }
    }
    writeln!(
        out,
        "outline            {} points in {} parts (--json or --out for all)",
        result.boundary.len() + result.further_parts.iter().map(Vec::len).sum::<usize>(),
        1 + result.further_parts.len()
    )?;
    result
        .files
        .iter()
        .try_for_each(|file| writeln!(out, "written: {file}"))
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

impl SensitivityArguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A parameter outside its range; a loop that is not stable; files that cannot be written.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let resolved = self.arguments.resolve(Wall::Needed)?;
        let sampled = resolved.sampled()?;
        let peak = sampled.sensitivity_peak().map_err(refused)?;
        let points: Vec<SensitivityPoint> = logarithmic(
            1e-3 * std::f64::consts::PI,
            std::f64::consts::PI,
            self.points as usize,
        )
        .map(|theta| SensitivityPoint {
            theta,
            magnitude_db: decibel(sampled.sensitivity(theta)),
        })
        .collect();
        let files = self.files.write("sensitivity", points.iter(), || {
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
        })?;
        let result = Sensitivity {
            order: resolved.order.get(),
            scheme: resolved.scheme.to_string(),
            path: resolved.path_result(),
            points,
            peak_db: decibel(peak.value),
            theta_at_peak: peak.theta,
            files,
        };
        output.print(&result, |out| {
            writeln!(
                out,
                "peak  {:.6} dB at theta = {:.6} rad",
                result.peak_db, result.theta_at_peak
            )?;
            result
                .files
                .iter()
                .try_for_each(|file| writeln!(out, "written: {file}"))
        })
    }
}
