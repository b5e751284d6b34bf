//! A device that goes away in the middle of a run: the same exit code whatever its kind.

use super::Emulated;
use crate::process::{PATIENCE, Place, binary};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

#[test]
fn a_device_that_goes_away_in_a_run_is_not_usable_whatever_its_kind() {
    for (kind, device) in [
        ("", "serial:device"),
        ("--kind moteus", "moteus:device,watchdog=1s,lost=1000"),
        ("--kind haply-2diy", "haply:device"),
    ] {
        let mut emulated = Emulated::new(kind);
        let line = format!(
            "relax --device {device} --watchdog 1s --late-ticks 0 --contact rigid --duration 300s --sample-time 5ms --out run --quiet"
        );
        let run = Command::new(binary())
            .args(line.split_whitespace())
            .current_dir(emulated.place.path(""))
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("runs");
        let began = Instant::now();
        while !emulated.place.path("run/relax.mcap.part").exists() {
            assert!(began.elapsed() < PATIENCE, "{kind}: no log");
            std::thread::sleep(Duration::from_millis(5));
        }
        emulated.kill();
        let ended = run.wait_with_output().expect("ends");
        let said = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(3), "{kind}: {said}");
        let last = said.lines().last().unwrap_or_default();
        assert!(
            last.starts_with("error: ") && last.contains("the log is run/relax.mcap"),
            "{kind}: {said}"
        );
    }
}

#[test]
fn a_wrong_number_of_axes_is_bad_input_whatever_the_device() {
    let place = Place::new();
    place.write("three.toml", "[touch]\naxes = 3\n");
    let one = "run three.toml --loop host --device";
    place
        .run(&format!("{one} moteus:nowhere"))
        .refused(2, &["it has 1 axis", "3 are asked for"]);
    place
        .run(&format!("{one} haply:nowhere"))
        .refused(2, &["it has 2 axes", "3 are asked for"]);
    place.write("line.toml", "[touch]\n");
    place
        .run("run line.toml --loop host --device haply:nowhere,axis=x")
        .refused(2, &["axis and zero choose a line"]);
    let emulated = Emulated::new("--axes 2");
    emulated
        .place
        .run("relax --device serial:device")
        .refused(2, &["has 2 axes"]);
}
