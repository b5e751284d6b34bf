//! The periodic loop: its clock, its settings and its overrun policy.

use super::here::{SPINNING_IS_ONE_IN, SystemWaiter};
use super::system::Waiter;
use super::thread::{RaisedThread, ThreadConfig};
use super::timing::Timing;
use crate::LoopParameterError;
use fracdiff::parameter::RangeError;
use std::time::Duration;

/// Shortest and longest period, s.
const PERIODS_S: core::ops::RangeInclusive<f64> = 1e-5..=1e3;

/// Time before the deadline at which sleeping ends and spinning begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SpinMargin {
    /// Measured on this machine at the start: a quarter of the period at most on Linux, the whole one elsewhere.
    #[default]
    Auto,
    /// This, within the same limit; zero never spins.
    Fixed(Duration),
}

/// The settings of a periodic loop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PeriodicConfig {
    /// T, 10 µs to 1000 s.
    pub period: Duration,
    /// The wishes for the thread.
    pub thread: ThreadConfig,
    /// The part of the waiting that is spinning.
    pub spin_margin: SpinMargin,
}

impl PeriodicConfig {
    /// A normal thread, the margin measured.
    #[must_use]
    pub const fn new(period: Duration) -> Self {
        Self {
            period,
            thread: ThreadConfig {
                priority: None,
                pin: None,
            },
            spin_margin: SpinMargin::Auto,
        }
    }

    /// Itself, if a loop can run by it.
    ///
    /// # Errors
    /// A period outside 10 µs to 1000 s.
    pub fn checked(self) -> Result<Self, LoopParameterError> {
        let period_s = self.period.as_secs_f64();
        if PERIODS_S.contains(&period_s) {
            return Ok(self);
        }
        Err(RangeError::new("period", period_s, "in [1e-5, 1000] {}", "s").into())
    }
}

/// A cycle that has begun.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cycle {
    /// Number of cycles that ran before it.
    pub number: u64,
    /// Time from when it was due to now.
    pub lateness: Duration,
    /// Whole periods that passed since it was due: they have no cycle.
    pub skipped: u64,
}

/// A loop by the clock, in the thread that made it.
#[derive(Debug)]
pub struct Periodic<W = SystemWaiter> {
    waiter: W,
    period_ns: u64,
    margin_ns: u64,
    /// When the next cycle is due; `None` before the first.
    due_ns: Option<u64>,
    number: u64,
    running: Option<Running>,
    timing: Timing,
    thread: RaisedThread,
}

#[derive(Clone, Copy, Debug)]
struct Running {
    number: u64,
    lateness_ns: u64,
    began_ns: u64,
}

impl Periodic {
    /// Raises the calling thread as far as the system allows, and measures the margin: for some 50 periods, 0.1 s at
    /// most. The first cycle is due one period after the first [`wait`](Self::wait) is called.
    ///
    /// # Errors
    /// A period outside 10 µs to 1000 s.
    pub fn new(config: PeriodicConfig) -> Result<Self, LoopParameterError> {
        Self::with_waiter(config, SystemWaiter::default())
    }
}

impl<W: Waiter> Periodic<W> {
    /// Loop like that of [`new`](Periodic::new), with another clock.
    ///
    /// # Errors
    /// A period outside 10 µs to 1000 s.
    pub fn with_waiter(config: PeriodicConfig, mut waiter: W) -> Result<Self, LoopParameterError> {
        let config = config.checked()?;
        // Before the memory is locked, which touches all of it.
        let timing = Timing::default();
        let thread = RaisedThread::new(config.thread);
        let margin = match config.spin_margin {
            SpinMargin::Auto => measure_margin(&mut waiter, config.period),
            SpinMargin::Fixed(margin) => margin,
        };
        Ok(Self {
            waiter,
            period_ns: nanoseconds(config.period),
            margin_ns: nanoseconds(margin.min(config.period / SPINNING_IS_ONE_IN)),
            due_ns: None,
            number: 0,
            running: None,
            timing,
            thread,
        })
    }

    /// Ends the cycle that runs, and waits for the next. A late cycle begins at once; one that is
    /// later than a period skips those that have passed, so that the next is due at t₀ + n·T again.
    pub fn wait(&mut self) -> Cycle {
        let ready_ns = self.end_cycle();
        let due_ns = self.due_ns.unwrap_or(ready_ns + self.period_ns);
        if ready_ns + self.margin_ns < due_ns {
            let until = Duration::from_nanos(due_ns - self.margin_ns);
            self.waiter.sleep_until(until);
        }
        self.waiter.spin_until(Duration::from_nanos(due_ns));
        let began_ns = nanoseconds(self.waiter.now());
        let lateness_ns = began_ns.saturating_sub(due_ns);
        let skipped = lateness_ns / self.period_ns;
        let by_compute = ready_ns >= due_ns + self.period_ns;
        self.timing.begun(lateness_ns, skipped, by_compute);
        self.due_ns = Some(due_ns + (skipped + 1) * self.period_ns);
        let number = self.number;
        self.number += 1;
        self.running = Some(Running {
            number,
            lateness_ns,
            began_ns,
        });
        Cycle {
            number,
            lateness: Duration::from_nanos(lateness_ns),
            skipped,
        }
    }

    /// Ends the cycle that runs, if one does, and says what time it is.
    fn end_cycle(&mut self) -> u64 {
        let now_ns = nanoseconds(self.waiter.now());
        if let Some(running) = self.running.take() {
            let compute_ns = now_ns.saturating_sub(running.began_ns);
            self.timing
                .ended(running.number, running.lateness_ns, compute_ns);
        }
        now_ns
    }

    /// Ends the cycle that runs. When the thread is dropped, it is what it was before.
    pub fn finish(mut self) -> (Timing, RaisedThread) {
        self.end_cycle();
        (self.timing, self.thread)
    }

    /// The thread: what was granted and refused.
    #[must_use]
    pub const fn thread(&self) -> &RaisedThread {
        &self.thread
    }

    /// The part of the waiting that is spinning.
    #[must_use]
    pub const fn spin_margin(&self) -> Duration {
        Duration::from_nanos(self.margin_ns)
    }
}

/// 584 years fit.
fn nanoseconds(time: Duration) -> u64 {
    time.as_nanos() as u64
}

/// Sleeps by which the margin is measured.
const TRIAL_SLEEPS: usize = 50;

/// One and a half times the lateness that 9 of 10 sleeps keep, and 5 µs for the sleep's own cost.
fn measure_margin(waiter: &mut impl Waiter, period: Duration) -> Duration {
    // Long sleeps let a processor doze deeper; the period itself, in the range where it does not take too long.
    let sleep = period.clamp(Duration::from_micros(100), Duration::from_millis(2));
    let mut lateness = [Duration::ZERO; TRIAL_SLEEPS];
    for late in &mut lateness {
        let due = waiter.now() + sleep;
        waiter.sleep_until(due);
        *late = waiter.now().saturating_sub(due);
    }
    lateness.sort_unstable();
    lateness[TRIAL_SLEEPS * 9 / 10] * 3 / 2 + Duration::from_micros(5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::realtime::{Overruns, WorstCycle};
    use std::cell::Cell;
    use std::rc::Rc;
    use std::string::ToString as _;

    const MS: u64 = 1_000_000;

    /// A machine in virtual time, ns: each sleep ends this much late.
    #[derive(Clone, Default)]
    struct Machine {
        now: Rc<Cell<u64>>,
        late: Rc<Cell<u64>>,
        slept: Rc<Cell<u64>>,
    }

    impl Machine {
        /// Somebody computes.
        fn pass(&self, ns: u64) {
            self.now.set(self.now.get() + ns);
        }
    }

    impl Waiter for Machine {
        fn now(&mut self) -> Duration {
            Duration::from_nanos(self.now.get())
        }

        fn sleep_until(&mut self, time: Duration) {
            self.slept.set(self.slept.get() + 1);
            let until = nanoseconds(time) + self.late.get();
            self.now.set(self.now.get().max(until));
        }

        fn spin_until(&mut self, time: Duration) {
            self.now.set(self.now.get().max(nanoseconds(time)));
        }
    }

    /// A loop of 1 ms on a machine that starts at 5 ms, so that the first cycle is due at 6 ms.
    fn millisecond_loop(spin_margin: SpinMargin) -> (Machine, Periodic<Machine>) {
        let machine = Machine::default();
        let config = PeriodicConfig {
            spin_margin,
            ..PeriodicConfig::new(Duration::from_millis(1))
        };
        let periodic = Periodic::with_waiter(config, machine.clone()).expect("a good period");
        machine.now.set(5 * MS);
        machine.slept.set(0);
        (machine, periodic)
    }

    fn without_spinning() -> (Machine, Periodic<Machine>) {
        millisecond_loop(SpinMargin::Fixed(Duration::ZERO))
    }

    #[test]
    fn cycles_keep_their_grid_whatever_lateness_and_compute_are() {
        let (machine, mut periodic) = without_spinning();
        for n in 0..1000 {
            let late = (n * 37_123) % MS;
            machine.late.set(late);
            let cycle = periodic.wait();
            assert_eq!((cycle.number, cycle.skipped), (n, 0));
            assert_eq!(cycle.lateness, Duration::from_nanos(late));
            assert_eq!(machine.now.get(), 6 * MS + n * MS + late);
            machine.pass((MS - late) / 2);
        }
        assert_eq!(periodic.finish().0.overruns, Overruns::default());
    }

    #[test]
    fn what_is_late_skips_whole_periods_keeps_the_phase_and_names_its_cause() {
        // The first cycle is at 6 ms, the next due at 7. Computed, late wake-up, ns; periods skipped, lateness; cycles late by
        // wake-up and by compute; sleeps; end of the third, ms.
        for (computed, late, skipped, lateness, overruns, slept, third) in [
            (0, 3 * MS + 400_000, 3, 3_400_000, [1, 0], 2, 11),
            (0, MS, 1, MS, [1, 0], 2, 9),
            // A late loop does not sleep.
            (2 * MS + 500_000, 0, 1, 1_500_000, [0, 1], 1, 9),
            (MS + 300_000, 0, 0, 300_000, [0, 0], 1, 8),
        ] {
            let (machine, mut periodic) = without_spinning();
            periodic.wait();
            machine.pass(computed);
            machine.late.set(late);
            let cycle = periodic.wait();
            assert_eq!((cycle.number, cycle.skipped), (1, skipped));
            assert_eq!(cycle.lateness, Duration::from_nanos(lateness));
            assert_eq!(machine.slept.get(), slept);
            machine.late.set(0);
            let next = periodic.wait();
            assert_eq!((next.number, next.skipped), (2, 0));
            assert_eq!(machine.now.get(), third * MS);
            assert_eq!(next.lateness, Duration::ZERO);
            let [by_wake_up, by_compute] = overruns;
            let wanted = Overruns {
                by_wake_up,
                by_compute,
                skipped_periods: skipped,
            };
            let seen = periodic.finish().0.overruns;
            assert_eq!((seen, seen.cycles()), (wanted, by_wake_up + by_compute));
        }
    }

    #[test]
    fn every_cycle_is_in_each_histogram_and_the_worst_has_its_number() {
        let (machine, mut periodic) = without_spinning();
        for n in 0..100 {
            machine.late.set(if n == 42 { 700_000 } else { 50_000 });
            periodic.wait();
            machine.pass(if n == 42 { 200_000 } else { 100_000 });
        }
        let (timing, _) = periodic.finish();
        for histogram in [&timing.lateness_ns, &timing.compute_ns, &timing.tick_ns] {
            assert_eq!(histogram.len(), 100);
        }
        let worst = WorstCycle {
            number: 42,
            lateness: Duration::from_micros(700),
            compute: Duration::from_micros(200),
        };
        assert_eq!(timing.worst, Some(worst));
        assert_eq!(timing.tick_ns.max(), 900_000);
        assert_eq!(timing.compute_ns.max(), 200_000);
        assert_eq!(timing.lateness_ns.max(), 700_000);
    }

    #[test]
    fn a_margin_absorbs_the_lateness_of_the_sleep() {
        let (machine, mut periodic) =
            millisecond_loop(SpinMargin::Fixed(Duration::from_micros(60)));
        machine.late.set(59_000);
        for _ in 0..10 {
            assert_eq!(periodic.wait().lateness, Duration::ZERO);
        }
        machine.late.set(61_000);
        assert_eq!(periodic.wait().lateness, Duration::from_micros(1));
    }

    #[test]
    fn a_measured_margin_is_one_and_a_half_times_the_lateness() {
        let machine = Machine::default();
        machine.late.set(40_000);
        let config = PeriodicConfig::new(Duration::from_millis(1));
        let periodic = Periodic::with_waiter(config, machine.clone()).expect("a good period");
        assert_eq!(periodic.spin_margin(), Duration::from_micros(65));
        // A part of the period at most, however late the machine is.
        machine.late.set(5 * MS);
        let periodic = Periodic::with_waiter(config, machine).expect("a good period");
        let most = if cfg!(target_os = "linux") { 250 } else { 1000 };
        assert_eq!(periodic.spin_margin(), Duration::from_micros(most));
    }

    #[test]
    fn a_period_outside_the_range_is_refused() {
        for period in [
            Duration::ZERO,
            Duration::from_micros(9),
            Duration::from_secs(1001),
        ] {
            let refused = Periodic::new(PeriodicConfig::new(period));
            let text = refused.expect_err("refused").to_string();
            assert!(text.contains("[1e-5, 1000] s"), "{text}");
        }
    }
}
