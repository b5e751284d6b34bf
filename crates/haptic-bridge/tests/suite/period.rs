//! The time of the haptic thread as it is and as it was declared: a force that depends on a rate is right, or there is a fault.

use crate::bench::{Bench, TICK_US, description, wall};
use haptic_bridge::{Description, Reason, Trouble};
use haptic_link::{
    Configuration, DeviceReport, Limits, OperatorForm, OperatorShape, Request, Start,
};
use haptic_loop::{Fault, realtime::Waiter};
use std::time::Duration;
use testkit::Random;

/// v, m/s.
const SPEED: f64 = 0.01;

/// A one-sided damper of 10 N·s/m at 1 kHz: 0.1 N at 10 mm/s, whoever calls.
fn damper() -> (Configuration, Vec<f32>) {
    let (wall, _) = wall();
    let operator = OperatorShape {
        form: OperatorForm::Taps,
        integer: 0,
        count: 2,
    };
    let limits = Limits {
        force_n: 2.0,
        watchdog_ms: 200,
        ..wall.limits
    };
    let configuration = Configuration {
        stiffness_n_per_m: 0.001,
        dissipation_n_s_mu_per_m: 10.0,
        one_sided: true,
        operator,
        limits,
        ..wall
    };
    (configuration, vec![1000.0, -1000.0])
}

impl Bench {
    /// The damper of this device is armed, which calls so far apart, µs.
    fn damped(apart_us: u64) -> Self {
        let mut bench = Self::new(&description(1));
        let (configuration, values) = damper();
        bench.configure(&configuration, &values);
        bench.apart_us = apart_us;
        bench
    }

    /// It has pushed a hand that moves at v for a while.
    fn pushing() -> Self {
        let mut bench = Self::damped(TICK_US);
        bench.arm();
        bench.done(Request::Start(Start::ENDLESS));
        for _ in 0..200 {
            bench.moves(TICK_US);
        }
        bench
    }

    /// The next call of that hand.
    fn moves(&mut self, apart_us: u64) -> f64 {
        self.apart_us = apart_us;
        self.position_m[0] += 1e-6 * SPEED * apart_us as f64;
        self.step();
        -self.force_n[0]
    }

    fn slow(&self) -> Option<Reason> {
        let reason = self.handle.reason();
        assert_eq!(self.handle.fault(), reason.map(|_| Fault::TickOverrun));
        reason.inspect(|reason| assert_eq!((reason.trouble, reason.told_us), (Trouble::Slow, 1000)))
    }
}

#[test]
fn a_damper_is_what_it_was_declared_or_there_is_a_fault() {
    // Of a thread that becomes slow in a run: the largest force before the fault, N, and the time of that, s.
    // A position in single precision is off by 4 nm at 50 mm, which is 0.04 mN each way.
    for (apart_us, most_n, within_s) in [
        (1000, 0.1005, f64::INFINITY),
        (1060, 0.1065, 0.4),
        (1100, 0.1105, 0.4),
        (1400, 0.1405, 0.4),
        (1900, 0.1005, 0.4),
        (2500, 0.1255, 0.1),
        (3000, 0.1005, 0.1),
    ] {
        let mut bench = Bench::pushing();
        let mut passed_s = 0.0;
        while passed_s < 5.0 && bench.slow().is_none() {
            let force_n = bench.moves(apart_us);
            passed_s += 1e-6 * apart_us as f64;
            let good = (0.094..most_n).contains(&force_n);
            let falls = bench.slow().is_some() && force_n < most_n;
            assert!(good || falls, "{apart_us} µs: {force_n} N");
        }
        match bench.slow() {
            None => assert_eq!(apart_us, 1000),
            Some(reason) => {
                assert!(passed_s <= within_s, "{apart_us} µs: {passed_s} s");
                // Of a window that may have begun before.
                let measured_us = u64::from(reason.measured_us);
                assert!((1050..=apart_us).contains(&measured_us), "{reason}");
                bench.fades_by(|bench| {
                    bench.moves(apart_us);
                });
            }
        }
        assert_eq!(bench.allocations, 0);
    }
}

#[test]
fn a_thread_that_was_slow_before_is_a_fault_with_both_numbers_before_any_force() {
    for apart_us in [1060, 1100, 1400, 1900, 3000] {
        let mut bench = Bench::damped(apart_us);
        bench.steps(3000);
        // Nobody relies on it yet.
        assert_eq!(bench.handle.fault(), None);
        bench.arm();
        bench.step();
        let reason = bench.slow().expect("it is slow");
        let words = format!(
            "calls of hb_tick were {apart_us} µs apart, and 1000 µs were declared: call hb_wait before each, or declare the true sample_time_us"
        );
        assert_eq!(reason.to_string(), words);
        bench.steps(20);
        bench.told_of(Fault::TickOverrun, reason);
        assert_eq!(bench.force_n, [0.0; 3]);
    }
}

#[test]
fn jitter_pauses_and_calls_in_between_are_no_slowness_and_two_percent_are() {
    type Schedule = Box<dyn FnMut(u64) -> u64>;
    let (mut random, mut early_us) = (Random(65), 0);
    let cases: [(&str, bool, Schedule); 6] = [
        ("called at the declared time", false, Box::new(|_| 1000)),
        (
            "jitter of 0.3 ms",
            false,
            Box::new(move |_| {
                let late_us = random.bits() % 601;
                let apart_us = 1000 + late_us - early_us;
                early_us = late_us;
                apart_us
            }),
        ),
        (
            "a pause of 3 ms twice a second",
            false,
            Box::new(|call| if call % 498 == 0 { 3000 } else { 1000 }),
        ),
        ("one and a half percent slow", false, Box::new(|_| 1015)),
        ("at 4 kHz", false, Box::new(|_| 250)),
        ("three percent slow", true, Box::new(|_| 1030)),
    ];
    for (what, is_slow, mut apart_us) in cases {
        let mut bench = Bench::damped(TICK_US);
        bench.arm();
        for call in 0..30_000 {
            bench.apart_us = apart_us(call);
            bench.step();
        }
        assert_eq!(
            bench.slow().is_some(),
            is_slow,
            "{what}: {:?}",
            bench.slow()
        );
    }
}

#[test]
fn twenty_missed_samples_go_on_and_more_are_a_fault() {
    for (missed, fault) in [(20, None), (21, Some(Fault::TickOverrun))] {
        let mut bench = Bench::pushing();
        let force_n = bench.moves(TICK_US * (missed + 1));
        assert!(force_n <= 0.1005, "{force_n} N");
        assert_eq!(bench.handle.fault(), fault, "{missed}");
        if fault.is_some() {
            assert_eq!(bench.slow().map(|slow| slow.measured_us), Some(22_000));
        }
    }
}

/// T, µs, as the device tells it: declared, and measured in ns.
fn periods(bench: &mut Bench) -> (u32, u32) {
    let DeviceReport::Capabilities(can) = bench.done(Request::GetCapabilities) else {
        panic!("no capabilities");
    };
    let statistics = bench.statistics();
    assert_eq!(can.tick_period_min_us, can.tick_period_max_us);
    assert!(!can.lets_go_alone.lets_go);
    (can.tick_period_min_us, statistics.period_ns)
}

#[test]
fn a_sample_time_of_zero_is_the_mean_of_the_first_second() {
    let unknown = Description {
        sample_time_us: 0,
        ..description(2)
    };
    for (apart_us, declared_us) in [(1250, 1250), (40, 100), (1003, 1003)] {
        let mut bench = Bench::new(&unknown);
        bench.apart_us = apart_us;
        let calls = 1_000_000 / apart_us;
        for call in 0..=calls {
            bench.position_m = [0.0, if call == 7 { f64::NAN } else { 0.0 }, 0.0];
            bench.tick();
            assert_eq!((bench.force_n, bench.handle.fault()), ([0.0; 3], None));
        }
        assert_eq!(bench.allocations, 0);
        bench.done(Request::Hello { nonce: 1 });
        bench.steps(3 * calls as u32);
        let (declared, measured_ns) = periods(&mut bench);
        assert_eq!(u64::from(declared), declared_us);
        assert_eq!(u64::from(measured_ns).div_ceil(1000), declared_us);
        let (mut configuration, values) = damper();
        configuration.tick_period_us = declared;
        bench.configure(&configuration, &values);
        bench.arm();
        bench.done(Request::Start(Start::ENDLESS));
    }
}

/// A clock whose sleepers wake late.
struct Late {
    now: Duration,
    random: Random,
}

impl Waiter for Late {
    fn now(&mut self) -> Duration {
        self.now
    }

    fn sleep_until(&mut self, time: Duration) {
        let late = Duration::from_micros(self.random.bits() % 400);
        self.now = self.now.max(time + late);
    }
}

#[test]
fn a_thread_that_waits_runs_at_what_it_declared_and_makes_up_for_nothing() {
    let mut bench = Bench::new(&description(1));
    let mut late = Late {
        now: Duration::from_secs(1),
        random: Random(7),
    };
    let first_us = bench.ticker.wait_by(&mut late);
    for call in 1..=20_000 {
        // Its own work takes a part of the time.
        late.now += Duration::from_micros(350);
        let time_us = bench.ticker.wait_by(&mut late);
        let off_us = time_us as i64 - (first_us + 1000 * call) as i64;
        assert!(off_us.abs() < 400, "{call}: {off_us} µs");
    }
    let stopped_us = late.now.as_micros() as u64;
    late.now += Duration::from_micros(5500);
    let mut woke_us: Vec<u64> = (0..3).map(|_| bench.ticker.wait_by(&mut late)).collect();
    assert!(woke_us[0] - stopped_us < 6000);
    woke_us.rotate_left(1);
    assert!(woke_us[1] > woke_us[0] + 500, "{woke_us:?}");
}

#[test]
fn a_time_in_milliseconds_is_named_and_leaves_no_force() {
    let mut bench = Bench::running(&description(1));
    let mut clock_us = 0;
    // Calls that are 1 ms apart, and are said to be this far apart, µs.
    let mut calls = |bench: &mut Bench, calls: u32, said_us: u64| {
        for _ in 0..calls {
            clock_us += 1000;
            bench.line.watch(clock_us);
            bench.tick_after(said_us);
        }
    };
    calls(&mut bench, 760, 1);
    assert_eq!(
        (bench.force_n, bench.handle.fault()),
        ([0.0; 3], Some(Fault::BoardFailed))
    );
    let reason = bench.handle.reason().expect("a reason").to_string();
    let words = "the time given to hb_tick went on by 250 in 250000 µs: give it in microseconds";
    assert!(reason.starts_with(words), "{reason}");
    // Arming it again changes nothing, until the time is right.
    bench.apart_us = 1;
    bench.arm();
    calls(&mut bench, 1, 1);
    assert_eq!(bench.handle.fault(), Some(Fault::BoardFailed));
    calls(&mut bench, 600, 1000);
    bench.apart_us = TICK_US;
    bench.arm();
    bench.start();
}
