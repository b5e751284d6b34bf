//! Passivity of a device under a wall.

use super::operator;
use crate::refused::OrRefused as _;
use fracdiff::Seconds;
use haptic_analysis::{Dynamics, ForcePath, Largest, LoopOperator, OnePort, RequiredDamping};
use pyo3::prelude::*;
use std::sync::Arc;

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
        order: f64,
        sample_time: f64,
        scheme: &str,
        delay_s: f64,
        current_lag_s: f64,
        horizon: f64,
    ) -> PyResult<Self> {
        let dynamics = Dynamics {
            delay_s,
            current_lag_s,
            ..Dynamics::ideal(1.0, 0.0)
        };
        let port = Self {
            operator: operator(order, sample_time, scheme, horizon)?,
            path: dynamics.path(sample_time).or_refused()?,
            sample_time: Seconds(sample_time),
        };
        port.port()?;
        Ok(port)
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
        &self,
        py: Python<'_>,
        stiffness_n_per_m: f64,
        dissipation_n_s_mu_per_m: f64,
    ) -> PyResult<f64> {
        let port = self.port()?;
        let required: RequiredDamping = py
            .detach(|| {
                port.required_damping(
                    self.sample_time,
                    stiffness_n_per_m,
                    dissipation_n_s_mu_per_m,
                )
            })
            .or_refused()?;
        Ok(if required.negative_at_rest {
            f64::INFINITY
        } else {
            required.damping_n_s_per_m
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
        &self,
        py: Python<'_>,
        damping_n_s_per_m: f64,
        dissipation_n_s_mu_per_m: f64,
    ) -> PyResult<f64> {
        let port = self.port()?;
        let largest = py.detach(|| {
            port.largest_stiffness(
                self.sample_time,
                damping_n_s_per_m,
                dissipation_n_s_mu_per_m,
            )
        });
        largest.map(number).or_refused()
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
        &self,
        py: Python<'_>,
        damping_n_s_per_m: f64,
        stiffness_n_per_m: f64,
    ) -> PyResult<f64> {
        let port = self.port()?;
        let largest = py.detach(|| {
            port.largest_dissipation(self.sample_time, damping_n_s_per_m, stiffness_n_per_m)
        });
        largest.map(number).or_refused()
    }
}
