//! Lines that flood, stall and say nothing of use: each is told in time, left at once when somebody stops, and feeds no watchdog.
//!
//! The line is in virtual time once it is mad: a read takes its wait of the line's own clock, and a share of that of this machine's.
//! By night both are one; what was listened counts, as this machine may be busy.

use super::{
    tests::{look, quiet, rendered},
    *,
};
use haptic_emulator::{
    LineFaults,
    board::{Emulation, emulate},
};
use haptic_link::{
    BatchItem, Configuration, DeviceReport, Direction, Event, FRAME_MAX, Header, Limits, Receiver,
    encode,
};
use haptic_remote::serial::{Line, Pipe};
use std::{
    io::{ErrorKind, Read, Result as Done, Write},
    sync::{Arc, Mutex, MutexGuard},
};
use testkit::Random;

const fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

#[derive(Clone, Copy, Debug)]
enum Nonsense {
    Silent,
    Garbage,
    Trickle,
    Zeros,
    Echo,
    /// The last frame over and over, or its beginning.
    Repeats,
    Cut,
    /// Good frames: notices, samples of another number of axes, and those of one tick.
    Notices,
    Aliens,
    Stands,
}
use Nonsense::{Aliens, Cut, Echo, Garbage, Notices, Repeats, Silent, Stands, Trickle, Zeros};

const ALL: [Nonsense; 10] = [
    Silent, Garbage, Trickle, Zeros, Echo, Repeats, Cut, Notices, Aliens, Stands,
];

/// Where it becomes mad, and how the run goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    Greeting,
    Request,
    Device,
    Host,
    Closing,
}

const PHASES: [Phase; 5] = [
    Phase::Greeting,
    Phase::Request,
    Phase::Device,
    Phase::Host,
    Phase::Closing,
];

struct Mad {
    nonsense: Nonsense,
    phase: Phase,
    random: Random,
    /// Seconds of the line in one of this machine.
    speed: u32,
    /// Time of a read that brings something.
    pace: Duration,
    /// The line's time beyond this machine's, and by it when it became mad.
    ahead: Duration,
    since: Option<Moment>,
    /// Time listened since, and the end of the last read.
    listened: (Duration, Moment),
    from_device: Receiver<DeviceReport>,
    from_host: Receiver<Request>,
    samples: u32,
    sequence: u16,
    sample: Sample,
    echo: Vec<u8>,
    /// When the last keep-alive came since it is mad.
    fed: Duration,
}

/// An end of a line to a board, which becomes mad.
#[derive(Clone)]
struct MadLine(Pipe, Arc<Mutex<Mad>>);

impl MadLine {
    fn mad(&self) -> MutexGuard<'_, Mad> {
        self.1.lock().expect("no panic")
    }

    /// Time listened since it became mad.
    fn passed(&self) -> Duration {
        self.mad().listened.0
    }
}

impl Mad {
    fn good(&mut self, report: &DeviceReport) -> Vec<u8> {
        self.sequence = self.sequence.wrapping_add(1);
        let mut frame = [0; FRAME_MAX];
        let length = encode(report, Header::from_device(self.sequence), &mut frame);
        frame[..length.expect("fits")].to_vec()
    }

    /// The next of its words, at most so many.
    fn says(&mut self, most: usize) -> Vec<u8> {
        let sample = self.sample.clone();
        match self.nonsense {
            Silent => Vec::new(),
            Garbage => (0..most).map(|_| self.random.bits() as u8).collect(),
            Trickle => vec![self.random.bits() as u8],
            Zeros => vec![0; most],
            Echo => std::mem::take(&mut self.echo),
            Repeats => {
                self.sequence = self.sequence.wrapping_sub(1);
                self.good(&DeviceReport::Sample(sample))
            }
            Cut => {
                let frame = self.good(&DeviceReport::Sample(sample));
                [&[0], &frame[..frame.len() / 2]].concat()
            }
            Notices => self.good(&DeviceReport::Event(Event {
                kind: EventKind::Armed,
                tick: 0,
                time_us: 0,
            })),
            Stands => self.good(&DeviceReport::Sample(sample)),
            Aliens => {
                let axes = [BatchItem::default(); 3].into_iter().collect();
                let tick = self.sample.tick + 1;
                self.sample.tick = tick;
                self.good(&DeviceReport::Sample(Sample {
                    tick,
                    axes,
                    ..sample
                }))
            }
        }
    }

    fn turns(&mut self, is_it: bool) {
        if is_it && self.since.is_none() {
            self.since = Some(Moment::now());
            self.listened.1 = Moment::now();
        }
    }
}

impl Read for MadLine {
    fn read(&mut self, into: &mut [u8]) -> Done<usize> {
        if self.mad().since.is_none() {
            let count = self.0.read(into)?;
            let mut mad = self.mad();
            for byte in &into[..count] {
                let Some((header, report)) = mad.from_device.push(*byte) else {
                    continue;
                };
                mad.sequence = header.sequence as u16;
                if let DeviceReport::Sample(sample) = report {
                    (mad.samples, mad.sample) = (mad.samples + 1, sample);
                }
            }
            let runs = matches!(mad.phase, Phase::Device | Phase::Host);
            let turns = runs && mad.samples > 20;
            mad.turns(turns);
            return Ok(count);
        }
        let mut mad = self.mad();
        let words = mad.says(into.len());
        let took = if words.is_empty() { ms(20) } else { mad.pace };
        let speed = mad.speed;
        mad.ahead += took * (speed - 1) / speed;
        drop(mad);
        std::thread::sleep(took / speed);
        let now = self.now();
        let mut mad = self.mad();
        let took = now.saturating_duration_since(std::mem::replace(&mut mad.listened.1, now));
        // As the link counts a round.
        mad.listened.0 += took.min(ms(30));
        match words.len() {
            0 => Err(ErrorKind::TimedOut.into()),
            _ => words.as_slice().read(into),
        }
    }
}

impl Write for MadLine {
    fn write(&mut self, bytes: &[u8]) -> Done<usize> {
        let mut mad = self.1.lock().expect("no panic");
        for byte in bytes {
            let Some((_, request)) = mad.from_host.push(*byte) else {
                continue;
            };
            let turns = match mad.phase {
                Phase::Greeting => true,
                Phase::Request => matches!(request, Request::Configure(_)),
                Phase::Closing => matches!(request, Request::Disarm),
                Phase::Device | Phase::Host => false,
            };
            mad.turns(turns);
            if mad.since.is_some() && matches!(request, Request::KeepAlive { .. }) {
                mad.fed = mad.listened.0;
            }
        }
        match mad.since {
            Some(_) => mad.echo.extend(bytes),
            None => return self.0.write(bytes),
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> Done<()> {
        Ok(())
    }
}

impl Line for MadLine {
    fn share(&self) -> Done<Box<dyn Line>> {
        Ok(Box::new(self.clone()))
    }

    fn set_baud_rate(&mut self, _: u32) {}

    fn set_patience(&mut self, patience: Duration) -> Done<()> {
        self.0.set_patience(patience)
    }

    fn now(&self) -> Moment {
        Moment::now() + self.mad().ahead
    }
}

const BOARD: Emulation = Emulation {
    axes: 1,
    body: None,
    sensor: None,
    at_handle: None,
    robot: None,
    speed: 1.0,
    faults: LineFaults {
        drop: 0.0,
        corrupt: 0.0,
        duplicate: 0.0,
        reorder: 0.0,
        delay_s: 0.0,
        stall: 0.0,
        stall_s: 0.0,
    },
    seed: 1,
    duration: None,
};

/// The device at this line, configured; or why not.
fn configured(
    line: &MadLine,
    mode: LoopMode,
    stop: &Arc<AtomicBool>,
) -> Result<SerialLink, SerialError> {
    let mut link = SerialLink::to_line(Box::new(line.clone()), "mad", Some(stop))?;
    let limits = Limits {
        watchdog_ms: Limits::WATCHDOG_MAX_MS,
        max_age_ticks: Limits::MAX_AGE_TICKS,
        ..Limits::bare(10.0, 1e5)
    };
    let configuration = Configuration {
        loop_mode: mode,
        limits,
        ..Configuration::PASSIVE
    };
    link.set(configuration, &[0.0])?;
    Ok(link)
}

/// A run on this line to whatever end it comes: how it ended, and the line's time from where it became mad, or was stopped, until it was told.
fn run(line: &MadLine, phase: Phase, stop: &'static Arc<AtomicBool>) -> (String, Duration) {
    let mode = if phase == Phase::Host {
        LoopMode::Host
    } else {
        LoopMode::Device
    };
    let link = match configured(line, mode, stop) {
        Ok(link) => link,
        Err(error) => return (error.to_string(), line.passed()),
    };
    let supervisor = Supervisor { stop, ..quiet() };
    let [left] = look([None], None, |[session]| {
        session.ready.schedule.samples = if phase == Phase::Closing { 50 } else { 100_000 };
        (session.ready.link, session.ready.stop) = (link, stop);
        let ended = match mode {
            LoopMode::Device => session.listen(supervisor),
            LoopMode::Host => session.control(&mut rendered(), &mut (), supervisor),
        };
        if let Err(error) = ended {
            session.give_up(&error);
        }
    });
    (left.record.reason().unwrap_or_default(), line.passed())
}

/// The case of this number: stopped so long after it became mad, if at all.
fn conduct(case: usize, speed: u32, stopped: Option<Duration>) {
    let (nonsense, phase) = (ALL[case % 10], PHASES[case / 10 % 5]);
    let mut random = Random(case as u64);
    let pace = ms(1).mul_f64(random.log_between(0.05, 15.0));
    let (here, far_end) = Pipe::pair();
    let over = AtomicBool::new(false);
    let stop: &Arc<AtomicBool> = Box::leak(Box::default());
    let mad = Mad {
        nonsense,
        phase,
        random,
        speed,
        pace,
        ahead: Duration::ZERO,
        since: None,
        listened: (Duration::ZERO, Moment::now()),
        from_device: Receiver::new(Direction::FromDevice),
        from_host: Receiver::new(Direction::FromHost),
        samples: 0,
        sequence: 0,
        sample: Sample::default(),
        echo: Vec::new(),
        fed: Duration::ZERO,
    };
    let line = MadLine(here, Arc::new(Mutex::new(mad)));
    let (words, told) = std::thread::scope(|scope| {
        let board = scope.spawn(|| emulate(Box::new(far_end), &BOARD, &over));
        let (line, over) = (&line, &over);
        scope.spawn(move || {
            let Some(after) = stopped else { return };
            testkit::until("it is mad", || line.mad().since);
            while line.passed() < after && !over.load(Ordering::Relaxed) {
                std::thread::sleep(ms(1));
            }
            stop.store(true, Ordering::Relaxed);
        });
        let told = run(line, phase, stop);
        over.store(true, Ordering::Relaxed);
        board.join().expect("no panic").expect("a good board");
        told
    });
    let case =
        format!("{case}: {nonsense:?} while {phase:?}, stopped {stopped:?}: {words}, {told:?}");
    assert!(!words.is_empty(), "{case}");
    let fed = line.mad().fed;
    // In virtual time whoever waits looks too rarely.
    if speed == 1 {
        let most = stopped.map_or(ms(2500), |after| after + ms(500));
        assert!(told <= most, "{case}");
        assert!(fed <= ms(2100), "{case}: fed at {fed:?}");
    }
}

/// Each case in a thread of its own, some at a time.
fn conduct_all(cases: usize, at_a_time: usize, one: impl Fn(usize) + Sync) {
    for first in (0..cases).step_by(at_a_time) {
        std::thread::scope(|scope| {
            for case in first..cases.min(first + at_a_time) {
                let one = &one;
                scope.spawn(move || one(case));
            }
        });
    }
}

#[test]
fn whatever_a_line_says_instead_of_samples_its_run_ends_and_says_so() {
    conduct_all(testkit::cases(50), 10, |case| {
        conduct(case, 20, (case / 50 % 2 == 1).then(|| ms(100)));
    });
}

#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_a_line_that_floods_is_told_in_time_and_left_at_once() {
    conduct_all(testkit::cases(20), 2, |case| {
        // In a hundred each of them, stopped and not.
        conduct(7 * case, 1, (case / 2 % 2 == 1).then(|| ms(300)));
    });
}
