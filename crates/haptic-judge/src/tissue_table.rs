//! A piece of tissue, and the operator of a law, as the keys of any table give them.

use crate::modelled_tissue::{ModelledTissue, TissuePiece, operator};
use fracdiff::{Order, Scheme, Seconds, parameter::Shown};
use haptic_document::{FileError, Table, parameters as p, parameters::Parameter};
use haptic_loop::{Loading, LoadingKind, LoopParameterError};
use haptic_quantity::label;
use haptic_tissue::{Library, Material, Model};

/// A scheme that can be made for this order, or for a model, and sample time.
///
/// # Errors
/// A value that is wrong, with its place.
pub fn scheme(
    table: &Table<'_>,
    model: Option<&Model>,
    order: Order,
    sample_time_s: f64,
    duration_s: f64,
) -> Result<Scheme, FileError> {
    let scheme = table.scheme(&p::SCHEME)?;
    let horizon = haptic_trial::samples::horizon((duration_s / sample_time_s) as u64);
    match operator::<f64>(model, scheme, order, Seconds(sample_time_s), horizon) {
        Ok(_) => Ok(scheme),
        Err(error) => Err(table.fail_at("scheme", error)),
    }
}

/// A tissue of the library and a piece of it.
///
/// # Errors
/// A value that is wrong, with its place.
pub fn piece(table: &Table<'_>) -> Result<TissuePiece, FileError> {
    let folder = table.file(&p::LIBRARY)?;
    let library =
        Library::load(folder.as_deref()).map_err(|error| table.fail_at("library", error))?;
    let tissue = table.file(&p::TISSUE)?.unwrap_or_default();
    let wrong = |error: String| table.fail_at("tissue", error);
    let logged = table.logged(&p::TISSUE);
    let material = match logged.filter(|_| !table.is_given(&p::LIBRARY)) {
        Some(text) => Material::parse(&tissue, text),
        None => library.find(&tissue.to_string_lossy()),
    };
    let material = ModelledTissue::new(material.map_err(|error| wrong(error.to_string()))?);
    let material = material.map_err(|error| wrong(error.to_string()))?;
    // A size with a default is one of a slab only.
    let given = loading(table)?;
    let usual = |parameter: Parameter| {
        let slab = given.kind.is_slab();
        slab.then_some(parameter.default_number())
    };
    let loading = Loading {
        area_m2: given.area_m2.or(usual(p::AREA)),
        thickness_m: given.thickness_m.or(usual(p::THICKNESS)),
        ..given
    };
    TissuePiece::new(material, loading).map_err(|error| match of_loading(&error) {
        Some((parameter, remedy)) => {
            table.fail_at(parameter.key, format!("{error}: {remedy} {parameter}"))
        }
        None => table.fail(error),
    })
}

/// The loading of a specimen, as far as the keys give it.
fn loading(table: &Table<'_>) -> Result<Loading, FileError> {
    let kind: LoadingKind = table.choice(&p::LOADING)?;
    let given = |parameter: &Parameter| {
        let number = table.has(parameter).then(|| table.number(parameter));
        number.transpose()
    };
    Ok(Loading {
        kind,
        area_m2: given(&p::AREA)?,
        thickness_m: given(&p::THICKNESS)?,
        radius_m: table.number_if(&p::INDENTER_RADIUS)?,
        half_angle_rad: table.number_if(&p::HALF_ANGLE)?,
        bonded: table.flag(&p::BONDED)?,
    })
}

/// The key of a size that a loading refuses, and what to do with it.
fn of_loading(error: &LoopParameterError) -> Option<(&'static Parameter, &'static str)> {
    let (what, remedy) = if let LoopParameterError::Missing { what, .. } = error {
        (*what, "give")
    } else if let LoopParameterError::NoEffect { what, .. }
    | LoopParameterError::Layer { what, .. } = error
    {
        (*what, "omit")
    } else if let LoopParameterError::Range(range) = error {
        (range.what, "change")
    } else {
        return None;
    };
    let mut keys = p::PIECE.iter();
    let key = keys.find(|parameter| label(parameter.key) == what)?;
    Some((key, remedy))
}

/// Refuses a depth beyond the thickness of a piece.
///
/// # Errors
/// A value that is wrong, with its place.
pub fn fits(table: &Table<'_>, piece: &TissuePiece, depth_m: f64) -> Result<(), FileError> {
    let thickness_m = piece.specimen.loading().thickness_m;
    match thickness_m.filter(|thickness_m| depth_m > *thickness_m) {
        None => Ok(()),
        Some(thickness_m) => Err(table.fail_at(
            "depth_m",
            format_args!(
                "depth_m = {depth_m} is beyond thickness_m = {thickness_m}: change one of them",
                depth_m = Shown(depth_m),
                thickness_m = Shown(thickness_m)
            ),
        )),
    }
}

/// A piece whose force follows its depth by the memory alone.
///
/// # Errors
/// A value that is wrong, with its place.
pub fn linear_piece(table: &Table<'_>) -> Result<TissuePiece, FileError> {
    let piece = piece(table)?;
    if piece.is_linear() {
        Ok(piece)
    } else {
        Err(table.fail_at(p::LOADING.key, TissuePiece::NOT_LINEAR))
    }
}
