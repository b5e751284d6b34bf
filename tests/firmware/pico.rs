//! The Pico of `tests/pico`, whose forces are those of the same device half here and on a Cortex-M4F, bit for bit.

use super::board::samples;
use super::image::{Image, built};
use super::{lists, printed, replayed};
use fracdiff::{Order, Seconds, ShortMemory};
use fractional_control::{Controller as _, ControllerSetup, FractionalPid, PidParameters};
use haptic_link::{Configuration, HandSide, Limits, LoopMode, Start};
use haptic_loop::units::{Newtons, NewtonsPerSecond};
use haptic_loop::{Device as _, Reading, SafetyChain};
use haptic_remote::controller_law;
use haptic_remote::serial::{Companions, ConnectOptions, SerialLink};
use haptic_teleoperation::{CouplerGains, Port, PortLaw, Settings};
use std::io::Write as _;
use std::time::Duration;

/// The Pico of `tests/pico/run night`.
fn connected() -> SerialLink {
    let line = std::env::var("PICO_LINE").expect("tests/pico/run night sets PICO_LINE");
    let options = ConnectOptions {
        patience: testkit::PATIENCE,
        ..ConnectOptions::default()
    };
    SerialLink::connect(&line, options).expect("answers")
}

/// Where the image `firmware/tests/replay.rs` looks for positions.
const INPUT: u32 = 0x2100_0000;

/// The digest of the forces on these positions in QEMU.
fn on_the_cortex_m4f(positions_m: &[f32]) -> u32 {
    let images = built().expect("tests/pico/run night needs QEMU");
    let count = u32::try_from(positions_m.len()).expect("fits");
    let words = core::iter::once(count).chain(positions_m.iter().map(|x| x.to_bits()));
    let bytes: Vec<u8> = words.flat_map(u32::to_le_bytes).collect();
    let mut file = tempfile::NamedTempFile::new().expect("a file");
    file.write_all(&bytes).expect("room");
    let device = format!(
        "loader,file={},addr={INPUT:#x},force-raw=on",
        file.path().display()
    );
    let text = printed(&images.run_with(Image::Replay, &["-device".to_owned(), device]));
    let digest = text["full 200 s"].trim_start_matches("0x");
    u32::from_str_radix(digest, 16).expect("a digest")
}

/// `tests/pico/run night` runs it: a controller that holds the handle, the longest for which a tick of 1 ms has the time.
#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_a_pico_has_the_bits_of_the_hosts_controller_within_its_promised_tick() {
    const RAMP_TICKS: u32 = 400;
    let ticks = std::env::var("PICO_TICKS").expect("and PICO_TICKS");
    let ticks: u32 = ticks.parse().expect("a number");
    let mut link = connected();
    let cost = link.controller_cost().expect("it runs controllers");
    let t = Seconds(1e-3);
    let gains = PidParameters {
        proportional: 200.0,
        integral: 600.0,
        integral_order: 0.9,
        derivative: 4.0,
        derivative_order: 0.9,
    };
    let law = |scheme: &str| {
        let setup = ControllerSetup {
            scheme: scheme.parse().expect("valid"),
            output_low: Some(-0.8),
            output_high: Some(0.8),
            ..ControllerSetup::new(gains, t)
        };
        let law = controller_law(&setup, 3e-3, RAMP_TICKS, 5.0).expect("a law");
        let configuration = Configuration {
            operator: law.0,
            limits: Limits {
                force_n: 5.0,
                watchdog_ms: 1000,
                late_ticks: 0,
                ..Limits::DEFAULT
            },
            ..Configuration::PASSIVE
        };
        (setup, configuration, law.1, law.2)
    };
    let (_, configuration, values, long) = law("full-bdf2:1e-6");
    let companions = |law| Companions {
        controller: Some(law),
        ..Companions::default()
    };
    let refused = link.set_run(configuration, &values, companions(&long));
    let refused = refused.expect_err("too long for it").to_string();
    assert!(refused.contains("sample time (ms) 1 is not"), "{refused}");

    let (setup, configuration, values, short) = law("full:1e-4");
    link.set_run(configuration, &values, companions(&short))
        .expect("there is time for it");
    link.arm(Duration::from_secs(5)).expect("arms");
    let start = Start {
        ticks,
        ..Start::ENDLESS
    };
    link.start(start).expect("starts");
    let seen = samples(&mut link);
    let (actuator, memory) = (setup.actuator().expect("valid"), setup.memory());
    let memory = memory.expect("valid").fewest_modes();
    let host = FractionalPid::<f32>::new(gains, setup.set_point, actuator, memory, t);
    let host = host.expect("valid");
    let mut history = host.at_rest();
    for (sample, tick) in seen.iter().zip(0..ticks) {
        assert_eq!(sample.tick, tick, "a sample is missing");
        let axis = &sample.axes[0];
        let r = if tick < RAMP_TICKS {
            3e-3 * (tick as f32 / RAMP_TICKS as f32)
        } else {
            3e-3
        };
        let want = host.output(&history, r, axis.position_m);
        let have = axis.environment_force_n;
        assert_eq!(want.to_bits(), have.to_bits(), "tick {tick}: {want} {have}");
        host.advance(&mut history, r, axis.position_m, axis.force_n);
    }
    let cycles = link.statistics().expect("answers").tick_cycles_max;
    let promised = cost.tick_period_min_us(values.len() as u16) * 125 / 2;
    assert!((1..=promised).contains(&cycles), "{cycles} {promised}");
    println!("{ticks} ticks, at most {cycles} of {promised} cycles: the same bits");
}

/// `tests/pico/run night` runs it, with a hand that swings behind the pins. The ROM's floats round as IEEE 754 demands but
/// have no subnormal numbers: a difference would begin below 1.2e-38.
#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_a_pico_has_the_forces_of_the_host_and_of_a_cortex_m4f_bit_for_bit() {
    let ticks = std::env::var("PICO_TICKS").expect("and PICO_TICKS");
    let ticks: u32 = ticks.parse().expect("a number");
    let list = lists::all().find(|list| list.name == "full 200 s");
    let list = list.expect("a list");
    let mut link = connected();
    let (values, count) = list.values();
    link.set(replayed::configuration(&list), &values[..count])
        .expect("good");
    link.arm(Duration::from_secs(5)).expect("arms");
    let start = Start {
        ticks,
        ..Start::ENDLESS
    };
    link.start(start).expect("starts");
    let mut seen = samples(&mut link);
    assert!(seen.len() >= ticks as usize, "{} samples", seen.len());
    seen.truncate(ticks as usize);

    let positions_m: Vec<f32> = (seen.iter().zip(0..))
        .map(|(sample, tick)| {
            assert_eq!(sample.tick, tick, "a sample is missing");
            sample.axes[0].position_m
        })
        .collect();
    let mut moved = 0;
    let read = |tick: u32| positions_m[tick as usize];
    let host = replayed::forces(&list, ticks, read, |tick, here| {
        let force = seen[tick as usize].axes[0].force_n;
        assert_eq!(
            force.to_bits(),
            here.to_bits(),
            "tick {tick}: {force:e}, here {here:e}"
        );
        moved += u32::from(force.abs() > 0.05);
    });
    assert!(moved > ticks / 2, "no force in most ticks");
    assert_eq!(on_the_cortex_m4f(&positions_m), host, "on the Cortex-M4F");
    println!("{ticks} ticks, {moved} of them above 50 mN: the same bits on all three");
}

/// The slave: 65 g on 3.5 N·s/m in a spring, N/m.
#[derive(Default)]
struct Slave {
    position_m: f64,
    velocity_m_per_s: f64,
}

const SPRING: f64 = 100.0;
const COUPLER: f64 = 200.0;

impl Slave {
    fn push(&mut self, force_n: f64) {
        for _ in 0..10 {
            let net = force_n - 3.5 * self.velocity_m_per_s - SPRING * self.position_m;
            self.velocity_m_per_s += 1e-4 / 0.065 * net;
            self.position_m += 1e-4 * self.velocity_m_per_s;
        }
    }
}

/// `tests/pico/run night` runs it, with a hand that pulls the master, and compares what the hand feels at the pins with two springs in
/// series. Held still that does not depend on how late this process is.
#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_a_pico_is_the_master_of_a_teleoperation() {
    let t = Seconds(1e-3);
    let side = |side| {
        let gains = CouplerGains {
            stiffness_n_per_m: COUPLER,
            dissipation_n_s_mu_per_m: 2.0,
        };
        let operator = ShortMemory::<f64, 2>::new(Order::new(1.0).expect("valid"), t);
        let law = PortLaw::PositionPosition(gains, operator.expect("valid"));
        let settings = Settings {
            side,
            sample_time: t,
            silence: Seconds(Settings::SILENCE_S),
        };
        let chain = SafetyChain::new(Newtons(4.0), NewtonsPerSecond(1000.0), t);
        Port::new(law, settings, chain.expect("valid")).expect("a port")
    };
    let (mut master, mut slave) = (side(HandSide::Master), side(HandSide::Slave));
    let mut link = connected();
    let configuration = Configuration {
        loop_mode: LoopMode::Host,
        limits: Limits {
            watchdog_ms: 1000,
            late_ticks: 0,
            max_age_ticks: 1000,
            force_n: 4.0,
            ..Limits::DEFAULT
        },
        ..Configuration::PASSIVE
    };
    link.set(configuration, &[1.0]).expect("good");
    link.arm(Duration::from_secs(5)).expect("arms");
    let start = Start {
        ticks: 4000,
        ..Start::ENDLESS
    };
    link.start(start).expect("starts");
    let mut remote = Slave::default();
    let mut given_j = [0.0; 2];
    for tick in 0..3900 {
        let reading: Reading<f64, 1> = link.read().expect("a sample");
        let displaced_m = reading.position_m[0];
        let begun = master.begin(reading);
        link.write(begun.force()).expect("there");
        let text = begun.finish().message;
        let begun = slave.begin(Reading {
            tick,
            time_s: 1e-3 * tick as f64,
            position_m: [remote.position_m].into(),
        });
        remote.push(begun.force().newtons()[0]);
        master.receive(&begun.finish().message);
        slave.receive(&text);
        if tick % 1300 == 1299 {
            let share = COUPLER / (COUPLER + SPRING);
            println!("{:.6} m of {displaced_m:.6} m", remote.position_m);
            assert!(
                (remote.position_m - share * displaced_m).abs() < 2e-5,
                "it follows"
            );
        }
        given_j = [master.given_j(), slave.given_j()];
    }
    link.disarm().expect("disarms");
    println!("given {given_j:?} J");
}
