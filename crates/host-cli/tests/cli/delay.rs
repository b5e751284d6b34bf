//! Delay that is no whole number of samples and current lag, in `analyze` and in the pre-flight.

use super::process::{Place, number};
use serde_json::Value;

const DEVICE: &str = "--mass 65g --damping 3.5 --sample-time 1ms";
const WALL: &str = "--order 1 --stiffness 8N/mm --dissipation 15";

fn analyze(line: &str) -> Value {
    Place::new()
        .run(&format!("analyze {line} --json"))
        .succeeded()
        .json()
}

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

#[test]
fn a_spring_behind_half_a_sample_needs_more_than_interpolation_promises() {
    let spring = |path: &str| analyze(&format!("passivity --order 1 --alpha 0.2 --beta 0 {path}"));
    let required = |path: &str| number(&spring(path), "required_delta");
    // (α/2)(1/2 + h + √(1/4 + 2h)), 1.059 α at 1/2
    for (path, want) in [
        ("--delay-samples 0", 0.1),
        ("--delay-samples 0.5", 0.1 * (1.0 + 1.25_f64.sqrt())),
        ("--delay-samples 1", 0.3),
    ] {
        assert!((required(path) - want).abs() < 1e-12, "{path}");
    }
    assert!(required("--current-lag 0.5ms --sample-time 1ms") > 0.1);
    let spring = spring("--delay-samples 0.5");
    assert_eq!(number(&spring, "delay_samples"), 0.5);
}

#[test]
fn every_analysis_takes_delay_and_lag() {
    let alpha_max = |path: &str| {
        number(
            &analyze(&format!(
                "stability-region --order 1 --delta 0.1 --sample-time 1ms {path}"
            )),
            "alpha_max",
        )
    };
    let (none, half, one) = (
        alpha_max(""),
        alpha_max("--delay 0.5ms"),
        alpha_max("--delay 1ms"),
    );
    assert!(none > half && half > one, "{none} {half} {one}");
    assert!(alpha_max("--current-lag 0.5ms") < none);
    let peak = |path: &str| {
        number(
            &analyze(&format!("sensitivity {WALL} {DEVICE} --points 2 {path}")),
            "peak_db",
        )
    };
    assert!(peak("--delay 0.3ms --current-lag 0.2ms") > peak(""));
    let felt = |path: &str| {
        let result = analyze(&format!("transparency {WALL} {DEVICE} --points 2 {path}"));
        let points = result["points"].as_array().expect("points").clone();
        number(&points[0], "effective_damping")
    };
    // At rest a delay and a lag take K(delay + lag) of the damping.
    let taken = felt("") - felt("--delay 0.3ms --current-lag 0.2ms");
    assert!((taken / (8000.0 * 0.5e-3) - 1.0).abs() < 1e-3, "{taken}");
}

#[test]
fn delays_and_lags_that_make_no_sense_are_refused_in_one_line() {
    let place = Place::new();
    for (line, words) in [
        (
            "stability --order 1 --alpha 0.1 --beta 0.1 --delay 1ms --delay-samples 1 --sample-time 1ms",
            "give either --delay-samples or --delay",
        ),
        (
            "stability --order 1 --alpha 0.1 --beta 0.1 --delay 1ms",
            "--delay 0.001 s is a time, and the loop has none: give --sample-time, or --delay-samples",
        ),
        (
            "passivity --order 1 --alpha 0.1 --beta 0.1 --current-lag 1ms",
            "--current-lag 0.001 s is a time, and the loop has none: give --sample-time",
        ),
        (
            "stability --order 1 --alpha 0.1 --beta 0.1 --delay-samples 20000",
            "delay samples 20000 is not from 0 to 10000: change --delay-samples",
        ),
        (
            "stability --order 1 --alpha 0.1 --beta 0.1 --sample-time 1ms --current-lag -1ms",
            "current lag -0.001 s is not from 0 to 1 s: change --current-lag",
        ),
        (
            "stability-region --order 1 --delta 0.1 --delay-samples 64.5",
            "delay of a region 64.5 samples is not from 0 to 64 samples",
        ),
        (
            "stability --order 1 --alpha 0.1 --beta 0.1 --sample-time 0s --delay 1ms",
            "sample time 0 s is not from 1e-9 to 1e6 s",
        ),
    ] {
        place.run(&format!("analyze {line}")).refused(2, &[words]);
    }
}

#[test]
fn the_pre_flight_of_a_simulated_wall_knows_its_delay_and_its_lag() {
    let place = Place::new();
    let wall = |extra: &str| {
        place.write(
            "wall.toml",
            format!(
                "[wall]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 1e-3\norder = 1\n\
                 stiffness_n_per_m = 8000\ndissipation_n_s_mu_per_m = 15\n{extra}"
            ),
        );
        place.run("run wall.toml --json").json()
    };
    let ideal = wall("");
    assert_eq!(ideal["preflight"]["stable"], true, "{ideal}");
    let real = wall("delay_s = 1.3e-3\ncurrent_lag_s = 1.5e-3\n");
    let preflight = &real["preflight"];
    assert_eq!(preflight["stable"], false, "{real}");
    assert!(
        (number(preflight, "delay_samples") - 1.3).abs() < 1e-12,
        "{real}"
    );
    assert_eq!(number(preflight, "current_lag_s"), 1.5e-3);
    assert_eq!(real["stable"], false, "the trial agrees: {real}");
}
