//! A host in another language, written from `crates/haptic-link/protocol.md` alone, against an emulated device.

#![cfg(unix)]

use haptic_loop::Fault;
use haptic_remote::{FLIGHT_SAMPLES, QUEUE_SAMPLES};
use serde_json::Value;
use std::io::{BufRead as _, BufReader, Read as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use testkit::assert_says;

/// Ticks of a run.
const TICKS: u64 = 10_000;
/// One at a time: three devices at five times their speed are too much for a small machine.
static TURN: Mutex<()> = Mutex::new(());
/// Device seconds in a second. A run of 10 s takes 2, and the watchdog time of 1 s is 200 ms; a machine that is
/// too busy to let a host speak in that time gets a slower device.
const SPEEDS: [&str; 3] = ["5", "2", "1"];

/// An emulated device; gone when dropped.
struct Emulator {
    _turn: MutexGuard<'static, ()>,
    child: Child,
    port: String,
}

impl Emulator {
    fn new(speed: &str, line: &str) -> Self {
        // After a test that failed the next one has its turn all the same.
        let turn = TURN.lock().unwrap_or_else(PoisonError::into_inner);
        let mut child = Command::new(assert_cmd::cargo::cargo_bin!("host-cli"))
            .args(["device", "emulate", "--json", "--duration", "60s"])
            .args(["--speed", speed])
            .args(line.split_whitespace())
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the emulator starts");
        let mut first = String::new();
        let stdout = child.stdout.take().expect("piped");
        BufReader::new(stdout)
            .read_line(&mut first)
            .expect("it tells its port");
        let started: Value = serde_json::from_str(&first).expect("JSON");
        let port = started["path"].as_str().expect("a path").to_owned();
        Self {
            _turn: turn,
            child,
            port,
        }
    }
}

impl Emulator {
    /// Ends it, and asks how many frames nobody fetched: a machine that is too busy loses them behind the line.
    fn unread(mut self) -> u64 {
        let ended = Command::new("kill")
            .args(["-INT", &self.child.id().to_string()])
            .status();
        assert!(ended.expect("kill runs").success());
        let mut message = String::new();
        let mut stderr = self.child.stderr.take().expect("piped");
        stderr.read_to_string(&mut message).expect("is text");
        let before = message.split(" not fetched").next();
        let count = before.and_then(|text| text.rsplit(' ').next());
        count.and_then(|count| count.parse().ok()).expect(&message)
    }
}

impl Drop for Emulator {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .join(path)
}

/// The Python client's summary of a run with a device on such a line, and the device. `None` where there is no
/// Python, which is a failure in CI.
fn client(line: &str, ticks: u64, options: &str) -> Option<(Value, Emulator)> {
    let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    let mut message = String::new();
    for speed in SPEEDS {
        let emulator = Emulator::new(speed, line);
        let output = Command::new(&python)
            .arg(repository("tests/protocol/client.py"))
            .arg(&emulator.port)
            .args(["--samples", &ticks.to_string(), "--watchdog-ms", "1000"])
            .args(options.split_whitespace())
            .output();
        let output = match output {
            Ok(output) => output,
            Err(error) => {
                testkit::skip(&format!(
                    "{}: {error}; point PYTHON to a Python",
                    python.display()
                ));
                return None;
            }
        };
        if output.status.success() {
            let summary = serde_json::from_slice(&output.stdout);
            return Some((summary.expect("one JSON object"), emulator));
        }
        message = String::from_utf8_lossy(&output.stderr).into_owned();
        let silent = format!("fault {}", Fault::HostSilent.code());
        assert_says(&message, &silent);
    }
    panic!("the host is silent even for a device at its own speed: {message}")
}

fn count(summary: &Value, group: &str, name: &str) -> u64 {
    let value = summary[group][name].as_u64();
    value.unwrap_or_else(|| panic!("{group}.{name}: {summary}"))
}

/// The force of the spring balances the push of 1 N.
fn is_at_rest(summary: &Value, stiffness: f64) {
    let position = summary["final_position_m"].as_f64().expect("a number");
    assert!((position * stiffness - 1.0).abs() < 1e-3, "{summary}");
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_python_host_gets_every_sample_over_a_good_line() {
    let options = "--stiffness 500 --dissipation 5 --order 0.5";
    let Some((summary, emulator)) = client("", TICKS, options) else {
        return;
    };
    assert_eq!(summary["samples"], TICKS, "{summary}");
    assert_eq!(summary["lost_ticks"], 0);
    assert_eq!(summary["limited"], 0, "no limiter has a reason to act");
    for (group, names) in [
        ("link", "corrupt oversize foreign lost duplicate late"),
        (
            "device",
            "corrupt oversize foreign lost duplicate late samples_dropped",
        ),
    ] {
        for name in names.split(' ') {
            assert_eq!(count(&summary, group, name), 0, "{group}.{name}: {summary}");
        }
    }
    // Single precision, 41 terms, the largest 0.3 N: 41·2^(−24)·0.3 N = 7e-7 N at worst.
    let error = summary["largest_force_error_n"].as_f64().expect("a number");
    assert!(error < 1e-6, "{summary}");

    // What Python has set is what this project's own host reads.
    let output = Command::new(assert_cmd::cargo::cargo_bin!("host-cli"))
        .args(["device", "get", "--json", "--device"])
        .arg(format!("serial:{}", emulator.port))
        .output()
        .expect("runs");
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{message}");
    let parameters: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(parameters["stiffness_n_per_m"], 500.0, "{parameters}");
    assert_eq!(parameters["order"], 0.5);
    let coefficients = parameters["operator"]["coefficients"].as_array();
    assert_eq!(coefficients.map(Vec::len), Some(40));
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_python_host_survives_a_bad_line_and_counts_what_is_missing() {
    let line = "corrupt=2% drop=1% duplicate=1% line_seed=1";
    let Some((summary, emulator)) = client(line, TICKS, "--stiffness 500") else {
        return;
    };
    let unread = emulator.unread();
    let number = |name: &str| summary[name].as_u64().expect("a number");
    let (samples, missing) = (number("samples"), number("lost_ticks"));
    assert_eq!(samples + missing, TICKS);
    // 3 % of the frames do not arrive whole; five standard deviations around that, and what was not fetched.
    assert!(
        (215..=385 + unread).contains(&missing),
        "{unread} {summary}"
    );
    // Every sample that is missing left a gap in the numbers; so did a few answers.
    let lost = count(&summary, "link", "lost");
    assert!((missing..missing + 100).contains(&lost), "{summary}");
    // 2 % and 1 % of the 10 000 that were fetched.
    let unread = unread.min(TICKS);
    let least = |count: u64| count * (TICKS - unread) / TICKS;
    assert!(
        (least(130)..=300).contains(&count(&summary, "link", "corrupt")),
        "{unread} {summary}"
    );
    assert!(
        (least(50)..=150).contains(&count(&summary, "link", "duplicate")),
        "{unread} {summary}"
    );
    assert!(count(&summary, "link", "retries") > 0, "{summary}");
    // Of the few hundred requests and keep-alives some were damaged, none was acted on: what was set was
    // read back, and every force is that of its position, to the last bit.
    assert!(count(&summary, "device", "corrupt") > 0, "{summary}");
    assert_eq!(summary["largest_force_error_n"], 0.0, "{summary}");
    is_at_rest(&summary, 500.0);
}

#[test]
fn batches_tell_a_python_host_the_same() {
    let Some((summary, _emulator)) = client("", 2000, "--stiffness 500 --batch 16") else {
        return;
    };
    assert_eq!(summary["samples"], 2000, "{summary}");
    // 125 frames, and some answers.
    assert!(count(&summary, "link", "received") < 500, "{summary}");
    assert_eq!(summary["largest_force_error_n"], 0.0, "{summary}");
    is_at_rest(&summary, 500.0);
}

#[test]
fn the_document_tells_the_devices_numbers() {
    let document =
        std::fs::read_to_string(repository("crates/haptic-link/protocol.md")).expect("is there");
    let faults = document.split("### Enumeration Fault\n").nth(1);
    let faults = faults.expect("a table of faults");
    let codes: Vec<&str> = faults
        .split("\n#")
        .next()
        .unwrap_or_default()
        .lines()
        .filter(|line| line.starts_with("| ") && !line.starts_with("| number"))
        .collect();
    assert_eq!(codes.len(), Fault::ALL.len());
    for (line, fault) in codes.iter().zip(Fault::ALL) {
        let row = format!("| {} | {fault:?} |", fault.code());
        assert!(line.starts_with(&row), "{line} is not {row}");
    }
    let words: Vec<&str> = document.split_whitespace().collect();
    let flat = words.join(" ");
    for text in [
        format!("the last {FLIGHT_SAMPLES} ticks"),
        format!("up to {QUEUE_SAMPLES} samples wait"),
    ] {
        assert!(flat.contains(&text), "\"{text}\" is not there");
    }
}
