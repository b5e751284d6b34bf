//! The interface of an experiment of any kind.

use crate::judge::{Published, Report};
use haptic_document::{Failure, FileError, Table, parameters::KeyTable};
use haptic_judge::setup::Beside;
use haptic_link::LoopMode;
use haptic_run::{
    Watched,
    remote::RemoteDevice,
    schedule::{Pace, Schedule},
};
use std::{any::Any, collections::BTreeMap, fmt::Debug};

/// Makes an experiment of its own table and those beside it.
type Read = fn(&Table<'_>, Beside<'_>) -> Result<Box<dyn Experiment>, FileError>;

/// Facts of a kind before a document of it is read.
pub(crate) struct Kind {
    /// The name of its table in a document.
    pub name: &'static str,
    pub keys: &'static [KeyTable],
    pub companion: Companion,
    pub read: Read,
}

/// Other parts of a document that a kind reads besides its own table.
#[derive(PartialEq, Eq)]
pub(crate) enum Companion {
    Nothing,
    /// A table of the drive that holds its indenter.
    Drive,
    /// That, and the device file of its simulated device.
    DriveAndDeviceFile,
}

impl Companion {
    pub(crate) const fn has_drive(&self) -> bool {
        match self {
            Self::Drive | Self::DriveAndDeviceFile => true,
            Self::Nothing => false,
        }
    }

    pub(crate) const fn has_device_file(&self) -> bool {
        match self {
            Self::DriveAndDeviceFile => true,
            Self::Nothing | Self::Drive => false,
        }
    }
}

/// Settings of how an experiment is run, which do not change the experiment.
#[derive(Clone, Debug)]
pub(crate) struct Conduct {
    pub pace: Pace,
    /// The device at a port; `None` for the simulated one.
    pub remote: Option<RemoteDevice>,
    /// Runs even a loop that the pre-flight calls unstable.
    pub force_unstable: bool,
}

impl Conduct {
    /// Conduct in virtual time, on this device.
    pub(crate) const fn on(remote: Option<RemoteDevice>) -> Self {
        Self {
            pace: Pace::Virtual,
            remote,
            force_unstable: false,
        }
    }

    /// Place of the loop of a device at a port; `None` for the simulated one.
    pub(crate) fn at_port(&self) -> Option<LoopMode> {
        self.remote.as_ref().map(|remote| remote.loop_mode)
    }
}

/// The settings of an [`Experiment`] that has them in a field.
macro_rules! conducts {
    () => {
        fn conduct(&self) -> &crate::experiment::kind::Conduct {
            &self.conduct
        }

        fn conduct_mut(&mut self) -> &mut crate::experiment::kind::Conduct {
            &mut self.conduct
        }
    };
}
pub(crate) use conducts;

/// An experiment of any kind.
pub(crate) trait Experiment: Any + Debug + Send + Sync {
    /// The number of samples, if all parameters are good.
    fn check(&self) -> Result<u64, Failure>;

    fn sample_time_s(&self) -> f64;

    fn axes(&self) -> usize {
        1
    }

    /// Metadata for the log of its run, which overrides its document.
    fn metadata(&self) -> BTreeMap<String, String>;

    fn conduct(&self) -> &Conduct;

    fn conduct_mut(&mut self) -> &mut Conduct;

    /// Runs it; log and table go into the folder.
    fn run(&self, watched: Watched<'_>) -> Result<Published<Report>, Failure>;

    /// Ticks of its loop for a run of `samples` samples.
    fn schedule(&self, samples: u64) -> Schedule {
        Schedule {
            samples,
            sample_time_s: self.sample_time_s(),
            pace: self.conduct().pace,
        }
    }

    /// Refuses a simulated hand that begins inside the shape that it touches.
    fn check_start(&self) -> Result<(), Failure> {
        Ok(())
    }

    /// True if the pre-flight may refuse it on the simulated device too.
    fn may_be_refused(&self) -> bool {
        false
    }
}
