//! Arrays in: whatever NumPy makes an array of, as numbers of 64 bits, copied. A copy costs little beside what is done
//! with it, and another thread cannot change it while the interpreter is released.

use crate::refused::refused;
use numpy::ndarray::Dimension;
use numpy::{Complex64, Element};
use numpy::{PyArray, PyArrayDescrMethods, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;

/// Kinds of NumPy's types that are real numbers: floating point, signed and unsigned integers.
const REAL: &[u8] = b"fiu";

/// The array of an argument, in numbers of type T; `kinds` are the kinds of types that it may have.
fn converted<'py, T: Element, D: Dimension>(
    name: &str,
    x: &Bound<'py, PyAny>,
    kinds: &[u8],
) -> PyResult<Bound<'py, PyArray<T, D>>> {
    let py = x.py();
    let array = py
        .import("numpy")?
        .call_method1("asarray", (x,))
        .map_err(|error| refused(format_args!("{name} is no array of numbers: {error}")))?;
    let array = array.cast_into::<PyUntypedArray>()?;
    let kind = array.dtype().kind();
    if !kinds.contains(&kind) {
        return Err(refused(format_args!(
            "{name} has numbers of type {}, and must have real ones: convert it with astype(float)",
            array.dtype().str()?
        )));
    }
    let wanted = D::NDIM.unwrap_or(array.ndim());
    if array.ndim() != wanted {
        return Err(refused(format_args!(
            "{name} has the shape {}, and must have {wanted} dimension{}",
            array.getattr("shape")?.str()?,
            if wanted == 1 { "" } else { "s" }
        )));
    }
    let array = array.call_method1("astype", (numpy::dtype::<T>(py),))?;
    Ok(array.cast_into::<PyArray<T, D>>()?)
}

/// The numbers of an array of type T, whatever its layout, in the order of its last axis.
fn copied<T: Element + Copy, D: Dimension>(array: &Bound<'_, PyArray<T, D>>) -> PyResult<Vec<T>> {
    let array = array.try_readonly()?;
    Ok(array.as_array().iter().copied().collect())
}

/// A vector of real numbers; integers are converted.
///
/// # Errors
/// `ValueError` for other shapes and types, with the name of the argument.
pub(crate) fn vector(name: &str, x: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    // As it mostly is.
    if let Ok(array) = x.cast::<numpy::PyArray1<f64>>() {
        return copied(array);
    }
    copied(&converted::<f64, numpy::Ix1>(name, x, REAL)?)
}

/// A matrix of real numbers, row by row, with its number of rows and columns.
///
/// # Errors
/// As [`vector`].
pub(crate) fn matrix(name: &str, x: &Bound<'_, PyAny>) -> PyResult<(Vec<f64>, [usize; 2])> {
    let array = converted::<f64, numpy::Ix2>(name, x, REAL)?;
    let shape = [array.shape()[0], array.shape()[1]];
    Ok((copied(&array)?, shape))
}

/// A vector of numbers that may be complex.
///
/// # Errors
/// As [`vector`].
pub(crate) fn complex_vector(name: &str, x: &Bound<'_, PyAny>) -> PyResult<Vec<Complex64>> {
    copied(&converted::<Complex64, numpy::Ix1>(name, x, b"fiuc")?)
}

/// The numbers of an array of any shape, in the order of its last axis.
///
/// # Errors
/// `ValueError` for another type, with the name of the argument.
pub(crate) fn any_shape<'py>(
    name: &str,
    x: &Bound<'py, PyAny>,
) -> PyResult<(Vec<f64>, Vec<usize>)> {
    let array = converted::<f64, numpy::IxDyn>(name, x, REAL)?;
    Ok((copied(&array)?, array.shape().to_vec()))
}
