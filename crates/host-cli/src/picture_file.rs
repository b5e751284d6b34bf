//! The files of a picture: `STEM.svg` and `STEM.png`, both or neither. A build without the feature `png` has only the
//! first, and says so once.

use haptic_experiment::Failure;
use haptic_figure::{FigureError, Picture};
use haptic_log::record::NewFile;
use std::path::{Path, PathBuf};

/// The names of a picture's files.
pub(crate) fn names(stem: &Path) -> [PathBuf; 2] {
    ["svg", "png"].map(|extension| with_suffix(stem, extension))
}

/// Writes `STEM.svg` and `STEM.png`, both or neither, and names the one to look at. Existing files are refused unless
/// `overwrite` is set, and then replaced whole.
///
/// # Errors
/// If a file exists or cannot be written, or the picture cannot be drawn.
pub fn save(
    picture: Result<Picture, FigureError>,
    stem: &Path,
    overwrite: bool,
) -> Result<String, Failure> {
    let picture = picture.map_err(undrawn)?;
    // Both are staged before either gets its name.
    let svg = NewFile::filled(
        &with_suffix(stem, "svg"),
        picture.svg().as_bytes(),
        overwrite,
    )?;
    let png = stage_png(&picture, &with_suffix(stem, "png"), overwrite)?;
    let shown = png.as_ref().unwrap_or(&svg).target().display().to_string();
    svg.publish()?;
    png.map(NewFile::publish).transpose()?;
    Ok(shown)
}

#[cfg(feature = "png")]
fn stage_png(picture: &Picture, png: &Path, overwrite: bool) -> Result<Option<NewFile>, Failure> {
    let pixels = picture.png().map_err(undrawn)?;
    Ok(Some(NewFile::filled(png, &pixels, overwrite)?))
}

#[cfg(not(feature = "png"))]
fn stage_png(_: &Picture, png: &Path, overwrite: bool) -> Result<Option<NewFile>, Failure> {
    // One of an earlier run would pass for the pixels of this one.
    if overwrite {
        let _ = std::fs::remove_file(png);
    } else if png.exists() {
        return Err(haptic_log::record::NewFileError::Exists(png.to_owned()).into());
    }
    static SAID: std::sync::Once = std::sync::Once::new();
    let text = "this build draws pictures as SVG only; build it with --features png for PNG";
    SAID.call_once(|| crate::output::note("warning", text));
    Ok(None)
}

/// The failure of a picture that cannot be drawn.
pub(crate) fn undrawn(error: FigureError) -> Failure {
    match matches!(error, FigureError::Render(_)) {
        true => Failure::run(error),
        false => Failure::input(error),
    }
}

/// `a-0.5` and `png` to `a-0.5.png`; `Path::with_extension` would make `a-0.png` of it.
fn with_suffix(stem: &Path, extension: &str) -> PathBuf {
    let mut name = stem.as_os_str().to_owned();
    name.push(".");
    name.push(extension);
    PathBuf::from(name)
}
