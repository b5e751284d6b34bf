//! Files from outside, which are not waited for, and texts that never take more memory than they may.

use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

/// No experiment or tissue file is longer, bytes.
pub const TEXT_MOST: u64 = 1 << 20;

/// Opens a file to read.
/// # Errors
/// Those of the system; what is not a regular file, as a pipe, where nobody may ever write.
pub fn open_file(path: &Path) -> io::Result<File> {
    if !std::fs::metadata(path)?.is_file() {
        let why = "it is not a regular file";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, why));
    }
    File::open(path)
}

/// The text of a file, if it is not longer than [`TEXT_MOST`].
/// # Errors
/// Those of [`open_file`]; a longer file.
pub fn read_text(path: &Path) -> io::Result<String> {
    let mut text = Vec::new();
    (open_file(path)?.take(TEXT_MOST + 1)).read_to_end(&mut text)?;
    if text.len() as u64 > TEXT_MOST {
        return Err(io::Error::new(
            io::ErrorKind::InvalidData,
            format!("it is longer than {TEXT_MOST} bytes"),
        ));
    }
    String::from_utf8(text)
        .map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "it is not UTF-8 text"))
}
