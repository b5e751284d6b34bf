//! `design`: walls that are what they promise.

mod files;

use crate::process::{Place, number, row, says};
use serde_json::Value;

/// Runs a design that must succeed without a word on standard error.
fn design(place: &Place, options: &str) -> Value {
    let ended = place.run(&format!("design --json --out design {options}"));
    ended.succeeded_with_warnings().json()
}

/// Runs the designed experiment, with its stiffness `factor` times as large.
fn settles(place: &Place, factor: f64) -> bool {
    let text = place.text("design/design.toml");
    let line = |line: &str| match line.strip_prefix("stiffness_n_per_m = ") {
        Some(stiffness) => {
            let stiffness: f64 = stiffness.parse().expect("a number");
            format!("stiffness_n_per_m = {:?}", factor * stiffness)
        }
        None => line.to_owned(),
    };
    let lines: Vec<String> = text.lines().map(line).collect();
    place.write("trial.toml", lines.join("\n"));
    let ended = place.run("run trial.toml --json --out trial --overwrite");
    // The file says that the wall must be stable.
    let code = ended.code.expect("ended by itself");
    let report = ended.json();
    let stable = report["stable"].as_bool().expect("a verdict");
    let agrees = report["analysis_agrees"].as_bool().expect("a comparison");
    assert_eq!(code == 0, stable && agrees, "{ended}");
    stable
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_stiffest_wall_is_stable_and_three_times_it_is_not() {
    for device in [
        "",
        "--delay 1ms",
        "--delay 1.3ms current_lag=0.5ms",
        "--hand-stiffness 400 --sample-time 1ms",
    ] {
        let place = Place::new();
        let report = design(&place, device);
        let best = &report["best"];
        assert!(number(best, "margin") >= 2.0, "{device}: {report}");
        assert_eq!(report["simulated"]["stable"], true, "{device}");
        assert_eq!(report["experiment"], "design/design.toml");
        for candidate in report["candidates"].as_array().expect("an array") {
            if let Some(stiffness) = candidate["stiffness"].as_f64() {
                assert!(
                    stiffness <= number(best, "stiffness"),
                    "{device}: {candidate}"
                );
            }
        }
        assert!(settles(&place, 1.0), "{device}");
        assert!(!settles(&place, 3.0), "{device}");
        let files = ["csv", "png", "svg", "toml"].map(|e| format!("design/design.{e}"));
        assert!(files.iter().all(|file| place.files().contains(file)));
    }
}

#[test]
fn what_cannot_be_is_said_in_words() {
    let place = Place::new();
    let line = "design --require passive --damping 0 --out design";
    // Nothing was found: the report, and exit code 1.
    let ended = place.run(line).failed(1);
    assert!(
        ended.error().contains("no candidate fulfils the wish"),
        "{ended}"
    );
    let words = "no passive wall of this order on this device: it has no damping";
    assert_eq!(ended.stdout.matches(words).count(), 10, "{ended}");
    assert!(!ended.stdout.contains("best"), "{ended}");
    assert_eq!(place.files(), ["design/", "design/design.csv"]);
    assert!(!place.text("design/design.csv").contains("NaN"));
}

/// Γ(2μ + 1)/Γ(μ + 1)², the sum of all squared weights, at orders of the grid.
fn squared_weights(order: f64) -> f64 {
    let known = [
        (0.0, 1.0),
        (0.5, 4.0 / std::f64::consts::PI),
        (1.0, 2.0),
        (1.5, 32.0 / (3.0 * std::f64::consts::PI)),
        (2.0, 6.0),
    ];
    let found = known.iter().find(|(mu, _)| *mu == order);
    found.expect("an order of the list").1
}

const DESK: &str = "--device-model laboratory --mass 45g --damping 0.2 --sample-time 1ms --force-limit 3.3N --orders 0,0.5,1,1.5,2";

#[test]
fn a_design_for_the_device_on_the_desk_runs_there() {
    let place = Place::new();
    let report = design(&place, DESK);
    assert_eq!(report["ideal_device_assumed"], false);
    assert_eq!(report["realistic"], Value::Null);
    let asked = ["mass_kg", "damping_n_s_per_m", "sample_time_s"];
    assert_eq!(asked.map(|key| number(&report, key)), [0.045, 0.2, 1e-3]);
    for (key, want) in [
        ("friction_n", 0.05),
        ("delay_s", 0.5e-3),
        ("current_lag_s", 1e-3),
        ("encoder_resolution_m", 1e-6),
    ] {
        assert_eq!(number(&report["imperfections"], key), want, "{key}");
    }
    for candidate in report["candidates"].as_array().expect("an array") {
        let (mu, b) = (number(candidate, "order"), number(candidate, "dissipation"));
        let rms = b * 1e-6 / 12.0_f64.sqrt() * 1e-3_f64.powf(-mu) * squared_weights(mu).sqrt();
        let have = number(candidate, "force_noise_rms_n");
        assert!((have - rms).abs() <= 1e-4 * rms, "{candidate} {rms}");
    }
    assert_eq!(report["simulated"]["verdict"], "stable");
    assert!(settles(&place, 1.0));
    assert!(!settles(&place, 3.0));
}

#[test]
fn a_design_that_assumes_an_ideal_device_says_so_and_shows_a_realistic_one() {
    let place = Place::new();
    let report = design(&place, "--orders 2");
    assert_eq!(report["ideal_device_assumed"], true);
    assert_eq!(report["best"]["force_noise_rms_n"], Value::Null);
    // Order 2 is the stiffest on paper and the first to shake where the current lags.
    let real = &report["realistic"];
    assert_eq!(real["analysis_stable"], false);
    assert!(number(real, "margin") < 0.2, "{real}");
    assert_eq!(real["simulated"]["stable"], false);
    let said = place.run("design --orders 2").succeeded_with_warnings();
    says(&said.stderr, &["this is for an ideal device", "saturated"]);
    assert_eq!(row(&said.stdout, "ideal device assumed"), "yes");
}
