//! Limits of the safety chain: start-up, norm, workspace, speed, and what holds whatever happens.
#![expect(clippy::float_cmp, reason = "exact results are compared exactly")]

mod motion;

use crate::{BARE, T, apply, chain};
use fracdiff::Seconds;
use haptic_loop::units::{
    Hertz, Kilograms, Metres, MetresPerSecond, NewtonSecondsPerMetre, Newtons, NewtonsPerSecond,
};
use haptic_loop::{
    Fault, Limiters, SafetyChain, SafetyLimits, SafetyState, SpeedLimit, StartRefused, Stuck,
    Workspace,
};
use nalgebra::{SVector, vector};
use proptest::prelude::*;

#[test]
fn the_force_rises_in_proportion_to_time_after_start_and_after_clear() {
    // Quarters are exact; the start is over with the sample that has the whole force.
    let chain = chain(SafetyLimits {
        rise_time: Some(Seconds(4e-3)),
        ..BARE
    });
    let mut state = SafetyState::default();
    for _ in 0..2 {
        for tick in 0..50 {
            let (force, limiters) = chain.apply(&mut state, &vector![0.0], &vector![2.0]);
            let share = f64::min(0.25 * f64::from(tick), 1.0);
            let rising = if tick < 4 {
                Limiters::STARTUP
            } else {
                Limiters::NONE
            };
            assert_eq!(
                (force.newtons()[0], limiters),
                (2.0 * share, rising),
                "{tick}"
            );
        }
        state.stop();
        for _ in 0..5 {
            apply(&chain, &mut state, 0.0, 5.0);
        }
        assert!(state.is_at_rest());
        state.clear();
    }
}

#[test]
fn a_start_is_refused_with_too_large_a_force() {
    let chain = chain(SafetyLimits {
        start_force: Some(Newtons(1.0)),
        ..BARE
    });
    assert_eq!(chain.may_start(&vector![0.6, -0.8]), Ok(()));
    let refused = StartRefused {
        wanted_n: 5.0,
        allowed_n: 1.0,
    };
    assert_eq!(chain.may_start(&vector![3.0, -4.0]), Err(refused));
    assert_eq!(
        refused.to_string(),
        "the wanted force of 5 N is not within the 1 N allowed at the start"
    );
    for bad in [f64::NAN, f64::INFINITY] {
        assert!(chain.may_start(&vector![bad]).is_err());
        let any = crate::chain(BARE);
        assert!(any.may_start(&vector![bad]).is_err());
        assert_eq!(any.may_start(&vector![1e9]), Ok(()));
    }
}

#[test]
fn the_norm_is_limited_without_turning_the_force_and_no_force_is_stuck() {
    let limits = SafetyLimits {
        norm: Some(Newtons(5.0)),
        ..BARE
    };
    let chain = chain(limits);
    let mut state = SafetyState::<f64, 2>::default();
    // Along the circle, where a slew of each axis for itself would lead outside, and a box of 10 N would turn the force.
    for angle in 0..360 {
        let (y, x) = (f64::from(angle * 7).to_radians()).sin_cos();
        let wanted = vector![50.0 * x, 50.0 * y];
        let mut last = (SVector::zeros(), Limiters::NONE);
        for _ in 0..30 {
            let (force, limiters) = chain.apply(&mut state, &vector![0.0, 0.0], &wanted);
            last = (*force.newtons(), limiters);
        }
        // 5 N, one millionth less for rounding.
        assert!((last.0 - vector![x, y] * 5.0).norm() < 1e-5, "{last:?}");
        assert_eq!(last.1, Limiters::MAGNITUDE);
    }
}

/// 0 to 100 mm, zones of 20 mm, 5 N·s/m, and a velocity that follows within the tick.
fn workspace() -> SafetyLimits {
    SafetyLimits {
        workspace: Some(Workspace {
            low: Metres(0.0),
            high: Metres(0.1),
            soft: Metres(0.02),
        }),
        braking: Some(NewtonSecondsPerMetre(5.0)),
        velocity_bandwidth: Hertz(1e5),
        ..BARE
    }
}

#[test]
fn a_sensor_stands_still_if_the_force_grows_by_more_and_more_is_applied() {
    let chain = chain(SafetyLimits {
        stuck: Some(Stuck {
            force: Newtons(3.0),
            time: Seconds(2e-3),
        }),
        ..BARE
    });
    // From 1 N to 4 N is no more than 3 N; half a newton more is.
    let mut state = SafetyState::default();
    for wanted in [1.0, 1.0, 1.0, 2.0, 3.0, 4.0, 4.0, 4.0] {
        apply(&chain, &mut state, 0.0, wanted);
        assert_eq!(state.fault(), None);
    }
    apply(&chain, &mut state, 0.0, 4.5);
    assert_eq!(state.fault(), Some(Fault::PositionStuck));
    // Wanted at once, 1 N a tick applied: not yet while the last that was applied is 3 N.
    let mut state = SafetyState::default();
    for _ in 0..3 {
        apply(&chain, &mut state, 0.0, 0.0);
    }
    for applied in [1.0, 2.0, 3.0, 4.0] {
        let force = apply(&chain, &mut state, 0.0, 9.0);
        assert_eq!((force, state.fault()), (applied, None));
    }
    apply(&chain, &mut state, 0.0, 9.0);
    assert_eq!(state.fault(), Some(Fault::PositionStuck));
}

#[test]
fn after_a_fault_the_force_goes_through_damping_to_zero() {
    let chain = chain(SafetyLimits {
        stop_time: Seconds(0.1),
        ..workspace()
    });
    let mut state = SafetyState::default();
    for tick in 0..300 {
        // Moves on at 0.1 m/s, whatever the force.
        let position = vector![0.05 + 1e-4 * f64::from(tick)];
        if tick == 100 {
            state.trip(Fault::HostSilent);
        }
        let (force, limiters) = chain.apply(&mut state, &position, &vector![0.3]);
        let force = force.newtons()[0];
        if tick >= 100 {
            let left = match tick - 100 {
                tick @ 0..99 => 1.0 - f64::from(tick) / 100.0,
                _ => 0.0,
            };
            assert!((force + left * 0.5).abs() < 1e-9, "{tick}: {force}");
            assert!(limiters.contains(Limiters::FAULT));
        }
        assert_eq!(state.is_at_rest(), tick >= 199, "{tick}");
    }
}

#[test]
fn no_braking_without_a_sensor_or_an_actuator() {
    for fault in [Fault::NonFiniteForce, Fault::CurrentMismatch] {
        let chain = chain(workspace());
        let mut state = SafetyState::default();
        for tick in 0..20 {
            let mut position = vector![0.05 + 1e-4 * f64::from(tick)];
            if tick == 10 && fault == Fault::NonFiniteForce {
                position[0] = f64::NAN;
            } else if tick == 10 {
                state.trip(fault);
            }
            let (force, _) = chain.apply(&mut state, &position, &vector![0.0]);
            assert_eq!(force.newtons()[0], 0.0);
        }
        assert_eq!(state.fault(), Some(fault));
    }
}

#[test]
fn what_is_not_finite_is_a_fault_while_stopping_and_in_the_braking_too() {
    let mut state = SafetyState::default();
    state.stop();
    apply(&chain(BARE), &mut state, 0.0, f64::NAN);
    assert_eq!(state.fault(), Some(Fault::NonFiniteForce));
    // 1e308 m/s is a number, 5 N·s/m times that is none.
    let vast = chain(SafetyLimits {
        workspace: Some(Workspace {
            low: Metres(-1e305),
            high: Metres(1e305),
            soft: Metres(1e305),
        }),
        ..workspace()
    });
    let mut state = SafetyState::default();
    apply(&vast, &mut state, 0.0, 1.0);
    assert_eq!(state.fault(), None);
    let (force, limiters) = vast.apply(&mut state, &vector![1e305], &vector![1.0]);
    assert_eq!(force.newtons()[0], 0.0);
    assert!(limiters.contains(Limiters::FAULT));
    assert_eq!(state.fault(), Some(Fault::NonFiniteForce));
}

/// Whether the default limits are refused with this change.
fn refused(change: &dyn Fn(&mut SafetyLimits)) -> bool {
    let mut limits = SafetyLimits::default();
    change(&mut limits);
    SafetyChain::<f32>::from_limits(&limits, T).is_err()
}

#[test]
fn bad_limits_are_refused() {
    type Set = fn(&mut SafetyLimits, f64);
    /// Each with whether it is used as a number of the loop, in which 1e-46 is none.
    const NUMBERS: [(bool, Set); 12] = [
        (true, |limits, x| limits.force = Newtons(x)),
        (true, |limits, x| limits.rate = NewtonsPerSecond(x)),
        (true, |limits, x| limits.norm = Some(Newtons(x))),
        (true, |limits, x| {
            limits.braking = Some(NewtonSecondsPerMetre(x));
        }),
        (true, |limits, x| limits.velocity_bandwidth = Hertz(x)),
        (false, |limits, x| limits.start_force = Some(Newtons(x))),
        (false, |limits, x| limits.rise_time = Some(Seconds(x))),
        (false, |limits, x| limits.stop_time = Seconds(x)),
        (false, |limits, x| limits.jump = Some(Metres(x))),
        (false, |limits, x| limits.device_mass = Some(Kilograms(x))),
        (false, |limits, x| {
            let (force, time) = (Newtons(x), Stuck::DEFAULT.time);
            limits.stuck = Some(Stuck { force, time });
        }),
        (false, |limits, x| {
            let (force, time) = (Stuck::DEFAULT.force, Seconds(x));
            limits.stuck = Some(Stuck { force, time });
        }),
    ];
    assert!(!refused(&|_| {}));
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-46] {
        for (n, (of_the_loop, set)) in NUMBERS.into_iter().enumerate() {
            if bad != 1e-46 || of_the_loop {
                assert!(refused(&|limits| set(limits, bad)), "{n}: {bad}");
            }
        }
        let chain = SafetyChain::<f32>::new(BARE.force, BARE.rate, Seconds(bad));
        assert!(bad == 1e-46 || chain.is_err(), "{bad} s");
    }
    // Beyond single precision: infinite, or a rate that would never let go.
    assert!(refused(&|limits| limits.force = Newtons(1e39)));
    assert!(refused(&|limits| limits.rate = NewtonsPerSecond(1e45)));
    assert!(refused(&|limits| limits.rate = NewtonsPerSecond(1e-45)));
    // Without a speed limit too.
    assert!(refused(&|limits| {
        (limits.speed, limits.jump) = (None, Some(Metres(-1e-3)));
    }));
}

#[test]
fn bad_ranges_of_place_and_speed_are_refused() {
    for (low, high, soft) in [
        (0.1, 0.1, 0.0),
        (0.1, 0.0, 0.0),
        (0.0, 0.1, 0.06),
        (0.0, 0.1, -0.01),
        (f64::NAN, 0.1, 0.0),
        (0.0, f64::INFINITY, 0.0),
    ] {
        let bad = Workspace {
            low: Metres(low),
            high: Metres(high),
            soft: Metres(soft),
        };
        assert!(refused(&|limits| limits.workspace = Some(bad)));
        assert!(refused(&|limits| limits.workspace_box = Some([bad; 3])));
    }
    for (soft, hard) in [(1.0, 1.0), (-1.0, 1.0), (2.0, 1.0), (0.0, f64::NAN)] {
        assert!(refused(&|limits| limits.speed = Some(SpeedLimit {
            soft: MetresPerSecond(soft),
            hard: MetresPerSecond(hard),
        })));
    }
}

/// The chain of one axis as it was before it knew more than force and rate.
fn first_chain(last: &mut f64, wanted: f64, released: bool) {
    let wanted = if released { 0.0 } else { wanted };
    let slewed = wanted.max(*last - 1.0).min(*last + 1.0);
    *last = slewed.clamp(-10.0, 10.0);
}

/// Any number, or one of the size of a force or position, or one that hardly moves.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<f64>(),
        -30.0..30.0,
        -0.1..0.1,
        -1e-3..1e-3,
        Just(f64::NAN),
        Just(f64::INFINITY),
        Just(5e-324),
        Just(0.0),
    ]
}

proptest! {
    #[test]
    fn force_and_rate_alone_on_one_axis_are_what_they_always_were(
        ticks in proptest::collection::vec((number(), any::<u8>()), 1..200),
    ) {
        let chain = SafetyChain::new(BARE.force, BARE.rate, T).expect("valid");
        let mut state = SafetyState::default();
        let (mut last, mut fault, mut stopped) = (0.0, false, false);
        for (wanted, event) in ticks {
            fault |= !f64::is_finite(wanted);
            if event == 0 {
                state.stop();
                stopped = true;
            }
            first_chain(&mut last, wanted, fault || stopped);
            let force = apply(&chain, &mut state, f64::NAN, wanted);
            prop_assert_eq!(force.to_bits(), last.to_bits());
            if event < 100 {
                state.clear();
                (fault, stopped) = (false, false);
            }
        }
    }
}
