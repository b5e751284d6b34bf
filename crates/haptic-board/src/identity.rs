//! The image's identity, by which a host knows what it flashes.

use haptic_link::Capabilities;

const MARK: [u8; 20] = *b"haptic-device image\0";

/// Identity of an image: a mark, the board's name in 16 bytes, the version (major, minor, patch).
/// `host-cli device flash` looks for it in the image and compares it with the device that answers afterwards.
///
/// Keep it in the image, though nothing there reads it:
///
/// ```
/// static IDENTITY: [u8; 39] = haptic_board::identity("my-board", [0, 1, 0]);
/// core::hint::black_box(&IDENTITY);
/// # assert_eq!(IDENTITY[20..28], *b"my-board");
/// # assert_eq!(IDENTITY[36..], [0, 1, 0]);
/// ```
#[must_use]
pub const fn identity(board: &str, version: [u8; 3]) -> [u8; 39] {
    let board = Capabilities::board_name(board);
    let mut identity = [0; 39];
    let (mark, rest) = identity.split_at_mut(MARK.len());
    mark.copy_from_slice(&MARK);
    let (name, of_version) = rest.split_at_mut(board.len());
    name.copy_from_slice(&board);
    of_version.copy_from_slice(&version);
    identity
}
