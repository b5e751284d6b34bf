//! The simulated robot against fine integration and closed forms.

use super::*;
use crate::plant_parameters::{Change, refuses};

const HAND: RobotHand = RobotHand {
    mass: Kilograms(1.5),
    damping: NewtonSecondsPerMetre(20.0),
    stiffness: NewtonsPerMetre(800.0),
};

/// A motion through a chain too wide to change it.
pub(super) fn safe<const D: usize>(velocity: SVector<f64, D>) -> SafeMotion<f64, D> {
    let limits = MotionLimits {
        speed: MetresPerSecond(1e3),
        speed_norm: None,
        acceleration: MetresPerSecondSquared(1e9),
        low: [Metres(-1e6); D],
        high: [Metres(1e6); D],
        rest_time: Seconds(1e-3),
        ..super::limits()
    };
    let chain = MotionChain::new(&limits, T).expect("in range");
    let (mut state, resting) = (
        MotionState::default(),
        reading(0, SVector::zeros(), SVector::zeros()),
    );
    chain.rest(&mut state, &resting);
    chain.arm(&mut state, &resting).expect("armed");
    chain.sense(&mut state, &resting);
    chain.apply(&mut state, &velocity).0
}

fn shown(robot: &mut SimulatedRobot<1>) -> MotionReading<f64, 1> {
    robot.sense().expect("infallible")
}

/// Commands, m/s, and places of the hand, m, that change now and then.
fn command(tick: usize) -> f64 {
    0.1 * libm::sin((tick / 7) as f64)
}

fn place(tick: usize) -> f64 {
    0.02 * libm::cos((tick / 11) as f64)
}

#[test]
fn a_robot_in_a_hand_is_the_solution_of_its_equations_whatever_the_dead_time() {
    for samples in [0.0, 0.3, 2.0, 5.75] {
        let config = SimulatedRobotConfig {
            dead_time: Seconds(samples * T.0),
            ..robot(HAND)
        };
        let mut have = made(config);
        let (omega, cutoff) = (std::f64::consts::TAU * 10.0, std::f64::consts::TAU * 30.0);
        // (x, v, v̇, two lags) by Runge and Kutta, in 400 pieces a sample, which end where a command begins to act.
        const PIECES: usize = 400;
        let slope = |[x, v, a, s, r]: [f64; 5], u: f64, place: f64| {
            let jerk = omega * omega * (u - v) - 1.6 * omega * a;
            let force = -1.5 * a - 20.0 * v - 800.0 * (x - place);
            [v, a, jerk, cutoff * (force - s), cutoff * (s - r)]
        };
        let along = |y: [f64; 5], k: [f64; 5], h: f64| -> [f64; 5] {
            std::array::from_fn(|i| y[i] + h * k[i])
        };
        let (mut y, h) = ([0.0; 5], T.0 / PIECES as f64);
        for tick in 0..300 {
            have.set_hand_target(vector![place(tick)]);
            have.command(safe(vector![command(tick)]))
                .expect("infallible");
            for piece in 0..PIECES {
                let ago = tick as f64 + piece as f64 / PIECES as f64 - samples;
                let u = if ago < 0.0 {
                    0.0
                } else {
                    command((ago + 1e-9) as usize)
                };
                let slope = |y| slope(y, u, place(tick));
                let k1 = slope(y);
                let k2 = slope(along(y, k1, 0.5 * h));
                let k3 = slope(along(y, k2, 0.5 * h));
                let k4 = slope(along(y, k3, h));
                for i in 0..5 {
                    y[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
                }
            }
            let sensed = shown(&mut have);
            // (ω·h)⁴ is 1e-12 of these numbers.
            assert_close("x", sensed.position_m[0], y[0], 1e-12);
            assert_close("v", have.velocity()[0], y[1], 1e-11);
            assert_close("sensed", sensed.sensed_force_n[0], y[4], 1e-9);
            let force = -1.5 * y[2] - 20.0 * y[1] - 800.0 * (y[0] - place(tick));
            assert_close("force", have.hand_force()[0], force, 1e-9);
        }
    }
}

#[test]
fn a_loop_of_first_order_by_its_states_is_its_exponential_on_each_axis() {
    let (mut a, mut b, mut c) = (SMatrix::zeros(), SVector::zeros(), SVector::zeros());
    (a[(0, 0)], b[0], c[0]) = (-50.0, 50.0, 1.0);
    let motion = RobotLoop { a, b, c };
    let mut robot = made::<3>(SimulatedRobotConfig::of(T, motion, HAND));
    let speeds = vector![0.1, -0.2, 0.3];
    for tick in 1..=200 {
        robot.command(safe(speeds)).expect("infallible");
        let t = f64::from(tick) * T.0;
        let rise = -libm::expm1(-50.0 * t);
        for (axis, speed) in speeds.iter().enumerate() {
            let (v, x) = (speed * rise, speed * (t - rise / 50.0));
            assert_close("v", robot.velocity()[axis], v, 1e-14);
            assert_close("x", robot.position()[axis], x, 1e-14);
            // The force has a part of the command itself: v̇ = 50·(u − v).
            let force = -1.5 * 50.0 * (speed - v) - 20.0 * v - 800.0 * x;
            assert_close("f", robot.hand_force()[axis], force, 1e-11);
        }
    }
}

#[test]
fn the_sensor_has_its_range_counts_noise_and_each_trouble() {
    let config = SimulatedRobotConfig {
        sensor_lags: 0,
        sensor_range: Newtons(20.0),
        sensor_resolution: Newtons(0.5),
        ..robot(RobotHand::relaxed())
    };
    let mut robot = made(config);
    let mut show = |force: f64, trouble: Option<SensorTrouble>| {
        robot.set_hand_force(vector![force]);
        robot.set_trouble(trouble);
        let reading = shown(&mut robot);
        robot
            .command(SafeMotion::<f64, 1>::zero())
            .expect("infallible");
        (reading.sensed_force_n[0], reading.force_age_s)
    };
    assert_eq!(show(3.2, None), (3.0, 0.0));
    assert_eq!(show(30.0, None), (20.0, 0.0));
    assert_eq!(show(-3.0, Some(SensorTrouble::Gain(2.0))), (-6.0, 0.0));
    assert_eq!(show(-3.0, Some(SensorTrouble::Offset(5.0))), (2.0, 0.0));
    assert!(show(-3.0, Some(SensorTrouble::NotANumber)).0.is_nan());
    assert_eq!(show(1.0, None), (1.0, 0.0));
    assert_eq!(show(7.0, Some(SensorTrouble::Stuck)), (1.0, 0.0));
    assert_eq!(show(7.0, Some(SensorTrouble::Silent)), (1.0, 2.0 * T.0));
    let count = |tick: u32| f64::from(tick % 9);
    let before: Vec<f64> = (0..64).map(|tick| show(count(tick), None).0).collect();
    let again = (0..64).map(|_| show(50.0, Some(SensorTrouble::Replayed)).0);
    assert_eq!(again.collect::<Vec<_>>(), before);
    // The same seed makes the same noise.
    let noisy = SimulatedRobotConfig {
        sensor_noise: Newtons(0.1),
        sensor_resolution: Newtons(0.0),
        ..config
    };
    let record = |seed| {
        let mut robot = made(SimulatedRobotConfig { seed, ..noisy });
        let forces = (0..4000).map(|_| shown(&mut robot).sensed_force_n[0]);
        forces.collect::<Vec<f64>>()
    };
    let noise = record(1);
    let deviation = libm::sqrt(noise.iter().map(|n| n * n).sum::<f64>() / 4000.0);
    // Of 4000 numbers within 1 % or so.
    assert_close("σ", deviation, 0.1, 0.005);
    assert_eq!(record(1), noise);
    assert_ne!(record(2), noise);
}

#[test]
fn a_robot_without_sense_is_refused() {
    let changes: [(Change<SimulatedRobotConfig>, &str); 4] = [
        (|it| it.dead_time = Seconds(0.2), "dead time 0.2 s"),
        (|it| it.sensor_lags = 5, "lags of the force sensor 5"),
        (|it| it.hand.mass = Kilograms(-1.0), "hand mass -1"),
        (
            |it| it.sensor_range = Newtons(0.0),
            "range of the force sensor",
        ),
    ];
    refuses(robot(HAND), &changes, SimulatedRobot::<1>::new);
    for (frequency, ratio, words) in [
        (0.0, 0.8, "natural frequency"),
        (10.0, f64::NAN, "damping ratio"),
    ] {
        assert_refused(RobotLoop::second_order(Hertz(frequency), ratio), words);
    }
}
