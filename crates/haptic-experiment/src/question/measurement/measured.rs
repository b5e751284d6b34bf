//! A device as a record tells it: numbers with their intervals, and what a user should know of them.

use super::intervals::GOES_ON;
use crate::document::parameters as p;
use crate::document::parameters::Parameter;
use crate::question::measurement::keys::{
    MEASURE_BOX, MEASURE_DURATION, MEASURE_FORCE_LIMIT, MEASURE_SAMPLE_TIME,
};
use crate::run::plant_file::{DeviceModel, DeviceValues, Interval};
use serde::Serialize;

/// Widest interval of the mass, half of it, that still is an answer.
pub(super) const UNSURE: f64 = 0.5;
/// Residuals beyond so many times what the sensor explains are worth a warning.
const UNEXPLAINED: f64 = 2.0;
/// Residuals below it, m, are none, whatever the sensor explains: finer than the sensor of a desktop device.
const UNNOTICED_M: f64 = 1e-7;
/// One lost sample in so many is worth a warning.
const LOST: usize = 1000;

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

    /// The interval holds that of another too.
    fn widen(&mut self, other: &Self) {
        self.low = self.low.min(other.low);
        self.high = self.high.max(other.high);
    }

    /// Half the width of the interval over the value.
    #[must_use]
    pub(crate) fn relative(&self) -> f64 {
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
    /// Correlation of successive residuals: near 0 unless the model is off.
    pub residual_correlation: f64,
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

/// Masses that differ by this factor are those of two devices that move alike.
const APART: f64 = 1.1;

impl Measured {
    /// This device, and another one that fits as well: intervals wide enough for both. Where their masses are apart, the one with the
    /// faster motor is told.
    pub(super) fn or_as_well(self, other: Self) -> Self {
        let (mut found, mut other) = (self, other);
        let ratio = other.mass_kg.value / found.mass_kg.value;
        if !(1.0 / APART..=APART).contains(&ratio) {
            if other.current_lag_s.value < found.current_lag_s.value {
                std::mem::swap(&mut found, &mut other);
            }
            found.warnings.push(format!(
                "the motion does not tell mass and current lag apart: {:.3} g and {:.3} ms fit as well as {:.3} g and {:.3} ms; the intervals \
                 hold both. Add a mass that you know and measure again, or take the lag from the motor's data",
                1e3 * found.mass_kg.value,
                1e3 * found.current_lag_s.value,
                1e3 * other.mass_kg.value,
                1e3 * other.current_lag_s.value
            ));
        }
        let hands = (found.hand_stiffness_n_per_m.iter_mut()).zip(&other.hand_stiffness_n_per_m);
        let numbers = [
            (&mut found.mass_kg, &other.mass_kg),
            (&mut found.current_lag_s, &other.current_lag_s),
            (&mut found.delay_s, &other.delay_s),
            (&mut found.damping_n_s_per_m, &other.damping_n_s_per_m),
            (&mut found.friction_n, &other.friction_n),
            (&mut found.bias_n, &other.bias_n),
        ];
        for (ours, theirs) in hands.chain(numbers) {
            ours.widen(theirs);
        }
        found
    }

    /// What a user should know. `ticks` are those of the whole record.
    pub(super) fn warn(&mut self, ticks: usize) {
        self.warn_of_losses(ticks);
        self.warn_of_the_unexplained();
        self.warn_of_the_unsure();
    }

    fn warn_of_losses(&mut self, ticks: usize) {
        let lost = self.lost_samples;
        if lost * LOST >= ticks && lost > 0 {
            self.warnings.push(format!(
                "{lost} of {ticks} samples were lost, and what the line lost on its way to the device nobody counted: free the machine or \
                 the line, or give a longer {MEASURE_SAMPLE_TIME}"
            ));
        }
    }

    fn warn_of_the_unexplained(&mut self) {
        let micro = |x: f64| 1e6 * x;
        let (left, expected) = (self.residual_rms_m, self.expected_residual_rms_m);
        // No sensor makes what goes on from sample to sample.
        let goes_on = self.residual_correlation > GOES_ON;
        let sensed = left * (1.0 - self.residual_correlation.clamp(0.0, 1.0)).sqrt();
        if (left > UNEXPLAINED * expected || goes_on) && left > UNNOTICED_M {
            self.warnings.push(format!(
                "the model is off by {:.3} µm rms, of which the sensor explains {:.3} µm: a line that loses frames, play, friction that \
                 changes with the place, or a hand that moves; the intervals allow for it as far as it comes and goes",
                micro(left),
                micro(expected.min(sensed))
            ));
        }
    }

    /// Intervals about as wide as their value; one of the mass is refused. A delay or lag much shorter than a sample, and a friction far
    /// below that at rest, may be as unsure as they like.
    fn warn_of_the_unsure(&mut self) {
        let half = |number: &Estimate| 0.5 * (number.high - number.low);
        let sample_s = self.sample_time_s;
        let at_rest_n = self.breakaway_n.unwrap_or(f64::INFINITY);
        let named = [
            (
                "damping",
                &self.damping_n_s_per_m,
                self.damping_n_s_per_m.value > 0.0,
            ),
            (
                "friction",
                &self.friction_n,
                half(&self.friction_n) > UNSURE * at_rest_n,
            ),
            (
                "delay",
                &self.delay_s,
                half(&self.delay_s) > UNSURE * sample_s,
            ),
            (
                "current lag",
                &self.current_lag_s,
                self.current_lag_s.low > 0.0 || half(&self.current_lag_s) > UNSURE * sample_s,
            ),
        ];
        for (what, number, counts) in named {
            let relative = number.relative();
            if counts && (relative > UNSURE || relative.is_nan()) {
                let known = match relative.is_finite() && relative < 10.0 {
                    true => format!("to ±{:.0} % only", 100.0 * relative),
                    false => "not at all".to_owned(),
                };
                self.warnings.push(format!(
                    "the {what} is known {known}: a larger {MEASURE_FORCE_LIMIT}, a larger {MEASURE_BOX} or a longer {MEASURE_DURATION} tells more"
                ));
            }
        }
    }
}

impl DeviceModel {
    /// A device that was measured.
    #[must_use]
    pub fn measured(found: &Measured, program: &str, note: &str) -> Self {
        let six = |value: f64| format!("{value:.5e}").parse().unwrap_or(value);
        let hand = found.hand_stiffness_n_per_m;
        let estimates: [(&'static Parameter, Option<Estimate>); 7] = [
            (&p::MASS, Some(found.mass_kg)),
            (&p::DAMPING, Some(found.damping_n_s_per_m)),
            (&p::HAND_STIFFNESS, hand),
            (&p::DELAY, Some(found.delay_s)),
            (&p::CURRENT_LAG, Some(found.current_lag_s)),
            (&p::FRICTION, Some(found.friction_n)),
            (&p::SENSOR_NOISE, Some(found.sensor_noise_m)),
        ];
        let intervals = estimates.iter().filter_map(|(parameter, estimate)| {
            estimate.map(|estimate| Interval {
                key: parameter.key,
                low: six(estimate.low),
                high: six(estimate.high),
            })
        });
        Self {
            values: DeviceValues {
                mass_kg: six(found.mass_kg.value),
                damping_n_s_per_m: six(found.damping_n_s_per_m.value),
                hand_stiffness_n_per_m: hand.map_or(0.0, |hand| six(hand.value)),
                delay_s: six(found.delay_s.value),
                current_lag_s: six(found.current_lag_s.value),
                friction_n: six(found.friction_n.value),
                encoder_resolution_m: six(found.encoder_resolution_m),
                sensor_noise_m: six(found.sensor_noise_m.value),
            },
            intervals: intervals.collect(),
            program: program.to_owned(),
            note: note.to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn about(value: f64, half: f64) -> Estimate {
        Estimate {
            value,
            low: (value - half).max(0.0),
            high: value + half,
        }
    }

    /// A device that was measured well.
    fn sound() -> Measured {
        Measured {
            mass_kg: about(0.065, 1e-4),
            damping_n_s_per_m: about(3.5, 0.01),
            friction_n: about(0.05, 1e-3),
            hand_stiffness_n_per_m: None,
            delay_s: about(1e-3, 1e-5),
            current_lag_s: about(0.0, 1e-4),
            encoder_resolution_m: 1e-5,
            sensor_noise_m: about(0.0, 1e-7),
            bias_n: about(0.0, 1e-3),
            breakaway_n: Some(0.06),
            residual_rms_m: 3e-6,
            expected_residual_rms_m: 2.9e-6,
            residual_correlation: 0.0,
            delay_lag_correlation: 0.0,
            sample_time_s: 1e-3,
            samples: 8000,
            lost_samples: 0,
            warnings: Vec::new(),
            curve: Vec::new(),
        }
    }

    type Defect = fn(&mut Measured);

    fn said(change: impl Fn(&mut Measured)) -> Vec<String> {
        let mut found = sound();
        change(&mut found);
        found.warn(10_000);
        found.warnings
    }

    #[test]
    fn a_sound_measurement_has_no_warnings_and_each_defect_has_one() {
        assert_eq!(said(|found| found.lost_samples = 9), [""; 0]);
        // Residuals of the arithmetic, where the sensor explains nothing.
        let exact = |found: &mut Measured| {
            (found.residual_rms_m, found.expected_residual_rms_m) = (1e-9, 0.0);
        };
        assert_eq!(said(exact), [""; 0]);
        let defects: [(&str, Defect); 8] = [
            ("10 of 10000 samples were lost", |found| {
                found.lost_samples = 10;
            }),
            (
                "off by 107.700 µm rms, of which the sensor explains 0.000",
                |found| {
                    (found.residual_rms_m, found.expected_residual_rms_m) = (107.7e-6, 0.0);
                },
            ),
            ("off by 9.000 µm", |found| found.residual_rms_m = 9e-6),
            ("off by 3.000 µm", |found| {
                found.residual_correlation = 0.06;
            }),
            ("the delay is known not at all", |found| {
                found.delay_s = about(1e-3, 1.47);
            }),
            ("the delay is known to ±60 %", |found| {
                found.delay_s = Estimate {
                    value: 1e-3,
                    low: 0.4e-3,
                    high: 1.6e-3,
                };
            }),
            ("the current lag is known not at all", |found| {
                found.current_lag_s = about(0.0, 2e-3);
            }),
            ("the friction is known not at all", |found| {
                found.friction_n = about(1e-3, 0.07);
            }),
        ];
        for (words, change) in defects {
            let said = said(change);
            assert!(
                said.len() == 1 && said[0].contains(words),
                "{words}: {said:?}"
            );
        }
    }
}
