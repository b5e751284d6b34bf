//! A drawing as SVG text.

use std::fmt::{Error, Result, Write as _};

use quick_xml::escape::escape;

use crate::FigureError;
use crate::drawing::{Anchor, Drawing, Item, Outline, Rectangle, Ruled, Shape, Text, hundredths};
use crate::style::{INK, PAPER};
use crate::superscript::{LOWER_EM, Part, RAISE_EM, RAISED_SIZE, parts};
use crate::thin::Points;

/// Families named in the file; a PNG is set in the first, which the crate brings along.
const FONTS: &str = "DejaVu Sans, Verdana, Arial, sans-serif";

/// The drawing as SVG text.
pub(crate) fn write(drawing: &Drawing) -> std::result::Result<String, FigureError> {
    let mut svg = String::new();
    let written = page(&mut svg, drawing);
    written.map_err(|error: Error| FigureError::Render(error.to_string()))?;
    Ok(svg)
}

fn page(svg: &mut String, drawing: &Drawing) -> Result {
    let (width, height) = (drawing.width, drawing.height);
    let (scale, unit) = match drawing.printed_m {
        Some(width_m) => (1e3 * width_m / width, "mm"),
        None => (1.0, ""),
    };
    let [across, down] = [width, height].map(|length| hundredths(scale * length));
    svg.write_str(r#"<svg xmlns="http://www.w3.org/2000/svg" "#)?;
    write!(svg, r#"width="{across}{unit}" height="{down}{unit}" "#)?;
    write!(svg, r#"viewBox="0 0 {width} {height}" "#)?;
    write!(svg, r#"font-family="{FONTS}" fill="{INK}">"#)?;
    write!(svg, r#"<rect width="100%" height="100%" fill="{PAPER}"/>"#)?;
    items(svg, &drawing.items)?;
    svg.write_str("</svg>")
}

fn items(svg: &mut String, items: &[Item]) -> Result {
    items.iter().try_for_each(|thing| item(svg, thing))
}

fn item(svg: &mut String, item: &Item) -> Result {
    match item {
        Item::Moved { by: (x, y), items } => {
            write!(svg, r#"<g transform="translate({x:.2},{y:.2})">"#)?;
            self::items(svg, items)?;
            svg.write_str("</g>")
        }
        Item::Ruled(ruled) => self::ruled(svg, ruled),
        Item::Boxed { name, edges, items } => {
            // Named by the box, the same data give the same file.
            write!(svg, r#"<clipPath id="box-{name}">"#)?;
            rectangle(svg, *edges, "")?;
            write!(svg, r#"</clipPath><g clip-path="url(#box-{name})" "#)?;
            svg.write_str(r#"stroke-linejoin="round" fill-rule="evenodd">"#)?;
            self::items(svg, items)?;
            svg.write_str("</g>")
        }
        Item::Curves { pieces, stroke } => {
            let (colour, width) = (stroke.colour, stroke.width);
            write!(svg, r#"<path d="{}" stroke="{colour}" "#, path_data(pieces))?;
            write!(svg, r#"stroke-width="{width}" fill="none""#)?;
            if let Some(dash) = stroke.dash {
                let lengths: Vec<String> = dash.iter().map(f64::to_string).collect();
                write!(svg, r#" stroke-dasharray="{}""#, lengths.join(" "))?;
            }
            svg.write_str("/>")
        }
        Item::Area {
            rings,
            colour,
            opacity,
        } => {
            write!(svg, r#"<path d="{}" "#, path_data(rings))?;
            write!(svg, r#"fill="{colour}" fill-opacity="{opacity}"/>"#)
        }
        Item::Markers(middles, marker) => {
            let data = marker_data(middles, marker.shape, marker.radius);
            let (rim, width) = (marker.rim.colour, marker.rim.width);
            let inside = marker.inside.unwrap_or("none");
            write!(svg, r#"<path d="{data}" stroke="{rim}" "#)?;
            // The rim beneath: those of crowded markers would hide each other's colour.
            write!(
                svg,
                r#"stroke-width="{width}" fill="{inside}" paint-order="stroke"/>"#
            )
        }
        Item::Text(text) => self::text(svg, text),
    }
}

fn ruled(svg: &mut String, ruled: &Ruled) -> Result {
    let (colour, width) = (ruled.colour, ruled.width);
    write!(svg, r#"<g stroke="{colour}" stroke-width="{width}">"#)?;
    if let Some(border) = ruled.border {
        rectangle(svg, border, r#" fill="none""#)?;
    }
    for ((x1, y1), (x2, y2)) in &ruled.lines {
        write!(svg, r#"<line x1="{x1}" y1="{y1}" x2="{x2}" y2="{y2}"/>"#)?;
    }
    svg.write_str("</g>")
}

/// A rectangle with one more attribute.
fn rectangle(svg: &mut String, at: Rectangle, more: &str) -> Result {
    let (x, y) = (at.x, at.y);
    write!(svg, r#"<rect x="{x}" y="{y}" "#)?;
    let (width, height) = (at.width, at.height);
    write!(svg, r#"width="{width}" height="{height}"{more}/>"#)
}

fn text(svg: &mut String, text: &Text) -> Result {
    let (x, y) = text.place;
    write!(svg, r#"<text x="{x}" y="{y}" font-size="{}""#, text.size)?;
    match text.anchor {
        Anchor::Start => {}
        Anchor::Middle => svg.write_str(r#" text-anchor="middle""#)?,
        Anchor::End => svg.write_str(r#" text-anchor="end""#)?,
    }
    if text.upright {
        write!(svg, r#" transform="rotate(-90,{x},{y})""#)?;
    }
    if text.colour != INK {
        write!(svg, r#" fill="{}""#, text.colour)?;
    }
    svg.write_str(">")?;
    let mut is_raised = false;
    for part in parts(&text.content) {
        match part {
            Part::Raised(letters) => {
                let size = 100.0 * RAISED_SIZE;
                write!(svg, r#"<tspan dy="-{RAISE_EM}em" font-size="{size}%">"#)?;
                write!(svg, "{}</tspan>", escape(letters))?;
            }
            Part::Level(letters) if is_raised => {
                write!(
                    svg,
                    r#"<tspan dy="{LOWER_EM}em">{}</tspan>"#,
                    escape(letters)
                )?;
            }
            Part::Level(letters) => svg.write_str(&escape(letters))?,
        }
        is_raised = matches!(part, Part::Raised(_));
    }
    svg.write_str("</text>")
}

fn path_data(pieces: &[Points]) -> String {
    let mut data = String::new();
    for piece in pieces {
        for (index, (x, y)) in piece.iter().enumerate() {
            let start = if index == 0 { "M" } else { " " };
            let _ = write!(data, "{start}{x} {y}");
        }
    }
    data
}

fn marker_data(middles: &[(f64, f64)], shape: Shape, radius: f64) -> String {
    let outline = marker_outline(shape, radius);
    let mut data = String::new();
    for (x, y) in middles {
        let _ = write!(data, "M{x} {y}{outline}");
    }
    data
}

/// A marker as path data relative to its middle; begins with `m`.
fn marker_outline(shape: Shape, radius: f64) -> String {
    match shape.outline(radius) {
        Outline::Circle { radius: r, handle } => {
            let left = hundredths(r - handle);
            format!(
                "m-{r} 0c0-{handle} {left}-{r} {r}-{r}s{r} {left} {r} {r}-{left} {r}-{r} {r}-{r}-{left}-{r}-{r}z"
            )
        }
        Outline::Corners(corners) => {
            let mut outline = String::new();
            let mut from = (0.0, 0.0);
            for to in corners {
                let start = if outline.is_empty() { "m" } else { " " };
                let (dx, dy) = ((to.0 - from.0) / 10.0, (to.1 - from.1) / 10.0);
                let _ = write!(outline, "{start}{dx} {dy}");
                from = to;
            }
            outline + "z"
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(item: Item) -> String {
        let mut drawing = Drawing::new(10.0, 10.004);
        drawing.items.push(item);
        write(&drawing).expect("is text")
    }

    fn letters(content: &str) -> String {
        let svg = written(Item::Text(Text::new(content, 1.0, 2.004, 9)));
        let text = svg.split_once("<text ").expect("has a text").1.to_owned();
        text.split_once('>').expect("has content").1.to_owned()
    }

    #[test]
    fn superscripts_stand_higher_and_what_follows_does_not() {
        assert_eq!(
            letters("N·s^μ/m"),
            r#"N·s<tspan dy="-0.5em" font-size="70%">μ</tspan><tspan dy="0.35em">/m</tspan></text></svg>"#
        );
        assert_eq!(
            letters("T^{2−μ}"),
            r#"T<tspan dy="-0.5em" font-size="70%">2−μ</tspan></text></svg>"#
        );
    }

    #[test]
    fn text_is_escaped_and_rid_of_what_xml_cannot_hold() {
        assert_eq!(letters("a<b & c\u{1}\0"), "a&lt;b &amp; c</text></svg>");
    }

    #[test]
    fn a_line_has_its_places_and_the_paper_its_size() {
        let mut ruled = Ruled::new(INK, 1.5);
        ruled.line((1.0 / 3.0, 80.710_000_000_1), (2.0, 3.0));
        let svg = written(Item::Ruled(ruled));
        for wanted in [
            r#" width="10" height="10" viewBox="0 0 10 10" "#,
            r##"<g stroke="#1a1a1a" stroke-width="1.5"><line x1="0.33" y1="80.71" x2="2" y2="3"/></g></svg>"##,
        ] {
            assert!(svg.contains(wanted), "{wanted}: {svg}");
        }
    }

    #[test]
    fn markers_end_where_they_began() {
        assert_eq!(
            marker_outline(Shape::Circle, 4.0),
            "m-4 0c0-2.21 1.79-4 4-4s4 1.79 4 4-1.79 4-4 4-4-1.79-4-4z"
        );
        assert_eq!(
            marker_outline(Shape::Diamond, 4.0),
            "m5.4 0 -5.4 5.4 -5.4 -5.4 5.4 -5.4z"
        );
    }
}
