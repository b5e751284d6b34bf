//! Patience in virtual time, and what a device that falls silent costs.

use haptic_link::{LineCounters, Request};
use haptic_remote::serial::{Heard, Line as _, Pipe, SerialLink};
use haptic_remote::{Conversation, DeviceSession, LinkError, Patience, SimulatedPlant, TickSide};
use std::time::Duration;
use testkit::Random;

/// Milliseconds of virtual time.
const fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

/// A host that waits for a device, and is held up at times: all in virtual ms.
struct Host {
    now: u64,
    patience: Patience,
    /// Time in which it ran: of each wait so much as was asked.
    ran: u64,
}

impl Host {
    fn new(most: u64) -> Self {
        Self {
            now: 0,
            patience: Patience::new(ms(most)),
            ran: 0,
        }
    }

    /// Waits for the next sign of the device, at most so long, and wakes so much later; what it has taken by then.
    fn waits(&mut self, asked: u64, late: u64, signs: &mut std::vec::IntoIter<u64>) -> usize {
        let began = self.now;
        let next = signs.as_slice().first().copied().unwrap_or(u64::MAX);
        self.now = next.clamp(began, began + asked) + late;
        let taken = signs.as_slice().partition_point(|sign| *sign <= self.now);
        signs.by_ref().take(taken).for_each(drop);
        if taken > 0 {
            self.patience.heard();
        }
        self.patience.waited(ms(asked), ms(self.now - began));
        if taken > 0 {
            self.patience.heard();
        }
        self.ran += asked.min(self.now - began);
        taken
    }
}

/// Rows of: the most that a device may be silent | waits asked and taken, ms | silent by listening | over.
#[test]
fn only_what_was_asked_of_a_wait_counts() {
    for [most, waits, silent, over] in testkit::table(
        "
        100 | 20:20 20:20 20:20 20:20 | 80 | false
        100 | 20:20 20:20 20:20 20:20 20:20 | 100 | true
        # A thread that woke 300 ms late has waited no 300 ms for the device.
        100 | 20:320 | 20 | false
        100 | 20:320 20:5000 20:90 20:20 | 80 | false
        100 | 20:320 20:5000 20:90 20:20 20:20 | 100 | true
        # A wait that something ended before its time.
        100 | 20:1 20:1 20:0 | 2 | false
        # A look without a wait.
        100 | 0:0 0:400 | 0 | false
        0 | 0:0 | 0 | true
        ",
    ) {
        let number = |text: &str| text.parse::<u64>().expect("a number");
        let mut patience = Patience::new(ms(number(&most)));
        for wait in waits.split(' ') {
            let (asked, took) = wait.split_once(':').expect("asked:took");
            patience.waited(ms(number(asked)), ms(number(took)));
        }
        assert_eq!(patience.silent(), ms(number(&silent)), "{waits}");
        assert_eq!(patience.is_over(), over == "true", "{waits}");
    }
}

#[test]
fn a_device_that_answers_in_time_is_never_given_up_and_a_silent_one_is() {
    let mut random = Random(83);
    for case in 0..testkit::cases(2000) {
        let most = 50 + random.bits() % 2000;
        // It says something at least every `most` less 1, and then nothing any more.
        let mut signs = vec![0];
        for _ in 0..random.bits() % 40 {
            let last = signs[signs.len() - 1];
            signs.push(last + 1 + random.bits() % (most - 1));
        }
        let last = signs[signs.len() - 1];
        let mut signs = signs.into_iter();
        let mut host = Host::new(most);
        let held_up = random.share();
        let (mut since, mut waits) = (0, 0);
        while !host.patience.is_over() {
            let asked = 1 + random.bits() % 50;
            let late = match random.chance(held_up) {
                true => random.log_between(1.0, 20_000.0) as u64,
                false => 0,
            };
            if host.waits(asked, late, &mut signs) > 0 {
                (since, waits) = (host.ran, 0);
            }
            waits += 1;
            assert!(waits <= most + 1, "case {case}: it waits for ever");
        }
        assert!(host.now >= last + most, "case {case}: given up too early");
        assert_eq!(signs.len(), 0, "case {case}: given up while it spoke");
        // The last wait may go beyond it.
        let listened = host.ran - since;
        assert!((most..most + 50).contains(&listened), "case {case}");
    }
}

/// Tries of a request count what was listened: a thread that sends them cannot give up what another has not read.
#[test]
fn an_answer_that_nobody_took_is_not_missing() {
    let mut line = [0; haptic_link::FRAME_MAX];
    let mut host = Conversation::new(150_000).by_listening();
    host.ask(Request::GetStatistics, 0, &mut line);
    // Nobody listens, for a minute.
    for now_us in (0..60_000_000).step_by(50_000) {
        assert_eq!(host.due(now_us, &mut line), Ok(0), "{now_us}");
    }
    // Somebody does, held up at each wait.
    let mut listened_ms = 0;
    let error = loop {
        host.waited(ms(20), ms(500));
        listened_ms += 20;
        if let Err(error) = host.due(60_000_000 + 500_000 * listened_ms, &mut line) {
            break error;
        }
    };
    let silent = LinkError::NoAnswer {
        request: Request::GetStatistics.name(),
        line: LineCounters::default(),
    };
    assert_eq!((error, listened_ms), (silent, 10 * 160));
}

/// The far end of a pipe with a board on it, until it is dropped.
struct Board {
    line: Pipe,
    device: std::cell::RefCell<TickSide<SimulatedPlant>>,
    session: DeviceSession,
    now_us: u64,
}

impl Board {
    fn new(line: Pipe) -> Self {
        let device = TickSide::new(SimulatedPlant::new("board", || 0)).expect("works");
        Self {
            line,
            device: std::cell::RefCell::new(device),
            session: DeviceSession::within_this_process(),
            now_us: 0,
        }
    }

    /// Answers what has come, for so long as this is true.
    fn serves(&mut self, goes_on: impl Fn() -> bool) {
        use std::io::{Read as _, Write as _};
        let mut bytes = [0; 512];
        let mut frame = [0; haptic_link::FRAME_MAX];
        self.line.set_patience(ms(1)).expect("a pipe can");
        while goes_on() {
            let count = self.line.read(&mut bytes).unwrap_or(0);
            for &byte in &bytes[..count] {
                let length = (self.session).receive(byte, self.now_us, &self.device, &mut frame);
                let _ = self.line.write(&frame[..length]);
            }
            self.now_us += 1000;
            self.device.borrow_mut().tick(self.now_us);
            loop {
                let length = self.session.poll(&self.device, &mut frame);
                if length == 0 {
                    break;
                }
                let _ = self.line.write(&frame[..length]);
            }
        }
    }
}

/// A link to a board that is served until something is done with the link, and what the board's end has heard since it stopped.
fn with_board(served_meanwhile: bool, done: impl FnOnce(SerialLink)) -> Vec<Request> {
    use std::sync::atomic::{AtomicBool, Ordering};
    let (here, there) = Pipe::pair();
    let mut board = Board::new(there);
    let served = AtomicBool::new(true);
    std::thread::scope(|scope| {
        let serving = scope.spawn(|| {
            board.serves(|| served.load(Ordering::Relaxed));
            board
        });
        let link = SerialLink::to_line(Box::new(here), "board").expect("answers");
        link.arm(ms(1000)).expect("arms");
        let stop = || served.store(false, Ordering::Relaxed);
        if served_meanwhile {
            done(link);
            stop();
            return Vec::new();
        }
        stop();
        let mut board = serving.join().expect("no panic");
        done(link);
        board.heard()
    })
}

impl Board {
    /// Requests that have come and were not read.
    fn heard(&mut self) -> Vec<Request> {
        use std::io::Read as _;
        let mut receiver = haptic_link::Receiver::<Request>::new(haptic_link::Direction::FromHost);
        let mut bytes = vec![0; 1 << 16];
        let count = self.line.read(&mut bytes).unwrap_or(0);
        let frames = bytes[..count].iter();
        let frames = frames.filter_map(|byte| receiver.push(*byte));
        frames.map(|(_, request)| request).collect()
    }
}

/// Hears until the device says nothing for so long.
fn silence(link: &mut SerialLink, most: Duration) {
    while let Some(heard) = link.hear(most) {
        assert!(!matches!(heard, Heard::Over(_)), "{heard:?}");
    }
}

#[test]
fn a_device_that_falls_silent_is_asked_once_more_and_waited_for_no_longer() {
    let heard = with_board(false, |mut link| {
        silence(&mut link, ms(100));
        let mut patience = link.patience(ms(250));
        let silent = LinkError::NoSamples { waited_ms: 100 };
        assert_eq!(link.silent(ms(100)), silent);
        // Nothing that follows waits for it: neither a question nor the end of the link.
        assert!(link.statistics().is_err() && link.disarm().is_err());
        assert!(!link.is_silent(&mut patience), "{patience:?}");
        drop(link);
    });
    let told = |wanted: &Request| heard.iter().filter(|request| *request == wanted).count();
    // Two tries, and one for each that let it go.
    let disarms = told(&Request::Disarm);
    assert!((3..=4).contains(&disarms), "{heard:?}");
    assert_eq!(told(&Request::GetStatistics), 1, "{heard:?}");
}

#[test]
fn a_device_that_answers_and_sends_no_samples_is_held_up() {
    with_board(true, |mut link| {
        silence(&mut link, ms(100));
        let held_up = LinkError::HeldUp { waited_ms: 100 };
        assert_eq!(link.unheard(ms(100)), held_up);
        assert_eq!(link.silent(ms(100)), held_up);
        // It is heard as before.
        assert!(link.statistics().is_ok());
        assert!(link.answers_again());
    });
}

#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_a_silence_of_two_seconds_is_told_within_two_and_a_half() {
    with_board(false, |link| {
        let mut link = link;
        let began = haptic_loop::realtime::Moment::now();
        let none = std::sync::atomic::AtomicBool::new(false);
        let read: Result<haptic_loop::Reading<f64, 1>, _> = link.read_or_stop(&none);
        let silent = LinkError::NoSamples { waited_ms: 2000 };
        assert_eq!(read.expect_err("silent"), silent.into());
        drop(link);
        let took = began.elapsed();
        assert!((ms(2000)..ms(2500)).contains(&took), "{took:?}");
    });
}
