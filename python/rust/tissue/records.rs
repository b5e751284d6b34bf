//! Functions of arrays of any shape, and records of a motion.

use crate::arrays::any_shape;
use crate::conducted::heard;
use crate::refused::refused;
use numpy::{Element, IntoPyArray as _, PyArrayDyn, PyArrayMethods as _};
use pyo3::prelude::*;
use std::time::Duration;

/// A function of each number of an array, in the array's shape.
pub(super) fn each<'py, T: Element + 'static>(
    name: &str,
    x: &Bound<'py, PyAny>,
    function: impl FnOnce(&[f64]) -> Vec<T> + Send + 'static,
) -> PyResult<Bound<'py, PyAny>> {
    let py = x.py();
    let (x, shape) = any_shape(name, x)?;
    let about = Duration::from_micros(5 * x.len() as u64);
    let values = heard(py, about, move |_| Ok(function(&x)))?;
    let values: Bound<'_, PyArrayDyn<T>> = values.into_pyarray(py).reshape(shape)?;
    // An array without dimensions becomes a number, as NumPy's own functions do.
    values.get_item(pyo3::types::PyTuple::empty(py))
}

/// Refuses times that do not rise, with the index, and columns of different length.
pub(super) fn checked_history(time_s: &[f64], other: &[f64], name: &str) -> PyResult<()> {
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
