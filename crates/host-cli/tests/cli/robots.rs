//! A robot behind the bridge as a device of the command line: armed with its file alone, and only where its box of hands is proved.

use crate::emulated::Emulator;
use crate::process::{Place, number};
use crate::signals::bridged;
use haptic_bridge::{BridgeTicker, Takes};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use testkit::assert_relative;

const WALL: &str = "[wall]\norder = 1\nstiffness_n_per_m = 1000\ndissipation_n_s_mu_per_m = 10\nduration_s = 1\nsample_time_s = 0.001\n";
const ROBOT: &str = "[admittance]\nbandwidth_hz = 10\ndead_time_s = 0.004\nbody_inertance_n_s_mu_per_m = 8\nbody_damping_n_s_per_m = 60\nhand_stiffness_n_per_m = ";

#[test]
fn a_robot_is_armed_with_its_file_and_only_in_hands_that_bear_it() {
    let place = Place::new();
    place.write("wall.toml", WALL);
    place.write("robot.toml", format!("{ROBOT}[0, 300]\n"));
    place.write("stiff.toml", format!("{ROBOT}[0, 3000]\n"));
    let ended = Arc::new(AtomicBool::new(false));
    let takes = Takes::Velocity {
        robot: place.path("robot.toml"),
    };
    let mut position_m = 0.0;
    // Nobody pushes it, and its sensor has rested before any host is heard.
    let tick = move |ticker: &mut BridgeTicker, time_us| {
        if time_us > 300_000 {
            ticker.wait();
        }
        ticker.sense(&[0.0; 3]);
        let command = ticker.tick_motion(time_us, Some(&[position_m, 0.0, 0.0]));
        position_m += 1e-3 * command[0];
    };
    let port = bridged(takes, 50.0, Arc::clone(&ended), tick);
    let line = format!("run wall.toml --device tcp:127.0.0.1:{port}");
    let known = "mass_kg=1 damping_n_s_per_m=1";
    let words = ["device_model=robot.toml", "bandwidth_hz", "dead_time_s"];
    place.run(&format!("{line} {known}")).refused(2, &words);
    let stiff = place.run(&format!("{line} device_model=stiff.toml"));
    stiff.refused(2, &["hand of the box", "body_inertance_n_s_mu_per_m"]);
    let run = place.run(&format!("{line} device_model=robot.toml --json"));
    let report = run.succeeded_with_warnings().json();
    assert_eq!(report["preflight"]["robot"]["every_hand"], true, "{report}");
    assert_eq!(report["verdict"], "untouched", "{report}");
    let info = place.json(&format!("device info --device tcp:127.0.0.1:{port}"));
    assert_eq!(info["moves"], true, "{info}");
    // Nor is it tested by forces.
    let test = format!("device selftest --device tcp:127.0.0.1:{port} --emergency-stop none");
    let ended_by_it = place.run(&test);
    assert!(
        ended_by_it.error().contains("device_model=robot.toml"),
        "{ended_by_it}"
    );
    ended.store(true, Ordering::Relaxed);
}

/// As patient as a device may be asked to be.
const PATIENT: &str = "watchdog=1s max_age_ticks=1000 --json";

#[test]
fn an_emulated_robot_renders_the_wall_of_its_file_in_its_hand() {
    let place = Place::new();
    place.write("wall.toml", format!("{WALL}push_n = 2\n"));
    place.write("robot.toml", format!("{ROBOT}[0, 300]\n"));
    let options = "--device-model robot.toml --listen 127.0.0.1:0";
    let mut robot = Emulator::start(&place, options);
    let line = format!(
        "run wall.toml --device {} device_model=robot.toml duration=3s {PATIENT}",
        robot.name()
    );
    let report = place.run(&line).succeeded_with_warnings().json();
    assert_eq!(report["preflight"]["robot"]["every_hand"], true, "{report}");
    // 2 N in a hand of 300 N/m before a wall of 1 kN/m.
    let rested = number(&report, "final_force_n");
    assert_relative("rests", rested, 2.0 / 1.3, 0.01);
    let refused = place.run(&format!(
        "device measure --device {} {PATIENT}",
        robot.name()
    ));
    refused.refused(2, &["start it with a file that has neither"]);
    assert!(robot.ends().contains("emulated"));
    for (more, words) in [
        ("sensed_range=20N", "has one axis, its own force sensor"),
        ("measured=maybe", "is not true or false"),
    ] {
        let line = format!("device emulate {options} {more}");
        place.run(&line).refused(2, &[words]);
    }
    let no_robot = place.run("device emulate --listen 127.0.0.1:0 sample_time=2ms");
    no_robot.refused(2, &["apply only to a robot"]);
}

#[test]
fn a_robot_without_dead_time_and_bandwidth_is_measured_and_refused_until_then() {
    let place = Place::new();
    place.write("wall.toml", WALL);
    place.write("robot.toml", format!("{ROBOT}[0, 300]\n"));
    let options = "--device-model robot.toml --listen 127.0.0.1:0 measured=false encoder_resolution=10um noise=1um";
    let robot = Emulator::start(&place, options);
    let run = format!(
        "run wall.toml --device {} device_model=robot.toml",
        robot.name()
    );
    place.run(&run).refused(2, &["device measure"]);
    let known = ROBOT.replace("dead_time_s = 0.004\n", "");
    place.write("half.toml", format!("{known}[0, 300]\n"));
    let half = place.run("run wall.toml device_model=half.toml");
    half.refused(2, &["dead_time_s", "device measure"]);
    let line = format!(
        "device measure --device {} --duration 4s --out measured.toml {PATIENT}",
        robot.name()
    );
    let ended = place.run(&line);
    if ended.code == Some(2) {
        return testkit::skip_for_load("the robot was not answered in time");
    }
    let found = ended.succeeded_with_warnings().json();
    for (key, truth) in [
        ("bandwidth_hz", 10.0),
        ("damping_ratio", 0.8),
        ("dead_time_s", 0.004),
    ] {
        assert_relative(key, number(&found[key], "value"), truth, 0.05);
    }
    // With a body it is a whole robot.
    let file = place.text("measured.toml");
    let body = "body_inertance_n_s_mu_per_m = 8\nbody_damping_n_s_per_m = 60\n";
    place.write(
        "whole.toml",
        file.replace("# The body", &format!("{body}# The body")),
    );
    let line = "analyze admittance --device-model whole.toml --sample-time 1ms";
    assert_eq!(place.json(line)["stable"], true);
}
