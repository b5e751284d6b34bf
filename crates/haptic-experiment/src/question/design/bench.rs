//! One order on the device: everything that an analysis needs.

use super::candidate::{Candidate, Point};
use super::noise;
use super::question::{Design, Requirement, Wish};
use crate::document::failure::Failure;
use crate::judge::modelled_tissue::loop_operator;
use fracdiff::Order;
use haptic_analysis::{
    AnalysisError, Dynamics, Environment, LoopOperator, OnePort, SampledLoop, SampledPlant,
};
use std::f64::consts::PI;

/// Memory for which a full-memory operator is designed, samples: 1000 s at 1 kHz.
const HORIZON: f64 = 1e6;

/// Share of the largest wall that is taken.
pub(super) const INSIDE: f64 = 1.0 - 1e-4;

/// One order on the device: everything that an analysis needs.
pub(super) struct Bench<'a> {
    pub(super) design: &'a Design,
    pub(super) order: Order,
    pub(super) operator: LoopOperator,
    pub(super) dynamics: Dynamics,
    pub(super) plant: SampledPlant,
    pub(super) delta: f64,
    /// Noise of the force for β = 1, rms N.
    pub(super) noise_unit_n: f64,
}

impl Design {
    /// One order on the device.
    pub(super) fn bench(&self, order: Order) -> Result<Bench<'_>, Failure> {
        let device = &self.device;
        let t = device.plant.sample_time;
        let dynamics = device.dynamics();
        let model = self.model(order);
        let operator = loop_operator(model, self.scheme, order, t, HORIZON)?;
        let noise_m = device.imperfections().position_noise_m();
        let noise_n = noise_m * noise::amplification(model, self.scheme, order, t)?;
        Ok(Bench {
            design: self,
            order,
            operator,
            dynamics,
            plant: dynamics.plant(t.0).map_err(Failure::input)?,
            delta: dynamics.damping_n_s_per_m * t.0 / dynamics.mass_kg,
            noise_unit_n: noise_n * device.dissipation_unit(order),
        })
    }
}

impl Bench<'_> {
    /// The loop with this wall; where there is no spring at all the device only drifts.
    pub(super) fn closed(&self, alpha: f64, beta: f64) -> Result<SampledLoop<'_>, AnalysisError> {
        SampledLoop::with_plant(self.plant, alpha, beta, &self.operator)
            .map(SampledLoop::beside_rest)
    }

    pub(super) fn port(&self) -> Result<OnePort<'_, LoopOperator>, AnalysisError> {
        let t = self.design.device.plant.sample_time.0;
        self.dynamics.port(t, &self.operator)
    }

    /// The largest β whose force noise is within the limit.
    pub(super) fn quiet_beta(&self) -> f64 {
        let limit = self.design.force_noise_limit_n;
        limit.map_or(f64::INFINITY, |limit| limit / self.noise_unit_n)
    }

    /// K, B and the specimen's scale of the wished tissue at this order.
    pub(super) fn tissue(&self) -> Result<Point, AnalysisError> {
        let Wish::Tissue {
            material,
            specimen,
            frequency_hz,
        } = &self.design.wish
        else {
            return Ok(Point::None(String::new()));
        };
        let device = &self.design.device;
        let shape = specimen.area().0 / specimen.thickness().0;
        let alpha = shape * material.rest_modulus_pa() / device.stiffness_unit();
        let dissipation = material.dissipation_at(shape, self.order, 2.0 * PI * frequency_hz);
        let beta = dissipation / device.dissipation_unit(self.order);
        let scale = match self.design.requirement {
            Requirement::Passive => self.largest_passive_scale(alpha, beta)?,
            Requirement::Stable { gain_margin } => self
                .largest_stable_scale(alpha, beta)?
                .map(|scale| scale / gain_margin),
        };
        let scale = scale.map(|scale| scale.min(self.quiet_beta() / beta));
        Ok(match scale {
            Some(scale) => Point::Wall {
                alpha,
                beta,
                scale: Some(scale * INSIDE),
            },
            None => Point::None(self.nothing()),
        })
    }

    /// Stability of a wall, and the factor that takes it to the edge.
    pub(super) fn stable_and_margin(
        &self,
        alpha: f64,
        beta: f64,
    ) -> Result<(bool, Option<f64>), AnalysisError> {
        let closed = self.closed(alpha, beta)?;
        if closed.is_stable() {
            return Ok((true, closed.margins()?.gain_up.map(|gain| gain.value)));
        }
        Ok((false, self.largest_stable_scale(alpha, beta)?))
    }

    /// Margin, passivity and units of a wall.
    pub(super) fn judged(&self, point: Point) -> Result<Candidate, AnalysisError> {
        let (alpha, beta, scale) = match point {
            Point::None(reason) => return Ok(Candidate::none(self.order, reason)),
            Point::Wall { alpha, beta, scale } => (alpha, beta, scale),
        };
        let device = &self.design.device;
        let (_, margin) = self.stable_and_margin(alpha, beta)?;
        let noisy = !device.sensors.are_ideal();
        let (stiffness, dissipation) = (
            alpha * device.stiffness_unit(),
            beta * device.dissipation_unit(self.order),
        );
        let required = self.port()?.required_delta(alpha, beta)?;
        let environment = Environment {
            stiffness_n_per_m: stiffness,
            dissipation_n_s_mu_per_m: dissipation,
            order: self.order,
            sample_time_s: device.plant.sample_time.0,
        };
        let effective = self
            .design
            .wish
            .frequency_hz()
            .map(|frequency| environment.effective(&self.operator, 2.0 * PI * frequency));
        let reason = scale
            .filter(|scale| *scale < 1.0)
            .map(|scale| format!("the specimen is too large for it: {scale:.4} of it would do"));
        Ok(Candidate {
            order: self.order.get(),
            stiffness: Some(stiffness),
            dissipation: Some(dissipation),
            margin,
            alpha: Some(alpha),
            beta: Some(beta),
            passive: Some(required.passive(self.delta)),
            required_damping_n_s_per_m: Some(
                required.delta * device.plant.mass.0 / device.plant.sample_time.0,
            ),
            effective_damping_n_s_per_m: effective
                .transpose()?
                .map(|effective| effective.damping_n_s_per_m),
            force_noise_rms_n: noisy.then_some(beta * self.noise_unit_n),
            largest_scale: scale,
            reason,
        })
    }

    /// Why there is no wall at all.
    pub(super) fn nothing(&self) -> String {
        match self.design.requirement {
            Requirement::Passive if self.delta <= 0.0 => {
                "no passive wall of this order on this device: it has no damping".to_owned()
            }
            Requirement::Passive => "no passive wall of this order on this device".to_owned(),
            Requirement::Stable { gain_margin } => format!(
                "no wall of this order is stable on this device with a gain margin of {gain_margin}"
            ),
        }
    }
}
