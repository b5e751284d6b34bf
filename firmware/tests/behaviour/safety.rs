//! The safety chain.

use super::Test;
use haptic_loop::units::{Newtons, NewtonsPerSecond, Seconds};
use haptic_loop::{Fault, Limiters, SafetyChain, SafetyState};
use nalgebra::SVector;

pub(crate) const TESTS: [Test; 3] = [
    (
        "a_force_rises_at_the_rate_limit_up_to_the_magnitude_limit",
        rises,
    ),
    (
        "a_force_that_is_not_finite_latches_a_fault_and_falls_at_the_rate_limit",
        not_finite,
    ),
    ("the_first_fault_stays_until_it_is_cleared", first_fault),
];

/// 2 N at most, 1 N a tick.
fn chain() -> SafetyChain<f32> {
    SafetyChain::new(Newtons(2.0), NewtonsPerSecond(1000.0), Seconds(1e-3)).expect("valid")
}

fn apply(state: &mut SafetyState<f32, 1>, wanted: f32) -> (f32, Limiters) {
    let (force, limiters) = chain().apply(state, &SVector::from([0.0]), &SVector::from([wanted]));
    (force.newtons()[0], limiters)
}

fn rises() {
    let mut state = SafetyState::default();
    assert_eq!(apply(&mut state, 5.0), (1.0, Limiters::RATE));
    let (force, limiters) = apply(&mut state, 2.5);
    assert_eq!(force.to_bits(), 2.0_f32.to_bits());
    assert!(limiters.contains(Limiters::RATE));
    let (force, limiters) = apply(&mut state, 2.5);
    assert_eq!(force.to_bits(), 2.0_f32.to_bits());
    assert!(limiters.contains(Limiters::MAGNITUDE));
}

fn not_finite() {
    for wrong in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut state = SafetyState::default();
        for _ in 0..3 {
            apply(&mut state, 5.0);
        }
        let (force, limiters) = apply(&mut state, wrong);
        assert_eq!(force.to_bits(), 1.0_f32.to_bits(), "one step down from 2 N");
        assert!(limiters.contains(Limiters::FAULT));
        assert_eq!(state.fault(), Some(Fault::NonFiniteForce));
        let (force, _) = apply(&mut state, 2.0);
        assert_eq!(force.to_bits(), 0, "zero, whatever is wanted");
        assert!(state.is_at_rest());
    }
}

fn first_fault() {
    let mut state = SafetyState::<f32, 1>::default();
    state.trip(Fault::EmergencyStop);
    apply(&mut state, f32::NAN);
    assert_eq!(state.fault(), Some(Fault::EmergencyStop));
    state.clear();
    assert_eq!(apply(&mut state, 0.5), (0.5, Limiters::NONE));
}
