//! A robot behind the bridge as a device of the command line: armed with its file alone, and only where its box of hands is proved.

use crate::process::Place;
use crate::signals::bridged;
use haptic_bridge::{BridgeTicker, Takes};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

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
