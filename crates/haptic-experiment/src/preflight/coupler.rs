//! Pre-flight of a coupler: the loop that runs, and the two criteria for every hand and object.
//!
//! ```text
//! stable      the sampled loop of this device, this hand and this object has no pole on or outside the unit circle: certified
//! Llewellyn   2b·Re(1/Z_c) ≥ cos(θ/2)(1 − cos(θ/2)): every passive hand and object, of a device under Tustin's rule
//! passive     2b·Re(1/Z_c) ≥ 1 − cos θ (no delay): every passive hand and object, of the sampled device
//! ```
//! - *Llewellyn is not enough for a real device.* Under Tustin's rule the force acts half a sample earlier than a held one does. The
//!   sampled port asks for at least four times his damping, and a coupler that he passes can be unstable with a light device: so the
//!   loop that runs is looked at beside him. A run needs both, `stable` and Llewellyn; `passive` is told.
//! - *Only* `passive` *promises anything for another hand.*

use super::verdict::three_digits_down;
use super::{Dynamics, PreflightSubject, PreflightVerdict, refused, softer};
use crate::failure::Failure;
use fracdiff::{Order, Scheme, Seconds};
use haptic_analysis::{
    AnalysisError, CoupledLoop, CoupledObject, Coupler, CouplerOperator, LeastDamping, LoopOperator,
};
use serde::Serialize;

/// A coupler and an object that are to be looked at.
#[derive(Clone, Copy, Debug)]
pub struct CouplerPreflight {
    /// `k_c`, N·s/m.
    pub stiffness_n_s_per_m: f64,
    /// `b_c`, N·s^(1−μ)/m.
    pub dissipation_n_s_1_minus_mu_per_m: f64,
    /// μ, 0 to 1.
    pub order: Order,
    /// The operator, of order 1 − μ.
    pub scheme: Scheme,
    /// T, s.
    pub sample_time_s: f64,
    /// Samples of the run.
    pub samples: u64,
    /// The object.
    pub object: CoupledObject,
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

impl PreflightSubject for CouplerPreflight {
    fn verdict(&self, dynamics: Dynamics, line: usize) -> Result<PreflightVerdict, Failure> {
        self.judge(dynamics, line).map_err(|error| refused(&error))
    }
}

impl CouplerPreflight {
    fn judge(&self, dynamics: Dynamics, line: usize) -> Result<PreflightVerdict, AnalysisError> {
        let t = self.sample_time_s;
        let dynamics = Dynamics {
            delay_s: dynamics.delay_s + line as f64 * t,
            ..dynamics
        };
        let path = dynamics.path(t)?;
        let horizon = crate::schedule::horizon(self.samples);
        let order = Order::new(1.0 - self.order.get())?;
        let operator = LoopOperator::new(self.scheme, order, Seconds(t), horizon)?;
        let exact = Coupler::exact(
            self.order,
            t,
            self.stiffness_n_s_per_m,
            self.dissipation_n_s_1_minus_mu_per_m,
        )?;
        let runs = CouplerOperator(&operator);
        let coupler = exact.with_operator(&runs, operator.memory());
        let coupled = CoupledLoop::new(&dynamics, &exact, &self.object, &operator)?;
        let stable = coupled.is_stable();
        let margin = if stable {
            coupled.gain_margin()?.map(|edge| edge.value)
        } else {
            softer(|factor| Ok(coupled.scaled(factor).is_stable()))?
        };
        let enough = |least: LeastDamping| match least {
            LeastDamping::Enough {
                damping_n_s_per_m, ..
            } => Some(damping_n_s_per_m),
            LeastDamping::NoneIsEnough { .. } => None,
        };
        let damping = dynamics.damping_n_s_per_m;
        let llewellyn = enough(coupler.least_damping()?);
        let sampled = enough(coupler.sampled_damping(path)?);
        let per_delta = t / dynamics.mass_kg;
        let (alpha, beta) = coupled.nondimensional();
        Ok(PreflightVerdict {
            stable,
            margin,
            passive: sampled.is_some_and(|needed| damping >= needed),
            required_delta: sampled.map(|needed| needed * per_delta),
            delta: damping * per_delta,
            delay_samples: path.delay_samples(),
            delay_s: dynamics.delay_s,
            current_lag_s: dynamics.current_lag_s,
            alpha,
            beta,
            coupler: Some(CouplerVerdict {
                llewellyn: llewellyn.is_some_and(|needed| damping >= needed),
                damping_n_s_per_m: damping,
                llewellyn_damping_n_s_per_m: llewellyn,
                corollary_damping_n_s_per_m: coupler.corollary_damping(),
                sampled_damping_n_s_per_m: sampled,
            }),
        })
    }
}

impl CouplerVerdict {
    /// Refuses what is unstable, and what Llewellyn refuses.
    pub(super) fn require(&self, verdict: &PreflightVerdict) -> Result<(), Failure> {
        let smaller = |factor: f64| {
            format!(
                "take `coupler_stiffness_n_s_per_m` and `coupler_dissipation_n_s_1_minus_mu_per_m` both {} times as large or \
                 smaller,",
                three_digits_down(factor)
            )
        };
        if !verdict.stable {
            let advice = match verdict.margin {
                Some(factor) => smaller(factor),
                None => {
                    "a weaker coupler does not help alone: shorten the delay, or take another object,"
                        .to_owned()
                }
            };
            return Err(Failure::bad_input(format_args!(
                "pre-flight: the coupled loop would be unstable on this device, {}: {advice} or run it all the same with \
                 `force_unstable`",
                verdict.numbers()
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
            "pre-flight: Llewellyn's criterion refuses the coupler, {}: {advice} or run it all the same with `force_unstable`",
            self.needs()
        )))
    }

    /// A sentence about a stable loop that Llewellyn refuses, or that is stable for this hand and object only.
    pub(super) fn warning(&self, verdict: &PreflightVerdict) -> Option<String> {
        if verdict.passive && self.llewellyn {
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
            verdict.numbers(),
            self.damping_n_s_per_m
        ))
    }

    /// One line for a summary.
    pub(super) fn line(&self, verdict: &PreflightVerdict) -> String {
        let stable = if verdict.stable {
            "stable with this device, hand and object"
        } else {
            "unstable by the analysis"
        };
        let llewellyn = if self.llewellyn {
            "passes"
        } else {
            "refuses it"
        };
        let passive = match (verdict.passive, self.sampled_damping_n_s_per_m) {
            (true, _) => "passive as sampled with any hand and object".to_owned(),
            (false, Some(needed)) => {
                format!("not passive as sampled: needs {needed:.4} N·s/m")
            }
            (false, None) => "not passive as sampled with any damping".to_owned(),
        };
        format!(
            "{stable}, {}; Llewellyn {llewellyn}, {}; {passive}",
            verdict.numbers(),
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

    /// As metadata.
    pub(super) fn entries(&self) -> [(&'static str, String); 5] {
        let or_none =
            |value: Option<f64>| value.map_or_else(|| "none".to_owned(), |value| value.to_string());
        [
            ("llewellyn", self.llewellyn.to_string()),
            ("damping_n_s_per_m", self.damping_n_s_per_m.to_string()),
            (
                "llewellyn_damping_n_s_per_m",
                or_none(self.llewellyn_damping_n_s_per_m),
            ),
            (
                "corollary_damping_n_s_per_m",
                self.corollary_damping_n_s_per_m.to_string(),
            ),
            (
                "sampled_damping_n_s_per_m",
                or_none(self.sampled_damping_n_s_per_m),
            ),
        ]
    }
}
