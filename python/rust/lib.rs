//! The native module of the Python package `fractional_haptics`: the Rust crates, with NumPy arrays in and out.

mod arrays;
mod operators;
mod refused;

/// The native module; use the modules of `fractional_haptics` beside it.
#[pyo3::pymodule]
mod _native {
    #[pymodule_export]
    use super::operators::{PyOperator, differintegrate, frequency_response, grunwald_weights};
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
