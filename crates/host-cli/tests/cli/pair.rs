//! Two devices in one experiment: a tissue on one, and on the other the drive that presses it.

use crate::emulated::Emulated;
use crate::process::{Ended, Place, column, number, signal};
use haptic_log::record::{Entry, LogFiles};
use haptic_loop::Limiters;
use haptic_message::TickMessage;
use serde_json::Value;
use std::path::Path;
use testkit::{assert_close, assert_says};

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

/// `None` on a machine so busy that it hears keep-alives late: the clocks then leave more open than a tenth of the error.
fn closed_form_error(report: &Value) -> Option<f64> {
    let error = report["closed_form_error"].as_f64();
    if error.is_none() {
        let reason = report["closed_form_error_reason"].to_string();
        assert_says(&reason, "the clocks of both devices tell within");
    }
    error
}

/// The ticks of both devices.
fn ticks(log: &Path) -> [Vec<TickMessage>; 2] {
    let (mut first, mut drive) = (Vec::new(), Vec::new());
    for entry in LogFiles::open(log).expect("opens") {
        match entry.expect("reads") {
            Entry::Tick(tick) => first.push(tick),
            Entry::Drive(tick) => drive.push(tick),
            Entry::Event(_) | Entry::Metadata(_) | _ => {}
        }
    }
    [first, drive]
}

/// What a whole run of both has to reach: no sample lost, the force within 1e-6 of its peak of the defining sum over the motion that was
/// made and within 0.5 % of the closed form from 0.1 s after the ramp on.
fn reaches(pair: &Emulated, duration_s: u64) {
    // The weights of the default scheme are only right to 1e-6.
    let scheme = "scheme=full:1e-8";
    let report = pair.json(&format!("{RUN} {scheme} duration={duration_s}s --out run"));
    let drive = &report["drive"];
    assert_eq!(report["dropped_samples"], 0, "{report}");
    assert_eq!(drive["dropped_samples"], 0, "{report}");
    let table = pair.place.text("run/relax.csv");
    let [force_n, full_n] =
        ["rendered_force_n", "full_history_force_n"].map(|name| column(&table, name));
    let off_n = (force_n.iter().zip(&full_n)).map(|(force, full)| (force - full).abs());
    let off = off_n.fold(0.0, f64::max) / number(&report, "peak_force_n");
    assert!(off < 1e-6 && force_n.len() > 900, "{off}: {report}");
    // Boards of one emulator have one clock: so all that is between them is when each began. The closed form counts from the tissue's
    // start, so that a drive which a busy machine lets begin later has relaxed for less: d ln σ = −μ dt/t.
    let apart_s = number(drive, "clock_drive_tick_0_s") - number(drive, "clock_tick_0_s");
    let late = number(&report, "order") * apart_s.max(0.0) / 1.1;
    if let Some(error) = closed_form_error(&report) {
        assert!(error < 0.005 + late, "{report}");
        assert!(number(&report, "closed_form_error_from_s") < 1.1011);
    }
    for key in ["max_relative_error", "closed_form_error"] {
        println!("{key}: {}", report[key]);
    }
    for key in ["tracking_error_final", "clock_drift", "clock_residual_s"] {
        println!("drive.{key}: {}", drive[key]);
    }
    for stable in ["free", "in_contact"] {
        assert_eq!(drive["preflight"][stable]["stable"], true, "{report}");
    }
    let residual_s = number(drive, "clock_residual_s");
    for time_s in [0.0, duration_s as f64] {
        let error_s =
            number(drive, "clock_offset_s") + number(drive, "clock_drift") * time_s - apart_s;
        println!("clocks at {time_s} s: {error_s} s, at most {residual_s} s");
        assert!(error_s.abs() <= residual_s, "{error_s} {report}");
    }

    let place = &pair.place;
    place.run("log check run/relax.mcap").succeeded();
    let info = place.json("log info run/relax.mcap");
    assert!(
        info["drive_samples"].as_u64() > Some(1000 * duration_s - 200),
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
    let rows: Vec<&str> = rows.collect();
    assert_eq!(rows.len() as u64, 1000 * duration_s + 1);
    // At the very end too: the drive holds on until the other device has made its samples.
    let held_s = duration_s as f64;
    let row = rows.iter().map(|row| {
        let mut values = row.split(',').map(|value| value.parse().expect("a number"));
        let mut next = move || values.next().expect("a column");
        [next(), next(), next()]
    });
    let held: Option<[f64; 3]> = row.into_iter().find(|[time_s, ..]| *time_s >= held_s);
    let [_, ideal_m, position_m] = held.expect("a row of the hold");
    assert!((ideal_m - position_m).abs() < 1e-5, "{held:?}");

    // The drive is where the tissue is, but for what the contact gives, 100 kN/m; its force is what the tissue opposes, and damping.
    let [first, drive] = ticks(&place.path("run/relax.mcap"));
    let at = |ticks: &[TickMessage], time_s: f64| {
        let tick = ticks.iter().find(|tick| tick.time_s >= time_s);
        *tick.expect("a tick of the hold")
    };
    let (first, drive) = (at(&first, held_s), at(&drive, held_s));
    assert_eq!([first.limiters, drive.limiters], [0, 0]);
    let opposed_n = -first.commanded_force_n[0];
    let overlap_m = drive.position_m[0] - first.position_m[0];
    assert_close("overlap_m", overlap_m, opposed_n / 1e5, 1e-8);
    assert_close(
        "drive.commanded_force_n[0]",
        drive.commanded_force_n[0],
        opposed_n,
        1e-3 * opposed_n,
    );
}

#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_a_tissue_on_one_device_is_pressed_by_another() {
    // Settled by its end even if a busy machine lets the drive begin a second late.
    reaches(&facing(""), 4);
}

#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_two_devices_hold_a_tissue_for_200_s() {
    reaches(&facing(""), 200);
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

/// The time from which a device lets go, by its own word or its silence, and that of its last force, s. Between them no force grows.
fn letting_go(ticks: &[TickMessage], what: &str) -> (f64, f64) {
    let over = Limiters::FAULT.bits() | Limiters::STOPPING.bits();
    let force_n = |tick: &TickMessage| tick.applied_force_n[0].abs();
    let limited = ticks.iter().position(|tick| tick.limiters & over != 0);
    let from = limited.unwrap_or(ticks.len().saturating_sub(1));
    for pair in ticks[from..].windows(2) {
        assert!(force_n(&pair[1]) <= force_n(&pair[0]), "{pair:?} {what}");
    }
    let forced = ticks.iter().rev().find(|tick| force_n(tick) != 0.0);
    let time_s = |tick: Option<&TickMessage>| tick.map_or(0.0, |tick| tick.time_s);
    (time_s(ticks.get(from)), time_s(forced))
}

/// Error of a time of one device on the clock of the other, as the log of a run says it, s. That of an emulated one waits while this machine
/// is too busy to tick it.
fn clock_error_s(log: &Path) -> f64 {
    let mut entries = LogFiles::open(log).expect("opens");
    let message = entries.find_map(|entry| match entry.expect("reads") {
        Entry::Metadata(metadata) if metadata.name == "drive.clock" => {
            metadata.values.get("clock_residual_s")?.parse().ok()
        }
        Entry::Tick(_) | Entry::Drive(_) | Entry::Event(_) | Entry::Metadata(_) | _ => None,
    });
    message.unwrap_or(0.0)
}

/// No device has a force later than a watchdog time behind the end of the first that let go.
fn both_let_go(log: &Path, what: &str) {
    let error_s = clock_error_s(log);
    let sides = ticks(log).map(|ticks| letting_go(&ticks, what));
    // A drive that never began has no end either.
    let ends = sides.iter().map(|side| side.0).filter(|end_s| *end_s > 0.0);
    let ended_s = ends.fold(f64::INFINITY, f64::min);
    println!("ends and last forces, s: {sides:?}, clocks within {error_s} s");
    for (_, forced_s) in sides {
        assert!(
            forced_s <= ended_s + 1.0 + error_s,
            "{sides:?} {error_s} {what}"
        );
    }
}

/// Ctrl-C was the end, or came to a run whose line had ended it.
fn interrupted(ended: &Ended) {
    assert!([Some(1), Some(3)].contains(&ended.code), "{ended}");
}

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
                ["in a fault", "idle"].contains(&status["state"].as_str().expect("a state")),
                "{status}"
            );
        }
    }
    let log = place.path("run/relax.mcap");
    let [tissue, drive] = ticks(&log);
    let what = format!("{mischance:?} after {after_ms} ms: {ended}");
    // Lost before its first tick: then the other has not begun.
    assert!(!tissue.is_empty() || drive.is_empty(), "{what}");
    println!("{mischance:?} after {after_ms} ms");
    if let Mischance::ProgramKilled = mischance {
        // Its log ends before they let go.
        return;
    }
    both_let_go(&log, &what);
    if let Mischance::Interrupted = mischance {
        return interrupted(&ended);
    }
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

/// A bad line to one of two boards that share a world, and Ctrl-C so many ms into a run that it has not ended.
fn lets_go_on_a_bad_line(line: &str, after_ms: u64) {
    let pair = facing(line);
    let place = &pair.place;
    let run = format!("{RUN} duration=100s --out run");
    let mut child = place.start(&run);
    while !place.path("run/relax.mcap.part").exists() {
        if child.try_wait().expect("can be asked").is_some() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    std::thread::sleep(std::time::Duration::from_millis(after_ms));
    signal(&child, "INT");
    let ended = Ended::new(run, &child.wait_with_output().expect("ends"));
    let what = format!("{line}, Ctrl-C after {after_ms} ms: {ended}");
    if !place.path("run/relax.mcap").exists() {
        // It never was armed.
        assert!([Some(1), Some(3)].contains(&ended.code), "{what}");
        println!("no run: {what}");
        return;
    }
    both_let_go(&place.path("run/relax.mcap"), &what);
    println!("{line}, Ctrl-C after {after_ms} ms: {}", ended.error());
    assert!(matches!(ended.code, Some(1 | 3)), "{what}");
    let check = place.run("log check run/relax.mcap");
    assert!(
        check.code == Some(0) || check.stderr.contains("missing") || check.stderr.contains("lost"),
        "{check}"
    );
}

/// What lines do: now and then they lose and damage frames, or stop for longer than a watchdog time.
const BAD_LINES: [&str; 6] = [
    "",
    "facing_drop=2% facing_corrupt=2%",
    "drop=2% corrupt=2%",
    "facing_stall=0.3% facing_stall_time=3s",
    "stall=0.3% stall_time=3s",
    "drop=1% facing_drop=1% stall=0.2% facing_stall=0.2% stall_time=200ms facing_stall_time=200ms",
];

#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_two_boards_of_one_world_let_go_on_bad_lines_and_at_ctrl_c() {
    for n in 0..36 {
        let line = BAD_LINES[n as usize % BAD_LINES.len()];
        let seeds = format!("line_seed={} facing_line_seed={}", 2 * n + 1, 2 * n + 101);
        lets_go_on_a_bad_line(&format!("{line} {seeds}"), moment(n));
    }
}

/// A fault of the drive's board lets the tissue's go too; the drive has a log of its fault of its own.
#[test]
fn a_fault_of_the_drive_ends_the_run_of_both() {
    let pair = facing("");
    let place = &pair.place;
    // The ramp moves at 1 mm/s.
    pair.json("device set --device serial:white speed_limit=0.8mm/s");
    let ended = place.run(&format!("{RUN} duration=60s --out run"));
    assert_eq!(ended.code, Some(1), "{ended}");
    for message in ["drive serial:white", "moved faster", "force was zero"] {
        assert!(ended.stderr.contains(message), "{ended}");
    }
    assert!(place.path("run/relax-drive-fault.mcap").exists());
    assert!(!place.path("run/relax-fault.mcap").exists());
    let [tissue, drive] = ticks(&place.path("run/relax.mcap"));
    let fault = Limiters::FAULT.bits();
    let faulted = drive.iter().find(|tick| tick.limiters & fault != 0);
    let faulted_s = faulted.expect("a fault").time_s;
    let mut forced = tissue.iter().rev();
    let forced = forced.find(|tick| tick.applied_force_n[0] != 0.0);
    let forced_s = forced.map_or(0.0, |tick| tick.time_s);
    assert!(forced_s < faulted_s + 1.0, "{forced_s} {faulted_s}");
    place.run("log check run/relax.mcap").succeeded();
}

/// A moment of a run, ms: before its begin, in the ramp, in the hold.
fn moment(n: u64) -> u64 {
    (n.wrapping_mul(2_654_435_761) >> 7) % 2500
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
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
