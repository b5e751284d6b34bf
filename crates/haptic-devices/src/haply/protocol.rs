//! The frames of the board, byte by byte. No checksum, no length: both ends count.
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

use super::model::Model;

/// Number of the device on its board, that of the maker's examples.
pub(crate) const DEVICE_ID: u8 = 5;
/// Largest torque that the board lets a motor make, N·m.
pub const TORQUE_MAX_NM: f64 = 0.123;
/// Bytes of a frame of torques.
pub const TORQUES_BYTES: usize = 10;
/// Bytes of a configuration.
pub const CONFIGURATION_BYTES: usize = 26;
/// Bytes of an answer.
pub const ANSWER_BYTES: usize = 9;
/// More zeros than any frame can still miss: a configuration of four motors and encoders with 255 sensors and pins, which a byte
/// too many may have begun, has 3 + 4 + 1 + 4 + 1 + 255 + 1 + 255 + 4·8 = 556 bytes.
const ZEROS: usize = 600;
/// A type that no board knows.
const SKIPPED: u8 = 0xFF;

/// The frame that resets the board.
#[must_use]
pub const fn reset() -> [u8; 2] {
    [0, DEVICE_ID]
}

/// Bytes after which the board begins a new frame for certain, whatever it had of the last: zeros that fill up a frame, as torques
/// and numbers of nothing, and reset the board; then a type that it skips, or takes for the number of the last reset.
#[must_use]
pub(crate) const fn resynchronise() -> [u8; ZEROS + 1] {
    let mut bytes = [0; ZEROS + 1];
    bytes[ZEROS] = SKIPPED;
    bytes
}

/// The frame that configures the board for this device.
#[must_use]
pub fn configuration(model: &Model) -> [u8; CONFIGURATION_BYTES] {
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
    for (place, number) in bytes[10..].chunks_exact_mut(4).zip(numbers.as_flattened()) {
        place.copy_from_slice(&number.to_le_bytes());
    }
    bytes
}

/// The frame that sets the torques of both joints, N·m.
///
/// The lowest byte of each number is zero. When a byte of the frame is lost, what the board reads a place too early then has zero
/// as its highest byte: next to no torque instead of any. It costs 3·10⁻⁵ of the torque at most, towards zero.
#[must_use]
pub fn torques(model: &Model, torques_nm: [f32; 2]) -> [u8; TORQUES_BYTES] {
    let mut bytes = [0; TORQUES_BYTES];
    bytes[..2].copy_from_slice(&[2, DEVICE_ID]);
    for (place, joint) in bytes[2..].chunks_exact_mut(4).zip(model.by_port()) {
        place.copy_from_slice(&torques_nm[joint].to_le_bytes());
        place[0] = 0;
    }
    bytes
}

/// The answer of the board with this number and these angles of the joints, degrees.
#[must_use]
pub fn answer(model: &Model, device_id: u8, angles_deg: [f32; 2]) -> [u8; ANSWER_BYTES] {
    let mut bytes = [0; ANSWER_BYTES];
    bytes[0] = device_id;
    for (place, joint) in bytes[1..].chunks_exact_mut(4).zip(model.by_port()) {
        place.copy_from_slice(&angles_deg[joint].to_le_bytes());
    }
    bytes
}

/// Number of the device and angles of the joints, degrees, of an answer.
#[must_use]
pub fn angles_of(model: &Model, bytes: [u8; ANSWER_BYTES]) -> (u8, [f32; 2]) {
    let [device_id, a0, a1, a2, a3, b0, b1, b2, b3] = bytes;
    let by_port = [[a0, a1, a2, a3], [b0, b1, b2, b3]].map(f32::from_le_bytes);
    let mut angles_deg = [0.0; 2];
    for (angle, joint) in by_port.into_iter().zip(model.by_port()) {
        angles_deg[joint] = angle;
    }
    (device_id, angles_deg)
}
