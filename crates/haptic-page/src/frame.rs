//! The binary frame of a view, byte by byte: see `docs/page-protocol.md`.

use crate::pyramid::Columns;

/// "FHP1".
pub const MAGIC: u32 = 0x3150_4846;
/// Bytes before the numbers.
pub const HEADER_BYTES: usize = 40;

/// Writes a frame that answers the request of this number.
///
/// ```
/// use haptic_page::frame::{HEADER_BYTES, frame};
/// use haptic_page::pyramid::{Pyramid, PyramidSize, Span};
///
/// let mut pyramid = Pyramid::new(PyramidSize::usual(2));
/// pyramid.push(&[1.0, -1.0]);
/// let bytes = frame(7, &pyramid.columns(Span::new(0, 1, 1)), 1e-3);
/// assert_eq!((&bytes[..4], bytes.len()), (&b"FHP1"[..], HEADER_BYTES + 2 * 2 * 4));
/// ```
#[must_use]
pub fn frame(request: u32, columns: &Columns, sample_time_s: f64) -> Vec<u8> {
    let numbers = columns.numbers();
    let mut bytes = Vec::with_capacity(HEADER_BYTES + 4 * numbers.len());
    // A view has thousands of columns at most, and few channels.
    let (channels, count) = (columns.channels() as u32, columns.count() as u32);
    for word in [MAGIC, request, channels, count] {
        bytes.extend_from_slice(&word.to_le_bytes());
    }
    let (first, width) = (columns.first_tick() as f64, columns.width() as f64);
    for number in [first, width, sample_time_s] {
        bytes.extend_from_slice(&number.to_le_bytes());
    }
    for number in numbers {
        bytes.extend_from_slice(&number.to_le_bytes());
    }
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pyramid::{Pyramid, PyramidSize, Span};

    #[test]
    fn a_frame_is_what_the_protocol_says_byte_by_byte() {
        let mut pyramid = Pyramid::new(PyramidSize {
            channels: 2,
            samples: 8,
            entries: 8,
            coarser: 1,
        });
        for sample in [[1.0, f32::NAN], [-2.0, 5.0], [0.5, f32::NAN]] {
            pyramid.push(&sample);
        }
        let bytes = frame(7, &pyramid.columns(Span::new(0, 4, 2)), 1e-3);
        let mut want = vec![0x46, 0x48, 0x50, 0x31, 7, 0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0];
        for number in [0.0, 2.0, 1e-3_f64] {
            want.extend(number.to_le_bytes());
        }
        let nan = f32::NAN;
        for number in [-2.0, 0.5, 1.0, 0.5, 5.0, nan, 5.0, nan] {
            want.extend(number.to_le_bytes());
        }
        assert_eq!(bytes, want);
    }
}
