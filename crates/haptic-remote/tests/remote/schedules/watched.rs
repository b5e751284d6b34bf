//! A bench whose force is checked after every step of the clock.

use crate::line::{Bench, STEP_US};
use haptic_emulator::LineFaults;
use haptic_link::{DeviceReport, Limits, Refusal, State};
use haptic_remote::LinkError;

/// What a device does at the moment.
struct Now {
    force_n: f32,
    state: State,
    limits: Limits,
    period_us: u64,
}

impl Now {
    fn of(bench: &Bench) -> Self {
        let device = bench.device.borrow();
        let (configuration, _) = device.configuration();
        let state = device.status().state;
        assert_eq!(state == State::Fault, device.status().fault != 0);
        Self {
            force_n: bench.force_n(),
            state,
            limits: configuration.limits,
            period_us: u64::from(configuration.tick_period_us),
        }
    }

    /// The stop time.
    fn ticks_of_a_fall(&self) -> f64 {
        let ticks = 1e6 * f64::from(self.limits.stop_time_s) / self.period_us as f64;
        (ticks * (1.0 - 1e-6)).ceil().max(1.0)
    }
}

/// A bench that is watched.
pub(super) struct Watched {
    pub(super) bench: Bench,
    pub(super) force_n: f32,
    /// Since when the state is one in which the force falls, and from where, N.
    pub(super) falling: Option<(u64, f32)>,
    /// Since when it is one in which the watchdog looks.
    pub(super) looking_us: Option<u64>,
}

impl Watched {
    pub(super) fn new(seed: u64) -> Self {
        Self {
            bench: Bench::new(LineFaults::default(), seed),
            force_n: 0.0,
            falling: None,
            looking_us: None,
        }
    }

    pub(super) fn step(&mut self) -> Result<Option<Result<DeviceReport, Refusal>>, LinkError> {
        let answer = self.bench.step();
        self.check();
        answer
    }

    fn check(&mut self) {
        let now = Now::of(&self.bench);
        self.check_rate(&now);
        self.check_fall(&now);
        self.check_watchdog(&now);
        self.force_n = now.force_n;
    }

    fn check_rate(&self, now: &Now) {
        let (force_n, limits, period_us) = (now.force_n, &now.limits, now.period_us);
        assert!(force_n.abs() <= limits.force_n, "{force_n} N, {limits:?}");
        let step_n = limits.force_rate_n_per_s * (1e-6 * period_us as f32);
        let moved_n = (force_n - self.force_n).abs();
        let falls = matches!(
            now.state,
            State::Fault | State::Stopping | State::Idle | State::Armed
        ) && force_n.abs() <= self.force_n.abs();
        // To one rounding of the force.
        let rounding_n = f32::EPSILON * force_n.abs().max(self.force_n.abs());
        assert!(
            falls || moved_n <= step_n * (1.0 + 1e-5) + rounding_n,
            "{moved_n} N in a tick, {limits:?}"
        );
        if matches!(now.state, State::Idle | State::Armed) {
            assert_eq!(force_n, 0.0, "{}", now.state);
        }
    }

    /// A force that falls stays below its envelope.
    fn check_fall(&mut self, now: &Now) {
        let (force_n, state, limits) = (now.force_n, now.state, &now.limits);
        let ticks = now.ticks_of_a_fall();
        let now_us = self.bench.now_us;
        if matches!(state, State::Fault | State::Stopping) {
            // A fault takes effect in its own tick, a run that has had its ticks stops after the last.
            let from = if state == State::Fault {
                self.force_n
            } else {
                force_n
            };
            let (since, from_n) = *self.falling.get_or_insert((now_us, from.abs()));
            let done = ((now_us - since) / now.period_us) as f64;
            let share = (1.0 - done / ticks).max(0.0);
            let envelope_n = f64::from(from_n.max(limits.brake_force_n)) * share;
            assert!(
                f64::from(force_n.abs()) <= envelope_n * (1.0 + 1e-6),
                "{force_n} N of {envelope_n} N, {state} for {} us, {limits:?}",
                now_us - since
            );
        } else {
            self.falling = None;
        }
    }

    fn check_watchdog(&mut self, now: &Now) {
        let Now {
            state, period_us, ..
        } = *now;
        let now_us = self.bench.now_us;
        let fall_us = period_us * (1 + now.ticks_of_a_fall() as u64);
        // The watchdog looks once a tick, from the tick after a stop on.
        let watchdog_us = 1000 * u64::from(now.limits.watchdog_ms) + period_us;
        let silent_us = now_us - self.bench.heard_us;
        if matches!(state, State::Armed | State::Running) {
            let since = *self.looking_us.get_or_insert(now_us);
            assert!(
                silent_us <= watchdog_us + STEP_US || now_us - since <= period_us,
                "{state} after {silent_us} us of silence"
            );
        } else {
            self.looking_us = None;
        }
        if silent_us > watchdog_us + fall_us {
            assert_eq!(now.force_n, 0.0, "{state} after {silent_us} us of silence");
        }
    }

    pub(super) fn run_ms(&mut self, milliseconds: u64) {
        for _ in 0..milliseconds * 1000 / STEP_US {
            // A request that nobody waited for may go unanswered.
            let _ = self.step();
        }
    }
}
