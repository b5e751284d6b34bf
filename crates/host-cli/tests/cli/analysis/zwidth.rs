//! `zwidth`: the region of the theory, and walls that are only called stable.

use super::super::process::{Place, number};
use serde_json::Value;

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
    assert!(ended.stderr.contains("friction alone"), "{ended}");
    let report = ended.succeeded_with_warnings().json();
    assert_eq!(report["verdict"], "held-by-friction");
    assert_eq!(report["stable"], false);
}
