//! The limits of a motion chain, in SI units.

use crate::units::{
    Joules, Metres, MetresPerSecond, MetresPerSecondCubed, MetresPerSecondSquared, Newtons, Seconds,
};

/// Every limit of a [`MotionChain`](super::MotionChain); `None` is off.
///
/// The abilities of a robot are not known here: [`of`](Self::of) takes them and adds defaults for the rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionLimits<const D: usize> {
    /// Largest speed of the command on each axis, above 0; a faster one is scaled down without changing its direction.
    pub speed: MetresPerSecond,
    /// Largest speed of the whole command, above 0. *Default* `speed`: a diagonal is no faster than an axis.
    pub speed_norm: Option<MetresPerSecond>,
    /// a, largest change of the command on each axis, |Δv|/T, above 0: of growth, of braking before the end of the workspace, and of
    /// the way to rest after a fault or stop.
    pub acceleration: MetresPerSecondSquared,
    /// Largest change of the whole command, above 0: no axis changes by more than its √D-th part, so that an axis can brake whatever
    /// the others do. *Default* off.
    pub acceleration_norm: Option<MetresPerSecondSquared>,
    /// Largest change of the acceleration on each axis, |Δ²v|/T², above 0. It gives way to every other limit: braking before an end,
    /// for the speed, after a fault or stop is not softened. *Default* off.
    pub jerk: Option<MetresPerSecondCubed>,
    /// Lowest position of the command on each axis.
    pub low: [Metres; D],
    /// Highest position of the command on each axis, above `low`: from where it is, the command can always stop inside.
    pub high: [Metres; D],
    /// R, largest force that the sensor shows either way on an axis, above 0: a reading of R or beyond is saturated, a fault.
    pub sensor_range: Newtons,
    /// Largest sensed force, of all axes together and without the offset, above 0: beyond it the hand is crushed, a fault.
    /// *Default* half of `sensor_range`.
    pub force: Newtons,
    /// Largest distance from the command to the measured position on an axis, above 0; beyond it is a fault. *Default* 20 mm: a loop
    /// that follows 50 ms late is 15 mm behind at 0.3 m/s.
    pub following: Metres,
    /// Largest age of a sensed force, at least 0, and largest time without a tick; beyond it is a fault. *Default* 20 ms.
    pub force_age: Seconds,
    /// The sign of a sensor that is stuck. *Default* 0.1 s and 5 mm.
    pub stuck: Option<StuckSensor>,
    /// Largest offset of the resting sensor, and largest spread of its readings there, on an axis, as a share of R from 0 to 1: beyond
    /// it the robot is not armed. *Default* 0.05.
    pub offset_share: f64,
    /// Time at rest before arming in which the offset is measured, 1 ms to 60 s. *Default* 0.2 s.
    pub rest_time: Seconds,
    /// Sensed force below which nothing moves, at least 0: it is taken off the magnitude of any larger one, without a jump. As large as
    /// the noise of the sensor at rest. *Default* 0.
    pub dead_band: Newtons,
    /// Largest energy that the loop may give to the hand beyond what the hand has given since, above 0; beyond it is a fault. Choose it
    /// above what virtual body and virtual world can store. *Default* 2 J: more than 1 kg at 1 m/s or 10 kN/m pushed in by 20 mm.
    pub hand_energy: Option<Joules>,
}

/// A force sensor that stands still although the robot moves.
///
/// A reading that has been the same on an axis, to the last bit, for `time`, while the command has moved on this axis by more than
/// `travel`, latches [`MotionFault::SensorStuck`](super::MotionFault::SensorStuck). A hand that holds still latches nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StuckSensor {
    /// Above 0.
    pub travel: Metres,
    /// 0.001 to 10 s.
    pub time: Seconds,
}

impl<const D: usize> MotionLimits<D> {
    /// Limits of speed, acceleration and workspace, and the range of the sensor; everything else at its default.
    #[must_use]
    pub const fn of(
        speed: MetresPerSecond,
        acceleration: MetresPerSecondSquared,
        low: [Metres; D],
        high: [Metres; D],
        sensor_range: Newtons,
    ) -> Self {
        Self {
            speed,
            speed_norm: Some(speed),
            acceleration,
            acceleration_norm: None,
            jerk: None,
            low,
            high,
            sensor_range,
            force: Newtons(0.5 * sensor_range.0),
            following: Metres(20e-3),
            force_age: Seconds(20e-3),
            stuck: Some(StuckSensor {
                travel: Metres(5e-3),
                time: Seconds(0.1),
            }),
            offset_share: 0.05,
            rest_time: Seconds(0.2),
            dead_band: Newtons(0.0),
            hand_energy: Some(Joules(2.0)),
        }
    }

    /// These limits with other ends, on as many axes as those have.
    #[must_use]
    pub const fn between<const E: usize>(
        self,
        low: [Metres; E],
        high: [Metres; E],
    ) -> MotionLimits<E> {
        MotionLimits {
            low,
            high,
            speed: self.speed,
            speed_norm: self.speed_norm,
            acceleration: self.acceleration,
            acceleration_norm: self.acceleration_norm,
            jerk: self.jerk,
            sensor_range: self.sensor_range,
            force: self.force,
            following: self.following,
            force_age: self.force_age,
            stuck: self.stuck,
            offset_share: self.offset_share,
            rest_time: self.rest_time,
            dead_band: self.dead_band,
            hand_energy: self.hand_energy,
        }
    }

    /// Longest time from a fault or stop to rest, s: ⌈speed/(a·T)⌉ samples, of the acceleration that an axis may have.
    #[must_use]
    pub fn stop_time(&self, sample_time: Seconds) -> Seconds {
        let step = self.axis_acceleration() * sample_time.0;
        Seconds(libm::ceil(self.speed.0 / step * (1.0 - 1e-6)) * sample_time.0)
    }

    /// Largest acceleration of an axis, m/s², `acceleration_norm` shared evenly.
    pub(super) fn axis_acceleration(&self) -> f64 {
        let shared = |norm: MetresPerSecondSquared| norm.0 / libm::sqrt(D as f64);
        let norm = self.acceleration_norm.map_or(f64::INFINITY, shared);
        f64::min(self.acceleration.0, norm)
    }
}
