//! One device with one operator: region, passive walls, effective stiffness and damping.

use crate::judgement::Judgement;
use crate::passive::passive_walls;
use fracdiff::{Order, Scheme, Seconds};
use haptic_analysis::{
    ClosedLoop, Dynamics, Environment, LoopOperator, NoiseGain, Nondimensional, StabilityRegion,
};
use std::fmt::Display;
use wasm_bindgen::prelude::*;

/// Points on the boundary of the stability region.
const POINTS: usize = 400;
/// Memory for which the operator that runs is designed, samples.
const HORIZON: f64 = 1e5;

/// The device and its sample time, SI units.
#[wasm_bindgen]
#[derive(Clone, Copy, Debug)]
pub struct Device {
    /// m, kg.
    pub mass_kg: f64,
    /// b, N·s/m.
    pub damping_n_s_per_m: f64,
    /// k of the hand, N/m.
    pub hand_stiffness_n_per_m: f64,
    /// From a measurement to the force that answers it, s.
    pub delay_s: f64,
    /// Time constant of the motor current, s.
    pub current_lag_s: f64,
    /// T, s.
    pub sample_time_s: f64,
}

#[wasm_bindgen]
impl Device {
    /// All of it.
    #[wasm_bindgen(constructor)]
    pub fn new(
        mass_kg: f64,
        damping_n_s_per_m: f64,
        hand_stiffness_n_per_m: f64,
        delay_s: f64,
        current_lag_s: f64,
        sample_time_s: f64,
    ) -> Self {
        Self {
            mass_kg,
            damping_n_s_per_m,
            hand_stiffness_n_per_m,
            delay_s,
            current_lag_s,
            sample_time_s,
        }
    }
}

/// A device, an order and an operator: all that does not depend on the wall.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Bench {
    device: Device,
    dynamics: Dynamics,
    order: Order,
    operator: LoopOperator,
    /// Stability region, flat.
    region: Vec<f64>,
    /// Passive walls, flat.
    passive: Vec<f64>,
    noise_gain: NoiseGain,
}

/// An error of the libraries, as the page shows it.
pub(crate) fn refused(error: impl Display) -> JsError {
    JsError::new(&error.to_string())
}

#[wasm_bindgen]
impl Bench {
    /// `scheme` by its name on the command line, as `full` or `muir:3`; `exact` stands for any full memory, and
    /// is much quicker.
    ///
    /// # Errors
    /// A parameter outside its range: the message of the library.
    #[wasm_bindgen(constructor)]
    pub fn new(scheme: &str, order: f64, device: &Device) -> Result<Self, JsError> {
        Self::prepare(scheme, order, device).map_err(refused)
    }

    fn prepare(
        scheme: &str,
        order: f64,
        device: &Device,
    ) -> Result<Self, Box<dyn std::error::Error>> {
        let scheme: Scheme = scheme.parse()?;
        let order = Order::new(order)?;
        let t = device.sample_time_s;
        let dynamics = Dynamics {
            mass_kg: device.mass_kg,
            damping_n_s_per_m: device.damping_n_s_per_m,
            hand_stiffness_n_per_m: device.hand_stiffness_n_per_m,
            delay_s: device.delay_s,
            current_lag_s: device.current_lag_s,
        };
        let operator = LoopOperator::new(scheme, order, Seconds(t), HORIZON)?;
        let region = StabilityRegion::new(dynamics.plant(t)?, &operator, 0, POINTS)?;
        let noise_gain = match scheme {
            Scheme::Exact => NoiseGain::exact(order, Seconds(t))?,
            _ => NoiseGain::of(scheme.build::<f64>(order, Seconds(t), HORIZON)?),
        };
        let mut bench = Self {
            device: *device,
            dynamics,
            order,
            region: Vec::new(),
            passive: Vec::new(),
            noise_gain,
            operator,
        };
        bench.region = bench.outline(&region)?;
        bench.passive = passive_walls(&bench.dynamics.port(t, &bench.operator)?, t, &dynamics)?;
        Ok(bench)
    }

    /// The stability region: B, K of each corner in order; NaN, NaN ends a polygon.
    #[must_use]
    pub fn region(&self) -> Vec<f64> {
        self.region.clone()
    }

    /// The edge of the passive walls, B, K from B = 0 to K = 0; empty if none is passive.
    #[must_use]
    pub fn passive(&self) -> Vec<f64> {
        self.passive.clone()
    }

    /// Judges a wall. `position_noise_m` is the rms of the position's noise.
    ///
    /// # Errors
    /// K or B outside its range.
    pub fn judge(
        &self,
        stiffness_n_per_m: f64,
        dissipation_n_s_mu_per_m: f64,
        position_noise_m: f64,
    ) -> Result<Judgement, JsError> {
        let wall = self.wall(stiffness_n_per_m, dissipation_n_s_mu_per_m);
        let gain = self.noise_gain.of_wall(stiffness_n_per_m, dissipation_n_s_mu_per_m);
        let noise_n = position_noise_m * gain;
        Judgement::of(&self.dynamics, &wall, &self.operator, noise_n).map_err(refused)
    }

    /// Effective stiffness and damping of the wall alone and as felt through the device: for each ω four
    /// numbers, ES and ED of the wall, ES and ED felt.
    ///
    /// # Errors
    /// K, B or an ω outside its range.
    pub fn effective(
        &self,
        stiffness_n_per_m: f64,
        dissipation_n_s_mu_per_m: f64,
        omega_rad_s: &[f64],
    ) -> Result<Vec<f64>, JsError> {
        let environment = self.wall(stiffness_n_per_m, dissipation_n_s_mu_per_m);
        let path = self.dynamics.path(self.device.sample_time_s);
        let felt = ClosedLoop {
            mass_kg: self.device.mass_kg,
            damping_n_s_per_m: self.device.damping_n_s_per_m,
            environment,
            path: path.map_err(refused)?,
        };
        let mut answer = Vec::with_capacity(4 * omega_rad_s.len());
        for omega in omega_rad_s {
            let alone = environment.effective(&self.operator, *omega);
            for effective in [alone, felt.sampled(&self.operator, *omega)] {
                let effective = effective.map_err(refused)?;
                answer.extend([effective.stiffness_n_per_m, effective.damping_n_s_per_m]);
            }
        }
        Ok(answer)
    }
}

impl Bench {
    fn wall(&self, stiffness_n_per_m: f64, dissipation_n_s_mu_per_m: f64) -> Environment {
        Environment {
            stiffness_n_per_m,
            dissipation_n_s_mu_per_m,
            order: self.order,
            sample_time_s: self.device.sample_time_s,
        }
    }

    /// Polygons of α and β as B and K.
    fn outline(
        &self,
        region: &StabilityRegion,
    ) -> Result<Vec<f64>, haptic_analysis::AnalysisError> {
        // N/m of α = 1 and N·s^μ/m of β = 1.
        let unit = Nondimensional {
            alpha: 1.0,
            beta: 1.0,
            delta: 0.0,
            gamma: 0.0,
        }
        .with_units(self.device.mass_kg, self.device.sample_time_s, self.order)?;
        let mut flat = Vec::new();
        for polygon in region.bounded().map_or(&[][..], |area| &area.polygons) {
            for point in &polygon.points {
                flat.extend([
                    point.beta * unit.dissipation_n_s_mu_per_m,
                    point.alpha * unit.stiffness_n_per_m,
                ]);
            }
            flat.extend([f64::NAN, f64::NAN]);
        }
        Ok(flat)
    }
}
