//! Arrays in and out. In comes whatever NumPy makes an array of, as numbers of 64 bits, copied. A copy costs little beside what is done
//! with it, and another thread cannot change it while the interpreter is released. And how many: counts, and room for them.

use crate::refused::refused;
use num_complex::Complex64;
use pyo3::Borrowed;
use pyo3::prelude::*;
use pyo3::types::{IntoPyDict as _, PyByteArray, PyBytes};
use std::fmt::Display;
use std::ops::RangeInclusive;

/// Kinds of NumPy's types that are real numbers: floating point, signed and unsigned integers.
const REAL: &str = "fiu";

/// An item of an array, in the bytes of this machine.
pub(crate) trait Element: Copy + Send {
    /// Its type, as NumPy calls it.
    const TYPE: &'static str;

    fn put(self, bytes: &mut [u8]);
}

macro_rules! elements {
    ($($number:ty = $name:literal;)*) => {
        $(impl Element for $number {
            const TYPE: &'static str = $name;

            fn put(self, bytes: &mut [u8]) {
                bytes.copy_from_slice(&self.to_ne_bytes());
            }
        })*
    };
}

elements! { f64 = "float64"; u64 = "uint64"; u8 = "uint8"; }

impl Element for bool {
    const TYPE: &'static str = "bool";

    fn put(self, bytes: &mut [u8]) {
        u8::from(self).put(bytes);
    }
}

impl Element for Complex64 {
    const TYPE: &'static str = "complex128";

    fn put(self, bytes: &mut [u8]) {
        let (re, im) = bytes.split_at_mut(bytes.len() / 2);
        self.re.put(re);
        self.im.put(im);
    }
}

/// Numbers that are an array of NumPy as soon as Python has them. The crate `numpy` is not used: it turns on the platform's functions in every
/// complex number.
pub(crate) struct Array<T> {
    values: Vec<T>,
    shape: Vec<usize>,
}

impl<T> Array<T> {
    /// One dimension.
    pub(crate) fn of(values: Vec<T>) -> Self {
        let shape = vec![values.len()];
        Self { values, shape }
    }

    /// Array of as many numbers as the shape has, those of the last axis side by side.
    pub(crate) const fn shaped(values: Vec<T>, shape: Vec<usize>) -> Self {
        Self { values, shape }
    }
}

impl<'py, T: Element> IntoPyObject<'py> for Array<T> {
    type Target = PyAny;
    type Output = Bound<'py, PyAny>;
    type Error = PyErr;

    fn into_pyobject(self, py: Python<'py>) -> PyResult<Self::Output> {
        let bytes = PyByteArray::new_with(py, size_of_val(&*self.values), |bytes| {
            let places = bytes.chunks_exact_mut(size_of::<T>());
            places
                .zip(&self.values)
                .for_each(|(bytes, value)| value.put(bytes));
            Ok(())
        })?;
        let flat = py
            .import("numpy")?
            .call_method1("frombuffer", (bytes, T::TYPE))?;
        flat.call_method1("reshape", (self.shape,))
    }
}

/// The bytes of an argument as items of this type, in the order of its last axis, and its shape; `kinds` are the kinds of types that it may have.
fn converted<'py, T: Element>(
    name: &str,
    x: &Bound<'py, PyAny>,
    kinds: &str,
    dimensions: Option<usize>,
) -> PyResult<(Bound<'py, PyBytes>, Vec<usize>)> {
    unmasked(name, x)?;
    let array = x
        .py()
        .import("numpy")?
        .call_method1("asarray", (x,))
        .map_err(|error| refused(format_args!("{name} is not an array of numbers: {error}")))?;
    let dtype = array.getattr("dtype")?;
    let kind: String = dtype.getattr("kind")?.extract()?;
    if !kinds.contains(&kind) {
        return Err(refused(format_args!(
            "{name} has numbers of type {}, and must have real ones: convert it with astype(float)",
            dtype.str()?
        )));
    }
    let shape = array.getattr("shape")?;
    let lengths: Vec<usize> = shape.extract()?;
    if let Some(wanted) = dimensions.filter(|wanted| *wanted != lengths.len()) {
        return Err(refused(format_args!(
            "{name} has the shape {}, and must have {wanted} dimension{}",
            shape.str()?,
            if wanted == 1 { "" } else { "s" }
        )));
    }
    // The bytes are a copy already.
    let known = [("copy", false)].into_py_dict(x.py())?;
    let bytes = array.call_method("astype", (T::TYPE,), Some(&known))?;
    let bytes = bytes.call_method0("tobytes")?;
    Ok((bytes.cast_into::<PyBytes>()?, lengths))
}

/// The real numbers in bytes of this machine.
fn real(bytes: &Bound<'_, PyBytes>) -> Vec<f64> {
    let (numbers, _) = bytes.as_bytes().as_chunks();
    numbers
        .iter()
        .map(|bytes| f64::from_ne_bytes(*bytes))
        .collect()
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

/// A vector of real numbers; integers are converted.
pub(crate) fn vector(name: &str, x: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    Ok(real(&converted::<f64>(name, x, REAL, Some(1))?.0))
}

/// A matrix of real numbers, row by row, with its number of rows and columns.
pub(crate) fn matrix(name: &str, x: &Bound<'_, PyAny>) -> PyResult<(Vec<f64>, [usize; 2])> {
    let (bytes, shape) = converted::<f64>(name, x, REAL, Some(2))?;
    Ok((real(&bytes), [shape[0], shape[1]]))
}

/// A vector of numbers that may be complex.
pub(crate) fn complex_vector(name: &str, x: &Bound<'_, PyAny>) -> PyResult<Vec<Complex64>> {
    let (bytes, _) = converted::<Complex64>(name, x, "fiuc", Some(1))?;
    let parts = real(&bytes);
    let (pairs, _) = parts.as_chunks();
    Ok(pairs
        .iter()
        .map(|[re, im]| Complex64::new(*re, *im))
        .collect())
}

/// The numbers of an array of any shape, in the order of its last axis.
pub(crate) fn any_shape(name: &str, x: &Bound<'_, PyAny>) -> PyResult<(Vec<f64>, Vec<usize>)> {
    let (bytes, shape) = converted::<f64>(name, x, REAL, None)?;
    Ok((real(&bytes), shape))
}

/// A vector of real numbers as an argument.
pub(crate) struct Vector(pub(crate) Vec<f64>);

impl<'py> FromPyObject<'_, 'py> for Vector {
    type Error = PyErr;

    fn extract(numbers: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        vector("the reference", &numbers).map(Self)
    }
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
    /// Number in a range.
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

    /// Number of values, with room for `each` times as many.
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
pub(crate) fn numbers(name: &str, x: &Bound<'_, PyAny>) -> PyResult<Array<f64>> {
    let (numbers, shape) = any_shape(name, x)?;
    Ok(Array::shaped(numbers, shape))
}
