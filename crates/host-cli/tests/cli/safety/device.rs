//! The safety chain of a device on a serial line.

use super::*;
use crate::emulated::Emulated;
use crate::process::{cases, says};

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
    let set = "device set --guard energy-bounding --workspace -10mm:20mm --speed-limit 0.75 \
               --start-force 2N --rise-time 0.25s --braking 4";
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
    let shown = device
        .place
        .run("device get --device serial:device")
        .succeeded();
    says(
        &shown.stdout,
        &[
            "at most 2 N",
            "rises in 0.25 s",
            "0.75 m/s",
            "guard energy-bounding",
        ],
    );
    for (change, words) in cases(
        "
        --workspace -200:1 => low end of the workspace | -200
        --rise-time 100s => rise time | 100
        --start-force -1N => start force | -1
        --guard energy-bounding --device-damping 0 => device damping 0 | 0
        ",
    ) {
        let line = format!("device set {change} --device serial:device");
        device.place.run(&line).refused(2, &words);
    }
    let line = "device set --guard off --workspace none --speed-limit 0 --braking 0 --rise-time 0 \
                --start-force 0";
    let off = json(&device, line)["safety"].clone();
    assert_eq!(
        (&off["workspace_m"], &off["guard"]),
        (&Value::Null, &Value::Null)
    );
    assert_eq!(numbers.map(|key| number(&off, key)), [0.0; 4]);
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_wall_keeps_what_it_does_not_speak_of() {
    let device = emulated();
    json(
        &device,
        "device set --force-rate-limit 700N/s --speed-limit 0.9 --rise-time 0.2s",
    );
    let limits = |device: &Emulated| {
        let now = json(device, "device get");
        let safety = &now["safety"];
        [
            number(&now, "force_rate_limit_n_per_s"),
            number(safety, "speed_limit_m_per_s"),
            number(safety, "rise_time_s"),
        ]
        .map(|x| (1e6 * x).round() / 1e6)
    };
    let soft = SHAKING.replace("8000", "1000") + "duration_s = 1\n";
    device.place.write("wall.toml", &soft);
    json(&device, "run wall.toml watchdog=1s --out kept --quiet");
    assert_eq!(limits(&device), [700.0, 0.9, 0.2]);
    device.place.write(
        "wall.toml",
        format!("{soft}force_rate_limit_n_per_s = 600\n"),
    );
    json(
        &device,
        "run wall.toml watchdog=1s --out asked rise_time=0.3s --quiet",
    );
    // The run had what it asked for; the device has what was set again.
    let log = device.place.run("log info asked/wall.mcap --json");
    let info = log.succeeded().json();
    let records = info["metadata"].as_array().expect("records");
    let named = |name: &str| records.iter().find(|record| record["name"] == name);
    let run = &named("experiment").expect("is there")["values"];
    assert_eq!(run["device_force_rate_limit_n_per_s"], "600");
    assert_eq!(run["device_rise_time_s"], "0.3");
    assert_eq!(limits(&device), [700.0, 0.9, 0.2]);
}

#[test]
fn the_watchdog_goes_with_the_loop_and_braking_with_the_mass() {
    let device = emulated();
    assert_eq!(number(&json(&device, "device get"), "watchdog_s"), 0.5);
    let host = json(&device, "device set --loop host");
    assert_eq!(number(&host, "watchdog_s"), 0.02);
    let chosen = json(&device, "device set --watchdog 50ms --loop device");
    assert_eq!(number(&chosen, "watchdog_s"), 0.05);
    // The simulated mass is known: 65 g bear 21.6 N·s/m with a tick of delay.
    let braked = json(
        &device,
        "device set --braking 20 --stop-time 50ms --brake-force 3N",
    );
    let safety = &braked["safety"];
    assert_eq!(number(safety, "braking_n_s_per_m"), 20.0);
    assert_eq!(number(safety, "brake_force_n"), 3.0);
    assert!((number(safety, "stop_time_s") - 0.05).abs() < 1e-8);
    for (change, words) in cases(
        "
        --stiffness 1e39 => stiffness 1e39 N/m is not | from 0 to 1e8
        --force-limit 1e-60N => --force-limit 1e-60 is not | 1.4e-45
        --watchdog 5.4ms => 0.0054s is not a whole number of milliseconds | --watchdog
        --braking 30 => braking | 30
        --braking 6 --device-mass 0 => braking | 6
        --stop-time 2s => stop time | 2
        --brake-force 11N => brake force | 11
        ",
    ) {
        let line = format!("device set {change} --device serial:device");
        device.place.run(&line).refused(2, &words);
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn experiments_on_a_device_have_its_chain() {
    // They take the time of their device, so each has its own.
    std::thread::scope(|scope| {
        for side in ["device", "host"] {
            scope.spawn(move || a_guarded_wall_is_still(side));
        }
        scope.spawn(a_relaxation_is_limited_as_far_as_asked_for);
    });
}

/// With limits that no experiment here reaches: a run may not loosen what is set.
fn loose() -> Emulated {
    let device = emulated();
    json(
        &device,
        "device set --rise-time 0s --force-limit 100N --force-rate-limit 200kN/s --speed-limit 0m/s \
         --start-force 0N",
    );
    device
}

/// In either loop the guard is on the device.
fn a_guarded_wall_is_still(side: &str) {
    let device = loose();
    device.place.write("wall.toml", SHAKING);
    let report = json(
        &device,
        &format!(
            "run wall.toml --guard energy-bounding watchdog=1s max_age_ticks=1000 --loop {side} --out run --quiet"
        ),
    );
    assert_eq!(report["stable"], true, "{side}: {report}");
    assert!(number(&report, "limited_samples") > 0.0, "{side}: {report}");
    if side == "device" {
        let ticks = ticks(&device.place, "run/wall.mcap");
        assert!(ticks.iter().all(|row| row[ENERGY].is_nan()));
    }
}

fn a_relaxation_is_limited_as_far_as_asked_for() {
    let device = loose();
    let line = format!(
        "{RELAX} --device serial:device watchdog=1s workspace_low=-1mm workspace_high=0.5mm --quiet"
    );
    device.place.run(&line).failed(1);
    let check = device
        .place
        .run("log check run/relax.mcap --json")
        .succeeded()
        .json();
    assert!(check["events"].to_string().contains("workspace"), "{check}");
    // Without a word the force is neither ramped nor braked.
    let plain = json(&device, &format!("{RELAX} watchdog=1s --overwrite --quiet"));
    assert_eq!(number(&plain, "limited_samples"), 0.0);
}
