//! The name of a 2DIY: port, version, line and home.

use super::model::Version;
use crate::name::{NameError, Settings};
use nalgebra::Vector2;
use std::fmt;

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
    /// All, by name.
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

/// Where the encoders count from.
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
    /// Path of the port.
    pub path: String,
    /// Version of the hardware; 3 unless given.
    pub version: Version,
    /// Line of the plane; y unless given.
    pub axis: Axis,
    /// Place of zero on that line, m from the middle of the base: 90 mm for y, 0 for x unless given.
    pub zero_m: f64,
    /// Where the encoders count from.
    pub home: Home,
}

impl HaplyName {
    /// The kind of device.
    pub const KIND: &'static str = "haply";
    /// Form of its names.
    pub const FORM: &'static str =
        "haply:PATH[,version=2|3][,axis=x|y|-x|-y][,zero=LENGTH][,home=now|before]";
    /// With the settings that are not given.
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
            path: settings.path().to_owned(),
            version: settings.choice("version", &versions, Version::default())?,
            axis,
            zero_m: settings.metres("zero", -0.2..=0.2, axis.zero_m())?,
            home: settings.choice("home", &homes, Home::default())?,
        })
    }
}

impl HaplyName {
    /// True if it chooses a line of the plane, which an experiment with both axes has no use for.
    #[must_use]
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
