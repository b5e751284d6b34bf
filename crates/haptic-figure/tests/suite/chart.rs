//! Charts of any series: what is on them, what must never be, and that they can be read.

mod lines;

use crate::picture::{self, texts};
use haptic_figure::{AxisSpec, Chart, ChartPage, FigureError, Look, Picture, Scale, Series};

type Points = Vec<(f64, f64)>;

/// A page stays below this, whatever is on it.
const MOST_BYTES: usize = 500_000;

fn assert_sound(picture: &Picture, name: &str) {
    picture::assert_sound(picture, name, MOST_BYTES);
}

fn chart<'a>(caption: &'a str, scale: Scale, series: Vec<Series<'a>>) -> Chart<'a> {
    Chart {
        caption,
        x: AxisSpec::new("dissipation β = BT^{2−μ}/m", scale),
        y: AxisSpec::new("stiffness K / N·mm⁻¹", scale),
        series,
    }
}

fn draw(columns: usize, charts: Vec<Chart<'_>>) -> Result<Picture, FigureError> {
    ChartPage {
        title: "Stability of the virtual wall",
        subtitle: "m = 65 g, no hand",
        columns,
        charts,
    }
    .draw()
}

/// Stability region for μ = 1 without device damping: 0 < α < 2β(2−β)/(2+β), from theory.md, 5.
fn region(size: f64) -> Points {
    (0..=1_000)
        .map(|i| f64::from(i) / 500.0)
        .map(|beta| (size * beta, size * 2.0 * beta * (2.0 - beta) / (2.0 + beta)))
        .collect()
}

/// Numbers without order in [0, 1).
fn noise(index: u32) -> f64 {
    f64::from(index.wrapping_mul(2_654_435_761) >> 8) / f64::from(1_u32 << 24)
}

/// The smallest numbers that there are, alone, beside zero and beside each other, are drawn as zeros.
#[test]
fn the_smallest_numbers_are_drawn() {
    let least = 5e-324;
    for points in [
        vec![(0.0, 0.0), (1.0, least)],
        vec![(0.0, least), (least, -least)],
        vec![(least, 0.0), (2.0 * least, 1e-310)],
        vec![(0.0, 1e-31), (1.0, 2e-31)],
    ] {
        for scale in [Scale::Linear, Scale::Log] {
            let series = vec![Series::new("least", &points, Look::Line, 0)];
            if let Ok(picture) = draw(1, vec![chart("least", scale, series)]) {
                assert_sound(&picture, "least");
            }
        }
    }
}

/// Path data of all paths with this attribute.
fn paths<'a>(picture: &'a Picture, attribute: &str) -> Vec<&'a str> {
    let elements = picture.svg().split("<path d=\"").skip(1);
    elements
        .filter(|element| {
            let end = element.find("/>").unwrap_or(element.len());
            element[..end].contains(attribute)
        })
        .filter_map(|element| element.split('"').next())
        .collect()
}

/// The numbers of path data in pairs.
fn places(data: &str) -> Points {
    let numbers: Vec<f64> = (data.split(|c: char| !matches!(c, '0'..='9' | '.' | '-')))
        .filter_map(|number| number.parse().ok())
        .collect();
    numbers
        .chunks_exact(2)
        .map(|pair| (pair[0], pair[1]))
        .collect()
}

/// No text covers another. The boxes are those of lines, higher than their letters.
fn assert_apart(picture: &Picture, name: &str) {
    let texts = texts(picture);
    let cores: Vec<_> = (texts.iter())
        .map(|(text, [left, top, right, bottom])| {
            let (dx, dy) = (0.1 * (right - left), 0.25 * (bottom - top));
            (
                text,
                [left + dx.min(dy), top + dy, right - dx.min(dy), bottom - dy],
            )
        })
        .collect();
    for (index, (text, a)) in cores.iter().enumerate() {
        for (other, b) in &cores[index + 1..] {
            let apart = a[2] <= b[0] || b[2] <= a[0] || a[3] <= b[1] || b[3] <= a[1];
            assert!(apart, "{name}: `{text}` covers `{other}`");
        }
    }
}

#[test]
fn a_chart_says_what_is_on_its_axes_and_names_its_series() {
    let (small, large) = (region(1.0), region(1.2));
    let charts = vec![
        chart(
            "regions",
            Scale::Linear,
            vec![
                Series::new("μ = 1", &small, Look::Area, 0),
                Series::new("μ = 1.5", &large, Look::Dotted, 1),
                Series::new("", &large, Look::Line, 2),
            ],
        ),
        chart(
            "log–log",
            Scale::Log,
            vec![Series::new("μ = 1", &small, Look::Markers, 0)],
        ),
    ];
    let picture = draw(2, charts).expect("draws");
    assert_sound(&picture, "two panels");
    assert_apart(&picture, "two panels");
    let texts = texts(&picture);
    let count = |wanted: &str| texts.iter().filter(|(text, _)| text == wanted).count();
    for wanted in [
        "Stability of the virtual wall",
        "m = 65 g, no hand",
        "(a) regions",
        "(b) log–log",
        "stiffness K / N·mm⁻¹",
        "μ = 1",
        "μ = 1.5",
    ] {
        assert_eq!(count(wanted), 1, "{wanted}");
    }
    // One below each column, with a true superscript.
    assert_eq!(count("dissipation β = BT2−μ/m"), 2);
    assert!(picture.svg().contains(">2−μ</tspan>"));
    // The one name has both an area and markers in the legend: its panel and its sample.
    assert_eq!(paths(&picture, "fill-opacity").len(), 2);
}

#[test]
fn the_legend_does_not_name_what_is_not_drawn() {
    let unknown: Points = (0..50).map(|i| (f64::from(i), f64::NAN)).collect();
    let line: Points = (0..50).map(|i| (f64::from(i), 1.0)).collect();
    let series = vec![
        Series::new("hand", &unknown, Look::Dashed, 2),
        Series::new("object", &[], Look::Dashed, 3),
        Series::new("device", &line, Look::Line, 0),
    ];
    let picture = draw(1, vec![chart("", Scale::Linear, series)]).expect("draws");
    let texts = texts(&picture);
    let named = |wanted: &str| texts.iter().any(|(text, _)| text == wanted);
    assert_eq!(
        ["hand", "object", "device"].map(named),
        [false, false, true]
    );
}

#[test]
fn an_area_is_filled_to_its_points_and_a_ring_within_it_is_a_hole() {
    let square = |from: f64, to: f64| [(from, from), (to, from), (to, to), (from, to)];
    let mut ring = square(0.0, 4.0).to_vec();
    ring.push((f64::NAN, 0.0));
    ring.extend(square(1.0, 3.0));
    let mut one = chart(
        "",
        Scale::Linear,
        vec![Series::new("", &ring, Look::Area, 0)],
    );
    one.x = one.x.between(0.0, 4.0);
    one.y = one.y.between(0.0, 8.0);
    let picture = draw(1, vec![one]).expect("draws");
    let fills = paths(&picture, "fill-opacity");
    assert_eq!(fills.len(), 1);
    assert_eq!(fills[0].matches('M').count(), 2, "two rings: {}", fills[0]);
    assert!(picture.svg().contains(r#"fill-rule="evenodd""#));
    let corners = places(fills[0]);
    let width = |corners: &[(f64, f64)]| corners[1].0 - corners[0].0;
    assert!((width(&corners[4..]) / width(&corners) - 0.5).abs() < 1e-3);
    // Its border along the axes is the axes.
    let outlines = paths(&picture, "stroke=\"#0072b2\"");
    assert_eq!(places(outlines[0]).len(), 2 + 5, "{}", outlines[0]);
}

#[test]
fn nine_series_differ_without_colours() {
    let waves: Vec<Points> = (0..9)
        .map(|k| {
            (0..50)
                .map(|i| (f64::from(i), f64::from(k) + noise(i)))
                .collect()
        })
        .collect();
    let styles = |look: Look, style: fn(&str) -> String| -> Vec<String> {
        let all = waves.iter().enumerate();
        let all = all
            .map(|(k, points)| Series::new("", points, look, k))
            .collect();
        let picture = draw(1, vec![chart("", Scale::Linear, all)]).expect("draws");
        let elements = picture.svg().split("<path ").skip(1);
        let mut styles: Vec<String> = elements.map(style).collect();
        assert_eq!(styles.len(), 9);
        // The first eight need no colour, the ninth differs from the first by that.
        styles.truncate(8);
        styles.sort();
        styles.dedup();
        styles
    };
    let dash = |element: &str| {
        let dash = element.split("dasharray=\"").nth(1);
        dash.map_or(String::new(), |dash| {
            dash.split('"').next().expect("splits").to_owned()
        })
    };
    assert_eq!(styles(Look::Line, dash).len(), 8);
    let shape = |element: &str| {
        let marker = element.split('m').nth(1).expect("has a marker");
        marker.split('z').next().expect("splits").to_owned()
    };
    assert_eq!(styles(Look::Markers, shape).len(), 8);
}

#[test]
fn fifteen_panels_can_be_read_in_three_columns_and_in_five() {
    let regions: Vec<Points> = (0..4).map(|j| region(1.0 - 0.2 * f64::from(j))).collect();
    let names = ["T = 1 ms", "T = 2 ms", "T = 5 ms", "T = 10 ms"];
    let captions: Vec<String> = (0..15)
        .map(|k| format!("μ = {}", 0.5 * f64::from(k % 5)))
        .collect();
    for (columns, scale) in [
        (3, Scale::Linear),
        (5, Scale::Linear),
        (4, Scale::Log),
        (99, Scale::Log),
        (0, Scale::Linear),
    ] {
        let all = || {
            (0..4)
                .map(|j| Series::new(names[j], &regions[j], Look::Area, j))
                .collect()
        };
        let charts = captions.iter().map(|caption| chart(caption, scale, all()));
        let picture = draw(columns, charts.collect()).expect("draws");
        let name = format!("{columns} columns");
        assert_sound(&picture, &name);
        assert_apart(&picture, &name);
        for (letter, caption) in ('a'..='o').zip(&captions) {
            let heading = format!("({letter}) {caption}");
            assert!(picture.svg().contains(&heading), "{name}: {heading}");
        }
        for wanted in names {
            assert_eq!(picture.svg().matches(wanted).count(), 1, "{name}: {wanted}");
        }
        let texts = texts(&picture);
        let label = |wanted: &str| texts.iter().any(|(text, _)| text == wanted);
        assert!(
            label("stiffness K / N·mm⁻¹") && label("dissipation β = BT2−μ/m"),
            "{name}"
        );
        let is_number = |text: &str| text.parse::<f64>().is_ok() || text.starts_with("10");
        let numbers = texts.iter().filter(|(text, _)| is_number(text));
        assert!(numbers.count() > 15 * 4, "{name}: tick labels");
    }
}

#[test]
fn an_empty_panel_says_so_and_a_page_of_them_is_an_error() {
    let region = region(1.0);
    let full = || {
        chart(
            "full",
            Scale::Linear,
            vec![Series::new("μ = 1", &region, Look::Area, 0)],
        )
    };
    let nothing = [(f64::NAN, 1.0), (0.0, f64::INFINITY)];
    let empty = || {
        chart(
            "none",
            Scale::Linear,
            vec![Series::new("μ = 2", &nothing, Look::Area, 1)],
        )
    };
    let picture = draw(2, vec![full(), empty()]).expect("draws");
    assert_sound(&picture, "half empty");
    assert_eq!(picture.svg().matches(">empty</text>").count(), 1);
    // Both have the same axes, so that one sees what is empty.
    assert_eq!(picture.svg().matches(">1.5</text>").count(), 2);

    let error = draw(2, vec![empty(), empty()]).expect_err("refuses");
    assert!(
        matches!(error, FigureError::Empty { samples: 4, .. }),
        "{error}"
    );
    let error = draw(1, Vec::new()).expect_err("refuses");
    assert!(
        matches!(error, FigureError::Empty { samples: 0, .. }),
        "{error}"
    );
    let error = draw(5, (0..27).map(|_| full()).collect()).expect_err("refuses");
    assert_eq!(error.to_string(), "27 panels on one page; at most 26 fit");
}

#[test]
fn long_names_wrap_in_the_legend_and_long_captions_are_made_to_fit() {
    let region = region(1.0);
    let names: Vec<String> = (0..9)
        .map(|k| format!("series number {k} of a page"))
        .collect();
    let all = || -> Vec<Series<'_>> {
        let names = names.iter().enumerate();
        names
            .map(|(k, name)| Series::new(name, &region, Look::Line, k))
            .collect()
    };
    let caption = "a caption much longer than its panel ".repeat(3);
    let charts = (0..5).map(|_| chart(&caption, Scale::Log, all()));
    let picture = draw(5, charts.collect()).expect("draws");
    assert_sound(&picture, "long");
    assert_apart(&picture, "long");
    for name in &names {
        assert!(picture.svg().contains(name.as_str()), "{name}");
    }
}

/// Texts of a page of one chart of lines over this axis.
fn message(y: AxisSpec<'_>, lines: &[&[(f64, f64)]]) -> Vec<String> {
    let x = AxisSpec::new("x", Scale::Linear);
    let lines = lines.iter().enumerate();
    let series = lines.map(|(n, points)| Series::new("", points, Look::Line, n));
    let series = series.collect();
    said_by(Chart {
        caption: "",
        x,
        y,
        series,
    })
}

fn said_by(chart: Chart<'_>) -> Vec<String> {
    let picture = draw(1, vec![chart]).expect("draws");
    texts(&picture).into_iter().map(|text| text.0).collect()
}

#[test]
fn a_line_beyond_a_focused_axis_says_how_far_it_goes_and_one_beyond_another_does_not() {
    let kick = [(0.0, 554.8), (0.1, 3.0), (0.2, -75.25), (0.3, 1.0)];
    let calm = [(0.0, 0.5), (0.3, 1.0)];
    let with = |y: AxisSpec<'static>| message(y, &[&kick, &calm]);
    let command = AxisSpec::new("command / V", Scale::Linear);
    let focused = with(command.focused(-10.0, 36.0));
    assert_eq!(focused.iter().filter(|text| *text == "↑ 554.8").count(), 1);
    assert!(
        !focused.iter().any(|text| text.starts_with('↓')),
        "{focused:?}"
    );
    let below = with(command.focused(-10.0, 600.0));
    assert!(below.contains(&"↓ −75.25".to_owned()), "{below:?}");
    let plain = with(command.between(-10.0, 36.0));
    assert!(!plain.iter().any(|text| text.contains('↑')), "{plain:?}");
    // In the unit of the axis.
    let small = [(0.0, 0.005_548), (1.0, 0.0)];
    let force = AxisSpec::new("force / N", Scale::Linear);
    let small = message(force.focused(0.0, 0.002), &[&small]);
    assert!(small.contains(&"↑ 5.548".to_owned()) && small.contains(&"force / mN".to_owned()));
}

#[test]
fn markers_without_a_place_on_a_logarithmic_axis_are_counted() {
    let points = [(0.0, 1.0), (1.0, -2.0), (2.0, 3.0), (f64::NAN, 1.0)];
    let notes = |scale| {
        let axis = AxisSpec::new("x / m", scale);
        let series = vec![Series::new("dots", &points, Look::Markers, 0)];
        said_by(Chart {
            caption: "",
            x: axis,
            y: axis,
            series,
        })
    };
    assert!(notes(Scale::Log).contains(&"2 not drawn: not above 0".to_owned()));
    assert!(
        !notes(Scale::Linear)
            .iter()
            .any(|text| text.contains("not above"))
    );
}

#[test]
fn units_have_the_prefix_at_which_numbers_are_short() {
    let label = |label: &str, largest: f64| {
        let points = [(0.0, 0.0), (1.0, largest)];
        let all = message(AxisSpec::new(label, Scale::Linear), &[&points]);
        let is_label = |text: &&String| text.contains(" / ");
        let label = all.iter().find(is_label).expect("has a label").clone();
        assert!(
            !all.iter().any(|text| text.contains("·10")) || label.contains('°'),
            "{all:?}"
        );
        label
    };
    for (given, largest, wanted) in [
        ("force / N", 1.0, "force / N"),
        ("force / N", 0.02, "force / N"),
        ("force / N", 1.6e-9, "force / nN"),
        ("position / mm", 1.6e-6, "position / nm"),
        ("position / mm", 3e-3, "position / µm"),
        ("error / µm", 2e6, "error / m"),
        ("K / N·m⁻¹", -6e5, "K / kN·m⁻¹"),
        ("B / N·s^μ·m⁻¹", 8e-7, "B / nN·sμ·m⁻¹"),
        ("modulus / kPa", 4e5, "modulus / MPa"),
        ("energy / mJ", 4e-4, "energy / nJ"),
        ("time / s", 4e5, "time / s"),
    ] {
        assert_eq!(label(given, largest), wanted, "{largest}");
    }
    for other in ["phase / °", "angle / rad", "G / (m/N)", "rate / s⁻¹"] {
        let points = [(0.0, 0.0), (1.0, 1e-7)];
        let all = message(AxisSpec::new(other, Scale::Linear), &[&points]);
        assert!(all.contains(&other.to_owned()), "{all:?}");
    }
}
