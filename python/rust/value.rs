//! Values: equal, hashed and pickled by what makes them, which is what `__reduce__` says.

use pyo3::PyClass;
use pyo3::prelude::*;

/// True for two of one type that are made of the same.
pub(crate) fn equal<C: PyClass>(one: &Bound<'_, C>, other: &Bound<'_, PyAny>) -> PyResult<bool> {
    if !other.get_type().is(one.as_any().get_type()) {
        return Ok(false);
    }
    let made = one.as_any().call_method0("__reduce__")?;
    made.eq(other.call_method0("__reduce__")?)
}

/// The hash of what makes it.
pub(crate) fn hash<C: PyClass>(one: &Bound<'_, C>) -> PyResult<isize> {
    one.as_any().call_method0("__reduce__")?.hash()
}
