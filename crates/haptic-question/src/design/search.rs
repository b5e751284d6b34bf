//! The best wall that passes its trials.
//!
//! ```text
//! rays     (α, β) = s·(α₁, β₁), 0 < s ≤ 1: α₁ and β₁ are the strongest wall of an order that the requirement allows,
//!          first the one that the wish likes best, then those at other ratios β/α, an octave apart
//! next     of all orders and rays the wall that the wish likes best; where it fails, s falls by 15 %, or as far as
//!          its noise says
//! edge     the steps of all rays that may hold a better wall are halved, until none can be better by 4 %
//! refined  ratio and order go to a wall that passes and is better by 0.7 %, in steps that are halved where there is
//!          none; then to one that is better by 3 or 8 %, at any order, up to three octaves of ratio away
//! passes   20 s at each of six pushes, with five seeds of the sensor's noise, or, without noise, at five places between
//!          two steps of the encoder: at rest at the end, a tenth in hand on the swing of the force, none above the least
//!          push, and a deviation in the last 10 s of at most the limit less 15 %, less 3 % without noise of the sensor
//! ```
//! - *The analysis proposes, the trial decides.* Steps of an encoder are no white noise: the loop keeps them alive, and friction, the limit
//!   of the force and a contact that never pulls are in no analysis.
//! - *More than one trial*: a limit cycle at one push may be absent at another, and the noise of one seed is exceeded at others by up to 1.6
//!   times. A wall that never pulls is hit at all speeds at each push too.
//! - *Without a limit* it is 5 % of the push; the best wall without any stands beside. A tissue is as noisy as it is.
//! - *Best* is claimed of the walls that were searched.
//! - *Proved walls*: those proved for every motion keep their ratio. A passive wall is tried for as long as it rings, up to 256 times as
//!   long as usual.
//! - *No wall is given up early*: a ray ends where its wall could not hold the push within the reach of a trial.
//! - *Cost*: a wall is given up at its first trial that fails, most often at a look of 5 s; it is tried first as the last one failed. One
//!   that passes has 30 trials of 20 s, of a wall that never pulls 66.

use crate::bench::last;
use crate::design::bench::Bench;
use crate::design::{Candidate, Noisier, WallDesign};
use fracdiff::{FrequencyResponse as _, Order, Seconds};
use haptic_analysis::AnalysisError;
use haptic_document::Failure;
use haptic_judge::pushed_trial::PushedTrial;
use haptic_judge::pushed_trial::louder;
use haptic_judge::settling::Settling;
use haptic_judge::settling::{GONE_M, TrialVerdict};
use haptic_judge::setup::TrialSetup;
use haptic_judge::trial::TrialPlan;
use haptic_judge::wall::WallTrial;
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Push, N, as long as the device can hold four times as much.
const PUSH_N: f64 = 1.0;
/// Pushes of the trials of a wall, in that one: those at which most walls fail first.
const PUSHES: [f64; 6] = [0.5, 1.0, 2.0, 0.75, 0.9, 1.1];
/// Seeds of a sensor's noise with which it is tried; of an encoder alone places between two of its steps.
const SEEDS: u32 = 5;
/// The limit of noise over the worst that is tried, of an encoder alone and of a noisy sensor: at other pushes and seeds there may be more.
const IN_HAND: [f64; 2] = [1.03, 1.15];
/// Share of the swing of the force that counts as rest, an extreme value.
const SWING: f64 = 0.9;
/// The limit of noise where none is asked for, in the push.
const NOISE_SHARE: f64 = 0.05;
/// Length of a run and of its window, s and samples: the larger of the two.
const DURATION: (f64, f64) = (5.0, 2500.0);
const WINDOW_LENGTH: (f64, f64) = (0.4, 200.0);
/// Lengths of a trial, in those of the usual one: of the last every wall is tried.
const STRETCHES: [f64; 3] = [1.0, 2.0, LONGEST];
pub(super) const LONGEST: f64 = 4.0;
/// Lengths of a trial of a passive wall that rings, likewise.
const RINGING: [f64; 3] = [16.0, 64.0, 256.0];
/// Halvings of the time that it rings.
const RING_HALVINGS: u32 = 7;
/// Share of a wall that failed which is tried next.
const WEAKER: f64 = 0.85;
/// The least such share, of one that is only too noisy, or weaker than a tenth of the strongest of its ray.
const WEAKEST: f64 = 0.5;
const SOFT: f64 = 0.1;
/// A wall that may be better by less than this share is not looked for.
const NEAR: f64 = 0.04;
/// Octaves of the ratios β/α of the rays, from that of the first wall of the order.
const OCTAVES: std::ops::RangeInclusive<i32> = -4..=8;
/// Gains that are tried around the best wall: a limit cycle may be absent beyond one that is not.
const GAINS: [f64; 2] = [1.04, 1.007];
/// Gains at which all orders are looked through around its ratio, and those ratios, quarters of an octave.
const GAINS_OF_ALL: [f64; 2] = [1.03, 1.08];
const QUARTERS: std::ops::RangeInclusive<i32> = -12..=12;
/// First and last step around it: of the ratio, octaves; the order moves by as much of 0.25.
const STEPS: (f64, f64) = (0.5, 0.05);
/// Signs in a look of 5 s that 20 s do not bring a force to rest either: times the limit that it varies by, and share of its variation over the
/// second half that it has at the end. An exponential that falls by less is above the limit after 15 s.
const RESTLESS: (f64, f64) = (3.0, 0.9);
/// A candidate must be better by this share to win over one of lower order.
const BETTER: f64 = 1e-6;

/// A wall or coupler that was tried.
#[derive(Clone, Debug)]
pub(super) struct Tried<T> {
    pub(super) experiment: T,
    pub(super) settling: Settling,
}

/// The wall that is taken, its run, and what a noisier wish would get.
pub(super) struct Found {
    pub(super) wall: Candidate,
    pub(super) tried: Tried<WallTrial>,
    /// Time until it is at rest, if it rings for long, s.
    pub(super) rings_s: Option<f64>,
    pub(super) noisier: Option<Noisier>,
}

/// A wall after the trials that it passed, and the first that it did not pass.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outcome {
    pub(super) passes: bool,
    /// Settling in the trial that failed, or in the last.
    pub(super) settling: Settling,
    /// The worst of all trials, N.
    noise_n: Option<f64>,
    /// Length of the trials, in those of the usual one.
    stretch: f64,
}

/// True if a device is at rest, with something in hand.
fn is_at_rest(settling: &Settling) -> bool {
    let most = settling.force_range_limit_n.map(|limit| SWING * limit);
    settling.stable && most.is_none_or(|most| settling.force_range_n <= Some(most))
}

impl Outcome {
    /// Why it does not pass, in a column's width.
    fn reason(&self) -> String {
        if is_at_rest(&self.settling) {
            "too noisy when tried".to_owned()
        } else {
            failed(self.settling.verdict)
        }
    }
}

/// Why a trial does not pass, in a column's width.
fn failed(verdict: TrialVerdict) -> String {
    match verdict {
        TrialVerdict::HeldByFriction => "held by friction alone".to_owned(),
        // With nothing in hand too.
        TrialVerdict::Stable | TrialVerdict::Unstable => "not at rest when tried".to_owned(),
        other @ (TrialVerdict::Saturated
        | TrialVerdict::Untouched
        | TrialVerdict::Gone
        | TrialVerdict::Unfinished) => format!("{} when tried", other.words()),
    }
}

/// One trial of a wall.
#[derive(Clone, Copy, Debug)]
pub(super) struct Try {
    /// Push, in those of the usual trial.
    pub(super) push: f64,
    /// Seed of the noise, counted from that of the device.
    pub(super) seed: u32,
    /// Share of a step of the encoder by which it rests elsewhere.
    pub(super) moved: f64,
    /// Speed of the hit, m/s.
    pub(super) impact_m_per_s: f64,
    pub(super) stretch: f64,
}

impl Try {
    /// That of the file of a wall.
    pub(super) const fn usual(stretch: f64) -> Self {
        Self {
            push: 1.0,
            seed: 0,
            moved: 0.0,
            impact_m_per_s: TrialPlan::DEFAULT.impact_m_per_s,
            stretch,
        }
    }
}

/// Walls of one ratio of an order.
#[derive(Clone)]
struct Ray<'a> {
    bench: Arc<Bench<'a>>,
    /// Index of the candidate that is its strongest wall.
    candidate: Option<usize>,
    alpha: f64,
    beta: f64,
    merit: f64,
    /// Share that is tried next, and the least of those that failed.
    share: f64,
    failed: f64,
}

impl<'a> Ray<'a> {
    fn new(bench: Arc<Bench<'a>>, alpha: f64, beta: f64) -> Result<Self, AnalysisError> {
        Ok(Self {
            merit: bench.merit(alpha, beta)?,
            bench,
            candidate: None,
            alpha,
            beta,
            share: 1.0,
            failed: 1.0,
        })
    }

    /// K and B of a share of it.
    fn law(&self, share: f64) -> (f64, f64) {
        self.bench.law(share * self.alpha, share * self.beta)
    }

    /// True if its next wall is the candidate itself.
    fn is_first(&self) -> bool {
        self.candidate.is_some() && self.share >= 1.0
    }

    fn next_merit(&self) -> f64 {
        self.share * self.merit
    }

    /// The ray of an order this many octaves beside the ratio with the same time β/α; `None` if it cannot be analysed.
    fn neighbour(&self, bench: Arc<Bench<'a>>, octaves: f64) -> Option<Self> {
        let power = bench.order.get() / self.bench.order.get();
        let ratio = libm::pow(self.beta / self.alpha, power) * libm::exp2(octaves);
        Ray::new(bench, self.alpha, self.alpha * ratio).ok()
    }
}

/// The first of those that are best by their number.
pub(super) fn best<T>(all: impl IntoIterator<Item = (f64, T)>) -> Option<T> {
    let better = |best: Option<(f64, T)>, next: (f64, T)| match best {
        Some(best) if next.0 <= best.0 + BETTER * best.0.abs() => Some(best),
        Some(_) | None => Some(next),
    };
    all.into_iter().fold(None, better).map(|(_, best)| best)
}

/// A search that is on its way.
struct Search<'s, 'a> {
    design: &'a WallDesign,
    candidates: &'s mut [Candidate],
    rays: Vec<Ray<'a>>,
    /// One of each order of the grid.
    benches: Vec<Arc<Bench<'a>>>,
    limit_n: Option<f64>,
    /// The trial in which the last wall failed.
    hardest: AtomicUsize,
    stop: &'s AtomicBool,
}

impl WallDesign {
    /// The best wall that passes, and how it did; candidates whose wall failed say so.
    pub(super) fn best_that_passes(
        &self,
        candidates: &mut [Candidate],
        stop: &AtomicBool,
    ) -> Result<Option<Found>, Failure> {
        let rays = self.first_rays(candidates)?;
        let benches = rays.iter().map(|ray| &ray.bench);
        let of_grid =
            |bench: &&Arc<Bench<'_>>| bench.order.get() > 0.0 && self.orders.contains(&bench.order);
        let mut search = Search {
            benches: benches.filter(of_grid).cloned().collect(),
            rays,
            design: self,
            candidates,
            limit_n: self.force_noise_limit_n,
            hardest: AtomicUsize::new(0),
            stop,
        };
        let unasked_n = self.noise_limit_n().filter(|_| search.limit_n.is_none());
        if unasked_n.is_none() {
            if search.limit_n.is_some() {
                // The strongest by the analysis of its noise is not the strongest that passes.
                search.turn_all();
            }
            return search.best(None);
        }
        // Walls that do not come to rest do not with a limit either: the search continues from there.
        let noisier = search.run()?;
        search.limit_n = unasked_n;
        let noisier = noisier.filter(|(_, outcome)| !self.is_within(outcome.noise_n, unasked_n));
        let noisier = noisier.map(|(ray, outcome)| Noisier {
            order: ray.bench.order.get(),
            stiffness_n_per_m: ray.law(ray.share).0,
            dissipation_n_s_mu_per_m: ray.law(ray.share).1,
            tried_force_noise_rms_n: outcome.noise_n,
        });
        search.best(noisier)
    }

    /// The limit of the noise of the force, asked for or not, N.
    pub(super) fn noise_limit_n(&self) -> Option<f64> {
        let has_choice = !self.wish.is_given();
        let unasked = has_choice && !self.device.sensors.are_ideal();
        (self.force_noise_limit_n).or_else(|| unasked.then(|| NOISE_SHARE * self.push_n()))
    }

    /// The rays of the candidates, before they are tried.
    fn first_rays(&self, candidates: &[Candidate]) -> Result<Vec<Ray<'_>>, Failure> {
        let ray = |n: usize| -> Result<Option<Ray<'_>>, Failure> {
            let one = &candidates[n];
            let (Some(merit), Some(order), Some(alpha), Some(beta)) =
                (self.merit(one), one.order, one.alpha, one.beta)
            else {
                return Ok(None);
            };
            let order = Order::new(order).map_err(Failure::input)?;
            Ok(Some(Ray {
                bench: Arc::new(Bench::new(self, order)?),
                candidate: Some(n),
                alpha,
                beta,
                merit,
                share: 1.0,
                failed: 1.0,
            }))
        };
        let rays = (0..candidates.len()).into_par_iter().map(ray);
        let rays: Vec<_> = rays.collect::<Result<_, _>>()?;
        Ok(rays.into_iter().flatten().collect())
    }

    fn plan(&self, stretch: f64) -> TrialPlan {
        let device = &self.device;
        plan(device.plant.sample_time, device.force_limit_n, stretch)
    }

    pub(super) fn push_n(&self) -> f64 {
        self.plan(1.0).push_n
    }

    pub(super) fn is_noisy(&self) -> bool {
        self.device.sensors.noise_m > 0.0
    }

    /// Seeds or places that make a difference.
    fn seeds(&self) -> u32 {
        if self.device.sensors.are_ideal() {
            1
        } else {
            SEEDS
        }
    }

    /// True if the worst noise of a wall is within a limit, with something in hand.
    fn is_within(&self, noise_n: Option<f64>, limit_n: Option<f64>) -> bool {
        let times = IN_HAND[usize::from(self.is_noisy())];
        (noise_n.zip(limit_n)).is_none_or(|(noise, limit)| times * noise <= limit)
    }

    /// True if a trial of 5 s shows that a longer one fails.
    fn is_restless(&self, settling: &Settling, limit_n: Option<f64>) -> bool {
        let limits = [settling.force_std_limit_n, limit_n];
        let limit = limits.into_iter().flatten().reduce(f64::min);
        let now = settling.force_std_n;
        let is_loud = now
            .zip(limit)
            .is_some_and(|(now, limit)| now > RESTLESS.0 * limit);
        let goes_on = now.zip(settling.noise_n);
        let goes_on = goes_on.is_some_and(|(now, before)| now >= RESTLESS.1 * before);
        matches!(
            settling.verdict,
            TrialVerdict::Gone | TrialVerdict::Saturated
        ) || is_loud && goes_on
    }

    /// All trials of a wall: with the first seed all hits of a push, of which the hardest fails first, then the other seeds.
    fn trials(&self, stretch: f64) -> Vec<Try> {
        let (plan, is_noisy) = (self.plan(stretch), self.is_noisy());
        let planned = plan.impact_m_per_s;
        let one = |push: f64, n: u32, impact_m_per_s: f64| Try {
            push,
            seed: if is_noisy { n } else { 0 },
            moved: f64::from(if is_noisy { 0 } else { n }) / f64::from(SEEDS),
            impact_m_per_s,
            stretch,
        };
        let mut hits: Vec<f64> = plan.hits(self.contact).chain([planned]).collect();
        hits.reverse();
        let first = (PUSHES.iter()).flat_map(|push| hits.iter().map(|hit| one(*push, 0, *hit)));
        let seeds = 1..self.seeds();
        let others = seeds.flat_map(|n| PUSHES.map(|push| one(push, n, planned)));
        first.chain(others).collect()
    }

    /// A wall of an order, K in N/m and B in N·s^μ/m, before a trial.
    fn wall(&self, order: Order, law: (f64, f64), one: &Try) -> WallTrial {
        let device = &self.device;
        let usual = self.plan(one.stretch);
        // At rest it is between two steps of the encoder, and there it matters where.
        let controller = self.wish.controller();
        let spring = match controller.filter(|controller| !controller.integrates) {
            Some(controller) => controller.operator.response(0.0).re,
            None => law.0,
        };
        let step_n = device.sensors.encoder_resolution_m * (spring + device.plant.stiffness.0);
        let push_n = one.push * usual.push_n + one.moved * step_n;
        let plan = TrialPlan {
            // A step of more force than the device has is far too noisy.
            push_n: push_n.min(0.9 * device.force_limit_n),
            impact_m_per_s: one.impact_m_per_s,
            ..usual
        };
        let mut sensors = device.sensors;
        sensors.seed = sensors.seed.wrapping_add(u64::from(one.seed));
        let setup = TrialSetup {
            must_be_stable: true,
            ..TrialSetup::new(device.plant, sensors, plan)
        };
        WallTrial {
            model: self.model(order).cloned(),
            controller: controller.cloned().map(Box::new),
            contact: self.contact,
            ..WallTrial::linear(setup, order, self.scheme, law.0, law.1)
        }
    }

    /// One trial of a wall.
    pub(super) fn tried_once(
        &self,
        order: Order,
        law: (f64, f64),
        one: &Try,
    ) -> Result<Settling, Failure> {
        let wall = self.wall(order, law, one);
        wall.named(wall.tried()?)
    }

    /// Tries a wall of an order for as long as it needs to come to rest: K in N/m, B in N·s^μ/m.
    pub(super) fn tried(&self, order: Order, k: f64, b: f64) -> Result<Tried<WallTrial>, Failure> {
        let wall = |stretch| self.wall(order, (k, b), &Try::usual(stretch));
        Tried::of(wall, |settling| settling.stable)
    }

    /// Tries a wall in each way until it fails in one, first as the last one failed; `None` if, having passed that, it turns out not to be
    /// allowed.
    pub(super) fn outcome(
        &self,
        order: Order,
        law: (f64, f64),
        stretch: f64,
        limit_n: Option<f64>,
        hardest: &AtomicUsize,
        is_allowed: impl FnOnce() -> Result<bool, Failure>,
    ) -> Result<Option<Outcome>, Failure> {
        let mut is_allowed = Some(is_allowed);
        let (mut noise_n, mut swing_n, mut last) = (None, None, None);
        let mut trials: Vec<_> = self.trials(stretch).into_iter().enumerate().collect();
        let (n, first) = trials.remove(hardest.load(Ordering::Relaxed).min(trials.len() - 1));
        let first = [1.0, stretch].map(|stretch| (n, Try { stretch, ..first }));
        for (n, one) in first.into_iter().chain(trials) {
            let settling = self.tried_once(order, law, &one)?;
            let is_look = one.stretch < stretch;
            if is_look && (stretch > LONGEST || !self.is_restless(&settling, limit_n)) {
                continue;
            }
            if !self.device.sensors.are_ideal() {
                noise_n = louder([settling.noise_n, noise_n]);
            }
            // It swings by steps of the encoder whatever the push is, and the least must hold.
            swing_n = louder([settling.force_range_n, swing_n]);
            let holds = swing_n <= Some(PUSHES[0] * self.push_n());
            let is_quiet = holds && self.is_within(noise_n, limit_n);
            let outcome = Outcome {
                passes: !is_look && is_at_rest(&settling) && is_quiet,
                settling,
                noise_n,
                stretch,
            };
            last = Some(outcome);
            if !outcome.passes {
                hardest.store(n, Ordering::Relaxed);
                break;
            }
            if let Some(is_allowed) = is_allowed.take()
                && !is_allowed()?
            {
                return Ok(None);
            }
        }
        Ok(last)
    }
}

impl<T: PushedTrial> Tried<T> {
    /// Tries it for as long as it needs to pass.
    pub(super) fn of(
        make: impl Fn(f64) -> T,
        passes: impl Fn(&Settling) -> bool,
    ) -> Result<Self, Failure> {
        let mut stretches = STRETCHES.into_iter();
        loop {
            let experiment = make(stretches.next().unwrap_or(LONGEST));
            let settling = experiment.settled()?;
            // A device that left does not settle later; hits against the force limit are a smaller share of a longer trial.
            let is_over = passes(&settling) || settling.verdict > TrialVerdict::Saturated;
            if is_over || stretches.len() == 0 {
                return Ok(Self {
                    experiment,
                    settling,
                });
            }
        }
    }

    /// Why it does not pass, in a column's width.
    pub(super) fn reason(&self) -> String {
        failed(self.settling.verdict)
    }
}

impl<'a> Search<'_, 'a> {
    fn go_on(&self) -> Result<(), Failure> {
        if self.stop.load(Ordering::Relaxed) {
            Err(Failure::interrupted())
        } else {
            Ok(())
        }
    }

    /// The best wall between those that passed or were not tried and those that failed.
    fn run(&mut self) -> Result<Option<(Ray<'a>, Outcome)>, Failure> {
        let design = self.design;
        // Walls that are tried at once race for it.
        self.hardest.store(0, Ordering::Relaxed);
        while let Some(index) = best((0..).zip(&self.rays).map(|(n, ray)| (ray.next_merit(), n))) {
            self.go_on()?;
            let ray = self.rays.remove(index);
            let Some(outcome) = self.outcome(&ray, ray.share)? else {
                continue;
            };
            if outcome.passes {
                return self.at_the_edge(ray, outcome).map(Some);
            }
            let first = ray.candidate.filter(|_| ray.is_first());
            if let Some(n) = first {
                self.candidates[n].reason = Some(outcome.reason());
                self.candidates[n].tried_force_noise_rms_n = outcome.noise_n;
            }
            if design.wish.is_given() {
                continue;
            }
            if first.is_some() && design.force_noise_limit_n.is_none() {
                let turned = self.turned(&ray);
                self.rays.extend(turned);
            }
            let limit = self.limit_n.filter(|_| is_at_rest(&outcome.settling));
            let quieter = limit.zip(outcome.noise_n);
            let otherwise = if ray.share > SOFT { WEAKER } else { WEAKEST };
            let weaker = quieter.map_or(otherwise, |(limit, noise)| (limit / noise).max(WEAKEST));
            self.rays.push(Ray {
                share: ray.share * weaker.min(WEAKER),
                failed: ray.share,
                ..ray
            });
        }
        Ok(None)
    }

    /// Tries a share of a ray; `None` if the requirement does not allow it, or it could not hold the push.
    fn outcome(&self, ray: &Ray<'a>, share: f64) -> Result<Option<Outcome>, Failure> {
        let (design, bench) = (self.design, &ray.bench);
        let law = ray.law(share);
        let is_known = ray.candidate.is_some() && share >= 1.0;
        // Beside a hand that could hold it too, so that a ray ends.
        if !is_known && law.0 * GONE_M <= design.push_n() {
            return Ok(None);
        }
        let tried = |stretch| {
            let is_allowed = || {
                let allows = || bench.allows(share * ray.alpha, share * ray.beta);
                Ok(is_known || allows().map_err(Failure::run)?)
            };
            design.outcome(
                bench.order,
                law,
                stretch,
                self.limit_n,
                &self.hardest,
                is_allowed,
            )
        };
        let outcome = tried(LONGEST)?;
        let may_ring = is_known && design.gain_margin.is_none();
        let is_restless = |one: &Outcome| one.settling.verdict == TrialVerdict::Unstable;
        if may_ring && outcome.as_ref().is_some_and(is_restless) {
            for stretch in RINGING {
                self.go_on()?;
                if let Some(rings) = tried(stretch)?.filter(|one| one.passes) {
                    return Ok(Some(rings));
                }
            }
        }
        Ok(outcome)
    }

    /// The rays of the order of a candidate at other ratios.
    fn turned(&self, first: &Ray<'a>) -> Vec<Ray<'a>> {
        let (design, bench) = (self.design, &first.bench);
        // A spring beside a spring is one; a proof takes longer than many trials; orders between those of the grid are alike.
        if bench.order.get() <= 0.0 || design.every_motion || !design.orders.contains(&bench.order)
        {
            return Vec::new();
        }
        let ratio = Some(first.beta / first.alpha).filter(|ratio| ratio.is_normal());
        let ratio = ratio.unwrap_or(1.0);
        let mut others: Vec<i32> = OCTAVES.collect();
        others.retain(|n| *n != 0 || design.force_noise_limit_n.is_some());
        let rays = others.par_iter().map(|n| {
            // A ratio that cannot be analysed is no ray.
            let ratio = ratio * libm::exp2(f64::from(*n));
            let alpha = bench.largest_scale(1.0, ratio).ok()??;
            Ray::new(Arc::clone(bench), alpha, alpha * ratio).ok()
        });
        rays.collect::<Vec<_>>().into_iter().flatten().collect()
    }

    fn turn_all(&mut self) {
        if !self.design.wish.is_given() {
            let turned: Vec<_> = self.rays.iter().flat_map(|ray| self.turned(ray)).collect();
            self.rays.extend(turned);
        }
    }

    /// The best wall between those that passed or were not tried and those that failed, from one that passes.
    fn at_the_edge(
        &mut self,
        mut ray: Ray<'a>,
        mut outcome: Outcome,
    ) -> Result<(Ray<'a>, Outcome), Failure> {
        self.rays.push(ray.clone());
        loop {
            self.go_on()?;
            let merit = ray.next_merit();
            let near = |other: &Ray<'_>| other.failed * other.merit > merit + NEAR * merit.abs();
            let rays = (0..).zip(&self.rays).filter(|(_, other)| near(other));
            let Some(n) = best(rays.map(|(n, other)| (other.failed * other.merit, n))) else {
                return Ok((ray, outcome));
            };
            let mut other = self.rays[n].clone();
            other.share = 0.5 * (merit / other.merit + other.failed);
            let next = self.outcome(&other, other.share)?;
            match next.filter(|next| next.passes) {
                Some(next) => (ray, outcome) = (other.clone(), next),
                None => {
                    other.failed = other.share;
                    other.share *= WEAKER;
                }
            }
            self.rays[n] = other;
        }
    }

    /// The best wall around one, of other ratios and orders.
    fn refined(
        &self,
        mut ray: Ray<'a>,
        mut outcome: Outcome,
    ) -> Result<(Ray<'a>, Outcome), Failure> {
        let design = self.design;
        let is_fixed = design.every_motion || design.wish.is_given();
        if is_fixed || ray.is_first() || ray.bench.order.get() <= 0.0 {
            return Ok((ray, outcome));
        }
        loop {
            let (mut step, least) = STEPS;
            while step > least {
                match self.better_beside(&ray, step)? {
                    Some(better) => (ray, outcome) = better,
                    None => step *= 0.5,
                }
            }
            match self.better_anywhere(&ray)? {
                Some(better) => (ray, outcome) = better,
                None => return Ok((ray, outcome)),
            }
        }
    }

    /// The first wall that passes of those that are better than one, at all orders of the grid.
    fn better_anywhere(&self, ray: &Ray<'a>) -> Result<Option<(Ray<'a>, Outcome)>, Failure> {
        let places = self.benches.iter().flat_map(|bench| {
            let ratios = QUARTERS.map(move |quarters| (bench, quarters));
            ratios.flat_map(|(bench, quarters)| GAINS_OF_ALL.map(|gain| (bench, quarters, gain)))
        });
        let places: Vec<_> = places.collect();
        let better = places.par_iter().find_map_first(|(bench, quarters, gain)| {
            let octaves = 0.25 * f64::from(*quarters);
            let tried = self.go_on().and_then(|()| {
                let neighbour = ray.neighbour(Arc::clone(bench), octaves);
                neighbour.map_or(Ok(None), |neighbour| self.better(ray, neighbour, *gain))
            });
            tried.transpose()
        });
        better.transpose()
    }

    /// A wall of a ray that is better than one by this factor, if it passes.
    fn better(
        &self,
        than: &Ray<'a>,
        ray: Ray<'a>,
        gain: f64,
    ) -> Result<Option<(Ray<'a>, Outcome)>, Failure> {
        let share = gain * than.next_merit() / ray.merit;
        let outcome = self.outcome(&ray, share)?.filter(|one| one.passes);
        Ok(outcome.map(|outcome| (Ray { share, ..ray }, outcome)))
    }

    /// A better wall that passes one step from one.
    fn better_beside(
        &self,
        ray: &Ray<'a>,
        step: f64,
    ) -> Result<Option<(Ray<'a>, Outcome)>, Failure> {
        let orders: &[f64] = if self.design.finer { &[1.0, -1.0] } else { &[] };
        let ratios = [0.0, 1.0, -1.0].map(|octaves| (octaves, 0.0));
        let orders = orders.iter().map(|orders| (0.0, 0.25 * orders));
        for (octaves, orders) in ratios.into_iter().chain(orders) {
            let from = ray.bench.order;
            // In hundredths, but for one that was given.
            let moved = ((from.get() + step * orders) * 100.0).round() / 100.0;
            let order = if orders.abs() > 0.0 {
                Order::new(moved.clamp(0.01, 2.0)).map_err(Failure::input)?
            } else {
                from
            };
            let bench = if order == from {
                Arc::clone(&ray.bench)
            } else {
                Arc::new(Bench::new(self.design, order)?)
            };
            let Some(neighbour) = ray.neighbour(bench, step * octaves) else {
                continue;
            };
            for gain in GAINS {
                self.go_on()?;
                if let Some(better) = self.better(ray, neighbour.clone(), gain)? {
                    return Ok(Some(better));
                }
            }
        }
        Ok(None)
    }

    /// The best wall that passes, beside what a noisier wish would get.
    fn best(&mut self, noisier: Option<Noisier>) -> Result<Option<Found>, Failure> {
        let best = self.run()?;
        best.map(|(ray, outcome)| self.found(ray, outcome, noisier))
            .transpose()
    }

    /// The wall that is taken.
    fn found(
        &self,
        ray: Ray<'a>,
        outcome: Outcome,
        noisier: Option<Noisier>,
    ) -> Result<Found, Failure> {
        let design = self.design;
        let (ray, outcome) = self.refined(ray, outcome)?;
        let first = ray.candidate.filter(|_| ray.is_first());
        let mut wall = match first {
            Some(n) => self.candidates[n].clone(),
            None => {
                let wall = (ray.share * ray.alpha, ray.share * ray.beta, None);
                ray.bench.judged(wall).map_err(Failure::run)?
            }
        };
        wall.tried_force_noise_rms_n = outcome.noise_n;
        let (order, law) = (ray.bench.order, ray.law(ray.share));
        let rings = outcome.stretch > LONGEST;
        let mut tried = if !rings {
            design.tried(order, law.0, law.1)?
        } else {
            Tried {
                experiment: design.wall(order, law, &Try::usual(outcome.stretch)),
                settling: design.tried_once(order, law, &Try::usual(outcome.stretch))?,
            }
        };
        tried.settling.noise_n = outcome.noise_n;
        let is_over = |stretch| {
            let settling = design.tried_once(order, law, &Try::usual(stretch));
            settling.is_ok_and(|settling| settling.stable)
        };
        let rings_s = rings.then(|| {
            let until = last(outcome.stretch, LONGEST, RING_HALVINGS, is_over);
            design.plan(until).duration_s
        });
        Ok(Found {
            wall,
            tried,
            rings_s,
            noisier,
        })
    }
}

/// A push and the time of its trial, longer than usual by the factor `stretch`.
pub(super) fn plan(sample_time: Seconds, force_limit_n: f64, stretch: f64) -> TrialPlan {
    let larger = |least: (f64, f64)| least.0.max(least.1 * sample_time.0);
    TrialPlan {
        push_n: PUSH_N.min(0.25 * force_limit_n),
        duration_s: stretch * larger(DURATION),
        window_s: larger(WINDOW_LENGTH),
        force_limit_n,
        ..TrialPlan::DEFAULT
    }
}
