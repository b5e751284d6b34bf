//! A device that is watched and not there any more at the end.

use super::Emulated;
use crate::process::{Ended, binary, number, says, signal};
use std::io::{BufRead as _, BufReader, Read as _};
use std::process::{Command, Stdio};

/// Each kind of device: how it is emulated, and its name.
const KINDS: [(&str, &str); 3] = [
    ("", "serial:device"),
    ("--kind moteus", "moteus:device"),
    ("--kind haply-2diy hand=free", "haply:device"),
];

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
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
    // A machine that is too busy to hold the line has closed it already, or could not open it.
    let logs = ["watch/monitor.mcap.part", "watch/monitor.mcap"];
    while !logs.iter().any(|log| device.place.path(log).exists())
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
    assert!(error.contains("it did not come back"), "{kind}: {ended}");
    assert_eq!(ended.json()["reconnected"], 0, "{kind}: {ended}");
}

#[test]
fn a_monitor_whose_log_finds_no_space_says_so_at_once_and_goes_on() {
    let device = Emulated::new("");
    // No file above 20 kB: a quarter of a second.
    let line = "trap '' XFSZ; ulimit -f 40 && exec \"$0\" device monitor --device serial:device --out watch --json";
    let mut monitor = Command::new("sh")
        .args(["-c", line])
        .arg(binary())
        .current_dir(device.place.path(""))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("starts");
    let mut stderr = BufReader::new(monitor.stderr.take().expect("piped"));
    let mut said = String::new();
    let count = stderr.read_line(&mut said).expect("is text");
    assert!(count > 0 && !said.contains("ulimit"), "{said}");
    says(
        &said,
        &[
            "warning: ",
            "watch/monitor.mcap.part",
            "samples are safe",
            "nothing is kept",
        ],
    );
    assert!(monitor.try_wait().expect("can be asked").is_none());
    signal(&monitor, "INT");
    stderr.read_to_string(&mut said).expect("is text");
    let mut output = monitor.wait_with_output().expect("ends");
    output.stderr = said.into_bytes();
    let ended = Ended::new(line.to_owned(), &output).failed(4);
    says(
        ended.error(),
        &["watch/monitor.mcap.part", "samples are safe"],
    );
    let report = ended.json();
    assert!(number(&report, "dropped_samples") > 0.0, "{report}");
    assert!(
        number(&report, "samples") >= number(&report, "dropped_samples"),
        "{report}"
    );
}
