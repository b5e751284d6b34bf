//! A tissue by name, and the library.

use super::model::PyModel;
use crate::conducted::heard;
use crate::json::{from_python, to_python};
use crate::refused::{OrRefused as _, unread};
use haptic_tissue::{Library, Material};
use pyo3::exceptions::PyUserWarning;
use pyo3::prelude::*;
use std::ffi::CString;
use std::path::{Path, PathBuf};
use std::time::Duration;

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
/// loading : dict, optional
///     Loading of the measurement: ``kind`` (shear, tension, compression, punch, sphere, cone), ``modulus`` (shear, young),
///     ``poisson_ratio``. Unknown ones are left out.
/// stiffening : float, default 0
///     b of tissue that stiffens by (exp(b e) - 1)/(b e) at the nominal strain e.
/// range : dict, optional
///     Range in which it holds: ``time_from_s``, ``time_to_s``, ``omega_from_rad_s``, ``omega_to_rad_s``, ``strain_to``.
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
    #[pyo3(signature = (name, description, model, source, range = None, *, loading = None, stiffening = 0.0))]
    fn new(
        name: &str,
        description: &str,
        model: &PyModel,
        source: &Bound<'_, PyAny>,
        range: Option<&Bound<'_, PyAny>>,
        loading: Option<&Bound<'_, PyAny>>,
        stiffening: f64,
    ) -> PyResult<Self> {
        let source = from_python("source", source)?;
        let material = Material::new(name, description, model.0.clone(), source).or_refused()?;
        let loading = loading.map(|loading| from_python("loading", loading));
        let material = material.with_loading(loading.transpose()?.unwrap_or_default(), stiffening);
        // Reading it back finds a stiffening that is out of range.
        let material = Material::parse(Path::new("material"), &material.to_toml()).or_refused()?;
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

    /// The name under which the library finds it.
    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    /// A few words for people.
    #[getter]
    fn description(&self) -> &str {
        &self.0.description
    }

    /// The model of the matter, without the specimen it was measured on.
    #[getter]
    fn model(&self) -> PyModel {
        PyModel(self.0.model.clone())
    }

    /// The origin of the numbers, a dict.
    #[getter]
    fn source<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.0.source)
    }

    /// Loading of the measurement, a dict; None where the source says nothing.
    #[getter]
    fn loading<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.0.loading)
    }

    /// b of tissue that stiffens; 0 of any other.
    #[getter]
    fn stiffening(&self) -> f64 {
        self.0.stiffening
    }

    /// Range in which the parameters hold, a dict; None where the source says nothing.
    #[getter]
    fn range<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.0.range)
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

/// The library; warns of files in the folder that are no tissues.
fn loaded(py: Python<'_>, folder: Option<PathBuf>) -> PyResult<Library> {
    let library = heard(py, Duration::MAX, move |_| {
        Library::load(folder.as_deref()).map_err(|error| unread(&error))
    })?;
    for file in library.skipped() {
        let file = CString::new(file.replace('\0', " "))?;
        PyErr::warn(py, &py.get_type::<PyUserWarning>(), &file, 2)?;
    }
    Ok(library)
}

/// The tissues that come with the package, and those of a folder.
#[pyfunction]
pub(crate) fn library(py: Python<'_>, folder: Option<PathBuf>) -> PyResult<Vec<PyMaterial>> {
    let library = loaded(py, folder)?;
    let materials = library.materials().iter().cloned();
    Ok(materials.map(PyMaterial).collect())
}

/// A tissue by name, or from a file.
#[pyfunction]
pub(crate) fn find_material(
    py: Python<'_>,
    name: String,
    folder: Option<PathBuf>,
) -> PyResult<PyMaterial> {
    let library = loaded(py, folder)?;
    heard(py, Duration::MAX, move |_| {
        let found = library.find(&name).map_err(|error| unread(&error))?;
        Ok(PyMaterial(found))
    })
}
