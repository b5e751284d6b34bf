//! A touch: device, shape, hand, limits.

use super::hand::{Grip, HandPath};
use super::shape::{TouchLaw, TouchShape, per_axis};
use crate::document::advice::parameter;
use crate::document::failure::Failure;
use crate::document::parameters::WORKSPACE_LOW;
use crate::experiment::touch::keys::{TOUCH_BOX_HIGH, TOUCH_BOX_LOW};
use crate::experiment::trial::{delay_ticks, dynamics, force_alone, safe_force_limit};
use crate::run::record::WHOLE_MOST;
use crate::run::remote::{RemoteDevice, host_limits};
use crate::run::safety::{Safety, workspace};
use crate::run::schedule::Pace;
use crate::run::sensors::Sensors;
use fracdiff::parameter::Shown;
use fracdiff::{Scheme, Seconds};
use haptic_analysis::Dynamics;
use haptic_loop::plant::MassDamperConfig;
use haptic_loop::units::{Kilograms, Newtons, NewtonsPerMetre, NewtonsPerSecond};
use haptic_loop::{Limits, SafetyChain, Workspace};

/// A touch.
///
/// ```
/// use haptic_experiment::ExperimentFile;
/// use std::path::Path;
///
/// // A finger round a disc of tissue, 2 mm deep.
/// let text = "[touch]\ntissue = \"prostate-cancerous\"\nradius_m = 0.02\ncircle_radius_m = 0.018";
/// let ExperimentFile::Touch(touch) = ExperimentFile::parse(Path::new("touch.toml"), text)? else {
///     panic!("a touch")
/// };
/// assert_eq!((touch.axes, touch.check()?), (2, 5001));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct TouchExperiment {
    /// Number of axes: 2 or 3.
    pub axes: usize,
    /// The shape.
    pub shape: TouchShape,
    /// The matter behind its surface.
    pub law: TouchLaw,
    /// The operator.
    pub scheme: Scheme,
    /// Mass of the device on each axis, kg, above 0.
    pub mass_kg: Vec<f64>,
    /// The device without its mass and hand: damping, delay, friction, lag, sample time; the same on each axis.
    pub device: MassDamperConfig,
    /// Its sensors.
    pub sensors: Sensors,
    /// Path of the hand, m or N.
    pub path: HandPath,
    /// How the hand holds the device.
    pub grip: Grip,
    /// Length of a run, s.
    pub duration_s: f64,
    /// Largest norm of the force, N.
    pub force_limit_n: f64,
    /// Largest rate of the force on an axis, N/s; `None` for any.
    pub force_rate_limit_n_per_s: Option<f64>,
    /// The workspace, if there is one.
    pub workspace: Option<WorkspaceBox>,
    /// Energy given to the hand, or a force at its limit, is a failure.
    pub must_be_passive: bool,
    /// Further settings of the safety chain.
    pub safety: Safety,
    /// Pace of time.
    pub pace: Pace,
    /// The device at a port, in whose hand the shape is then felt; `None` for the simulated one.
    pub remote: Option<RemoteDevice>,
    /// Run on a device what the analysis refuses.
    pub force_unstable: bool,
}

/// Corners of a workspace, a number an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct WorkspaceBox {
    /// Lowest place, m.
    pub low_m: Vec<f64>,
    /// Highest place, m, above it on each axis.
    pub high_m: Vec<f64>,
}

impl TouchExperiment {
    /// T.
    #[must_use]
    pub const fn sample_time(&self) -> Seconds {
        self.device.sample_time
    }

    /// That at time 0 included.
    ///
    /// # Errors
    /// Fewer than 10 or more than a million.
    pub(super) fn samples(&self) -> Result<u64, Failure> {
        let allowed = 10.0..=WHOLE_MOST as f64;
        crate::run::schedule::samples(self.duration_s, self.sample_time().0, &allowed)
    }

    /// The axes as they are simulated, the spring of the hand with them.
    pub(super) fn axes_of<const D: usize>(&self) -> Result<[MassDamperConfig; D], Failure> {
        let masses: [f64; D] = per_axis("mass_kg", &self.mass_kg)?;
        Ok(masses.map(|mass| self.axis(mass)))
    }

    /// An axis of this mass, kg.
    pub(super) const fn axis(&self, mass_kg: f64) -> MassDamperConfig {
        let stiffness = match self.grip {
            Grip::Spring(stiffness) => stiffness,
            Grip::Force => 0.0,
        };
        MassDamperConfig {
            mass: Kilograms(mass_kg),
            stiffness: NewtonsPerMetre(stiffness),
            ..self.device
        }
    }

    /// An axis as the analysis knows it, the lightest.
    pub(super) fn dynamics(&self) -> Dynamics {
        dynamics(&self.axis(self.masses()[0]))
    }

    /// The lightest and the heaviest axis, kg.
    pub(super) fn masses(&self) -> [f64; 2] {
        let masses = || self.mass_kg.iter().copied();
        [
            masses().fold(f64::INFINITY, f64::min),
            masses().fold(0.0, f64::max),
        ]
    }

    /// The safety chain of the loop that runs here: force limited by its norm, the guard for the lightest axis. On a device it is that
    /// of the force alone; the rest is the device's.
    ///
    /// # Errors
    /// A limit outside its range; settings that would have no effect.
    pub(super) fn chain(&self) -> Result<SafetyChain<f64>, Failure> {
        let limits = self.norm_and_box()?;
        if self.remote.is_some() {
            let limits = host_limits(&self.limits_there()?);
            let chain = SafetyChain::from_limits(&limits, self.sample_time());
            self.safety.acts_on_device()?;
            return chain.map_err(parameter);
        }
        let lightest = self.axis(self.masses()[0]);
        let chain = safe_force_limit(limits, &lightest, self.sensors, &self.safety)?;
        self.safety.acts()?;
        Ok(chain)
    }

    fn norm_and_box(&self) -> Result<Limits, Failure> {
        let alone = force_alone(self.force_limit_n, self.sample_time());
        Ok(Limits {
            norm: Some(Newtons(self.force_limit_n)),
            rate: self
                .force_rate_limit_n_per_s
                .map_or(alone.rate, NewtonsPerSecond),
            workspace_box: self.workspace_box()?,
            ..alone
        })
    }

    /// Limits of the chain of a device, without its guard.
    ///
    /// # Errors
    /// A box that is none.
    pub(super) fn limits_there(&self) -> Result<Limits, Failure> {
        let limits = self.safety.on(self.norm_and_box()?, true);
        let delay = limits.device_delay_samples.max(delay_ticks(&self.device));
        Ok(self.safety.braked(limits, self.masses()[0], delay))
    }

    fn workspace_box(&self) -> Result<Option<[Workspace; 3]>, Failure> {
        let Some(WorkspaceBox { low_m, high_m }) = &self.workspace else {
            return Ok(None);
        };
        for (key, corner) in [("box_low_m", low_m), ("box_high_m", high_m)] {
            if corner.len() != self.axes {
                return Err(Failure::bad_input(format_args!(
                    "`{key}` has {} numbers, not one for each of {} axes",
                    corner.len(),
                    self.axes
                )));
            }
        }
        if let Some((low, high)) = low_m.iter().zip(high_m).find(|(low, high)| low >= high) {
            return Err(Failure::bad_input(format_args!(
                "{TOUCH_BOX_HIGH} has {high}, which is not above {low} of {TOUCH_BOX_LOW}",
                high = Shown(*high),
                low = Shown(*low)
            )));
        }
        if self.safety.workspace_m.is_some() {
            return Err(Failure::bad_input(format_args!(
                "{WORKSPACE_LOW} is of every axis and {TOUCH_BOX_LOW} of each by itself: leave one of them out"
            )));
        }
        let brakes = self.safety.braking_n_s_per_m.is_some();
        // An axis that is not there is not looked at.
        let ends = |axis: usize| {
            let axis = axis.min(low_m.len() - 1);
            workspace((low_m[axis], high_m[axis]), brakes)
        };
        Ok(Some([ends(0), ends(1), ends(2)]))
    }
}
