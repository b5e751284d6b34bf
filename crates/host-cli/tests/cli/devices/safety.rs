//! The safety chain of a device on a serial line.

use super::Emulated;
use crate::process::number;
use serde_json::Value;

/// 8000 N/m on the dissertation's device: it shakes.
const SHAKING: &str = "[wall]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 2e-3\norder = 0\n\
                       stiffness_n_per_m = 8000\ndissipation_n_s_mu_per_m = 0\n";

fn emulated() -> Emulated {
    Emulated::new("--speed 2")
}

/// What a command on the device says.
fn json(device: &Emulated, line: &str) -> Value {
    device.json(&format!("{line} --device serial:device"))
}

#[test]
fn the_chain_of_a_device_is_set_and_shown() {
    let device = emulated();
    let before = json(&device, "device get")["safety"].clone();
    assert_eq!(number(&before, "start_force_n"), 1.0);
    assert_eq!(
        (&before["workspace_m"], &before["guard"]),
        (&Value::Null, &Value::Null)
    );
    let set = "device set guard=energy-bounding workspace=-10mm:20mm speed_limit=0.75 \
               start_force=2N rise_time=0.25s braking=4";
    let after = json(&device, set)["safety"].clone();
    let numbers = [
        "start_force_n",
        "rise_time_s",
        "speed_limit_m_per_s",
        "speed_soft_m_per_s",
    ];
    assert_eq!(
        numbers.map(|key| number(&after, key)),
        [2.0, 0.25, 0.75, 0.5]
    );
    assert_eq!(number(&after, "braking_n_s_per_m"), 4.0);
    let ends = after["workspace_m"].as_array().expect("two ends");
    let ends: Vec<f64> = ends.iter().filter_map(Value::as_f64).collect();
    assert!((ends[0] + 0.01).abs() < 1e-8 && (ends[1] - 0.02).abs() < 1e-8);
    // That of the plant that it simulates.
    assert_eq!(after["guard"]["kind"], "energy-bounding");
    assert_eq!(number(&after["guard"], "damping_n_s_per_m"), 3.5);
    let line = "device set guard=off workspace=none speed_limit=0 braking=0 rise_time=0 \
                start_force=0";
    let off = json(&device, line)["safety"].clone();
    assert_eq!(
        (&off["workspace_m"], &off["guard"]),
        (&Value::Null, &Value::Null)
    );
    assert_eq!(numbers.map(|key| number(&off, key)), [0.0; 4]);
}

#[test]
fn the_watchdog_goes_with_the_loop_and_braking_with_the_mass() {
    let device = emulated();
    assert_eq!(number(&json(&device, "device get"), "watchdog_s"), 0.5);
    let host = json(&device, "device set loop=host");
    assert_eq!(number(&host, "watchdog_s"), 0.02);
    let chosen = json(&device, "device set watchdog=50ms loop=device");
    assert_eq!(number(&chosen, "watchdog_s"), 0.05);
    // The simulated mass is known: 65 g bear 21.6 N·s/m with a tick of delay.
    let braked = json(
        &device,
        "device set braking=20 stop_time=50ms brake_force=3N",
    );
    let safety = &braked["safety"];
    assert_eq!(number(safety, "braking_n_s_per_m"), 20.0);
    assert_eq!(number(safety, "brake_force_n"), 3.0);
    assert!((number(safety, "stop_time_s") - 0.05).abs() < 1e-8);
    let refused = device
        .place
        .run("device set braking=30 --device serial:device");
    refused.refused(2, &["braking", "30"]);
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn in_either_loop_the_guard_is_on_the_device() {
    // They take the time of their device, so each has its own.
    std::thread::scope(|scope| {
        for side in ["device", "host"] {
            scope.spawn(move || a_guarded_wall_is_still(side));
        }
    });
}

fn a_guarded_wall_is_still(side: &str) {
    let device = emulated();
    device.loosen();
    device.place.write("wall.toml", SHAKING);
    let report = json(
        &device,
        &format!(
            "run wall.toml --guard energy-bounding watchdog=1s max_age_ticks=1000 --loop {side} --out run --quiet"
        ),
    );
    assert_eq!(report["stable"], true, "{side}: {report}");
    assert!(number(&report, "limited_samples") > 0.0, "{side}: {report}");
}
