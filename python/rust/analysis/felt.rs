//! Transparency: the closed loop as a hand feels it.

use super::environment;
use super::plant::AnyPlant;
use crate::arrays::{complex_vector, vector};
use crate::conducted::heard;
use crate::refused::refused;
use numpy::PyArray1;
use pyo3::prelude::*;
use std::time::Duration;

/// Two columns.
type Pair<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>);

/// Effective stiffness and damping of the closed loop at frequencies; `impedance` is that of the plant there, without hand. A
/// wall is K, B and order, an operator sample time, scheme and horizon.
#[pyfunction]
pub(crate) fn transparency<'py>(
    omega: &Bound<'py, PyAny>,
    impedance: &Bound<'py, PyAny>,
    plant: AnyPlant,
    wall: (f64, f64, f64),
    operator: (f64, String, f64),
) -> PyResult<Pair<'py>> {
    let py = omega.py();
    let omega = vector("omega", omega)?;
    let impedance = complex_vector("impedance", impedance)?;
    let (sample_time, scheme, horizon) = operator;
    let (stiffness, damping) = heard(py, Duration::MAX, move |_| {
        let operator = super::operator(wall.2, sample_time, &scheme, horizon)?;
        let wall = environment(wall, sample_time)?;
        let path = plant.path(sample_time)?;
        let (mut stiffness, mut damping) = (Vec::new(), Vec::new());
        for (index, (&omega, &impedance)) in omega.iter().zip(&impedance).enumerate() {
            let felt = wall.felt_on(impedance, path, operator.as_ref(), omega);
            let felt = felt.map_err(|error| refused(format_args!("omega[{index}]: {error}")))?;
            stiffness.push(felt.stiffness_n_per_m);
            damping.push(felt.damping_n_s_per_m);
        }
        Ok((stiffness, damping))
    })?;
    Ok((
        PyArray1::from_vec(py, stiffness),
        PyArray1::from_vec(py, damping),
    ))
}
