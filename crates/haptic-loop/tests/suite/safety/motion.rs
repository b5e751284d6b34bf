//! Limits of place and speed: braked in the soft zone, a fault beyond the hard end.

use super::{T, chain, workspace};
use crate::{BARE, apply, spring};
use fracdiff::Seconds;
use haptic_loop::units::{Hertz, Metres, MetresPerSecond, NewtonSecondsPerMetre, Newtons};
use haptic_loop::{
    Controller, EnergyBounding, Fault, Limiters, PassivityGuard, SafetyChain, SafetyLimits,
    SafetyState, SpeedLimit, Stuck, Workspace,
};
use nalgebra::SVector;

/// Along each axis of devices of one, two and three.
macro_rules! on_each_axis {
    ($look:ident) => {{
        $look::<1>(0);
        (0..2).for_each($look::<2>);
        (0..3).for_each($look::<3>);
    }};
}

/// This along an axis, and that on the others.
fn along<const D: usize>(axis: usize, value: f64, others: f64) -> SVector<f64, D> {
    SVector::from_fn(|at, _| if at == axis { value } else { others })
}

/// The force is this along the axis, and none on the others.
#[track_caller]
fn assert_along<const D: usize>(force: &SVector<f64, D>, axis: usize, want: f64) {
    let off = (force - along(axis, want, 0.0)).amax();
    assert!(off < 1e-9, "axis {axis} of {D}: {force}, not {want}");
}

#[test]
fn an_outward_motion_is_braked_in_the_soft_zone_and_beyond_it_is_a_fault() {
    on_each_axis!(brakes_in_the_soft_zone);
}

fn brakes_in_the_soft_zone<const D: usize>(axis: usize) {
    let on_all = workspace();
    let wide = Workspace {
        low: Metres(-9.0),
        high: Metres(9.0),
        soft: Metres(0.0),
    };
    let mut on_one = [wide; 3];
    on_one[axis] = on_all.workspace.expect("is on");
    let on_one = SafetyLimits {
        // The box goes before it.
        workspace: Some(Workspace {
            high: Metres(-8.0),
            ..wide
        }),
        workspace_box: Some(on_one),
        ..on_all
    };
    // One axis has no box.
    for limits in &[on_all, on_one][..D.min(2)] {
        let chain = chain(*limits);
        for (sign, offset) in [(1.0, 0.0), (-1.0, 0.1)] {
            let mut state = SafetyState::<f64, D>::default();
            let mut apply = |x: f64, wanted: f64| {
                let (position, wanted) = (
                    along(axis, offset + sign * x, 0.05),
                    along(axis, wanted, 0.0),
                );
                let (force, limiters) = chain.apply(&mut state, &position, &wanted);
                (*force.newtons(), limiters, state.fault())
            };
            // 0.1 m/s from the middle outwards.
            for tick in 0..=500 {
                let x = 0.05 + 1e-4 * f64::from(tick);
                let (force, limiters, fault) = apply(x, 0.0);
                let depth = ((x - 0.08) / 0.02).max(0.0);
                assert_along(&force, axis, -sign * depth * 5.0 * 0.1);
                if (x - 0.08).abs() > 1e-9 {
                    assert_eq!(limiters.contains(Limiters::WORKSPACE), depth > 0.0, "{x}");
                }
                assert_eq!(fault.is_some(), x > 0.1 + 1e-12, "{x}");
            }
            // Inwards nothing brakes.
            let (force, limiters, _) = apply(0.09, 0.0);
            assert_eq!((force.amax(), limiters), (0.0, Limiters::NONE));
            assert_eq!(apply(0.1001, 2.0).2, Some(Fault::Workspace));
        }
    }
}

#[test]
fn each_limit_of_the_motion_is_kept_with_no_other_beside_it() {
    on_each_axis!(keeps_each_limit);
}

fn keeps_each_limit<const D: usize>(axis: usize) {
    let place = Workspace {
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
    type Change<'a> = &'a dyn Fn(&mut SafetyLimits);
    let changes: [(Change, Fault); 4] = [
        (&|it| it.workspace = Some(place), Fault::Workspace),
        (&|it| it.speed = Some(speed), Fault::Velocity),
        (
            &|it| (it.speed, it.jump) = (Some(speed), Some(Metres(1e-3))),
            Fault::PositionJump,
        ),
        (&|it| it.stuck = Some(stuck), Fault::PositionStuck),
    ];
    for (change, fault) in changes {
        let mut limits = BARE;
        change(&mut limits);
        let chain = chain(limits);
        for sign in [1.0, -1.0] {
            let mut state = SafetyState::<f64, D>::default();
            // 20 m/s to 0.2 m, then a force that grows against a reading that does not change; the other axes go at 0.1 m/s.
            for tick in 0..40 {
                let tick = f64::from(tick);
                let position = along(axis, sign * (0.02 * tick).min(0.2), 1e-4 * tick);
                let wanted = along(axis, -sign * (tick - 15.0).max(0.0), 0.0);
                chain.apply(&mut state, &position, &wanted);
            }
            assert_eq!(state.fault(), Some(fault), "axis {axis} of {D}");
            // Between two ticks too.
            let controller = Controller::<_, D, _>::new(spring(0.0, 1.0, 0.5), chain);
            let strays = controller.strays(&along(axis, 0.2 * sign, 0.0)).err();
            assert_eq!(strays, limits.workspace.map(|_| fault));
        }
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
    on_each_axis!(follows_the_velocity);
}

fn follows_the_velocity<const D: usize>(axis: usize) {
    let chain = chain(SafetyLimits {
        braking: Some(NewtonSecondsPerMetre(5.0)),
        ..BARE
    });
    let mut state = SafetyState::<f64, D>::default();
    for tick in 0..50 {
        // 0.2 m/s: v[n] = 0.2·(1 − e^(−ωTn))
        let position = along(axis, 3.0 + 2e-4 * f64::from(tick), 1.0);
        chain.apply(&mut state, &position, &along(axis, 0.0, 0.0));
        let want = 0.2 * (1.0 - (-std::f64::consts::TAU * 50.0 * 1e-3 * f64::from(tick)).exp());
        assert_along(state.velocity_m_per_s(), axis, want);
    }
    // After a stop it brakes.
    state.stop();
    let (force, _) = chain.apply(&mut state, &along(axis, 3.01, 1.0), &along(axis, 0.0, 0.0));
    assert_along(force.newtons(), axis, -5.0 * state.velocity_m_per_s()[axis]);
}

#[test]
fn too_fast_is_braked_and_then_a_fault() {
    on_each_axis!(brakes_what_is_too_fast);
}

fn brakes_what_is_too_fast<const D: usize>(axis: usize) {
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
        let mut state = SafetyState::<f64, D>::default();
        let mut x = 0.0;
        let none = along(axis, 0.0, 0.0);
        for (speed, share) in [(0.9, 0.0), (1.5, 0.5), (1.99, 0.99)] {
            for _ in 0..2 {
                x += sign * speed * T.0;
                let (force, limiters) = chain.apply(&mut state, &along(axis, x, 0.0), &none);
                let moves = state.velocity_m_per_s()[axis] != 0.0;
                let want = if moves {
                    -sign * share * 0.1 * speed
                } else {
                    0.0
                };
                assert_along(force.newtons(), axis, want);
                assert_eq!(limiters.contains(Limiters::VELOCITY), want != 0.0);
            }
        }
        assert_eq!(state.fault(), None);
        chain.apply(&mut state, &along(axis, x + sign * 2.01 * T.0, 0.0), &none);
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
    let mut state = SafetyState::default();
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
