//! Models from records.

use super::kind_of;
use super::model::PyModel;
use crate::arrays::{Whole, complex_vector, vector};
use crate::conducted::{Interrupted, conduct};
use crate::json::{from_python, to_python};
use crate::refused::{OrRefused as _, refused};
use haptic_experiment::question::tissue::{RecordForm, RecordQuestion, contact_point, held};
use haptic_loop::{Loading, LoadingKind, Specimen};
use haptic_tissue::identify::{
    self, Baseline, CANDIDATES, ContactPoint, Identification, Options, Record, Weighting, table,
};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

/// How a specimen is pressed, by the names of keys.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Pressed {
    loading: String,
    area_m2: Option<f64>,
    thickness_m: Option<f64>,
    indenter_radius_m: Option<f64>,
    half_angle_rad: Option<f64>,
    bonded: bool,
    poisson_ratio: f64,
    contact_point: Option<String>,
}

impl Pressed {
    fn contact(&self) -> PyResult<ContactPoint> {
        let contact = self.contact_point.as_deref().map(contact_point);
        let contact = contact.transpose();
        contact
            .map(Option::unwrap_or_default)
            .map_err(|why| refused(format_args!("contact_point {why}")))
    }

    fn specimen(&self) -> PyResult<Specimen> {
        let mut kinds = LoadingKind::ALL.into_iter();
        let Some(kind) = kinds.find(|kind| kind.name() == self.loading) else {
            let known = LoadingKind::ALL.map(LoadingKind::name).join(", ");
            return Err(refused(format_args!(
                "loading \"{}\" is not one of {known}",
                self.loading
            )));
        };
        let loading = Loading {
            kind,
            area_m2: self.area_m2,
            thickness_m: self.thickness_m,
            radius_m: self.indenter_radius_m,
            half_angle_rad: self.half_angle_rad,
            bonded: self.bonded,
        };
        Specimen::new(loading, self.poisson_ratio, 0.0).or_refused()
    }
}

/// Columns of a record: t, y, strain, depth.
type Columns<'py> = (
    Bound<'py, PyAny>,
    Bound<'py, PyAny>,
    Option<Bound<'py, PyAny>>,
    Option<Bound<'py, PyAny>>,
);

/// A record of its kind from columns; strain, or depth of a specimen, only for any motion.
fn record(
    kind: &str,
    columns: &Columns<'_>,
    pressed: Option<&Pressed>,
    ramp_time_s: Option<f64>,
) -> PyResult<Record> {
    let (t, y, strain, depth) = columns;
    let x = vector("t", t)?;
    if let (Some(pressed), Some(depth)) = (pressed, depth) {
        if kind != "record" || strain.is_some() {
            return Err(refused(
                "depth belongs to kind=\"record\" without strain: y is then the force in N",
            ));
        }
        let (depth, force) = (vector("depth", depth)?, vector("y", y)?);
        let contact = pressed.contact()?;
        return Record::pressed_from(contact, x, depth, force, &pressed.specimen()?).or_refused();
    }
    if strain.is_some() != (kind == "record") {
        return Err(refused(if kind == "record" {
            "strain is missing: a record of any motion has time, strain and stress, or time, depth and force"
        } else {
            "strain belongs to kind=\"record\" only: divide the stress by a held strain yourself"
        }));
    }
    if let Some(ramp_time_s) = ramp_time_s {
        return ramped(kind, x, vector("y", y)?, ramp_time_s);
    }
    match (kind, strain) {
        ("relaxation", _) => Record::relaxation(x, vector("y", y)?),
        ("creep", _) => Record::creep(x, vector("y", y)?),
        ("oscillation", _) => {
            let moduli = complex_vector("y", y)?;
            let (storage, loss) = moduli.iter().map(|m| (m.re, m.im)).unzip();
            Record::oscillation(x, storage, loss)
        }
        ("record", Some(strain)) => Record::history(x, vector("strain", strain)?, vector("y", y)?),
        _ => {
            let known = identify::RecordKind::ALL
                .map(identify::RecordKind::name)
                .join(", ");
            return Err(refused(format_args!(
                "kind \"{kind}\" is not one of {known}"
            )));
        }
    }
    .or_refused()
}

/// A relaxation that begins with the ramp to its strain.
fn ramped(kind: &str, time_s: Vec<f64>, modulus_pa: Vec<f64>, ramp_s: f64) -> PyResult<Record> {
    if kind != "relaxation" {
        return Err(refused("ramp_time_s belongs to kind=\"relaxation\" only"));
    }
    let columns = table::Columns {
        values: vec![
            (table::Column::Time, "t".to_owned(), time_s),
            (table::Column::Modulus, "y".to_owned(), modulus_pa),
        ],
        ..table::Columns::default()
    };
    let reading = table::Reading {
        ramp_time_s: Some(ramp_s),
        ..table::Reading::default()
    };
    Ok(columns.record(&reading).or_refused()?.record)
}

/// The options of an identification by their names.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct IdentifyOptions {
    models: Option<Vec<String>>,
    chosen: Option<String>,
    weights: String,
    starts: Whole,
    bootstrap: Whole,
    seed: Whole,
    stiffening: bool,
    baseline: Option<String>,
    fix: Vec<String>,
    ramp_time_s: Option<f64>,
}

impl IdentifyOptions {
    fn baseline(&self) -> PyResult<Option<Baseline>> {
        let Some(name) = &self.baseline else {
            return Ok(None);
        };
        let known = Baseline::CHOICES.iter().find(|one| one.1 == name);
        known.map(|one| Some(one.0)).ok_or_else(|| {
            let names = Baseline::CHOICES.map(|one| one.1).join(", ");
            refused(format_args!("baseline \"{name}\" is not one of {names}"))
        })
    }

    fn options(&self) -> PyResult<Options> {
        let candidates = match &self.models {
            Some(names) => names
                .iter()
                .map(|name| kind_of(name))
                .collect::<PyResult<_>>()?,
            None => CANDIDATES.to_vec(),
        };
        let weighting = match self.weights.as_str() {
            "equal" => Weighting::Equal,
            "log-spacing" => Weighting::LogSpacing,
            other => {
                return Err(refused(format_args!(
                    "weights \"{other}\" is not one of equal, log-spacing"
                )));
            }
        };
        Ok(Options {
            candidates,
            chosen: self.chosen.as_deref().map(kind_of).transpose()?,
            weighting,
            starts: self.starts.within("starts", Options::STARTS_ALLOWED)? as usize,
            bootstrap: self
                .bootstrap
                .within("bootstrap", Options::BOOTSTRAP_ALLOWED)? as usize,
            seed: self.seed.within("seed", 0..=u64::MAX)?,
            stiffening: self.stiffening,
            baseline: self.baseline()?,
            held: (self.fix.iter())
                .map(|one| held(one).map_err(|why| refused(format_args!("fix {one:?} {why}"))))
                .collect::<PyResult<_>>()?,
        })
    }
}

/// Models fitted to a record, as dictionaries.
#[pyfunction]
pub(crate) fn identify_record<'py>(
    py: Python<'py>,
    records: Vec<Columns<'py>>,
    kind: &str,
    pressed: Option<Pressed>,
    options: IdentifyOptions,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let ramp_time_s = options.ramp_time_s;
    let record = |columns| record(kind, columns, pressed.as_ref(), ramp_time_s);
    let records = records.iter().map(record);
    let record = Record::together(records.collect::<PyResult<_>>()?).or_refused()?;
    let options = options.options()?;
    let found = conduct(py, progress, Interrupted::Forgotten, move |conduct| {
        let done = |records| conduct.add(records as u64);
        identify::identify_unless(&record, &options, conduct.stop(), &done).or_refused()
    })?;
    report(py, &found)
}

/// Models fitted to tables, as the command reads them: names with bytes, and options by their keys.
#[pyfunction]
pub(crate) fn identify_tables<'py>(
    py: Python<'py>,
    tables: Vec<(String, Vec<u8>)>,
    options: &Bound<'py, PyAny>,
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
    let answer = conduct(py, None, Interrupted::Forgotten, move |conduct| {
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

fn report<'py>(py: Python<'py>, found: &Identification) -> PyResult<Bound<'py, PyDict>> {
    let report = PyDict::new(py);
    report.set_item("kind", found.kind.name())?;
    report.set_item("x", PyArray1::from_slice(py, &found.x))?;
    report.set_item("measured", PyArray1::from_slice(py, &found.measured))?;
    report.set_item("warnings", &found.warnings)?;
    let fits = PyList::empty(py);
    for fit in &found.fits {
        let one = PyDict::new(py);
        one.set_item("kind", fit.kind.name())?;
        let model = fit.to_model().ok().map(PyModel);
        one.set_item("model", model.map(|model| Py::new(py, model)).transpose()?)?;
        let estimates = fit.parameters.iter().map(|p| {
            let (error, low, high) = (p.standard_error, p.low_95, p.high_95);
            (p.name, p.unit, p.value, error, low, high)
        });
        one.set_item("estimates", estimates.collect::<Vec<_>>())?;
        one.set_item("correlation", fit.correlation.clone())?;
        one.set_item("rms", fit.rms)?;
        one.set_item("aic", fit.aic)?;
        one.set_item("bic", fit.bic)?;
        one.set_item("predicted", PyArray1::from_slice(py, &fit.predicted))?;
        one.set_item("is_settled", fit.is_settled())?;
        fits.append(one)?;
    }
    report.set_item("fits", fits)?;
    Ok(report)
}
