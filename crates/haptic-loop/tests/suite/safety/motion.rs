//! Limits of place and speed: braked in the soft zone, a fault beyond the hard end.

use super::{BARE, T, chain, workspace};
use crate::apply;
use fracdiff::Seconds;
use haptic_loop::units::{Hertz, Metres, MetresPerSecond, NewtonSecondsPerMetre, Newtons};
use haptic_loop::{
    EnergyBounding, Fault, Limiters, PassivityGuard, SafetyChain, SafetyLimits, SafetyState,
    SpeedLimit, Stuck, Workspace,
};
use nalgebra::vector;

#[test]
fn an_outward_motion_is_braked_in_the_soft_zone_and_beyond_it_is_a_fault() {
    let chain = chain(workspace());
    for (sign, offset) in [(1.0, 0.0), (-1.0, 0.1)] {
        let mut state = SafetyState::<f64, 1>::default();
        // 0.1 m/s from the middle outwards.
        for tick in 0..=500 {
            let x = 0.05 + 1e-4 * f64::from(tick);
            let position = vector![offset + sign * x];
            let (force, limiters) = chain.apply(&mut state, &position, &vector![0.0]);
            let depth = ((x - 0.08) / 0.02).max(0.0);
            assert!(
                (force.newtons()[0] + sign * depth * 5.0 * 0.1).abs() < 1e-9,
                "{x}: {}",
                force.newtons()[0]
            );
            if (x - 0.08).abs() > 1e-9 {
                assert_eq!(limiters.contains(Limiters::WORKSPACE), depth > 0.0, "{x}");
            }
            assert_eq!(state.fault().is_some(), x > 0.1 + 1e-12, "{x}");
        }
        // Inwards nothing brakes.
        let inward = vector![offset + sign * 0.09];
        let (force, limiters) = chain.apply(&mut state, &inward, &vector![0.0]);
        assert_eq!((force.newtons()[0], limiters), (0.0, Limiters::NONE));
        let beyond = vector![offset + sign * 0.1001];
        chain.apply(&mut state, &beyond, &vector![2.0]);
        assert_eq!(state.fault(), Some(Fault::Workspace));
    }
}

#[test]
fn each_limit_of_the_motion_is_kept_with_no_other_beside_it() {
    let workspace = Workspace {
        low: Metres(-0.1),
        high: Metres(0.1),
        soft: Metres(0.0),
    };
    let speed = SpeedLimit {
        soft: MetresPerSecond(0.5),
        hard: MetresPerSecond(1.0),
    };
    let stuck = Stuck {
        force: Newtons(1.0),
        time: Seconds(1e-3),
    };
    let (place, fast, still) = (Fault::Workspace, Fault::Velocity, Fault::PositionStuck);
    for (workspace, speed, stuck, fault) in [
        (Some(workspace), None, None, place),
        (None, Some(speed), None, fast),
        (None, None, Some(stuck), still),
    ] {
        let chain = chain(SafetyLimits {
            workspace,
            speed,
            stuck,
            ..BARE
        });
        let mut state = SafetyState::<f64, 1>::default();
        // 20 m/s to 0.2 m, then a force that grows against a reading that does not change.
        for tick in 0..40 {
            let tick = f64::from(tick);
            let wanted = vector![(tick - 15.0).max(0.0)];
            chain.apply(&mut state, &vector![(0.02 * tick).min(0.2)], &wanted);
        }
        assert_eq!(state.fault(), Some(fault));
    }
}

#[test]
fn a_velocity_beyond_the_number_type_is_a_fault_though_the_way_is_not() {
    let limits = SafetyLimits {
        braking: Some(NewtonSecondsPerMetre(5.0)),
        velocity_bandwidth: Hertz(1e5),
        ..BARE
    };
    let chain = SafetyChain::<f32>::from_limits(&limits, T).expect("valid");
    let mut state = SafetyState::<f32, 1>::default();
    for x in [0.0, 1e36] {
        apply(&chain, &mut state, x, 1.0);
    }
    assert_eq!(state.fault(), Some(Fault::Velocity));
    assert_eq!(state.velocity_m_per_s()[0], 0.0);
}

#[test]
fn the_velocity_is_a_low_pass_of_the_differences() {
    let chain = chain(SafetyLimits {
        braking: Some(NewtonSecondsPerMetre(5.0)),
        ..BARE
    });
    let mut state = SafetyState::<f64, 1>::default();
    for tick in 0..50 {
        // 0.2 m/s: v[n] = 0.2·(1 − e^(−ωTn))
        let position = vector![3.0 + 2e-4 * f64::from(tick)];
        chain.apply(&mut state, &position, &vector![0.0]);
        let want = 0.2 * (1.0 - (-std::f64::consts::TAU * 50.0 * 1e-3 * f64::from(tick)).exp());
        let have = state.velocity_m_per_s()[0];
        assert!((have - want).abs() < 1e-12, "{tick}: {have} {want}");
    }
}

#[test]
fn too_fast_is_braked_and_then_a_fault() {
    let chain = chain(SafetyLimits {
        speed: Some(SpeedLimit {
            soft: MetresPerSecond(1.0),
            hard: MetresPerSecond(2.0),
        }),
        braking: Some(NewtonSecondsPerMetre(0.1)),
        velocity_bandwidth: Hertz(1e5),
        ..BARE
    });
    for sign in [1.0, -1.0] {
        let mut state = SafetyState::<f64, 1>::default();
        let mut x = 0.0;
        for (speed, share) in [(0.9, 0.0), (1.5, 0.5), (1.99, 0.99)] {
            for _ in 0..2 {
                x += sign * speed * T.0;
                let (force, limiters) = chain.apply(&mut state, &vector![x], &vector![0.0]);
                let want = if x.abs() > 0.0 && state.velocity_m_per_s()[0] != 0.0 {
                    -sign * share * 0.1 * speed
                } else {
                    0.0
                };
                assert!((force.newtons()[0] - want).abs() < 1e-9, "{speed}");
                assert_eq!(limiters.contains(Limiters::VELOCITY), want != 0.0);
            }
        }
        assert_eq!(state.fault(), None);
        x += sign * 2.01 * T.0;
        apply(&chain, &mut state, x, 0.0);
        assert_eq!(state.fault(), Some(Fault::Velocity));
    }
}

#[test]
fn a_device_moved_while_nothing_ran_is_not_too_fast_after_clear() {
    let chain = chain(SafetyLimits {
        guard: Some(PassivityGuard::EnergyBounding(EnergyBounding::of(
            NewtonSecondsPerMetre(3.5),
        ))),
        ..SafetyLimits::default()
    });
    let mut state = SafetyState::<f64, 1>::default();
    apply(&chain, &mut state, 0.0, 0.0);
    apply(&chain, &mut state, 1e-4, 0.0);
    assert!(state.observed_energy_j() > 0.0);
    state.stop();
    state.clear();
    apply(&chain, &mut state, 0.3, 0.0);
    assert_eq!(state.fault(), None);
    assert_eq!(state.observed_energy_j(), 0.0);
    // Without a clear it is.
    apply(&chain, &mut state, 0.0, 0.0);
    assert_eq!(state.fault(), Some(Fault::PositionJump));
}
