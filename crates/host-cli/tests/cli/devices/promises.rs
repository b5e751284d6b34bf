//! The safety chain of a device on a serial line.

use super::middle::Middle;
use super::{Emulated, at};
use crate::process::{Ended, Place, number, signal};
use haptic_link::{Capabilities, DeviceReport};
use serde_json::Value;
use std::io::{BufRead as _, BufReader, Read as _};
use testkit::{assert_close, assert_says};

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
    let keys = "start_force_n rise_time_s speed_limit_m_per_s speed_soft_m_per_s braking_n_s_per_m";
    let numbers =
        |object: &Value| -> Vec<f64> { keys.split(' ').map(|key| number(object, key)).collect() };
    assert_eq!(numbers(&after), [2.0, 0.25, 0.75, 0.5, 4.0]);
    assert_close("low", at(&after, "/workspace_m/0"), -0.01, 1e-8);
    assert_close("high", at(&after, "/workspace_m/1"), 0.02, 1e-8);
    // That of the plant that it simulates.
    assert_eq!(after["guard"]["kind"], "energy-bounding");
    assert_eq!(number(&after["guard"], "damping_n_s_per_m"), 3.5);
    let line =
        "device set guard=off workspace=none speed_limit=0 braking=0 rise_time=0 start_force=0";
    let off = json(&device, line)["safety"].clone();
    assert_eq!([&off["workspace_m"], &off["guard"]], [&Value::Null; 2]);
    assert_eq!(numbers(&off), [0.0; 5]);
}

#[test]
fn the_watchdog_goes_with_the_loop_and_braking_with_the_mass() {
    let device = emulated();
    let watchdog = |line: &str| number(&json(&device, line), "watchdog_s");
    assert_eq!(watchdog("device get"), 0.5);
    assert_eq!(watchdog("device set loop=host"), 0.02);
    assert_eq!(watchdog("device set watchdog=50ms loop=device"), 0.05);
    // The simulated mass is known: 65 g bear 21.6 N·s/m with a tick of delay.
    let set = "device set braking=20 stop_time=50ms brake_force=3N";
    let safety = json(&device, set)["safety"].clone();
    assert_eq!(number(&safety, "braking_n_s_per_m"), 20.0);
    assert_eq!(number(&safety, "brake_force_n"), 3.0);
    assert_close("stop time", number(&safety, "stop_time_s"), 0.05, 1e-8);
    let more = device
        .place
        .run("device set braking=30 --device serial:device");
    more.refused(2, &["braking", "30"]);
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
    let line =
        "run wall.toml --guard energy-bounding watchdog=1s max_age_ticks=1000 --out run --quiet";
    let report = json(&device, &format!("{line} --loop {side}"));
    assert_eq!(report["stable"], true, "{side}: {report}");
    assert!(number(&report, "limited_samples") > 0.0, "{side}: {report}");
}

#[test]
fn a_push_that_the_devices_own_limit_cannot_hold_is_refused_before_a_force() {
    let device = emulated();
    device.place.write("wall.toml", SHAKING);
    json(&device, "device set force_limit=0.5N");
    let run = "run wall.toml --out run --device serial:device --quiet";
    let words = [
        "push_n = 1",
        "device's own force limit of 0.5 N",
        "device set",
    ];
    for line in [run, &format!("{run} --loop host"), SEARCH] {
        let refused = device.place.run(line);
        refused.refused(2, &words);
    }
    let limits = json(&device, "device info");
    assert_eq!(number(&limits, "faults"), 0.0);
    // A smaller push is held.
    let held = device.place.run(&format!(
        "{run} push=0.4N stiffness=1kN/m duration=1s watchdog=1s"
    ));
    held.succeeded_with_warnings();
}

/// Two dissipations, in trials of half a second.
const SEARCH: &str = "zwidth --orders 1 --points 2 --sample-time 2ms duration=0.5s window=0.2s --device serial:device watchdog=1s --quiet";

/// Faults that have latched since it was switched on.
fn faults(device: &Emulated) -> f64 {
    at(
        &device.json("device info --device serial:device"),
        "/faults",
    )
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_z_width_can_be_found_on_a_device() {
    let device = Emulated::new("--speed 400");
    device.loosen();
    let report = device.json(SEARCH);
    // Thousands before it began from soft walls.
    assert!(at(&report, "/runs") < 100.0, "{report}");
    let points = report["orders"][0]["boundary"].as_array().expect("points");
    assert_eq!(points.len(), 2, "{report}");
    for point in points {
        // The same wall on the simulated device: a little softer it comes to rest, a little stiffer it does not.
        for (times, stable) in [(0.97, true), (1.03, false)] {
            let wall = format!(
                "[wall]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 0.002\norder = 1\nimpact_m_per_s = 0\n\
                 duration_s = 0.5\nwindow_s = 0.2\nstiffness_n_per_m = {:?}\n\
                 dissipation_n_s_mu_per_m = {:?}\n",
                times * at(point, "/stiffness_max"),
                at(point, "/dissipation")
            );
            device.place.write("wall.toml", wall);
            let tried = device.json("run wall.toml --out wall --overwrite --quiet");
            assert_eq!(tried["stable"], stable, "{times} of {point}");
        }
    }
    // A person is told what is missing beside them, and where it is to be had.
    let shown = device.place.run(&SEARCH.replace(" --quiet", ""));

    assert_says(
        &shown.succeeded_with_warnings().stderr,
        "the analysis needs & --device-model & host-cli device measure",
    );
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_z_width_on_a_device_stands_beside_the_analysis_of_its_file() {
    let file = "[device]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nhand_stiffness_n_per_m = 0.0\ndelay_s = 0.0005\n\
                current_lag_s = 0.001\nfriction_n = 0.0\nencoder_resolution_m = 1e-6\nsensor_noise_m = 0.0\n";
    let place = Place::new();
    place.write("device.toml", file);
    let model = place.path("device.toml");
    let device = Emulated::new(&format!("--speed 400 --device-model {}", model.display()));
    device.loosen();
    let line =
        "zwidth --orders 1 --points 2 --sample-time 1ms --device serial:device watchdog=1s --quiet";
    let report = device.json(&format!("{line} --device-model {}", model.display()));
    let points = report["orders"][0]["boundary"].as_array().expect("points");
    // Without dissipation: the largest stiffness of such a delay, within what a trial tells.
    let (found, analysed) = (
        at(&points[0], "/stiffness_max"),
        at(&points[0], "/analysis_stiffness_n_per_m"),
    );
    assert!((found / analysed - 1.0).abs() < 0.05, "{report}");
}

/// A wall into which the device pushes by itself.
const PUSHED: &str =
    "run wall.toml --device serial:device watchdog=1s push_by=device --quiet --overwrite --out run";
/// Limits within which it may.
const NIGHT: &str = "device set --device serial:device force_limit=3N workspace=-0.3m:0.3m speed_limit=2m/s rise_time=5ms";

fn wall(stiffness: f64, dissipation: f64) -> String {
    format!(
        "[wall]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 0.002\norder = 1\nduration_s = 1.0\nwindow_s = 0.2\n\
         stiffness_n_per_m = {stiffness:?}\ndissipation_n_s_mu_per_m = {dissipation:?}\n"
    )
}

#[test]
fn a_device_pushes_by_itself_only_within_lasting_limits() {
    let device = Emulated::new("--speed 8");
    device.place.write("wall.toml", wall(500.0, 2.0));
    let set = "device set --device serial:device";
    for (limits, push, words) in [
        (
            "watchdog=400ms",
            1,
            "set workspace_low and workspace_high with host-cli device set",
        ),
        (
            "workspace=-0.3m:0.3m speed_limit=0m/s",
            1,
            "set speed_limit with host-cli device set",
        ),
        (
            "force_limit=3N speed_limit=2m/s rise_time=0.05s",
            3,
            "push_n = 3 is not below the device's own force limit of 3 N",
        ),
    ] {
        let run = format!("{PUSHED} push={push}N");
        if push == 1 && limits.starts_with("watchdog") {
            let words = [
                "lasting limits of force, workspace and speed",
                "set force_limit, workspace_low",
            ];
            device.place.run(&run).refused(2, &words);
        }
        device.json(&format!("{set} {limits}"));
        device.place.run(&run).refused(2, &[words]);
    }
    let guarded = format!("{PUSHED} --guard observer");
    device
        .place
        .run(&guarded)
        .refused(2, &["a guard takes away"]);
    assert_eq!(faults(&device), 0.0);
    let ran = device.json(PUSHED);
    assert_eq!(
        (&ran["push_by"], &ran["stable"]),
        (&Value::from("device"), &Value::from(true)),
        "{ran}"
    );
    assert_says(
        ran["shared_actuator"].as_str().expect("words"),
        "one actuator",
    );
    let deflection = at(&ran, "/deflection_m");
    assert!((deflection - 2e-3).abs() < 2e-5, "{ran}");
    assert!(at(&ran, "/max_relative_error") < 1e-4, "{ran}");
    // The first swing ends a wall that is not stable.
    device.place.write("wall.toml", wall(2e4, 2.0));
    let ended = device
        .place
        .run(&format!("{PUSHED} --force-unstable --json"))
        .failed(1);
    assert_says(ended.error(), "the law swung");
    let report = ended.json();
    assert_eq!(report["verdict"], "unstable", "{report}");
    assert!(at(&report, "/duration_s") < 0.5, "{report}");
}

/// Holds points that a device found against walls of the simulated one: 5 % weaker it comes to rest, 5 % stronger it does not, in K or in K
/// and B together.
fn follow_the_simulated_walls(device: &Emulated, report: &Value, keys: &str) {
    let stable = |order: f64, k: f64, b: f64| {
        let text = wall(k, b).replace("order = 1\n", &format!("order = {order:?}\n"));
        device.place.write("tried.toml", text);
        let tried = device.json(&format!(
            "run tried.toml push_by=device {keys} --out tried --overwrite --quiet"
        ));
        tried["stable"] == true
    };
    for order in report["orders"].as_array().expect("orders") {
        for point in order["boundary"].as_array().expect("points") {
            let (mu, k, b) = (
                at(order, "/order"),
                at(point, "/stiffness_max"),
                at(point, "/dissipation"),
            );
            let in_k = stable(mu, 0.95 * k, b) && !stable(mu, 1.05 * k, b);
            let in_both = || stable(mu, 0.95 * k, 0.95 * b) && !stable(mu, 1.05 * k, 1.05 * b);
            assert!(in_k || in_both(), "order {mu}: {point}");
        }
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_search_without_anybody_goes_on_from_its_campaign() {
    let device = Emulated::new("--speed 8");
    device.json(NIGHT);
    let search = SEARCH.replace("0.5s", "1s");
    let line = format!("{search} --push-by device --campaign night.jsonl --out night --overwrite");
    let report = device.json(&line);
    assert_eq!(report["push_by"], "device");
    follow_the_simulated_walls(&device, &report, "duration=1s window=0.2s");
    let again = device.json(&line);
    assert_eq!(
        (at(&again, "/runs"), &again["orders"]),
        (0.0, &report["orders"])
    );
    let other = device
        .place
        .run(&line.replace("duration=1s", "duration=2s"));
    let words = ["`night.jsonl` is not of this search (line 1)", "--campaign"];
    other.refused(2, &words);
    // Limits of the device are part of the question.
    device.json("device set --device serial:device force_limit=2N");
    device.place.run(&line).refused(2, &words);
}

#[test]
fn a_fault_of_the_sensor_ends_a_search_at_once() {
    let device = Emulated::new("--speed 8");
    device.json("device set --device serial:device speed_limit=2mm/s jump=1um");
    let ended = device.place.run(&format!("{SEARCH} --json")).failed(3);

    assert_says(
        ended.error(),
        "the position jumped by more than the speed limit allows & no more trials are made",
    );
    // Each trial that ends so would have armed the device again.
    assert_eq!(faults(&device), 1.0, "{ended}");
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn an_emulated_device_keeps_its_promises_on_a_bad_line_too() {
    std::thread::scope(|scope| {
        for line in ["", "drop=1% corrupt=1% duplicate=1% line_seed=3"] {
            scope.spawn(|| keeps_its_promises(line));
        }
    });
}

fn keeps_its_promises(line: &str) {
    let device = Emulated::new(line);
    let before = device.json("device get --device serial:device");
    let report = device.json("device selftest --device serial:device");
    assert_eq!(report["holds"], true, "{line}: {report:#}");
    assert_eq!(report["board"], "emulated");
    assert_close("value", number(&report, "force_limit_n"), 0.1, 1e-6);
    assert!(
        report["date"]
            .as_str()
            .is_some_and(|date| date.ends_with('Z'))
    );
    let checks = report["checks"].as_array().expect("a list");
    let ok = |name: &str| {
        let found = checks.iter().find(|check| check["check"] == name);
        found.unwrap_or_else(|| panic!("no {name}: {report:#}"))["ok"].as_bool()
    };
    for name in
        "arm force-limit stop direction finite-check watchdog flight-recorder reconnect".split(' ')
    {
        assert_eq!(ok(name), Some(true), "{line}: {report:#}");
    }
    assert_eq!(ok("emergency-stop"), None);
    // It is as it was, without a fault.
    assert_eq!(device.json("device get --device serial:device"), before);
    let info = device.json("device info --device serial:device");
    assert_eq!(
        (&info["state"], &info["fault"]),
        (&"idle".into(), &Value::Null)
    );
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_person_sees_a_table_and_what_cannot_be_is_refused() {
    let device = Emulated::new("");
    let line = "device selftest --device serial:device --force-limit";
    let shown = device.place.run(&format!("{line} 50mN"));
    assert_eq!(shown.code, Some(0), "{shown}");

    assert_says(
        &shown.stdout,
        "force-limit & at most 0.05 N & no force for 200 ms is a fault & emergency-stop & not there",
    );
    let much = device.place.run(&format!("{line} 20N"));
    much.refused(2, &["20 N", "[0.001, 2] N", "--force-limit"]);
    let nobody = device.place.run("device selftest --device serial:nowhere");
    nobody.refused(3, &["nowhere"]);
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_form_of_a_first_time_has_what_was_found_and_is_never_replaced() {
    let device = Emulated::new("");
    let place = &device.place;
    let line = "device selftest --device serial:device --emergency-stop none --out";
    let report = device.json(&format!("{line} form.md"));
    assert_eq!(report["form"], "form.md", "{report:#}");
    let form = place.text("form.md");
    let firmware = report["firmware"].as_str().expect("a version");
    let words = format!(
        "# First time on real hardware: emulated\n & \
         | firmware | {firmware} |\n & \
         | force limit | 10 N | 500 mN or less | tighten it first |\n & \
         | workspace low | none | -20 mm or above | tighten it first |\n & \
         | who holds the emergency stop | |\n & \
         \n## What ends it\n"
    );
    assert_says(&form, &words);
    for check in report["checks"].as_array().expect("a list") {
        let [name, promised] = ["check", "promised"].map(|key| check[key].as_str().expect("words"));
        let ok = match check["ok"].as_bool() {
            Some(true) => "yes",
            Some(false) => "no",
            None => "–",
        };
        let row = form
            .lines()
            .find(|line| line.starts_with(&format!("| {name} | {promised} |")));
        assert_says(
            row.unwrap_or_else(|| panic!("{name}: {form}")),
            &format!(" | {ok} | no | no |"),
        );
    }
    // Nothing was found, so nothing is written.
    let nobody = place.run("device selftest --device serial:nowhere --out none.md");
    nobody.refused(3, &["nowhere"]);
    assert!(!place.path("none.md").exists());
    // What was written into it stays.
    place.write("form.md", "somebody wrote this");
    let again = place.run(&format!("{line} form.md"));
    again.refused(2, &["form.md", "already exists", "--out"]);
    assert_eq!(place.text("form.md"), "somebody wrote this");
    for (name, words) in [
        ("form.toml", ["Markdown", "form.md"]),
        ("form", ["Markdown", "form.md"]),
        ("nowhere/form.md", ["nowhere/form.md", "folder"]),
    ] {
        place.run(&format!("{line} {name}")).refused(2, &words);
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_test_that_somebody_stops_tells_what_it_has_seen() {
    let device = Emulated::new("");
    let line = "device selftest --device serial:device --emergency-stop pressed --json";
    let mut test = device.place().start(line);
    let mut stderr = BufReader::new(test.stderr.take().expect("piped"));
    let mut message = String::new();
    // Nobody presses it: all before it was tried.
    while !message.contains("press the emergency stop") {
        let count = stderr.read_line(&mut message).expect("is text");
        assert!(count > 0, "{message}");
    }
    signal(&test, "INT");
    stderr.read_to_string(&mut message).expect("is text");
    let mut output = test.wait_with_output().expect("ends");
    output.stderr = message.into_bytes();
    let ended = Ended::new(line.to_owned(), &output);
    assert_eq!(ended.code, Some(1), "{ended}");
    assert_says(ended.error(), "interrupted: the device was disarmed");
    let report = ended.json();
    assert_eq!(
        [&report["interrupted"], &report["holds"]],
        [true, false].map(Value::from).each_ref()
    );
    let checks = report["checks"].as_array().expect("a list");
    let (last, before) = checks.split_last().expect("some");
    let judged = before.iter().all(|check| check["not_judged"] == false);
    assert!(judged && last["not_judged"] == true, "{report:#}");
    assert_eq!(last["check"], "emergency-stop");
}

/// An ELF file of an Arm with this at an address: header of 52 bytes, a program header of 32, data.
fn elf(address: u32, data: &[u8]) -> Vec<u8> {
    const PT_LOAD: u32 = 1;
    let length = data.len() as u32;
    let mut file = b"\x7fELF\x01\x01\x01\0\0\0\0\0\0\0\0\0\x02\0\x28\0\x01\0\0\0".to_vec();
    file.extend([0, 52, 0, 0].map(u32::to_le_bytes).as_flattened());
    file.extend([52, 32, 1, 40, 0, 0].map(u16::to_le_bytes).as_flattened());
    let header = [PT_LOAD, 84, address, address, length, length, 4, 4];
    file.extend(header.map(u32::to_le_bytes).as_flattened());
    file.extend(data);
    file
}

/// What an image says of its board.
fn identity(board: &str) -> Vec<u8> {
    format!("haptic-device image\0{board:\0<16}\0\x01\0\0").into_bytes()
}

/// A program in the way of the real one.
fn stands_in(place: &Place, name: &str, script: &str) {
    place.write(name, format!("#!/bin/sh\n{script}\n"));
    let mode = std::os::unix::fs::PermissionsExt::from_mode(0o755);
    std::fs::set_permissions(place.path(name), mode).expect("can be set");
}

#[test]
fn what_is_flashed_is_what_cargo_has_built_and_only_a_fresh_start_proves_it() {
    let device = Emulated::new("");
    let place = device.place();
    let mut since_us = 3_600_000_000;
    let _line = Middle::changing(&device, move |mut report| {
        if let DeviceReport::Capabilities(abilities) = &mut report {
            abilities.board = Capabilities::board_name("nucleo-f446re");
        }
        if let DeviceReport::Hello(hello) = &mut report {
            hello.firmware = [0, 1, 0];
        }
        // It has run for an hour, then for a microsecond.
        if let DeviceReport::Alive(alive) = &mut report {
            alive.time_us = std::mem::replace(&mut since_us, 1);
        }
        Some(report)
    });
    // The image of yesterday lies where it would be without CARGO_TARGET_DIR or build.target-dir.
    let yesterday = "firmware/target/thumbv7em-none-eabihf/release";
    std::fs::create_dir_all(place.path(yesterday)).expect("a folder");
    place.write("firmware/Cargo.toml", "");
    place.write(&format!("{yesterday}/haptic-device"), "yesterday's");
    let image = place.path("elsewhere");
    place.write("elsewhere", elf(0x0800_0000, &identity("nucleo-f446re")));
    let announcement = format!(
        r#"{{"executable":null}}\n{{"executable":"{}"}}"#,
        image.display()
    );
    let script = format!("[ $1 = image-nucleo-f446re ] && echo '{announcement}'");
    stands_in(place, "cargo", &script.replace("\\n", "\n"));
    stands_in(
        place,
        "probe-rs",
        &format!("echo \"$@\" >> {}", place.path("programmed").display()),
    );
    let flash = || {
        let mut command = place.command("device flash --device serial:line --json --quiet");
        let output = command.env("PATH", place.path("")).output().expect("runs");
        Ended::new("device flash".to_owned(), &output)
    };
    let words = ["has been running for 3600 s", "plug it in again"];
    flash().refused(3, &words);
    let done = flash().json();
    assert_eq!(done["image"], image.display().to_string());
    let programmed = place.text("programmed");
    assert_says(&programmed, &format!("--verify {}", image.display()));
}

#[test]
fn an_image_of_another_board_is_not_programmed() {
    let place = Place::new();
    stands_in(&place, "probe-rs", "exit 0");
    let flash = |image: &str, device: &str| {
        let mut command = place.command("device flash");
        command.args([image, "--device", device]);
        let output = command.env("PATH", place.path("")).output().expect("runs");
        (
            output.status.code(),
            String::from_utf8_lossy(&output.stderr).into_owned(),
        )
    };
    let image = |address: u32, board: &str| elf(address, &identity(board));
    place.write("mps2", image(0x0800_0000, "mps2-an386"));
    place.write("pico", image(0x1000_0000, "rp2040"));
    place.write("empty", elf(0x0800_0000, b"nothing"));
    place.write("text", "no image");
    // Said before a probe or a drive is looked for.
    for (words, says_too) in [
        ("--image=none --board=rp2040", "no image `none`"),
        ("--image=text", "`text` is not an image for this chip"),
        ("--image=pico", "at 0x10000000 lie outside its flash"),
        ("--image=empty", "does not say which board it is for"),
        (
            "--image=mps2",
            "is for board mps2-an386 with firmware 0.1.0, not for nucleo-f446re",
        ),
    ] {
        let mut command = place.command(&format!("device flash {words}"));
        let output = command.env("PATH", "").output().expect("runs");
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{words}: {error}");
        assert_says(&error, says_too);
    }
    // The right image, but what answers is another board.
    place.write("nucleo", image(0x0800_0000, "nucleo-f446re"));
    let device = Emulated::new("");
    let port = format!("serial:{}", device.place.path("device").display());
    let (code, error) = flash("--image=nucleo", &port);
    assert_eq!(code, Some(3), "{error}");
    assert_says(&error, "board emulated with firmware 0.1.0 answers");
}

#[test]
fn flashing_without_probe_rs_says_how_to_get_it() {
    let place = Place::new();
    // A path without anything in it.
    let mut command = place.command("device flash");
    let output = command.env("PATH", place.path("")).output().expect("runs");
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(3), "{error}");
    assert_says(&error, "cargo install probe-rs-tools");
}
