//! What a change does to the force and to the energy of a touch.

use super::*;
use fracdiff::{Operator, Order, Scheme, Seconds};
use haptic_loop::SpringDamper;

type Damper = SpringDamper<f64, Operator<f64>>;

fn law(order: f64, dissipation: f64) -> Damper {
    let scheme: Scheme = "full".parse().expect("a scheme");
    let order = Order::new(order).expect("valid");
    let operator = scheme.build(order, Seconds(1e-3), 1e4).expect("made");
    SpringDamper::new(100.0, dissipation, operator).expect("valid")
}

fn position(n: u32) -> Vector1<f64> {
    Vector1::new(1e-3 * (f64::from(n) / 300.0).sin().max(0.0))
}

/// Force of a law alone on the same motion.
fn alone(law: &Damper, ticks: u32) -> Vec<f64> {
    let mut history: <Damper as Environment<f64, 1>>::History = law.at_rest();
    let tick = |n| {
        let x = position(n);
        let force = law.force(&history, &x)[0];
        law.advance(&mut history, &x);
        force
    };
    (0..ticks).map(tick).collect()
}

#[test]
fn a_change_goes_from_the_old_force_to_the_new_without_a_bump() {
    let (old, new) = (law(0.3, 20.0), law(0.6, 5.0));
    let (of_old, of_new) = (alone(&old, 2000), alone(&new, 2000));
    let mut fading = Fading::new(old, 100);
    let mut history = fading.at_rest();
    let mut largest_step = 0.0_f64;
    let mut before = 0.0;
    for n in 0..2000_u32 {
        if n == 500 {
            let mut next = Law::at_rest(new.clone());
            for heard in 0..n {
                next.hear(position(heard)[0]);
            }
            fading.change(&mut history, &mut next);
        }
        let x = position(n);
        let force = fading.force(&history, &x)[0];
        let share = (f64::from(n) - 500.0) / 100.0;
        let share = share.clamp(0.0, 1.0);
        let want = (1.0 - share) * of_old[n as usize] + share * of_new[n as usize];
        // Until the touch is nearly over: then it gives no more than it took.
        if n < 800 {
            assert!((force - want).abs() < 1e-12, "tick {n}: {force} for {want}");
        }
        history.sent(force);
        if (490..800).contains(&n) {
            largest_step = largest_step.max((force - before).abs());
        }
        before = force;
        fading.advance(&mut history, &x);
    }
    // No larger than the two forces themselves change, and a hundredth of what lies between them.
    let apart = (of_old[500] - of_new[500]).abs();
    assert!(apart > 10.0 * largest_step, "{largest_step} of {apart}");
}

/// Energy that a law, changed at these ticks, has given in each touch of a motion, J; and the force at each tick. Of the law, not
/// of the hold of its force, which the damping of a device pays for.
fn given(
    laws: &[Felt],
    changes: &[u32],
    motion: impl Fn(u32) -> f64,
    ticks: u32,
) -> (Vec<f64>, Vec<f64>) {
    let mut fading = Fading::new(laws[0].clone(), 200);
    let mut history = fading.at_rest();
    let (mut touches, mut forces) = (vec![0.0], Vec::new());
    for n in 0..ticks {
        if let Some(change) = changes.iter().position(|&at| at == n) {
            let mut next = Law::at_rest(laws[change + 1].clone());
            (0..n).for_each(|heard| next.hear(motion(heard)));
            fading.change(&mut history, &mut next);
        }
        let x = Vector1::new(motion(n));
        let force = fading.force(&history, &x)[0];
        fading.advance(&mut history, &x);
        history.sent(force);
        if x[0] <= 0.0 {
            touches.push(0.0);
        }
        if let Some(touch) = touches.last_mut() {
            *touch += force * (motion(n) - motion(n.max(1) - 1));
        }
        forces.push(force);
    }
    (touches, forces)
}

type Felt = haptic_loop::Contact<f64, Damper, 1>;

fn tissue(order: f64, stiffness: f64, dissipation: f64) -> Felt {
    let scheme: Scheme = "full".parse().expect("a scheme");
    let order = Order::new(order).expect("valid");
    let operator = scheme.build(order, Seconds(1e-3), 1e4).expect("made");
    let inner = SpringDamper::new(stiffness, dissipation, operator).expect("valid");
    Felt::at(haptic_loop::units::Metres(0.0), inner).expect("valid")
}

#[test]
fn a_touch_in_which_the_law_grows_stiffer_gives_no_more_than_it_took() {
    let (soft, stiff) = (tissue(0.3, 100.0, 5.0), tissue(0.3, 1000.0, 50.0));
    // Two touches to 5 mm: in 0.3 s, held for 1 s, back in 0.3 s.
    let motion = |n: u32| {
        let t = f64::from(n % 2000);
        5e-3 * (t / 300.0).min(1.0).min((1600.0 - t) / 300.0) - 1e-4
    };
    let laws = [soft, stiff.clone()];
    let (touches, forces) = given(&laws, &[700], motion, 4000);
    let most = touches.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    assert!(most < 1e-9, "{most:e} J given");
    // It is felt at once where nobody moves, and in the next touch as if it had always been.
    let alone = given(&[stiff], &[], motion, 4000).1;
    assert!((forces[1100] / alone[1100] - 1.0).abs() < 1e-12);
    for n in 2000..4000 {
        assert_eq!(forces[n].to_bits(), alone[n].to_bits(), "tick {n}");
    }
}

#[test]
fn no_touch_gives_energy_whatever_changes_in_it() {
    let mut random = 1_u64;
    let mut share = move || {
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (random >> 11) as f64 / (1_u64 << 53) as f64
    };
    for case in 0..40 {
        let laws: Vec<Felt> = (0..4)
            .map(|_| tissue(share(), 1000.0 * share(), 1.0 + 60.0 * share()))
            .collect();
        let changes = [1, 2, 3].map(|n| 700 * n + (400.0 * share()) as u32);
        let (size, slow, fast) = (
            5e-3 * share(),
            100.0 + 400.0 * share(),
            20.0 + 40.0 * share(),
        );
        let motion = |n: u32| {
            let n = f64::from(n);
            size * ((n / slow).sin() + 0.2 * (n / fast).sin())
        };
        let (touches, _) = given(&laws, &changes, motion, 3000);
        for (n, touch) in touches.iter().enumerate() {
            assert!(*touch < 1e-6, "case {case}, touch {n}: {touch:e} J");
        }
    }
}

#[test]
fn what_is_replaced_is_gone_at_once() {
    let (old, new) = (law(0.3, 20.0), law(0.6, 5.0));
    let mut fading = Fading::new(old.clone(), 100);
    let mut history = fading.at_rest();
    fading.advance(&mut history, &Vector1::new(1e-3));
    let mut next = Law::at_rest(new.clone());
    fading.replace(&mut history, &mut next);
    let fresh: <Damper as Environment<f64, 1>>::History = new.at_rest();
    let x = Vector1::new(2e-3);
    assert_eq!(fading.force(&history, &x), new.force(&fresh, &x));
    // The caller has the one that was.
    let force: Vector1<f64> = next.environment.force(&next.history, &Vector1::new(1e-3));
    let rested: Vector1<f64> = old.force(&old.at_rest(), &Vector1::new(1e-3));
    assert!(force[0] > rested[0], "it remembers 1 mm");
}
