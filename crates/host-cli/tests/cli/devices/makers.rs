//! Devices of other makers, emulated: held to the makers' own programs, and experiments on them.

use super::{Emulated, at};
use crate::process::{column, number};
use haptic_devices::haply::Version;
use serde_json::Value;
use std::path::Path;
use std::process::Command;
use testkit::{assert_close, skip};

/// A servo as a device; this machine may be too busy to answer in time for so long, so lost answers are allowed for.
const DEVICE: &str = "--device moteus:device,radius=20mm,watchdog=1s,lost=1000";

/// What a maker's own program, run by a script, tells of an emulated device; `None` where it is not installed.
fn by_the_maker(script: &str, device: &Path, arguments: &[String]) -> Option<Value> {
    let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/conformance");
    let mut command = Command::new(&python);
    command.arg(folder.join(script)).arg(device).args(arguments);
    let output = match command.output() {
        Ok(output) => output,
        Err(error) => {
            skip(&format!("{}: {error}", python.display()));
            return None;
        }
    };
    let message = String::from_utf8_lossy(&output.stderr);
    if output.status.code() == Some(3) {
        skip(message.trim());
        return None;
    }
    assert!(output.status.success(), "{message}");
    Some(serde_json::from_slice(&output.stdout).expect("one JSON object"))
}

/// The numbers behind these words in what an emulated device says at its end.
pub(crate) fn numbers_after(message: &str, before: &str, count: usize) -> Vec<f64> {
    let text = message.split(before).nth(1);
    let text = text.unwrap_or_else(|| panic!("no {before}: {message}"));
    let words = text.split([' ', ',', ';']);
    words
        .filter_map(|word| word.parse().ok())
        .take(count)
        .collect()
}

#[test]
fn the_makers_own_client_takes_the_emulated_servo_for_a_real_one() {
    let device = Emulated::at_terminal("device", "--kind moteus servo_id=5");
    let path = device.place.path("device");
    let Some(seen) = by_the_maker("moteus_servo.py", &path, &["5".to_owned()]) else {
        return;
    };
    let is = |path: &str, value: f64| assert_close(path, at(&seen, path), value, 1e-6);
    for step in "stopped driven turning stopped_again silent last".split(' ') {
        is(&format!("/{step}/fault"), 0.0);
        is(&format!("/{step}/voltage_v"), 24.0);
        is(&format!("/{step}/temperature_c"), 25.0);
    }
    is("/stopped/mode", 0.0);
    is("/stopped/torque_nm", 0.0);
    is("/driven/mode", 10.0);
    is("/driven/torque_nm", 0.0125);
    // The lever of 4e-5 kg·m² turns, with at most the speed that 0.0125 N·m reaches against 2e-4 N·m·s.
    let speed = at(&seen, "/turning/velocity_rev_per_s");
    let most = 0.0125 / 2e-4 / core::f64::consts::TAU;
    assert!(speed > 0.5 && speed < most, "{seen}");
    assert!(at(&seen, "/turning/position_rev") > 0.01, "{seen}");
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
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_run_that_a_person_holds_says_what_was_felt_unless_it_has_to_be_stable() {
    let device = Emulated::new("--kind moteus turn=2mm:0.2s");
    let keys = "mass_kg = 0.1\ndamping_n_s_per_m = 0.5\nsample_time_s = 2e-3\norder = 1\nstiffness_n_per_m = 100\n\
         dissipation_n_s_mu_per_m = 0.5\nforce_limit_n = 4\nwindow_s = 0.1";
    let write = |more: &str| {
        let wall = format!("[wall]\n{keys}\n{more}");
        device.place.write("held.toml", wall);
    };
    // What a busy machine makes the loop late must not decide before the run.
    let line = format!(
        "run held.toml {DEVICE} watchdog=1s late_ticks=0 max_age_ticks=1000 duration=2s --loop host --force-unstable --out held \
         --overwrite --quiet"
    );
    write("");
    let run = |line: &str| device.place.run(&format!("{line} --json"));
    let report = run(&line).ended_by_the_clock().json();
    assert_eq!(report["verdict"], "held by a person", "{report}");
    for key in [
        "stable",
        "deflection_m",
        "analysis_agrees",
        "closed_form_error",
        "push_n",
    ] {
        assert!(report.get(key).is_none(), "{key}: {report}");
    }
    // By the table: each of its ticks lasts 2 ms.
    let table = device.place.text("held/wall.csv");
    let columns = ["position_m", "reaction_force_n"].map(|name| column(&table, name));
    let [places_m, forces_n] = columns;
    let motion: Vec<(f64, f64)> = places_m.into_iter().zip(forces_n).collect();
    let inside = motion.iter().filter(|(place_m, _)| *place_m > 0.0);
    let forces: Vec<f64> = inside.clone().map(|(_, force_n)| force_n.abs()).collect();
    let ticks = forces.len() as f64;
    let is = |key: &str, want: f64| assert_close(key, at(&report["felt"], key), want, 1e-9);
    assert!(
        ticks > 10.0 && at(&report, "/felt/deepest_m") > 5e-4,
        "{report}"
    );
    let outside = motion
        .windows(2)
        .filter(|two| two[0].0 <= 0.0 && two[1].0 > 0.0);
    let begins_inside = f64::from(u8::from(motion[0].0 > 0.0));
    is("/contacts", begins_inside + outside.count() as f64);
    is("/dwell_s", 2e-3 * ticks);
    is("/peak_force_n", forces.iter().copied().fold(0.0, f64::max));
    is("/mean_force_n", forces.iter().sum::<f64>() / ticks);
    let squares: f64 = forces.iter().map(|force_n| force_n * force_n).sum();
    is("/rms_force_n", (squares / ticks).sqrt());
    is("/deepest_m", inside.map(|at| at.0).fold(0.0, f64::max));
    // Places 10 ms apart.
    let apart: Vec<f64> = motion.iter().step_by(5).map(|at| at.0).collect();
    let way: f64 = apart.windows(2).map(|two| (two[1] - two[0]).abs()).sum();
    is("/speed_m_per_s", way / (2e-3 * motion.len() as f64));
    // One that has to be stable is a trial, whoever pushes.
    write("must_be_stable = true");
    let trial = run(&line);
    // A busy machine skips periods of the device, which counts more.
    let code = if trial.code == Some(4) { 4 } else { 1 };
    let trial = trial.failed(code).json();
    assert!(
        trial["felt"].is_null() && trial["stable"].is_boolean(),
        "{trial}"
    );
}

#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_what_a_servo_did_not_take_is_told_by_report_warning_and_log() {
    // One line in two is damaged by it.
    let mut device = Emulated::at_terminal("device", "--kind moteus drop=1% line_seed=5");
    let line = "relax --device moteus:device,lost=1000,watchdog=1s watchdog=1s late_ticks=0 --contact rigid --ramp-time 0.2s \
                --duration 1s --sample-time 2ms --out run --json";
    // A busy machine may skip ticks too.
    let ended = device.place.run(line).ended_by_the_clock();
    let report = ended.json();
    let count = |key: &str| at(&report, &format!("/link/{key}"));
    let (unanswered, not_taken) = (count("unanswered"), count("forces_not_taken"));
    assert!(unanswered > 100.0 && not_taken >= unanswered, "{report}");
    let counted = format!("{unanswered} had no answer from its board");
    assert!(ended.stderr.contains(&counted), "{ended}");
    // The log has the ticks of the run, the link those before and after it too.
    let check = device
        .place
        .run("log check run/relax.mcap --json")
        .failed(4);
    assert!(check.error().contains("ticks are stale"), "{check}");
    let check = check.json();
    let logged = at(&check, "/unanswered");
    assert!(logged > 100.0 && logged <= unanswered, "{check}");
    // What the servo heard, and what it was sent: each tick one frame, and those of opening it.
    let message = device.ends();
    let heard = numbers_after(&message, "emulated: ", 1)[0];
    let sent = count("ticks");
    assert!(
        heard + not_taken >= sent,
        "{heard} heard, {not_taken} not taken, {sent} sent"
    );
}

/// An emulated 2DIY in a place, as `2diy`.
fn board(options: &str) -> Emulated {
    Emulated::at_terminal("2diy", &format!("--kind haply-2diy {options}"))
}

/// The maker's host on such a board: what it saw, and what the board said at the end. `None` where it is not installed.
fn makers_host(version: Version, hand: &str, force: [f64; 2]) -> Option<(Value, String)> {
    let number = version.number();
    let mut emulated = board(&format!("hardware={number} hand={hand}"));
    let [x, y] = force.map(|force| force.to_string());
    let arguments = [number.to_string(), x, y, "2.5".to_owned()];
    let path = emulated.place.path("2diy");
    let seen = by_the_maker("haply_2diy.py", &path, &arguments)?;
    Some((seen, emulated.ends()))
}

fn pair(seen: &Value, key: &str) -> [f64; 2] {
    [0, 1].map(|i| at(&seen[key], &format!("/{i}")))
}

/// Where a hand holds the handle, m to the right of the middle and away from the base.
const PLACES_M: [(f64, f64); 3] = [(0.0, 0.09), (-0.03, 0.11), (0.04, 0.06)];

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_makers_own_host_reads_the_place_to_a_count_and_sends_our_torques() {
    // The hand takes its time to lead the handle there, so all at once.
    std::thread::scope(|scope| {
        for version in Version::ALL {
            for place in PLACES_M {
                scope.spawn(move || reads_and_sends(version, place));
            }
        }
    });
}

fn reads_and_sends(version: Version, (x, y): (f64, f64)) {
    let model = version.model();
    let place = [0.5 * model.pantograph.base_m + x, y];
    let force = [0.3, -0.5];
    let hand = format!("fixed:{}:{}", place[0], place[1]);
    let Some((seen, message)) = makers_host(version, &hand, force) else {
        return;
    };
    assert!(number(&seen, "answers") > 50.0, "{seen}");
    let truth = model.pantograph.angles(place.into()).expect("within reach");
    let angles = pair(&seen, "angles_deg").map(f64::to_radians);
    for joint in 0..2 {
        let count = std::f64::consts::TAU / f64::from(model.joints[joint].counts_per_turn);
        let turn = std::f64::consts::TAU;
        let off = (angles[joint] - truth[joint] + 0.5 * turn).rem_euclid(turn) - 0.5 * turn;
        // Half a count, and the rounding of a float of degrees.
        let place = format!("{version:?} {place:?}");
        assert_close(&place, off, 0.0, 0.51 * count);
    }
    // The same kinematics from the same angles: the maker's cosines of cosines lose some digits.
    let posture = model.pantograph.posture(angles).expect("in order");
    let (read, hand) = (pair(&seen, "place_m"), posture.hand_m);
    assert_close("x", read[0], hand.x, 1e-9);
    assert_close("y", read[1], hand.y, 1e-9);
    let ours = posture.torques(force.into());
    let theirs = pair(&seen, "torques_nm");
    // The maker takes the angle of a far arm by its cosine alone: of the wrong sign where the hand is nearer to the base than
    // an elbow. Ours is that of the golden values there too.
    let elbow = angles
        .map(|angle| 0.07 * angle.sin())
        .into_iter()
        .fold(0.0, f64::max);
    let off = (ours.x - theirs[0]).abs().max((ours.y - theirs[1]).abs());
    let same = posture.hand_m.y > elbow;
    assert_eq!(off < 1e-9, same, "{version:?} {place:?}: {ours} {seen}");
    // At the right motors.
    for (made, theirs) in numbers_after(&message, "torques ", 2)
        .into_iter()
        .zip(theirs)
    {
        assert_close("motor", made, theirs, 1e-6);
    }
}
