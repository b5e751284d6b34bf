//! Curves of a finished run, for whoever draws them. An experiment draws nothing itself.

use crate::run::folder::OutputFolder;
use crate::run::record::Record;

/// Origin of a quantity: the device decides. No instrument measured it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// A simulated device.
    Simulated,
    /// A device's own record of what it commanded and read.
    Rendered,
}

impl Origin {
    /// Of the force of a run: without a link, or with a device that simulates its plant, nothing but a simulation.
    #[must_use]
    pub(crate) fn of(record: &Record) -> Self {
        Self::of_device(record.link.as_ref().map(|link| link.simulated))
    }

    /// Of a device that says whether it simulates its plant; `None` without a link, which is a simulation too.
    const fn of_device(simulates: Option<bool>) -> Self {
        match simulates {
            None | Some(true) => Self::Simulated,
            Some(false) => Self::Rendered,
        }
    }

    /// The word for it.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Simulated => "simulated",
            Self::Rendered => "rendered",
        }
    }
}

/// Results of an experiment: a report, and the folder of its further files.
#[derive(Debug)]
pub struct Published<R, C> {
    /// The report. Whoever saves a picture names it there.
    pub report: R,
    /// Curves to draw; `None` for a run that was cut short.
    pub curves: Option<C>,
    /// The folder of the log.
    pub folder: OutputFolder,
}

impl<R, C> Published<R, C> {
    pub(crate) fn new((report, curves): (R, Option<C>), folder: OutputFolder) -> Self {
        Self {
            report,
            curves,
            folder,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_device_decides_between_simulated_and_rendered() {
        for (simulates, word) in [
            (None, "simulated"),
            (Some(true), "simulated"),
            (Some(false), "rendered"),
        ] {
            assert_eq!(Origin::of_device(simulates).word(), word);
        }
    }
}
