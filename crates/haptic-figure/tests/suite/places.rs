//! Places in a picture: curves against the labels of their axes, read from the SVG alone.

use haptic_figure::{AxisSpec, Chart, ChartPage, Look, Scale, Series};

/// Height of a digit of `DejaVu Sans` over the size of the font: 1493 of 2048 units.
const DIGIT_HEIGHT: f64 = 1493.0 / 2048.0;
/// Places are rounded to hundredths of a pixel.
const ROUNDING: f64 = 0.011;

fn svg(x: AxisSpec<'_>, y: AxisSpec<'_>, points: &[(f64, f64)]) -> String {
    let page = ChartPage {
        title: "Places",
        subtitle: "",
        columns: 1,
        charts: vec![Chart {
            caption: "",
            x,
            y,
            series: vec![Series::new("", points, Look::Markers, 0)],
        }],
    };
    page.draw().expect("draws").svg().to_owned()
}

fn attribute(element: &str, name: &str) -> f64 {
    let (_, value) = element
        .split_once(&format!(" {name}=\""))
        .expect("is there");
    let value = value.split('"').next().expect("ends");
    value.parse().expect("is a number")
}

/// Elements of this name, from their attributes to their end.
fn elements<'a>(svg: &'a str, name: &str) -> Vec<&'a str> {
    let start = format!("<{name} ");
    let elements = svg.split(start.as_str()).skip(1);
    elements
        .map(|rest| rest.split("/>").next().unwrap_or(rest))
        .collect()
}

/// The place of the tick with this label on the horizontal or vertical axis.
fn tick(svg: &str, label: &str, is_horizontal: bool) -> f64 {
    let anchor = if is_horizontal { "middle" } else { "end" };
    let found: Vec<&str> = (svg.split("<text ").skip(1))
        .filter(|text| text.contains(&format!("\"{anchor}\">{label}</text>")))
        .collect();
    let [text] = found[..] else {
        panic!("{} ticks `{label}`", found.len());
    };
    let text = &format!(" {text}");
    if is_horizontal {
        attribute(text, "x")
    } else {
        attribute(text, "y") - 0.5 * DIGIT_HEIGHT * attribute(text, "font-size")
    }
}

/// Middles of the markers.
fn markers(svg: &str) -> Vec<(f64, f64)> {
    let paths = elements(svg, "path");
    let [path] = paths[..] else {
        panic!("{} paths", paths.len());
    };
    let data = path.split('"').nth(1).expect("has data");
    let starts = data.split('M').skip(1);
    starts
        .map(|start| {
            let end = start.find('m').expect("has an outline");
            let (x, y) = start[..end].split_once(' ').expect("has two numbers");
            (x.parse().expect("x"), y.parse().expect("y"))
        })
        .collect()
}

#[test]
fn a_point_stands_where_the_ticks_of_its_numbers_are() {
    let points = [(2.0, 100.0), (1.0, 10.0), (4.0, 1000.0)];
    let x = AxisSpec::new("x", Scale::Linear).between(0.0, 5.0);
    let y = AxisSpec::new("y", Scale::Log).between(5.0, 2000.0);
    let drawn = svg(x, y, &points);
    for ((x, y), marker) in points.into_iter().zip(markers(&drawn)) {
        let place = (
            tick(&drawn, &x.to_string(), true),
            tick(&drawn, &y.to_string(), false),
        );
        assert!((marker.0 - place.0).abs() < ROUNDING, "{x}: {marker:?}");
        // The baseline of the label is rounded too.
        assert!(
            (marker.1 - place.1).abs() < 2.0 * ROUNDING,
            "{y}: {marker:?}"
        );
    }
}

#[test]
fn between_ticks_a_logarithmic_axis_divides_by_ratios() {
    let points: Vec<(f64, f64)> = [1.0, 3.0, 30.0, 100.0].map(|v| (v, v)).to_vec();
    let axis = |label| AxisSpec::new(label, Scale::Log).between(1.0, 100.0);
    let drawn = svg(axis("x"), axis("y"), &points);
    let places = markers(&drawn);
    let (first, last) = (places[0], places[3]);
    for ((value, _), place) in points.iter().zip(&places) {
        let share = value.log10() / 2.0;
        let x = first.0 + share * (last.0 - first.0);
        let y = first.1 + share * (last.1 - first.1);
        assert!((place.0 - x).abs() < 2.0 * ROUNDING, "{value}: {place:?}");
        assert!((place.1 - y).abs() < 2.0 * ROUNDING, "{value}: {place:?}");
    }
}

#[test]
fn every_tick_has_its_line_and_every_line_is_within_the_box() {
    let points = [(0.0, 1e-3), (7.0, 5.0)];
    let y = AxisSpec::new("y", Scale::Log).between(1e-3, 10.0);
    let drawn = svg(AxisSpec::new("x", Scale::Linear), y, &points);
    let boxes: Vec<&str> = (elements(&drawn, "rect").into_iter())
        .filter(|element| element.contains("fill=\"none\""))
        .collect();
    let [edges] = boxes[..] else {
        panic!("{} boxes", boxes.len());
    };
    let edges = format!(" {edges}");
    let (left, top) = (attribute(&edges, "x"), attribute(&edges, "y"));
    let right = left + attribute(&edges, "width");
    let bottom = top + attribute(&edges, "height");
    let lines: Vec<[f64; 4]> = (elements(&drawn, "line").into_iter())
        .map(|line| ["x1", "y1", "x2", "y2"].map(|name| attribute(&format!(" {line}"), name)))
        .collect();
    for [x1, y1, x2, y2] in &lines {
        for x in [x1, x2] {
            assert!((left - ROUNDING..=right + ROUNDING).contains(x), "{x}");
        }
        for y in [y1, y2] {
            assert!((top - ROUNDING..=bottom + ROUNDING).contains(y), "{y}");
        }
    }
    for label in ["0", "2", "4", "6"] {
        let x = tick(&drawn, label, true);
        let ends = |y: f64| {
            let mut lines = lines.iter();
            lines.any(|line| (line[0] - x).abs() < ROUNDING && (line[1] - y).abs() < ROUNDING)
        };
        assert!(ends(bottom) && ends(top), "{label}");
    }
    for label in ["0.001", "0.01", "0.1", "1", "10"] {
        let y = tick(&drawn, label, false);
        let ends = |x: f64| {
            let mut lines = lines.iter();
            lines.any(|line| (line[1] - y).abs() < 2.0 * ROUNDING && (line[0] - x).abs() < ROUNDING)
        };
        assert!(ends(left) && ends(right), "{label}");
    }
}
