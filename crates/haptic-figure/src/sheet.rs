//! Size and content of a printed picture.

use std::ops::RangeInclusive;

/// Size and content of a printed picture; the default is all of it, 880 CSS pixels wide.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sheet {
    /// Width on paper, m. Panels then stand below each other where they have no room beside, and no text but a superscript is
    /// smaller than 6 points.
    pub width_m: Option<f64>,
    /// The one panel to print: its letter, its number, or the start of its caption.
    pub panel: Option<String>,
    /// True for a picture without its title and conditions, as beside a caption of their own.
    pub untitled: bool,
}

impl Sheet {
    /// The widths that a picture can have, m.
    pub const WIDTHS_M: RangeInclusive<f64> = 0.06..=0.5;
}
