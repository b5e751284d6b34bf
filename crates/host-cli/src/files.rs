//! Places of results: folders with their provenance, and pictures in them.

mod place;

pub use place::{Place, PlaceOfFile};

use crate::picture_file;
use haptic_experiment::Failure;
use haptic_experiment::run::{FolderRequest, OutputFolder};
use haptic_figure::{FigureError, Picture};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// A folder for files of this stem, whose logs say what made them.
#[must_use]
pub fn folder(out: Option<PathBuf>, stem: &str, overwrite: bool) -> FolderRequest {
    FolderRequest {
        out,
        stem: stem.to_owned(),
        overwrite,
        roll_bytes: None,
        provenance: provenance(),
    }
}

/// Refuses to overwrite where no folder is named: nothing is there yet.
///
/// # Errors
/// Overwriting without a folder.
pub fn overwrite_acts(out: Option<&Path>, overwrite: bool) -> Result<(), Failure> {
    if overwrite && out.is_none() {
        return Err(Failure::bad_input(
            "overwriting has no effect without a folder of an earlier run: give --out too, or leave --overwrite out",
        ));
    }
    Ok(())
}

/// Program and command line, as log metadata.
#[must_use]
pub fn provenance() -> BTreeMap<String, String> {
    let arguments: Vec<String> = std::env::args_os()
        .map(|argument| argument.to_string_lossy().into_owned())
        .collect();
    [
        (
            "program",
            concat!("host-cli ", env!("CARGO_PKG_VERSION")).to_owned(),
        ),
        ("command_line", arguments.join(" ")),
    ]
    .map(|(key, value)| (key.to_owned(), value))
    .into()
}

/// Saves a picture as SVG and PNG under the folder's own stem, and names the one to look at.
///
/// # Errors
/// If it cannot be drawn or the disk does not take it.
pub fn save_picture(
    folder: &OutputFolder,
    picture: Result<Picture, FigureError>,
) -> Result<String, Failure> {
    let picture = picture.map_err(picture_file::PictureFileError::from)?;
    let saved = picture_file::save(&picture, &folder.stem(), folder.overwrite())?;
    Ok(saved.shown().display().to_string())
}
