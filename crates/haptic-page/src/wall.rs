//! A wall on a device, judged and drawn: the map, the margins and the curves of *Design* and of *Is it safe?*.

use crate::Number;
use fracdiff::{Order, Scheme, Seconds};
use haptic_analysis::{
    AnalysisError, BoundaryPoint, ClosedLoop, Dynamics, Environment, Largest, LoopOperator,
    NoiseGain, StabilityRegion,
};
use haptic_experiment::Failure;
use haptic_quantity::{short, written};
use serde::Deserialize;
use serde_json::{Value, json};
use std::error::Error;
use std::f64::consts::PI;
use std::fmt::Display;
use std::ops::RangeInclusive;

/// Points on the boundary of the map: few while a slider is dragged, all at rest. Each lies on the boundary, and with 500 a
/// chord leaves it by less than a pixel.
const POINTS: RangeInclusive<usize> = 16..=500;
/// Longest ring buffer that is judged here: its characteristic polynomial has as many roots, and a minute would pass for ten thousand.
const RING_MOST: usize = 300;
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
    /// White noise, rms: an encoder with steps q has q/√12.
    position_noise_m: Number,
    points: usize,
}

/// A scheme that is read, and judged within the time that a person waits for.
pub(crate) fn judged_scheme(text: &str) -> Result<Scheme, Failure> {
    let refused =
        |why: &dyn Display| Failure::bad_input(format_args!("`scheme` = {}: {why}", short(text)));
    let scheme: Scheme = short(text).parse().map_err(|error| refused(&error))?;
    if matches!(scheme, Scheme::Grunwald { length } if length > RING_MOST) {
        return Err(refused(&format_args!(
            "the page judges at most {RING_MOST} samples: use the command line for more"
        )));
    }
    Ok(scheme)
}

/// B in N·s^μ/m and K in N/m.
type Point = [f32; 2];

impl WallQuestion {
    /// All that the panels show of it.
    ///
    /// # Errors
    /// A number outside its range, in the words of the library.
    pub(crate) fn answer(&self) -> Result<Value, Box<dyn Error>> {
        if !POINTS.contains(&self.points) {
            let (least, most, points) = (POINTS.start(), POINTS.end(), self.points);
            let allowed = format!("[{least}, {most}]: {most} are finer than pixels");
            return Err(format!("`points` = {points} is not in {allowed}").into());
        }
        let (order, t) = (Order::new(self.order.0)?, Seconds(self.sample_time_s.0));
        let (k, b) = (self.stiffness_n_per_m.0, self.dissipation_n_s_mu_per_m.0);
        let scheme = judged_scheme(&self.scheme)?;
        let rendered = Rendered {
            dynamics: Dynamics {
                mass_kg: self.mass_kg.0,
                damping_n_s_per_m: self.damping_n_s_per_m.0,
                hand_stiffness_n_per_m: self.hand_stiffness_n_per_m.0,
                delay_s: self.delay_s.0,
                current_lag_s: self.current_lag_s.0,
            },
            wall: Environment {
                stiffness_n_per_m: k,
                dissipation_n_s_mu_per_m: b,
                order,
                sample_time_s: t.0,
            },
            operator: LoopOperator::new(scheme, order, t, HORIZON)?,
        };
        let (dynamics, operator) = (&rendered.dynamics, &rendered.operator);
        // Without any spring the device drifts, which is no instability.
        let closed = dynamics.closed(&rendered.wall, operator)?.beside_rest();
        let margins = closed.is_stable().then(|| closed.margins()).transpose()?;
        let proved = closed.slope_limit().proved;
        let required = dynamics.port(t.0, operator)?.required_damping(t, k, b)?;
        let noise = if scheme == Scheme::Exact {
            NoiseGain::exact(order, t)?
        } else {
            NoiseGain::of(scheme.build::<f64>(order, t, HORIZON)?)
        };
        Ok(json!({
            "region": rendered.region(self.points)?,
            "passive_walls": rendered.passive_walls()?,
            "stable": margins.is_some(),
            "gain_margin": margins.and_then(|m| m.gain_up).map(|gain| gain.value),
            "gain_margin_down": margins.and_then(|m| m.gain_down).map(|gain| gain.value),
            "pulling_contact_margin": (proved > 0.0).then_some(proved),
            "pulling_contact": said_of_pulling_contact(margins.is_some(), proved, [k, b]),
            "delay_margin_s": margins.and_then(|m| m.delay).map(|delay| delay.value * t.0),
            "sensitivity_peak": margins.map(|m| m.sensitivity.value),
            "sensitivity_peak_hz": margins.map(|m| m.sensitivity.theta / (2.0 * PI * t.0)),
            "passive": required.passive(dynamics.damping_n_s_per_m),
            "negative_at_rest": required.negative_at_rest,
            "required_damping_n_s_per_m": required.damping_n_s_per_m,
            "required_damping": written("required_damping_n_s_per_m", required.damping_n_s_per_m),
            "force_noise_n": self.position_noise_m.0 * noise.of_wall(k, b),
            "curves": rendered.curves()?,
        }))
    }
}

/// Up to which K, or B without a spring, contact that may pull, acts on one side or stiffens is proved stable, whatever the motion.
fn said_of_pulling_contact(stable: bool, proved: f64, [k, b]: [f64; 2]) -> String {
    let limit = match k > 0.0 {
        true => format!("K = {}", written("proved_stiffness_n_per_m", proved * k)),
        false => format!(
            "B = {}",
            written("proved_dissipation_n_s_mu_per_m", proved * b)
        ),
    };
    match proved {
        _ if !stable => "unstable".to_owned(),
        proved if proved >= 1.0 => format!("proved up to {limit}"),
        proved if proved > 0.0 => format!("not proved, only up to {limit}"),
        _ => "not proved".to_owned(),
    }
}

/// A wall, and all that renders it.
struct Rendered {
    dynamics: Dynamics,
    wall: Environment,
    operator: LoopOperator,
}

impl Rendered {
    /// Polygons of the stable walls.
    fn region(&self, points: usize) -> Result<Vec<Vec<Point>>, AnalysisError> {
        let plant = self.dynamics.plant(self.wall.sample_time_s)?;
        let region = StabilityRegion::new(plant, &self.operator, 0, points)?;
        // α of 1 N/m and β of 1 N·s^μ/m.
        let one = self.dynamics.nondimensional(&Environment {
            stiffness_n_per_m: 1.0,
            dissipation_n_s_mu_per_m: 1.0,
            ..self.wall
        })?;
        let point =
            |at: &BoundaryPoint| [at.beta / one.beta, at.alpha / one.alpha].map(|x| x as f32);
        let polygons = region.bounded().map_or(&[][..], |area| &area.polygons);
        let outlines = polygons
            .iter()
            .map(|outline| outline.points.iter().map(point));
        Ok(outlines.map(Iterator::collect).collect())
    }

    /// The edge of the passive walls from B = 0 to K = 0; empty if none is passive. The set is convex, so chords lie inside.
    fn passive_walls(&self) -> Result<Vec<Point>, AnalysisError> {
        let t = Seconds(self.wall.sample_time_s);
        let (damping, mut edge) = (self.dynamics.damping_n_s_per_m, Vec::new());
        let port = self.dynamics.port(t.0, &self.operator)?;
        if let Largest::Below { value: most, .. } = port.largest_dissipation(t, damping, 0.0)? {
            for step in 0..STEPS {
                let dissipation = most * step as f64 / STEPS as f64;
                let largest = port.largest_stiffness(t, damping, dissipation)?;
                if let Largest::Below { value, .. } = largest {
                    edge.push([dissipation as f32, value as f32]);
                }
            }
            edge.push([most as f32, 0.0]);
        }
        Ok(edge)
    }

    /// Frequency, effective stiffness and damping of the wall alone, and both as felt through the device.
    fn curves(&self) -> Result<Vec<[f64; 5]>, AnalysisError> {
        let t = self.wall.sample_time_s;
        let through_device = ClosedLoop {
            mass_kg: self.dynamics.mass_kg,
            damping_n_s_per_m: self.dynamics.damping_n_s_per_m,
            environment: self.wall,
            path: self.dynamics.path(t)?,
        };
        let ratio = 0.5 / t / LOWEST_HZ;
        let points = (0..FREQUENCIES).map(|n| {
            let hertz = LOWEST_HZ * ratio.powf(n as f64 / (FREQUENCIES - 1) as f64);
            let omega = (2.0 * PI * hertz).min(PI / t);
            let felt = through_device.sampled(&self.operator, omega)?;
            let alone = self.wall.effective(&self.operator, omega)?;
            let [alone, felt] =
                [alone, felt].map(|at| (at.stiffness_n_per_m, at.damping_n_s_per_m));
            Ok([hertz, alone.0, alone.1, felt.0, felt.1])
        });
        points.collect()
    }
}
