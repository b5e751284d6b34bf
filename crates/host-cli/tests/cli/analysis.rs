//! `analyze` and `zwidth`: the contract's keys, known numbers, refusals.

mod zwidth;

use super::process::{Place, number};
use serde_json::Value;

/// One analysis, as JSON.
fn analyze(line: &str) -> Value {
    Place::new()
        .run(&format!("analyze {line} --json"))
        .succeeded()
        .json()
}

fn close(have: f64, want: f64, tolerance: f64) -> bool {
    (have - want).abs() <= tolerance
}

#[test]
fn a_wall_is_stable_below_the_known_boundary_and_not_above() {
    // μ = 1, exact, δ = 0: α < 2β(2 − β)/(2 + β) = 2/3 at β = 1.
    let wall = |alpha| analyze(&format!("stability --order 1 --alpha {alpha} --beta 1"));
    let inside = wall(0.666_666);
    assert_eq!(inside["stable"], true, "{inside}");
    assert_eq!(inside["encirclements"], 0);
    assert!(number(&inside, "gain_margin") > 1.0);
    let outside = wall(0.666_667);
    assert_eq!(outside["stable"], false, "{outside}");
    assert_eq!(outside["encirclements"], 2);
    for key in [
        "order",
        "scheme",
        "alpha",
        "beta",
        "delta",
        "gamma",
        "delay_samples",
    ] {
        assert!(!outside[key].is_null(), "{key}");
    }
}

#[test]
fn units_and_no_units_give_the_same_loop() {
    // m = 65 g, T = 2 ms: α = K·4e-6/0.065, β = B·T^1.5/m, δ = 3.5·0.002/0.065.
    let with = analyze(
        "stability --order 0.5 --mass 65g --damping 3.5 --sample-time 2ms --stiffness 3N/mm --dissipation 100",
    );
    let (alpha, beta) = (number(&with, "alpha"), number(&with, "beta"));
    assert!(close(alpha, 3000.0 * 4e-6 / 0.065, 1e-15), "{alpha}");
    assert!(
        close(beta, 100.0 * 0.002_f64.powf(1.5) / 0.065, 1e-15),
        "{beta}"
    );
    let delta = number(&with, "delta");
    let without = analyze(&format!(
        "stability --order 0.5 --alpha {alpha} --beta {beta} --delta {delta}"
    ));
    // JSON readers round numbers to the last digit but one.
    let margins = (
        number(&with, "gain_margin"),
        number(&without, "gain_margin"),
    );
    assert!(close(margins.0, margins.1, 1e-12), "{margins:?}");
}

#[test]
fn an_analysis_leaves_a_picture_and_a_table_without_nan() {
    let place = Place::new();
    for (line, stem) in [
        ("stability-region --order 0.5 --delta 0.1", "region"),
        (
            "sensitivity --order 0.5 --alpha 0.1 --beta 0.3 --delta 0.1",
            "sensitivity",
        ),
        (
            "environment --order 2 --stiffness 10N/mm --dissipation 100 --sample-time 1ms",
            "environment",
        ),
        (
            "transparency --order 0.5 --stiffness 50 --dissipation 1 --mass 0.65kg --damping 3.5 --sample-time 1ms",
            "transparency",
        ),
    ] {
        place
            .run(&format!("analyze {line} --out here --quiet"))
            .succeeded();
        for extension in ["csv", "svg"] {
            let text = place.text(&format!("here/{stem}.{extension}"));
            assert!(text.len() > 500, "{stem}.{extension}");
            assert!(
                !text.contains("NaN") && !text.contains("inf,"),
                "{stem}.{extension}"
            );
        }
        assert!(!place.read(&format!("here/{stem}.png")).is_empty());
    }
}

/// Ranges are tested with `haptic-analysis`.
#[test]
fn questions_without_an_answer_are_refused_with_the_option_to_change() {
    Place::new().refuses(
        "
        analyze stability --order 1 --alpha 0.1 => --beta is missing
        analyze stability --order 1 --alpha -0.1 --beta 1 => --alpha -0.1: alpha = -0.1 is not from 0 to 1e12: change it
        analyze stability --order 1 --mass 1e9 => --mass 1e9: mass_kg = 1e9 is not
        analyze stability mas=3 => mas=3 | is not KEY=VALUE with one of the keys order, scheme
        analyze stability --order 1 order=1 => order=1: is given twice
        analyze sensitivity --order 1 --points 1 => --points = 1 is not a whole number from 2 to 100000
        analyze teleoperation architecture=none => none | is not one of position-position
        analyze stability --order 0.5 --scheme oustaloup:3:1:100 --alpha 0.1 --beta 0.1 => oustaloup:3:1:100 | Hz | --sample-time
        analyze sensitivity --order 1 --alpha 3 --beta 1 => not stable
        analyze stability --order 1 --alpha 0.1 --beta 0.1 --delay 1ms
            => --delay 0.001 s is a time, and the loop has none: give --sample-time
        ",
    );
}

const DEVICE: &str = "--mass 65g --damping 3.5 --sample-time 1ms";
const WALL: &str = "--order 1 --stiffness 8N/mm --dissipation 15";

#[test]
fn a_delay_is_the_same_in_samples_and_in_seconds_and_a_lag_costs_margin() {
    let at = |path: &str| analyze(&format!("stability {WALL} {DEVICE} {path}"));
    let margin = |path: &str| number(&at(path), "gain_margin");
    let both = at("--delay 1.3ms --current-lag 0.5ms");
    assert!(
        (number(&both, "delay_samples") - 1.3).abs() < 1e-12,
        "{both}"
    );
    assert!((number(&both, "delay_s") - 1.3e-3).abs() < 1e-15, "{both}");
    assert!(
        (number(&both, "current_lag_s") - 0.5e-3).abs() < 1e-15,
        "{both}"
    );
    assert!(
        (number(&both, "current_lag_samples") - 0.5).abs() < 1e-12,
        "{both}"
    );
    assert!((margin("--delay 0.5ms") / margin("--delay-samples 0.5") - 1.0).abs() < 1e-12);
    let margins = ["", "--delay-samples 0.5", "--delay-samples 1"].map(margin);
    assert!(
        margins[0] > margins[1] && margins[1] > margins[2],
        "{margins:?}"
    );
    assert!(margin("--current-lag 0.4ms") < margins[0]);
    // Without units a sample time of 1 makes seconds of samples.
    let (alpha, beta, delta) = (
        number(&both, "alpha"),
        number(&both, "beta"),
        number(&both, "delta"),
    );
    let plain = analyze(&format!(
        "stability --order 1 --alpha {alpha} --beta {beta} --delta {delta} --sample-time 1s \
         --delay-samples 1.3 --current-lag 0.5s"
    ));
    assert_eq!(plain["stable"], both["stable"]);
    // Nothing is known in seconds without a sample time.
    let plain =
        analyze("stability --order 1 --alpha 0.05 --beta 0.1 --delta 0.1 --delay-samples 0.5");
    assert!(
        plain["delay_s"].is_null() && plain["current_lag_s"].is_null(),
        "{plain}"
    );
    assert_eq!(number(&plain, "delay_samples"), 0.5);
}
