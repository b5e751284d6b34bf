//! A tissue in place of a wall: what the analyses say of it, against sums of our own, and how far trials let it grow.

use crate::design::{has, number};
use fracdiff::{Order, grunwald_weights, num_complex::Complex};
use haptic_experiment::{
    Failure,
    question::{Answer, Question},
};
use haptic_tissue::{Model, ModelKind};
use serde_json::Value;
use std::{f64::consts::PI, fmt::Write as _, path::Path, sync::Arc};
use testkit::{Random, Tested, assert_close, assert_refused, assert_relative};

const T: f64 = 1e-3;

/// A file of this text.
fn written(text: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("made.toml"), text).expect("written");
    folder
}

/// The file of a tissue of 1 m² by 1 m, whose force is its stress.
struct TissueFile(tempfile::TempDir);

impl TissueFile {
    fn of(kind: ModelKind, numbers: &[f64]) -> Self {
        let names = kind.parameters().iter().map(|parameter| parameter.name);
        Self::with(&format!("model = \"{}\"", kind.name()), names, numbers)
    }

    fn with<'a>(model: &str, names: impl Iterator<Item = &'a str>, numbers: &[f64]) -> Self {
        let mut text = format!("name = \"made\"\ndescription = \"made\"\n{model}\n[parameters]\n");
        for (name, number) in names.zip(numbers) {
            writeln!(text, "{name} = {number:?}").expect("a text");
        }
        text.push_str("[range]\ntime_from_s = 1e-6\ntime_to_s = 1e6\n[source]\ncitation = \"none\"\nconditions = \"none\"\nchecked = false\n");
        Self(written(&text))
    }

    fn ask(&self, analysis: &str, more: &str) -> Value {
        let file = self.0.path().join("made.toml");
        ask(
            analysis,
            &format!("tissue = {file:?}\nloading = \"tension\"\narea_m2 = 1\nthickness_m = 1\nsample_time_s = {T}\n{more}"),
        )
        .expect("an answer")
    }
}

/// A controller file of this table and law.
struct ControllerFile(tempfile::TempDir);

impl ControllerFile {
    fn of(law: &str, scheme: &str) -> Self {
        Self(written(&format!(
            "{law}\n[loop]\nsample_time_s = {T}\nscheme = \"{scheme}\"\n"
        )))
    }

    fn asked(&self, analysis: &str, more: &str) -> Result<Value, String> {
        let file = self.0.path().join("made.toml");
        ask(analysis, &format!("controller = {file:?}\n{more}"))
    }

    fn ask(&self, analysis: &str, more: &str) -> Value {
        self.asked(analysis, more).expect("an answer")
    }
}

/// Each row of a table is refused in a line with these words.
fn refused(table: &str, ask: impl Fn(&str) -> Result<Value, String>) {
    for [keys, wanted] in testkit::table(table) {
        let answer = ask(&keys);
        assert!(answer.is_err(), "{keys}");
        assert_refused(answer, &wanted);
    }
}

/// Analyses of a law on a device, and of a law alone.
const ANALYSES: [(&str, &str); 5] = [
    ("analyze-stability", DEVICE),
    ("analyze-passivity", DEVICE),
    ("analyze-sensitivity", DEVICE),
    ("analyze-transparency", DEVICE),
    ("analyze-environment", ""),
];

fn answered(analysis: &str, keys: &str) -> Result<Answer, String> {
    let question = Question::parse(Path::new("form"), &format!("[{analysis}]\n{keys}\n"));
    let never = Arc::default();
    let answer = question.and_then(|question| question.answer(&|_| (), &never, &|_| ()));
    answer.map_err(|error| error.to_string())
}

fn ask(analysis: &str, keys: &str) -> Result<Value, String> {
    let answer = answered(analysis, keys)?;
    Ok(serde_json::to_value(&answer).expect("JSON"))
}

/// max over θ of (T/2)·Re{(1 − w)·H(w)}/(1 − cos θ), on a grid that holds π.
fn damping_needed(h: impl Fn(Complex<f64>) -> Complex<f64>) -> f64 {
    let angles = (1..=20_000).map(|n| PI * f64::from(n) / 20_000.0);
    let needed = angles.map(|theta| {
        let w = Complex::from_polar(1.0, -theta);
        0.5 * T * ((1.0 - w) * h(w)).re / (1.0 - theta.cos())
    });
    needed.fold(f64::NEG_INFINITY, f64::max)
}

/// The first N terms of (1 − w)^α, over T^α.
fn short(order: f64, length: usize, w: Complex<f64>) -> Complex<f64> {
    let weights: Vec<f64> = grunwald_weights(Order::new(order).expect("an order"))
        .take(length)
        .collect();
    let sum = weights
        .iter()
        .rev()
        .fold(Complex::new(0.0, 0.0), |sum, c| sum * w + c);
    sum * T.powf(-order)
}

/// Two spring-pots and a spring, as a model's numbers stand: sizes between these, β up to this, α above it.
fn composed(random: &mut Random, [low, high]: [f64; 2], most: f64) -> [f64; 5] {
    let [first, second, spring] = [(); 3].map(|()| random.log_between(low, high));
    let beta = random.between(0.0, most);
    [
        first,
        random.between(beta + 0.05, 1.0),
        second,
        beta,
        spring,
    ]
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn two_hundred_models_need_the_damping_of_their_sums() {
    let kinds = [
        ModelKind::FractionalKelvinVoigt,
        ModelKind::FractionalMaxwell,
        ModelKind::FractionalZener,
        ModelKind::FractionalPoyntingThomson,
    ];
    let mut random = Random(30);
    for case in 0..200 {
        let kind = kinds[case % kinds.len()];
        let drawn = composed(&mut random, [10.0, 1e4], 0.9);
        let [first, alpha, second, beta, spring] = drawn;
        let numbers = &drawn[..kind.parameters().len()];
        let file = TissueFile::of(kind, numbers);
        let (length, more) = match case % 3 {
            0 => (None, "mass_kg = 1\nscheme = \"full:1e-7\"".to_owned()),
            _ => {
                let length = random.between(2.0, 60.0) as usize;
                (
                    Some(length),
                    format!("mass_kg = 1\nscheme = \"grunwald:{length}\""),
                )
            }
        };
        let model = Model::from_parameters(kind, numbers).expect("a model");
        let law = |w: Complex<f64>| {
            let Some(length) = length else {
                return model.modulus((1.0 - w) / T);
            };
            let (a, b) = (
                first * short(alpha, length, w),
                second * short(beta, length, w),
            );
            // As in `kinds`.
            let joined = [
                a + b,
                a * b / (a + b),
                spring + a * b / (a + b),
                (a + b) * spring / (a + b + spring),
            ];
            joined[case % kinds.len()]
        };
        let report = file.ask("analyze-passivity", &more);
        let found = number(&report, "required_damping_n_s_per_m");
        assert_relative(
            &format!("{kind:?} {numbers:?} {length:?}"),
            found,
            damping_needed(law),
            2e-5,
        );
    }
}

/// A spring beside a spring-pot is K + B·D^μ, whoever names the numbers.
#[test]
fn a_spring_beside_a_spring_pot_is_a_wall() {
    let file = pot(300.0, 40.0, 0.3);
    let wall = format!(
        "order = 0.3\nstiffness_n_per_m = 300\ndissipation_n_s_mu_per_m = 40\nsample_time_s = {T}\n"
    );
    for (analysis, more) in ANALYSES {
        let by_tissue = file.ask(analysis, more);
        let by_wall = ask(analysis, &format!("{wall}{more}")).expect("an answer");
        let Value::Object(by_wall) = by_wall else {
            panic!("a report");
        };
        for (key, value) in &by_wall {
            // Spring and memory of a tissue grow together.
            if !key.starts_with("largest_") {
                assert_eq!(&by_tissue[key], value, "{analysis}: {key}");
            }
        }
    }
}

#[test]
fn a_tissue_is_felt_as_its_modulus() {
    let numbers = [873.9, 0.6751, 220.7, 0.1102];
    let model = Model::from_parameters(ModelKind::FractionalMaxwell, &numbers).expect("a model");
    let file = TissueFile::of(ModelKind::FractionalMaxwell, &numbers);
    let report = file.ask("analyze-environment", "scheme = \"full:1e-9\"\npoints = 20");
    let points = report["points"].as_array().expect("points");
    assert_eq!(points.len(), 20);
    for point in points {
        let omega = number(point, "omega_rad_s");
        let w = Complex::from_polar(1.0, -omega * T);
        let h = model.modulus((1.0 - w) / T);
        has(point, "effective_stiffness", h.re, 1e-6);
        assert_relative(
            "damping",
            number(point, "effective_damping") * omega,
            h.im,
            1e-6,
        );
    }
    // Slow motion through a device: its own inertia and damping are small beside it.
    let device = "mass_kg = 0.01\ndamping_n_s_per_m = 0\nomega_max_rad_s = 10\npoints = 5";
    let report = file.ask("analyze-transparency", device);
    for point in report["points"].as_array().expect("points") {
        let omega = number(point, "omega_rad_s");
        let h =
            model.modulus(Complex::new(0.0, omega)) * Complex::from_polar(1.0, -0.5 * omega * T);
        let wanted = h.re - 0.01 * omega * omega;
        has(point, "continuous_stiffness_n_per_m", wanted, 1e-9);
        has(point, "effective_stiffness", wanted, 0.01);
    }
}

/// Scaled by its margin, the loop is on the edge.
#[test]
fn a_tissue_may_grow_by_its_margin() {
    let numbers = [873.9, 0.6751, 220.7, 0.1102];
    let margin = |factor: f64| {
        let [v, alpha, g, beta] = numbers;
        let file = TissueFile::of(
            ModelKind::FractionalMaxwell,
            &[v * factor, alpha, g * factor, beta],
        );
        file.ask("analyze-stability", DEVICE)
    };
    let gain = number(&margin(1.0), "gain_margin");
    assert_eq!(margin(0.999 * gain)["stable"], true);
    assert_eq!(margin(1.001 * gain)["stable"], false);
}

#[test]
fn what_a_tissue_does_not_have_is_refused_in_a_line() {
    let device = "sample_time_s = 1e-3\nmass_kg = 0.065\n";
    refused(
        r#"
        tissue = "fish-muscle"\nstiffness_n_per_m = 1 | has no effect beside
        tissue = "fish-muscle"\norder = 0.5 | has no effect beside
        tissue = "fish-muscle"\nscheme = "exact" | use full, or a short memory, as in grunwald:1000
        tissue = "fish-muscle"\nscheme = "muir:3" | use `scheme` = full
        tissue = "fish-muscle"\nscheme = "grunwald:1" | from 2 to 10000
        tissue = "fish-muscle"\nscheme = "grunwald:20000" | from 2 to 10000
        tissue = "no-such" | no-such
        tissue = "fish-muscle"\nloading = "sphere"\nindenter_radius_m = 0.01 | give `depth_m`
        tissue = "fish-muscle"\ndepth_m = 1e-3 | is linear in its depth: omit it
        tissue = "brain-cortex"\ndepth_m = 0.03 | is beyond thickness_m = 0.02
        tissue = "fish-muscle"\nalpha = 1 | with and without units
        order = 1\nstiffness_n_per_m = 1\ndissipation_n_s_mu_per_m = 1\narea_m2 = 1 | belongs to a tissue
        controller = "no-such.toml" | no-such.toml
        controller = "no-such.toml"\ntissue = "fish-muscle" | has no effect beside
        "#,
        |keys| ask("analyze-passivity", &format!("{device}{keys}")),
    );
    // A sphere is judged where it is: steeper the deeper it presses.
    let sphere = |depth: &str| {
        let keys = format!(
            "{device}tissue = \"fish-muscle\"\nloading = \"sphere\"\nindenter_radius_m = 0.01\ndepth_m = {depth}"
        );
        number(
            &ask("analyze-passivity", &keys).expect("an answer"),
            "required_damping_n_s_per_m",
        )
    };
    // Hertz: f ∝ δ^1.5, so the slope grows as its root.
    assert_relative("Hertz", sphere("4e-3") / sphere("1e-3"), 2.0, 1e-6);
}

/// Device of 65 g with 3.5 N·s/m, and a sample of delay: G of the force over the place, behind its hold.
fn device(w: Complex<f64>) -> Complex<f64> {
    let (mass, a) = (0.065, 3.5 * T / 0.065);
    let e = (-a).exp();
    let above = w * (a - 1.0 + e) + w * w * (1.0 - e - a * e);
    w * above / ((1.0 - w) * (1.0 - w * e)) * (T * T / (mass * a * a))
}

const DEVICE: &str = "mass_kg = 0.065\ndamping_n_s_per_m = 3.5\ndelay_s = 1e-3\n";

/// The last number from `low` on up to which this is so.
fn bisected(mut low: f64, mut high: f64, is_so: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if is_so(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// The factors g with which 1 + g·G·H is 0 somewhere, from 1e-5 rad on.
fn edges(h: impl Fn(Complex<f64>) -> Complex<f64>) -> Vec<f64> {
    let open = |theta: f64| {
        let w = Complex::from_polar(1.0, -theta);
        device(w) * h(w)
    };
    let angles: Vec<f64> = (0..=4_000)
        .map(|n| 1e-5 * (PI * 1e5).powf(f64::from(n) / 4_000.0))
        .collect();
    let mut found = Vec::new();
    for pair in angles.windows(2) {
        let is_positive = |theta: f64| open(theta).im.is_sign_positive();
        let before = is_positive(pair[0]);
        if before != is_positive(pair[1]) {
            let at = bisected(pair[0], pair[1], |theta| is_positive(theta) == before);
            found.push(-1.0 / open(at).re);
        }
    }
    found
}

/// The largest edge below 1 and the smallest above it.
fn around(h: impl Fn(Complex<f64>) -> Complex<f64>) -> [f64; 2] {
    let (below, above): (Vec<f64>, Vec<f64>) = edges(h).into_iter().partition(|edge| *edge < 1.0);
    let least = below.into_iter().fold(0.0, f64::max);
    [least, above.into_iter().fold(f64::INFINITY, f64::min)]
}

fn gain_margin(h: impl Fn(Complex<f64>) -> Complex<f64>) -> f64 {
    around(h)[1]
}

/// C(w), N/m.
type Function = Box<dyn Fn(Complex<f64>) -> Complex<f64>>;

/// The text of a random law, and the function that its samples are of.
fn drawn(random: &mut Random, case: usize) -> (String, Function) {
    let gain = 10.0_f64.powf(random.between(1.5, 2.5));
    let [small, order, low] = [0.3, random.between(0.1, 0.95), random.between(1.0, 20.0)];
    let rate = |w: Complex<f64>| (1.0 - w) / T;
    let second = 0.02 * gain * random.between(0.1, 1.0);
    match case % 5 {
        0 | 1 => {
            let integral = if case.is_multiple_of(5) {
                0.0
            } else {
                low * gain * small
            };
            let lambda = random.between(0.5, 1.0);
            let text = format!(
                "[pid]\nproportional_gain = {gain}\nintegral_gain_per_s_lambda = {integral}\nintegral_order = {lambda}\nderivative_gain_s_mu = {second}\nderivative_order = {order}\n"
            );
            let law = move |w| {
                let s = rate(w);
                gain + integral * s.powf(-lambda) + second * s.powf(order)
            };
            (text, Box::new(law))
        }
        2 => {
            let (below, above) = (low, 10.0 * low);
            let text = format!(
                "[crone]\ngain = {gain}\norder = {order}\nlow_rad_s = {below}\nhigh_rad_s = {above}\n"
            );
            let law = move |w: Complex<f64>| {
                let s = (1.0 - w) / (1.0 + w) * (2.0 / T);
                gain * ((1.0 + s / below) / (1.0 + s / above)).powf(order)
            };
            (text, Box::new(law))
        }
        3 => {
            let text = format!(
                "[transfer_function]\nfunction = \"{gain}(1+0.1s^{order})/(1+0.02s^{order})\"\n"
            );
            let law = move |w| {
                let power = rate(w).powf(order);
                gain * (1.0 + 0.1 * power) / (1.0 + 0.02 * power)
            };
            (text, Box::new(law))
        }
        _ => {
            let text = format!(
                "[pid]\nproportional_gain = {gain}\nintegral_gain_per_s_lambda = 0\nintegral_order = 1\nderivative_gain_s_mu = 0\nderivative_order = 1\n"
            );
            (text, Box::new(move |_| Complex::new(gain, 0.0)))
        }
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn sixty_controllers_are_judged_as_their_functions_are() {
    let mut random = Random(69);
    for case in 0..60 {
        let (text, law) = drawn(&mut random, case);
        let file = ControllerFile::of(&text, "full:1e-9");
        let stable = file.ask("analyze-stability", DEVICE);
        assert_eq!(stable["stable"], true, "{text}");
        let margin = gain_margin(&law);
        assert_relative(&text, number(&stable, "gain_margin"), margin, 1e-5);
        let region = file.ask("analyze-stability-region", DEVICE);
        let scales = region["stable_scales"].as_array().expect("intervals");
        let last = scales.last().and_then(|last| last[1].as_f64());
        assert_relative("scale", last.expect("a scale"), margin.min(10.0), 1e-5);
        let passive = file.ask(
            "analyze-passivity",
            "mass_kg = 0.065\ndamping_n_s_per_m = 3.5",
        );
        let has_integral = case % 5 == 1;
        if has_integral {
            assert_eq!(passive["passive"], false, "{text}");
            assert!(passive["required_damping_n_s_per_m"].is_null(), "{passive}");
            assert!(region["empty"].is_null(), "{region}");
        } else {
            let needed = damping_needed(&law);
            let found = number(&passive, "required_damping_n_s_per_m");
            assert_relative(&text, found, needed, 2e-5);
            has(&passive, "largest_scale", 3.5 / needed, 2e-5);
            has(&region, "scale_max", margin, 1e-4);
        }
        let felt = file.ask("analyze-environment", "points = 20");
        for point in felt["points"].as_array().expect("points") {
            let omega = number(point, "omega_rad_s");
            let h = law(Complex::from_polar(1.0, -omega * T));
            has(point, "effective_stiffness", h.re, 1e-4);
        }
    }
}

/// m·s³ + (b + g·D)s² + g·K·s + g·I needs g above (m·I/K − b)/D, 0.75 here, and a sample of delay bounds it from above.
#[test]
fn a_controller_that_is_stable_between_two_factors_has_both() {
    let law = "[pid]\nproportional_gain = 300\nintegral_gain_per_s_lambda = 30000\nintegral_order = 1\nderivative_gain_s_mu = 4\nderivative_order = 1\n";
    let file = ControllerFile::of(law, "full:1e-9");
    let [least, most] = around(|w| {
        let s = (1.0 - w) / T;
        300.0 + 30_000.0 / s + 4.0 * s
    });
    let report = file.ask("analyze-stability-region", DEVICE);
    let scales = report["stable_scales"].as_array().expect("intervals");
    let [only] = scales.as_slice() else {
        panic!("{report}");
    };
    for (end, wanted) in [(&only[0], least), (&only[1], most.min(10.0))] {
        assert_relative("an end", end.as_f64().expect("a factor"), wanted, 1e-6);
    }
    assert_close("from", least, 0.75, 0.2);
}

/// K + B·D^μ, whether a wall or a PD^μ says it, in each rule.
#[test]
fn a_controller_of_a_spring_and_a_derivative_is_a_wall() {
    let law = "[pid]\nproportional_gain = 300\nintegral_gain_per_s_lambda = 0\nintegral_order = 1\nderivative_gain_s_mu = 40\nderivative_order = 0.3\n";
    for scheme in ["full:1e-9", "full-bdf2:1e-9"] {
        let file = ControllerFile::of(law, scheme);
        let wall = format!(
            "order = 0.3\nstiffness_n_per_m = 300\ndissipation_n_s_mu_per_m = 40\nsample_time_s = {T}\nscheme = \"{scheme}\"\n"
        );
        for (analysis, more) in ANALYSES {
            let by_controller = file.ask(analysis, more);
            let by_wall = ask(analysis, &format!("{wall}{more}")).expect("an answer");
            let Value::Object(by_wall) = by_wall else {
                panic!("a report");
            };
            let of_a_wall = [
                "order",
                "stiffness_n_per_m",
                "dissipation_n_s_mu_per_m",
                "alpha",
                "beta",
                "corollary_delta",
            ];
            for (key, value) in &by_wall {
                let found = &by_controller[key];
                if of_a_wall.contains(&key.as_str()) || key.starts_with("largest_") {
                    assert!(found.is_null(), "{analysis}: {key}");
                } else if let Some(value) = value.as_f64() {
                    let found = found.as_f64().expect(key);
                    assert!(
                        (found - value).abs() <= 1e-5 * value.abs(),
                        "{analysis}: {key}: {found} {value}"
                    );
                } else if key != "points" {
                    assert_eq!(found, value, "{analysis}: {key}");
                }
            }
            let points = |report: &Value| report["points"].as_array().map_or(0, Vec::len);
            assert_eq!(points(&by_controller), points(&Value::Object(by_wall)));
        }
    }
}

#[test]
fn what_a_controller_does_not_have_is_refused_in_a_line() {
    let made = ControllerFile::of("[transfer_function]\nfunction = \"10/(0.1s+1)\"\n", "full");
    refused(
        r#"
        sample_time_s = 2e-3 | 0.002 s is not the 0.001 s of the controller
        stiffness_n_per_m = 1 | no effect beside `controller`: omit it
        order = 0.5 | has no effect beside
        scheme = "full" | has no effect beside
        area_m2 = 1 | belongs to a tissue
        alpha = 1 | with and without units
        "#,
        |keys| made.asked("analyze-stability", &format!("{DEVICE}{keys}")),
    );
    assert_eq!(
        made.ask(
            "analyze-stability",
            &format!("{DEVICE}sample_time_s = 1e-3")
        )["stable"],
        true
    );
    let grows = ControllerFile::of("[transfer_function]\nfunction = \"10/(0.1s-1)\"\n", "full");
    let error = grows.asked("analyze-stability", DEVICE);
    assert_refused(
        error,
        "poles of the controller that grow by themselves 1 is not 0",
    );
}

/// A load on a spring k, whose other end a motor moves as fast as P + I/s of the error of the spring's force asks.
///
/// States: place and speed of the load, place of the motor, sum of the errors; the law takes the place of the load.
struct SeriesElastic {
    load_kg: f64,
    spring: f64,
    gains: [f64; 2],
}

impl SeriesElastic {
    fn ask(&self, analysis: &str, more: &str) -> Result<Value, String> {
        let Self {
            load_kg: m,
            spring: k,
            gains: [p, i],
        } = self;
        let (pull, follow) = (k / m, p * k);
        let text = format!(
            "[state_space]\na = [[0, 1, 0, 0], [{:?}, 0, {pull:?}, 0], [{follow:?}, 0, {:?}, {i:?}], [{k:?}, 0, {:?}, 0]]\nb = [0, 0, {p:?}, 1]\nc = [1, 0, 0, 0]\n",
            -pull, -follow, -k
        );
        let folder = written(&text);
        let file = folder.path().join("made.toml");
        ask(analysis, &format!("plant_model = {file:?}\n{more}"))
    }

    /// M·s⁴ + M·k·P·s³ + (M·k·I + k(1 + B·P))s² + k(K·P + B·I)s + k·K·I: the least K above 0 on the edge, by Routh.
    fn largest_stiffness(&self, damper: f64) -> f64 {
        let Self {
            load_kg: m,
            spring: k,
            gains: [p, i],
        } = self;
        let margin = |stiffness: f64| {
            let c = stiffness * p + damper * i;
            m * k * p * i * i * damper + c * (k * p * (1.0 + damper * p) - c)
        };
        bisected(0.0, 1e9, |stiffness| margin(stiffness) > 0.0)
    }
}

/// Vallery and others 2007: no wish above the spring of the actuator, whatever it carries; and with a damper beside the wish.
#[test]
fn a_series_elastic_actuator_renders_at_most_its_spring() {
    let sampling = "sample_time_s = 1e-6\nscheme = \"grunwald:2\"\norder = 1\n";
    for load_kg in [0.01, 0.3, 5.0] {
        for (damper, gains) in [(0.0, [0.2, 4.0]), (0.4, [0.2, 4.0]), (0.4, [0.05, 2.0])] {
            let actuator = SeriesElastic {
                load_kg,
                spring: 400.0,
                gains,
            };
            let largest = actuator.largest_stiffness(damper);
            if damper == 0.0 {
                assert_relative("the spring", largest, 400.0, 1e-9);
            }
            for (factor, stable) in [(0.99, true), (1.01, false)] {
                let wall = format!(
                    "{sampling}stiffness_n_per_m = {:?}\ndissipation_n_s_mu_per_m = {damper}",
                    factor * largest
                );
                let report = actuator.ask("analyze-stability", &wall).expect("an answer");
                assert_eq!(
                    report["stable"], stable,
                    "{load_kg} {damper} {gains:?} {factor}: {report}"
                );
            }
        }
    }
}

/// A mass on a damper is one, whether named or by its matrices.
#[test]
fn a_plant_of_matrices_is_the_device_that_they_are_of() -> Tested {
    let rate = 3.5 / 0.065;
    let text = format!(
        "[state_space]\na = [[0, 1], [0, {:?}]]\nb = [0, {:?}]\nc = [1, 0]\ndelay_s = 0.5e-3\ncurrent_lag_s = 2e-4\n",
        -rate,
        1.0 / 0.065
    );
    let folder = written(&text);
    let file = folder.path().join("made.toml");
    let wall = "order = 0.5\nstiffness_n_per_m = 500\ndissipation_n_s_mu_per_m = 20\nsample_time_s = 1e-3\n";
    let plant = format!("{wall}plant_model = {file:?}\ndelay_s = 0.5e-3\n");
    let named = format!("{wall}{DEVICE}current_lag_s = 2e-4\n");
    for (analysis, keys) in [
        (
            "analyze-stability",
            ["gain_margin", "delay_margin_samples", "peak_sensitivity_db"].as_slice(),
        ),
        (
            "analyze-stability-region",
            &[
                "stiffness_max_n_per_m",
                "dissipation_at_stiffness_max_n_s_mu_per_m",
            ],
        ),
        ("analyze-sensitivity", &["peak_db", "theta_at_peak"]),
        (
            "analyze-passivity",
            &["required_damping_n_s_per_m", "largest_stiffness_n_per_m"],
        ),
    ] {
        let [of_plant, of_device] =
            [&plant, &named].map(|keys| ask(analysis, keys).expect("an answer"));
        for key in keys {
            has(&of_plant, key, number(&of_device, key), 1e-6);
        }
        assert!(
            of_plant["mass_kg"].is_null() && of_plant["delta"].is_null(),
            "{of_plant}"
        );
    }
    refused(
        r#"
        mass_kg = 1 | no effect beside `plant_model`: omit it
        current_lag_s = 1e-3 | has no effect beside
        alpha = 1 | with and without units
        "#,
        |more| ask("analyze-stability", &format!("{plant}{more}")),
    );
    std::fs::write(&file, "[device]\nmass_kg = 1\ndamping_n_s_per_m = 1\n")?;
    assert_refused(ask("analyze-stability", &plant), "has no [state_space]");
    // Where the hand acts elsewhere, nothing is proved; a loop that takes energy from it at one frequency is known.
    let hand = text.clone() + "b_hand = [1, 0]\n";
    std::fs::write(&file, &hand)?;
    let report = ask("analyze-passivity", &plant).expect("an answer");
    assert!(
        report["plant_damping_n_s_per_m"].is_null() && report["passive"] != true,
        "{report}"
    );
    std::fs::write(&file, hand.replace("b_hand = [1, 0]", "b_hand = [1]"))?;
    let error = ask("analyze-transparency", &plant);
    assert_refused(error, "as many as those of B: change `plant_model`");
    Ok(())
}

/// A spring beside a spring-pot.
fn pot(k: f64, b: f64, order: f64) -> TissueFile {
    let names = ["elastic_modulus_pa", "viscosity_pa_s_alpha", "order"];
    TissueFile::with("", names.into_iter(), &[k, b, order])
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_specimen_ends_where_its_line_leaves_the_map_of_all_walls() {
    // The first is the model of Kelvin and Voigt.
    for (order, share) in [(1.0, 0.1), (0.25, 2.0), (0.6, 0.01), (0.9, 0.7)] {
        let keys = format!("{DEVICE}duration_s = 2\n");
        let of_map = format!("sample_time_s = {T}\norders = [{order}]\npoints = 4\n{keys}");
        let map = ask("zwidth", &of_map).expect("a map");
        let boundary = &map["orders"][0]["boundary"];
        let grown = |k: f64, point: &Value| {
            let b = number(point, "dissipation");
            let report = pot(share * k, share * b, order).ask("zwidth", &keys);
            share * number(&report, "largest_scale")
        };
        let k = number(&boundary[2], "stiffness_max");
        // Both are bisected to 2e-4.
        assert_relative("on a line", grown(k, &boundary[2]), 1.0, 2e-4);
        // Without a spring it is at the end of the axis, where the last wall of the map has a soft one that takes its share.
        assert_relative("no spring", grown(0.0, &boundary[3]), 1.0, 0.01);
    }
}

#[test]
fn a_composed_tissue_grows_up_to_what_the_sums_of_its_model_say() {
    let kinds = [
        ModelKind::FractionalMaxwell,
        ModelKind::FractionalZener,
        ModelKind::FractionalPoyntingThomson,
    ];
    let mut random = Random(30);
    for case in 0..testkit::cases(9) {
        let kind = kinds[case % kinds.len()];
        let drawn = composed(&mut random, [10.0, 300.0], 0.5);
        let numbers = &drawn[..kind.parameters().len()];
        let keys = format!("{DEVICE}duration_s = 10\nsensor_noise_m = 1e-7\nseed = {case}\n");
        let report = TissueFile::of(kind, numbers).ask("zwidth", &keys);
        let model = Model::from_parameters(kind, numbers).expect("a model");
        let margin = gain_margin(|w| model.modulus((1.0 - w) / T));
        has(&report, "analysis_scale", margin, 1e-5);
        has(&report, "largest_scale", margin, 0.05);
        assert_eq!(report["disagreements"], 0, "{report}");
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn ten_controllers_grow_up_to_what_the_sums_of_their_functions_say() {
    let mut random = Random(102);
    for case in 0..testkit::cases(10) {
        let (text, law) = drawn(&mut random, case);
        let file = ControllerFile::of(&text, "full:1e-9");
        let report = file.ask("zwidth", &format!("{DEVICE}duration_s = 5\n"));
        let margin = gain_margin(law);
        assert_relative(&text, number(&report, "analysis_scale"), margin, 1e-5);
        assert_relative(&text, number(&report, "largest_scale"), margin, 0.05);
    }
}

/// The controller of the rig, whose device comes back to its start by a power of time.
#[test]
fn a_controller_whose_integral_is_slow_at_the_end_is_at_rest_when_it_holds_the_push() {
    let law = "[pid]\nproportional_gain = 2085.25\nintegral_gain_per_s_lambda = 68324.0\nintegral_order = 1.834\nderivative_gain_s_mu = 15.652\nderivative_order = 0.9906\n";
    let margin = gain_margin(|w| {
        let s = (1.0 - w) / T;
        2085.25 + 68324.0 * s.powf(-1.834) + 15.652 * s.powf(0.9906)
    });
    let report = ControllerFile::of(law, "full:1e-9").ask("zwidth", DEVICE);
    has(&report, "analysis_scale", margin, 1e-5);
    has(&report, "largest_scale", margin, 0.02);
}

/// m·s³ + b·s² + k·s + g·I is stable below g = b·k/(m·I), and m·τ·s³ + (m + b·τ)s² + b·s + g·K below g = (m + b·τ)b/(m·τ·K): both far below what
/// the newest sample bears. Near the edge a motion dies out slowly, so that trials have to be long.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn slow_controllers_grow_up_to_their_edge_and_those_of_the_wrong_sign_nowhere() {
    let integral = |gain: f64| {
        let law = format!(
            "[pid]\nproportional_gain = 0\nintegral_gain_per_s_lambda = {gain}\nintegral_order = 1\nderivative_gain_s_mu = 0\nderivative_order = 1\n"
        );
        ControllerFile::of(&law, "full")
    };
    let held =
        "mass_kg = 0.065\ndamping_n_s_per_m = 3.5\nhand_stiffness_n_per_m = 100\nduration_s = 20\n";
    let edge = 3.5 * 100.0 / (0.065 * 2000.0);
    let report = integral(2000.0).ask("zwidth", held);
    // The hold is half a sample late, which is little at 40 rad/s.
    has(&report, "analysis_scale", edge, 0.03);
    has(
        &report,
        "largest_scale",
        number(&report, "analysis_scale"),
        0.05,
    );
    let lag = ControllerFile::of("[transfer_function]\nfunction = \"10/(0.1s+1)\"\n", "full");
    let report = lag.ask(
        "zwidth",
        "mass_kg = 0.065\ndamping_n_s_per_m = 3.5\nduration_s = 20\n",
    );
    let edge = (0.065 + 0.35) * 3.5 / (0.065 * 0.1 * 10.0);
    has(&report, "analysis_scale", edge, 0.03);
    has(&report, "largest_scale", edge, 0.08);
    // By Routh: far below what the newest sample bears; and where less gain is unstable too.
    let device = "mass_kg = 0.065\ndamping_n_s_per_m = 3.5\n";
    let slow = ControllerFile::of("[transfer_function]\nfunction = \"400/(s+1)\"\n", "full");
    let report = slow.ask("zwidth", device);
    let edge = (0.065 + 3.5) * 3.5 / (0.065 * 400.0);
    has(&report, "analysis_scale", edge, 0.03);
    assert!(report["analysis_scale_from"].is_null(), "{report}");
    let pid = "[pid]\nproportional_gain = 400\nintegral_gain_per_s_lambda = 40000\nintegral_order = 1\nderivative_gain_s_mu = 5\nderivative_order = 1\n";
    let report = ControllerFile::of(pid, "full").ask("zwidth", device);
    let edge = (0.065 * 40e3 / 400.0 - 3.5) / 5.0;
    has(&report, "analysis_scale_from", edge, 0.07);
    // Damped so much that it does not get far in the time of a trial.
    for file in [
        integral(-2000.0),
        ControllerFile::of("[transfer_function]\nfunction = \"-10/(0.1s+1)\"\n", "full"),
    ] {
        let report = file.ask("zwidth", "mass_kg = 0.065\ndamping_n_s_per_m = 20\n");
        assert!(report["largest_scale"].is_null(), "{report}");
        assert!(report["orders"].as_array().is_some_and(Vec::is_empty));
    }
}

/// K, B and μ as a PID.
fn pd([k, b, order]: [f64; 3]) -> ControllerFile {
    let law = format!(
        "[pid]\nproportional_gain = {k:?}\nderivative_gain_s_mu = {b:?}\nderivative_order = {order:?}\n"
    );
    ControllerFile::of(&law, "full")
}

/// f = −B·D^μ x gives way for ever, beyond any distance, and is stable up to its gain margin.
#[test]
fn a_law_without_a_spring_is_judged_alike_by_trial_and_design() {
    for order in [1.0, 0.5] {
        let file = pd([0.0, 5.0, order]);
        let margin = gain_margin(|w| 5.0 * ((1.0 - w) / T).powf(order));
        let grown = file.ask("zwidth", DEVICE);
        has(&grown, "largest_scale", margin, 0.05);
        let report = file.ask("design", &format!("wish = \"controller\"\n{DEVICE}"));
        assert_eq!(report["controller"]["fits"], true, "{report}");
        let scale = number(&report["controller"], "largest_scale");
        assert_relative("design", scale, 0.5 * margin, 2e-4);
        // The order of the power is no order of the law.
        assert!(report["best"]["order"].is_null() && report["candidates"][0]["order"].is_null());
    }
}

/// Between scales that come to rest there are some at which an encoder keeps the loop alive: both searches have to see the same.
#[test]
fn a_controller_grows_as_far_as_the_specimen_that_it_equals_however_coarse_the_encoder_is() {
    let keys = format!("{DEVICE}encoder_resolution_m = 1e-5\n");
    let [of_pd, of_pot] = [
        pd([400.0, 5.0, 1.0]).ask("zwidth", &keys),
        pot(400.0, 5.0, 1.0).ask("zwidth", &keys),
    ]
    .map(|report| number(&report, "largest_scale"));
    assert_relative("scale", of_pd, of_pot, 1e-9);
}

#[test]
fn a_search_without_a_result_fails_whatever_it_searched_by() {
    let file = pd([-10.0, 0.0, 1.0]).0;
    let controller = file.path().join("made.toml");
    for (question, wish) in [("zwidth", ""), ("design", "wish = \"controller\"\n")] {
        let answer = answered(question, &format!("controller = {controller:?}\n{wish}"));
        let failed = answer.expect("an answer").require(&|_| ());
        assert!(
            matches!(failed, Err(Failure::Run(_))),
            "{question}: {failed:?}"
        );
    }
}

/// Stable on an ideal device up to 6.1 times 2000 N/m and 20 N·s/m, with delay and lag of a realistic one up to 2.4 times.
#[test]
fn what_a_realistic_device_does_not_bear_does_not_fit() {
    let ideal = "mass_kg = 0.065\ndamping_n_s_per_m = 3.5\n";
    let of_pot = format!("wish = \"tissue\"\norders = [1]\n{ideal}");
    for (k, fits) in [(1500.0, true), (5500.0, false)] {
        let by_pd =
            pd([k, 0.01 * k, 1.0]).ask("design", &format!("wish = \"controller\"\n{ideal}"));
        let by_pot = pot(k, 0.01 * k, 1.0).ask("design", &of_pot);
        for (report, law) in [(by_pd, "controller"), (by_pot, "tissue")] {
            assert!(!report["best"].is_null(), "{k}: {report}");
            assert_eq!(
                report["realistic"]["analysis_stable"], fits,
                "{k}: {report}"
            );
            assert_eq!(report[law]["fits"], fits, "{k}: {report}");
        }
    }
}

#[test]
fn a_controller_that_answers_a_new_position_with_a_pull_has_no_region() {
    // K + B/T.
    let pulls = pd([400.0, -5.0, 1.0]).asked("analyze-stability-region", DEVICE);
    assert_refused(
        pulls,
        "-4600 is not above 0: this is the force against a new position, N/m; change `controller`",
    );
}

#[test]
fn what_a_controller_that_is_tried_does_not_have_is_refused_in_a_line() {
    let made = ControllerFile::of("[transfer_function]\nfunction = \"10/(0.1s+1)\"\n", "full");
    refused(
        r#"
        sample_time_s = 2e-3 | 0.002 s is not the 0.001 s of the controller
        orders = [1] | no effect beside `controller`: omit it
        scheme = "full" | has no effect beside
        tissue = "fish-muscle" | has no effect beside
        area_m2 = 1 | belongs to a tissue
        one_sided = true | pulls too: omit it
        device = "serial:x" | is tried on the simulated device
        "#,
        |keys| made.asked("zwidth", keys),
    );
    refused(
        r#"
        sample_time_s = 2e-3 | 0.002 s is not the 0.001 s of the controller
        orders = [1] | belongs to another wish
        scheme = "full" | belongs to another wish
        one_sided = true | belongs to another wish
        frequency_hz = 1 | belongs to another wish
        tissue = "fish-muscle" | belongs to the wish tissue
        "#,
        |keys| made.asked("design", &format!("wish = \"controller\"\n{keys}")),
    );
    refused(
        r#"
        wish = "controller" | give `controller`
        controller = "x.toml" | belongs to the wish controller
        front = true\ncontroller = "x.toml" | a design without `front`
        "#,
        |keys| ask("design", keys),
    );
    let missing = ask("zwidth", "controller = \"no-such.toml\"");
    assert_refused(missing, "no-such.toml");
}

/// One step of 0.1 mm through 200 N/m of an element that hardly flows is 40 mN; its B alone would make it 0.25 N, the most that is excused.
#[test]
fn a_step_of_the_encoder_counts_as_what_the_whole_memory_makes_of_it() {
    let slow = TissueFile::of(ModelKind::FractionalMaxwell, &[1e6, 0.9, 200.0, 0.1]);
    let report = slow.ask(
        "design",
        &format!("{DEVICE}wish = \"tissue\"\norders = [0.9]\nhand_stiffness_n_per_m = 100\nencoder_resolution_m = 1e-4\n"),
    );
    let limit = number(&report["simulated"], "force_std_limit_n");
    assert_relative("5 % of the push", limit, 0.05, 1e-12);
}

/// K + B·D^μ, whether a specimen or a PD^μ says it.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_design_of_a_controller_is_that_of_the_specimen_that_it_equals() {
    let law = |scale: f64| {
        format!(
            "[pid]\nproportional_gain = {}\nintegral_gain_per_s_lambda = 0\nintegral_order = 1\nderivative_gain_s_mu = {}\nderivative_order = 0.3\n",
            300.0 * scale,
            40.0 * scale
        )
    };
    let by_controller = |scale: f64, more: &str| {
        let keys = format!("{DEVICE}wish = \"controller\"\nencoder_resolution_m = 1e-5\n{more}");
        ControllerFile::of(&law(scale), "full:1e-9").ask("design", &keys)
    };
    for more in [
        "",
        "require = \"passive\"\n",
        "require = \"every-motion\"\n",
    ] {
        let found = by_controller(1.0, more);
        let keys = format!(
            "{DEVICE}wish = \"tissue\"\nencoder_resolution_m = 1e-5\norders = [0.3]\nscheme = \"full:1e-9\"\n{more}"
        );
        let wanted = pot(300.0, 40.0, 0.3).ask("design", &keys);
        assert_eq!(
            found["controller"]["fits"], wanted["tissue"]["fits"],
            "{found}"
        );
        let scale = number(&found["controller"], "largest_scale");
        assert_relative(
            "scale",
            scale,
            number(&wanted["tissue"], "largest_scale"),
            1e-5,
        );
        let of_a_wall = ["order", "alpha", "beta", "effective_damping_n_s_per_m"];
        for (key, wanted) in wanted["candidates"][0].as_object().expect("a candidate") {
            let found = &found["candidates"][0][key];
            match wanted
                .as_f64()
                .filter(|_| !of_a_wall.contains(&key.as_str()))
            {
                _ if key.starts_with("stiffness_") || key.starts_with("dissipation_") => {
                    assert!(found.is_null(), "{key}: {found}");
                }
                Some(wanted) => {
                    let tolerance = if key.starts_with("tried") { 1e-2 } else { 1e-5 };
                    assert_relative(key, found.as_f64().expect(key), wanted, tolerance);
                }
                None => {}
            }
        }
        if more.is_empty() {
            // Three digits are enough to tell.
            let largest = found["controller"]["largest"].as_str().expect("a law");
            let gain: f64 = largest
                .split('+')
                .next()
                .and_then(|gain| gain.parse().ok())
                .expect("a gain");
            assert_relative("gain", gain, 300.0 * scale, 1e-3);
            for (factor, fits) in [(0.99, true), (1.01, false)] {
                let report = by_controller(scale * factor, more);
                assert_eq!(report["controller"]["fits"], fits, "{factor}: {report}");
                assert_eq!(report["best"].is_null(), !fits);
            }
        }
    }
}

#[test]
fn a_controller_with_an_integral_has_a_margin_both_ways_and_no_proof() {
    let law = |gain: f64| {
        format!(
            "[pid]\nproportional_gain = {}\nintegral_gain_per_s_lambda = {}\nintegral_order = 1\nderivative_gain_s_mu = {}\nderivative_order = 1\n",
            300.0 * gain,
            30_000.0 * gain,
            4.0 * gain
        )
    };
    let [least, most] = around(|w| {
        let s = (1.0 - w) / T;
        300.0 + 30_000.0 / s + 4.0 * s
    });
    let ask = |gain: f64, more: &str| {
        let keys = format!("{DEVICE}wish = \"controller\"\ngain_margin = 1.5\n{more}");
        ControllerFile::of(&law(gain), "full:1e-9").asked("design", &keys)
    };
    for (gain, fits, reason) in [
        (1.4 * least, false, "unstable below 0.7143 times the gain"),
        (1.7 * least, true, ""),
        (most / 1.4, false, "the gain is too large"),
    ] {
        let report = ask(gain, "encoder_resolution_m = 1e-6\n").expect("an answer");
        assert_eq!(report["controller"]["fits"], fits, "{gain}: {report}");
        let found = number(&report["controller"], "largest_scale");
        assert_relative("scale", found, most / (1.5 * gain), 2e-4);
        let from = number(&report["controller"], "analysis_scale_from");
        assert_relative("from", from, least / gain, 1e-5);
        let candidate = &report["candidates"][0];
        assert_eq!(candidate["reason"].as_str().unwrap_or(""), reason);
        assert_eq!(candidate["passive"], false);
        assert!(candidate["force_noise_rms_n"].is_null());
        assert_eq!(report["best"].is_null(), !fits);
    }
    let error = ask(1.0, "require = \"every-motion\"\n").expect_err("no proof");
    assert!(error.contains("an integral has no such proof"), "{error}");
    let keys = format!("{DEVICE}wish = \"controller\"\nrequire = \"passive\"\n");
    let report = ControllerFile::of(&law(1.0), "full").ask("design", &keys);
    let reason = report["candidates"][0]["reason"].as_str();
    assert_eq!(reason, Some("no damping is enough for an integral"));
}
