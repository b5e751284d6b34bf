//! Devices that move: the virtual body, the motion chain, the simulated robot, and all of them in a hand.

mod body;
mod borders;
mod chain;
mod hostile;
mod loops;
mod robot;

use fracdiff::{Differintegrator, FrequencyResponse, Operator, Real, Scheme, Seconds, ShortMemory};
use haptic_loop::plant::{
    RobotHand, RobotLoop, SensorTrouble, SimulatedRobot, SimulatedRobotConfig,
};
use haptic_loop::units::*;
use haptic_loop::*;
use nalgebra::{SMatrix, SVector, vector};
use testkit::device::write;
use testkit::operator::order;
use testkit::{Random, assert_close, assert_refused};

/// Sample time of the robots here, s.
const T: Seconds = Seconds(2e-3);

/// 0.5 m/s, 10 m/s², 0.1 m to both sides, a sensor of 50 N.
fn limits<const D: usize>() -> MotionLimits<D> {
    let (speed, acceleration) = (MetresPerSecond(0.5), MetresPerSecondSquared(10.0));
    let ends = [[Metres(-0.1); D], [Metres(0.1); D]];
    MotionLimits::of(speed, acceleration, ends[0], ends[1], Newtons(50.0))
}

/// The robot of theory: 10 Hz with ζ 0.8, two samples of dead time, a sensor with two lags of 30 Hz.
fn robot(hand: RobotHand) -> SimulatedRobotConfig {
    let motion = RobotLoop::second_order(Hertz(10.0), 0.8).expect("in range");
    SimulatedRobotConfig {
        dead_time: Seconds(2.0 * T.0),
        sensor_lags: 2,
        ..SimulatedRobotConfig::of(T, motion, hand)
    }
}

/// Grünwald's operator with its whole past, each weight right to this share.
fn full<F: Real>(alpha: f64, sample_time: Seconds, share: f64) -> Operator<F> {
    let scheme: Scheme = format!("full:{share:e}").parse().expect("a scheme");
    let operator = scheme.build(order(alpha), sample_time, 1e5);
    operator.expect("in range")
}

fn body<F: Real, O: Differintegrator<F>>(m: f64, b: f64, operator: O) -> VirtualBody<F, O> {
    VirtualBody::new(m, NewtonSecondsPerMetre(b), operator).expect("in range")
}

/// A robot behind a virtual body, armed.
fn admittance<F: Real, const D: usize, O: Differintegrator<F>, R>(
    limits: &MotionLimits<D>,
    robot: R,
    body: VirtualBody<F, O>,
) -> Admittance<F, D, O, R>
where
    R: MovingDevice<F, D, Error: std::fmt::Debug>,
{
    let chain = MotionChain::new(limits, T).expect("in range");
    let mut device = Admittance::new(robot, body, chain);
    for _ in 0..100 {
        device.rest().expect("rests");
    }
    device.arm().expect("may be armed");
    device
}

/// The robot of theory in this hand, behind a virtual body, armed.
fn in_hand<O: Differintegrator<f64>>(
    limits: &MotionLimits<1>,
    hand: RobotHand,
    body: VirtualBody<f64, O>,
) -> Admittance<f64, 1, O, SimulatedRobot<1>> {
    admittance(limits, made(robot(hand)), body)
}

fn made<const D: usize>(config: SimulatedRobotConfig) -> SimulatedRobot<D> {
    SimulatedRobot::new(config).expect("in range")
}

/// A law's chain without a guard.
fn law_chain<F: Real>() -> SafetyChain<F> {
    SafetyChain::new(Newtons(20.0), NewtonsPerSecond(1e5), T).expect("in range")
}

fn reading<F: Real, const D: usize>(
    tick: u64,
    position_m: SVector<F, D>,
    sensed_force_n: SVector<F, D>,
) -> MotionReading<F, D> {
    MotionReading {
        tick,
        time_s: tick as f64 * T.0,
        position_m,
        sensed_force_n,
        force_age_s: F::ZERO,
    }
}

/// A chain with these limits, armed where the robot stands.
fn armed<F: Real, const D: usize>(
    limits: &MotionLimits<D>,
    position_m: SVector<F, D>,
) -> (MotionChain<F, D>, MotionState<F, D>) {
    let chain = MotionChain::new(limits, T).expect("in range");
    let mut state = MotionState::default();
    let resting = reading(0, position_m, SVector::from([F::ZERO; D]));
    for _ in 0..100 {
        chain.rest(&mut state, &resting);
    }
    chain.arm(&mut state, &resting).expect("may be armed");
    (chain, state)
}
