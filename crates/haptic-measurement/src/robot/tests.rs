//! Random simulated robots are measured through a chain of motion, and what is found is held against what they are.
//!
//! `CAMPAIGN_CASES` sets how many; 6 unless it is given, 500 at night.

use super::*;
use crate::OwnLimits;
use haptic_loop::{
    MotionChain, MotionLimits, MotionState, MovingDevice as _, Reading, SafeForce,
    plant::{RobotHand, RobotLoop, SimulatedRobot, SimulatedRobotConfig},
    units::{
        Hertz, Kilograms, Metres, MetresPerSecond, MetresPerSecondSquared, NewtonSecondsPerMetre,
        Newtons,
    },
};
use std::convert::Infallible;
use testkit::Random;

/// A robot whose commands have passed a chain of motion, as those of one behind a port.
struct Bench {
    robot: SimulatedRobot<1>,
    chain: MotionChain<f64, 1>,
    state: MotionState<f64, 1>,
    /// Its command over the one that is asked of it.
    gain: f64,
    /// Ticks of which the sample is lost: each of this number.
    lost: u64,
    fastest: f64,
}

impl Bench {
    fn new(config: SimulatedRobotConfig) -> Self {
        let (speed, acceleration) = (MetresPerSecond(0.05), MetresPerSecondSquared(5.0));
        let ends = [[Metres(-0.02)], [Metres(0.02)]];
        let mut limits = MotionLimits::of(speed, acceleration, ends[0], ends[1], Newtons(100.0));
        (limits.stuck, limits.dead_band) = (None, limits.sensor_range);
        let mut bench = Self {
            robot: SimulatedRobot::new(config).expect("a robot"),
            chain: MotionChain::new(&limits, config.sample_time).expect("limits"),
            state: MotionState::default(),
            gain: 1.0,
            lost: 0,
            fastest: 0.0,
        };
        for _ in 0..500 {
            let reading = bench.robot.sense().expect("never fails");
            bench.chain.rest(&mut bench.state, &reading);
        }
        let reading = bench.robot.sense().expect("never fails");
        bench.chain.arm(&mut bench.state, &reading).expect("rests");
        bench
    }
}

impl Device<f64, 1> for Bench {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<f64, 1>, Infallible> {
        let reading = self.robot.sense()?;
        self.chain.sense(&mut self.state, &reading);
        if self.lost > 0 && reading.tick % self.lost == self.lost - 1 {
            let held = *self.state.velocity_m_per_s();
            let (motion, _) = self.chain.apply(&mut self.state, &held);
            self.robot.command(motion)?;
            return self.read();
        }
        Ok(Reading {
            tick: reading.tick,
            time_s: reading.time_s,
            position_m: reading.position_m,
        })
    }

    fn write(&mut self, force: SafeForce<f64, 1>) -> Result<(), Infallible> {
        let wanted = force.newtons() * (self.gain / 100.0);
        let (motion, _) = self.chain.apply(&mut self.state, &wanted);
        self.fastest = self.fastest.max(motion.metres_per_second()[0].abs());
        self.robot.command(motion)
    }
}

fn plan(t: f64, duration_s: f64) -> MeasurePlan {
    let own = OwnLimits {
        // 5 m/s², as the limit of the chain above.
        force_rate_n_per_s: 0.99 * 500.0,
        ..OwnLimits::NONE
    };
    MeasurePlan {
        sample_time_s: t,
        duration_s,
        ..MeasurePlan::default()
    }
    .within(own)
    .of_robot()
}

fn measured(bench: &mut Bench, plan: &MeasurePlan) -> Result<MeasuredRobot, Failure> {
    let never = AtomicBool::new(false);
    let driven = drive_robot(plan, bench, &mut |_, sent| sent, &|_| (), &never);
    let record = driven.map_err(|error| match error {
        DriveError::Said(failure) => failure,
        other @ (DriveError::Plan(_) | DriveError::Device(_)) => panic!("{other:?}"),
    })?;
    assert!(
        bench.fastest <= 0.0201 * bench.gain,
        "{} m/s",
        bench.fastest
    );
    assert!(bench.robot.position()[0].abs() < 5e-3 * bench.gain.max(1.0));
    estimate_robot(&record)
}

/// Bandwidth, Hz, damping ratio, dead time, s, sample time, s, encoder step and noise, m.
fn robot([bandwidth, damping, late, t, step, noise]: [f64; 6], seed: u64) -> SimulatedRobotConfig {
    let motion = RobotLoop::second_order(Hertz(bandwidth), damping).expect("a loop");
    // The tool at the sensor: nobody holds it.
    let tool = RobotHand {
        mass: Kilograms(0.5),
        damping: NewtonSecondsPerMetre(0.0),
        ..RobotHand::relaxed()
    };
    SimulatedRobotConfig {
        dead_time: Seconds(late),
        position_noise: Metres(noise),
        position_resolution: Metres(step),
        sensor_noise: Newtons(0.05),
        seed,
        ..SimulatedRobotConfig::of(Seconds(t), motion, tool)
    }
}

/// Largest error of the three numbers, relative, and the numbers whose interval does not have the truth in it.
fn off(found: &MeasuredRobot, [bandwidth, damping, late, t, ..]: [f64; 6]) -> (f64, usize) {
    let numbers = [
        (found.bandwidth_hz, bandwidth, 0.0),
        (found.damping_ratio, damping, 0.0),
        // A share of next to nothing says nothing: of a tenth of a sample it does.
        (found.dead_time_s, late, 2.0 * t),
    ];
    let error = numbers.map(|(found, truth, least)| (found.value - truth).abs() / truth.max(least));
    // Rounding is in no interval.
    let is_missed = |found: MeasuredNumber, truth: f64| {
        !found.covers(truth) && (found.value - truth).abs() > 1e-5 * truth
    };
    let missed = numbers.map(|(found, truth, _)| usize::from(is_missed(found, truth)));
    (error.into_iter().fold(0.0, f64::max), missed.iter().sum())
}

#[test]
fn random_robots_are_measured_within_5_percent_by_seed_encoder_and_noise() {
    let cases: u64 = testkit::cases(6);
    let mut random = Random(85);
    let mut missed = 0;
    for case in 0..cases {
        let t = random.one_of(&[1e-3, 2e-3]);
        let truth = [
            random.log_between(3.0, 30.0),
            random.log_between(0.4, 1.2),
            random.between(0.0, 15e-3),
            t,
            random.one_of(&[0.0, 1e-6, 1e-5, 2e-5]),
            random.one_of(&[0.0, 1e-6, 5e-6]),
        ];
        let mut bench = Bench::new(robot(truth, case));
        let found = measured(&mut bench, &plan(t, 8.0)).expect("measured");
        let (error, outside) = off(&found, truth);
        assert!(error < 0.05, "case {case}: {truth:?} {:?}", found.named());
        missed += outside;
    }
    // 95 of 100, and what chance may do to a few.
    let most = 0.05 * 3.0 * cases as f64;
    assert!(
        (missed as f64) < most + 3.0 * most.sqrt() + 1.0,
        "{missed} of {}",
        3 * cases
    );
}

#[test]
fn an_exact_record_gives_exact_numbers_also_with_lost_samples() {
    let truth = [10.0, 0.8, 4.3e-3, 1e-3, 0.0, 0.0];
    for lost in [0, 7] {
        let mut bench = Bench::new(robot(truth, 1));
        bench.lost = lost;
        let found = measured(&mut bench, &plan(1e-3, 3.0)).expect("measured");
        assert!(off(&found, truth).0 < 1e-4, "{lost}: {:?}", found.named());
        assert_eq!(found.lost_samples > 0, lost > 0);
    }
}

#[test]
fn a_robot_that_does_not_do_what_it_is_told_is_refused_in_words() {
    let truth = [10.0, 0.8, 4e-3, 1e-3, 1e-6, 0.0];
    let refused = |change: &dyn Fn(&mut Bench), words: &str| {
        let mut bench = Bench::new(robot(truth, 1));
        change(&mut bench);
        let refused = measured(&mut bench, &plan(1e-3, 3.0)).expect_err(words);
        assert!(refused.to_string().contains(words), "{refused}");
    };
    refused(&|bench| bench.gain = 0.0, "does not move");
    refused(&|bench| bench.gain = 0.5, "50.0 % of its command");
    refused(&|bench| bench.gain = -1.0, "left its box");
}
