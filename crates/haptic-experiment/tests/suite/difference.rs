//! The difference that a hand should feel, against closed forms.

use crate::design::{has, number};
use haptic_experiment::question::Question;
use serde_json::Value;
use std::{fs, path::Path, sync::Arc};
use testkit::{assert_refused, assert_relative};

/// A device that hardly adds to what is felt, sampled so fast that hold and steps do not count.
const LIGHT: &str = "mass_kg = 1e-9\ndamping_n_s_per_m = 1e-9\nsample_time_s = 1e-7";

fn law(order: f64, stiffness: f64, dissipation: f64) -> String {
    format!(
        "{LIGHT}\norder = {order}\nstiffness_n_per_m = {stiffness}\ndissipation_n_s_mu_per_m = {dissipation}\n"
    )
}

/// The answer for a law, another one in a file, and a hand.
fn difference(law: &str, other: Option<&str>, hand: &str) -> Result<Value, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let mut text = format!("[analyze-difference]\n{law}{hand}\n");
    if let Some(other) = other {
        fs::write(folder.path().join("other.toml"), format!("[wall]\n{other}")).expect("written");
        text += "other = \"other.toml\"\n";
    }
    let question = Question::parse(&folder.path().join("asked.toml"), &text)
        .map_err(|error| error.to_string())?;
    let answer = question
        .answer(&|_| (), &Arc::default(), &|_| ())
        .map_err(|error| error.to_string())?;
    Ok(serde_json::to_value(answer).expect("JSON"))
}

#[test]
fn springs_and_dampers_differ_as_their_numbers_do() {
    let near = |name: &str, found: &Value, want: f64| {
        assert_relative(name, number(found, "difference"), want, 1e-5);
    };
    let spring = |k: f64| law(0.0, k, 0.0);
    // 10 N/m of 100 N/m, of which 5 % are noticed.
    let found =
        difference(&spring(100.0), Some(&spring(110.0)), "weber_share = 0.05").expect("an answer");
    near("springs", &found["other"], 2.0);
    assert_eq!(found["other"]["felt"], true);
    // The other way round it is 10 of 110.
    let found =
        difference(&spring(110.0), Some(&spring(100.0)), "weber_share = 0.05").expect("an answer");
    near("not symmetric", &found["other"], 200.0 / 110.0);
    // In free air the least force counts: 20 mN at 10 mm are 2 N/m, of which a tenth is noticed.
    let found = difference(&spring(1e-6), Some(&spring(0.15)), "").expect("an answer");
    near("free air", &found["other"], 0.75);
    assert_eq!(found["other"]["felt"], false);
    // A damper of 2 N·s/m instead of 1 beside 1 N/m: 2π·1 Hz·1 of |1 + 2π·1 Hz·j|·0.1, most at the highest frequency.
    let hand = "low_hz = 0.5\nhigh_hz = 1\nleast_force_n = 1e-6";
    let found =
        difference(&law(1.0, 1.0, 1.0), Some(&law(1.0, 1.0, 2.0)), hand).expect("an answer");
    let omega = std::f64::consts::TAU;
    near(
        "dampers",
        &found["other"],
        omega / (0.1 * 1_f64.hypot(omega)),
    );
    assert_eq!(
        (
            &found["other"]["part"],
            number(&found["other"], "frequency_hz")
        ),
        (&Value::from("damping"), 1.0)
    );
}

#[test]
fn the_best_spring_and_damper_of_a_law_that_is_one_are_its_own_and_of_another_none_is_nearer() {
    let answer = difference(&law(1.0, 300.0, 2.0), None, "").expect("an answer");
    has(&answer, "best_stiffness_n_per_m", 300.0, 1e-6);
    has(&answer, "best_damping_n_s_per_m", 2.0, 1e-6);
    assert!(answer["other"].is_null());
    // In every loop: what hold, delay and scheme do to the law, they do to its rival. It is stable where `analyze stability` says so.
    for (delay_s, damping, scheme, stable) in [
        (1e-3, 1.922, "exact", true),
        (0.0, 4.0, "grunwald:1000", true),
        (8e-3, 1.922, "full:1e-6", false),
    ] {
        let device = format!(
            "mass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 1e-3\ndelay_s = {delay_s}\nscheme = \"{scheme}\""
        );
        let wall = format!(
            "{device}\norder = 1\nstiffness_n_per_m = 1012\ndissipation_n_s_mu_per_m = {damping}\n"
        );
        let answer = difference(&wall, None, "").expect("an answer");
        assert!(
            number(&answer["spring_and_damper"], "difference") < 1e-6,
            "{answer}"
        );
        has(&answer, "best_stiffness_n_per_m", 1012.0, 1e-7);
        has(&answer, "best_damping_n_s_per_m", damping, 1e-7);
        assert_eq!(answer["best_stable"], stable, "{answer}");
    }
    // K + B·s^0.5: the same as another law, it differs as much as it is said to, and no spring and damper beside it differs less.
    let fractional = law(0.5, 100.0, 30.0);
    let found = difference(&fractional, None, "").expect("an answer");
    let best = number(&found["spring_and_damper"], "difference");
    let [k, b] =
        ["best_stiffness_n_per_m", "best_damping_n_s_per_m"].map(|key| number(&found, key));
    let as_other = |k: f64, b: f64| {
        let found = difference(&fractional, Some(&law(1.0, k, b)), "").expect("an answer");
        number(&found["other"], "difference")
    };
    assert_relative("as another law", as_other(k, b), best, 1e-5);
    for (k_by, b_by) in [
        (1.02, 1.0),
        (0.98, 1.0),
        (1.02, 1.1),
        (0.98, 0.9),
        (1.02, 0.9),
        (0.98, 1.1),
        (1.0, 1.3),
        (1.0, 0.7),
    ] {
        assert!(
            as_other(k * k_by, b * b_by) >= best * (1.0 - 1e-6),
            "{k_by} {b_by}"
        );
    }
}

#[test]
fn what_has_no_difference_is_refused_in_a_line() {
    let spring = law(0.0, 100.0, 0.0);
    for (other, hand, want) in [
        (
            None,
            "weber_share = 0",
            "weber_share = 0 is not above 0 and at most 1",
        ),
        (
            None,
            "hand_amplitude_m = 0",
            "hand_amplitude_m = 0 is not above 0",
        ),
        (
            None,
            "low_hz = 5\nhigh_hz = 0.5",
            "5 to 0.5 Hz do not rise within 5000000 Hz, half the sample rate",
        ),
        (Some("order = 1\n"), "", "sample_time_s"),
    ] {
        assert_refused(difference(&spring, other, hand), want);
    }
    let both = "[analyze-difference]\nlaw = \"a.toml\"\norder = 1";
    assert_refused(Question::parse(Path::new("form"), both), "a.toml");
}
