//! Calls of the program that are late, early, too many, and wrong.

use crate::bench::{Bench, TICK_US, description};
use haptic_bridge::{Description, Reason, Trouble};
use haptic_link::{DeviceReport, EventKind, Request, Sample};
use haptic_loop::Fault;

/// Forces on the device in a tick of trouble are none at once, and stay none.
fn is_at_rest_at_once(bench: &mut Bench, trouble: Trouble) {
    assert_eq!(bench.force_n, [0.0; 3]);
    assert_eq!(bench.handle.fault(), Some(Fault::BoardFailed));
    assert_eq!(bench.handle.reason(), Some(Reason::of(trouble)));
    for _ in 0..50 {
        bench.step();
        assert_eq!(bench.force_n, [0.0; 3]);
    }
    // The host hears of it, and the device can be armed again.
    bench.told_of(Fault::BoardFailed, Reason::of(trouble));
    bench.arm();
    assert_eq!((bench.handle.fault(), bench.handle.reason()), (None, None));
    bench.start();
}

#[test]
fn a_position_that_is_no_number_leaves_no_force_at_once() {
    for (axes, bad) in [
        (1, f64::NAN),
        (2, f64::INFINITY),
        (3, -1e300),
        (3, f64::NAN),
    ] {
        let mut bench = Bench::running(&description(axes));
        bench.position_m[axes as usize - 1] = bad;
        bench.tick();
        bench.position_m = [0.01; 3];
        is_at_rest_at_once(&mut bench, Trouble::Position);
    }
}

#[test]
fn axes_that_a_device_does_not_have_are_not_looked_at() {
    let mut bench = Bench::running(&description(1));
    (bench.position_m[1], bench.position_m[2]) = (f64::NAN, f64::INFINITY);
    bench.steps(10);
    assert_eq!(bench.handle.fault(), None);
    assert!(bench.force_n[0] < -0.5, "{:?}", bench.force_n);
    assert_eq!(bench.force_n[1..], [0.0; 2]);
}

/// One reading is for one tick: a program that ceases to give them has a sensor without a reading, never one that stands still.
#[test]
fn a_sensed_force_is_in_the_sample_of_its_tick_and_in_no_other() {
    for axes in 1..=3 {
        let mut bench = Bench::running(&description(axes));
        bench.steps(20);
        let samples = |bench: &Bench| -> Vec<Sample> {
            let samples = bench.reports.iter().filter_map(|report| {
                let DeviceReport::Sample(sample) = report else {
                    return None;
                };
                Some(sample.clone())
            });
            samples.collect()
        };
        let before = samples(&bench);
        assert!(before.iter().all(|sample| sample.sensed_force_n.is_empty()));
        bench.reports.clear();
        let given: Vec<Vec<f32>> = (0..50_u8)
            .map(|n| {
                let force_n = [0.1 * f64::from(n), -2.0, 1e-3];
                let gives = n % 5 != 0;
                if gives {
                    bench.ticker.sense(&force_n);
                }
                bench.step();
                let single = force_n.map(|axis| axis as f32);
                single[..if gives { axes as usize } else { 0 }].to_vec()
            })
            .collect();
        let sent = samples(&bench);
        assert!(sent.len() > 45, "{}", sent.len());
        let first = before.last().expect("samples").tick + 1;
        for sample in sent {
            let sensed = sample.sensed_force_n.to_vec();
            assert_eq!(
                sensed,
                given[(sample.tick - first) as usize],
                "{}",
                sample.tick
            );
        }
    }
}

#[test]
fn a_time_that_stands_or_goes_back_leaves_no_force_at_once() {
    for back_us in [0, 1, 5_000_000] {
        let mut bench = Bench::running(&description(3));
        bench.time_us -= back_us.min(bench.time_us);
        bench.tick_after(0);
        is_at_rest_at_once(&mut bench, Trouble::Time);
        // The watchdog is that of the device, not of a clock that was set back.
        bench.is_there = false;
        bench.falls(Fault::HostSilent, 52);
    }
}

#[test]
fn a_call_without_a_position_leaves_no_force_at_once() {
    let mut bench = Bench::running(&description(2));
    bench.time_us += TICK_US;
    bench.force_n = bench.ticker.tick(bench.time_us, None);
    is_at_rest_at_once(&mut bench, Trouble::Missing);
}

#[test]
fn a_haptic_thread_that_stood_still_gets_no_old_force() {
    let mut bench = Bench::running(&description(3));
    bench.tick_after(60_000);
    assert_eq!(bench.force_n, [0.0; 3]);
    assert_eq!(bench.handle.fault(), Some(Fault::HostSilent));
    // A time far in the future is no more than that.
    let mut bench = Bench::running(&description(3));
    bench.tick_after(u64::MAX - 10_000_000);
    assert_eq!(bench.force_n, [0.0; 3]);
}

#[test]
fn outside_its_workspace_there_is_no_force_and_no_arming() {
    let mut bench = Bench::running(&description(2));
    bench.position_m[1] = 0.11;
    bench.tick();
    assert_eq!(bench.force_n, [0.0; 3]);
    assert_eq!(bench.handle.fault(), Some(Fault::Workspace));
    bench.steps(20);
    bench
        .answered(Request::Arm { faults: 1 })
        .expect_err("it is outside");
    bench.position_m[1] = 0.0;
    bench.step();
    bench.arm();
    bench.start();
}

/// Ticks of the loop that so many calls make, this far apart, µs.
fn ticks(calls: u32, apart_us: impl Fn(u32) -> u64) -> (u32, u32) {
    let mut bench = Bench::armed(&description(1));
    let before = bench.statistics();
    for call in 0..calls {
        bench.apart_us = apart_us(call);
        bench.step();
        bench.apart_us = TICK_US;
    }
    let passed = bench.statistics().since(&before);
    (passed.ticks, passed.overruns)
}

#[test]
fn calls_at_the_sample_time_are_a_tick_each_whatever_their_jitter_and_clock() {
    // The question itself takes a tick or two.
    let about = |ticks: (u32, u32), wanted: u32| {
        assert!(
            (wanted..=wanted + 3).contains(&ticks.0),
            "{ticks:?}, not {wanted}"
        );
        assert_eq!(ticks.1, 0);
    };
    about(ticks(2000, |_| 1000), 2000);
    about(
        ticks(2000, |call| if call % 2 == 0 { 1400 } else { 600 }),
        2000,
    );
    about(ticks(2000, |_| 1001), 2000);
    // A clock that is one in a thousand too fast has one call too many.
    about(ticks(2000, |_| 999), 1998);
    // Called more often, the calls in between hold.
    about(ticks(8000, |_| 250), 2000);
    about(ticks(3000, |_| 700), 2100);
}

#[test]
fn between_ticks_the_force_is_held() {
    let mut bench = Bench::running(&description(3));
    let held = bench.force_n;
    bench.position_m = [0.0101; 3];
    for _ in 0..4 {
        bench.tick_after(100);
        assert_eq!(bench.force_n, held);
    }
    bench.tick_after(600);
    assert_ne!(bench.force_n, held);
}

/// Each is found in the call that sees it, and no force comes back, wherever the next calls are.
#[test]
fn between_ticks_a_place_beyond_a_limit_leaves_no_force_at_once() {
    for (what, at_m, fault) in [
        (
            "outside the workspace of the program",
            0.11,
            Fault::Workspace,
        ),
        ("outside that of the host", 0.0105, Fault::Workspace),
        ("a jump", 0.0099 - 0.0028, Fault::PositionJump),
        ("no number", f64::NAN, Fault::BoardFailed),
        ("infinite", f64::NEG_INFINITY, Fault::BoardFailed),
    ] {
        for axes in 1..=3 {
            let mut bench = Bench::new(&description(axes));
            let (mut configuration, values) = crate::bench::wall();
            let limits = &mut configuration.limits;
            (limits.workspace_low_m, limits.workspace_high_m) = (-0.1, 0.0102);
            bench.configure(&configuration, &values);
            bench.arm();
            bench.start();
            bench.tick_after(200);
            assert!(
                bench.norm_n() > 0.5 && bench.handle.fault().is_none(),
                "{what}"
            );
            bench.position_m[axes as usize - 1] = at_m;
            bench.tick_after(200);
            assert_eq!(
                (bench.force_n, bench.handle.fault()),
                ([0.0; 3], Some(fault)),
                "{what}"
            );
            bench.position_m = [0.01; 3];
            for _ in 0..200 {
                bench.tick_after(200);
                assert_eq!(bench.force_n, [0.0; 3], "{what}");
            }
            assert_eq!(bench.allocations, 0);
        }
    }
}

#[test]
fn other_sample_times_are_refused_and_their_own_is_kept() {
    let slow = Description {
        sample_time_us: 2000,
        ..description(1)
    };
    let mut bench = Bench::new(&slow);
    bench.done(Request::Hello { nonce: 1 });
    let (configuration, values) = crate::bench::wall();
    let mut answers = crate::bench::transaction(&configuration, &values).into_iter();
    let refused = answers.find_map(|request| bench.answered(request).err());
    assert!(format!("{refused:?}").contains("TickPeriod"), "{refused:?}");
}

#[test]
fn a_stop_brings_the_force_to_zero_and_disarms() {
    let mut bench = Bench::running(&description(3));
    bench.handle.stop();
    bench.fades();
    assert_eq!(bench.handle.fault(), None);
    let withdrawn = |report: &DeviceReport| matches!(report, DeviceReport::Event(event) if event.kind == EventKind::Withdrawn);
    assert_eq!(
        bench
            .reports
            .iter()
            .filter(|report| withdrawn(report))
            .count(),
        1
    );
    bench
        .answered(Request::Start(haptic_link::Start::ENDLESS))
        .expect_err("disarmed");
    bench.arm();
    bench.start();
}
