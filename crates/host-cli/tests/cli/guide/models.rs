//! The page of viscoelastic models: its numbers are those of the analysis and of closed forms, and its picture is drawn from them.

use haptic_experiment::question::Question;
use haptic_figure::{AxisSpec, Chart, ChartPage, Look, Scale, Series};
use serde_json::Value;
use std::path::Path;
use std::sync::Arc;
use testkit::book;

const PAGE: &str = "models.md";
const PICTURE: &str = "short-memory.svg";
/// T, s, and the solid: E₀ and E₁, N/m, τ, s.
const T: f64 = 1e-3;
const BESIDE: f64 = 200.0;
const SERIES: f64 = 800.0;
const TAU: f64 = 0.05;
const ORDER: f64 = 0.6;

/// Damping that a tissue of these lines needs, N·s/m, with the whole past or a short memory.
fn needed(folder: &Path, tissue: &str, scheme: &str) -> f64 {
    let file = folder.join("tissue.toml");
    let source = "[source]\ncitation = \"made up\"\nconditions = \"none\"\nchecked = false\n";
    let range = "[range]\ntime_from_s = 1e-6\ntime_to_s = 1e6\n";
    let text = format!("name = \"made\"\ndescription = \"made\"\n{tissue}\n{range}{source}");
    std::fs::write(&file, text).expect("written");
    let keys = format!(
        "[analyze-passivity]\ntissue = {file:?}\nloading = \"tension\"\narea_m2 = 1\nthickness_m = 1\nmass_kg = 1\nsample_time_s = {T}\nscheme = \"{scheme}\"\n"
    );
    let question = Question::parse(Path::new("form"), &keys).expect("a question");
    let never = Arc::default();
    let answer = question.answer(&|_| (), &never, &|_| ());
    let answer = serde_json::to_value(answer.expect("an answer")).expect("JSON");
    let found = answer.get("required_damping_n_s_per_m");
    found.and_then(Value::as_f64).expect("a damping")
}

/// A spring-pot of order α as stiff as E₁ at 1/τ, in series with E₁ and beside the other spring.
fn solid(modulus_pa: f64, order: f64) -> String {
    let viscosity = SERIES * TAU.powf(order);
    let (model, series) = match (order < 1.0, modulus_pa > 0.0) {
        (true, true) => ("fractional-zener", "second_viscosity_pa_s_beta"),
        (true, false) => ("fractional-maxwell", "second_viscosity_pa_s_beta"),
        (false, true) => ("zener", "second_elastic_modulus_pa"),
        (false, false) => ("maxwell", "elastic_modulus_pa"),
    };
    let dashpot = if order < 1.0 {
        format!("viscosity_pa_s_alpha = {viscosity:?}\norder = {order}\nsecond_order = 0")
    } else {
        format!("viscosity_pa_s = {viscosity:?}")
    };
    let spring = if modulus_pa > 0.0 {
        format!("elastic_modulus_pa = {modulus_pa:?}\n")
    } else {
        String::new()
    };
    format!("model = \"{model}\"\n[parameters]\n{spring}{series} = {SERIES:?}\n{dashpot}\n")
}

/// E₀ beside that spring-pot alone.
fn kelvin_voigt(order: f64) -> String {
    let viscosity = SERIES * TAU.powf(order);
    format!(
        "[parameters]\nelastic_modulus_pa = {BESIDE:?}\nviscosity_pa_s_alpha = {viscosity:?}\norder = {order}\n"
    )
}

/// X at θ = π: (τ/T)^α·S, where S is 2^α of the whole past and 1 + α of two samples.
fn x(order: f64, sum: f64) -> f64 {
    (TAU / T).powf(order) * sum
}

#[test]
fn special_cases_of_one_condition_need_the_damping_of_their_closed_forms() {
    let folder = tempfile::tempdir().expect("a folder");
    let page = book::chapter(PAGE);
    let side_by_side = |x: f64| BESIDE + SERIES * x;
    let in_series = |x: f64| SERIES * x / (1.0 + x);
    let solids = |x: f64| BESIDE + SERIES * x / (1.0 + x);
    type Form<'a> = &'a dyn Fn(f64) -> f64;
    let rows: [(&str, String, f64, Form<'_>); 6] = [
        ("Kelvin–Voigt", kelvin_voigt(1.0), 1.0, &side_by_side),
        (
            "fractional Kelvin–Voigt",
            kelvin_voigt(ORDER),
            ORDER,
            &side_by_side,
        ),
        ("Maxwell", solid(0.0, 1.0), 1.0, &in_series),
        ("fractional Maxwell", solid(0.0, ORDER), ORDER, &in_series),
        ("standard linear solid", solid(BESIDE, 1.0), 1.0, &solids),
        (
            "fractional standard linear solid",
            solid(BESIDE, ORDER),
            ORDER,
            &solids,
        ),
    ];
    for (name, tissue, order, at_nyquist) in rows {
        let whole = needed(folder.path(), &tissue, "full:1e-9");
        let short = needed(folder.path(), &tissue, "grunwald:2");
        for (found, sum) in [(whole, 2.0_f64.powf(order)), (short, 1.0 + order)] {
            let wanted = 0.5 * T * at_nyquist(x(order, sum));
            assert!(
                (found / wanted - 1.0).abs() < 1e-7,
                "{name}: {found} {wanted}"
            );
        }
        let cells = format!("| {whole:.5} | {short:.5}");
        let mut lines = page.lines();
        let row = lines.find(|line| line.starts_with(&format!("{name} |")));
        assert!(row.expect(name).ends_with(&cells), "{name}: {cells}");
    }
}

fn curve_of(curve: &Named, look: Look, colour: usize) -> Series<'_> {
    Series::new(&curve.0, &curve.1, look, colour)
}

/// A curve and its name.
type Named = (String, Vec<(f64, f64)>);

#[test]
fn the_table_and_the_picture_over_order_and_memory_are_those_of_the_analysis() {
    let folder = tempfile::tempdir().expect("a folder");
    let page = book::chapter(PAGE);
    let at = |order: f64, scheme: &str| needed(folder.path(), &solid(BESIDE, order), scheme);
    for order in ["0.1", "0.2", "0.6", "0.9", "1"] {
        let alpha: f64 = order.parse().expect("an order");
        let memories = [
            "grunwald:2",
            "grunwald:3",
            "grunwald:10",
            "grunwald:100",
            "full:1e-9",
        ];
        let cells = memories.map(|scheme| format!("{:.5}", at(alpha, scheme)));
        let row = format!("{order} | {}", cells.join(" | "));
        assert!(page.lines().any(|line| line == row), "{row}");
    }
    let more = |order: f64, whole: f64, length: u32| {
        100.0 * (at(order, &format!("grunwald:{length}")) / whole - 1.0)
    };
    let whole = |order: f64| (order, at(order, "full:1e-9"));
    let orders: Vec<_> = (1..=20).map(|step| whole(0.05 * f64::from(step))).collect();
    let over_orders: [Named; 4] = [2, 3, 4, 5].map(|length| {
        let points = orders
            .iter()
            .map(|&(order, whole)| (order, more(order, whole, length)));
        (format!("N = {length}"), points.collect())
    });
    let over_memory: [Named; 3] = [0.1, 0.2, 0.6].map(whole).map(|(order, whole)| {
        let points = (2..=16).map(|length| (f64::from(length), more(order, whole, length)));
        (format!("α = {order}"), points.collect())
    });
    let axis = |label| AxisSpec::new(label, Scale::Linear);
    let first = over_orders.iter().enumerate();
    let second = (4..).zip(&over_memory);
    let chart_page = ChartPage {
        title: "Damping that a fractional standard linear solid with a short memory needs",
        subtitle: "More than with the whole past · E₀ = 200 N/m · E₁ = 800 N/m · τ = 50 ms · T = 1 ms",
        columns: 2,
        charts: vec![
            Chart {
                caption: "over the order",
                x: axis("order α"),
                y: axis("additional damping / %"),
                series: first
                    .map(|(n, curve)| curve_of(curve, Look::Line, n))
                    .collect(),
            },
            Chart {
                caption: "over the memory",
                x: axis("memory N / samples"),
                y: axis("additional damping / %"),
                series: second
                    .map(|(n, curve)| curve_of(curve, Look::Markers, n))
                    .collect(),
            },
        ],
    };
    let picture = chart_page.draw().expect("a picture");
    let kept = book::folder().join(PICTURE);
    if std::env::var_os("UPDATE_GUIDE").is_some() {
        std::fs::write(&kept, picture.svg()).expect("written");
        let drawn = std::env::temp_dir().join("short-memory.png");
        std::fs::write(drawn, picture.png().expect("pixels")).expect("written");
    }
    let kept = std::fs::read_to_string(kept).expect("the picture of the page");
    assert_eq!(kept, picture.svg(), "UPDATE_GUIDE=1 draws it anew");
}
