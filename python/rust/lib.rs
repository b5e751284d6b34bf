//! The native module of the Python package `fractional_haptics`: the Rust crates, with NumPy arrays in and out.

mod analysis;
mod arrays;
mod bridge;
mod conducted;
mod control;
mod driving;
mod experiment;
mod json;
mod log;
mod operators;
mod refused;
mod session;
mod tissue;

/// The native module; use the modules of `fractional_haptics` beside it.
#[pyo3::pymodule]
mod _native {
    #[pymodule_export]
    use super::analysis::{
        PyCoupler, PyDevice, PyLinearPlant, PyLoop, PyPort, PyRegion, stability_region,
        transparency,
    };
    #[pymodule_export]
    use super::arrays::numbers;
    #[pymodule_export]
    use super::bridge::PyBridge;
    #[pymodule_export]
    use super::control::{
        PyControlPlant, PyPid, PyTransferFunction, analyze_loop, design_controller, identify_plant,
        simulate_loop,
    };
    #[pymodule_export]
    use super::driving::{forked, let_go};
    #[pymodule_export]
    use super::experiment::{answer, calibrate, experiment_parameters, run_experiment, table};
    #[pymodule_export]
    use super::json::{lines, name_and_unit, quantity};
    #[pymodule_export]
    use super::log::read_log;
    #[pymodule_export]
    use super::operators::{PyOperator, differintegrate, frequency_response, grunwald_weights};
    #[pymodule_export]
    use super::session::{PySession, open_session};
    #[pymodule_export]
    use super::tissue::{
        PyMaterial, PyModel, explain_table, find_material, identify_record, identify_tables,
        library, model_table, restore_model,
    };
    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("COLOURS", haptic_figure::SERIES_COLOURS)?;
        module.add("INK", haptic_figure::INK)?;
        module.add("GRID", haptic_figure::GRID)?;
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
