//! The report of a designed controller: its numbers, and sentences on them.

use super::{CROSSOVER, LOOP_TIME, NOT_FLAT, PHASE_MARGIN};
use crate::words::{DesignWords, gains, margins, row_of_wish, shape};
use control_tuning::Wish;
use control_tuning::design::{ControlAnswer, ControlDesign, TunedController};
use fractional_control::ControlError;
use haptic_document::{Failure, rows};
use haptic_trial::advice::{in_degrees, refused};
use serde_json::{Value, json};

/// A controller that was designed, with the best PID of order 1 beside it.
#[derive(Clone, Debug)]
pub struct DesignedController {
    /// The wishes, and how they were tried.
    pub design: ControlDesign,
    /// The PI^λD^μ and the PID of order 1, each tuned and tried.
    pub answer: ControlAnswer,
}

/// Tunes by wishes.
///
/// # Errors
/// Wishes that no controller meets.
pub fn designed(design: ControlDesign) -> Result<DesignedController, Failure> {
    let answer = design.answer().map_err(|error| {
        let is_lost = matches!(error, ControlError::NotFound { .. });
        let failure = refused(error);
        if is_lost {
            failure.and(&format!("see {CROSSOVER}, {PHASE_MARGIN} and {NOT_FLAT}"))
        } else {
            failure
        }
    })?;
    Ok(DesignedController { design, answer })
}

/// The verdict on a loop; null for a plant that was measured, which does not run, and where nothing is proved of the plant.
fn stable(candidate: &TunedController) -> Option<bool> {
    let trial = candidate.trial.as_ref();
    let proved = trial.filter(|trial| trial.analysis.coarse.is_none());
    proved.map(|trial| trial.analysis.verdict.stable)
}

/// The loop of a controller.
fn trial(candidate: &TunedController, t: f64) -> Value {
    let Some(trial) = &candidate.trial else {
        return json!({});
    };
    let proved = trial.analysis.coarse.is_none();
    let between = trial.stable_gains.filter(|_| proved);
    let robustness = trial.robustness.iter().map(|row| {
        let gain_db = 20.0 * libm::log10(row.gain);
        let shape = row.stable.then(|| shape(&row.shape, t));
        json!({"gain_db": gain_db, "stable": row.stable, "shape": shape})
    });
    json!({
        // None of an unstable loop, nor a shape: they would mean nothing.
        "margins": trial.margins().map(margins),
        "coarse": trial.analysis.coarse,
        // Over the nominal gain of the plant.
        "stable_gain_low": between.map(|[low, _]| low),
        "stable_gain_high": between.map(|[_, high]| high),
        "robust": proved && trial.is_robust(),
        "overshoot_spread": trial.overshoot_spread(),
        "robustness": robustness.collect::<Vec<_>>(),
        "shape": trial.analysis.verdict.stable.then(|| shape(&trial.shape, t)),
        "limited_share": trial.limited_share,
    })
}

impl DesignedController {
    /// The answer in sentences.
    #[must_use]
    pub const fn words(&self) -> DesignWords<'_> {
        DesignWords(&self.answer)
    }

    /// The report for a plant in words. The keys are a contract of the command line.
    #[must_use]
    pub fn report(&self, plant: &str) -> Value {
        let (fractional, t) = (&self.answer.fractional, self.design.sample_time.0);
        let integer = self.answer.integer.as_ref().ok();
        let wish = |wish: &Wish| {
            let (name, _, in_unit) = row_of_wish(wish.name);
            let wish_of = |other: &TunedController| {
                other.wishes.iter().find(|w| w.name == wish.name).copied()
            };
            json!({
                "name": name,
                "wanted": in_unit(wish.wanted),
                "reached": in_unit(wish.reached),
                "met": wish.is_met(),
                "integer_reached": integer.and_then(wish_of).map(|other| in_unit(other.reached)),
            })
        };
        let step = fractional.trial.as_ref().map(|trial| {
            let samples = trial.step.measured.iter().zip(&trial.step.command);
            let samples = samples.enumerate().map(|(n, (output, command))| {
                json!({"time_s": n as f64 * t, "output": output, "command": command})
            });
            samples.collect::<Vec<_>>()
        });
        let asked = json!({
            "plant": plant,
            "sample_time_s": t,
            "scheme": self.design.scheme.to_string(),
            "controller": gains(&fractional.tuned.parameters),
            "specification": fractional.wishes.iter().map(wish).collect::<Vec<_>>(),
            "stable": stable(fractional),
            "notes": self.words().sentences(),
        });
        let answer = json!({
            "integer": integer.map(|other| {
                let controller = gains(&other.tuned.parameters);
                let verdict = json!({"controller": controller, "stable": stable(other)});
                Value::Object(rows([verdict, trial(other, t)]))
            }),
            "integer_reason": self.answer.integer.as_ref().err().map(in_degrees),
            "step": step.unwrap_or_default(),
        });
        Value::Object(rows([asked, trial(fractional, t), answer]))
    }

    /// Refuses an unstable loop, and a wish that is not met.
    ///
    /// # Errors
    /// As said, with the remedy.
    pub fn judge(&self) -> Result<(), Failure> {
        let trial = self.answer.fractional.trial.as_ref();
        if trial.is_some_and(|trial| !trial.analysis.verdict.stable) {
            return Err(Failure::run(format_args!(
                "the loop is not stable: lower {CROSSOVER} or shorten {LOOP_TIME}"
            )));
        }
        let unmet = self.words().unmet();
        if unmet.is_empty() {
            return Ok(());
        }
        let or = if self.design.wishes.iso_damping {
            format!(", change {PHASE_MARGIN}, or give {NOT_FLAT}")
        } else {
            format!(", or change {PHASE_MARGIN}")
        };
        Err(Failure::run(format_args!(
            "not met: {unmet}; this is the best found: allow more, move {CROSSOVER}{or}"
        )))
    }
}
