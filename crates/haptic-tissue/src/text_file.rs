//! Files from outside, which are not waited for, and texts that never take more memory than they may.

use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

/// Largest size of an experiment or tissue file, bytes.
pub const TEXT_MOST: u64 = 1 << 20;

/// The bytes of a file, up to one more than these.
///
/// # Errors
/// The system's errors; anything but a regular file, such as a pipe, which might never
/// deliver.
pub fn read_bytes(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    if !std::fs::metadata(path)?.is_file() {
        let why = "it is not a regular file";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, why));
    }
    let mut bytes = Vec::new();
    (File::open(path)?.take(most + 1)).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// The text of a file, if it is not longer than [`TEXT_MOST`].
///
/// # Errors
/// As for [`read_bytes`]; a longer file.
pub fn read_text(path: &Path) -> io::Result<String> {
    let wrong = |why: String| io::Error::new(io::ErrorKind::InvalidData, why);
    let text = read_bytes(path, TEXT_MOST)?;
    if text.len() as u64 > TEXT_MOST {
        return Err(wrong(format!("it is longer than {TEXT_MOST} bytes")));
    }
    String::from_utf8(text).map_err(|_| wrong("it is not UTF-8 text".to_owned()))
}
