//! Frames that a line loses, counted at both ends.

use super::SeedNote;
use crate::line::{Bench, START, spring};
use haptic_emulator::LineFaults;
use haptic_link::{DeviceReport, Request, Sample, Statistics};

/// A session whose line has had these faults for a while.
fn damaged(seed: u64, faults: LineFaults) -> Bench {
    let mut bench = Bench::new(LineFaults::default(), seed);
    bench.hello();
    let (configuration, values) = spring();
    bench.set(configuration, &values).expect("good");
    bench.arm();
    bench.host.set_keep_alive(Some(1_000));
    bench.done(Request::Start(START));
    bench.run_ms(10);
    bench.reports.clear();
    for (faults, milliseconds) in [(faults, 400), (LineFaults::default(), 150)] {
        bench.to_host.set_faults(faults).expect("valid");
        bench.to_device.set_faults(faults).expect("valid");
        bench.run_ms(milliseconds);
    }
    bench
}

/// A line in the middle of a session, its frames counted at both ends.
fn losses(seed: u64, faults: LineFaults) {
    let note = SeedNote(seed);
    let mut bench = damaged(seed, faults);
    // The first good frame after the damage tells of all that are missing before it.
    let DeviceReport::Statistics(device) = bench.done(Request::GetStatistics) else {
        panic!("no statistics");
    };
    bench.run_ms(5);
    let host = bench.host.counters();
    let (to_host, to_device) = (bench.to_host.damage(), bench.to_device.damage());
    for (lost, late, line) in [
        (host.order.lost, host.order.late, to_host),
        (device.lost, device.late, to_device),
    ] {
        let lost = u64::from(lost);
        if faults.corrupt == 0.0 && faults.reorder == 0.0 {
            assert_eq!(lost, line.dropped);
        }
        // A damaged zero takes the next frame along. A late frame was counted as lost before it came.
        let most = line.dropped + 2 * line.corrupted + line.reordered;
        assert!(lost <= most, "{lost} lost, {line:?}");
        assert!(lost >= line.dropped, "{lost} lost, {line:?}");
        assert!(u64::from(late) <= line.reordered + line.duplicated);
    }
    // Nobody but the line loses samples.
    let Statistics {
        samples_dropped, ..
    } = device;
    assert_eq!(samples_dropped, 0);
    let samples: Vec<&Sample> = bench.samples().collect();
    let gaps = samples.windows(2).map(|pair| {
        assert!(pair[1].tick > pair[0].tick);
        u64::from(pair[1].tick - pair[0].tick - 1)
    });
    let gaps: u64 = gaps.sum();
    assert!(
        gaps <= u64::from(host.order.lost),
        "{gaps} > {}",
        host.order.lost
    );
    drop(note);
}

#[test]
fn every_lost_frame_is_counted_at_both_ends() {
    for seed in 0..20 {
        let drop = 0.3 * (seed as f64 / 20.0);
        let only_drops = LineFaults {
            drop,
            ..LineFaults::default()
        };
        losses(seed, only_drops);
        let repeats_and_delays = LineFaults {
            duplicate: 0.2,
            delay_s: 0.01,
            ..only_drops
        };
        losses(seed, repeats_and_delays);
        let all = LineFaults {
            corrupt: 0.1,
            reorder: 0.1,
            stall: 0.01,
            stall_s: 0.02,
            ..repeats_and_delays
        };
        losses(seed, all);
    }
}
