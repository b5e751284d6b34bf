//! Starts whose answer is late or lost.

use super::{armed, armed_host_loop, fault, started};
use crate::line::{Bench, START};
use haptic_emulator::LineFaults;
use haptic_link::{
    DeviceReport, Event, EventKind, FRAME_MAX, Header, Refusal, Request, Start, State, encode,
};
use haptic_remote::Incoming;

#[test]
fn a_start_that_is_sent_again_does_not_begin_anew() {
    let mut bench = started(START);
    bench.run_ms(20);
    bench.done(Request::Start(START));
    bench.run_ms(20);
    assert!(bench.ticks().windows(2).all(|pair| pair[1] == pair[0] + 1));
    let other = Request::Start(Start { run: 9, ..START });
    assert_eq!(bench.refused(other), Refusal::State(State::Running));
}

#[test]
fn a_start_that_is_sent_again_after_its_run_has_ended_starts_nothing() {
    let mut bench = armed();
    let start = Start { ticks: 20, ..START };
    bench.done(Request::Start(start));
    bench.run_ms(100);
    assert_eq!(bench.state(), State::Armed);
    bench.done(Request::Start(start));
    bench.run_ms(10);
    assert_eq!(bench.state(), State::Armed);
    assert_eq!(bench.events().last(), Some(&EventKind::Finished));
    // Another run, which is still stopping when its start comes again.
    let second = Start { run: 2, ..START };
    bench.done(Request::Start(second));
    bench.run_ms(200);
    bench.done(Request::Stop);
    bench.done(Request::Start(second));
    bench.run_ms(50);
    assert_eq!(bench.state(), State::Armed);
    // Armed anew, numbers may begin anew.
    bench.done(Request::Disarm);
    bench.done(Request::Arm { faults: 0 });
    bench.done(Request::Start(start));
    assert_eq!(bench.state(), State::Running);
}

/// Asks for a start whose answer the line loses, and all else for so long.
fn start_unheard(bench: &mut Bench, lost_ms: u64) -> DeviceReport {
    let lost = LineFaults {
        drop: 1.0,
        ..LineFaults::default()
    };
    bench.to_host.set_faults(lost).expect("valid");
    let mut line = [0; FRAME_MAX];
    let length = (bench.host).ask(Request::Start(START), bench.now_us, &mut line);
    bench.to_device.send(&line[..length], bench.now_us);
    bench.run_ms(lost_ms);
    assert!(bench.host.is_waiting(), "nothing came");
    let good = LineFaults::default();
    bench.to_host.set_faults(good).expect("valid");
    loop {
        if let Some(answer) = bench.step().expect("the line works") {
            return answer.expect("taken");
        }
    }
}

#[test]
fn the_first_sample_of_a_run_answers_its_start_so_that_a_loop_on_the_host_answers_in_time() {
    let mut bench = armed_host_loop(|_| -0.5);
    // The watchdog has 20 ms, another try comes after 50 ms.
    let asked_us = bench.now_us;
    let answer = start_unheard(&mut bench, 5);
    assert!(matches!(answer, DeviceReport::Sample(_)), "{answer:?}");
    assert!(bench.now_us - asked_us < 10_000, "{}", bench.now_us);
    bench.run_ms(200);
    assert_eq!((fault(&bench), bench.state()), (None, State::Running));
    assert_eq!(bench.force_n(), -0.5);
    assert_eq!(bench.host.counters().retries, 0);
}

/// What the host makes of a frame of the device that is so far ahead of those that came.
fn heard(bench: &mut Bench, report: &DeviceReport, ahead: u16) -> Option<Incoming> {
    let mut line = [0; FRAME_MAX];
    let sequence = (bench.host.counters().line.received as u16).wrapping_add(ahead);
    let length = encode(report, Header::from_device(sequence), &mut line).expect("fits");
    let bytes = line[..length].iter();
    bytes.fold(None, |heard, &byte| {
        bench.host.receive(byte, bench.now_us).or(heard)
    })
}

#[test]
fn only_what_is_heard_of_the_new_run_answers_its_start() {
    let mut bench = started(START);
    bench.run_ms(100);
    bench.done(Request::Stop);
    bench.run_ms(200);
    let mut sample = bench.samples().next_back().expect("it ran").clone();
    let event = |kind| {
        DeviceReport::Event(Event {
            kind,
            tick: 0,
            time_us: 0,
        })
    };
    let mut line = [0; FRAME_MAX];
    let mut ask = |bench: &mut Bench, run| {
        let start = Request::Start(Start { run, ..START });
        bench.host.ask(start, bench.now_us, &mut line);
    };
    ask(&mut bench, 2);
    // The last of the run before, late.
    sample.tick += 1;
    for (ahead, old) in [
        (10, DeviceReport::Sample(sample.clone())),
        (20, event(EventKind::Stopped)),
    ] {
        let old = heard(&mut bench, &old, ahead);
        assert!(matches!(old, Some(Incoming::Report(_))), "{old:?}");
    }
    assert!(bench.host.is_waiting());
    // Its ticks count anew.
    sample.tick = 0;
    let new = heard(&mut bench, &DeviceReport::Sample(sample), 30);
    assert!(matches!(new, Some(Incoming::Begun(_))), "{new:?}");
    assert!(!bench.host.is_waiting());
    // The device says so.
    ask(&mut bench, 3);
    let new = heard(&mut bench, &event(EventKind::Started), 40);
    assert!(matches!(new, Some(Incoming::Begun(_))), "{new:?}");
    assert!(!bench.host.is_waiting());
}
