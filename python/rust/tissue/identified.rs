//! Models from records.

use super::kind_of;
use super::model::PyModel;
use crate::arrays::{Array, complex_vector, vector};
use crate::conducted::{Interrupted, conduct};
use crate::json::{dict, from_python, to_python};
use crate::refused::{OrRefused as _, refused};
use haptic_loop::{INCOMPRESSIBLE, Specimen};
use haptic_question::tissue::{RecordForm, RecordQuestion};
use haptic_tissue::ModelKind;
use measured_table::Column;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use tissue_identification::{
    CANDIDATES, Identification, Record, RecordKind, TableDetails, identify_unless,
};

/// Columns of a record: t, y, strain, depth.
type Columns<'py> = (
    Bound<'py, PyAny>,
    Bound<'py, PyAny>,
    Option<Bound<'py, PyAny>>,
    Option<Bound<'py, PyAny>>,
);

/// A record of its kind from columns; strain, or depth of a specimen, only for any motion.
fn record(columns: &Columns<'_>, reading: &TableDetails) -> PyResult<Record> {
    let (t, y, strain, depth) = columns;
    let x = vector("t", t)?;
    let kind = reading.kind.unwrap_or(RecordKind::Relaxation);
    let is_motion = kind == RecordKind::History;
    if let Some(depth) = depth {
        if !is_motion || strain.is_some() {
            return Err(refused(
                "depth belongs to kind=\"record\" without strain: y is then the force in N",
            ));
        }
        let (depth, force) = (vector("depth", depth)?, vector("y", y)?);
        let ratio = reading.poisson_ratio.unwrap_or(INCOMPRESSIBLE);
        let specimen = Specimen::new(reading.loading, ratio, 0.0).or_refused()?;
        return Record::pressed_from(reading.contact, x, depth, force, &specimen).or_refused();
    }
    if strain.is_some() != is_motion {
        return Err(refused(if is_motion {
            "strain is missing: a record of any motion has time, strain and stress, or time, depth and force"
        } else {
            "strain belongs to kind=\"record\" only: divide the stress by a held strain yourself"
        }));
    }
    if reading.ramp_time_s.is_some() {
        return ramped(x, vector("y", y)?, reading);
    }
    match (kind, strain) {
        (RecordKind::Relaxation, _) => Record::relaxation(x, vector("y", y)?),
        (RecordKind::Creep, _) => Record::creep(x, vector("y", y)?),
        (RecordKind::History, Some(strain)) => {
            Record::history(x, vector("strain", strain)?, vector("y", y)?)
        }
        (RecordKind::Oscillation | RecordKind::History, _) => {
            let moduli = complex_vector("y", y)?;
            let (storage, loss) = moduli.iter().map(|m| (m.re, m.im)).unzip();
            Record::oscillation(x, storage, loss)
        }
    }
    .or_refused()
}

/// A relaxation that begins with the ramp to its strain.
fn ramped(time_s: Vec<f64>, modulus_pa: Vec<f64>, reading: &TableDetails) -> PyResult<Record> {
    if reading
        .kind
        .is_some_and(|kind| kind != RecordKind::Relaxation)
    {
        return Err(refused("ramp_time_s belongs to kind=\"relaxation\" only"));
    }
    let columns = measured_table::Columns {
        values: vec![
            (Column::Time, "t".to_owned(), time_s),
            (Column::Modulus, "y".to_owned(), modulus_pa),
        ],
        ..measured_table::Columns::default()
    };
    Ok(reading.record(columns).or_refused()?.record)
}

/// Models fitted to records, as dictionaries: these models, or all, and options by the keys of a form.
#[pyfunction]
pub(crate) fn identify_record<'py>(
    py: Python<'py>,
    records: Vec<Columns<'py>>,
    models: Option<Vec<String>>,
    form: &Bound<'py, PyAny>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let form: RecordForm = from_python("options", form)?;
    let RecordQuestion {
        reading,
        mut options,
        ..
    } = RecordQuestion::of(&form).or_refused()?;
    let models = models.map(|names| names.iter().map(|name| kind_of(name)).collect());
    let models: Option<PyResult<Vec<ModelKind>>> = models;
    options.candidates = models.unwrap_or_else(|| Ok(CANDIDATES.to_vec()))?;
    let records = records.iter().map(|columns| record(columns, &reading));
    let record = Record::together(records.collect::<PyResult<_>>()?).or_refused()?;
    let found = conduct(py, progress, Interrupted::Forgotten, move |conduct| {
        let done = |records| conduct.add(records as u64);
        identify_unless(&record, &options, conduct.stop(), &done).or_refused()
    })?;
    report(py, &found)
}

/// Models fitted to tables, as the command reads them: names with bytes, and options by their keys.
#[pyfunction]
pub(crate) fn identify_tables<'py>(
    py: Python<'py>,
    tables: Vec<(String, Vec<u8>)>,
    options: &Bound<'py, PyAny>,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let form: RecordForm = from_python("options", options)?;
    let question = RecordQuestion::of(&form).or_refused()?;
    question.check(tables.len()).or_refused()?;
    let (mut all, mut names) = (Vec::new(), Vec::new());
    for (file, (name, bytes)) in tables.iter().enumerate() {
        let read = question.read(file, question.reader.clone(), bytes);
        let read = read.map_err(|error| refused(format_args!("{name}: {error}")))?;
        names.extend(read.iter().map(|_| name.clone()));
        all.extend(read);
    }
    let answer = conduct(py, progress, Interrupted::Forgotten, move |conduct| {
        let done = |records| conduct.add(records as u64);
        question
            .answer(all, &names, conduct.stop(), &done)
            .or_refused()
    })?;
    let report = report(py, &answer.found)?;
    report.set_item("notes", &answer.understood.notes)?;
    report.set_item("several", to_python(py, &answer.rows)?)?;
    Ok(report)
}

/// Explains a table: its columns, its segments, and the records that they make.
#[pyfunction]
pub(crate) fn explain_table<'py>(
    py: Python<'py>,
    bytes: Vec<u8>,
    options: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let form: RecordForm = from_python("options", options)?;
    let question = RecordQuestion::of(&form).or_refused()?;
    let rows = question.explained(0, &question.reader, &bytes);
    to_python(py, &rows.or_refused()?)
}

fn report<'py>(py: Python<'py>, found: &Identification) -> PyResult<Bound<'py, PyDict>> {
    let fits = found.fits.iter().map(|fit| {
        let model = fit.to_model().ok().map(PyModel);
        Ok(dict! {py;
            "kind": fit.kind.name(),
            "model": model.map(|model| Py::new(py, model)).transpose()?,
            "estimates": to_python(py, &fit.parameters)?,
            "correlation": fit.correlation.clone(),
            "rms": fit.rms,
            "aic": fit.aic,
            "bic": fit.bic,
            "predicted": Array::of(fit.predicted.to_vec()),
            "is_settled": fit.is_settled(),
        })
    });
    Ok(dict! {py;
        "kind": found.kind.name(),
        "x": Array::of(found.x.to_vec()),
        "measured": Array::of(found.measured.to_vec()),
        "warnings": &found.warnings,
        "beside": to_python(py, &found.placement)?,
        "fits": fits.collect::<PyResult<Vec<_>>>()?,
    })
}
