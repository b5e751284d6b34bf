//! A wall on a device, judged and drawn: the map, the margins and the curves of *Design* and of *Is it safe?*.

use crate::Number;
use fracdiff::{Order, Scheme, Seconds};
use haptic_analysis::{
    AnalysisError, ClosedLoop, Dynamics, Environment, Largest, LoopOperator, NoiseGain,
    StabilityRegion,
};
use haptic_experiment::Failure;
use serde::Deserialize;
use serde_json::{Value, json};
use std::f64::consts::PI;
use std::ops::RangeInclusive;

/// Points on the boundary of the map: few while a slider is dragged, all at rest. Each lies on the boundary, and with 500 a
/// chord leaves it by less than a pixel.
const POINTS: RangeInclusive<usize> = 16..=500;
/// Memory for which the operator that runs is designed, samples.
const HORIZON: f64 = 1e5;
/// Steps of B along the edge of the passive walls.
const STEPS: usize = 20;
/// Frequencies of the curves, from the lowest, Hz, up to the one that two samples make.
const FREQUENCIES: usize = 120;
const LOWEST_HZ: f64 = 0.1;

/// A wall K + B·D^μ, and the device and operator that render it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct WallQuestion {
    /// As on the command line, `full` or `muir:3`; `exact` stands for any full memory, and is much quicker.
    scheme: String,
    order: Number,
    stiffness_n_per_m: Number,
    dissipation_n_s_mu_per_m: Number,
    mass_kg: Number,
    damping_n_s_per_m: Number,
    hand_stiffness_n_per_m: Number,
    delay_s: Number,
    current_lag_s: Number,
    sample_time_s: Number,
    /// rms of white noise.
    position_noise_m: Number,
    points: usize,
}

/// B, K.
type Point = [f32; 2];

pub(crate) fn judged(wall: &WallQuestion) -> Result<Value, Failure> {
    if !POINTS.contains(&wall.points) {
        let (least, most) = (POINTS.start(), POINTS.end());
        return Err(Failure::bad_input(format_args!(
            "`points` = {} is not in [{least}, {most}]: {most} are finer than pixels",
            wall.points
        )));
    }
    wall.judged().map_err(Failure::bad_input)
}

impl WallQuestion {
    fn judged(&self) -> Result<Value, Box<dyn std::error::Error>> {
        let (order, t) = (Order::new(self.order.0)?, self.sample_time_s.0);
        let (k, b) = (self.stiffness_n_per_m.0, self.dissipation_n_s_mu_per_m.0);
        let scheme: Scheme = self.scheme.parse()?;
        let operator = LoopOperator::new(scheme, order, Seconds(t), HORIZON)?;
        let dynamics = Dynamics {
            mass_kg: self.mass_kg.0,
            damping_n_s_per_m: self.damping_n_s_per_m.0,
            hand_stiffness_n_per_m: self.hand_stiffness_n_per_m.0,
            delay_s: self.delay_s.0,
            current_lag_s: self.current_lag_s.0,
        };
        let wall = Environment {
            stiffness_n_per_m: k,
            dissipation_n_s_mu_per_m: b,
            order,
            sample_time_s: t,
        };
        // Without any spring the device drifts, which is no instability.
        let closed = dynamics.closed(&wall, &operator)?.beside_rest();
        let margins = closed.is_stable().then(|| closed.margins()).transpose()?;
        let proved = closed.slope_limit().proved;
        let port = dynamics.port(t, &operator)?;
        let required = port.required_damping(Seconds(t), k, b)?;
        let noise = if scheme == Scheme::Exact {
            NoiseGain::exact(order, Seconds(t))?
        } else {
            NoiseGain::of(scheme.build::<f64>(order, Seconds(t), HORIZON)?)
        };
        let curves = curves(&dynamics, &wall, &operator)?;
        let curve = |part: usize| curves.iter().map(|at| at[part]).collect::<Vec<_>>();
        Ok(json!({
            "region": region(&dynamics, &wall, &operator, self.points)?,
            "passive_walls": passive_walls(&dynamics, t, &operator)?,
            "stable": margins.is_some(),
            "gain_margin": margins.and_then(|m| m.gain_up).map(|gain| gain.value),
            "gain_margin_down": margins.and_then(|m| m.gain_down).map(|gain| gain.value),
            "every_motion_margin": (proved > 0.0).then_some(proved),
            "delay_margin_s": margins.and_then(|m| m.delay).map(|delay| delay.value * t),
            "sensitivity_peak": margins.map(|m| m.sensitivity.value),
            "sensitivity_peak_hz": margins.map(|m| m.sensitivity.theta / (2.0 * PI * t)),
            "passive": required.passive(dynamics.damping_n_s_per_m),
            "negative_at_rest": required.negative_at_rest,
            "required_damping_n_s_per_m": required.damping_n_s_per_m,
            "force_noise_n": self.position_noise_m.0 * noise.of_wall(k, b),
            "frequency_hz": curve(0),
            "stiffness_n_per_m": curve(1),
            "damping_n_s_per_m": curve(2),
            "felt_stiffness_n_per_m": curve(3),
            "felt_damping_n_s_per_m": curve(4),
        }))
    }
}

/// Polygons of the stable walls.
fn region(
    dynamics: &Dynamics,
    wall: &Environment,
    operator: &LoopOperator,
    points: usize,
) -> Result<Vec<Vec<Point>>, AnalysisError> {
    let region = StabilityRegion::new(dynamics.plant(wall.sample_time_s)?, operator, 0, points)?;
    // α of 1 N/m and β of 1 N·s^μ/m.
    let one = dynamics.nondimensional(&Environment {
        stiffness_n_per_m: 1.0,
        dissipation_n_s_mu_per_m: 1.0,
        ..*wall
    })?;
    let polygons = region.bounded().map_or(&[][..], |area| &area.polygons);
    let outline = polygons.iter().map(|polygon| {
        let points = polygon.points.iter();
        let point = points.map(|at| [at.beta / one.beta, at.alpha / one.alpha].map(|x| x as f32));
        point.collect()
    });
    Ok(outline.collect())
}

/// The edge of the passive walls from B = 0 to K = 0; empty if none is passive. The set is convex, so chords lie inside.
fn passive_walls(
    dynamics: &Dynamics,
    sample_time_s: f64,
    operator: &LoopOperator,
) -> Result<Vec<Point>, AnalysisError> {
    let (t, damping) = (Seconds(sample_time_s), dynamics.damping_n_s_per_m);
    let port = dynamics.port(sample_time_s, operator)?;
    let Largest::Below { value: most, .. } = port.largest_dissipation(t, damping, 0.0)? else {
        return Ok(Vec::new());
    };
    let mut edge = Vec::new();
    for step in 0..STEPS {
        let dissipation = most * step as f64 / STEPS as f64;
        if let Largest::Below { value, .. } = port.largest_stiffness(t, damping, dissipation)? {
            edge.push([dissipation as f32, value as f32]);
        }
    }
    edge.push([most as f32, 0.0]);
    Ok(edge)
}

/// Frequency, effective stiffness and damping of the wall alone, and both as felt through the device.
fn curves(
    dynamics: &Dynamics,
    wall: &Environment,
    operator: &LoopOperator,
) -> Result<Vec<[f64; 5]>, AnalysisError> {
    let t = wall.sample_time_s;
    let through_device = ClosedLoop {
        mass_kg: dynamics.mass_kg,
        damping_n_s_per_m: dynamics.damping_n_s_per_m,
        environment: *wall,
        path: dynamics.path(t)?,
    };
    let ratio = 0.5 / t / LOWEST_HZ;
    (0..FREQUENCIES)
        .map(|n| {
            let hertz = LOWEST_HZ * ratio.powf(n as f64 / (FREQUENCIES - 1) as f64);
            let omega = (2.0 * PI * hertz).min(PI / t);
            let alone = wall.effective(operator, omega)?;
            let felt = through_device.sampled(operator, omega)?;
            Ok([
                hertz,
                alone.stiffness_n_per_m,
                alone.damping_n_s_per_m,
                felt.stiffness_n_per_m,
                felt.damping_n_s_per_m,
            ])
        })
        .collect()
}
