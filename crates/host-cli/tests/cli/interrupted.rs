//! Runs that do not reach their end: stopped by a signal, by a fault, by a full disk.

use crate::process::{Ended, Place, SHORT, column, number, until};
use std::process::Child;
use testkit::{assert_close, assert_says};

/// A limiter bit of the log: the loop is stopping.
const STOPPING: u8 = 8;

/// The log of a run while it is written.
const PART: &str = "run/relax.mcap.part";

/// Starts `host-cli LINE`, and sends it a signal as soon as it is `ready`; before that does something else.
fn start_and_signal(
    place: &Place,
    line: &str,
    signal: &str,
    ready: impl Fn(&Child) -> bool,
    meanwhile: impl FnOnce(),
) -> Ended {
    let mut child = place.start(line);
    until("it to be ready", || {
        let is_ready = ready(&child);
        let gone = child.try_wait().expect("can be waited for");
        assert!(
            is_ready || gone.is_none(),
            "ended before the signal: {gone:?}"
        );
        is_ready.then_some(())
    });
    meanwhile();
    crate::process::signal(&child, signal);
    let output = child.wait_with_output().expect("ends");
    Ended::new(format!("{line} & kill -{signal}"), &output)
}

/// True once a log holds a few hundred samples: 100 ms are 8 kB.
fn has_grown(place: &Place, log: &str) -> bool {
    std::fs::metadata(place.path(log)).map_or(0, |file| file.len()) >= 20_000
}

/// Starts `host-cli LINE`, and interrupts it when its log has grown; before that does something else.
fn run_and_interrupt(place: &Place, line: &str, meanwhile: impl FnOnce()) -> Ended {
    start_and_signal(place, line, "INT", |_| has_grown(place, PART), meanwhile)
}

/// Ctrl-C. No picture of the run that it overwrites is left.
#[test]
fn ctrl_c_ramps_the_force_to_zero_and_closes_the_log() {
    // 2 N/s, so that the way from 0.15 N to zero takes some 70 ticks.
    const RATE_LIMIT_N_PER_S: f64 = 2.0;
    let place = Place::new();
    place.run(SHORT).succeeded();
    let line = "relax --realtime force_rate_limit=2N/s --out run --overwrite --json";
    let ended = run_and_interrupt(&place, line, || ()).failed(1);
    assert_says(
        ended.error(),
        "interrupted & ramped to zero & run/relax.mcap",
    );
    let report = ended.json();
    assert_eq!(report["ended_early"], "interrupted");
    assert_eq!(place.files(), ["run/", "run/relax.mcap"]);
    // The ramp to zero is no fault of the operator, the tissue or the limits.
    assert!(number(&report, "max_relative_error") < 1e-5, "{report}");
    assert_eq!(report["limited_samples"], 0, "{report}");
    let warnings = report["warnings"].to_string();
    let mut blamed = ["times the closed form", "force_limit_n"].into_iter();
    assert!(!blamed.any(|words| warnings.contains(words)), "{report}");

    let check = place.json("log check run/relax.mcap");
    assert_eq!(check["samples"], report["samples"]);
    let events = check["events"].as_array().expect("a list");
    assert_eq!(events.len(), 1, "{check}");
    assert_eq!(events[0]["kind"], "interrupted");

    let ticks = place.run("log export run/relax.mcap -").succeeded().stdout;
    let [times, forces, limiters] =
        ["time_s", "commanded_force_n", "limiters"].map(|name| column(&ticks, name));
    let stops = |limiters: &f64| *limiters as u8 & STOPPING != 0;
    let stop = limiters
        .iter()
        .position(stops)
        .expect("the log shows the stop");
    // The event lies in the tick before the first that stops.
    // This reader of JSON takes 0.20700000000000002 for 0.207.
    assert_close(
        "event",
        number(&events[0], "time_s"),
        times[stop - 1],
        1e-12,
    );
    let ramp = &forces[stop - 1..];
    assert!(ramp.len() > 10, "a ramp, not a step: {} ticks", ramp.len());
    for pair in ramp.windows(2) {
        let step = pair[0].abs() - pair[1].abs();
        assert!(
            step > 0.0 && step <= RATE_LIMIT_N_PER_S * 1e-3 + 1e-12,
            "{pair:?} N"
        );
    }
    assert_eq!(forces.last(), Some(&0.0), "the force at the end");
}

/// Starts `host-cli LINE` and interrupts it as soon as it listens.
#[cfg(target_os = "linux")]
pub(crate) fn interrupt_when_it_listens(place: &Place, line: &str) -> Ended {
    // Caught signals as a mask: bit 1 is SIGINT.
    let listens = |child: &Child| {
        let status = std::fs::read_to_string(format!("/proc/{}/status", child.id()));
        let status = status.unwrap_or_default();
        let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:"));
        caught.is_some_and(|mask| {
            u64::from_str_radix(mask.trim(), 16).is_ok_and(|mask| mask & 2 != 0)
        })
    };
    start_and_signal(place, line, "INT", listens, || ())
}

#[test]
#[cfg(target_os = "linux")]
fn long_searches_stop_at_ctrl_c_and_say_what_they_have() {
    let place = Place::new();
    let line = "zwidth --points 1000 duration=60s --out z --json";
    let ended = interrupt_when_it_listens(&place, line).failed(1);
    assert!(ended.error().contains("interrupted"), "{ended}");
    assert_eq!(ended.json()["ended_early"], "interrupted");
    let ended = interrupt_when_it_listens(&place, "reproduce --out again --json").failed(1);
    let report = ended.json();
    assert_eq!(report["ended_early"], "interrupted");
    // What is there is whole, and the report of it is written.
    let files = place.files();
    for figure in report["figures"].as_array().expect("a list") {
        assert!(
            files.iter().any(|file| figure["data"] == **file),
            "{figure}"
        );
    }
    assert!(place.text("again/report.md").contains("laim"));
}
