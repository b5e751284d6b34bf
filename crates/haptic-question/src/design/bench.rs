//! One order on the device: the best wall under the requirement, and what the analysis says of it.

use crate::bench::{crossings, largest_scales, last, minimum_of, units};
use crate::design::{Candidate, WallDesign, WallWish};
use fracdiff::{Order, Scheme, Seconds};
use haptic_analysis::{
    AnalysisError, Dynamics, Effective, Largest, LoopOperator, NoiseGain, OnePort, RequiredDelta,
    SampledLoop, SampledPlant, SampledWall, StabilityRegion, StableArea,
};
use haptic_document::Failure;
use haptic_judge::modelled_tissue::{loop_operator, operator};
use haptic_quantity::digits;
use haptic_tissue::Model;
use haptic_trial::device_table::dynamics;
use std::f64::consts::PI;

/// Memory for which a full-memory operator is designed, samples: 1000 s at 1 kHz.
const HORIZON: f64 = 1e6;
/// Memory of an operator whose noise is summed, samples: twice the weights.
const NOISE_HORIZON: f64 = 8192.0;
/// Share of the largest wall that is used.
const INSIDE: f64 = 1.0 - 1e-4;
/// Share of the largest β that a passive wall with the most damping has.
const MOST_DAMPING: f64 = 0.99;
/// Golden sections: (0.618)^60 of a quarter turn.
const SECTIONS: usize = 60;
/// Points on the boundary of a region.
const POINTS: usize = 600;
/// Shares of the largest β that are tried for the most damping of a stable wall.
const SHARES: [f64; 6] = [0.99, 0.97, 0.9, 0.8, 0.6, 0.3];
/// Halvings of the way to the edge of the quiet walls.
const HALVINGS_TO_EDGE: u32 = 60;
/// Times that the β of the stiffest quiet passive wall is halved.
const NOISE_HALVINGS: usize = 30;
/// Factor on the gain of a controller up to which stable ones are looked for.
const LARGEST_SCALE: f64 = 1e6;
/// Times that a wall is halved until it is stable.
const HALVINGS: usize = 40;

/// One order on the device.
pub(super) struct Bench<'a> {
    design: &'a WallDesign,
    pub(super) order: Order,
    operator: LoopOperator,
    dynamics: Dynamics,
    plant: SampledPlant,
    delta: f64,
    /// N/m of α = 1 and N·s^μ/m of β = 1.
    units: (f64, f64),
    /// rms of the position's noise, m.
    noise_m: f64,
    /// `None` of a controller that integrates.
    noise: Option<NoiseGain>,
}

/// α, β, and of a tissue the factor by which its specimen may grow.
pub(super) type Wall = (f64, f64, Option<f64>);

/// Noise gain of the operator that runs.
fn noise_gain(
    model: Option<&Model>,
    scheme: Scheme,
    order: Order,
    sample_time: Seconds,
) -> Result<NoiseGain, Failure> {
    let operator = operator::<f64>(model, scheme, order, sample_time, NOISE_HORIZON)?;
    Ok(NoiseGain::of(operator))
}

impl<'a> Bench<'a> {
    pub(super) fn new(design: &'a WallDesign, order: Order) -> Result<Self, Failure> {
        let device = &design.device;
        let t = device.plant.sample_time;
        let dynamics = dynamics(&device.plant);
        let (model, units) = (design.model(order), units(&device.plant, order));
        let (operator, noise) = match design.wish.controller() {
            Some(controller) => (controller.operator.clone(), controller.noise()?),
            None => (
                loop_operator(model, design.scheme, order, t, HORIZON)?,
                Some(noise_gain(model, design.scheme, order, t)?),
            ),
        };
        Ok(Self {
            design,
            order,
            operator,
            dynamics,
            plant: dynamics.plant(t.0).map_err(Failure::input)?,
            delta: dynamics.damping_n_s_per_m * t.0 / dynamics.mass_kg,
            units,
            noise_m: device.sensors.deviation_m(),
            noise,
        })
    }

    /// The best wall, or the reason why no wall meets the wishes.
    pub(super) fn candidate(&self) -> Result<Candidate, AnalysisError> {
        let wall = match (&self.design.wish, self.design.gain_margin) {
            (WallWish::Tissue { .. } | WallWish::Controller(_), _) => self.given()?,
            (_, None) => self.passive_wall()?,
            (_, Some(gain_margin)) => self.stable_wall(gain_margin)?,
        };
        match wall {
            Some(wall) => self.judged(wall),
            None => Ok(Candidate {
                order: Some(self.order.get()),
                reason: Some(self.nothing()),
                ..Candidate::default()
            }),
        }
    }

    /// The loop with this wall; where there is no spring at all the device only drifts.
    fn closed(&self, alpha: f64, beta: f64) -> Result<SampledLoop<'_>, AnalysisError> {
        SampledLoop::with_plant(self.plant, alpha, beta, &self.operator)
            .map(SampledLoop::beside_rest)
    }

    fn port(&self) -> Result<OnePort<'_, LoopOperator>, AnalysisError> {
        let t = self.design.device.plant.sample_time.0;
        self.dynamics.port(t, &self.operator)
    }

    /// True of a controller that pushes on and on at a place that stands.
    fn integrates(&self) -> bool {
        self.noise.is_none()
    }

    /// Noise of the force of a wall, rms N; `None` where an integral makes it endless without the loop.
    pub(super) fn force_noise_n(&self, alpha: f64, beta: f64) -> Option<f64> {
        let (stiffness, dissipation) = self.law(alpha, beta);
        Some(self.noise_m * self.noise?.of_wall(stiffness, dissipation))
    }

    /// The factor that takes a wall to the limit of its force noise.
    pub(super) fn largest_quiet_scale(&self, alpha: f64, beta: f64) -> f64 {
        let limit = self.design.force_noise_limit_n;
        let limited = limit.zip(self.force_noise_n(alpha, beta));
        limited.map_or(f64::INFINITY, |(limit, noise)| limit / noise)
    }

    /// The largest α beside β at which the wall times `times` is within the limit, or 0.
    fn quiet_alpha(&self, beta: f64, times: f64) -> f64 {
        let most = self.largest_quiet_scale(1.0, 0.0) / times;
        if most.is_infinite() {
            return most;
        }
        let is_quiet = |alpha: f64| self.largest_quiet_scale(alpha, beta) >= times;
        last(0.0, most, HALVINGS_TO_EDGE, is_quiet)
    }

    /// K, B and the scale of the tissue or controller that is wished, at this order.
    fn given(&self) -> Result<Option<Wall>, AnalysisError> {
        let (stiffness, dissipation) = match &self.design.wish {
            WallWish::Tissue {
                material,
                shape_m: shape,
                frequency_hz,
            } => (
                shape * material.rest_modulus_pa(),
                material.dissipation_at(*shape, self.order, 2.0 * PI * frequency_hz),
            ),
            WallWish::Controller(controller) => (0.0, controller.setup.sample_time_s),
            WallWish::StiffestWall | WallWish::MostDamping { .. } => return Ok(None),
        };
        let (alpha, beta) = (stiffness / self.units.0, dissipation / self.units.1);
        let proved = if self.design.every_motion {
            self.closed(alpha, beta)?.slope_limit().proved
        } else {
            f64::INFINITY
        };
        let scale = self.largest_scale(alpha, beta)?;
        let quiet = self.largest_quiet_scale(alpha, beta);
        let most = proved.min(quiet) * INSIDE;
        Ok(scale.map(|scale| (alpha, beta, Some(scale.min(most)))))
    }

    /// The factor that takes a wall to the strongest that the requirement allows, but for noise and proof; `None` if no factor does.
    pub(super) fn largest_scale(
        &self,
        alpha: f64,
        beta: f64,
    ) -> Result<Option<f64>, AnalysisError> {
        let edge = match self.design.gain_margin {
            None => None,
            Some(_) => self.largest_stable_scale(alpha, beta)?,
        };
        self.scale_within(edge, alpha, beta)
    }

    /// [`largest_scale`](Self::largest_scale) of a wall whose largest stable scale is known.
    pub(super) fn scale_within(
        &self,
        edge: Option<f64>,
        alpha: f64,
        beta: f64,
    ) -> Result<Option<f64>, AnalysisError> {
        let scale = match self.design.gain_margin {
            None => self.largest_passive_scale(alpha, beta)?,
            Some(gain_margin) => edge.map(|edge| edge / gain_margin),
        };
        Ok((scale.filter(|scale| *scale > 0.0)).map(|scale| scale * INSIDE))
    }

    /// True if the requirement allows a wall, whatever its noise; those weaker than one proved for every motion all are.
    pub(super) fn allows(&self, alpha: f64, beta: f64) -> Result<bool, AnalysisError> {
        match self.design.gain_margin {
            Some(_) if self.design.every_motion => Ok(true),
            Some(margin) => self.has_margin(alpha, beta, margin),
            None => Ok(self.largest_passive_scale(alpha, beta)? >= Some(1.0)),
        }
    }

    /// A wall as the wish measures it.
    pub(super) fn merit(&self, alpha: f64, beta: f64) -> Result<f64, AnalysisError> {
        let damping = self.effective_damping(alpha, beta)?;
        Ok(damping.unwrap_or_else(|| self.law(alpha, beta).0))
    }

    /// K and B of a wall, N/m and N·s^μ/m.
    pub(super) fn law(&self, alpha: f64, beta: f64) -> (f64, f64) {
        (alpha * self.units.0, beta * self.units.1)
    }

    /// The damping that a wall seems to have at the wish's frequency, N·s/m; `None` without a frequency.
    pub(super) fn effective_damping(
        &self,
        alpha: f64,
        beta: f64,
    ) -> Result<Option<f64>, AnalysisError> {
        let at = self.design.wish.frequency_hz().map(|hz| 2.0 * PI * hz);
        let felt = at.map(|omega| self.felt(alpha, beta, omega));
        Ok(felt.transpose()?.map(|felt| felt.damping_n_s_per_m))
    }

    /// Stiffness and damping of a wall at a frequency.
    pub(super) fn felt(
        &self,
        alpha: f64,
        beta: f64,
        omega_rad_s: f64,
    ) -> Result<Effective, AnalysisError> {
        let (stiffness_n_per_m, dissipation_n_s_mu_per_m) = self.law(alpha, beta);
        let environment = SampledWall {
            stiffness_n_per_m,
            dissipation_n_s_mu_per_m,
            order: self.order,
            sample_time_s: self.design.device.plant.sample_time.0,
        };
        environment.effective(&self.operator, omega_rad_s)
    }

    /// The largest α and β of the stable region; `None` if it is not bounded.
    pub(super) fn largest_parts(&self) -> Result<Option<[f64; 2]>, AnalysisError> {
        let region = StabilityRegion::new(self.plant, &self.operator, 0, POINTS)?;
        Ok(region.bounded().map(|area| [area.alpha_max, area.beta_max]))
    }

    /// The δ that passivity requires for this wall, and the damping of the device that makes it, N·s/m.
    pub(super) fn required(
        &self,
        alpha: f64,
        beta: f64,
    ) -> Result<(RequiredDelta, f64), AnalysisError> {
        let device = &self.design.device.plant;
        let required = self.port()?.required_delta(alpha, beta)?;
        let damping = required.delta * device.mass.0 / device.sample_time.0;
        Ok((required, damping))
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
    pub(super) fn judged(&self, (alpha, beta, scale): Wall) -> Result<Candidate, AnalysisError> {
        let device = &self.design.device;
        let (_, margin) = self.stable_and_margin(alpha, beta)?;
        let (stiffness, dissipation) = self.law(alpha, beta);
        let (mut proved, mut required) = (0.0, None);
        // No proof and no damping is enough where an integral pushes on and on.
        if !self.integrates() {
            proved = self.closed(alpha, beta)?.slope_limit().proved;
            required = Some(self.required(alpha, beta)?);
        }
        let is_controller = self.design.wish.controller().is_some();
        let reason = match (scale, self.design.gain_margin) {
            (Some(scale), _) if scale < 1.0 && is_controller => {
                Some("the gain is too large".to_owned())
            }
            (Some(scale), _) if scale < 1.0 => Some("the specimen is too large".to_owned()),
            (Some(_), Some(g)) if is_controller && !self.has_margin(alpha, beta, g)? => {
                let from = self.stable_scales(alpha, beta)?;
                let from = from.and_then(|(from, _)| from);
                from.map(|from| format!("unstable below {} times the gain", digits(from, 4)))
            }
            _ => None,
        };
        Ok(Candidate {
            order: Some(self.order.get()),
            stiffness_n_per_m: Some(stiffness),
            dissipation_n_s_mu_per_m: Some(dissipation),
            margin,
            pulling_contact_margin: (proved > 0.0).then_some(proved),
            alpha: Some(alpha),
            beta: Some(beta),
            passive: Some(required.is_some_and(|(required, _)| required.passive(self.delta))),
            required_damping_n_s_per_m: required.map(|(_, damping)| damping),
            effective_damping_n_s_per_m: self.effective_damping(alpha, beta)?,
            force_noise_rms_n: (self.force_noise_n(alpha, beta))
                .filter(|_| !device.sensors.are_ideal()),
            tried_force_noise_rms_n: None,
            largest_scale: scale,
            reason,
        })
    }

    /// Why there is no wall at all.
    fn nothing(&self) -> String {
        match self.design.gain_margin {
            None if self.delta <= 0.0 => "none is passive: the device has no damping",
            None if self.integrates() => "no damping is enough for an integral",
            None => "none is passive",
            Some(_) if self.design.every_motion => "none is proved for every motion",
            Some(_) => "none is stable with the gain margin",
        }
        .to_owned()
    }

    /// The largest passive wall, by Theorem 1. The set of passive walls is convex, so the middle of two is passive, and where the best ratio is
    /// not allowed its bound is best.
    fn passive_wall(&self) -> Result<Option<Wall>, AnalysisError> {
        let port = self.port()?;
        let required = |alpha: f64, beta: f64| port.required_delta(alpha, beta).map(|r| r.delta);
        let wall = |alpha, beta| Some((INSIDE * alpha, INSIDE * beta, None));
        if self.delta <= 0.0 {
            return Ok(None);
        }
        if let WallWish::MostDamping { .. } = self.design.wish {
            let (mut ratio, mut least) = minimum(|s| required(s, 1.0))?;
            if let Some(softest) = port.largest_ratio().map(|most| 1.0 / (INSIDE * most))
                && ratio < softest
            {
                (ratio, least) = (softest, required(softest, 1.0)?);
            }
            if least <= 0.0 {
                return Ok(None);
            }
            let quiet = self.largest_quiet_scale(ratio, 1.0);
            let beta = MOST_DAMPING * quiet.min(self.delta / least);
            let Largest::Below { value, .. } = port.largest_alpha(self.delta, beta)? else {
                return Ok(None);
            };
            let middle = 0.5 * (ratio * beta + value);
            return Ok(wall(middle.min(self.quiet_alpha(beta, 1.0)), beta));
        }
        let (mut ratio, mut least) = minimum(|t| required(1.0, t))?;
        if let Some(most) = port.largest_ratio().map(|most| INSIDE * most)
            && ratio > most
        {
            (ratio, least) = (most, required(1.0, most)?);
        }
        if least <= 0.0 {
            return Ok(None);
        }
        let alpha = self.delta / least;
        if self.largest_quiet_scale(alpha, ratio * alpha) >= 1.0 {
            return Ok(wall(alpha, ratio * alpha));
        }
        // Up to the best β the stiffest passive walls are stiffer and noisier: the stiffest quiet one is as noisy as it may be.
        let [mut low, mut high] = [0.0, ratio * alpha];
        let mut found = self.quiet_alpha(0.0, 1.0);
        for _ in 0..NOISE_HALVINGS {
            let beta = 0.5 * (low + high);
            let Largest::Below { value, .. } = port.largest_alpha(self.delta, beta)? else {
                return Ok(None);
            };
            if self.largest_quiet_scale(value, beta) >= 1.0 {
                (low, found) = (beta, value);
            } else {
                high = beta;
            }
        }
        Ok(wall(found, low))
    }

    /// The factor up to which a wall stays passive; `None` if a device without damping bears none.
    fn largest_passive_scale(&self, alpha: f64, beta: f64) -> Result<Option<f64>, AnalysisError> {
        if self.integrates() {
            return Ok(None);
        }
        // sup(α·u + β·v) grows in proportion to the wall.
        let required = self.port()?.required_delta(alpha, beta)?;
        let scale = self.delta / required.delta;
        let sound = scale > 0.0 && scale.is_finite() && !required.negative_at_rest;
        Ok(Some(scale).filter(|_| sound))
    }

    /// The largest stable wall with a gain margin, from the stability region.
    fn stable_wall(&self, gain_margin: f64) -> Result<Option<Wall>, AnalysisError> {
        let region = StabilityRegion::new(self.plant, &self.operator, 0, POINTS)?;
        let Some(area) = region.bounded() else {
            return Ok(None);
        };
        let factor = INSIDE / gain_margin;
        // On the boundary, before the margin is taken.
        let edge = if matches!(self.design.wish, WallWish::MostDamping { .. }) {
            let quiet = self.largest_quiet_scale(0.0, 1.0) / factor;
            most_damping(area, quiet, |beta| self.quiet_alpha(beta, factor))
        } else {
            stiffest(area, |alpha, beta| {
                self.largest_quiet_scale(alpha, beta) >= factor
            })
        };
        // The region need not hold the whole way from no wall to its edge.
        for (alpha, beta) in edge {
            let (alpha, beta) = (factor * alpha, factor * beta);
            if alpha > 0.0
                && self.has_margin(alpha, beta, gain_margin)?
                && self.is_proved(alpha, beta)?
            {
                return Ok(Some((alpha, beta, None)));
            }
        }
        Ok(None)
    }

    /// True if a wall is stable, also when all of it is weaker or stronger by up to g. A device with
    /// delay may need the wall in order to be stable at high order, so both ways count.
    fn has_margin(&self, alpha: f64, beta: f64, g: f64) -> Result<bool, AnalysisError> {
        let closed = self.closed(alpha, beta)?;
        if !closed.is_stable() {
            return Ok(false);
        }
        let margins = closed.margins()?;
        Ok(margins.gain_up.is_none_or(|gain| gain.value >= g)
            && margins.gain_down.is_none_or(|gain| gain.value <= 1.0 / g))
    }

    /// True if a stable wall is one at every smaller slope, and proved for every motion, as far as that is asked for.
    fn is_proved(&self, alpha: f64, beta: f64) -> Result<bool, AnalysisError> {
        if !self.design.every_motion {
            return Ok(true);
        }
        let closed = self.closed(alpha, beta)?;
        // The cheap question first.
        Ok(closed.margins()?.gain_down.is_none() && closed.slope_limit().proved >= 1.0)
    }

    /// The factor on a wall at which it ceases to be stable, from below; `None` if it is not stable
    /// at any size.
    fn largest_stable_scale(&self, alpha: f64, beta: f64) -> Result<Option<f64>, AnalysisError> {
        Ok(self.stable_scales(alpha, beta)?.map(|(_, high)| high))
    }

    /// The factors on a wall between which it is stable: the first, if smaller ones are unstable, and the edge.
    pub(super) fn stable_scales(
        &self,
        alpha: f64,
        beta: f64,
    ) -> Result<Option<(Option<f64>, f64)>, AnalysisError> {
        if self.design.wish.controller().is_some() {
            // One with an integral may need gain too.
            return Ok(largest_scales(&self.closed(alpha, beta)?, LARGEST_SCALE));
        }
        let mut scale = 1.0;
        for _ in 0..HALVINGS {
            let closed = self.closed(scale * alpha, scale * beta)?;
            if closed.is_stable() {
                // Without a limit there is no edge; no sampled wall is like that.
                let margins = closed.margins()?;
                let low = margins.gain_down.map(|gain| scale * gain.value);
                return Ok(margins.gain_up.map(|gain| (low, scale * gain.value)));
            }
            scale *= 0.5;
        }
        Ok(None)
    }
}

/// Minimum of a convex function of t ≥ 0: its place and its value; t = 0 if nothing else is better by 1e-9.
fn minimum(
    function: impl Fn(f64) -> Result<f64, AnalysisError>,
) -> Result<(f64, f64), AnalysisError> {
    // t = tan φ; a convex function of t falls and rises at most once in φ too.
    let at = |phi: f64| function(libm::tan(phi));
    let phi = minimum_of(0.0, 0.5 * PI, SECTIONS, at)?;
    let least = at(phi)?;
    let alone = function(0.0)?;
    if alone <= least * (1.0 + 1e-9) {
        Ok((0.0, alone))
    } else {
        Ok((libm::tan(phi), least))
    }
}

/// The boundary from the largest α down, as far as its walls are quiet: of all walls on one ray from the origin
/// the one whose g-fold lies on the boundary is the stiffest.
fn stiffest(area: &StableArea, is_quiet: impl Fn(f64, f64) -> bool) -> Vec<(f64, f64)> {
    let mut edge = Vec::new();
    for polygon in &area.polygons {
        for (a, b) in polygon.edges() {
            edge.push((a.alpha, a.beta));
            let at = |way: f64| {
                (
                    a.alpha + way * (b.alpha - a.alpha),
                    a.beta + way * (b.beta - a.beta),
                )
            };
            let holds = |way: f64| is_quiet(at(way).0, at(way).1);
            if holds(0.0) != holds(1.0) {
                let [quiet, loud] = if holds(0.0) { [0.0, 1.0] } else { [1.0, 0.0] };
                edge.push(at(last(quiet, loud, HALVINGS_TO_EDGE, holds)));
            }
        }
    }
    edge.push((area.alpha_max, area.beta_at_alpha_max));
    edge.retain(|(alpha, beta)| is_quiet(*alpha, *beta));
    edge.sort_by(|a, b| b.0.total_cmp(&a.0));
    edge
}

/// Points with almost the largest β, or the largest that is small enough, each in the middle of the widest
/// interval of quiet α that it leaves.
fn most_damping(
    area: &StableArea,
    quiet: f64,
    quiet_alpha: impl Fn(f64) -> f64,
) -> Vec<(f64, f64)> {
    let middle = |beta: f64| {
        let (crossings, most) = (crossings(area, beta), quiet_alpha(beta));
        let intervals = crossings.chunks_exact(2);
        let intervals = intervals.map(|ends| [ends[0], ends[1].min(most)]);
        let widest = intervals.max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))?;
        (widest[0] < widest[1]).then_some((0.5 * (widest[0] + widest[1]), beta))
    };
    let shares = SHARES.into_iter().map(|share| share * area.beta_max);
    let quiet_ones = SHARES.into_iter().map(|share| share * quiet);
    let first = [quiet].into_iter().chain(quiet_ones);
    let mut betas: Vec<f64> = first.chain(shares).collect();
    betas.retain(|beta| *beta <= quiet && *beta <= SHARES[0] * area.beta_max);
    betas.sort_by(|a, b| b.total_cmp(a));
    betas.into_iter().filter_map(middle).collect()
}

#[cfg(test)]
mod tests {
    use crate::design::bench::*;

    #[test]
    fn it_is_the_closed_form_for_the_exact_operator() {
        let t = Seconds(2e-3);
        for mu in [0.0, 0.3, 0.5, 1.0, 1.5, 2.0] {
            let order = Order::new(mu).expect("in range");
            let scheme = "full".parse().expect("a scheme");
            let have = noise_gain(None, scheme, order, t).expect("builds");
            let want = NoiseGain::exact(order, t).expect("in range");
            let [have, want] = [have, want].map(|gain| gain.of_wall(0.0, 1.0));
            assert!((have / want - 1.0).abs() < 1e-5, "{mu}: {have} {want}");
        }
    }

    #[test]
    fn a_polynomial_has_its_own_weights() {
        // A₃ at μ = 1: 1, −1, 1/3, −1/3.
        let order = Order::new(1.0).expect("in range");
        let muir = Scheme::Muir { degree: 3 };
        let have = noise_gain(None, muir, order, Seconds(1.0)).expect("builds");
        let have = have.of_wall(0.0, 1.0);
        assert!(
            (have - (2.0 + 2.0 / 9.0_f64).sqrt()).abs() < 1e-12,
            "{have}"
        );
    }

    #[test]
    fn the_minimum_of_a_convex_function_is_found() {
        let (t, value) = minimum(|t| Ok((t - 3.0).abs() + 1.0)).expect("finite");
        assert!(
            (t - 3.0).abs() < 1e-9 && (value - 1.0).abs() < 1e-9,
            "{t} {value}"
        );
        let (t, value) = minimum(|t| Ok(2.0 + t)).expect("finite");
        assert!(
            t.abs() < f64::EPSILON && (value - 2.0).abs() < f64::EPSILON,
            "{t} {value}"
        );
    }
}
