//! The search for the stiffest wall of one order.

use super::report::BoundaryPoint;
use super::specification::ZWidth;
use super::theory::Theory;
use super::upward::Settled;
use crate::document::failure::Failure;
use crate::experiment::trial::{
    TrialPlan, encoder_step, force_and_rate, force_limit, thrown, try_out, wall_at_start,
};
use crate::judge::settling::Judge;
use crate::question::zwidth::trials::Trials;
use crate::run::remote::{RemoteLaw, UnchangedLimits, portable, push};
use crate::run::sensors::Sensors;
use fracdiff::{Operator, Order};
use haptic_link::{OperatorShape, Simulation};
use haptic_loop::plant::{MassDamper, MassDamperConfig};
use haptic_loop::units::Newtons;
use haptic_loop::{Controller, SafetyChain};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Bisections after the coarse search: 2e-4 of the value found, or better.
const BISECTIONS: u32 = 12;
/// Share by which the wall of a trial may be off from the boundary of the analysis, up or down.
const AGREES_WITHIN: f64 = 0.05;

/// Limit of a search: beyond the largest α and β of any region that was computed. These are 4 without
/// damping and below 4(1 + δ) with it.
pub(super) fn search_limit(delta: f64) -> f64 {
    f64::max(5.0, 4.0 * (1.0 + delta))
}

/// The coarse scale from `most` down: fifty even steps, then ten a decade down to 1e-4, then 0. A wall
/// far softer than the softest of the even steps is still found.
fn coarse(most: f64) -> impl Iterator<Item = f64> {
    let even = (1..=50)
        .rev()
        .map(move |step| most * f64::from(step) / 50.0);
    let fine = (1..=24).map(move |step| most / 50.0 * 10f64.powf(-f64::from(step) / 10.0));
    even.chain(fine).chain([0.0])
}

/// The largest value up to `most` that is stable; `None` if no value of the coarse scale is.
fn largest(most: f64, stable: impl Fn(f64) -> bool) -> Option<f64> {
    let mut above = most;
    let found = coarse(most).find(|&value| {
        let found = stable(value);
        if !found {
            above = value;
        }
        found
    })?;
    let (mut low, mut high) = (found, above);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        *(if stable(middle) { &mut low } else { &mut high }) = middle;
    }
    Some(low)
}

/// Result for one dissipation, as α.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    stable: f64,
    held: Option<f64>,
}

/// How far the search of one order goes.
pub(super) enum Extent {
    /// Of a simulated device: the largest β.
    UpTo(f64),
    /// Of a real one: walls that came to rest.
    Known(Settled),
}

impl Extent {
    /// The largest β.
    pub(super) fn largest_dissipation(&self) -> f64 {
        match self {
            Self::UpTo(beta) => *beta,
            Self::Known(settled) => settled.largest_dissipation().unwrap_or(0.0),
        }
    }
}

/// A wall of one order that lacks only its stiffness and dissipation.
pub(super) struct Search<'a> {
    experiment: &'a ZWidth,
    plan: TrialPlan,
    pub(super) order: Order,
    operator: Operator<f64>,
    /// The device as it is.
    device: MassDamper<1>,
    /// The same without friction, if it has some.
    smooth: Option<MassDamper<1>>,
    chain: SafetyChain<f64>,
    samples: u64,
    /// T^(−μ).
    rate: f64,
    encoder_step_m: f64,
    theory: Option<Theory>,
    /// Largest α or β that is looked at.
    most: f64,
    /// N/m of α = 1, and N·s^μ/m of β = 1.
    pub(super) units: (f64, f64),
    /// Seed of this order's cells.
    seed: u64,
    /// The operator for the serial device, and the device.
    remote: Option<((OperatorShape, Vec<f32>), &'a Trials<'a>)>,
    stop: &'a AtomicBool,
    runs: AtomicU64,
}

impl<'a> Search<'a> {
    pub(super) fn new(
        experiment: &'a ZWidth,
        order: Order,
        place: usize,
        trials: Option<&'a Trials<'a>>,
        stop: &'a AtomicBool,
    ) -> Result<Self, Failure> {
        let config = experiment.device;
        let t = config.sample_time;
        let mut plan = experiment.plan();
        let samples = plan.samples(t)?;
        let (scheme, horizon) = (experiment.scheme, crate::run::schedule::horizon(samples));
        let mut encoder_step_m = encoder_step(experiment.sensors);
        if let Some(trials) = trials {
            let (step_m, most_n) = trials.encoder_and_force();
            encoder_step_m = step_m;
            plan.force_limit_n = plan.force_limit_n.min(most_n);
        }
        let device = thrown(config, &plan)?;
        // Sensors that cannot be made are refused before the first run.
        experiment.sensors.before(device.clone())?;
        let smooth = MassDamperConfig {
            friction: Newtons(0.0),
            ..config
        };
        let smooth = (config.friction.0 > 0.0).then(|| thrown(smooth, &plan));
        Ok(Self {
            experiment,
            plan,
            order,
            operator: scheme.build(order, t, horizon).map_err(Failure::input)?,
            smooth: smooth.transpose()?,
            device,
            chain: force_limit(plan.force_limit_n, t)?,
            samples,
            rate: t.rate_to_the(order).map_err(Failure::input)?,
            encoder_step_m,
            theory: Theory::new(experiment, order),
            most: search_limit(config.damping.0 * t.0 / config.mass.0),
            units: (
                config.mass.0 / (t.0 * t.0),
                config.mass.0 / t.0.powf(2.0 - order.get()),
            ),
            seed: experiment.sensors.seed.wrapping_add((place as u64) << 32),
            remote: match trials {
                Some(trials) => {
                    let built = scheme.build(order, t, horizon);
                    Some((portable(&built.map_err(Failure::input)?)?, trials))
                }
                None => None,
            },
            stop,
            runs: AtomicU64::new(0),
        })
    }

    /// Runs made.
    pub(super) fn runs(&self) -> u64 {
        self.runs.load(Ordering::Relaxed)
    }

    /// Outline of the stable region by the analysis, as (β, α).
    pub(super) fn outline(&self) -> Vec<(f64, f64)> {
        self.theory.as_ref().map_or_else(Vec::new, Theory::outline)
    }

    pub(super) fn point(&self, beta: f64, cell: Cell) -> BoundaryPoint {
        let (stiffness, dissipation) = self.units;
        let theory = self.theory.as_ref();
        BoundaryPoint {
            dissipation: beta * dissipation,
            stiffness_max: cell.stable * stiffness,
            alpha: cell.stable,
            beta,
            analysis_stiffness_n_per_m: theory
                .and_then(|theory| theory.largest_alpha(beta))
                .map(|alpha| alpha * stiffness),
            analysis_agrees: theory
                .filter(|_| cell.stable < 0.999 * self.most)
                .and_then(|theory| theory.has_edge_within(cell.stable, beta, AGREES_WITHIN)),
            held_by_friction_up_to_n_per_m: cell.held.map(|alpha| alpha * stiffness),
        }
    }

    /// The largest α that is stable with this β; `None` if none that is tried is, or the search has ended.
    pub(super) fn cell(&self, beta: f64, extent: &Extent, cell: u64) -> Option<Cell> {
        if let Extent::Known(settled) = extent {
            let rests = |alpha| self.settles(&self.device, alpha, beta, cell);
            let stable = settled.largest(beta, self.most, rests)?;
            return self.whole(Cell { stable, held: None });
        }
        let as_it_is = largest(self.most, |alpha| {
            self.settles(&self.device, alpha, beta, cell)
        })?;
        let Some(smooth) = &self.smooth else {
            return self.whole(Cell {
                stable: as_it_is,
                held: None,
            });
        };
        let stable = largest(as_it_is, |alpha| {
            self.settles(smooth, alpha, beta, cell) && self.settles(&self.device, alpha, beta, cell)
        })?;
        // Two bisections end where they end: closer than a thousandth is the same.
        let held = Some(as_it_is).filter(|held| *held > 1.001 * stable);
        self.whole(Cell { stable, held })
    }

    /// The result, unless the search has ended on the way.
    fn whole<T>(&self, found: T) -> Option<T> {
        (!self.is_over()).then_some(found)
    }

    /// True if nothing more is tried: it was stopped, or its device failed.
    fn is_over(&self) -> bool {
        let failed = |(_, trials): &(_, &Trials<'_>)| trials.has_failed();
        self.stop.load(Ordering::Relaxed) || self.remote.as_ref().is_some_and(failed)
    }

    /// How far it goes; `None` if no wall of a real device comes to rest, or the search has ended.
    pub(super) fn extent(&self) -> Option<Extent> {
        if self.remote.is_none() {
            return self.largest_dissipation().map(Extent::UpTo);
        }
        let rests = |alpha, beta| self.settles(&self.device, alpha, beta, 0);
        // α = β·(T/τ)^μ: what is left of the way is an eighth of the time for it.
        let plan = &self.plan;
        let tau_s = (plan.duration_s - plan.window_s) / 8.0;
        let soft = (self.rate * tau_s.powf(self.order.get())).recip();
        let settled = Settled::look(self.most, |beta| beta * soft, rests);
        settled.largest_dissipation()?;
        self.whole(Extent::Known(settled))
    }

    /// The largest β that is stable with any α, 0 if there is none; `None` if the search was stopped. Not with
    /// α = 0: a pure damper of order 1 and more gives way for ever; and with A₃ at μ > 1 a wall needs
    /// stiffness to be stable at all.
    fn largest_dissipation(&self) -> Option<f64> {
        let any_stiffness = |beta| {
            let mut walls = coarse(self.most).filter(|alpha| *alpha > 0.0);
            walls.any(|alpha| self.is_stable(alpha, beta))
        };
        self.whole(largest(self.most, any_stiffness).unwrap_or(0.0))
    }

    /// True if a wall settles, also without friction.
    fn is_stable(&self, alpha: f64, beta: f64) -> bool {
        let smooth = self.smooth.as_ref();
        smooth.is_none_or(|device| self.settles(device, alpha, beta, 0))
            && self.settles(&self.device, alpha, beta, 0)
    }

    /// One run. Whatever goes wrong on the way is not stable.
    fn settles(&self, device: &MassDamper<1>, alpha: f64, beta: f64, cell: u64) -> bool {
        if self.is_over() {
            return false;
        }
        self.runs.fetch_add(1, Ordering::Relaxed);
        let (stiffness, dissipation) = (alpha * self.units.0, beta * self.units.1);
        let t = self.experiment.device.sample_time.0;
        let spring = stiffness + self.experiment.device.stiffness.0;
        let mut judge = self
            .plan
            .judge((spring, dissipation * self.rate), self.encoder_step_m, t);
        if let Some((operator, trials)) = &self.remote {
            let law = self.law(stiffness, dissipation, operator);
            return settles_there(trials, &law, self.samples, t, &mut judge);
        }
        let sensors = Sensors {
            seed: self.seed.wrapping_add(cell),
            ..self.experiment.sensors
        };
        let one_sided = self.experiment.one_sided;
        let wall = wall_at_start(stiffness, dissipation, self.operator.clone(), one_sided);
        let (Ok(wall), Ok(mut device)) = (wall, sensors.before(device.clone())) else {
            return false;
        };
        let mut controller = Controller::<f64, 1, _>::new(wall, self.chain);
        let whole = try_out(&mut controller, &mut device, self.samples, &mut judge);
        judge.settling(whole, None).stable
    }

    /// The same wall for the serial device.
    fn law(
        &self,
        stiffness: f64,
        dissipation: f64,
        operator: &(OperatorShape, Vec<f32>),
    ) -> RemoteLaw {
        let device = &self.experiment.device;
        RemoteLaw {
            stiffness_n_per_m: stiffness,
            dissipation_n_s_mu_per_m: dissipation,
            order: self.order.get(),
            one_sided: self.experiment.one_sided,
            operator: operator.clone(),
            limits: force_and_rate(self.plan.force_limit_n, None, device.sample_time),
            unchanged: UnchangedLimits::default(),
            guard: Default::default(),
            simulation: Simulation {
                mass_kg: device.mass.0 as f32,
                damping_n_s_per_m: device.damping.0 as f32,
                hand_stiffness_n_per_m: device.stiffness.0 as f32,
                ..push(self.plan.push_n)
            },
            after_rise: false,
        }
    }
}

/// One run on the serial device, judged by what it measured and commanded.
fn settles_there(
    trials: &Trials<'_>,
    law: &RemoteLaw,
    samples: u64,
    sample_time_s: f64,
    judge: &mut Judge,
) -> bool {
    let Some(motion) = trials.motion(law, samples, sample_time_s) else {
        return false;
    };
    for (n, (position_m, force_n)) in motion.into_iter().enumerate() {
        judge.see(n as f64 * sample_time_s, position_m, force_n);
    }
    judge.settling(true, None).stable
}
