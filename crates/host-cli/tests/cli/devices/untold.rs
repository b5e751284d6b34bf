//! What a log says of a run where the line lost what told of it: the frame of a fault, forces on their way to the device.

use super::middle::Middle;
use super::unheard::{LEAVES, ended, under_way};
use super::{Emulated, number};
use crate::faults::metadata;
use haptic_link::{Report, Request, Sample, Start};
use haptic_loop::Limiters;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex};
use std::time::Duration;

/// Samples that a device told, by tick.
pub(super) type Told = Arc<Mutex<BTreeMap<u32, Sample>>>;

/// A line that keeps what the device tells, and loses the messages for which this is true.
pub(super) fn witnessed(device: &Emulated, loses: fn(&Report) -> bool) -> (Middle, Told) {
    let told = Told::default();
    let telling = Arc::clone(&told);
    let start = Request::Start(Start::ENDLESS).number();
    let line = Middle::before(device, move |report| {
        let mut told = telling.lock().expect("nobody panicked");
        match report {
            Report::Sample(sample) => drop(told.insert(sample.tick, sample.clone())),
            // The samples of a run before are none of this one.
            Report::Ack(ack) if ack.request == start => told.clear(),
            _ => {}
        }
        loses(report)
    });
    (line, told)
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_fault_whose_frame_is_lost_has_its_own_tick() {
    for options in ["", "--loop host max_age_ticks=500"] {
        let device = Emulated::new("");
        let (_line, told) = witnessed(&device, |report| matches!(report, Report::Fault(_)));
        device.place.write("wall.toml", LEAVES);
        let line = format!("run wall.toml --device serial:line {options} --out run --json");
        let ended = device.place.run(&line).failed(1);
        assert!(ended.error().contains("left its workspace"), "{ended}");
        let told = told.lock().expect("nobody panicked");
        let faulted = |sample: &&Sample| sample.axes[0].limiters & Limiters::FAULT.bits() != 0;
        let first = told.values().find(faulted).expect("a fault").tick;
        let report = ended.json();
        assert_eq!(number(&report, "/dropped_samples"), 0.0, "{report}");
        // The tick of the fault is none of the result.
        let last = (1e3 * number(&report, "/duration_s")).round();
        assert_eq!(last, f64::from(first) - 1.0, "{report}");
        let info = device.json("log info run/wall-fault.mcap");
        let fault = metadata(&info, "fault");
        assert_eq!(fault["tick"], first.to_string(), "{fault}");
        assert_eq!(fault["code"], "6", "{fault}");
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn forces_that_did_not_arrive_are_in_no_log() {
    let device = Emulated::new("");
    device.loosen();
    let (middle, told) = witnessed(&device, |_| false);
    let line = "relax --device serial:line --loop host max_age_ticks=500 watchdog=500ms late_ticks=0 --contact rigid \
                --ramp-time 2s --duration 60s --out run --quiet --json";
    // It loses all that goes to the device while the indenter moves.
    let child = under_way(&device, line);
    let newest = |told: &Told| {
        *told
            .lock()
            .expect("nobody panicked")
            .keys()
            .last()
            .expect("samples")
    };
    middle.deafen();
    std::thread::sleep(Duration::from_millis(20));
    let lost = newest(&told);
    let ended = ended(line, child).failed(1);
    assert!(ended.error().contains("heard nothing"), "{ended}");
    logged_as_told(&device, &told, lost);
}

/// The log of `run/relax` behind this tick, some hundred ticks and forces, N. Each tick of all has the force that the device itself told.
pub(super) fn logged_as_told(device: &Emulated, told: &Told, after: u32) -> Vec<(u32, f64)> {
    device
        .place
        .run("log export run/relax.mcap ticks.csv")
        .succeeded();
    let told = told.lock().expect("nobody panicked");
    let mut rows = csv(&device.place.text("ticks.csv"));
    let other = |(tick, force_n): &&(u32, f64)| {
        (force_n - f64::from(told[tick].axes[0].force_n)).abs() > 1e-9
    };
    let other = rows.iter().find(other);
    assert_eq!(other, None, "{:?}", other.map(|(tick, _)| &told[tick]));
    rows.retain(|(tick, _)| *tick > after);
    assert!(rows.len() > 400, "{}", rows.len());
    rows
}

/// Ticks and forces, N, of an exported log.
fn csv(text: &str) -> Vec<(u32, f64)> {
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().expect("a header").split(',').collect();
    let column = |name| {
        header
            .iter()
            .position(|column| *column == name)
            .expect("a column")
    };
    let (tick, force) = (column("tick"), column("applied_force_n"));
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let force_n = cells[force].parse().expect("a number");
        (cells[tick].parse().expect("a tick"), force_n)
    };
    lines.map(row).collect()
}
