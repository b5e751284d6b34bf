//! The standard simulated device: a mass with damping, and optionally a hand, friction, delay,
//! saturation and actuator lag.

use super::discretise::{moved, transition};
use crate::error::Checks;
use crate::units::{Kilograms, NewtonSecondsPerMetre, Newtons, NewtonsPerMetre, Seconds};
use crate::{Device, LoopParameterError, Reading, SafeForce};
use core::convert::Infallible;
use fracdiff::Real;
use nalgebra::{Matrix4, SVector, Vector4};

/// Parameters of a [`MassDamper`]. Every effect after the sample time is off when zero or `None`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassDamperConfig {
    /// m > 0: device, plus the hand if there is one.
    pub mass: Kilograms,
    /// b ≥ 0, viscous: device, plus the hand.
    pub damping: NewtonSecondsPerMetre,
    /// T > 0, the time from one write to the next.
    pub sample_time: Seconds,
    /// k ≥ 0, hand stiffness towards position 0.
    pub stiffness: NewtonsPerMetre,
    /// Fc ≥ 0, Coulomb friction per axis. With it k·T²/m must not exceed 1.
    pub friction: Newtons,
    /// Time from a write to the force acting, 0 to [`MAX_DELAY_SAMPLES`]
    /// sample times, not necessarily whole.
    pub delay: Seconds,
    /// Largest magnitude of the actuator's force, > 0, per axis.
    pub saturation: Option<Newtons>,
    /// τ ≥ 0, time constant of the actuator's current.
    pub current_lag: Seconds,
    /// g, force for each newton written: 1 of an actuator that is what it says, below 0 of one whose leads are swapped.
    pub gain: f64,
}

impl MassDamperConfig {
    /// A plain mass-damper: no hand, no friction, an ideal actuator.
    #[must_use]
    pub const fn ideal(
        mass: Kilograms,
        damping: NewtonSecondsPerMetre,
        sample_time: Seconds,
    ) -> Self {
        Self {
            mass,
            damping,
            sample_time,
            stiffness: NewtonsPerMetre(0.0),
            friction: Newtons(0.0),
            delay: Seconds(0.0),
            saturation: None,
            current_lag: Seconds(0.0),
            gain: 1.0,
        }
    }
}

/// A mass-damper with a hand, D equal and independent axes.
///
/// ```text
/// m·x'' + b·x' + k·x = a + w + r        τ·a' = u(t - delay) - a,  or a = u(t - delay) if τ = 0
/// ```
/// - *Symbols*: x position m; a actuator force N; u written force N times g after saturation, held for one
///   sample time T; w external force N, constant until set again; r friction N, |r| ≤ Fc.
///   Positive forces act towards positive positions.
/// - *Exact* at the sample instants without friction, for any b, k, delay and lag, by the matrix
///   exponential. A delay of (d + η)·T splits each sample at η·T, where the force changes.
/// - *Friction* is held over a (part) sample and chosen to end at rest if it can. Instants of
///   stopping, breaking away and reversing are right to one sample, so a sliding distance to
///   O(T²); a mass at rest whose net force stays within Fc does not move by a single bit. Per
///   axis, so not isotropic.
/// - *Start-up*: at rest at 0, no force in the delay line. *Output*: the position of tick n is
///   x(n·T), before the force written in tick n.
/// - *Cost* per sample: one 4×4 product per axis, two with a fractional delay; no allocation, no
///   panic.
#[derive(Clone, Debug)]
pub struct MassDamper<const D: usize> {
    config: MassDamperConfig,
    delay: usize,
    /// η·T under the older force, if η > 0.
    before: Option<Step>,
    /// The rest of the sample.
    after: Step,
    limit: f64,
    axes: [Axis; D],
    line: ForceLine<D>,
    external: SVector<f64, D>,
    tick: u64,
}

#[derive(Clone, Copy, Debug, Default)]
struct Axis {
    position: f64,
    velocity: f64,
    actuator: f64,
}

impl<const D: usize> MassDamper<D> {
    /// A plant at rest at position 0.
    ///
    /// # Errors
    /// Each parameter must be finite and in the range its field states; and the fastest motion
    /// (b·T/m, k·T²/m, T/τ) must stay below 1e6 per sample.
    pub fn new(config: MassDamperConfig) -> Result<Self, LoopParameterError> {
        let mut checks = Checks::default();
        let mass = checks.positive("mass", config.mass.0, "kg");
        checks.not_negative("damping", config.damping.0, "N·s/m");
        let sample_time = checks.positive("sample time", config.sample_time.0, "s");
        let stiffness = checks.not_negative("hand stiffness", config.stiffness.0, "N/m");
        let friction = checks.not_negative("friction", config.friction.0, "N");
        checks.not_negative("current lag", config.current_lag.0, "s");
        checks.range("gain", config.gain, true, "finite", "");
        let limit = config.saturation.map_or(f64::INFINITY, |limit| {
            checks.positive("actuator saturation", limit.0, "N")
        });
        let (delay, fraction) = whole_and_fraction("delay", config.delay, sample_time, &mut checks);
        // A held friction force must push the velocity its own way: sin(ω·T) > 0.
        let pushes = !(friction > 0.0 && stiffness * sample_time * sample_time > mass);
        let allowed = "at most m/T², as with friction";
        checks.range("hand stiffness", stiffness, pushes, allowed, "N/m");
        checks.done()?;
        let before = if fraction > 0.0 {
            Some(Step::new(&config, fraction * sample_time)?)
        } else {
            None
        };
        Ok(Self {
            config,
            delay,
            before,
            after: Step::new(&config, (1.0 - fraction) * sample_time)?,
            limit,
            axes: [Axis::default(); D],
            line: ForceLine::at_rest(),
            external: SVector::from([0.0; D]),
            tick: 0,
        })
    }

    /// Another device at rest at position 0, under the same external force.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with(&self, config: MassDamperConfig) -> Result<Self, LoopParameterError> {
        Ok(Self {
            external: self.external,
            ..Self::new(config)?
        })
    }

    /// Back to rest at position 0 and tick 0, no force in the delay line. The external force stays.
    pub fn restart(&mut self) {
        self.axes = [Axis::default(); D];
        self.line = ForceLine::at_rest();
        self.tick = 0;
    }

    /// Puts the mass at `position` (m) with `velocity` (m/s). Forces and time continue.
    pub fn set_state(&mut self, position: SVector<f64, D>, velocity: SVector<f64, D>) {
        for (index, axis) in self.axes.iter_mut().enumerate() {
            axis.position = position[index];
            axis.velocity = velocity[index];
        }
    }

    /// Sets w, N: a hand's push, gravity. Acts from now on, undelayed and unlimited.
    pub fn set_external_force(&mut self, force: SVector<f64, D>) {
        self.external = force;
    }

    /// True position now, m, of each axis.
    #[must_use]
    pub fn position(&self) -> SVector<f64, D> {
        SVector::from_fn(|axis, _| self.axes[axis].position)
    }

    /// True velocity now, m/s, of each axis.
    #[must_use]
    pub fn velocity(&self) -> SVector<f64, D> {
        SVector::from_fn(|axis, _| self.axes[axis].velocity)
    }

    /// a, the actuator's force at the end of the last sample, N: after delay, saturation and lag.
    #[must_use]
    pub fn applied_force(&self) -> SVector<f64, D> {
        SVector::from_fn(|axis, _| self.axes[axis].actuator)
    }

    /// w − k·x now, N: the push from outside and the spring of the hand, what a force sensor in the handle shows.
    #[must_use]
    pub fn contact_force(&self) -> SVector<f64, D> {
        self.external - self.position() * self.config.stiffness.0
    }

    /// The parameters it was made from.
    #[must_use]
    pub const fn config(&self) -> &MassDamperConfig {
        &self.config
    }

    /// Moves on by a sample under this force, N.
    pub(super) fn advance(&mut self, force: SVector<f64, D>) {
        let (low, high) = (-self.limit, self.limit);
        let gain = self.config.gain;
        self.line
            .push(force.map(|axis| (gain * axis).max(low).min(high)));
        for (index, axis) in self.axes.iter_mut().enumerate() {
            let external = self.external[index];
            if let Some(before) = &self.before {
                // η > 0, so d + 1 is at most the length of the line.
                before.advance(axis, self.line.aged(self.delay + 1)[index], external);
            }
            self.after
                .advance(axis, self.line.aged(self.delay)[index], external);
        }
        self.tick += 1;
    }
}

impl MassDamper<1> {
    /// Moves on under each of these forces, held for `parts` sample times; `see` sees the position, m, before it.
    ///
    /// For records that are replayed a thousand times: not generic, so compiled once and here.
    pub fn replay(
        &mut self,
        forces: &mut dyn Iterator<Item = SafeForce<f64, 1>>,
        parts: u32,
        see: &mut dyn FnMut(f64),
    ) {
        for force in forces {
            see(self.axes[0].position);
            for _ in 0..parts {
                self.advance(*force.newtons());
            }
        }
    }
}

impl<F: Real, const D: usize> Device<F, D> for MassDamper<D> {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<F, D>, Infallible> {
        Ok(Reading {
            tick: self.tick,
            time_s: self.tick as f64 * self.config.sample_time.0,
            position_m: self.position().map(F::from_f64),
        })
    }

    fn write(&mut self, force: SafeForce<F, D>) -> Result<(), Infallible> {
        self.advance(force.newtons().map(F::to_f64));
        Ok(())
    }
}

/// The motion of one axis over a fixed time, the commanded and external force being constant.
#[derive(Clone, Debug)]
struct Step {
    /// Transition of the state x, v, e = a - u, held force u + w + r.
    transition: Matrix4<f64>,
    stiffness: f64,
    friction: f64,
    lags: bool,
}

impl Step {
    fn new(config: &MassDamperConfig, duration: f64) -> Result<Self, LoopParameterError> {
        let (m, b, k) = (config.mass.0, config.damping.0, config.stiffness.0);
        let lags = config.current_lag.0 > 0.0;
        let decay = if lags {
            -1.0 / config.current_lag.0
        } else {
            0.0
        };
        #[rustfmt::skip]
        let generator = Matrix4::new(
            0.0,    1.0,    0.0,     0.0,
            -k / m, -b / m, 1.0 / m, 1.0 / m,
            0.0,    0.0,    decay,   0.0,
            0.0,    0.0,    0.0,     0.0,
        );
        // Natural units: the faster of one step h and one radian of oscillation sets the time.
        let rate = libm::sqrt(k / m).max(1.0 / duration);
        let force = m * rate * rate;
        let scale = Vector4::new(1.0, rate, force, force);
        Ok(Self {
            transition: transition(&generator, &scale, duration)?,
            stiffness: k,
            friction: config.friction.0,
            lags,
        })
    }

    fn advance(&self, axis: &mut Axis, command: f64, external: f64) {
        let start = *axis;
        let actuator = if self.lags { start.actuator } else { command };
        let held = command + external;
        let state = Vector4::new(start.position, start.velocity, actuator - command, held);
        let free = moved(&self.transition, &state);
        axis.actuator = command + free[2];
        if self.friction == 0.0 {
            (axis.position, axis.velocity) = (free[0], free[1]);
            return;
        }
        // The actuator's force is monotone within the step: its ends bound it.
        let resting = external - self.stiffness * start.position;
        let net = (actuator + resting)
            .abs()
            .max((axis.actuator + resting).abs());
        if start.velocity == 0.0 && net <= self.friction {
            return;
        }
        match coulomb(self.friction, free[1], self.transition[(1, 3)]) {
            Friction::Stops(force) => {
                axis.position = free[0] + self.transition[(0, 3)] * force;
                axis.velocity = 0.0;
            }
            Friction::Slides(force) => {
                axis.position = free[0] + self.transition[(0, 3)] * force;
                axis.velocity = free[1] + self.transition[(1, 3)] * force;
            }
        }
    }
}

/// Longest delay of a plant's force, in samples.
pub const MAX_DELAY_SAMPLES: usize = 64;

const LENGTH: usize = MAX_DELAY_SAMPLES + 1;

/// A delay of d + η samples, 0 ≤ η < 1: `(d, η)`.
///
/// A ratio within 1e-9 of a whole number is that number, so that 3e-3 s / 1e-3 s is 3 and not just
/// below.
///
/// Refused unless 0 ≤ delay ≤ [`MAX_DELAY_SAMPLES`] sample times.
pub(super) fn whole_and_fraction(
    what: &'static str,
    delay: Seconds,
    sample_time: f64,
    checks: &mut Checks,
) -> (usize, f64) {
    let ratio = checks.not_negative(what, delay.0, "s") / sample_time;
    let nearest = libm::rint(ratio);
    let ratio = if (ratio - nearest).abs() < 1e-9 {
        nearest
    } else {
        ratio
    };
    let short = ratio <= MAX_DELAY_SAMPLES as f64;
    checks.range(what, delay.0, short, "from 0 to 64 sample times", "s");
    let whole = libm::floor(ratio);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "0 ≤ whole ≤ 64"
    )]
    (whole as usize, ratio - whole)
}

/// The last commanded forces, N; zero before the first.
#[derive(Clone, Debug)]
struct ForceLine<const D: usize> {
    forces: [SVector<f64, D>; LENGTH],
    newest: usize,
}

impl<const D: usize> ForceLine<D> {
    fn at_rest() -> Self {
        Self {
            forces: [SVector::from([0.0; D]); LENGTH],
            newest: 0,
        }
    }

    fn push(&mut self, force: SVector<f64, D>) {
        self.newest = (self.newest + 1) % LENGTH;
        self.forces[self.newest] = force;
    }

    /// The force pushed `age` pushes before the newest, `age` ≤ [`MAX_DELAY_SAMPLES`].
    fn aged(&self, age: usize) -> &SVector<f64, D> {
        &self.forces[(self.newest + LENGTH - age) % LENGTH]
    }
}

/// The effect of friction in a step, chosen implicitly.
///
/// ```text
/// v(h) = w + Y·r,  |r| ≤ Fc:    r = -w/Y if that is within Fc, so that v(h) = 0;  else r = -Fc·sign(w)
/// ```
/// w is the velocity without friction at the end of the step h, m/s, Y > 0 the velocity gained per newton held over it,
/// m/(N·s). A force that follows sign(v) would chatter about zero for ever; this one ends there. It is held over the step,
/// so stopping and reversing are right to one step, and sliding one way is exact.
///
/// Source: J. J. Moreau, "Unilateral contact and dry friction in finite freedom dynamics", 1988.
#[derive(Debug, PartialEq)]
enum Friction {
    /// It can bring the velocity to zero at the end of the step, with this force, N.
    Stops(f64),
    /// It can not, and opposes the motion with this force, N.
    Slides(f64),
}

/// Chooses the friction force. `limit` ≥ 0 in N, `mobility` Y > 0 in m/(N·s).
fn coulomb(limit: f64, free_velocity: f64, mobility: f64) -> Friction {
    let stopping = -free_velocity / mobility;
    if stopping.abs() <= limit {
        Friction::Stops(stopping)
    } else {
        Friction::Slides(libm::copysign(limit, stopping))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_stops_what_it_can_and_opposes_the_rest() {
        // Y = 0.5 m/(N·s): 1 m/s needs 2 N.
        assert_eq!(coulomb(2.0, 1.0, 0.5), Friction::Stops(-2.0));
        assert_eq!(coulomb(1.9, 1.0, 0.5), Friction::Slides(-1.9));
        assert_eq!(coulomb(1.9, -1.0, 0.5), Friction::Slides(1.9));
    }
}
