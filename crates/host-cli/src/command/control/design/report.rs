//! The report of a design: its numbers, and what they mean in sentences.

use crate::command::analyze::resolved::decibel;
use crate::command::control::words::{in_degrees, margins, pid, shape};
use crate::output::joined;
use fractional_control::design::{
    Candidate, ControlAnswer, ControlDesign, ROBUST_GAINS, Trial, Wish, WishName,
};
use haptic_experiment::Failure;
use haptic_quantity::digits;
use serde_json::{Value, json};
use std::f64::consts::LN_10;

pub(super) struct Report<'a> {
    pub(super) design: &'a ControlDesign,
    pub(super) answer: &'a ControlAnswer,
}

/// Key and words of a wish, and its value in the unit of the key.
fn row(name: WishName) -> (&'static str, &'static str, fn(f64) -> f64) {
    let same: fn(f64) -> f64 = |value| value;
    match name {
        WishName::Crossover => ("crossover_rad_s", "crossover / rad/s", same),
        WishName::PhaseMargin => ("phase_margin_deg", "phase margin / °", f64::to_degrees),
        WishName::IsoDamping => (
            "phase_slope_deg_per_decade",
            "slope of the phase / °/decade",
            |slope| (slope * LN_10).to_degrees(),
        ),
        WishName::SensitivityPeak => ("sensitivity_peak", "largest |S|", same),
        WishName::ComplementaryPeak => ("complementary_peak", "largest |T|", same),
        WishName::Noise => ("noise", "|T| above the noise's frequency", same),
        _ => ("disturbance", "|S| below the disturbance's frequency", same),
    }
}

/// The verdict on a loop; null for a plant that was measured, which does not run, and where nothing is proved of the plant.
fn stable(candidate: &Candidate) -> Option<bool> {
    let trial = candidate.trial.as_ref();
    let proved = trial.filter(|trial| trial.coarse.is_none());
    proved.map(|trial| trial.verdict.stable)
}

/// The loop of a controller.
fn trial(candidate: &Candidate, t: f64) -> Value {
    let Some(trial) = &candidate.trial else {
        return json!({});
    };
    let proved = trial.coarse.is_none();
    let gains = trial.stable_gains.filter(|_| proved);
    let robustness = trial.robustness.iter().map(|row| {
        let gain_db = decibel(row.gain);
        let shape = row.stable.then(|| shape(&row.shape, t));
        json!({"gain_db": gain_db, "stable": row.stable, "shape": shape})
    });
    json!({
        // None of an unstable loop, nor a shape: they would mean nothing.
        "margins": (proved && trial.verdict.stable).then(|| margins(&trial.margins)),
        "coarse": trial.coarse,
        // Over the nominal gain of the plant.
        "stable_gain_low": gains.map(|[low, _]| low),
        "stable_gain_high": gains.map(|[_, high]| high),
        "robust": proved && trial.is_robust(),
        "overshoot_spread": trial.overshoot_spread(),
        "robustness": robustness.collect::<Vec<_>>(),
        "shape": trial.verdict.stable.then(|| shape(&trial.shape, t)),
        "limited_share": trial.limited_share,
    })
}

impl Report<'_> {
    fn own(&self) -> &Candidate {
        &self.answer.fractional
    }

    fn integer(&self) -> Option<&Candidate> {
        self.answer.integer.as_ref().ok()
    }

    pub(super) fn value(&self, plant: &str, controller: Option<&str>, files: &[String]) -> Value {
        let (own, integer, t) = (self.own(), self.integer(), self.design.sample_time.0);
        let wish = |wish: &Wish| {
            let (name, _, in_unit) = row(wish.name);
            let of = |other: &Candidate| other.wishes.iter().find(|w| w.name == wish.name).copied();
            json!({
                "name": name,
                "wanted": in_unit(wish.wanted),
                "reached": in_unit(wish.reached),
                "met": wish.is_met(),
                "integer_reached": integer.and_then(of).map(|other| in_unit(other.reached)),
            })
        };
        let step = own.trial.as_ref().map(|trial| {
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
            "controller": pid(own.tuned.parameters),
            "specification": own.wishes.iter().map(wish).collect::<Vec<_>>(),
            "stable": stable(own),
            "notes": self.sentences(),
        });
        let beside = json!({
            "integer": integer.map(|other| {
                let controller = pid(other.tuned.parameters);
                let verdict = json!({"controller": controller, "stable": stable(other)});
                joined([verdict, trial(other, t)])
            }),
            "integer_reason": self.answer.integer.as_ref().err().map(in_degrees),
            "step": step.unwrap_or_default(),
            "controller_file": controller,
            "files": files,
        });
        joined([asked, trial(own, t), beside])
    }

    /// Wishes that are not met, and a loop that is not robust, for the controller file.
    pub(super) fn note(&self) -> String {
        let unmet = Some(self.unmet()).filter(|unmet| !unmet.is_empty());
        let parts = unmet.map(|unmet| format!("not met: {unmet}"));
        let parts: Vec<String> = parts.into_iter().chain(self.fragile()).collect();
        parts.join("; ")
    }

    fn unmet(&self) -> String {
        let missed = self.own().wishes.iter().filter(|wish| !wish.is_met());
        let words = missed.map(|wish| {
            let (_, words, in_unit) = row(wish.name);
            let [wanted, reached] = [wish.wanted, wish.reached].map(in_unit);
            let by = match wanted {
                0.0 => String::new(),
                _ => format!(" ({:+.0} %)", 100.0 * (reached / wanted - 1.0)),
            };
            let [reached, wanted] = [reached, wanted].map(|value| digits(value, 4));
            format!("{words} {reached} instead of {wanted}{by}")
        });
        words.collect::<Vec<_>>().join(", ")
    }

    /// The end of the command: an error if a wish is not met, or the loop is not stable.
    pub(super) fn judge(&self) -> Result<(), Failure> {
        let trial = self.own().trial.as_ref();
        if trial.is_some_and(|trial| !trial.verdict.stable) {
            return Err(Failure::Run(anyhow::anyhow!(
                "the loop is not stable: lower --crossover or shorten --sample-time"
            )));
        }
        let unmet = self.unmet();
        if unmet.is_empty() {
            return Ok(());
        }
        let remedies = match self.design.wishes.iso_damping {
            true => "move --crossover, change --phase-margin, or give --not-flat",
            false => "move --crossover, or change --phase-margin",
        };
        Err(Failure::Run(anyhow::anyhow!(
            "not met: {unmet}; this is the best found: allow more, {remedies}"
        )))
    }

    /// The gains of the plant for which the loop is proved stable, if they do not reach from half to double.
    fn fragile(&self) -> Option<String> {
        let own = self.own().trial.as_ref().filter(|own| !own.is_robust())?;
        let [low, high] = own.stable_gains?;
        let verdict = match own.coarse {
            None => "proved stable",
            Some(_) => "stable by the sampled model, not proved,",
        };
        Some(format!(
            "the sampled loop is {verdict} only from {} to {} times the plant's gain",
            digits(low, 3),
            digits(high, 3)
        ))
    }

    /// The verdict, for which gains it is proved, and the remedy.
    fn verdict(&self, own: &Trial) -> String {
        let all = "for half to double the plant's gain";
        if !own.verdict.stable {
            return "The sampled loop is not stable.".to_owned();
        }
        let sturdier = match own.stable_gains {
            Some([low, _]) if low > ROBUST_GAINS[0] => {
                "Raise --crossover: a smaller gain does not hold this plant"
            }
            _ => "Lower --crossover, raise --phase-margin or shorten --sample-time",
        };
        // Why the verdict of a loop is not that of its plant.
        let too_fast = own.coarse.map(|times| {
            let times = digits(times, 4);
            format!("too fast to prove it for the plant: shorten --sample-time {times} times")
        });
        match (self.fragile(), too_fast) {
            (None, Some(too_fast)) => {
                format!("Warning: the sampled model is stable {all}, {too_fast}.")
            }
            (Some(fragile), Some(too_fast)) => {
                format!("Warning: {fragile}, {too_fast}. {sturdier}.")
            }
            (None, None) => format!("The sampled loop is proved stable {all}."),
            (Some(fragile), None) => format!("Warning: {fragile}. {sturdier}."),
        }
    }

    fn sentences(&self) -> Vec<String> {
        let Some(own) = &self.own().trial else {
            let count = "Stable at the measured frequencies, if the plant is stable; not proved.";
            let more = "For a proof and steps identify a function: host-cli control identify.";
            return vec![format!("{count} {more}")];
        };
        let mut said = vec![self.verdict(own)];
        let other = self.integer().and_then(|other| other.trial.as_ref());
        let spread = |trial: &Trial| trial.overshoot_spread().filter(|_| trial.is_robust());
        match other.map(|other| (spread(own), spread(other))) {
            Some((Some(fractional), Some(integer))) => {
                said.push(format!(
                    "Over these gains its overshoot varies by {} %, that of the integer-order PID by {} %: {}.",
                    digits(100.0 * fractional, 3),
                    digits(100.0 * integer, 3),
                    compared(fractional, integer)
                ));
            }
            Some((Some(_), None)) => {
                said.push("The integer-order PID is not stable at all these gains.".to_owned());
            }
            Some(_) => {}
            None => said.push(format!(
                "No integer-order PID has this crossover and margin: {}.",
                (self.answer.integer.as_ref().err())
                    .map_or("none was found".to_owned(), in_degrees)
            )),
        }
        let order = self.own().tuned.parameters.integral_order;
        if own.verdict.stable && own.shape.settled.is_none() && order < 1.0 {
            let crossover = self.own().wishes.first().map_or(1.0, |wish| wish.wanted);
            said.push(format!(
                "It does not settle in the time shown: its integral fades as t^-{}. Give --disturbance {}rad/s:0.05.",
                digits(order, 4),
                digits(0.05 * crossover, 4)
            ));
        }
        if self.unmet().is_empty() {
            said.push("Every wish is met within 1 %.".to_owned());
        }
        said
    }
}

fn compared(fractional: f64, integer: f64) -> String {
    let least = 1e-3;
    if fractional < least && integer < least {
        "no difference".to_owned()
    } else if fractional <= integer {
        format!("{:.1} times less", integer / fractional.max(1e-6))
    } else {
        "the fractional PID is not better".to_owned()
    }
}
