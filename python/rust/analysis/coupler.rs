//! Fractional virtual couplers.

use super::operator;
use super::plant::{PyDevice, path};
use crate::conducted::{heard, heard_by};
use crate::json::dict;
use crate::refused::OrRefused as _;
use fracdiff::Order;
use haptic_analysis::{CoupledLoop, CoupledObject, Coupler, LeastDamping};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::time::Duration;

/// A fractional virtual coupler between a device and any passive environment; velocity in, force out.
///
/// ::
///
///     Z_c = k_c + b_c s^(-order)
///
/// Parameters
/// ----------
/// order : float
///     0 to 2; 1 is a damper ``k_c`` beside a spring ``b_c``.
/// sample_time : float
///     T in s.
/// damping_n_s_per_m : float
///     k_c in N·s/m.
/// spring_n_s_1_minus_mu_per_m : float
///     b_c in N·s^(1-order)/m.
///
/// Raises
/// ------
/// ValueError
///     A parameter outside its range.
///
/// References
/// ----------
/// O. Tokatlı, *Fractional Order Control in Haptics*, chapter 5; J. E. Colgate, J. M. Brown, 1995.
#[pyclass(name = "Coupler", module = "fractional_haptics.analysis", frozen)]
#[derive(Debug)]
pub(crate) struct PyCoupler {
    order: Order,
    sample_time: f64,
    stiffness: f64,
    dissipation: f64,
}

impl PyCoupler {
    fn coupler(&self) -> PyResult<Coupler<'static>> {
        let (order, stiffness) = (self.order, self.stiffness);
        Coupler::exact(order, self.sample_time, stiffness, self.dissipation).or_refused()
    }
}

/// Infinite where none is enough.
fn number(least: LeastDamping) -> f64 {
    least.damping_n_s_per_m().unwrap_or(f64::INFINITY)
}

#[pymethods]
impl PyCoupler {
    #[new]
    fn new(
        py: Python<'_>,
        order: f64,
        sample_time: f64,
        damping_n_s_per_m: f64,
        spring_n_s_1_minus_mu_per_m: f64,
    ) -> PyResult<Self> {
        let coupler = Self {
            order: Order::new(order).or_refused()?,
            sample_time,
            stiffness: damping_n_s_per_m,
            dissipation: spring_n_s_1_minus_mu_per_m,
        };
        heard(py, Duration::MAX, move |_| {
            coupler.coupler()?;
            Ok(coupler)
        })
    }

    /// Least damping of a device under Tustin's rule that fulfils Llewellyn's conditions, N·s/m; infinite if none does.
    fn least_damping(slf: &Bound<'_, Self>) -> PyResult<f64> {
        heard_by(slf, |coupler, _| {
            coupler.coupler()?.least_damping().map(number).or_refused()
        })
    }

    /// Least damping of the really sampled device that is passive with the coupler and every passive object.
    ///
    /// Parameters
    /// ----------
    /// delay_s, current_lag_s : float, default 0
    ///     As in `Device`.
    ///
    /// Returns
    /// -------
    /// float
    ///     N·s/m; infinite if none is enough.
    #[pyo3(signature = (delay_s = 0.0, current_lag_s = 0.0))]
    fn sampled_damping(slf: &Bound<'_, Self>, delay_s: f64, current_lag_s: f64) -> PyResult<f64> {
        heard_by(slf, move |coupler, _| {
            let path = path(delay_s, current_lag_s, coupler.sample_time)?;
            let least = coupler.coupler()?.sampled_damping(path);
            least.map(number).or_refused()
        })
    }

    /// The damping that Corollary 2 of the dissertation asks for, N·s/m.
    fn corollary_damping(&self) -> PyResult<f64> {
        Ok(self.coupler()?.corollary_damping())
    }

    /// The really sampled loop of a device, this coupler and an object, as a dictionary.
    fn _with_object<'py>(
        slf: &Bound<'py, Self>,
        device: &PyDevice,
        object: (f64, f64, f64),
        scheme: String,
        horizon: f64,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (py, sample_time) = (slf.py(), slf.get().sample_time);
        let dynamics = device.dynamics();
        let object = CoupledObject {
            mass_kg: object.0,
            damping_n_s_per_m: object.1,
            stiffness_n_per_m: object.2,
        };
        let (unstable, margin) = heard_by(slf, move |coupler, _| {
            let difference = operator(1.0 - coupler.order.get(), sample_time, &scheme, horizon)?;
            let coupled = CoupledLoop::new(&dynamics, &coupler.coupler()?, &object, &difference);
            let coupled = coupled.or_refused()?;
            let unstable = coupled.unstable_poles();
            let margin = match unstable {
                Some(0) => coupled.gain_margin().or_refused()?,
                _ => None,
            };
            Ok((unstable, margin))
        })?;
        let margin = margin.map(|margin| super::at(margin, sample_time));
        Ok(dict! {py;
            "stable": unstable == Some(0),
            "unstable_poles": unstable,
            "gain_up": margin,
        })
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> (Bound<'py, PyAny>, (f64, f64, f64, f64)) {
        let coupler = slf.get();
        let arguments = (
            coupler.order.get(),
            coupler.sample_time,
            coupler.stiffness,
            coupler.dissipation,
        );
        (slf.get_type().into_any(), arguments)
    }
}
