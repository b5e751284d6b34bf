//! `device measure`, and the commands that take its file.

use crate::emulated::Emulated;
use crate::process::{Place, column, number};
use serde_json::Value;
use testkit::{assert_close, assert_relative, assert_says};

/// Mass, damping, friction, delay and lag of the device that is measured here.
const DEVICE: &str =
    "--mass 80g --damping 3 friction=0.06N delay=1.3ms current_lag=0.5ms encoder_resolution=10um";

fn measured(place: &Place) -> Value {
    let line =
        format!("device measure --device sim {DEVICE} --duration 8s --out device.toml --json");
    place.run(&line).succeeded().json()
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_device_is_measured_into_a_file_that_the_other_commands_take() {
    let place = Place::new();
    let found = measured(&place);
    let value = |key: &str| number(&found[key], "value");
    assert_relative("mass", value("mass_kg"), 0.08, 0.05);
    assert_relative("damping", value("damping_n_s_per_m"), 3.0, 0.05);
    assert_close("delay", value("delay_s"), 1.3e-3, 1e-4);
    assert_relative("lag", value("current_lag_s"), 0.5e-3, 0.2);
    assert_relative(
        "encoder",
        number(&found, "encoder_resolution_m"),
        1e-5,
        1e-6,
    );
    assert!(number(&found, "largest_force_n") <= 2.0, "{found}");
    let files = ["device.csv", "device.png", "device.svg", "device.toml"];
    assert_eq!(place.files(), files);
    assert!(number(&found, "coherent_lines") > 15.0, "{found}");

    // The measured response is a plant to tune for.
    let tuned = "control design --plant device.csv --crossover 40rad/s --json";
    let tuned = place.run(tuned).succeeded().json();
    let specification = tuned["specification"].as_array().expect("wishes");
    assert!(
        specification.iter().all(|wish| wish["met"] == true),
        "{tuned}"
    );

    // The same device by its file and by options: the same answer, and an option beside the file wins.
    let text = place.text("device.toml");
    let key = |key: &str| -> f64 {
        let value = text
            .lines()
            .find_map(|line| line.strip_prefix(key)?.strip_prefix(" = "));
        value.expect(key).parse().expect("a number")
    };
    let by_file = "--device-model device.toml";
    let [mass, damping] = ["mass_kg", "damping_n_s_per_m"].map(key);
    let [delay, lag] = ["delay_s", "current_lag_s"].map(key);
    let by_options =
        format!("--mass {mass}kg --damping {damping} --delay {delay}s --current-lag {lag}s");
    let loops =
        "analyze stability --order 0.5 --sample-time 1ms --stiffness 1000 --dissipation 10 --json";
    let analysed = |device: &str| place.run(&format!("{loops} {device}")).succeeded().json();
    assert_eq!(analysed(by_file), analysed(&by_options));
    let heavier = number(&analysed(&format!("{by_file} --mass 1kg")), "alpha");
    assert_close("α", heavier, 1e-3, 1e-12);
    let walls = "zwidth --orders 1 --points 2 --sample-time 1ms duration=2s window=0.5s --json";
    // So short a trial differs from the analysis, which it says.
    let tried = |device: &str| {
        let ended = place.run(&format!("{walls} {device}"));
        ended.succeeded_with_warnings().json()
    };
    let [friction, encoder, noise] =
        ["friction_n", "encoder_resolution_m", "sensor_noise_m"].map(key);
    let keys = by_options
        .replace("--delay ", "delay=")
        .replace("--current-lag ", "current_lag=");
    let keys =
        format!("{keys} friction={friction}N encoder_resolution={encoder}m sensor_noise={noise}m");
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
            let estimate = number(&found["damping_n_s_per_m"], "value");
            assert!((estimate / damping - 1.0).abs() < 0.02, "{line}: {found}");
        }
    }
    // One that stands still is seen in any.
    let still = "device measure --device sim friction=0.3N --force-limit 1N --box 200mm";
    place
        .run(still)
        .refused(1, &["does not move under 200 mN", "give --force-limit 2"]);
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_serial_device_is_measured_without_its_line() {
    let device = Emulated::new("");
    // A busy machine answers late: the box is wide, the device patient.
    let line = "device measure --device serial:device --duration 2s --box 50mm watchdog=1s max_age_ticks=1000 --out device.toml --json";
    let ended = device.place().run(line);
    if ended.code == Some(2) {
        // Forces that come late are no motion of a mass.
        ended.refused(2, &["no mass with damping"]);
        testkit::skip_for_load("the device was not answered in time");
        return;
    }
    let found = ended.succeeded_with_warnings().json();
    let value = |key: &str| number(&found[key], "value");
    assert_relative("mass", value("mass_kg"), 0.065, 0.01);
    assert_relative("damping", value("damping_n_s_per_m"), 3.5, 0.01);
    assert!(value("delay_s") + value("current_lag_s") < 5e-5, "{found}");
    assert!(number(&found, "largest_force_n") <= 2.0, "{found}");
    assert!(device.place().text("device.toml").contains("emulated"));
    // A limit that the measurement asks for is none of the device.
    let line = "device measure --device serial:device --duration 1s --box 50mm --force-limit 3.3N watchdog=1s max_age_ticks=1000";
    let ended = device.place().run(line).succeeded_with_warnings();
    let tighter = "set on the device hold where they are tighter: rising in 500 ms; a run";
    assert!(ended.stderr.contains(tighter), "{ended}");
}

#[test]
fn what_cannot_be_measured_is_said_in_one_line() {
    let place = Place::new();
    let held = place.run("device measure --device sim friction=3N");
    held.refused(
        1,
        &[
            "does not move under 2 N",
            "the force is zero",
            "--force-limit",
        ],
    );
    place.write(
        "bad.toml",
        "[device]\nmass_kg = -1\ndamping_n_s_per_m = 3\n",
    );
    place.write(
        "good.toml",
        "[device]\nmass_kg = 1\ndamping_n_s_per_m = 3\n",
    );
    place.refuses(
        "
        device measure --device serial:none --mass 1kg => --mass 1kg: mass_kg has no effect | --device sim
        zwidth --device-model bad.toml => bad.toml:2 | mass_kg = -1 | above 0
        relax --device-model good.toml => --device-model | guard
        ",
    );
}

/// Delay, lag, friction and encoder of a desktop device.
const DEVICE_FILE: &str = "[device]\nmass_kg = 0.08\ndamping_n_s_per_m = 3\nfriction_n = 0.05\ndelay_s = 0.0013\n\
                      current_lag_s = 0.0005\nencoder_resolution_m = 1e-6\n";
const WALL: &str = "[wall]\ndevice_model = \"device.toml\"\nsample_time_s = 0.001\norder = 1\nstiffness_n_per_m = 900\n\
                    dissipation_n_s_mu_per_m = 1\nimpact_m_per_s = 0\npush_n = 0.5\nduration_s = 1.5\n";

/// A board that is a device.
fn board(device: &str) -> Emulated {
    let files = Place::new();
    files.write("device.toml", device);
    let file = files.path("device.toml");
    let board = Emulated::new(&format!("--device-model {}", file.display()));
    board.place().write("device.toml", device);
    board
}

fn preflight(report: &Value) -> [f64; 3] {
    ["margin", "delay_s", "current_lag_s"].map(|key| number(&report["preflight"], key))
}

#[test]
fn a_device_file_is_the_same_device_in_sim_and_on_a_board() {
    let board = board(DEVICE_FILE);
    board.loosen();
    board.place().write("wall.toml", WALL);
    let sim = board.json("run wall.toml --out sim");
    let board_run = board.json("run wall.toml --device serial:device watchdog=1s --out there");
    assert_eq!(preflight(&sim), preflight(&board_run));
    assert_eq!(preflight(&board_run)[1..], [0.0013, 0.0005]);
    assert_eq!(board_run["verdict"], sim["verdict"], "{board_run}");
    // The board's law is in single precision, which the encoder hides: a position may fall on the next count now and then.
    let [sim, on_board] = ["sim", "there"].map(|run| {
        let table = board.place().text(&format!("{run}/wall.csv"));
        column(&table, "position_m")
    });
    assert_eq!(sim.len(), 1501);
    let largest = sim.iter().copied().fold(0.0, f64::max);
    assert!(largest > 4e-4, "{largest}");
    for (sim, on_board) in sim.into_iter().zip(on_board) {
        assert_close("position", on_board, sim, 1.5e-6);
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn what_design_writes_runs_in_sim_and_on_a_board() {
    let board = board(DEVICE_FILE);
    let place = board.place();
    let line = "design --device-model device.toml --sample-time 1ms force_limit=3N --orders 1 --out designed";
    place.run(line).succeeded_with_warnings();
    let sim = board.json("run designed/design.toml --out sim");
    let on_board =
        board.json("run designed/design.toml --device serial:device watchdog=1s --out there");
    assert!(on_board["ended_early"].is_null(), "{on_board}");
    assert_eq!(preflight(&on_board), preflight(&sim));
    assert_eq!(on_board["verdict"], "stable", "{on_board}");
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_simulated_plant_moves_once_the_force_has_risen() {
    let board = Emulated::new("");
    let report = |kind, device| {
        let line = format!("{kind} --device {device} --duration 2s precision=f32");
        let report = board.json(&line);
        // The ramp of the device is in its log alone.
        assert_eq!(number(&report, "limited_samples"), 0.0, "{report}");
        report
    };
    let on_board = report("relax", "serial:device watchdog=1s");
    let here = report("relax", "sim");
    for same in [
        "max_relative_error_samples",
        "closed_form_error",
        "final_over_theory",
    ] {
        assert_relative(same, number(&on_board, same), number(&here, same), 1e-4);
    }
    // A push that began with the ramp would be 18 % off.
    let creep = report("creep", "serial:device watchdog=1s");
    assert!(number(&creep, "closed_form_error") < 0.01, "{creep}");
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_board_of_several_axes_is_measured_axis_by_axis_and_tested_on_all() {
    let board = Emulated::new("--axes 2");
    let place = &board.place;
    for (axis, words) in [
        ("z", "which has 2 axes: omit it"),
        ("up", "is not one of x, y, z"),
    ] {
        let line = format!("device measure --device serial:device axis={axis}");
        let refused = place.run(&line);
        assert_eq!(refused.code, Some(2), "{refused}");
        assert!(refused.stderr.contains(words), "{refused}");
    }
    // A simulated board is the mass and damping that a run asks for: 65 g and 3.5 N·s/m.
    let line = "device measure --device serial:device axis=y --duration 2s --box 50mm watchdog=1s max_age_ticks=1000 --json";
    let found = place.run(line).succeeded_with_warnings().json();
    assert_relative("mass", number(&found["mass_kg"], "value"), 0.065, 0.05);
    let refused = place.run("device selftest --device serial:device --axes 3");
    assert_eq!(refused.code, Some(2), "{refused}");
    assert!(refused.stderr.contains("--axes 3, but"), "{refused}");
    let tested = place.json("device selftest --device serial:device --axes 2");
    let checks = tested["checks"].as_array().expect("rows");
    assert_eq!(tested["holds"], true, "{tested}");
    // Of each axis.
    let direction = checks.iter().find(|row| row["check"] == "direction");
    let seen = direction.expect("a row")["seen"].to_string();
    assert_says(&seen, "x:  & ; y: ");
}

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
