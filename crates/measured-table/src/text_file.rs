//! Files from outside, which are not waited for, and texts that never take more memory than they may, in UTF-8, UTF-16 or
//! Windows-1252.
//!
//! This is the one door to a disk below the crates that touch the world: without the feature `files` it is shut, and says so.

use std::borrow::Cow;
use std::io;
use std::path::{Path, PathBuf};

/// Largest size of an experiment or tissue file, bytes.
pub const TEXT_MOST: u64 = 1 << 20;

/// Largest size of a table, bytes.
pub const TABLE_MOST: u64 = 1 << 28;

/// The bytes of a file, up to one more than these.
///
/// # Errors
/// The system's errors; anything but a regular file, such as a pipe, which might never
/// deliver; any file, in a program without files.
pub fn read_bytes(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    open::bytes(path, most)
}

/// The files of a folder with this extension, by name.
///
/// # Errors
/// The system's errors; any folder, in a program without files.
pub fn files_in(folder: &Path, extension: &str) -> io::Result<Vec<PathBuf>> {
    let mut files = open::files(folder)?;
    files.retain(|path| path.extension().is_some_and(|known| known == extension));
    files.sort();
    Ok(files)
}

/// True if there is a regular file of this name; never in a program without files.
#[must_use]
pub fn is_file(path: &Path) -> bool {
    open::is_file(path)
}

#[cfg(feature = "files")]
mod open {
    use std::fs::{File, metadata, read_dir};
    use std::io::{self, Read as _};
    use std::path::{Path, PathBuf};

    pub(super) fn bytes(path: &Path, most: u64) -> io::Result<Vec<u8>> {
        if !metadata(path)?.is_file() {
            let why = "it is not a regular file";
            return Err(io::Error::new(io::ErrorKind::InvalidInput, why));
        }
        let mut bytes = Vec::new();
        (File::open(path)?.take(most + 1)).read_to_end(&mut bytes)?;
        Ok(bytes)
    }

    pub(super) fn is_file(path: &Path) -> bool {
        metadata(path).is_ok_and(|found| found.is_file())
    }

    pub(super) fn files(folder: &Path) -> io::Result<Vec<PathBuf>> {
        read_dir(folder)?.map(|entry| Ok(entry?.path())).collect()
    }
}

#[cfg(not(feature = "files"))]
mod open {
    use std::io;
    use std::path::{Path, PathBuf};

    fn shut<T>() -> io::Result<T> {
        let why = "this program reads no files: give the text itself";
        Err(io::Error::new(io::ErrorKind::Unsupported, why))
    }

    pub(super) fn bytes(_: &Path, _: u64) -> io::Result<Vec<u8>> {
        shut()
    }

    pub(super) const fn is_file(_: &Path) -> bool {
        false
    }

    pub(super) fn files(_: &Path) -> io::Result<Vec<PathBuf>> {
        shut()
    }
}

/// The text of a file, if it is not longer than [`TEXT_MOST`].
///
/// # Errors
/// As for [`read_bytes`]; a longer file; one that is no text.
pub fn read_text(path: &Path) -> io::Result<String> {
    let wrong = |why: String| io::Error::new(io::ErrorKind::InvalidData, why);
    let bytes = read_bytes(path, TEXT_MOST)?;
    if bytes.len() as u64 > TEXT_MOST {
        return Err(wrong(format!("it is longer than {TEXT_MOST} bytes")));
    }
    let text = decoded(&bytes).map_err(|why| wrong(why.to_owned()))?;
    Ok(text.into_owned())
}

/// Bytes as text, without their marks, or the reason why they cannot be one.
pub(crate) fn decoded(bytes: &[u8]) -> Result<Cow<'_, str>, &'static str> {
    let wide = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        // Some programs end the text with a byte of its own.
        let whole = bytes.strip_suffix(b"\n").filter(|_| bytes.len() % 2 == 1);
        let bytes = whole.unwrap_or(bytes);
        if bytes.len() % 2 == 1 {
            return Err("this is UTF-16 of an odd number of bytes, so its end is missing");
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
        return Err("this is no text");
    }
    // Lines of an old Mac.
    Ok(if text.contains('\r') && !text.contains('\n') {
        Cow::Owned(text.replace('\r', "\n"))
    } else {
        text
    })
}
