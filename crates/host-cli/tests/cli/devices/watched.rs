//! A device that is watched and not there any more at the end.

use super::Emulated;
use crate::process::{Ended, signal};
use std::io::{BufRead as _, BufReader, Read as _};

/// Each kind of device: how it is emulated, and its name.
const KINDS: [(&str, &str); 3] = [
    ("", "serial:device"),
    ("--kind moteus", "moteus:device"),
    ("--kind haply-2diy --hand free", "haply:device"),
];

#[test]
fn a_monitor_says_that_its_device_is_silent_or_gone_and_ends_so_whatever_its_kind() {
    std::thread::scope(|scope| {
        for (kind, name) in KINDS {
            for away in [Emulated::hang as fn(&mut _), Emulated::kill] {
                scope.spawn(move || watched(kind, name, away));
            }
        }
    });
}

fn watched(kind: &str, name: &str, away: fn(&mut Emulated)) {
    let mut device = Emulated::new(kind);
    let line = format!("device monitor --device {name} --out watch --json");
    let mut monitor = device.place.start(&line);
    let mut stderr = BufReader::new(monitor.stderr.take().expect("piped"));
    // Of a machine that is too busy to open it, the end.
    while !device.place.path("watch/monitor.mcap.part").exists()
        && monitor.try_wait().expect("can be asked").is_none()
    {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    away(&mut device);
    let mut said = String::new();
    while !said.contains("link: ") {
        let count = stderr.read_line(&mut said).expect("is text");
        assert!(count > 0, "{kind}: {said}");
    }
    signal(&monitor, "INT");
    stderr.read_to_string(&mut said).expect("is text");
    let mut output = monitor.wait_with_output().expect("ends");
    output.stderr = said.into_bytes();
    let ended = Ended::new(line, &output);
    assert_eq!(ended.code, Some(3), "{kind}: {ended}");
    let error = ended.error();
    assert!(
        error.contains("it was not there again until the end"),
        "{kind}: {ended}"
    );
    assert_eq!(ended.json()["reconnected"], 0, "{kind}: {ended}");
}
