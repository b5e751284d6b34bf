//! A drawing as a page of PDF.
//!
//! Text is text, in the part of the included font that it needs: it can be searched and copied, and journals that refuse
//! fonts of type 3 take it. The file has no date, so the same picture is the same bytes.

use miniz_oxide::deflate::compress_to_vec_zlib;
use pdf_writer::types::{CidFontType, FontFlags, LineJoinStyle, SystemInfo, UnicodeCmap};
use pdf_writer::writers::ExtGraphicsState;
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref, Str};
use std::collections::{BTreeMap, BTreeSet};
use subsetter::GlyphRemapper;

use crate::drawing::{Item, Marker, Outline, Rectangle, Ruled, Text};
use crate::lettering::{FONT, Lettering};
use crate::pixels::{MITER_LIMIT, colour};
use crate::style::Stroke;
use crate::thin::Points;
use crate::{FigureError, Picture};

const POINTS_PER_METRE: f64 = 72.0 / 0.0254;
/// A pixel of CSS is 1/96 of an inch.
const POINTS_PER_PX: f64 = 0.75;
/// Ends of the arms of Bézier's quarter of a circle, over its radius.
const QUARTER: f32 = 0.552_284_8;
/// Widths in a PDF are thousandths of the size of the font.
const PER_SIZE: f32 = 1000.0;
const SYSTEM: SystemInfo<'_> = SystemInfo {
    registry: Str(b"Adobe"),
    ordering: Str(b"Identity"),
    supplement: 0,
};
const CATALOG: Ref = Ref::new(1);
const PAGES: Ref = Ref::new(2);
const PAGE: Ref = Ref::new(3);
const CONTENT: Ref = Ref::new(4);
const TYPE0: Ref = Ref::new(5);
const CID: Ref = Ref::new(6);
const DESCRIPTOR: Ref = Ref::new(7);
const FILE: Ref = Ref::new(8);
const UNICODE: Ref = Ref::new(9);

impl Picture {
    /// The picture as a PDF of one page.
    ///
    /// Text is set as in [`Picture::png`](Self::png).
    ///
    /// # Errors
    /// If the drawing cannot be written, which would be a defect of this crate.
    pub fn pdf(&self) -> Result<Vec<u8>, FigureError> {
        let drawing = &self.drawing;
        let printed = drawing.printed_m.map(|width_m| POINTS_PER_METRE * width_m);
        let scale = printed.map_or(POINTS_PER_PX, |width| width / drawing.width) as f32;
        let (width, height) = (drawing.width as f32, drawing.height as f32);
        let mut sheet = Writer {
            content: Content::new(),
            lettering: Lettering::new()?,
            glyphs: GlyphRemapper::new(),
            letters: BTreeMap::new(),
            opacities: BTreeSet::new(),
        };
        // From the upper left corner downwards.
        (sheet.content).transform([scale, 0.0, 0.0, -scale, 0.0, scale * height]);
        sheet.content.set_miter_limit(MITER_LIMIT);
        sheet.items(&drawing.items)?;

        let mut pdf = Pdf::new();
        pdf.catalog(CATALOG).pages(PAGES);
        pdf.pages(PAGES).kids([PAGE]).count(1);
        let mut page = pdf.page(PAGE);
        page.parent(PAGES).contents(CONTENT);
        page.media_box(Rect::new(0.0, 0.0, scale * width, scale * height));
        let mut resources = page.resources();
        resources.fonts().pair(Name(b"F"), TYPE0);
        let mut states = resources.ext_g_states();
        for per_cent in &sheet.opacities {
            let name = format!("A{per_cent}");
            let mut state = states
                .insert(Name(name.as_bytes()))
                .start::<ExtGraphicsState<'_>>();
            state.non_stroking_alpha(*per_cent as f32 / 100.0);
        }
        states.finish();
        resources.finish();
        page.finish();
        sheet.font(&mut pdf)?;
        packed(&mut pdf, CONTENT, &sheet.content.finish());
        Ok(pdf.finish())
    }
}

/// Writes a stream, packed.
fn packed(pdf: &mut Pdf, at: Ref, bytes: &[u8]) {
    let bytes = compress_to_vec_zlib(bytes, 6);
    pdf.stream(at, &bytes).filter(Filter::FlateDecode);
}

struct Writer {
    content: Content,
    lettering: Lettering,
    /// Numbers of the glyphs in the part of the font that is written, and the letters that they stand for.
    glyphs: GlyphRemapper,
    letters: BTreeMap<u16, char>,
    /// Opacities of areas, per cent.
    opacities: BTreeSet<u8>,
}

impl Writer {
    fn items(&mut self, items: &[Item]) -> Result<(), FigureError> {
        items.iter().try_for_each(|item| self.item(item))
    }

    fn item(&mut self, item: &Item) -> Result<(), FigureError> {
        self.content.save_state();
        match item {
            Item::Moved { by, items } => {
                let by = [1.0, 0.0, 0.0, 1.0, by.0 as f32, by.1 as f32];
                self.content.transform(by);
                self.items(items)?;
            }
            Item::Ruled(ruled) => self.ruled(ruled)?,
            Item::Boxed { edges, items, .. } => {
                self.rectangle(*edges);
                self.content.clip_nonzero().end_path();
                self.content.set_line_join(LineJoinStyle::RoundJoin);
                self.items(items)?;
            }
            Item::Curves { pieces, stroke } => {
                self.stroke(*stroke)?;
                self.joined(pieces, false);
                self.content.stroke();
            }
            Item::Area {
                rings,
                colour,
                opacity,
            } => {
                let per_cent = (100.0 * opacity).round() as u8;
                self.opacities.insert(per_cent);
                let name = format!("A{per_cent}");
                self.content.set_parameters(Name(name.as_bytes()));
                self.fill_in(colour)?;
                self.joined(rings, true);
                self.content.fill_even_odd();
            }
            Item::Markers(middles, marker) => self.markers(middles, *marker)?,
            Item::Text(text) => self.text(text)?,
        }
        self.content.restore_state();
        Ok(())
    }

    fn ruled(&mut self, ruled: &Ruled) -> Result<(), FigureError> {
        self.stroke(Stroke::solid(ruled.colour, ruled.width))?;
        if let Some(border) = ruled.border {
            self.rectangle(border);
        }
        let lines: Vec<Points> = ruled.lines.iter().map(|(a, b)| vec![*a, *b]).collect();
        self.joined(&lines, false);
        self.content.stroke();
        Ok(())
    }

    fn rectangle(&mut self, at: Rectangle) {
        let [x, y, width, height] = [at.x, at.y, at.width, at.height].map(|side| side as f32);
        self.content.rect(x, y, width, height);
    }

    fn fill_in(&mut self, name: &str) -> Result<(), FigureError> {
        let colour = colour(name)?;
        (self.content).set_fill_rgb(colour.red(), colour.green(), colour.blue());
        Ok(())
    }

    fn stroke(&mut self, stroke: Stroke) -> Result<(), FigureError> {
        let colour = colour(stroke.colour)?;
        (self.content).set_stroke_rgb(colour.red(), colour.green(), colour.blue());
        self.content.set_line_width(stroke.width as f32);
        if let Some(dash) = stroke.dash {
            let lengths = dash.iter().map(|length| *length as f32);
            self.content.set_dash_pattern(lengths, 0.0);
        }
        Ok(())
    }

    /// Straight lines through the points of each piece.
    fn joined(&mut self, pieces: &[Points], closed: bool) {
        for piece in pieces {
            for (index, (x, y)) in piece.iter().enumerate() {
                match index {
                    0 => self.content.move_to(*x as f32, *y as f32),
                    _ => self.content.line_to(*x as f32, *y as f32),
                };
            }
            if closed {
                self.content.close_path();
            }
        }
    }

    /// All rims, and then all insides.
    fn markers(&mut self, middles: &Points, marker: Marker) -> Result<(), FigureError> {
        self.stroke(marker.rim)?;
        self.outlines(middles, marker);
        self.content.stroke();
        if let Some(inside) = marker.inside {
            self.fill_in(inside)?;
            self.outlines(middles, marker);
            self.content.fill_nonzero();
        }
        Ok(())
    }

    fn outlines(&mut self, middles: &Points, marker: Marker) {
        match marker.shape.outline(marker.radius) {
            Outline::Circle(r) => {
                let (r, arm) = (r as f32, QUARTER * r as f32);
                for (x, y) in middles.iter().map(|(x, y)| (*x as f32, *y as f32)) {
                    self.content.move_to(x + r, y);
                    // From quarter to quarter: where one ends, and the direction there.
                    for (dx, dy) in [(0.0, 1.0), (-1.0, 0.0), (0.0, -1.0), (1.0, 0.0)] {
                        let (from, to) = ((x + r * dy, y - r * dx), (x + r * dx, y + r * dy));
                        let first = (from.0 + arm * dx, from.1 + arm * dy);
                        let second = (to.0 + arm * dy, to.1 - arm * dx);
                        (self.content).cubic_to(first.0, first.1, second.0, second.1, to.0, to.1);
                    }
                    self.content.close_path();
                }
            }
            Outline::Corners(corners) => {
                let around = |(x, y): &(f64, f64)| -> Points {
                    let corners = corners.iter();
                    corners
                        .map(|(dx, dy)| (x + dx / 10.0, y + dy / 10.0))
                        .collect()
                };
                let rings: Vec<Points> = middles.iter().map(around).collect();
                self.joined(&rings, true);
            }
        }
    }

    /// Each letter at its own place, as in the pixels.
    fn text(&mut self, text: &Text) -> Result<(), FigureError> {
        self.fill_in(text.colour)?;
        let (letters, start) = self.lettering.anchored(text);
        let (x, y) = (text.place.0 as f32, text.place.1 as f32);
        self.content.begin_text();
        for letter in letters {
            let along = start + letter.x;
            let matrix = match text.upright {
                false => [1.0, 0.0, 0.0, -1.0, x + along, y - letter.raise],
                true => [0.0, -1.0, -1.0, 0.0, x - letter.raise, y - along],
            };
            let glyph = self.glyphs.remap(letter.glyph.0);
            self.letters.insert(glyph, letter.letter);
            self.content
                .set_font(Name(b"F"), self.lettering.size(letter.scale));
            self.content.set_text_matrix(matrix);
            self.content.show(Str(&glyph.to_be_bytes()));
        }
        self.content.end_text();
        Ok(())
    }

    /// The part of the font that the texts need, and the letters of its glyphs.
    fn font(&self, pdf: &mut Pdf) -> Result<(), FigureError> {
        let part = subsetter::subset(FONT, 0, &self.glyphs);
        let part = part.map_err(|error| FigureError::Render(error.to_string()))?;
        let glyphs: Vec<u16> = self.glyphs.remapped_gids().collect();
        // Parts of a font have names of their own, of six letters.
        let sum = glyphs.iter().fold(0_u32, |sum, glyph| {
            sum.wrapping_mul(31).wrapping_add(u32::from(*glyph))
        });
        let tag = (0..6).map(|n| char::from(b'A' + (sum / 26_u32.pow(n) % 26) as u8));
        let name = format!("{}+DejaVuSans", tag.collect::<String>());
        let name = Name(name.as_bytes());
        let mut font = pdf.type0_font(TYPE0);
        font.base_font(name)
            .encoding_predefined(Name(b"Identity-H"));
        font.descendant_font(CID).to_unicode(UNICODE);
        font.finish();
        let mut cid = pdf.cid_font(CID);
        cid.subtype(CidFontType::Type2)
            .base_font(name)
            .system_info(SYSTEM);
        cid.font_descriptor(DESCRIPTOR)
            .cid_to_gid_map_predefined(Name(b"Identity"));
        let widths = glyphs
            .iter()
            .map(|glyph| PER_SIZE * self.lettering.advance(*glyph));
        cid.widths().consecutive(0, widths);
        cid.finish();
        let [ascent, descent, capital] = self.lettering.heights().map(|height| PER_SIZE * height);
        let mut descriptor = pdf.font_descriptor(DESCRIPTOR);
        descriptor
            .name(name)
            .flags(FontFlags::SYMBOLIC)
            .font_file2(FILE);
        descriptor.bbox(Rect::new(-PER_SIZE, descent, 2.0 * PER_SIZE, ascent));
        descriptor.italic_angle(0.0).ascent(ascent).descent(descent);
        descriptor.cap_height(capital).stem_v(80.0);
        descriptor.finish();
        packed(pdf, FILE, &part);
        let mut unicode = UnicodeCmap::new(Name(b"Letters"), SYSTEM);
        for (glyph, letter) in &self.letters {
            unicode.pair(*glyph, *letter);
        }
        packed(pdf, UNICODE, &unicode.finish());
        Ok(())
    }
}
