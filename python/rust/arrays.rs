//! Arrays in: whatever NumPy makes an array of, as numbers of 64 bits, copied. A copy costs little beside what is done
//! with it, and another thread cannot change it while the interpreter is released. And how many: counts, and room for them.

use crate::refused::refused;
use numpy::ndarray::Dimension;
use numpy::{Complex64, Element, IntoPyArray as _, PyArrayDyn};
use numpy::{PyArray, PyArrayDescrMethods, PyArrayMethods, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::Borrowed;
use pyo3::prelude::*;
use std::fmt::Display;
use std::ops::RangeInclusive;

/// Kinds of NumPy's types that are real numbers: floating point, signed and unsigned integers.
const REAL: &[u8] = b"fiu";

/// The array of an argument, in numbers of type T; `kinds` are the kinds of types that it may have.
fn converted<'py, T: Element, D: Dimension>(
    name: &str,
    x: &Bound<'py, PyAny>,
    kinds: &[u8],
) -> PyResult<Bound<'py, PyArray<T, D>>> {
    unmasked(name, x)?;
    let py = x.py();
    let array = py
        .import("numpy")?
        .call_method1("asarray", (x,))
        .map_err(|error| refused(format_args!("{name} is not an array of numbers: {error}")))?;
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

/// Refuses a masked array: NumPy would give what is behind the mask for a sample.
pub(crate) fn unmasked(name: &str, x: &Bound<'_, PyAny>) -> PyResult<()> {
    let masked = x.py().import("numpy.ma")?.getattr("MaskedArray")?;
    if !x.is_instance(&masked)? {
        return Ok(());
    }
    Err(refused(format_args!(
        "{name} is a masked array, and masked samples have no value: give {name}.filled(value), or {name}.compressed() without them"
    )))
}

/// The numbers of an array of type T, whatever its layout, in the order of its last axis.
fn copied<T: Element + Copy, D: Dimension>(array: &Bound<'_, PyArray<T, D>>) -> PyResult<Vec<T>> {
    let array = array.try_readonly()?;
    // As it mostly is: many times as fast as one by one.
    match array.as_slice() {
        Ok(numbers) if array.is_c_contiguous() => Ok(numbers.to_vec()),
        _ => Ok(array.as_array().iter().copied().collect()),
    }
}

/// A vector of real numbers; integers are converted.
pub(crate) fn vector(name: &str, x: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    // As it mostly is; a subclass may mean something else.
    if let Ok(array) = x.cast::<numpy::PyArray1<f64>>()
        && x.get_type().is(x.py().get_type::<PyUntypedArray>())
    {
        return copied(array);
    }
    copied(&converted::<f64, numpy::Ix1>(name, x, REAL)?)
}

/// A matrix of real numbers, row by row, with its number of rows and columns.
pub(crate) fn matrix(name: &str, x: &Bound<'_, PyAny>) -> PyResult<(Vec<f64>, [usize; 2])> {
    let array = converted::<f64, numpy::Ix2>(name, x, REAL)?;
    let shape = [array.shape()[0], array.shape()[1]];
    Ok((copied(&array)?, shape))
}

/// A vector of numbers that may be complex.
pub(crate) fn complex_vector(name: &str, x: &Bound<'_, PyAny>) -> PyResult<Vec<Complex64>> {
    copied(&converted::<Complex64, numpy::Ix1>(name, x, b"fiuc")?)
}

/// The numbers of an array of any shape, in the order of its last axis.
pub(crate) fn any_shape<'py>(
    name: &str,
    x: &Bound<'py, PyAny>,
) -> PyResult<(Vec<f64>, Vec<usize>)> {
    let array = converted::<f64, numpy::IxDyn>(name, x, REAL)?;
    Ok((copied(&array)?, array.shape().to_vec()))
}

/// Frequencies in rad/s up to half the sample rate, of any shape; 0 is one of them if `from_zero`.
pub(crate) fn frequencies(
    omega: &Bound<'_, PyAny>,
    sample_time: f64,
    from_zero: bool,
) -> PyResult<(Vec<f64>, Vec<usize>)> {
    let (omega, shape) = any_shape("omega", omega)?;
    // A frequency of π/T that was rounded up is half the sample rate all the same.
    let nyquist = std::f64::consts::PI / sample_time * (1.0 + 4.0 * f64::EPSILON);
    let fits = |w: f64| w <= nyquist && (w > 0.0 || from_zero && w == 0.0);
    let Some(index) = omega.iter().position(|&w| !fits(w)) else {
        return Ok((omega, shape));
    };
    let (asked, least) = (omega[index], if from_zero { "[0" } else { "(0" });
    Err(refused(format_args!(
        "omega[{index}] = {asked} rad/s is not in {least}, {nyquist}] rad/s, that is up to half the sample rate"
    )))
}

/// A whole number of Python, as large as it likes; beyond 128 bits the largest there is.
pub(crate) struct Whole(i128);

impl<'py> FromPyObject<'_, 'py> for Whole {
    type Error = PyErr;

    fn extract(number: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let py = number.py();
        let number = py.import("operator")?.call_method1("index", (number,))?;
        Ok(Self(match number.extract() {
            Ok(whole) => whole,
            Err(_) if number.lt(0)? => i128::MIN,
            Err(_) => i128::MAX,
        }))
    }
}

impl Whole {
    /// As a number in a range.
    pub(crate) fn within<T>(&self, name: &str, range: RangeInclusive<T>) -> PyResult<T>
    where
        T: TryFrom<i128> + PartialOrd + Display,
    {
        let value = T::try_from(self.0)
            .ok()
            .filter(|value| range.contains(value));
        value.ok_or_else(|| {
            refused(format_args!(
                "{name} {} is not in [{}, {}]",
                self.0,
                range.start(),
                range.end()
            ))
        })
    }

    /// As a number of values, with room for `each` times as many.
    pub(crate) fn with_room(&self, name: &str, each: usize) -> PyResult<usize> {
        // As many as there can be addresses for.
        let count = self.within(name, 0..=isize::MAX as usize / size_of::<f64>())?;
        room(name, count, each).map(|_: Vec<f64>| count)
    }
}

/// An empty vector with room for `each` times `count` values.
pub(crate) fn room<T>(name: &str, count: usize, each: usize) -> PyResult<Vec<T>> {
    let mut room = Vec::new();
    let wanted = count.saturating_mul(each);
    room.try_reserve_exact(wanted).map_err(|_| {
        refused(format_args!(
            "{name} {count} takes {:.0} GB, more than this machine has: ask for fewer",
            wanted as f64 * size_of::<T>() as f64 * 1e-9
        ))
    })?;
    Ok(room)
}

/// The real numbers of an array of any shape, copied.
#[pyfunction]
pub(crate) fn numbers<'py>(
    name: &str,
    x: &Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let (numbers, shape) = any_shape(name, x)?;
    numbers.into_pyarray(x.py()).reshape(shape)
}
