//! The designer's view: what is stable, passive, transparent.

mod coupler;
mod plant;
mod port;
mod region;
mod sampled_loop;

pub(crate) use coupler::PyCoupler;
pub(crate) use plant::{PyDevice, PyLinearPlant};
pub(crate) use port::PyPort;
pub(crate) use region::{PyRegion, stability_region};
pub(crate) use sampled_loop::PyLoop;

use crate::arrays::{Array, complex_vector, vector};
use crate::conducted::heard;
use crate::operators::scheme_of;
use crate::refused::{OrRefused as _, refused};
use fracdiff::{Order, Seconds};
use haptic_analysis::{LoopOperator, SampledWall};
use plant::AnyPlant;
use pyo3::prelude::*;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// An operator by order, sample time, scheme and horizon, as bits.
type Known = ((u64, u64, String, u64), Arc<LoopOperator>);

/// The operators that were asked for last, newest first: a full memory takes milliseconds to design, and the next question is
/// mostly about another wall with the same one.
static KNOWN: Mutex<Vec<Known>> = Mutex::new(Vec::new());
/// Most of them that are kept, some 20 kB each at most.
const KNOWN_MOST: usize = 64;

/// The operator of a wall, from its words; `horizon` in s.
fn operator(
    order: f64,
    sample_time: f64,
    scheme: &str,
    horizon: f64,
) -> PyResult<Arc<LoopOperator>> {
    let key = (
        order.to_bits(),
        sample_time.to_bits(),
        scheme.to_owned(),
        horizon.to_bits(),
    );
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(index) = known.iter().position(|(known, _)| *known == key) {
        known[..=index].rotate_right(1);
        return Ok(Arc::clone(&known[0].1));
    }
    drop(known);
    let operator = Arc::new(designed(order, sample_time, scheme, horizon)?);
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    known.truncate(KNOWN_MOST - 1);
    known.insert(0, (key, Arc::clone(&operator)));
    Ok(operator)
}

/// K, B and order as a sampled wall.
fn environment(
    stiffness_n_per_m: f64,
    dissipation_n_s_mu_per_m: f64,
    order: f64,
    sample_time_s: f64,
) -> PyResult<SampledWall> {
    Ok(SampledWall {
        stiffness_n_per_m,
        dissipation_n_s_mu_per_m,
        order: Order::new(order).or_refused()?,
        sample_time_s,
    })
}

fn designed(order: f64, sample_time: f64, scheme: &str, horizon: f64) -> PyResult<LoopOperator> {
    let (order, scheme) = (Order::new(order).or_refused()?, scheme_of(scheme)?);
    let sample_time = Seconds(sample_time);
    sample_time.rate_to_the(order).or_refused()?;
    fracdiff::parameter::positive("horizon", horizon, "s").or_refused()?;
    LoopOperator::new(scheme, order, sample_time, horizon / sample_time.0).or_refused()
}

/// A value, and the frequency in rad/s at which it arises.
fn at(value: haptic_analysis::AtAngle, sample_time: f64) -> (f64, f64) {
    (value.value, value.theta / sample_time)
}

/// Stiffness and damping at each frequency.
type Pair<'py> = (Array<f64>, Array<f64>);

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
        let operator = self::operator(wall.2, sample_time, &scheme, horizon)?;
        let wall = environment(wall.0, wall.1, wall.2, sample_time)?;
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
    Ok((Array::of(stiffness), Array::of(damping)))
}
