//! Faults, silence and stops.

use super::{armed, fault, started};
use crate::line::{Bench, START};
use haptic_link::{BatchItem, Field, Refusal, Request, Sample, Start, State};
use haptic_loop::Fault;

#[test]
fn silence_latches_a_fault_and_the_force_falls_to_zero() {
    let mut bench = started(START);
    bench.run_ms(100);
    assert!(bench.force_n() < -0.9);
    bench.host_dead = true;
    // 20 ms of silence, then 1 N at 10 000 N/s: one tick.
    bench.run_ms(26);
    assert_eq!(bench.state(), State::Fault);
    assert_eq!(bench.force_n(), 0.0);
    assert_eq!(fault(&bench), Some(Fault::HostSilent));
    // The host comes back, looks, and only then arms again.
    bench.host_dead = false;
    assert_eq!(
        bench.refused(Request::Start(START)),
        Refusal::State(State::Fault)
    );
    assert_eq!(
        bench.refused(Request::Arm { faults: 0 }),
        Refusal::UnknownFault
    );
    bench.done(Request::Arm { faults: 1 });
    bench.done(Request::Start(Start { run: 2, ..START }));
    bench.run_ms(100);
    assert_eq!(bench.state(), State::Running);
}

#[test]
fn an_idle_device_does_not_mind_silence() {
    let mut bench = Bench::ideal();
    bench.hello();
    bench.host_dead = true;
    bench.run_ms(2000);
    assert_eq!(bench.state(), State::Idle);
}

#[test]
fn stop_and_disarm_work_in_every_state() {
    let mut bench = Bench::ideal();
    bench.hello();
    assert_eq!(bench.refused(Request::Stop), Refusal::State(State::Idle));
    bench.done(Request::Disarm);
    let mut bench = armed();
    bench.done(Request::Stop);
    assert_eq!(bench.state(), State::Armed);
    bench.done(Request::Start(START));
    bench.run_ms(100);
    bench.done(Request::Stop);
    bench.run_ms(10);
    assert_eq!((bench.state(), bench.force_n()), (State::Armed, 0.0));
    bench.done(Request::Start(Start { run: 2, ..START }));
    bench.run_ms(100);
    bench.done(Request::Disarm);
    bench.done(Request::Disarm);
    bench.run_ms(10);
    assert_eq!((bench.state(), bench.force_n()), (State::Idle, 0.0));
    bench.device.borrow_mut().trip(Fault::EmergencyStop);
    assert_eq!(bench.refused(Request::Stop), Refusal::State(State::Fault));
    bench.done(Request::Disarm);
    assert_eq!(bench.state(), State::Fault);
}

#[test]
fn a_board_that_fails_at_a_tick_lets_go_at_once_and_can_be_armed_when_it_is_mended() {
    let fails = |bench: &mut Bench, reads: bool, fails: bool| {
        let mut device = bench.device.borrow_mut();
        let board = device.hardware_mut();
        *(if reads {
            &mut board.broken
        } else {
            &mut board.stuck
        }) = fails;
    };
    for (reads, fault) in [
        (true, Fault::EmergencyStop),
        (false, Fault::CurrentMismatch),
    ] {
        for lasts in [false, true] {
            let mut bench = started(START);
            bench.run_ms(100);
            assert!(bench.force_n() < -0.5);
            fails(&mut bench, reads, true);
            bench.run_ms(1);
            assert_eq!((bench.state(), bench.fault()), (State::Fault, Some(fault)));
            fails(&mut bench, reads, lasts);
            for tick in 0..50 {
                assert_eq!(bench.force_n(), 0.0, "{fault}, tick {tick}");
                bench.run_ms(1);
            }
            assert_eq!(bench.told_fault().map(|(fault, _)| fault), Some(fault));
            if reads && lasts {
                let persists = Refusal::FaultPersists(fault.code());
                assert_eq!(bench.refused(Request::Arm { faults: 1 }), persists);
            }
            fails(&mut bench, reads, false);
            bench.run_ms(1);
            bench.done(Request::Arm { faults: 1 });
            assert_eq!(bench.state(), State::Armed);
        }
    }
}

#[test]
fn late_ticks_in_a_row_latch_a_fault() {
    let bench = started(START);
    for n in 0..20_u64 {
        bench.device.borrow_mut().overrun();
        assert_eq!(bench.state() == State::Fault, n == 19, "{n}");
    }
}

#[test]
fn the_flight_recorder_keeps_what_led_to_a_fault() {
    let mut bench = started(START);
    bench.run_ms(200);
    let nothing = |bench: &mut Bench| {
        let flight = bench.flight(0);
        flight.count == 0 && flight.sample.axes[..] == [BatchItem::default()]
    };
    assert!(nothing(&mut bench), "no fault has latched");
    let second = bench.refused(Request::ReadFlight { index: 1 });
    assert!(matches!(second, Refusal::Range { .. }), "{second:?}");
    bench.device.borrow_mut().trip(Fault::EmergencyStop);
    bench.run_ms(100);
    let first = bench.flight(0);
    let ticks = (0..first.count).map(|index| bench.flight(index).sample);
    let ticks: Vec<Sample> = ticks.collect();
    assert!(
        ticks
            .windows(2)
            .all(|pair| pair[1].tick == pair[0].tick + 1)
    );
    let faulty = ticks
        .iter()
        .filter(|sample| sample.axes[0].limiters & 4 != 0)
        .count();
    assert!(
        faulty >= 1 && ticks.len() > 24 + faulty,
        "{faulty} of {}",
        ticks.len()
    );
    // It stands still until the fault is cleared.
    bench.run_ms(200);
    let index = first.count;
    assert_eq!(bench.flight(0), first);
    let refusal = bench.refused(Request::ReadFlight { index });
    assert!(matches!(
        refusal,
        Refusal::Range {
            field: Field::FlightIndex,
            ..
        }
    ));
    bench.done(Request::Arm { faults: 1 });
    assert!(nothing(&mut bench), "the fault is cleared");
}
