//! A picture of each kind, with all that can be on one but `ff`, `fi` and `fl`: resvg sets them as ligatures, we do
//! not, and what follows stands up to 0.3 px elsewhere.

use haptic_figure::{AxisSpec, Chart, ChartPage, Look, Picture, PlaneFigure, Scale, Series};

type Points = Vec<(f64, f64)>;

pub(crate) fn all() -> Vec<(&'static str, Picture)> {
    vec![
        ("lines", chart(Look::Line, Scale::Linear)),
        ("dashes", chart(Look::Dashed, Scale::Log)),
        ("broad", chart(Look::Broad, Scale::Linear)),
        ("markers", chart(Look::Markers, Scale::Linear)),
        ("logarithmic", chart(Look::Markers, Scale::Log)),
        ("open", chart(Look::OpenMarkers, Scale::Linear)),
        ("areas", chart(Look::Area, Scale::Linear)),
        ("panels", panels()),
        ("letters", letters()),
        ("plane", plane()),
    ]
}

/// Eight series of one look: waves on linear axes, powers on logarithmic ones.
fn chart(look: Look, scale: Scale) -> Picture {
    let curve = |k: u32| -> Points {
        let x = (1..=60).map(|i| f64::from(i) / 10.0);
        let k = f64::from(k);
        x.map(|x| match scale {
            Scale::Linear => (x, k + (x + 0.3 * k).sin()),
            Scale::Log => (x, (k + 1.0) * x.powf(0.2 * k - 1.0)),
        })
        .collect()
    };
    let curves: Vec<Points> = (0..8).map(curve).collect();
    let names: Vec<String> = (0..8)
        .map(|k| format!("μ = {}", f64::from(k) / 4.0))
        .collect();
    let series = curves.iter().zip(&names).enumerate();
    let page = ChartPage {
        title: "Stability of the virtual wall: AV, To, P. and Ty kern",
        subtitle: "B in N·s^μ·m⁻¹, T^{2−μ} and a “quotation”",
        columns: 1,
        charts: vec![Chart {
            caption: "",
            x: AxisSpec::new("dissipation β = BT^{2−μ}/m", scale),
            y: AxisSpec::new("modulus G / N·mm⁻¹", scale),
            series: series
                .map(|(k, (points, name))| Series::new(name, points, look, k))
                .collect(),
        }],
    };
    page.draw().expect("draws")
}

/// Fifteen small panels in five columns; curves run out of their boxes.
fn panels() -> Picture {
    let line: Points = (0..200)
        .map(|i| 0.1 * f64::from(i))
        .map(|x| (x, x * x.sin()))
        .collect();
    let ring: Points = [
        (2.0, -5.0),
        (30.0, -5.0),
        (9.0, 12.0),
        (f64::NAN, 0.0),
        (5.0, -2.0),
        (9.0, -2.0),
        (7.0, 3.0),
    ]
    .into();
    let dots: Points = line.iter().step_by(9).copied().collect();
    let charts = (0..15).map(|k| Chart {
        caption: "caption",
        x: AxisSpec::new("time / s", Scale::Linear).between(0.0, 15.0),
        y: AxisSpec::new("force / N", Scale::Linear).between(-8.0, 8.0),
        series: vec![
            Series::new("region", &ring, Look::Area, k),
            Series::new("curve", &line, Look::Dotted, k + 1),
            Series::new("points", &dots, Look::Markers, k + 2),
        ],
    });
    let page = ChartPage {
        title: "Many panels",
        subtitle: "one line\nanother line",
        columns: 5,
        charts: charts.collect(),
    };
    page.draw().expect("draws")
}

/// All letters that pictures of this project use, as names of series.
fn letters() -> Picture {
    let names = [
        "ABCDEFGHIJKLM",
        "NOPQRSTUVWXYZ",
        "abcdefghijklm",
        "nopqrstuvwxyz",
        "0123456789 ,.;:!?",
        "αβγδεζηθικλμ",
        "νξοπρστυφχψω",
        "ΓΔΘΛΞΠΣΦΨΩ",
        "⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺",
        "−×·±≤≥≈∞∂∫√→–—…",
        "äöüßéèåñ łşčř µ°",
        "()[]{}<>&'\"/\\|@#%",
        "AVATAR Type LT. WAY Yo 11 r. f'",
    ];
    let point = [(1.0, 1.0), (2.0, 3.0)];
    let series = names.iter().enumerate();
    let page = ChartPage {
        title: "Letters",
        subtitle: "two  spaces, and some at the end  ",
        columns: 1,
        charts: vec![Chart {
            caption: "",
            x: AxisSpec::new("x", Scale::Linear),
            y: AxisSpec::new("y", Scale::Linear),
            series: series
                .map(|(k, name)| Series::new(name, &point, Look::Line, k))
                .collect(),
        }],
    };
    page.draw().expect("draws")
}

fn times() -> Vec<f64> {
    (1..=4000).map(|i| 1e-3 * f64::from(i)).collect()
}

fn plane() -> Picture {
    let time_s = times();
    let turn = |turned: fn(f64) -> f64, radius: f64| -> Vec<f64> {
        time_s
            .iter()
            .map(|t| radius * turned(9.0 * t) * (1.0 + 0.1 * t))
            .collect()
    };
    let outline: Points = (0..100)
        .map(|i| 0.0628 * f64::from(i))
        .map(|angle| (0.02 * angle.cos(), 0.02 * angle.sin()))
        .collect();
    let figure = PlaneFigure {
        title: "A ball",
        subtitle: "two axes",
        outline_m: &outline,
        time_s: &time_s,
        reference_m: [&turn(f64::cos, 0.019), &turn(f64::sin, 0.019)],
        position_m: [&turn(f64::cos, 0.02), &turn(f64::sin, 0.02)],
        depth_m: Some(&turn(f64::sin, 0.001)),
        force_n: &[turn(f64::cos, 2.0), turn(f64::sin, 3.0)],
    };
    figure.draw().expect("draws")
}
