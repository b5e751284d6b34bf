//! One look for all pictures: sizes in CSS pixels, colours, strokes, widths of text.
//!
//! The sizes are chosen so that tick labels still have 7.5 px when the page is shown at half its width.

use std::ops::RangeInclusive;

pub(crate) const PAGE_WIDTH: f64 = 880.0;
/// Space around the page's content.
pub(crate) const PAGE_EDGE: f64 = 14.0;

pub(crate) const TITLE_SIZE: u32 = 20;
/// A title that is longer than this allows continues in another line.
pub(crate) const SMALLEST_TITLE_SIZE: u32 = 15;
pub(crate) const SUBTITLE_SIZE: u32 = 16;
/// Conditions that are longer than this allows continue in another line.
pub(crate) const SMALLEST_SUBTITLE_SIZE: u32 = 12;
pub(crate) const LABEL_SIZE: u32 = 17;
/// No text is made smaller than this to fit.
pub(crate) const SMALLEST_SIZE: u32 = 11;

/// Colours that people with any colour vision tell apart: M. Okabe and K. Ito, "Color universal
/// design", 2008. Orange is light and blue dark, so grey prints work too.
pub(crate) const BLUE: &str = "#0072b2";
pub(crate) const ORANGE: &str = "#e69f00";
pub(crate) const VERMILION: &str = "#d55e00";
pub(crate) const GREEN: &str = "#009e73";
pub(crate) const PURPLE: &str = "#cc79a7";
const SKY: &str = "#56b4e9";
pub(crate) const PAPER: &str = "white";
/// The colour of text and axes, for pictures that others draw in the same look.
pub const INK: &str = "#1a1a1a";
pub(crate) const MUTED_INK: &str = "#555555";
/// The colour of the grid, light enough to stay behind every series.
pub const GRID: &str = "#e4e4e4";

/// The colours of series, in the order that keeps them easiest to distinguish. Yellow is left out:
/// a yellow line is lost on white paper.
pub const SERIES_COLOURS: [&str; 7] = [BLUE, VERMILION, GREEN, ORANGE, PURPLE, INK, SKY];
/// The dashes of series, for prints without colour. One more than colours, so that a series beyond the last colour differs from the first.
const SERIES_DASHES: [Dash; 8] = [
    None,
    DASHED,
    DOTTED,
    Some(&[11.0, 3.0, 2.2, 3.0]),
    Some(&[18.0, 5.0]),
    Some(&[11.0, 3.0, 2.2, 3.0, 2.2, 3.0]),
    Some(&[4.5, 4.5]),
    Some(&[18.0, 4.0, 6.0, 4.0]),
];
const DASHED: Dash = Some(&[9.0, 4.0]);
const DOTTED: Dash = Some(&[2.2, 3.0]);
/// Number of the dotted one.
pub(crate) const DOTTED_INDEX: usize = 2;
/// Dashes with gaps as long, a length for each colour: of two lines on top of each other both are seen, whatever their phases.
const EVEN_DASHES: [Dash; 8] = [
    Some(&[10.0, 10.0]),
    Some(&[8.0, 8.0]),
    Some(&[5.5, 5.5]),
    Some(&[13.0, 13.0]),
    Some(&[3.7, 3.7]),
    Some(&[6.7, 6.7]),
    Some(&[16.0, 16.0]),
    Some(&[2.6, 2.6]),
];
/// Looks of one kind before they repeat: dashes or shapes times colours.
pub(crate) const LOOKS: usize = SERIES_DASHES.len() * SERIES_COLOURS.len();

/// Lengths of dashes and gaps by turns, px; `None` is a solid line.
pub(crate) type Dash = Option<&'static [f64]>;

/// The number of the dash or shape, and of the colour, of the look `further` places down the line: first all of one colour.
pub(crate) const fn further_look(style: usize, colour: usize, further: usize) -> (usize, usize) {
    let styles = SERIES_DASHES.len();
    (style + further % styles, colour + further / styles)
}

/// The colour of a series.
pub(crate) fn series_colour(index: usize) -> &'static str {
    SERIES_COLOURS[index % SERIES_COLOURS.len()]
}

/// The dash of a series that has no other.
pub(crate) fn series_dash(index: usize) -> Dash {
    SERIES_DASHES[index % SERIES_DASHES.len()]
}

/// One with gaps as long as its dashes.
pub(crate) fn even_dash(index: usize) -> Dash {
    EVEN_DASHES[index % EVEN_DASHES.len()]
}

/// Colour, width in px and dash of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stroke {
    pub(crate) colour: &'static str,
    pub(crate) width: f64,
    pub(crate) dash: Dash,
}

impl Stroke {
    pub(crate) const fn solid(colour: &'static str, width: f64) -> Self {
        Self {
            colour,
            width,
            dash: None,
        }
    }
}

/// Sizes of a panel's text and of the space around its box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sizes {
    /// Font sizes of captions and axis labels, and of tick labels.
    pub(crate) label: u32,
    pub(crate) tick: u32,
    /// Space between the edges of a panel and its box: on the left at least, if it has a label; below with a label and without.
    pub(crate) left: f64,
    pub(crate) right: f64,
    pub(crate) top: f64,
    pub(crate) bottom: f64,
    pub(crate) bottom_bare: f64,
    pub(crate) tick_length: f64,
    pub(crate) minor_tick_length: f64,
    /// Lines and markers of a series.
    pub(crate) series_width: f64,
    pub(crate) marker_radius: f64,
    /// Least width of a panel: on a narrower page fewer panels stand side by side.
    pub(crate) least_width: f64,
}

/// One or two panels in a row.
pub(crate) const LARGE: Sizes = Sizes {
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
    least_width: 300.0,
};

/// Three panels in a row, or more.
pub(crate) const SMALL: Sizes = Sizes {
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
    least_width: 170.0,
};

/// Width of a text in px: an estimate by classes of letters of `DejaVu Sans`, on the wide side.
pub(crate) fn text_width(text: &str, size: u32) -> f64 {
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
/// fit at the smallest size has an ellipsis in its middle.
pub(crate) fn fit(text: &str, size: u32, width: f64) -> (String, u32) {
    fit_between(text, SMALLEST_SIZE..=size, width)
}

/// Fits a text as [`fit`] does, between two sizes.
pub(crate) fn fit_between(text: &str, sizes: RangeInclusive<u32>, width: f64) -> (String, u32) {
    let least = *sizes.start();
    let fitting = sizes.rev().find(|&size| text_width(text, size) <= width);
    match fitting {
        Some(size) => (text.to_owned(), size),
        None => (cut(text, least, width), least),
    }
}

/// The text in one line, or in as many of the smallest size as it needs, broken at ` · ` or, where a part is too long for a
/// line, at a space; a word that has no room is cut. Nothing has no line.
pub(crate) fn wrapped(text: &str, sizes: RangeInclusive<u32>, width: f64) -> Vec<(String, u32)> {
    let least = *sizes.start();
    if text.is_empty() {
        return Vec::new();
    }
    if text_width(text, least) <= width {
        return vec![fit_between(text, sizes, width)];
    }
    let mut lines: Vec<String> = Vec::new();
    let parts = text.split_inclusive(" · ").flat_map(|part| {
        let part = part.trim_end();
        if text_width(part, least) <= width {
            vec![part]
        } else {
            part.split(' ').collect()
        }
    });
    for word in parts {
        match lines.last_mut() {
            Some(line) if text_width(&format!("{line} {word}"), least) <= width => {
                *line = format!("{line} {word}");
            }
            _ => lines.push(word.to_owned()),
        }
    }
    let lines = lines.iter();
    lines
        .map(|line| fit_between(line.trim_end_matches(" ·"), least..=least, width))
        .collect()
}

/// Part of a text, from both its ends, that has room beside an ellipsis.
fn cut(text: &str, size: u32, width: f64) -> String {
    let letters: Vec<char> = text.chars().collect();
    let (mut head, mut tail) = (0, letters.len());
    let mut used = text_width("…", size);
    while head < tail {
        let is_head = head <= letters.len() - tail;
        let next = letters[if is_head { head } else { tail - 1 }];
        used += text_width(next.encode_utf8(&mut [0; 4]), size);
        if used > width {
            break;
        }
        if is_head {
            head += 1;
        } else {
            tail -= 1;
        }
    }
    let ends = letters[..head].iter().chain(&['…']).chain(&letters[tail..]);
    ends.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_text_shrinks_and_then_is_cut_but_never_wider_than_its_room() {
        assert_eq!(fit("short", 20, 400.0), ("short".to_owned(), 20));
        let (text, size) = fit(&"x".repeat(50), 20, 400.0);
        assert_eq!((text.chars().count(), size < 20), (50, true));
        for (long, least) in [("x".repeat(500), 11), ("ab".repeat(30) + ".csv", 16)] {
            let (text, size) = fit_between(&long, least..=20, 400.0);
            assert!(text_width(&text, size) <= 400.0);
            // It begins and ends as before.
            let (head, tail) = text.split_once('…').expect("it is cut");
            assert!(size == least && long.starts_with(head) && long.ends_with(tail));
            assert!((head.len() - tail.len()) < 2 && tail.len() > 10, "{text}");
        }
    }
}
