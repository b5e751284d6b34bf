//! A body tried in virtual time, in each corner of its hands, in free space and in its world, with a noisy sensor.
//! ```text
//! two runs of the same noise, one with a tap for 0.1 s:   settled if the last fifth of their difference is at most 5 % of its peak
//! ```
//! The difference has no noise but that of counts, so a slow growth is seen beneath it. Seeds 1 to 5 in turn; a world of several elements, or a
//! controller, is not tried.

use crate::analysis::admittance::moving::Around;
use fracdiff::{Order, Scheme, Seconds};
use haptic_analysis::HandImpedance;
use haptic_document::Failure;
use haptic_loop::units::{
    Metres, MetresPerSecond, MetresPerSecondSquared, Newtons, NewtonsPerSecond,
};
use haptic_loop::{Controller, MotionLimits, SafetyChain, SpringDamper};
use haptic_trial::advice::parameter;
use haptic_trial::robot::{BodyValues, RobotInHands, rendered};

const SEEDS: usize = 5;
const TAP_N: f64 = 2.0;
const TAP_S: f64 = 0.1;
/// Length of a run, s, and most samples of one.
pub(crate) const RUN_S: f64 = 10.0;
const SAMPLES: f64 = 20_000.0;
/// Share of the peak that may be left.
const LEFT: f64 = 0.05;
/// Share of it that rounding leaves.
const ROUNDED: f64 = 1e-12;
/// Limits that such a motion does not meet.
const FAR: f64 = 1e3;

#[derive(Clone, Copy, Debug)]
pub(super) struct Trials {
    pub(super) runs: usize,
    pub(super) settled: usize,
}

/// The trials of a body; `None` where its world is not tried.
///
/// # Errors
/// A device that cannot be simulated.
pub(super) fn trials(around: &Around, body: &BodyValues) -> Result<Option<Trials>, Failure> {
    let law = match &around.world {
        Some(law) if !law.is_one_element() => return Ok(None),
        law => law.as_ref(),
    };
    let free = (
        [0.0; 2],
        Order::new(0.0).map_err(Failure::input)?,
        Scheme::Exact,
    );
    let world = law.map(|law| (Around::gains(law), law.order, law.scheme));
    let mut settled = Vec::new();
    for (gains, order, scheme) in [Some(free), world].into_iter().flatten() {
        for hand in around.place.corners() {
            let run = RobotTap {
                place: &around.place,
                hand,
                gains,
                order,
                scheme,
                tap_n: TAP_N,
                duration_s: RUN_S,
            };
            settled.push(run.settles(body, settled.len())?);
        }
    }
    Ok(Some(Trials {
        runs: settled.len(),
        settled: settled.iter().filter(|settled| **settled).count(),
    }))
}

/// One hand at one wall.
pub(crate) struct RobotTap<'a> {
    pub(crate) place: &'a RobotInHands,
    pub(crate) hand: HandImpedance,
    /// K, N/m, and B, N·s^μ/m, of the wall.
    pub(crate) gains: [f64; 2],
    pub(crate) order: Order,
    pub(crate) scheme: Scheme,
    /// The tap, N.
    pub(crate) tap_n: f64,
    pub(crate) duration_s: f64,
}

impl RobotTap<'_> {
    /// True if the motion after the tap has died; the noise is that of one of five seeds in turn.
    fn settles(&self, body: &BodyValues, turn: usize) -> Result<bool, Failure> {
        let seed = turn % SEEDS;
        let still = self.velocities(body, seed, 0.0)?;
        let tapped = self.velocities(body, seed, self.tap_n)?;
        let changes = still.iter().zip(&tapped).map(|(a, b)| (b - a).abs());
        let last = still.len() - still.len() / 5;
        let (mut peak, mut left) = (0.0_f64, 0.0_f64);
        for (n, change) in changes.enumerate() {
            // NaN does not settle.
            peak = if change <= peak { peak } else { change };
            if n >= last {
                left = if change <= left { left } else { change };
            }
        }
        Ok(left <= LEFT * peak && peak.is_finite())
    }

    /// True if the motion after the tap is dying, however slowly: the loudest of the last fifth is quieter than that of the fifth before it. This
    /// tells a border where a robot has no noise.
    ///
    /// # Errors
    /// A device that cannot be simulated.
    pub(crate) fn decays(&self, body: &BodyValues) -> Result<bool, Failure> {
        let velocities = self.velocities(body, 0, self.tap_n)?;
        // NaN does not decay.
        let loudest = |part: &[f64]| {
            let louder = |most: f64, v: &f64| if v.abs() <= most { most } else { v.abs() };
            part.iter().fold(0.0, louder)
        };
        let fifth = velocities.len() / 5;
        let (earlier, last) = velocities.split_at(velocities.len() - fifth);
        let left = loudest(last);
        let before = loudest(&earlier[earlier.len() - fifth..]);
        Ok(left < before || left <= ROUNDED * loudest(earlier))
    }

    /// The command's velocity, sample by sample, m/s, with a tap of so many newtons.
    fn velocities(&self, body: &BodyValues, seed: usize, tap_n: f64) -> Result<Vec<f64>, Failure> {
        let place = self.place;
        let t = Seconds(place.robot.sample_time_s());
        let limits = MotionLimits {
            following: Metres(FAR),
            hand_energy: None,
            stuck: None,
            rest_time: Seconds(0.01),
            ..MotionLimits::of(
                MetresPerSecond(FAR),
                MetresPerSecondSquared(1e6),
                [Metres(-FAR)],
                [Metres(FAR)],
                place.simulated.sensor_range,
            )
        };
        let mut device = place.simulated(body, &limits, self.hand, 1 + seed as u64)?;
        let samples = (self.duration_s / t.0).min(SAMPLES) as usize;
        let mut velocities = Vec::with_capacity(samples);
        let [stiffness, dissipation] = self.gains;
        let memory = rendered(self.scheme, self.order, t)?;
        let wall = SpringDamper::new(stiffness, dissipation, memory).map_err(parameter)?;
        let safety =
            SafetyChain::new(Newtons(1e9), NewtonsPerSecond(1e15), t).map_err(parameter)?;
        let mut controller = Controller::<f64, 1, _>::new(wall, safety);
        let mut engaged = controller.engage(&mut device);
        for n in 0..samples {
            let push = if (n as f64) * t.0 < TAP_S { tap_n } else { 0.0 };
            engaged
                .device_mut()
                .robot_mut()
                .set_hand_force([push].into());
            if engaged.tick().is_err() {
                velocities.push(f64::NAN);
                break;
            }
            velocities.push(engaged.device().state().velocity_m_per_s()[0]);
        }
        Ok(velocities)
    }
}
