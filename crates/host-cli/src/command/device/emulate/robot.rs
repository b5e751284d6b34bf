//! Keys of an emulated robot, and the robot that they make of its file.

use haptic_emulator::board::EmulatedRobot;
use haptic_experiment::Failure;
use haptic_experiment::parameters::Range;
use haptic_loop::plant::{RobotHand, SimulatedRobotConfig};
use haptic_loop::units::{Kilograms, Metres, NewtonSecondsPerMetre, NewtonsPerMetre, Seconds};
use haptic_trial::robot::RobotModel;
use std::path::Path;

pub(super) const KEYS: [(&str, &str); 4] = [
    ("sample_time_s", "Robot: its sample time [default: 1ms]"),
    (
        "encoder_resolution_m",
        "Robot: a step of its encoder [default: 0]",
    ),
    ("noise_m", "Robot: noise of its position [default: 0]"),
    (
        "measured",
        "Robot: false of one whose bandwidth and dead time are to be measured [default: true]",
    ),
];
/// Sample times of a robot, s.
pub(super) const SAMPLE_TIMES: Range = Range::Within(1e-4, 1e-2);

/// A robot, as far as its file does not say it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Words {
    pub(super) sample_time_s: f64,
    pub(super) encoder_resolution_m: f64,
    pub(super) noise_m: f64,
    pub(super) is_to_measure: bool,
}

impl Default for Words {
    fn default() -> Self {
        Self {
            sample_time_s: 1e-3,
            encoder_resolution_m: 0.0,
            noise_m: 0.0,
            is_to_measure: false,
        }
    }
}

pub(super) fn is_to_measure(text: &str) -> Result<bool, String> {
    let measured: Result<bool, _> = text.parse();
    let measured = measured.map_err(|_| "is not true or false".to_owned())?;
    Ok(!measured)
}

impl Words {
    /// The robot of a file, in the largest hand of its box; nobody holds one that is to be measured.
    pub(super) fn emulated(self, path: &Path, text: &str) -> Result<EmulatedRobot, Failure> {
        let t = self.sample_time_s;
        let model = RobotModel::parse(path, text, t)?;
        let body = model.body.on_device(Seconds(t));
        let tool_kg = model.place.robot.tool_mass_kg();
        let hand = model.place.hand([1; 3]);
        let [mass, damping, stiffness] = if self.is_to_measure {
            [0.0; 3]
        } else {
            [hand.mass_kg, hand.damping_n_s_per_m, hand.stiffness_n_per_m]
        };
        Ok(EmulatedRobot {
            robot: SimulatedRobotConfig {
                hand: RobotHand {
                    mass: Kilograms(mass + tool_kg),
                    damping: NewtonSecondsPerMetre(damping),
                    stiffness: NewtonsPerMetre(stiffness),
                },
                position_noise: Metres(self.noise_m),
                position_resolution: Metres(self.encoder_resolution_m),
                ..model.place.simulated
            },
            body: if self.is_to_measure {
                None
            } else {
                Some(body.map_err(Failure::bad_input)?)
            },
            limits: model.limits,
        })
    }
}
