//! The device: the motors, encoders and lengths of its two versions, its name, and the plane in which it moves.

use super::kinematics::{Pantograph, Singular};
use crate::name::{NameError, Settings};
use nalgebra::{Matrix2, Vector2};
use std::fmt;
use thiserror::Error;

haptic_loop::enumerated! {
    /// A version of the hardware.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum Version {
        /// The one with a metal plate: both arms turn about one axis.
        V2,
        /// The one of plastic: the arms turn about axes 38 mm apart.
        #[default]
        V3,
    }
}

/// Sense in which a motor or an encoder counts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum CountingSense {
    /// Sense of the clock, 0 on the wire.
    Clockwise = 0,
    /// Against it, 1.
    CounterClockwise = 1,
}

/// A joint at the base: a motor and an encoder at one port of the board.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BaseJoint {
    /// Port of the board, 1 to 4.
    pub port: u8,
    /// Sense in which the motor turns at a positive torque.
    pub motor: CountingSense,
    /// Sense in which the encoder counts up.
    pub encoder: CountingSense,
    /// Angle of the arm when the handle is at home, degrees: the board takes it as the place where it is configured.
    pub home_deg: f32,
    /// Counts of the encoder in a turn.
    pub counts_per_turn: f32,
}

/// The device of a version. Source of all numbers: the maker's Python host, `HaplyHAPI` 1.0.1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HaplyModel {
    /// Version whose numbers these are.
    pub version: Version,
    /// The joints of both arms.
    pub joints: [BaseJoint; 2],
    /// Lengths of the arms, from which positions and forces follow.
    pub pantograph: Pantograph,
}

impl Version {
    /// The version, 2 or 3, which is not printed on the device.
    #[must_use]
    pub const fn number(self) -> u8 {
        match self {
            Self::V2 => 2,
            Self::V3 => 3,
        }
    }

    /// The other version, suspected when a device's answers do not fit this one.
    #[must_use]
    pub const fn other(self) -> Self {
        match self {
            Self::V2 => Self::V3,
            Self::V3 => Self::V2,
        }
    }

    /// The device of this version.
    #[must_use]
    pub const fn model(self) -> HaplyModel {
        use CountingSense::{Clockwise, CounterClockwise};
        match self {
            Self::V2 => HaplyModel {
                version: self,
                joints: [
                    joint(2, CounterClockwise, 241.0, 10_752.0),
                    joint(1, Clockwise, -61.0, 10_752.0),
                ],
                pantograph: arms(0.0),
            },
            Self::V3 => HaplyModel {
                version: self,
                joints: [
                    joint(2, CounterClockwise, 168.0, 4880.0),
                    joint(1, CounterClockwise, 12.0, 4880.0),
                ],
                pantograph: arms(0.038),
            },
        }
    }
}

/// Both versions have arms of these lengths.
const fn arms(base_m: f64) -> Pantograph {
    Pantograph {
        near_m: 0.07,
        far_m: 0.09,
        base_m,
    }
}

const fn joint(
    port: u8,
    direction: CountingSense,
    home_deg: f32,
    counts_per_turn: f32,
) -> BaseJoint {
    BaseJoint {
        port,
        motor: direction,
        encoder: direction,
        home_deg,
        counts_per_turn,
    }
}

/// Whole counts of an angle in degrees, in the arithmetic of the board.
#[must_use]
pub fn counts_at(degrees: f32, counts_per_turn: f32) -> f32 {
    libm::truncf(degrees * counts_per_turn / 360.0)
}

impl HaplyModel {
    /// Largest step of the hand for one count of an encoder, to first order, in the middle of the workspace, m: l·2π/n times 1.
    #[must_use]
    pub fn resolution_m(&self) -> f32 {
        let counts = self.joints[0].counts_per_turn;
        core::f32::consts::TAU * self.pantograph.near_m as f32 / counts
    }

    /// Angles with the handle at home, rad, as the whole counts that the board assumes there.
    #[must_use]
    pub fn home(&self) -> [f64; 2] {
        self.joints.map(|joint| {
            // Whole, cut off as the board does.
            let counts = f64::from(counts_at(joint.home_deg, joint.counts_per_turn));
            counts / f64::from(joint.counts_per_turn) * core::f64::consts::TAU
        })
    }

    /// Indices of the joints in the order of their ports, which is that of every list on the wire.
    pub(crate) const fn by_port(&self) -> [usize; 2] {
        if self.joints[0].port < self.joints[1].port {
            [0, 1]
        } else {
            [1, 0]
        }
    }
}

/// A line of the plane along which the device moves and pushes, with its positive direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Axis {
    /// Along the base, to the right.
    X,
    /// Away from the base.
    #[default]
    Y,
    /// Along the base, to the left.
    MinusX,
    /// Towards the base.
    MinusY,
}

impl Axis {
    /// Every line with its name in `axis=`.
    pub const NAMES: [(&'static str, Self); 4] = [
        ("x", Self::X),
        ("y", Self::Y),
        ("-x", Self::MinusX),
        ("-y", Self::MinusY),
    ];

    /// Unit vector in the positive direction.
    #[must_use]
    pub fn along(self) -> Vector2<f64> {
        match self {
            Self::X => Vector2::new(1.0, 0.0),
            Self::Y => Vector2::new(0.0, 1.0),
            Self::MinusX => Vector2::new(-1.0, 0.0),
            Self::MinusY => Vector2::new(0.0, -1.0),
        }
    }

    /// The place at a distance on this axis from the middle of the base; its sign is that of the plane.
    pub(super) fn across_and_along(self, distance_m: f64) -> Vector2<f64> {
        match self {
            Self::X | Self::MinusX => Vector2::new(distance_m, 0.0),
            Self::Y | Self::MinusY => Vector2::new(0.0, distance_m),
        }
    }

    /// Place of zero on this axis unless another is given, m from the middle of the base: the middle of the workspace.
    pub(super) const fn zero_m(self) -> f64 {
        match self {
            Self::X | Self::MinusX => 0.0,
            Self::Y | Self::MinusY => 0.09,
        }
    }

    fn name(self) -> &'static str {
        let found = Self::NAMES.iter().find(|(_, axis)| *axis == self);
        found.map_or("", |(name, _)| name)
    }
}

/// Position that counts as home for the encoders.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Home {
    /// The handle is at its home while the device is opened.
    #[default]
    Now,
    /// It was at home when an earlier command opened the device, and the board has been on since.
    Before,
}

/// A 2DIY by name: `haply:PATH[,version=2|3][,axis=x|y|-x|-y][,zero=LENGTH][,home=now|before]`.
#[derive(Clone, Debug, PartialEq)]
pub struct HaplyName {
    /// Path of the port, as the system names it.
    pub path: String,
    /// Version of the hardware; 3 unless given.
    pub version: Version,
    /// Line of the plane; y unless given.
    pub axis: Axis,
    /// Position of zero on that line, m from the middle of the base: 90 mm for y, 0 for x unless
    /// given.
    pub zero_m: f64,
    /// The moment at which the handle was at its home.
    pub home: Home,
}

impl HaplyName {
    /// First word of a name, before the colon.
    pub const KIND: &'static str = "haply";
    /// The form of its names, for help texts.
    pub const FORM: &'static str =
        "haply:PATH[,version=2|3][,axis=x|y|-x|-y][,zero=LENGTH][,home=now|before]";
    /// A device at this path, with default settings.
    #[must_use]
    pub fn at(path: &str) -> Self {
        Self {
            path: path.to_owned(),
            version: Version::default(),
            axis: Axis::default(),
            zero_m: Axis::default().zero_m(),
            home: Home::default(),
        }
    }

    /// Reads what stands behind `haply:`.
    ///
    /// # Errors
    /// No path; a key or value that is not known.
    pub fn parse(text: &str) -> Result<Self, NameError> {
        let settings = Settings::parse(Self::KIND, text, &["version", "axis", "zero", "home"])?;
        let axis = settings.choice("axis", &Axis::NAMES, Axis::default())?;
        let versions = [("2", Version::V2), ("3", Version::V3)];
        let homes = [("now", Home::Now), ("before", Home::Before)];
        Ok(Self {
            path: settings.path.to_owned(),
            version: settings.choice("version", &versions, Version::default())?,
            axis,
            zero_m: settings.metres("zero", -0.2..=0.2, axis.zero_m())?,
            home: settings.choice("home", &homes, Home::default())?,
        })
    }
}

impl HaplyName {
    /// True if it chooses a line of the plane, which an experiment with both axes has no use for.
    pub(crate) fn chooses_line(&self) -> bool {
        let default = Axis::default();
        self.axis != default || (self.zero_m - default.zero_m()).abs() > 0.0
    }
}

impl fmt::Display for HaplyName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", Self::KIND, self.path)?;
        if self.version != Version::default() {
            write!(f, ",version={}", self.version.number())?;
        }
        if self.axis != Axis::default() {
            write!(f, ",axis={}", self.axis.name())?;
        }
        if (self.zero_m - self.axis.zero_m()).abs() > 0.0 {
            write!(f, ",zero={}mm", 1e3 * self.zero_m)?;
        }
        if self.home == Home::Before {
            f.write_str(",home=before")?;
        }
        Ok(())
    }
}

/// Largest distance between the checked places of a box, m.
const GRID_M: f64 = 1e-3;
/// A longer side of a box than any arm reaches, m.
const SIDE_MOST_M: f64 = 0.5;

/// The plane of a device, with positions measured from the middle of the workspace: x along the
/// base to the right, y away from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HaplyPlane {
    model: HaplyModel,
}

/// A box that the handle cannot fill.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Unreachable {
    /// A place in it that the arms do not reach, or next to which they are in a line.
    #[error("at ({x_mm:.0}, {y_mm:.0}) mm, from the middle of the workspace, {singular}")]
    Place {
        /// x of the place from the middle of the workspace, mm.
        x_mm: f64,
        /// y of the place from the middle of the workspace, mm.
        y_mm: f64,
        /// Names what is wrong with the posture there.
        singular: Singular,
    },
    /// A place behind the base, or one that the arms reach only turned over.
    #[error(
        "at ({x_mm:.0}, {y_mm:.0}) mm, from the middle of the workspace, the arms would be turned over"
    )]
    TurnedOver {
        /// x of the place from the middle of the workspace, mm.
        x_mm: f64,
        /// y of the place from the middle of the workspace, mm.
        y_mm: f64,
    },
    /// An invalid side.
    #[error("a side of {side_m} m is not in (0, 0.5] m")]
    Side {
        /// Length that was given for the side, m.
        side_m: f64,
    },
}

/// The middle between the arms at the base, m.
pub(super) fn middle(model: &HaplyModel) -> Vector2<f64> {
    Vector2::new(0.5 * model.pantograph.base_m, 0.0)
}

impl HaplyPlane {
    /// Lowest and highest position between which both motors reach the largest force, m.
    pub const HANDY_M: ([f64; 2], [f64; 2]) = ([-0.05, -0.05], [0.05, 0.04]);

    /// The plane in which a device of this model moves.
    #[must_use]
    pub const fn of(model: HaplyModel) -> Self {
        Self { model }
    }

    /// The position of zero in the maker's coordinates, m.
    #[must_use]
    pub fn centre(&self) -> Vector2<f64> {
        middle(&self.model) + Axis::Y.across_and_along(Axis::Y.zero_m())
    }

    /// The derivatives ∂(x, y)/∂(θ₁, θ₂) of the posture at a place, m/rad.
    fn jacobian(&self, place_m: Vector2<f64>) -> Result<Matrix2<f64>, Unreachable> {
        let pantograph = &self.model.pantograph;
        let (x_mm, y_mm) = (1e3 * place_m.x, 1e3 * place_m.y);
        let hand_m = self.centre() + place_m;
        let angles = pantograph.angles(hand_m);
        let posture = angles.and_then(|angles| Ok((angles, pantograph.posture(angles)?)));
        let (angles, posture) = posture.map_err(|singular| Unreachable::Place {
            x_mm,
            y_mm,
            singular,
        })?;
        // The angles of a place behind the base have their hand in front of it.
        let same = (posture.hand_m - hand_m).norm() < GRID_M;
        if same && pantograph.is_assembled(angles, &posture) {
            Ok(posture.jacobian)
        } else {
            Err(Unreachable::TurnedOver { x_mm, y_mm })
        }
    }

    /// The least and the largest mass of the handle, kg, in any direction anywhere in a box, if its
    /// mean over directions in the middle of the workspace is 1 kg.
    ///
    /// ```text
    /// M = I·(J·Jᵀ)⁻¹,   mass along n  1/(nᵀ·M⁻¹·n) = I/|Jᵀ·n|²  in [I/σ₁², I/σ₂²],  σ the singular values of J
    /// ```
    /// Both arms are assumed to have the same inertia I about their base joints. Positions are
    /// checked on a grid of 1 mm.
    ///
    /// # Errors
    /// A box with a place that the arms do not reach, or where they are next to a singular posture.
    pub fn masses(&self, low_m: [f64; 2], high_m: [f64; 2]) -> Result<[f64; 2], Unreachable> {
        let [across, away] = [high_m[0] - low_m[0], high_m[1] - low_m[1]];
        for side_m in [across, away] {
            if !(side_m > 0.0 && side_m <= SIDE_MOST_M) {
                return Err(Unreachable::Side { side_m });
            }
        }
        let inertia = self.jacobian(Vector2::zeros())?.determinant().abs();
        let steps = |side_m: f64| (side_m / GRID_M).ceil() as u32;
        let (columns, rows) = (steps(across), steps(away));
        let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
        for row in 0..=rows {
            for column in 0..=columns {
                let share = |n: u32, whole: u32| f64::from(n) / f64::from(whole);
                let place = Vector2::new(
                    low_m[0] + across * share(column, columns),
                    low_m[1] + away * share(row, rows),
                );
                let values = self.jacobian(place)?.singular_values();
                least = least.min(inertia / libm::pow(values.max(), 2.0));
                most = most.max(inertia / libm::pow(values.min(), 2.0));
            }
        }
        Ok([least, most])
    }
}
