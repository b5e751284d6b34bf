//! The controller of a loop: a file, or notation.

use super::words::in_degrees;
use crate::command::words::{parse_number, parse_scheme};
use crate::within::in_range;
use crate::within::within;
use clap::Args;
use fracdiff::{Scheme, Seconds};
use fractional_control::{
    ControllerParameters, ControllerSetup, FractionalTransferFunction, PidParameters,
};
use haptic_experiment::Failure;
use haptic_experiment::document::ControllerFile;
use haptic_experiment::document::short;
use haptic_experiment::parameters::range;
use haptic_quantity::{Time, digits};
use std::path::Path;

/// Options of the controller.
#[derive(Debug, Args)]
#[command(next_help_heading = "Controller")]
pub(super) struct ControllerArguments {
    /// Controller file (*.toml), or notation, as in '2+3/s^0.9+0.1s^0.5'
    #[arg(long, value_name = "FILE|FUNCTION", allow_hyphen_values = true)]
    controller: Option<String>,
    /// Sample time [default: that of the controller file]
    #[arg(long, value_parser = within::<Time>(range::SAMPLE_TIMES), value_name = "TIME", allow_hyphen_values = true)]
    sample_time: Option<Time>,
    /// Scheme: full or full-bdf2, each with :TOLERANCE [default: that of the controller file, else full-bdf2]
    #[arg(long, value_parser = controller_scheme)]
    scheme: Option<Scheme>,
    /// Limits of the command [default: those of the controller file, else none]
    #[arg(long, value_name = "LOW:HIGH", value_parser = parse_limits, allow_hyphen_values = true)]
    output_limits: Option<Limits>,
}

/// Lowest and highest command.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Limits {
    pub(super) low: f64,
    pub(super) high: f64,
}

impl ControllerArguments {
    /// The sample time that was given.
    pub(super) fn sample_time_s(&self) -> Option<f64> {
        self.sample_time.map(|time| time.0)
    }

    /// The controller, if one is given.
    ///
    /// # Errors
    /// A file that cannot be read, one that is wrong, a controller in notation without a sample time.
    pub(super) fn resolve(&self) -> Result<Option<ControllerSetup>, Failure> {
        let sample_time_s = self.sample_time_s();
        let Some(text) = &self.controller else {
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
        let path = Path::new(text);
        let is_file = path.extension().is_some_and(|own| own == "toml") || path.is_file();
        let mut file = if is_file {
            ControllerFile::read(path).map_err(Failure::input)?.setup
        } else {
            let law = law(text)?;
            let sample_time_s = sample_time_s.ok_or_else(|| {
                Failure::bad_input(
                    "a controller in notation has no sample time: give --sample-time, as in 1ms",
                )
            })?;
            let mut file = ControllerSetup::new(law, Seconds(sample_time_s));
            // On the error, as it is written.
            file.set_point = fractional_control::SetPoint::ERROR;
            file
        };
        file.sample_time_s = sample_time_s.unwrap_or(file.sample_time_s);
        file.scheme = self.scheme.unwrap_or(file.scheme);
        if let Some(limits) = self.output_limits {
            (file.output_low, file.output_high) = (Some(limits.low), Some(limits.high));
        }
        file.check().map_err(super::words::refused)?;
        Ok(Some(file))
    }
}

/// A PI^λD^μ, or any proper function.
fn law(text: &str) -> Result<ControllerParameters, Failure> {
    if let Ok(pid) = text.parse::<PidParameters>() {
        return Ok(pid.into());
    }
    let function = text.parse::<FractionalTransferFunction>();
    super::plant::say_loose_factor("controller", text);
    function.map(Into::into).map_err(|error| {
        let (text, error) = (short(text), in_degrees(&error));
        Failure::bad_input(format_args!(
            "controller \"{text}\": {error}; change --controller, as in 2+3/s^0.9+0.1s^0.5"
        ))
    })
}

/// Reads a SCHEME that a controller may have.
pub(super) fn controller_scheme(text: &str) -> Result<Scheme, String> {
    let scheme = parse_scheme(text)?;
    match scheme {
        Scheme::FullBdf2 { .. } => Ok(scheme),
        Scheme::Full { .. } if text.starts_with("full") => Ok(scheme),
        _ => Err(format!(
            "scheme \"{scheme}\" is not for a controller: give full or full-bdf2"
        )),
    }
}

/// Reads two limits of a command.
pub(super) fn parse_limits(text: &str) -> Result<Limits, String> {
    let wrong = || format!("\"{}\" is not LOW:HIGH, as in -10:10", short(text));
    let (low, high) = text.split_once(':').ok_or_else(wrong)?;
    let (low, high) = (
        parse_number(low).map_err(|_| wrong())?,
        parse_number(high).map_err(|_| wrong())?,
    );
    let (low, high) = (
        in_range(low, range::NUMBERS)?,
        in_range(high, range::NUMBERS)?,
    );
    if low < high {
        return Ok(Limits { low, high });
    }
    Err(format!(
        "the low limit {} is not below the high limit {}",
        digits(low, 4),
        digits(high, 4)
    ))
}
