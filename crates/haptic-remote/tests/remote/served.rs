//! A device that this process serves: late ticks count, and the end of the link is the end of the force.

use haptic_link::{
    Capabilities, Configuration, FaultReport, Limits, Refusal, Sample, Start, State,
};
use haptic_loop::{Device, Fault, Limiters, Reading, SafeForce, realtime::Moment};
use haptic_remote::{
    Hardware, LinkError, SimulatedPlant, TickSide,
    serial::{BoardTrouble, DeviceMessage, SerialError, SerialLink, Served, ServedHardware},
};
use nalgebra::SVector;
use std::{
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, AtomicU32, Ordering},
    },
    time::Duration,
};
use testkit::Tested;

/// What a board has done.
#[derive(Debug, Default)]
struct Done {
    /// Each force, N.
    forces_n: Mutex<Vec<f32>>,
    /// Calls of `let_go`, and forces up to the last.
    let_go: AtomicU32,
    /// The next read fails.
    breaks: AtomicBool,
    /// The next read, or write, stands still for longer than the watchdog time.
    stalls: [AtomicBool; 2],
}

impl Done {
    fn stand_still(&self, place: usize) {
        if self.stalls[place].swap(false, Ordering::Relaxed) {
            std::thread::sleep(2 * WATCHDOG);
        }
    }
}

const WATCHDOG: Duration = Duration::from_secs(1);

/// A board that stands still, slowly.
struct Slow {
    done: Arc<Done>,
    takes: Duration,
}

impl Device<f32, 1> for Slow {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, 1>, Fault> {
        std::thread::sleep(self.takes);
        self.done.stand_still(0);
        if self.done.breaks.swap(false, Ordering::Relaxed) {
            return Err(Fault::BoardFailed);
        }
        Ok(Reading {
            tick: 0,
            time_s: 0.0,
            position_m: SVector::from([0.01]),
        })
    }

    fn write(&mut self, force: SafeForce<f32, 1>) -> Result<(), Fault> {
        let mut forces = self.done.forces_n.lock().expect("nobody panicked");
        forces.push(force.newtons()[0]);
        drop(forces);
        self.done.stand_still(1);
        Ok(())
    }

    fn let_go(&mut self) {
        self.done.let_go.fetch_add(1, Ordering::Relaxed);
    }
}

impl Hardware for Slow {
    type Setup = ();

    fn capabilities(&self) -> Capabilities {
        Capabilities {
            simulated: false,
            ..SimulatedPlant::new("slow", || 0).capabilities()
        }
    }

    fn install(&mut self, (): (), _: u32) {}

    fn restart(&mut self) {}

    fn idle(&mut self) -> Result<Reading<f32, 1>, Fault> {
        self.read()
    }
}

impl ServedHardware for Slow {
    fn trouble(&self) -> Option<BoardTrouble> {
        Some(BoardTrouble::of_board("it is broken: mend it".to_owned()))
    }
}

/// A spring that pushes with 1 N, and no limit on how late its ticks may be but this.
fn spring(late_ticks: u16) -> Configuration {
    Configuration {
        stiffness_n_per_m: 100.0,
        limits: Limits {
            late_ticks,
            watchdog_ms: WATCHDOG.as_millis() as u16,
            ..Limits::bare(10.0, 1e5)
        },
        ..Configuration::PASSIVE
    }
}

fn running(takes: Duration, late_ticks: u16) -> (SerialLink, Arc<Done>) {
    running_as(Start::ENDLESS, takes, late_ticks)
}

fn running_as(start: Start, takes: Duration, late_ticks: u16) -> (SerialLink, Arc<Done>) {
    running_by(Moment::now, start, takes, late_ticks)
}

fn running_by(
    clock: fn() -> Moment,
    start: Start,
    takes: Duration,
    late_ticks: u16,
) -> (SerialLink, Arc<Done>) {
    let done = Arc::new(Done::default());
    let slow = Slow {
        done: Arc::clone(&done),
        takes,
    };
    let served = Served::serve(slow, clock, None).expect("starts");
    let mut link = SerialLink::to_served(served, "slow:one").expect("answers");
    assert_eq!((link.name().as_str(), link.trouble()), ("slow:one", None));
    link.set(spring(late_ticks), &[0.0]).expect("good");
    link.arm(WATCHDOG).expect("arms");
    link.start(start).expect("starts");
    (link, done)
}

/// The fault that ends it, and its news.
fn fault(link: &mut SerialLink) -> (Fault, FaultReport) {
    loop {
        match link.hear(testkit::PATIENCE).expect("something") {
            DeviceMessage::Fault(report) => {
                let fault = Fault::from_code(report.status.fault).expect("known");
                return (fault, report);
            }
            DeviceMessage::Over(error) => panic!("{error}"),
            DeviceMessage::Sample(_) | DeviceMessage::Event(_) => {}
        }
    }
}

/// The next so many samples.
fn samples(link: &mut SerialLink, count: usize) -> Vec<Sample> {
    let mut samples = Vec::new();
    while samples.len() < count {
        match link.hear(testkit::PATIENCE).expect("something") {
            DeviceMessage::Sample(sample) => samples.push(sample),
            DeviceMessage::Event(_) => {}
            over @ (DeviceMessage::Fault(_) | DeviceMessage::Over(_)) => panic!("{over:?}"),
        }
    }
    samples
}

#[test]
fn ticks_that_take_too_long_are_counted_and_are_a_fault() {
    let (mut link, _) = running(Duration::from_millis(3), 20);
    assert_eq!(fault(&mut link).0, Fault::TickOverrun);
    let overruns = link.statistics().expect("answers").overruns;
    assert!(overruns >= 20, "{overruns}");
}

#[test]
fn a_stop_is_heard_where_no_sample_comes() {
    // But for one at the start, if that tick is not late, it runs for a minute without a word.
    let seldom = Start {
        every: u16::MAX,
        ..Start::ENDLESS
    };
    let (mut link, _) = running_as(seldom, Duration::ZERO, 0);
    let stop = AtomicBool::new(true);
    let error = loop {
        let read: Result<Reading<f64, 1>, _> = link.read_or_stop(&stop);
        if let Err(error) = read {
            break error;
        }
    };
    assert_eq!(error, LinkError::Stopped.into());
}

/// Time for which the machine of [`clock`] has slept, s.
static SLEPT_S: AtomicU32 = AtomicU32::new(0);

fn clock() -> Moment {
    Moment::now() + Duration::from_secs(u64::from(SLEPT_S.load(Ordering::Relaxed)))
}

#[test]
fn a_force_of_before_the_machine_slept_is_taken_away_when_it_wakes() {
    let (mut link, done) = running_by(clock, Start::ENDLESS, Duration::ZERO, 0);
    samples(&mut link, 20);
    let forces = || done.forces_n.lock().expect("nobody panicked").clone();
    assert!(forces().last().is_some_and(|force| *force < -0.9));
    SLEPT_S.store(5, Ordering::Relaxed);
    assert_eq!(fault(&mut link).0, Fault::HostSilent);
    // No force goes out any more: the hardware is told to let go instead.
    let before = forces().len();
    samples(&mut link, 20);
    assert!(forces()[before..].iter().all(|force| *force == 0.0));
    assert!(done.let_go.load(Ordering::Relaxed) > 0);
}

#[test]
fn dropping_the_link_lets_the_force_fall_and_then_lets_go() {
    // However late this machine is.
    let (mut link, done) = running(Duration::ZERO, 0);
    samples(&mut link, 20);
    assert_eq!(done.let_go.load(Ordering::Relaxed), 0);
    drop(link);
    assert_eq!(done.let_go.load(Ordering::Relaxed), 1);
    let forces = done.forces_n.lock().expect("nobody panicked");
    let largest = forces
        .iter()
        .fold(0.0_f32, |most, force| most.max(force.abs()));
    assert!((largest - 1.0).abs() < 1e-6, "{largest} N");
    assert_eq!(forces.last(), Some(&0.0));
}

#[test]
fn a_board_that_fails_is_let_go_at_once_and_says_why() {
    let (mut link, done) = running(Duration::ZERO, 0);
    samples(&mut link, 20);
    done.breaks.store(true, Ordering::Relaxed);
    let (fault, report) = fault(&mut link);
    assert_eq!(fault, Fault::BoardFailed);
    assert!(done.let_go.load(Ordering::Relaxed) >= 1);
    let trouble = link.trouble().map(|trouble| trouble.words);
    assert_eq!(trouble.as_deref(), Some("it is broken: mend it"));
    assert_eq!(link.lost_board(), None);
    assert_eq!(link.status().state, State::Fault);
    // The tick of the fault is told too: no force, and the place of before.
    let rest = samples(&mut link, 50);
    let failed = rest.iter().find(|sample| sample.tick == report.tick);
    let failed = failed.expect("it is among them").axes[0];
    assert_eq!((failed.force_n, failed.position_m), (0.0, 0.01));
    assert_eq!(failed.limiters, Limiters::FAULT.bits());
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn after_a_standstill_no_force_of_before_goes_out() {
    // Inside a tick, between its place and its force; and between two ticks, where the host is heard before the next.
    for place in [0, 1] {
        let (mut link, done) = running(Duration::ZERO, 0);
        samples(&mut link, 20);
        // Held, so that nothing goes out between.
        let before = {
            let forces = done.forces_n.lock().expect("nobody panicked");
            done.stalls[place].store(true, Ordering::Relaxed);
            forces.len()
        };
        let (fault, _) = fault(&mut link);
        assert_eq!(fault, Fault::HostSilent, "{place}");
        drop(link);
        assert!(done.let_go.load(Ordering::Relaxed) >= 1);
        let forces = done.forces_n.lock().expect("nobody panicked");
        // Of the tick that was held.
        let pushed = forces[before..].iter().filter(|&&force| force != 0.0);
        let pushed = pushed.count();
        assert!(pushed <= 1, "{place}: {pushed} forces");
    }
}

#[test]
fn the_number_of_a_tick_is_its_time_however_late_it_is() {
    // Three periods a tick, and no limit on that.
    let (mut link, _) = running(Duration::from_millis(3), 0);
    let samples = samples(&mut link, 20);
    let (first, last) = (&samples[0], &samples[19]);
    for sample in &samples {
        let passed_us = sample.time_us.wrapping_sub(first.time_us);
        let numbers = f64::from(sample.tick - first.tick);
        assert!(
            (f64::from(passed_us) / 1e3 - numbers).abs() <= 1.0,
            "{sample:?}"
        );
    }
    assert!(
        last.tick - first.tick >= 2 * 19,
        "{} to {}",
        first.tick,
        last.tick
    );
}

#[test]
fn skipped_periods_have_their_numbers_and_their_part_of_a_run() {
    let mut device = TickSide::new(SimulatedPlant::new("skips", || 0)).expect("starts");
    device.arm(0).expect("nothing is wrong");
    let start = Start {
        ticks: 20,
        ..Start::ENDLESS
    };
    device.start(start).expect("is armed");
    let mut now_us = 0;
    for (skipped, tick, runs) in [
        (0, 0, true),
        (0, 1, true),
        (7, 9, true),
        (0, 10, true),
        (30, 41, false),
    ] {
        device.skip(skipped);
        now_us += 1000 * (1 + u64::from(skipped));
        device.tick(now_us);
        assert_eq!(device.newest().tick, tick);
        assert_eq!(device.status().state == State::Running, runs, "tick {tick}");
    }
}

#[test]
fn a_fault_between_arm_and_start_ends_the_run_by_its_name() -> Tested {
    let done = Arc::new(Done::default());
    let slow = Slow {
        done: Arc::clone(&done),
        takes: Duration::ZERO,
    };
    let served = Served::start(slow)?;
    let mut link = SerialLink::to_served(served, "slow:one")?;
    link.set(spring(0), &[0.0])?;
    let refused = |link: &mut SerialLink| match link.start(Start::ENDLESS) {
        Err(SerialError::Link(error)) => error,
        other => panic!("{other:?}"),
    };
    // The host has heard of it before it starts, or not yet.
    for hears_of_it in [true, false] {
        link.arm(WATCHDOG)?;
        done.breaks.store(true, Ordering::Relaxed);
        while done.breaks.load(Ordering::Relaxed) {
            std::thread::yield_now();
        }
        if hears_of_it {
            testkit::until("the news", || {
                (link.status().state == State::Fault).then_some(())
            });
        }
        let LinkError::Faulted(report) = refused(&mut link) else {
            panic!("not by its name");
        };
        assert_eq!(report.status.fault, Fault::BoardFailed.code());
        assert_eq!(link.status(), report.status);
    }
    // Armed anew it runs; a start without that is refused, as no run has ended by that.
    link.arm(WATCHDOG)?;
    link.start(Start::ENDLESS)?;
    samples(&mut link, 20);
    done.breaks.store(true, Ordering::Relaxed);
    fault(&mut link);
    let error = refused(&mut link);
    let refusal = Refusal::State(State::Fault);
    assert_eq!(
        error,
        LinkError::Refused {
            request: "start",
            refusal
        }
    );
    Ok(())
}
