//! The native module of the Python package `fractional_haptics`: the Rust crates, with NumPy arrays in and out.

use pyo3::prelude::*;

/// The native module `fractional_haptics._native`; use the modules beside it.
#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    Ok(())
}
