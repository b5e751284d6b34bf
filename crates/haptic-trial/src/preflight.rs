//! Questions of a run to the pre-flight before a device is armed, and the answers.

use crate::{
    drive_verdict::DriveVerdict,
    flat::flat,
    keys::admittance::{BODY_DAMPING, BODY_INERTANCE},
};
use haptic_analysis::Dynamics;
use haptic_document::{
    Failure, bad_input,
    parameters::{COUPLER_DAMPING, COUPLER_SPRING, FORCE_UNSTABLE},
};
use haptic_quantity::written;
use serde::Serialize;
use std::{collections::BTreeMap, time::Duration};

/// Time over which the round trip is measured.
pub const MEASURED: Duration = Duration::from_millis(200);

/// Whole samples of delay for a round trip, µs: it, and the tick that the force waits for, rounded up.
pub fn delay_samples(round_trip_us: u64, sample_time_s: f64) -> usize {
    (1e-6 * round_trip_us as f64 / sample_time_s + 1.0).ceil() as usize
}

/// Judges a loop with this device and this many samples of delay on a line besides its own.
pub type LoopJudge<'a> = dyn Fn(Dynamics, usize) -> Result<Findings, Failure> + 'a;

/// Findings of the pre-flight of a device.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(untagged)]
pub enum Findings {
    /// Verdict on a loop through an environment.
    Loop(PreflightVerdict),
    /// The loop of a controller that holds an indenter.
    Drive(DriveVerdict),
}

impl Findings {
    /// Refuses what is unstable, unless it is forced.
    ///
    /// # Errors
    /// Says what would be unstable.
    pub fn require_stable(&self, force: bool) -> Result<(), Failure> {
        match self {
            Self::Loop(verdict) => verdict.require_stable(force),
            Self::Drive(verdict) => verdict.require_stable(force),
        }
    }

    /// A sentence before the run; `None` if there is nothing to say, or a guard that promises passivity looks after it.
    pub fn warning(&self, guarded: bool) -> Option<String> {
        match self {
            Self::Loop(verdict) => verdict.warning(guarded),
            Self::Drive(_) => None,
        }
    }
}

/// Hard hits may grow on contact that pushes only, even where the same contact is proved if it may pull.
pub const NOT_PROVED: &str = "not proved";
/// Energy bounding holds for any environment. It proves neither that the device comes to rest nor a force.
pub const NO_ENERGY: &str = "proved to give no energy, with the guard on";
/// Proof by the certificate of the loop that runs, up to the force limit.
pub const EVERY_MOTION: &str =
    "proved for every motion, but for friction, encoder, rate limit, guard, start ramp and braking";

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
    /// The damping by Corollary 2, which is not sufficient.
    pub corollary_damping_n_s_per_m: f64,
    /// The least b with which the sampled device, its delay and lag included, is passive whatever the object; null if none is
    /// enough.
    pub sampled_damping_n_s_per_m: Option<f64>,
}

/// Verdict on a robot in each hand of its box, at each wall from free space to the one that is asked for. Keys of reports and, with
/// `preflight.robot.` before them, of the log's metadata.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct RobotVerdict {
    /// True if all of them are proved stable, false if one of them is not stable; null if the proof did not end.
    pub every_hand: Option<bool>,
    /// Least factor on the virtual body, 0.01 to 1000, with which all of them are proved; null if none is.
    pub least_body_factor: Option<f64>,
}

/// Findings of the pre-flight. Keys of reports and, with `preflight.` before them, of the log's metadata.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PreflightVerdict {
    /// True if no pole is on or outside the unit circle.
    pub stable: bool,
    /// Factor on K and B at which the loop is on the edge of stability: above 1 if it is stable,
    /// below 1 if not; null if no factor does.
    pub margin: Option<f64>,
    /// The factor on K and B up to which contact that may pull, acts on one side or stiffens, and is nowhere steeper than this, is
    /// proved stable for every motion; null if none is, of a coupler, of a touch and on the page's *Feel*.
    pub pulling_contact_margin: Option<f64>,
    /// The depth down to which this is proved for a tissue that stiffens, m; null for one that does
    /// not stiffen.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pulling_contact_depth_m: Option<f64>,
    /// The proved result, in words, for contact that pushes and never pulls; null for a law that pulls.
    pub pushing_contact: Option<&'static str>,
    /// True if passive by Theorem 1, for the operator really used.
    pub passive: bool,
    /// The damping δ = bT/m above which the loop is passive; null if none is.
    pub required_delta: Option<f64>,
    /// The δ that the device has.
    pub delta: f64,
    /// Total delay of line and device, samples.
    pub delay_samples: f64,
    /// That delay in seconds, including the line's.
    pub delay_s: f64,
    /// Time constant of the motor current, s.
    pub current_lag_s: f64,
    /// α = KT²/m, by which loops of any device compare.
    pub alpha: f64,
    /// β = BT^(2−μ)/m.
    pub beta: f64,
    /// Llewellyn's verdict on a coupler. Then `margin` is the factor on `k_c` and `b_c`, `passive` and `required_delta` are
    /// those of the sampled port with any object, α = `k_c`T/m and β = `b_c`T^(1+μ)/m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coupler: Option<CouplerVerdict>,
    /// Verdict on a robot that a hand pushes. Then `stable` is that of its whole box of hands, `margin` the factor on K and B up to which the
    /// box is proved; α, β and δ are of a device of forces, and null.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub robot: Option<RobotVerdict>,
}

/// Rounded up, so that the printed number suffices.
fn needed_damping(needed: f64) -> String {
    written("required_damping_n_s_per_m", needed)
}

fn needed_delta(needed: f64) -> String {
    written("required_delta", needed)
}

impl CouplerVerdict {
    /// Damping that Llewellyn needs and the device has.
    fn needs(&self) -> String {
        match self.llewellyn_damping_n_s_per_m {
            Some(needed) => format!(
                "it needs a damping of {} and has {:.4} N·s/m",
                needed_damping(needed),
                self.damping_n_s_per_m
            ),
            None => "the coupler is active by itself, so no damping is enough".to_owned(),
        }
    }
}

impl RobotVerdict {
    fn words(&self) -> &'static str {
        match self.every_hand {
            Some(true) => "stable in every hand of the box, proved",
            Some(false) => "unstable in a hand of the box",
            None => "not proved for every hand of the box",
        }
    }

    /// The changes that help, as the end of a sentence.
    fn advice(&self, margin: Option<f64>) -> String {
        let body = self.least_body_factor.map(|factor| {
            let factor = (factor * 1e3).ceil() / 1e3;
            format!("a body {factor} times as heavy and damped ({BODY_INERTANCE}, {BODY_DAMPING})")
        });
        let wall = margin.map(|factor| {
            let factor = (factor * 1e3).floor() / 1e3;
            format!("a softer K and less B, both {factor} times as large or smaller")
        });
        match (body, wall) {
            (Some(body), Some(wall)) => format!("use {body}, {wall}, or softer hands"),
            (Some(one), None) | (None, Some(one)) => format!("use {one}, or softer hands"),
            (None, None) => "no heavier body is proved: ask for softer hands".to_owned(),
        }
    }
}

impl PreflightVerdict {
    /// Refuses what is unstable, and what Llewellyn refuses, unless it is forced.
    ///
    /// # Errors
    /// Says what would be unstable, with its numbers and what to change.
    pub fn require_stable(&self, force: bool) -> Result<(), Failure> {
        let refused = self.coupler.filter(|coupler| !coupler.llewellyn);
        if force || (self.stable && refused.is_none()) {
            return Ok(());
        }
        if let Some(robot) = &self.robot {
            return Err(bad_input!(
                "pre-flight: this robot is {}: {}, or run it anyway with {FORCE_UNSTABLE}",
                self.numbers(),
                robot.advice(self.margin)
            ));
        }
        let smaller = |factor: f64| {
            let factor = (factor * 1e3).floor() / 1e3;
            match self.coupler {
                Some(_) => format!(
                    "use {COUPLER_DAMPING} and {COUPLER_SPRING} both {factor} times as large or smaller,"
                ),
                None => {
                    format!("use a softer K and less B, both {factor} times as large or smaller,")
                }
            }
        };
        let (what, numbers, advice) = match refused.filter(|_| self.stable) {
            Some(coupler) => (
                "the coupler does not meet Llewellyn's criterion",
                coupler.needs(),
                match coupler.llewellyn_damping_n_s_per_m {
                    Some(needed) if coupler.damping_n_s_per_m > 0.0 => {
                        smaller(coupler.damping_n_s_per_m / needed)
                    }
                    Some(_) => "use a device with damping,".to_owned(),
                    None => "use another scheme, as full,".to_owned(),
                },
            ),
            None => (
                match self.coupler {
                    Some(_) => "the coupled loop would be unstable on this device",
                    None => "the loop would be unstable on this device",
                },
                self.numbers(),
                match (self.margin, self.coupler) {
                    (Some(factor), _) => smaller(factor),
                    (None, Some(_)) => "a weaker coupler does not help alone: shorten the delay, or use another object,".to_owned(),
                    (None, None) => "a softer K and less B do not help alone: shorten the delay, use another order or scheme,".to_owned(),
                },
            ),
        };
        Err(bad_input!(
            "pre-flight: {what}, {numbers}: {advice} or run it anyway with {FORCE_UNSTABLE}"
        ))
    }

    /// A sentence about a loop that is unstable or not passive; `None` if there is nothing to say, or a guard
    /// that promises passivity looks after it.
    pub fn warning(&self, guarded: bool) -> Option<String> {
        if !self.stable {
            let why = if guarded {
                "only the guard keeps it stable"
            } else {
                "it runs anyway"
            };
            return Some(format!(
                "pre-flight: the loop is unstable by the analysis, {}; {why}",
                self.numbers()
            ));
        }
        // A robot with a dead time is never passive.
        if guarded || self.robot.is_some() {
            return None;
        }
        if let Some(coupler) = self.coupler {
            let needed = match coupler.sampled_damping_n_s_per_m {
                Some(needed) => format!("a damping of {}", needed_damping(needed)),
                None => "another coupler, no damping is enough,".to_owned(),
            };
            let llewellyn = if coupler.llewellyn {
                "it meets Llewellyn's criterion, but that assumes a device sampled by Tustin's rule"
                    .to_owned()
            } else {
                format!(
                    "it does not meet Llewellyn's criterion, {}",
                    coupler.needs()
                )
            };
            return (!(self.passive && coupler.llewellyn)).then(|| format!(
                "pre-flight: stable with this device, hand and object, {}; {llewellyn}: any others need {needed}, it has {:.4} N·s/m",
                self.numbers(), coupler.damping_n_s_per_m
            ));
        }
        let needed = match self.required_delta {
            Some(needed) => format!("passivity needs a delta above {}", needed_delta(needed)),
            None => "at rest it is a negative spring, which no damping makes passive".to_owned(),
        };
        (!self.passive).then(|| {
            format!(
                "pre-flight: stable, but not passive, {}: {needed}; another hand may make it unstable",
                self.numbers()
            )
        })
    }

    /// One line for a summary.
    #[must_use]
    pub fn line(&self) -> String {
        let numbers = self.numbers();
        if self.robot.is_some() {
            return numbers;
        }
        let Some(coupler) = self.coupler else {
            let word = match (self.stable, self.passive) {
                (false, _) => "unstable by the analysis",
                (true, false) => "stable, not passive",
                (true, true) => "stable and passive",
            };
            let needed = self.required_delta.map_or_else(String::new, |needed| {
                format!("; passive above delta {}", needed_delta(needed))
            });
            return format!("{word}, {numbers}{needed}");
        };
        let stable = if self.stable {
            "stable with this device, hand and object"
        } else {
            "unstable by the analysis"
        };
        let llewellyn = if coupler.llewellyn { "met" } else { "not met" };
        let passive = match (self.passive, coupler.sampled_damping_n_s_per_m) {
            (true, _) => "passive as sampled with any hand and object".to_owned(),
            (false, Some(needed)) => {
                format!("not passive as sampled: needs {}", needed_damping(needed))
            }
            (false, None) => "not passive as sampled with any damping".to_owned(),
        };
        format!(
            "{stable}, {numbers}; Llewellyn's criterion {llewellyn}, {}; {passive}",
            coupler.needs()
        )
    }

    fn numbers(&self) -> String {
        let three_digits = |value: f64| (value * 1e3).round() / 1e3;
        let margin = match self.margin {
            Some(factor) => format!("{factor:.3}"),
            None if self.stable => "any".to_owned(),
            None => "none".to_owned(),
        };
        if let Some(robot) = &self.robot {
            return format!(
                "{}, delay {} samples, margin {margin} on the wall",
                robot.words(),
                three_digits(self.delay_samples)
            );
        }
        let lag = if self.current_lag_s > 0.0 {
            format!(
                ", current lag {} ms",
                three_digits(1e3 * self.current_lag_s)
            )
        } else {
            String::new()
        };
        let proved = self
            .pulling_contact_margin
            .map_or_else(String::new, |factor| {
                let depth = self
                    .pulling_contact_depth_m
                    .map_or_else(String::new, |depth_m| {
                        format!(", down to {} mm", three_digits(1e3 * depth_m))
                    });
                let factor = written("pulling_contact_margin", factor);
                format!(" ({factor} proved for every motion of contact that may pull{depth})")
            });
        let pushing = self.pushing_contact.map_or_else(String::new, |proof| {
            format!(", contact that only pushes is {proof}")
        });
        format!(
            "alpha {:.4}, beta {:.4}, delta {:.4}, delay {} samples{lag}, margin {margin}{proved}{pushing}",
            self.alpha,
            self.beta,
            self.delta,
            three_digits(self.delay_samples),
        )
    }
}

/// Adds findings to the metadata of a log, each by its key of reports behind `prefix` and a point.
pub fn note_findings(
    metadata: &mut BTreeMap<String, String>,
    prefix: &str,
    findings: &impl Serialize,
) {
    metadata.extend(flat(findings, &format!("{prefix}."), "."));
}
