//! The verdict of a pre-flight, in numbers and in words.

use super::llewellyn::{CouplerVerdict, Sampled, three_digits_down};
use crate::document::failure::Failure;
use crate::document::parameters::FORCE_UNSTABLE;
use serde::Serialize;

/// Findings of the pre-flight. Keys of reports and, with `preflight.` before them, of the log's metadata.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PreflightVerdict {
    /// No pole on or outside the unit circle.
    pub stable: bool,
    /// Factor on K and B that takes the loop to the edge: above 1 if it is stable, below 1 if not; null if no
    /// factor does.
    pub margin: Option<f64>,
    /// By Theorem 1, for the operator really used.
    pub passive: bool,
    /// The damping δ = bT/m above which the loop is passive; null if none is.
    pub required_delta: Option<f64>,
    /// The δ that the device has.
    pub delta: f64,
    /// Delay, samples, of line and device together.
    pub delay_samples: f64,
    /// The same, s.
    pub delay_s: f64,
    /// Time constant of the motor current, s.
    pub current_lag_s: f64,
    /// α = KT²/m.
    pub alpha: f64,
    /// β = BT^(2−μ)/m.
    pub beta: f64,
    /// Of a coupler: Llewellyn's verdict. Then `margin` is the factor on `k_c` and `b_c`, `passive` and `required_delta` are
    /// those of the sampled port with any object, α = `k_c`T/m and β = `b_c`T^(1+μ)/m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coupler: Option<CouplerVerdict>,
}

impl PreflightVerdict {
    /// Refuses what is unstable, unless it is forced.
    ///
    /// # Errors
    /// Bad input, with the numbers and what to change.
    pub(crate) fn require_stable(&self, force: bool) -> Result<(), Failure> {
        if force {
            return Ok(());
        }
        if let Some(coupler) = &self.coupler {
            return coupler.require(&self.sampled());
        }
        if self.stable {
            return Ok(());
        }
        let advice = match self.margin {
            Some(factor) => format!(
                "take a softer K and less B, both {} times as large or smaller,",
                three_digits_down(factor)
            ),
            None => "a softer K and less B do not help alone: shorten the delay, take another order or scheme,"
                .to_owned(),
        };
        Err(Failure::bad_input(format_args!(
            "pre-flight: the loop would be unstable on this device, {}: {advice} or run it all the same with \
             {FORCE_UNSTABLE}",
            self.numbers()
        )))
    }

    /// A sentence about a loop that is unstable or not passive; `None` if there is nothing to say, or a guard
    /// that promises passivity looks after it.
    #[must_use]
    pub fn warning(&self, guarded: bool) -> Option<String> {
        if let (Some(coupler), true) = (&self.coupler, self.stable) {
            return coupler.warning(&self.sampled()).filter(|_| !guarded);
        }
        if !self.stable {
            return Some(format!(
                "pre-flight: the loop is unstable by the analysis, {}; {}",
                self.numbers(),
                if guarded {
                    "the guard alone holds it"
                } else {
                    "run all the same"
                }
            ));
        }
        if guarded {
            return None;
        }
        let needed = match self.required_delta {
            Some(needed) => format!("Theorem 1 asks for a delta above {needed:.4}"),
            None => "at rest it is a negative spring, which no damping makes passive".to_owned(),
        };
        (!self.passive).then(|| {
            format!(
                "pre-flight: stable, but not passive, {}: {needed}; a hand or another device on it may make \
                 it unstable",
                self.numbers()
            )
        })
    }

    /// One line for a summary.
    #[must_use]
    pub fn line(&self) -> String {
        if let Some(coupler) = &self.coupler {
            return coupler.line(&self.sampled());
        }
        let word = match (self.stable, self.passive) {
            (false, _) => "unstable by the analysis",
            (true, false) => "stable, not passive",
            (true, true) => "stable and passive",
        };
        let needed = self.required_delta.map_or_else(String::new, |needed| {
            format!("; passive above delta {needed:.4}")
        });
        format!("{word}, {}{needed}", self.numbers())
    }

    fn sampled(&self) -> Sampled {
        Sampled {
            stable: self.stable,
            margin: self.margin,
            passive: self.passive,
            numbers: self.numbers(),
        }
    }

    fn numbers(&self) -> String {
        let margin = self
            .margin
            .map_or_else(|| "any".to_owned(), |factor| format!("{factor:.3}"));
        format!(
            "alpha {:.4}, beta {:.4}, delta {:.4}, delay {} samples{}, margin {}",
            self.alpha,
            self.beta,
            self.delta,
            three_digits(self.delay_samples),
            self.lag(),
            if self.stable || self.margin.is_some() {
                margin
            } else {
                "none".to_owned()
            }
        )
    }

    /// Words about the current lag, if there is one.
    fn lag(&self) -> String {
        if self.current_lag_s > 0.0 {
            format!(
                ", current lag {} ms",
                three_digits(1e3 * self.current_lag_s)
            )
        } else {
            String::new()
        }
    }
}

/// Rounded for a message.
fn three_digits(value: f64) -> f64 {
    (value * 1e3).round() / 1e3
}
