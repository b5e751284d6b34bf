//! Energy bounding by its books: delay, lag, noise, and what it cannot promise.

use super::{DAMPING, T, at_once, bare, bounding, guarded, late, observer};
use crate::apply;
use fracdiff::Seconds;
use haptic_loop::units::{Metres, NewtonSecondsPerMetre};
use haptic_loop::{
    EnergyBounding, Fault, Limiters, PassivityGuard, SafetyChain, SafetyLimits, SafetyState,
};
use nalgebra::vector;
use testkit::{assert_close, assert_refused, assert_relative};

#[test]
fn an_energy_that_is_no_number_gives_no_force() {
    // Jumps whose squares are beyond the number type, at once and after a good motion.
    for jump in [2e19_f32, 1e25, -1e25, 3e34] {
        for before in [0, 5] {
            let (chain, mut state) = bare::<f32>(at_once());
            for step in 0..=before {
                apply(&chain, &mut state, 1e-3 * step as f32, 0.0);
            }
            for back in [jump, jump, 0.0, jump] {
                let force = apply(&chain, &mut state, back, -10.0);
                assert!(force.abs() <= 0.0, "{jump} {back}");
                assert!(state.observed_energy_j() <= 0.0, "{jump} {back}");
            }
        }
    }
    // The same in double precision, and a position that is no number: nothing more is credited.
    for jump in [1e160, f64::NAN, f64::INFINITY] {
        let (chain, mut state) = bare::<f64>(at_once());
        apply(&chain, &mut state, 0.0, 0.0);
        for x in [jump, 0.0, 0.0] {
            let force = apply(&chain, &mut state, x, -10.0);
            assert!(force.abs() <= 0.0, "{jump}");
        }
        assert!(state.observed_energy_j() <= 0.0, "{jump}");
    }
    // The observer takes it for no credit too: all the damping there is.
    let (chain, mut state) = guarded::<f32, 1>(observer(), 100.0, 1e9);
    for x in [0.0, -1e37, -2e37] {
        apply(&chain, &mut state, x, 100.0);
    }
    assert!(state.observed_energy_j() <= 0.0);
    // Work of −∞ is not "nothing is owed": no force follows from it.
    let mut state = SafetyState::default();
    for (x, wanted) in [(0.0, 0.0), (-1e10, 1e30), (-2e10, 1e30)] {
        let force = apply(&chain, &mut state, x, wanted);
        assert!(force.abs() <= 0.0, "{x}");
    }
    assert_eq!(state.fault(), Some(Fault::NonFiniteForce));
}

#[test]
fn after_the_device_has_let_go_no_force_is_on_its_way_and_no_credit_is_left() {
    let (chain, begun) = bare::<f64>(late(2.5 * T.0, 2.5 * T.0, 0.0));
    // The same motion, pushed or not: once it has let go, the books are the same, to the bit.
    let [pushed, alone] = [-2.0, 0.0].map(|wanted| {
        let mut state = begun;
        let tick =
            |state: &mut _, wanted: f64, n: i32| apply(&chain, state, 1e-3 * f64::from(n), wanted);
        let sent = (0..10).map(|n| tick(&mut state, wanted, n)).last();
        assert_eq!(
            sent.is_some_and(|sent| sent < -0.5),
            wanted < 0.0,
            "{sent:?}"
        );
        assert!(state.observed_energy_j() > 0.0);
        state.let_go();
        assert!(state.observed_energy_j() <= 0.0);
        (10..20)
            .map(|n| {
                tick(&mut state, 0.0, n);
                state.observed_energy_j().to_bits()
            })
            .collect::<Vec<_>>()
    });
    assert_eq!(pushed, alone);
}

#[test]
fn a_rate_limit_does_not_keep_up_a_force_that_the_guard_takes_away() {
    // 1 N/s: without the guard 10 N would take 10 s to fall.
    let (chain, mut state) = guarded::<f64, 1>(bounding(0.0), 10.0, 1.0);
    let (mut x, mut last) = (0.0, 0.0);
    for _ in 0..1000 {
        x += 1e-4;
        let force = apply(&chain, &mut state, x, -10.0);
        // It holds back what grows.
        assert!(force - last >= -T.0 - 1e-12);
        last = force;
    }
    assert_close("last", last, -2.0, 1e-2);
    // The worst motion, sample by sample.
    let mut acted = false;
    for _ in 0..5000 {
        x += last * T.0 / (2.0 * 0.8 * DAMPING);
        let (force, limiters) = chain.apply(&mut state, &vector![x], &vector![-10.0]);
        assert!(state.observed_energy_j() >= -1e-12);
        let fell = force.newtons()[0] - last;
        acted |= limiters.contains(Limiters::GUARD) && fell > 2.0 * T.0;
        last = force.newtons()[0];
    }
    assert!(acted, "faster than the rate");
    assert!(last.abs() < 1e-2, "{last}");
}

#[test]
fn the_price_of_delay_lag_and_interval_is_that_of_its_formula() {
    let most = 2.0 * 0.8 * DAMPING / T.0;
    for (least, wide, lag) in [
        (0.0, 0.0, 0.0),
        (0.5, 0.0, 0.0),
        (2.25, 0.0, 0.0),
        (0.0, 0.0, 0.5),
        (0.75, 0.0, 3.0),
        (0.0, 1.0, 0.0),
        (0.5, 3.0, 1.0),
    ] {
        let guard = late(least * T.0, (least + wide) * T.0, lag * T.0);
        let (chain, mut state) = bare::<f64>(guard);
        // Slowly 1 mm into a wall of 1 MN/m, in 2 s.
        let mut force = 0.0;
        for tick in 0..=1000 {
            let x = 1e-6 * f64::from(tick);
            force = apply(&chain, &mut state, x, -1e6 * x);
        }
        let held = 1.0 + least + 0.5 * wide + 0.5 * lag;
        let spread = f64::ceil(0.5 * wide) * 0.5 * wide;
        let want = most / held / (1.0 + (spread / held).sqrt()).powi(2);
        let have = -force / 1e-3;
        assert_relative("have", have, want, 0.02);
    }
}

#[test]
fn noise_is_owed_for_a_thousand_samples_and_paid_only_with_energy_to_spare() {
    const SIGMA: f64 = 1e-5;
    // ρb/T; 2ρ(b/T)σ² a sample; what one sample leaves of a surplus.
    let (damping, keep) = (0.8 * DAMPING / T.0, 1.0 - T.0 / 0.5);
    let noise = 2.0 * damping * SIGMA * SIGMA;
    let guard = EnergyBounding {
        noise: Metres(SIGMA),
        ..at_once()
    };
    let (chain, mut state) = bare::<f64>(guard);
    let mut tick = |x: f64, wanted: f64| {
        let force = apply(&chain, &mut state, x, wanted);
        (force, state.observed_energy_j())
    };
    for _ in 0..5000 {
        tick(0.0, 0.0);
    }
    // A motion that pays for half of what is owed leaves nothing, and no debt in the books.
    let x = (500.0 * noise / damping).sqrt();
    assert!(tick(x, 0.0).1.abs() < 1e-9 * noise);
    // Half is left, and a sample more has come to it. Twice that: the rest is a surplus.
    let x = x + (1002.0 * noise / damping).sqrt();
    let left = tick(x, 0.0).1 / (keep * noise);
    assert_close("left", left, 501.0, 1e-6);
    // All that is covered for a force is not spent on noise: it is held for a minute.
    let sent = tick(x, -10.0).0;
    assert!((-10.0..-0.1).contains(&sent), "{sent}");
    for _ in 0..30_000 {
        assert_close("held", tick(x, -10.0).0, sent, 1e-9);
    }
}

#[test]
fn a_force_that_was_bounded_has_no_surplus_to_forget() {
    // f = 2ρ(b/T)·|Δ| of the first motion, and its energy ρ(b/T)·Δ² stays.
    let (chain, mut state) = bare::<f64>(at_once());
    for (x, wanted) in [(0.0, 0.0), (1e-3, -100.0)] {
        apply(&chain, &mut state, x, wanted);
    }
    let energy = 0.8 * DAMPING / T.0 * 1e-6;
    assert_relative("energy", state.observed_energy_j(), energy, 1e-12);
}

#[test]
fn what_a_guard_cannot_promise_is_refused() {
    let (nan, none) = (f64::NAN, at_once());
    let damped = |damping| EnergyBounding::of(NewtonSecondsPerMetre(damping));
    let noise = Metres(-1e-6);
    let forget = Seconds(0.5 * T.0);
    let shared = |share| EnergyBounding { share, ..none };
    for (bounding, words) in [
        (damped(0.0), "damping of the device 0"),
        (damped(nan), "damping of the device"),
        (
            late(-1e-6, 0.0, 0.0),
            "least delay of the guard -0.000001 s is not at least 0",
        ),
        (late(nan, 0.0, 0.0), "least delay of the guard"),
        (
            late(1e-3, 0.9e-3, 0.0),
            "delay of the guard 0.0009 s is not from the least delay to 4 sample times",
        ),
        (late(0.0, 8.1e-3, 0.0), "0.0081 s is not from"),
        (late(0.0, f64::INFINITY, 0.0), "delay of the guard inf"),
        (
            late(0.0, 0.0, 0.129),
            "lag of the actuator 0.129 s is not from 0 to 64 sample times",
        ),
        (late(0.0, 0.0, nan), "lag of the actuator NaN"),
        (EnergyBounding { noise, ..none }, "device noise"),
        (
            EnergyBounding { forget, ..none },
            "time in which the guard forgets",
        ),
        (shared(0.0), "share of the damping"),
        (shared(1.01), "share of the damping"),
    ] {
        let limits = SafetyLimits {
            guard: Some(PassivityGuard::EnergyBounding(bounding)),
            ..SafetyLimits::default()
        };
        assert_refused(SafetyChain::<f64>::from_limits(&limits, T), words);
    }
}

#[test]
fn the_ends_of_the_ranges_of_a_guard_are_good() {
    for good in [
        late(0.0, 8e-3, 0.128),
        late(8e-3, 8e-3, 0.0),
        late(0.0, 0.0, 1e-9),
    ] {
        let _ = bare::<f32>(good);
        let _ = bare::<f64>(good);
    }
}
