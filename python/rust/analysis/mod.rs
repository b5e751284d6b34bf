//! The designer's view: what is stable, passive, transparent.

mod coupler;
mod felt;
mod plant;
mod port;
mod region;
mod sampled_loop;

pub(crate) use coupler::PyCoupler;
pub(crate) use felt::transparency;
pub(crate) use plant::{PyDevice, PyLinearPlant};
pub(crate) use port::PyPort;
pub(crate) use region::{PyRegion, stability_region};
pub(crate) use sampled_loop::PyLoop;

use crate::refused::OrRefused as _;
use fracdiff::{Order, Scheme, Seconds};
use haptic_analysis::LoopOperator;
use pyo3::prelude::*;

/// The operator of a wall, from its words; `horizon` in s.
fn operator(order: f64, sample_time: f64, scheme: &str, horizon: f64) -> PyResult<LoopOperator> {
    let (order, scheme) = (
        Order::new(order).or_refused()?,
        scheme.parse::<Scheme>().or_refused()?,
    );
    let sample_time = Seconds(sample_time);
    sample_time.rate_to_the(order).or_refused()?;
    fracdiff::parameter::positive("horizon", horizon, "s").or_refused()?;
    LoopOperator::new(scheme, order, sample_time, horizon / sample_time.0).or_refused()
}

/// A value, and the frequency in rad/s at which it arises.
fn at(value: haptic_analysis::AtAngle, sample_time: f64) -> (f64, f64) {
    (value.value, value.theta / sample_time)
}
