//! The answer: each order, the best of them tried, and its experiment file.

use crate::bench::{AskedDevice, for_each_order};
use crate::design::bench::Bench;
use crate::design::search::{Found, best};
use crate::design::{
    Candidate, ControllerVerdict, DesignReport, FORCE_NOISE_LIMIT, RealisticTrial, TissueVerdict,
    WallDesign, WallWish,
};
use fracdiff::{Order, Scheme};
use haptic_document::parameters::Parameter;
use haptic_document::{Failure, lines_of, parameters as p};
use haptic_judge::preflight::WallContact;
use haptic_judge::setup::TrialSetup;
use haptic_judge::wall::WallTrial;
use haptic_loop::plant::MassDamperConfig;
use haptic_quantity::written;
use haptic_trial::DeviceModel;
use haptic_trial::keys::trial::{PUSH, TRIAL_FORCE_LIMIT, WINDOW};
use haptic_trial::keys::wall::{DISSIPATION, ORDER, STIFFNESS};
use std::cmp::Ordering;
use std::path::Path;
use std::sync::atomic::AtomicBool;

impl WallDesign {
    /// Answers it; `progress` hears of each order that is done, `stop` ends it before the next.
    ///
    /// # Errors
    /// A design that was stopped, or a loop that cannot be analysed.
    pub fn answer(
        &self,
        stop: &AtomicBool,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<DesignReport, Failure> {
        let mut candidates = self.candidates(stop, progress)?;
        let found = self.best_that_passes(&mut candidates, stop)?;
        let best = found.as_ref().map(|found| found.wall.clone());
        let imperfections = self.device.imperfections();
        let realistic = match &found {
            Some(found) if imperfections.is_ideal() => Some(self.realistic(found)?),
            _ => None,
        };
        let fits = found.as_ref().is_some_and(|found| {
            (candidates.first()).is_some_and(|first| first.order == found.wall.order)
                && realistic.is_none_or(|real| real.simulated.stable)
        });
        Ok(DesignReport {
            asked: AskedDevice::of(&self.device.plant),
            notes: self.notes(&candidates, found.as_ref()),
            tissue: self.tissue_verdict(&candidates, fits),
            controller: self.controller_verdict(&candidates, fits)?,
            wish: self.wish.name(),
            require: match self.gain_margin {
                None => "passive",
                Some(_) if self.every_motion => "every-motion",
                Some(_) => "stable",
            },
            requirement: self.requirement(),
            gain_margin: self.gain_margin,
            frequency_hz: self.wish.frequency_hz(),
            scheme: self.scheme.to_string(),
            contact: self.contact,
            force_noise_limit_n: self.noise_limit_n(),
            trials: found.as_ref().map(|found| self.trials_in_words(found)),
            rings_s: found.as_ref().and_then(|found| found.rings_s),
            noisier: found.as_ref().and_then(|found| found.noisier),
            ideal_device_assumed: imperfections.is_ideal(),
            imperfections,
            realistic,
            candidates: candidates.into_iter().map(|one| self.shown(one)).collect(),
            best: best.map(|best| self.shown(best)),
            simulated: found.as_ref().map(|found| found.tried.settling),
            // A wall file knows no models.
            experiment_text: found
                .map(|found| found.tried.experiment)
                .filter(|wall| wall.model.is_none() && wall.controller.is_none())
                .map(|wall| self.experiment_file(&wall)),
        })
    }

    /// The candidates by their order, that of a tissue first; if no orders were given, the steps beside the best are halved some times.
    fn candidates(
        &self,
        stop: &AtomicBool,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<Vec<Candidate>, Failure> {
        let judged = |orders: &[Order]| {
            for_each_order(orders, stop, progress, |order| {
                // An order that cannot be analysed does not spoil the others.
                let candidate = Bench::new(self, order)?.candidate();
                Ok(candidate.unwrap_or_else(|error| Candidate {
                    order: Some(order.get()),
                    reason: Some(error.to_string()),
                    ..Candidate::default()
                }))
            })
        };
        let mut candidates = judged(&self.orders_to_try())?;
        let fixed = usize::from(self.wish.is_given());
        for _ in 0..self.halvings() {
            let Some(best) = self.best(&candidates).and_then(|best| best.order) else {
                break;
            };
            let finer = half_way(best, &candidates);
            candidates.extend(judged(&finer)?);
            candidates[fixed..]
                .sort_by(|a, b| a.order.partial_cmp(&b.order).unwrap_or(Ordering::Equal));
        }
        Ok(candidates)
    }

    /// Merit of a candidate, as the wish measures it.
    pub(super) fn merit(&self, candidate: &Candidate) -> Option<f64> {
        candidate.stiffness_n_per_m?;
        let is_taken = match self.contact {
            WallContact::Linear => true,
            WallContact::OneSided => candidate.reason.is_none(),
            WallContact::Signed => {
                candidate.pulling_contact_margin >= Some(1.0)
                    && candidate.stiffness_n_per_m > Some(0.0)
            }
        };
        if !is_taken {
            return None;
        }
        match &self.wish {
            WallWish::StiffestWall => candidate.stiffness_n_per_m,
            WallWish::MostDamping { .. } => candidate.effective_damping_n_s_per_m,
            WallWish::Tissue { material, .. } => candidate
                .largest_scale
                .filter(|scale| *scale >= 1.0)
                .zip(candidate.order)
                .map(|(_, order)| -(order - material.order().get()).abs()),
            WallWish::Controller(_) => candidate.reason.is_none().then_some(0.0),
        }
    }

    fn best<'c>(&self, candidates: &'c [Candidate]) -> Option<&'c Candidate> {
        best((candidates.iter()).filter_map(|candidate| Some((self.merit(candidate)?, candidate))))
    }

    fn tissue_verdict(&self, candidates: &[Candidate], fits: bool) -> Option<TissueVerdict> {
        let WallWish::Tissue { material, .. } = &self.wish else {
            return None;
        };
        let first = candidates.first()?;
        Some(TissueVerdict {
            name: material.name.clone(),
            order: first.order?,
            fits,
            largest_scale: first.largest_scale,
        })
    }

    fn controller_verdict(
        &self,
        candidates: &[Candidate],
        fits: bool,
    ) -> Result<Option<ControllerVerdict>, Failure> {
        let (Some(controller), Some(found)) = (self.wish.controller(), candidates.first()) else {
            return Ok(None);
        };
        let scales = match found.alpha.zip(found.beta) {
            Some((alpha, beta)) => Bench::new(self, self.orders[0])?.stable_scales(alpha, beta),
            None => Ok(None),
        };
        let scales = scales.map_err(Failure::run)?;
        let largest = found.largest_scale.map(|scale| controller.scaled(scale));
        Ok(Some(ControllerVerdict {
            law: controller.setup.law.to_string(),
            fits,
            largest_scale: found.largest_scale,
            analysis_scale_from: scales.and_then(|(from, _)| from),
            largest: largest.and_then(|setup| Some(setup.ok()?.law.to_string())),
        }))
    }

    /// A candidate as a report has it: a controller is no point among walls.
    fn shown(&self, candidate: Candidate) -> Candidate {
        match self.wish.controller() {
            None => candidate,
            Some(_) => Candidate {
                order: None,
                stiffness_n_per_m: None,
                dissipation_n_s_mu_per_m: None,
                alpha: None,
                beta: None,
                ..candidate
            },
        }
    }

    /// Notes for the designer beside the numbers.
    fn notes(&self, candidates: &[Candidate], found: Option<&Found>) -> Vec<String> {
        let mut notes = Vec::new();
        let best = found.map(|found| &found.wall);
        let plant = &self.device.plant;
        let acts_at_once = plant.delay.0 + plant.current_lag.0 <= 0.0;
        if best.is_none() {
            let first = candidates.iter().find_map(|found| found.reason.as_deref());
            notes.push(first.unwrap_or("nothing does it").to_owned());
        } else if (candidates.iter()).any(|one| one.alpha.is_some() && one.reason.is_some()) {
            notes.push(
                "stronger walls fail: this is the best of those searched that passes its trials"
                    .to_owned(),
            );
        } else if self.gain_margin.is_none() && self.wish == WallWish::StiffestWall && acts_at_once
        {
            notes.push(
                "without delay no dissipation makes a passive wall stiffer: K is 2b/T for every order"
                    .to_owned(),
            );
        }
        notes.extend(found.and_then(|found| self.on_noise(found)));
        notes.extend(found.and_then(|found| found.rings_s).map(|rings_s| {
            format!("proved, but it rings: pushed and hit it is at rest after {rings_s:.0} s")
        }));
        if best.is_some() && self.wish.controller().is_some() {
            notes.push("no experiment file: a wall has no controller".to_owned());
        }
        if found.is_some_and(|found| found.tried.experiment.model.is_some()) {
            notes.push(
                "no experiment file: a wall has one spring-pot, and this tissue has more elements; relax and creep can render it"
                    .to_owned(),
            );
        }
        notes
    }

    /// The limit that nobody asked for, and the wall that a noisier wish would get.
    fn on_noise(&self, found: &Found) -> Option<String> {
        let limit_n = self.noise_limit_n()?;
        if self.force_noise_limit_n.is_some() {
            return None;
        }
        let without = match &found.noisier {
            Some(noisier) => format!(
                "without it {} of order {} with {} of noise passes: give {FORCE_NOISE_LIMIT}",
                written("stiffness_n_per_m", noisier.stiffness_n_per_m),
                noisier.order,
                written("noise_n", noisier.tried_force_noise_rms_n.unwrap_or(0.0)),
            ),
            None => "without it nothing is better".to_owned(),
        };
        Some(format!(
            "no limit on noise was given, so 5 % of the push is one, {}; {without}",
            written("limit_n", limit_n)
        ))
    }

    /// The trials that the best wall passed.
    fn trials_in_words(&self, found: &Found) -> String {
        let seeds = if self.device.sensors.are_ideal() {
            ""
        } else if self.is_noisy() {
            "five of five seeds of the noise at "
        } else {
            "five of five places between two encoder steps at "
        };
        let push_n = self.push_n();
        let [least, most] = [0.5, 2.0].map(|push| written("push_n", push * push_n));
        let noise_n = found.wall.tried_force_noise_rms_n;
        let worst = noise_n.map_or_else(String::new, |noise| {
            format!(", worst {}", written("noise_n", noise))
        });
        format!("{seeds}six of six pushes, {least} to {most}{worst}")
    }

    /// Trial of the candidate on the device `laboratory`.
    fn realistic(&self, found: &Found) -> Result<RealisticTrial, Failure> {
        let mut real = self.clone();
        let laboratory = DeviceModel::find(Path::new(p::LABORATORY));
        let laboratory = laboratory?.values;
        real.device.plant = MassDamperConfig {
            mass: self.device.plant.mass,
            damping: self.device.plant.damping,
            stiffness: self.device.plant.stiffness,
            ..laboratory.free(self.device.plant.sample_time)
        };
        real.device.sensors = laboratory.sensors();
        let bench = Bench::new(&real, found.tried.experiment.order)?;
        let best = &found.wall;
        let (alpha, beta) = (best.alpha.unwrap_or(0.0), best.beta.unwrap_or(0.0));
        let (k, b) = bench.law(alpha, beta);
        let (analysis_stable, margin) =
            bench.stable_and_margin(alpha, beta).map_err(Failure::run)?;
        Ok(RealisticTrial {
            imperfections: real.device.imperfections(),
            analysis_stable,
            margin,
            force_noise_rms_n: bench.force_noise_n(alpha, beta),
            simulated: real.tried(bench.order, k, b)?.settling,
        })
    }

    /// The requirement for a wall, in words.
    fn requirement(&self) -> String {
        match self.gain_margin {
            Some(margin) if self.every_motion => {
                let of = match self.contact {
                    WallContact::Signed => "",
                    WallContact::Linear | WallContact::OneSided => " of contact that may pull",
                };
                format!("proved for every motion{of}, stable with a gain margin of {margin}")
            }
            Some(margin) => format!("stable with a gain margin of {margin}"),
            None => "passive".to_owned(),
        }
    }

    /// The experiment file of a wall that was tried.
    fn experiment_file(&self, wall: &WallTrial) -> String {
        let head = format!(
            "# Written by host-cli design: {}, {}.\n\
             # host-cli run FILE tries the wall; it ends with 0 only if trial and analysis call it stable.\n\
             [wall]\n{}",
            self.wish.name(),
            self.requirement(),
            match self.contact {
                WallContact::Linear => "",
                WallContact::OneSided => "one_sided = true\n",
                WallContact::Signed => "contact = \"signed\"\n",
            }
        );
        let law = [
            (ORDER, wall.order.get()),
            (STIFFNESS, wall.stiffness_n_per_m),
            (DISSIPATION, wall.dissipation_n_s_mu_per_m),
        ];
        head + &keys(&wall.setup, wall.scheme, &law)
    }
}

/// The orders half way from one to its neighbours, in hundredths, that are not among them.
fn half_way(order: f64, candidates: &[Candidate]) -> Vec<Order> {
    let orders = || candidates.iter().filter_map(|candidate| candidate.order);
    let below = orders().filter(|other| *other < order).reduce(f64::max);
    let above = orders().filter(|other| *other > order).reduce(f64::min);
    let neighbours = [below, above].into_iter().flatten();
    let tried: Vec<Order> = orders().flat_map(Order::new).collect();
    neighbours
        .flat_map(|other| Order::new((50.0 * (order + other)).round() / 100.0))
        .filter(|middle| !tried.contains(middle))
        .collect()
}

/// An experiment that was tried as keys of its file: the device, the law, the trial.
pub(super) fn keys(setup: &TrialSetup, scheme: Scheme, law: &[(Parameter, f64)]) -> String {
    let (device, sensors, plan) = (&setup.device, &setup.sensors, &setup.plan);
    let device = lines_of([
        (p::MASS, device.mass.0),
        (p::DAMPING, device.damping.0),
        (p::HAND_STIFFNESS, device.stiffness.0),
        (p::SAMPLE_TIME, device.sample_time.0),
        (p::DELAY, device.delay.0),
        (p::CURRENT_LAG, device.current_lag.0),
        (p::FRICTION, device.friction.0),
        (p::ENCODER_RESOLUTION, sensors.encoder_resolution_m),
        (p::SENSOR_NOISE, sensors.noise_m),
        (TRIAL_FORCE_LIMIT, plan.force_limit_n),
    ]);
    let trial = lines_of([
        (PUSH, plan.push_n),
        (p::TRIAL_DURATION, plan.duration_s),
        (WINDOW, plan.window_s),
    ]);
    format!(
        "{device}seed = {}\n\nscheme = \"{scheme}\"\n{}\n{trial}must_be_stable = {}\n",
        sensors.seed,
        lines_of(law.iter().copied()),
        setup.must_be_stable
    )
}
