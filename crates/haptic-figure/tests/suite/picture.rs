//! Shared by the tests of pictures: their texts, read from the SVG, with the room that the font gives them.

use haptic_figure::Picture;
use quick_xml::Reader;
use quick_xml::escape::resolve_predefined_entity;
use quick_xml::events::{BytesStart, Event};
use ttf_parser::Face;

/// Left, top, right and bottom, px on the page.
type Edges = [f64; 4];

/// Width and height of the page, px.
pub(crate) fn size(picture: &Picture) -> (f64, f64) {
    let mut reader = Reader::from_str(picture.svg());
    let Event::Start(root) = reader.read_event().expect("is XML") else {
        panic!("begins with no element");
    };
    assert_eq!(root.name().as_ref(), "svg");
    (number(&root, "width"), number(&root, "height"))
}

/// All texts of a picture with the boxes of their lines, from the font's height above the baseline to that below it.
#[expect(
    clippy::wildcard_enum_match_arm,
    reason = "declarations and comments of XML, which no picture has"
)]
pub(crate) fn texts(picture: &Picture) -> Vec<(String, Edges)> {
    let font = include_bytes!("../../assets/DejaVuSans.ttf");
    let face = Face::parse(font, 0).expect("is a font");
    let mut reader = Reader::from_str(picture.svg());
    let mut found = Vec::new();
    // The places of the groups around, and the line that is read.
    let mut places = vec![(0.0, 0.0)];
    let mut line: Option<Line> = None;
    loop {
        match reader.read_event().expect("is XML") {
            Event::Start(element) => match (element.name().as_ref(), &mut line) {
                ("text", None) => {
                    line = Some(Line::new(&element, *places.last().expect("a place")));
                }
                ("tspan", Some(line)) => line.begin_span(&element),
                ("tspan" | "text", _) => panic!("a line within a line, or a span without"),
                (_, None) => places.push(moved(*places.last().expect("a place"), &element)),
                (_, Some(_)) => panic!("{element:?} in a line"),
            },
            Event::End(element) => match (element.name().as_ref(), &mut line) {
                ("text", Some(_)) => found.extend(line.take().map(Line::finish)),
                ("tspan", Some(line)) => line.spans.truncate(1),
                _ => {
                    places.pop();
                }
            },
            Event::Text(text) => {
                let line = line.as_mut().expect("letters stand in a line");
                line.add(&text, &face);
            }
            Event::GeneralRef(name) => {
                let letter = resolve_predefined_entity(&name).expect("is known");
                line.as_mut().expect("stands in a line").add(letter, &face);
            }
            Event::Eof => break,
            _ => {}
        }
    }
    assert!(line.is_none() && places.len() == 1, "is whole");
    found
}

/// A line of text while it is read; it runs to the right from its place, or upwards.
struct Line {
    content: String,
    place: (f64, f64),
    anchor: String,
    upright: bool,
    /// Size of the line, and of the span in it, px.
    spans: Vec<f64>,
    /// Height of the spans from here on above the line, px.
    raise: f64,
    width: f64,
    above: f64,
    below: f64,
}

impl Line {
    fn new(element: &BytesStart<'_>, origin: (f64, f64)) -> Self {
        let (x, y) = (number(element, "x"), number(element, "y"));
        let turned = attribute(element, "transform");
        if let Some(turned) = &turned {
            assert_eq!(*turned, format!("rotate(-90,{x},{y})"));
        }
        Self {
            content: String::new(),
            place: (origin.0 + x, origin.1 + y),
            anchor: attribute(element, "text-anchor").unwrap_or_default(),
            upright: turned.is_some(),
            spans: vec![number(element, "font-size")],
            raise: 0.0,
            width: 0.0,
            above: 0.0,
            below: 0.0,
        }
    }

    fn begin_span(&mut self, element: &BytesStart<'_>) {
        let share = attribute(element, "font-size").map_or(1.0, |percent| {
            let percent = percent.strip_suffix('%').expect("is a percentage");
            percent.parse::<f64>().expect("is a number") / 100.0
        });
        let size = share * self.spans[0];
        let lower = attribute(element, "dy").expect("has a height");
        let lower = lower.strip_suffix("em").expect("is in em");
        self.raise -= size * lower.parse::<f64>().expect("is a number");
        self.spans.push(size);
    }

    fn add(&mut self, letters: &str, face: &Face<'_>) {
        let unit = self.spans.last().expect("has a size") / f64::from(face.units_per_em());
        for letter in letters.chars() {
            let glyph = face.glyph_index(letter);
            let glyph = glyph.unwrap_or_else(|| panic!("the font has no `{letter}`"));
            let advance = face.glyph_hor_advance(glyph).expect("has a width");
            self.width += unit * f64::from(advance);
        }
        self.above = (self.above).max(self.raise + unit * f64::from(face.ascender()));
        self.below = (self.below).max(-self.raise - unit * f64::from(face.descender()));
        self.content += letters;
    }

    fn finish(self) -> (String, Edges) {
        let start = match self.anchor.as_str() {
            "" => 0.0,
            "middle" => -self.width / 2.0,
            "end" => -self.width,
            other => panic!("{other} is no anchor"),
        };
        let ((x, y), end) = (self.place, start + self.width);
        let edges = if self.upright {
            [x - self.above, y - end, x + self.below, y - start]
        } else {
            [x + start, y - self.above, x + end, y + self.below]
        };
        (self.content, edges)
    }
}

/// The place of a group, or of any other element with content.
fn moved(around: (f64, f64), element: &BytesStart<'_>) -> (f64, f64) {
    let Some(transform) = attribute(element, "transform") else {
        return around;
    };
    let by = transform.strip_prefix("translate(").expect("is moved");
    let by = by.strip_suffix(')').and_then(|by| by.split_once(','));
    let (x, y) = by.expect("has two numbers");
    let number = |text: &str| text.parse::<f64>().expect("is a number");
    (around.0 + number(x), around.1 + number(y))
}

fn attribute(element: &BytesStart<'_>, name: &str) -> Option<String> {
    let attribute = element.try_get_attribute(name).expect("is XML")?;
    Some(attribute.value.into_owned())
}

fn number(element: &BytesStart<'_>, name: &str) -> f64 {
    let text = attribute(element, name).expect("is there");
    text.parse().expect("is a number")
}

/// Checks what holds of every picture.
pub(crate) fn assert_sound(picture: &Picture, name: &str, most_bytes: usize) {
    let svg = picture.svg();
    for word in ["NaN", "inf"] {
        assert!(!svg.contains(word), "{name}: `{word}` in the SVG");
    }
    assert!(svg.len() < most_bytes, "{name}: {} bytes", svg.len());
    let texts = texts(picture);
    assert!(texts.len() > 10, "{name}: {} texts", texts.len());
    let (width, height) = size(picture);
    for (text, [left, top, right, bottom]) in texts {
        assert!(
            left >= 0.0 && top >= 0.0 && right <= width && bottom <= height,
            "{name}: `{text}` is cut off at the edge of the page"
        );
    }
}
