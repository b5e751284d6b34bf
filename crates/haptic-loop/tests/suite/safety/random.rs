//! No input whatever leaves the limits.

use super::{BARE, T};
use fracdiff::{Real, Seconds};
use haptic_loop::units::{Kilograms, Metres, NewtonSecondsPerMetre, Newtons};
use haptic_loop::{
    EnergyBounding, Fault, Guard, Limiters, Limits, PassivityObserver, SafetyChain, SafetyState,
    Workspace,
};
use nalgebra::{SVector, vector};
use proptest::prelude::*;

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

fn limits() -> impl Strategy<Value = Limits> {
    let norm = prop_oneof![
        Just(None),
        Just(Some(Newtons(10.0))),
        Just(Some(Newtons(1.3)))
    ];
    (guards(), norm, any::<bool>()).prop_map(|(guard, norm, rise)| Limits {
        norm,
        guard,
        rise_time: rise.then_some(Seconds(0.02)),
        workspace: Some(Workspace {
            low: Metres(-0.05),
            high: Metres(0.05),
            soft: Metres(0.045),
        }),
        ..Limits::default()
    })
}

proptest! {
    #[test]
    fn no_input_whatever_leaves_limits_norm_or_slew(ticks in ticks(), limits in limits()) {
        limits_hold::<f64>(&limits, &ticks, f64::EPSILON)?;
        limits_hold::<f32>(&limits, &ticks, f64::from(f32::EPSILON))?;
    }

    #[test]
    fn no_push_leaves_limits_norm_or_slew(ticks in pushes(), limits in limits()) {
        limits_hold::<f64>(&limits, &ticks, f64::EPSILON)?;
        limits_hold::<f32>(&limits, &ticks, f64::from(f32::EPSILON))?;
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
