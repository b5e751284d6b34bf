//! Environments: the law, its sign, one-sidedness, axes kept apart.
#![expect(clippy::float_cmp, reason = "exact results are compared exactly")]

use crate::{T, memory, spring};
use fracdiff::{Differintegrator, ShortMemory};
use haptic_loop::units::{Metres, Pascals, SquareMetres};
use haptic_loop::{
    Contact, Environment, Modulus, OwnPush, Pushing, Specimen, SpringDamper, Tap, Tissue, Wall,
    WallShape,
};
use nalgebra::{Vector1, vector};
use proptest::prelude::*;
use testkit::{assert_close, assert_refused, assert_relative, operator::order};

/// Positions through an environment, forces out.
fn run<E: Environment<f64, 1>>(environment: &E, positions: &[f64]) -> Vec<f64> {
    let path = positions.iter().map(|&x| Vector1::new(x));
    let forces = crate::forces(environment, path).into_iter();
    forces.map(|force| force[0]).collect()
}

#[test]
fn axes_do_not_mix() {
    let environment = spring(100.0, 2.0, 0.5);
    let mut history = Environment::<f64, 3>::at_rest(&environment);
    let (mut x_axis, mut z_axis) = (memory(0.5).at_rest(), memory(0.5).at_rest());
    for n in 1..100 {
        let x = vector![1e-3 * f64::from(n), 0.0, -2e-3 / f64::from(n)];
        let force = environment.force(&history, &x);
        environment.advance(&mut history, &x);
        let alone = |x: f64, h| -(100.0 * x + 2.0 * memory(0.5).step(h, x));
        assert_eq!(force[0], alone(x[0], &mut x_axis));
        assert_eq!(force[1], 0.0);
        assert_eq!(force[2], alone(x[2], &mut z_axis));
    }
}

/// A spring and damper that comes at v: the signed law pushes from x = −(B/K)·v on, and rises by K·v·T a sample; the law that
/// is fed with the depth makes nothing before the surface, and jumps there by B times the speed of the first sample inside.
#[test]
fn a_signed_contact_pushes_before_the_surface_and_does_not_jump_there() {
    let (k, b, v, t) = (1000.0, 20.0, 0.5, T.0);
    let pushing = |as_it_is| Pushing::new(spring(k, b, 1.0), as_it_is);
    let way: Vec<f64> = (0..=40).map(|n| v * t * f64::from(n) - 0.015).collect();
    let signed = run(&pushing(false), &way);
    let depth = run(
        &Contact::at(Metres(0.0), spring(k, b, 1.0)).expect("valid"),
        &way,
    );
    // The first sample sees a jump from rest at 0 to where the device comes from, which pulls.
    for (n, &x) in way.iter().enumerate().skip(1) {
        let want = (k * x + b * v).max(0.0);
        assert!((signed[n] + want).abs() < 1e-9, "{x}: {} {want}", signed[n]);
    }
    let touched = way.iter().position(|x| *x > 0.0).expect("touches");
    assert!(depth[..touched].iter().all(|force| *force == 0.0));
    let jump = |forces: &[f64]| forces[touched - 1] - forces[touched];
    assert!(jump(&signed) <= k * v * t + 1e-9, "{}", jump(&signed));
    let first = way[touched];
    assert_close(
        "jump(&depth)",
        jump(&depth),
        k * first + b * first / t,
        1e-9,
    );
    assert!(jump(&depth) > 9.0, "{}", jump(&depth));
    // Never a pull, and an environment as it is is not clamped.
    let out: Vec<f64> = (0..20).map(|n| 0.01 - v * t * f64::from(n)).collect();
    assert!(run(&pushing(false), &out).iter().all(|force| *force <= 0.0));
    assert_eq!(run(&pushing(true), &out), run(&spring(k, b, 1.0), &out));
    for odd in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert!(!run(&pushing(false), &[odd])[0].is_finite());
    }
}

#[test]
fn a_slab_is_its_area_over_its_thickness() {
    // A/ℓ = 4e-4/0.02 = 0.02 m
    let specimen = Specimen::slab(SquareMetres(4e-4), Metres(0.02)).expect("valid");
    assert_close("A/ℓ", specimen.shape(Modulus::Young), 0.02, 1e-17);
    assert_eq!(specimen.strain(Metres(1e-3)), 0.05);
}

#[test]
fn relaxation_stress_agrees_with_50_digits() {
    // tests/golden/make_golden.py: cancerous prostate, 5 % in 1 s.
    let tissue = Tissue::new(Pascals(0.0), 8650.0, order(0.2247)).expect("valid");
    for row in testkit::golden::rows("relaxation_stress_pa.csv") {
        let [time, want] = row[..] else {
            panic!("{row:?}");
        };
        let have = tissue.relaxation_stress(0.05, 1.0, time).0;
        assert!((have / want - 1.0).abs() < 1e-13, "t {time}: {have} {want}");
    }
}

#[test]
fn a_short_ramp_relaxes_like_a_step() {
    let tissue = Tissue::new(Pascals(70.0), 30.0, order(0.4)).expect("valid");
    let ramp = tissue.relaxation_stress(0.1, 1e-6, 5.0).0;
    let step = tissue.relaxation_stress(0.1, 0.0, 5.0).0;
    assert_relative("ramp", ramp, step, 1e-7);
    assert_eq!(tissue.relaxation_stress(0.1, 1.0, 0.0).0, 0.0);
    assert_eq!(tissue.relaxation_stress(0.1, 1.0, -3.0).0, 0.0);
}

#[test]
fn bad_parameters_are_refused_with_name_value_range_and_unit() {
    assert_refused(
        SpringDamper::new(-1.0, 0.0, memory(0.5)),
        "stiffness -1 N/m is not at least 0 N/m",
    );
    for (area, thickness, words) in [
        (1e-4, 0.0, "thickness 0 m is not above 0 m"),
        (f64::NAN, 1.0, "area NaN m² is not above 0 m²"),
    ] {
        assert_refused(Specimen::slab(SquareMetres(area), Metres(thickness)), words);
    }
    assert_refused(
        Tissue::new(Pascals(1.0), 1.0, order(1.5)),
        "order of a tissue 1.5 is not in [0, 1]",
    );
    assert!(Tissue::new(Pascals(0.0), 0.0, order(0.5)).is_err());
    // Finite in f64, infinite in f32.
    let single = ShortMemory::<f32, 8>::new(order(0.5), T).expect("valid");
    assert!(SpringDamper::new(1e39, 0.0, single.clone()).is_err());
    assert!(SpringDamper::new(0.0, 1e39, single).is_err());
}

proptest! {
    #[test]
    fn a_push_of_its_own_is_added_to_the_law_from_where_the_handle_stood(
        positions in proptest::collection::vec(-0.01..0.01_f64, 50), mu in 0.0..2.0_f64, push in -3.0..3.0_f64, start in -0.1..0.1_f64,
        tap in -3.0..3.0_f64, ticks in 1..20_u32,
    ) {
        let law = || spring(500.0, 2.0, mu);
        let wanted = run(&law(), &positions);
        prop_assert_eq!(&run(&OwnPush::new(law(), None), &positions), &wanted);
        let tap = Tap { force_n: tap, ticks };
        let mut pushed = OwnPush::new(law(), None);
        pushed.reshape(Some(push), tap);
        prop_assert_eq!([0, ticks - 1, ticks, 2 * ticks].map(|n| tap.at(n.into())), [0.0, 0.0, tap.force_n, 0.0]);
        let mut history = pushed.at_rest();
        pushed.settle(&mut history, &vector![start]);
        prop_assert!(pushed.starting_force(&history, &vector![start])[0] == 0.0);
        for (n, (x, law_n)) in (0..).zip(positions.iter().zip(wanted)) {
            let (force, input) = pushed.force_and_input(&history, &vector![start + x]);
            let push = push + tap.at(n);
            prop_assert!((force[0] - law_n - push).abs() < 1e-6, "{} {law_n} {push}", force[0]);
            pushed.advance_input(&mut history, &input);
        }
    }

    #[test]
    fn a_contact_never_pulls(positions in proptest::collection::vec(-0.01..0.01_f64, 200), mu in 0.0..2.0_f64) {
        let contact = Contact::at(Metres(0.001), spring(500.0, 0.1, mu)).expect("valid");
        for (n, force) in run(&contact, &positions).iter().enumerate() {
            prop_assert!(*force <= 0.0, "sample {}: {}", n, force);
            prop_assert!(positions[n] > 0.001 || *force == 0.0, "sample {}: {}", n, force);
        }
    }
}

#[test]
fn a_wall_that_is_reshaped_in_its_place_is_the_new_one_and_its_history_at_rest() {
    let shapes = [
        (100.0, 2.0, None),
        (300.0, 0.0, Some(Metres(0.01))),
        (50.0, 1.0, Some(Metres(-0.02))),
        (0.0, 3.0, None),
    ];
    for (k, b, surface) in shapes {
        for (other_k, other_b, other_surface) in shapes {
            let mut wall = Wall::new(k, b, memory(0.5), surface).expect("valid");
            let mut history = wall.at_rest();
            wall.advance(&mut history, &vector![0.1]);
            let shape = WallShape::new(other_k, other_b, other_surface).expect("valid");
            *wall.reshape(shape, || memory(1.0)) = memory(0.3);
            assert_eq!(wall, Wall::of(shape, memory(0.3)));
            wall.rest(&mut history);
            assert_eq!(history, wall.at_rest());
        }
    }
    let none = Wall::of(WallShape::NONE, memory(0.5));
    assert_eq!(none.force(&none.at_rest(), &vector![1.0]), vector![0.0]);
}

#[test]
fn a_wall_that_sees_the_place_in_front_of_it_starts_where_the_device_stands() {
    // Of order 1.5 the way from zero would push a device that stands still 50 mm in front of the wall.
    for mu in [0.5, 1.0, 1.5, 1.9] {
        let operator = ShortMemory::<f64, 64>::new(order(mu), T);
        let wall = SpringDamper::new(1000.0, 1.0, operator.expect("valid")).expect("valid");
        let wall = Pushing::new(wall, false);
        let at = vector![-0.05];
        let mut history = wall.at_rest();
        wall.settle(&mut history, &at);
        for tick in 0..200 {
            assert_eq!(wall.force(&history, &at), vector![0.0], "{mu} {tick}");
            wall.advance(&mut history, &at);
        }
    }
}
