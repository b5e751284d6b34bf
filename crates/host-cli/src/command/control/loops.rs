//! Plant and controller, as the commands of `control` ask for them.

use super::refused;
use crate::output::warn;
use crate::parse::{of, quantity};
use clap::Args;
use fracdiff::parameter::Shown;
use fracdiff::{Scheme, Seconds};
use fractional_control::{
    ControllerParameters, ControllerSetup, FractionalTransferFunction, PidParameters, Plant,
    SetPoint,
};
use haptic_experiment::control::{in_degrees, loose_factor};
use haptic_experiment::document::{ControllerFile, short};
use haptic_experiment::question::controller::{CommandLimits, controller_scheme};
use haptic_experiment::run::{DeviceValues, PlantModel};
use haptic_experiment::{Failure, parameters};
use std::path::Path;

#[derive(Debug, Args)]
#[command(next_help_heading = "Plant")]
pub(super) struct PlantArguments {
    /// Transfer function, as in '0.55exp(-s)/(62s+1)', plant file (*.toml), or, for control design
    /// only, measured response (*.csv with `omega_rad_s`, gain and `phase_deg`)
    #[arg(long, value_name = "FUNCTION|FILE", allow_hyphen_values = true)]
    plant: Option<String>,
    /// Mass of a device instead of --plant: force in, position out
    #[arg(long, value_parser = of(parameters::MASS), conflicts_with = "plant")]
    mass: Option<f64>,
    /// Viscous damping of the device
    #[arg(long, value_parser = of(parameters::DAMPING), requires = "mass")]
    damping: Option<f64>,
    /// Stiffness of the hand that holds the device
    #[arg(long, value_parser = of(parameters::HAND_STIFFNESS), requires = "mass")]
    hand_stiffness: Option<f64>,
    /// Time constant of the actuator's current
    #[arg(long, value_name = "TIME", value_parser = of(parameters::CURRENT_LAG), requires = "mass")]
    current_lag: Option<f64>,
    /// Dead time, in addition to the plant's
    #[arg(long, value_name = "TIME", value_parser = of(parameters::DEAD_TIME))]
    delay: Option<f64>,
}

#[derive(Debug)]
pub(super) struct NamedPlant {
    pub(super) plant: Plant,
    pub(super) words: String,
}

impl NamedPlant {
    /// True if it was measured: it can be tuned for, not run.
    pub(super) fn is_measured(&self) -> bool {
        self.plant.band().1.is_finite()
    }
}

impl PlantArguments {
    pub(super) fn resolve(&self) -> Result<NamedPlant, Failure> {
        let delay_s = self.delay.unwrap_or(0.0);
        let model = match (&self.plant, self.mass) {
            (Some(text), _) => named(text)?,
            (None, Some(mass)) => PlantModel::Device(DeviceValues {
                mass_kg: mass,
                damping_n_s_per_m: self.damping.unwrap_or(0.0),
                hand_stiffness_n_per_m: self.hand_stiffness.unwrap_or(0.0),
                delay_s,
                current_lag_s: self.current_lag.unwrap_or(0.0),
                ..DeviceValues::default()
            }),
            (None, None) => {
                return Err(Failure::bad_input(
                    "no plant: give --plant, as in '1/(62s+1)' or plant.toml, or --mass of a device",
                ));
            }
        };
        let plant = model.plant().map_err(|error| match self.plant {
            Some(_) => refused(error),
            None => Failure::input_with_advice(error, "change --mass or --current-lag"),
        })?;
        let words = model.in_words();
        if self.plant.is_none() || delay_s == 0.0 {
            return Ok(NamedPlant { plant, words });
        }
        let plant = plant.delayed(delay_s);
        Ok(NamedPlant {
            plant: plant.map_err(|error| Failure::input_with_advice(error, "change --delay"))?,
            words: format!("{words}, {} s more dead time", Shown(delay_s)),
        })
    }
}

/// A plant by notation, or in a file.
fn named(text: &str) -> Result<PlantModel, Failure> {
    let path = Path::new(text);
    let ends = |extension: &str| {
        path.extension()
            .is_some_and(|found| found.eq_ignore_ascii_case(extension))
    };
    if ends("csv") || ends("toml") || path.is_file() {
        return PlantModel::read(path);
    }
    let model = text.parse().map_err(|error| {
        let (text, error) = (short(text), in_degrees(&error));
        if text.starts_with("s^") && !text.contains('/') {
            let why = "an operator alone is no plant: give it to --controller";
            return Failure::bad_input(format_args!("plant \"{text}\": {why}"));
        }
        Failure::bad_input(format_args!(
            "plant \"{text}\": {error}; write a power as s^2, a number for any letter but s, or a file that ends in .toml or .csv"
        ))
    })?;
    loose_factor("plant", text)
        .iter()
        .for_each(|said| warn(said));
    Ok(model)
}

#[derive(Debug, Args)]
pub(crate) struct ControllerOption {
    /// Controller file (*.toml), or notation, as in '2+3/s^0.9+0.1s^0.5'
    #[arg(
        long,
        value_name = "FILE|FUNCTION",
        allow_hyphen_values = true,
        help_heading = "Controller"
    )]
    pub(crate) controller: Option<String>,
}

impl ControllerOption {
    /// The controller, with this in place of what its file says.
    pub(crate) fn resolve(
        &self,
        sample_time_s: Option<f64>,
        scheme: Option<Scheme>,
    ) -> Result<Option<ControllerSetup>, Failure> {
        let Some(text) = &self.controller else {
            return Ok(None);
        };
        let path = Path::new(text);
        let is_file = path.extension().is_some_and(|found| found == "toml") || path.is_file();
        let mut file = if is_file {
            ControllerFile::read(path)?.setup
        } else {
            let law = law(text)?;
            let sample_time_s = sample_time_s.ok_or_else(|| {
                Failure::bad_input(
                    "a controller in notation has no sample time: give --sample-time, as in 1ms",
                )
            })?;
            let mut file = ControllerSetup::new(law, Seconds(sample_time_s));
            // On the error, as it is written.
            file.set_point = SetPoint::ERROR;
            file
        };
        file.sample_time_s = sample_time_s.unwrap_or(file.sample_time_s);
        file.scheme = scheme.unwrap_or(file.scheme);
        Ok(Some(file))
    }
}

#[derive(Debug, Args)]
#[command(next_help_heading = "Controller")]
pub(super) struct ControllerArguments {
    #[command(flatten)]
    controller: ControllerOption,
    /// Sample time [default: from the controller file]
    #[arg(long, value_name = "TIME", value_parser = quantity("_s", parameters::SAMPLE_TIME.range()))]
    pub(super) sample_time: Option<f64>,
    /// Scheme: full or full-bdf2, each with :TOLERANCE [default: from the controller file, else full-bdf2]
    #[arg(long, value_parser = controller_scheme)]
    scheme: Option<Scheme>,
    /// Limits of the command [default: from the controller file, else none]
    #[arg(long, value_name = "LOW:HIGH", value_parser = CommandLimits::parse)]
    output_limits: Option<CommandLimits>,
}

impl ControllerArguments {
    pub(super) fn resolve(&self) -> Result<Option<ControllerSetup>, Failure> {
        let controller = &self.controller;
        let Some(mut file) = controller.resolve(self.sample_time, self.scheme)? else {
            let option = match (self.output_limits, self.scheme) {
                (None, None) => return Ok(None),
                (Some(_), None) => "--output-limits has",
                (None, Some(_)) => "--scheme has",
                (Some(_), Some(_)) => "--output-limits and --scheme have",
            };
            return Err(Failure::bad_input(format_args!(
                "{option} no effect without a controller: give --controller too, or omit it"
            )));
        };
        if let Some(limits) = self.output_limits {
            (file.output_low, file.output_high) = (Some(limits.low), Some(limits.high));
        }
        file.check().map_err(refused)?;
        Ok(Some(file))
    }
}

/// A PI^λD^μ, or any proper function.
fn law(text: &str) -> Result<ControllerParameters, Failure> {
    if let Ok(pid) = text.parse::<PidParameters>() {
        return Ok(pid.into());
    }
    let function = text.parse::<FractionalTransferFunction>();
    loose_factor("controller", text)
        .iter()
        .for_each(|said| warn(said));
    function.map(Into::into).map_err(|error| {
        let (text, error) = (short(text), in_degrees(&error));
        Failure::bad_input(format_args!(
            "controller \"{text}\": {error}; change --controller, as in 2+3/s^0.9+0.1s^0.5"
        ))
    })
}
