//! Questions of a session about laws: which may be felt, and which may become one another in the hand.

use super::{
    Allowed, Course, NOT_ALLOWED, Session,
    opening::{law_keys, wall},
};
use crate::live::orders::locked;
use haptic_analysis::Dynamics;
use haptic_document::{Document, Failure, Named as _, bad_input, parameters::CONTROLLER};
use haptic_judge::{
    law_region::{LawRegion, prove_mix},
    wall::WallTrial,
};
use haptic_trial::in_hand::{
    hand::{HAND_DAMPING, HAND_STIFFNESS},
    law::{HORIZON, refuse_unstable},
};

impl Session {
    /// Judges walls, each with the keys of a `[wall]` for its law, on this device, free and in a hand. All may be felt, or none; the number
    /// of the first.
    ///
    /// # Errors
    /// The first that may not be felt, by its place among them, and why.
    pub fn allow(&self, walls: &[Document]) -> Result<usize, Failure> {
        self.goes_on()?;
        let judged = walls.iter().enumerate().map(|(place, wall)| {
            let judged = self.law_of(wall).and_then(|trial| self.judged(trial));
            judged.map_err(|failure| bad_input!("wall {place}: {failure}"))
        });
        let judged = judged.collect::<Result<Vec<Allowed>, Failure>>()?;
        let mut course = locked(&self.course);
        let first = course.allowed.len();
        course.allowed.extend(judged);
        Ok(first)
    }

    /// The law of its keys on this device.
    fn law_of(&self, law: &Document) -> Result<WallTrial, Failure> {
        if let Some(other) = law
            .given()
            .find(|given| law_keys().all(|key| key != *given))
        {
            if other == CONTROLLER.key {
                return Err(bad_input!(
                    "{other} cannot be felt in a session: its memory follows the force that was sent, which no law has alone while two fade or \
                     energy runs out, so no change could be proved; give a wall or a tissue, and judge a controller by [zwidth]"
                ));
            }
            let keys: Vec<&str> = law_keys().collect();
            return Err(bad_input!(
                "{other} is not a key of a wall to feel: give some of {}",
                keys.join(", ")
            ));
        }
        Ok(wall(&self.base.with(law)?)?.trial)
    }

    /// The device behind the line, free and in a hand.
    fn devices(&self) -> [Dynamics; 2] {
        let free = Dynamics {
            delay_s: self.dynamics.delay_s + self.line as f64 * self.t.0,
            ..self.dynamics
        };
        let held = Dynamics {
            damping_n_s_per_m: free.damping_n_s_per_m + HAND_DAMPING.0,
            hand_stiffness_n_per_m: free.hand_stiffness_n_per_m + HAND_STIFFNESS.0,
            ..free
        };
        [free, held]
    }

    fn judged(&self, trial: WallTrial) -> Result<Allowed, Failure> {
        let [free, held] = self.devices();
        let (felt, free) = trial.judged_law(HORIZON, free, 0)?;
        refuse_unstable(&free)?;
        refuse_unstable(&trial.look(HORIZON).verdict(held, 0)?)?;
        let tissue = trial.tissue.as_ref().map(|piece| {
            let model = &piece.material.model;
            let numbers = model.parameters().into_iter();
            let numbers = numbers.map(|(parameter, value)| format!("{} {value}", parameter.name));
            let numbers: Vec<String> = numbers.collect();
            format!(
                "tissue {} ({}: {}), ",
                piece.material.name,
                model.kind().name(),
                numbers.join(", ")
            )
        });
        let words = format!(
            "{}order {}, K {} N/m, B {} N·s^μ/m, scheme {}, contact {}",
            tissue.unwrap_or_default(),
            trial.order,
            trial.stiffness_n_per_m,
            trial.dissipation_n_s_mu_per_m,
            trial.scheme,
            trial.contact.name()
        );
        Ok(Allowed {
            law: felt,
            trial,
            words,
        })
    }

    /// Proves all laws between two, and all mixes of two of them, stable on this device, free and in a hand. Each may be felt then. Passivity,
    /// in every hand there may be, is proved neither here nor by [`allow`](Self::allow).
    ///
    /// # Errors
    /// Two that are not of one kind; a region that is not proved, with the largest part of it that is.
    pub fn allow_between(&self, ends: [&Document; 2]) -> Result<(), Failure> {
        self.goes_on()?;
        let [first, second] = ends;
        let region = LawRegion::new([self.law_of(first)?, self.law_of(second)?])?;
        region.prove(&self.devices())?;
        locked(&self.course).regions.push(region);
        Ok(())
    }

    /// The number of a law that lies in a region: it may be felt.
    ///
    /// # Errors
    /// A law outside of what was allowed, with the nearest that is inside.
    pub fn inside(&self, law: &Document) -> Result<usize, Failure> {
        self.goes_on()?;
        let trial = self.law_of(law)?;
        let mut course = locked(&self.course);
        let mut nearest: Option<(String, f64)> = None;
        for region in &course.regions {
            match region.holds(&trial) {
                Some(Ok(())) => {
                    // Its own operator is judged too: the proof is of one without a tolerance.
                    let allowed = self.judged(trial)?;
                    course.allowed.push(allowed);
                    return Ok(course.allowed.len() - 1);
                }
                Some(Err(off)) if nearest.as_ref().is_none_or(|known| off.1 < known.1) => {
                    nearest = Some(off);
                }
                Some(Err(_)) | None => {}
            }
        }
        Err(Failure::bad_input(match nearest {
            Some((nearest, _)) => format!(
                "this wall is outside of what was allowed: the nearest inside has {nearest}"
            ),
            None => NOT_ALLOWED.to_owned(),
        }))
    }

    /// Proves what is felt while the law of a stimulus becomes another.
    pub(super) fn prove_change(
        &self,
        course: &mut Course,
        stimulus: u64,
        to: usize,
    ) -> Result<(), Failure> {
        let Some(&from) = course.stimuli.get((stimulus as usize).wrapping_sub(1)) else {
            return Ok(());
        };
        let pair = [from.min(to), from.max(to)];
        if from == to || course.mixes.contains(&pair) {
            return Ok(());
        }
        let [one, other] = pair.map(|law| course.allowed[law].trial.look(HORIZON));
        prove_mix([&one, &other], &self.devices())?;
        course.mixes.insert(pair);
        Ok(())
    }
}
