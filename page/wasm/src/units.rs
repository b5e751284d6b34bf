//! Values with units, read by the code of the command line.

use crate::bench::refused;
use crate::quantity::{
    Area, Damping, Force, Frequency, Length, Mass, Stiffness, Strain, Stress, Time,
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
        _ => number(text),
    }
}

fn number(text: &str) -> Result<f64, JsError> {
    let value = text.trim().parse::<f64>().ok();
    value
        .filter(|value| value.is_finite())
        .ok_or_else(|| refused(format!("\"{text}\" is not a finite number")))
}
