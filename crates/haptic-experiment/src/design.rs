//! The designer's question: what is the most that a device can render, and with which order μ?
//!
//! For each order of a grid the best wall under a requirement is computed, not searched by trying:
//!
//! ```text
//! stable    (gα, gβ) on the boundary of the stability region, so that the wall as a whole may grow by
//!           the gain margin g before it is unstable, or shrink by it; the region by D-decomposition
//! passive   δ > sup_θ (α·u + β·v), Theorem 1 for the operator really used. The right side grows in
//!           proportion to the wall, so α = δ/sup(u + t·v) for a given t = β/α, and that sup is convex
//!           in t: its minimum by golden sections gives the largest α, and the same with roles
//!           exchanged the largest β
//! ```
//! - *Stiffest wall*: the largest α, with the β that allows it.
//! - *Most damping* at ω: the largest β, since the effective damping Im H/ω grows with B alone. The
//!   very largest β leaves no choice of α, and at α = 0 the device creeps away. So β is 99 % of it, and
//!   α is in the middle of what that leaves.
//! - *Tissue*: K, B and μ are given by tissue and specimen; the question is by which factor the
//!   specimen may grow. For other orders K is the same, and B makes |B·s^μ| the same at a frequency.
//!
//! - *Noise*: steps q of the encoder make a noise of the force, rms B·(q/√12)·T^(−μ)·√Σc², c the weights
//!   of the operator. A limit on it is a limit on B.
//! - *The device* is the one on the desk: delay and current lag are in the analysis, friction and encoder in
//!   the trial. If none is given an ideal device is assumed, and the trial on a realistic one stands beside.
//!
//! A wall "on the boundary" is made a ten-thousandth weaker, because Theorem 1 is strict.

mod beside;
mod candidate;
pub mod coupler;
mod noise;
mod passive;
mod stable;
mod trial;

use crate::failure::Failure;
use crate::modelled::ModelledTissue;
use crate::{Imperfections, Sensors, dynamics};
pub use beside::RealisticTrial;
use candidate::Point;
pub use candidate::{Candidate, DesignReport, TissueVerdict};
use fracdiff::{Order, Scheme};
use haptic_analysis::{
    AnalysisError, Dynamics, Environment, LoopOperator, OnePort, SampledLoop, SampledPlant,
};
use haptic_loop::Specimen;
use haptic_loop::plant::MassDamperConfig;
use rayon::prelude::*;
use std::f64::consts::PI;

/// Memory for which a full-memory operator is designed, samples: 1000 s at 1 kHz.
const HORIZON: f64 = 1e6;
/// Share of the largest wall that is taken.
const INSIDE: f64 = 1.0 - 1e-4;
/// A candidate must be better by this share to win over one of lower order.
const BETTER: f64 = 1e-6;

/// A device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Device {
    /// Mass, damping, hand and sample time; delay, current lag and friction.
    pub plant: MassDamperConfig,
    /// Its encoder.
    pub sensors: Sensors,
    /// Largest force, N.
    pub force_limit_n: f64,
}

/// What a wall must be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Requirement {
    /// Passive by Theorem 1, for the operator really used.
    Passive,
    /// Stable, also when it is stiffer and more dissipative by a factor.
    Stable {
        /// The factor, above 1.
        gain_margin: f64,
    },
}

/// What is wanted most.
#[derive(Clone, Debug, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "there is one of them in a run")]
pub enum Wish {
    /// The largest K.
    StiffestWall,
    /// The largest effective damping of the wall at a frequency.
    MostDamping {
        /// Hz.
        frequency_hz: f64,
    },
    /// A specimen of a tissue.
    Tissue {
        /// The tissue.
        material: ModelledTissue,
        /// The piece of it.
        specimen: Specimen,
        /// Where other orders are made equal to it, Hz.
        frequency_hz: f64,
    },
}

/// A question of a designer.
#[derive(Clone, Debug)]
pub struct Design {
    /// On which device.
    pub device: Device,
    /// With which operator.
    pub scheme: Scheme,
    /// Orders to try.
    pub orders: Vec<Order>,
    /// Under which requirement.
    pub requirement: Requirement,
    /// What for.
    pub wish: Wish,
    /// Largest noise of the force that encoder and sensor noise may make, rms N; `None` for any.
    pub force_noise_limit_n: Option<f64>,
}

/// One order on the device: everything that an analysis needs.
struct Bench<'a> {
    design: &'a Design,
    order: Order,
    operator: LoopOperator,
    dynamics: Dynamics,
    plant: SampledPlant,
    delta: f64,
    /// Noise of the force for β = 1, rms N.
    noise_unit_n: f64,
}

impl Device {
    /// m/T², N/m of α = 1.
    fn stiffness_unit(&self) -> f64 {
        let t = self.plant.sample_time.0;
        self.plant.mass.0 / (t * t)
    }

    /// m/T^(2−μ), N·s^μ/m of β = 1.
    fn dissipation_unit(&self, order: Order) -> f64 {
        self.plant.mass.0 / self.plant.sample_time.0.powf(2.0 - order.get())
    }

    /// What the analysis knows of it.
    fn dynamics(&self) -> Dynamics {
        dynamics(&self.plant)
    }

    /// What is less than ideal about it.
    #[must_use]
    pub fn imperfections(&self) -> Imperfections {
        Imperfections {
            friction_n: self.plant.friction.0,
            delay_s: self.plant.delay.0,
            current_lag_s: self.plant.lag.0,
            sensors: self.sensors,
        }
    }
}

impl Design {
    /// Answers it; `progress` hears of each order that is done.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn answer(&self, progress: &(dyn Fn(u64) + Sync)) -> Result<DesignReport, Failure> {
        self.check()?;
        let candidates = self
            .orders_to_try()
            .par_iter()
            .map(|&order| {
                let candidate = self.candidate(order);
                progress(1);
                candidate
            })
            .collect::<Result<Vec<_>, _>>()?;
        let best = self.best(&candidates).cloned();
        let trial = best.as_ref().map(|best| self.trial(best)).transpose()?;
        let imperfections = self.device.imperfections();
        let realistic = match &best {
            Some(best) if imperfections.is_ideal() => Some(self.beside(best)?),
            _ => None,
        };
        Ok(DesignReport {
            notes: self.notes(&candidates, best.as_ref()),
            tissue: self.tissue_verdict(&candidates),
            wish: self.wish.name().to_owned(),
            require: self.requirement.name().to_owned(),
            gain_margin: self.requirement.gain_margin(),
            frequency_hz: self.wish.frequency_hz(),
            scheme: self.scheme.to_string(),
            force_noise_limit_n: self.force_noise_limit_n,
            ideal_device_assumed: imperfections.is_ideal(),
            imperfections,
            realistic,
            candidates,
            best,
            simulated: trial.as_ref().map(|(_, settling)| *settling),
            experiment_text: trial.map(|(wall, _)| self.experiment_file(&wall)),
            experiment: None,
            files: Vec::new(),
        })
    }

    /// The tissue's own order, then those of the grid.
    #[must_use]
    pub fn orders_to_try(&self) -> Vec<Order> {
        let mut orders = self.orders.clone();
        if let Wish::Tissue { material, .. } = &self.wish {
            let own = material.tissue().order();
            orders.retain(|order| *order != own);
            orders.insert(0, own);
        }
        orders
    }

    fn check(&self) -> Result<(), Failure> {
        let device = &self.device;
        let plant = device.dynamics().plant(device.plant.sample_time.0);
        plant.map_err(Failure::input)?;
        if self.scheme == Scheme::Exact {
            return Err(Failure::input(fracdiff::SchemeError::AnalysisOnly));
        }
        if self.orders.is_empty() {
            return Err(Failure::bad_input(
                "no order was given: give `orders`, as in 0, 0.5, 1",
            ));
        }
        if let Some(order) = self.orders.iter().find(|order| order.get() < 0.0) {
            return Err(Failure::bad_input(format_args!(
                "order {order} is not in [0, 2]: a wall has no integral; change `orders`"
            )));
        }
        if !(device.force_limit_n > 0.0 && device.force_limit_n.is_finite()) {
            return Err(Failure::bad_input(format_args!(
                "force limit {} N is not above 0 N: give `force_limit_n`, as in 10",
                device.force_limit_n
            )));
        }
        if let Requirement::Stable { gain_margin } = self.requirement
            && !(gain_margin > 1.0 && gain_margin <= 1e3)
        {
            return Err(Failure::bad_input(format_args!(
                "gain margin {gain_margin} is not in (1, 1000]: give `gain_margin`, as in 2"
            )));
        }
        if let Some(limit) = self.force_noise_limit_n {
            if !(limit > 0.0 && limit.is_finite()) {
                return Err(Failure::bad_input(format_args!(
                    "limit {limit} N of the force noise is not above 0 N: 0.01 N is felt by few"
                )));
            }
            if self.device.sensors.are_ideal() {
                return Err(Failure::bad_input(format_args!(
                    "limit {limit} N of the force noise needs an encoder or sensor noise that makes some: give \
                     its resolution, as in 1um"
                )));
            }
        }
        let highest = 0.5 / device.plant.sample_time.0;
        match self.wish.frequency_hz() {
            Some(f) if !(f > 0.0 && f <= highest) => Err(Failure::bad_input(format_args!(
                "frequency {f} Hz is not in (0, {highest}] Hz, up to half the sample rate: give `frequency_hz`"
            ))),
            _ => Ok(()),
        }
    }

    /// One order on the device.
    fn bench(&self, order: Order) -> Result<Bench<'_>, Failure> {
        let device = &self.device;
        let t = device.plant.sample_time;
        let dynamics = device.dynamics();
        let operator = LoopOperator::new(self.scheme, order, t, HORIZON).map_err(Failure::input)?;
        let noise_m = device.imperfections().position_noise_m();
        let noise_n = noise_m * noise::amplification(self.scheme, order, t)?;
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

    /// The best wall of one order, or why there is none.
    fn candidate(&self, order: Order) -> Result<Candidate, Failure> {
        let bench = self.bench(order)?;
        let found = match (&self.wish, self.requirement) {
            (Wish::Tissue { .. }, _) => bench.tissue(),
            (_, Requirement::Passive) => bench.passive_wall(),
            (_, Requirement::Stable { gain_margin }) => bench.stable_wall(gain_margin),
        };
        match found.and_then(|point| bench.judged(point)) {
            Ok(candidate) => Ok(candidate),
            // An order that cannot be analysed does not spoil the others.
            Err(error) => Ok(Candidate::none(order, error.to_string())),
        }
    }

    /// What the wish measures of a candidate.
    fn merit(&self, candidate: &Candidate) -> Option<f64> {
        candidate.stiffness?;
        match &self.wish {
            Wish::StiffestWall => candidate.stiffness,
            Wish::MostDamping { .. } => candidate.effective_damping_n_s_per_m,
            Wish::Tissue { material, .. } => candidate
                .largest_scale
                .filter(|scale| *scale >= 1.0)
                .map(|_| -(candidate.order - material.order).abs()),
        }
    }

    fn best<'c>(&self, candidates: &'c [Candidate]) -> Option<&'c Candidate> {
        let mut best: Option<(f64, &Candidate)> = None;
        for candidate in candidates {
            if let Some(merit) = self.merit(candidate)
                && best.is_none_or(|(most, _)| merit > most + BETTER * most.abs())
            {
                best = Some((merit, candidate));
            }
        }
        best.map(|(_, candidate)| candidate)
    }

    fn tissue_verdict(&self, candidates: &[Candidate]) -> Option<TissueVerdict> {
        let Wish::Tissue { material, .. } = &self.wish else {
            return None;
        };
        let own = candidates.first()?;
        Some(TissueVerdict {
            name: material.name.clone(),
            order: own.order,
            fits: own.largest_scale.is_some_and(|scale| scale >= 1.0),
            largest_scale: own.largest_scale,
        })
    }

    /// What a designer should know beside the numbers.
    fn notes(&self, candidates: &[Candidate], best: Option<&Candidate>) -> Vec<String> {
        let mut notes = Vec::new();
        let passive = self.requirement == Requirement::Passive;
        let acts_at_once = self.device.plant.delay.0 + self.device.plant.lag.0 <= 0.0;
        if best.is_none() {
            let mut reasons = candidates
                .iter()
                .filter_map(|candidate| candidate.reason.clone());
            let first = reasons.next().unwrap_or_default();
            notes.push(format!("nothing on the grid does it: {first}"));
        } else if passive && self.wish == Wish::StiffestWall && acts_at_once {
            notes.push(
                "without delay no dissipation makes a passive wall stiffer: K is 2b/T for every order, \
                 and the order is free for something else"
                    .to_owned(),
            );
        }
        notes
    }
}

impl Requirement {
    fn name(self) -> &'static str {
        match self {
            Self::Passive => "passive",
            Self::Stable { .. } => "stable",
        }
    }

    /// Of the stable one.
    #[must_use]
    pub fn gain_margin(self) -> Option<f64> {
        match self {
            Self::Passive => None,
            Self::Stable { gain_margin } => Some(gain_margin),
        }
    }
}

impl Wish {
    fn name(&self) -> &'static str {
        match self {
            Self::StiffestWall => "stiffest-wall",
            Self::MostDamping { .. } => "most-damping",
            Self::Tissue { .. } => "tissue",
        }
    }

    fn frequency_hz(&self) -> Option<f64> {
        match self {
            Self::StiffestWall => None,
            Self::MostDamping { frequency_hz } | Self::Tissue { frequency_hz, .. } => {
                Some(*frequency_hz)
            }
        }
    }
}

impl Bench<'_> {
    /// The loop with this wall; held, where there is no spring at all and the device only drifts.
    fn closed(&self, alpha: f64, beta: f64) -> Result<SampledLoop<'_>, AnalysisError> {
        SampledLoop::with_plant(self.plant, alpha, beta, &self.operator).map(SampledLoop::held)
    }

    fn port(&self) -> Result<OnePort<'_, LoopOperator>, AnalysisError> {
        let t = self.design.device.plant.sample_time.0;
        self.dynamics.port(t, &self.operator)
    }

    /// The largest β whose force noise is within the limit.
    fn quiet_beta(&self) -> f64 {
        let limit = self.design.force_noise_limit_n;
        limit.map_or(f64::INFINITY, |limit| limit / self.noise_unit_n)
    }

    /// K, B and the specimen's scale of the wished tissue at this order.
    fn tissue(&self) -> Result<Point, AnalysisError> {
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
        // |B'·(jω)^μ| = |B·(jω)^α|
        let change = (2.0 * PI * frequency_hz).powf(material.order - self.order.get());
        let alpha = shape * material.elastic_modulus_pa / device.stiffness_unit();
        let beta =
            shape * material.viscosity_pa_s_alpha * change / device.dissipation_unit(self.order);
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

    /// Whether a wall is stable, and the factor that takes it to the edge.
    fn stable_and_margin(
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
    fn judged(&self, point: Point) -> Result<Candidate, AnalysisError> {
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
    fn nothing(&self) -> String {
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
