//! `control identify`: a fractional transfer function from a record of input and output.

use super::draw::draw_identified;
use crate::command::conduct::progress_bar;
use crate::files::{File, PROGRAM, PlaceOfFile};
use crate::options::{Options, keys};
use crate::output::{Output, note};
use crate::table;
use clap::Args;
use haptic_experiment::Failure;
use haptic_quantity::written;
use haptic_question::plant::keys::PlantForm;
use haptic_question::plant::{FoundReport, PlantData, PlantQuestion};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// Fit a fractional transfer function to a record or a frequency response
///
/// Fits coefficients, orders and dead time together, to a CSV record at any times, and where the plant was when it
/// began: at rest, settled at another input, or moving. Writes a plant file for the other commands of control.
///
/// Without --model it tries integer orders with up to four poles, one or two powers of s with free orders, and sums
/// of a resistance, arcs and a power, and chooses the simplest function whose BIC is close to the lowest. A sum in
/// --model stays one. Warnings say what the function does not explain, which numbers the record does not determine,
/// and whether dead time and a pole can be distinguished.
///
/// A table of frequencies with gain and phase, or real and imaginary parts, is fitted as such, its errors in
/// proportion to its size, and is tested by Kramers' and Kronig's relations.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli control identify record.csv --columns \
                  input=valve,output=temperature --out plant.toml"
)]
pub(crate) struct Arguments {
    /// CSV with a header
    #[arg(value_name = "DATA")]
    data: PathBuf,
    #[command(flatten)]
    asked: Options<keys::PlantRecord>,
    #[command(flatten)]
    file: File,
}

/// Number of samples above which the time is announced.
const LONG: usize = 200_000;
/// Approximate time for a sample on one core of 2024, s.
const A_SAMPLE_S: f64 = 6e-5;

/// The result, and where it was written.
#[derive(Serialize)]
struct Shown<'a> {
    #[serde(flatten)]
    report: FoundReport<'a>,
    plant_file: Option<String>,
    files: &'a [String],
}

impl Arguments {
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        let mut outputs = PlaceOfFile::look(&self.file, "plant")?;
        let form: PlantForm = self.asked.form()?;
        let question = PlantQuestion::of(&form)?;
        let read = |path: &Path| {
            let columns = question.columns.clone();
            table::read(path, columns, |columns, bytes| {
                question.data(columns, bytes)
            })
        };
        let record = read(&self.data)?;
        let other = Some(&*form.validate).filter(|path| !path.is_empty());
        let other = other.map(|path| read(path.as_ref())).transpose()?;
        let samples = match &record {
            PlantData::Record(record) => record.record.time_s.len(),
            PlantData::Response(_) => 0,
        };
        if samples > LONG && !output.quiet {
            let words = format!(
                "{samples} samples take about {}; every tenth may be enough for a slow plant",
                written("time_s", A_SAMPLE_S * samples as f64)
            );
            note("note", words);
        }
        let bar = progress_bar(0, output);
        let steps = |what, all: usize, done: usize| match done {
            0 => {
                bar.set_message(what);
                bar.set_length(all as u64);
                bar.set_position(0);
            }
            done => bar.inc(done as u64),
        };
        let answer = question.found(record, other, &AtomicBool::new(false), &steps);
        bar.finish_and_clear();
        let answer = answer?;
        let name = self.data.file_name().unwrap_or(self.data.as_os_str());
        let name = name.to_string_lossy();
        let text = || answer.to_toml(PROGRAM, &name);
        let (plant_file, figure) = outputs.write(text, || draw_identified(&answer, &name));
        for warning in answer.warnings() {
            output.warn(warning);
        }
        output.report(&Shown {
            report: answer.report(),
            plant_file,
            files: figure.as_slice(),
        })?;
        outputs.close(Ok(()))
    }
}
