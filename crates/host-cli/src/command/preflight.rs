//! Options of the pre-flight.

use clap::Args;
use fracdiff::parameter::Shown;
use haptic_experiment::failure::Failure;
use haptic_experiment::plant_file::DeviceModel;
use haptic_experiment::{Dynamics, PreflightRequest, Safety};

/// Arguments of every experiment that can run on a device.
#[derive(Clone, Copy, Debug, Args)]
#[command(next_help_heading = "Device")]
pub struct PreflightArguments {
    /// Run what the analysis calls unstable, on a serial device, under a drive or in a remote place
    #[arg(long)]
    force_unstable: bool,
}

impl PreflightArguments {
    /// The request for the pre-flight; `judged` is true for an experiment that one can refuse: on a serial device, under a drive, or a teleoperation.
    /// Mass and damping of a real device are those of the guard, its delay and lag those of its device file.
    ///
    /// # Errors
    /// The option where nothing is refused; a mass or damping outside its range.
    pub fn wanted(
        &self,
        judged: bool,
        safety: &Safety,
        model: Option<&DeviceModel>,
    ) -> Result<PreflightRequest, Failure> {
        if !judged && self.force_unstable {
            return Err(Failure::bad_input(
                "--force-unstable is for serial devices, drives and teleoperations: add --device serial:PATH or --drive FILE.toml",
            ));
        }
        let known = safety.device_mass_kg.zip(safety.device_damping_n_s_per_m);
        if let Some((mass, damping)) = known.filter(|(mass, b)| !(*mass > 0.0 && *b >= 0.0)) {
            return Err(Failure::bad_input(format_args!(
                "a device of {mass} kg and {damping} N·s/m: give a --device-mass above 0 and a \
                 --device-damping of at least 0",
                mass = Shown(mass),
                damping = Shown(damping)
            )));
        }
        Ok(PreflightRequest {
            force_unstable: self.force_unstable,
            dynamics: known.map(|(mass_kg, damping_n_s_per_m)| Dynamics {
                mass_kg,
                damping_n_s_per_m,
                ..model.map_or(
                    Dynamics::ideal(mass_kg, damping_n_s_per_m),
                    DeviceModel::dynamics,
                )
            }),
        })
    }
}
