//! Requests whose answers are lost, and stops that the device does not hear.

use super::middle::Middle;
use super::untold::{logged_as_told, witnessed};
use super::{Emulated, number};
use crate::process::{Ended, PATIENCE, signal};
use haptic_link::Report;
use std::process::Child;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::time::{Duration, Instant};

/// A wall that the device is pushed through, out of its workspace.
pub(super) const LEAVES: &str = "[wall]
mass_kg = 0.065
damping_n_s_per_m = 3.5
sample_time_s = 0.001
order = 0.5
stiffness_n_per_m = 20
dissipation_n_s_mu_per_m = 1
push_n = 1
force_limit_n = 5
duration_s = 4
workspace_low_m = -0.01
workspace_high_m = 0.01
";

/// A relaxation that has some hundred samples.
pub(super) fn under_way(device: &Emulated, line: &str) -> Child {
    let mut child = device.place.start(line);
    let log = device.place.path("run/relax.mcap.part");
    let began = Instant::now();
    while std::fs::metadata(&log).map_or(0, |file| file.len()) < 40_000 {
        let gone = child.try_wait().expect("can be waited for");
        assert!(gone.is_none(), "ended before the signal: {gone:?}");
        assert!(began.elapsed() < PATIENCE, "no log");
        std::thread::sleep(Duration::from_millis(5));
    }
    child
}

pub(super) fn ended(line: &str, child: Child) -> Ended {
    Ended::new(line.to_owned(), &child.wait_with_output().expect("ends"))
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_sample_that_is_asked_for_after_a_silence_is_none_of_the_run() {
    let device = Emulated::new("");
    device.loosen();
    let (said, faults) = channel();
    let _line = Middle::before(&device, move |report| {
        if matches!(report, Report::Fault(_)) {
            // Nobody waits for the second.
            let _ = said.send(());
        }
        false
    });
    let line = "relax --device serial:line watchdog=300ms --contact rigid --ramp-time 100ms --duration 60s --out run --quiet --json";
    let child = under_way(&device, line);
    signal(&child, "STOP");
    faults.recv_timeout(PATIENCE).expect("the device lets go");
    // It tells a hundred ticks after its fault, then none.
    std::thread::sleep(Duration::from_millis(600));
    signal(&child, "CONT");
    let ended = ended(line, child).failed(1);
    assert!(ended.error().contains("heard nothing"), "{ended}");
    assert!(!ended.error().contains("lacks"), "{ended}");
    assert_eq!(number(&ended.json(), "/dropped_samples"), 0.0, "{ended}");
    let check = device.place.run("log check run/relax.mcap --json").json();
    assert_eq!(number(&check, "/missing_samples"), 0.0, "{check}");
}

/// Samples are lost, and all else comes: the stop goes out at once, not when the silence is noticed.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_stop_without_samples_goes_out_at_once() {
    let device = Emulated::new("");
    device.loosen();
    let lost = Arc::new(AtomicBool::new(false));
    let losing = Arc::clone(&lost);
    let _line = Middle::before(&device, move |report| {
        losing.load(Ordering::Relaxed) && matches!(report, Report::Sample(_))
    });
    let line = "relax --device serial:line watchdog=1s --contact rigid --ramp-time 100ms --duration 60s --out run --quiet --json";
    let child = under_way(&device, line);
    lost.store(true, Ordering::Relaxed);
    signal(&child, "INT");
    let ended = ended(line, child).failed(1);
    assert!(
        ended.error().contains("interrupted: the run ended"),
        "{ended}"
    );
    assert_eq!(ended.json()["ended_early"], "interrupted");
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_stop_that_the_device_does_not_hear_is_told_as_it_was() {
    std::thread::scope(|scope| {
        for options in ["", "--loop host max_age_ticks=500"] {
            scope.spawn(move || is_told_as_it_was(options));
        }
    });
}

fn is_told_as_it_was(options: &str) {
    let device = Emulated::new("");
    device.loosen();
    let (middle, told) = witnessed(&device, |_| false);
    let line = format!(
        "relax --device serial:line {options} watchdog=500ms late_ticks=0 --contact rigid --ramp-time 100ms \
         --duration 60s --out run --quiet --json"
    );
    // Ctrl-C when nothing reaches the device any more.
    let child = under_way(&device, &line);
    middle.deafen();
    signal(&child, "INT");
    let ended = ended(&line, child).failed(1);
    let words = [
        "interrupted, but",
        "heard nothing from the host",
        "the device pushed on until",
    ];
    assert!(
        words.iter().all(|part| ended.error().contains(part)),
        "{ended}"
    );
    let last = (1e3 * number(&ended.json(), "/duration_s")).round();
    assert!(
        device.place.path("run/relax-fault.mcap").exists(),
        "{ended}"
    );
    // Those behind the samples that count.
    let behind = logged_as_told(&device, &told, last as u32);
    assert!(behind.iter().any(|(_, force_n)| *force_n < -0.01));
    let (_, last_n) = behind.last().expect("samples");
    assert!(last_n.abs() < 1e-12, "{last_n} N at the end");
    let check = device.place.run("log check run/relax.mcap --json").json();
    assert_eq!(check["end"]["ended"], "fault", "{check}");
    assert_eq!(number(&check, "/missing_samples"), 0.0, "{check}");
}
