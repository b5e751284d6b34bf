//! The safety chain of a device on a serial line.

use super::middle::Middle;
use super::{Emulated, at};
use crate::process::{Ended, Place, signal};
use haptic_link::{Capabilities, DeviceReport};
use serde_json::Value;
use std::io::{BufRead as _, BufReader, Read as _};
use testkit::assert_says;

/// Two dissipations, in trials of half a second.
const SEARCH: &str = "zwidth --orders 1 --points 2 --sample-time 2ms duration=0.5s window=0.2s --device serial:device watchdog=1s --quiet";

/// Limits within which it may.
const NIGHT: &str = "device set --device serial:device force_limit=3N workspace=-0.3m:0.3m speed_limit=2m/s rise_time=5ms";

fn wall(stiffness: f64, dissipation: f64) -> String {
    format!(
        "[wall]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 0.002\norder = 1\nduration_s = 1.0\nwindow_s = 0.2\n\
         stiffness_n_per_m = {stiffness:?}\ndissipation_n_s_mu_per_m = {dissipation:?}\n"
    )
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
        let mut command = place.command("device flash --device serial:line --json");
        let output = command.env("PATH", place.path("")).output().expect("runs");
        Ended::new("device flash".to_owned(), &output)
    };
    let late = flash();
    assert_eq!(late.code, Some(3), "{late}");
    let words = "written:  & has been running for 3600 s & plug it in again";
    assert_says(&late.stderr, words);
    let done = flash().json();
    assert_eq!(done["image"], image.display().to_string());
    let programmed = place.text("programmed");
    assert_says(&programmed, &format!("--verify {}", image.display()));
}

#[test]
fn an_image_of_another_board_is_not_programmed() {
    let device = Emulated::new("");
    let place = device.place();
    stands_in(place, "probe-rs", "exit 0");
    let image = |address: u32, board: &str| elf(address, &identity(board));
    place.write("mps2", image(0x0800_0000, "mps2-an386"));
    place.write("pico", image(0x1000_0000, "rp2040"));
    place.write("empty", elf(0x0800_0000, b"nothing"));
    place.write("nucleo", image(0x0800_0000, "nucleo-f446re"));
    place.write("text", "no image");
    // All but the last is said before a probe or a drive is looked for.
    for (path, options, code, says) in [
        ("", "--image=none --board=rp2040", 2, "no image `none`"),
        (
            "",
            "--image=text",
            2,
            "`text` is not an image for this chip",
        ),
        ("", "--image=pico", 2, "at 0x10000000 lie outside its flash"),
        ("", "--image=empty", 2, "does not say which board it is for"),
        (
            "",
            "--image=mps2",
            2,
            "is for board mps2-an386 with firmware 0.1.0, not for nucleo-f446re",
        ),
        (
            ".",
            "--image=nucleo --device=serial:device",
            3,
            "board emulated with firmware 0.0.1 answers",
        ),
    ] {
        let mut command = place.command(&format!("device flash --quiet {options}"));
        let output = command.env("PATH", path).output().expect("runs");
        Ended::new(options.to_owned(), &output).refused(code, &[says]);
    }
}
