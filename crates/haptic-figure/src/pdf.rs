//! A drawing as a page of PDF, of the paths that its pixels are painted by.
//!
//! Text is outlines, so no font can be missing. The file has no date: the same picture is the same bytes.

use miniz_oxide::deflate::compress_to_vec_zlib;
use pdf_writer::types::LineJoinStyle;
use pdf_writer::writers::ExtGraphicsState;
use pdf_writer::{Content, Filter, Name, Pdf, Rect, Ref};
use tiny_skia::{Color, FillRule, LineJoin, Mask, Path, PathSegment, Point, Transform};

use crate::curve::AREA_OPACITY;
use crate::pixels::{MITER_LIMIT, Surface, Surroundings, draw};
use crate::style::Stroke;
use crate::{FigureError, Picture};

/// Name of the state in which areas are filled.
const SEEN_THROUGH: Name<'static> = Name(b"A");
const POINTS_PER_METRE: f64 = 72.0 / 0.0254;
/// A pixel of CSS is 1/96 of an inch.
const POINTS_PER_PX: f64 = 0.75;

impl Picture {
    /// The picture as a PDF of one page, with its text as outlines.
    ///
    /// # Errors
    /// If the drawing cannot be turned into paths, which would be a defect of this crate.
    pub fn pdf(&self) -> Result<Vec<u8>, FigureError> {
        let drawing = &self.drawing;
        let printed = drawing.printed_m.map(|width_m| POINTS_PER_METRE * width_m);
        let scale = printed.map_or(POINTS_PER_PX, |width| width / drawing.width) as f32;
        let size = [drawing.width, drawing.height].map(|length| scale * length as f32);
        // From the upper left corner downwards.
        let transform = Transform::from_row(scale, 0.0, 0.0, -scale, 0.0, size[1]);
        let sheet = draw(drawing, Sheet(Content::new()), transform)?;
        let [catalog, pages, page, content] = [1, 2, 3, 4].map(Ref::new);
        let mut pdf = Pdf::new();
        pdf.catalog(catalog).pages(pages);
        pdf.pages(pages).kids([page]).count(1);
        let mut page = pdf.page(page);
        page.parent(pages).contents(content);
        page.media_box(Rect::new(0.0, 0.0, size[0], size[1]));
        let mut resources = page.resources();
        // Areas are all that is seen through, and all alike.
        let mut states = resources.ext_g_states();
        let mut state = states.insert(SEEN_THROUGH).start::<ExtGraphicsState<'_>>();
        state.non_stroking_alpha(AREA_OPACITY as f32);
        drop(state);
        drop(states);
        drop(resources);
        drop(page);
        let packed = compress_to_vec_zlib(&sheet.0.finish(), 6);
        pdf.stream(content, &packed).filter(Filter::FlateDecode);
        Ok(pdf.finish())
    }
}

struct Sheet(Content);

impl Sheet {
    /// Saves the state, and goes to a place and into its box.
    fn begin(&mut self, around: Surroundings<'_>) {
        let to = around.transform;
        let content = self.0.save_state();
        content.transform([to.sx, to.ky, to.kx, to.sy, to.tx, to.ty]);
        if let Some(edges) = around.edges {
            content.rect(edges.x(), edges.y(), edges.width(), edges.height());
            content.clip_nonzero().end_path();
        }
    }

    fn path(&mut self, path: &Path) {
        let content = &mut self.0;
        let mut from = Point::zero();
        for segment in path.segments() {
            match segment {
                PathSegment::MoveTo(to) => content.move_to(to.x, to.y),
                PathSegment::LineTo(to) => content.line_to(to.x, to.y),
                // As a cubic, whose arms are two thirds as long.
                PathSegment::QuadTo(arm, to) => {
                    let towards = |end: f32, arm: f32| end + 2.0 / 3.0 * (arm - end);
                    let [first, second] = [from, to]
                        .map(|end| Point::from_xy(towards(end.x, arm.x), towards(end.y, arm.y)));
                    content.cubic_to(first.x, first.y, second.x, second.y, to.x, to.y)
                }
                PathSegment::CubicTo(first, second, to) => {
                    content.cubic_to(first.x, first.y, second.x, second.y, to.x, to.y)
                }
                PathSegment::Close => content.close_path(),
            };
            if let PathSegment::MoveTo(to)
            | PathSegment::LineTo(to)
            | PathSegment::QuadTo(_, to)
            | PathSegment::CubicTo(_, _, to) = segment
            {
                from = to;
            }
        }
    }
}

impl Surface for Sheet {
    fn mask(&self, _: &Path, _: Transform) -> Option<Mask> {
        None
    }

    fn fill(&mut self, path: &Path, colour: Color, around: Surroundings<'_>) {
        self.begin(around);
        if colour.alpha() < 1.0 {
            self.0.set_parameters(SEEN_THROUGH);
        }
        (self.0).set_fill_rgb(colour.red(), colour.green(), colour.blue());
        self.path(path);
        match around.rule {
            FillRule::Winding => self.0.fill_nonzero(),
            FillRule::EvenOdd => self.0.fill_even_odd(),
        };
        self.0.restore_state();
    }

    fn stroke(&mut self, path: &Path, stroke: Stroke, colour: Color, around: Surroundings<'_>) {
        self.begin(around);
        let content = &mut self.0;
        content.set_stroke_rgb(colour.red(), colour.green(), colour.blue());
        content.set_miter_limit(MITER_LIMIT);
        content.set_line_width(stroke.width as f32);
        let dash = stroke.dash.unwrap_or_default().iter();
        content.set_dash_pattern(dash.map(|length| *length as f32), 0.0);
        if around.join == LineJoin::Round {
            content.set_line_join(LineJoinStyle::RoundJoin);
        }
        self.path(path);
        self.0.stroke().restore_state();
    }
}
