//! Sessions over a good line: states, transactions, streams, watchdog.

mod faults;
mod starts;
mod transactions;

use crate::line::{Bench, START, spring};
use haptic_emulator::LineFaults;
use haptic_link::{
    Alive, DeviceReport, EventKind, FRAME_MAX, Header, LoopMode, OperatorForm, OperatorShape,
    Refusal, Request, Sample, SimulationKind, Start, State, Status, encode,
};
use haptic_loop::Fault;
use haptic_remote::{Conversation, DeviceOperator, Incoming, LinkError};
use testkit::{Tested, assert_says};

fn fault(bench: &Bench) -> Option<Fault> {
    bench.told_fault().map(|(fault, _)| fault)
}

/// Connected, configured, armed, kept alive.
fn armed() -> Bench {
    let (configuration, values) = spring();
    let mut bench = Bench::configured(configuration, &values);
    bench.arm();
    bench
}

/// A loop on the host, which answers each position with this force, armed.
fn armed_host_loop(law: fn(f32) -> f32) -> Bench {
    let (mut configuration, values) = spring();
    configuration.loop_mode = LoopMode::Host;
    let mut bench = Bench::configured(configuration, &values);
    bench.arm();
    bench.law = Some(law);
    bench
}

/// A run of so many ticks, started.
fn started(start: Start) -> Bench {
    let mut bench = armed();
    bench.done(Request::Start(start));
    bench
}

#[test]
fn a_device_at_power_up_makes_no_force_and_waits() {
    let mut bench = Bench::ideal();
    bench.run_ms(50);
    assert_eq!(bench.state(), State::Idle);
    assert_eq!(bench.force_n(), 0.0);
    assert!(bench.reports.is_empty());
    let DeviceReport::Hello(hello) = bench.hello() else {
        panic!("not a hello");
    };
    assert_ne!(hello.connection, 0);
    let keys = bench.done(Request::GetKeys);
    assert_eq!(keys, DeviceReport::Keys(haptic_link::Keys::current()));
    assert_eq!(hello.status.state, State::Idle);
    let DeviceReport::Capabilities(capabilities) = bench.done(Request::GetCapabilities) else {
        panic!("no capabilities");
    };
    assert_eq!(capabilities.board(), "bench");
}

#[test]
fn a_run_sends_every_tick_and_ends_by_itself_with_zero_force() {
    let mut bench = started(Start {
        ticks: 200,
        ..START
    });
    bench.run_ms(150);
    assert_eq!(bench.state(), State::Running);
    assert!(bench.force_n() < -0.9, "{}", bench.force_n());
    bench.run_ms(150);
    assert_eq!(bench.state(), State::Armed);
    let ticks = bench.ticks();
    assert!(ticks.len() >= 200, "{}", ticks.len());
    assert!(ticks.iter().enumerate().all(|(n, &tick)| tick == n as u32));
    let last = bench
        .samples()
        .next_back()
        .map(|sample| sample.axes[0].force_n);
    assert_eq!(last, Some(0.0));
    let kinds = [
        EventKind::Configured,
        EventKind::Armed,
        EventKind::Started,
        EventKind::Finished,
    ];
    assert_eq!(bench.events(), kinds);
    // The event comes after the last sample.
    assert!(matches!(bench.reports.last(), Some(DeviceReport::Event(_))));
    assert_eq!(bench.host.counters().order.lost, 0);
}

#[test]
fn a_sensed_force_comes_with_its_sample_in_every_form_and_none_comes_without_a_sensor() {
    for (batch, sensed_n) in [(1, 0.5), (16, 0.5), (5, 0.5), (1, f32::NAN), (16, f32::NAN)] {
        let mut bench = armed();
        bench.device.borrow_mut().hardware_mut().sensed_n = sensed_n;
        let start = Start { batch, ..START };
        bench.done(Request::Start(start));
        bench.run_ms(200);
        bench.host_dead = true;
        bench.run_ms(400);
        bench.host_dead = false;
        assert_eq!(fault(&bench), Some(Fault::HostSilent));
        let mut sent: Vec<Sample> = bench.samples().cloned().collect();
        let most = if sensed_n.is_nan() { 16 } else { 12 };
        for report in &bench.reports {
            if let DeviceReport::Batch(batched) = report {
                assert!(
                    batched.items.len() <= most.min(usize::from(batch)),
                    "{batched:?}"
                );
                sent.extend(batched.samples(1000));
            }
        }
        assert!(sent.len() > 300, "{}", sent.len());
        let flight = bench.flight(3).sample;
        for sample in sent.iter().chain([&flight]) {
            // The start of a run looks at the board once more before its first tick.
            let want = (!sensed_n.is_nan()).then_some(sensed_n + 1.0 + sample.tick as f32);
            assert!(sample.sensed_force_n.iter().copied().eq(want), "{sample:?}");
        }
    }
}

#[test]
fn the_force_of_a_device_loop_is_that_of_the_same_loop_on_the_host() -> Tested {
    use haptic_loop::{
        Controller, SafetyChain, Wall,
        units::{Newtons, NewtonsPerSecond, Seconds},
    };
    let mut bench = started(Start {
        ticks: 500,
        ..START
    });
    bench.run_ms(700);
    let (configuration, values) = spring();
    let operator = DeviceOperator::new(fracdiff::portable::Form::Taps, 0, &values)?;
    let wall = Wall::new(1000.0, 2.0, operator, None)?;
    let chain = SafetyChain::new(Newtons(10.0), NewtonsPerSecond(1e4), Seconds(1e-3));
    let mut controller = Controller::<f32, 1, _>::new(wall, chain?);
    let mass_kg = f64::from(configuration.simulation.mass_kg);
    let mut plant = testkit::device::plant(testkit::device::ideal(mass_kg, 3.5, 1e-3));
    plant.set_external_force(nalgebra::vector![1.0]);
    let mut engaged = controller.engage(plant);
    let mut compared = 0;
    for sample in bench.samples() {
        if sample.tick >= 500 {
            break;
        }
        let here = engaged.tick()?;
        assert_eq!(
            here.reading.position_m[0], sample.axes[0].position_m,
            "{}",
            sample.tick
        );
        assert_eq!(
            here.force.newtons()[0],
            sample.axes[0].force_n,
            "{}",
            sample.tick
        );
        compared += 1;
    }
    assert_eq!(compared, 500);
    Ok(())
}

#[test]
fn a_device_that_reboots_is_noticed() {
    let mut bench = started(START);
    bench.run_ms(100);
    bench.reboot();
    // Its numbers start anew, which takes eight keep-alives to believe.
    bench.run_ms(60);
    assert!(bench.rebooted);
}

#[test]
fn a_device_that_is_not_there_is_reported_whatever_it_sent_before() {
    for before in [false, true] {
        let mut bench = Bench::ideal();
        if before {
            bench.hello();
            bench.done(Request::GetCapabilities);
        }
        let all = LineFaults {
            drop: 1.0,
            ..LineFaults::default()
        };
        bench.to_device.set_faults(all).expect("valid");
        bench.to_host.set_faults(all).expect("valid");
        let error = bench
            .ask(Request::GetCapabilities)
            .expect_err("nobody answers");
        let LinkError::NoAnswer { request, .. } = error else {
            panic!("{error}");
        };
        assert_eq!(request, "get-capabilities");
        let message = error.to_string();
        assert_says(&message, "nothing came: check");
    }
}

/// What came in an earlier turn of a greeting is told, though the last turn was silent; an echo and another version too.
#[test]
fn a_greeting_in_vain_is_judged_by_all_of_its_turns() {
    let garbage = b"AT+OK\r\n\0garbage\0".as_slice();
    let mut line = [0; FRAME_MAX];
    let length = Conversation::new(50_000).ask(Request::Hello { nonce: 1 }, 0, &mut line);
    for (heard, words) in [
        (b"".as_slice(), "nothing came; is this the right port"),
        (garbage, "only garbage came"),
        (b"$GPGGA,123519,4807.038,N\r\n", "only garbage came"),
        (&line[..length], "echoes"),
    ] {
        let mut host = Conversation::new(50_000);
        let mut out = [0; FRAME_MAX];
        for turn in 0..3 {
            host.ask(Request::Hello { nonce: 1 }, 100_000 * turn, &mut out);
            let again = host.due(100_000 * turn + 60_000, &mut out);
            again.expect("nothing was heard in this turn");
            // After the second try, so late that no turn is left to look at it.
            if turn == if heard == garbage { 1 } else { 2 } {
                for &byte in heard {
                    host.receive(byte, 0);
                }
            }
        }
        let message = host.no_answer().to_string();
        assert_says(&message, words);
    }
}

#[test]
fn an_indentation_is_imposed_by_the_device_itself() {
    let (mut configuration, _) = spring();
    configuration.operator = OperatorShape {
        form: OperatorForm::Taps,
        integer: 0,
        count: 1,
    };
    configuration.dissipation_n_s_mu_per_m = 0.0;
    configuration.simulation.kind = SimulationKind::RigidIndentation;
    configuration.simulation.depth_m = 1e-3;
    configuration.simulation.ramp_time_s = 0.1;
    let mut bench = Bench::configured(configuration, &[1.0]);
    bench.arm();
    bench.done(Request::Start(START));
    bench.run_ms(300);
    for sample in bench.samples() {
        let want = 1e-3 * (f64::from(sample.tick) / 100.0).min(1.0);
        assert!((f64::from(sample.axes[0].position_m) - want).abs() < 1e-9);
    }
}

impl Bench {
    /// What a device has at power-up.
    fn ideal_configuration() -> DeviceReport {
        let mut bench = Self::ideal();
        bench.hello();
        bench.done(Request::GetConfiguration)
    }
}

#[test]
fn a_round_trip_longer_than_the_time_between_two_keep_alives_is_measured() {
    let mut host = Conversation::new(50_000);
    let mut line = [0; FRAME_MAX];
    host.set_keep_alive(Some(5_000));
    // Each answer comes 13 ms after its question, when two more have been asked.
    let mut measured = Vec::new();
    for ms in 0..100_u32 {
        let now_us = 1000 * u64::from(ms);
        host.due(now_us, &mut line).expect("nothing was asked");
        let Some(answered) = ms
            .checked_sub(13)
            .filter(|asked| asked % 5 == 0 && *asked > 0)
        else {
            continue;
        };
        let alive = DeviceReport::Alive(Alive {
            token: answered / 5,
            time_us: 1000 * u64::from(answered),
            status: Status::default(),
            observed_energy_j: 0.0,
        });
        let header = Header::from_device(answered as u16);
        let length = encode(&alive, header, &mut line).expect("it fits");
        for &byte in &line[..length] {
            match host.receive(byte, now_us) {
                Some(Incoming::Alive {
                    round_trip_us,
                    newest,
                    ..
                }) => measured.push((round_trip_us, newest)),
                other => assert_eq!(other, None),
            }
        }
    }
    // What is said of an older question is not how far the device is.
    assert_eq!(measured, vec![(13_000, false); 17]);
}

#[test]
fn parameters_cannot_change_under_a_closed_loop() {
    let mut bench = armed();
    let (mut other, values) = spring();
    other.stiffness_n_per_m = 900.0;
    let before = bench.done(Request::GetConfiguration);
    assert_eq!(bench.set(other, &values), Err(Refusal::State(State::Armed)));
    bench.done(Request::Start(START));
    assert_eq!(
        bench.set(other, &values),
        Err(Refusal::State(State::Running))
    );
    assert_eq!(bench.done(Request::GetConfiguration), before);
}
