//! Planes and balls: penetration, normal, rotation and the middle of a ball.
#![expect(clippy::float_cmp, reason = "exact results are compared exactly")]

mod axes;

use fracdiff::{Order, Seconds, ShortMemory};
use haptic_loop::units::Metres;
use haptic_loop::{Ball, Contact, Environment, Plane, Shape, SpringDamper, Surface};
use nalgebra::{Rotation3, SVector, Vector3, vector};
use testkit::{assert_close, assert_relative};

const T: Seconds = Seconds(1e-3);

type Tissue = SpringDamper<f64, ShortMemory<f64, 64>>;

fn tissue() -> Tissue {
    let operator = ShortMemory::new(Order::new(0.3).expect("valid"), T).expect("valid");
    SpringDamper::new(400.0, 8.0, operator).expect("valid")
}

/// Positions through an environment, forces out.
fn run<E: Environment<f64, D>, const D: usize>(
    environment: &E,
    path: impl IntoIterator<Item = SVector<f64, D>>,
) -> Vec<SVector<f64, D>> {
    let mut history = environment.at_rest();
    path.into_iter()
        .map(|x| {
            let force = environment.force(&history, &x);
            environment.advance(&mut history, &x);
            force
        })
        .collect()
}

/// In and out of a surface at 0, and in again: depth of sample n, m.
fn depth(n: u32) -> f64 {
    4e-3 * (0.03 * f64::from(n)).sin()
}

fn ball_3(centre: [f64; 3], radius: f64) -> Ball<f64, 3> {
    Ball::solid(centre.map(Metres), Metres(radius)).expect("valid")
}

#[test]
fn a_sphere_pressed_along_a_line_is_the_wall_of_one_axis() {
    // Exact in binary, so that depth, normal and force have no rounding of their own.
    let radius = 0.25;
    let sphere = Contact::behind(ball_3([0.0; 3], radius), tissue());
    let wall = Contact::at(Metres(0.0), tissue()).expect("valid");
    let one = run(&wall, (0..600).map(|n| vector![depth(n)]));
    let along = (0..600).map(|n| vector![0.0, 0.0, -(radius - depth(n))]);
    for (n, (sphere, one)) in run(&sphere, along).iter().zip(&one).enumerate() {
        assert_eq!([sphere[0], sphere[1]], [0.0, 0.0], "{n}");
        // radius − (radius − depth) is the depth to a rounding of the radius.
        assert_close("force", sphere[2], one[0], 1e-12);
    }
    assert!(one.iter().any(|force| force[0] < -1.0));
}

#[test]
fn turning_plane_and_path_turns_the_force() {
    let (normal, offset) = (vector![0.3, -0.5, 0.9], 4e-3);
    let path = |n: u32| {
        let s = 0.01 * f64::from(n);
        vector![
            9e-3 * s.sin(),
            8e-3 * (1.7 * s).cos(),
            7e-3 * (0.6 * s).sin()
        ]
    };
    let wall = |normal: Vector3<f64>| {
        Contact::new(normal.into(), Metres(offset), tissue()).expect("valid")
    };
    let straight = run(&wall(normal), (0..900).map(path));
    let turn = Rotation3::from_euler_angles(0.7, -1.1, 2.3);
    let turned = run(&wall(turn * normal), (0..900).map(|n| turn * path(n)));
    let mut most = 0.0_f64;
    for (straight, turned) in straight.iter().zip(&turned) {
        assert!(
            (turn * straight - turned).norm() <= 1e-12 * 8.0,
            "{straight} {turned}"
        );
        most = most.max(straight.norm());
    }
    assert!(most > 1.0, "it was touched: {most} N");
}

#[test]
fn a_hand_that_slides_round_a_disc_feels_one_memory() {
    // At one depth all the way round: as if it stood still and the tissue relaxed.
    let (radius, depth) = (0.25, 2e-3);
    let disc = Ball::solid([Metres(0.0); 2], Metres(radius)).expect("valid");
    let still = run(
        &Contact::at(Metres(0.0), tissue()).expect("valid"),
        (0..500).map(|_| vector![depth]),
    );
    let round = |n: u32| {
        let angle = 0.02 * f64::from(n);
        (radius - depth) * vector![angle.cos(), angle.sin()]
    };
    let forces = run(&Contact::behind(disc, tissue()), (0..500).map(round));
    for (n, (force, still)) in forces.iter().zip(&still).enumerate() {
        assert_close("force", force.norm(), -still[0], 1e-11);
        // Outwards, along the normal: no friction.
        let outwards = round(u32::try_from(n).expect("small")).normalize();
        assert!((force - force.norm() * outwards).norm() < 1e-12);
    }
    // K·p stays of K·p + B·D^μ p.
    assert!(forces[0].norm() > 1.1 * forces[499].norm());
}

#[test]
fn in_the_middle_of_a_ball_the_force_is_bounded_continuous_and_no_nan() {
    let radius = 0.02;
    let ball = Contact::behind(ball_3([0.0; 3], radius), tissue());
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
    let disc = Ball::<f64, 2>::solid([Metres(0.0); 2], Metres(0.02)).expect("valid");
    let disc = Contact::behind(Shape::Ball(disc), tissue());
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e200] {
        let force = disc.force(&disc.at_rest(), &vector![x, 0.0]);
        assert!(!force.iter().all(|axis| axis.is_finite()), "{x}: {force}");
    }
}

#[test]
fn surfaces_without_size_or_direction_are_refused() {
    for radius in [0.0, -1.0, 1e-7, 1e7, f64::NAN] {
        let error = Ball::<f64, 3>::solid([Metres(0.0); 3], Metres(radius)).expect_err("refused");
        assert!(error.to_string().contains("radius of the ball"), "{error}");
    }
    assert!(Ball::<f32, 2>::hollow([Metres(1e300), Metres(0.0)], Metres(1.0)).is_err());
    assert!(Plane::<f64, 2>::new([0.0, 0.0], Metres(0.0)).is_err());
    assert!(Plane::<f64, 2>::new([1.0, 0.0], Metres(f64::INFINITY)).is_err());
}

#[test]
fn a_start_in_the_middle_of_a_ball_is_judged_by_the_force_beside_it() {
    let operator = ShortMemory::<f64, 8>::new(Order::new(0.5).expect("valid"), T).expect("valid");
    let law = SpringDamper::new(1200.0, 0.0, operator).expect("valid");
    let disc = Ball::solid([Metres(0.0); 2], Metres(0.05)).expect("valid");
    let disc = Contact::behind(disc, law);
    let rest = disc.at_rest();
    let (middle, beside, outside) = (vector![0.0, 0.0], vector![0.001, 0.0], vector![0.06, 0.0]);
    assert_eq!(disc.force(&rest, &middle).norm(), 0.0);
    let starting = |place| disc.starting_force(&rest, place).norm();
    assert_relative("in the middle", starting(&middle), 1200.0 * 0.05, 1e-12);
    let there = disc.force(&rest, &beside).norm();
    assert_relative("beside it", starting(&beside), there, 1e-12);
    assert_eq!(starting(&outside), 0.0);
}
