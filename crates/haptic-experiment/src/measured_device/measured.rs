//! A device as a record tells it: numbers with their intervals, and what a user should know of them.

use serde::Serialize;

/// Widest interval of the mass, half of it, that still is an answer.
pub(super) const UNSURE: f64 = 0.5;
/// Residuals larger by this factor tell a worse fit from a better one.
const TELLS_APART: f64 = 1.02;
/// Residuals below it, m, are rounding and tell nothing.
const NOTHING_M: f64 = 1e-15;
/// Residuals beyond so many times what the sensor explains are worth a warning.
const UNEXPLAINED: f64 = 2.0;

/// A number and the interval in which it lies in 95 of 100 cases, if the model is right.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// The most likely value.
    pub value: f64,
    /// Low end.
    pub low: f64,
    /// High end.
    pub high: f64,
}

impl Estimate {
    /// True of a number in the interval.
    #[must_use]
    pub fn covers(&self, number: f64) -> bool {
        (self.low..=self.high).contains(&number)
    }

    /// Half the width of the interval over the value.
    #[must_use]
    pub fn relative(&self) -> f64 {
        0.5 * (self.high - self.low) / self.value.abs()
    }
}

/// A device, as a record tells it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Measured {
    /// m.
    pub mass_kg: Estimate,
    /// b.
    pub damping_n_s_per_m: Estimate,
    /// `F_c`, while it slides.
    pub friction_n: Estimate,
    /// k of a hand; `None` if there was none.
    pub hand_stiffness_n_per_m: Option<Estimate>,
    /// D: from a measurement to the force that answers it, beside the hold.
    pub delay_s: Estimate,
    /// τ.
    pub current_lag_s: Estimate,
    /// q; 0 if no steps were seen.
    pub encoder_resolution_m: f64,
    /// σ: noise of the position beside the rounding to steps, and whatever the model does not explain.
    pub sensor_noise_m: Estimate,
    /// w: a constant force, as that of a slope or a cable.
    pub bias_n: Estimate,
    /// Half the force between those at which it began to move upwards and downwards: friction at rest, at most.
    pub breakaway_n: Option<f64>,
    /// Root mean square of model less record.
    pub residual_rms_m: f64,
    /// What rounding and the noise at rest explain of it.
    pub expected_residual_rms_m: f64,
    /// Correlation of delay and lag, −1 to 1.
    pub delay_lag_correlation: f64,
    /// Sample time of the record.
    pub sample_time_s: f64,
    /// Samples that were fitted.
    pub samples: usize,
    /// Samples that were lost.
    pub lost_samples: usize,
    /// Facts that a user should know.
    pub warnings: Vec<String>,
    /// Time since the start, s, position read and position of the model, m, of each fitted tick.
    #[serde(skip)]
    pub curve: Vec<[f64; 3]>,
}

impl Measured {
    /// This device, or the one with exchanged time constants if that fits better. If none does, the one with the faster motor,
    /// its intervals wide enough for both.
    pub(super) fn or_exchanged(self, other: Self) -> Self {
        let [ours, theirs] = [&self, &other].map(|found| found.residual_rms_m.max(NOTHING_M));
        let apart = |a: &Estimate, b: &Estimate| a.high < b.low || b.high < a.low;
        if !apart(&self.mass_kg, &other.mass_kg) || theirs > TELLS_APART * ours {
            return self;
        }
        if ours > TELLS_APART * theirs {
            return other;
        }
        let faster = |a: &Self, b: &Self| a.current_lag_s.value <= b.current_lag_s.value;
        let (mut found, other) = if faster(&self, &other) {
            (self, other)
        } else {
            (other, self)
        };
        found.warnings.push(format!(
            "the motion does not tell mass and current lag apart: {:.3} g and {:.3} ms fit as well as {:.3} g and {:.3} ms; the intervals \
             hold both. Add a mass that you know and measure again, or take the lag from the motor's data",
            1e3 * found.mass_kg.value,
            1e3 * found.current_lag_s.value,
            1e3 * other.mass_kg.value,
            1e3 * other.current_lag_s.value
        ));
        for (ours, theirs) in [
            (&mut found.mass_kg, other.mass_kg),
            (&mut found.current_lag_s, other.current_lag_s),
            (&mut found.delay_s, other.delay_s),
            (&mut found.damping_n_s_per_m, other.damping_n_s_per_m),
            (&mut found.friction_n, other.friction_n),
        ] {
            ours.low = ours.low.min(theirs.low);
            ours.high = ours.high.max(theirs.high);
        }
        found
    }

    /// What a user should know.
    pub(super) fn warn(&mut self) {
        let micro = |x: f64| 1e6 * x;
        let (left, expected) = (self.residual_rms_m, self.expected_residual_rms_m);
        if expected > 0.0 && left > UNEXPLAINED * expected {
            self.warnings.push(format!(
                "the model is off by {:.3} µm rms, of which the sensor explains {:.3} µm: play, friction that changes with the place, or a hand \
                 that moves; the intervals allow for it as far as it comes and goes",
                micro(left),
                micro(expected)
            ));
        }
        let wide = [
            (
                "damping",
                self.damping_n_s_per_m.relative(),
                self.damping_n_s_per_m.value > 0.0,
            ),
            (
                "current lag",
                self.current_lag_s.relative(),
                self.current_lag_s.low > 0.0,
            ),
        ];
        for (what, relative, counts) in wide {
            if counts && relative > UNSURE {
                self.warnings.push(format!(
                    "the {what} is known to ±{:.0} % only: a larger `force_limit_n`, a larger `box_m` or a longer `duration_s` tells more",
                    100.0 * relative
                ));
            }
        }
    }
}
