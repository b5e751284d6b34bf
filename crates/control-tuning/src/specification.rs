//! Wishes for a loop, and which of them contradict each other.

use core::f64::consts::PI;
use fracdiff::{
    Seconds,
    parameter::{positive, range},
};
use fractional_control::{
    Actuator, ControlError, FractionalPid, HeldPlant, MODES, PidParameters, Plant, PowerMemory,
    Response, Rule, SetPoint, simulate,
};

/// A bound of a gain on one side of a frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// The frequency at which the bound begins or ends, rad/s.
    pub omega_rad_s: f64,
    /// The gain is at most this.
    pub at_most: f64,
}

/// Wishes for a loop of plant and PI^λD^μ.
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
    /// |S| at this frequency and below: the remaining share of a disturbance.
    pub disturbance: Option<Bound>,
    /// The largest |S|.
    pub sensitivity_peak: Option<f64>,
    /// The largest |T|.
    pub complementary_peak: Option<f64>,
}

/// The wish of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum WishName {
    /// `ω_c`, rad/s.
    Crossover,
    /// Phase margin, rad.
    PhaseMargin,
    /// dφ/d ln ω at `ω_c`, rad: 0 is flat.
    IsoDamping,
    /// Largest |S|.
    SensitivityPeak,
    /// Largest |T|.
    ComplementaryPeak,
    /// |T| from a frequency on.
    Noise,
    /// |S| up to a frequency.
    Disturbance,
}

/// A wish and the value reached.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Wish {
    /// The wish that the two numbers are of.
    pub name: WishName,
    /// The required value, in the unit that [`WishName`] states.
    pub wanted: f64,
    /// Value of the loop, in that unit.
    pub reached: f64,
}

/// A wish that is missed by less than this share is met.
const MET: f64 = 0.01;

impl Wish {
    pub(crate) const fn new(name: WishName, wanted: f64, reached: f64) -> Self {
        Self {
            name,
            wanted,
            reached,
        }
    }

    /// True if it is met within 1 %.
    #[must_use]
    pub fn is_met(&self) -> bool {
        match self.name {
            WishName::Crossover | WishName::PhaseMargin => {
                (self.reached / self.wanted - 1.0).abs() <= MET
            }
            WishName::IsoDamping => self.reached.abs() <= MET,
            WishName::SensitivityPeak
            | WishName::ComplementaryPeak
            | WishName::Noise
            | WishName::Disturbance => self.reached <= self.wanted * (1.0 + MET),
        }
    }
}

/// A wish that is not met, by the name of its field.
impl core::fmt::Display for Wish {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let field = match self.name {
            WishName::Crossover => "crossover_rad_s",
            WishName::PhaseMargin => "phase_margin_rad",
            WishName::IsoDamping => "iso_damping",
            WishName::SensitivityPeak => "sensitivity_peak",
            WishName::ComplementaryPeak => "complementary_peak",
            WishName::Noise => "noise",
            WishName::Disturbance => "disturbance",
        };
        write!(
            f,
            "`{field}` {:.4} is not reached: {:.4} is the best that was found; allow more, or move the crossover",
            self.wanted, self.reached
        )
    }
}

/// The sample time for which a controller is tuned, with the rule of its powers. The hold is taken into account.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampling {
    /// T of the loop that will run.
    pub sample_time: Seconds,
    /// The rule by which its powers are sampled.
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

    /// Each bound with what is reached: the largest |S| and |T|, and |T| and |S| beyond the frequencies of noise and disturbance.
    pub(crate) fn bounds(
        &self,
        [sensitivity, complementary]: [f64; 2],
        [noise, disturbance]: [Option<f64>; 2],
    ) -> impl Iterator<Item = Wish> {
        let peak = |name, most: Option<f64>, reached| Some(Wish::new(name, most?, reached));
        let beyond = |name, bound: Option<Bound>, reached: Option<f64>| {
            Some(Wish::new(name, bound?.at_most, reached?))
        };
        let all = [
            peak(
                WishName::SensitivityPeak,
                self.sensitivity_peak,
                sensitivity,
            ),
            peak(
                WishName::ComplementaryPeak,
                self.complementary_peak,
                complementary,
            ),
            beyond(WishName::Noise, self.noise, noise),
            beyond(WishName::Disturbance, self.disturbance, disturbance),
        ];
        all.into_iter().flatten()
    }

    /// |S| and |T| at the crossover: `1/(2 sin(φ_m/2))`.
    #[must_use]
    fn peak_at_crossover(&self) -> f64 {
        0.5 / libm::sin(0.5 * self.phase_margin_rad)
    }

    pub(crate) fn check(
        &self,
        plant: &Plant,
        sampling: Option<Sampling>,
    ) -> Result<(), ControlError> {
        let omega = positive("crossover", self.crossover_rad_s, "rad/s")?;
        let margin = self.phase_margin_rad;
        let inside = margin > 0.0 && margin < PI;
        let allowed = "above 0 and below π {}";
        range("phase margin", margin, inside, allowed, "rad")?;
        let (low, high) = plant.band();
        let inside = omega > low && omega < high;
        let allowed = "inside the band that was measured";
        range("crossover", omega, inside, allowed, "rad/s")?;
        if let Some(sampling) = sampling {
            let t = positive("sample time", sampling.sample_time.0, "s")?;
            plant.delay_samples(sampling.sample_time)?;
            if omega >= PI / t / 3.0 {
                return Err(ControlError::Contradiction {
                    first: "crossover_rad_s",
                    first_value: omega,
                    second: "sample_time_s",
                    second_value: t,
                    remedy: "use more than six samples a period",
                });
            }
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

/// Steps of the sampled loop, unlimited, all on the error, one for each of [`GAINS`]: `samples`
/// samples each. The command is computed for the nominal plant times the gain.
///
/// # Errors
/// A plant that does not run, parameters outside their range.
pub fn steps(
    parameters: &PidParameters,
    plant: &Plant,
    memory: PowerMemory,
    sample_time: Seconds,
    samples: usize,
) -> Result<Vec<Response>, ControlError> {
    let plant = HeldPlant::new(plant, memory, sample_time)?;
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
