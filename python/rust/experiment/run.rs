//! Runs: experiments of every kind, and those of files.

use super::{Heard, document, failed, over, provenance};
use crate::arrays::Array;
use crate::conducted::{Conduct, Interrupted, conduct};
use crate::json::to_python;
use crate::refused::OrRefused as _;
use haptic_document::Document;
use haptic_experiment::DocumentOfKind as _;
use haptic_experiment::parameters::{Parameter, Value, of_kind};
use haptic_experiment::{ExperimentFile, Failure};
use haptic_log::live::{Live, LiveStreams};
use haptic_message::{EventMessage, TickMessage};
use haptic_run::FolderRequest;
use haptic_run::{Pace, RealtimeOptions, Supervisor, read_document};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Section, key, default (None without one), whether it has to be given, range and help of each parameter of a kind.
#[pyfunction]
pub(crate) fn experiment_parameters<'py>(
    py: Python<'py>,
    kind: &str,
) -> PyResult<Bound<'py, PyList>> {
    let list = PyList::empty(py);
    for (section, table) in of_kind(kind) {
        for parameter in table {
            let needed = section == "required";
            let range = match parameter.value {
                Value::Number(_, range) => range.to_string(),
                Value::List(range) => format!("a list of numbers {range}"),
                Value::Count(_) | Value::Flag(_) | Value::Text(_) => String::new(),
            };
            let (key, help) = (parameter.key, parameter.help);
            list.append((section, key, default(py, parameter)?, needed, range, help))?;
        }
    }
    Ok(list)
}

fn default<'py>(py: Python<'py>, parameter: &Parameter) -> PyResult<Bound<'py, PyAny>> {
    Ok(match parameter.value {
        Value::Number(Some(number), _) => number.into_pyobject(py)?.into_any(),
        Value::Count(count) => count.into_pyobject(py)?.into_any(),
        Value::Flag(flag) => flag.into_pyobject(py)?.to_owned().into_any(),
        Value::Text(text) => text.into_pyobject(py)?.into_any(),
        Value::Number(None, _) | Value::List(_) => py.None().into_bound(py),
    })
}

/// Tells that the log of a stopped run is closed.
#[derive(Debug)]
struct Closed {
    stop: Arc<AtomicBool>,
    kept: Arc<AtomicBool>,
}

impl Live for Closed {
    fn tick(&mut self, _: &TickMessage) {}

    fn event(&mut self, _: &EventMessage) {}

    fn finish(self: Box<Self>) -> Option<String> {
        // Of a run that is not stopped, the log gets its verdict too: whoever stops it from here on waits for that.
        if self.stop.load(Ordering::Relaxed) {
            self.kept.store(true, Ordering::Relaxed);
        }
        None
    }
}

struct Finished {
    report: serde_json::Value,
    warnings: Vec<String>,
}

/// Runs an experiment of a kind, or of a file or log, into a folder; its kind and report, and what a user should know.
#[pyfunction]
#[pyo3(signature = (kind, file, parameters, out, overwrite, force_unstable, progress))]
pub(crate) fn run_experiment<'py>(
    kind: &str,
    file: Option<PathBuf>,
    parameters: &Bound<'py, PyDict>,
    out: PathBuf,
    overwrite: bool,
    force_unstable: bool,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<(String, Bound<'py, PyAny>, Vec<String>)> {
    let py = parameters.py();
    let document = match file {
        Some(file) => {
            let document = read_document(&file).or_refused()?;
            let kind = document.kind().or_refused()?.to_owned();
            over(document, &kind, parameters)?
        }
        None => document(kind, parameters)?,
    };
    let kind = document.kind().or_refused()?.to_owned();
    let mut request = FolderRequest {
        out: Some(out),
        stem: kind.clone(),
        overwrite,
        roll_bytes: None,
        provenance: provenance(),
    };
    let finished = conduct(py, progress, Interrupted::Awaited, move |conduct| {
        let experiment = prepared(&document, force_unstable)?;
        document.keep_in(&mut request.provenance).or_refused()?;
        let drives = (!experiment.is_simulated()).then(|| conduct.drives());
        let _drives = drives.transpose()?;
        run(&experiment, &request, conduct).map_err(|failure| failed(&failure))
    })?;
    Ok((kind, to_python(py, &finished.report)?, finished.warnings))
}

/// The columns of a table that a run has written.
#[pyfunction]
pub(crate) fn table(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyDict>> {
    let read = py.detach(|| columns(&path));
    let arrays = PyDict::new(py);
    for (name, values) in read.map_err(|failure| failed(&failure))? {
        arrays.set_item(name, Array::of(values))?;
    }
    Ok(arrays)
}

/// The experiment, with the pace that its device asks for.
fn prepared(document: &Document, force_unstable: bool) -> PyResult<ExperimentFile> {
    let mut experiment = ExperimentFile::open(document).or_refused()?;
    if !experiment.is_simulated() {
        experiment = experiment.in_pace(Pace::Realtime(RealtimeOptions::default()));
    }
    if force_unstable {
        experiment = experiment.though_unstable().or_refused()?;
    }
    experiment.samples().or_refused()?;
    Ok(experiment)
}

fn run(
    experiment: &ExperimentFile,
    request: &FolderRequest,
    conduct: &Conduct,
) -> Result<Finished, Failure> {
    let heard = Heard::default();
    let warn = |text: &str| heard.hear(text);
    // A device is to be let go too. Of what is simulated only the log is kept: report and table of an interrupted run are not seen.
    let closed = experiment.is_simulated().then(|| {
        let [stop, kept] = conduct.stop_and_kept();
        LiveStreams::new(vec![Box::new(Closed { stop, kept })])
    });
    let supervisor = Supervisor {
        stop: conduct.stop(),
        progress: &|done| conduct.set(done),
        live: closed.as_ref(),
        warn: &warn,
    };
    let run = experiment.run_for(request, supervisor, || conduct.is_awaited())?;
    let report = run.report;
    if let Some(lost) = report.run.lost_table() {
        return Err(lost);
    }
    Ok(Finished {
        report: serde_json::to_value(&report).map_err(Failure::input)?,
        warnings: heard.all(),
    })
}

/// The columns of a table; NaN where a cell is empty.
fn columns(path: &Path) -> Result<Vec<(String, Vec<f64>)>, Failure> {
    let mut reader = csv::Reader::from_path(path).map_err(Failure::input)?;
    let headers = reader.headers().map_err(Failure::input)?.clone();
    let mut columns: Vec<(String, Vec<f64>)> = headers
        .iter()
        .map(|name| (name.to_owned(), Vec::new()))
        .collect();
    for row in reader.records() {
        let row = row.map_err(Failure::input)?;
        for ((_, values), cell) in columns.iter_mut().zip(&row) {
            values.push(cell.parse().unwrap_or(f64::NAN));
        }
    }
    Ok(columns)
}
