//! A drawing as SVG text.

use std::fmt::{Display, Write as _};
use std::io::Result;

use quick_xml::events::{BytesStart, BytesText, Event};
use quick_xml::writer::Writer;

use crate::FigureError;
use crate::drawing::{Anchor, Drawing, Item, Outline, Rectangle, Ruled, Shape, Text};
use crate::style::{INK, PAPER, Stroke};
use crate::superscript::{LOWER_EM, Part, RAISE_EM, RAISED_SIZE, parts};
use crate::thin::Points;

/// Families named in the file; a PNG is set in the first, which the crate brings along.
const FONTS: &str = "DejaVu Sans, Verdana, Arial, sans-serif";

/// The drawing as SVG text.
pub(crate) fn write(drawing: &Drawing) -> std::result::Result<String, FigureError> {
    let mut sheet = Sheet(Writer::new(Vec::new()));
    (sheet.page(drawing)).map_err(|error| FigureError::Render(error.to_string()))?;
    String::from_utf8(sheet.0.into_inner()).map_err(|error| FigureError::Render(error.to_string()))
}

/// An element without content, or the start of one.
#[derive(Debug)]
struct Element(BytesStart<'static>);

impl Element {
    fn new(name: &'static str) -> Self {
        Self(BytesStart::new(name))
    }

    /// The same element with one more attribute.
    fn with(mut self, name: &str, value: impl Display) -> Self {
        self.0.push_attribute((name, value.to_string().as_str()));
        self
    }
}

/// The text so far.
struct Sheet(Writer<Vec<u8>>);

impl Sheet {
    fn page(&mut self, drawing: &Drawing) -> Result<()> {
        let (width, height) = (drawing.width, drawing.height);
        let root = Element::new("svg")
            .with("xmlns", "http://www.w3.org/2000/svg")
            .with("width", width)
            .with("height", height)
            .with("viewBox", format_args!("0 0 {width} {height}"))
            .with("font-family", FONTS)
            .with("fill", INK);
        let paper = Element::new("rect")
            .with("width", "100%")
            .with("height", "100%")
            .with("fill", PAPER);
        self.within(root, |sheet| {
            sheet.empty(paper)?;
            sheet.items(&drawing.items)
        })
    }

    fn items(&mut self, items: &[Item]) -> Result<()> {
        items.iter().try_for_each(|item| self.item(item))
    }

    fn item(&mut self, item: &Item) -> Result<()> {
        match item {
            Item::Moved { by: (x, y), items } => {
                let place = format_args!("translate({x:.2},{y:.2})").to_string();
                let group = Element::new("g").with("transform", place);
                self.within(group, |sheet| sheet.items(items))
            }
            Item::Ruled(ruled) => self.ruled(ruled),
            Item::Boxed { name, edges, items } => self.boxed(*name, *edges, items),
            Item::Curves { pieces, stroke } => self.empty(curves(pieces, *stroke)),
            Item::Area {
                rings,
                colour,
                opacity,
            } => self.empty(
                Element::new("path")
                    .with("d", path_data(rings))
                    .with("fill", colour)
                    .with("fill-opacity", opacity),
            ),
            Item::Markers(all) => self.empty(
                Element::new("path")
                    .with("d", marker_data(&all.middles, all.shape, all.radius))
                    .with("stroke", all.rim.colour)
                    .with("stroke-width", all.rim.width)
                    .with("fill", all.colour),
            ),
            Item::Text(text) => self.text(text),
        }
    }

    fn ruled(&mut self, ruled: &Ruled) -> Result<()> {
        let group = Element::new("g")
            .with("stroke", ruled.colour)
            .with("stroke-width", ruled.width);
        self.within(group, |sheet| {
            if let Some(border) = ruled.border {
                sheet.empty(rectangle(border).with("fill", "none"))?;
            }
            ruled.lines.iter().try_for_each(|((x1, y1), (x2, y2))| {
                let line = Element::new("line").with("x1", x1).with("y1", y1);
                sheet.empty(line.with("x2", x2).with("y2", y2))
            })
        })
    }

    fn boxed(&mut self, name: char, edges: Rectangle, items: &[Item]) -> Result<()> {
        // Named by the box, the same data give the same file.
        let clip = format!("box-{name}");
        self.within(Element::new("clipPath").with("id", &clip), |sheet| {
            sheet.empty(rectangle(edges))
        })?;
        let group = Element::new("g")
            .with("clip-path", format_args!("url(#{clip})"))
            .with("stroke-linejoin", "round")
            .with("fill-rule", "evenodd");
        self.within(group, |sheet| sheet.items(items))
    }

    fn text(&mut self, text: &Text) -> Result<()> {
        self.within(line_of_text(text), |sheet| {
            let mut is_raised = false;
            for part in parts(&text.content) {
                match part {
                    Part::Raised(letters) => {
                        let raised = Element::new("tspan").with("dy", em(-RAISE_EM));
                        let size = format_args!("{}%", 100.0 * RAISED_SIZE).to_string();
                        sheet.span(raised.with("font-size", size), letters)?;
                    }
                    Part::Level(letters) if is_raised => {
                        sheet.span(Element::new("tspan").with("dy", em(LOWER_EM)), letters)?;
                    }
                    Part::Level(letters) => sheet.letters(letters)?,
                }
                is_raised = matches!(part, Part::Raised(_));
            }
            Ok(())
        })
    }

    fn span(&mut self, element: Element, letters: &str) -> Result<()> {
        self.within(element, |sheet| sheet.letters(letters))
    }

    fn letters(&mut self, letters: &str) -> Result<()> {
        self.0.write_event(Event::Text(BytesText::new(letters)))
    }

    fn empty(&mut self, element: Element) -> Result<()> {
        self.0.write_event(Event::Empty(element.0))
    }

    fn within(
        &mut self,
        element: Element,
        content: impl FnOnce(&mut Self) -> Result<()>,
    ) -> Result<()> {
        let end = element.0.to_end().into_owned();
        self.0.write_event(Event::Start(element.0))?;
        content(self)?;
        self.0.write_event(Event::End(end))
    }
}

fn em(share: f64) -> String {
    format!("{share}em")
}

fn rectangle(rectangle: Rectangle) -> Element {
    Element::new("rect")
        .with("x", rectangle.x)
        .with("y", rectangle.y)
        .with("width", rectangle.width)
        .with("height", rectangle.height)
}

/// A line of text without its letters.
fn line_of_text(text: &Text) -> Element {
    let (x, y) = text.place;
    let mut element = Element::new("text")
        .with("x", x)
        .with("y", y)
        .with("font-size", text.size);
    match text.anchor {
        Anchor::Start => {}
        Anchor::Middle => element = element.with("text-anchor", "middle"),
        Anchor::End => element = element.with("text-anchor", "end"),
    }
    if text.upright {
        element = element.with("transform", format_args!("rotate(-90,{x},{y})"));
    }
    if text.colour == INK {
        element
    } else {
        element.with("fill", text.colour)
    }
}

fn curves(pieces: &[Points], stroke: Stroke) -> Element {
    let path = Element::new("path")
        .with("d", path_data(pieces))
        .with("stroke", stroke.colour)
        .with("stroke-width", stroke.width)
        .with("fill", "none");
    match stroke.dash {
        Some(dash) => {
            let lengths: Vec<String> = dash.iter().map(f64::to_string).collect();
            path.with("stroke-dasharray", lengths.join(" "))
        }
        None => path,
    }
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
        Outline::Circle(r) => {
            let across = 2.0 * r;
            format!("m-{r} 0a{r} {r} 0 1 0 {across} 0a{r} {r} 0 1 0-{across} 0z")
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
            "m-4 0a4 4 0 1 0 8 0a4 4 0 1 0-8 0z"
        );
        assert_eq!(
            marker_outline(Shape::Diamond, 4.0),
            "m5.4 0 -5.4 5.4 -5.4 -5.4 5.4 -5.4z"
        );
    }
}
