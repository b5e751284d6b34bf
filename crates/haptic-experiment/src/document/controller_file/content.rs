//! The content of a controller file.

use fractional_control::ControllerSetup;

/// A controller and where it comes from.
///
/// ```
/// use haptic_experiment::document::ControllerFile;
/// use std::path::Path;
///
/// let text = "[pid]\nproportional_gain = 2\n[loop]\nsample_time_s = 0.01";
/// let file = ControllerFile::parse(Path::new("lab/pid.toml"), text)?;
/// assert_eq!(file.setup.pid().map(|pid| pid.proportional), Some(2.0));
/// assert_eq!(ControllerFile::parse(Path::new("again.toml"), &file.to_toml())?, file);
/// let wrong = ControllerFile::parse(Path::new("lab/pid.toml"), "[pid]\nproportional_gian = 2");
/// assert!(wrong.unwrap_err().to_string().starts_with("lab/pid.toml:2: unknown key"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ControllerFile {
    /// The controller and how it runs.
    pub setup: ControllerSetup,
    /// Where it comes from.
    pub origin: ControllerOrigin,
}

/// Where a controller comes from, in words; empty where that is not known.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ControllerOrigin {
    /// The plant it was made for.
    pub plant: String,
    /// The wishes it was made for.
    pub wishes: String,
    /// The program that made it.
    pub program: String,
    /// Anything else.
    pub note: String,
}

impl From<ControllerSetup> for ControllerFile {
    fn from(setup: ControllerSetup) -> Self {
        Self {
            setup,
            origin: ControllerOrigin::default(),
        }
    }
}
