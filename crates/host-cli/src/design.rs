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
//! A wall "on the boundary" is made a ten-thousandth weaker, because Theorem 1 is strict.

mod candidate;
pub mod coupler;
mod passive;
mod stable;
mod trial;

use crate::failure::Failure;
use crate::material::Material;
use candidate::Point;
pub use candidate::{Candidate, DesignReport, TissueVerdict};
use fracdiff::{Order, Scheme, Seconds};
use haptic_analysis::{
    AnalysisError, Environment, LoopOperator, Nondimensional, OnePort, SampledLoop, SampledPlant,
};
use haptic_loop::Specimen;
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
    /// m, kg.
    pub mass_kg: f64,
    /// b, N·s/m.
    pub damping_n_s_per_m: f64,
    /// k, N/m; 0 without a hand.
    pub hand_stiffness_n_per_m: f64,
    /// T, s.
    pub sample_time_s: f64,
    /// d, from computing a force to its acting, samples.
    pub delay_samples: usize,
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
        material: Material,
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
}

/// One order on the device: everything that an analysis needs.
struct Bench<'a> {
    design: &'a Design,
    order: Order,
    operator: LoopOperator,
    plant: SampledPlant,
    delta: f64,
    gamma: f64,
}

impl Device {
    /// m/T², N/m of α = 1.
    fn stiffness_unit(&self) -> f64 {
        self.mass_kg / (self.sample_time_s * self.sample_time_s)
    }

    /// m/T^(2−μ), N·s^μ/m of β = 1.
    fn dissipation_unit(&self, order: Order) -> f64 {
        self.mass_kg / self.sample_time_s.powf(2.0 - order.get())
    }

    /// The loop without a wall, its parameters checked.
    fn bare(&self) -> Result<Nondimensional, AnalysisError> {
        haptic_analysis::Loop {
            mass_kg: self.mass_kg,
            damping_n_s_per_m: self.damping_n_s_per_m,
            hand_stiffness_n_per_m: self.hand_stiffness_n_per_m,
            sample_time_s: self.sample_time_s,
            order: Order::new(0.0)?,
            stiffness_n_per_m: 0.0,
            dissipation_n_s_mu_per_m: 0.0,
        }
        .nondimensional()
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
        Ok(DesignReport {
            notes: self.notes(&candidates, best.as_ref()),
            tissue: self.tissue_verdict(&candidates),
            wish: self.wish.name().to_owned(),
            require: self.requirement.name().to_owned(),
            gain_margin: self.requirement.gain_margin(),
            frequency_hz: self.wish.frequency_hz(),
            scheme: self.scheme.to_string(),
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
            let own = material.tissue.order();
            orders.retain(|order| *order != own);
            orders.insert(0, own);
        }
        orders
    }

    fn check(&self) -> Result<(), Failure> {
        let device = &self.device;
        let bare = device.bare().map_err(Failure::input)?;
        SampledPlant::new(bare.delta, bare.gamma).map_err(Failure::input)?;
        if self.scheme == Scheme::Exact {
            return Err(Failure::input(fracdiff::SchemeError::AnalysisOnly));
        }
        if self.orders.is_empty() {
            return Err(Failure::bad_input(
                "no order was given: give --orders 0,0.5,1",
            ));
        }
        if let Some(order) = self.orders.iter().find(|order| order.get() < 0.0) {
            return Err(Failure::bad_input(format_args!(
                "order {order} is not in [0, 2]: a wall has no integral; change --orders"
            )));
        }
        if !(device.force_limit_n > 0.0 && device.force_limit_n.is_finite()) {
            return Err(Failure::bad_input(format_args!(
                "force limit {} N is not above 0 N: give --force-limit, as in 10N",
                device.force_limit_n
            )));
        }
        if let Requirement::Stable { gain_margin } = self.requirement
            && !(gain_margin > 1.0 && gain_margin <= 1e3)
        {
            return Err(Failure::bad_input(format_args!(
                "gain margin {gain_margin} is not in (1, 1000]: give --gain-margin, as in 2"
            )));
        }
        let highest = 0.5 / device.sample_time_s;
        match self.wish.frequency_hz() {
            Some(f) if !(f > 0.0 && f <= highest) => Err(Failure::bad_input(format_args!(
                "frequency {f} Hz is not in (0, {highest}] Hz, up to half the sample rate: give --frequency"
            ))),
            _ => Ok(()),
        }
    }

    /// The best wall of one order, or why there is none.
    fn candidate(&self, order: Order) -> Result<Candidate, Failure> {
        let device = &self.device;
        let bare = device.bare().map_err(Failure::input)?;
        let t = Seconds(device.sample_time_s);
        let bench = Bench {
            design: self,
            order,
            operator: LoopOperator::new(self.scheme, order, t, HORIZON).map_err(Failure::input)?,
            plant: SampledPlant::new(bare.delta, bare.gamma).map_err(Failure::input)?,
            delta: bare.delta,
            gamma: bare.gamma,
        };
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
        if best.is_none() {
            let mut reasons = candidates
                .iter()
                .filter_map(|candidate| candidate.reason.clone());
            let first = reasons.next().unwrap_or_default();
            notes.push(format!("nothing on the grid does it: {first}"));
        } else if passive && self.wish == Wish::StiffestWall && self.device.delay_samples == 0 {
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
        let parameters = Nondimensional {
            alpha,
            beta,
            delta: self.delta,
            gamma: self.gamma,
        };
        let delay = self.design.device.delay_samples;
        SampledLoop::new(parameters, &self.operator, delay).map(SampledLoop::held)
    }

    fn port(&self) -> Result<OnePort<'_, LoopOperator>, AnalysisError> {
        // A finite memory is what a response can ripple with.
        let memory = match self.operator.polynomials() {
            Some((numerator, denominator)) if denominator.len() == 1 => numerator.len(),
            _ => 1,
        };
        let port = OnePort::new(&self.operator, self.order)?;
        Ok(port
            .with_delay(self.design.device.delay_samples)?
            .with_memory(memory))
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
        Ok(match scale {
            Some(scale) => Point::Wall {
                alpha,
                beta,
                scale: Some(scale * INSIDE),
            },
            None => Point::None(self.nothing()),
        })
    }

    /// Margin, passivity and units of a wall.
    fn judged(&self, point: Point) -> Result<Candidate, AnalysisError> {
        let (alpha, beta, scale) = match point {
            Point::None(reason) => return Ok(Candidate::none(self.order, reason)),
            Point::Wall { alpha, beta, scale } => (alpha, beta, scale),
        };
        let device = &self.design.device;
        let closed = self.closed(alpha, beta)?;
        let margin = if closed.is_stable() {
            closed.margins()?.gain_up.map(|gain| gain.value)
        } else {
            self.largest_stable_scale(alpha, beta)?
        };
        let (stiffness, dissipation) = (
            alpha * device.stiffness_unit(),
            beta * device.dissipation_unit(self.order),
        );
        let required = self.port()?.required_delta(alpha, beta)?;
        let environment = Environment {
            stiffness_n_per_m: stiffness,
            dissipation_n_s_mu_per_m: dissipation,
            order: self.order,
            sample_time_s: device.sample_time_s,
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
                required.delta * device.mass_kg / device.sample_time_s,
            ),
            effective_damping_n_s_per_m: effective
                .transpose()?
                .map(|effective| effective.damping_n_s_per_m),
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
