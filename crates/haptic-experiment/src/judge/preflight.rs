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
//!   should. Such a loop is judged beside that pole, see `SampledLoop::beside_rest`.
//! - *Delay*: that of the device, whole samples or not, as simulated or as known of a real one; in a loop on the host
//!   the round trip beside it that nine of ten keep-alives do not exceed, plus the tick that the force waits for,
//!   rounded up to whole samples, since the device writes once a sample. The current lag of the motor likewise.
//! - *Margin*: the factor on K and B together that takes the loop to the edge of stability.

#[cfg(test)]
mod tests;

use crate::document::failure::Failure;
use crate::document::parameters::{CURRENT_LAG, DAMPING, DELAY, HAND_STIFFNESS, MASS, SAMPLE_TIME};
use crate::judge::modelled_tissue::loop_operator;
use crate::run::preflight::{PreflightSubject, PreflightVerdict};
use fracdiff::{Order, Scheme, Seconds};
use haptic_analysis::{AnalysisError, Dynamics, Environment, LoopOperator, SampledLoop};
use haptic_tissue::Model;

/// A loop that is to be looked at.
#[derive(Clone, Copy, Debug)]
pub struct Preflight<'a> {
    /// K, N/m.
    pub stiffness_n_per_m: f64,
    /// B, N·s^μ/m.
    pub dissipation_n_s_mu_per_m: f64,
    /// μ.
    pub order: Order,
    /// The model whose memory the operator is; `None` for D^μ.
    pub model: Option<&'a Model>,
    /// The operator.
    pub scheme: Scheme,
    /// T, s.
    pub sample_time_s: f64,
    /// Samples of the run.
    pub samples: u64,
}

impl PreflightSubject for Preflight<'_> {
    fn verdict(&self, dynamics: Dynamics, line: usize) -> Result<PreflightVerdict, Failure> {
        Self::verdict(self, dynamics, line)
    }
}

/// A number that the analysis does not take, with the keys that make it.
pub(crate) fn refused(error: &AnalysisError) -> Failure {
    let what = match error {
        AnalysisError::Range(range) => range.what,
        _ => "",
    };
    let advice = match what {
        "alpha" => format!("it is K·T²/m: change stiffness, mass or {SAMPLE_TIME}"),
        "beta" => format!("it is B·T^(2−μ)/m: change dissipation, mass or {SAMPLE_TIME}"),
        "delta" => format!("it is b·T/m: change {DAMPING}, {MASS} or {SAMPLE_TIME}"),
        "gamma" => format!("it is k·T²/m: change {HAND_STIFFNESS}, {MASS} or {SAMPLE_TIME}"),
        "mass" => format!("change {MASS}"),
        "damping" => format!("change {DAMPING}"),
        "hand stiffness" => format!("change {HAND_STIFFNESS}"),
        "sample time" => format!("change {SAMPLE_TIME}"),
        "stiffness" => "change the stiffness".to_owned(),
        "dissipation" => "change the dissipation".to_owned(),
        "delay" => format!("change {DELAY} or {SAMPLE_TIME}"),
        "lag" | "current lag" => format!("change {CURRENT_LAG} or {SAMPLE_TIME}"),
        _ => "take a device, a wall and a sample time that are more usual".to_owned(),
    };
    Failure::input_with_advice(format_args!("pre-flight: {error}"), advice)
}

impl Preflight<'_> {
    /// Looks at the loop with this device and `line` samples of delay beside its own.
    ///
    /// # Errors
    /// A number that the analysis does not take.
    pub fn verdict(&self, dynamics: Dynamics, line: usize) -> Result<PreflightVerdict, Failure> {
        let horizon = crate::run::schedule::horizon(self.samples);
        let t = Seconds(self.sample_time_s);
        let operator = loop_operator(self.model, self.scheme, self.order, t, horizon);
        let operator =
            operator.map_err(|error| Failure::bad_input(format_args!("pre-flight: {error}")))?;
        self.judge(dynamics, line, &operator)
            .map_err(|error| refused(&error))
    }

    fn judge(
        &self,
        dynamics: Dynamics,
        line: usize,
        operator: &LoopOperator,
    ) -> Result<PreflightVerdict, AnalysisError> {
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
        let scaled = |factor: f64| {
            SampledLoop::with_plant(plant, factor * wall.alpha, factor * wall.beta, operator)
                .map(SampledLoop::beside_rest)
        };
        let sampled = scaled(1.0)?;
        let stable = sampled.is_stable();
        let margin = if stable {
            sampled.margins()?.gain_up.map(|edge| edge.value)
        } else {
            softer(|factor| Ok(scaled(factor)?.is_stable()))?
        };
        let required = dynamics
            .port(self.sample_time_s, operator)?
            .required_delta(wall.alpha, wall.beta)?;
        Ok(PreflightVerdict {
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
            coupler: None,
        })
    }
}

/// The largest factor below 1 known to be stable, to three digits and rounded down; `None` if a millionth is
/// not.
pub(crate) fn softer(
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
