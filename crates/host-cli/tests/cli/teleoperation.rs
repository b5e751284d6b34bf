//! Two hands over a line: analysis, simulated runs, and two processes with real datagrams between them.

use crate::process::{Ended, Place, column, number, signal};
use std::io::{BufRead as _, BufReader};
use std::process::Child;
use testkit::{assert_close, assert_says};

/// A side in a process of its own, and the address it listens at.
struct Side {
    child: Child,
    line: String,
    address: String,
    complaints: std::thread::JoinHandle<String>,
}

impl Side {
    /// Starts `host-cli LINE --json` and waits until it says where it listens or connects.
    fn start(place: &Place, line: &str) -> Self {
        let mut child = place.start(&format!("{line} --json"));
        let mut lines = BufReader::new(child.stderr.take().expect("piped"));
        let mut first = String::new();
        lines.read_line(&mut first).expect("readable");
        let address = first.trim().rsplit(' ').next().unwrap_or("").to_owned();
        let complaints = std::thread::spawn(move || {
            let mut rest = first;
            if !rest.starts_with("error") {
                rest.clear();
            }
            while lines.read_line(&mut rest).is_ok_and(|bytes| bytes > 0) {}
            rest
        });
        Self {
            child,
            line: line.to_owned(),
            address,
            complaints,
        }
    }

    fn end(self) -> Ended {
        let mut output = self.child.wait_with_output().expect("ends");
        output.stderr = self.complaints.join().expect("read").into_bytes();
        Ended::new(self.line, &output)
    }

    fn signal(&self, name: &str) {
        signal(&self.child, name);
    }
}

/// Both sides of a file, the master at the slave's address.
fn both(place: &Place, file: &str, options: &str) -> (Side, Side) {
    // However busy this machine is.
    let options = format!("{options} --skipped-most 100%");
    let listen = format!("teleoperate {file} --listen 127.0.0.1:0 {options}");
    let slave = Side::start(place, &listen);
    let connect = format!("teleoperate {file} --connect {} {options}", slave.address);
    let master = Side::start(place, &connect);
    (slave, master)
}

/// The log of a master that runs.
const MASTERS_LOG: &str = "results/master-0001/master.mcap.part";

/// Silence that no busy machine makes.
const PATIENT: &str = "[teleoperation]\narchitecture = \"time-domain\"\nsilence_s = 60\n";

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn two_processes_meet_count_what_is_lost_and_end_with_forces_at_zero() {
    let place = Place::new();
    place.write("far.toml", PATIENT);
    let (slave, master) = both(&place, "far.toml", "duration=2s window=1s");
    let (master, slave) = (master.end(), slave.end());
    for (ended, side) in [(master, "master"), (slave, "slave")] {
        let report = ended.succeeded_with_warnings().json();
        assert_eq!(report["side"], side);
        assert_eq!(number(&report, "final_force_n"), 0.0);
        let (acted_on, sent) = (number(&report, "acted_on"), number(&report, "sent"));
        assert!(acted_on > 0.0 && sent > 0.0, "{report}");
        // Every number up to the newest was acted on, or came late, or is counted as missing.
        assert!(
            number(&report, "missing") >= number(&report, "stale"),
            "{report}"
        );
        assert_eq!(
            ["duplicate", "corrupt"].map(|key| number(&report, key)),
            [0.0; 2]
        );
        keeps_its_run(&place, side, &report);
    }
}

/// Log, table and picture of a side: each tick of its device is there, those that a busy machine skipped with their flaw.
fn keeps_its_run(place: &Place, side: &str, report: &serde_json::Value) {
    let file = |ending: &str| format!("results/{side}-0001/{side}.{ending}");
    for (key, ending) in [("log", "mcap"), ("csv", "csv"), ("figure", "png")] {
        assert_eq!(report[key], file(ending), "{report}");
        assert!(place.path(&file(ending)).exists(), "{}", file(ending));
    }
    let check = place
        .run(&format!("log check {} --json", file("mcap")))
        .json();
    let (ticks, skipped) = (number(report, "ticks"), number(report, "skipped"));
    let counts = ["samples", "missing_samples", "late_forces"].map(|key| number(&check, key));
    assert_eq!(counts, [ticks, 0.0, skipped], "{check}");
    // The forces of the table are those of the report.
    let table = place.text(&file("csv"));
    let header = "time_s,reference_m,position_m,force_n,outside_force_n,taken_j";
    assert_eq!(table.lines().next(), Some(header));
    let forces = column(&table, "force_n").into_iter().map(f64::abs);
    // This reader of JSON rounds the last bit.
    let peak_n = number(report, "peak_force_n");
    assert_close("peak", forces.fold(0.0, f64::max), peak_n, 1e-12 * peak_n);
}

#[test]
fn a_side_whose_partner_is_killed_is_at_zero_within_the_stated_time() {
    let place = Place::new();
    let file = "[teleoperation]\narchitecture = \"wave\"\nsilence_s = 0.5\n";
    place.write("far.toml", file);
    let (mut slave, mut master) = both(&place, "far.toml", "duration=600s");
    // Or a busy machine has let one fall silent before.
    place.grows(MASTERS_LOG, 40_000, &mut master.child);
    slave.child.kill().expect("running");
    slave.child.wait().expect("ends");
    let ended = master.end().failed(1);
    assert_says(ended.error(), "the other side fell silent");
    let report = ended.json();
    assert_eq!(report["ended"], "silent");
    assert_eq!(number(&report, "final_force_n"), 0.0);
    // Device time, so a busy machine changes nothing, but for whole samples that its clock skipped in one piece.
    let most = number(&report, "silent_to_zero_most_s") + 1e-3 * number(&report, "skipped");
    let check = place.run("log check results/master-0001/master.mcap --json");
    let check = check.failed(4).json();
    let reason = &check["end"]["reason"];
    assert_eq!(*reason, "the other side was silent for too long");
    assert_eq!(number(&check, "missing_samples"), 0.0, "{check}");
    assert!(report["csv"].is_null() && report["figure"].is_null());
    let took = number(&report, "silent_to_zero_s");
    assert!(took <= most && took >= 0.5, "{took} s of {most} s");
}

#[test]
fn ctrl_c_is_zero_first_and_a_goodbye() {
    let place = Place::new();
    place.write("far.toml", PATIENT);
    let (slave, mut master) = both(&place, "far.toml", "duration=600s");
    assert!(place.grows(MASTERS_LOG, 40_000, &mut master.child));
    master.signal("INT");
    let master = master.end().failed(1);
    let report = master.json();
    assert_eq!(report["ended"], "interrupted");
    assert_eq!(number(&report, "final_force_n"), 0.0);
    let report = slave.end().succeeded_with_warnings().json();
    assert_eq!(report["ended"], "other-left");
    assert_eq!(number(&report, "final_force_n"), 0.0);
}
