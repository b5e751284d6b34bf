//! What a run asks of the pre-flight before a device is armed, and what it answers.

use crate::document::failure::Failure;
use crate::document::parameters::{COUPLER_DISSIPATION, COUPLER_STIFFNESS, FORCE_UNSTABLE};
use haptic_analysis::Dynamics;
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::time::Duration;

/// Time over which the round trip is measured.
pub(crate) const MEASURED: Duration = Duration::from_millis(200);

/// Request for the pre-flight, and the known dynamics of the device.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PreflightRequest {
    /// Run what is unstable, too.
    pub force_unstable: bool,
    /// Known dynamics of a device at a port.
    pub dynamics: Option<Dynamics>,
}

/// Whole samples of delay for a round trip, µs: it, and the tick that the force waits for, rounded up.
#[must_use]
pub(crate) fn delay_samples(round_trip_us: u64, sample_time_s: f64) -> usize {
    (1e-6 * round_trip_us as f64 / sample_time_s + 1.0).ceil() as usize
}

/// A loop that the analysis can look at.
pub(crate) trait PreflightSubject {
    /// Looks at the loop with this device and `line` samples of delay beside its own.
    ///
    /// # Errors
    /// A number that the analysis does not take.
    fn verdict(&self, dynamics: Dynamics, line: usize) -> Result<PreflightVerdict, Failure>;
}

/// The verdict on the sampled loop, for sentences.
pub(crate) struct Sampled {
    pub(crate) stable: bool,
    pub(crate) margin: Option<f64>,
    pub(crate) passive: bool,
    pub(crate) numbers: String,
}

/// Llewellyn's verdict on a coupler, and what the sampled device needs. Keys of reports and, with `preflight.coupler.` before
/// them, of the log's metadata.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CouplerVerdict {
    /// Passive with every passive hand and object by Llewellyn's criterion, for the operator really used.
    pub llewellyn: bool,
    /// b of the device, N·s/m.
    pub damping_n_s_per_m: f64,
    /// The least b by Llewellyn's criterion; null if none is enough.
    pub llewellyn_damping_n_s_per_m: Option<f64>,
    /// Corollary 2, which is not sufficient.
    pub corollary_damping_n_s_per_m: f64,
    /// The least b with which the sampled device, its delay and lag included, is passive whatever the object; null if none is
    /// enough.
    pub sampled_damping_n_s_per_m: Option<f64>,
}

impl CouplerVerdict {
    /// Refuses what is unstable, and what Llewellyn refuses.
    pub(crate) fn require(&self, sampled: &Sampled) -> Result<(), Failure> {
        let smaller = |factor: f64| {
            format!(
                "take {COUPLER_STIFFNESS} and {COUPLER_DISSIPATION} both {} times as large or \
                 smaller,",
                three_digits_down(factor)
            )
        };
        if !sampled.stable {
            let advice = match sampled.margin {
                Some(factor) => smaller(factor),
                None => {
                    "a weaker coupler does not help alone: shorten the delay, or take another object,"
                        .to_owned()
                }
            };
            return Err(Failure::bad_input(format_args!(
                "pre-flight: the coupled loop would be unstable on this device, {}: {advice} or run it all the same with \
                 {FORCE_UNSTABLE}",
                sampled.numbers
            )));
        }
        if self.llewellyn {
            return Ok(());
        }
        let advice = match self.llewellyn_damping_n_s_per_m {
            Some(needed) if self.damping_n_s_per_m > 0.0 => {
                smaller(self.damping_n_s_per_m / needed)
            }
            Some(_) => "take a device with damping,".to_owned(),
            None => "take another scheme, as full,".to_owned(),
        };
        Err(Failure::bad_input(format_args!(
            "pre-flight: Llewellyn's criterion refuses the coupler, {}: {advice} or run it all the same with {FORCE_UNSTABLE}",
            self.needs()
        )))
    }

    /// A sentence about a stable loop that Llewellyn refuses, or that is stable for this hand and object only.
    pub(crate) fn warning(&self, sampled: &Sampled) -> Option<String> {
        if sampled.passive && self.llewellyn {
            return None;
        }
        let needed = match self.sampled_damping_n_s_per_m {
            Some(needed) => format!("a damping of {needed:.4} N·s/m"),
            None => "another coupler, no damping is enough,".to_owned(),
        };
        let llewellyn = if self.llewellyn {
            "Llewellyn's criterion is fulfilled, but it knows a device under Tustin's rule only"
                .to_owned()
        } else {
            format!("Llewellyn's criterion refuses it, {}", self.needs())
        };
        Some(format!(
            "pre-flight: stable with this device, hand and object, {}; {llewellyn}: for every hand and object the sampled \
             device needs {needed} and has {:.4} N·s/m",
            sampled.numbers, self.damping_n_s_per_m
        ))
    }

    /// One line for a summary.
    pub(crate) fn line(&self, sampled: &Sampled) -> String {
        let stable = if sampled.stable {
            "stable with this device, hand and object"
        } else {
            "unstable by the analysis"
        };
        let llewellyn = if self.llewellyn {
            "passes"
        } else {
            "refuses it"
        };
        let passive = match (sampled.passive, self.sampled_damping_n_s_per_m) {
            (true, _) => "passive as sampled with any hand and object".to_owned(),
            (false, Some(needed)) => {
                format!("not passive as sampled: needs {needed:.4} N·s/m")
            }
            (false, None) => "not passive as sampled with any damping".to_owned(),
        };
        format!(
            "{stable}, {}; Llewellyn {llewellyn}, {}; {passive}",
            sampled.numbers,
            self.needs()
        )
    }

    /// Damping that Llewellyn needs and the device has.
    fn needs(&self) -> String {
        match self.llewellyn_damping_n_s_per_m {
            Some(needed) => format!(
                "it needs a damping of {needed:.4} N·s/m and has {:.4} N·s/m",
                self.damping_n_s_per_m
            ),
            None => "the coupler is active by itself, so no damping is enough".to_owned(),
        }
    }
}

/// As a message shows a factor that must not be exceeded.
pub(crate) fn three_digits_down(factor: f64) -> f64 {
    (factor * 1e3).floor() / 1e3
}

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

/// Adds findings to the metadata of a log, each by its key of reports behind `prefix` and a point.
pub(crate) fn note_findings(
    metadata: &mut BTreeMap<String, String>,
    prefix: &str,
    findings: &impl Serialize,
) {
    fn entry(metadata: &mut BTreeMap<String, String>, key: &str, value: &Value) {
        let text = match value {
            Value::Object(inner) => {
                for (name, value) in inner {
                    entry(metadata, &format!("{key}.{name}"), value);
                }
                return;
            }
            Value::Null => "none".to_owned(),
            Value::Number(number) => number.as_f64().unwrap_or(f64::NAN).to_string(),
            Value::String(text) => text.clone(),
            other => other.to_string(),
        };
        metadata.insert(key.to_owned(), text);
    }
    // A structure of numbers and words always becomes JSON.
    let findings = serde_json::to_value(findings).unwrap_or_default();
    entry(metadata, prefix, &findings);
}
