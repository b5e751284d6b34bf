//! A loop closed over a virtual wall: verdict, margins, sensitivity.

use super::plant::AnyPlant;
use super::{at, environment, operator, scheme_of};
use crate::arrays::{Array, Element, frequencies};
use crate::conducted::{heard, heard_by};
use crate::json::dict;
use crate::refused::OrRefused as _;
use haptic_analysis::{Dynamics, LoopOperator, SampledLoop, SampledPlant};
use num_complex::Complex64;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;
use std::time::Duration;

/// A plant under a sampled virtual wall ``K + B D^order``.
///
/// ::
///
///     f = -(K x + B D^order x),  held between samples
///
/// Parameters
/// ----------
/// plant : Device, LinearPlant or control.StateSpace
///     From force to position.
/// stiffness_n_per_m : float
///     K, at least 0.
/// dissipation_n_s_mu_per_m : float
///     B, at least 0.
/// order : float
///     Order of B's operator, 0 to 2.
/// sample_time : float
///     T in s.
/// scheme : str, default "exact"
///     The operator that runs, see `fractional_haptics.operators`.
/// horizon : float, default 3600
///     As in `Operator`.
///
/// Raises
/// ------
/// ValueError
///     A parameter outside its range.
///
/// Notes
/// -----
/// Stability is certified: zeros of the characteristic function are counted with bounds, not on a grid. Every method
/// releases the interpreter.
///
/// References
/// ----------
/// O. Tokatlı, *Fractional Order Control in Haptics*; the crate ``haptic-analysis``.
///
/// Examples
/// --------
/// >>> from fractional_haptics.analysis import Device, Loop
/// >>> Loop(Device(0.065, 3.5), 1000.0, 3.0, 0.5, 1e-3).verdict().stable
/// True
#[pyclass(name = "Loop", module = "fractional_haptics._native", frozen, subclass)]
#[derive(Debug)]
pub(crate) struct PyLoop {
    plant: SampledPlant,
    alpha: f64,
    beta: f64,
    operator: Arc<LoopOperator>,
    sample_time: f64,
    made: Made,
}

/// The arguments of a loop: plant, K, B, order, sample time, scheme, horizon.
type Made = (AnyPlant, f64, f64, f64, f64, String, f64);

impl PyLoop {
    fn sampled(&self) -> PyResult<SampledLoop<'_>> {
        SampledLoop::with_plant(self.plant, self.alpha, self.beta, &self.operator).or_refused()
    }

    /// A function of θ at frequencies in rad/s up to half the sample rate, above 0.
    fn over<'py, T: Element + 'static>(
        slf: &Bound<'py, Self>,
        omega: &Bound<'py, PyAny>,
        function: impl Fn(&SampledLoop<'_>, f64) -> T + Send + 'static,
    ) -> PyResult<Array<T>> {
        let sample_time = slf.get().sample_time;
        let (omega, shape) = frequencies(omega, sample_time, false)?;
        let values: Vec<T> = heard_by(slf, move |closed_loop, conduct| {
            let sampled_loop = closed_loop.sampled()?;
            Ok(conduct.each(&omega, |w| function(&sampled_loop, w * sample_time)))
        })?;
        Ok(Array::shaped(values, shape))
    }
}

#[pymethods]
impl PyLoop {
    #[expect(
        clippy::too_many_arguments,
        reason = "the wrapper in Python names them"
    )]
    #[new]
    fn new(
        py: Python<'_>,
        plant: AnyPlant,
        stiffness_n_per_m: f64,
        dissipation_n_s_mu_per_m: f64,
        order: f64,
        sample_time: f64,
        scheme: String,
        horizon: f64,
    ) -> PyResult<Self> {
        heard(py, Duration::MAX, move |_| {
            let operator = operator(order, sample_time, &scheme, horizon)?;
            let (k, b) = (stiffness_n_per_m, dissipation_n_s_mu_per_m);
            let unit = Dynamics::ideal(plant.mass_kg(), 0.0)
                .nondimensional(&environment(k, b, order, sample_time)?)
                .or_refused()?;
            let scheme = scheme_of(&scheme)?.to_string();
            Ok(Self {
                plant: plant.sampled(sample_time)?,
                alpha: unit.alpha,
                beta: unit.beta,
                operator,
                sample_time,
                made: (plant, k, b, order, sample_time, scheme, horizon),
            })
        })
    }

    /// The verdict as a dictionary.
    fn _verdict<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyDict>> {
        let (verdict, radius, drifts) = heard_by(slf, |closed_loop, _| {
            let sampled_loop = closed_loop.sampled()?;
            let judged = sampled_loop.beside_rest();
            Ok((
                judged.verdict(),
                judged.spectral_radius(),
                sampled_loop.drifts(),
            ))
        })?;
        Ok(dict! {slf.py();
            "stable": verdict.stable,
            "unstable_poles": verdict.unstable_poles,
            "distance": verdict.distance,
            "omega_rad_s": verdict.theta / slf.get().sample_time,
            "spectral_radius": radius,
            "drifts": drifts,
        })
    }

    /// The margins as a dictionary of pairs.
    fn _margins<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyDict>> {
        let margins = heard_by(slf, |closed_loop, _| {
            closed_loop.sampled()?.beside_rest().margins().or_refused()
        })?;
        let sample_time = slf.get().sample_time;
        let pair = |value| at(value, sample_time);
        let delay = margins.delay.map(pair);
        Ok(dict! {slf.py();
            "gain_up": margins.gain_up.map(pair),
            "gain_down": margins.gain_down.map(pair),
            "delay_s": delay.map(|(samples, omega)| (samples * sample_time, omega)),
            "sensitivity": pair(margins.sensitivity),
        })
    }

    /// Largest slope of contact for stability under every motion, as a dictionary.
    fn _slope_limit<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyDict>> {
        let limit = heard_by(slf, |closed_loop, _| {
            Ok(closed_loop.sampled()?.slope_limit())
        })?;
        Ok(dict! {slf.py();
            "linear": limit.linear,
            "provable": limit.provable,
            "proved": limit.proved,
            "multiplier": limit.multiplier,
        })
    }

    /// The peak of the sensitivity as a pair.
    fn _sensitivity_peak(slf: &Bound<'_, Self>) -> PyResult<(f64, f64)> {
        let peak = heard_by(slf, |closed_loop, _| {
            closed_loop
                .sampled()?
                .beside_rest()
                .sensitivity_peak()
                .or_refused()
        })?;
        Ok(at(peak, slf.get().sample_time))
    }

    /// Loop gain.
    ///
    /// Parameters
    /// ----------
    /// omega : array_like
    ///     Frequencies in rad/s, above 0 up to pi/T, of any shape.
    ///
    /// Returns
    /// -------
    /// ndarray of complex, same shape
    ///     GH(exp(-j omega T)), without unit; -1 is the critical point.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     A frequency above half the sample rate, with its index.
    fn loop_gain<'py>(
        slf: &Bound<'py, Self>,
        omega: &Bound<'py, PyAny>,
    ) -> PyResult<Array<Complex64>> {
        Self::over(slf, omega, |sampled_loop, theta| {
            sampled_loop.loop_gain(theta)
        })
    }

    /// Sensitivity.
    ///
    /// Parameters
    /// ----------
    /// omega : array_like
    ///     As in `loop_gain`.
    ///
    /// Returns
    /// -------
    /// ndarray, same shape
    ///     abs(1/(1 + GH)): how much a disturbance of the position is amplified.
    fn sensitivity<'py>(slf: &Bound<'py, Self>, omega: &Bound<'py, PyAny>) -> PyResult<Array<f64>> {
        Self::over(slf, omega, |sampled_loop, theta| {
            sampled_loop.sensitivity(theta)
        })
    }

    /// Poles in z, for operators that are polynomials or rational; those at 0 left out.
    ///
    /// Returns
    /// -------
    /// ndarray of complex, or None for the other operators
    fn poles<'py>(slf: &Bound<'py, Self>) -> PyResult<Option<Array<Complex64>>> {
        let poles = heard_by(slf, |closed_loop, _| Ok(closed_loop.sampled()?.poles()))?;
        Ok(poles.map(Array::of))
    }

    /// T in s.
    #[getter]
    fn sample_time(&self) -> f64 {
        self.sample_time
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let (py, closed_loop) = (slf.py(), slf.get());
        Ok((slf.get_type(), &closed_loop.made)
            .into_pyobject(py)?
            .into_any())
    }
}
