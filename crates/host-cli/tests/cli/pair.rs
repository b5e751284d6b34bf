//! Two devices in one experiment: a tissue on one, and on the other the drive that presses it.

use crate::emulated::Emulated;
use crate::process::{Ended, Place, signal};
use haptic_log::record::{Entry, LogFiles, TickMessage};
use serde_json::Value;
use std::path::Path;

/// Both are voice coils of 65 g.
const BODY: &str = "[device]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\n";

/// Fast enough for a ramp in 1 s, on either mass and on both.
const SERVO: &str = "[pid]\nproportional_gain = 8000\nintegral_gain_per_s_lambda = 400000\nderivative_gain_s_mu = 40\n\
                     [loop]\nsample_time_s = 0.001\n";

/// 5 % in 1 s, by two devices that know each other's names.
const RUN: &str = "relax --device serial:device drive_device=serial:white controller=servo.toml device_model=body.toml \
                   drive_device_model=body.toml watchdog=1s";

/// Both boards of one world.
fn facing(options: &str) -> Emulated {
    let pair = Emulated::new(&format!("--facing white {options}"));
    prepare(&pair.place);
    pair
}

fn prepare(place: &Place) {
    place.write("body.toml", BODY);
    place.write("servo.toml", SERVO);
}

fn number(report: &Value, key: &str) -> f64 {
    let value = &report[key];
    value.as_f64().unwrap_or_else(|| panic!("{key}: {value}"))
}

/// The ticks of both devices.
fn ticks(log: &Path) -> [Vec<TickMessage>; 2] {
    let (mut first, mut drive) = (Vec::new(), Vec::new());
    for entry in LogFiles::open(log).expect("opens") {
        match entry.expect("reads") {
            Entry::Tick(tick) => first.push(tick),
            Entry::Drive(tick) => drive.push(tick),
            _ => {}
        }
    }
    [first, drive]
}

/// What a whole run of both has to reach: no sample lost, the force within 1e-6 of the defining sum over the motion that was made and
/// within 0.5 % of the closed form from 0.1 s after the ramp on.
fn reaches(pair: &Emulated, duration_s: u64) {
    let report = pair.json(&format!("{RUN} duration={duration_s}s --out run"));
    let drive = &report["drive"];
    assert_eq!(report["dropped_samples"], 0, "{report}");
    assert_eq!(drive["dropped_samples"], 0, "{report}");
    assert_eq!(drive["samples"], 1000 * duration_s + 1);
    assert!(number(&report, "max_relative_error") < 1e-6, "{report}");
    assert!(number(&report, "closed_form_error") < 0.005, "{report}");
    assert!(
        number(&report, "closed_form_error_from_s") < 1.1011,
        "{report}"
    );
    for stable in ["free", "in_contact"] {
        assert_eq!(drive["preflight"][stable]["stable"], true, "{report}");
    }
    assert!(number(drive, "tracking_error_final") < 1e-5, "{report}");
    // Boards of one emulator have one clock.
    let residual_s = number(drive, "clock_residual_s");
    assert!(
        number(drive, "clock_drift").abs() * duration_s as f64 <= 2.0 * residual_s,
        "{report}"
    );

    let place = &pair.place;
    place.run("log check run/relax.mcap").succeeded();
    let info = place.json("log info run/relax.mcap");
    assert!(
        info["drive_samples"].as_u64() > Some(1000 * duration_s),
        "{info}"
    );
    assert_eq!(info["drive_missing_samples"], 0);
    place
        .run("log export run/relax.mcap --out run/all.csv")
        .succeeded();
    place
        .run("log plot run/relax.mcap --out run/all")
        .succeeded();
    let table = place.text("run/relax.csv");
    let mut rows = table.lines();
    let names = rows.next().expect("names");
    assert!(
        names.ends_with("indenter_position_m,drive_force_n"),
        "{names}"
    );
    assert_eq!(rows.count() as u64, 1000 * duration_s + 1);

    // The drive is where the tissue is, but for what the contact gives, 100 kN/m; its force is what the tissue opposes, and damping.
    let [first, drive] = ticks(&place.path("run/relax.mcap"));
    let held = |ticks: &[TickMessage]| {
        let held = ticks.iter().rev().find(|tick| tick.limiters == 0);
        *held.expect("a tick without limits")
    };
    let (first, drive) = (held(&first), held(&drive));
    assert!(
        (first.time_s - drive.time_s).abs() < 0.01,
        "{first:?} {drive:?}"
    );
    let opposed_n = -first.commanded_force_n[0];
    let overlap_m = drive.position_m[0] - first.position_m[0];
    assert!(
        (overlap_m - opposed_n / 1e5).abs() < 1e-8,
        "{overlap_m} {opposed_n}"
    );
    assert!((drive.commanded_force_n[0] - opposed_n).abs() < 1e-3 * opposed_n);
}

#[test]
fn a_tissue_on_one_device_is_pressed_by_another() {
    reaches(&facing(""), 3);
}

#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_two_devices_hold_a_tissue_for_200_s() {
    reaches(&facing(""), 200);
}

/// The loops of both run here; a creep test takes the force of the other device.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn loops_of_a_pair_may_run_here() {
    let pair = facing("");
    let host = "max_age_ticks=1000 drive_loop=host";
    let slow = "[pid]\nproportional_gain = 900\nintegral_gain_per_s_lambda = 9000\nderivative_gain_s_mu = 12\n[loop]\nsample_time_s = 0.001\n";
    pair.place.write("servo.toml", slow);
    let report = pair.json(&format!(
        "{RUN} {host} duration=3s --force-unstable --out host"
    ));
    assert!(number(&report, "max_relative_error") < 1e-6, "{report}");
    let push = "[pid]\nproportional_gain = 0.3\nintegral_gain_per_s_lambda = 20\n[loop]\nsample_time_s = 0.001\n";
    pair.place.write("servo.toml", push);
    let creep = RUN.replace("relax", "creep");
    let report = pair.json(&format!(
        "{creep} {host} duration=3s --force-unstable --out creep"
    ));
    assert!(number(&report, "closed_form_error") < 0.02, "{report}");
    let peak_n = number(&report["drive"], "tracking_error_final");
    assert!(peak_n < 0.01, "{report}");
}

/// Two boards that do not meet, each in a process of its own: the tissue's simulates the indentation.
struct Apart {
    tissue: Emulated,
    drive: Emulated,
}

impl Apart {
    fn new(options: &str) -> Self {
        let tissue = Emulated::new(options);
        prepare(&tissue.place);
        let drive = Emulated::new(options);
        std::os::unix::fs::symlink(drive.place.path("device"), tissue.place.path("white"))
            .expect("links");
        Self { tissue, drive }
    }
}

/// What is done to one of two devices, or to the program that runs them.
#[derive(Clone, Copy, Debug)]
enum Mischance {
    TissueKilled,
    DriveKilled,
    TissueHangs,
    DriveHangs,
    Interrupted,
    ProgramKilled,
}

const MISCHANCES: [Mischance; 6] = [
    Mischance::TissueKilled,
    Mischance::DriveKilled,
    Mischance::TissueHangs,
    Mischance::DriveHangs,
    Mischance::Interrupted,
    Mischance::ProgramKilled,
];

/// After a mischance so many ms into the run the other device has no force within its watchdog time, by its own clock, and the log is whole
/// or says what it lacks.
fn lets_go(mischance: Mischance, after_ms: u64) {
    let mut apart = Apart::new("");
    let place = &apart.tissue.place;
    let line = format!("{RUN} duration=100s --force-unstable --out run");
    let mut child = place.start(&line);
    place.wait_for("run/relax.mcap.part", &mut child);
    std::thread::sleep(std::time::Duration::from_millis(after_ms));
    match mischance {
        Mischance::TissueKilled => apart.tissue.kill(),
        Mischance::DriveKilled => apart.drive.kill(),
        Mischance::TissueHangs => apart.tissue.hang(),
        Mischance::DriveHangs => apart.drive.hang(),
        Mischance::Interrupted => signal(&child, "INT"),
        Mischance::ProgramKilled => child.kill().expect("can be killed"),
    }
    let output = child.wait_with_output().expect("ends");
    let ended = Ended::new(line, &output);
    let place = &apart.tissue.place;
    if let Mischance::ProgramKilled = mischance {
        // Both boards are there, and have let go by their watchdogs.
        place.run("log recover run/relax.mcap.part run/relax.mcap");
        for device in ["device", "white"] {
            let status = place.run(&format!("device info --device serial:{device} --json"));
            let status = status.succeeded_with_warnings().json();
            assert!(
                ["fault", "idle"].contains(&status["state"].as_str().expect("a state")),
                "{status}"
            );
        }
    }
    let log = place.path("run/relax.mcap");
    let [tissue, drive] = ticks(&log);
    assert!(!tissue.is_empty(), "{ended}");
    let last = |ticks: &[TickMessage]| ticks.last().map_or(0.0, |tick| tick.time_s);
    let forced = |ticks: &[TickMessage]| {
        let forced = ticks
            .iter()
            .rev()
            .find(|tick| tick.applied_force_n[0] != 0.0);
        forced.map_or(0.0, |tick| tick.time_s)
    };
    // The end of the one that was lost, and the last force of the other: both in the time of the log.
    let (lost_s, forced_s) = match mischance {
        Mischance::TissueKilled | Mischance::TissueHangs => (last(&tissue), forced(&drive)),
        Mischance::DriveKilled | Mischance::DriveHangs => (last(&drive), forced(&tissue)),
        Mischance::Interrupted | Mischance::ProgramKilled => return,
    };
    assert!(
        forced_s <= lost_s + 1.0,
        "{mischance:?} after {after_ms} ms: {forced_s} {lost_s}\n{ended}"
    );
    assert_eq!(
        ended.code,
        Some(3),
        "{mischance:?} after {after_ms} ms: {ended}"
    );
    // Whole, or told.
    let check = place.run("log check run/relax.mcap");
    assert!(
        check.code == Some(0) || check.stderr.contains("missing") || check.stderr.contains("lost"),
        "{check}"
    );
}

/// A moment of a run, ms: before its begin, in the ramp, in the hold.
fn moment(n: u64) -> u64 {
    (n.wrapping_mul(2_654_435_761) >> 7) % 2500
}

#[test]
fn if_one_of_two_devices_is_lost_the_other_lets_go() {
    for (n, mischance) in MISCHANCES.into_iter().enumerate() {
        lets_go(mischance, 700 + moment(n as u64) / 4);
    }
}

#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_if_one_of_two_devices_is_lost_at_any_moment_the_other_lets_go() {
    for n in 0..50 {
        lets_go(MISCHANCES[n as usize % MISCHANCES.len()], moment(n));
    }
}

#[test]
fn what_cannot_be_a_pair_is_refused_before_any_force() {
    let pair = facing("");
    let place = &pair.place;
    std::os::unix::fs::symlink(place.path("white"), place.path("also")).expect("links");
    place.write("wild.toml", SERVO.replace("8000", "80000"));
    place.write(
        "function.toml",
        "[transfer_function]\nfunction = \"3000\"\n[loop]\nsample_time_s = 0.001\n",
    );
    place.write("quick.toml", SERVO.replace("0.001", "0.00002"));
    place.refuses(
        "
        relax --device serial:white drive_device=serial:also controller=servo.toml --out no => may be the same device
        relax --device serial:auto drive_device=serial:white controller=servo.toml --out no => may be the same device
        relax drive_device=serial:white controller=servo.toml --out no => both devices of a drive
        relax --device serial:device drive_device=sim controller=servo.toml --out no => both devices of a drive
        relax --device serial:device drive_device=serial:white --out no => missing key `controller`
        relax --device serial:device controller=servo.toml drive_loop=host --out no => drive_loop has no effect
        relax --device serial:device controller=servo.toml contact_stiffness=1kN/m --out no => contact_stiffness_n_per_m has no effect
        relax --device serial:device drive_device=serial:white controller=function.toml --out no => `drive_loop` = host
        relax --device serial:device drive_device=serial:white controller=servo.toml duration=2000s --out no => at most 1000000 samples
        creep --device serial:device drive_device=serial:white controller=servo.toml --out no => `drive_loop` = host
        ",
    );
    let wild = RUN.replace("servo", "wild");
    place
        .run(&format!("{wild} --out no"))
        .refused(2, &["unstable"]);
    let quick = RUN.replace("servo", "quick");
    place
        .run(&format!("{quick} sample_time=20us duration=3s --out no"))
        .refused(2, &["sample time", "serial:device"]);
    let gone = RUN.replace("white", "gone");
    place
        .run(&format!("{gone} --out no"))
        .refused(3, &["serial:gone"]);
    assert!(!place.path("no").exists());
    for device in ["device", "white"] {
        let info = pair.json(&format!("device info --device serial:{device}"));
        assert_eq!(info["state"], "idle", "{info}");
    }
}
