//! Runs that do not reach their end: stopped by a signal, by a fault, by a full disk.

use crate::experiments::SHORT;
use crate::process::{Ended, Place, column, number, until};
use std::process::Child;
use testkit::{assert_close, assert_says, skip};

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

#[test]
fn creep_stops_at_a_termination_signal_too() {
    let (place, log) = (Place::new(), "run/creep.mcap.part");
    let line = "creep --realtime --out run --quiet";
    let ended = start_and_signal(&place, line, "TERM", |_| has_grown(&place, log), || ()).failed(1);
    assert_eq!(ended.stdout, "", "{ended}");
    assert_eq!(place.files(), ["run/", "run/creep.mcap"]);
    let ticks = place.run("log export run/creep.mcap -").succeeded().stdout;
    let forces = column(&ticks, "commanded_force_n");
    assert_eq!(forces.last(), Some(&0.0), "the force at the end");
}

#[test]
fn a_folder_that_a_run_writes_to_is_its_own() {
    let place = Place::new();
    let ended = run_and_interrupt(&place, "relax --realtime --out run", || {
        for line in [
            "relax --duration 2s --out run",
            "relax --duration 2s --out run --overwrite",
            "log recover run/relax.mcap.part saved.mcap",
        ] {
            let refused = place.run(line).failed(2);
            assert_says(
                refused.error(),
                "relax.mcap.part` is being written by another run; wait",
            );
        }
    });
    ended.failed(1);
    assert_eq!(place.files(), ["run/", "run/relax.mcap"]);
    place.run("log check run/relax.mcap").succeeded();
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

/// The promises for a disk that took only the first of `run/`.
fn a_full_disk_was_survived(place: &Place, ended: Ended) {
    let words = [
        "run/relax.mcap.part",
        "log recover",
        "the force fell to zero",
    ];
    let ended = ended.refused(4, &words);
    // One line says the cause once.
    assert_eq!(ended.error().matches("os error").count(), 1, "{ended}");
    assert_eq!(place.files()[1..], ["run/relax.mcap.part"]);

    let saved = place.run("log recover run/relax.mcap.part saved.mcap --json");
    let saved = saved.failed(4).json();
    // A sample is 69 bytes and more; compression may halve that at best.
    let samples = number(&saved, "samples");
    assert!(samples >= 500.0, "{saved}");
    let check = place.json("log check saved.mcap");
    assert_eq!(number(&check, "samples"), samples);
    // Whole chunks of 100 ms, from the start.
    assert_eq!(number(&check, "first_s"), 0.0);
}

/// Runs a line of the shell where no file may be longer than so many blocks of 512 bytes; nothing where the shell cannot
/// limit it. Messages are no files.
pub(crate) fn with_short_files(place: &Place, blocks: u32, line: &str) -> Option<Ended> {
    let ended = place.shell(&format!("ulimit -f {blocks} && {line}"));
    if ended.stderr.contains("ulimit") {
        skip("the shell cannot limit the file size");
        return None;
    }
    Some(ended)
}

#[test]
fn a_limit_on_the_file_size_ends_the_run_with_what_was_written() {
    let place = Place::new();
    if let Some(ended) = with_short_files(&place, 200, "exec \"$0\" relax --out run") {
        a_full_disk_was_survived(&place, ended);
    }
}

#[test]
fn a_disk_without_room_for_a_table_speaks_of_no_log_where_there_is_none() {
    let place = Place::new();
    // The table of 1000 frequencies takes 40 kB.
    let run = "exec \"$0\" analyze sensitivity --order 0.5 --alpha 0.01 --beta 0.01 --points 1000 --out s";
    let Some(ended) = with_short_files(&place, 8, run) else {
        return;
    };
    assert!(!ended.stderr.contains("log"), "{ended}");
    let ended = ended.failed(4);
    assert_says(
        ended.error(),
        "s/sensitivity.csv & make space and try again",
    );
    // What was found is told all the same.
    assert!(ended.stdout.contains("peak"), "{ended}");
}

#[test]
#[cfg(target_os = "linux")]
fn what_was_exported_before_the_disk_was_full_is_not_said_to_be_gone() {
    let place = Place::new();
    place.run(SHORT).succeeded();
    let ended = place.shell("exec \"$0\" log export run/relax.mcap - > /dev/full");
    assert!(!ended.stderr.contains("nothing was left"), "{ended}");
    ended.refused(4, &["standard output", "the log is untouched: make space"]);
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_under_the_summary_is_an_error_that_says_so() {
    let place = Place::new();
    place.run(SHORT).succeeded();
    place.write("x.csv", "x\n1\n2\n");
    for line in [
        "--help",
        "relax --duration 1s --ramp-time 0.5s --out a",
        "relax --duration 1s --ramp-time 0.5s --out b --json",
        "weights --order 0.5",
        "differintegrate --order 0.5 --sample-time 1ms x.csv",
        "materials list",
        "analyze stability-region --order 0.5 --delta 0.1",
        "log check run/relax.mcap",
        "log export run/relax.mcap -",
        "man pages",
    ] {
        let ended = place.shell(&format!("exec \"$0\" {line} > /dev/full"));
        // Not 0: the numbers did not arrive.
        assert_eq!(ended.code, Some(4), "{ended}");
        assert!(ended.error().contains("standard output"), "{ended}");
    }
}

#[test]
fn a_full_disk_under_any_file_loses_data_and_says_so() {
    let place = Place::new();
    place.run(SHORT).succeeded();
    for line in [
        "log export run/relax.mcap ticks.csv",
        "log recover run/relax.mcap saved.mcap",
        "log plot run/relax.mcap --out pictures",
        "analyze stability-region --order 0.5 --delta 0.1 --out region",
        "man pages",
    ] {
        let Some(ended) = with_short_files(&place, 0, &format!("exec \"$0\" {line}")) else {
            return;
        };
        assert_eq!(ended.code, Some(4), "{ended}");
        assert_eq!(ended.error().lines().count(), 1, "{ended}");
    }
}

/// What `nohup` does: the run goes on to its end. Without it, it is ended in order.
#[test]
fn a_hangup_that_was_ignored_from_the_start_stays_ignored() {
    for (before, duration, code) in [("", "300s", 1), ("trap '' HUP && ", "800ms", 0)] {
        let place = Place::new();
        let script = format!(
            "{before} \"$0\" relax --realtime --duration {duration} --ramp-time 100ms --out run --quiet & \
             while ! [ -s run/relax.mcap.part ]; do sleep 0.05; done; kill -HUP $!; wait $!"
        );
        let ended = place.shell(&script);
        assert_eq!(ended.code, Some(code), "{ended}");
        assert!(place.path("run/relax.mcap").exists(), "{ended}");
    }
}

#[test]
fn a_folder_that_is_removed_under_a_run_is_lost_data() {
    let place = Place::new();
    type Done = fn(std::path::PathBuf) -> std::io::Result<()>;
    let removed: (Done, &str) = (std::fs::remove_file, "was removed while");
    let emptied: (Done, &str) = (
        |path| std::fs::File::create(path).map(drop),
        "was emptied or cut while",
    );
    for (done, what) in [removed, emptied] {
        let path = place.path(PART);
        let line = "relax --realtime --out run --overwrite";
        let ended = run_and_interrupt(&place, line, || done(path).expect("is done"));
        ended.refused(4, &[PART, what, "make the run again"]);
        let _ = std::fs::remove_file(place.path(PART));
    }
}
