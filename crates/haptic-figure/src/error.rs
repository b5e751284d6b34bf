//! Errors of pictures.

use crate::Sheet;

/// A picture that could not be drawn.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FigureError {
    /// There is nothing to draw.
    #[error("no {what} to draw: {samples} samples, none of them finite and within its axes")]
    Empty {
        /// The curve that is missing.
        what: &'static str,
        /// Number of samples given; none of them can be shown.
        samples: usize,
    },
    /// A page has no letters for this many panels.
    #[error("{found} panels on one page; at most {most} fit")]
    Panels {
        /// Panels that the page was asked for.
        found: usize,
        /// More would have no letter of their own.
        most: usize,
    },
    /// The slices of a figure belong together sample by sample and differ in length.
    #[error("{what} has {found} samples where time has {expected}; both need the same number")]
    Lengths {
        /// The slice with another length.
        what: &'static str,
        /// Number of samples of the time.
        expected: usize,
        /// Number of samples of this slice.
        found: usize,
    },
    /// A page has no such panel.
    #[error(
        "there is no panel `{wanted}`: {known}; give a letter, a number or the start of a caption"
    )]
    Panel {
        /// The name that was asked for.
        wanted: String,
        /// The panels of the page.
        known: String,
    },
    /// A page cannot be printed at this width.
    #[error(
        "a picture cannot be {} mm wide: {} mm to {} mm",
        1e3 * width_m, 1e3 * Sheet::WIDTHS_M.start(), 1e3 * Sheet::WIDTHS_M.end()
    )]
    Width {
        /// The width that was asked for, m.
        width_m: f64,
    },
    /// The drawing could not be turned into pixels.
    #[error("the picture cannot be rendered: {0}")]
    Render(String),
}
