//! The identity in a firmware's image, and the digest by which a board proves that it runs exactly that image.
//!
//! ```text
//! 0 IMAGE_MARK │ 20 board, u8[16] │ 36 version, u8[3] │ 39 0 │ 40 seven addresses, u32 LE: __stext __etext __srodata __erodata __sidata __sdata __edata
//! ```
//! The addresses are those of `cortex-m-rt`'s linker script, all the same where the image does not know them. They bound what the
//! digest is over: code, constants, and in the flash from `__sidata` on the first values of the variables. What lies
//! between these depends on who programs the board, and the vectors before them are addresses of that code.

use crate::frame::CRC;

/// Marks the description that an image carries of itself.
pub const IMAGE_MARK: [u8; 20] = *b"haptic-device image\0";

/// CRC-32 (as zlib's) over the concatenated sections of an image; 0 if they are empty.
#[must_use]
pub fn image_digest(sections: [&[u8]; 3]) -> u32 {
    let mut digest = CRC.digest();
    for section in sections {
        digest.update(section);
    }
    digest.finalize()
}
