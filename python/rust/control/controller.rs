//! A fractional PID controller, sample by sample.

use super::memory;
use super::transfer::responses;
use crate::conducted::heard;
use crate::json::dict;
use crate::refused::OrRefused as _;
use fracdiff::Seconds;
use fracdiff::parameter::range;
use fractional_control::{
    Actuator, ControllerSetup, FractionalPid, PidParameters, SetPoint, Station,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::time::Duration;

/// The controller and the history of its loop.
type Running = Station<f64, FractionalPid<f64, MODES>>;

/// Modes of each memory: enough for 1e-9 over a day at 1 kHz.
const MODES: usize = 64;

/// PI^lambda D^mu: ``u = Kp (b r - y) + Ki I^lambda (r - y) + Kd D^mu (c r - y)``, limited, with anti-windup.
///
/// Parameters
/// ----------
/// sample_time : float
///     T in s.
/// proportional, integral, derivative : float, default 0
///     Kp in [u]/[y], Ki in [u]/[y] s^(-lambda), Kd in [u]/[y] s^mu.
/// integral_order, derivative_order : float, default 1
///     lambda and mu, above 0 and at most 2.
/// low, high : float, default infinite
///     Limits of the command.
/// proportional_weight, derivative_weight : float, default 1 and 0
///     b and c: the share of the reference that both parts see.
/// rule : {"bdf2", "grunwald"}
///     s as a function of the delay: an error of O(T^2) or O(T).
/// tolerance : float, default 1e-6
///     Of each weight of the memories.
/// horizon : float, default 3600
///     Up to which time it holds, s.
///
/// Raises
/// ------
/// ValueError
///     A parameter outside its range.
///
/// Notes
/// -----
/// `output` before the command leaves, `advance` after it has left; `step` is both. Beside a plant that runs already, `settle` first.
///
/// A reference or measurement that is not a finite number holds the last command for its sample; `missed` counts them, and from the
/// tenth in a row on the command is 0.
///
/// References
/// ----------
/// I. Podlubny, *Fractional-order systems and PI^λD^μ-controllers*, IEEE Trans. Automatic Control 44(1), 1999; the crate
/// ``fractional-control``.
///
/// Examples
/// --------
/// >>> from fractional_haptics.control import Pid
/// >>> pid = Pid(1e-3, proportional=2.0, integral=1.0, integral_order=0.8, low=-3.0, high=3.0)
/// >>> pid.step(5.0, 0.0)
/// 3.0
///
/// A heater that stands at 20 °C and shall stay there:
///
/// >>> pid = Pid(0.1, proportional=2.0, integral=0.1, derivative=0.5)
/// >>> pid.settle(20.0)
/// 0.0
/// >>> pid.step(20.0, 20.0)
/// 0.0
#[pyclass(name = "Pid", module = "fractional_haptics.control", subclass)]
#[derive(Debug)]
pub(crate) struct PyPid {
    running: Running,
    parameters: PidParameters,
    /// Parameters, memory and limits, for a loop.
    pub(super) setup: ControllerSetup,
}

#[pymethods]
impl PyPid {
    #[expect(clippy::too_many_arguments, reason = "Python names them")]
    #[new]
    #[pyo3(signature = (sample_time, *, proportional = 0.0, integral = 0.0, integral_order = 1.0, derivative = 0.0,
        derivative_order = 1.0, low = f64::NEG_INFINITY, high = f64::INFINITY, proportional_weight = 1.0,
        derivative_weight = 0.0, rule = "bdf2", tolerance = 1e-6, horizon = 3600.0))]
    fn new(
        py: Python<'_>,
        sample_time: f64,
        proportional: f64,
        integral: f64,
        integral_order: f64,
        derivative: f64,
        derivative_order: f64,
        low: f64,
        high: f64,
        proportional_weight: f64,
        derivative_weight: f64,
        rule: &str,
        tolerance: f64,
        horizon: f64,
    ) -> PyResult<Self> {
        let parameters = PidParameters {
            proportional,
            integral,
            integral_order,
            derivative,
            derivative_order,
        };
        let set_point = SetPoint {
            proportional: proportional_weight,
            derivative: derivative_weight,
        };
        let actuator = Actuator::new(low, high).or_refused()?;
        let (memory, sample_time) = (memory(rule, tolerance, horizon)?, Seconds(sample_time));
        let limit = |end: f64| end.is_finite().then_some(end);
        let setup = ControllerSetup {
            set_point,
            output_low: limit(low),
            output_high: limit(high),
            scheme: memory.scheme(),
            memory_s: Some(horizon),
            ..ControllerSetup::new(parameters, sample_time)
        };
        let controller = heard(py, Duration::MAX, move |_| {
            FractionalPid::new(parameters, set_point, actuator, memory, sample_time).or_refused()
        })?;
        Ok(Self {
            running: Station::new(controller),
            parameters,
            setup,
        })
    }

    /// The command for reference r and measured y; the history stays as it is.
    #[pyo3(signature = (reference, measured, /))]
    fn output(&self, reference: f64, measured: f64) -> f64 {
        self.running.output(reference, measured)
    }

    /// Takes the sample into the history, with the command that was applied; NaN if that is unknown.
    #[pyo3(signature = (reference, measured, applied, /))]
    fn advance(&mut self, reference: f64, measured: f64, applied: f64) {
        self.running.advance(reference, measured, applied);
    }

    /// The command, which is then taken as applied.
    #[pyo3(signature = (reference, measured, /))]
    fn step(&mut self, reference: f64, measured: f64) -> f64 {
        self.running.step(reference, measured)
    }

    /// Starts as if measurement, reference and command had stood for ever: beside a plant that runs already.
    ///
    /// Parameters
    /// ----------
    /// measured : float
    ///     The measurement.
    /// reference : float, default measured
    ///     The reference.
    /// command : float, default 0
    ///     The command that stands, by hand or from another controller; NaN if that is unknown. An integral keeps it; without one it
    ///     fades with 1 s.
    ///
    /// Returns
    /// -------
    /// float
    ///     The bump that is left: by how much the next command differs from this one, as beyond a limit.
    #[pyo3(signature = (measured, /, *, reference = None, command = 0.0))]
    fn settle(&mut self, measured: f64, reference: Option<f64>, command: f64) -> PyResult<f64> {
        let reference = reference.unwrap_or(measured);
        for (what, value) in [("measured", measured), ("reference", reference)] {
            range(what, value, true, "finite", "").or_refused()?;
        }
        // A PID rests everywhere.
        Ok((self.running)
            .settle(reference, measured, command)
            .unwrap_or_default())
    }

    /// Samples in a row, up to now, whose reference or measurement was NaN.
    #[getter]
    fn missed(&self) -> u32 {
        self.running.missed()
    }

    /// Forgets the past.
    fn reset(&mut self) {
        self.running.reset();
    }

    /// C(j omega) in continuous time, for frequencies in rad/s of any shape.
    fn response<'py>(&self, omega: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        let parameters = self.parameters;
        responses(omega, move |omega| parameters.response(omega))
    }

    /// Gains and orders: the keywords that make it.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let of = &self.parameters;
        Ok(dict! {py;
            "proportional": of.proportional,
            "integral": of.integral,
            "integral_order": of.integral_order,
            "derivative": of.derivative,
            "derivative_order": of.derivative_order,
        })
    }

    /// T in s.
    #[getter]
    fn sample_time(&self) -> f64 {
        self.setup.sample_time_s
    }

    fn __str__(&self) -> String {
        self.parameters.to_string()
    }

    fn __repr__(&self) -> String {
        format!(
            "<Pid {} at {} s>",
            self.parameters, self.setup.sample_time_s
        )
    }
}
