//! The files of a picture: `STEM.svg` and `STEM.png`, both or neither.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use haptic_figure::{FigureError, Picture};

use crate::record::{Leftover, NewFile, NewFileError};

/// A picture that could not be saved.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PictureFileError {
    /// The pixels could not be made.
    #[error(transparent)]
    Figure(#[from] FigureError),
    /// The files could not be written.
    #[error(transparent)]
    File(#[from] NewFileError),
}

/// The files of a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SavedPicture {
    /// The drawing, to edit or to include in a paper.
    pub svg: PathBuf,
    /// The pixels, to look at.
    pub png: PathBuf,
}

/// Writes `STEM.svg` and `STEM.png`, both or neither. Existing files are refused unless `overwrite` is set, and
/// then replaced whole.
///
/// # Errors
/// If a file exists or cannot be written, or the picture cannot be rendered.
pub fn save(
    picture: &Picture,
    stem: &Path,
    overwrite: bool,
) -> Result<SavedPicture, PictureFileError> {
    let [svg, png] = ["svg", "png"].map(|extension| with_suffix(stem, extension));
    // Both are staged before either gets its name.
    let staged_svg = stage(&svg, picture.svg().as_bytes(), overwrite)?;
    let staged_png = stage(&png, &picture.png()?, overwrite)?;
    staged_svg.publish()?;
    staged_png.publish()?;
    Ok(SavedPicture { svg, png })
}

/// `a-0.5` and `png` to `a-0.5.png`; `Path::with_extension` would make `a-0.png` of it.
fn with_suffix(stem: &Path, extension: &str) -> PathBuf {
    let mut name = stem.as_os_str().to_owned();
    name.push(".");
    name.push(extension);
    PathBuf::from(name)
}

fn stage(path: &Path, bytes: &[u8], overwrite: bool) -> Result<NewFile, NewFileError> {
    let (new_file, mut file) = NewFile::create(path, Leftover::Discard, overwrite)?;
    (file.write_all(bytes)).map_err(|source| NewFileError::io(path, source))?;
    Ok(new_file)
}
