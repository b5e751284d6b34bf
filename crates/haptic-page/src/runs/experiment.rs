//! An experiment from a form: it becomes a document, so the same reader checks it.

use super::form::{document, simulated};
use super::going::{Drawn, Finished, Work};
use crate::folder::next_folder;
use haptic_answer::channels::Channels;
use haptic_experiment::DocumentOfKind as _;
use haptic_experiment::{ExperimentFile, Failure};
use haptic_judge::curves::{Curves, Drawing};
use haptic_run::FolderRequest;
use haptic_run::{Pace, RealtimeOptions, Supervisor};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::path::Path;

/// A form, to be run in the next free folder of the runs.
pub(super) fn work(
    kind: &str,
    parameters: &Map<String, Value>,
    realtime: Option<RealtimeOptions>,
    runs: &Path,
    provenance: &BTreeMap<String, String>,
) -> Result<Work, Failure> {
    let document = document(kind, parameters)?;
    let experiment = ExperimentFile::open(&document)?;
    simulated(experiment.is_simulated())?;
    let experiment = experiment.in_pace(realtime.map_or(Pace::Virtual, Pace::Realtime));
    let samples = experiment.samples()?;
    // A run refuses it too, but only after the page has announced its start.
    experiment.check_start()?;
    let (mut request, name) = next_folder(runs, kind, provenance)?;
    document.keep_in(&mut request.provenance)?;
    let mut metadata = request.provenance.clone();
    metadata.extend(experiment.metadata());
    Ok(Work {
        kind: kind.to_owned(),
        name,
        steps: samples,
        drawn: Some(Drawn {
            channels: Channels::of(experiment.axes()),
            sample_time_s: experiment.sample_time_s(),
            metadata,
        }),
        run: Box::new(move |attendant| {
            let supervisor = Supervisor {
                stop: attendant.stop,
                progress: &attendant.progress,
                live: Some(attendant.live),
                warn: attendant.warn,
            };
            run(&experiment, &request, supervisor)
        }),
    })
}

fn run(
    experiment: &ExperimentFile,
    request: &FolderRequest,
    supervisor: Supervisor<'_>,
) -> Result<Finished, Failure> {
    let published = experiment.run(request, supervisor)?;
    let report = &published.report;
    let drawn = published.curves.as_ref();
    Ok(Finished {
        report: json!(report),
        curves: drawn.map_or(Value::Null, shown),
        verdict: report.verdict.clone(),
        ended_early: report.run.ended_early.clone(),
    })
}

/// The part of a run that the page draws.
fn shown(curves: &Curves) -> Value {
    match &curves.drawing {
        Drawing::Theory(theory) => {
            let mut named = named(curves, &curves.title);
            named["quantity"] = json!(theory.quantity);
            named["label"] = json!(theory.label);
            if let Some(record) = &theory.record {
                named["record_time_s"] = json!(record.time_s);
                named["record"] = json!(record.values);
            }
            named
        }
        Drawing::Trial {
            expected_deflection_m,
        } => {
            let mut named = named(curves, &curves.subtitle);
            named["expected_deflection_m"] = json!(expected_deflection_m);
            named
        }
        Drawing::Pair { .. } | Drawing::Side | Drawing::Press => named(curves, &curves.subtitle),
        // The log has all of it, in every axis.
        Drawing::Plane { .. } => Value::Null,
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

#[cfg(test)]
mod tests {
    use super::*;

    fn form(value: Value) -> Map<String, Value> {
        value.as_object().expect("an object").clone()
    }

    fn job(kind: &str, form: &Map<String, Value>) -> Result<u64, Failure> {
        let provenance = BTreeMap::new();
        work(kind, form, None, Path::new("nowhere"), &provenance).map(|work| work.steps)
    }

    #[test]
    fn a_form_is_read_as_an_experiment_file_is() {
        let given =
            form(json!({"strain": 0.05, "duration_s": 2, "scheme": "grunwald:100", "guard": ""}));
        assert_eq!(job("relax", &given).expect("good"), 2001);
        let mut wall = form(
            json!({"tissue": "prostate-healthy", "mass_kg": 0.065, "damping_n_s_per_m": 3.5, "sample_time_s": 0.001,
                "order": 0.5, "stiffness_n_per_m": 3000, "dissipation_n_s_mu_per_m": 100}),
        );
        job("wall", &wall).expect("nobody changed what was suggested");
        wall["order"] = json!(0.7);
        assert!(job("wall", &wall).is_err());
    }

    #[test]
    fn a_form_is_refused_in_a_sentence_without_a_file() {
        for [kind, given, want] in testkit::table(
            r#"
            relax | {"strain": 5} | strain = 5 is not above 0 and at most 1
            relax | {"colour": 5} | colour
            relax | {"strain": [1, {}]} | strain
            wall | {} | missing key
            dance | {} | is not one of relax
            touch | {"axes": 4} | is not 2 or 3
            touch | {"centre_m": [0, 0, 0]} | one for each of 2 axes
            relax | {"device": "serial:/dev/null"} | simulated device
            "#,
        ) {
            let given = form(given.parse().expect("JSON"));
            let error = job(&kind, &given).expect_err(&want).to_string();
            assert!(error.contains(&want) && !error.contains('\n'), "{error}");
            let closed = !error.contains("form") || error.contains("closed");
            assert!(closed, "{error}");
        }
    }
}
