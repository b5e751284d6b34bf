//! The SVG under construction: elements in the order in which they cover each other.

use std::fmt::Display;

use quick_xml::events::{BytesStart, BytesText, Event};
use quick_xml::writer::Writer;

use crate::FigureError;
use crate::picture::Picture;
use crate::style::INK;
use crate::superscript::{Part, parts};

/// Families named in the file; a PNG is set in the first, which the crate brings along.
const FONTS: &str = "DejaVu Sans, Verdana, Arial, sans-serif";
/// Size of a superscript, and its height above the line over the line's size and over its own.
const RAISED_SIZE: &str = "70%";
const RAISE: &str = "-0.5em";
const LOWER: &str = "0.35em";

/// An element without content, or the start of one.
#[derive(Clone, Debug)]
pub(crate) struct Element(BytesStart<'static>);

impl Element {
    pub(crate) fn new(name: &'static str) -> Self {
        Self(BytesStart::new(name))
    }

    /// The same element with one more attribute.
    pub(crate) fn with(mut self, name: &str, value: impl Display) -> Self {
        self.0.push_attribute((name, value.to_string().as_str()));
        self
    }

    /// The same element with a length or place in hundredths of a pixel.
    pub(crate) fn at(self, name: &str, value: f64) -> Self {
        self.with(name, hundredths(value))
    }
}

/// The part of a text that stands at its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// A line of text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Text<'a> {
    /// `^μ` and `^{…}` in it are superscripts.
    pub(crate) content: &'a str,
    pub(crate) x: f64,
    /// Baseline.
    pub(crate) y: f64,
    pub(crate) size: u32,
    pub(crate) anchor: Anchor,
    /// From below upwards.
    pub(crate) upright: bool,
    pub(crate) colour: &'static str,
}

impl<'a> Text<'a> {
    /// Black text from a place on.
    pub(crate) fn new(content: &'a str, x: f64, y: f64, size: u32) -> Self {
        Self {
            content,
            x,
            y,
            size,
            anchor: Anchor::Start,
            upright: false,
            colour: INK,
        }
    }

    /// The same with its middle or end there.
    pub(crate) fn anchored(self, anchor: Anchor) -> Self {
        Self { anchor, ..self }
    }

    fn element(&self) -> Element {
        let mut element = Element::new("text")
            .at("x", self.x)
            .at("y", self.y)
            .with("font-size", self.size);
        match self.anchor {
            Anchor::Start => {}
            Anchor::Middle => element = element.with("text-anchor", "middle"),
            Anchor::End => element = element.with("text-anchor", "end"),
        }
        if self.upright {
            let (x, y) = (hundredths(self.x), hundredths(self.y));
            element = element.with("transform", format_args!("rotate(-90,{x},{y})"));
        }
        if self.colour == INK {
            element
        } else {
            element.with("fill", self.colour)
        }
    }
}

/// See the [module](self).
#[derive(Debug)]
pub(crate) struct Drawing {
    events: Vec<Event<'static>>,
}

impl Drawing {
    /// White paper of this size, px.
    pub(crate) fn new(width: f64, height: f64) -> Self {
        let (width, height) = (hundredths(width), hundredths(height));
        let root = Element::new("svg")
            .with("xmlns", "http://www.w3.org/2000/svg")
            .with("width", width)
            .with("height", height)
            .with("viewBox", format_args!("0 0 {width} {height}"))
            .with("font-family", FONTS)
            .with("fill", INK);
        let mut drawing = Self {
            events: vec![Event::Start(root.0)],
        };
        let paper = Element::new("rect")
            .with("width", "100%")
            .with("height", "100%");
        drawing.add(paper.with("fill", "white"));
        drawing
    }

    /// Puts an element on top of all others.
    pub(crate) fn add(&mut self, element: Element) {
        self.events.push(Event::Empty(element.0));
    }

    /// Puts an element on top that contains what `draw` puts into it.
    pub(crate) fn within(&mut self, element: Element, draw: impl FnOnce(&mut Self)) {
        let end = element.0.to_end().into_owned();
        self.events.push(Event::Start(element.0));
        draw(self);
        self.events.push(Event::End(end));
    }

    /// Puts a straight line on top, in the stroke of the group around it.
    pub(crate) fn line(&mut self, from: (f64, f64), to: (f64, f64)) {
        let line = Element::new("line").at("x1", from.0).at("y1", from.1);
        self.add(line.at("x2", to.0).at("y2", to.1));
    }

    /// Puts a text on top. Control characters, which no XML can hold, are left out.
    pub(crate) fn text(&mut self, text: Text<'_>) {
        let content: String = (text.content.chars())
            .filter(|letter| !letter.is_control())
            .collect();
        self.within(text.element(), |drawing| {
            let mut is_raised = false;
            for part in parts(&content) {
                match part {
                    Part::Raised(text) => {
                        let raised = Element::new("tspan").with("dy", RAISE);
                        drawing.span(raised.with("font-size", RAISED_SIZE), text);
                    }
                    Part::Level(text) if is_raised => {
                        drawing.span(Element::new("tspan").with("dy", LOWER), text);
                    }
                    Part::Level(text) => drawing.letters(text),
                }
                is_raised = matches!(part, Part::Raised(_));
            }
        });
    }

    fn span(&mut self, element: Element, text: &str) {
        self.within(element, |drawing| drawing.letters(text));
    }

    fn letters(&mut self, text: &str) {
        self.events
            .push(Event::Text(BytesText::new(text).into_owned()));
    }

    /// The drawing as a picture.
    pub(crate) fn finish(mut self) -> Result<Picture, FigureError> {
        let root = self.events.first().and_then(|event| match event {
            Event::Start(root) => Some(Event::End(root.to_end().into_owned())),
            _ => None,
        });
        self.events.extend(root);
        let mut writer = Writer::new(Vec::new());
        for event in self.events {
            (writer.write_event(event)).map_err(|error| FigureError::Render(error.to_string()))?;
        }
        let svg = String::from_utf8(writer.into_inner());
        svg.map(Picture::new)
            .map_err(|error| FigureError::Render(error.to_string()))
    }
}

/// A hundredth of a pixel is seen by nobody, and further digits only make files large.
pub(crate) fn hundredths(value: f64) -> f64 {
    (100.0 * value).round() / 100.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(content: &str) -> String {
        let mut drawing = Drawing::new(10.0, 10.0);
        drawing.text(Text::new(content, 1.0, 2.004, 9));
        let svg = drawing.finish().expect("is text").svg().to_owned();
        let text = svg.split_once("<text ").expect("has a text").1.to_owned();
        text.split_once('>').expect("has content").1.to_owned()
    }

    #[test]
    fn superscripts_stand_higher_and_what_follows_does_not() {
        assert_eq!(
            drawn("N·s^μ/m"),
            r#"N·s<tspan dy="-0.5em" font-size="70%">μ</tspan><tspan dy="0.35em">/m</tspan></text></svg>"#
        );
        assert_eq!(
            drawn("T^{2−μ}"),
            r#"T<tspan dy="-0.5em" font-size="70%">2−μ</tspan></text></svg>"#
        );
    }

    #[test]
    fn text_is_escaped_and_rid_of_what_xml_cannot_hold() {
        assert_eq!(drawn("a<b & c\u{1}\0"), "a&lt;b &amp; c</text></svg>");
    }

    #[test]
    fn places_are_rounded_to_hundredths() {
        let line = Element::new("line")
            .at("x1", 1.0 / 3.0)
            .at("y1", 80.710_000_000_1);
        let mut drawing = Drawing::new(10.0, 10.0);
        drawing.add(line);
        let picture = drawing.finish().expect("is text");
        assert!(picture.svg().contains(r#"<line x1="0.33" y1="80.71"/>"#));
    }
}
