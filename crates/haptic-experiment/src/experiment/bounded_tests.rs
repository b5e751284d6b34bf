//! A run that is kept in memory and the same run read again from its log are judged alike.

use crate::{
    experiment::{coupler::CouplerExperiment, indentation::Indentation, wall::WallExperiment},
    open::ExperimentFile,
};
use haptic_document::Failure;
use haptic_judge::modelled_tissue::ModelledTissue;
use haptic_run::{Ran, Supervisor, Watched, folder::FolderRequest};
use serde_json::Value;
use std::{collections::BTreeMap, path::Path, sync::Arc};
use testkit::Folder;

/// Weights of the operator that stands for the full history are right to 1e-9; sums of them, of one sign
/// or nearly, are as good.
const TOLERANCE: f64 = 3e-9;

/// Conducts a run whose files are `run.*` in this folder.
pub(super) fn conducted<T>(folder: &Path, run: impl FnOnce(Watched<'_>) -> T) -> T {
    let request = FolderRequest {
        out: Some(folder.to_owned()),
        stem: "run".to_owned(),
        overwrite: true,
        roll_bytes: None,
        provenance: BTreeMap::new(),
    };
    let supervisor = Supervisor {
        stop: &Arc::default(),
        progress: &|_| (),
        live: None,
        warn: &|_| {},
    };
    let request = &request;
    run(Watched {
        request,
        supervisor,
    })
}

/// A relaxation of this tissue with the defaults of the parameters.
pub(crate) fn defaults(material: ModelledTissue) -> Indentation {
    let file = ExperimentFile::parse(Path::new("lab.toml"), "[relax]").expect("defaults");
    let mut relaxation = file.indentation().expect("one").clone();
    relaxation.piece.material = Box::new(material);
    relaxation
}

/// Runs what `text` describes, and reports twice: from memory, then from the log. With each the CSV.
fn twice(text: &str) -> [(Value, Vec<Vec<f64>>); 2] {
    let folder = Folder::empty();
    let experiment = ExperimentFile::parse(Path::new("lab.toml"), text).expect("is right");
    let (wall, coupler) = (
        experiment.of::<WallExperiment>(),
        experiment.of::<CouplerExperiment>(),
    );
    let report = |ran: &Ran| -> Result<Value, Failure> {
        let (report, _) = match (experiment.indentation(), wall, coupler) {
            (Some(pressed), ..) => pressed.report(ran)?,
            (_, Some(wall), _) => wall.report(ran)?,
            (.., coupler) => coupler.expect("what is judged after it ran").report(ran)?,
        };
        Ok(serde_json::to_value(report).expect("is JSON"))
    };
    let ran = conducted(&folder, |watched| {
        match (experiment.indentation(), wall, coupler) {
            (Some(pressed), ..) => pressed.record(watched),
            (_, Some(wall), _) => wall.recorded(watched),
            (.., coupler) => (coupler.expect("one of them")).recorded(watched),
        }
    });
    let mut ran = ran.expect("runs");
    let table = || {
        let mut rows = csv::Reader::from_path(folder.join("run.csv")).expect("is there");
        // A cell without a number is an error without meaning.
        let number = |cell: Option<f64>| cell.unwrap_or(f64::NAN);
        let rows = rows.deserialize::<Vec<Option<f64>>>();
        rows.map(|row| Ok(row?.into_iter().map(number).collect()))
            .collect::<Result<Vec<_>, csv::Error>>()
            .expect("numbers")
    };
    let whole = (report(&ran).expect("reports"), table());
    ran.record.whole = None;
    [whole, (report(&ran).expect("reports"), table())]
}

/// `key` differs by no more than the reference may be off; both are numbers.
fn close(reports: [&Value; 2], key: &str) {
    let [a, b] = reports.map(|report| report[key].as_f64().expect(key));
    assert!((a - b).abs() <= TOLERANCE, "{key}: {a:e} {b:e}");
}

/// The rows but for this column are the same, and in it close to the largest value.
fn rows_agree(tables: [&[Vec<f64>]; 2], history: Option<usize>) {
    let [a, b] = tables;
    assert_eq!(a.len(), b.len());
    let largest = history.map_or(0.0, |column| {
        (a.iter()).fold(0.0, |most: f64, row| most.max(row[column].abs()))
    });
    for (a, b) in a.iter().zip(b) {
        for (column, (a, b)) in a.iter().zip(b).enumerate() {
            let same = a.to_bits() == b.to_bits();
            let near = history == Some(column) && (a - b).abs() <= TOLERANCE * largest;
            assert!(same || near, "column {column}: {a:e} {b:e}");
        }
    }
}

/// The exact sums say nothing of a tolerance, the operator says its own.
fn say_what_they_compare_with(reports: [&Value; 2]) {
    let [whole, logged] = reports.map(|report| &report["reference_tolerance"]);
    assert_eq!((whole, logged), (&Value::Null, &Value::from(1e-9)));
}

const ERRORS: [&str; 3] = ["max_relative_error", "discretisation_error", "rig_error"];

/// The rows are the same but for a column, these numbers near, and these others the same. The report.
fn alike(text: &str, history: Option<usize>, near: &[&str], same: &[&str]) -> Value {
    let [(whole, rows), (logged, again)] = twice(text);
    rows_agree([&rows, &again], history);
    let reports = [&whole, &logged];
    near.iter().for_each(|key| close(reports, key));
    for key in same {
        assert_eq!(whole[key], logged[key], "{key}");
    }
    say_what_they_compare_with(reports);
    whole
}

#[test]
fn relaxation_and_creep_are_judged_alike() {
    let same = ["closed_form_error", "final_over_theory", "peak_force_n"];
    for options in [
        "",
        "scheme = \"grunwald:100\"",
        "encoder_resolution_m = 1e-6",
        "scheme = \"full-bdf2\"",
    ] {
        let text = format!("[relax]\nduration_s = 4\nramp_time_s = 0.5\n{options}");
        let whole = alike(&text, Some(4), &ERRORS, &same);
        if options.contains("bdf2") {
            // Its own weights, not those of backward differences, which are 1e-3 away.
            let error = whole["max_relative_error"].as_f64().expect("a number");
            assert!(error < 1e-5, "{error:e}");
        }
    }
    alike("[creep]\nduration_s = 4", Some(4), &ERRORS, &same[..1]);
}

#[test]
fn walls_and_couplers_are_judged_alike() {
    let device = "mass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 0.002\n";
    let same = [
        "position_std_m",
        "deflection_m",
        "stable",
        "object_position_m",
    ];
    let text = format!(
        "[wall]\n{device}order = 0.5\nstiffness_n_per_m = 1000\ndissipation_n_s_mu_per_m = 20\n"
    );
    alike(&text, None, &ERRORS[..1], &same[..3]);
    for order in [0.5, 1.0] {
        let text = format!(
            "[coupler]\n{device}order = {order}\n\
             coupler_damping_n_s_per_m = 1\ncoupler_spring_n_s_1_minus_mu_per_m = 200\n"
        );
        let whole = alike(&text, None, &ERRORS[..1], &same);
        // Nothing was compared with itself.
        let error = whole["max_relative_error"].as_f64().expect("a number");
        assert!(error > 0.0 && error < 1e-5, "order {order}: {error:e}");
    }
}
