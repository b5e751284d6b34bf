//! Planes and balls: penetration, normal, rotation and the middle of a ball; what a safety chain, its guards and a device make of several
//! axes.
#![expect(clippy::float_cmp, reason = "exact results are compared exactly")]

use crate::{T, chain, forces as run, spring};
use fracdiff::Seconds;
use haptic_loop::plant::{Axes, MassMatrix};
use haptic_loop::units::{Kilograms, Metres, NewtonSecondsPerMetre, Newtons, NewtonsPerSecond};
use haptic_loop::{
    Ball, Contact, Controller, Device as _, EnergyBounding, Environment, PassivityGuard,
    PassivityObserver, Plane, Reading, SafetyLimits, Shape, ShapeNumbers, SpringDamper, Surface,
};
use nalgebra::{Matrix2, Matrix3, Rotation3, Vector2, Vector3, vector};
use testkit::device::{DAMPING, MASS, ideal, plant, safe, with_hand, write};
use testkit::{assert_refused, assert_relative};

type Tissue = SpringDamper<f64, crate::Memory>;

/// Depth of sample n, m: in and out of a surface at 0, and in again.
fn depth(n: u32) -> f64 {
    4e-3 * (0.03 * f64::from(n)).sin()
}

fn tissue() -> Tissue {
    spring(400.0, 8.0, 0.3)
}

fn ball<const D: usize>(radius: f64) -> Ball<f64, D> {
    Ball::solid([Metres(0.0); D], Metres(radius)).expect("valid")
}

fn wall() -> Contact<f64, Tissue, 1> {
    Contact::at(Metres(0.0), tissue()).expect("valid")
}

/// Numbers as they go to a device: what is made a unit normal again is rounded again.
#[test]
fn a_shape_of_its_numbers_is_the_same_to_the_last_bit() {
    for n in 0..1000 {
        let s = f64::from(n);
        let (normal, at) = (
            [s.sin(), (1.7 * s).cos(), 0.3 - (0.6 * s).sin()],
            0.02 * s.cos(),
        );
        let plane = Plane::<f32, 3>::new(normal, Metres(at)).expect("valid");
        let (centre, radius) = (normal.map(Metres), Metres(0.03 + at));
        let solid = Ball::solid(centre, radius).expect("valid");
        let hollow = Ball::hollow(centre, radius).expect("valid");
        for shape in [Shape::Plane(plane), Shape::Ball(solid), Shape::Ball(hollow)] {
            assert_eq!(Shape::of(&shape.numbers()), Ok(shape), "{n}");
        }
    }
    let good = Shape::Plane(Plane::<f32, 2>::new([3.0, 4.0], Metres(0.0)).expect("valid"));
    for place in [
        [0.6, 0.81],
        [0.6, f32::NAN],
        [0.0, 0.0],
        [f32::INFINITY, 0.8],
    ] {
        let bad = ShapeNumbers {
            place,
            ..good.numbers()
        };
        assert!(Shape::of(&bad).is_err(), "{place:?}");
    }
}

#[test]
fn a_plane_is_the_wall_of_one_axis_along_its_normal() {
    let along: Vector3<f64> = vector![0.3, -0.5, 0.9];
    let (normal, offset) = (along.normalize(), Metres(4e-3));
    let path = |n: u32| {
        let s = 0.01 * f64::from(n);
        vector![
            9e-3 * s.sin(),
            8e-3 * (1.7 * s).cos(),
            7e-3 * (0.6 * s).sin()
        ]
    };
    let plane = Contact::new(along.into(), offset, tissue()).expect("valid");
    let wall = Contact::at(offset, tissue()).expect("valid");
    let depths = (0..900).map(|n| vector![normal.dot(&path(n))]);
    let mut most = 0.0_f64;
    for (have, one) in run(&plane, (0..900).map(path))
        .iter()
        .zip(run(&wall, depths))
    {
        assert!((have - normal * one[0]).norm() <= 1e-11, "{have} {one}");
        most = most.max(have.norm());
    }
    assert!(most > 1.0, "it was touched: {most} N");
}

#[test]
fn a_hand_that_slides_round_a_disc_feels_one_memory_and_the_wall_of_one_axis() {
    let radius = 0.25;
    let round = |n: u32| {
        let angle = 0.02 * f64::from(n);
        vector![angle.cos(), angle.sin()]
    };
    let one = run(&wall(), (0..600).map(|n| vector![depth(n)]));
    let path = (0..600).map(|n| (radius - depth(n)) * round(n));
    let forces = run(&Contact::behind(ball::<2>(radius), tissue()), path);
    for ((n, force), one) in (0..).zip(&forces).zip(&one) {
        // Outwards, along the normal: no friction. radius − (radius − depth) is the depth to a rounding of the radius.
        assert!((force + one[0] * round(n)).norm() < 1e-11, "{n}: {force}");
    }
    assert!(one.iter().any(|force| force[0] < -1.0));
}

#[test]
fn in_the_middle_of_a_ball_the_force_is_bounded_continuous_and_no_nan() {
    let radius = 0.02;
    let ball = Contact::behind(ball::<3>(radius), tissue());
    let at = |x: f64| ball.force(&ball.at_rest(), &vector![x, 0.0, 0.0]);
    assert_eq!(at(0.0), vector![0.0, 0.0, 0.0]);
    let most = at(-radius / 512.0).norm();
    let mut last = at(-1e-3)[0];
    for n in -1000..=1000 {
        let force = at(1e-6 * f64::from(n));
        assert!(force.iter().all(|axis| axis.is_finite()) && force.norm() <= 1.001 * most);
        // 1 µm in a core of 20 µm: a twentieth of the force, and a little of the slope.
        assert!(
            (force[0] - last).abs() < 0.06 * most,
            "{n}: {last} to {}",
            force[0]
        );
        last = force[0];
    }
    // So small that its square is no number: still none but a small force.
    for tiny in [1e-200, f64::MIN_POSITIVE] {
        assert!(at(tiny).norm() < 1e-6, "{tiny}");
    }
    let single = Ball::<f32, 2>::solid([Metres(0.0); 2], Metres(1e-6)).expect("valid");
    let (depth, normal) = single.touch(&vector![1e-30, 0.0]);
    assert!(depth > 0.0 && normal.iter().all(|n| n.abs() < 1e-6));
}

#[test]
fn a_depth_tells_how_long_the_normal_is() {
    let centre = [Metres(0.01), Metres(-0.02)];
    let solid = Ball::<f64, 2>::solid(centre, Metres(0.02)).expect("valid");
    let hollow = Ball::<f64, 2>::hollow(centre, Metres(0.02)).expect("valid");
    let line = Plane::<f64, 2>::new([1.0, 2.0], Metres(0.0)).expect("valid");
    for shape in [Shape::Ball(solid), Shape::Ball(hollow), Shape::Plane(line)] {
        for n in 0..400 {
            // From the centre, by a core of 20 µm, to outside.
            let place = vector![0.01, -0.02] + vector![0.6, 0.8] * 1e-6 * 1.04_f64.powi(n);
            let (depth, normal) = shape.touch(&place);
            let have = shape.normal_length(depth);
            assert!((have - normal.norm()).abs() < 1e-9, "{n}: {have}");
        }
    }
}

#[test]
fn a_hollow_ball_keeps_the_hand_inside() {
    let hollow = Ball::hollow([Metres(0.1), Metres(0.0)], Metres(0.05)).expect("valid");
    let room = Contact::behind(hollow, tissue());
    let force = |x| room.force(&room.at_rest(), &x);
    assert_eq!(force(vector![0.1, 0.0]), vector![0.0, 0.0]);
    assert_eq!(force(vector![0.12, 0.03]), vector![0.0, 0.0]);
    let pushed = force(vector![0.1, 0.052]);
    assert!(pushed[0].abs() < 1e-12 && pushed[1] < -0.5, "{pushed}");
}

#[test]
fn a_place_that_is_not_finite_reaches_the_chain_as_no_force() {
    let disc = Contact::behind(Shape::Ball(ball::<2>(0.02)), tissue());
    let wall = wall();
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e200] {
        let force = disc.force(&disc.at_rest(), &vector![x, 0.0]);
        assert!(!force.iter().all(|axis| axis.is_finite()), "{x}: {force}");
        let force = wall.force(&wall.at_rest(), &vector![x])[0];
        assert!(x == 1e200 || !force.is_finite(), "{x}: {force}");
    }
}

#[test]
fn surfaces_without_size_or_direction_are_refused() {
    for radius in [0.0, -1.0, 1e-7, 1e7, f64::NAN] {
        let ball = Ball::<f64, 3>::solid([Metres(0.0); 3], Metres(radius));
        assert_refused(ball, "radius of the ball");
    }
    assert!(Ball::<f32, 2>::hollow([Metres(1e300), Metres(0.0)], Metres(1.0)).is_err());
    assert!(Plane::<f64, 2>::new([0.0, 0.0], Metres(0.0)).is_err());
    assert!(Plane::<f64, 2>::new([1.0, 0.0], Metres(f64::INFINITY)).is_err());
}

#[test]
fn a_start_in_the_middle_of_a_ball_is_judged_by_the_force_beside_it() {
    let disc = Contact::behind(ball::<2>(0.05), spring(1200.0, 0.0, 0.5));
    let rest = disc.at_rest();
    let (middle, rim, outside) = (vector![0.0, 0.0], vector![0.001, 0.0], vector![0.06, 0.0]);
    assert_eq!(disc.force(&rest, &middle).norm(), 0.0);
    let starting = |place| disc.starting_force(&rest, place).norm();
    assert_relative("in the middle", starting(&middle), 1200.0 * 0.05, 1e-12);
    let force_n = disc.force(&rest, &rim).norm();
    assert_relative("beside it", starting(&rim), force_n, 1e-12);
    assert_eq!(starting(&outside), 0.0);
}

#[test]
fn axes_of_their_own_move_as_devices_of_one_axis() {
    let configs = [0.05, 0.2].map(|mass| with_hand(mass, 2.0, 300.0, T.0));
    let mut both = Axes::new(configs).expect("valid");
    let mut alone = configs.map(plant);
    for n in 0..300 {
        let force = vector![0.5, -0.01 * f64::from(n)];
        both.write(safe(force)).expect("written");
        for (axis, device) in alone.iter_mut().enumerate() {
            write(device, force[axis]);
            assert_eq!(device.position()[0], both.position()[axis]);
            assert_eq!(device.velocity()[0], both.velocity()[axis]);
        }
        let reading: Reading<f64, 2> = both.read().expect("read");
        assert_eq!(reading.tick, n as u64 + 1);
    }
    let mut other = configs;
    other[1].sample_time = Seconds(2e-3);
    assert_refused(Axes::new(other), "sample time of an axis 0.002 s");
}

#[test]
fn an_effective_mass_is_that_of_a_push_along_the_normal() {
    let masses = [Kilograms(0.05), Kilograms(0.2)];
    let axes = MassMatrix::of_axes(masses).expect("valid");
    for angle in [0.0, 0.3, 1.0, 1.5, 2.5] {
        let normal = vector![f64::cos(angle), f64::sin(angle)];
        let closed = 1.0 / (normal[0] * normal[0] / 0.05 + normal[1] * normal[1] / 0.2);
        let have = axes.along(&(3.0 * normal)).expect("a direction").0;
        assert_relative("effective mass", have, closed, 1e-14);
        assert!((0.05..=0.2).contains(&have));
    }
    let turn = Rotation3::from_euler_angles(0.2, 0.4, -0.9);
    let axes = Matrix3::from_diagonal(&vector![0.05, 0.1, 0.3]);
    let turned = MassMatrix::new(turn * axes * turn.transpose()).expect("valid");
    let along = turned
        .along(&(turn * vector![0.0, 0.0, 1.0]))
        .expect("valid");
    assert_relative("along an own axis", along.0, 0.3, 1e-12);
    for wrong in [
        Matrix2::new(1.0, 2.0, 2.0, 1.0),
        Matrix2::new(1.0, 0.5, 0.0, 1.0),
        Matrix2::new(-1.0, 0.0, 0.0, 1.0),
        Matrix2::new(f64::NAN, 0.0, 0.0, 1.0),
    ] {
        assert!(MassMatrix::new(wrong).is_err(), "{wrong}");
    }
    assert!(
        MassMatrix::of_axes(masses)
            .expect("valid")
            .along(&Vector2::zeros())
            .is_err()
    );
}

/// A stiff wall, and a hand that slides along it while it shakes.
#[test]
fn guards_act_along_the_normal_and_add_no_friction() {
    let damping = NewtonSecondsPerMetre(DAMPING);
    let (normal, along) = (vector![0.6, 0.8], vector![0.8, -0.6]);
    for guard in [
        PassivityGuard::Observer(PassivityObserver::bearable(Kilograms(MASS), T)),
        PassivityGuard::EnergyBounding(EnergyBounding::of(damping)),
    ] {
        let wall = Contact::new(normal.into(), Metres(0.0), spring(60e3, 0.0, 0.3));
        let limits = SafetyLimits {
            guard: Some(guard),
            ..SafetyLimits::bare(Newtons(1e3), NewtonsPerSecond(1e9))
        };
        let mut controller = Controller::new(wall.expect("valid"), chain(limits));
        let device = Axes::new([ideal(MASS, DAMPING, T.0); 2]).expect("valid");
        let mut engaged = controller.engage(device);
        let mut acted = 0;
        for n in 0..3000 {
            let slide = if n < 1500 { 1.5 } else { -1.5 };
            let push = 2.0 * normal + slide * along;
            engaged.device_mut().set_external_force(push);
            let Ok(sample) = engaged.tick();
            let (sent, wanted) = (*sample.force.newtons(), sample.environment_force_n);
            if wanted.norm() > 0.0 {
                let friction = sent.dot(&along).abs();
                assert!(friction < 1e-9, "{guard:?}: {sent} for {wanted}");
                acted += usize::from((sent - wanted).norm() > 1e-6);
            }
        }
        assert!(acted > 10, "{guard:?} acted {acted} times");
    }
}
