//! A step, or any record, through a loop or a plant alone.

use super::{COMMAND_LIMITS, ControlLoop, LOOP_CONTROLLER, REFERENCE, RUN_LENGTH, STEP_HEIGHT};
use crate::controller::{check_step, samples};
use crate::words::shape;
use control_tuning::integer_baseline;
use fracdiff::Seconds;
use fracdiff::parameter::Shown;
use fractional_control::run::{LoopRun, run, run_plant, samples_for};
use fractional_control::{ControlError, ControllerSetup, Response};
use haptic_document::parameters::range::{DURATIONS, NUMBERS, SAMPLE_TIMES};
use haptic_document::{Failure, short};
use haptic_quantity::digits;
use haptic_trial::advice::{in_degrees, refused};
use measured_table::read_record;
use serde_json::{Value, json};

/// Samples of a plant alone, if no sample time is given.
const SAMPLES_ALONE: f64 = 2000.0;

fn unusable(values: &[f64]) -> Option<usize> {
    values.iter().position(|value| !NUMBERS.contains(*value))
}

/// A reference that was recorded: at each time the value that was last given.
#[derive(Clone, Debug)]
pub struct Reference {
    time_s: Vec<f64>,
    value: Vec<f64>,
}

impl Reference {
    /// The columns of its table.
    pub const COLUMNS: [&'static str; 2] = ["time_s", "reference"];

    /// The reference in a table with columns of these names.
    ///
    /// # Errors
    /// A mistake in it, with line and column.
    pub fn read(columns: &[String; 2], bytes: &[u8]) -> Result<Self, String> {
        let remedy = format!("give {REFERENCE} a file with both");
        let found = read_record(bytes, columns.each_ref().map(String::as_str))
            .map_err(|error| format!("{}; {remedy}", short(&error.to_string())))?;
        if let Some(rows) = found.gaps() {
            return Err(format!(
                "{rows} without a reference: give one in every row, or delete the row"
            ));
        }
        let (lines, [time_s, value]) = (found.lines, found.columns);
        if time_s.is_empty() {
            return Err(format!("no column time_s; {remedy}"));
        }
        if let Some(row) = time_s.windows(2).position(|pair| pair[1] <= pair[0]) {
            let line = lines[row + 1];
            return Err(format!(
                "line {line}: the time does not increase: sort the rows"
            ));
        }
        match unusable(&value) {
            None => Ok(Self { time_s, value }),
            Some(row) => Err(format!(
                "line {}: {} in column reference is not {NUMBERS}: give the column in another unit",
                lines[row],
                Shown(value[row])
            )),
        }
    }

    /// The reference with a value for each sample, from 0 s.
    ///
    /// # Errors
    /// No value; one outside −1e12 to 1e12.
    pub fn sampled(value: Vec<f64>, sample_time_s: f64) -> Result<Self, String> {
        if value.is_empty() {
            return Err("no value: give one for each sample".to_owned());
        }
        if let Some(n) = unusable(&value) {
            let given = Shown(value[n]);
            return Err(format!("{given} of sample {n} is not {NUMBERS}"));
        }
        let time_s = (0..value.len()).map(|n| n as f64 * sample_time_s).collect();
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

/// A run of a loop, or of a plant alone.
#[derive(Clone, Debug)]
pub struct Simulated {
    /// Time from one sample of the responses to the next, s.
    pub sample_time_s: f64,
    /// Reference, output and command of the loop as it was given.
    pub response: Response,
    /// Response with the integer-order PID of the same crossover and phase margin.
    pub integer: Option<Response>,
    /// Everything but the signals, with warnings. The keys are a contract of the command line.
    pub report: Value,
    away: Option<String>,
}

impl Simulated {
    /// Refuses an output that does not end at its reference.
    ///
    /// # Errors
    /// As said, with the reason and the remedy.
    pub fn judge(&self) -> Result<(), Failure> {
        self.away
            .as_ref()
            .map_or(Ok(()), |away| Err(Failure::run(away)))
    }

    /// The report, with that refusal among its warnings.
    #[must_use]
    pub fn judged(&self) -> Value {
        let mut report = self.report.clone();
        if let Value::Array(warnings) = &mut report["warnings"] {
            warnings.extend(self.away.iter().map(|away| json!(away)));
        }
        report
    }
}

/// An output that is not where it was asked to be, and what would bring it there.
fn away(run: &LoopRun) -> String {
    let Response {
        measured,
        reference,
        ..
    } = &run.response;
    let [output, reference] =
        [measured, reference].map(|samples| digits(samples.last().copied().unwrap_or(f64::NAN), 4));
    let why = match (run.verdict.stable, run.settles, run.limited_share) {
        _ if run.coarse.is_some() => {
            "the loop is too fast for the sampled model; see control analyze".to_owned()
        }
        (false, ..) => "the loop is unstable; see control analyze".to_owned(),
        (true, Some(true), _) => {
            "the loop rests beside it; give the controller an integral, or more gain".to_owned()
        }
        (true, _, share) if share > 0.0 => format!(
            "with the command at a limit in a share of {} of the samples; widen {COMMAND_LIMITS}, or give a longer {RUN_LENGTH}",
            digits(share, 4)
        ),
        (true, ..) => format!("give a longer {RUN_LENGTH}, or see control analyze"),
    };
    format!("the output ends at {output}, not at its reference {reference}: {why}")
}

impl ControlLoop {
    /// The sample time of a run.
    fn sample_time_s(&self) -> Result<f64, Failure> {
        let setup = self.controller.as_ref();
        let given = setup.map(|setup| setup.sample_time_s);
        if let Some(sample_time_s) = given.or(self.form.sample_time_s) {
            return Ok(sample_time_s);
        }
        let Some(duration_s) = self.form.duration_s else {
            return Err(Failure::bad_input(format_args!(
                "a plant alone has no crossover: give {RUN_LENGTH}, as in 20s, or {LOOP_CONTROLLER}"
            )));
        };
        let sample_time_s = duration_s / SAMPLES_ALONE;
        if SAMPLE_TIMES.contains(sample_time_s) {
            return Ok(sample_time_s);
        }
        let [low, high] = DURATIONS.ends();
        let shortest = SAMPLE_TIMES.ends()[0] * SAMPLES_ALONE;
        Err(Failure::bad_input(format_args!(
            "duration {} s is not from {} to {} s, shown in {SAMPLES_ALONE} samples: change {RUN_LENGTH}",
            Shown(duration_s),
            digits(shortest.max(low), 4),
            Shown(high)
        )))
    }

    /// The crossover of the loop, rad/s.
    fn crossover(&self) -> Option<f64> {
        let setup = self.controller.as_ref()?;
        let sampled = setup.sampled(&self.plant.plant).ok()?;
        let margins = setup.closed_with(&sampled).ok()?.margins();
        margins.phase.map(|phase| phase.omega_rad_s)
    }

    /// The reference, one value a sample.
    fn signal(&self, reference: Option<&Reference>, t: f64) -> Result<Vec<f64>, Failure> {
        let samples = samples(self.form.duration_s, t, || match reference {
            Some(reference) => (reference.length_s() / t).floor() + 1.0,
            None => samples_for(self.crossover(), t),
        })?;
        let height = self.form.step.unwrap_or(1.0);
        let at = |n| reference.map_or(height, |reference| reference.at(n as f64 * t));
        Ok((0..samples).map(at).collect())
    }

    /// The integer-order PID with the same crossover and phase margin, and its run; says so if that PID does not exist.
    fn baseline(
        &self,
        setup: &ControllerSetup,
        run: &dyn Fn(&ControllerSetup) -> Result<LoopRun, Failure>,
        warnings: &mut Vec<String>,
    ) -> Result<Option<(String, LoopRun)>, Failure> {
        let why = match integer_baseline(setup, &self.plant.plant) {
            Ok(None) => return Ok(None),
            Ok(Some(other)) => return Ok(Some((other.law.to_string(), run(&other)?))),
            // Its wishes are those of this loop, not of the user.
            Err(ControlError::Range(range)) => range.to_string(),
            Err(error) => in_degrees(&error),
        };
        warnings.push(format!("no integer-order PID to compare with: {why}"));
        Ok(None)
    }

    /// Runs a step, or this reference, from rest.
    ///
    /// # Errors
    /// A plant that does not run, a step of no height, too many samples.
    pub fn simulated(&self, reference: Option<&Reference>) -> Result<Simulated, Failure> {
        if self.form.step.is_some() && reference.is_some() {
            return Err(Failure::bad_input(format_args!(
                "{STEP_HEIGHT} and {REFERENCE} exclude each other: omit one"
            )));
        }
        let height = self.form.step.unwrap_or(1.0);
        check_step(height)?;
        let (plant, setup) = (&self.plant.plant, self.controller.as_ref());
        let t = self.sample_time_s()?;
        let signal = self.signal(reference, t)?;
        let step = reference.is_none().then_some(height);
        let run = |setup: &_| run(setup, plant, &signal, step).map_err(refused);
        let closed = setup.map(run).transpose()?;
        let mut warnings = self.warnings.clone();
        let integer = setup.map(|setup| self.baseline(setup, &run, &mut warnings));
        let integer = integer.transpose()?.flatten();
        let response = match &closed {
            Some(closed) => closed.response.clone(),
            None => run_plant(plant, Seconds(t), &signal).map_err(refused)?,
        };
        let closed = closed.as_ref();
        // Null where nothing is proved, as in an analysis.
        let stable = match closed {
            Some(run) => run.coarse.is_none().then_some(run.verdict.stable),
            None => Some(plant.stable_by_itself().is_ok()),
        };
        warnings.extend(
            match (closed, stable) {
                (_, Some(true)) => None,
                (None, _) => {
                    Some("the plant does not come to rest: its output goes on as long as the run")
                }
                (Some(_), Some(false)) => Some("the loop is unstable: see control analyze"),
                (Some(_), None) => {
                    Some("the loop is too fast for the sampled model: see control analyze")
                }
            }
            .map(str::to_owned),
        );
        let shape = |run: &LoopRun| run.shape.as_ref().map(|found| shape(found, t));
        let report = json!({
            "plant": self.plant.words,
            "controller": setup.map(|setup| setup.law.to_string()),
            "sample_time_s": t,
            "scheme": setup.map(|setup| setup.scheme.to_string()),
            "stable": stable,
            "shape": closed.and_then(shape),
            "limited_share": closed.map_or(0.0, |run| run.limited_share),
            "output_at_end": response.measured.last(),
            "at_reference": closed.and_then(|run| run.at_reference),
            "integer": integer.as_ref().map(|(controller, run)| json!({
                "controller": controller,
                "shape": shape(run),
                "limited_share": run.limited_share,
            })),
            "warnings": warnings,
        });
        let away = closed.filter(|run| run.at_reference == Some(false));
        Ok(Simulated {
            sample_time_s: t,
            away: away.map(self::away),
            response,
            integer: integer.map(|(_, run)| run.response),
            report,
        })
    }
}
