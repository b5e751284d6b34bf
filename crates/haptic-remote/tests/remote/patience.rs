//! Patience in virtual time, and what a device that falls silent costs.

use crate::tcp::ideal;
use haptic_emulator::board::emulate;
use haptic_link::{Direction, LineCounters, Receiver, Request};
use haptic_loop::{Reading, realtime::Moment};
use haptic_remote::{
    Conversation, LinkError, Patience,
    serial::{DeviceMessage, Pipe, SerialError, SerialLink},
};
use std::{
    io::Read as _,
    sync::atomic::{AtomicBool, Ordering},
    time::Duration,
};
use testkit::Random;

/// Milliseconds of virtual time.
const fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

/// Rows of: the most that a device may be silent | waits asked and taken, or all that another thread has listened, ms | silent by
/// listening | over.
#[test]
fn only_what_was_asked_of_a_wait_counts() {
    for [most, waits, silent, over] in testkit::table(
        "
        100 | 20:20 20:20 20:20 20:20 20:20 | 100 | true
        # A thread that woke 300 ms late has waited no 300 ms for the device.
        100 | 20:320 | 20 | false
        100 | 20:320 20:5000 20:90 20:20 | 80 | false
        100 | 20:320 20:5000 20:90 20:20 20:20 | 100 | true
        # A wait that something ended before its time.
        100 | 20:1 20:1 20:0 | 2 | false
        # Another thread listens, whose count was read late once.
        100 | 20:20 +60 +50 | 60 | false
        100 | +60 +100 | 100 | true
        # A look without a wait.
        100 | 0:0 0:400 | 0 | false
        ",
    ) {
        let number = |text: &str| text.parse::<u64>().expect("a number");
        let mut patience = Patience::new(ms(number(&most)));
        for wait in waits.split(' ') {
            match wait.split_once(':') {
                Some((asked, took)) => patience.waited(ms(number(asked)), ms(number(took))),
                None => patience.listened_for(ms(number(&wait[1..]))),
            }
        }
        assert_eq!(patience.silent(), ms(number(&silent)), "{waits}");
        assert_eq!(patience.is_over(), over == "true", "{waits}");
    }
}

/// A host that is held up by chance, for up to 20 s at a time, and a device that says something at least every `most` less 1 ms, and
/// then nothing any more: it is given up after its last word, when what the host listened since is `most`.
#[test]
fn a_device_that_answers_in_time_is_never_given_up_and_a_silent_one_is() {
    let mut random = Random(83);
    for case in 0..testkit::cases(2000) {
        let most = 50 + random.bits() % 2000;
        let mut signs = vec![0];
        for _ in 0..random.bits() % 40 {
            signs.push(signs[signs.len() - 1] + 1 + random.bits() % (most - 1));
        }
        let (held_up, mut heard) = (random.share(), 0);
        let (mut patience, mut now, mut listened) = (Patience::new(ms(most)), 0, 0);
        while !patience.is_over() {
            let asked = 1 + random.bits() % 50;
            let late = if random.chance(held_up) {
                random.log_between(1.0, 20_000.0) as u64
            } else {
                0
            };
            let next = signs.get(heard).copied().unwrap_or(u64::MAX);
            let took = next.clamp(now, now + asked) - now + late;
            now += took;
            patience.waited(ms(asked), ms(took));
            listened += asked.min(took);
            let taken = signs[heard..].partition_point(|sign| *sign <= now);
            if taken > 0 {
                heard += taken;
                listened = 0;
                patience.heard();
            }
            assert!(listened < most + 50, "case {case}: waited for too long");
        }
        assert_eq!(heard, signs.len(), "case {case}: given up while it spoke");
        assert!(now >= signs[heard - 1] + most, "case {case}: too early");
        assert!(listened >= most, "case {case}");
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

/// What feeds the watchdog of a device ends with the patience, and begins anew with it, whatever comes that is no good frame.
#[test]
fn keep_alives_end_when_nothing_good_has_come_for_two_seconds() {
    let (mut line, mut host) = (
        [0; haptic_link::FRAME_MAX],
        Conversation::new(150_000).by_listening(),
    );
    let mut sent = |host: &mut Conversation, from_ms: u64| {
        (from_ms..from_ms + 3000)
            .filter(|now_ms| {
                assert_eq!(host.receive(b'x', 1000 * now_ms), None);
                host.waited(ms(30), ms(1));
                host.due(1000 * now_ms, &mut line).expect("no request") > 0
            })
            .count()
    };
    // Of a host that was idle for long, too.
    host.waited(ms(9000), ms(9000));
    for from_ms in [10_000, 20_000] {
        host.set_keep_alive(Some(100_000));
        assert_eq!(sent(&mut host, from_ms), 20, "{from_ms}");
        assert_eq!(sent(&mut host, from_ms + 3000), 0, "{from_ms}");
    }
}

/// A link to an emulated board that goes on, or falls silent before something is done; what its end has not read.
fn with_board(goes_on: bool, done: impl FnOnce(SerialLink)) -> Vec<Request> {
    let (here, mut far_end) = Pipe::pair();
    let (line, stop) = (Box::new(far_end.clone()), AtomicBool::new(false));
    std::thread::scope(|scope| {
        let board = scope.spawn(|| emulate(line, &ideal(), &stop));
        let link = SerialLink::to_line(Box::new(here), "board", None).expect("answers");
        link.arm(ms(1000)).expect("arms");
        if !goes_on {
            stop.store(true, Ordering::Relaxed);
            board.join().expect("no panic").expect("a good device");
        }
        done(link);
        stop.store(true, Ordering::Relaxed);
    });
    let mut receiver = Receiver::<Request>::new(Direction::FromHost);
    let mut bytes = vec![0; 1 << 16];
    let count = far_end.read(&mut bytes).unwrap_or(0);
    let frames = bytes[..count].iter();
    let frames = frames.filter_map(|byte| receiver.push(*byte));
    frames.map(|(_, request)| request).collect()
}

/// Hears until the device says nothing for 100 ms.
fn silence(link: &mut SerialLink) {
    while let Some(heard) = link.hear(ms(100)) {
        assert!(!matches!(heard, DeviceMessage::Over(_)), "{heard:?}");
    }
}

#[test]
fn a_device_that_falls_silent_is_asked_once_more_and_waited_for_no_longer() {
    let heard = with_board(false, |mut link| {
        silence(&mut link);
        // One question in vain takes 1500 ms.
        let mut patience = link.patience(ms(1000));
        let silent = LinkError::NoSamples { waited_ms: 100 };
        assert_eq!(link.silent(ms(100)), silent);
        // Nothing that follows waits for it: neither a question nor the end of the link.
        assert!(link.statistics().is_err() && link.disarm().is_err());
        assert!(!link.is_silent(&mut patience), "{patience:?}");
        drop(link);
    });
    // A try or two, and one for each that let it go.
    let disarms = heard.iter().filter(|request| **request == Request::Disarm);
    assert!((3..=4).contains(&disarms.count()), "{heard:?}");
}

#[test]
fn a_device_that_answers_and_sends_no_samples_is_held_up() {
    with_board(true, |mut link| {
        silence(&mut link);
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
    with_board(false, |mut link| {
        let began = Moment::now();
        let read: Result<Reading<f64, 1>, SerialError> = link.read_or_stop(&AtomicBool::new(false));
        let silent = LinkError::NoSamples { waited_ms: 2000 };
        assert_eq!(read.expect_err("silent"), silent.into());
        drop(link);
        let took = began.elapsed();
        assert!((ms(2000)..ms(2500)).contains(&took), "{took:?}");
    });
}

#[test]
fn a_line_that_has_ended_is_listened_to_no_more() {
    let (here, far_end) = Pipe::pair();
    let stop = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let board = scope.spawn(|| emulate(Box::new(far_end), &ideal(), &stop));
        let mut link = SerialLink::to_line(Box::new(here), "board", None).expect("answers");
        stop.store(true, Ordering::Relaxed);
        board.join().expect("no panic").expect("a good device");
        let over = std::iter::repeat_with(|| link.hear(testkit::PATIENCE));
        let over = over
            .flatten()
            .find(|heard| matches!(heard, DeviceMessage::Over(_)));
        assert_eq!(over, Some(DeviceMessage::Over(LinkError::Gone)));
        // Nobody listens: it would be waited for without end.
        assert_eq!(link.hear(testkit::PATIENCE), None);
        assert!(link.wait_for_rest() && !link.answers_again());
    });
}
