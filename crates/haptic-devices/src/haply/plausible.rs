//! Judging what a board without a checksum says: what cannot be true is a fault.

use super::kinematics::{Posture, Singular};
use super::model::{Model, Version};
use super::protocol::{ANSWER_BYTES, DEVICE_ID, angles_of};
use haptic_loop::Fault;
use haptic_remote::serial::TroubleCause;
use thiserror::Error;

/// Faster than a hand moves the handle, m/s.
pub const SPEED_MOST_M_PER_S: f64 = 3.0;
/// Counts of the encoder beside that: the steps of two readings.
const COUNTS_SPARE: f64 = 4.0;

/// Something that a 2DIY in order does not do.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Trouble {
    /// The port is gone, or takes no bytes.
    #[error("its port is gone: look at its plug and its supply")]
    Gone,
    /// No whole answer in time.
    #[error(
        "no whole answer for {ticks} ticks ({bytes} of 9 bytes came): a byte was lost, the board hangs, or the sample time is too short for this USB port"
    )]
    Silent {
        /// Ticks.
        ticks: u32,
        /// Bytes that did come.
        bytes: u8,
    },
    /// More bytes than were asked for.
    #[error(
        "{bytes} bytes came where {expected} were due: something was added on the line, or another program speaks to the board"
    )]
    TooMuch {
        /// Bytes that came.
        bytes: u8,
        /// Bytes that were due.
        expected: u8,
    },
    /// The answer of another device.
    #[error(
        "the answer is of device {device_id} instead of 5: a byte was lost or changed, or this is no 2DIY"
    )]
    OtherDevice {
        /// The number in it.
        device_id: u8,
    },
    /// An angle that is no number.
    #[error("an angle is not a finite number: a byte was changed")]
    NotFinite,
    /// The angles changed faster than a hand moves.
    #[error(
        "the handle went {step_mm:.1} mm in {time_ms:.1} ms, faster than a hand: a byte was changed, an encoder loses counts, or this is a 2DIY of version {other}"
    )]
    Jump {
        /// Distance, mm.
        step_mm: f64,
        /// Time for it, ms.
        time_ms: f64,
        /// The version that the device was not said to be.
        other: u8,
    },
    /// No posture of these arms has such angles.
    #[error(
        "angles of {first:.1}° and {second:.1}° are out of reach of a 2DIY of version {version}: give version={other} if it is one of those, and hold the handle at its home while the device is opened"
    )]
    OutOfReach {
        /// θ₁, degrees.
        first: f32,
        /// θ₂, degrees.
        second: f32,
        /// The version that the device was said to be.
        version: u8,
        /// The other one.
        other: u8,
    },
    /// The posture is singular, or next to it.
    #[error(
        "{singular}: keep the handle in the middle, or give version={other} if it is one of those"
    )]
    Singular {
        /// The posture.
        singular: Singular,
        /// The version that the device was not said to be.
        other: u8,
    },
}

impl Trouble {
    /// The fault that it is.
    #[must_use]
    pub const fn fault(self) -> Fault {
        match self {
            Self::Singular { .. } => Fault::Workspace,
            _ => Fault::BoardFailed,
        }
    }

    /// Where its cause lies.
    #[must_use]
    pub const fn cause(self) -> TroubleCause {
        match self {
            Self::Gone | Self::Silent { .. } => TroubleCause::Gone,
            _ => TroubleCause::Board,
        }
    }
}

/// Angles in rad and the posture of an answer.
///
/// `before` is the last posture that was believed, and the time since then, s.
///
/// # Errors
/// The first thing in it that cannot be true.
pub(super) fn judged(
    model: &Model,
    bytes: [u8; ANSWER_BYTES],
    before: Option<(&Posture, f64)>,
) -> Result<([f64; 2], Posture), Trouble> {
    let (device_id, angles_deg) = angles_of(model, bytes);
    if device_id != DEVICE_ID {
        return Err(Trouble::OtherDevice { device_id });
    }
    let angles = angles_deg.map(|angle| f64::from(angle).to_radians());
    let posture = model.pantograph.posture(angles);
    let posture = posture.map_err(|singular| match singular {
        Singular::NotFinite => Trouble::NotFinite,
        Singular::OutOfReach { .. } => out_of_reach(model.version, angles_deg),
        _ if !turned_little(model, angles_deg) => out_of_reach(model.version, angles_deg),
        singular => Trouble::Singular {
            singular,
            other: model.version.other().number(),
        },
    })?;
    if !turned_little(model, angles_deg) || !model.pantograph.is_assembled(angles, &posture) {
        return Err(out_of_reach(model.version, angles_deg));
    }
    if let Some((last, time_s)) = before {
        let step = posture.hand_m - last.hand_m;
        let step_m = libm::sqrt(step.dot(&step));
        let spare_m = COUNTS_SPARE * f64::from(model.resolution_m());
        if step_m > SPEED_MOST_M_PER_S * time_s + spare_m {
            return Err(Trouble::Jump {
                step_mm: 1e3 * step_m,
                time_ms: 1e3 * time_s,
                other: model.version.other().number(),
            });
        }
    }
    Ok((angles, posture))
}

/// True if each arm is within half a turn of its home: it cannot turn further.
fn turned_little(model: &Model, angles_deg: [f32; 2]) -> bool {
    let pairs = angles_deg.iter().zip(&model.joints);
    pairs.fold(true, |all, (angle, joint)| {
        all && (angle - joint.home_deg).abs() <= 200.0
    })
}

const fn out_of_reach(version: Version, [first, second]: [f32; 2]) -> Trouble {
    Trouble::OutOfReach {
        first,
        second,
        version: version.number(),
        other: version.other().number(),
    }
}
