//! Values with units, read as the command line reads them.

use crate::bench::refused;
use haptic_quantity::{
    Area, Damping, Force, Frequency, Length, Mass, Stiffness, Strain, Stress, Time, parse_number,
};
use wasm_bindgen::prelude::*;

/// A value of a kind (`time`, `mass`, `stiffness`, …) in SI units; a kind that is not listed is a number.
///
/// # Errors
/// Text that is none: the message of the command line, which lists the units.
#[wasm_bindgen]
pub fn parse_quantity(kind: &str, text: &str) -> Result<f64, JsError> {
    macro_rules! read {
        ($quantity:ident) => {
            text.parse::<$quantity>()
                .map(|value| value.0)
                .map_err(refused)
        };
    }
    match kind {
        "area" => read!(Area),
        "damping" => read!(Damping),
        "force" => read!(Force),
        "frequency" => read!(Frequency),
        "length" => read!(Length),
        "mass" => read!(Mass),
        "stiffness" => read!(Stiffness),
        "strain" => read!(Strain),
        "stress" => read!(Stress),
        "time" => read!(Time),
        _ => parse_number(text).map_err(|error| refused(format!("\"{text}\" is {error}"))),
    }
}
