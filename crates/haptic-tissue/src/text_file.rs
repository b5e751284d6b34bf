//! Text files from outside, which never take more memory than they may.

use std::fs::File;
use std::io::{self, Read as _};
use std::path::Path;

/// No experiment or tissue file is longer, bytes.
pub const TEXT_MOST: u64 = 1 << 20;

/// The text of a file, if it is not longer than [`TEXT_MOST`].
///
/// # Errors
/// Those of the system; a longer file; what is not a regular file, as a pipe, where nobody may ever write.
pub fn read_text(path: &Path) -> io::Result<String> {
    if !std::fs::metadata(path)?.is_file() {
        let why = "it is not a regular file";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, why));
    }
    let mut text = Vec::new();
    (File::open(path)?.take(TEXT_MOST + 1)).read_to_end(&mut text)?;
    if text.len() as u64 > TEXT_MOST {
        return Err(io::Error::new(
            io::ErrorKind::InvalidData,
            format!("it is longer than {TEXT_MOST} bytes"),
        ));
    }
    String::from_utf8(text)
        .map_err(|_| io::Error::new(io::ErrorKind::InvalidData, "it is not UTF-8 text"))
}
