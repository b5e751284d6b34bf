//! The files of a picture: `STEM.svg` and `STEM.png`, both or neither. A build without the feature `png` has only the
//! first, and says so once.

use std::path::{Path, PathBuf};

use haptic_experiment::Failure;
use haptic_figure::{FigureError, Picture};

use haptic_log::record::{NewFile, NewFileError};

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

/// Said behind the name of the file to look at.
pub const AND_SVG: &str = if cfg!(feature = "png") {
    " (and .svg)"
} else {
    ""
};

/// The files of a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SavedPicture {
    /// The drawing, to edit or to include in a paper.
    pub svg: PathBuf,
    /// The pixels, to look at; in a build with the feature `png`.
    pub png: Option<PathBuf>,
}

impl SavedPicture {
    /// The file to look at.
    #[must_use]
    pub fn shown(&self) -> &Path {
        self.png.as_ref().unwrap_or(&self.svg)
    }
}

/// The names of a picture's files.
#[must_use]
pub fn names(stem: &Path) -> [PathBuf; 2] {
    ["svg", "png"].map(|extension| with_suffix(stem, extension))
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
    let svg = with_suffix(stem, "svg");
    // Both are staged before either gets its name.
    let staged_svg = NewFile::filled(&svg, picture.svg().as_bytes(), overwrite)?;
    let staged_png = stage_png(picture, stem, overwrite)?;
    staged_svg.publish()?;
    let png = match staged_png {
        None => None,
        Some(staged) => {
            let png = staged.target().to_owned();
            staged.publish()?;
            Some(png)
        }
    };
    Ok(SavedPicture { svg, png })
}

#[cfg(feature = "png")]
fn stage_png(
    picture: &Picture,
    stem: &Path,
    overwrite: bool,
) -> Result<Option<NewFile>, PictureFileError> {
    let png = with_suffix(stem, "png");
    Ok(Some(NewFile::filled(&png, &picture.png()?, overwrite)?))
}

#[cfg(not(feature = "png"))]
fn stage_png(
    _: &Picture,
    stem: &Path,
    overwrite: bool,
) -> Result<Option<NewFile>, PictureFileError> {
    // One of an earlier run would pass for the pixels of this one.
    let png = with_suffix(stem, "png");
    if overwrite {
        let _ = std::fs::remove_file(png);
    } else if png.exists() {
        return Err(NewFileError::Exists(png).into());
    }
    static SAID: std::sync::Once = std::sync::Once::new();
    let text = "this build draws pictures as SVG only; build it with --features png for PNG";
    SAID.call_once(|| crate::output::note("warning", text));
    Ok(None)
}

/// `a-0.5` and `png` to `a-0.5.png`; `Path::with_extension` would make `a-0.png` of it.
fn with_suffix(stem: &Path, extension: &str) -> PathBuf {
    let mut name = stem.as_os_str().to_owned();
    name.push(".");
    name.push(extension);
    PathBuf::from(name)
}

impl From<PictureFileError> for Failure {
    fn from(error: PictureFileError) -> Self {
        match error {
            PictureFileError::Figure(FigureError::Render(_)) => Self::Run(error.into()),
            PictureFileError::Figure(_) => Self::Input(error.into()),
            PictureFileError::File(error) => error.into(),
        }
    }
}
