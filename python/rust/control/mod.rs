//! Fractional control: transfer functions, controllers, tuning.

mod closed;
mod controller;
mod identified;
mod transfer;

pub(crate) use closed::{analyze_loop, design_controller, simulate_loop};
pub(crate) use controller::PyPid;
pub(crate) use identified::identify_plant;
pub(crate) use transfer::{PyControlPlant, PyTransferFunction};

use crate::refused::{OrRefused as _, refused};
use fractional_control::{PowerMemory, Rule};
use pyo3::prelude::*;

fn memory(name: &str, tolerance: f64, horizon: f64) -> PyResult<PowerMemory> {
    let rule = match name {
        "grunwald" => Rule::Grunwald,
        "bdf2" => Rule::Bdf2,
        _ => {
            let why = format_args!("rule \"{name}\" is not one of grunwald, bdf2");
            return Err(refused(why));
        }
    };
    PowerMemory::new(rule, tolerance, horizon).or_refused()
}
