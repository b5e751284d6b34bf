//! A controller that holds the indenter of the rig: the indenter is a mass, the tissue pushes it back, the controller keeps it on its way.
//!
//! ```text
//! relaxation   r the ramp, y the place of the indenter, m        u the force on the indenter, N
//! creep        r the push, y the force between the actuators, N  |u| ≤ the limit of the drive
//! ```
//! The tissue is judged as ever: by the sum over the motion that was really made.

mod holder;
mod judged;
mod preflight;
mod rig;

use crate::failure::Failure;
use crate::parameters;
use fracdiff::Seconds;
use fractional_control::{Actuator, ControlError, ControllerParameters, Memory, SetPoint};
use haptic_loop::plant::RigDrive;
pub(crate) use holder::ControllerHolder;
pub use judged::{DriveCurves, DriveReport};
pub(crate) use judged::{DriveJudge, drive_columns};
pub(crate) use preflight::TissueLaw;
pub use preflight::{DriveVerdict, LoopVerdict};
pub(crate) use rig::SimulatedRig;
use std::collections::BTreeMap;

/// A controller for the indenter, and the largest force of its motor.
///
/// ```
/// use fractional_control::{Memory, PidParameters, Rule, SetPoint};
/// use haptic_experiment::{Drive, ModelledTissue, Relaxation, Rendering};
/// use std::ops::ControlFlow;
///
/// let gains: PidParameters = "900+9000/s^0.9+25s^0.9".parse()?;
/// let drive = Drive {
///     name: "my own".to_owned(),
///     controller: gains.into(),
///     set_point: SetPoint::DEFAULT,
///     memory: Memory::new(Rule::Grunwald, 1e-6, 200.0)?,
///     force_limit_n: 10.0,
/// };
/// let tissue = haptic_tissue::Library::load(None)?.find("prostate-cancerous")?;
/// let rendering = Rendering { drive: Some(drive), ..Rendering::new(ModelledTissue::new(tissue)?)? };
/// let relaxation = Relaxation { duration_s: 2.0, ..Relaxation::of(rendering) };
/// let mut place_m = 0.0;
/// relaxation.simulate(&mut |sample| {
///     place_m = sample.indenter_position_m;
///     ControlFlow::Continue(())
/// })?;
/// assert!((place_m - 1e-3).abs() < 1e-5); // 5 % of 20 mm
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// Its name in logs and reports, as the path of its file.
    pub name: String,
    /// Kind, gains and orders: from m, or N in a creep test, to N.
    pub controller: ControllerParameters,
    /// Set-point weights, of a PID.
    pub set_point: SetPoint,
    /// Rule, tolerance and horizon of its powers.
    pub memory: Memory,
    /// Largest force on the indenter, N, above 0.
    pub force_limit_n: f64,
}

impl Drive {
    /// The controller at rest, at this sample time.
    ///
    /// # Errors
    /// A force limit that is not above 0, a controller that cannot be made.
    pub(crate) fn holder(&self, sample_time_s: f64) -> Result<ControllerHolder, Failure> {
        let limit = self.force_limit_n;
        if !parameters::DRIVE_FORCE_LIMIT.range().contains(limit) {
            return Err(Failure::bad_input(format_args!(
                "drive force limit {limit} N is not above 0 N: change `drive_force_limit_n`"
            )));
        }
        let actuator = Actuator::new(-limit, limit);
        let made = actuator.and_then(|actuator| {
            ControllerHolder::new(
                &self.controller,
                self.set_point,
                actuator,
                self.memory,
                Seconds(sample_time_s),
            )
        });
        made.map_err(|error| self.refused(&error))
    }

    fn refused(&self, error: &ControlError) -> Failure {
        Failure::bad_input(format_args!("drive {}: {error}", self.name))
    }

    /// Adds the drive to the metadata of a log.
    pub(crate) fn describe(&self, metadata: &mut BTreeMap<String, String>) {
        for (key, value) in [
            ("controller", self.name.clone()),
            ("force_limit_n", self.force_limit_n.to_string()),
            ("rule", format!("{:?}", self.memory.rule()).to_lowercase()),
        ] {
            metadata.insert(format!("drive.{key}"), value);
        }
        for (key, value) in numbers(&self.controller) {
            metadata.insert(format!("drive.{key}"), value);
        }
    }
}

/// Kind and numbers of a controller.
fn numbers(controller: &ControllerParameters) -> Vec<(&'static str, String)> {
    let (kind, values): (&str, Vec<(&str, f64)>) = match controller {
        ControllerParameters::Pid(own) => (
            "pid",
            vec![
                ("proportional", own.proportional),
                ("integral", own.integral),
                ("integral_order", own.integral_order),
                ("derivative", own.derivative),
                ("derivative_order", own.derivative_order),
            ],
        ),
        ControllerParameters::Tid(own) => (
            "tid",
            vec![
                ("tilt", own.tilt),
                ("tilt_divisor", own.tilt_divisor),
                ("integral", own.integral),
                ("derivative", own.derivative),
            ],
        ),
        ControllerParameters::Crone(own) => (
            "crone",
            vec![
                ("gain", own.gain),
                ("order", own.order),
                ("low_rad_s", own.low_rad_s),
                ("high_rad_s", own.high_rad_s),
            ],
        ),
        ControllerParameters::LeadLag(own) => (
            "lead-lag",
            vec![
                ("gain", own.gain),
                ("order", own.order),
                ("lambda_s", own.lambda_s),
                ("x", own.x),
            ],
        ),
        _ => ("other", Vec::new()),
    };
    let mut all = vec![("kind", kind.to_owned())];
    all.extend(values.into_iter().map(|(key, value)| (key, value.to_string())));
    all
}

/// The set point of a tick: m, or N in a creep test.
pub(crate) fn set_point(drive: RigDrive, time_s: f64) -> f64 {
    match drive {
        RigDrive::Position(profile) => profile.position(time_s),
        RigDrive::Force(push) => push.0,
    }
}
