//! A drawing as pixels.

use tiny_skia::{
    Color, FillRule, LineJoin, Mask, Paint, Path, PathBuilder, Pixmap, Rect, StrokeDash, Transform,
};

use crate::FigureError;
use crate::drawing::{Drawing, Item, Rectangle, Ruled, Text};
use crate::lettering::Lettering;
use crate::marker::{Outline, Shape};
use crate::style::{PAPER, Stroke};
use crate::thin::Points;

/// Corners sharper than this are cut off, as in SVG: length of the corner over the width of its line.
const MITER_LIMIT: f32 = 4.0;

/// The drawing with `scale` pixels to a CSS pixel.
///
/// # Errors
/// If the paper has no size or too large a one, or a colour has no name here.
pub(crate) fn paint(drawing: &Drawing, scale: u32) -> Result<Pixmap, FigureError> {
    let across = |length: f64| scale * length.ceil() as u32;
    let pixels = Pixmap::new(across(drawing.width), across(drawing.height));
    let mut pixels =
        pixels.ok_or_else(|| FigureError::Render("its size is not positive".to_owned()))?;
    pixels.fill(colour(PAPER)?);
    let mut canvas = Canvas {
        pixels,
        lettering: Lettering::new()?,
    };
    canvas.items(&drawing.items, Surroundings::of_paper(scale as f32))?;
    Ok(canvas.pixels)
}

struct Canvas {
    pixels: Pixmap,
    lettering: Lettering,
}

/// What holds for all that is drawn at one place.
#[derive(Clone, Copy)]
struct Surroundings<'a> {
    transform: Transform,
    /// Where something is seen; `None` is everywhere.
    mask: Option<&'a Mask>,
    join: LineJoin,
    rule: FillRule,
}

impl Surroundings<'_> {
    fn of_paper(scale: f32) -> Self {
        Self {
            transform: Transform::from_scale(scale, scale),
            mask: None,
            join: LineJoin::Miter,
            rule: FillRule::Winding,
        }
    }
}

impl Canvas {
    fn items(&mut self, items: &[Item], around: Surroundings<'_>) -> Result<(), FigureError> {
        items.iter().try_for_each(|item| self.item(item, around))
    }

    fn item(&mut self, item: &Item, around: Surroundings<'_>) -> Result<(), FigureError> {
        match item {
            Item::Moved { by, items } => {
                let transform = around.transform.pre_translate(by.0 as f32, by.1 as f32);
                self.items(
                    items,
                    Surroundings {
                        transform,
                        ..around
                    },
                )
            }
            Item::Ruled(ruled) => self.ruled(ruled, around),
            Item::Boxed { edges, items, .. } => self.boxed(*edges, items, around),
            Item::Curves { pieces, stroke } => self.stroke(joined(pieces, false), *stroke, around),
            Item::Area {
                rings,
                colour,
                opacity,
            } => self.fill(joined(rings, true), (colour, *opacity), around),
            Item::Markers {
                middles,
                shape,
                radius,
                colour,
                rim,
            } => {
                let path = markers(middles, *shape, *radius);
                self.fill(path.clone(), (colour, 1.0), around)?;
                self.stroke(path, *rim, around)
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
        let mask = Mask::new(self.pixels.width(), self.pixels.height());
        let (Some(mut mask), Some(edges)) = (mask, rectangle(edges)) else {
            return Ok(());
        };
        let edges = PathBuilder::from_rect(edges);
        mask.fill_path(&edges, FillRule::Winding, true, around.transform);
        let inside = Surroundings {
            mask: Some(&mask),
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
        self.fill(
            letters,
            (text.colour, 1.0),
            Surroundings {
                transform,
                ..around
            },
        )
    }

    fn fill(
        &mut self,
        path: Option<Path>,
        (name, opacity): (&str, f64),
        around: Surroundings<'_>,
    ) -> Result<(), FigureError> {
        let Some(path) = path else { return Ok(()) };
        let mut paint = ink(name)?;
        paint.shader.apply_opacity(opacity as f32);
        let (rule, transform) = (around.rule, around.transform);
        (self.pixels).fill_path(&path, &paint, rule, transform, around.mask);
        Ok(())
    }

    fn stroke(
        &mut self,
        path: Option<Path>,
        stroke: Stroke,
        around: Surroundings<'_>,
    ) -> Result<(), FigureError> {
        let Some(path) = path else { return Ok(()) };
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
        let paint = ink(stroke.colour)?;
        (self.pixels).stroke_path(&path, &paint, &line, around.transform, around.mask);
        Ok(())
    }
}

/// Straight lines through the points of each piece; `None` if there is none.
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
            Outline::Circle(r) => path.push_circle(*x as f32, *y as f32, *r as f32),
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

/// `None` if it has no area.
fn rectangle(rectangle: Rectangle) -> Option<Rect> {
    let Rectangle {
        x,
        y,
        width,
        height,
    } = rectangle;
    Rect::from_xywh(x as f32, y as f32, width as f32, height as f32)
}

fn ink(name: &str) -> Result<Paint<'static>, FigureError> {
    let mut paint = Paint::default();
    paint.set_color(colour(name)?);
    Ok(paint)
}

/// The colour that SVG calls `white` or `#rrggbb`.
fn colour(name: &str) -> Result<Color, FigureError> {
    let digits = match name {
        "white" => Some("ffffff"),
        name => name.strip_prefix('#').filter(|digits| digits.len() == 6),
    };
    let number = digits.and_then(|digits| u32::from_str_radix(digits, 16).ok());
    let [_, red, green, blue] = number
        .ok_or_else(|| FigureError::Render(format!("`{name}` is no colour: `#rrggbb` is")))?
        .to_be_bytes();
    Ok(Color::from_rgba8(red, green, blue, u8::MAX))
}
