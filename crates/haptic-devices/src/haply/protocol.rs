//! The frames of the board, byte by byte, and what of them can be true. No checksum, no length: both ends count.
//!
//! ```text
//! host → board   0 id                                        reset: the board forgets its configuration
//!                1 id motors d d encoders d d 0 0 f32×4      ports as bits, a direction each; no sensors, no PWM;
//!                                                            home in degrees and counts per turn of each encoder
//!                2 id f32 f32                                torques, N·m; all lists in the order of the ports
//! board → host   id f32 f32                                  answer to 2 only: angles, degrees
//! ```
//! Numbers are little endian. Read from the maker's Python host (`HaplyHAPI` 1.0.1) and from the headers of its board firmware
//! 1.5: there a torque above [`TORQUE_MAX_NM`] is cut, type 0 stops no motor, an unknown type is skipped, a frame that is cut off
//! waits for its rest, and a configuration takes the present place as home.

use super::{
    kinematics::{Posture, Singular},
    model::{HaplyModel, Version},
};
use haptic_loop::Fault;
use haptic_remote::serial::TroubleCause;
use thiserror::Error;

/// Number of the device on its board, that of the maker's examples.
const DEVICE_ID: u8 = 5;
/// Largest torque that the board lets a motor make, N·m.
pub const TORQUE_MAX_NM: f64 = 0.123;
/// Bytes of a frame of torques.
pub const TORQUES_BYTES: usize = 10;
/// Bytes of the frame that configures the board.
pub const CONFIGURATION_BYTES: usize = 26;
/// Bytes of the board's answer; the board sends no other frame.
pub const ANSWER_BYTES: usize = 9;
/// More zeros than any frame can still miss: the longest configuration has 3 + 4 + 1 + 4 + 1 + 255 + 1 + 255 + 4·8 =
/// 556 bytes.
const ZEROS: usize = 600;
/// A type that no board knows.
const SKIPPED: u8 = 0xFF;

/// The frame that resets the board.
#[must_use]
pub const fn reset() -> [u8; 2] {
    [0, DEVICE_ID]
}

/// Bytes after which the board begins a new frame for certain: zeros that fill up whatever was begun and reset the
/// board, then a type that it skips.
pub(crate) const fn resynchronise() -> [u8; ZEROS + 1] {
    let mut bytes = [0; ZEROS + 1];
    bytes[ZEROS] = SKIPPED;
    bytes
}

/// The frame that configures the board for this device.
#[must_use]
pub fn configuration(model: &HaplyModel) -> [u8; CONFIGURATION_BYTES] {
    let mut bytes = [0; CONFIGURATION_BYTES];
    let by_port = model.by_port().map(|joint| model.joints[joint]);
    let ports = (by_port.iter()).fold(0, |bits, joint| bits | 1 << (joint.port - 1));
    let [first, second] = by_port;
    bytes[..10].copy_from_slice(&[
        1,
        DEVICE_ID,
        ports,
        first.motor as u8,
        second.motor as u8,
        ports,
        first.encoder as u8,
        second.encoder as u8,
        0,
        0,
    ]);
    let numbers = by_port.map(|joint| [joint.home_deg, joint.counts_per_turn]);
    for (slot, number) in bytes[10..].chunks_exact_mut(4).zip(numbers.as_flattened()) {
        slot.copy_from_slice(&number.to_le_bytes());
    }
    bytes
}

/// The frame that sets the torques of both joints, N·m. The lowest byte of each number is zero, so
/// after a lost byte the board reads almost no torque, not an arbitrary one. This costs at most
/// 3·10⁻⁵ of the torque.
#[must_use]
pub fn torques(model: &HaplyModel, torques_nm: [f32; 2]) -> [u8; TORQUES_BYTES] {
    let mut bytes = [0; TORQUES_BYTES];
    bytes[..2].copy_from_slice(&[2, DEVICE_ID]);
    for (slot, joint) in bytes[2..].chunks_exact_mut(4).zip(model.by_port()) {
        slot.copy_from_slice(&torques_nm[joint].to_le_bytes());
        slot[0] = 0;
    }
    bytes
}

/// The answer of the board with this number and these angles of the joints, degrees.
#[must_use]
pub fn answer(model: &HaplyModel, device_id: u8, angles_deg: [f32; 2]) -> [u8; ANSWER_BYTES] {
    let mut bytes = [0; ANSWER_BYTES];
    bytes[0] = device_id;
    for (slot, joint) in bytes[1..].chunks_exact_mut(4).zip(model.by_port()) {
        slot.copy_from_slice(&angles_deg[joint].to_le_bytes());
    }
    bytes
}

/// The device number and the joint angles, degrees, in an answer.
#[must_use]
pub fn angles_of(model: &HaplyModel, bytes: [u8; ANSWER_BYTES]) -> (u8, [f32; 2]) {
    let [device_id, a0, a1, a2, a3, b0, b1, b2, b3] = bytes;
    let by_port = [[a0, a1, a2, a3], [b0, b1, b2, b3]].map(f32::from_le_bytes);
    let mut angles_deg = [0.0; 2];
    for (angle, joint) in by_port.into_iter().zip(model.by_port()) {
        angles_deg[joint] = angle;
    }
    (device_id, angles_deg)
}

/// Faster than a hand moves the handle, m/s.
pub const SPEED_MOST_M_PER_S: f64 = 3.0;
/// Counts of the encoder beside that: the steps of two readings.
const COUNTS_SPARE: f64 = 4.0;

/// Something that a working 2DIY does not do.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum HaplyTrouble {
    /// The port is gone, or takes no bytes.
    #[error("its port is gone: check its plug and power supply")]
    Gone,
    /// No whole answer in time.
    #[error(
        "no complete answer for {ticks} ticks ({bytes} of 9 bytes came): a byte was lost, the board hangs, or the sample time is too short for this USB port"
    )]
    Silent {
        /// Ticks in a row without a whole answer.
        ticks: u32,
        /// Bytes of the answer that did come.
        bytes: u8,
    },
    /// More bytes than were asked for.
    #[error(
        "{bytes} bytes arrived instead of {expected}: the line added some, or another program is talking to the board"
    )]
    TooMuch {
        /// Bytes that came in the tick.
        bytes: u8,
        /// Bytes of all answers that were due.
        expected: u8,
    },
    /// The answer of another device.
    #[error(
        "the answer comes from device {device_id} instead of 5: a byte was lost or changed, or this is not a 2DIY"
    )]
    OtherDevice {
        /// Number that the answer carries in place of the device's.
        device_id: u8,
    },
    /// An angle that is no number.
    #[error("an angle is not a finite number: a byte was changed")]
    NotFinite,
    /// The angles changed faster than a hand moves.
    #[error(
        "the handle moved {step_mm:.1} mm in {time_ms:.1} ms, faster than a hand: a byte was changed, an encoder loses counts, or this is a 2DIY of version {other}"
    )]
    Jump {
        /// Distance from the last place that was believed, mm.
        step_mm: f64,
        /// Time that the handle had for it, ms.
        time_ms: f64,
        /// The version that the device was not said to be.
        other: u8,
    },
    /// No posture of these arms has such angles.
    #[error(
        "angles of {first:.1}° and {second:.1}° are out of reach of a 2DIY of version {version}: give version={other} if yours is that version, and hold the handle at its home while the device is opened"
    )]
    OutOfReach {
        /// θ₁ of the answer, degrees.
        first: f32,
        /// θ₂ of the answer, degrees.
        second: f32,
        /// The version that the device was said to be.
        version: u8,
        /// The version that would fit instead.
        other: u8,
    },
    /// The posture is singular, or next to it.
    #[error(
        "{singular}: keep the handle in the middle, or give version={other} if yours is that version"
    )]
    Singular {
        /// Names what is wrong with the posture.
        singular: Singular,
        /// The version that the device was not said to be.
        other: u8,
    },
}

impl HaplyTrouble {
    /// The fault that it is.
    #[must_use]
    pub const fn fault(self) -> Fault {
        if matches!(self, Self::Singular { .. }) {
            Fault::Workspace
        } else {
            Fault::BoardFailed
        }
    }

    /// Says whether the user should check the board or its line.
    #[must_use]
    pub const fn cause(self) -> TroubleCause {
        if matches!(self, Self::Gone | Self::Silent { .. }) {
            TroubleCause::Gone
        } else {
            TroubleCause::Board
        }
    }
}

/// Angles in rad and the posture of an answer; `before` is the last posture that was believed, and the time since
/// then, s.
pub(super) fn judged(
    model: &HaplyModel,
    bytes: [u8; ANSWER_BYTES],
    before: Option<(&Posture, f64)>,
) -> Result<([f64; 2], Posture), HaplyTrouble> {
    let (device_id, angles_deg) = angles_of(model, bytes);
    if device_id != DEVICE_ID {
        return Err(HaplyTrouble::OtherDevice { device_id });
    }
    let angles = angles_deg.map(|angle| f64::from(angle).to_radians());
    let posture = model.pantograph.posture(angles);
    let far = !turned_little(model, angles_deg);
    let posture = posture.map_err(|singular| match singular {
        Singular::NotFinite => HaplyTrouble::NotFinite,
        Singular::Stretched { .. } | Singular::Straight { .. } if !far => HaplyTrouble::Singular {
            singular,
            other: model.version.other().number(),
        },
        Singular::OutOfReach { .. } | Singular::Stretched { .. } | Singular::Straight { .. } => {
            out_of_reach(model.version, angles_deg)
        }
    })?;
    if far || !model.pantograph.is_assembled(angles, &posture) {
        return Err(out_of_reach(model.version, angles_deg));
    }
    if let Some((last, time_s)) = before {
        let step = posture.hand_m - last.hand_m;
        let step_m = libm::sqrt(step.dot(&step));
        let spare_m = COUNTS_SPARE * f64::from(model.resolution_m());
        if step_m > SPEED_MOST_M_PER_S * time_s + spare_m {
            return Err(HaplyTrouble::Jump {
                step_mm: 1e3 * step_m,
                time_ms: 1e3 * time_s,
                other: model.version.other().number(),
            });
        }
    }
    Ok((angles, posture))
}

/// True if each arm is within half a turn of its home: it cannot turn further.
fn turned_little(model: &HaplyModel, angles_deg: [f32; 2]) -> bool {
    let pairs = angles_deg.iter().zip(&model.joints);
    pairs.fold(true, |all, (angle, joint)| {
        all && (angle - joint.home_deg).abs() <= 200.0
    })
}

const fn out_of_reach(version: Version, [first, second]: [f32; 2]) -> HaplyTrouble {
    HaplyTrouble::OutOfReach {
        first,
        second,
        version: version.number(),
        other: version.other().number(),
    }
}
