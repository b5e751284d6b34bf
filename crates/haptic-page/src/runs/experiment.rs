//! An experiment from a form: it becomes an experiment file, so the same reader checks it.

use super::forms::KINDS;
use haptic_experiment::curves::{CouplerCurves, Published, TheoryCurves, WallCurves};
use haptic_experiment::folder::{FolderRequest, next_free};
use haptic_experiment::teleoperation::TeleoperationCurves;
use haptic_experiment::{ExperimentFile, Failure, Pace, RealtimeOptions, Supervisor};
use serde::Serialize;
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Name of the file in the messages of its reader.
const FILE: &str = "form";

/// Reads a form.
///
/// # Errors
/// What the reader of experiment files refuses, and a serial device.
pub(super) fn parse(
    kind: &str,
    parameters: &Map<String, Value>,
) -> Result<ExperimentFile, Failure> {
    if !KINDS.contains(&kind) {
        return Err(Failure::bad_input(format_args!(
            "experiment {kind:?} is none of {}",
            KINDS.join(", ")
        )));
    }
    let mut table = toml::Table::new();
    // Null and an empty field of a form are the default.
    let given = parameters
        .iter()
        .filter(|(_, value)| !value.is_null() && **value != "");
    for (key, value) in given {
        let value = toml::Value::try_from(value).map_err(|_| {
            Failure::bad_input(format_args!(
                "`{key}` is not a number, a text, or true or false"
            ))
        })?;
        table.insert(key.clone(), value);
    }
    let document = toml::Table::from_iter([(kind.to_owned(), toml::Value::Table(table))]);
    let text = toml::to_string(&document).map_err(Failure::input)?;
    let parsed = ExperimentFile::parse(Path::new(FILE), &text);
    let experiment =
        parsed.map_err(|error| Failure::bad_input(without_place(&error.to_string())))?;
    if experiment.remote().is_some() {
        return Err(Failure::bad_input(
            "the page runs experiments on the simulated device: for a serial one use the command line, as in \
             `run FILE.toml`; its log is shown here",
        ));
    }
    Ok(experiment)
}

/// The message without the file and line that nobody sees.
fn without_place(message: &str) -> &str {
    let after_line = message.strip_prefix(FILE).and_then(|rest| {
        let rest = rest
            .strip_prefix(':')?
            .trim_start_matches(|c: char| c.is_ascii_digit());
        Some(rest.trim_start_matches(':').trim_start())
    });
    after_line.unwrap_or(message)
}

/// An experiment with its place.
#[derive(Debug)]
pub(super) struct Job {
    kind: String,
    experiment: ExperimentFile,
    request: FolderRequest,
    name: String,
    samples: u64,
    sample_time_s: f64,
}

/// Results of a job.
pub(super) struct Finished {
    pub(super) report: Value,
    pub(super) curves: Value,
    pub(super) verdict: Option<String>,
    pub(super) ended_early: Option<String>,
}

impl Job {
    /// In the next free folder of the runs.
    ///
    /// # Errors
    /// Parameters that are refused; no free folder.
    pub(super) fn new(
        kind: &str,
        experiment: ExperimentFile,
        realtime: Option<RealtimeOptions>,
        runs: &Path,
        provenance: &BTreeMap<String, String>,
    ) -> Result<Self, Failure> {
        let experiment = experiment.in_pace(realtime.map_or(Pace::Virtual, Pace::Realtime));
        let samples = experiment.samples()?;
        let out: PathBuf = next_free(runs, kind).ok_or_else(|| {
            Failure::bad_input(format_args!(
                "`{}` holds {kind}-0001 to {kind}-9999: move some away",
                runs.display()
            ))
        })?;
        let folder = out.file_name().unwrap_or_default().to_string_lossy();
        Ok(Self {
            name: format!("{folder}/{kind}"),
            sample_time_s: sample_time_s(&experiment),
            request: FolderRequest {
                out: Some(out),
                stem: kind.to_owned(),
                overwrite: false,
                roll_bytes: None,
                provenance: provenance.clone(),
            },
            kind: kind.to_owned(),
            experiment,
            samples,
        })
    }

    pub(super) fn kind(&self) -> &str {
        &self.kind
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    pub(super) const fn samples(&self) -> u64 {
        self.samples
    }

    pub(super) const fn sample_time_s(&self) -> f64 {
        self.sample_time_s
    }

    /// Runs it.
    ///
    /// # Errors
    /// Those of the experiment.
    pub(super) fn run(&self, supervisor: Supervisor<'_>) -> Result<Finished, Failure> {
        let request = &self.request;
        Ok(match &self.experiment {
            ExperimentFile::Relax(relaxation) => {
                let published = relaxation.run(request, supervisor)?;
                let verdict = error_words(published.report.errors.closed_form_error);
                result(
                    &published,
                    verdict,
                    theory,
                    &published.report.run.ended_early,
                )
            }
            ExperimentFile::Creep(creep) => {
                let published = creep.run(request, supervisor)?;
                let verdict = error_words(published.report.errors.closed_form_error);
                result(
                    &published,
                    verdict,
                    theory,
                    &published.report.run.ended_early,
                )
            }
            ExperimentFile::Wall(wall) => {
                let published = wall.run(request, supervisor)?;
                let verdict = Some(published.report.trial.settling.verdict.words().to_owned());
                result(
                    &published,
                    verdict,
                    of_wall,
                    &published.report.trial.run.ended_early,
                )
            }
            ExperimentFile::Coupler(coupler) => {
                let published = coupler.run(request, supervisor)?;
                let verdict = Some(published.report.trial.settling.verdict.words().to_owned());
                result(
                    &published,
                    verdict,
                    of_coupler,
                    &published.report.trial.run.ended_early,
                )
            }
            ExperimentFile::Teleoperation(far) => {
                let published = far.run(request, supervisor)?;
                let verdict = Some(published.report.verdict.words().to_owned());
                result(
                    &published,
                    verdict,
                    of_teleoperation,
                    &published.report.run.ended_early,
                )
            }
            ExperimentFile::Touch(_) => {
                return Err(Failure::bad_input(
                    "the page has no form for a touch: run it from a file",
                ));
            }
        })
    }
}

fn sample_time_s(experiment: &ExperimentFile) -> f64 {
    match experiment {
        ExperimentFile::Relax(experiment) => experiment.rendering.sample_time_s,
        ExperimentFile::Creep(experiment) => experiment.rendering.sample_time_s,
        ExperimentFile::Wall(experiment) => experiment.setup.device.sample_time.0,
        ExperimentFile::Coupler(experiment) => experiment.setup.device.sample_time.0,
        ExperimentFile::Teleoperation(experiment) => experiment.sample_time().0,
        ExperimentFile::Touch(experiment) => experiment.sample_time().0,
    }
}

fn error_words(error: Option<f64>) -> Option<String> {
    error.map(|error| format!("{:.2} % from the closed form", 1e2 * error))
}

fn result<R: Serialize, C>(
    published: &Published<R, C>,
    verdict: Option<String>,
    curves: impl Fn(&C) -> Value,
    ended_early: &Option<String>,
) -> Finished {
    Finished {
        report: json!(published.report),
        curves: published.curves.as_ref().map_or(Value::Null, curves),
        verdict,
        ended_early: ended_early.clone(),
    }
}

fn theory(curves: &TheoryCurves) -> Value {
    json!({
        "title": curves.title,
        "quantity": curves.quantity.word(),
        "label": curves.quantity.label(),
        "time_s": curves.time_s,
        "values": curves.values,
        "closed_form": curves.closed_form,
        "relative_error": curves.relative_error,
    })
}

fn of_wall(curves: &WallCurves) -> Value {
    json!({
        "title": curves.subtitle,
        "time_s": curves.time_s,
        "position_m": curves.position_m,
        "force_n": curves.force_n,
        "expected_deflection_m": curves.expected_deflection_m,
    })
}

fn of_coupler(curves: &CouplerCurves) -> Value {
    json!({
        "title": curves.subtitle,
        "time_s": curves.time_s,
        "position_m": curves.position_m,
        "object_position_m": curves.object_position_m,
        "force_n": curves.force_n,
        "expected_deflection_m": curves.expected_deflection_m,
    })
}

fn of_teleoperation(curves: &TeleoperationCurves) -> Value {
    json!({
        "title": curves.subtitle,
        "time_s": curves.time_s,
        "position_m": curves.master_m,
        "far_position_m": curves.slave_m,
        "force_n": curves.master_n,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn form(value: Value) -> Map<String, Value> {
        value.as_object().expect("an object").clone()
    }

    #[test]
    fn a_form_is_read_as_an_experiment_file_is() {
        let given =
            form(json!({"strain": 0.05, "duration_s": 2, "scheme": "grunwald:100", "guard": ""}));
        let experiment = parse("relax", &given).expect("good");
        assert_eq!(experiment.samples().expect("good"), 2001);
    }

    #[test]
    fn a_form_is_refused_in_a_sentence_without_a_file() {
        for (kind, given, want) in [
            (
                "relax",
                json!({"strain": 5}),
                "strain = 5 is not above 0 and at most 1",
            ),
            ("relax", json!({"colour": 5}), "colour"),
            ("relax", json!({"strain": [1, {}]}), "strain"),
            ("wall", json!({}), "missing key"),
            ("dance", json!({}), "is none of relax"),
            (
                "relax",
                json!({"device": "serial:/dev/null"}),
                "simulated device",
            ),
        ] {
            let error = parse(kind, &form(given)).expect_err(want).to_string();
            assert!(error.contains(want), "{error}");
            assert!(!error.contains(FILE) || error.contains("closed"), "{error}");
            assert!(!error.contains('\n'), "{error}");
        }
    }
}
