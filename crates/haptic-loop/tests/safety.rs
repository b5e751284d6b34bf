//! Limits of the safety chain: start-up, norm, workspace, speed, and what holds whatever happens.
#![expect(clippy::float_cmp, reason = "exact results are compared exactly")]

use fracdiff::{Real, Seconds};
use haptic_loop::units::{
    Hertz, Kilograms, Metres, MetresPerSecond, NewtonSecondsPerMetre, Newtons, NewtonsPerSecond,
};
use haptic_loop::{
    EnergyBounding, Fault, Guard, Limiters, Limits, PassivityObserver, SafetyChain, SafetyState,
    SpeedLimit, StartRefused, Stuck, Workspace,
};
use nalgebra::{SVector, vector};
use proptest::prelude::*;

const T: Seconds = Seconds(1e-3);

/// 10 N on each axis, 1 N a tick, everything else off.
const BARE: Limits = Limits::bare(Newtons(10.0), NewtonsPerSecond(1000.0));

fn chain(limits: Limits) -> SafetyChain<f64> {
    SafetyChain::from_limits(&limits, T).expect("valid")
}

#[test]
fn the_force_rises_in_proportion_to_time_after_start_and_after_clear() {
    let chain = chain(Limits {
        rise_time: Some(Seconds(0.1)),
        ..BARE
    });
    let mut state = SafetyState::default();
    for _ in 0..2 {
        for tick in 0..150 {
            let (force, limiters) = chain.apply(&mut state, &vector![0.0], &vector![5.0]);
            let share = f64::from(tick.min(100)) / 100.0;
            assert!(
                (force.newtons()[0] - 5.0 * share).abs() < 1e-12,
                "tick {tick}"
            );
            // The share is a sum of hundredths: its last rounding may take a tick more.
            if tick != 100 {
                assert_eq!(limiters.contains(Limiters::STARTUP), tick < 100, "{tick}");
            }
        }
        state.stop();
        for _ in 0..5 {
            chain.apply(&mut state, &vector![0.0], &vector![5.0]);
        }
        assert!(state.is_at_rest());
        state.clear();
    }
}

#[test]
fn the_start_is_over_with_the_sample_that_has_the_whole_force() {
    // Quarters are exact.
    let chain = chain(Limits {
        rise_time: Some(Seconds(4e-3)),
        ..BARE
    });
    let mut state = SafetyState::default();
    for (share, bits) in [(0.0, 16), (0.25, 16), (0.5, 16), (0.75, 16), (1.0, 0)] {
        let (force, limiters) = chain.apply(&mut state, &vector![0.0], &vector![2.0]);
        assert_eq!((force.newtons()[0], limiters.bits()), (2.0 * share, bits));
    }
}

#[test]
fn a_start_is_refused_with_too_large_a_force() {
    let chain = chain(Limits {
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
        let any = SafetyChain::from_limits(&BARE, T).expect("valid");
        assert!(any.may_start(&vector![bad]).is_err());
        assert_eq!(any.may_start(&vector![1e9]), Ok(()));
    }
}

#[test]
fn the_norm_is_limited_without_turning_the_force_and_no_force_is_stuck() {
    let limits = Limits {
        norm: Some(Newtons(5.0)),
        ..BARE
    };
    let chain = chain(limits);
    let mut state = SafetyState::<f64, 2>::default();
    let settle = |state: &mut _, wanted: [f64; 2]| {
        let mut last = (SVector::zeros(), Limiters::NONE);
        for _ in 0..30 {
            let (force, limiters) = chain.apply(state, &vector![0.0, 0.0], &SVector::from(wanted));
            last = (*force.newtons(), limiters);
        }
        last
    };
    // 3-4-5, twice as long: limited to 5 N, one millionth less for rounding.
    let (force, limiters) = settle(&mut state, [6.0, 8.0]);
    assert!((force - vector![3.0, 4.0]).norm() < 1e-5, "{force}");
    assert_eq!(limiters, Limiters::MAGNITUDE);
    // Along the circle, where a slew of each axis for itself would lead outside, and a box of 10 N would turn the force.
    for angle in 0..360 {
        let (y, x) = (f64::from(angle * 7).to_radians()).sin_cos();
        let (force, _) = settle(&mut state, [50.0 * x, 50.0 * y]);
        assert!((force - vector![x, y] * 5.0).norm() < 1e-5, "{force}");
    }
}

/// 0 to 100 mm, zones of 20 mm, 5 N·s/m, and a velocity that follows within the tick.
fn workspace() -> Limits {
    Limits {
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
        let chain = chain(Limits {
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
    let limits = Limits {
        braking: Some(NewtonSecondsPerMetre(5.0)),
        velocity_bandwidth: Hertz(1e5),
        ..BARE
    };
    let chain = SafetyChain::<f32>::from_limits(&limits, T).expect("valid");
    let mut state = SafetyState::<f32, 1>::default();
    for x in [0.0, 1e36] {
        chain.apply(&mut state, &vector![x], &vector![1.0]);
    }
    assert_eq!(state.fault(), Some(Fault::Velocity));
    assert_eq!(state.velocity_m_per_s()[0], 0.0);
}

#[test]
fn a_sensor_stands_still_if_the_force_grows_by_more_and_more_is_applied() {
    let chain = chain(Limits {
        stuck: Some(Stuck {
            force: Newtons(3.0),
            time: Seconds(2e-3),
        }),
        ..BARE
    });
    // From 1 N to 4 N is no more than 3 N; half a newton more is.
    let mut state = SafetyState::<f64, 1>::default();
    for wanted in [1.0, 1.0, 1.0, 2.0, 3.0, 4.0, 4.0, 4.0] {
        chain.apply(&mut state, &vector![0.0], &vector![wanted]);
        assert_eq!(state.fault(), None);
    }
    chain.apply(&mut state, &vector![0.0], &vector![4.5]);
    assert_eq!(state.fault(), Some(Fault::PositionStuck));
    // Wanted at once, 1 N a tick applied: not yet while the last that was applied is 3 N.
    let mut state = SafetyState::<f64, 1>::default();
    for _ in 0..3 {
        chain.apply(&mut state, &vector![0.0], &vector![0.0]);
    }
    for applied in [1.0, 2.0, 3.0, 4.0] {
        let (force, _) = chain.apply(&mut state, &vector![0.0], &vector![9.0]);
        assert_eq!((force.newtons()[0], state.fault()), (applied, None));
    }
    chain.apply(&mut state, &vector![0.0], &vector![9.0]);
    assert_eq!(state.fault(), Some(Fault::PositionStuck));
}

#[test]
fn after_a_fault_the_force_goes_through_damping_to_zero() {
    let chain = chain(Limits {
        stop_time: Seconds(0.1),
        ..workspace()
    });
    let mut state = SafetyState::<f64, 1>::default();
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
        let mut state = SafetyState::<f64, 1>::default();
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
    let mut state = SafetyState::<f64, 1>::default();
    state.stop();
    chain(BARE).apply(&mut state, &vector![0.0], &vector![f64::NAN]);
    assert_eq!(state.fault(), Some(Fault::NonFiniteForce));
    // 1e308 m/s is a number, 5 N·s/m times that is none.
    let vast = chain(Limits {
        workspace: Some(Workspace {
            low: Metres(-1e305),
            high: Metres(1e305),
            soft: Metres(1e305),
        }),
        ..workspace()
    });
    let mut state = SafetyState::<f64, 1>::default();
    vast.apply(&mut state, &vector![0.0], &vector![1.0]);
    assert_eq!(state.fault(), None);
    let (force, limiters) = vast.apply(&mut state, &vector![1e305], &vector![1.0]);
    assert_eq!(force.newtons()[0], 0.0);
    assert!(limiters.contains(Limiters::FAULT));
    assert_eq!(state.fault(), Some(Fault::NonFiniteForce));
}

#[test]
fn the_velocity_is_a_low_pass_of_the_differences() {
    let chain = chain(Limits {
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
    let chain = chain(Limits {
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
        chain.apply(&mut state, &vector![x], &vector![0.0]);
        assert_eq!(state.fault(), Some(Fault::Velocity));
    }
}

#[test]
fn a_device_moved_while_nothing_ran_is_not_too_fast_after_clear() {
    let chain = chain(Limits {
        guard: Some(Guard::EnergyBounding(EnergyBounding::of(
            NewtonSecondsPerMetre(3.5),
        ))),
        ..Limits::default()
    });
    let mut state = SafetyState::<f64, 1>::default();
    chain.apply(&mut state, &vector![0.0], &vector![0.0]);
    chain.apply(&mut state, &vector![1e-4], &vector![0.0]);
    assert!(state.observed_energy_j() > 0.0);
    state.stop();
    state.clear();
    chain.apply(&mut state, &vector![0.3], &vector![0.0]);
    assert_eq!(state.fault(), None);
    assert_eq!(state.observed_energy_j(), 0.0);
    // Without a clear it is.
    chain.apply(&mut state, &vector![0.0], &vector![0.0]);
    assert_eq!(state.fault(), Some(Fault::PositionJump));
}

#[test]
fn bad_limits_are_refused() {
    let refused = |change: &dyn Fn(&mut Limits)| {
        let mut limits = Limits::default();
        change(&mut limits);
        SafetyChain::<f32>::from_limits(&limits, T).is_err()
    };
    assert!(!refused(&|_| {}));
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-46] {
        assert!(refused(&|limits| limits.norm = Some(Newtons(bad))));
        assert!(refused(
            &|limits| limits.braking = Some(NewtonSecondsPerMetre(bad))
        ));
        assert!(refused(&|limits| limits.velocity_bandwidth = Hertz(bad)));
        if bad != 1e-46 {
            assert!(refused(&|limits| limits.start_force = Some(Newtons(bad))));
            assert!(refused(&|limits| limits.rise_time = Some(Seconds(bad))));
            assert!(refused(&|limits| limits.stop_time = Seconds(bad)));
            assert!(refused(&|limits| limits.jump = Some(Metres(bad))));
            assert!(refused(&|limits| limits.device_mass = Some(Kilograms(bad))));
            let stuck = Stuck::DEFAULT;
            assert!(refused(&|limits| limits.stuck = Some(Stuck {
                force: Newtons(bad),
                ..stuck
            })));
            assert!(refused(&|limits| limits.stuck = Some(Stuck {
                time: Seconds(bad),
                ..stuck
            })));
        }
    }
    let ends = [
        (0.1, 0.1, 0.0),
        (0.1, 0.0, 0.0),
        (0.0, 0.1, 0.06),
        (0.0, 0.1, -0.01),
    ];
    for (low, high, soft) in ends
        .into_iter()
        .chain([(f64::NAN, 0.1, 0.0), (0.0, f64::INFINITY, 0.0)])
    {
        assert!(refused(&|limits| limits.workspace = Some(Workspace {
            low: Metres(low),
            high: Metres(high),
            soft: Metres(soft),
        })));
    }
    for (soft, hard) in [(1.0, 1.0), (-1.0, 1.0), (2.0, 1.0), (0.0, f64::NAN)] {
        assert!(refused(&|limits| limits.speed = Some(SpeedLimit {
            soft: MetresPerSecond(soft),
            hard: MetresPerSecond(hard),
        })));
    }
    let good = EnergyBounding::of(NewtonSecondsPerMetre(3.5));
    for guard in [
        EnergyBounding { share: 1.1, ..good },
        EnergyBounding { share: 0.0, ..good },
        EnergyBounding {
            delay_most: Seconds(0.1),
            ..good
        },
        EnergyBounding {
            forget: Seconds(0.5e-3),
            ..good
        },
        EnergyBounding {
            device_damping: NewtonSecondsPerMetre(0.0),
            ..good
        },
    ] {
        assert!(refused(
            &|limits| limits.guard = Some(Guard::EnergyBounding(guard))
        ));
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

/// The inputs of a tick: position, wanted force, and now and then a fault, a stop or a clear.
fn ticks() -> impl Strategy<Value = Vec<([f64; 3], [f64; 3], u8)>> {
    let three = || proptest::array::uniform3(number());
    proptest::collection::vec((three(), three(), 0u8..20), 1..150)
}

/// Smooth pushes, so that nothing trips and the guards, ramp and zones work.
fn pushes() -> impl Strategy<Value = Vec<([f64; 3], [f64; 3], u8)>> {
    let step = || proptest::array::uniform3(-1e-3..1e-3);
    let force = || proptest::array::uniform3(-30.0..30.0);
    proptest::collection::vec((step(), force(), Just(9u8)), 1..300).prop_map(|mut ticks| {
        let mut at = [0.0; 3];
        for (x, _, _) in &mut ticks {
            for (at, x) in at.iter_mut().zip(x) {
                *at += *x;
                *x = *at;
            }
        }
        ticks
    })
}

fn guards() -> impl Strategy<Value = Option<Guard>> {
    let bounding = EnergyBounding::of(NewtonSecondsPerMetre(3.5));
    prop_oneof![
        Just(None),
        Just(Some(Guard::Observer(PassivityObserver::bearable(
            Kilograms(0.065),
            T
        )))),
        Just(Some(Guard::EnergyBounding(bounding))),
        Just(Some(Guard::EnergyBounding(EnergyBounding {
            delay_least: Seconds(0.5e-3),
            delay_most: Seconds(2e-3),
            lag: Seconds(1e-3),
            forget: Seconds(0.1),
            ..bounding
        }))),
    ]
}

fn limits_hold<F: Real>(
    limits: &Limits,
    ticks: &[([f64; 3], [f64; 3], u8)],
    relative: f64,
) -> Result<(), TestCaseError> {
    let chain = SafetyChain::<F>::from_limits(limits, T).expect("valid");
    let mut state = SafetyState::<F, 3>::default();
    let mut last = [0.0; 3];
    for &(position, wanted, event) in ticks {
        match event {
            0 => state.trip(Fault::HostSilent),
            1 => state.stop(),
            2..8 => state.clear(),
            _ => {}
        }
        let (force, limiters) = chain.apply(
            &mut state,
            &SVector::from(position.map(F::from_f64)),
            &SVector::from(wanted.map(F::from_f64)),
        );
        let now: [f64; 3] = force.newtons().map(F::to_f64).into();
        let released = limiters.contains(Limiters::FAULT) || limiters.contains(Limiters::STOPPING);
        prop_assert!(now.iter().all(|axis| axis.abs() <= 10.0), "{now:?}");
        // Energy bounding and the way to zero may take force away faster, not turn it round.
        let bounding = matches!(limits.guard, Some(Guard::EnergyBounding(_)));
        let change = now.iter().zip(last).map(|(now, last)| {
            let taken = bounding && now.abs() <= last.abs() && now * last >= 0.0;
            if taken { 0.0 } else { now - last }
        });
        let change = change.map(|axis| axis * axis).sum::<f64>().sqrt();
        let size = |force: [f64; 3]| force.map(|axis| axis * axis).iter().sum::<f64>().sqrt();
        // Some roundings of the force.
        let slewed = change <= 1.0 + 40.0 * relative;
        let falls = released && size(now) <= size(last);
        prop_assert!(slewed || falls, "{last:?} {now:?}");
        if let Some(norm) = limits.norm {
            let square: f64 = now.iter().map(|axis| axis * axis).sum();
            prop_assert!(square.sqrt() <= norm.0, "{now:?}");
        }
        last = now;
    }
    Ok(())
}

proptest! {
    #[test]
    fn no_input_whatever_leaves_limits_norm_or_slew(
        wild in ticks(),
        gentle in pushes(),
        guard in guards(),
        norm in prop_oneof![Just(None), Just(Some(Newtons(10.0))), Just(Some(Newtons(1.3)))],
        rise in any::<bool>(),
    ) {
        let limits = Limits {
            norm,
            guard,
            rise_time: rise.then_some(Seconds(0.02)),
            workspace: Some(Workspace {
                low: Metres(-0.05),
                high: Metres(0.05),
                soft: Metres(0.045),
            }),
            ..Limits::default()
        };
        for ticks in [&wild, &gentle] {
            limits_hold::<f64>(&limits, ticks, f64::EPSILON)?;
            limits_hold::<f32>(&limits, ticks, f64::from(f32::EPSILON))?;
        }
    }

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
            let (force, _) = chain.apply(&mut state, &vector![f64::NAN], &vector![wanted]);
            prop_assert_eq!(force.newtons()[0].to_bits(), last.to_bits());
            if event < 100 {
                state.clear();
                (fault, stopped) = (false, false);
            }
        }
    }
}
