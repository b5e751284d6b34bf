//! Tissues: models, the library, and models from records.

use crate::arrays::{any_shape, complex_vector, vector};
use crate::conducted::conduct;
use crate::json::{from_python, to_python};
use crate::refused::{OrRefused as _, refused};
use haptic_tissue::identify::{self, CANDIDATES, Identification, Options, Record, Weighting};
use haptic_tissue::{ExportFormat, Library, Material, Model, ModelKind, PronyFit};
use numpy::{Complex64, Element, IntoPyArray as _, PyArray1, PyArrayDyn, PyArrayMethods as _};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::path::{Path, PathBuf};

fn kind_of(name: &str) -> PyResult<ModelKind> {
    ModelKind::from_name(name).ok_or_else(|| {
        let known: Vec<&str> = ModelKind::ALL.iter().map(|kind| kind.name()).collect();
        refused(format_args!(
            "model \"{name}\" is not known: take one of {}",
            known.join(", ")
        ))
    })
}

/// Name, description and parameters of each model; a parameter has name, unit, range, help and whether it is a list.
#[pyfunction]
pub(crate) fn model_table(py: Python<'_>) -> PyResult<Bound<'_, PyList>> {
    let table = PyList::empty(py);
    for kind in ModelKind::ALL {
        let parameters = PyList::empty(py);
        for parameter in kind.parameters() {
            parameters.append((
                parameter.name,
                parameter.unit,
                parameter.range.words(),
                parameter.help,
                parameter.for_each_branch,
            ))?;
        }
        table.append((kind.name(), kind.description(), parameters))?;
    }
    Ok(table)
}

/// A model of viscoelastic matter: springs, dashpots and spring-pots, side by side and in series.
///
/// ::
///
///     spring-pot                 stress = V D^alpha strain,   M(s) = V s^alpha
///     side by side, in series    moduli add, compliances add
///
/// Parameters
/// ----------
/// kind : str
///     Name of the model, a key of `fractional_haptics.tissue.MODELS`, which has their parameters.
/// **parameters : float
///     Its parameters by name, with their units in the names; those of the branches of ``prony`` are lists.
///
/// Raises
/// ------
/// ValueError
///     An unknown model, a parameter that is missing, unknown or outside its range.
///
/// Notes
/// -----
/// Closed forms agree with mpmath within 1e-10 for 1e-6 <= t/tau <= 1e6; about 0.2 µs for each of many times.
///
/// References
/// ----------
/// A. Bonfanti, J. L. Kaplan, G. Charras, A. Kabla, *Fractional viscoelastic models for power-law materials*, Soft Matter 16,
/// 2020; the crate ``haptic-tissue``.
///
/// Examples
/// --------
/// >>> from fractional_haptics.tissue import Model
/// >>> gel = Model("spring-pot", viscosity_pa_s_alpha=8650.0, order=0.2247)
/// >>> round(float(gel.relaxation_modulus(1.0)), 1)
/// 7249.6
#[pyclass(name = "Model", module = "fractional_haptics.tissue", frozen)]
#[derive(Debug)]
pub(crate) struct PyModel(pub(crate) Model);

/// The values of [`ModelKind::parameters`] in their order, from arguments by name.
fn values_of(kind: ModelKind, parameters: Option<&Bound<'_, PyDict>>) -> PyResult<Vec<f64>> {
    let table = kind.parameters();
    let names = || {
        table
            .iter()
            .map(|known| known.name)
            .collect::<Vec<_>>()
            .join(", ")
    };
    for key in parameters.map(|given| given.keys()).iter().flatten() {
        let key: String = key.extract()?;
        if !table.iter().any(|known| known.name == key) {
            return Err(refused(format_args!(
                "{key} is not a parameter of the model {kind}, which has {}",
                names()
            )));
        }
    }
    let (mut single, mut branches) = (Vec::new(), Vec::new());
    for known in table {
        let given = match parameters {
            Some(given) => given.get_item(known.name)?,
            None => None,
        };
        let given = given.ok_or_else(|| {
            refused(format_args!(
                "{} is missing: the model {kind} has {}",
                known.name,
                names()
            ))
        })?;
        if known.for_each_branch {
            branches.push(vector(known.name, &given)?);
        } else {
            single.push(given.extract::<f64>()?);
        }
    }
    if let [moduli, times] = branches.as_slice() {
        if moduli.len() != times.len() {
            return Err(refused(format_args!(
                "{} moduli and {} times of branches: give one of each for a branch",
                moduli.len(),
                times.len()
            )));
        }
        single.extend(moduli.iter().zip(times).flat_map(|(e, tau)| [*e, *tau]));
    }
    Ok(single)
}

/// A function of each number of an array, in the array's shape.
fn each<'py, T: Element>(
    name: &str,
    x: &Bound<'py, PyAny>,
    function: impl FnOnce(&[f64]) -> Vec<T> + Send,
) -> PyResult<Bound<'py, PyAny>> {
    let py = x.py();
    let (x, shape) = any_shape(name, x)?;
    let values = py.detach(|| function(&x));
    let values: Bound<'_, PyArrayDyn<T>> = values.into_pyarray(py).reshape(shape)?;
    // An array without dimensions becomes a number, as NumPy's own functions do.
    values.get_item(pyo3::types::PyTuple::empty(py))
}

/// Refuses times that do not rise, with the index, and columns of different length.
fn checked_history(time_s: &[f64], other: &[f64], name: &str) -> PyResult<()> {
    if time_s.len() != other.len() {
        return Err(refused(format_args!(
            "time_s has {} values and {name} {}: give one for each time",
            time_s.len(),
            other.len()
        )));
    }
    if let Some(index) = time_s.iter().position(|t| !t.is_finite()) {
        return Err(refused(format_args!(
            "time_s[{index}] = {} s is not finite",
            time_s[index]
        )));
    }
    if let Some(index) = time_s.windows(2).position(|pair| pair[1] <= pair[0]) {
        return Err(refused(format_args!(
            "time_s[{}] = {} s is not after time_s[{index}] = {} s",
            index + 1,
            time_s[index + 1],
            time_s[index]
        )));
    }
    if let Some(index) = other.iter().position(|x| !x.is_finite()) {
        return Err(refused(format_args!(
            "{name}[{index}] = {} is not finite",
            other[index]
        )));
    }
    Ok(())
}

#[pymethods]
impl PyModel {
    #[new]
    #[pyo3(signature = (kind, /, **parameters))]
    fn new(kind: &str, parameters: Option<&Bound<'_, PyDict>>) -> PyResult<Self> {
        let kind = kind_of(kind)?;
        let values = values_of(kind, parameters)?;
        Ok(Self(Model::from_parameters(kind, &values).or_refused()?))
    }

    /// Name of the model: the classical one where the orders are 1 and 0.
    #[getter]
    fn kind(&self) -> &'static str {
        self.0.kind().name()
    }

    /// Parameters by name; lists for the branches of ``prony``.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dictionary = PyDict::new(py);
        let values = self.0.parameters();
        for known in self.0.kind().parameters() {
            let own = values.iter().filter(|(parameter, _)| *parameter == known);
            let own: Vec<f64> = own.map(|(_, value)| *value).collect();
            if known.for_each_branch {
                dictionary.set_item(known.name, own)?;
            } else {
                dictionary.set_item(known.name, own.first())?;
            }
        }
        Ok(dictionary)
    }

    /// Relaxation modulus G(t): stress over a step of strain.
    ///
    /// Parameters
    /// ----------
    /// time_s : array_like
    ///     Times after the step in s, of any shape.
    ///
    /// Returns
    /// -------
    /// float or ndarray, same shape
    ///     Pa; 0 before the step.
    fn relaxation_modulus<'py>(&self, time_s: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        each("time_s", time_s, |t| self.0.relaxation_moduli(t))
    }

    /// Creep compliance J(t): strain over a step of stress.
    ///
    /// Parameters
    /// ----------
    /// time_s : array_like
    ///     Times after the step in s, of any shape.
    ///
    /// Returns
    /// -------
    /// float or ndarray, same shape
    ///     1/Pa; 0 before the step.
    fn creep_compliance<'py>(&self, time_s: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        each("time_s", time_s, |t| self.0.creep_compliances(t))
    }

    /// Complex modulus M(i omega): storage modulus, and i times the loss modulus.
    ///
    /// Parameters
    /// ----------
    /// omega_rad_s : array_like
    ///     Angular frequencies in rad/s, of any shape.
    ///
    /// Returns
    /// -------
    /// complex or ndarray of complex, same shape
    ///     Pa.
    fn complex_modulus<'py>(&self, omega_rad_s: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        each("omega_rad_s", omega_rad_s, |omega| -> Vec<Complex64> {
            omega
                .iter()
                .map(|&omega| self.0.complex_modulus(omega))
                .collect()
        })
    }

    /// Stress of a strain that is straight between its samples.
    ///
    /// Parameters
    /// ----------
    /// time_s : array_like, shape (n,)
    ///     Times in s, rising, at any distances. Before the first the specimen is at rest.
    /// strain : array_like, shape (n,)
    ///     Strain at these times.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (n,)
    ///     Pa. Infinite where a step of strain has no finite stress.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     Different lengths, times that do not rise, a number that is not finite; with the index.
    fn stress<'py>(
        &self,
        time_s: &Bound<'py, PyAny>,
        strain: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let py = time_s.py();
        let (time_s, strain) = (vector("time_s", time_s)?, vector("strain", strain)?);
        checked_history(&time_s, &strain, "strain")?;
        let stress = py.detach(|| self.0.stress(&time_s, &strain));
        Ok(stress.into_pyarray(py))
    }

    /// Strain of a stress that is straight between its samples; see `stress`.
    ///
    /// Parameters
    /// ----------
    /// time_s : array_like, shape (n,)
    ///     Times in s, rising.
    /// stress_pa : array_like, shape (n,)
    ///     Stress at these times in Pa.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (n,)
    ///     Strain.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     As `stress`.
    fn strain<'py>(
        &self,
        time_s: &Bound<'py, PyAny>,
        stress_pa: &Bound<'py, PyAny>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let py = time_s.py();
        let (time_s, stress_pa) = (vector("time_s", time_s)?, vector("stress_pa", stress_pa)?);
        checked_history(&time_s, &stress_pa, "stress_pa")?;
        let strain = py.detach(|| self.0.strain(&time_s, &stress_pa));
        Ok(strain.into_pyarray(py))
    }

    /// G(0) in Pa; infinite for a spring-pot.
    #[getter]
    fn instantaneous_modulus_pa(&self) -> f64 {
        self.0.instantaneous_modulus()
    }

    /// G after an infinite time in Pa.
    #[getter]
    fn equilibrium_modulus_pa(&self) -> f64 {
        self.0.equilibrium_modulus()
    }

    /// A Prony series of few branches, for other programs.
    ///
    /// Parameters
    /// ----------
    /// branches : int
    ///     Most branches, 1 to 100; 2 for each decade of time give about 1 %.
    /// shortest_s, horizon_s : float
    ///     Ends of the band of times in s.
    ///
    /// Returns
    /// -------
    /// model : Model
    ///     Of the kind ``prony``.
    /// max_relative_error : float
    ///     Largest relative error of its relaxation modulus over the band.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     No band, too many branches, a model whose stress is an impulse at a step of strain.
    fn prony(
        &self,
        py: Python<'_>,
        branches: usize,
        shortest_s: f64,
        horizon_s: f64,
    ) -> PyResult<(Self, f64)> {
        let fit = py.detach(|| PronyFit::new(&self.0, branches, shortest_s, horizon_s));
        let fit = fit.or_refused()?;
        Ok((Self(fit.model().or_refused()?), fit.max_relative_error))
    }

    /// A Prony series as the text that a finite-element program reads.
    ///
    /// Parameters
    /// ----------
    /// program : {"table", "ansys", "abaqus", "febio"}
    ///     Its conventions.
    /// branches, shortest_s, horizon_s
    ///     As in `prony`.
    /// title : str
    ///     A line for people.
    ///
    /// Returns
    /// -------
    /// str
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     As `prony`; more branches than the program takes.
    #[pyo3(signature = (program, branches, shortest_s, horizon_s, title = "fractional-haptics"))]
    fn export(
        &self,
        py: Python<'_>,
        program: &str,
        branches: usize,
        shortest_s: f64,
        horizon_s: f64,
        title: &str,
    ) -> PyResult<String> {
        let mut formats = ExportFormat::ALL.into_iter();
        let format = formats.find(|format| format.name() == program);
        let format = format.ok_or_else(|| {
            let known = ExportFormat::ALL.map(ExportFormat::name).join(", ");
            refused(format_args!("program \"{program}\" is not one of {known}"))
        })?;
        let fit = py.detach(|| PronyFit::new(&self.0, branches, shortest_s, horizon_s));
        fit.or_refused()?.text(format, title).or_refused()
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other
            .cast::<Self>()
            .is_ok_and(|other| other.get().0 == self.0)
    }

    fn __hash__(&self) -> u64 {
        use std::hash::{DefaultHasher, Hash as _, Hasher as _};
        let mut hasher = DefaultHasher::new();
        self.0.kind().hash(&mut hasher);
        for (_, value) in self.0.parameters() {
            value.to_bits().hash(&mut hasher);
        }
        hasher.finish()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let mut text = format!("Model('{}'", self.kind());
        for (name, value) in self.parameters(py)?.iter() {
            text += &format!(", {name}={}", value.repr()?);
        }
        Ok(text + ")")
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let py = slf.py();
        let restore = py
            .import("fractional_haptics._native")?
            .getattr("restore_model")?;
        let own = slf.get();
        let arguments = (own.kind(), own.parameters(py)?);
        Ok((restore, arguments).into_pyobject(py)?.into_any())
    }
}

/// For pickles: a model from its kind and its parameters.
#[pyfunction]
pub(crate) fn restore_model(kind: &str, parameters: &Bound<'_, PyDict>) -> PyResult<PyModel> {
    PyModel::new(kind, Some(parameters))
}

/// A tissue by name: a model, where its parameters come from, and where they hold.
///
/// Parameters
/// ----------
/// name : str
///     Lower-case letters, digits and hyphens.
/// description : str
///     A few words for people.
/// model : Model
///     The model.
/// source : dict
///     ``citation``, ``conditions``, ``checked`` (bool); and as far as known ``note``, ``date``, ``sample``, ``temperature``,
///     ``residual``.
/// range : dict, optional
///     Where it holds: ``time_from_s``, ``time_to_s``, ``omega_from_rad_s``, ``omega_to_rad_s``, ``strain_to``.
///
/// Raises
/// ------
/// ValueError
///     A name of other characters, a field that is missing or unknown.
#[pyclass(name = "Material", module = "fractional_haptics.tissue", frozen)]
#[derive(Debug)]
pub(crate) struct PyMaterial(pub(crate) Material);

#[pymethods]
impl PyMaterial {
    #[new]
    #[pyo3(signature = (name, description, model, source, range = None))]
    fn new(
        name: &str,
        description: &str,
        model: &PyModel,
        source: &Bound<'_, PyAny>,
        range: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let source = from_python("source", source)?;
        let material = Material::new(name, description, model.0.clone(), source).or_refused()?;
        Ok(Self(match range {
            Some(range) => material.with_range(from_python("range", range)?),
            None => material,
        }))
    }

    /// A material from the text of a tissue file (TOML).
    ///
    /// Parameters
    /// ----------
    /// text : str
    ///     The text.
    ///
    /// Returns
    /// -------
    /// Material
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     With line and reason.
    #[staticmethod]
    fn from_toml(text: &str) -> PyResult<Self> {
        Ok(Self(Material::parse(Path::new("text"), text).or_refused()?))
    }

    /// The text of a tissue file, which reads back to the same numbers to the bit.
    fn to_toml(&self) -> String {
        self.0.to_toml()
    }

    /// Name.
    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    /// A few words for people.
    #[getter]
    fn description(&self) -> &str {
        &self.0.description
    }

    /// The model.
    #[getter]
    fn model(&self) -> PyModel {
        PyModel(self.0.model.clone())
    }

    /// The origin of the numbers, a dict.
    #[getter]
    fn source<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.0.source)
    }

    /// Where the parameters hold, a dict; None where the source says nothing.
    #[getter]
    fn range<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.0.range)
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other
            .cast::<Self>()
            .is_ok_and(|other| other.get().0.to_toml() == self.0.to_toml())
    }

    fn __repr__(&self) -> String {
        format!(
            "<Material '{}': {}, {}>",
            self.0.name,
            self.0.description,
            self.0.model.kind()
        )
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, (String,))> {
        Ok((slf.get_type().getattr("from_toml")?, (slf.get().to_toml(),)))
    }
}

/// The tissues that come with the package, and those of a folder.
#[pyfunction]
pub(crate) fn library(folder: Option<PathBuf>) -> PyResult<Vec<PyMaterial>> {
    let library = Library::load(folder.as_deref()).or_refused()?;
    Ok(library
        .materials()
        .iter()
        .cloned()
        .map(PyMaterial)
        .collect())
}

/// A tissue by name, or from a file.
#[pyfunction]
pub(crate) fn find_material(name: &str, folder: Option<PathBuf>) -> PyResult<PyMaterial> {
    let library = Library::load(folder.as_deref()).or_refused()?;
    Ok(PyMaterial(library.find(name).or_refused()?))
}

/// A record of its kind from columns; `strain` only for any motion.
fn record(
    kind: &str,
    t: &Bound<'_, PyAny>,
    y: &Bound<'_, PyAny>,
    strain: Option<&Bound<'_, PyAny>>,
) -> PyResult<Record> {
    let x = vector("t", t)?;
    if strain.is_some() != (kind == "record") {
        return Err(refused(if kind == "record" {
            "strain is missing: a record of any motion has time, strain and stress"
        } else {
            "strain belongs to kind=\"record\" only: divide the stress by a held strain yourself"
        }));
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

/// The options of an identification by their names.
#[derive(FromPyObject)]
pub(crate) struct IdentifyOptions {
    #[pyo3(item)]
    models: Option<Vec<String>>,
    #[pyo3(item)]
    chosen: Option<String>,
    #[pyo3(item)]
    weights: String,
    #[pyo3(item)]
    starts: usize,
    #[pyo3(item)]
    bootstrap: usize,
    #[pyo3(item)]
    seed: u64,
}

impl IdentifyOptions {
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
            starts: self.starts,
            bootstrap: self.bootstrap,
            seed: self.seed,
        })
    }
}

/// Models fitted to a record, as dictionaries.
#[pyfunction]
pub(crate) fn identify_record<'py>(
    t: &Bound<'py, PyAny>,
    y: &Bound<'py, PyAny>,
    kind: &str,
    strain: Option<&Bound<'py, PyAny>>,
    options: IdentifyOptions,
    progress: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let py = t.py();
    let (record, options) = (record(kind, t, y, strain)?, options.options()?);
    let found = conduct(py, progress, false, move |conduct| {
        identify::identify(&record, &options, &|records| conduct.add(records as u64))
    })?;
    report(py, &found.or_refused()?)
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
        one.set_item(
            "model",
            fit.to_model()
                .ok()
                .map(PyModel)
                .map(|model| Py::new(py, model))
                .transpose()?,
        )?;
        let estimates = fit.parameters.iter().map(|p| {
            (
                p.name,
                p.unit,
                p.value,
                p.standard_error,
                p.low_95,
                p.high_95,
            )
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
