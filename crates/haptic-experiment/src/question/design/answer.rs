//! The answer: each order, the best of them, and what to know of it.

use super::candidate::{Candidate, DesignReport, TissueVerdict};
use super::question::{Design, Requirement, Wish};
use crate::document::failure::Failure;
use crate::question::asked_device::AskedDevice;
use fracdiff::Order;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// A candidate must be better by this share to win over one of lower order.
const BETTER: f64 = 1e-6;

/// Ends a design that is to stop.
///
/// # Errors
/// If it is.
pub(super) fn goes_on(stop: &AtomicBool) -> Result<(), Failure> {
    match stop.load(Ordering::Relaxed) {
        true => Err(Failure::Run(anyhow::anyhow!("interrupted"))),
        false => Ok(()),
    }
}

impl Design {
    /// Answers it; `progress` hears of each order that is done.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn answer(&self, progress: &(dyn Fn(u64) + Sync)) -> Result<DesignReport, Failure> {
        self.answer_unless(&AtomicBool::new(false), progress)
    }

    /// The same; `stop` ends it before the next order.
    ///
    /// # Errors
    /// A parameter outside its range; a stop.
    pub fn answer_unless(
        &self,
        stop: &AtomicBool,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<DesignReport, Failure> {
        self.check()?;
        let candidates = self
            .orders_to_try()
            .par_iter()
            .map(|&order| {
                goes_on(stop)?;
                let candidate = self.candidate(order);
                progress(1);
                candidate
            })
            .collect::<Result<Vec<_>, _>>()?;
        goes_on(stop)?;
        let best = self.best(&candidates).cloned();
        let trial = best.as_ref().map(|best| self.trial(best)).transpose()?;
        let imperfections = self.device.imperfections();
        let realistic = match &best {
            Some(best) if imperfections.is_ideal() => Some(self.beside(best)?),
            _ => None,
        };
        Ok(DesignReport {
            asked: AskedDevice::of(&self.device.plant),
            notes: self.notes(&candidates, best.as_ref()),
            tissue: self.tissue_verdict(&candidates),
            wish: self.wish.name().to_owned(),
            require: self.requirement.name().to_owned(),
            gain_margin: self.requirement.gain_margin(),
            frequency_hz: self.wish.frequency_hz(),
            scheme: self.scheme.to_string(),
            stiffness_unit: "N/m",
            dissipation_unit: "N·s^μ/m",
            force_noise_limit_n: self.force_noise_limit_n,
            ideal_device_assumed: imperfections.is_ideal(),
            imperfections,
            realistic,
            candidates,
            best,
            simulated: trial.as_ref().map(|(_, settling)| *settling),
            // A wall file knows no models.
            experiment_text: trial
                .filter(|(wall, _)| wall.model.is_none())
                .map(|(wall, _)| self.experiment_file(&wall)),
            experiment: None,
            files: Vec::new(),
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

    /// Merit of a candidate, as the wish measures it.
    fn merit(&self, candidate: &Candidate) -> Option<f64> {
        candidate.stiffness?;
        match &self.wish {
            Wish::StiffestWall => candidate.stiffness,
            Wish::MostDamping { .. } => candidate.effective_damping_n_s_per_m,
            Wish::Tissue { material, .. } => candidate
                .largest_scale
                .filter(|scale| *scale >= 1.0)
                .map(|_| -(candidate.order - material.order().get()).abs()),
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

    /// Notes for the designer beside the numbers.
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
        let order = best.and_then(|best| Order::new(best.order).ok());
        if order.is_some_and(|order| self.model(order).is_some()) {
            notes.push(
                "no experiment file: a wall has one spring-pot, this tissue more elements; relax and creep render it"
                    .to_owned(),
            );
        }
        notes
    }
}
