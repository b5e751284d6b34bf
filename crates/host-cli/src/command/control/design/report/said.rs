//! What a design means, in sentences.

use super::{Report, TrialReport};
use fractional_control::design::ROBUST_GAINS;
use haptic_quantity::digits;

impl Report {
    /// The gains of the plant for which the loop is proved stable, if they do not reach from half to double.
    pub(super) fn fragile(&self) -> Option<String> {
        let own = self.trial.as_ref().filter(|own| !own.robust_by_model)?;
        let [low, high] = own.gains_by_model?;
        let verdict = match own.coarse {
            None => "proved stable",
            Some(_) => "stable by the sampled model, not proved,",
        };
        Some(format!(
            "the sampled loop is {verdict} only from {} to {} times the plant's gain, not from half to double",
            digits(low, 3),
            digits(high, 3)
        ))
    }

    /// The remedy.
    fn sturdier(&self) -> &'static str {
        let gains = self.trial.as_ref().and_then(|own| own.gains_by_model);
        if gains.is_some_and(|[low, _]| low > ROBUST_GAINS[0]) {
            "Raise --crossover: a smaller gain does not hold this plant"
        } else {
            "Lower --crossover, raise --phase-margin or shorten --sample-time"
        }
    }

    /// The verdict, and for which gains it is proved.
    fn verdict(&self, own: &TrialReport) -> String {
        match (own.stable_by_model, self.fragile()) {
            (true, None) if own.coarse.is_some() => {
                format!(
                    "Warning: the sampled model is stable for half to double the plant's gain, which does not prove it for the plant: {}.",
                    too_fast(own)
                )
            }
            (true, Some(fragile)) if own.coarse.is_some() => {
                format!(
                    "Warning: {fragile}, which does not prove it for the plant: {}. {}.",
                    too_fast(own),
                    self.sturdier()
                )
            }
            (true, None) => {
                "The sampled loop is proved stable for half to double the plant's gain.".to_owned()
            }
            (true, Some(fragile)) => {
                format!("Warning: {fragile}. {}.", self.sturdier())
            }
            _ => "The sampled loop is not stable.".to_owned(),
        }
    }

    /// The verdict and the comparison.
    pub(super) fn sentences(&self) -> Vec<String> {
        let Some(own) = &self.trial else {
            return vec![
                "Tuned to a measured response: stable by Nyquist's count at the measured frequencies, if the plant is stable; not proved. Identify \
                 a transfer function (host-cli control identify) for a proof and steps."
                    .to_owned(),
            ];
        };
        let always = |trial: &TrialReport| trial.robust_by_model;
        let mut said = vec![self.verdict(own)];
        let other = self.integer.as_ref().and_then(|other| other.trial.as_ref());
        match other {
            Some(other) if always(own) && always(other) => {
                let (fractional, integer) = (own.overshoot_spread, other.overshoot_spread);
                said.push(format!(
                    "Over these gains its overshoot varies by {}, that of the PID of order 1 by {}: {}.",
                    percent(fractional),
                    percent(integer),
                    compared(fractional, integer)
                ));
            }
            Some(other) if always(own) && !always(other) => {
                said.push("The PID of order 1 is not stable at all these gains.".to_owned());
            }
            Some(_) => {}
            None => said.push(format!(
                "No PID of order 1 has this crossover and margin: {}.",
                self.integer_reason.as_deref().unwrap_or("none was found")
            )),
        }
        let order = self.controller.integral_order;
        if own.stable_by_model && own.shape.settling_time_s.is_none() && order < 1.0 {
            said.push(format!(
                "It does not settle in the time shown: an integral of order {} fades as t^-{0}. Limit the error at low frequency, as with \
                 --disturbance {}rad/s:0.05.",
                digits(order, 4),
                digits(0.05 * self.specification.first().map_or(1.0, |wish| wish.wanted), 4)
            ));
        }
        let unmet = self.unmet();
        if unmet.is_empty() {
            said.push("Every wish is met within 1 %.".to_owned());
        }
        said
    }
}

/// Why the verdict of a loop is not that of its plant.
fn too_fast(own: &TrialReport) -> String {
    format!(
        "the loop is too fast for the sampled model of this fractional plant; shorten --sample-time at least {} times",
        digits(own.coarse.unwrap_or(1.0), 4)
    )
}

/// A share of the step.
fn percent(share: f64) -> String {
    format!("{} %", digits(100.0 * share, 3))
}

/// One spread against another.
fn compared(fractional: f64, integer: f64) -> String {
    let least = 1e-3;
    if fractional < least && integer < least {
        "no difference".to_owned()
    } else if fractional <= integer {
        format!("{:.1} times less", integer / fractional.max(1e-6))
    } else {
        "the fractional one is not better".to_owned()
    }
}
