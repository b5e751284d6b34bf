//! The files of a picture: `STEM.svg` and `STEM.png`, or the formats that are asked for, all or none. A build without the
//! feature `png` has only the first.

use crate::parse::quantity;
use clap::{Args, ValueEnum};
use haptic_experiment::Failure;
use haptic_experiment::parameters::Range;
use haptic_figure::{FigureError, Picture, Sheet};
use haptic_log::record::{NewFile, NewFileError, remove_earlier};
use std::path::{Path, PathBuf};

/// Options of pictures, for every command that draws.
#[derive(Clone, Debug, Args)]
pub struct Pictures {
    /// Width of pictures on paper, as in 85mm for a column of a journal
    #[arg(long, value_name = "LENGTH", value_parser = quantity("_m", WIDTHS), hide_short_help = true, help_heading = "Run")]
    figure_width: Option<f64>,
    /// Formats to write: svg, png, pdf
    #[arg(
        long,
        value_name = "FORMATS",
        value_delimiter = ',',
        default_value = FORMATS,
        hide_possible_values = true,
        hide_short_help = true,
        help_heading = "Run"
    )]
    figure_format: Vec<Format>,
    /// Draw one panel alone: its letter, number or caption
    #[arg(
        long,
        value_name = "PANEL",
        hide_short_help = true,
        help_heading = "Run"
    )]
    panel: Option<String>,
    /// Draw neither title nor conditions
    #[arg(long, hide_short_help = true, help_heading = "Run")]
    no_title: bool,
}

/// Widths that a picture can have, m.
const WIDTHS: Range = Range::Within(*Sheet::WIDTHS_M.start(), *Sheet::WIDTHS_M.end());

/// The formats that this build writes unless others are asked for.
const FORMATS: &str = if cfg!(feature = "png") {
    "svg,png"
} else {
    "svg"
};

/// A format of pictures; what is shown of several comes last.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
enum Format {
    Pdf,
    Svg,
    Png,
}

impl Format {
    /// The file of a picture: `a-0.5` to `a-0.5.png`; `Path::with_extension` would make `a-0.png` of it.
    fn file(self, stem: &Path) -> PathBuf {
        let mut name = stem.as_os_str().to_owned();
        name.push(match self {
            Self::Pdf => ".pdf",
            Self::Svg => ".svg",
            Self::Png => ".png",
        });
        PathBuf::from(name)
    }

    /// The bytes of a picture.
    fn bytes(self, picture: &Picture) -> Result<Vec<u8>, FigureError> {
        match self {
            Self::Svg => Ok(picture.svg().as_bytes().to_vec()),
            #[cfg(feature = "png")]
            Self::Png => picture.png(),
            #[cfg(feature = "png")]
            Self::Pdf => picture.pdf(),
            #[cfg(not(feature = "png"))]
            Self::Png | Self::Pdf => Err(FigureError::Render(
                "this build has SVG alone: build it with --features png for PNG and PDF".to_owned(),
            )),
        }
    }
}

impl Default for Pictures {
    fn default() -> Self {
        let formats = FORMATS.split(',');
        Self {
            figure_width: None,
            figure_format: formats
                .flat_map(|name| Format::from_str(name, false))
                .collect(),
            panel: None,
            no_title: false,
        }
    }
}

impl Pictures {
    /// The names of a picture's files.
    pub(crate) fn names(&self, stem: &Path) -> Vec<PathBuf> {
        let formats = self.figure_format.iter();
        formats.map(|format| format.file(stem)).collect()
    }

    /// Refuses a panel that the picture of a run will not have, before the run.
    pub(crate) fn check(
        &self,
        rehearsed: impl FnOnce() -> Option<Result<Picture, FigureError>>,
    ) -> Result<(), Failure> {
        let picture = self.panel.as_ref().and_then(|_| rehearsed());
        let on_sheet = picture.map(|picture| picture?.on(&self.sheet()));
        on_sheet.transpose().map_err(undrawn).map(drop)
    }

    fn sheet(&self) -> Sheet {
        Sheet {
            width_m: self.figure_width,
            panel: self.panel.clone(),
            untitled: self.no_title,
        }
    }

    /// Writes the files of a picture, all or none, and names the one to look at. Existing files are refused unless
    /// `overwrite` is set, and then replaced whole; one of a format that is not written any more is taken away.
    ///
    /// # Errors
    /// If a file exists or cannot be written, or the picture cannot be drawn.
    pub fn save(
        &self,
        picture: Result<Picture, FigureError>,
        stem: &Path,
        overwrite: bool,
    ) -> Result<String, Failure> {
        let picture = picture.and_then(|picture| picture.on(&self.sheet()));
        let picture = picture.map_err(undrawn)?;
        // All are staged before one gets its name.
        let (mut staged, mut stale) = (Vec::new(), Vec::new());
        for format in [Format::Pdf, Format::Svg, Format::Png] {
            let file = format.file(stem);
            if self.figure_format.contains(&format) {
                let bytes = format.bytes(&picture).map_err(undrawn)?;
                staged.push(NewFile::filled(&file, &bytes, overwrite)?);
            } else if overwrite {
                stale.push(file);
            } else if file.exists() {
                return Err(NewFileError::Exists(file).into());
            }
        }
        let shown = staged
            .last()
            .map(|file| file.target().display().to_string());
        staged.into_iter().try_for_each(NewFile::publish)?;
        // One of an earlier run would pass for that of this one.
        stale.iter().for_each(|file| remove_earlier(file));
        Ok(shown.unwrap_or_default())
    }
}

/// The failure of a picture that cannot be drawn.
pub(crate) fn undrawn(error: FigureError) -> Failure {
    if matches!(error, FigureError::Render(_)) {
        Failure::run(error)
    } else {
        Failure::input(error)
    }
}
