//! `control simulate`: a step, or any record, through a loop or a plant alone.

use super::draw::draw_run;
use super::loops::{ControllerArguments, NamedPlant, PlantArguments};
use super::refused;
use crate::files::Files;
use crate::output::{Output, warn};
use crate::parse::quantity;
use crate::table;
use clap::Args;
use fracdiff::Seconds;
use fracdiff::parameter::Shown;
use fractional_control::run::{LoopRun, integer_baseline, run, run_plant, samples_for};
use fractional_control::{ControlError, ControllerSetup, Response};
use haptic_experiment::control::{in_degrees, shape};
use haptic_experiment::question::controller::{check_step, samples};
use haptic_experiment::{Failure, parameters};
use haptic_quantity::digits;
use serde::Serialize;
use serde_json::json;
use std::path::{Path, PathBuf};

/// An output that is not where it was asked to be, and what would bring it there.
fn away(last: Option<&Row>, run: &LoopRun) -> Failure {
    let [output, reference] = last
        .map_or([f64::NAN; 2], |row| [row.output, row.reference])
        .map(|value| digits(value, 4));
    let why = match (run.verdict.stable, run.settles, run.limited_share) {
        _ if run.coarse.is_some() => {
            "the loop is too fast for the sampled model; see host-cli control analyze".to_owned()
        }
        (false, ..) => "the loop is unstable; see host-cli control analyze".to_owned(),
        (true, Some(true), _) => {
            "the loop rests beside it; give the controller an integral, or more gain".to_owned()
        }
        (true, _, share) if share > 0.0 => format!(
            "with the command at a limit in a share of {} of the samples; widen --output-limits, or give a longer --duration",
            digits(share, 4)
        ),
        (true, ..) => "give a longer --duration, or see host-cli control analyze".to_owned(),
    };
    Failure::run(format_args!(
        "the output ends at {output}, not at its reference {reference}: {why}"
    ))
}

/// The integer-order PID with the same crossover and phase margin, and its run; warns if that PID does not exist.
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
        let mut outputs = self.files.look("response", &[])?;
        let file = self.controller.resolve()?;
        let file = file.as_ref();
        let t = file.map_or_else(|| self.sample_time_alone(), |file| Ok(file.sample_time_s))?;
        let crossover = || {
            let file = file?;
            let sampled = file.sampled(&plant.plant).ok()?;
            let margins = file.closed_with(&sampled).ok()?.margins();
            margins.phase.map(|phase| phase.omega_rad_s)
        };
        let reference = self.signal(t, || samples_for(crossover(), t))?;
        let step = self.height();
        let closed = file.map(|file| run(file, &plant.plant, &reference, step));
        let closed = closed.transpose().map_err(refused)?;
        let integer = file.map(|file| baseline(file, &plant, &reference, step));
        let integer = integer.transpose()?.flatten();
        let response = match &closed {
            Some(closed) => &closed.response,
            None => &run_plant(&plant.plant, Seconds(t), &reference).map_err(refused)?,
        };
        let beside = integer.as_ref().map(|(_, run)| &run.response);
        let rows = rows(response, t);
        let files = outputs.table_and_picture(&[], rows.iter(), || {
            draw_run(response, beside, &plant, file, t)
        });
        // Null where nothing is proved, as in `analyze`.
        let stable = closed.as_ref().map_or(Some(true), |run| {
            run.coarse.is_none().then_some(run.verdict.stable)
        });
        match stable {
            Some(true) => {}
            Some(false) => warn("the loop is unstable: see host-cli control analyze"),
            None => {
                warn("the loop is too fast for the sampled model: see host-cli control analyze");
            }
        }
        let shape = |run: &LoopRun| run.shape.as_ref().map(|found| shape(found, t));
        let closed = closed.as_ref();
        let limited_share = closed.map_or(0.0, |run| run.limited_share);
        output.report(&json!({
            "plant": plant.words,
            "controller": file.map(|file| file.law.to_string()),
            "sample_time_s": t,
            "scheme": file.map(|file| file.scheme.to_string()),
            "stable": stable,
            "shape": closed.and_then(shape),
            "limited_share": limited_share,
            "at_reference": closed.and_then(|run| run.at_reference),
            "integer": integer.as_ref().map(|(file, run)| json!({
                "controller": file.law.to_string(),
                "shape": shape(run),
                "limited_share": run.limited_share,
            })),
            "step": rows,
            "files": files,
        }))?;
        let away = closed.filter(|run| run.at_reference == Some(false));
        outputs.close(away.map_or(Ok(()), |run| Err(self::away(rows.last(), run))))
    }

    /// The sample time of a plant that runs alone.
    fn sample_time_alone(&self) -> Result<f64, Failure> {
        match (self.controller.sample_time, self.duration) {
            (Some(t), _) => Ok(t),
            (None, Some(duration)) => sample_time_of(duration),
            (None, None) => Err(Failure::bad_input(
                "a plant alone has no crossover: give --duration, as in 20s, or --controller",
            )),
        }
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
        if time_s.is_empty() {
            return Err(table::wrong(
                path,
                format_args!("no column time_s; {remedy}"),
            ));
        }
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
