//! The two versions of the device: motors, encoders, lengths.

use super::kinematics::Pantograph;

/// A version of the hardware.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Version {
    /// The one with a metal plate: both arms turn about one axis.
    V2,
    /// The one of plastic: the arms turn about axes 38 mm apart.
    #[default]
    V3,
}

/// Sense in which a motor or an encoder counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Direction {
    /// With the clock, 0 on the wire.
    Clockwise = 0,
    /// Against it, 1.
    CounterClockwise = 1,
}

/// A joint at the base: a motor and an encoder at one port of the board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    /// Port of the board, 1 to 4.
    pub port: u8,
    /// Of the motor.
    pub motor: Direction,
    /// Of the encoder.
    pub encoder: Direction,
    /// Angle of the arm when the handle is at home, degrees: the board takes it as the place where it is configured.
    pub home_deg: f32,
    /// Counts of the encoder in a turn.
    pub counts_per_turn: f32,
}

/// The device of a version. Source of all numbers: the maker's Python host, `HaplyHAPI` 1.0.1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// Its version.
    pub version: Version,
    /// The joints of both arms.
    pub joints: [Joint; 2],
    /// Lengths of the arms.
    pub pantograph: Pantograph,
}

impl Version {
    /// All versions.
    pub const ALL: [Self; 2] = [Self::V2, Self::V3];

    /// The version as it is printed on no device: 2 or 3.
    #[must_use]
    pub const fn number(self) -> u8 {
        match self {
            Self::V2 => 2,
            Self::V3 => 3,
        }
    }

    /// The other one.
    #[must_use]
    pub const fn other(self) -> Self {
        match self {
            Self::V2 => Self::V3,
            Self::V3 => Self::V2,
        }
    }

    /// The device of this version.
    #[must_use]
    pub const fn model(self) -> Model {
        use Direction::{Clockwise, CounterClockwise};
        match self {
            Self::V2 => Model {
                version: self,
                joints: [
                    joint(2, CounterClockwise, 241.0, 10_752.0),
                    joint(1, Clockwise, -61.0, 10_752.0),
                ],
                pantograph: Pantograph::of_arms(0.07, 0.09, 0.0),
            },
            Self::V3 => Model {
                version: self,
                joints: [
                    joint(2, CounterClockwise, 168.0, 4880.0),
                    joint(1, CounterClockwise, 12.0, 4880.0),
                ],
                pantograph: Pantograph::of_arms(0.07, 0.09, 0.038),
            },
        }
    }
}

const fn joint(port: u8, direction: Direction, home_deg: f32, counts_per_turn: f32) -> Joint {
    Joint {
        port,
        motor: direction,
        encoder: direction,
        home_deg,
        counts_per_turn,
    }
}

impl Joint {
    /// Counts of the encoder when the handle is at home: whole, cut off as the board does.
    #[must_use]
    pub(crate) fn home_counts(&self) -> f32 {
        counts_at(self.home_deg, self.counts_per_turn)
    }
}

/// Whole counts of an angle in degrees, in the arithmetic of the board.
#[must_use]
pub fn counts_at(degrees: f32, counts_per_turn: f32) -> f32 {
    libm::truncf(degrees * counts_per_turn / 360.0)
}

impl Model {
    /// Largest step of the hand for one count of an encoder, to first order, in the middle of the workspace, m: l·2π/n times 1.
    #[must_use]
    pub fn resolution_m(&self) -> f32 {
        let counts = self.joints[0].counts_per_turn;
        core::f32::consts::TAU * self.pantograph.near_m() as f32 / counts
    }

    /// Angles with the handle at home, rad: the whole counts that the board takes it for.
    #[must_use]
    pub fn home(&self) -> [f64; 2] {
        self.joints.map(|joint| {
            let counts = f64::from(joint.home_counts());
            counts / f64::from(joint.counts_per_turn) * core::f64::consts::TAU
        })
    }

    /// Indices of the joints in the order of their ports, which is that of every list on the wire.
    #[must_use]
    pub(crate) const fn by_port(&self) -> [usize; 2] {
        if self.joints[0].port < self.joints[1].port {
            [0, 1]
        } else {
            [1, 0]
        }
    }
}
