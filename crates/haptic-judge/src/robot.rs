//! A robot that a hand pushes into a law: in virtual time, and judged for every hand of its box.
//!
//! ```text
//! hand ─push─▶ robot ─sensed force─▶ body ◀─force─ law          position of the trial: that of the command
//! ```
//! - *Trial*: armed and at rest at 0 m, then the push in one corner of the box of hands; every other corner is tried too, and the worst is the
//!   verdict.
//! - *The ends of its way* end a trial: behind one the command is not the law's motion.
//! - *Exact at the virtual port*: what the law reads is the command, so its force is its own whatever the robot does; the log has the robot's
//!   true place and the true force of the hand beside it.
//! - *Verdict*: of the box of hands × walls from free space to the one that is asked for, not of the trial.

use haptic_analysis::{AdmittanceWorld, BoxVerdict, HandImpedance};
use haptic_document::Failure;
use haptic_loop::{Admittance, Device, Fault, Limiters, Reading, SafeForce, plant::SimulatedRobot};
use haptic_message::TickMessage;
use haptic_trial::{
    ending::Ending,
    preflight::{PreflightVerdict, RobotVerdict},
    robot::{BodyOperator, RobotModel},
};
use std::convert::Infallible;

/// Factors on walls that are looked for, and on bodies.
const FACTORS: [f64; 2] = [1e-3, 1e3];
const BODIES: [f64; 2] = [1e-2, 1e3];
/// Factors are known to this share of themselves.
const KNOWN: f64 = 1e-3;

/// Verdict on a robot whose law is this world, whose delay is that of a line.
///
/// # Errors
/// A number that the analysis does not take.
pub fn verdict(
    model: &RobotModel,
    world: AdmittanceWorld<'_>,
) -> Result<PreflightVerdict, Failure> {
    let (place, body) = (&model.place, &model.body);
    let of = |factor: f64| {
        let world = AdmittanceWorld {
            stiffness_n_per_m: factor * world.stiffness_n_per_m,
            dissipation_n_s_mu_per_m: factor * world.dissipation_n_s_mu_per_m,
            ..world
        };
        place.all(body, Some(world))
    };
    let all = of(1.0)?;
    let every_hand = match all.verdict() {
        BoxVerdict::Proved => Some(true),
        BoxVerdict::Unstable(_) => Some(false),
        BoxVerdict::Unproved { .. } => None,
    };
    let stable = every_hand == Some(true);
    let holds = |factor: f64| of(factor).map(|all| all.is_proved());
    // A larger box has the smaller one in it, so what holds is an interval from 0 on.
    let [mut good, mut bad] = if stable {
        [1.0, FACTORS[1]]
    } else {
        [FACTORS[0], 1.0]
    };
    let margin = match (stable, holds(good)?, holds(bad)?) {
        (true, _, true) | (false, false, _) => None,
        _ => {
            while bad / good > 1.0 + KNOWN {
                let middle = (good * bad).sqrt();
                if holds(middle)? {
                    good = middle;
                } else {
                    bad = middle;
                }
            }
            Some(good)
        }
    };
    let t = place.robot.sample_time_s();
    let (delay_s, line) = (place.simulated.dead_time.0, world.delay_samples as f64);
    Ok(PreflightVerdict {
        stable,
        margin,
        pulling_contact_margin: None,
        pulling_contact_depth_m: None,
        pushing_contact: None,
        passive: false,
        required_delta: None,
        delta: f64::NAN,
        delay_samples: delay_s / t + line,
        delay_s: delay_s + line * t,
        current_lag_s: 0.0,
        alpha: f64::NAN,
        beta: f64::NAN,
        coupler: None,
        robot: Some(RobotVerdict {
            every_hand,
            least_body_factor: all.least_body(BODIES),
        }),
    })
}

/// A simulated robot in a hand that pushes it.
#[derive(Clone, Debug)]
pub struct PushedRobot {
    device: Admittance<f64, 1, BodyOperator, SimulatedRobot<1>>,
    /// Tick at which the trial began.
    begun: u64,
    last: Reading<f64, 1>,
    held_back: bool,
}

impl PushedRobot {
    /// The robot at rest in this hand, and its push, N.
    ///
    /// # Errors
    /// As [`RobotInHands::simulated`](haptic_trial::robot::RobotInHands::simulated).
    pub fn new(model: &RobotModel, hand: HandImpedance, push_n: f64) -> Result<Self, Failure> {
        let RobotModel {
            place,
            body,
            limits,
        } = model;
        let mut device = place.simulated(body, limits, hand, place.simulated.seed)?;
        device.robot_mut().set_hand_force([push_n].into());
        let begun = device.reading().map_or(0, |last| last.tick + 1);
        Ok(Self {
            device,
            begun,
            last: Reading {
                tick: 0,
                time_s: 0.0,
                position_m: [0.0].into(),
            },
            held_back: false,
        })
    }

    /// Reason why it stands still, or why its motion is no longer that of the law: an end of its way held the command back.
    pub fn ended(&self) -> Option<Ending> {
        let fault = self.device.state().fault().map(|fault| fault.of_loop());
        let held = self.held_back.then_some(Fault::Workspace);
        fault.or(held).map(Ending::Fault)
    }

    /// Places of the robot and force of the hand, as they truly are.
    pub(crate) fn observe(&self) -> TickMessage {
        let robot = self.device.robot();
        TickMessage {
            reference_m: 0.0.into(),
            indenter_position_m: robot.position()[0].into(),
            contact_force_n: robot.hand_force()[0].into(),
            ..TickMessage::unknown(1)
        }
    }
}

impl Device<f64, 1> for PushedRobot {
    type Error = Infallible;

    fn read(&mut self) -> Result<Reading<f64, 1>, Infallible> {
        let (tick, position_m) = match self.device.read() {
            Ok(reading) => (reading.tick.saturating_sub(self.begun), reading.position_m),
            // One that has come to rest after a fault stands where it was.
            Err(_) => (self.last.tick + 1, self.last.position_m),
        };
        self.last = Reading {
            tick,
            time_s: tick as f64 * self.device.robot().config().sample_time.0,
            position_m,
        };
        Ok(self.last)
    }

    fn write(&mut self, force: SafeForce<f64, 1>) -> Result<(), Infallible> {
        // A simulated robot has no other error than that it stands still.
        let _ = self.device.write(force);
        self.held_back |= self.device.limiters().contains(Limiters::WORKSPACE);
        Ok(())
    }

    fn let_go(&mut self) {
        self.device.let_go();
    }

    fn stop(&mut self) {
        self.device.stop();
    }

    fn moves(&self) -> bool {
        self.device.moves()
    }
}

#[cfg(test)]
mod tests {
    use crate::{
        pushed_trial::PushedTrial as _,
        settling::TrialVerdict,
        setup::Beside,
        wall::{WallTrial, wall},
    };
    use haptic_document::{Document, FileError};
    use haptic_trial::{
        keys::{admittance::ADMITTANCE_TABLE, wall::WALL_TABLES},
        preflight::PreflightVerdict,
        robot::ADMITTANCE,
    };
    use std::path::Path;
    use testkit::Tested;

    /// A wall of 1 kN/m on a robot of 10 Hz and 4 ms, with further lines of `[wall]` and the body and hands of `[admittance]`.
    fn read(law: &str, robot: &str) -> Result<WallTrial, FileError> {
        let text = format!(
            "[wall]\nsample_time_s = 0.002\norder = 1\nstiffness_n_per_m = 1000\ndissipation_n_s_mu_per_m = 20\nduration_s = 8\n{law}\n\
             [admittance]\nbandwidth_hz = 10\ndead_time_s = 0.004\nforce_cutoff_hz = 30\n{robot}\n"
        );
        let document = Document::of_text(Path::new("lab.toml"), &text);
        let document = document.parse()?;
        let (_, table, mut beside) = document.one_of(&["wall"], &[ADMITTANCE], "", "")?;
        let robot = beside.remove(ADMITTANCE).expect("a robot");
        let robot = robot.with_keys(&[(ADMITTANCE, ADMITTANCE_TABLE)])?;
        let beside = Beside {
            drive: None,
            admittance: Some(&robot),
        };
        wall(&table.with_keys(WALL_TABLES)?, beside, [None, None])
    }

    fn body(inertance: f64, damping: f64, hand: &str) -> String {
        format!(
            "body_inertance_n_s_mu_per_m = {inertance:?}\nbody_damping_n_s_per_m = {damping:?}\nhand_stiffness_n_per_m = {hand}"
        )
    }

    fn judged(wall: &WallTrial) -> PreflightVerdict {
        let dynamics = wall.setup.dynamics();
        wall.judge(4000, dynamics, 0).expect("judges")
    }

    #[test]
    fn a_wall_holds_a_push_in_every_corner_of_the_hands_as_its_springs_say() -> Tested {
        let wall = read("", &body(8.0, 20.0, "[0, 400]"))?;
        let verdict = judged(&wall);
        assert!(verdict.stable && verdict.margin.is_some_and(|margin| margin > 1.0));
        let (worst, hits) = wall.worst(wall.tried()?)?;
        assert!(worst.stable && hits.len() == 8, "{hits:?}");
        for setup in [wall.setup.clone()]
            .into_iter()
            .chain(wall.setup.in_other_hands())
        {
            let wanted = 1.0 / (1000.0 + setup.device.stiffness.0);
            let one = WallTrial {
                setup,
                ..wall.clone()
            };
            let deflection = one.tried()?.deflection_m.expect("at rest");
            assert!((deflection / wanted - 1.0).abs() < 1e-3, "{deflection}");
        }
        Ok(())
    }

    #[test]
    fn a_robot_that_runs_away_in_a_stiff_hand_is_told_the_body_that_bears_it() {
        let small = [2.0, 10.0];
        let stiff = "[0, 3000]";
        let wall = read("", &body(small[0], small[1], stiff)).expect("a wall");
        let verdict = judged(&wall);
        assert!(!verdict.stable);
        let refused = verdict
            .require_stable(false)
            .expect_err("refused")
            .to_string();
        assert!(
            refused.contains("in a hand of the box")
                && refused.contains("`body_inertance_n_s_mu_per_m`"),
            "{refused}"
        );
        let settled = |wall: &WallTrial| {
            let worst = wall.worst(wall.tried().expect("runs")).expect("runs").0;
            worst.stable
        };
        assert!(!settled(&wall));
        let factor = verdict.robot.and_then(|robot| robot.least_body_factor);
        let factor = factor.expect("a body");
        let times = |share: f64| {
            let [m, b] = small.map(|value| share * factor * value);
            judged(&read("", &body(m, b, stiff)).expect("a wall")).stable
        };
        assert!(times(1.001) && !times(0.98));
    }

    #[test]
    fn a_robot_that_stopped_by_a_fault_or_at_an_end_of_its_way_is_not_at_rest() {
        for (law, robot) in [
            ("push_n = 60\nforce_limit_n = 200", ""),
            ("push_n = 20", "\nmotion_high_m = 0.005"),
        ] {
            let robot = body(8.0, 20.0, "0") + robot;
            let settling = read(law, &robot).expect("a wall").tried().expect("runs");
            assert_eq!(settling.verdict, TrialVerdict::Unfinished, "{law}");
            let reason = settling.reason().expect("a reason");
            assert!(reason.contains("fault: "), "{reason}");
        }
    }

    #[test]
    fn keys_of_a_device_of_forces_and_a_guard_are_refused_on_a_robot() {
        for (line, named) in [
            ("mass_kg = 1", "mass_kg of [wall]"),
            ("impact_m_per_s = 0.1", "impact_m_per_s of [wall]"),
            (
                "hand_stiffness_n_per_m = 100",
                "give admittance.hand_stiffness",
            ),
            (
                "guard = \"energy-bounding\"",
                "a guard needs a device that damps",
            ),
            ("device_model = \"laboratory\"", "beside [admittance]"),
        ] {
            let refused = read(line, &body(8.0, 20.0, "0"))
                .expect_err(line)
                .to_string();
            assert!(refused.contains(named), "{refused}");
        }
    }
}
