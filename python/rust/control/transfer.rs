//! Fractional transfer functions and plants.

use super::memory;
use crate::arrays::{Array, Whole, complex_vector, matrix, vector};
use crate::conducted::{each, heard_by};
use crate::refused::{OrRefused as _, refused};
use fracdiff::Seconds;
use fractional_control::{
    ControlError, FractionalTransferFunction, Plant, PowerMemory, Term, impulse_response, respond,
    step_response,
};
use nalgebra::{DMatrix, DVector, RowDVector};
use num_complex::Complex64;
use pyo3::prelude::*;
use pyo3::types::{PyComplex, PyTuple};
use std::sync::Arc;

/// A fractional transfer function ``G(s) = sum b_j s^beta_j / sum a_i s^alpha_i``.
///
/// Parameters
/// ----------
/// numerator : str or list of (coefficient, order)
///     The whole function in the usual notation, as ``"1/(0.8s^2.2+0.5s^0.9+1)"``; or its terms.
/// denominator : list of (coefficient, order), optional
///     Its terms, if `numerator` is a list.
///
/// Raises
/// ------
/// ValueError
///     No such notation (with place and remedy), an improper function, orders that cancel or are common to both.
///
/// References
/// ----------
/// I. Podlubny, *Fractional Differential Equations*, Academic Press, 1999; the crate ``fractional-control``.
///
/// Examples
/// --------
/// >>> from fractional_haptics.control import TransferFunction
/// >>> complex(TransferFunction("1/(s^0.5+1)").response(1.0))  # doctest: +ELLIPSIS
/// (0.5-0.207...j)
#[pyclass(
    name = "_TransferFunction",
    module = "fractional_haptics._native",
    frozen,
    subclass
)]
#[derive(Debug)]
pub(crate) struct PyTransferFunction(FractionalTransferFunction);

/// Coefficient and order of each term, as Python writes them.
type Pairs = Vec<(f64, f64)>;

/// A text, or terms as pairs.
#[derive(FromPyObject)]
enum Notation {
    Text(String),
    Terms(Pairs),
}

fn terms(pairs: &[(f64, f64)]) -> Vec<Term> {
    pairs
        .iter()
        .map(|&(coefficient, order)| Term { coefficient, order })
        .collect()
}

fn pairs(terms: &[Term]) -> Pairs {
    terms
        .iter()
        .map(|term| (term.coefficient, term.order))
        .collect()
}

/// The response to a given input, by memory, sample time and samples.
type Respond =
    fn(&FractionalTransferFunction, PowerMemory, Seconds, usize) -> Result<Vec<f64>, ControlError>;

impl PyTransferFunction {
    fn record<'py>(
        slf: &Bound<'py, Self>,
        sample_time: f64,
        samples: &Whole,
        rule: &str,
        tolerance: f64,
        respond: Respond,
    ) -> PyResult<Array<f64>> {
        // Input, output and what lies between.
        let samples = samples.with_room("samples", 4)?;
        let memory = memory(rule, tolerance, horizon(sample_time, samples))?;
        let y = heard_by(slf, move |function, _| {
            respond(&function.0, memory, Seconds(sample_time), samples).or_refused()
        })?;
        Ok(Array::of(y))
    }
}

#[pymethods]
impl PyTransferFunction {
    #[new]
    #[pyo3(signature = (numerator, denominator = None))]
    fn new(numerator: Notation, denominator: Option<Pairs>) -> PyResult<Self> {
        match (numerator, denominator) {
            (Notation::Text(text), None) => text.parse().map(Self).or_refused(),
            (Notation::Text(_), Some(_)) => Err(refused(
                "a text is the whole function: leave denominator out",
            )),
            (Notation::Terms(_), None) => Err(refused(
                "denominator is missing: give its terms, as [(1.0, 0.5), (2.0, 0.0)]",
            )),
            (Notation::Terms(above), Some(below)) => {
                FractionalTransferFunction::new(&terms(&above), &terms(&below))
                    .map(Self)
                    .or_refused()
            }
        }
    }

    /// Terms of the numerator, (coefficient, order), highest order first.
    #[getter]
    fn numerator(&self) -> Pairs {
        pairs(self.0.numerator().terms())
    }

    /// Terms of the denominator, in the same order as those of the numerator.
    #[getter]
    fn denominator(&self) -> Pairs {
        pairs(self.0.denominator().terms())
    }

    /// Frequency response.
    ///
    /// Parameters
    /// ----------
    /// omega : array_like
    ///     rad/s, of any shape.
    ///
    /// Returns
    /// -------
    /// complex or ndarray of complex, same shape
    ///     G(j omega).
    fn response<'py>(&self, omega: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let function = self.0;
        responses(omega, move |omega| function.response(omega))
    }

    /// Poles of a commensurate function on the principal sheet.
    ///
    /// Returns
    /// -------
    /// ndarray of complex
    ///     rad/s.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     Orders without a common unit.
    fn poles<'py>(slf: &Bound<'py, Self>) -> PyResult<Array<Complex64>> {
        let poles = heard_by(slf, |function, _| {
            Ok(function.0.commensurate().or_refused()?.poles())
        })?;
        Ok(Array::of(poles))
    }

    /// Number of poles in the right half-plane; None where the count is not certain.
    fn unstable_poles(slf: &Bound<'_, Self>) -> PyResult<Option<usize>> {
        heard_by(slf, |function, _| Ok(function.0.unstable_poles()))
    }

    /// Response to a unit step.
    ///
    /// Parameters
    /// ----------
    /// sample_time : float
    ///     T in s.
    /// samples : int
    ///     Number of samples, the first at the time of the step.
    /// rule : {"bdf2", "grunwald"}
    ///     s as a function of the delay: an error of O(T^2) or O(T).
    /// tolerance : float, default 1e-9
    ///     Of each weight of the memories.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (samples,)
    #[pyo3(signature = (sample_time, samples, rule = "bdf2", tolerance = 1e-9))]
    fn step_response<'py>(
        slf: &Bound<'py, Self>,
        sample_time: f64,
        samples: Whole,
        rule: &str,
        tolerance: f64,
    ) -> PyResult<Array<f64>> {
        Self::record(slf, sample_time, &samples, rule, tolerance, step_response)
    }

    /// Response to a unit impulse; as `step_response`.
    #[pyo3(signature = (sample_time, samples, rule = "bdf2", tolerance = 1e-9))]
    fn impulse_response<'py>(
        slf: &Bound<'py, Self>,
        sample_time: f64,
        samples: Whole,
        rule: &str,
        tolerance: f64,
    ) -> PyResult<Array<f64>> {
        let response = impulse_response;
        Self::record(slf, sample_time, &samples, rule, tolerance, response)
    }

    /// Response to a record, from rest.
    ///
    /// Parameters
    /// ----------
    /// u : array_like, shape (n,)
    ///     Input at t = 0, T, 2T, …
    /// sample_time, rule, tolerance
    ///     As in `step_response`.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (n,)
    #[pyo3(signature = (u, sample_time, rule = "bdf2", tolerance = 1e-9))]
    fn respond<'py>(
        slf: &Bound<'py, Self>,
        u: &Bound<'py, PyAny>,
        sample_time: f64,
        rule: &str,
        tolerance: f64,
    ) -> PyResult<Array<f64>> {
        let u = vector("u", u)?;
        let memory = memory(rule, tolerance, horizon(sample_time, u.len()))?;
        let y = heard_by(slf, move |function, _| {
            respond(&function.0, memory, Seconds(sample_time), &u).or_refused()
        })?;
        Ok(Array::of(y))
    }

    fn __str__(&self) -> String {
        self.0.to_string()
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<(Bound<'py, PyAny>, Terms<'py>)> {
        let py = slf.py();
        let function = slf.get();
        let terms = (
            PyTuple::new(py, function.numerator())?,
            PyTuple::new(py, function.denominator())?,
        );
        Ok((slf.get_type().into_any(), terms))
    }
}

/// Terms of numerator and denominator, which cannot change.
type Terms<'py> = (Bound<'py, PyTuple>, Bound<'py, PyTuple>);

/// Horizon as long as a record, and never shorter than a memory can be.
fn horizon(sample_time: f64, samples: usize) -> f64 {
    sample_time * samples.max(100) as f64
}

/// Responses at frequencies of any shape; a number for a number.
pub(super) fn responses<'py>(
    omega: &Bound<'py, PyAny>,
    response: impl Fn(f64) -> Complex64 + Send + 'static,
) -> PyResult<Bound<'py, PyAny>> {
    each("omega", omega, move |omega, conduct| {
        conduct.each(omega, |&omega| response(omega))
    })
}

/// A plant with a dead time, made by `fractional_haptics.control.plant`.
#[pyclass(name = "Plant", module = "fractional_haptics.control", frozen)]
#[derive(Debug)]
pub(crate) struct PyControlPlant {
    pub(super) plant: Arc<Plant>,
    /// The function that made it, and its arguments.
    made: (&'static str, Py<PyTuple>),
}

impl PyControlPlant {
    fn new<'py>(
        py: Python<'py>,
        plant: Plant,
        by: &'static str,
        arguments: impl IntoPyObject<'py, Target = PyTuple, Output = Bound<'py, PyTuple>, Error = PyErr>,
    ) -> PyResult<Self> {
        Ok(Self {
            plant: Arc::new(plant),
            made: (by, arguments.into_pyobject(py)?.unbind()),
        })
    }
}

#[pymethods]
impl PyControlPlant {
    /// Plant from the usual notation, dead time included.
    #[staticmethod]
    fn _from_text(py: Python<'_>, text: &str) -> PyResult<Self> {
        Self::new(py, text.parse().or_refused()?, "_from_text", (text,))
    }

    /// Plant from a transfer function and a dead time in s.
    #[staticmethod]
    fn _from_function(function: &Bound<'_, PyTransferFunction>, delay_s: f64) -> PyResult<Self> {
        let plant = Plant::transfer(function.get().0, delay_s).or_refused()?;
        Self::new(function.py(), plant, "_from_function", (function, delay_s))
    }

    /// Plant from matrices and a dead time in s.
    #[staticmethod]
    fn _from_matrices(
        a: &Bound<'_, PyAny>,
        b: &Bound<'_, PyAny>,
        c: &Bound<'_, PyAny>,
        delay_s: f64,
    ) -> PyResult<Self> {
        let py = a.py();
        let (a, [rows, columns]) = matrix("a", a)?;
        let (b, c) = (vector("b", b)?, vector("c", c)?);
        let in_rows = a.chunks(columns.max(1)).map(|row| PyTuple::new(py, row));
        let in_rows = PyTuple::new(py, in_rows.collect::<PyResult<Vec<_>>>()?)?;
        let numbers = (
            in_rows,
            PyTuple::new(py, &b)?,
            PyTuple::new(py, &c)?,
            delay_s,
        );
        let states = fractional_control::StateSpace::new(
            DMatrix::from_row_slice(rows, columns, &a),
            DVector::from_vec(b),
            RowDVector::from_vec(c),
        );
        let plant = Plant::state_space(states.or_refused()?, delay_s).or_refused()?;
        Self::new(py, plant, "_from_matrices", numbers)
    }

    /// Plant from a measured response.
    #[staticmethod]
    fn _from_response(omega: &Bound<'_, PyAny>, response: &Bound<'_, PyAny>) -> PyResult<Self> {
        let py = omega.py();
        let (omega, response) = (
            vector("omega", omega)?,
            complex_vector("response", response)?,
        );
        if omega.len() != response.len() {
            return Err(refused(format_args!(
                "{} frequencies and {} responses: give one for each",
                omega.len(),
                response.len()
            )));
        }
        let complex = response
            .iter()
            .map(|g| PyComplex::from_doubles(py, g.re, g.im));
        let numbers = (PyTuple::new(py, &omega)?, PyTuple::new(py, complex)?);
        let points: Vec<(f64, Complex64)> = omega.into_iter().zip(response).collect();
        let plant = Plant::measured(&points).or_refused()?;
        Self::new(py, plant, "_from_response", numbers)
    }

    /// Frequency response; NaN outside the band of a measured one.
    fn response<'py>(&self, omega: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let nan = Complex64::new(f64::NAN, f64::NAN);
        let plant = Arc::clone(&self.plant);
        responses(omega, move |omega| plant.response(omega).unwrap_or(nan))
    }

    /// Dead time in s; that of a measured response is in the response.
    #[getter]
    fn delay_s(&self) -> f64 {
        self.plant.delay_s()
    }

    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let (by, arguments) = &slf.get().made;
        let by = slf.get_type().getattr(*by)?;
        Ok((by, arguments.bind(slf.py()).clone()))
    }
}
