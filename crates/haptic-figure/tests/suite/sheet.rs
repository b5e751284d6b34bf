//! A sheet: the same picture at a width on paper, one panel of it, without its title.

use crate::picture::{size, texts};
use haptic_figure::{AxisSpec, Chart, ChartPage, FigureError, Look, Picture, Scale, Series, Sheet};

/// Two columns of two panels, and conditions that are longer than a narrow page.
fn page() -> Picture {
    let wave: Vec<(f64, f64)> = (0..300)
        .map(|i| 0.01 * f64::from(i))
        .map(|t| (t, (9.0 * t).sin()))
        .collect();
    let chart = |caption, name| Chart {
        caption,
        x: AxisSpec::new("time / s", Scale::Linear),
        y: AxisSpec::new("force on the hand / N", Scale::Linear),
        series: vec![Series::new(name, &wave, Look::Line, 0)],
    };
    let page = ChartPage {
        title: "A title that is far too long for one line of a narrow page",
        subtitle: "order μ = 0.5 · K = 3000 N/m · B = 100 N·s^μ/m · device sim · push 1 N · stable",
        columns: 2,
        charts: vec![
            chart("position", "one"),
            chart("force", "one"),
            chart("beginning", "two"),
            chart("end", "two"),
        ],
    };
    page.draw().expect("draws")
}

fn wide(width_m: f64) -> Sheet {
    Sheet {
        width_m: Some(width_m),
        ..Sheet::default()
    }
}

fn at(width_m: f64) -> Picture {
    page().on(&wide(width_m)).expect("draws")
}

/// The height of a capital or a digit says nothing: the size of the font does, in points.
#[test]
fn no_text_is_below_six_points_and_none_beyond_the_paper_at_any_width() {
    for width_mm in [60.0, 85.0, 120.0, 170.0, 300.0] {
        let picture = at(1e-3 * width_mm);
        let svg = picture.svg();
        let px = viewed(svg);
        let points_per_px = width_mm / 25.4 * 72.0 / px.0;
        for size in svg.split("font-size=\"").skip(1) {
            let size = size.split('"').next().expect("ends");
            if let Ok(size) = size.parse::<f64>() {
                assert!(size * points_per_px >= 6.0 - 1e-9, "{width_mm} mm: {size}");
            }
        }
        for (text, [left, top, right, bottom]) in texts(&picture) {
            let inside = left >= 0.0 && top >= 0.0 && right <= px.0 && bottom <= px.1;
            assert!(inside, "{width_mm} mm: {text} {left} {right} of {}", px.0);
        }
        // Nothing of the conditions is lost.
        let all: Vec<String> = texts(&picture).into_iter().map(|text| text.0).collect();
        assert!(all.iter().any(|text| text.ends_with("stable")), "{all:?}");
        assert!(!svg.contains('…'), "{width_mm} mm");
    }
}

#[test]
fn conditions_are_whole_in_a_line_and_lines_of_a_kind_have_one_size() {
    let wave = [(0.0, 0.0), (1.0, 1.0)];
    let lines = ["plant 1/(s+1)", "T = 200 ms · held until 50 s"];
    let names = ["short", "a name that is nearly too long for a column"];
    let page = ChartPage {
        title: "",
        subtitle: "plant 1/(s+1)\ncontroller 9.7479+0.60718/s^0.9-2.8389s^0.6063 · T = 200 ms · held until 50 s",
        columns: 1,
        charts: vec![Chart {
            caption: "",
            x: AxisSpec::new("", Scale::Linear),
            y: AxisSpec::new("", Scale::Linear),
            series: names
                .map(|name| Series::new(name, &wave, Look::Line, 0))
                .into(),
        }],
    };
    let picture = page.draw().expect("draws");
    let picture = picture.on(&wide(0.085)).expect("draws");
    let height = |line: &str| {
        let found = texts(&picture).into_iter().find(|(text, _)| text == line);
        let [_, top, _, bottom] = found.unwrap_or_else(|| panic!("no line {line}")).1;
        bottom - top
    };
    for [one, other] in [lines, names] {
        assert!((height(one) - height(other)).abs() < 1e-9, "{one}");
    }
}

/// Width and height of the page in its own pixels.
fn viewed(svg: &str) -> (f64, f64) {
    let (_, after) = svg.split_once("viewBox=\"0 0 ").expect("has one");
    let (box_, _) = after.split_once('"').expect("ends");
    let (width, height) = box_.split_once(' ').expect("two numbers");
    (width.parse().expect("px"), height.parse().expect("px"))
}

#[test]
fn a_width_is_in_millimetres_and_a_narrow_page_has_its_panels_below_each_other() {
    let svg = at(0.085).svg().to_owned();
    assert!(svg.contains(r#" width="85mm" height=""#), "{}", &svg[..200]);
    let boxes = |svg: &str| -> Vec<f64> {
        let moved = svg.split("translate(").skip(1);
        let x = moved.map(|rest| rest.split(',').next().expect("x").parse().expect("px"));
        x.collect()
    };
    let narrow = boxes(&svg);
    assert_eq!(narrow.len(), 4);
    assert!(
        narrow.iter().all(|x| (x - narrow[0]).abs() < 1e-9),
        "{narrow:?}"
    );
    let wide = boxes(at(0.17).svg());
    assert_eq!(
        (wide[0].to_bits(), wide[1].to_bits()),
        (wide[2].to_bits(), wide[3].to_bits())
    );
    assert!(wide[0] < wide[1]);
}

#[test]
fn one_panel_has_its_own_legend_labels_and_no_letter() {
    for name in ["3", "c", "C", "begin", "Beginning"] {
        let sheet = Sheet {
            panel: Some(name.to_owned()),
            untitled: true,
            ..Sheet::default()
        };
        let picture = page().on(&sheet).expect("draws");
        let all: Vec<String> = texts(&picture).into_iter().map(|text| text.0).collect();
        for wanted in ["beginning", "two", "time / s", "force on the hand / N"] {
            assert!(
                all.iter().any(|text| text == wanted),
                "{name}: {wanted}: {all:?}"
            );
        }
        assert!(
            !all.iter()
                .any(|text| text == "one" || text.contains("title") || text.contains("stable"))
        );
        assert!(size(&picture).1 < size(&page()).1);
    }
}

#[test]
fn a_panel_or_a_width_that_there_is_not_is_an_error_that_names_those_there_are() {
    let on = |panel: &str| {
        let sheet = Sheet {
            panel: Some(panel.to_owned()),
            ..Sheet::default()
        };
        page()
            .on(&sheet)
            .map(|_| ())
            .expect_err("refuses")
            .to_string()
    };
    for wrong in ["e", "0", "5", "middle", "", "µ"] {
        let error = on(wrong);
        assert!(
            error.contains("a (position), b (force), c (beginning)"),
            "{error}"
        );
    }
    for width_m in [0.059, 0.0, -1.0, f64::NAN, 0.51] {
        let error = page().on(&wide(width_m));
        let error = error.map(|_| ()).expect_err("refuses");
        assert!(matches!(error, FigureError::Width { .. }), "{error}");
        assert!(error.to_string().contains("60 mm to 500 mm"), "{error}");
    }
}

#[test]
fn a_sheet_that_asks_for_nothing_changes_nothing_and_one_twice_is_the_same() {
    assert!(page().on(&Sheet::default()).expect("draws") == page());
    let again = at(0.085).on(&wide(0.085));
    assert!(again.expect("draws").svg() == at(0.085).svg());
}

#[cfg(feature = "png")]
#[test]
fn a_png_says_how_large_its_pixels_are() {
    let png = at(0.085).png().expect("paints");
    let at_chunk = png
        .windows(4)
        .position(|four| four == b"pHYs")
        .expect("is there");
    let number = |from: usize| u32::from_be_bytes(png[from..from + 4].try_into().expect("four"));
    let per_metre = number(at_chunk + 4);
    let width = number(16);
    // In metres, and at least 300 to the inch.
    assert_eq!(png[at_chunk + 12], 1);
    assert!((f64::from(width) / f64::from(per_metre) - 0.085).abs() < 1e-5);
    assert!(f64::from(per_metre) * 0.0254 >= 300.0);
}
