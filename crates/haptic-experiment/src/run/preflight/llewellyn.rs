//! Llewellyn's verdict on a coupler, beside that of the sampled loop, in words.

use crate::document::failure::Failure;
use crate::document::parameters::{COUPLER_DISSIPATION, COUPLER_STIFFNESS, FORCE_UNSTABLE};
use serde::Serialize;

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
