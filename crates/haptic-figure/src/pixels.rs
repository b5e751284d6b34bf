//! A drawing as pixels.

use png::{BitDepth, ColorType, Encoder, EncodingError, Filter, PixelDimensions, Unit};
use tiny_skia::{
    Color, FillRule, LineJoin, Mask, Paint, Path, PathBuilder, Pixmap, Rect, StrokeDash, Transform,
};

use crate::drawing::{Drawing, Item, Outline, Rectangle, Ruled, Shape, Text};
use crate::lettering::Lettering;
use crate::style::{PAPER, Stroke};
use crate::thin::Points;
use crate::{FigureError, Picture};

/// Corners sharper than this are cut off, as in SVG: length of the corner over the width of its line.
pub(crate) const MITER_LIMIT: f32 = 4.0;

/// The drawing with `scale` pixels to a CSS pixel.
pub(crate) fn paint(drawing: &Drawing, scale: u32) -> Result<Pixmap, FigureError> {
    let across = |length: f64| scale * length.ceil() as u32;
    let pixels = Pixmap::new(across(drawing.width), across(drawing.height));
    let mut pixels =
        pixels.ok_or_else(|| FigureError::Render("its size is not positive".to_owned()))?;
    pixels.fill(colour(PAPER)?);
    draw(
        drawing,
        pixels,
        Transform::from_scale(scale as f32, scale as f32),
    )
}

/// Draws on a surface that places are brought to by a transform.
pub(crate) fn draw<S: Surface>(
    drawing: &Drawing,
    surface: S,
    transform: Transform,
) -> Result<S, FigureError> {
    let mut canvas = Canvas {
        surface,
        lettering: Lettering::new()?,
    };
    canvas.items(&drawing.items, Surroundings::of_paper(transform))?;
    Ok(canvas.surface)
}

/// Paths are all that pixels and a page of PDF need.
pub(crate) trait Surface {
    /// Mask that hides all outside a box; `None` where [`Surroundings::edges`] is enough.
    fn mask(&self, edges: &Path, transform: Transform) -> Option<Mask>;
    fn fill(&mut self, path: &Path, colour: Color, around: Surroundings<'_>);
    fn stroke(&mut self, path: &Path, stroke: Stroke, colour: Color, around: Surroundings<'_>);
}

impl Surface for Pixmap {
    fn mask(&self, edges: &Path, transform: Transform) -> Option<Mask> {
        let mut mask = Mask::new(self.width(), self.height())?;
        mask.fill_path(edges, FillRule::Winding, true, transform);
        Some(mask)
    }

    fn fill(&mut self, path: &Path, colour: Color, around: Surroundings<'_>) {
        self.fill_path(
            path,
            &ink(colour),
            around.rule,
            around.transform,
            around.mask,
        );
    }

    fn stroke(&mut self, path: &Path, stroke: Stroke, colour: Color, around: Surroundings<'_>) {
        let dash = stroke.dash.and_then(|lengths| {
            let lengths = lengths.iter().map(|length| *length as f32).collect();
            StrokeDash::new(lengths, 0.0)
        });
        let line = tiny_skia::Stroke {
            width: stroke.width as f32,
            miter_limit: MITER_LIMIT,
            line_join: around.join,
            dash,
            ..tiny_skia::Stroke::default()
        };
        self.stroke_path(path, &ink(colour), &line, around.transform, around.mask);
    }
}

struct Canvas<S> {
    surface: S,
    lettering: Lettering,
}

/// Settings for all that is drawn at one place.
#[derive(Clone, Copy)]
pub(crate) struct Surroundings<'a> {
    pub(crate) transform: Transform,
    /// Visible area, as a mask and as a box; `None` is everywhere.
    mask: Option<&'a Mask>,
    pub(crate) edges: Option<Rect>,
    pub(crate) join: LineJoin,
    pub(crate) rule: FillRule,
}

impl Surroundings<'_> {
    fn of_paper(transform: Transform) -> Self {
        Self {
            transform,
            mask: None,
            edges: None,
            join: LineJoin::Miter,
            rule: FillRule::Winding,
        }
    }
}

impl<S: Surface> Canvas<S> {
    fn items(&mut self, items: &[Item], around: Surroundings<'_>) -> Result<(), FigureError> {
        items.iter().try_for_each(|item| self.item(item, around))
    }

    fn item(&mut self, item: &Item, around: Surroundings<'_>) -> Result<(), FigureError> {
        match item {
            Item::Moved { by, items } => {
                let transform = around.transform.pre_translate(by.0 as f32, by.1 as f32);
                let around = Surroundings {
                    transform,
                    ..around
                };
                self.items(items, around)
            }
            Item::Ruled(ruled) => self.ruled(ruled, around),
            Item::Boxed { edges, items, .. } => self.boxed(*edges, items, around),
            Item::Curves { pieces, stroke } => self.stroke(joined(pieces, false), *stroke, around),
            Item::Area {
                rings,
                colour,
                opacity,
            } => self.fill(joined(rings, true), colour, *opacity, around),
            Item::Markers(middles, marker) => {
                let path = markers(middles, marker.shape, marker.radius);
                self.stroke(path.clone(), marker.rim, around)?;
                // Over all rims: those of crowded markers would hide each other's colour.
                match marker.inside {
                    Some(inside) => self.fill(path, inside, 1.0, around),
                    None => Ok(()),
                }
            }
            Item::Text(text) => self.text(text, around),
        }
    }

    fn ruled(&mut self, ruled: &Ruled, around: Surroundings<'_>) -> Result<(), FigureError> {
        let stroke = Stroke::solid(ruled.colour, ruled.width);
        if let Some(border) = ruled.border.and_then(rectangle) {
            self.stroke(Some(PathBuilder::from_rect(border)), stroke, around)?;
        }
        // One by one: where two cross, each adds its own ink, as in SVG.
        ruled.lines.iter().try_for_each(|&(from, to)| {
            let line = joined(&[vec![from, to]], false);
            self.stroke(line, stroke, around)
        })
    }

    fn boxed(
        &mut self,
        edges: Rectangle,
        items: &[Item],
        around: Surroundings<'_>,
    ) -> Result<(), FigureError> {
        let Some(edges) = rectangle(edges) else {
            return Ok(());
        };
        let path = PathBuilder::from_rect(edges);
        let mask = self.surface.mask(&path, around.transform);
        let inside = Surroundings {
            mask: mask.as_ref(),
            edges: Some(edges),
            join: LineJoin::Round,
            rule: FillRule::EvenOdd,
            ..around
        };
        self.items(items, inside)
    }

    fn text(&mut self, text: &Text, around: Surroundings<'_>) -> Result<(), FigureError> {
        let (x, y) = text.place;
        let mut transform = around.transform.pre_translate(x as f32, y as f32);
        if text.upright {
            transform = transform.pre_concat(Transform::from_row(0.0, -1.0, 1.0, 0.0, 0.0, 0.0));
        }
        let letters = self.lettering.line(text);
        let around = Surroundings {
            transform,
            ..around
        };
        self.fill(letters, text.colour, 1.0, around)
    }

    fn fill(
        &mut self,
        path: Option<Path>,
        name: &str,
        opacity: f64,
        around: Surroundings<'_>,
    ) -> Result<(), FigureError> {
        let Some(path) = path else { return Ok(()) };
        let mut colour = colour(name)?;
        colour.apply_opacity(opacity as f32);
        self.surface.fill(&path, colour, around);
        Ok(())
    }

    fn stroke(
        &mut self,
        path: Option<Path>,
        stroke: Stroke,
        around: Surroundings<'_>,
    ) -> Result<(), FigureError> {
        let Some(path) = path else { return Ok(()) };
        (self.surface).stroke(&path, stroke, colour(stroke.colour)?, around);
        Ok(())
    }
}

/// Straight lines through the points of each piece; `None` without a point.
fn joined(pieces: &[Points], closed: bool) -> Option<Path> {
    let mut path = PathBuilder::new();
    for piece in pieces {
        for (index, (x, y)) in piece.iter().enumerate() {
            match index {
                0 => path.move_to(*x as f32, *y as f32),
                _ => path.line_to(*x as f32, *y as f32),
            }
        }
        if closed {
            path.close();
        }
    }
    path.finish()
}

fn markers(middles: &[(f64, f64)], shape: Shape, radius: f64) -> Option<Path> {
    let outline = shape.outline(radius);
    let mut path = PathBuilder::new();
    for (x, y) in middles {
        match &outline {
            Outline::Circle { radius, handle } => circle(&mut path, (*x, *y), *radius, *handle),
            Outline::Corners(corners) => {
                for (index, (dx, dy)) in corners.iter().enumerate() {
                    let corner = ((x + dx / 10.0) as f32, (y + dy / 10.0) as f32);
                    match index {
                        0 => path.move_to(corner.0, corner.1),
                        _ => path.line_to(corner.0, corner.1),
                    }
                }
                path.close();
            }
        }
    }
    path.finish()
}

fn circle(path: &mut PathBuilder, (x, y): (f64, f64), radius: f64, handle: f64) {
    let at = |dx: f64, dy: f64| ((x + dx) as f32, (y + dy) as f32);
    let start = at(-radius, 0.0);
    path.move_to(start.0, start.1);
    // Each quarter begins in a direction and ends in the next.
    for (along, out) in [
        ((0.0, -1.0), (-1.0, 0.0)),
        ((1.0, 0.0), (0.0, -1.0)),
        ((0.0, 1.0), (1.0, 0.0)),
        ((-1.0, 0.0), (0.0, 1.0)),
    ] {
        let place = |a: f64, o: f64| at(a * along.0 + o * out.0, a * along.1 + o * out.1);
        let (first, second, end) = (
            place(handle, radius),
            place(radius, handle),
            place(radius, 0.0),
        );
        path.cubic_to(first.0, first.1, second.0, second.1, end.0, end.1);
    }
    path.close();
}

/// `None` if it has no area.
fn rectangle(at: Rectangle) -> Option<Rect> {
    let [x, y, width, height] = [at.x, at.y, at.width, at.height].map(|side| side as f32);
    Rect::from_xywh(x, y, width, height)
}

fn ink(colour: Color) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color(colour);
    paint
}

/// The colour that SVG calls `white` or `#rrggbb`.
fn colour(name: &str) -> Result<Color, FigureError> {
    let digits = match name {
        "white" => Some("ffffff"),
        name => name.strip_prefix('#').filter(|digits| digits.len() == 6),
    };
    let number = digits.and_then(|digits| u32::from_str_radix(digits, 16).ok());
    let [_, red, green, blue] = number
        .ok_or_else(|| FigureError::Render(format!("`{name}` is not a colour: write `#rrggbb`")))?
        .to_be_bytes();
    Ok(Color::from_rgba8(red, green, blue, u8::MAX))
}

/// PNG pixels per CSS pixel: 1760 pixels, 250 per inch on a page 7 inches wide.
const SCALE: u32 = 2;
/// Least pixels per CSS pixel of a picture whose width is given, and least pixels per metre: 300 per inch.
const PRINT_SCALE: f64 = 4.0;
const PER_METRE: f64 = 300.0 / 0.0254;

impl Picture {
    /// The picture as PNG bytes, two pixels for each unit of the SVG; of a width on paper four, and at least 300 to the inch.
    ///
    /// Text is set letter by letter in `DejaVu Sans`, with its kerning. A letter that the font does not have is an
    /// empty box, and scripts that join letters or run from right to left are for the SVG and its viewer.
    ///
    /// # Errors
    /// If the drawing cannot be turned into pixels, which would be a defect of this crate.
    pub fn png(&self) -> Result<Vec<u8>, FigureError> {
        let (width, printed_m) = (self.drawing.width, self.drawing.printed_m);
        let scale = printed_m.map_or(SCALE, |width_m| {
            (PER_METRE * width_m / width).ceil().max(PRINT_SCALE) as u32
        });
        let pixels = paint(&self.drawing, scale)?;
        encode(pixels, printed_m).map_err(|error| FigureError::Render(error.to_string()))
    }
}

/// The pixels as PNG. `Pixmap::encode_png` would copy them all first: 10 MB of the memory of a run.
fn encode(pixels: Pixmap, width_m: Option<f64>) -> Result<Vec<u8>, EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, pixels.width(), pixels.height());
    encoder.set_color(ColorType::Rgba);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_pixel_dims(width_m.map(|width_m| {
        let per_metre = (f64::from(pixels.width()) / width_m).round() as u32;
        PixelDimensions {
            xppu: per_metre,
            yppu: per_metre,
            unit: Unit::Meter,
        }
    }));
    // Flat colours: a third of the time of the adaptive filter, and a smaller file.
    encoder.set_filter(Filter::NoFilter);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&pixels.take_demultiplied())?;
    writer.finish()?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::{Anchor, Marker};

    const RED: &str = "#ff0000";
    const SEEN: [u8; 3] = [255, 0, 0];
    const WHITE: [u8; 3] = [255; 3];

    /// The items on paper of 20 px by 20 px, and the colour at a place of it.
    fn painted(items: Vec<Item>) -> impl Fn(f64, f64) -> [u8; 3] {
        let mut drawing = Drawing::new(20.0, 20.0);
        drawing.items = items;
        let pixels = paint(&drawing, 2).expect("paints");
        move |x, y| {
            let pixel = pixels.pixel((2.0 * x) as u32, (2.0 * y) as u32);
            let pixel = pixel.expect("is on the paper").demultiply();
            [pixel.red(), pixel.green(), pixel.blue()]
        }
    }

    fn line(from: (f64, f64), to: (f64, f64), dash: Option<&'static [f64]>) -> Item {
        let stroke = Stroke {
            dash,
            ..Stroke::solid(RED, 2.0)
        };
        Item::curves(&[vec![from, to]], stroke)
    }

    fn square(from: f64, to: f64) -> Points {
        vec![(from, from), (to, from), (to, to), (from, to)]
    }

    #[test]
    fn lines_lie_at_their_places_in_their_dashes_and_move_with_their_group() {
        let mut ruled = Ruled::new(RED, 2.0);
        ruled.border = Some(Rectangle::new((2.0, 2.0), (18.0, 18.0)));
        ruled.line((0.0, 10.0), (20.0, 10.0));
        let at = painted(vec![Item::Ruled(ruled)]);
        assert_eq!([at(5.0, 10.0), at(2.0, 5.0), at(18.0, 15.0)], [SEEN; 3]);
        assert_eq!([at(5.0, 5.0), at(0.5, 5.0)], [WHITE; 2]);

        let dashed = line((0.0, 3.0), (20.0, 3.0), Some(&[4.0, 6.0]));
        let at = painted(vec![Item::Moved {
            by: (1.0, 4.0),
            items: vec![dashed],
        }]);
        assert_eq!([at(2.0, 7.0), at(4.0, 7.0), at(12.0, 7.0)], [SEEN; 3]);
        assert_eq!([at(2.0, 3.0), at(6.0, 7.0), at(10.0, 7.0)], [WHITE; 3]);
    }

    #[test]
    fn a_box_hides_what_is_outside_and_a_ring_in_a_ring_is_a_hole() {
        let tinted = Item::area(&[square(0.0, 20.0), square(8.0, 12.0)], RED, 0.1);
        let at = painted(vec![Item::Boxed {
            name: 'a',
            edges: Rectangle::new((4.0, 0.0), (16.0, 20.0)),
            items: vec![tinted, line((0.0, 18.0), (20.0, 18.0), None)],
        }]);
        assert_eq!([at(5.0, 18.0), at(15.0, 18.0)], [SEEN; 2]);
        assert_eq!([at(3.0, 18.0), at(17.0, 18.0), at(3.0, 5.0)], [WHITE; 3]);
        assert_eq!(at(10.0, 10.0), WHITE);
        let [red, green, blue] = at(6.0, 6.0);
        assert!(
            red == 255 && green == blue && (228..=231).contains(&green),
            "{green}"
        );
    }

    #[test]
    fn markers_are_whole_with_a_rim_over_what_lies_beneath() {
        let beneath = Item::area(&[square(0.0, 20.0)], "#0000ff", 1.0);
        for shape in (0..8).map(Shape::of_series) {
            let marker = Marker {
                shape,
                radius: 3.0,
                inside: Some(RED),
                rim: Stroke::solid(PAPER, 2.0),
            };
            let items = vec![beneath.clone(), Item::markers(&[(10.0, 10.0)], marker)];
            let at = painted(items);
            assert_eq!(at(10.0, 10.0), SEEN, "{shape:?}");
            let along: Vec<[u8; 3]> = (0..40).map(|i| at(10.0, f64::from(i) / 2.0)).collect();
            assert!(along.contains(&WHITE), "{shape:?}: no rim");
            assert_eq!((along[0], along[39]), ([0, 0, 255], [0, 0, 255]));
        }
    }

    #[test]
    fn what_lies_beneath_an_open_marker_is_seen_in_it() {
        let beneath = Item::area(&[square(0.0, 20.0)], "#0000ff", 1.0);
        let marker = Marker {
            shape: Shape::Circle,
            radius: 3.0,
            inside: None,
            rim: Stroke::solid(RED, 2.0),
        };
        let marker = Item::markers(&[(10.0, 10.0)], marker);
        let at = painted(vec![beneath, marker]);
        assert_eq!(at(10.0, 10.0), [0, 0, 255]);
        assert_eq!(at(10.0, 13.0), SEEN);
    }

    #[test]
    fn upright_text_runs_upwards_from_its_place() {
        let text = |upright| Text {
            colour: RED,
            upright,
            ..Text::new("—", 10.0, 10.0, 10).anchored(Anchor::Start)
        };
        // A dash as long as the size, a third of it above the baseline.
        let dark = |at: &dyn Fn(f64, f64) -> [u8; 3], places: [(f64, f64); 2]| {
            places.map(|(x, y)| {
                (-1..=1).any(|off| {
                    let off = f64::from(off) / 2.0;
                    at(x + off, y + off)[1] < 128
                })
            })
        };
        let (right, up) = ((15.0, 6.9), (6.9, 5.0));
        assert_eq!(
            dark(&painted(vec![Item::Text(text(false))]), [right, up]),
            [true, false]
        );
        assert_eq!(
            dark(&painted(vec![Item::Text(text(true))]), [right, up]),
            [false, true]
        );
    }

    #[test]
    fn a_colour_without_a_name_here_is_an_error() {
        for name in ["red", "#12345", "#12345g", ""] {
            assert!(colour(name).is_err(), "{name}");
        }
        for name in crate::SERIES_COLOURS
            .into_iter()
            .chain([PAPER, crate::INK, crate::GRID])
        {
            assert!(colour(name).is_ok(), "{name}");
        }
    }
}
