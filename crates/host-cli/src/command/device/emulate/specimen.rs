//! The specimen at the handle of an emulated board: the keys of a piece of tissue, as [press] has them.

use crate::options::Options;
use crate::options::keys::Press;
use haptic_document::Document;
use haptic_experiment::Failure;
use haptic_experiment::parameters::{
    AREA, BONDED, HALF_ANGLE, INDENTER_RADIUS, LOADING, Parameter, THICKNESS, TISSUE,
};
use haptic_loop::plant::PressedSpecimen;

/// Parameters with their texts and the words in which they were said.
pub(super) type Words = Vec<(&'static Parameter, String, String)>;

/// The key that names the tissue.
const SPECIMEN: &str = "specimen";

const PIECE: &[Parameter] = &[
    TISSUE,
    LOADING,
    AREA,
    THICKNESS,
    INDENTER_RADIUS,
    HALF_ANGLE,
    BONDED,
];

const fn key(parameter: &Parameter) -> &'static str {
    match parameter.key.as_bytes() {
        b"tissue" => SPECIMEN,
        _ => parameter.key,
    }
}

pub(super) fn keys() -> impl Iterator<Item = (&'static str, &'static str)> {
    PIECE
        .iter()
        .map(|parameter| (key(parameter), parameter.help))
}

/// The parameter of this key, if it is one of a specimen.
pub(super) fn parameter(name: &str) -> Option<&'static Parameter> {
    PIECE.iter().find(|parameter| key(parameter) == name)
}

/// The specimen of these words; `None` without any.
///
/// # Errors
/// A tissue that there is not, a piece of no size, a size without a tissue.
pub(super) fn read(words: Words) -> Result<Option<PressedSpecimen>, Failure> {
    let Some((_, _, first)) = words.first() else {
        return Ok(None);
    };
    let needed = format!(
        "{first} applies only to a specimen: give {SPECIMEN} too, as {SPECIMEN}=fish-muscle"
    );
    let document = Options::<Press>::of(words).over(Document::new("press"))?;
    let piece = haptic_experiment::pressed(&document)?.ok_or_else(|| Failure::bad_input(needed))?;
    Ok(Some(haptic_experiment::specimen(&piece)))
}
