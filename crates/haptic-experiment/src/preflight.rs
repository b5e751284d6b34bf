//! Pre-flight: what the analysis says of an experiment before a device is armed.
//!
//! ```text
//! K, B, μ, T, the operator really used ─┐
//! m, b, k of device and hand            ├─▶ stable? how far from the edge? passive?
//! delay really measured ────────────────┘
//! ```
//! - *The loop* is the one of the stability analysis: a mass on a damper under a wall that is felt all the time.
//!   Safety chain, friction and the end of the contact are not in it; they make a loop no less stable, but may
//!   turn an unstable one into a limit cycle.
//! - *Without any spring* (a tissue that only dissipates) the loop has a pole at rest, z = 1, and the device drifts, as it
//!   should. Such a loop is judged held by a spring of 1e-4·β, see `SampledLoop::held`.
//! - *Delay*: that of the device, whole samples or not, as simulated or as known of a real one; in a loop on the host
//!   the round trip beside it that nine of ten keep-alives do not exceed, plus the tick that the force waits for,
//!   rounded up to whole samples, since the device writes once a sample. The current lag of the motor likewise.
//! - *Margin*: the factor on K and B together that takes the loop to the edge of stability.

use crate::failure::Failure;
use fracdiff::{Order, Scheme, Seconds};
pub use haptic_analysis::Dynamics;
use haptic_analysis::{AnalysisError, Environment, LoopOperator, SampledLoop};
use serde::Serialize;
use std::collections::BTreeMap;
use std::time::Duration;

/// How long the round trip is measured.
pub const MEASURED: Duration = Duration::from_millis(200);

/// What the user wants of the pre-flight, and knows of the device.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PreflightRequest {
    /// Run what is unstable, too.
    pub force_unstable: bool,
    /// What is known of a real device; a simulated one tells its own numbers.
    pub dynamics: Option<Dynamics>,
}

/// A loop that is to be looked at.
#[derive(Clone, Copy, Debug)]
pub struct Preflight {
    /// K, N/m.
    pub stiffness_n_per_m: f64,
    /// B, N·s^μ/m.
    pub dissipation_n_s_mu_per_m: f64,
    /// μ.
    pub order: Order,
    /// The operator.
    pub scheme: Scheme,
    /// T, s.
    pub sample_time_s: f64,
    /// Samples of the run.
    pub samples: u64,
}

/// What was found. Keys of reports and, with `preflight.` before them, of the log's metadata.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Verdict {
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
}

/// Whole samples of delay for a round trip, µs: it, and the tick that the force waits for, rounded up.
#[must_use]
pub fn delay_samples(round_trip_us: u64, sample_time_s: f64) -> usize {
    (1e-6 * round_trip_us as f64 / sample_time_s + 1.0).ceil() as usize
}

impl Preflight {
    /// Looks at the loop with this device and `line` samples of delay beside its own.
    ///
    /// # Errors
    /// A number that the analysis does not take.
    pub fn verdict(&self, dynamics: Dynamics, line: usize) -> Result<Verdict, Failure> {
        self.judge(dynamics, line).map_err(|error| {
            Failure::input_with_advice(
                format_args!("pre-flight: {error}"),
                "check mass, damping, delay, current lag and sample time",
            )
        })
    }

    fn judge(&self, dynamics: Dynamics, line: usize) -> Result<Verdict, AnalysisError> {
        let sample_time = Seconds(self.sample_time_s);
        let dynamics = Dynamics {
            delay_s: dynamics.delay_s + line as f64 * self.sample_time_s,
            ..dynamics
        };
        let plant = dynamics.plant(self.sample_time_s)?;
        let wall = dynamics.nondimensional(&Environment {
            stiffness_n_per_m: self.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: self.dissipation_n_s_mu_per_m,
            order: self.order,
            sample_time_s: self.sample_time_s,
        })?;
        let horizon = crate::schedule::horizon(self.samples);
        let operator = LoopOperator::new(self.scheme, self.order, sample_time, horizon)?;
        let scaled = |factor: f64| {
            SampledLoop::with_plant(plant, factor * wall.alpha, factor * wall.beta, &operator)
                .map(SampledLoop::held)
        };
        let sampled = scaled(1.0)?;
        let stable = sampled.is_stable();
        let margin = if stable {
            sampled.margins()?.gain_up.map(|edge| edge.value)
        } else {
            softer(|factor| Ok(scaled(factor)?.is_stable()))?
        };
        let required = dynamics
            .port(self.sample_time_s, &operator)?
            .required_delta(wall.alpha, wall.beta)?;
        Ok(Verdict {
            stable,
            margin,
            passive: required.passive(wall.delta),
            required_delta: (!required.negative_at_rest).then_some(required.delta),
            delta: wall.delta,
            delay_samples: plant.path().delay_samples(),
            delay_s: dynamics.delay_s,
            current_lag_s: dynamics.current_lag_s,
            alpha: wall.alpha,
            beta: wall.beta,
        })
    }
}

/// The largest factor below 1 known to be stable, to three digits and rounded down; `None` if a millionth is
/// not.
fn softer(
    stable: impl Fn(f64) -> Result<bool, AnalysisError>,
) -> Result<Option<f64>, AnalysisError> {
    let (mut good, mut bad) = (0.5, 1.0);
    while !stable(good)? {
        bad = good;
        good *= 0.5;
        if good < 1e-6 {
            return Ok(None);
        }
    }
    while bad - good > 1e-3 * good {
        let middle = 0.5 * (good + bad);
        if stable(middle)? {
            good = middle;
        } else {
            bad = middle;
        }
    }
    Ok(Some(good))
}

impl Verdict {
    /// Refuses what is unstable, unless it is forced.
    ///
    /// # Errors
    /// Bad input, with the numbers and what to change.
    pub fn require_stable(&self, force: bool) -> Result<(), Failure> {
        if self.stable || force {
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
             `force_unstable`",
            self.numbers()
        )))
    }

    /// A sentence about a loop that is unstable or not passive; `None` if there is nothing to say, or a guard
    /// that promises passivity looks after it.
    #[must_use]
    pub fn warning(&self, guarded: bool) -> Option<String> {
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

    /// Adds the verdict to the metadata of a log.
    pub fn describe(&self, metadata: &mut BTreeMap<String, String>) {
        let or_none =
            |value: Option<f64>| value.map_or_else(|| "none".to_owned(), |value| value.to_string());
        for (key, value) in [
            ("stable", self.stable.to_string()),
            ("margin", or_none(self.margin)),
            ("passive", self.passive.to_string()),
            ("required_delta", or_none(self.required_delta)),
            ("delta", self.delta.to_string()),
            ("delay_samples", self.delay_samples.to_string()),
            ("delay_s", self.delay_s.to_string()),
            ("current_lag_s", self.current_lag_s.to_string()),
            ("alpha", self.alpha.to_string()),
            ("beta", self.beta.to_string()),
        ] {
            metadata.insert(format!("preflight.{key}"), value);
        }
    }
}

/// Rounded for a message.
fn three_digits(value: f64) -> f64 {
    (value * 1e3).round() / 1e3
}

/// As a message shows a factor that must not be exceeded.
fn three_digits_down(factor: f64) -> f64 {
    (factor * 1e3).floor() / 1e3
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The dissertation's device.
    const TESTBED: Dynamics = Dynamics::ideal(0.065, 3.5);

    fn wall(order: f64, stiffness: f64, dissipation: f64) -> Preflight {
        Preflight {
            stiffness_n_per_m: stiffness,
            dissipation_n_s_mu_per_m: dissipation,
            order: Order::new(order).expect("in range"),
            scheme: Scheme::Exact,
            sample_time_s: 1e-3,
            samples: 5000,
        }
    }

    #[test]
    fn a_damper_has_the_margin_of_its_closed_form() {
        // Without damping of the device: α < 2β(2 − β)/(2 + β), 2/3 at β = 1.
        let device = Dynamics {
            damping_n_s_per_m: 0.0,
            mass_kg: 1.0,
            ..TESTBED
        };
        let at = |factor: f64| wall(1.0, factor * 0.6e6, factor * 1e3);
        let verdict = at(1.0).verdict(device, 0).expect("judges");
        assert!(verdict.stable && !verdict.passive, "{verdict:?}");
        // 0.6g = 2g(2 − g)/(2 + g)  ⇔  1.2 + 0.6g = 4 − 2g.
        let edge = 2.8 / 2.6;
        let margin = verdict.margin.expect("a margin");
        assert!((margin - edge).abs() < 1e-6, "{margin}");
        // Theorem 1 at μ = 1: δ > α/2 + β.
        let required = verdict.required_delta.expect("some");
        assert!((required - 1.3).abs() < 1e-9, "{required}");
        // An unstable one is told how much softer it has to be.
        let verdict = at(2.0).verdict(device, 0).expect("judges");
        let margin = verdict.margin.expect("a margin");
        assert!(!verdict.stable);
        assert!(margin <= 0.5 * edge && margin > 0.499 * edge, "{margin}");
        let refused = verdict.require_stable(false).expect_err("refused");
        assert_eq!(refused.exit_code(), 2);
        let text = refused.to_string();
        for part in [
            "alpha 1.2000",
            "beta 2.0000",
            "delta 0.0000",
            "delay 0 samples",
            "margin 0.538",
            "softer K",
            "less B",
            "`force_unstable`",
        ] {
            assert!(text.contains(part), "\"{part}\" in {text}");
        }
        verdict.require_stable(true).expect("forced");
        for (guarded, words) in [(false, "run all the same"), (true, "the guard alone")] {
            let warning = verdict.warning(guarded).expect("a warning");
            assert!(
                warning.contains("unstable") && warning.contains(words),
                "{warning}"
            );
        }
    }

    #[test]
    fn delay_makes_a_stable_wall_unstable() {
        let wall = wall(0.5, 3000.0, 30.0);
        assert!(wall.verdict(TESTBED, 0).expect("judges").stable);
        assert!(!wall.verdict(TESTBED, 20).expect("judges").stable);
    }

    #[test]
    fn delay_and_current_lag_of_the_device_count_as_they_are() {
        let wall = wall(1.0, 12e3, 15.0);
        let late = |delay_s: f64, current_lag_s: f64| {
            let device = Dynamics {
                delay_s,
                current_lag_s,
                ..TESTBED
            };
            wall.verdict(device, 0).expect("judges")
        };
        let margin = |delay, lag| late(delay, lag).margin.expect("a margin");
        // Between whole samples the margin is between theirs, and a lag costs too.
        let (none, half, one) = (margin(0.0, 0.0), margin(0.5e-3, 0.0), margin(1e-3, 0.0));
        assert!(none > half && half > one, "{none} {half} {one}");
        assert!(margin(0.0, 0.5e-3) < none);
        let verdict = late(1.3e-3, 1.5e-3);
        assert!(!verdict.stable, "{verdict:?}");
        let words = verdict.line();
        assert!(
            words.contains("delay 1.3 samples, current lag 1.5 ms"),
            "{words}"
        );
        // Samples of the line come on top.
        let verdict = wall.verdict(TESTBED, 2).expect("judges");
        assert_eq!(verdict.delay_samples.to_string(), "2");
    }

    #[test]
    fn a_soft_and_plain_wall_is_passive_and_nothing_is_said() {
        let verdict = wall(1.0, 100.0, 0.5).verdict(TESTBED, 0).expect("judges");
        assert!(verdict.stable && verdict.passive, "{verdict:?}");
        assert_eq!(verdict.warning(false), None);
        let mut metadata = BTreeMap::new();
        verdict.describe(&mut metadata);
        assert_eq!(metadata["preflight.stable"], "true");
        assert_eq!(metadata["preflight.delay_samples"], "0");
    }

    #[test]
    fn the_operator_that_runs_is_judged_and_not_the_ideal_one() {
        // Order 1.5 by A₃ is a negative spring at rest, (1−μ)(3−μ)/3 = −1/4.
        let ideal = wall(1.5, 10.0, 1.0);
        let short = Preflight {
            scheme: Scheme::Muir { degree: 3 },
            ..ideal
        };
        assert!(ideal.verdict(TESTBED, 0).expect("judges").stable);
        let verdict = short.verdict(TESTBED, 0).expect("judges");
        assert_eq!((verdict.stable, verdict.required_delta), (false, None));
    }

    #[test]
    fn a_tissue_without_a_spring_drifts_and_is_stable() {
        let tissue = |dissipation: f64| Preflight {
            scheme: "full".parse().expect("a scheme"),
            ..wall(0.2247, 0.0, dissipation)
        };
        let verdict = tissue(174.0).verdict(TESTBED, 0).expect("judges");
        assert!(verdict.stable, "{verdict:?}");
        // These left a negative spring at rest once.
        for order in [0.35, 0.4, 0.45, 0.7, 0.8] {
            for scheme in ["full", "piecewise-linear", "exact"] {
                let tissue = Preflight {
                    scheme: scheme.parse().expect("a scheme"),
                    ..wall(order, 0.0, 20.0)
                };
                let verdict = tissue.verdict(TESTBED, 0).expect("judges");
                assert!(verdict.stable, "{scheme} {order}: {verdict:?}");
                assert!(
                    verdict.required_delta.is_some(),
                    "{scheme} {order}: {verdict:?}"
                );
            }
        }
        assert!(
            verdict.margin.is_some_and(|factor| factor > 10.0),
            "{verdict:?}"
        );
        // One that shakes is still told.
        let verdict = tissue(1e6).verdict(TESTBED, 0).expect("judges");
        assert!(!verdict.stable && verdict.margin.is_some(), "{verdict:?}");
    }

    #[test]
    fn delays_are_rounded_up() {
        assert_eq!(delay_samples(0, 1e-3), 1);
        assert_eq!(delay_samples(300, 1e-3), 2);
        assert_eq!(delay_samples(2100, 1e-3), 4);
    }
}
