//! What a hand meets of a plant: against a mass and damper, the closed form of a series elastic actuator, brute force and a simulation in time.

use fracdiff::{Scheme, Seconds, linear_motion};
use haptic_analysis::{
    ClosedLoop, ForcePath, HandPort, LoopOperator, SampledLoop, SampledPlant, SampledWall,
};
use nalgebra::{DMatrix, DVector};
use num_complex::Complex;
use std::f64::consts::TAU;
use testkit::operator::{exact, order};
use testkit::{assert_close, assert_relative};

/// The guide's actuator: a load of 300 g on a spring of 400 N/m, whose motor's speed follows the error of the force by 0.2 and 4 m/(N·s²).
const SEA: [&[f64]; 3] = [
    &[
        0.0,
        1.0,
        0.0,
        0.0, //
        -4e2 / 0.3,
        0.0,
        4e2 / 0.3,
        0.0, //
        80.0,
        0.0,
        -80.0,
        4.0, //
        400.0,
        0.0,
        -400.0,
        0.0,
    ],
    &[0.0, 0.0, 0.2, 1.0],
    &[1.0, 0.0, 0.0, 0.0],
];
const AT_THE_LOAD: &[f64] = &[0.0, 1.0 / 0.3, 0.0, 0.0];

fn wall(stiffness_n_per_m: f64, dissipation_n_s_mu_per_m: f64, sample_time_s: f64) -> SampledWall {
    SampledWall {
        stiffness_n_per_m,
        dissipation_n_s_mu_per_m,
        order: order(1.0),
        sample_time_s,
    }
}

/// Force per displacement at the hand, N/m.
fn felt(
    plant: [&[f64]; 3],
    hand: Option<&[f64]>,
    wall: SampledWall,
    path: ForcePath,
    omega: f64,
) -> Complex<f64> {
    let t = wall.sample_time_s;
    let operator =
        LoopOperator::new(Scheme::Exact, order(1.0), Seconds(t), 1.0).expect("an operator");
    let [a, b, c] = plant;
    let sampled = SampledPlant::linear(a, b, c, t, 1.0, path).expect("a plant");
    let (alpha, beta) = (
        wall.stiffness_n_per_m * t * t,
        wall.dissipation_n_s_mu_per_m * t,
    );
    let sampled = SampledLoop::with_plant(sampled, alpha, beta, &operator).expect("a loop");
    let port = HandPort::new(plant, [hand, None]).expect("a port");
    let theta = omega * t;
    let law = wall.response(&operator, theta);
    let felt = port
        .felt(law, sampled.loop_gain(theta), path, t, omega)
        .expect("finite");
    Complex::new(felt.stiffness_n_per_m, omega * felt.damping_n_s_per_m)
}

/// A mass with damper.
fn device(mass: f64, damping: f64) -> [Vec<f64>; 3] {
    [
        vec![0.0, 1.0, 0.0, -damping / mass],
        vec![0.0, 1.0 / mass],
        vec![1.0, 0.0],
    ]
}

#[test]
fn a_mass_and_a_damper_are_felt_as_the_closed_loop_and_damp_by_their_damper() {
    let (mass_kg, damping_n_s_per_m, path) = (0.065, 3.5, ForcePath::new(0.4, 0.3).expect("short"));
    let parts = device(mass_kg, damping_n_s_per_m);
    let parts = parts.each_ref().map(Vec::as_slice);
    let (least, _) = HandPort::new(parts, [None; 2])
        .expect("a port")
        .least_damping()
        .expect("passive");
    assert_close("b", least, damping_n_s_per_m, 1e-7);
    for omega in [1.0, 10.0, 60.0] {
        let closed = ClosedLoop {
            mass_kg,
            damping_n_s_per_m,
            environment: wall(800.0, 1.5, 1e-4),
            path,
        };
        let want = closed.sampled(&exact(1.0), omega).expect("finite");
        let want = Complex::new(want.stiffness_n_per_m, omega * want.damping_n_s_per_m);
        let have = felt(parts, None, closed.environment, path, omega);
        // The closed loop leaves out images above π/T: of the order θ² of the hold, and θ·(α + β) of the loop.
        let theta = omega * 1e-4;
        let images = theta * (theta + 2.5e-3);
        assert!(
            (have - want).norm() < images * want.norm().max(800.0),
            "{omega}: {have} {want}"
        );
    }
}

#[test]
fn a_series_elastic_actuator_is_felt_as_its_closed_form_and_gives_energy_beyond_its_spring() {
    for (k, t) in [(300.0, 1e-6), (395.0, 1e-6)] {
        for omega in [1.0, 20.0, 100.0, 400.0] {
            let s = Complex::new(0.0, omega);
            let motor = 0.2 * s + 4.0;
            // k(s² + K(Ps + I))/(s² + k(Ps + I)) at the spring, and the load beside it.
            let want = 400.0 * (s * s + k * motor) / (s * s + 400.0 * motor) + 0.3 * s * s;
            let have = felt(
                SEA,
                Some(AT_THE_LOAD),
                wall(k, 0.0, t),
                ForcePath::NONE,
                omega,
            );
            assert!(
                (have - want).norm() < 5e-4 * (want.norm() + 1.0),
                "{omega}: {have} {want}"
            );
        }
    }
    // Where its own formula is negative, K > k, it is so here.
    let beyond = felt(
        SEA,
        Some(AT_THE_LOAD),
        wall(450.0, 0.0, 1e-6),
        ForcePath::NONE,
        100.0,
    );
    assert!(beyond.im < 0.0, "{beyond}");
    let port = HandPort::new(SEA, [Some(AT_THE_LOAD), None]).expect("a port");
    assert_eq!(port.least_damping(), None, "its hand acts elsewhere");
}

#[test]
fn two_masses_damp_by_no_more_than_a_fine_grid_finds() {
    let mut seeds = testkit::Random(83);
    for case in 0..40 {
        let mut draw = |low, high| seeds.log_between(low, high);
        let [m, b] = [draw(0.01, 1.0), draw(0.1, 10.0)];
        let (m2, b2, k, d) = (
            draw(0.01, 1.0),
            draw(0.01, 10.0),
            draw(50.0, 1e4),
            draw(1e-3, 5.0),
        );
        let a = [
            0.0,
            1.0,
            0.0,
            0.0,
            -k / m,
            -(b + d) / m,
            k / m,
            d / m,
            0.0,
            0.0,
            0.0,
            1.0,
            k / m2,
            d / m2,
            -k / m2,
            -(b2 + d) / m2,
        ];
        let input = [0.0, 1.0 / m, 0.0, 0.0];
        let plant: [&[f64]; 3] = [&a, &input, &[1.0, 0.0, 0.0, 0.0]];
        let have = HandPort::new(plant, [None; 2])
            .expect("a port")
            .least_damping();
        let (have, omega) = have.expect("dampers and springs are passive");
        // Z of the masses by hand, on a grid of 1e5 points from 1e-3 to 1e6 rad/s.
        let damped = |omega: f64| {
            let s = Complex::new(0.0, omega);
            let joint = k / s + d;
            let far = m2 * s + b2;
            (m * s + b + joint * far / (joint + far)).re
        };
        let grid = (0..100_000).map(|n| damped(libm::pow(10.0, 9.0 * f64::from(n) / 1e5 - 3.0)));
        let want = grid.fold(f64::INFINITY, f64::min);
        assert_relative(&format!("{case} at {omega} rad/s"), have, want, 1e-6);
    }
    let grows = HandPort::new([&[0.0, 1.0, 0.0, 1.0], &[0.0, 1.0], &[1.0, 0.0]], [None; 2]);
    assert_eq!(
        grows.expect("a port").least_damping(),
        None,
        "a pole right of the axis"
    );
    assert!(HandPort::new(SEA, [Some(&[1.0]), None]).is_err());
}

/// A slow loop whose images count, against the same loop run in time: states, held force and the hand's sine move exactly between instants.
#[test]
fn a_sine_of_the_hand_moves_it_as_a_simulation_in_time_does() {
    let (t, steps, law) = (0.02, 200, wall(120.0, 3.0, 0.02));
    let [a, b, c] = SEA;
    for periods_of_100 in [7, 23, 41] {
        // So many periods in 100 samples.
        let omega = TAU * f64::from(periods_of_100) / (100.0 * t);
        // x, the held force, cos and sin of the hand.
        let mut matrix = DMatrix::zeros(7, 7);
        for row in 0..4 {
            for column in 0..4 {
                matrix[(row, column)] = a[4 * row + column];
            }
            matrix[(row, 4)] = b[row];
            matrix[(row, 5)] = AT_THE_LOAD[row];
        }
        (matrix[(5, 6)], matrix[(6, 5)]) = (-omega, omega);
        let (moved, _) = linear_motion(matrix.as_slice(), &[0.0; 7], t / f64::from(steps));
        let moved = DMatrix::from_vec(7, 7, moved) + DMatrix::identity(7, 7);
        let mut x = DVector::zeros(7);
        x[5] = 1.0;
        let (mut before, mut seen) = (0.0, Complex::new(0.0, 0.0));
        for n in 0..2100 {
            let y: f64 = c.iter().zip(x.iter()).map(|(c, x)| c * x).sum();
            x[4] = -(law.stiffness_n_per_m * y + law.dissipation_n_s_mu_per_m * (y - before) / t);
            before = y;
            for step in 0..steps {
                if n >= 2000 {
                    let at = (f64::from(n) + f64::from(step) / f64::from(steps)) * t;
                    seen +=
                        x[0] * Complex::from_polar(2.0 / (100.0 * f64::from(steps)), -omega * at);
                }
                x = &moved * &x;
            }
        }
        let have = felt(SEA, Some(AT_THE_LOAD), law, ForcePath::NONE, omega).inv();
        assert!(
            (have - seen).norm() < 1e-3 * seen.norm(),
            "{omega}: {have} {seen}"
        );
    }
}
