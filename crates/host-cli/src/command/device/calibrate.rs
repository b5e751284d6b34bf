//! `device calibrate`: is a newton of the device a newton?

use crate::command::conduct::stop_on_interrupt;
use crate::files::{File, PROGRAM, PlaceOfFile};
use crate::options::{Options, keys};
use crate::output::{Output, note};
use crate::parse::{WAITS, quantity};
use clap::Args;
use haptic_document::Document;
use haptic_experiment::Failure;
use haptic_experiment::parameters::CALIBRATION;
use haptic_experiment::question::{Calibrator, GRAVITY, Person};
use haptic_quantity::parse_for_key;
use std::io::stdin;
use std::sync::Arc;
use std::time::Duration;

/// Check a newton of a device against a kitchen scale, a spring balance or a hung weight
///
/// Finds how many newtons the motor makes for each that is commanded, and the force sensor shows for
/// each, with 95 % intervals, and the sensor's offset and lag. The result goes into the device file:
/// runs, searches and measurements with --device-model then command and record true newtons, within
/// limits that hold in true ones, and their reports say when it was found.
///
/// First the free handle moves a little, which tells a motor with its leads swapped. Then the force
/// goes slowly to five levels, up to a fifth of --force-limit, and at each you type what the
/// instrument shows, as 51g or 0.5N. With --weight nobody reads: the weight is lifted and let down
/// three times. The device is armed only while it moves or is read. On Ctrl-C, and after three
/// minutes without an answer, the force falls to zero.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  host-cli device calibrate --device serial:/dev/ttyACM0 --device-model device.toml --out calibrated.toml\n  \
                  host-cli device calibrate --device serial:/dev/ttyACM0 --weight 100g --device-model device.toml --out calibrated.toml"
)]
pub(crate) struct Arguments {
    #[command(flatten)]
    options: Options<keys::Calibrate>,
    /// Keep trying for this long if the device is absent [default: 0s]
    #[arg(long, value_name = "TIME", value_parser = quantity("_s", WAITS))]
    wait: Option<f64>,
    #[command(flatten)]
    file: File,
}

impl Arguments {
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        let mut outputs = PlaceOfFile::look(&self.file, "calibrated")?;
        let document = self.options.over(Document::new(CALIBRATION))?;
        let mut asked = Calibrator::open(&document)?;
        if let Some(wait) = self.wait {
            asked = asked.with_patience(Duration::from_secs_f64(wait));
        }
        let person: Person = Arc::new(answer);
        let mut report = asked.run(&person, stop_on_interrupt()?, &|text| output.warn(text))?;
        report.model = outputs.write_beside("toml", Some(report.device_file(PROGRAM)));
        output.report(&report)?;
        outputs.close(Ok(()))
    }
}

/// The answer that somebody types.
fn answer(words: &str, held_n: Option<f64>) -> Result<f64, Failure> {
    let how = held_n.map_or("then press Enter", |_| "type it, as 51g or 0.5N");
    note("now", format_args!("{words}; {how}"));
    for line in stdin().lines().map_while(Result::ok) {
        match read_force(&line) {
            Ok(force_n) => return Ok(force_n),
            Err(_) if held_n.is_none() => return Ok(0.0),
            Err(why) => note("again", why),
        }
    }
    Err(Failure::bad_input(
        "standard input ended before the last reading: the force is zero, nothing was written",
    ))
}

/// Force that an instrument shows, N: itself, or a mass that weighs as much.
fn read_force(text: &str) -> Result<f64, String> {
    let text = text.trim();
    match text.parse::<f64>() {
        Ok(0.0) => return Ok(0.0),
        Ok(_) => return Err(format!("\"{text}\" has no unit: write {text}g or {text}N")),
        Err(_) => {}
    }
    let mass = parse_for_key("mass_kg", text).map(|mass_kg| GRAVITY * mass_kg);
    mass.or_else(|_| parse_for_key("force_n", text))
        .map_err(|_| format!("\"{text}\" is neither a mass nor a force: write 51g or 0.5N"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reading_is_a_mass_or_a_force_and_never_without_its_unit() {
        for (text, want) in [
            ("51g", 0.500_139_15),
            (" 0.5 N", 0.5),
            ("0.1kg", 0.980_665),
            ("0", 0.0),
        ] {
            let read = read_force(text).expect(text);
            assert!((read - want).abs() < 1e-12, "{text}: {read}");
        }
        for (text, remedy) in [
            ("51", "write 51g or 51N"),
            ("", "51g or 0.5N"),
            ("5 mm", "51g or 0.5N"),
        ] {
            let error = read_force(text).expect_err(text);
            assert!(error.ends_with(remedy), "{error}");
        }
    }
}
