//! Wishes for a loop, and which of them contradict each other.

use crate::records::MODES;
use crate::{
    Actuator, ControlError, FractionalPid, Memory, PidParameters, Plant, Response, Rule,
    SampledPlant, SetPoint, simulate,
};
use core::f64::consts::PI;
use fracdiff::Seconds;
use fracdiff::parameter::{positive, range};
use std::vec::Vec;

/// A bound of a gain on one side of a frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// The frequency, rad/s.
    pub omega_rad_s: f64,
    /// The gain is at most this.
    pub at_most: f64,
}

/// Wishes for a loop of plant and PI^λD^μ.
///
/// ```
/// use fractional_control::tuning::{Bound, Specification};
///
/// let wishes = Specification {
///     noise: Some(Bound { omega_rad_s: 10.0, at_most: 0.2 }),
///     ..Specification::new(0.5, 60_f64.to_radians())
/// };
/// assert!(wishes.iso_damping);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Specification {
    /// `ω_c`, where |L| is 1, rad/s.
    pub crossover_rad_s: f64,
    /// Phase margin at `ω_c`, rad.
    pub phase_margin_rad: f64,
    /// A flat phase at `ω_c`, dφ/dω = 0: the margin stays when the gain changes.
    pub iso_damping: bool,
    /// |T| at this frequency and above: what noise of the measurement does.
    pub noise: Option<Bound>,
    /// |S| at this frequency and below: what is left of a disturbance.
    pub disturbance: Option<Bound>,
    /// The largest |S|.
    pub sensitivity_peak: Option<f64>,
    /// The largest |T|.
    pub complementary_peak: Option<f64>,
}

/// The sample time for which a controller is tuned, with the rule of its powers. The hold is taken into account.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampling {
    /// T.
    pub sample_time: Seconds,
    /// The rule.
    pub rule: Rule,
}

impl Specification {
    /// Crossover in rad/s, phase margin in rad, flat phase; nothing else.
    #[must_use]
    pub const fn new(crossover_rad_s: f64, phase_margin_rad: f64) -> Self {
        Self {
            crossover_rad_s,
            phase_margin_rad,
            iso_damping: true,
            noise: None,
            disturbance: None,
            sensitivity_peak: None,
            complementary_peak: None,
        }
    }

    /// |S| and |T| at the crossover: `1/(2 sin(φ_m/2))`.
    #[must_use]
    pub(crate) fn peak_at_crossover(&self) -> f64 {
        0.5 / libm::sin(0.5 * self.phase_margin_rad)
    }

    /// Refuses what nothing can meet.
    pub(crate) fn check(
        &self,
        plant: &Plant,
        sampling: Option<Sampling>,
    ) -> Result<(), ControlError> {
        let omega = positive("crossover", self.crossover_rad_s, "rad/s")?;
        let margin = self.phase_margin_rad;
        let inside = margin > 0.0 && margin < PI;
        range("phase margin", margin, inside, "above 0 and below π", "rad")?;
        let (low, high) = plant.band();
        let inside = omega > low && omega < high;
        let allowed = "inside the band that was measured";
        range("crossover", omega, inside, allowed, "rad/s")?;
        if let Some(sampling) = sampling {
            let nyquist = PI / sampling.sample_time.0;
            positive("sample time", sampling.sample_time.0, "s")?;
            let allowed = "below a third of half the sample rate: sample faster";
            range("crossover", omega, omega < nyquist / 3.0, allowed, "rad/s")?;
        }
        self.check_bounds(omega)
    }

    fn check_bounds(&self, omega: f64) -> Result<(), ControlError> {
        let here = self.peak_at_crossover();
        let remedy = "at the crossover |S| and |T| are 1/(2 sin(margin/2)): move the frequency, allow more, or ask for more margin";
        let against_crossover = |first, bound: Bound| ControlError::Contradiction {
            first,
            first_value: bound.at_most,
            second: "crossover_rad_s",
            second_value: omega,
            remedy,
        };
        for (bound, above) in [(self.noise, true), (self.disturbance, false)] {
            let Some(bound) = bound else { continue };
            positive("frequency of a bound", bound.omega_rad_s, "rad/s")?;
            positive("bound of a gain", bound.at_most, "")?;
            let covers = if above {
                bound.omega_rad_s <= omega
            } else {
                bound.omega_rad_s >= omega
            };
            if covers && bound.at_most < here {
                let first = if above { "noise" } else { "disturbance" };
                return Err(against_crossover(first, bound));
            }
        }
        if let (Some(noise), Some(disturbance)) = (self.noise, self.disturbance) {
            // S + T = 1
            let overlap = noise.omega_rad_s <= disturbance.omega_rad_s;
            if overlap && noise.at_most + disturbance.at_most < 1.0 {
                return Err(ControlError::Contradiction {
                    first: "noise",
                    first_value: noise.at_most,
                    second: "disturbance",
                    second_value: disturbance.at_most,
                    remedy: "S + T is 1: keep the two bands apart",
                });
            }
        }
        for (first, peak) in [
            ("sensitivity_peak", self.sensitivity_peak),
            ("complementary_peak", self.complementary_peak),
        ] {
            let Some(peak) = peak else { continue };
            positive(first, peak, "")?;
            if peak < here {
                return Err(ControlError::Contradiction {
                    first,
                    first_value: peak,
                    second: "phase_margin_rad",
                    second_value: self.phase_margin_rad,
                    remedy: "allow at least 1/(2 sin(margin/2))",
                });
            }
        }
        Ok(())
    }
}

/// Gains of the plant over the nominal one: ± 6 dB in five steps.
pub const GAINS: [f64; 5] = [
    0.501_187_233_627_272_2,
    0.707_945_784_384_137_9,
    1.0,
    1.412_537_544_622_754_3,
    1.995_262_314_968_879_5,
];

/// Steps of the sampled loop, unlimited, all on the error, one for each of [`GAINS`]: `samples` samples each. The command is that for the
/// nominal plant times the gain.
///
/// ```
/// use fracdiff::Seconds;
/// use fractional_control::tuning::steps;
/// use fractional_control::{Memory, PidParameters, Plant, Rule};
///
/// let plant: Plant = "1/(s^1.3+0.1)".parse()?;
/// let gains = PidParameters { proportional: 1.0, ..PidParameters::NONE };
/// let memory = Memory::new(Rule::Bdf2, 1e-5, 100.0)?;
/// let steps = steps(&gains, &plant, memory, Seconds(0.02), 2000)?;
/// // A loop of about 1/s^1.3 overshoots alike at any gain.
/// assert!(steps.iter().all(|step| step.shape().overshoot < 0.1));
/// # Ok::<(), fractional_control::ControlError>(())
/// ```
/// # Errors
/// A plant that does not run, parameters outside their range.
pub fn steps(
    parameters: &PidParameters,
    plant: &Plant,
    memory: Memory,
    sample_time: Seconds,
    samples: usize,
) -> Result<Vec<Response>, ControlError> {
    let plant = SampledPlant::new(plant, memory, sample_time)?;
    let one = |gain: f64| {
        // The gain of the plant is that of the controller, as far as y goes.
        let scaled = PidParameters {
            proportional: gain * parameters.proportional,
            integral: gain * parameters.integral,
            derivative: gain * parameters.derivative,
            ..*parameters
        };
        let pid = FractionalPid::<f64, MODES>::new(
            scaled,
            SetPoint::ERROR,
            Actuator::UNLIMITED,
            memory,
            sample_time,
        )?;
        Ok(simulate(&pid, &plant, |_| 1.0, samples))
    };
    GAINS.into_iter().map(one).collect()
}
