//! Values with units, read as the command line reads them.

use crate::bench::refused;
use haptic_quantity::parse_for_key;
use wasm_bindgen::prelude::*;

/// A value in the SI unit that the end of a key says.
///
/// # Errors
/// Text that is none: the message of the command line, which lists the units.
#[wasm_bindgen]
pub fn parse_quantity(key: &str, text: &str) -> Result<f64, JsError> {
    parse_for_key(key, text).map_err(refused)
}
