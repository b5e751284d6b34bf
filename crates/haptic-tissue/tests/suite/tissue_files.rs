//! Tissue files of every model: read, written, read back; refused with line and reason.

use haptic_tissue::{Library, Material, Model, ModelKind, ParameterRange, Source, ValidRange};
use std::path::Path;
use testkit::assert_relative;

/// Values that are no round numbers.
fn model(kind: ModelKind, seed: f64) -> Model {
    let mut order = 1.0;
    let mut time = 1e-3;
    let mut values = Vec::new();
    let columns = kind.parameters();
    let repeat = if kind == ModelKind::Prony { 5 } else { 1 };
    for branch in 0..repeat {
        for parameter in columns {
            if branch > 0 && !parameter.for_each_branch {
                continue;
            }
            order -= 0.3 * seed;
            time *= 1.0 + 10.0 * seed;
            values.push(match parameter.name {
                "branch_times_s" => time,
                _ if parameter.range == ParameterRange::Order => order,
                _ => 1e4 * seed / time,
            });
        }
    }
    Model::from_parameters(kind, &values).expect("valid")
}

#[test]
fn a_written_file_reads_back_to_the_same_bits() {
    for kind in ModelKind::ALL {
        for seed in [0.1, 1.0 / 3.0, 0.777] {
            let source = Source {
                citation: "me \"myself\" \\ and I".to_owned(),
                conditions: "21 °C\ntwo lines\ttab".to_owned(),
                checked: kind == ModelKind::Prony,
                date: "2026-11-20".to_owned(),
                sample: "one cube, 1 cm³".to_owned(),
                residual: "rms 0.0045 in log modulus".to_owned(),
                ..Source::default()
            };
            let range = ValidRange {
                time_from_s: Some(seed * 1e-7),
                time_to_s: Some(981.0),
                strain_to: Some(0.1 / 3.0),
                ..ValidRange::default()
            };
            let made = Material::new("gel-1", "a \"gel\" = 1", model(kind, seed), source);
            let made = made.expect("valid").with_range(range);
            let text = made.to_toml();
            let read = Material::parse(Path::new("gel.toml"), &text).expect(&text);
            assert_eq!(read, made, "{text}");
            assert_eq!(read.to_toml(), text);
        }
    }
}

#[test]
fn a_file_without_a_model_keeps_its_three_numbers() {
    for (modulus, viscosity, order, kind) in [
        ("0.0", "8650.0", "0.2247", ModelKind::SpringPot),
        ("100.0", "5.0", "0.3", ModelKind::FractionalKelvinVoigt),
        ("100.0", "5.0", "1.0", ModelKind::KelvinVoigt),
        ("100.0", "5.0", "0.0", ModelKind::Spring),
        ("100.0", "0.0", "0.5", ModelKind::Spring),
    ] {
        let text = format!(
            "name = \"gel\"\ndescription = \"\"\n\n[parameters]\nelastic_modulus_pa = {modulus}\n\
             viscosity_pa_s_alpha = {viscosity}\norder = {order}\n\n[source]\ncitation = \"\"\nconditions = \"\"\n\
             checked = false\n"
        );
        let gel = Material::parse(Path::new("gel.toml"), &text).expect("valid");
        let have = [
            gel.elastic_modulus_pa(),
            gel.viscosity_pa_s_alpha(),
            gel.order(),
        ];
        let want = [modulus, viscosity, order].map(|number| number.parse().ok());
        assert_eq!(have, want);
        assert_eq!(gel.model.kind(), kind);
        assert_eq!(gel.to_toml(), text);
    }
}

const GEL: &str = "name = \"gel\"\ndescription = \"a gel\"\n\n[parameters]\nelastic_modulus_pa = 100\n\
    viscosity_pa_s_alpha = 5.0\norder = 0.3\n\n[source]\ncitation = \"me, 2026\"\nconditions = \"21 °C\"\nchecked = true\n";

const MUSCLE: &str = "name = \"muscle\"\ndescription = \"\"\nmodel = \"fractional-maxwell\"\n\n[parameters]\n\
    viscosity_pa_s_alpha = 876e3\norder = 0.675\nsecond_viscosity_pa_s_beta = 22100\nsecond_order = 0.11\n\n\
    [range]\ntime_from_s = 0.014\ntime_to_s = 981\n\n[source]\ncitation = \"\"\nconditions = \"\"\nchecked = false\n";

const SERIES: &str = "name = \"rubber\"\ndescription = \"\"\nmodel = \"prony\"\n\n[parameters]\n\
    elastic_modulus_pa = 0\nbranch_moduli_pa = [3, 2.5]\nbranch_times_s = [0.1, 7]\n\n[source]\ncitation = \"\"\n\
    conditions = \"\"\nchecked = false\n";

#[test]
fn a_model_of_elements_in_series_has_no_elastic_modulus() {
    let muscle = Material::parse(Path::new("muscle.toml"), MUSCLE).expect("valid");
    assert_eq!(muscle.model.kind(), ModelKind::FractionalMaxwell);
    assert_eq!(muscle.order(), None);
    assert_eq!(muscle.range.time_to_s, Some(981.0));
    assert!(Material::parse(Path::new("rubber.toml"), SERIES).is_ok());
    assert!(Material::parse(Path::new("gel.toml"), GEL).is_ok());
}

/// A good file, what of it is replaced, by what, and how the refusal begins.
const WRONG: &str = r#"
gel | order = 0.3 | order = 1.3 | x.toml:7: order = 1.3 is not in [0, 1]
gel | order = 0.3 | order = nan | x.toml:7: order = NaN is not in [0, 1]
gel | = 5.0 | = -5.0 | x.toml:6: viscosity_pa_s_alpha = -5 Pa·s^α is not a finite number of at least 0
gel | = 100 | = "x" | x.toml:5: expected a number or a list of numbers
gel | order = 0.3 |  | x.toml:4: missing field `order` of a tissue without `model`
gel | order = 0.3 | ordre = 0.3 | x.toml:7: ordre is not a parameter of a tissue without `model`, which has elastic_modulus_pa,
gel | "gel" | "Gel 1" | x.toml:1: name "Gel 1" is not made of
gel | [source] | [source | x.toml:9:
muscle | fractional-maxwell | jelly | x.toml:3: model "jelly" is not known: use one of spring, dashpot,
muscle | order = 0.675 | order = 1.5 | x.toml:7: order = 1.5 is not in [0, 1]
muscle | = 22100 | = -1 | x.toml:8: second_viscosity_pa_s_beta = -1 Pa·s^β is not above 0 and finite
muscle | = 22100 | = nan | x.toml:8: second_viscosity_pa_s_beta = NaN Pa·s^β
muscle | = 22100 | = true | x.toml:8: expected a number or a list of numbers
muscle | = 22100 | = [1, 2] | x.toml:8: second_viscosity_pa_s_beta is a list: give one number
muscle | second_order = 0.11 |  | x.toml:5: missing field `second_order` of the model fractional-maxwell
muscle | second_order | third_order | x.toml:9: third_order is not a parameter of the model fractional-maxwell, which has
muscle | 0.11 | 0.8 | x.toml:5: order = 0.675 is below second_order = 0.8: exchange the two elements
muscle | 0.11 | 0.675 | x.toml:5: both elements have the order 0.675
muscle | = 981 | = 0.001 | x.toml:11: time_to_s = 0.001 is below time_from_s = 0.014: swap them
muscle | = 981 | = inf | x.toml:11: time_to_s = inf is not a finite number of at least 0
muscle | time_to_s | time_until_s | x.toml:13: unknown field "time_until_s"
series | [0.1, 7] | [0.1] | x.toml:5: branch_moduli_pa has 2 numbers and branch_times_s 1: each branch has one of each
series | [0.1, 7] | [7, 0.1] | x.toml:5: branch_times_s = 0.1 s is not above the one before it
series | [0.1, 7] | 7 | x.toml:8: branch_times_s is not a list: give one number for each branch
series | [3, 2.5] | [3, 0] | x.toml:7: branch_moduli_pa = 0 Pa is not above 0 and finite
"#;

#[test]
fn a_wrong_file_is_refused_with_line_and_reason() {
    for [file, from, to, want] in testkit::table(WRONG) {
        let (from, want) = (&from[..], &want[..]);
        let text = match &file[..] {
            "gel" => GEL,
            "muscle" => MUSCLE,
            _ => SERIES,
        };
        assert!(text.contains(from), "{from}");
        let error = Material::parse(Path::new("x.toml"), &text.replacen(from, &to, 1));
        let have = error.expect_err(&to).to_string();
        assert!(have.starts_with(want), "have {have}\nwant {want}");
        assert!(!have.contains('\n'), "{have}");
    }
}

#[test]
fn a_name_that_is_none_is_refused() {
    let spring = model(ModelKind::Spring, 0.1);
    let error = Material::new("Gel 1", "", spring, Source::default());
    let message = error.expect_err("a name").to_string();
    assert!(message.starts_with("name \"Gel 1\""), "{message}");
}

/// A tissue of the library.
fn known(name: &str) -> Material {
    let library = Library::load(None).expect("valid");
    library.find(name).expect("known")
}

#[test]
fn other_numbers_of_the_two_elements_are_those_of_the_closed_form_and_are_named() {
    let prostate = known("prostate-cancerous");
    let other = prostate.with_elements([Some(300.0), None, Some(0.5)]);
    let other = other.expect("one order");
    // E + V·t^(−1/2)/Γ(1/2), with Γ(1/2)² = π.
    for time_s in [0.01, 1.0, 40.0] {
        let have = other.model.relaxation_moduli(&[time_s])[0];
        let want = 300.0 + 8650.0 / (core::f64::consts::PI * time_s).sqrt();
        assert_relative("have", have, want, 1e-12);
    }
    assert_eq!(other.name, "prostate-cancerous-changed");
    let words = "changed to elastic_modulus_pa = 300, order = 0.5";
    assert!(other.description.ends_with(words), "{}", other.description);
    // A log repeats the change on what was changed already.
    let again = other.with_elements([Some(300.0), None, Some(0.5)]);
    assert_eq!(again.expect("the same"), other);
    let read = Material::parse(Path::new("log"), &other.to_toml());
    assert_eq!(read.expect("a file").model, other.model);
    let range = known("zebrafish-gray-matter");
    assert_ne!(range.range, ValidRange::default());
    let range = range.with_elements([None, None, Some(0.9)]);
    assert_eq!(range.expect("one order").range, ValidRange::default());
}

#[test]
fn a_tissue_without_a_single_order_has_none_to_change() {
    for (name, given, why) in [
        (
            "fish-muscle",
            [None, None, Some(0.5)],
            "is a fractional-maxwell, which has no single order",
        ),
        (
            "mucus",
            [Some(5.0), None, None],
            "is a fractional-kelvin-voigt, which has no single order",
        ),
        (
            "spring",
            [None, None, Some(0.5)],
            "tissue \"spring\" has no spring-pot",
        ),
        (
            "liver",
            [None, Some(20.0), None],
            "tissue \"liver\" has no spring-pot",
        ),
        (
            "dashpot",
            [None, Some(0.0), None],
            "elastic_modulus_pa = 0 Pa is not above 0",
        ),
        (
            "spring",
            [Some(-1.0), None, None],
            "elastic_modulus_pa = -1 Pa is not above 0",
        ),
    ] {
        let error = known(name)
            .with_elements(given)
            .expect_err(name)
            .to_string();
        assert!(error.contains(why), "{name}: {error}");
    }
    let all = Library::load(None).expect("valid");
    let with_one = all.materials().iter();
    let with_one = with_one.filter(|one| one.with_elements([None, None, Some(0.3)]).is_ok());
    let names: Vec<&str> = with_one.map(|one| one.name.as_str()).collect();
    let prostates = ["prostate-cancerous", "prostate-healthy"];
    let others = [
        "passive-muscle",
        "zebrafish-gray-matter",
        "dashpot",
        "spring-pot",
    ];
    assert_eq!(names, [&prostates[..], &others].concat());
}
