//! The plant, as every command of `control` asks for it.

use super::words::{in_degrees, refused};
use crate::output::note;
use crate::within::within;
use clap::Args;
use fracdiff::parameter::Shown;
use fractional_control::{Plant, factor_after_division};
use haptic_experiment::Failure;
use haptic_experiment::document::short;
use haptic_experiment::parameters;
use haptic_experiment::run::{DeviceValues, PlantFile, PlantModel, read_response};
use haptic_quantity::{Damping, Mass, Stiffness, Time};
use std::path::Path;

/// Options of the plant.
#[derive(Debug, Args)]
#[command(next_help_heading = "Plant")]
pub(super) struct PlantArguments {
    #[arg(
        long,
        value_name = "FUNCTION|FILE",
        allow_hyphen_values = true,
        help = "Transfer function, as in '0.55exp(-s)/(62s+1)', plant file (*.toml), or measured response (*.csv with omega_rad_s, gain \
                and phase_deg)"
    )]
    plant: Option<String>,
    /// Mass of a device instead of --plant: force in, position out
    #[arg(long, value_parser = within::<Mass>(parameters::MASS.range()), conflicts_with = "plant", allow_hyphen_values = true)]
    mass: Option<Mass>,
    /// Viscous damping of the device
    #[arg(long, value_parser = within::<Damping>(parameters::DAMPING.range()), requires = "mass", allow_hyphen_values = true)]
    damping: Option<Damping>,
    /// Stiffness of the hand
    #[arg(long, value_parser = within::<Stiffness>(parameters::HAND_STIFFNESS.range()), requires = "mass", allow_hyphen_values = true)]
    hand_stiffness: Option<Stiffness>,
    /// Time constant of the actuator's current
    #[arg(
        long, value_parser = within::<Time>(parameters::CURRENT_LAG.range()),
        requires = "mass",
        value_name = "TIME",
        allow_hyphen_values = true
    )]
    current_lag: Option<Time>,
    /// Additional dead time
    #[arg(long, value_parser = within::<Time>(parameters::DEAD_TIME.range()), value_name = "TIME", allow_hyphen_values = true)]
    delay: Option<Time>,
}

/// A plant and its name.
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
    /// The plant.
    ///
    /// # Errors
    /// None, or one that is wrong.
    pub(super) fn resolve(&self) -> Result<NamedPlant, Failure> {
        let delay_s = self.delay.map_or(0.0, |delay| delay.0);
        let model = match (&self.plant, self.mass) {
            (Some(text), _) => named(text)?,
            (None, Some(mass)) => PlantModel::Device(DeviceValues {
                hand_stiffness_n_per_m: self.hand_stiffness.map_or(0.0, |hand| hand.0),
                delay_s,
                current_lag_s: self.current_lag.map_or(0.0, |lag| lag.0),
                ..DeviceValues::ideal(mass.0, self.damping.map_or(0.0, |damping| damping.0))
            }),
            (None, None) => {
                return Err(Failure::bad_input(
                    "no plant: give --plant, as in '1/(0.8s^2.2+0.5s^0.9+1)' or plant.toml, or a device with --mass",
                ));
            }
        };
        let plant = model.plant().map_err(|error| match self.plant {
            Some(_) => refused(error),
            None => Failure::input_with_advice(error, "change --mass or --current-lag"),
        })?;
        let further = self.plant.is_some() && delay_s != 0.0;
        let words = match further {
            true => format!("{}, {} s more dead time", model.in_words(), Shown(delay_s)),
            false => model.in_words(),
        };
        let plant = match further {
            true => plant
                .delayed(delay_s)
                .map_err(|error| Failure::input_with_advice(error, "change --delay"))?,
            false => plant,
        };
        Ok(NamedPlant { plant, words })
    }
}

/// A plant by notation, or in a file.
fn named(text: &str) -> Result<PlantModel, Failure> {
    let path = Path::new(text);
    let ends = |extension: &str| {
        path.extension()
            .is_some_and(|own| own.eq_ignore_ascii_case(extension))
    };
    if ends("csv") {
        return read_response(path)
            .map(PlantModel::Measured)
            .map_err(Failure::bad_input);
    }
    if ends("toml") || path.is_file() {
        let file = PlantFile::read(path).map_err(Failure::input)?;
        return Ok(file.model);
    }
    let model = text.parse().map_err(|error| {
        let (text, error) = (short(text), in_degrees(&error));
        Failure::bad_input(format_args!("plant \"{text}\": {error}; change --plant"))
    })?;
    say_loose_factor("plant", text);
    Ok(model)
}

/// Says how a factor was understood that follows a division.
pub(super) fn say_loose_factor(what: &str, text: &str) {
    let Some(place) = factor_after_division(text) else {
        return;
    };
    let (before, factor) = text.split_at(place);
    note(
        "warning",
        format_args!(
            "{what} \"{}\": what follows \"{}\" multiplies; if \"{}\" belongs to the denominator, put brackets around all of it",
            short(text),
            short(before.trim_end()),
            short(factor)
        ),
    );
}
