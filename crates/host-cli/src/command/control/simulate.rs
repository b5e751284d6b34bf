//! `control simulate`: a step, or any record, through a loop or a plant alone.

use super::draw::draw_run;
use super::loops::{ControllerArguments, NamedPlant, PlantArguments, check_step, samples};
use super::words::{refused, shape};
use crate::files::{Files, Place};
use crate::output::{Output, warn};
use crate::parse::quantity;
use crate::table;
use clap::Args;
use fracdiff::Seconds;
use fracdiff::parameter::Shown;
use fractional_control::run::{LoopRun, integer_baseline, run, run_plant, samples_for};
use fractional_control::{ControlError, ControllerSetup, Response};
use haptic_experiment::control::in_degrees;
use haptic_experiment::{Failure, parameters};
use haptic_quantity::digits;
use serde::Serialize;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// An output that is not where it was asked to be.
fn away(report: &Value) -> Failure {
    let last = report["step"].as_array().and_then(|rows| rows.last());
    let shown = |value: &Value| {
        value
            .as_f64()
            .map_or_else(|| "NaN".to_owned(), |own| digits(own, 4))
    };
    let of_last = |key| last.map_or_else(String::new, |row| shown(&row[key]));
    Failure::Run(anyhow::anyhow!(
        "the output ends at {}, not at its reference {}, with the command at a limit in a share of {} of the samples: widen \
         --output-limits, give a longer --duration, or see host-cli control analyze",
        of_last("output"),
        of_last("reference"),
        shown(&report["limited_share"])
    ))
}

/// The integer-order PID with the same crossover and phase margin, and its run; said if there is none.
fn baseline(
    file: &ControllerSetup,
    plant: &NamedPlant,
    reference: &[f64],
    step: Option<f64>,
) -> Result<Option<(ControllerSetup, LoopRun)>, Failure> {
    let error = match integer_baseline(file, &plant.plant) {
        Ok(None) => return Ok(None),
        Ok(Some(baseline)) => {
            let run = run(&baseline, &plant.plant, reference, step).map_err(refused)?;
            return Ok(Some((baseline, run)));
        }
        Err(error) => error,
    };
    let why = if let ControlError::Range(range) = error {
        // Its wishes are those of this loop, not of the user.
        range.to_string()
    } else {
        in_degrees(&error)
    };
    warn(&format!("no integer-order PID to compare with: {why}"));
    Ok(None)
}

/// Samples of a plant alone, if no sample time is given.
const SAMPLES_ALONE: f64 = 2000.0;

/// The sample time of a plant that runs alone for so long.
fn sample_time_of(duration_s: f64) -> Result<f64, Failure> {
    let sample_time_s = duration_s / SAMPLES_ALONE;
    if parameters::SAMPLE_TIME.range().contains(sample_time_s) {
        return Ok(sample_time_s);
    }
    let [low, high] = parameters::TRIAL_DURATION.range().ends();
    let shortest = parameters::SAMPLE_TIME.range().ends()[0] * SAMPLES_ALONE;
    Err(Failure::bad_input(format_args!(
        "duration {} s is not from {} to {} s, shown in {SAMPLES_ALONE} samples: change --duration",
        Shown(duration_s),
        digits(shortest.max(low), 4),
        Shown(high)
    )))
}

/// Run a step or a record through a loop, or a plant alone
///
/// The loop starts at rest and runs as on hardware: sampled, with a command held between samples,
/// dead time, limits and anti-windup. The reference is a step or a CSV column. A fractional
/// controller is compared with the integer-order PID of the same crossover and phase margin. Exit
/// code 1 if the output does not end at its reference, or is NaN.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli control simulate --plant '0.55exp(-s)/(62s+1)' --controller \
                  design/controller.toml --out run"
)]
pub(crate) struct Arguments {
    #[command(flatten)]
    plant: PlantArguments,
    #[command(flatten)]
    controller: ControllerArguments,
    /// Length [default: 60 times 1/crossover]
    #[arg(long, value_name = "TIME", value_parser = quantity("_s", parameters::TRIAL_DURATION.range()))]
    duration: Option<f64>,
    /// Height of the step [default: 1]
    #[arg(long, value_parser = quantity("", parameters::OUTPUT_HIGH.range()))]
    step: Option<f64>,
    /// CSV with `time_s` and `reference`, instead of a step
    #[arg(long, value_name = "FILE.csv", conflicts_with = "step")]
    reference: Option<PathBuf>,
    #[command(flatten)]
    files: Files,
}

#[derive(Clone, Copy, Serialize)]
struct Row {
    time_s: f64,
    reference: f64,
    output: f64,
    command: f64,
}

fn rows(response: &Response, sample_time_s: f64) -> Vec<Row> {
    let samples = response.measured.iter().enumerate();
    samples
        .map(|(n, output)| Row {
            time_s: n as f64 * sample_time_s,
            reference: response.reference.get(n).copied().unwrap_or(f64::NAN),
            output: *output,
            command: response.command.get(n).copied().unwrap_or(f64::NAN),
        })
        .collect()
}

impl Arguments {
    pub(super) fn run(self, output: Output) -> Result<(), Failure> {
        let plant = self.plant.resolve()?;
        check_step(self.step.unwrap_or(1.0))?;
        let mut place = self.files.look("response", &[])?;
        let report = match self.controller.resolve()? {
            Some(file) => self.closed(&plant, &file, &mut place)?,
            None => self.open(&plant, &mut place)?,
        };
        match report["stable"].as_bool() {
            Some(true) => {}
            Some(false) => warn("the loop is unstable: see host-cli control analyze"),
            None => {
                warn("the loop is too fast for the sampled model: see host-cli control analyze");
            }
        }
        output.summary(&report)?;
        place.close(match report["at_reference"].as_bool() {
            Some(false) => Err(away(&report)),
            Some(true) | None => Ok(()),
        })
    }

    fn closed(
        &self,
        plant: &NamedPlant,
        file: &ControllerSetup,
        place: &mut Place,
    ) -> Result<Value, Failure> {
        let crossover = || {
            let sampled = file.sampled(&plant.plant).ok()?;
            let margins = file.closed_with(&sampled).ok()?.margins();
            margins.phase.map(|phase| phase.omega_rad_s)
        };
        let t = file.sample_time_s;
        let reference = self.signal(t, || samples_for(crossover(), t))?;
        let step = self.height();
        let own = run(file, &plant.plant, &reference, step).map_err(refused)?;
        let integer = baseline(file, plant, &reference, step)?;
        let beside = integer.as_ref().map(|(_, run)| &run.response);
        let rows = rows(&own.response, t);
        let files = place.table_and_picture(rows.iter(), || {
            draw_run(&own.response, beside, plant, Some(file), t)
        });
        let shape = |run: &LoopRun| run.shape.as_ref().map(|own| shape(own, t));
        Ok(json!({
            "plant": plant.words,
            "controller": file.law.to_string(),
            "sample_time_s": t,
            "scheme": file.scheme.to_string(),
            // Null where nothing is proved, as in `analyze`.
            "stable": own.coarse.is_none().then_some(own.verdict.stable),
            "shape": shape(&own),
            "limited_share": own.limited_share,
            "at_reference": own.at_reference,
            "integer": integer.as_ref().map(|(file, run)| json!({
                "controller": file.law.to_string(),
                "shape": shape(run),
                "limited_share": run.limited_share,
            })),
            "step": rows,
            "files": files,
        }))
    }

    fn open(&self, plant: &NamedPlant, place: &mut Place) -> Result<Value, Failure> {
        let t = match (self.controller.sample_time, self.duration) {
            (Some(t), _) => t,
            (None, Some(duration)) => sample_time_of(duration)?,
            (None, None) => {
                return Err(Failure::bad_input(
                    "a plant alone has no crossover: give --duration, as in 20s, or --controller",
                ));
            }
        };
        let reference = self.signal(t, || samples_for(None, t))?;
        let response = run_plant(&plant.plant, Seconds(t), &reference).map_err(refused)?;
        let rows = rows(&response, t);
        let files =
            place.table_and_picture(rows.iter(), || draw_run(&response, None, plant, None, t));
        Ok(json!({
            "plant": plant.words,
            "controller": null,
            "sample_time_s": t,
            "scheme": null,
            "stable": true,
            "shape": null,
            "limited_share": 0.0,
            "at_reference": null,
            "integer": null,
            "step": rows,
            "files": files,
        }))
    }

    /// Height of the step, if it is one.
    fn height(&self) -> Option<f64> {
        match self.reference {
            Some(_) => None,
            None => Some(self.step.unwrap_or(1.0)),
        }
    }

    /// The reference, one value a sample.
    fn signal(
        &self,
        sample_time_s: f64,
        or_else: impl FnOnce() -> f64,
    ) -> Result<Vec<f64>, Failure> {
        let record = self.reference.as_deref().map(Record::read).transpose()?;
        let samples = samples(self.duration, sample_time_s, || match &record {
            Some(record) => (record.length_s() / sample_time_s).floor() + 1.0,
            None => or_else(),
        })?;
        let times = (0..samples).map(|n| n as f64 * sample_time_s);
        Ok(match (&record, self.height()) {
            (Some(record), _) => times.map(|t| record.at(t)).collect(),
            (None, height) => times.map(|_| height.unwrap_or(1.0)).collect(),
        })
    }
}

struct Record {
    time_s: Vec<f64>,
    value: Vec<f64>,
}

impl Record {
    fn read(path: &Path) -> Result<Self, Failure> {
        let names = ["time_s", "reference"];
        let remedy = "give --reference a file with both";
        let found = table::record(path, names, remedy)?;
        if let Some(rows) = found.gaps() {
            let what =
                format!("{rows} without a reference: give one in every row, or delete the row");
            return Err(table::wrong(path, what));
        }
        let (lines, [time_s, value]) = (found.lines, found.columns);
        if let Some(row) = time_s.windows(2).position(|pair| pair[1] <= pair[0]) {
            let line = lines[row + 1];
            let what = format!("line {line}: the time does not increase: sort the rows");
            return Err(table::wrong(path, what));
        }
        let outside = |value: &f64| !parameters::OUTPUT_HIGH.range().contains(*value);
        if let Some(row) = value.iter().position(outside) {
            let what = format_args!(
                "line {}: {} in column reference is not {}: give the column in another unit",
                lines[row],
                Shown(value[row]),
                parameters::OUTPUT_HIGH.range()
            );
            return Err(table::wrong(path, what));
        }
        Ok(Self { time_s, value })
    }

    fn length_s(&self) -> f64 {
        let ends = self.time_s.first().zip(self.time_s.last());
        ends.map_or(0.0, |(first, last)| last - first)
    }

    /// The value that was last given, t seconds after the first row.
    fn at(&self, t: f64) -> f64 {
        let first = self.time_s.first().copied().unwrap_or(0.0);
        // A time of a row belongs to it, whatever its last digit is.
        let t = first + t + 1e-9 * t.abs();
        let after = self.time_s.partition_point(|time| *time <= t);
        self.value.get(after.max(1) - 1).copied().unwrap_or(0.0)
    }
}
