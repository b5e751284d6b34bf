//! Curves of a finished run, for whoever draws them. An experiment draws nothing itself.

use crate::drive::DriveCurves;
use crate::folder::OutputFolder;

/// Origin of a quantity: the device decides. No instrument measured it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// A simulated device.
    Simulated,
    /// A device's own record of what it commanded and read.
    Rendered,
}

impl Origin {
    /// Of a device that says whether it simulates its plant; `None` without a link, which is a simulation too.
    #[must_use]
    pub const fn of_device(simulates: Option<bool>) -> Self {
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

/// The quantity that is held against its closed form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Force, N.
    Force,
    /// Strain, dimensionless.
    Strain,
}

impl Quantity {
    /// The word for it.
    #[must_use]
    pub const fn word(self) -> &'static str {
        match self {
            Self::Force => "force",
            Self::Strain => "strain",
        }
    }

    /// Its axis label, with the unit.
    #[must_use]
    pub const fn label(self) -> &'static str {
        match self {
            Self::Force => "force / N",
            Self::Strain => "strain",
        }
    }
}

/// A run beside its closed form. The slices belong together point by point; long runs are thinned without losing a
/// peak.
#[derive(Clone, Debug, PartialEq)]
pub struct TheoryCurves {
    /// One line: which experiment, of what, simulated or rendered.
    pub title: String,
    /// Name of the tissue.
    pub tissue: String,
    /// Its order α.
    pub order: f64,
    /// Name of the device.
    pub device: String,
    /// The operator.
    pub scheme: String,
    /// Motion or load of the tissue, in words.
    pub remark: String,
    /// Kind of the quantity.
    pub quantity: Quantity,
    /// Its origin.
    pub origin: Origin,
    /// Time since contact or since the load, s.
    pub time_s: Vec<f64>,
    /// The quantity, N or 1.
    pub values: Vec<f64>,
    /// The quantity in closed form.
    pub closed_form: Vec<f64>,
    /// Its relative error; NaN where it has no meaning.
    pub relative_error: Vec<f64>,
    /// Of the controller that held the indenter.
    pub drive: Option<DriveCurves>,
}

/// The trial of a wall.
#[derive(Clone, Debug, PartialEq)]
pub struct WallCurves {
    /// One line: wall, device, operator, verdict.
    pub subtitle: String,
    /// Origin of the force.
    pub origin: Origin,
    /// Place of rest, m; `None` where no spring holds the push.
    pub expected_deflection_m: Option<f64>,
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Position, m.
    pub position_m: Vec<f64>,
    /// Force of the wall, opposed to the motion, N.
    pub force_n: Vec<f64>,
}

/// The trial of a coupler.
#[derive(Clone, Debug, PartialEq)]
pub struct CouplerCurves {
    /// One line: coupler, object, device, operator, verdict.
    pub subtitle: String,
    /// Origin of the force.
    pub origin: Origin,
    /// Place of rest of the device, m; `None` where the coupler creeps or nothing holds the object.
    pub expected_deflection_m: Option<f64>,
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Position of the device, m.
    pub position_m: Vec<f64>,
    /// Place of the object, m.
    pub object_position_m: Vec<f64>,
    /// Force of the coupler, opposed to the motion of the device, N.
    pub force_n: Vec<f64>,
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
