//! Bytes of a file as text: UTF-8, UTF-16 or Windows-1252.

use super::super::error::IdentifyError;
use std::borrow::Cow;

/// The text of a file, without its marks.
pub(super) fn decoded(bytes: &[u8]) -> Result<Cow<'_, str>, IdentifyError> {
    let wide = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        // Some programs end the text with a byte of its own.
        let whole = bytes.strip_suffix(b"\n").filter(|_| bytes.len() % 2 == 1);
        let bytes = whole.unwrap_or(bytes);
        if bytes.len() % 2 == 1 {
            return Err(IdentifyError::Record(
                "this is UTF-16 of an odd number of bytes: its end is missing, save it again"
                    .to_owned(),
            ));
        }
        let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
        let text = char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER));
        Ok(Cow::Owned(text.collect::<String>()))
    };
    let text = match bytes {
        [0xff, 0xfe, rest @ ..] => wide(rest, u16::from_le_bytes)?,
        [0xfe, 0xff, rest @ ..] => wide(rest, u16::from_be_bytes)?,
        // Without a mark: the first letters are of one byte.
        [1..=u8::MAX, 0, 1..=u8::MAX, 0, ..] => wide(bytes, u16::from_le_bytes)?,
        [0, 1..=u8::MAX, 0, 1..=u8::MAX, ..] => wide(bytes, u16::from_be_bytes)?,
        bytes => {
            let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
            match std::str::from_utf8(bytes) {
                Ok(text) => Cow::Borrowed(text),
                // Windows-1252, but for a few signs that no number has.
                Err(_) => Cow::Owned(bytes.iter().map(|byte| char::from(*byte)).collect()),
            }
        }
    };
    let is_sign = |c: &char| c.is_control() && !"\t\r\n\u{b}\u{c}\u{85}".contains(*c);
    let is_text = text.chars().filter(is_sign).count() * 50 <= text.len();
    if !is_text || bytes.starts_with(b"PK\x03\x04") {
        return Err(IdentifyError::Record(
            "this is no text: export the table as CSV".to_owned(),
        ));
    }
    // Lines of an old Mac.
    Ok(match text.contains('\r') && !text.contains('\n') {
        true => Cow::Owned(text.replace('\r', "\n")),
        false => text,
    })
}
