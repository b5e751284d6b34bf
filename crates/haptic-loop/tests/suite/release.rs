//! The way of a force to zero, and what makes a position implausible.
//!
//! `CAMPAIGN_CASES` sets how many random schedules are run, 4000 unless given: 100 000 take some 40 s of a processor.

mod schedules;

use crate::{T, apply, chain};
use fracdiff::Seconds;
use haptic_loop::units::{Kilograms, NewtonSecondsPerMetre};
use haptic_loop::{Fault, LoopParameterError, SafetyChain, SafetyLimits, SafetyState};
use testkit::assert_close;

#[test]
fn braking_beyond_what_the_device_bears_is_refused_in_one_line() {
    let with_braking = |braking, mass: Option<f64>, delay| SafetyLimits {
        braking: Some(NewtonSecondsPerMetre(braking)),
        device_mass: mass.map(Kilograms),
        device_delay_samples: delay,
        ..SafetyLimits::default()
    };
    for (limits, most, words) in [
        (with_braking(5.001, None, 1), 5.0, "give its mass"),
        (
            with_braking(1000.0, Some(0.065), 0),
            65.0,
            "use less braking",
        ),
        (
            with_braking(22.0, Some(0.065), 1),
            0.065 / 3e-3,
            "half of what",
        ),
    ] {
        let refused = SafetyChain::<f32>::from_limits(&limits, T).expect_err("too much");
        let text = refused.to_string();
        assert!(text.contains(words) && !text.contains('\n'), "{text}");
        let LoopParameterError::Braking { most_n_s_per_m, .. } = refused else {
            panic!("{refused:?}");
        };
        assert_close("most_n_s_per_m", most_n_s_per_m, most, 1e-9);
    }
    for good in [
        with_braking(5.0, None, 1),
        with_braking(65.0, Some(0.065), 0),
        with_braking(9.0, Some(0.065), 3),
    ] {
        SafetyChain::<f32>::from_limits(&good, T).expect("bearable");
    }
}

/// Largest speed left of a free mass that a sampled damper brakes with `gain` times the most that is accepted.
fn braked(mass: f64, delay: u32, bandwidth_hz: f64, sample_time: f64, gain: f64) -> f64 {
    let limits = SafetyLimits {
        device_mass: Some(Kilograms(mass)),
        device_delay_samples: delay,
        ..SafetyLimits::default()
    };
    let t = sample_time;
    let b = gain * limits.braking_max(Seconds(t)).0;
    let follow = 1.0 - (-std::f64::consts::TAU * bandwidth_hz * t).exp();
    let (mut x, mut v, mut estimate, mut before) = (0.0, 1.0, 0.0, 0.0);
    let mut pipe = vec![0.0; delay as usize + 1];
    let mut late = 0.0_f64;
    let ticks = 40_000;
    for tick in 0..ticks {
        estimate += follow * ((x - before) / t - estimate);
        before = x;
        pipe.rotate_right(1);
        pipe[0] = -b * estimate;
        let force = pipe[delay as usize];
        // Exact over a hold.
        x += v * t + 0.5 * force / mass * t * t;
        v += force / mass * t;
        if !v.is_finite() || v.abs() > 1e9 {
            return f64::INFINITY;
        }
        if tick >= ticks - 1000 {
            late = late.max(v.abs());
        }
    }
    late
}

#[test]
fn the_most_braking_has_a_gain_margin_of_two_for_every_filter_and_delay() {
    for delay in 0..=4 {
        for bandwidth in [3.0, 20.0, 50.0, 200.0, 5000.0] {
            for sample_time in [5e-4, 1e-3, 2e-3] {
                let left = |gain| braked(0.065, delay, bandwidth, sample_time, gain);
                let case = format!("{delay} ticks, {bandwidth} Hz, {sample_time} s");
                assert!(left(1.0) < 1e-2, "{case}: {}", left(1.0));
                // bT/m = 2·sin(θ/2)/sin((2d + 1)θ/2) is never below 2/(2d + 1).
                assert!(left(1.98) < 1.0, "{case}: {}", left(1.98));
                if delay == 0 {
                    // There it is 2, whatever the filter.
                    assert!(left(2.02) > 1.5, "{case}: {}", left(2.02));
                }
            }
        }
    }
    // A slow filter comes close to the bound with delay too.
    assert!(braked(0.065, 2, 1.0, 1e-3, 2.05) > 1.0);
}

/// The first fault of positions and wanted forces, with the limits of a device by default.
fn fault(ticks: impl Iterator<Item = (f64, f64)>) -> Option<(usize, Fault)> {
    let limits = SafetyLimits {
        rise_time: None,
        ..SafetyLimits::default()
    };
    let chain = chain(limits);
    let mut state = SafetyState::default();
    for (tick, (position, wanted)) in ticks.enumerate() {
        apply(&chain, &mut state, position, wanted);
        if let Some(fault) = state.fault() {
            return Some((tick, fault));
        }
    }
    None
}

#[test]
fn no_honest_standstill_is_a_fault() {
    // A host pushes with a sine at 2 Hz: a sensor that moves by a count now and then, less than the set amount, and a force that the
    // limits keep away.
    let sine = |n: usize| 5.0 * (std::f64::consts::TAU * 2e-3 * n as f64).sin();
    for (count, share, kept_away) in [(1e-5, 1.0, 0.0), (0.0, 0.55, 0.0), (0.0, 1.0, 20.0)] {
        let told = |n: usize| (count * ((n / 50) % 2) as f64, share * sine(n) + kept_away);
        assert_eq!(fault((0..1000).map(told)), None, "{count} m, {share}");
    }
    // A hand that does not move, a wall of 8 N, the force slewed up to it: 200 s.
    assert_eq!(fault((0..200_000).map(|_| (0.004, -8.0))), None);
    // Relaxation of every order on a rigid indenter, from 9 N, from the end of a ramp of 10 ms on.
    for order in [0.05, 0.2247, 0.5, 0.8, 0.95] {
        let shape = |n: usize| {
            let (t, ramp) = (1e-3 * n as f64, 0.01);
            let power = |t: f64| t.max(0.0).powf(1.0 - order);
            (power(t) - power(t - ramp)) / power(ramp)
        };
        let ticks = (0..200_000).map(|n| (1e-3 * (n as f64 / 10.0).min(1.0), -9.0 * shape(n)));
        assert_eq!(fault(ticks), None, "order {order}");
    }
    // An order above 1 turns round at the end of a ramp and comes back, 2 N to 9 N within the first 50 ms.
    let returns = (0..20_000).map(|n| {
        let since = (n as f64 - 100.0).max(0.0);
        (
            1e-4 * (n as f64).min(100.0),
            -9.0 + 7.0 * (-since / 10.0).exp(),
        )
    });
    assert_eq!(fault(returns), None);
}

#[test]
fn a_position_that_jumps_is_a_fault_before_its_force_is() {
    for jump in [0.01, 0.0026, -0.01] {
        let chain = chain(SafetyLimits::default());
        let mut state = SafetyState::default();
        for _ in 0..1000 {
            apply(&chain, &mut state, 0.0, -0.5);
        }
        let force = apply(&chain, &mut state, jump, -30.0);
        assert_eq!(state.fault(), Some(Fault::PositionJump), "{jump} m");
        assert!(force.abs() <= 0.5, "{jump} m: {force:?}");
    }
    // 1.5 m/s and 1 mm more in a tick are 2.5 mm.
    assert_eq!(fault([(0.0, 0.0), (2.4e-3, 0.0)].into_iter()), None);
}

#[test]
fn a_motion_over_ticks_that_did_not_come_is_as_fast_as_it_was() {
    for speed in [1.4, -1.4, 1.7] {
        for notify in [
            SafetyState::skip,
            |state: &mut SafetyState<f64, 1>, ticks| {
                state.unmeasured(ticks as u32);
            },
        ] {
            let chain = chain(SafetyLimits::default());
            let mut state = SafetyState::default();
            let mut tick = 0_u64;
            for n in 0..300 {
                let missed = if n % 7 == 3 { n % 11 } else { 0 };
                if missed > 0 {
                    notify(&mut state, missed);
                }
                tick += 1 + missed;
                let position = speed * 1e-3 * tick as f64;
                apply(&chain, &mut state, position, 0.0);
            }
            let fast = speed.abs() > 1.5;
            assert_eq!(state.fault().is_some(), fast, "{speed} m/s");
            assert!((state.velocity_m_per_s()[0] - speed).abs() < 1e-9 || fast);
        }
    }
}
