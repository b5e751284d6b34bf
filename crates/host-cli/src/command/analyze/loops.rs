//! A wall on a device: `stability`, `stability-region`, `passivity` and `sensitivity`.

use super::resolved::{ResolvedLoop, Wall, decibel, logarithmic, resolve};
use crate::options::{Options, WithFiles, keys};
use crate::output::{Output, warn};
use crate::picture::{Panel, Points, linear, logarithmic as axis, page};
use haptic_analysis::{AnalysisError, Largest, Nondimensional, OnePort, StabilityRegion};
use haptic_experiment::Failure;
use haptic_experiment::parameters::analysis::{ALPHA, BETA, SENSITIVITY_POINTS};
use haptic_experiment::parameters::{DISSIPATION, STIFFNESS};
use haptic_figure::{FigureError, Look, Picture};
use serde_json::json;
use std::f64::consts::PI;

pub(super) fn stability(options: Options<keys::Wall>, output: Output) -> Result<(), Failure> {
    let resolved = resolve(&options.given()?, Wall::Needed)?;
    let parameters = resolved.parameters;
    // Without any spring there is a pole at z = 1, which is no instability: the device stays where it is left.
    let sampled = resolved.sampled()?;
    let (drifts, sampled) = (sampled.drifts(), sampled.beside_rest());
    let verdict = sampled.verdict();
    // Only a stable loop has margins; the edge is not stable.
    let margins = verdict.stable.then(|| sampled.margins().ok()).flatten();
    let contact = sampled.slope_limit();
    let factor = |value: f64| (value > 0.0 && value.is_finite()).then_some(value);
    let without_units = json!({
        "alpha": parameters.alpha,
        "beta": parameters.beta,
        "delta": parameters.delta,
        "gamma": parameters.gamma,
    });
    let found = json!({
        "stable": verdict.stable,
        "stable_reason": match (verdict.unstable_poles, drifts) {
            (None, _) => Some("on the boundary"),
            (_, true) => Some("without a spring the device stays where it is left"),
            _ => None,
        },
        "drifts": drifts,
        // Largest |z| of a pole; null if P is irrational or the polynomial too long.
        "spectral_radius": sampled.spectral_radius(),
        // Poles with |z| > 1; null on the boundary.
        "encirclements": verdict.unstable_poles,
        // By how much the wall could grow, and how much more delay it could bear; null for any, or if unstable.
        "gain_margin": margins.and_then(|margins| margins.gain_up).map(|at| at.value),
        "delay_margin_samples": margins.and_then(|margins| margins.delay).map(|at| at.value),
        "peak_sensitivity_db": margins.map(|margins| decibel(margins.sensitivity.value)),
        // The factor on the wall up to which contact that may pull, acts on one side or stiffens, and is nowhere steeper than this, is proved
        // stable for every motion; null if nothing is proved. And the factor that no such proof reaches.
        "pulling_contact_margin": factor(contact.proved),
        "pulling_contact_margin_reason": (contact.proved == 0.0 && contact.provable > 0.0)
            .then_some("no proof was found; a device without damping has none"),
        "pulling_contact_margin_most": factor(contact.provable),
    });
    resolved.report(without_units, found, output)
}

pub(super) fn passivity(options: Options<keys::Wall>, output: Output) -> Result<(), Failure> {
    let resolved = resolve(&options.given()?, Wall::Needed)?;
    let parameters = resolved.parameters;
    let port = OnePort::new(&resolved.operator, resolved.order)
        .and_then(|port| port.through(resolved.path))
        .map_err(Failure::input)?
        .with_memory(resolved.operator.memory());
    let required = port.required_delta(parameters.alpha, parameters.beta);
    let required = required.map_err(Failure::input)?;
    let delta = resolved.delta_given.then_some(parameters.delta);
    let largest = |found: Result<Largest, AnalysisError>| match found.map_err(Failure::input)? {
        Largest::Below { value, .. } => Ok::<_, Failure>(Some(value)),
        Largest::Any | Largest::Empty => Ok(None),
    };
    let (mut alpha, mut beta) = (None, None);
    if let Some(delta) = delta {
        alpha = largest(port.largest_alpha(delta, parameters.beta))?;
        beta = largest(port.largest_beta(delta, parameters.alpha))?;
    }
    let [stiffness, dissipation] = resolved.with_units(alpha, beta);
    let without_units = json!({"alpha": parameters.alpha, "beta": parameters.beta, "delta": delta});
    let found = json!({
        // Least δ by Theorem 1 for the operator really used, and by Corollary 1 for the exact one without delay.
        "required_delta": required.delta,
        "corollary_delta": required.corollary_delta,
        "worst_theta": required.worst_theta,
        "passive": delta.map(|delta| required.passive(delta)),
        "passive_reason": match (required.negative_at_rest, delta) {
            (true, _) => Some("a negative spring at rest: no damping is enough"),
            (false, None) => Some("give --delta or --damping to know"),
            _ => None,
        },
        "negative_at_rest": required.negative_at_rest,
        // Passive with the given δ and the other; null without a δ, or if none or any is.
        "largest_alpha": alpha,
        "largest_beta": beta,
        "largest_stiffness_n_per_m": stiffness,
        "largest_dissipation_n_s_mu_per_m": dissipation,
        // δ = bT/m
        "required_damping_n_s_per_m": resolved.units.map(|(m, t)| required.delta * m / t),
        "worst_rad_s": resolved.units.map(|(_, t)| required.worst_theta / t),
    });
    resolved.report(without_units, found, output)
}

/// Points on the boundary of a region.
const POINTS: usize = 1000;

pub(super) fn region(asked: WithFiles<keys::Wall>, output: Output) -> Result<(), Failure> {
    let mut outputs = asked.files.look("region", &[])?;
    let given = asked.options.given()?;
    let resolved = resolve(&given, Wall::Sought)?;
    let of_wall = [STIFFNESS, DISSIPATION, ALPHA, BETA];
    if !resolved.wall_given && of_wall.iter().any(|parameter| given.has(parameter)) {
        warn("no wall is marked: give both --stiffness and --dissipation, or --alpha and --beta");
    }
    let parameters = resolved.parameters;
    let region = StabilityRegion::new(resolved.plant()?, &resolved.operator, 0, POINTS);
    let region = region.map_err(Failure::input)?;
    let area = region.bounded();
    let parts: Vec<Vec<_>> = (area.iter().flat_map(|area| &area.polygons))
        .map(|polygon| polygon.points.iter().collect())
        .collect();
    let rows = parts
        .iter()
        .enumerate()
        .flat_map(|(part, points)| points.iter().map(move |p| (part, p.alpha, p.beta, p.theta)));
    let files = match area {
        Some(_) => {
            outputs.table_and_picture(&["part", "alpha", "beta", "theta_rad"], rows, || {
                // Closed outlines.
                let outlines = parts.iter().map(|points| {
                    let closed = points.iter().chain(points.first());
                    closed.map(|p| (p.beta, p.alpha)).collect()
                });
                draw_region(&outlines.collect::<Vec<_>>(), &resolved)
            })
        }
        None => Vec::new(),
    };
    let mut outlines = parts.iter().map(|points| {
        let points = points
            .iter()
            .map(|p| json!({"alpha": p.alpha, "beta": p.beta}));
        points.collect::<Vec<_>>()
    });
    let [stiffness, dissipation] = resolved.with_units(
        area.map(|area| area.alpha_max),
        area.map(|area| area.beta_at_alpha_max),
    );
    let found = json!({
        "empty": region.bounded().is_none(),
        "area": area.map_or(0.0, |area| area.area),
        "alpha_max": area.map(|area| area.alpha_max),
        "beta_at_alpha_max": area.map(|area| area.beta_at_alpha_max),
        "beta_max": area.map(|area| area.beta_max),
        "stiffness_max_n_per_m": stiffness,
        "dissipation_at_stiffness_max_n_s_mu_per_m": dissipation,
        // Outline of the largest part; others follow in `further_parts`.
        "boundary": outlines.next().unwrap_or_default(),
        "further_parts": outlines.collect::<Vec<_>>(),
        "files": files,
    });
    let without_units = json!({"delta": parameters.delta, "gamma": parameters.gamma});
    resolved.report(without_units, found, output)?;
    outputs.close(Ok(()))
}

fn draw_region(parts: &[Points], resolved: &ResolvedLoop) -> Result<Picture, FigureError> {
    // Of α = 1 and of β = 1, in units where there are any.
    let ([x, y], [stiffness, dissipation]) = match resolved.with_units(Some(1.0), Some(1.0)) {
        [Some(stiffness), Some(dissipation)] => (
            ["dissipation B / N·s^μ·m⁻¹", "stiffness K / N·m⁻¹"],
            [stiffness, dissipation],
        ),
        _ => (
            ["dissipation β = BT^{2−μ}/m", "stiffness α = KT²/m"],
            [1.0, 1.0],
        ),
    };
    let in_units = |beta: f64, alpha: f64| (beta * dissipation, alpha * stiffness);
    let mut panel = Panel::new("", linear(x), linear(y));
    for part in parts {
        let outline = part.iter().map(|&(beta, alpha)| in_units(beta, alpha));
        panel = panel.with("stable", Look::Area, 0, outline);
    }
    let Nondimensional { alpha, beta, .. } = resolved.parameters;
    let wall = resolved.wall_given.then(|| in_units(beta, alpha));
    panel = panel.with("your wall", Look::Markers, 1, wall);
    page("Stable walls", &resolved.words(false), 1, &[panel])
}

pub(super) fn sensitivity(
    asked: WithFiles<keys::Sensitivity>,
    output: Output,
) -> Result<(), Failure> {
    let mut outputs = asked.files.look("sensitivity", &[])?;
    let given = asked.options.given()?;
    let count = given.count(&SENSITIVITY_POINTS, 2..=100_000)? as usize;
    let resolved = resolve(&given, Wall::Needed)?;
    let sampled = resolved.sampled()?;
    let peak = sampled.sensitivity_peak().map_err(Failure::input)?;
    let curve: Vec<(f64, f64)> = logarithmic(1e-3 * PI, PI, count)
        .map(|theta| (theta, decibel(sampled.sensitivity(theta))))
        .collect();
    let picture = || draw_sensitivity(&curve, &resolved);
    let names = ["theta", "magnitude_db"];
    let files = outputs.table_and_picture(&names, curve.iter(), picture);
    let points = curve.iter();
    let points = points.map(|(theta, gain)| json!({"theta": theta, "magnitude_db": gain}));
    let found = json!({
        "peak_db": decibel(peak.value),
        "theta_at_peak": peak.theta,
        "points": points.collect::<Vec<_>>(),
        "files": files,
    });
    resolved.report(json!({}), found, output)?;
    outputs.close(Ok(()))
}

fn draw_sensitivity(curve: &[(f64, f64)], resolved: &ResolvedLoop) -> Result<Picture, FigureError> {
    let panel = Panel::new("", axis("digital frequency θ / rad"), linear("|S| / dB"));
    let panel = panel.with("|1/(1 + GH)|", Look::Line, 0, curve.iter().copied());
    page("Sensitivity", &resolved.words(true), 1, &[panel])
}
