//! A device that goes away in the middle of a run or while it is watched: the same exit code whatever its kind.

use super::Emulated;
use crate::process::{Ended, Place, binary, holds, number, signal, until};
use haptic_log::record::{Entry, LogFiles};
use std::io::{BufRead as _, BufReader, Read as _};
use std::process::{Child, Command, Stdio};
use std::time::Duration;
use testkit::assert_says;

/// Each kind of device: how it is emulated, and its name.
const KINDS: [(&str, &str); 3] = [
    ("", "serial:device"),
    ("--kind moteus", "moteus:device,watchdog=1s"),
    ("--kind haply-2diy hand=free", "haply:device"),
];

#[test]
fn a_device_that_goes_away_in_a_run_is_not_usable_whatever_its_kind() {
    let kinds = [
        ("", "serial:device"),
        ("--kind moteus", "moteus:device,watchdog=1s,lost=1000"),
        ("--kind haply-2diy", "haply:device"),
    ];
    at_the_same_time(&kinds, a_run_is_not_usable);
}

/// They wait for the clock.
fn at_the_same_time(kinds: &[(&'static str, &'static str)], look: fn(&str, &str)) {
    std::thread::scope(|scope| {
        for &(kind, name) in kinds {
            scope.spawn(move || look(kind, name));
        }
    });
}

fn a_run_is_not_usable(kind: &str, device: &str) {
    let mut emulated = Emulated::at_terminal("device", kind);
    let line = format!(
        "relax --device {device} watchdog=1s late_ticks=0 --contact rigid --duration 300s --sample-time 5ms --out run --quiet"
    );
    // A busy machine may lose the device before there is a log: then anew.
    let run = until("a log", || {
        let mut run = emulated.place.start(&line);
        let begun = emulated.place.grows("run/relax.mcap.part", 0, &mut run);
        begun.then_some(run)
    });
    emulated.kill();
    let ended = Ended::new(line, &run.wait_with_output().expect("ends")).failed(3);
    assert_says(ended.error(), "the log is run/relax.mcap");
    let info = emulated.json("log info run/relax.mcap");
    assert_eq!(info["complete"], true, "{info}");
    holds(number(&info["end"], "planned_samples") > 6e4, &info);
    // Nobody knows how many samples our board still made; that of others is in a fault.
    if kind.is_empty() {
        assert_eq!(info["end"]["ended"], "link", "{info}");
        emulated.place.run("log check run/relax.mcap").failed(4);
    }
}

/// Reads the standard error of a command until a line says this, then pulls the plug of its device; how the command ended, or `None` if it
/// did before: a busy machine may lose a board that is slow.
fn unplugged_after(mut run: Child, device: &mut Emulated, words: &str) -> Option<Ended> {
    let mut stderr = BufReader::new(run.stderr.take().expect("piped"));
    let mut message = String::new();
    while !message.contains(words) {
        let count = stderr.read_line(&mut message).expect("is text");
        if count == 0 {
            break;
        }
    }
    // Into the middle of it, or to its beginning on a busy machine: the claim is the same.
    std::thread::sleep(Duration::from_millis(200));
    if run.try_wait().expect("is asked").is_some() {
        return None;
    }
    device.kill();
    stderr.read_to_string(&mut message).expect("is text");
    let mut output = run.wait_with_output().expect("ends");
    output.stderr = message.into_bytes();
    Some(Ended::new(words.to_owned(), &output))
}

/// It says in one line that the device is gone, what to look at, and no number.
fn says_that_it_is_gone(ended: &Ended) {
    let words = ["plug", "check the port", "may still push"];
    let one = words.iter().any(|word| ended.error().contains(word));
    assert!(one && !ended.error().contains("implausible"), "{ended}");
    says_only_what_can_be(ended.error());
}

/// A board is not said to have been told or reset through a port that is gone, and one that may still push is feared.
fn says_only_what_can_be(words: &str) {
    if words.contains("its port is gone") {
        assert!(!words.contains("was told"), "{words}");
        assert_says(words, "it may still push: switch its supply off");
    }
}

#[test]
fn a_measurement_of_a_device_that_goes_away_tells_no_numbers() {
    for (kind, name) in KINDS {
        let mut device = Emulated::at_terminal("device", kind);
        let line = format!(
            "device measure --device {name} --force-limit 1.5N --duration 60s --sample-time 5ms watchdog=1s max_age_ticks=1000 \
             --out model.toml --json"
        );
        let ended = until("a measurement", || {
            let run = device.place.start(&line);
            unplugged_after(run, &mut device, "the limits set on the device")
        });
        let ended = ended.failed(3);
        says_that_it_is_gone(&ended);
        assert_eq!(ended.stdout, "", "{ended}");
        assert!(!device.place.path("model.toml").exists());
    }
}

/// Logs of a monitor that are written to, and whole ones.
fn logs(place: &Place) -> (usize, usize) {
    let files = place.files();
    let count = |end: &str| files.iter().filter(|name| name.ends_with(end)).count();
    (count(".mcap.part"), count(".mcap"))
}
/// Those of its logs that hold a sample, also while they are written to.
fn sampled(place: &Place) -> Vec<String> {
    let mut files = place.files();
    files.retain(|name| {
        let samples = LogFiles::open(&place.path(name));
        // It may have got its final name meanwhile, or end in the middle of a chunk.
        let mut samples = samples.into_iter().flatten();
        name.contains(".mcap") && samples.any(|entry| matches!(entry, Ok(Entry::Tick(_))))
    });
    files
}

#[test]
fn a_monitor_closes_its_log_when_the_device_goes_away_and_goes_on_when_it_is_back() {
    at_the_same_time(&KINDS, a_monitor_goes_on);
}

/// How often a monitor says that its device is gone, and each time but the last that it is back.
fn times_lost(kind: &str, message: &str) -> usize {
    let notes: Vec<&str> = message
        .lines()
        .filter(|line| line.contains("link: "))
        .collect();
    assert!(notes.len() >= 2, "{kind}: {message}");
    for pair in notes.chunks(2) {
        let gone = [
            "the connection is gone",
            "is gone: check",
            "did not answer",
            "no complete answer",
            "its port is gone",
        ];
        let one = gone.iter().any(|words| pair[0].contains(words));
        assert!(one, "{kind}: {message}");
        says_only_what_can_be(pair[0]);
        // A busy machine may lose it once more at the end.
        let back = pair.get(1).unwrap_or(&"the device is back");
        assert!(back.contains("the device is back"), "{kind}: {message}");
    }
    notes.len() / 2
}

/// Waits as long as the command lives.
fn until_it_tells<T>(what: &str, run: &mut Child, mut look: impl FnMut() -> Option<T>) -> T {
    until(what, || {
        if run.try_wait().expect("can be asked").is_some() {
            let mut message = String::new();
            let stderr = run.stderr.as_mut().expect("piped");
            stderr.read_to_string(&mut message).expect("is text");
            panic!("no {what}: {message}");
        }
        look()
    })
}

fn a_monitor_goes_on(kind: &str, name: &str) {
    let mut device = Emulated::at_terminal("device", kind);
    // A busy machine may serve it late at first, too.
    let line = format!("device monitor --device {name} --wait 600s --out watch --json");
    let mut monitor = device.place.start(&line);
    // A busy machine may have lost the device before, and has its second log open then.
    until_it_tells("samples", &mut monitor, || sampled(&device.place).pop());
    device.kill();
    // Nothing is written any more while it is away.
    let before = until_it_tells("the end of the log", &mut monitor, || {
        let (open, _) = logs(&device.place);
        (open == 0).then(|| sampled(&device.place))
    });
    device.plug_in(kind);
    until_it_tells("samples of it when it is back", &mut monitor, || {
        let mut since = sampled(&device.place);
        since.retain(|name| !before.contains(name));
        since.pop()
    });
    signal(&monitor, "INT");
    let mut message = String::new();
    let stderr = monitor.stderr.as_mut().expect("piped");
    stderr.read_to_string(&mut message).expect("is text");
    let ended = monitor.wait_with_output().expect("ends");
    let lost = times_lost(kind, &message);
    // A busy machine skips samples of a device that it serves, and may lose it more often than it was unplugged: it says so.
    let code = ended.status.code();
    let watched: serde_json::Value = serde_json::from_slice(&ended.stdout).expect("JSON");
    let missing = number(&watched, "samples_lost") + number(&watched, "dropped_samples");
    let wanted = match (message.contains("did not come back"), missing > 0.0) {
        (true, _) => 3,
        (false, true) => 4,
        (false, false) => 0,
    };
    assert_eq!(code, Some(wanted), "{kind}: {message} {watched}");
    assert_eq!(number(&watched, "faults"), 0.0, "{kind}: {watched}");
    let again = number(&watched, "reconnected");
    assert_eq!(again, lost as f64, "{kind}: {watched}");
    let logs = watched["logs"].as_array().expect("names");
    assert_eq!(logs.len() as f64, 1.0 + again, "{kind}: {watched}");
    let mut samples = 0.0;
    for log in logs {
        let info = device.json(&format!("log info {}", log.as_str().expect("a name")));
        assert_eq!(info["complete"], true, "{kind}: {info}");
        samples += number(&info, "samples");
    }
    assert_eq!(samples, number(&watched, "samples"), "{kind}: {watched}");
    assert!(samples > 0.0, "{kind}: {watched}");
}

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
    until("a log", || {
        let ended = monitor.try_wait().expect("can be asked").is_some();
        (ended || logs(&device.place) != (0, 0)).then_some(())
    });
    away(&mut device);
    let mut message = String::new();
    while !message.contains("link: ") {
        let count = stderr.read_line(&mut message).expect("is text");
        assert!(count > 0, "{kind}: {message}");
    }
    signal(&monitor, "INT");
    stderr.read_to_string(&mut message).expect("is text");
    let mut output = monitor.wait_with_output().expect("ends");
    output.stderr = message.into_bytes();
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
    let line =
        "ulimit -f 40 && exec \"$0\" device monitor --device serial:device --out watch --json";
    let mut monitor = Command::new("sh");
    let monitor = monitor
        .args(["-c", line])
        .arg(binary())
        .current_dir(device.place.path(""));
    let monitor = monitor.stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut monitor = monitor.spawn().expect("starts");
    let mut stderr = BufReader::new(monitor.stderr.take().expect("piped"));
    let mut message = String::new();
    let count = stderr.read_line(&mut message).expect("is text");
    assert!(count > 0 && !message.contains("ulimit"), "{message}");
    let lost = "watch/monitor.mcap.part & samples are safe";
    assert_says(&message, "warning:  & nothing is recorded");
    assert_says(&message, lost);
    assert!(monitor.try_wait().expect("can be asked").is_none());
    signal(&monitor, "INT");
    stderr.read_to_string(&mut message).expect("is text");
    let mut output = monitor.wait_with_output().expect("ends");
    output.stderr = message.into_bytes();
    let ended = Ended::new(line.to_owned(), &output).failed(4);
    assert_says(ended.error(), lost);
    let report = ended.json();
    let [samples, dropped] = ["samples", "dropped_samples"].map(|key| number(&report, key));
    assert!(dropped > 0.0 && samples >= dropped, "{report}");
}
