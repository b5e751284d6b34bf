//! Values: equal, hashed and pickled by what makes them, which is what `__reduce__` says.

use pyo3::PyClass;
use pyo3::prelude::*;

/// Made of the same.
pub(crate) fn equal<C: PyClass>(own: &Bound<'_, C>, other: &Bound<'_, PyAny>) -> PyResult<bool> {
    let own = own.as_any();
    if !other.get_type().is(own.get_type()) {
        return Ok(false);
    }
    let made = own.call_method0("__reduce__")?;
    made.eq(other.call_method0("__reduce__")?)
}

/// The hash of what makes it.
pub(crate) fn hash<C: PyClass>(own: &Bound<'_, C>) -> PyResult<isize> {
    own.as_any().call_method0("__reduce__")?.hash()
}
