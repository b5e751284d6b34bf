//! Transparency: the closed loop as a hand feels it.

use super::operator;
use super::plant::AnyPlant;
use crate::arrays::{complex_vector, vector};
use crate::refused::{OrRefused as _, refused};
use fracdiff::Order;
use haptic_analysis::Environment;
use numpy::PyArray1;
use pyo3::prelude::*;

/// Two columns.
type Pair<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>);

/// Effective stiffness and damping of the closed loop at frequencies; `impedance` is that of the plant there, without hand.
#[expect(
    clippy::too_many_arguments,
    reason = "the wrapper in Python names them"
)]
#[pyfunction]
pub(crate) fn transparency<'py>(
    omega: &Bound<'py, PyAny>,
    impedance: &Bound<'py, PyAny>,
    plant: AnyPlant<'py>,
    stiffness_n_per_m: f64,
    dissipation_n_s_mu_per_m: f64,
    order: f64,
    sample_time: f64,
    scheme: &str,
    horizon: f64,
) -> PyResult<Pair<'py>> {
    let py = omega.py();
    let omega = vector("omega", omega)?;
    let impedance = complex_vector("impedance", impedance)?;
    let operator = operator(order, sample_time, scheme, horizon)?;
    let wall = Environment {
        stiffness_n_per_m,
        dissipation_n_s_mu_per_m,
        order: Order::new(order).or_refused()?,
        sample_time_s: sample_time,
    };
    let path = plant.path(sample_time)?;
    let (mut stiffness, mut damping) = (Vec::new(), Vec::new());
    for (index, (&omega, &impedance)) in omega.iter().zip(&impedance).enumerate() {
        let felt = wall.felt_on(impedance, path, operator.as_ref(), omega);
        let felt = felt.map_err(|error| refused(format_args!("omega[{index}]: {error}")))?;
        stiffness.push(felt.stiffness_n_per_m);
        damping.push(felt.damping_n_s_per_m);
    }
    Ok((
        PyArray1::from_vec(py, stiffness),
        PyArray1::from_vec(py, damping),
    ))
}
