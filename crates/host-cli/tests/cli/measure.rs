//! `device measure`, and the commands that take its file.

use crate::emulated::Emulated;
use crate::process::number;
use serde_json::Value;
use testkit::{assert_close, assert_relative, assert_says};

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_motor_with_half_its_gain_shows_and_its_newtons_are_right_once_it_is_calibrated() {
    let device = Emulated::new("--device-model laboratory motor_gain=0.5");
    let place = device.place();
    let measure = "device measure --device serial:device --duration 2s --box 50mm watchdog=1s max_age_ticks=1000 --json";
    let measured = |more: &str| {
        let ended = place.run(&format!("{measure} {more}"));
        if ended.code == Some(2) {
            testkit::skip_for_load("the device was not answered in time");
            return None;
        }
        Some(ended.succeeded_with_warnings().json())
    };
    let Some(raw) = measured("--out device.toml") else {
        return;
    };
    let mass = |found: &Value| number(&found["mass_kg"], "value");
    assert_relative("twice the mass", mass(&raw), 0.13, 0.03);
    assert_says(
        raw["calibration"].as_str().expect("words"),
        "never calibrated",
    );
    // The same motor presses on a scale. Its half newtons, less 50 mN of friction up and more down, in whole grams; one is without its unit.
    let scale = Emulated::new(
        "--device-model laboratory motor_gain=0.5 specimen=spring sensed_range=20N sensed_offset=0.1N",
    );
    let on_scale = scale.place();
    on_scale.write("device.toml", place.text("device.toml"));
    let line = "device calibrate --device serial:device watchdog=1s max_age_ticks=1000 --device-model device.toml --out true.toml --json";
    let ended = on_scale.run_with(line, b"\n\n29g\n63\n63g\n97g\n73g\n39g\n");
    assert_says(&ended.stderr, "again: \"63\" has no unit: write 63g or 63N");
    assert_eq!(ended.code, Some(0), "{ended}");
    let calibrated = ended.json();
    for (key, truth) in [
        ("motor_factor", 0.5),
        ("sensor_factor", 1.0),
        ("sensor_offset_n", 0.1),
    ] {
        let [low, high] = ["low", "high"].map(|end| number(&calibrated[key], end));
        assert!(
            low < truth && truth < high && high - low < 0.1,
            "{calibrated}"
        );
    }
    let file = on_scale.text("true.toml");
    place.write("true.toml", &file);
    // Another device is not taken for the one that was calibrated.
    let other = place.run(&format!("{measure} --device-model true.toml"));
    other.refused(2, &["was calibrated on", "give its own file"]);
    let line = file.lines().find(|line| line.starts_with("device = "));
    place.write("true.toml", file.replace(line.expect("an identity"), ""));
    let Some(found) = measured("--device-model true.toml") else {
        return;
    };
    assert_relative("mass", mass(&found), 0.065, 0.03);
    assert_says(
        found["calibration"].as_str().expect("words"),
        "calibrated on",
    );
    // In both loops the true force holds the push of the hand.
    for mode in ["device", "host"] {
        let wall = format!(
            "run wall.toml --device serial:device --device-model true.toml loop={mode} watchdog=1s max_age_ticks=1000 --out wall-{mode} --json"
        );
        place.write("wall.toml", "[wall]\norder = 1\nsample_time_s = 0.001\nstiffness_n_per_m = 500\ndissipation_n_s_mu_per_m = 2\npush_n = 0.5\nduration_s = 2\n");
        let report = place.run(&wall).succeeded_with_warnings().json();
        assert_says(
            report["link"]["calibration"].as_str().expect("words"),
            "calibrated on",
        );
        // Friction of 50 mN may hold the rest.
        assert_close(
            "force against the push",
            number(&report, "final_force_n"),
            0.5,
            0.055,
        );
    }
}
