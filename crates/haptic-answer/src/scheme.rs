//! Schemes that are judged while a person waits.

use fracdiff::Scheme;
use haptic_document::Failure;
use haptic_quantity::short;
use std::fmt::Display;

/// Longest ring buffer that is judged here: its characteristic polynomial has as many roots, and a minute would pass for ten thousand.
const RING_MOST: usize = 300;

/// A scheme that is read, and judged within the time that a person waits for.
pub(crate) fn judged_scheme(text: &str) -> Result<Scheme, Failure> {
    let refused =
        |why: &dyn Display| Failure::bad_input(format_args!("`scheme` = {}: {why}", short(text)));
    let scheme: Scheme = short(text).parse().map_err(|error| refused(&error))?;
    if matches!(scheme, Scheme::Grunwald { length } if length > RING_MOST) {
        return Err(refused(&format_args!(
            "the page judges at most {RING_MOST} samples: use the command line for more"
        )));
    }
    Ok(scheme)
}
