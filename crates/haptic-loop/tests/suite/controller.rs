//! Safety chain and controller tick.
#![expect(clippy::float_cmp, reason = "exact results are compared exactly")]

use crate::{BARE, T, spring};
use core::convert::Infallible;
use haptic_loop::units::{NewtonSecondsPerMetre, Newtons};
use haptic_loop::{
    Controller, Device, EnergyBounding, Fault, Limiters, PassivityGuard, Reading, SafeForce,
    SafetyChain, SafetyLimits, SafetyState, SpringDamper,
};
use nalgebra::vector;

/// 10 N, 1 N a tick.
fn chain() -> SafetyChain<f64> {
    crate::chain(BARE)
}

type Damper = SpringDamper<f64, crate::Memory>;

fn damped() -> Controller<f64, 1, Damper> {
    Controller::new(spring(100.0, 1.0, 0.5), chain())
}

/// Hands out given positions and keeps the forces.
struct Scripted {
    positions: Vec<f64>,
    forces: Vec<f64>,
}

impl Scripted {
    fn new(positions: Vec<f64>) -> Self {
        Self {
            positions,
            forces: Vec::new(),
        }
    }
}

impl Device<f64, 1> for Scripted {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<f64, 1>, Infallible> {
        let tick = self.forces.len();
        Ok(Reading {
            tick: tick as u64,
            time_s: tick as f64 * T.0,
            position_m: vector![self.positions[tick]],
        })
    }

    fn write(&mut self, force: SafeForce<f64, 1>) -> Result<(), Infallible> {
        self.forces.push(force.newtons()[0]);
        Ok(())
    }
}

#[test]
fn the_force_of_a_tick_is_that_of_its_own_position() {
    let mut device = Scripted::new(vec![0.0, 1e-3, 1e-3]);
    let mut controller = damped();
    let mut engaged = controller.engage(&mut device);
    let samples: Vec<_> = (0..3)
        .map(|_| engaged.tick().expect("infallible"))
        .collect();
    drop(engaged);
    assert_eq!(samples[0].force.newtons()[0], 0.0);
    // f = −(K·x + B·T^(−μ)·x): at once, not one tick late.
    let want = -(100.0 * 1e-3 + 1e-3 * 1e-3_f64.powf(-0.5));
    assert!(
        (device.forces[1] - want).abs() < 1e-15,
        "{} {want}",
        device.forces[1]
    );
    assert_eq!(samples[2].reading.tick, 2);
    assert_eq!(samples[2].environment_force_n[0], device.forces[2]);
}

#[test]
fn ticks_that_did_not_come_reach_the_law_on_the_line_to_the_next() {
    let line_m: Vec<f64> = (0..60).map(|tick| 1e-4 * f64::from(tick)).collect();
    let mut controller = damped();
    let mut all = controller.engage(Scripted::new(line_m.clone()));
    let force_n = |_| all.tick().expect("infallible").environment_force_n[0];
    let want: Vec<f64> = (0..60).map(force_n).collect();
    for missed in [1, 2, 20] {
        let come = line_m.iter().step_by(missed + 1).copied().collect();
        let mut controller = damped();
        let mut engaged = controller.engage(Scripted::new(come));
        for (tick, want) in want.iter().enumerate().step_by(missed + 1) {
            let before = tick
                .checked_sub(missed + 1)
                .map(|before| vector![line_m[before]]);
            let done = match before {
                None => engaged.tick(),
                Some(last_m) => engaged.tick_after(missed as u32, &last_m, None),
            };
            let force_n = done.expect("infallible").environment_force_n[0];
            // Rounding of positions on the line, 1e-18 m, times B·T^(−μ) and K.
            assert!(
                (force_n - want).abs() < 1e-13,
                "{missed}, {tick}: {force_n} {want}"
            );
        }
    }
}

#[test]
fn a_sensor_that_reads_nan_and_a_stop_end_in_zero_force() {
    for stops in [false, true] {
        let mut positions = vec![5e-3; 20];
        positions[5] = if stops { 5e-3 } else { f64::NAN };
        let mut device = Scripted::new(positions);
        let mut controller = damped();
        let mut engaged = controller.engage(&mut device);
        for tick in 0..20 {
            if stops && tick == 5 {
                engaged.controller_mut().stop();
            }
            let sample = engaged.tick().expect("infallible");
            // It is told with the sample, from the tick on that found it.
            let fault = (!stops && tick >= 5).then_some(Fault::NonFiniteForce);
            assert_eq!(sample.fault, fault, "tick {tick}");
        }
        drop(engaged);
        assert!(device.forces[4] < 0.0 && controller.safety().is_at_rest());
        let steps = device.forces.windows(2).map(|f| (f[1] - f[0]).abs());
        assert!(steps.fold(0.0, f64::max) <= 1.0 + 1e-12);
        assert!(device.forces[5..].iter().all(|f| f.is_finite()));
        assert_eq!(device.forces[19], 0.0);
    }
}

#[test]
fn arming_asks_first_and_a_sample_carries_the_energy() {
    let limits = SafetyLimits {
        start_force: Some(Newtons(1.0)),
        guard: Some(PassivityGuard::EnergyBounding(EnergyBounding::of(
            NewtonSecondsPerMetre(3.5),
        ))),
        ..BARE
    };
    let mut controller = Controller::new(spring(100.0, 1.0, 0.5), crate::chain(limits));
    let mut device = Scripted::new(vec![0.02, 0.0, 1e-3, 1e-3]);
    let deep = device.read().expect("infallible");
    let refused = controller.may_start(&deep).expect_err("2 N of the spring");
    assert!(refused.wanted_n > 2.0 && refused.allowed_n == 1.0);
    device.forces.push(0.0);
    let outside = device.read().expect("infallible");
    assert_eq!(controller.may_start(&outside), Ok(()));
    let mut engaged = controller.engage(&mut device);
    for _ in 0..3 {
        let sample = engaged.tick().expect("infallible");
        assert_eq!(
            sample.observed_energy_j,
            engaged.controller().safety().observed_energy_j()
        );
    }
    assert!(engaged.controller().safety().observed_energy_j() > 0.0);
}

#[test]
fn the_first_fault_stays_and_every_code_is_its_own() {
    let mut before = 0;
    for fault in Fault::ALL {
        assert!(fault.code() > before, "{fault:?}");
        before = fault.code();
        assert_eq!(Fault::from_code(fault.code()), Some(fault));
    }
    assert_eq!(Fault::from_code(0), None);
    let mut state = SafetyState::<f64, 1>::default();
    state.trip(Fault::HostSilent);
    state.trip(Fault::EmergencyStop);
    assert_eq!(state.fault(), Some(Fault::HostSilent));
}

#[test]
fn a_jump_is_slewed_and_then_limited() {
    let mut state = SafetyState::default();
    // Long enough for a standstill to be a fault, if somebody looked for one.
    for tick in 1..=500 {
        let (force, limiters) = chain().apply(&mut state, &vector![0.0], &vector![100.0]);
        assert_eq!(force.newtons()[0], f64::from(tick.min(10)));
        assert!(limiters.contains(Limiters::RATE));
        assert_eq!(
            limiters.contains(Limiters::MAGNITUDE),
            tick > 10,
            "tick {tick}"
        );
    }
}
