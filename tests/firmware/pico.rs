//! The Pico of `tests/pico`, whose forces are those of the same device half here, bit for bit.

use super::board::samples;
use fracdiff::{Operator, Order, Scheme, Seconds};
use fractional_control::{Controller, ControllerSetup, FractionalPid, PidParameters};
use haptic_link::{Capabilities, Configuration, Limits, LoopMode, Refusal, Simulation, Start};
use haptic_loop::{Device, Fault, Reading, SafeForce};
use haptic_remote::serial::{ConnectOptions, SerialLink};
use haptic_remote::{Hardware, TickSide, controller_law, operator_shape, prepare};
use nalgebra::Vector1;
use std::time::Duration;

/// A board that was there already: it reads what another one has read.
struct Replay {
    capabilities: Capabilities,
    positions_m: Vec<f32>,
    next: usize,
}

impl Device<f32, 1> for Replay {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, 1>, Fault> {
        let tick = self.next;
        let position = self.positions_m.get(tick).copied();
        self.next += 1;
        Ok(Reading {
            tick: tick as u64,
            time_s: 1e-3 * tick as f64,
            position_m: Vector1::new(position.unwrap_or_default()),
        })
    }

    fn write(&mut self, _: SafeForce<f32, 1>) -> Result<(), Fault> {
        Ok(())
    }
}

impl Hardware for Replay {
    type Setup = ();

    fn capabilities(&self) -> Capabilities {
        self.capabilities
    }

    fn prepare(_: &Simulation, _: u32) -> Result<(), Refusal> {
        Ok(())
    }

    fn install(&mut self, (): (), _: u32) {}

    fn restart(&mut self) {
        self.next = 0;
    }

    fn idle(&mut self) -> Result<Reading<f32, 1>, Fault> {
        self.next = 0;
        let reading = self.read();
        self.next = 0;
        reading
    }
}

/// The Pico of `PICO_LINE`, and `PICO_TICKS`.
fn pico() -> (SerialLink, u32) {
    let line = std::env::var("PICO_LINE").expect("tests/pico/run night sets PICO_LINE");
    let ticks = std::env::var("PICO_TICKS").expect("and PICO_TICKS");
    let options = ConnectOptions {
        patience: Duration::from_secs(20),
        ..ConnectOptions::default()
    };
    let link = SerialLink::connect(&line, options).expect("answers");
    (link, ticks.parse().expect("a number"))
}

/// `tests/pico/run night` runs it: a controller that holds the handle, the longest for which a tick of 1 ms has the time.
#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_a_pico_has_the_bits_of_the_hosts_controller_within_its_promised_tick() {
    const RAMP_TICKS: u32 = 400;
    let (mut link, ticks) = pico();
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
        let law = controller_law(&setup, (3e-3, RAMP_TICKS), 5.0).expect("a law");
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
    let refused = link.set_controller(configuration, &values, &long);
    let refused = refused.expect_err("too long for it").to_string();
    assert!(refused.contains("sample time (ms) 1 is not"), "{refused}");

    let (setup, configuration, values, short) = law("full:1e-4");
    link.set_controller(configuration, &values, &short)
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
fn by_night_a_pico_has_the_forces_of_the_host_bit_for_bit() {
    let order = Order::new(0.5).expect("valid");
    let scheme: Scheme = "full:1e-6".parse().expect("valid");
    let operator = scheme.build(order, Seconds(1e-3), 200.0);
    let operator: Operator<f32> = operator.expect("fits");
    let (coefficients, values) = operator_shape(&operator).expect("short");
    let (mut link, ticks) = pico();
    let capabilities = *link.capabilities();
    let configuration = Configuration {
        loop_mode: LoopMode::Device,
        stiffness_n_per_m: 200.0,
        dissipation_n_s_mu_per_m: 5.0,
        order: 0.5,
        operator: coefficients,
        limits: Limits {
            force_n: capabilities.force_max_n,
            watchdog_ms: 1000,
            late_ticks: 0,
            ..Limits::DEFAULT
        },
        ..Configuration::PASSIVE
    };
    link.set(configuration, &values).expect("good");
    link.arm(Duration::from_secs(5)).expect("arms");
    let start = Start {
        ticks,
        ..Start::ENDLESS
    };
    link.start(start).expect("starts");
    let seen = samples(&mut link);
    assert!(seen.len() >= ticks as usize, "{} samples", seen.len());

    let replay = Replay {
        capabilities,
        positions_m: seen
            .iter()
            .map(|sample| sample.axes[0].position_m)
            .collect(),
        next: 0,
    };
    let mut host = TickSide::new(replay).expect("starts");
    let prepared = prepare::<Replay, 1>(configuration, &values, &capabilities).expect("good");
    host.install(prepared, &values).expect("idle");
    host.arm(0).expect("nothing is wrong");
    host.start(start).expect("armed");
    let mut moved = 0;
    for (sample, tick) in seen.iter().zip(0..ticks) {
        assert_eq!(sample.tick, tick, "a sample is missing");
        let now_us = 1000 * u64::from(tick + 1);
        host.heard(now_us, false);
        host.tick(now_us);
        while host.next_report().is_some() {}
        let (force, here) = (sample.axes[0].force_n, host.newest().force_n[0]);
        assert_eq!(
            force.to_bits(),
            here.to_bits(),
            "tick {tick}: {force:e}, here {here:e}"
        );
        moved += usize::from(force.abs() > 0.05);
    }
    assert!(moved > seen.len() / 2, "no force in most ticks");
    println!("{ticks} ticks, {moved} of them above 50 mN: the same bits");
}
