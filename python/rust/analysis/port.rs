//! Passivity of a device under a wall.

use super::plant::path;
use super::{operator, scheme_of};
use crate::conducted::{heard, heard_by};
use crate::refused::OrRefused as _;
use fracdiff::Seconds;
use haptic_analysis::{ForcePath, Largest, LoopOperator, OnePort};
use pyo3::prelude::*;
use std::sync::Arc;
use std::time::Duration;

/// The port of an actuator under a sampled wall ``K + B D^order``, for passivity.
///
/// Parameters
/// ----------
/// order : float
///     0 to 2.
/// sample_time : float
///     T in s.
/// scheme : str, default "exact"
///     The operator that runs.
/// delay_s, current_lag_s : float, default 0
///     As in `Device`.
/// horizon : float, default 3600
///     As in `Operator`.
///
/// Notes
/// -----
/// Passive for every motion, inside samples too. The mass does not matter.
///
/// References
/// ----------
/// O. Tokatlı, *Fractional Order Control in Haptics*, eq. 3.14, after J. E. Colgate, G. Schenkel, *Passivity of a class of
/// sampled-data systems*, J. Robotic Systems 14(1), 1997.
///
/// Examples
/// --------
/// Colgate: a wall is passive for ``b > K T/2 + B``.
///
/// >>> from fractional_haptics.analysis import Port
/// >>> Port(1.0, 1e-3).largest_stiffness(3.5, 0.5)  # doctest: +ELLIPSIS
/// 6000.0...
#[pyclass(name = "Port", module = "fractional_haptics.analysis", frozen)]
#[derive(Debug)]
pub(crate) struct PyPort {
    operator: Arc<LoopOperator>,
    path: ForcePath,
    sample_time: Seconds,
    made: Made,
}

impl PyPort {
    fn port(&self) -> PyResult<OnePort<'_, LoopOperator>> {
        let port = OnePort::new(self.operator.as_ref(), self.operator.order()).or_refused()?;
        Ok(port
            .through(self.path)
            .or_refused()?
            .with_memory(self.operator.memory()))
    }
}

/// The largest value of a parameter: infinite if any is passive, NaN if none is.
fn number(largest: Largest) -> f64 {
    match largest {
        Largest::Below { value, .. } => value,
        Largest::Any => f64::INFINITY,
        Largest::Empty => f64::NAN,
    }
}

#[pymethods]
impl PyPort {
    #[new]
    #[pyo3(signature = (order, sample_time, scheme = "exact", delay_s = 0.0, current_lag_s = 0.0, horizon = 3600.0))]
    fn new(
        py: Python<'_>,
        order: f64,
        sample_time: f64,
        scheme: &str,
        delay_s: f64,
        current_lag_s: f64,
        horizon: f64,
    ) -> PyResult<Self> {
        let scheme = scheme.to_owned();
        heard(py, Duration::MAX, move |_| {
            let form = scheme_of(&scheme)?.to_string();
            let port = Self {
                operator: operator(order, sample_time, &scheme, horizon)?,
                path: path(delay_s, current_lag_s, sample_time)?,
                sample_time: Seconds(sample_time),
                made: (order, sample_time, form, delay_s, current_lag_s, horizon),
            };
            port.port()?;
            Ok(port)
        })
    }

    /// Damping that passivity takes.
    ///
    /// Parameters
    /// ----------
    /// stiffness_n_per_m, dissipation_n_s_mu_per_m : float
    ///     K and B.
    ///
    /// Returns
    /// -------
    /// float
    ///     The wall is passive on a device with more than this, N·s/m; infinite where none is enough, as with a negative
    ///     spring at rest.
    fn required_damping(
        slf: &Bound<'_, Self>,
        stiffness_n_per_m: f64,
        dissipation_n_s_mu_per_m: f64,
    ) -> PyResult<f64> {
        heard_by(slf, move |wall, _| {
            let port = wall.port()?;
            let (t, k, b) = (
                wall.sample_time,
                stiffness_n_per_m,
                dissipation_n_s_mu_per_m,
            );
            port.required_damping(t, k, b).or_refused()
        })
    }

    /// Largest stiffness that stays passive.
    ///
    /// Parameters
    /// ----------
    /// damping_n_s_per_m : float
    ///     b of the device.
    /// dissipation_n_s_mu_per_m : float, default 0
    ///     B.
    ///
    /// Returns
    /// -------
    /// float
    ///     N/m; infinite if any is passive, NaN if none is.
    #[pyo3(signature = (damping_n_s_per_m, dissipation_n_s_mu_per_m = 0.0))]
    fn largest_stiffness(
        slf: &Bound<'_, Self>,
        damping_n_s_per_m: f64,
        dissipation_n_s_mu_per_m: f64,
    ) -> PyResult<f64> {
        heard_by(slf, move |wall, _| {
            let (t, port) = (wall.sample_time, wall.port()?);
            let largest = port.largest_stiffness(t, damping_n_s_per_m, dissipation_n_s_mu_per_m);
            largest.map(number).or_refused()
        })
    }

    /// Largest dissipation that stays passive.
    ///
    /// Parameters
    /// ----------
    /// damping_n_s_per_m : float
    ///     b of the device.
    /// stiffness_n_per_m : float, default 0
    ///     K.
    ///
    /// Returns
    /// -------
    /// float
    ///     N·s^order/m; infinite if any is passive, NaN if none is.
    #[pyo3(signature = (damping_n_s_per_m, stiffness_n_per_m = 0.0))]
    fn largest_dissipation(
        slf: &Bound<'_, Self>,
        damping_n_s_per_m: f64,
        stiffness_n_per_m: f64,
    ) -> PyResult<f64> {
        heard_by(slf, move |wall, _| {
            let (t, port) = (wall.sample_time, wall.port()?);
            let largest = port.largest_dissipation(t, damping_n_s_per_m, stiffness_n_per_m);
            largest.map(number).or_refused()
        })
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> (Bound<'py, PyAny>, Made) {
        (slf.get_type().into_any(), slf.get().made.clone())
    }
}

/// The arguments of a port: order, sample time, scheme, delay, lag, horizon.
type Made = (f64, f64, String, f64, f64, f64);
