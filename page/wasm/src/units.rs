//! Values with units, read as the command line reads them.

use crate::bench::refused;
use haptic_quantity::parse_for_key;
use wasm_bindgen::prelude::*;

/// A value of a kind (`time`, `mass`, `stiffness`, …) in SI units; a kind that is not listed is a number.
///
/// # Errors
/// Text that is none: the message of the command line, which lists the units.
#[wasm_bindgen]
pub fn parse_quantity(kind: &str, text: &str) -> Result<f64, JsError> {
    let key = match kind {
        "area" => "_m2",
        "damping" => "_n_s_per_m",
        "force" => "_n",
        "frequency" => "_hz",
        "length" => "_m",
        "mass" => "_kg",
        "stiffness" => "_n_per_m",
        "stress" => "_pa",
        "time" => "_s",
        _ => "",
    };
    parse_for_key(key, text).map_err(refused)
}
