//! A device that tells what cannot be: a fault of its own, which ends the run with no force, and is in the log as what it is.

use super::Emulated;
use super::middle::Middle;
use crate::process::number;
use haptic_link::{Report, Sample};

/// The tick that lies.
const LIE: u32 = 700;

type Lie = fn(&mut Sample);

const LIES: [(&str, Lie); 2] = [
    ("a position of NaN m", |sample| {
        sample.axes[0].position_m = f32::NAN;
    }),
    ("a force of -1000000 N", |sample| {
        sample.axes[0].force_n = -1e6;
    }),
];

/// A run on a device that lies once. What else cannot be is named by `haptic-remote`.
fn lies((words, lie): (&str, Lie), options: &str) {
    let device = Emulated::new("");
    device.loosen();
    let _line = Middle::changing(&device, move |report| {
        Some(match report {
            Report::Sample(mut sample) if sample.tick == LIE => {
                lie(&mut sample);
                Report::Sample(sample)
            }
            report => report,
        })
    });
    let line = format!(
        "relax --device serial:line {options} watchdog=1s late_ticks=0 --contact rigid --ramp-time 0.5s --duration 60s --out run \
         --quiet --json"
    );
    let ended = device.place.run(&line).failed(1);
    let said = ended.error();
    assert!(
        said.contains("reported the impossible") && said.contains(words),
        "{ended}"
    );
    let report = ended.json();
    // It is no part of the result.
    assert!(
        number(&report, "duration_s") < 1e-3 * f64::from(LIE) - 5e-4,
        "{report}"
    );
    assert!(number(&report, "peak_force_n") < 100.0, "{report}");
    assert!(
        device.place.path("run/relax-fault.mcap").exists(),
        "{ended}"
    );
    let check = device
        .place
        .run("log check run/relax.mcap --json")
        .failed(4);
    let check = check.json();
    assert_eq!(number(&check, "impossible"), 1.0, "{check}");
    assert_eq!(number(&check, "missing_samples"), 0.0, "{check}");
    assert_eq!(check["end"]["ended"], "fault", "{check}");
    // It was told to let go: its own watchdog did not have to see to that.
    let info = device.json("device info --device serial:device");
    assert_eq!(
        (&info["state"], &info["fault"]),
        (&"idle".into(), &().into()),
        "{info}"
    );
}

#[test]
fn a_sample_that_cannot_be_ends_a_run_as_a_fault_of_the_device() {
    std::thread::scope(|scope| {
        for (lie, options) in LIES.into_iter().zip(["", "--loop host max_age_ticks=1000"]) {
            scope.spawn(move || lies(lie, options));
        }
    });
}

#[test]
fn abilities_that_are_no_numbers_are_refused_before_anything_moves() {
    let device = Emulated::new("");
    let _line = Middle::changing(&device, move |report| {
        Some(match report {
            Report::Capabilities(mut told) => {
                told.force_max_n = f32::NAN;
                Report::Capabilities(told)
            }
            report => report,
        })
    });
    let ended = device.place.run("device info --device serial:line");
    ended.refused(3, &["largest force, N, of NaN", "flash its firmware again"]);
}
