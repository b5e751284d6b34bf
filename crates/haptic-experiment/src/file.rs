//! Experiment files: TOML with one table, `[relax]`, `[creep]`, `[wall]`, `[coupler]`, `[teleoperation]` or `[touch]`, units in the names
//! of keys; `[drive]` beside the first two.
//!
//! ```toml
//! [wall]
//! mass_kg = 0.065
//! damping_n_s_per_m = 3.5
//! sample_time_s = 0.002
//! order = 0.5
//! stiffness_n_per_m = 3000
//! dissipation_n_s_mu_per_m = 60
//! ```
//! Defaults are those of the commands. Whatever is wrong is refused in one line, `FILE:LINE: reason`;
//! so are keys that are not known. Paths in a file start from the folder of the file.

mod bench;
mod coupler;
mod device;
pub(crate) mod document;
mod error;
mod pushed;
mod question;
pub(crate) mod reader;
mod rendering;
mod safety;
mod teleoperation;
#[cfg(test)]
mod tests;
mod touch;
mod wall;

use crate::device::LinkedName;
use crate::failure::Failure;
use crate::plant_file::DeviceModel;
use crate::preflight::PreflightRequest;
use crate::remote::RemoteDevice;
use crate::safety::Safety;
use crate::schedule::Pace;
use crate::{
    CouplerExperiment, Creep, Drive, Relaxation, TeleoperationExperiment, TouchExperiment,
    WallExperiment, parameters,
};
use document::Document;
pub use error::FileError;
pub(crate) use error::text_of;
pub use question::Question;
use std::path::Path;

/// The experiment that a file describes, all of its parameters checked.
///
/// ```
/// use haptic_experiment::ExperimentFile;
/// use std::path::Path;
///
/// let text = "[relax]\nstrain = 0.05\nduration_s = 2";
/// let experiment = ExperimentFile::parse(Path::new("lab/relax.toml"), text)?;
/// assert_eq!(experiment.samples()?, 2001);
/// let wrong = ExperimentFile::parse(Path::new("lab/relax.toml"), "[relax]\nstrain = 5");
/// assert_eq!(
///     wrong.expect_err("five times the thickness").to_string(),
///     "lab/relax.toml:2: strain = 5 is not above 0 and at most 1: change it, or leave it out for 0.05"
/// );
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub enum ExperimentFile {
    /// `[relax]`.
    Relax(Relaxation),
    /// `[creep]`.
    Creep(Creep),
    /// `[wall]`.
    Wall(WallExperiment),
    /// `[coupler]`.
    Coupler(CouplerExperiment),
    /// `[teleoperation]`.
    Teleoperation(Box<TeleoperationExperiment>),
    /// `[touch]`.
    Touch(Box<TouchExperiment>),
}

/// The table beside an experiment that a controller drives, and the kinds that may have it.
const DRIVE: &str = "drive";
const DRIVEN: [&str; 2] = ["relax", "creep"];

impl ExperimentFile {
    /// Reads and checks a file.
    ///
    /// # Errors
    /// If it cannot be read or is wrong: in one line, with file and line.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        Self::parse(path, &text_of(path, "experiment")?)
    }

    /// Reads and checks the text of a file; `path` is for messages and for the paths in it.
    ///
    /// # Errors
    /// If it is wrong: in one line, with file and line.
    pub fn parse(path: &Path, text: &str) -> Result<Self, FileError> {
        let document = Document::parse(path, text)?;
        let (kind, table, drive) = document.experiment(&parameters::KINDS, DRIVE)?;
        let table = table.with_keys(&parameters::of_kind(kind))?;
        if let Some(drive) = drive.as_ref().filter(|_| !DRIVEN.contains(&kind)) {
            let reason = format!(
                "[{DRIVE}] holds the indenter of [relax] or [creep], which [{kind}] has not: leave it out"
            );
            return Err(drive.fail(reason));
        }
        let drive = drive
            .map(|drive| drive.with_keys(&[(DRIVE, parameters::DRIVE)]))
            .transpose()?;
        let drive = drive.as_ref();
        match kind {
            "relax" => rendering::relax(&table, drive).map(Self::Relax),
            "creep" => rendering::creep(&table, drive).map(Self::Creep),
            "coupler" => coupler::coupler(&table).map(Self::Coupler),
            "teleoperation" => {
                let read = teleoperation::teleoperation(&table)?;
                Ok(Self::Teleoperation(Box::new(read)))
            }
            "touch" => Ok(Self::Touch(Box::new(touch::touch(&table)?))),
            _ => wall::wall(&table).map(Self::Wall),
        }
    }

    /// The number of samples.
    ///
    /// # Errors
    /// A parameter outside its range, which reading has ruled out.
    pub fn samples(&self) -> Result<u64, Failure> {
        match self {
            Self::Relax(experiment) => experiment.check(),
            Self::Creep(experiment) => experiment.check(),
            Self::Wall(experiment) => experiment.check(),
            Self::Coupler(experiment) => experiment.check(),
            Self::Teleoperation(experiment) => experiment.check(),
            Self::Touch(experiment) => experiment.check(),
        }
    }

    /// The serial device of the file; `None` for the simulated one.
    #[must_use]
    pub fn remote(&self) -> Option<&RemoteDevice> {
        match self {
            Self::Relax(Relaxation { rendering, .. }) | Self::Creep(Creep { rendering, .. }) => {
                rendering.remote.as_ref()
            }
            Self::Wall(WallExperiment { setup, .. })
            | Self::Coupler(CouplerExperiment { setup, .. }) => setup.remote.as_ref(),
            Self::Touch(touch) => touch.remote.as_ref(),
            Self::Teleoperation(_) => None,
        }
    }

    /// The device of this name, with what the file at this path says of the loop with a device at a port: for one that names no device.
    ///
    /// # Errors
    /// As [`read`](Self::read).
    pub fn remote_at(path: &Path, name: LinkedName) -> Result<RemoteDevice, FileError> {
        let text = text_of(path, "experiment")?;
        let document = Document::parse(path, &text)?;
        let (kind, table, _) = document.experiment(&parameters::KINDS, DRIVE)?;
        match kind {
            // It has no such device.
            "teleoperation" => Ok(RemoteDevice::new(name)),
            _ => device::remote_at(&table.with_keys(&parameters::of_kind(kind))?, name),
        }
    }

    /// The same, on another device.
    ///
    /// # Errors
    /// A serial device, if the experiment has settings that only the simulated device has, or its loop, if that cannot carry the
    /// experiment.
    pub fn on(mut self, remote: Option<RemoteDevice>) -> Result<Self, Failure> {
        match &mut self {
            Self::Relax(Relaxation { rendering, .. }) | Self::Creep(Creep { rendering, .. }) => {
                if remote.is_some() && !rendering.sensors.are_ideal() {
                    return Err(Failure::bad_input(
                        "encoder_resolution_m and sensor_noise_m are of the simulated rig: omit them with a serial device, which has its own",
                    ));
                }
                rendering.remote = remote;
            }
            Self::Wall(WallExperiment { setup, .. })
            | Self::Coupler(CouplerExperiment { setup, .. }) => setup.remote = remote,
            Self::Teleoperation(_) if remote.is_some() => {
                return Err(Failure::bad_input(
                    "a teleoperation runs on two simulated devices: leave `device` away",
                ));
            }
            Self::Touch(touch) => touch.remote = remote,
            Self::Teleoperation(_) => {}
        }
        if let Self::Coupler(coupler) = &self {
            coupler.check_loop()?;
        }
        Ok(self)
    }

    /// The controller that holds the indenter; `None` without one.
    #[must_use]
    pub const fn drive(&self) -> Option<&Drive> {
        match self {
            Self::Relax(Relaxation { rendering, .. }) | Self::Creep(Creep { rendering, .. }) => {
                rendering.drive.as_ref()
            }
            Self::Wall(_) | Self::Coupler(_) | Self::Teleoperation(_) | Self::Touch(_) => None,
        }
    }

    /// The same, held by what is chosen over the drive of the file.
    ///
    /// # Errors
    /// That of the choice; a drive for an experiment that has no indenter.
    pub fn driven(
        mut self,
        choose: impl FnOnce(Option<Drive>) -> Result<Option<Drive>, Failure>,
    ) -> Result<Self, Failure> {
        match &mut self {
            Self::Relax(Relaxation { rendering, .. }) | Self::Creep(Creep { rendering, .. }) => {
                rendering.drive = choose(rendering.drive.take())?;
            }
            Self::Wall(_) | Self::Coupler(_) | Self::Teleoperation(_) | Self::Touch(_) => {
                if choose(None)?.is_some() {
                    return Err(Failure::bad_input(
                        "the `controller` of a drive holds the indenter of [relax] or [creep]: leave it out",
                    ));
                }
            }
        }
        Ok(self)
    }

    /// Its settings of the safety chain.
    pub fn safety_mut(&mut self) -> &mut Safety {
        match self {
            Self::Relax(Relaxation { rendering, .. }) | Self::Creep(Creep { rendering, .. }) => {
                &mut rendering.safety
            }
            Self::Wall(WallExperiment { setup, .. })
            | Self::Coupler(CouplerExperiment { setup, .. }) => &mut setup.safety,
            Self::Teleoperation(experiment) => &mut experiment.safety,
            Self::Touch(experiment) => &mut experiment.safety,
        }
    }

    /// The same, on the device of a device file: what it says wins over the keys of a wall or coupler. Of a serial device it is what the
    /// pre-flight and a guard know.
    ///
    /// # Errors
    /// An experiment in which it would do nothing.
    pub fn of_device(mut self, model: &DeviceModel) -> Result<Self, Failure> {
        match &mut self {
            Self::Relax(Relaxation { rendering, .. }) | Self::Creep(Creep { rendering, .. }) => {
                let real = rendering.remote.is_some();
                rendering.safety = rendering.safety.on_rig(&model.guarded(), real)?;
            }
            Self::Wall(WallExperiment { setup, .. })
            | Self::Coupler(CouplerExperiment { setup, .. }) => {
                setup.take_device(model.dynamics(), &model.imperfections(), model.guarded());
            }
            Self::Teleoperation(_) => {
                return Err(Failure::bad_input(
                    "a teleoperation has two devices, each with its own keys: leave `device_model` out",
                ));
            }
            Self::Touch(_) => {
                return Err(Failure::bad_input(
                    "a touch has a mass for each axis, a device file has one: leave `device_model` out, and give `mass_kg` and \
                     `damping_n_s_per_m`",
                ));
            }
        }
        Ok(self)
    }

    /// The same, with this wish for the pre-flight. A wall and a coupler know their device; for the others it is told here.
    #[must_use]
    pub fn with_preflight(mut self, wanted: PreflightRequest) -> Self {
        match &mut self {
            Self::Relax(Relaxation { rendering, .. }) | Self::Creep(Creep { rendering, .. }) => {
                rendering.preflight = wanted;
            }
            Self::Wall(WallExperiment { setup, .. })
            | Self::Coupler(CouplerExperiment { setup, .. }) => {
                setup.force_unstable = wanted.force_unstable;
            }
            Self::Teleoperation(experiment) => {
                experiment.force_unstable = wanted.force_unstable;
            }
            Self::Touch(touch) => touch.force_unstable = wanted.force_unstable,
        }
        self
    }

    /// The same, in another pace.
    #[must_use]
    pub fn in_pace(mut self, pace: Pace) -> Self {
        match &mut self {
            Self::Relax(Relaxation { rendering, .. }) | Self::Creep(Creep { rendering, .. }) => {
                rendering.pace = pace;
            }
            Self::Wall(WallExperiment { setup, .. })
            | Self::Coupler(CouplerExperiment { setup, .. }) => setup.pace = pace,
            Self::Teleoperation(experiment) => experiment.pace = pace,
            Self::Touch(experiment) => experiment.pace = pace,
        }
        self
    }
}
