//! `analyze` and `zwidth`: the contract's keys, known numbers, refusals.

use super::process::{Place, number};
use serde_json::Value;
use testkit::{assert_relative, assert_says};

/// One analysis, as JSON.
fn analyze(line: &str) -> Value {
    Place::new().json(&format!("analyze {line}"))
}

#[test]
fn units_and_no_units_give_the_same_loop() {
    let stability = |path: &str| {
        analyze(&format!(
            "stability --order 0.5 --mass 65g --damping 3.5 --sample-time 2ms --stiffness 300 --dissipation 10 {path}"
        ))
    };
    let with = stability("--delay 2.6ms --current-lag 1ms");
    assert_eq!(with["stable"], true, "{with}");
    assert_eq!(with["encirclements"], 0);
    // α = KT²/m, β = B·T^1.5/m, δ = bT/m.
    for (key, want) in [
        ("alpha", 300.0 * 4e-6 / 0.065),
        ("beta", 10.0 * 0.002_f64.powf(1.5) / 0.065),
        ("delta", 3.5 * 0.002 / 0.065),
        ("delay_samples", 1.3),
        ("delay_s", 2.6e-3),
        ("current_lag_samples", 0.5),
        ("current_lag_s", 1e-3),
    ] {
        assert_relative(key, number(&with, key), want, 5e-15);
    }
    // Without units a sample time of 1 makes seconds of samples.
    let [alpha, beta, delta] = ["alpha", "beta", "delta"].map(|key| number(&with, key));
    let wall = format!("stability --order 0.5 --alpha {alpha} --beta {beta} --delta {delta}");
    let without = analyze(&format!(
        "{wall} --sample-time 1s --delay-samples 1.3 --current-lag 0.5s"
    ));
    let in_samples = stability("--delay-samples 1.3 --current-lag 1ms");
    for other in [without, in_samples] {
        // JSON readers round numbers to the last digit but one.
        let margins = [&with, &other].map(|report| number(report, "gain_margin"));
        assert_relative("margin", margins[1], margins[0], 1e-12);
    }
    // Nothing is known in seconds without a sample time.
    let plain = analyze(&format!("{wall} --delay-samples 0.5"));
    let seconds = ["delay_s", "current_lag_s"].map(|key| plain[key].is_null());
    assert_eq!((seconds, number(&plain, "delay_samples")), ([true; 2], 0.5));
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

#[test]
fn a_map_names_the_law_that_stands_in_place_of_a_wall() {
    let place = Place::new();
    let law = "[pid]\nproportional_gain = 300\nintegral_gain_per_s_lambda = 0\nintegral_order = 1\nderivative_gain_s_mu = 40\nderivative_order = 0.3\n[loop]\nsample_time_s = 0.001\n";
    std::fs::write(place.path("pd.toml"), law).expect("written");
    for (options, words) in [
        (
            "--tissue fish-muscle --sample-time 1ms",
            "your tissue & spring K of the tissue & more or less of it",
        ),
        (
            "--controller pd.toml",
            "your controller & factor on the controller & spring beside it",
        ),
    ] {
        let device = "--mass 65g --damping 3.5 --delay 0.5ms --out map --overwrite";
        let line = format!("analyze stability-region {options} {device}");
        place.run(&line).succeeded();
        let svg = place.text("map/region.svg");
        assert_says(&svg, words);
        assert!(!svg.contains("wall"), "{options}");
    }
}

#[test]
fn a_map_has_the_units_of_its_loop_and_the_wall_that_was_given() {
    let place = Place::new();
    let device = "--mass 65g --damping 3.5 --sample-time 1ms --delay 0.5ms";
    let (with, without) = ("stiffness K / N·m⁻¹ & m = 65 g", "α = KT²/m & δ = 0.1");
    for (options, words, has_wall) in [
        (
            format!("{device} --stiffness 3N/mm --dissipation 100"),
            with,
            true,
        ),
        (format!("{device} --stiffness 3N/mm"), with, false),
        (
            "--delta 0.1 --alpha 0.1 --beta 0.2".to_owned(),
            without,
            true,
        ),
        ("--delta 0.1".to_owned(), without, false),
    ] {
        let line = format!("analyze stability-region --order 0.5 {options} --out map --overwrite");
        let ended = place.run(&line);
        if has_wall || options.starts_with("--delta") {
            ended.succeeded()
        } else {
            ended.succeeded_with_warnings()
        };
        let svg = place.text("map/region.svg");
        assert_says(&svg, words);
        assert_eq!(svg.contains("your wall"), has_wall, "{options}");
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
        analyze stability foo=3 => foo=3 | unknown key `foo` | known are order, scheme
        analyze stability --order 1 order=1 => order=1: order is given twice
        analyze sensitivity --order 1 --points 1 => --points 1: points = 1 is not a whole number from 2 to 100000
        analyze teleoperation architecture=none => none | is not one of position-position
        analyze stability --order 0.5 --scheme oustaloup:3:1:100 --alpha 0.1 --beta 0.1 => oustaloup:3:1:100 | Hz | --sample-time
        analyze sensitivity --order 1 --alpha 3 --beta 1 => not stable
        analyze stability --order 1 --alpha 0.1 --beta 0.1 --delay 1ms
            => --delay 0.001 s is a time, but the loop has no units: give --sample-time
        ",
    );
}

/// The largest α of a report's only order, and of the analysis beside it.
fn stiffest(report: &Value) -> (f64, f64) {
    let boundary = report["orders"][0]["boundary"].as_array().expect("points");
    let largest = |key: &str, unit: f64| {
        let values = boundary.iter().filter_map(|point| point[key].as_f64());
        values.fold(0.0, f64::max) / unit
    };
    let first = &boundary[0];
    let unit = number(first, "stiffness_max") / number(first, "alpha");
    (
        largest("stiffness_max", unit),
        largest("analysis_stiffness_n_per_m", unit),
    )
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_wall_that_buzzes_against_the_force_limit_is_not_called_stable() {
    // theory.md, 5: μ = 1, no delay: α < 12 − 8√2 = 0.686 without damping, a little more with it. By the
    // position alone walls up to α = 4.3 (194 kN/m) passed: they buzz by microns, at 2.3 N rms.
    let place = Place::new();
    for (device, delta) in [
        (
            "--mass 45g --damping 0.2 --force-limit 3.3N",
            0.2e-3 / 0.045,
        ),
        ("--mass 0.15 --damping 1 --force-limit 8.9N", 1e-3 / 0.15),
    ] {
        let line = format!("zwidth {device} --sample-time 1ms --orders 1 --points 6 --json");
        let report = place.run(&line).succeeded_with_warnings().json();
        assert_eq!(report["criterion"], "settling");
        // Without dissipation these devices ring for longer than 5 s: the first point is strict.
        for point in report["orders"][0]["boundary"].as_array().expect("points") {
            let agrees = point["analysis_agrees"] == true;
            assert!(agrees || number(point, "beta") == 0.0, "{point}");
        }
        let (tried, analysed) = stiffest(&report);
        let top = 12.0 - 8.0 * 2.0_f64.sqrt() + 2.0 * delta;
        assert!(
            tried <= top && tried > 0.95 * analysed,
            "{tried} {analysed} {top}"
        );
        assert!(analysed <= top, "{analysed} {top}");
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_largest_dissipation_has_a_wall() {
    let place = Place::new();
    for noise in ["", "sensor_noise=1um"] {
        let line = "zwidth --device-model laboratory --orders 1 --points 2 --json";
        let report = place.run(&format!("{line} {noise}")).succeeded().json();
        let boundary = report["orders"][0]["boundary"].as_array().expect("points");
        assert_eq!(boundary.len(), 2, "{report}");
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_wall_that_friction_alone_holds_still_is_named_so() {
    let place = Place::new();
    let line = "zwidth friction=0.05N --orders 1 --points 2 --sample-time 2ms --json";
    let report = place.run(line).succeeded_with_warnings().json();
    let held = |report: &Value| {
        let points = report["orders"][0]["boundary"]
            .as_array()
            .expect("points")
            .clone();
        points[0].clone()
    };
    let point = held(&report);
    let stable = number(&point, "stiffness_max");
    let by_friction = number(&point, "held_by_friction_up_to_n_per_m");
    assert!(by_friction > 1.02 * stable, "{point}");
    // The same without friction: the same boundary, and nothing that is held.
    let line = "zwidth --orders 1 --points 2 --sample-time 2ms --json";
    let smooth = place.run(line).succeeded_with_warnings().json();
    let point = held(&smooth);
    assert!(point["held_by_friction_up_to_n_per_m"].is_null());
    let again = number(&point, "stiffness_max");
    assert!((again / stable - 1.0).abs() < 1e-3, "{stable} {point}");
    // And one of them in a file.
    let wall = format!(
        "[wall]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 0.002\nfriction_n = 0.05\norder = 1\n\
         stiffness_n_per_m = {:?}\ndissipation_n_s_mu_per_m = 0\n",
        0.5 * (stable + by_friction)
    );
    place.write("wall.toml", wall);
    let ended = place.run("run wall.toml --json --out wall");
    assert!(
        ended.stderr.contains("held by friction: without friction"),
        "{ended}"
    );
    let report = ended.succeeded_with_warnings().json();
    assert_eq!(report["verdict"], "held-by-friction");
    assert_eq!(report["stable"], false);
}

#[test]
fn a_tissue_of_several_elements_is_named_whole_and_judged_within_its_record() {
    let piece = "--tissue fish-muscle --area 4cm2 --thickness 20mm --sample-time 1ms --json";
    let place = Place::new();
    for (analysis, more) in [
        ("environment", ""),
        ("transparency", "--mass 65g --damping 3.5"),
    ] {
        let ended = place.run(&format!("analyze {analysis} {piece} {more}"));
        assert_says(
            &ended.stderr,
            "come from 0.0139 to 981 s & times earlier: times are 1/ω here",
        );
        let report = ended.succeeded_with_warnings().json();
        // One of its two spring-pots alone would look like the whole.
        for key in ["order", "stiffness_n_per_m", "dissipation_n_s_mu_per_m"] {
            assert!(report[key].is_null(), "{report}");
        }
        assert_eq!(report["tissue"], "fish-muscle");
    }
    let within = format!("analyze environment {piece} --omega-min 0.01 --omega-max 50");
    assert_eq!(place.run(&within).stderr, "");
}
