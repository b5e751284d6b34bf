//! A device that presses a specimen: a physical tissue in continuous time, which knows nothing of the law or the sample time of a loop.
//!
//! ```text
//! spring-pot   σ = V·D^α ε      G(t) = (V·sin(πα)/π)·∫ r^α·e^(−rt) d(ln r)     a sum of exponentials, evenly spaced in ln r
//! parallel     σ = Σσᵢ          series   ε = Σεᵢ, one σ
//! device       m·x'' + b·x' = u − F,   F = max(0, γ·σ),   ε = e(max(x, 0))
//! ```
//! - *Symbols*: V in Pa·s^α, α from 0, a spring, to 1, a dashpot; γ the shape in m, e the map of the depth, m.
//! - *Steps* of at most 50 µs, in which ε is straight and F held. F is that of the middle of a step, so both are of second order.
//! - *Independent* of what renders a tissue: no weights of a difference, no sample time; the exponentials reach from 10⁻⁷ s⁻¹ to a hundred
//!   times the rate of the steps, and both ends of the spectrum are summed to infinity. The relative error of G is below 1e-6.
//! - *Start-up*: at rest at 0, where the specimen begins. It never pulls. *Cost* of a step: some 60 products per spring-pot.

use super::{MassDamper, MassDamperConfig};
use crate::units::Seconds;
use crate::{DepthMap, Device, LoopParameterError, Reading, SafeForce};
use alloc::vec::Vec;
use core::convert::Infallible;
use core::f64::consts::PI;
use fracdiff::Real;
use fracdiff::parameter::{positive, range};
use nalgebra::SVector;

/// Longest step, s, in which ε is straight and F held.
const STEP_MOST: f64 = 5e-5;
/// Δ ln r between exponentials; the error of the sum is e^(−π²/Δ).
const SPACING: f64 = 0.5;
/// Slowest rate, 1/s.
const SLOWEST: f64 = 1e-7;
/// Fastest rate times the step.
const FASTEST: f64 = 100.0;

/// Springs, dashpots and spring-pots of a specimen, and how they are joined.
#[derive(Clone, Debug, PartialEq)]
pub enum SpecimenMatter {
    /// V in Pa·s^α, and α.
    SpringPot {
        /// V, at least 0.
        size: f64,
        /// α in [0, 1].
        order: f64,
    },
    /// Elements side by side: their stresses add.
    Parallel(Vec<Self>),
    /// Elements in a row: their strains add.
    Series(Vec<Self>),
}

/// A specimen by its matter and its shape.
#[derive(Clone, Debug, PartialEq)]
pub struct PressedSpecimen {
    /// Springs, dashpots and spring-pots, and how they are joined.
    pub matter: SpecimenMatter,
    /// γ, m: force over stress and depth.
    pub shape_m: f64,
    /// e, where the force is not linear in the depth.
    pub map: Option<DepthMap<f64>>,
}

/// A joint with its state. In a step the stress at its end is gain·Δε + past.
#[derive(Clone, Debug)]
struct Part {
    gain: f64,
    kind: Kind,
}

#[derive(Clone, Debug)]
enum Kind {
    /// Its strain.
    Spring(f64),
    Dashpot,
    /// A weight, a decay and a share of each mode, and its state.
    Modes(Vec<[f64; 4]>),
    Parallel(Vec<Part>),
    Series(Vec<Part>),
}

impl Part {
    /// Matter at rest, in steps of `h` s.
    fn new(matter: &SpecimenMatter, h: f64) -> Result<Self, LoopParameterError> {
        let parts = |all: &[SpecimenMatter]| {
            let parts: Result<Vec<Self>, _> = all.iter().map(|one| Self::new(one, h)).collect();
            parts
        };
        Ok(match matter {
            SpecimenMatter::SpringPot { size, order } => {
                let size = range("element", *size, *size >= 0.0, "at least 0", "Pa·s^α")?;
                let fits = (0.0..=1.0).contains(order);
                Self::spring_pot(size, range("order", *order, fits, "in [0, 1]", "")?, h)
            }
            SpecimenMatter::Parallel(all) => {
                let parts = parts(all)?;
                let gain = parts.iter().map(|part| part.gain).sum();
                let kind = Kind::Parallel(parts);
                Self { gain, kind }
            }
            SpecimenMatter::Series(all) => {
                let parts = parts(all)?;
                let gain = 1.0 / parts.iter().map(|part| 1.0 / part.gain).sum::<f64>();
                let kind = Kind::Series(parts);
                Self { gain, kind }
            }
        })
    }

    fn spring_pot(size: f64, order: f64, h: f64) -> Self {
        let spring = |size| Self {
            gain: size,
            kind: Kind::Spring(0.0),
        };
        let dashpot = |size: f64| Self {
            gain: size / h,
            kind: Kind::Dashpot,
        };
        if order <= 0.0 {
            return spring(size);
        }
        if order >= 1.0 {
            return dashpot(size);
        }
        let density = size * libm::sin(PI * order) / PI * SPACING;
        let count = libm::ceil(libm::log(FASTEST / (h * SLOWEST)) / SPACING) as usize;
        let rate = |n: usize| SLOWEST * libm::exp(SPACING * n as f64);
        let weight = |rate: f64| density * libm::pow(rate, order);
        let modes = (0..count).map(|n| {
            let decay = -rate(n) * h;
            let share = libm::expm1(decay) / decay;
            [weight(rate(n)), libm::exp(decay), share, 0.0]
        });
        let modes: Vec<[f64; 4]> = modes.collect();
        // Beyond both ends the terms are geometric: modes that never relax, and those that do at once.
        let (slower, faster) = (
            libm::exp(-SPACING * order),
            libm::exp(-SPACING * (1.0 - order)),
        );
        let last = rate(count - 1);
        let parts = [
            spring(weight(SLOWEST) * slower / (1.0 - slower)),
            Self {
                gain: modes.iter().map(|mode| mode[0] * mode[2]).sum(),
                kind: Kind::Modes(modes),
            },
            dashpot(weight(last) / last * faster / (1.0 - faster)),
        ];
        Self {
            gain: parts.iter().map(|part| part.gain).sum(),
            kind: Kind::Parallel(parts.into()),
        }
    }

    /// The stress at the end of a step without strain.
    fn past(&self) -> f64 {
        match &self.kind {
            Kind::Spring(strain) => self.gain * strain,
            Kind::Dashpot => 0.0,
            Kind::Modes(modes) => modes.iter().map(|mode| mode[0] * mode[1] * mode[3]).sum(),
            Kind::Parallel(parts) => parts.iter().map(Self::past).sum(),
            Kind::Series(parts) => {
                let past = parts.iter().map(|part| part.past() / part.gain);
                self.gain * past.sum::<f64>()
            }
        }
    }

    fn advance(&mut self, strain: f64) {
        let stress = match &self.kind {
            Kind::Series(_) => self.past() + self.gain * strain,
            Kind::Spring(_) | Kind::Dashpot | Kind::Modes(_) | Kind::Parallel(_) => 0.0,
        };
        match &mut self.kind {
            Kind::Spring(now) => *now += strain,
            Kind::Dashpot => {}
            Kind::Modes(modes) => {
                for [_, decay, share, state] in modes {
                    *state = *decay * *state + *share * strain;
                }
            }
            Kind::Parallel(parts) => parts.iter_mut().for_each(|part| part.advance(strain)),
            Kind::Series(parts) => {
                for part in parts {
                    part.advance((stress - part.past()) / part.gain);
                }
            }
        }
    }
}

/// A device with a specimen at its handle.
#[derive(Clone, Debug)]
pub struct PressedDevice {
    device: MassDamper<1>,
    specimen: PressedSpecimen,
    part: Part,
    at_rest: Part,
    /// e(δ) of the last step, m.
    effective: f64,
    /// F of the last step, N, never negative.
    force_n: f64,
    steps: u64,
    /// Steps in a sample time, at least 1.
    per_sample: u64,
    sample_time: f64,
}

impl PressedDevice {
    /// A device at rest at 0, in front of its specimen.
    ///
    /// # Errors
    /// A device or a specimen that its own type refuses; a delay beyond 64 steps.
    pub fn new(
        config: MassDamperConfig,
        specimen: PressedSpecimen,
    ) -> Result<Self, LoopParameterError> {
        let sample_time = positive("sample time", config.sample_time.0, "s")?;
        positive("shape of the specimen", specimen.shape_m, "m")?;
        // A ratio just above a whole number is that number.
        let per_sample = libm::ceil(sample_time / STEP_MOST - 1e-9).max(1.0);
        let h = sample_time / per_sample;
        let part = Part::new(&specimen.matter, h)?;
        let sample_time_of_step = Seconds(h);
        Ok(Self {
            device: MassDamper::new(MassDamperConfig {
                sample_time: sample_time_of_step,
                ..config
            })?,
            specimen,
            at_rest: part.clone(),
            part,
            effective: 0.0,
            force_n: 0.0,
            steps: 0,
            per_sample: per_sample as u64,
            sample_time,
        })
    }

    /// Back to rest at 0, with a specimen that nobody has pressed.
    pub fn restart(&mut self) {
        self.device.restart();
        self.part.clone_from(&self.at_rest);
        (self.effective, self.force_n, self.steps) = (0.0, 0.0, 0);
    }

    /// True position now, m, from where the specimen begins.
    #[must_use]
    pub fn position(&self) -> f64 {
        self.device.position()[0]
    }

    /// Force of the specimen on the device, N: at most 0, as it pushes it out.
    #[must_use]
    pub const fn contact_force(&self) -> f64 {
        0.0 - self.force_n
    }

    /// Moves on by steps of its own under this force, N.
    pub fn advance(&mut self, force_n: f64, steps: u64) {
        let h = self.device.config().sample_time.0;
        for _ in 0..steps {
            let middle = self.position() + 0.5 * h * self.device.velocity()[0];
            let depth = middle.max(0.0);
            let effective = self.specimen.map.map_or(depth, |map| map.at(depth));
            let strain = effective - self.effective;
            let stress = self.part.past() + self.part.gain * strain;
            self.part.advance(strain);
            self.effective = effective;
            self.force_n = if middle > 0.0 {
                (self.specimen.shape_m * stress).max(0.0)
            } else {
                0.0
            };
            self.device.set_external_force([0.0 - self.force_n].into());
            self.device.advance([force_n].into());
            self.steps += 1;
        }
    }
}

impl<F: Real> Device<F, 1> for PressedDevice {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<F, 1>, Infallible> {
        let tick = self.steps / self.per_sample;
        Ok(Reading {
            tick,
            time_s: tick as f64 * self.sample_time,
            position_m: SVector::from([F::from_f64(self.position())]),
        })
    }

    fn write(&mut self, force: SafeForce<F, 1>) -> Result<(), Infallible> {
        self.advance(force.newtons()[0].to_f64(), self.per_sample);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::{Kilograms, NewtonSecondsPerMetre};

    const H: f64 = 5e-5;

    fn pot(size: f64, order: f64) -> SpecimenMatter {
        SpecimenMatter::SpringPot { size, order }
    }

    /// Stress at these times after a ramp of `ramp_s` to a strain of 1.
    fn relaxed(matter: &SpecimenMatter, ramp_s: f64, times_s: &[f64]) -> Vec<f64> {
        let mut part = Part::new(matter, H).expect("matter");
        let last = (times_s[times_s.len() - 1] / H).round() as usize;
        let ramp = (ramp_s / H).round() as usize;
        let mut stress = Vec::new();
        for n in 0..last {
            let strain = if n < ramp { 1.0 / ramp as f64 } else { 0.0 };
            stress.push(part.past() + part.gain * strain);
            part.advance(strain);
        }
        let at = times_s.iter().map(|t| stress[(t / H).round() as usize - 1]);
        at.collect()
    }

    /// ∫₀^T G(t − s) ds/T of a spring-pot is V·(t^(1−α) − (t − T)^(1−α))/(T·Γ(2 − α)).
    #[test]
    fn a_spring_pot_relaxes_by_its_power_law_after_a_ramp() {
        let (ramp_s, times) = (0.1, [0.05, 0.1, 0.2, 1.0, 5.0]);
        for order in [0.02, 0.2, 0.5, 0.9, 0.98] {
            let found = relaxed(&pot(3000.0, order), ramp_s, &times);
            for (t, found) in times.into_iter().zip(found) {
                let power = |t: f64| libm::pow(t.max(0.0), 1.0 - order);
                let wanted =
                    3000.0 * (power(t) - power(t - ramp_s)) / (ramp_s * libm::tgamma(2.0 - order));
                assert!(
                    (found / wanted - 1.0).abs() < 1e-6,
                    "{order} {t}: {found} {wanted}"
                );
            }
        }
    }

    /// A Zener model relaxes by one exponential; two equal spring-pots in series are one of half the size.
    #[test]
    fn joints_are_those_of_their_closed_forms() {
        let maxwell = SpecimenMatter::Series(alloc::vec![pot(2000.0, 0.0), pot(600.0, 1.0)]);
        let zener = SpecimenMatter::Parallel(alloc::vec![pot(1000.0, 0.0), maxwell]);
        let (ramp, tau) = (0.1, 0.3);
        for (t, found) in [0.2, 0.5, 2.0]
            .into_iter()
            .zip(relaxed(&zener, ramp, &[0.2, 0.5, 2.0]))
        {
            let grown = libm::expm1(ramp / tau) * tau / ramp;
            let wanted = 1000.0 + 2000.0 * grown * libm::exp(-t / tau);
            // The step of a dashpot in series is of first order: h/τ = 2e-4 of a part that decays.
            assert!((found / wanted - 1.0).abs() < 3e-4, "{t}: {found} {wanted}");
        }
        let twice = SpecimenMatter::Series(alloc::vec![pot(4000.0, 0.3), pot(4000.0, 0.3)]);
        let [found, wanted] = [twice, pot(2000.0, 0.3)].map(|one| relaxed(&one, ramp, &[1.0])[0]);
        assert!((found / wanted - 1.0).abs() < 1e-12, "{found} {wanted}");
    }

    /// Against a spring the device comes to rest where the force is its own, and what is pulled out of a specimen is not held back.
    #[test]
    fn a_device_rests_where_its_force_is_that_of_the_specimen_and_is_never_pulled() {
        let config =
            MassDamperConfig::ideal(Kilograms(0.065), NewtonSecondsPerMetre(10.0), Seconds(1e-3));
        let specimen = PressedSpecimen {
            matter: pot(1e4, 0.0),
            shape_m: 0.02,
            map: None,
        };
        let mut device = PressedDevice::new(config, specimen).expect("a device");
        device.advance(0.5, 40_000);
        assert!((device.position() - 0.5 / 200.0).abs() < 1e-9);
        assert!((device.contact_force() + 0.5).abs() < 1e-6);
        device.advance(-0.5, 10_000);
        assert!(device.position() < 0.0 && device.contact_force() == 0.0);
        device.restart();
        assert_eq!((device.position().to_bits(), device.steps), (0, 0));
    }
}
