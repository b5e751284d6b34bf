//! The Pico of `tests/pico`, whose forces are those of the same device half here, bit for bit.

use super::board::samples;
use fracdiff::{Operator, Order, Scheme, Seconds};
use haptic_link::{Capabilities, Configuration, Limits, LoopMode, Refusal, Simulation, Start};
use haptic_loop::{Device, Fault, Reading, SafeForce};
use haptic_remote::serial::{ConnectOptions, SerialLink};
use haptic_remote::{Hardware, TickSide, operator_shape, prepare};
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

/// `tests/pico/run night` runs it, with a hand that swings behind the pins. The ROM's floats round as IEEE 754 demands but
/// have no subnormal numbers: a difference would begin below 1.2e-38.
#[test]
#[ignore = "by night: `.ci/nightly` does it"]
fn by_night_a_pico_has_the_forces_of_the_host_bit_for_bit() {
    let line = std::env::var("PICO_LINE").expect("tests/pico/run night sets PICO_LINE");
    let ticks = std::env::var("PICO_TICKS").expect("and PICO_TICKS");
    let ticks: u32 = ticks.parse().expect("a number");
    let order = Order::new(0.5).expect("valid");
    let scheme: Scheme = "full:1e-6".parse().expect("valid");
    let operator = scheme.build(order, Seconds(1e-3), 200.0);
    let operator: Operator<f32> = operator.expect("fits");
    let (coefficients, values) = operator_shape(&operator).expect("short");
    let options = ConnectOptions {
        patience: Duration::from_secs(20),
        ..ConnectOptions::default()
    };
    let mut link = SerialLink::connect(&line, options).expect("answers");
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
