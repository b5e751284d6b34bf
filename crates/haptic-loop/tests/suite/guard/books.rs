//! The books of the guards: what they hold, predict and go on with.

use super::{DAMPING, MASS, T, bounding, guarded, late, observer};
use crate::apply;
use fracdiff::Seconds;
use haptic_loop::{EnergyBounding, Limiters, PassivityGuard};
use nalgebra::{SVector, vector};
use proptest::prelude::*;
use testkit::assert_close;

#[test]
fn single_precision_holds_a_force_for_minutes() {
    // Delay from and to, lag, ms.
    for (least, most, lag, forget, settled) in [
        (0.0, 0.0, 0.0, 0.5, 101),
        (0.6, 0.6, 1.0, 0.0, 300),
        (3.4, 3.4, 6.0, 0.5, 300),
        (0.0, 2.0, 0.0, 0.5, 300),
        (0.5, 3.0, 5.0, 0.5, 300),
    ] {
        let guard = PassivityGuard::EnergyBounding(EnergyBounding {
            forget: Seconds(forget),
            ..late(1e-3 * least, 1e-3 * most, 1e-3 * lag)
        });
        let (chain, mut state) = guarded::<f32, 1>(Some(guard), 10.0, 1e4);
        let mut held = 0.0;
        // 1 mm deep into a wall of 10 kN/m, then nothing moves for 400 s.
        for tick in 0..200_000_u32 {
            let x = 1e-5 * tick.min(100) as f32;
            let (force, limiters) = chain.apply(&mut state, &vector![x], &vector![-1e4 * x]);
            if tick == settled {
                held = force.newtons()[0];
                let at_once = lag <= 0.0 && most <= 0.0;
                assert!(limiters.contains(Limiters::GUARD) || !at_once);
                assert!((-held / 2.8 - 1.0).abs() < 0.05 || !at_once, "{held}");
                assert!(held < -0.2, "{held}");
            }
            if tick > settled {
                assert!((force.newtons()[0] / held - 1.0).abs() < 1e-6, "{tick}");
            }
        }
    }
}

#[test]
fn the_observer_predicts_that_a_motion_goes_on_and_damps_no_more_than_needed() {
    let (chain, mut state) = guarded::<f64, 1>(observer(), 10.0, 1e6);
    // 1 mm against 1 N and back, from where it would go on and draw 1 mJ more: no damping, none, all.
    for (x, energy, force) in [(0.0, 0.0, -1.0), (1e-3, 1e-3, -1.0), (0.0, 0.0, 0.0)] {
        let (sent, limiters) = chain.apply(&mut state, &vector![x], &vector![-1.0]);
        // Of the energy 1/250 is forgotten in a sample.
        assert!((state.observed_energy_j() - energy).abs() < 5e-6, "{x}");
        assert!((sent.newtons()[0] - force).abs() < 5e-3, "{x}");
        assert_eq!(limiters.contains(Limiters::GUARD), force > -1.0);
    }
}

#[test]
fn the_books_go_on_while_a_force_falls_to_zero() {
    for (guard, damping) in [(observer(), 0.0), (bounding(0.0), 0.8 * DAMPING / T.0)] {
        let (chain, mut state) = guarded::<f64, 1>(guard, 10.0, 0.1 / T.0);
        let mut x = 0.0;
        for _ in 0..20 {
            x += 1e-3;
            apply(&chain, &mut state, x, -1.0);
        }
        let before = state.observed_energy_j();
        state.stop();
        apply(&chain, &mut state, x, -1.0);
        // Back by 1 mm under the 0.9 N that are left.
        apply(&chain, &mut state, x - 1e-3, -1.0);
        let lost = before - state.observed_energy_j();
        let want = 0.9e-3 - damping * 1e-6;
        // But for what is forgotten, 1/250 of at most 50 mJ a sample.
        assert_close("lost", lost, want, 4e-4);
    }
}

/// Motions in µm and wanted forces in N.
fn motions() -> impl Strategy<Value = Vec<([f64; 2], [f64; 2])>> {
    let steps = proptest::array::uniform2(-300.0..300.0);
    let forces = proptest::array::uniform2(-20.0..20.0);
    proptest::collection::vec((steps, forces), 1..400)
}

proptest! {
    #[test]
    fn no_motion_draws_more_than_the_damping_of_the_device(
        motions in motions(), delay in 0usize..=4, forget in prop_oneof![Just(0.0), 0.002..2.0],
    ) {
        let delay_s = delay as f64 * T.0;
        let guard = EnergyBounding { forget: Seconds(forget), ..late(delay_s, delay_s, 0.0) };
        let (chain, mut state) = guarded::<f64, 2>(Some(PassivityGuard::EnergyBounding(guard)), 100.0, 200.0 / T.0);
        let (mut x, mut energy) = (SVector::<f64, 2>::zeros(), 0.0);
        let mut line = [SVector::<f64, 2>::zeros(); 5];
        for (step, wanted) in motions {
            let moved = SVector::from(step) * 1e-6;
            x += moved;
            // What the force that acts does, and what the damping surely takes.
            energy += 0.8 * DAMPING / T.0 * moved.norm_squared() - line[delay].dot(&moved);
            prop_assert!(energy >= -1e-12, "{energy}");
            let (force, _) = chain.apply(&mut state, &x, &SVector::from(wanted));
            prop_assert!(state.observed_energy_j() <= energy + 1e-12);
            prop_assert!(state.observed_energy_j() >= -1e-12);
            line.rotate_right(1);
            line[0] = *force.newtons();
        }
    }

    #[test]
    fn the_observer_never_credits_more_than_was_given(motions in motions()) {
        let (chain, mut state) = guarded::<f64, 2>(observer(), 100.0, 200.0 / T.0);
        let (mut x, mut given) = (SVector::<f64, 2>::zeros(), 0.0);
        let mut last = SVector::<f64, 2>::zeros();
        let most = MASS / (2.0 * T.0);
        for (index, (step, wanted)) in motions.into_iter().enumerate() {
            // The first position is where it starts.
            let moved = SVector::from(step) * if index == 0 { 0.0 } else { 1e-6 };
            x += moved;
            given -= last.dot(&moved);
            let wanted = SVector::from(wanted);
            let (force, limiters) = chain.apply(&mut state, &x, &wanted);
            last = *force.newtons();
            prop_assert!(state.observed_energy_j() <= given + 1e-12);
            // Damping along the part of the motion that works, no more than the device bears.
            let moved = wanted * (wanted.dot(&moved) / wanted.norm_squared());
            let damping = (wanted - last) * T.0;
            prop_assert!((damping.dot(&moved) - damping.norm() * moved.norm()).abs() < 1e-12);
            prop_assert!(damping.norm() <= most * moved.norm() + 1e-12);
            prop_assert_eq!(limiters.contains(Limiters::GUARD), damping.norm() > 1e-15 );
        }
    }
}
