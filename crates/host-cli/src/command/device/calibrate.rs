//! `device calibrate`: is a newton of the device a newton?

use super::key_value::refused;
use crate::command::conduct::stop_on_interrupt;
use crate::files::{File, PROGRAM, PlaceOfFile};
use crate::options::{Options, keys};
use crate::output::{Output, note};
use crate::parse::{WAITS, quantity};
use clap::Args;
use haptic_experiment::Failure;
use haptic_experiment::document::Document;
use haptic_experiment::parameters::{CALIBRATE_READINGS, CALIBRATION};
use haptic_experiment::question::{CalibrationStep, Calibrator, GRAVITY};
use haptic_quantity::parse_for_key;
use std::io::stdin;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::task::Poll;
use std::time::Duration;
use toml::Value;

/// Check a newton of a device against a kitchen scale, a spring balance or a hung weight
///
/// Finds how many newtons the motor makes for each that is commanded, and the force sensor shows for
/// each, with 95 % intervals, and the sensor's offset and lag. The result goes into the device file:
/// runs, searches and measurements with --device-model then command and record true newtons, within
/// limits that hold in true ones, and their reports say when it was found.
///
/// First the free handle moves a little, which tells a motor with its leads swapped. Then the force
/// goes slowly to five levels up to --force-limit, and at each you type what the instrument shows,
/// as 51g or 0.5N. With --weight nobody reads: the weight is lifted and let down three times. The
/// device is armed only while it moves or is read. On Ctrl-C, and after three minutes without an
/// answer, the force falls to zero.
///
/// With --scale the readings are given, and nothing moves.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  host-cli device calibrate --device serial:/dev/ttyACM0 --device-model device.toml --out calibrated.toml\n  \
                  host-cli device calibrate --device serial:/dev/ttyACM0 --weight 100g --device-model device.toml --out calibrated.toml\n  \
                  host-cli device calibrate --scale 0.5N=26g --scale 1.5N=77g --device-model device.toml --out calibrated.toml"
)]
pub(crate) struct Arguments {
    #[command(flatten)]
    options: Options<keys::Calibrate>,
    /// A commanded force and what the instrument showed, as 0.5N=51g; give several
    #[arg(long, value_name = "FORCE=READING")]
    scale: Vec<String>,
    /// Keep trying for this long if the device is absent [default: 0s]
    #[arg(long, value_name = "TIME", value_parser = quantity("_s", WAITS))]
    wait: Option<f64>,
    #[command(flatten)]
    file: File,
}

impl Arguments {
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        let mut outputs = PlaceOfFile::look(&self.file, "calibrated")?;
        let mut document = self.options.over(Document::new(CALIBRATION))?;
        if let Some(first) = self.scale.first() {
            let pairs: Result<Vec<Value>, Failure> =
                self.scale.iter().map(|pair| read_pair(pair)).collect();
            let words = format!("--scale {first}");
            document.set(CALIBRATION, CALIBRATE_READINGS.key, pairs?, &words)?;
        }
        let mut asked = Calibrator::open(&document)?;
        if self.file.out.is_some() && !asked.has_device_file() {
            return Err(Failure::bad_input(
                "a calibration is kept in a device file: give --device-model FILE.toml too, as device measure writes it, or omit --out",
            ));
        }
        if let Some(wait) = self.wait {
            asked = asked.with_patience(Duration::from_secs_f64(wait));
        }
        let stop = stop_on_interrupt()?;
        let mut person = Person::default();
        let mut report = asked.run(&mut |step| person.answer(step), stop, &|text| {
            output.warn(text);
        })?;
        if let Some(text) = report.device_file(PROGRAM) {
            report.model = outputs.write_beside("toml", Some(text));
        }
        output.report(&report)?;
        outputs.close(Ok(()))
    }
}

/// Force that an instrument shows, N: itself, or a mass that weighs as much.
fn read_force(text: &str) -> Result<f64, String> {
    let text = text.trim();
    match text.parse::<f64>() {
        Ok(number) if number != 0.0 => {
            return Err(format!("\"{text}\" has no unit: write {text}g or {text}N"));
        }
        Ok(_) => return Ok(0.0),
        Err(_) => {}
    }
    let mass = parse_for_key("mass_kg", text).map(|mass_kg| GRAVITY * mass_kg);
    mass.or_else(|_| parse_for_key("force_n", text))
        .map_err(|_| format!("\"{text}\" is neither a mass nor a force: write 51g or 0.5N"))
}

fn read_pair(pair: &str) -> Result<Value, Failure> {
    let (force, reading) = pair
        .split_once('=')
        .ok_or_else(|| refused(pair, "is not FORCE=READING, as 0.5N=51g"))?;
    let wrong = |why: String| refused(pair, &format!(": {why}"));
    let force = parse_for_key("force_n", force).map_err(|error| wrong(error.to_string()))?;
    Ok(Value::from(vec![
        force,
        read_force(reading).map_err(wrong)?,
    ]))
}

/// Somebody who types lines.
#[derive(Default)]
struct Person {
    /// Lines of standard input, read by a thread of its own: nobody can end a read of it.
    lines: Option<Receiver<String>>,
    asked: Option<CalibrationStep>,
}

impl Person {
    fn answer(&mut self, step: &CalibrationStep) -> Poll<Result<f64, Failure>> {
        let reads = step.commanded_n.is_some();
        if self.asked.as_ref() != Some(step) {
            let how = if reads {
                "type it, as 51g or 0.5N"
            } else {
                "then press Enter"
            };
            note("now", format_args!("{}; {how}", step.words));
            self.asked = Some(step.clone());
        }
        let lines = self.lines.get_or_insert_with(|| {
            let (told, lines) = channel();
            std::thread::spawn(move || {
                stdin()
                    .lines()
                    .map_while(Result::ok)
                    .try_for_each(|line| told.send(line))
            });
            lines
        });
        match lines.try_recv().map(|line| read_force(&line)) {
            Ok(_) if !reads => Poll::Ready(Ok(0.0)),
            Ok(Ok(force_n)) => Poll::Ready(Ok(force_n)),
            Ok(Err(why)) => {
                note("again", why);
                Poll::Pending
            }
            Err(TryRecvError::Empty) => Poll::Pending,
            Err(TryRecvError::Disconnected) => Poll::Ready(Err(Failure::bad_input(
                "standard input ended before the last reading: the force is zero, nothing was written",
            ))),
        }
    }
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
        read_pair("0.5N").expect_err("a pair");
    }
}
