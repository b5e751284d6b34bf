//! `device selftest`: a table of promises, and an exit code.

use super::Emulated;
use crate::process::{Ended, Place, number, says, signal};
use serde_json::Value;
use std::io::{BufRead as _, BufReader, Read as _};

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
    assert!((number(&report, "force_limit_n") - 0.1).abs() < 1e-6);
    let checks = report["checks"].as_array().expect("a list");
    let named = |name: &str| {
        let mut found = checks.iter().filter(|check| check["check"] == name);
        found
            .next()
            .unwrap_or_else(|| panic!("no {name}: {report:#}"))
    };
    for name in [
        "arm",
        "force-limit",
        "stop",
        "finite-check",
        "watchdog",
        "flight-recorder",
        "reconnect",
    ] {
        assert_eq!(named(name)["ok"], true, "{line}: {report:#}");
    }
    assert_eq!(named("emergency-stop")["ok"], Value::Null);
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
    let shown = device
        .place()
        .run("device selftest --device serial:device --force-limit 50mN");
    assert_eq!(shown.code, Some(0), "{shown}");
    says(
        &shown.stdout,
        &[
            "force-limit",
            "at most 0.05 N",
            "no force for 200 ms is a fault",
            "emergency-stop",
            "not there",
        ],
    );
    device
        .place()
        .run("device selftest --device serial:device --force-limit 20N")
        .refused(2, &["20 N", "[0.001, 2] N", "--force-limit"]);
    Place::new()
        .run("device selftest --device serial:nowhere")
        .refused(3, &["nowhere"]);
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_test_that_somebody_stops_tells_what_it_has_seen() {
    let device = Emulated::new("");
    let line = "device selftest --device serial:device --emergency-stop pressed --json";
    let mut test = device.place().start(line);
    let mut stderr = BufReader::new(test.stderr.take().expect("piped"));
    let mut said = String::new();
    // Nobody presses it: all before it was tried.
    while !said.contains("press the emergency stop") {
        let count = stderr.read_line(&mut said).expect("is text");
        assert!(count > 0, "{said}");
    }
    signal(&test, "INT");
    stderr.read_to_string(&mut said).expect("is text");
    let mut output = test.wait_with_output().expect("ends");
    output.stderr = said.into_bytes();
    let ended = Ended::new(line.to_owned(), &output);
    assert_eq!(ended.code, Some(1), "{ended}");
    says(ended.error(), &["interrupted: the device was disarmed"]);
    let report = ended.json();
    assert_eq!(
        (&report["interrupted"], &report["holds"]),
        (&true.into(), &false.into())
    );
    let checks = report["checks"].as_array().expect("a list");
    let (last, before) = checks.split_last().expect("some");
    assert!(
        before.iter().all(|check| check["not_judged"] == false),
        "{report:#}"
    );
    assert_eq!(
        (&last["check"], &last["not_judged"]),
        (&"emergency-stop".into(), &true.into())
    );
}
