//! The code that the table times, in one place: `tests/suite/performance.rs` reads it too.

use crc::{CRC_32_ISO_HDLC, Crc};
use std::path::Path;

/// Files, or whole folders of them.
const KERNELS: &[&str] = &[
    "benches/table/src",
    "crates/certified-count/src",
    "crates/fracdiff/src/batch.rs",
    "crates/fracdiff/src/differintegrator.rs",
    "crates/fracdiff/src/fft.rs",
    "crates/fracdiff/src/fir.rs",
    "crates/fracdiff/src/full_memory",
    "crates/fracdiff/src/integer_part.rs",
    "crates/fracdiff/src/oustaloup.rs",
    "crates/fracdiff/src/short_memory.rs",
    "crates/fracdiff/src/tustin_muir.rs",
    "crates/fractional-control/src/parallel.rs",
    "crates/fractional-control/src/pid.rs",
    "crates/haptic-analysis/src/characteristic.rs",
    "crates/haptic-analysis/src/decomposition.rs",
    "crates/haptic-analysis/src/region.rs",
    "crates/haptic-analysis/src/stability.rs",
];

/// CRC-32 of the lines of code, as hexadecimal digits: comments, blank lines, indentation and the tests at the end of a
/// file take no time.
pub(crate) fn digest(root: &Path) -> std::io::Result<String> {
    let crc = Crc::<u32>::new(&CRC_32_ISO_HDLC);
    let mut digest = crc.digest();
    for name in KERNELS {
        for text in texts(&root.join(name))? {
            let code = text.split("#[cfg(test)]\nmod tests").next();
            for line in code.into_iter().flat_map(str::lines).map(str::trim) {
                if !line.is_empty() && !line.starts_with("//") {
                    digest.update(line.as_bytes());
                }
            }
        }
    }
    Ok(format!("{:08x}", digest.finalize()))
}

/// The texts of a file, or of a folder's files in the order of their names.
fn texts(path: &Path) -> std::io::Result<Vec<String>> {
    if path.is_file() {
        return Ok(vec![std::fs::read_to_string(path)?]);
    }
    let entries = std::fs::read_dir(path)?.map(|entry| entry.map(|entry| entry.path()));
    let mut paths = entries.collect::<Result<Vec<_>, _>>()?;
    paths.sort();
    let texts = paths.iter().map(|path| texts(path));
    Ok(texts.collect::<Result<Vec<_>, _>>()?.concat())
}
