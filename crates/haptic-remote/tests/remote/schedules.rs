//! Random schedules: lines that lose, damage, repeat, reorder, delay and hold back what is said, hosts that die
//! and come back, devices that reboot, requests in any state. What must hold is checked after every step of the
//! clock.
//!
//! `CAMPAIGN_CASES` sets how many are run, `SCHEDULE` the one of a number: a failure tells it. 100 000 are 22 h of virtual time and take a
//! minute of two processors.

mod losses;
mod random;
mod watched;

use self::{random::below, watched::Watched};
use crate::line::{START, STEP_US, spring};
use haptic_emulator::LineFaults;
use haptic_link::{DeviceReport, Field, Refusal, Request, Scope, Start, State};
use haptic_loop::Fault;
use haptic_remote::LinkError;
use std::sync::atomic::{AtomicU64, Ordering};
use testkit::Random;

/// Law from position, m, to force, N.
type Law = fn(f32) -> f32;

const LAWS: [Option<Law>; 4] = [
    None,
    Some(|x| -500.0 * x),
    Some(|x| 1e6 * x + 1.0),
    Some(|_| f32::NAN),
];

impl Watched {
    /// Asks; the answer, a refusal or the error has to come in time.
    fn ask(&mut self, request: Request) -> Result<Result<DeviceReport, Refusal>, LinkError> {
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
        let (configuration, values) = random::configuration(random);
        for request in crate::line::transaction(configuration, &values) {
            if !matches!(self.ask(request), Ok(Ok(_))) {
                return;
            }
        }
        let digest = haptic_link::DigestBuilder::new(&configuration).coefficients(&values);
        let digest = digest.finish();
        let scope = random.one_of(&[Scope::Run, Scope::Lasting]);
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

    fn good_line(&mut self) {
        let quiet = LineFaults::default();
        self.bench.to_device.set_faults(quiet).expect("valid");
        self.bench.to_host.set_faults(quiet).expect("valid");
    }

    fn act(&mut self, random: &mut Random) {
        match below(random, 26) {
            24 => {
                let offset_m = random.one_of(&[0.0, 0.0, 0.005, -0.02]);
                self.bench.device.borrow_mut().hardware_mut().offset_m = offset_m;
            }
            25 => {
                let mut device = self.bench.device.borrow_mut();
                let sticks = &mut device.hardware_mut().sticks;
                *sticks = !*sticks;
            }
            0 => {
                let faults = random::faults(random);
                self.bench.to_device.set_faults(faults).expect("valid");
            }
            1 => {
                let faults = random::faults(random);
                self.bench.to_host.set_faults(faults).expect("valid");
            }
            2 => self.good_line(),
            3 | 4 => {
                self.bench.host_dead = true;
                self.run_ms(u64::from(below(random, 100)));
                self.bench.host_dead = false;
            }
            5 => {
                self.bench.reboot();
                self.force_n = 0.0;
                (self.falling, self.looking_us) = (None, None);
            }
            6 => self.bench.device.borrow_mut().overrun(),
            7 => {
                let fault = random.one_of(&[Fault::EmergencyStop, Fault::CurrentMismatch]);
                self.bench.device.borrow_mut().trip(fault);
            }
            8 => {
                let interval = random.one_of(&[None, Some(1_000), Some(4_000), Some(30_000)]);
                self.bench.host.set_keep_alive(interval);
            }
            9 => self.bench.law = random.one_of(&LAWS),
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
                let _ = self.ask(random::request(random, faults));
            }
        }
        self.run_ms(u64::from(below(random, 15)));
    }

    /// After anything whatever, a good line and a host that keeps to the protocol get a run.
    fn recovers(&mut self) {
        self.good_line();
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
        let (digest, scope) = (digest.finish(), Scope::Lasting);
        self.done(Request::Commit { digest, scope });
        let faults = self.greet();
        self.done(Request::Arm { faults });
        self.bench.reports.clear();
        self.done(Request::Start(Start { run: 99, ..START }));
        self.run_ms(20);
        assert_eq!(self.bench.state(), State::Running);
        let ticks = self.bench.ticks();
        assert!(ticks.len() >= 15 && ticks.windows(2).all(|pair| pair[1] == pair[0] + 1));
    }

    /// Connects anew; the number of faults.
    fn greet(&mut self) -> u16 {
        let greeting = self.bench.greeting();
        let answer = self.done(greeting);
        let DeviceReport::Hello(hello) = answer else {
            panic!("not a hello: {answer:?}");
        };
        hello.status.faults
    }

    fn done(&mut self, request: Request) -> DeviceReport {
        let name = request.name();
        match self.ask(request) {
            Ok(Ok(report)) => report,
            other => panic!("{name} on a good line: {other:?}"),
        }
    }
}

/// Tells which schedule it was.
struct SeedNote(u64);

impl Drop for SeedNote {
    fn drop(&mut self) {
        if std::thread::panicking() {
            eprintln!("SCHEDULE={}", self.0);
        }
    }
}

fn schedule(seed: u64) -> u64 {
    let note = SeedNote(seed);
    let mut random = Random(seed);
    let mut watched = Watched::new(seed);
    for _ in 0..10 + below(&mut random, 20) {
        watched.act(&mut random);
    }
    watched.recovers();
    drop(note);
    watched.bench.now_us
}

#[test]
fn random_schedules_leave_the_force_safe_and_the_session_recoverable() {
    if let Ok(seed) = std::env::var("SCHEDULE") {
        schedule(seed.parse().expect("a number"));
        return;
    }
    let count = testkit::cases(200);
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
