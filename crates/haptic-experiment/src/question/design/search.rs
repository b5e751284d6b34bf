//! The best wall that passes its trial.
//!
//! ```text
//! rays     (α, β) = s·(α₁, β₁), 0 < s ≤ 1: α₁ and β₁ are the strongest wall of an order that the requirement allows,
//!          first the one that the wish likes best, then those at other ratios β/α
//! next     of all orders and rays the wall that the wish likes best; where it fails, s falls by 15 %, or as far as
//!          its noise says
//! passes   it comes to rest in 5, 10 or 20 s, it is at rest after 20 s, and the force varies by no more than the limit
//!          of its noise at the end of both trials
//! ```
//! - *The analysis proposes, the trial decides.* Steps of an encoder are no white noise: the loop keeps them alive, and friction, the limit
//!   of the force and a contact that never pulls are in no analysis.
//! - *At the end* the steps of all rays that may hold a better wall are halved, until none can be better by 2 %.
//! - *No wall is given up early*: a ray ends where its wall could not hold the push within the reach of a trial.
//! - *Cost*: one wall where the first passes; a hundred or more where walls of all orders fail. A wall is 25 to 55 s of simulation, six
//!   times that where it never pulls.

use super::bench::Bench;
use super::{Candidate, Design, Wish};
use crate::document::failure::Failure;
use crate::experiment::trial::{Trial, TrialSetup};
use crate::experiment::wall::WallExperiment;
use crate::judge::settling::{GONE_M, TrialVerdict};
use crate::{Settling, TrialPlan};
use fracdiff::{Order, Seconds};
use std::sync::atomic::{AtomicBool, Ordering};

/// Push, N, as long as the device can hold four times as much.
const PUSH_N: f64 = 1.0;
/// Length of a run and of its window, s and samples: the larger of the two.
const DURATION: (f64, f64) = (5.0, 2500.0);
const WINDOW_LENGTH: (f64, f64) = (0.4, 200.0);
/// Lengths of a trial, in those of the usual one: of the last every wall is tried.
const STRETCHES: [f64; 3] = [1.0, 2.0, 4.0];
/// Share of a wall that failed which is tried next.
const WEAKER: f64 = 0.85;
/// The least such share, of one that is only too noisy.
const WEAKEST: f64 = 0.5;
/// A wall that may be better by less than this share is not looked for.
const NEAR: f64 = 0.02;
/// Ratios β/α of the rays, in those of the first wall of the order.
const RATIOS: [f64; 6] = [1.0 / 16.0, 0.25, 4.0, 16.0, 64.0, 256.0];
/// A candidate must be better by this share to win over one of lower order.
const BETTER: f64 = 1e-6;

/// A wall or coupler that was tried.
#[derive(Clone, Debug)]
pub(super) struct Tried<T> {
    pub(super) experiment: T,
    pub(super) settling: Settling,
}

/// The wall that is taken, and its trial.
type Found = (Candidate, Tried<WallExperiment>);

/// Walls of one ratio of an order.
#[derive(Clone, Copy, Debug)]
struct Ray {
    /// Index of the candidate of its order.
    order: usize,
    alpha: f64,
    beta: f64,
    merit: f64,
    /// Share that is tried next, and the least of those that failed.
    share: f64,
    failed: f64,
    /// True of the ray of the candidate itself.
    is_first: bool,
}

impl Ray {
    /// That of a candidate.
    const fn new(order: usize, alpha: f64, beta: f64, merit: f64) -> Self {
        Self {
            order,
            alpha,
            beta,
            merit,
            share: 1.0,
            failed: 1.0,
            is_first: true,
        }
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
struct Search<'a> {
    design: &'a Design,
    candidates: &'a mut [Candidate],
    rays: Vec<Ray>,
}

impl Design {
    /// The best wall that passes, and how it did; candidates whose wall failed say so.
    pub(super) fn best_that_passes(
        &self,
        candidates: &mut [Candidate],
        stop: &AtomicBool,
    ) -> Result<Option<Found>, Failure> {
        let ray = |order: usize| {
            let candidate = &candidates[order];
            let merit = self.merit(candidate)?;
            Some(Ray::new(order, candidate.alpha?, candidate.beta?, merit))
        };
        let mut search = Search {
            design: self,
            rays: (0..candidates.len()).filter_map(ray).collect(),
            candidates,
        };
        search.run(stop)
    }

    /// Tries a wall of an order: K in N/m, B in N·s^μ/m.
    pub(super) fn tried(
        &self,
        order: Order,
        k: f64,
        b: f64,
    ) -> Result<Tried<WallExperiment>, Failure> {
        let device = &self.device;
        let wall = |stretch| {
            let plan = plan(device.plant.sample_time, device.force_limit_n, stretch);
            let setup = TrialSetup {
                must_be_stable: true,
                ..TrialSetup::new(device.plant, device.sensors, plan)
            };
            WallExperiment {
                model: self.model(order).cloned(),
                contact: self.contact,
                ..WallExperiment::linear(setup, order, self.scheme, k, b)
            }
        };
        Tried::of(wall, |settling| self.passes(settling))
    }

    /// True if it is at rest and quiet.
    pub(super) fn passes(&self, settling: &Settling) -> bool {
        let limit = self.force_noise_limit_n;
        let is_quiet = |limit| settling.noise_n.is_some_and(|noise| noise <= limit);
        settling.stable && limit.is_none_or(is_quiet)
    }
}

impl<T: Trial> Tried<T> {
    /// Tries it for as long as it needs to pass, and for the longest time, which counts if it is the worse.
    pub(super) fn of(
        make: impl Fn(f64) -> T,
        passes: impl Fn(&Settling) -> bool,
    ) -> Result<Self, Failure> {
        let hit = |stretch| -> Result<Self, Failure> {
            let experiment = make(stretch);
            let settling = experiment.settled()?;
            Ok(Self {
                experiment,
                settling,
            })
        };
        let [usual, longer, longest] = STRETCHES;
        let (mut tried, mut length) = (hit(usual)?, usual);
        for stretch in [longer, longest] {
            // A device that left or beats against the force limit does not settle later.
            if passes(&tried.settling) || tried.settling.verdict > TrialVerdict::Unstable {
                break;
            }
            (tried, length) = (hit(stretch)?, stretch);
        }
        if length < longest && passes(&tried.settling) {
            let long = hit(longest)?;
            if !long.settling.stable {
                return Ok(long);
            }
            let noises = [tried.settling.noise_n, long.settling.noise_n];
            tried.settling.noise_n = noises.into_iter().flatten().reduce(f64::max);
        }
        Ok(tried)
    }

    /// Why it does not pass, in a column's width.
    pub(super) fn reason(&self) -> String {
        match self.settling.verdict {
            TrialVerdict::Stable => "too noisy when tried".to_owned(),
            TrialVerdict::HeldByFriction => "held by friction alone".to_owned(),
            TrialVerdict::Unstable => "not at rest when tried".to_owned(),
            other @ (TrialVerdict::Saturated
            | TrialVerdict::Untouched
            | TrialVerdict::Gone
            | TrialVerdict::Unfinished) => format!("{} when tried", other.words()),
        }
    }
}

impl<'a> Search<'a> {
    fn run(&mut self, stop: &AtomicBool) -> Result<Option<Found>, Failure> {
        let design = self.design;
        while let Some(index) = best(
            (0..)
                .zip(&self.rays)
                .map(|(n, ray)| (ray.share * ray.merit, n)),
        ) {
            if stop.load(Ordering::Relaxed) {
                return Err(Failure::interrupted());
            }
            let ray = self.rays.remove(index);
            let Some(tried) = self.try_wall(&ray, ray.share)? else {
                continue;
            };
            if design.passes(&tried.settling) {
                return self.at_the_edge(ray, tried).map(Some);
            }
            let candidate = &mut self.candidates[ray.order];
            let is_first = ray.share >= 1.0 && ray.is_first;
            if is_first {
                candidate.reason = Some(tried.reason());
                candidate.tried_force_noise_rms_n = tried.settling.noise_n;
            }
            if matches!(design.wish, Wish::Tissue { .. }) {
                continue;
            }
            if is_first {
                self.turn(ray.order)?;
            }
            let limit = design.force_noise_limit_n.filter(|_| tried.settling.stable);
            let quieter = limit.zip(tried.settling.noise_n);
            let weaker = quieter.map_or(WEAKER, |(limit, noise)| (limit / noise).max(WEAKEST));
            self.rays.push(Ray {
                share: ray.share * weaker.min(WEAKER),
                failed: ray.share,
                ..ray
            });
        }
        Ok(None)
    }

    fn bench(&self, order: usize) -> Result<Bench<'a>, Failure> {
        let order = Order::new(self.candidates[order].order).map_err(Failure::input)?;
        Bench::new(self.design, order)
    }

    /// Tries a share of a ray; `None` if the requirement does not allow it, or it could not hold the push.
    fn try_wall(
        &mut self,
        ray: &Ray,
        share: f64,
    ) -> Result<Option<Tried<WallExperiment>>, Failure> {
        let design = self.design;
        let (alpha, beta) = (share * ray.alpha, share * ray.beta);
        let bench = self.bench(ray.order)?;
        let (k, b) = bench.law(alpha, beta);
        let device = &design.device;
        let push_n = plan(device.plant.sample_time, device.force_limit_n, 1.0).push_n;
        // Beside a hand that could hold it too, so that a ray ends.
        let holds = k * GONE_M > push_n;
        let is_known = ray.is_first && share >= 1.0;
        if !(is_known || holds && bench.allows(alpha, beta).map_err(Failure::run)?) {
            return Ok(None);
        }
        let mut tried = design.tried(bench.order, k, b)?;
        if device.sensors.are_ideal() {
            tried.settling.noise_n = None;
        }
        Ok(Some(tried))
    }

    /// Adds the rays of an order at other ratios.
    fn turn(&mut self, order: usize) -> Result<(), Failure> {
        let first = &self.candidates[order];
        let ratio = (first.alpha.zip(first.beta)).map(|(alpha, beta)| beta / alpha);
        let ratio = ratio.filter(|ratio| ratio.is_normal()).unwrap_or(1.0);
        let bench = self.bench(order)?;
        // A spring beside a spring is one; a proof takes longer than many trials.
        if bench.order.get() <= 0.0 || self.design.every_motion {
            return Ok(());
        }
        let rays = RATIOS.into_iter().filter_map(|times| {
            // A ratio that cannot be analysed is no ray.
            let alpha = bench.largest_scale(1.0, times * ratio).ok()??;
            let beta = alpha * times * ratio;
            let damping = bench.effective_damping(alpha, beta).ok()?;
            let merit = damping.unwrap_or_else(|| bench.law(alpha, beta).0);
            Some(Ray {
                is_first: false,
                ..Ray::new(order, alpha, beta, merit)
            })
        });
        let rays: Vec<Ray> = rays.collect();
        self.rays.extend(rays);
        Ok(())
    }

    /// The best wall between those that passed or were not tried and those that failed, from one that passes.
    fn at_the_edge(
        &mut self,
        mut ray: Ray,
        mut tried: Tried<WallExperiment>,
    ) -> Result<Found, Failure> {
        self.rays.push(ray);
        loop {
            let merit = ray.share * ray.merit;
            let near = |other: &Ray| other.failed * other.merit > merit + NEAR * merit.abs();
            let rays = (0..).zip(&self.rays).filter(|(_, other)| near(other));
            let Some(n) = best(rays.map(|(n, other)| (other.failed * other.merit, n))) else {
                break;
            };
            let mut other = self.rays[n];
            other.share = 0.5 * (merit / other.merit + other.failed);
            let next = self.try_wall(&other, other.share)?;
            match next.filter(|next| self.design.passes(&next.settling)) {
                Some(next) => (ray, tried) = (other, next),
                None => other.failed = other.share,
            }
            self.rays[n] = other;
        }
        let mut found = self.candidates[ray.order].clone();
        if ray.share < 1.0 || !ray.is_first {
            let wall = (ray.share * ray.alpha, ray.share * ray.beta, None);
            found = (self.bench(ray.order)?.judged(wall)).map_err(Failure::run)?;
        }
        found.tried_force_noise_rms_n = tried.settling.noise_n;
        Ok((found, tried))
    }
}

/// A push and how long it is looked at, so many times as long as usual.
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
