//! What a user says of the pre-flight, and of the device that it looks at.

use crate::experiment::{Dynamics, PreflightRequest};
use crate::failure::Failure;
use crate::quantity::{Damping, Mass};
use clap::Args;

/// Arguments of every experiment that can run on a device.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Device")]
pub struct PreflightArguments {
    /// Run on a serial device what the analysis calls unstable
    #[arg(long)]
    force_unstable: bool,
    #[command(flatten)]
    plant: PlantArguments,
}

/// The moving part of a real device; a simulated one and a `[wall]` tell their own.
#[derive(Clone, Copy, Debug, Args)]
pub struct PlantArguments {
    /// Mass of the moving part of a serial device, for the pre-flight
    #[arg(long, value_name = "MASS", allow_hyphen_values = true)]
    device_mass: Option<Mass>,
    /// Viscous damping of a serial device, for the pre-flight
    #[arg(long, value_name = "DAMPING", allow_hyphen_values = true)]
    device_damping: Option<Damping>,
}

impl PreflightArguments {
    /// What is asked of the pre-flight; `serial` says whether the experiment runs on a serial device.
    ///
    /// # Errors
    /// Options of a serial device without one; one of mass and damping without the other.
    pub fn wanted(&self, serial: bool) -> Result<PreflightRequest, Failure> {
        let dynamics = dynamics(self.plant.device_mass, self.plant.device_damping)?;
        if !serial && (self.force_unstable || dynamics.is_some()) {
            return Err(Failure::bad_input(
                "--force-unstable, --device-mass and --device-damping are for serial devices: add --device \
                 serial:PATH",
            ));
        }
        Ok(PreflightRequest {
            force_unstable: self.force_unstable,
            dynamics,
        })
    }
}

/// A device of this mass and damping, without a hand; `None` if neither is known.
///
/// # Errors
/// One without the other; a mass that is not above 0, a damping below 0.
pub fn dynamics(mass: Option<Mass>, damping: Option<Damping>) -> Result<Option<Dynamics>, Failure> {
    match (mass, damping) {
        (None, None) => Ok(None),
        (Some(Mass(mass)), Some(Damping(damping))) if mass > 0.0 && damping >= 0.0 => {
            Ok(Some(Dynamics {
                mass_kg: mass,
                damping_n_s_per_m: damping,
                hand_stiffness_n_per_m: 0.0,
            }))
        }
        (Some(mass), Some(damping)) => Err(Failure::bad_input(format_args!(
            "a device of {} kg and {} N·s/m: give a --device-mass above 0 and a --device-damping of at least 0",
            mass.0, damping.0
        ))),
        _ => Err(Failure::bad_input(
            "--device-mass and --device-damping belong together: give both, as in --device-mass 65g \
             --device-damping 3.5",
        )),
    }
}
