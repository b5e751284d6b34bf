//! A wall among all walls of its device, and over the frequency: what a page draws anew while a slider moves.

use crate::analysis::answer::{HORIZON, logarithmic};
use crate::analysis::keys::{ANALYSED_CONTROLLER, ANALYSED_MASS, ANALYSED_TISSUE};
use crate::analysis::wall::{WallLoop, WithUnits, missing};
use fracdiff::{Scheme, Seconds};
use haptic_analysis::{AnalysisError, ClosedLoop, Largest, NoiseGain, OutlinePoint};
use haptic_document::Failure;
use haptic_quantity::written;
use serde_json::{Value, json};
use std::f64::consts::PI;

/// Steps of B along the edge of the passive walls.
const STEPS: usize = 20;
/// Frequencies of the curves, from the lowest, Hz, up to the one that two samples make.
const FREQUENCIES: usize = 120;
const LOWEST_HZ: f64 = 0.1;

/// B in N·s^μ/m and K in N/m.
type Point = [f32; 2];

impl WallLoop {
    /// The wall, judged; the outlines of the stable walls, of so many points about, and of the passive ones; the noise of its force, and its
    /// curves.
    pub(crate) fn map(&self, points: usize, position_noise_m: f64) -> Result<Value, Failure> {
        if self.law.in_place.is_some() {
            let reason =
                format_args!("a map is of walls: omit {ANALYSED_TISSUE} and {ANALYSED_CONTROLLER}");
            return Err(Failure::bad_input(reason));
        }
        let Some(on_device @ WithUnits { device, wall }) = &self.units else {
            return Err(missing(&ANALYSED_MASS));
        };
        let (t, parameters) = (wall.sample_time_s, self.parameters);
        let [k, b] = [wall.stiffness_n_per_m, wall.dissipation_n_s_mu_per_m];
        // Without any spring the device drifts, which is no instability.
        let sampled = self.sampled()?.beside_rest();
        let margins = sampled.is_stable().then(|| sampled.margins()).transpose();
        let margins = margins.map_err(Failure::input)?;
        let proved = sampled.slope_limit().proved;
        let required = self.required_delta()?;
        let required_damping = required.delta * device.mass_kg / t;
        Ok(json!({
            "region": self.stable_walls(points)?,
            "passive_walls": self.passive_walls()?,
            "stable": margins.is_some(),
            "gain_margin": margins.and_then(|m| m.gain_up).map(|gain| gain.value),
            "gain_margin_down": margins.and_then(|m| m.gain_down).map(|gain| gain.value),
            "pulling_contact_margin": (proved > 0.0).then_some(proved),
            "pulling_contact": said_of_pulling_contact(margins.is_some(), proved, [k, b]),
            "delay_margin_s": margins.and_then(|m| m.delay).map(|delay| delay.value * t),
            "sensitivity_peak": margins.map(|m| m.sensitivity.value),
            "sensitivity_peak_hz": margins.map(|m| m.sensitivity.theta / (2.0 * PI * t)),
            "passive": required.passive(parameters.delta),
            "negative_at_rest": required.negative_at_rest,
            "required_damping_n_s_per_m": required_damping,
            "required_damping": written("required_damping_n_s_per_m", required_damping),
            "force_noise_n": position_noise_m * self.noise(t)?.of_wall(k, b),
            "curves": self.curves(on_device).map_err(Failure::input)?,
        }))
    }

    fn point(&self, beta: f64, alpha: f64) -> Point {
        let [k, b] = self.with_units(Some(alpha), Some(beta));
        [b, k].map(|number| number.unwrap_or(f64::NAN) as f32)
    }

    /// Polygons of the stable walls.
    fn stable_walls(&self, points: usize) -> Result<Vec<Vec<Point>>, Failure> {
        let region = self.stable_region(points)?;
        let point = |at: &OutlinePoint| self.point(at.beta, at.alpha);
        let polygons = region.bounded().map_or(&[][..], |area| &area.polygons);
        let outlines = polygons
            .iter()
            .map(|outline| outline.points.iter().map(point));
        Ok(outlines.map(Iterator::collect).collect())
    }

    /// The edge of the passive walls from B = 0 to K = 0; empty if none is passive. The set is convex, so chords lie inside.
    fn passive_walls(&self) -> Result<Vec<Point>, Failure> {
        let (port, delta, mut edge) = (self.port()?, self.parameters.delta, Vec::new());
        let most = port.largest_beta(delta, 0.0);
        if let Largest::Below { value: most, .. } = most.map_err(Failure::input)? {
            for step in 0..STEPS {
                let beta = most * step as f64 / STEPS as f64;
                let largest = port.largest_alpha(delta, beta);
                if let Largest::Below { value: alpha, .. } = largest.map_err(Failure::input)? {
                    edge.push(self.point(beta, alpha));
                }
            }
            edge.push(self.point(most, 0.0));
        }
        Ok(edge)
    }

    fn noise(&self, sample_time_s: f64) -> Result<NoiseGain, Failure> {
        let t = Seconds(sample_time_s);
        if self.law.scheme == Scheme::Exact {
            return NoiseGain::exact(self.law.order, t).map_err(Failure::input);
        }
        let operator = self.law.scheme.build::<f64>(self.law.order, t, HORIZON);
        Ok(NoiseGain::of(operator.map_err(Failure::input)?))
    }

    /// Frequency, effective stiffness and damping of the wall alone, and both as felt through the device.
    fn curves(&self, on_device: &WithUnits) -> Result<Vec<[f64; 5]>, AnalysisError> {
        let WithUnits { device, wall } = on_device;
        let through_device = ClosedLoop {
            mass_kg: device.mass_kg,
            damping_n_s_per_m: device.damping_n_s_per_m,
            environment: *wall,
            path: self.path,
        };
        let nyquist = PI / wall.sample_time_s;
        let omegas = logarithmic(2.0 * PI * LOWEST_HZ, nyquist, FREQUENCIES);
        let point = |omega| {
            let felt = through_device.sampled(&self.law.operator, omega)?;
            let alone = wall.effective(&self.law.operator, omega)?;
            Ok([
                omega / (2.0 * PI),
                alone.stiffness_n_per_m,
                alone.damping_n_s_per_m,
                felt.stiffness_n_per_m,
                felt.damping_n_s_per_m,
            ])
        };
        omegas.map(point).collect()
    }
}

/// Up to which K, or B without a spring, contact that may pull, acts on one side or stiffens is proved stable, whatever the motion.
fn said_of_pulling_contact(stable: bool, proved: f64, [k, b]: [f64; 2]) -> String {
    let limit = if k > 0.0 {
        format!("K = {}", written("proved_stiffness_n_per_m", proved * k))
    } else {
        format!(
            "B = {}",
            written("proved_dissipation_n_s_mu_per_m", proved * b)
        )
    };
    match proved {
        _ if !stable => "unstable".to_owned(),
        proved if proved >= 1.0 => format!("proved up to {limit}"),
        proved if proved > 0.0 => format!("not proved, only up to {limit}"),
        _ => "not proved".to_owned(),
    }
}
