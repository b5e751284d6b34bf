//! What an indentation rig is made of: contact, drive, servo, masses.

use super::profile::RampHold;
use crate::units::{Kilograms, NewtonSecondsPerMetre, Newtons, NewtonsPerMetre, Seconds};

/// The contact of the indenter with the renderer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RigContact {
    /// An ideal indenter without mass: what drives it is imposed on the renderer exactly, for ever
    /// in contact. Position: x₁ = profile. Force: F = push.
    Rigid,
    /// A one-sided contact: F = max(0, k·p + c·p') while the penetration p = x₂ - x₁ > 0.
    Compliant {
        /// k > 0.
        stiffness: NewtonsPerMetre,
        /// c ≥ 0.
        damping: NewtonSecondsPerMetre,
    },
}

impl RigContact {
    /// k = 1e5 N/m, c = 80 N·s/m.
    ///
    /// The two masses of [`RigConfig::new`] bounce on the contact with their reduced mass
    /// 0.065/2 kg: ω = √(k/0.0325) = 1754 rad/s (279 Hz), ζ = c/(2·√(k·0.0325)) = 0.70.
    /// A force F compresses it by F/k: 1.8 µm under the 0.18 N of a prostate 1 mm deep.
    pub const COMPLIANT: Self = Self::Compliant {
        stiffness: NewtonsPerMetre(1e5),
        damping: NewtonSecondsPerMetre(80.0),
    };
}

/// The drive of the indenter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RigDrive {
    /// A position profile, followed by the servo (relaxation experiment).
    Position(RampHold),
    /// A constant push from t = 0, without servo (creep experiment). Positive into the tissue.
    Force(Newtons),
}

/// The indenter's position servo, continuous in time.
///
/// ```text
/// S = K·(e + ∫e dt/Tᵢ) + D·e',    e = r - x₂
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigServo {
    /// K > 0.
    pub stiffness: NewtonsPerMetre,
    /// D ≥ 0.
    pub damping: NewtonSecondsPerMetre,
    /// Tᵢ > 0. Stable for Tᵢ above mass/damping: (m₁ + m₂)/(D + b₁ + b₂) in contact.
    pub integral_time: Seconds,
}

impl RigServo {
    /// A triple pole at ω = 200 rad/s for the masses and damping of [`RigConfig::new`] moving
    /// together, M = 0.13 kg and b = 7 N·s/m.
    ///
    /// M·s³ + (b + D)·s² + K·s + K/Tᵢ = M·(s + ω)³ gives K = 3·M·ω² = 15 600 N/m,
    /// D = 3·M·ω - b = 71 N·s/m, Tᵢ = 3/ω = 15 ms. [`RigContact::COMPLIANT`] moves the poles to
    /// -273, -177 ± 23i and -1517 ± 722i rad/s; apart, the indenter's are -899, -124 ± 50i.
    /// So 0.1 s after a corner of the profile, less than 1e-6 of its error is left.
    pub const DEFAULT: Self = Self {
        stiffness: NewtonsPerMetre(15_600.0),
        damping: NewtonSecondsPerMetre(71.0),
        integral_time: Seconds(0.015),
    };
}

/// Parameters of an [`IndentationRig`](super::IndentationRig).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigConfig {
    /// The drive of the indenter.
    pub drive: RigDrive,
    /// Its contact with the renderer.
    pub contact: RigContact,
    /// T > 0, the time from one write to the next.
    pub sample_time: Seconds,
    /// m₁ > 0.
    pub renderer_mass: Kilograms,
    /// b₁ ≥ 0.
    pub renderer_damping: NewtonSecondsPerMetre,
    /// Largest magnitude of the renderer's force, > 0.
    pub saturation: Option<Newtons>,
    /// m₂ > 0.
    pub indenter_mass: Kilograms,
    /// b₂ ≥ 0.
    pub indenter_damping: NewtonSecondsPerMetre,
    /// Used by [`RigDrive::Position`] with a compliant contact.
    pub servo: RigServo,
}

impl RigConfig {
    /// Two of the dissertation's voice coils, 65 g and 3.5 N·s/m each, without saturation, and
    /// [`RigServo::DEFAULT`].
    #[must_use]
    pub const fn new(drive: RigDrive, contact: RigContact, sample_time: Seconds) -> Self {
        Self {
            drive,
            contact,
            sample_time,
            renderer_mass: Kilograms(0.065),
            renderer_damping: NewtonSecondsPerMetre(3.5),
            saturation: None,
            indenter_mass: Kilograms(0.065),
            indenter_damping: NewtonSecondsPerMetre(3.5),
            servo: RigServo::DEFAULT,
        }
    }
}
