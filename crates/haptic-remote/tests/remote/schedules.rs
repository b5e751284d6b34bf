//! Random schedules: lines that lose, damage, repeat, reorder, delay and hold back what is said, hosts that die
//! and come back, devices that reboot, requests in any state. What must hold is checked after every step of the
//! clock.
//!
//! `SCHEDULES`, or `CAMPAIGN_CASES` as everywhere, sets how many are run, `SCHEDULE` the one of a number: a failure tells it. 100 000 are 22 h of
//! virtual time and take a minute of two processors.

mod losses;

use crate::line::{Bench, START, STEP_US, spring};
use haptic_link::{Configuration, Field, LoopMode, Refusal, Report, Request, Scope, Start, State};
use haptic_loop::Fault;
use haptic_remote::{LineFaults, LinkError};
use rand_distr::{Distribution as _, StandardUniform};
use rand_pcg::Pcg32;
use std::sync::atomic::{AtomicU64, Ordering};

/// From position, m, to force, N.
type Law = fn(f32) -> f32;

struct Random(Pcg32);

impl Random {
    fn new(seed: u64) -> Self {
        Self(Pcg32::new(seed, 0x5851_f42d_4c95_7f2d))
    }

    fn chance(&mut self) -> f64 {
        StandardUniform.sample(&mut self.0)
    }

    /// Below `end`.
    fn below(&mut self, end: u32) -> u32 {
        let drawn: u32 = StandardUniform.sample(&mut self.0);
        drawn % end
    }

    fn one_in(&mut self, n: u32) -> bool {
        self.below(n) == 0
    }

    fn of<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.below(list.len() as u32) as usize]
    }

    fn faults(&mut self) -> LineFaults {
        let mut some = |most: f64| {
            if self.one_in(2) {
                most * self.chance()
            } else {
                0.0
            }
        };
        LineFaults {
            drop: some(0.5),
            corrupt: some(0.5),
            duplicate: some(0.3),
            reorder: some(0.3),
            delay_s: some(0.03),
            stall: some(0.02),
            stall_s: some(0.1),
        }
    }

    fn configuration(&mut self) -> (Configuration, [f32; 2]) {
        let (mut configuration, values) = spring();
        configuration.loop_mode = self.of(&[LoopMode::Device, LoopMode::Host]);
        configuration.tick_period_us = self.of(&[500, 1000, 1000, 2000]);
        configuration.stiffness_n_per_m = self.of(&[0.0, 300.0, 3000.0]);
        configuration.simulation.push_n = self.of(&[0.0, 1.0, -3.0]);
        configuration.limits.force_n = self.of(&[0.5, 2.0, 10.0]);
        configuration.limits.force_rate_n_per_s = self.of(&[0.1, 300.0, 1000.0, 10_000.0]);
        configuration.limits.stop_time_s = self.of(&[0.001, 0.03, 0.1, 0.25]);
        configuration.limits.brake_force_n = self.of(&[0.0, 2.0, 10.0]);
        configuration.limits.braking_n_s_per_m = self.of(&[0.0, 0.5, 5.0]);
        if self.one_in(2) {
            // The most that 65 g bear with a tick of delay, for the longest tick here.
            configuration.limits.device_mass_kg = 0.065;
            configuration.limits.braking_n_s_per_m = 10.8;
        }
        configuration.limits.stuck_force_n = self.of(&[0.0, 0.2, 3.0]);
        configuration.limits.jump_m = self.of(&[0.0, 1e-3]);
        configuration.limits.watchdog_ms = self.of(&[5, 20, 50]);
        configuration.limits.late_ticks = self.of(&[0, 1, 20]);
        configuration.limits.max_age_ticks = self.of(&[1, 10, 1000]);
        if self.one_in(8) {
            configuration.surface_m = f32::NAN;
        }
        (configuration, values)
    }

    fn request(&mut self, faults: u16) -> Request {
        match self.below(16) {
            0 => Request::Hello {
                nonce: self.below(3),
            },
            1 => Request::GetCapabilities,
            2 => Request::Commit {
                digest: 1,
                scope: self.of(&[Scope::Run, Scope::Lasting]),
            },
            3 => Request::GetConfiguration,
            4 => Request::GetCoefficients {
                offset: self.of(&[0, 1, 16]),
            },
            5..=7 => Request::Arm {
                faults: faults.wrapping_sub(u16::from(self.one_in(8))),
            },
            8 => Request::Disarm,
            9..=11 => Request::Start(Start {
                run: self.below(3),
                ticks: self.of(&[0, 0, 1, 30]),
                every: self.of(&[1, 1, 3, 0]),
                batch: self.of(&[1, 1, 5, 17]),
            }),
            12 => Request::Stop,
            13 => Request::GetStatistics,
            14 => Request::ReadFlight {
                index: self.of(&[0, 95, 96]),
            },
            _ => Request::Stream {
                every: self.of(&[0, 1, 2]),
                batch: self.of(&[0, 1, 16]),
            },
        }
    }
}

/// A bench that is watched.
struct Watched {
    bench: Bench,
    force_n: f32,
    /// Since when the state is one in which the force falls, and from where, N.
    falling: Option<(u64, f32)>,
    /// Since when it is one in which the watchdog looks.
    looking_us: Option<u64>,
}

impl Watched {
    fn new(seed: u64) -> Self {
        Self {
            bench: Bench::new(LineFaults::default(), seed),
            force_n: 0.0,
            falling: None,
            looking_us: None,
        }
    }

    fn step(&mut self) -> Result<Option<Result<Report, Refusal>>, LinkError> {
        let answer = self.bench.step();
        self.check();
        answer
    }

    fn check(&mut self) {
        let force_n = self.bench.force_n();
        let device = self.bench.device.borrow();
        let (configuration, _) = device.configuration();
        let (limits, state) = (&configuration.limits, device.status().state);
        let period_us = u64::from(configuration.tick_period_us);
        assert!(force_n.abs() <= limits.force_n, "{force_n} N, {limits:?}");
        let step_n = limits.force_rate_n_per_s * (1e-6 * period_us as f32);
        let moved_n = (force_n - self.force_n).abs();
        let falls = matches!(
            state,
            State::Fault | State::Stopping | State::Idle | State::Armed
        ) && force_n.abs() <= self.force_n.abs();
        // To one rounding of the force.
        let rounding_n = f32::EPSILON * force_n.abs().max(self.force_n.abs());
        assert!(
            falls || moved_n <= step_n * (1.0 + 1e-5) + rounding_n,
            "{moved_n} N in a tick, {limits:?}"
        );
        if matches!(state, State::Idle | State::Armed) {
            assert_eq!(force_n, 0.0, "{state}");
        }
        // The stop time, and a tick until the first step.
        let ticks = 1e6 * f64::from(limits.stop_time_s) / period_us as f64;
        let ticks = (ticks * (1.0 - 1e-6)).ceil().max(1.0);
        let fall_us = period_us * (1 + ticks as u64);
        let now_us = self.bench.now_us;
        if matches!(state, State::Fault | State::Stopping) {
            // A fault takes effect in its own tick, a run that has had its ticks stops after the last.
            let from = if state == State::Fault {
                self.force_n
            } else {
                force_n
            };
            let (since, from_n) = *self.falling.get_or_insert((now_us, from.abs()));
            let done = ((now_us - since) / period_us) as f64;
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
        // The watchdog looks once a tick, from the tick after a stop on.
        let watchdog_us = 1000 * u64::from(limits.watchdog_ms) + period_us;
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
            assert_eq!(force_n, 0.0, "{state} after {silent_us} us of silence");
        }
        assert_eq!(state == State::Fault, device.status().fault != 0);
        drop(device);
        self.force_n = force_n;
    }

    fn run_ms(&mut self, milliseconds: u64) {
        for _ in 0..milliseconds * 1000 / STEP_US {
            // A request that nobody waited for may go unanswered.
            let _ = self.step();
        }
    }

    /// Asks; the answer, a refusal or the error has to come in time.
    fn ask(&mut self, request: Request) -> Result<Result<Report, Refusal>, LinkError> {
        let bench = &mut self.bench;
        let mut line = [0; haptic_link::FRAME_MAX];
        let length = bench.host.ask(request.clone(), bench.now_us, &mut line);
        bench.to_device.send(&line[..length], bench.now_us);
        // Ten tries of 50 ms.
        for _ in 0..=10 * 50_000 / STEP_US {
            if let Some(answer) = self.step()? {
                return Ok(answer);
            }
        }
        panic!("\"{}\" does not end", request.name());
    }

    fn configure(&mut self, random: &mut Random) {
        let (configuration, values) = random.configuration();
        for request in crate::line::transaction(configuration, &values) {
            if !matches!(self.ask(request), Ok(Ok(_))) {
                return;
            }
        }
        let digest = haptic_link::DigestBuilder::new(&configuration).coefficients(&values);
        let digest = digest.finish();
        let scope = random.of(&[Scope::Run, Scope::Lasting]);
        if let Ok(Err(refusal)) = self.ask(Request::Commit { digest, scope }) {
            let named = matches!(
                refusal,
                Refusal::Range {
                    field: Field::Surface,
                    ..
                }
            );
            // What was staged by an answer that came late, or lost with a reboot, is no longer this.
            let unlike = matches!(
                refusal,
                Refusal::State(_)
                    | Refusal::ForceNotZero
                    | Refusal::Incomplete
                    | Refusal::Digest
                    | Refusal::Connection
            ) || (scope == Scope::Run && matches!(refusal, Refusal::Looser(_)));
            assert!(named || unlike, "{refusal:?}");
        }
    }

    fn act(&mut self, random: &mut Random) {
        match random.below(26) {
            24 => {
                let offset_m = random.of(&[0.0, 0.0, 0.005, -0.02]);
                self.bench.device.borrow_mut().hardware_mut().offset_m = offset_m;
            }
            25 => {
                let mut device = self.bench.device.borrow_mut();
                let sticks = &mut device.hardware_mut().sticks;
                *sticks = !*sticks;
            }
            0 => {
                let faults = random.faults();
                self.bench.to_device.set_faults(faults).expect("valid");
            }
            1 => {
                let faults = random.faults();
                self.bench.to_host.set_faults(faults).expect("valid");
            }
            2 => {
                let quiet = LineFaults::default();
                self.bench.to_device.set_faults(quiet).expect("valid");
                self.bench.to_host.set_faults(quiet).expect("valid");
            }
            3 | 4 => {
                self.bench.host_dead = true;
                self.run_ms(u64::from(random.below(100)));
                self.bench.host_dead = false;
            }
            5 => {
                self.bench.reboot();
                self.force_n = 0.0;
                (self.falling, self.looking_us) = (None, None);
            }
            6 => self.bench.device.borrow_mut().overrun(),
            7 => {
                let fault = random.of(&[Fault::EmergencyStop, Fault::CurrentMismatch]);
                self.bench.device.borrow_mut().trip(fault);
            }
            8 => {
                let interval = random.of(&[None, Some(1_000), Some(4_000), Some(30_000)]);
                self.bench.host.set_keep_alive(interval);
            }
            9 => {
                let laws: [Option<Law>; 4] = [
                    None,
                    Some(|x| -500.0 * x),
                    Some(|x| 1e6 * x + 1.0),
                    Some(|_| f32::NAN),
                ];
                self.bench.law = random.of(&laws);
            }
            10..=12 => self.configure(random),
            13 => {
                // A whole session at once, so that runs do come about.
                let faults = self.bench.device.borrow().status().faults;
                self.bench.host.set_keep_alive(Some(2_000));
                let _ = self.ask(Request::Arm { faults });
                let _ = self.ask(Request::Start(START));
                self.run_ms(30);
            }
            _ => {
                let faults = self.bench.device.borrow().status().faults;
                let _ = self.ask(random.request(faults));
            }
        }
        self.run_ms(u64::from(random.below(15)));
    }

    /// After anything whatever, a good line and a host that keeps to the protocol get a run.
    fn recovers(&mut self) {
        let quiet = LineFaults::default();
        self.bench.to_device.set_faults(quiet).expect("valid");
        self.bench.to_host.set_faults(quiet).expect("valid");
        self.bench.law = None;
        let mut device = self.bench.device.borrow_mut();
        (device.hardware_mut().sticks, device.hardware_mut().offset_m) = (false, 0.0);
        drop(device);
        self.bench.host.set_keep_alive(Some(2_000));
        // What was held back comes now.
        self.run_ms(120);
        self.greet();
        self.done(Request::Disarm);
        // The longest stop time.
        self.run_ms(300);
        let (configuration, values) = spring();
        for request in crate::line::transaction(configuration, &values) {
            self.done(request);
        }
        let digest = haptic_link::DigestBuilder::new(&configuration).coefficients(&values);
        let digest = digest.finish();
        let scope = Scope::Lasting;
        self.done(Request::Commit { digest, scope });
        let faults = self.greet();
        self.done(Request::Arm { faults });
        self.bench.told.clear();
        self.done(Request::Start(Start { run: 99, ..START }));
        self.run_ms(20);
        assert_eq!(self.bench.state(), State::Running);
        let ticks = self.bench.ticks();
        assert!(ticks.len() >= 15 && ticks.windows(2).all(|pair| pair[1] == pair[0] + 1));
    }

    /// Connects anew; the number of faults.
    fn greet(&mut self) -> u16 {
        let greeting = self.bench.greeting();
        match self.done(greeting) {
            Report::Hello(hello) => hello.status.faults,
            other => panic!("not a hello: {other:?}"),
        }
    }

    fn done(&mut self, request: Request) -> Report {
        let name = request.name();
        match self.ask(request) {
            Ok(Ok(report)) => report,
            other => panic!("{name} on a good line: {other:?}"),
        }
    }
}

/// Tells which schedule it was.
struct Told(u64);

impl Drop for Told {
    fn drop(&mut self) {
        if std::thread::panicking() {
            eprintln!("SCHEDULE={}", self.0);
        }
    }
}

fn schedule(seed: u64) -> u64 {
    let told = Told(seed);
    let mut random = Random::new(seed);
    let mut watched = Watched::new(seed);
    for _ in 0..10 + random.below(20) {
        watched.act(&mut random);
    }
    watched.recovers();
    drop(told);
    watched.bench.now_us
}

#[test]
fn random_schedules_leave_the_force_safe_and_the_session_recoverable() {
    if let Ok(seed) = std::env::var("SCHEDULE") {
        schedule(seed.parse().expect("a number"));
        return;
    }
    let asked = std::env::var("SCHEDULES").or_else(|_| std::env::var("CAMPAIGN_CASES"));
    let count = asked.map_or(200, |n| n.parse().expect("a number"));
    let (next, virtual_us) = (AtomicU64::new(0), AtomicU64::new(0));
    let work = || {
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= count {
                break;
            }
            virtual_us.fetch_add(schedule(seed), Ordering::Relaxed);
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(work);
        }
    });
    let hours = virtual_us.into_inner() as f64 / 3.6e9;
    println!("{count} schedules, {hours:.2} h of virtual time");
}
