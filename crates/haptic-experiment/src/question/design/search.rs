//! The best wall that passes its trial.
//!
//! ```text
//! rays     (α, β) = s·(α₁, β₁), 0 < s ≤ 1: α₁ and β₁ are the strongest wall of an order that the requirement allows,
//!          first the one that the wish likes best, then those at other ratios β/α
//! next     of all orders and rays the wall that the wish likes best; where it fails, s falls by 15 %, or as far as
//!          its noise says
//! passes   it comes to rest in 5, 10 or 20 s, it is at rest after 20 s, the force varies by no more than the limit of
//!          its noise at the end of each of these trials, and the analysis of the run calls it stable
//! ```
//! - *The analysis proposes, the trial decides.* Steps of an encoder are no white noise: the loop keeps them alive, and friction, the limit
//!   of the force and a contact that never pulls are in no analysis.
//! - *The share s* of the wall that is taken is halved to its edge some times.
//! - *No wall is given up early*: a ray ends where its wall could not hold the push within the reach of a trial.
//! - *Cost*: one wall where the first passes; a hundred or more where walls of all orders fail. A wall is 25 to 35 s of simulation, six
//!   times that where it never pulls.

use super::answer::plan;
use super::bench::Bench;
use super::{Candidate, Design, Wish};
use crate::Settling;
use crate::document::failure::Failure;
use crate::experiment::trial::{Trial, TrialSetup, dynamics};
use crate::experiment::wall::WallExperiment;
use crate::judge::settling::{GONE_M, TrialVerdict};
use fracdiff::Order;
use std::sync::atomic::{AtomicBool, Ordering};

/// Lengths of a trial, in those of the usual one: of the last every wall is tried.
const STRETCHES: [f64; 3] = [1.0, 2.0, 4.0];
/// Share of a wall that failed which is tried next.
const WEAKER: f64 = 0.85;
/// The same of one that is only too noisy, at least and at most.
const QUIETER: [f64; 2] = [0.6, 0.95];
/// A force that varies by this share of what it did in a trial half as long does not come to rest.
const STILL: f64 = 0.9;
/// Share of its limit at which the noise is aimed.
const AIM: f64 = 0.97;
/// Halvings of the way to the least share that failed.
const HALVINGS: usize = 4;
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
    /// True if its strongest wall is known to be proved, as far as that is required.
    proved: bool,
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
            proved: true,
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
    tried: usize,
}

impl Design {
    /// The best wall that passes, how it did, and how many were tried; candidates whose wall failed say so.
    pub(super) fn best_that_passes(
        &self,
        candidates: &mut [Candidate],
        stop: &AtomicBool,
    ) -> Result<(Option<Found>, usize), Failure> {
        let ray = |order: usize| {
            let candidate = &candidates[order];
            let merit = self.merit(candidate)?;
            Some(Ray::new(order, candidate.alpha?, candidate.beta?, merit))
        };
        let mut search = Search {
            design: self,
            rays: (0..candidates.len()).filter_map(ray).collect(),
            candidates,
            tried: 0,
        };
        let found = search.run(stop)?;
        Ok((found, search.tried))
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
        settling.stable && limit.is_none_or(|limit| settling.noise_n <= Some(limit))
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
        let mut tried = hit(usual)?;
        let mut most = f64::INFINITY;
        for stretch in [longer, longest] {
            let varies = tried.settling.noise_n.filter(|_| tried.may_settle());
            if passes(&tried.settling) || varies.is_none_or(|varies| varies > most) {
                break;
            }
            most = STILL * varies.unwrap_or(0.0);
            tried = hit(stretch)?;
        }
        if passes(&tried.settling) {
            let long = hit(longest)?;
            if !long.settling.stable {
                return Ok(long);
            }
            let noises = [tried.settling.noise_n, long.settling.noise_n];
            tried.settling.noise_n = noises.into_iter().flatten().reduce(f64::max);
        }
        Ok(tried)
    }

    /// A device that left or beats against the force limit does not settle later.
    fn may_settle(&self) -> bool {
        self.settling.verdict <= TrialVerdict::Unstable
    }

    /// Why it does not pass, in a column's width.
    fn reason(&self) -> String {
        match self.settling.verdict {
            TrialVerdict::Stable => "too noisy when tried".to_owned(),
            TrialVerdict::HeldByFriction => "held by friction alone".to_owned(),
            other => {
                let (said, impact) = (other.words(), self.settling.impact_m_per_s);
                format!("{said} when hit at {impact} m/s")
            }
        }
    }
}

impl Search<'_> {
    fn run(&mut self, stop: &AtomicBool) -> Result<Option<Found>, Failure> {
        let mut rings = None;
        loop {
            let merits = self.rays.iter().enumerate();
            let merits = merits.map(|(index, ray)| (ray.share * ray.merit, index));
            let Some(index) = best(merits) else {
                break;
            };
            if stop.load(Ordering::Relaxed) {
                return Err(Failure::interrupted());
            }
            let mut ray = self.rays.remove(index);
            if !ray.proved {
                // It takes longer than a trial, so it is asked for when it matters.
                let proved = self
                    .bench(ray.order)?
                    .proved(ray.alpha, ray.beta)
                    .map_err(Failure::run)?;
                ray.proved = true;
                ray.share = proved.min(1.0);
                ray.failed = ray.share;
                self.rays.push(ray);
                continue;
            }
            let Some(tried) = self.try_wall(&ray, ray.share)? else {
                continue;
            };
            if self.design.passes(&tried.settling) {
                return self.at_the_edge(ray, tried).map(Some);
            }
            let candidate = &mut self.candidates[ray.order];
            let is_first = ray.share >= 1.0 && ray.is_first;
            if is_first {
                rings.get_or_insert_with(|| (candidate.clone(), tried.clone()));
                candidate.reason = Some(tried.reason());
                candidate.tried_force_noise_rms_n = tried.settling.noise_n;
            }
            if matches!(self.design.wish, Wish::Tissue { .. }) {
                continue;
            }
            if is_first {
                self.turn(ray.order)?;
            }
            let limit = self
                .design
                .force_noise_limit_n
                .filter(|_| tried.settling.stable);
            let share = limit
                .zip(tried.settling.noise_n)
                .map(|(limit, noise)| AIM * limit / noise);
            self.rays.push(Ray {
                share: ray.share
                    * share.map_or(WEAKER, |share| share.clamp(QUIETER[0], QUIETER[1])),
                failed: ray.share,
                ..ray
            });
        }
        // Proved by its passivity, and without steps that could keep it alive.
        let design = self.design;
        let is_proved = design.gain_margin.is_none() && design.device.sensors.are_ideal();
        let mut rings = rings.filter(|(_, tried)| is_proved && tried.may_settle());
        if let Some((_, tried)) = &mut rings {
            tried.experiment.setup.must_be_stable = false;
        }
        Ok(rings)
    }

    fn bench(&self, order: usize) -> Result<Bench<'_>, Failure> {
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
        let order = Order::new(self.candidates[ray.order].order).map_err(Failure::input)?;
        let bench = Bench::new(design, order)?;
        let (k, b) = bench.law(alpha, beta);
        let device = &design.device;
        let push_n = plan(device.plant.sample_time, device.force_limit_n, 1.0).push_n;
        let holds = k > 0.0 && (k + device.plant.stiffness.0) * GONE_M > push_n;
        let is_known = ray.is_first && share >= 1.0;
        if !is_known && !(holds && bench.allows(alpha, beta).map_err(Failure::run)?) {
            return Ok(None);
        }
        self.tried += 1;
        let mut tried = design.tried(order, k, b)?;
        if self.design.passes(&tried.settling) {
            // The memory of a run is as long as the run.
            let wall = &tried.experiment;
            let samples = wall.parts()?.samples;
            let analysis = wall.look(samples).verdict(dynamics(&device.plant), 0)?;
            if !analysis.stable {
                tried.settling.stable = false;
                tried.settling.verdict = TrialVerdict::Unstable;
            }
        }
        if device.sensors.are_ideal() {
            tried.settling.noise_n = None;
        }
        Ok(Some(tried))
    }

    /// Adds the rays of an order at other ratios.
    fn turn(&mut self, order: usize) -> Result<(), Failure> {
        let first = &self.candidates[order];
        let (alpha, beta) = (first.alpha.unwrap_or(0.0), first.beta.unwrap_or(0.0));
        let has_both = alpha > 0.0 && beta > 0.0;
        let ratio = if has_both { beta / alpha } else { 1.0 };
        let bench = self.bench(order)?;
        // A spring beside a spring is one.
        if bench.order.get() <= 0.0 {
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
                proved: !self.design.every_motion,
                ..Ray::new(order, alpha, beta, merit)
            })
        });
        let rays: Vec<Ray> = rays.collect();
        self.rays.extend(rays);
        Ok(())
    }

    /// The largest share of the ray that passes, from one that does.
    fn at_the_edge(
        &mut self,
        ray: Ray,
        mut tried: Tried<WallExperiment>,
    ) -> Result<Found, Failure> {
        let (mut share, mut failed) = (ray.share, ray.failed);
        let halvings = if share < failed { HALVINGS } else { 0 };
        for _ in 0..halvings {
            let middle = 0.5 * (share + failed);
            let next = self.try_wall(&ray, middle)?;
            match next.filter(|next| self.design.passes(&next.settling)) {
                Some(next) => (share, tried) = (middle, next),
                None => failed = middle,
            }
        }
        let mut found = self.candidates[ray.order].clone();
        if share < 1.0 || !ray.is_first {
            let wall = (share * ray.alpha, share * ray.beta, None);
            found = (self.bench(ray.order)?.judged(wall)).map_err(Failure::run)?;
        }
        found.tried_force_noise_rms_n = tried.settling.noise_n;
        Ok((found, tried))
    }
}
