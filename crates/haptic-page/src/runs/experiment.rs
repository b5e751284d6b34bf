//! An experiment from a form: it becomes a document, so the same reader checks it.

use super::channels::Channels;
use super::form::{document, place, simulated};
use super::going::{Drawn, Finished, Work};
use haptic_experiment::judge::{Curves, Published};
use haptic_experiment::run::FolderRequest;
use haptic_experiment::{
    ExperimentFile, Failure, Pace, RealtimeOptions, Report, Summary, Supervisor, TrialReport,
};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::path::Path;

/// A form, to be run in the next free folder of the runs.
pub(super) fn work(
    (kind, parameters): (&str, &Map<String, Value>),
    realtime: Option<RealtimeOptions>,
    runs: &Path,
    provenance: &BTreeMap<String, String>,
) -> Result<Work, Failure> {
    let document = document(kind, parameters)?;
    let experiment = ExperimentFile::open(&document).map_err(Failure::input)?;
    simulated(experiment.remote())?;
    let experiment = experiment.in_pace(realtime.map_or(Pace::Virtual, Pace::Realtime));
    let samples = experiment.samples()?;
    let (mut axes, mut metadata) = (1, BTreeMap::new());
    if let ExperimentFile::Touch(touch) = &experiment {
        // A run refuses it too, but then the page has been told that it began.
        touch.check_start()?;
        (axes, metadata) = (touch.axes, touch.metadata());
    }
    let (mut request, name) = place(runs, kind, provenance)?;
    document
        .keep_in(&mut request.provenance)
        .map_err(Failure::input)?;
    metadata.extend(request.provenance.clone());
    Ok(Work {
        kind: kind.to_owned(),
        name,
        steps: samples,
        drawn: Some(Drawn {
            channels: Channels::of(axes),
            sample_time_s: sample_time_s(&experiment),
            metadata,
        }),
        run: Box::new(move |attendant| {
            let supervisor = Supervisor {
                stop: attendant.stop,
                progress: &attendant.progress,
                live: None,
                warn: attendant.warn,
            };
            run(&experiment, &request, supervisor.watched(attendant.live))
        }),
    })
}

fn run(
    experiment: &ExperimentFile,
    request: &FolderRequest,
    supervisor: Supervisor<'_>,
) -> Result<Finished, Failure> {
    let words = |verdict: &str| Some(verdict.to_owned());
    Ok(match experiment {
        ExperimentFile::Relax(relaxation) => {
            let published = relaxation.run(request, supervisor)?;
            let verdict = error_words(published.report.errors.closed_form.largest);
            result(&published, verdict, theory)
        }
        ExperimentFile::Creep(creep) => {
            let published = creep.run(request, supervisor)?;
            let verdict = error_words(published.report.errors.closed_form.largest);
            result(&published, verdict, theory)
        }
        ExperimentFile::Wall(wall) => {
            let published = wall.run(request, supervisor)?;
            let verdict = words(published.report.trial.settling.verdict.words());
            result(&published, verdict, |report, curves| {
                of_trial(&report.trial, curves)
            })
        }
        ExperimentFile::Coupler(coupler) => {
            let published = coupler.run(request, supervisor)?;
            let verdict = words(published.report.trial.settling.verdict.words());
            result(&published, verdict, |report, curves| {
                of_trial(&report.trial, curves)
            })
        }
        ExperimentFile::Teleoperation(far) => {
            let published = far.run(request, supervisor)?;
            let verdict = words(published.report.verdict.words());
            result(&published, verdict, |_, curves| {
                named(curves, &curves.subtitle)
            })
        }
        ExperimentFile::Touch(touch) => {
            let published = touch.run(request, supervisor)?;
            let verdict = words(published.report.verdict.words());
            // The log has all of it, in every axis.
            result(&published, verdict, |_: &_, _: &_| Value::Null)
        }
    })
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

fn result<R: Summary>(
    published: &Published<R>,
    verdict: Option<String>,
    curves: impl Fn(&R, &Curves) -> Value,
) -> Finished {
    let drawn = published.curves.as_ref();
    Finished {
        report: json!(published.report),
        curves: drawn.map_or(Value::Null, |drawn| curves(&published.report, drawn)),
        verdict,
        ended_early: published.report.run().ended_early.clone(),
    }
}

/// Curves by their names, under this title.
fn named(curves: &Curves, title: &str) -> Value {
    let mut named = json!({ "title": title, "time_s": curves.time_s });
    for (name, values) in &curves.columns {
        named[name] = json!(values);
    }
    named
}

fn theory(report: &Report, curves: &Curves) -> Value {
    let (quantity, label) = match report.final_strain {
        Some(_) => ("strain", "strain"),
        None => ("force", "force / N"),
    };
    let mut named = named(curves, &curves.title);
    named["quantity"] = quantity.into();
    named["label"] = label.into();
    named
}

fn of_trial(report: &TrialReport, curves: &Curves) -> Value {
    let mut named = named(curves, &curves.subtitle);
    named["expected_deflection_m"] = json!(report.settling.expected_deflection_m);
    named
}

#[cfg(test)]
mod tests {
    use super::*;

    fn form(value: Value) -> Map<String, Value> {
        value.as_object().expect("an object").clone()
    }

    fn job(kind: &str, form: &Map<String, Value>) -> Result<u64, Failure> {
        let provenance = BTreeMap::new();
        work((kind, form), None, Path::new("nowhere"), &provenance).map(|work| work.steps)
    }

    #[test]
    fn a_form_is_read_as_an_experiment_file_is() {
        let given =
            form(json!({"strain": 0.05, "duration_s": 2, "scheme": "grunwald:100", "guard": ""}));
        assert_eq!(job("relax", &given).expect("good"), 2001);
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
            ("touch", json!({"axes": 4}), "is not 2 or 3"),
            (
                "touch",
                json!({"centre_m": [0, 0, 0]}),
                "one for each of 2 axes",
            ),
            (
                "relax",
                json!({"device": "serial:/dev/null"}),
                "simulated device",
            ),
        ] {
            let error = job(kind, &form(given)).expect_err(want).to_string();
            assert!(error.contains(want) && !error.contains('\n'), "{error}");
            let closed = !error.contains("form") || error.contains("closed");
            assert!(closed, "{error}");
        }
    }
}
