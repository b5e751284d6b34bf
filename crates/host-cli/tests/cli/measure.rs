//! `device measure`, and the commands that take its file.

use super::devices::Emulated;
use crate::process::{Place, cases, number};
use serde_json::Value;

/// Mass, damping, friction, delay and lag of the device that is measured here.
const DEVICE: &str =
    "--mass 80g --damping 3 friction=0.06N delay=1.3ms current_lag=0.5ms encoder_resolution=10um";

fn measured(place: &Place) -> Value {
    let line =
        format!("device measure --device sim {DEVICE} --duration 3s --out device.toml --json");
    place.run(&line).succeeded().json()
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_device_is_measured_into_a_file_that_the_other_commands_take() {
    let place = Place::new();
    let found = measured(&place);
    let value = |key: &str| number(&found[key], "value");
    assert!((value("mass_kg") / 0.08 - 1.0).abs() < 0.05, "{found}");
    assert!(
        (value("damping_n_s_per_m") / 3.0 - 1.0).abs() < 0.05,
        "{found}"
    );
    assert!((value("delay_s") - 1.3e-3).abs() < 1e-4, "{found}");
    assert!(
        (value("current_lag_s") / 0.5e-3 - 1.0).abs() < 0.2,
        "{found}"
    );
    assert!(
        (number(&found, "encoder_resolution_m") / 1e-5 - 1.0).abs() < 1e-6,
        "{found}"
    );
    assert!(number(&found, "largest_force_n") <= 2.0, "{found}");
    assert_eq!(place.files(), ["device.png", "device.svg", "device.toml"]);

    // The same device by its file and by options: the same answer, and an option beside the file wins.
    let text = place.text("device.toml");
    let key = |key: &str| -> f64 {
        let line = text
            .lines()
            .find(|line| line.starts_with(key))
            .expect("there");
        line.split(" = ")
            .nth(1)
            .and_then(|number| number.parse().ok())
            .expect("a number")
    };
    let by_file = "--device-model device.toml";
    let by_options = format!(
        "--mass {}kg --damping {} --delay {}s --current-lag {}s",
        key("mass_kg"),
        key("damping_n_s_per_m"),
        key("delay_s"),
        key("current_lag_s")
    );
    let loops =
        "analyze stability --order 0.5 --sample-time 1ms --stiffness 1000 --dissipation 10 --json";
    let analysed = |device: &str| place.run(&format!("{loops} {device}")).succeeded().json();
    assert_eq!(analysed(by_file), analysed(&by_options));
    let heavier = analysed(&format!("{by_file} --mass 1kg"));
    assert!(
        (number(&heavier, "alpha") - 1e-3).abs() < 1e-12,
        "{heavier}"
    );
    let walls = "zwidth --orders 1 --points 2 --sample-time 1ms duration=2s window=0.5s --json";
    // So short a trial differs from the analysis, which it says.
    let tried = |device: &str| {
        let ended = place.run(&format!("{walls} {device}"));
        ended.succeeded_with_warnings().json()
    };
    let further = format!(
        "{by_options} friction={}N encoder_resolution={}m sensor_noise={}m",
        key("friction_n"),
        key("encoder_resolution_m"),
        key("sensor_noise_m")
    );
    let keys = further.replace("--delay ", "delay=");
    let keys = keys.replace("--current-lag ", "current_lag=");
    assert_eq!(tried(by_file), tried(&keys));
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_wider_box_asks_for_no_more_motion() {
    let place = Place::new();
    for (force, damping) in [("3.3N", "3.5"), ("1N", "50")] {
        for width in ["5mm", "50mm", "200mm"] {
            let line = format!(
                "device measure --device sim --damping {damping} --force-limit {force} --box {width} --json"
            );
            let found = place.run(&line).succeeded_with_warnings().json();
            let damping: f64 = damping.parse().expect("a number");
            let told = number(&found["damping_n_s_per_m"], "value");
            assert!((told / damping - 1.0).abs() < 0.02, "{line}: {found}");
        }
    }
    // One that stands still is seen in any.
    place
        .run("device measure --device sim friction=0.3N --force-limit 1N --box 200mm")
        .refused(1, &["does not move under 0.2 N"]);
}

#[test]
fn a_wall_in_a_file_takes_its_device_from_a_device_file() {
    let place = Place::new();
    place.write(
        "device.toml",
        "[device]\nmass_kg = 0.08\ndamping_n_s_per_m = 3\nfriction_n = 0.06\ndelay_s = 0.0013\ncurrent_lag_s = 0.0005\n",
    );
    let wall = "sample_time_s = 0.001\norder = 1\nstiffness_n_per_m = 300\ndissipation_n_s_mu_per_m = 1\nduration_s = 1\n";
    place.write(
        "with.toml",
        format!("[wall]\ndevice_model = \"device.toml\"\n{wall}"),
    );
    place.write(
        "without.toml",
        format!("[wall]\nmass_kg = 0.08\ndamping_n_s_per_m = 3\nfriction_n = 0.06\ndelay_s = 0.0013\ncurrent_lag_s = 0.0005\n{wall}"),
    );
    place.write(
        "other.toml",
        format!("[wall]\nmass_kg = 0.2\ndamping_n_s_per_m = 1\n{wall}"),
    );
    let settled = |line: &str| {
        let ended = place.run(&format!("run {line} --overwrite --out out --json"));
        let report = ended.succeeded_with_warnings().json();
        number(&report, "deflection_m")
    };
    let with = settled("with.toml");
    assert!((with - settled("without.toml")).abs() < 1e-12);
    assert!((with - settled("other.toml --device-model device.toml")).abs() < 1e-12);
    place.write(
        "bad.toml",
        format!("[wall]\ndevice_model = \"none.toml\"\n{wall}"),
    );
    place
        .run("run bad.toml")
        .refused(2, &["bad.toml:2", "none.toml"]);
}

#[test]
fn what_cannot_be_measured_is_said_in_one_line() {
    let place = Place::new();
    place.write(
        "bad.toml",
        "[device]\nmass_kg = -1\ndamping_n_s_per_m = 3\n",
    );
    place.write(
        "late.toml",
        "[device]\nmass_kg = 1\ndamping_n_s_per_m = 3\ndelay_s = 1.3\n",
    );
    let still = cases(
        "
        device measure --device sim friction=3N => does not move under 2 N | the force is zero | --force-limit
        device measure --device sim --mass 1g --damping 0 => the force is zero | --force-limit
        ",
    );
    for (line, words) in still {
        place.run(line).refused(1, &words);
    }
    place.write(
        "good.toml",
        "[device]\nmass_kg = 1\ndamping_n_s_per_m = 3\n",
    );
    place.refuses(
        "
        device measure --device sim --box 0m => --box 0m: box_m = 0 is not from 0.0001
        device measure --device sim --out device => device file | device.toml
        device measure --device serial:none --mass 1kg => --mass 1kg: mass_kg has no effect | --device sim
        zwidth --device-model bad.toml => bad.toml:2 | mass_kg = -1 | above 0
        design --device-model late.toml => late.toml:4 | delay_s = 1.3 is not from 0 to 1
        analyze stability --order 1 --stiffness 1 --dissipation 1 --sample-time 1ms --device-model none.toml => none.toml
        relax --device-model good.toml => --device-model | guard
        ",
    );
    place.write("taken.toml", "");
    place
        .run("device measure --device sim --out taken.toml")
        .refused(2, &["taken.toml"]);
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_serial_device_is_measured_without_its_line() {
    let device = Emulated::new("");
    // A busy machine answers late: the box is wide, the device patient.
    let found = device.json(
        "device measure --device serial:device --duration 2s --box 50mm watchdog=1s max_age_ticks=1000 --out device.toml",
    );
    let value = |key: &str| number(&found[key], "value");
    assert!((value("mass_kg") / 0.065 - 1.0).abs() < 0.01, "{found}");
    assert!(
        (value("damping_n_s_per_m") / 3.5 - 1.0).abs() < 0.01,
        "{found}"
    );
    assert!(value("delay_s") + value("current_lag_s") < 5e-5, "{found}");
    assert!(number(&found, "largest_force_n") <= 2.0, "{found}");
    assert!(device.place().text("device.toml").contains("emulated"));
    // A limit that the measurement asks for is none of the device.
    let line = "device measure --device serial:device --duration 1s --box 50mm --force-limit 3.3N watchdog=1s max_age_ticks=1000";
    let ended = device.place().run(line).succeeded_with_warnings();
    let tighter = "set on the device hold where they are tighter: rising in 0.5 s; a run";
    assert!(ended.stderr.contains(tighter), "{ended}");
    let said = device
        .place()
        .run("device measure --device serial:device --mass 1kg");
    said.refused(2, &["--mass 1kg: mass_kg has no effect"]);
}
