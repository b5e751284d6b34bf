//! A line that floods or falls silent while a command asks a device for something: told, and left at once when somebody stops. Python has
//! a test of its own, the library all the ways in which a line can be mad; the page runs on no device.

use super::Emulated;
use super::middle::Middle;
use super::unheard::ended;
use crate::process::signal;
use haptic_link::DeviceReport;
use haptic_loop::realtime::Moment;
use std::sync::mpsc::channel;
use std::time::Duration;

/// What comes without a pause; nothing is a silence.
const FLOODS: [&[u8]; 3] = [b"", &[0; 4096], &[0x5a; 4096]];

const RELAX: &str =
    "relax watchdog=1s late_ticks=0 --contact rigid --ramp-time 0.5s --duration 600s --quiet";

const OTHERS: &[&str] = &[
    "relax watchdog=1s max_age_ticks=1000 --loop host --force-unstable --contact rigid --duration 600s --quiet",
    "zwidth --mass 65g --damping 3.5 --sample-time 1ms --orders 1 --points 2 --push-by hand",
    "device measure --force-limit 1N",
    "device selftest",
];

/// The command from its first sample on, until it has told it or was stopped; the time from then on.
fn floods(line: &str, words: &'static [u8], stopped: bool) -> Duration {
    let device = Emulated::new("");
    device.loosen();
    let (sampled, samples) = channel();
    let middle = Middle::before(&device, move |report| {
        if matches!(report, DeviceReport::Sample(_) | DeviceReport::Batch(_)) {
            // Nobody waits for the second.
            let _ = sampled.send(());
        }
        false
    });
    let line = format!("{line} --device serial:line");
    let run = device.place.start(&line);
    samples.recv().expect("a sample");
    middle.floods(words);
    if stopped {
        signal(&run, "INT");
    }
    let since = Moment::now();
    let ended = ended(&line, run);
    let words: &[&str] = if !stopped {
        &["does not answer", "no answer to"]
    } else {
        &["interrupted", "stopped without a sample", "no answer to"]
    };
    assert!(
        words.iter().any(|words| ended.error().contains(words)),
        "{ended}"
    );
    since.elapsed()
}

#[test]
fn a_command_tells_a_line_that_floods_and_hears_a_stop_meanwhile() {
    std::thread::scope(|scope| {
        for words in FLOODS {
            for stopped in [false, true] {
                scope.spawn(move || floods(RELAX, words, stopped));
            }
        }
        for line in OTHERS {
            scope.spawn(move || floods(line, FLOODS[1], true));
        }
    });
}

#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_a_flood_is_told_in_time_and_left_at_once() {
    for words in FLOODS {
        for line in [&[RELAX], OTHERS].concat() {
            // What a program takes to end is beside what it listens.
            for (stopped, most_s) in [(false, 3.0), (true, 1.0)] {
                let took_s = floods(line, words, stopped).as_secs_f64();
                // A self-test has said so, and asks on.
                let asks_on = !stopped && line.contains("selftest");
                assert!(asks_on || took_s < most_s, "{line}, {stopped}: {took_s} s");
            }
        }
    }
}
