//! The state of a motion chain, and why it stands still.

use crate::safety::Fault;
use crate::safety::clamps::norm;
use fracdiff::Real;
use fracdiff::parameter::Shown;
use nalgebra::SVector;
use thiserror::Error;

fracdiff::enumerated! {
    /// Why the motion chain holds the command at rest.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
    #[non_exhaustive]
    #[repr(u8)]
    pub enum MotionFault {
        /// The sensed force, its age, the measured position or the wanted velocity was NaN or infinite.
        #[error("a sensed force, position or wanted velocity was not a finite number")]
        NotFinite = 1,
        /// The sensed force is older than [`MotionLimits::force_age`](super::MotionLimits::force_age), or no tick came for so long.
        #[error("the sensed force is too old: the sensor or the loop was silent")]
        StaleForce = 2,
        /// A sensed force reached the end of the sensor's range.
        #[error("the force sensor is saturated")]
        SensorSaturated = 3,
        /// The sensed force is above [`MotionLimits::force`](super::MotionLimits::force).
        #[error("the sensed force is above its limit: a hand may be caught")]
        Force = 4,
        /// The sensed force stands still while the command moves: see [`StuckSensor`](super::StuckSensor).
        #[error("the force sensor shows the same to the last bit while the robot moves")]
        SensorStuck = 5,
        /// The command is farther from the measured position than [`MotionLimits::following`](super::MotionLimits::following).
        #[error("the robot does not follow its command")]
        Following = 6,
        /// The loop has given the hand more than [`MotionLimits::hand_energy`](super::MotionLimits::hand_energy).
        #[error("the robot gives energy to the hand: the loop is not stable in it")]
        HandEnergy = 7,
        /// The robot gave an error, or reports a fault of its own.
        #[error("the robot failed to sense or to move")]
        RobotFailed = 8,
    }
}

impl MotionFault {
    /// The code in logs, from 1.
    #[must_use]
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// The fault of a loop, as it goes over the wire.
    #[must_use]
    pub const fn of_loop(self) -> Fault {
        match self {
            Self::NotFinite | Self::StaleForce | Self::SensorSaturated | Self::SensorStuck => {
                Fault::ForceSensor
            }
            Self::Force => Fault::HandForce,
            Self::Following => Fault::Following,
            Self::HandEnergy => Fault::HandEnergy,
            Self::RobotFailed => Fault::BoardFailed,
        }
    }
}

/// The resting sensor before a robot was armed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AtRest<F, const D: usize> {
    /// Mean of its readings, N, which is taken off from now on.
    pub offset_n: SVector<F, D>,
    /// Largest reading less the smallest, N: twice the [dead band](super::MotionLimits::dead_band) that would hide its noise.
    pub spread_n: SVector<F, D>,
}

/// A robot that must not be armed now.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum MotionStartRefused {
    /// The command is not at rest.
    #[error("the command still moves: stop, and tick until it is at rest")]
    Moves,
    /// The sensor was not watched for long enough.
    #[error("the sensor was watched at rest for {have} ticks of {need}: keep resting")]
    TooShort {
        /// Readings taken without a break.
        have: u32,
        /// Readings needed.
        need: u32,
    },
    /// The sensor shows a force though nobody should touch the handle.
    #[error(
        "the sensor shows {value} N at rest, at most {most} N are allowed: let go of the handle, or set the sensor to zero",
        value = Shown(*offset_n), most = Shown(*most_n)
    )]
    Offset {
        /// Largest offset of an axis, N.
        offset_n: f64,
        /// Largest that is allowed, N.
        most_n: f64,
    },
    /// The readings at rest differ.
    #[error(
        "the readings of the sensor at rest differ by {value} N, at most {most} N are allowed: let go of the handle",
        value = Shown(*spread_n), most = Shown(*most_n)
    )]
    Unsteady {
        /// Largest spread of an axis, N.
        spread_n: f64,
        /// Largest that is allowed, N.
        most_n: f64,
    },
    /// The robot stands outside its workspace.
    #[error("the robot stands at {value} m on axis {axis}, outside its workspace: move it inside", value = Shown(*position_m))]
    Outside {
        /// The axis, from 0.
        axis: usize,
        /// Its position there, m.
        position_m: f64,
    },
    /// The last reading would be a fault at once.
    #[error("a start would be a fault: {0}")]
    Fault(MotionFault),
}

impl MotionStartRefused {
    /// The fault of a loop that keeps it from a start, as it goes over the wire; `None` while the command still moves.
    #[must_use]
    pub const fn of_loop(&self) -> Option<Fault> {
        match self {
            Self::Moves => None,
            Self::TooShort { .. } | Self::Offset { .. } | Self::Unsteady { .. } => {
                Some(Fault::ForceSensor)
            }
            Self::Outside { .. } => Some(Fault::Workspace),
            Self::Fault(fault) => Some(fault.of_loop()),
        }
    }
}

/// The chain's state: command, latched fault, what the sensor has shown.
///
/// *Start-up*: not armed, at rest at 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionState<F, const D: usize> {
    /// The law moves the robot: one flag, because a tick asks three times.
    pub(super) driven: bool,
    pub(super) fault: Option<MotionFault>,
    /// v of the last tick, m/s.
    pub(super) velocity: SVector<F, D>,
    /// Its change in the last tick, m/s.
    pub(super) change: SVector<F, D>,
    /// x of the command, m, and what rounding has taken from it.
    pub(super) position: SVector<F, D>,
    pub(super) lost: SVector<F, D>,
    /// Sensed force of this tick without the offset, N.
    pub(super) force: SVector<F, D>,
    /// Sensed force as it was shown, N.
    pub(super) shown: SVector<F, D>,
    pub(super) offset: SVector<F, D>,
    /// Samples since each reading changed, and the way of the command since then, m.
    pub(super) still: [F; D],
    pub(super) travel: [F; D],
    /// Energy given to the hand since it had last paid for everything, J.
    pub(super) energy: F,
    /// Number of the tick that comes next, if none is missing; the largest before the first.
    pub(super) next: u64,
    /// The readings at rest now, and the whole rest before.
    pub(super) rest: Rest<F, D>,
    pub(super) rested: Rest<F, D>,
}

/// Readings of the resting sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Rest<F, const D: usize> {
    pub(super) count: u32,
    pub(super) first: SVector<F, D>,
    /// Sum of what they differ from the first.
    pub(super) sum: SVector<F, D>,
    pub(super) least: SVector<F, D>,
    pub(super) most: SVector<F, D>,
}

impl<F: Real, const D: usize> Rest<F, D> {
    /// All readings of two rests, this the first.
    pub(super) fn and(self, next: &Self) -> Self {
        if self.count == 0 || next.count == 0 {
            return if self.count == 0 { *next } else { self };
        }
        let count = F::from_f64(f64::from(next.count));
        let each = |f: fn(F, F) -> bool, a: &SVector<F, D>, b: &SVector<F, D>| {
            SVector::from(core::array::from_fn(|axis| {
                if f(a[axis], b[axis]) {
                    a[axis]
                } else {
                    b[axis]
                }
            }))
        };
        Self {
            count: self.count + next.count,
            first: self.first,
            sum: SVector::from(core::array::from_fn(|axis| {
                self.sum[axis] + next.sum[axis] + count * (next.first[axis] - self.first[axis])
            })),
            least: each(|a, b| a < b, &self.least, &next.least),
            most: each(|a, b| a > b, &self.most, &next.most),
        }
    }
}

impl<F: Real, const D: usize> Default for Rest<F, D> {
    fn default() -> Self {
        let none = SVector::from([F::ZERO; D]);
        Self {
            count: 0,
            first: none,
            sum: none,
            least: none,
            most: none,
        }
    }
}

impl<F: Real, const D: usize> Default for MotionState<F, D> {
    fn default() -> Self {
        let none = SVector::from([F::ZERO; D]);
        Self {
            driven: false,
            fault: None,
            velocity: none,
            change: none,
            position: none,
            lost: none,
            force: none,
            shown: none,
            offset: none,
            still: [F::ZERO; D],
            travel: [F::ZERO; D],
            energy: F::ZERO,
            next: u64::MAX,
            rest: Rest::default(),
            rested: Rest::default(),
        }
    }
}

impl<F: Real, const D: usize> MotionState<F, D> {
    /// The fault that is latched until the robot is armed again.
    #[must_use]
    pub const fn fault(&self) -> Option<MotionFault> {
        self.fault
    }

    /// Latches a fault that something else has found. The first fault stays.
    pub fn trip(&mut self, fault: MotionFault) {
        self.fault.get_or_insert(fault);
        self.stop();
    }

    /// Brings the command to rest from the next tick on, until the robot is armed again.
    pub const fn stop(&mut self) {
        self.driven = false;
    }

    /// True from arming to a fault or stop: the law moves the robot.
    #[must_use]
    pub const fn is_driven(&self) -> bool {
        self.driven
    }

    /// True if the command is at rest on every axis.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.velocity.iter().all(|&axis| axis == F::ZERO)
    }

    /// Reports that the robot comes to rest by its own means: the command is zero now, until it is armed again.
    pub fn let_go(&mut self) {
        self.stop();
        self.velocity = SVector::from([F::ZERO; D]);
    }

    /// Velocity of the command, m/s.
    #[must_use]
    pub const fn velocity_m_per_s(&self) -> &SVector<F, D> {
        &self.velocity
    }

    /// Position of the command, m: where the robot stood when it was armed, and all that was commanded since.
    #[must_use]
    pub const fn position_m(&self) -> &SVector<F, D> {
        &self.position
    }

    /// Magnitude of the sensed force without the offset, N, before the dead band.
    #[must_use]
    pub fn sensed_n(&self) -> F {
        norm(&self.force)
    }

    /// Energy that the loop has given to the hand since the hand had last paid for everything, J: see
    /// [`MotionLimits::hand_energy`](super::MotionLimits::hand_energy).
    #[must_use]
    pub const fn hand_energy_j(&self) -> F {
        self.energy
    }
}
