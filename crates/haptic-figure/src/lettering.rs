//! Lines of text as outlines, set in the font of all pictures.
//!
//! Letters stand from left to right, each by itself, with the font's kerning: no ligatures, no joined or composed
//! letters, no scripts from right to left. A letter that the font does not have is drawn as an empty box. Spaces are
//! as in SVG: none at the ends, and one of several.

use tiny_skia::{Path, PathBuilder};
use ttf_parser::{Face, GlyphId, OutlineBuilder};

use crate::FigureError;
use crate::drawing::{Anchor, Text};
use crate::superscript::{LOWER_EM, Part, RAISED_SIZE, parts};

/// Only the bundled font: a picture must not depend on what a machine has installed. Licence in `assets/LICENSE-DejaVuSans.txt`.
const FONT: &[u8] = include_bytes!("../assets/DejaVuSans.ttf");

/// The font, ready to set lines.
pub(crate) struct Lettering(Face<'static>);

/// A letter at its place on the line: lengths in px, `raise` upwards.
struct Letter {
    glyph: GlyphId,
    x: f32,
    raise: f32,
    /// Pixels per unit of the font.
    scale: f32,
}

impl Lettering {
    pub(crate) fn new() -> Result<Self, FigureError> {
        let face = Face::parse(FONT, 0).map_err(|error| FigureError::Render(error.to_string()))?;
        Ok(Self(face))
    }

    /// The outlines of a line whose anchor is at the origin; `None` if there is nothing to see on it.
    pub(crate) fn line(&self, text: &Text) -> Option<Path> {
        let (letters, width) = self.place(&text.content, text.size as f32);
        let start = match text.anchor {
            Anchor::Start => 0.0,
            Anchor::Middle => -width / 2.0,
            Anchor::End => -width,
        };
        let mut path = PathBuilder::new();
        for letter in letters {
            let mut pen = Pen {
                path: &mut path,
                x: start + letter.x,
                y: -letter.raise,
                scale: letter.scale,
            };
            // `None` is a letter without outline, as a space.
            let _ = self.0.outline_glyph(letter.glyph, &mut pen);
        }
        path.finish()
    }

    /// The letters of a line from its start on, and its width.
    fn place(&self, content: &str, size: f32) -> (Vec<Letter>, f32) {
        let mut letters: Vec<Letter> = Vec::new();
        let mut x = 0.0;
        // A space counts once another letter follows.
        let mut space = None;
        for part in parts(content) {
            let (part, share, raise) = match part {
                Part::Level(part) => (part, 1.0, 0.0),
                Part::Raised(part) => (part, RAISED_SIZE, LOWER_EM),
            };
            let scale = share as f32 * size / f32::from(self.0.units_per_em());
            for letter in part.chars() {
                let here = (scale, raise as f32 * size);
                if letter == ' ' {
                    space = space.or((!letters.is_empty()).then_some(here));
                    continue;
                }
                let spaced = space.take().map(|place| (' ', place));
                for (letter, (scale, raise)) in spaced.into_iter().chain([(letter, here)]) {
                    let glyph = self.0.glyph_index(letter).unwrap_or(GlyphId(0));
                    if let Some(before) = letters.last() {
                        x += before.scale * f32::from(self.kerning(before.glyph, glyph));
                    }
                    letters.push(Letter {
                        glyph,
                        x,
                        raise,
                        scale,
                    });
                    x += scale * f32::from(self.0.glyph_hor_advance(glyph).unwrap_or(0));
                }
            }
        }
        (letters, x)
    }

    /// Distance by which a pair of letters is to stand wider, in units of the font.
    fn kerning(&self, left: GlyphId, right: GlyphId) -> i16 {
        let tables = self.0.tables().kern.iter();
        let mut subtables = tables
            .flat_map(|table| table.subtables)
            .filter(|subtable| subtable.horizontal && !subtable.variable);
        let pair = subtables.find_map(|subtable| subtable.glyphs_kerning(left, right));
        pair.unwrap_or(0)
    }
}

/// Draws outlines, whose y points upwards in the units of the font, at a place on a path, px.
struct Pen<'a> {
    path: &'a mut PathBuilder,
    x: f32,
    y: f32,
    scale: f32,
}

impl Pen<'_> {
    fn at(&self, x: f32, y: f32) -> (f32, f32) {
        (self.x + self.scale * x, self.y - self.scale * y)
    }
}

impl OutlineBuilder for Pen<'_> {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.at(x1, y1), self.at(x, y));
        self.path.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2), (x, y)) = (self.at(x1, y1), self.at(x2, y2), self.at(x, y));
        self.path.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.path.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Left edge, right edge, top and bottom of what is seen of a line.
    fn bounds(text: Text) -> [f32; 4] {
        let lettering = Lettering::new().expect("reads the font");
        let bounds = lettering.line(&text).expect("has ink").bounds();
        [bounds.left(), bounds.right(), bounds.top(), bounds.bottom()]
    }

    /// Asserts a width in units of the font.
    fn assert_wide(content: &str, units: f32) {
        let lettering = Lettering::new().expect("reads the font");
        let width = lettering.place(content, 2048.0).1;
        assert!((width - units).abs() < 0.1, "`{content}`: {width}");
    }

    #[test]
    fn widths_are_those_of_the_font() {
        // `DejaVu Sans`: 2048 units to the em, digits of 1303, a space of 651, W of 2025; a pair `AV` 131 closer.
        assert_wide("0123456789", 10.0 * 1303.0);
        assert_wide("W 0", 2025.0 + 651.0 + 1303.0);
        assert_wide("AV", 2.0 * 1401.0 - 131.0);
        assert_wide("^{0}", 0.7 * 1303.0);
    }

    #[test]
    fn spaces_count_once_and_not_at_the_ends() {
        for spaced in ["0 1", " 0 1 ", "0  1", "0 ^{ }1"] {
            assert_wide(spaced, 2.0 * 1303.0 + 651.0);
        }
        assert_wide("  ", 0.0);
        let lettering = Lettering::new().expect("reads the font");
        assert!(lettering.line(&Text::new(" ", 0.0, 0.0, 9)).is_none());
    }

    #[test]
    fn the_anchor_is_at_the_place() {
        let text = |anchor| Text::new("HIH", 70.0, 80.0, 20).anchored(anchor);
        let [left, right, top, bottom] = bounds(text(Anchor::Start));
        assert!(left > 0.0 && left < 3.0, "{left}");
        assert!(bottom.abs() < 1e-6, "{bottom}");
        // 1493 of 2048 units.
        assert!((top + 20.0 * 1493.0 / 2048.0).abs() < 1e-4, "{top}");
        let middle = bounds(text(Anchor::Middle));
        assert!((middle[0] + middle[1]).abs() < 1e-3, "{middle:?}");
        let end = bounds(text(Anchor::End));
        assert!((end[1] + left).abs() < 1e-3 && (end[0] + right).abs() < 1e-3);
    }

    #[test]
    fn what_is_raised_is_smaller_and_higher() {
        let [_, _, top, bottom] = bounds(Text::new("^{H}", 0.0, 0.0, 100));
        assert!((bottom + 35.0).abs() < 1e-3, "{bottom}");
        assert!((top - bottom + 70.0 * 1493.0 / 2048.0).abs() < 1e-3);
    }

    #[test]
    fn a_letter_that_the_font_lacks_is_seen_as_a_box() {
        let [left, right, top, bottom] = bounds(Text::new("漢", 0.0, 0.0, 20));
        assert!(right - left > 5.0 && bottom - top > 10.0);
        // The width of glyph 0.
        assert_wide("漢字", 2.0 * 1229.0);
    }
}
