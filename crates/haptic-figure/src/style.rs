//! One look for all pictures: sizes in CSS pixels, colours, strokes, numbers.
//!
//! The sizes are chosen so that tick labels still have 7.5 px when the page is shown at half its
//! width.

use kuva::render::theme::Theme;

/// Width of every page.
pub(super) const PAGE_WIDTH: f64 = 880.0;
/// Space around the page's content.
pub(super) const PAGE_EDGE: f64 = 14.0;
/// PNG pixels per CSS pixel: 1760 pixels, 250 per inch on a page 7 inches wide.
pub(super) const PNG_SCALE: f32 = 2.0;

/// Font sizes.
pub(super) const TITLE_SIZE: u32 = 20;
pub(super) const SUBTITLE_SIZE: u32 = 16;
pub(super) const LABEL_SIZE: u32 = 17;
/// No text is made smaller than this to fit.
pub(super) const SMALLEST_SIZE: u32 = 11;

/// Colours that people with any colour vision tell apart: M. Okabe and K. Ito, "Color universal
/// design", 2008. Orange is light and blue dark, so grey prints work too.
pub(super) const BLUE: &str = "#0072B2";
pub(super) const ORANGE: &str = "#E69F00";
pub(super) const VERMILION: &str = "#D55E00";
pub(super) const GREEN: &str = "#009E73";
const PURPLE: &str = "#CC79A7";
const SKY: &str = "#56B4E9";
pub(super) const INK: &str = "#1a1a1a";
pub(super) const MUTED_INK: &str = "#555555";
const GRID: &str = "#e4e4e4";

/// The colours of series, in the order in which they are best told apart. Yellow is left out: a
/// yellow line is lost on white paper.
const SERIES_COLOURS: [&str; 7] = [BLUE, VERMILION, GREEN, ORANGE, PURPLE, INK, SKY];
/// The dashes of series, for prints without colour. One more than colours, so that a series beyond
/// the last colour differs from the first.
const SERIES_DASHES: [Dash; 8] = [
    None,
    DASHED,
    DOTTED,
    Some("11 3 2.2 3"),
    Some("18 5"),
    Some("11 3 2.2 3 2.2 3"),
    Some("4.5 4.5"),
    Some("18 4 6 4"),
];
pub(super) const DASHED: Dash = Some("9 4");
pub(super) const DOTTED: Dash = Some("2.2 3");

/// Lengths of dashes and gaps, px; `None` is a solid line.
pub(super) type Dash = Option<&'static str>;

/// The colour of a series.
pub(super) fn series_colour(index: usize) -> &'static str {
    SERIES_COLOURS[index % SERIES_COLOURS.len()]
}

/// The dash of a series that has no other.
pub(super) fn series_dash(index: usize) -> Dash {
    SERIES_DASHES[index % SERIES_DASHES.len()]
}

/// How a curve is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stroke {
    pub(super) colour: &'static str,
    pub(super) width: f64,
    pub(super) dash: Dash,
}

impl Stroke {
    pub(super) const fn solid(colour: &'static str, width: f64) -> Self {
        Self {
            colour,
            width,
            dash: None,
        }
    }
}

/// Sizes of a panel's text and of the space around its box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Sizes {
    /// Font sizes of captions and axis labels, and of tick labels.
    pub(super) label: u32,
    pub(super) tick: u32,
    /// Space between the edges of a panel and its box: on the left at least, if it has a label;
    /// below with a label and without.
    pub(super) left: f64,
    pub(super) right: f64,
    pub(super) top: f64,
    pub(super) bottom: f64,
    pub(super) bottom_bare: f64,
    pub(super) tick_length: f64,
    pub(super) minor_tick_length: f64,
    /// Lines and markers of a series.
    pub(super) series_width: f64,
    pub(super) marker_radius: f64,
}

/// One or two panels in a row.
pub(super) const LARGE: Sizes = Sizes {
    label: LABEL_SIZE,
    tick: 15,
    left: 84.0,
    right: 16.0,
    top: 34.0,
    bottom: 58.0,
    bottom_bare: 32.0,
    tick_length: 7.0,
    minor_tick_length: 4.0,
    series_width: 2.0,
    marker_radius: 4.0,
};

/// Three panels in a row, or more.
pub(super) const SMALL: Sizes = Sizes {
    label: 15,
    tick: 13,
    left: 56.0,
    right: 12.0,
    top: 29.0,
    bottom: 50.0,
    bottom_bare: 26.0,
    tick_length: 5.0,
    minor_tick_length: 3.0,
    series_width: 1.7,
    marker_radius: 3.0,
};

/// Theory lies beneath, broad and light, so that a curve on top of it is seen to agree all along.
pub(super) const THEORY: Stroke = Stroke::solid(ORANGE, 6.0);
/// The run.
pub(super) const RUN: Stroke = Stroke::solid(BLUE, 1.8);
/// The difference of the two.
pub(super) const DIFFERENCE: Stroke = Stroke::solid(VERMILION, 1.8);

/// Black on white with a faint grid.
pub(super) fn theme() -> Theme {
    Theme {
        axis_color: INK.into(),
        tick_color: INK.into(),
        text_color: INK.into(),
        grid_color: GRID.into(),
        ..Theme::light()
    }
}

/// Width of a text in px: an estimate by classes of letters of `DejaVu Sans`, on the wide side.
pub(super) fn text_width(text: &str, size: u32) -> f64 {
    let widths = text.chars().map(|letter| match letter {
        'i' | 'j' | 'l' | '.' | ',' | ':' | ';' | ' ' | '|' | '·' => 0.34,
        'f' | 'r' | 't' | '(' | ')' | '[' | ']' | '/' | '-' => 0.42,
        'm' | 'w' | 'M' | 'W' | '@' | '%' | '…' => 1.0,
        '⁰'..='⁹' | '¹' | '²' | '³' | '⁻' => 0.5,
        'A'..='Z' => 0.76,
        ' '..='~' => 0.64,
        _ => 0.9,
    });
    widths.sum::<f64>() * f64::from(size)
}

/// The text and the size, at most `size`, at which it is not wider than `width`; what does not
/// fit at the smallest size is cut off with an ellipsis.
pub(super) fn fit(text: &str, size: u32, width: f64) -> (String, u32) {
    let fitting = (SMALLEST_SIZE..=size)
        .rev()
        .find(|&size| text_width(text, size) <= width);
    if let Some(size) = fitting {
        return (text.to_owned(), size);
    }
    let mut kept = String::new();
    for letter in text.chars() {
        kept.push(letter);
        if text_width(&kept, SMALLEST_SIZE) + text_width("…", SMALLEST_SIZE) > width {
            kept.pop();
            break;
        }
    }
    (kept + "…", SMALLEST_SIZE)
}

/// `10⁻³` and the like.
pub(super) fn power_of_ten(exponent: i32) -> String {
    format!("10{}", superscript(exponent))
}

/// A tick label on an axis whose ticks are `step` apart and whose largest value is `largest`:
/// plain digits with as many decimals as the step has, or powers of ten where that would be long.
pub(super) fn linear_label(value: f64, step: f64, largest: f64) -> String {
    // Half a step is zero as well: the sum of steps that led here is not exact.
    if value.abs() < 0.5 * step && value.abs() < 1e-9 * largest {
        return "0".to_owned();
    }
    let text = if (1e-4..1e6).contains(&largest) {
        let decimals = (-(step.log10() + 1e-9).floor()).max(0.0) as usize;
        format!("{value:.decimals$}")
    } else {
        let exponent = largest.log10().floor() as i32;
        let mantissa = value / 10f64.powi(exponent);
        let decimals = (exponent - (step.log10() + 1e-9).floor() as i32).max(0) as usize;
        format!("{mantissa:.decimals$}·{}", power_of_ten(exponent))
    };
    text.replace('-', "−")
}

fn superscript(exponent: i32) -> String {
    (exponent.to_string().chars())
        .map(|digit| match digit {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            other => char::from_u32(u32::from(other) - u32::from('0') + 0x2070).unwrap_or(other),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_as_in_a_journal() {
        assert_eq!(linear_label(0.0, 0.1, 1.0), "0");
        assert_eq!(linear_label(0.1 + 0.2, 0.1, 1.0), "0.3");
        assert_eq!(linear_label(-2.5, 0.5, 3.0), "−2.5");
        assert_eq!(linear_label(80_000.0, 2e4, 86_400.0), "80000");
        assert_eq!(linear_label(2e-7, 1e-7, 3e-7), "2·10⁻⁷");
        assert_eq!(linear_label(-3e9, 5e8, 3e9), "−3.0·10⁹");
        assert_eq!(power_of_ten(-12), "10⁻¹²");
    }

    #[test]
    fn long_text_shrinks_and_then_is_cut_but_never_wider_than_its_room() {
        assert_eq!(fit("short", 20, 400.0), ("short".to_owned(), 20));
        let (text, size) = fit(&"x".repeat(50), 20, 400.0);
        assert_eq!((text.chars().count(), size < 20), (50, true));
        let (text, size) = fit(&"x".repeat(500), 20, 400.0);
        assert!(text.ends_with('…') && text_width(&text, size) <= 400.0);
    }
}
