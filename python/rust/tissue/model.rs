//! A model of viscoelastic matter.

use super::{checked_history, kind_of, values_of};
use crate::arrays::{Array, Whole, vector};
use crate::conducted::{each, heard};
use crate::refused::{OrRefused as _, refused};
use haptic_tissue::{Card, ExportFormat, MeasuredLoading, Model, PronyFit};
use num_complex::Complex64;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use std::time::Duration;

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

impl PyModel {
    fn fit(
        &self,
        py: Python<'_>,
        branches: &Whole,
        shortest_s: f64,
        horizon_s: f64,
    ) -> PyResult<PronyFit> {
        let branches = branches.within("branches", PronyFit::BRANCHES)?;
        let model = self.0.clone();
        heard(py, Duration::MAX, move |_| {
            PronyFit::new(&model, branches, shortest_s, horizon_s).or_refused()
        })
    }

    /// The answer to a history that is straight between its samples.
    fn history<'py>(
        &self,
        time_s: &Bound<'py, PyAny>,
        name: &str,
        given: &Bound<'py, PyAny>,
        answer: fn(&Model, &[f64], &[f64]) -> Vec<f64>,
    ) -> PyResult<Array<f64>> {
        let py = time_s.py();
        let (time_s, given) = (vector("time_s", time_s)?, vector(name, given)?);
        checked_history(&time_s, &given, name)?;
        let model = self.0.clone();
        let answer = heard(py, Duration::MAX, move |_| {
            Ok(answer(&model, &time_s, &given))
        })?;
        Ok(Array::of(answer))
    }
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
            let pairs = values.iter().filter(|(parameter, _)| *parameter == known);
            let numbers: Vec<f64> = pairs.map(|(_, value)| *value).collect();
            if known.for_each_branch {
                dictionary.set_item(known.name, numbers)?;
            } else {
                dictionary.set_item(known.name, numbers.first())?;
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
        let model = self.0.clone();
        each("time_s", time_s, move |t, _| model.relaxation_moduli(t))
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
        let model = self.0.clone();
        each("time_s", time_s, move |t, _| model.creep_compliances(t))
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
        let model = self.0.clone();
        each("omega_rad_s", omega_rad_s, move |omega, _| {
            let modulus = |&omega: &f64| -> Complex64 { model.complex_modulus(omega) };
            omega.iter().map(modulus).collect()
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
    ) -> PyResult<Array<f64>> {
        self.history(time_s, "strain", strain, Model::stress)
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
    ) -> PyResult<Array<f64>> {
        self.history(time_s, "stress_pa", stress_pa, Model::strain)
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
        branches: Whole,
        shortest_s: f64,
        horizon_s: f64,
    ) -> PyResult<(Self, f64)> {
        let fit = self.fit(py, &branches, shortest_s, horizon_s)?;
        Ok((Self(fit.model().or_refused()?), fit.max_relative_error))
    }

    /// A Prony series as the text that a finite-element program reads, its modulus taken as Young's.
    ///
    /// Parameters
    /// ----------
    /// program : {"table", "ansys", "abaqus", "febio"}
    ///     Its conventions.
    /// branches, shortest_s, horizon_s
    ///     As in `prony`.
    /// title : str
    ///     A line for people; its first word names a whole material.
    /// card : {"series", "material"}
    ///     The series alone, or the elasticity of the material too, of ansys and abaqus.
    ///
    /// Returns
    /// -------
    /// str
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     As `prony`; more branches than the program takes.
    #[pyo3(signature = (program, branches, shortest_s, horizon_s, title = "fractional-haptics", card = "series"))]
    #[expect(clippy::too_many_arguments, reason = "Python names them")]
    fn export(
        &self,
        py: Python<'_>,
        program: &str,
        branches: Whole,
        shortest_s: f64,
        horizon_s: f64,
        title: &str,
        card: &str,
    ) -> PyResult<String> {
        let cards = Card::CHOICES.map(|one| one.1);
        let known = Card::CHOICES.iter().find(|one| one.1 == card);
        let card = known.ok_or_else(|| {
            refused(format_args!(
                "card \"{card}\" is not one of {}",
                cards.join(", ")
            ))
        })?;
        let card = card.0;
        let mut formats = ExportFormat::ALL.into_iter();
        let format = formats.find(|format| format.name() == program);
        let format = format.ok_or_else(|| {
            let known = ExportFormat::ALL.map(ExportFormat::name).join(", ");
            refused(format_args!("program \"{program}\" is not one of {known}"))
        })?;
        let fit = self.fit(py, &branches, shortest_s, horizon_s)?;
        fit.text(format, card, title, &MeasuredLoading::default())
            .or_refused()
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other
            .cast::<Self>()
            .is_ok_and(|other| other.get().0 == self.0)
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
        let model = slf.get();
        let values = model.0.parameters().into_iter().map(|(_, value)| value);
        let arguments = (
            model.kind(),
            PyTuple::new(py, values.collect::<Vec<f64>>())?,
        );
        Ok((restore, arguments).into_pyobject(py)?.into_any())
    }
}

/// Model for pickles, from its kind and the values of its parameters, in the order of its table.
#[pyfunction]
pub(crate) fn restore_model(kind: &str, values: Vec<f64>) -> PyResult<PyModel> {
    let model = Model::from_parameters(kind_of(kind)?, &values).or_refused()?;
    Ok(PyModel(model))
}
