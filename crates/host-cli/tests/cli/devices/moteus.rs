//! A moteus servo: the emulated one held to the maker's own client, and experiments on it.

use super::{Emulated, number};
use serde_json::Value;
use std::path::Path;
use std::process::{Child, Command};
use std::time::Duration;
use testkit::skip;

/// A servo as a device; this machine may be too busy to answer in time for so long, so lost answers are allowed for.
const DEVICE: &str = "--device moteus:device,radius=20mm,watchdog=1s,lost=1000";

/// What the maker's Python package reads from an emulated servo.
fn read_by_the_maker(device: &Emulated, id: u8) -> Option<Value> {
    let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    let script =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/conformance/moteus_servo.py");
    let run = Command::new(python)
        .arg(script)
        .arg(device.place.path("device"))
        .arg(id.to_string())
        .output();
    let Ok(output) = run else {
        skip("there is no Python");
        return None;
    };
    let errors = String::from_utf8_lossy(&output.stderr);
    if output.status.code() == Some(3) {
        skip(&errors);
        return None;
    }
    assert!(output.status.success(), "{errors}");
    Some(serde_json::from_slice(&output.stdout).expect("JSON"))
}

#[test]
fn the_makers_own_client_takes_the_emulated_servo_for_a_real_one() {
    let device = Emulated::at_terminal("device", "--kind moteus servo_id=5");
    let Some(seen) = read_by_the_maker(&device, 5) else {
        return;
    };
    let is = |path: &str, value: f64| {
        let found = number(&seen, path);
        assert!(
            (found - value).abs() < 1e-6,
            "{path} is {found}, not {value}: {seen}"
        );
    };
    for step in [
        "stopped",
        "driven",
        "turning",
        "stopped_again",
        "silent",
        "last",
    ] {
        is(&format!("/{step}/fault"), 0.0);
        is(&format!("/{step}/voltage_v"), 24.0);
        is(&format!("/{step}/temperature_c"), 25.0);
    }
    is("/stopped/mode", 0.0);
    is("/stopped/torque_nm", 0.0);
    is("/driven/mode", 10.0);
    is("/driven/torque_nm", 0.0125);
    // The lever of 4e-5 kg·m² turns, with at most the speed that 0.0125 N·m reaches against 2e-4 N·m·s.
    let speed = number(&seen, "/turning/velocity_rev_per_s");
    assert!(
        speed > 0.5 && speed < 0.0125 / 2e-4 / core::f64::consts::TAU,
        "{seen}"
    );
    assert!(number(&seen, "/turning/position_rev") > 0.01, "{seen}");
    is("/integers/mode", 10.0);
    // 1 mN·m a step, cut off.
    is("/integers/torque_nm", 0.012);
    is("/registers/0x22", 0.0125);
    is("/registers/0x25", 1.0);
    is("/registers/0x102", 5.0);
    for (step, mode) in [
        ("stopped_again", 0.0),
        ("silent", 11.0),
        ("refused", 11.0),
        ("last", 0.0),
    ] {
        is(&format!("/{step}/mode"), mode);
        is(&format!("/{step}/torque_nm"), 0.0);
    }
}

#[test]
fn info_names_the_servo_and_its_largest_force() {
    let device = Emulated::new("--kind moteus");
    let info = device.json(&format!("device info {DEVICE}"));
    assert_eq!(info["board"], "moteus");
    assert_eq!(info["simulated"], false);
    let most = number(&info, "/force_max_n");
    assert!((most - 5.0).abs() < 1e-5, "0.1 N·m at 20 mm: {info}");
}

/// A relaxation at 500 Hz of a servo that a hand turns by 2 mm within half a second.
fn relax(place_of_loop: &str, duration: &str) -> String {
    format!(
        "relax {DEVICE} --loop {place_of_loop} --contact rigid --duration {duration} --sample-time 2ms force_limit=4N \
         watchdog=1s late_ticks=0 max_age_ticks=1000 --out run --quiet"
    )
}

/// What a servo said at its end: mode, torque and largest torque.
fn last_words(said: &str) -> (f64, f64, f64) {
    let after = |words: &str| -> f64 {
        let rest = said
            .split(words)
            .nth(1)
            .and_then(|rest| rest.split([' ', ',']).next());
        let number = rest.and_then(|number| number.parse().ok());
        number.unwrap_or_else(|| panic!("no number after {words}: {said}"))
    };
    (after("mode "), after(" torque "), after("the largest "))
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_relaxation_runs_on_a_servo_and_leaves_it_stopped() {
    let mut device = Emulated::new("--kind moteus turn=2mm:0.5s");
    let ended = device
        .place
        .run(&format!("{} --json", relax("device", "2s")));
    // How near the force is to the sum over the motion is held in virtual time, by the tests of `haptic-devices`.
    let report = ended.ended_by_the_clock().json();
    println!("{report}");
    assert!(number(&report, "/max_relative_error").is_finite());
    assert_eq!(report["link"]["board"], "moteus");
    let peak_n = number(&report, "/peak_force_n");
    // A log that lacks samples may lack the one with the largest force.
    let lacks = number(&report, "/dropped_samples") > 0.0;
    assert!(peak_n <= 4.0 && (lacks || peak_n > 0.01), "{report}");
    // The last digit is rounded.
    let (mode, torque_nm, most_nm) = last_words(&device.ends());
    let unlogged_nm = most_nm - 0.02 * peak_n;
    assert!(
        unlogged_nm > -1e-6 && (lacks || unlogged_nm < 1e-6),
        "{most_nm} N·m for {peak_n} N"
    );
    assert!(most_nm <= 0.02 * 4.0, "{most_nm} N·m");
    assert_eq!((mode, torque_nm), (0.0, 0.0));
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_host_closes_the_loop_over_a_servo_as_over_a_board() {
    let mut device = Emulated::new("--kind moteus turn=2mm:0.5s");
    let ended = device.place.run(&format!("{} --json", relax("host", "2s")));
    let report = ended.ended_by_the_clock().json();
    assert_eq!(report["link"]["loop"], "host");
    let (mode, torque_nm, most_nm) = last_words(&device.ends());
    let lacks = number(&report, "/dropped_samples") > 0.0;
    let driven = lacks || most_nm > 0.0;
    assert!(driven && most_nm <= 0.02 * 4.0, "{most_nm} N·m");
    assert_eq!((mode, torque_nm), (0.0, 0.0));
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_host_that_is_killed_leaves_no_torque_on_the_servo() {
    let mut device = Emulated::new("--kind moteus turn=2mm:0.5s");
    let mut run = under_way(&device, &relax("device", "300s"));
    run.kill().expect("can be killed");
    run.wait().expect("ends");
    // Longer than the servo's watchdog, and than this machine is late.
    std::thread::sleep(Duration::from_millis(2500));
    let (mode, torque_nm, most_nm) = last_words(&device.ends());
    assert_eq!((mode, torque_nm), (11.0, 0.0), "it has let go");
    if most_nm <= 0.0 {
        testkit::skip_for_load("the servo was not driven before the host was killed");
    }
}

/// A run whose log has begun.
fn under_way(device: &Emulated, line: &str) -> Child {
    let mut run = device.place.start(line);
    device.place.wait_for("run/relax.mcap.part", &mut run);
    std::thread::sleep(Duration::from_millis(1500));
    run
}

#[test]
fn a_name_or_servo_that_cannot_be_is_said_in_one_line() {
    let device = Emulated::new("--kind moteus");
    let info = |name: &str| {
        let line = format!("device info --device {name}");
        device.place.run(&line)
    };
    info("moteus:device,servo=1").refused(2, &["servo=1"]);
    info("moteus:device,id=2").refused(3, &["servo 2 did not answer", "its number (`id`)"]);
}

#[test]
fn what_a_servo_did_not_take_is_told_by_report_warning_and_log() {
    // One line in two is damaged by it.
    let mut device = Emulated::at_terminal("device", "--kind moteus drop=1% line_seed=5");
    let line = "relax --device moteus:device,lost=1000,watchdog=1s watchdog=1s late_ticks=0 --contact rigid --ramp-time 0.2s \
                --duration 1s --sample-time 2ms --out run --json";
    // A busy machine may skip ticks too.
    let ended = device.place.run(line).ended_by_the_clock();
    let report = ended.json();
    let of = |key: &str| number(&report, &format!("/link/{key}"));
    let (unanswered, not_taken) = (of("unanswered"), of("forces_not_taken"));
    assert!(unanswered > 100.0 && not_taken >= unanswered, "{report}");
    let told = format!("{unanswered} had no answer of its board");
    assert!(ended.stderr.contains(&told), "{ended}");
    // The log has the ticks of the run, the link those before and after it too.
    let check = device
        .place
        .run("log check run/relax.mcap --json")
        .failed(4);
    assert!(check.error().contains("ticks are stale"), "{check}");
    let check = check.json();
    let logged = number(&check, "/unanswered");
    assert!(logged > 100.0 && logged <= unanswered, "{check}");
    // What the servo heard, and what it was sent: each tick one frame, and those of opening it.
    let said = device.ends();
    let heard: f64 = said
        .split("emulated: ")
        .nth(1)
        .and_then(|rest| rest.split(' ').next())
        .and_then(|number| number.parse().ok())
        .unwrap_or_else(|| panic!("{said}"));
    let sent = of("ticks");
    assert!(
        heard + not_taken >= sent,
        "{heard} heard, {not_taken} not taken, {sent} sent"
    );
}
