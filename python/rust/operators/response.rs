//! Frequency responses of operators.

use super::{PyOperator, scheme_of};
use crate::arrays::any_shape;
use crate::conducted::heard;
use crate::refused::{OrRefused as _, refused};
use fracdiff::{ExactDifference, FrequencyResponse as _, Order, Scheme, Seconds};
use numpy::{Complex64, IntoPyArray as _, PyArrayDyn, PyArrayMethods as _};
use pyo3::prelude::*;
use std::time::Duration;

/// T^(−μ)·P(e^(−jωT)) of any scheme, `exact` too.
#[pyfunction]
pub(crate) fn frequency_response<'py>(
    omega: &Bound<'py, PyAny>,
    order: f64,
    sample_time: f64,
    scheme: &str,
    horizon: f64,
) -> PyResult<Bound<'py, PyArrayDyn<Complex64>>> {
    if scheme_of(scheme)? != Scheme::Exact {
        let operator = PyOperator::new(omega.py(), order, sample_time, scheme, horizon)?;
        return operator.frequency_response(omega);
    }
    let order = Order::new(order).or_refused()?;
    let rate = Seconds(sample_time).rate_to_the(order).or_refused()?;
    let exact = ExactDifference(order);
    response(omega, sample_time, move |theta| {
        exact.response(theta) * rate
    })
}

/// A response at each of some frequencies in rad/s, which must be up to half the sample rate.
pub(super) fn response<'py>(
    omega: &Bound<'py, PyAny>,
    sample_time: f64,
    at: impl Fn(f64) -> Complex64 + Send + 'static,
) -> PyResult<Bound<'py, PyArrayDyn<Complex64>>> {
    let py = omega.py();
    let (omega, shape) = any_shape("omega", omega)?;
    // A frequency of π/T that was rounded up is half the sample rate all the same.
    let nyquist = std::f64::consts::PI / sample_time * (1.0 + 4.0 * f64::EPSILON);
    if let Some(index) = omega.iter().position(|w| !(0.0..=nyquist).contains(w)) {
        return Err(refused(format_args!(
            "omega[{index}] = {} rad/s is not in [0, {nyquist}] rad/s, that is up to half the sample rate",
            omega[index]
        )));
    }
    let values: Vec<Complex64> = heard(py, Duration::MAX, move |conduct| {
        Ok(conduct.each(&omega, |omega| at(omega * sample_time)))
    })?;
    values.into_pyarray(py).reshape(shape)
}
