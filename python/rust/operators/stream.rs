//! An operator of a stream, and the frequency response of any.

use super::{Axis, scheme_of};
use crate::arrays::{Array, Whole, frequencies, room, vector};
use crate::conducted::{Conduct, LONG, heard};
use crate::refused::{OrRefused as _, refused};
use fracdiff::parameter::positive;
use fracdiff::{
    Channel, ExactDifference, FrequencyResponse as _, OperatorHistory, Order, Scheme, Seconds,
};
use num_complex::Complex64;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::time::Duration;

/// D^μ of one signal, sample by sample or block by block.
///
/// ::
///
///     y[n] = T^(-order) * sum_j w_j (x[n-j] - reference)
///
/// Parameters
/// ----------
/// order : float
///     Order, -2 to 2: positive differentiates, negative integrates.
/// sample_time : float
///     Time T between samples in s, 1e-9 to 1e6.
/// scheme : str, default "full"
///     ``grunwald:N``, ``muir:N``, ``tustin-muir:N``, ``oustaloup:N:LOW_HZ:HIGH_HZ``, ``full[:TOLERANCE]``,
///     ``piecewise-linear[:TOLERANCE]`` or ``full-bdf2[:TOLERANCE]``.
/// horizon : float, default 3600
///     Longest duration of the stream in s, for the schemes with a tolerance: up to there it holds.
///
/// Raises
/// ------
/// ValueError
///     A parameter outside its range, an unknown scheme, a tolerance that cannot be reached.
///
/// Notes
/// -----
/// A new operator is at rest: the signal was 0 for ever. A NaN or an infinity makes the outputs that it reaches not
/// finite, which are all of them but for ``grunwald`` and ``muir``; `reset` forgets it. An operator belongs to one thread at
/// a time: `process` releases the interpreter, and a call from another thread meanwhile is a ``RuntimeError``. Pickling and
/// copying keep the history: the copy continues where the original stood, to the bit.
///
/// References
/// ----------
/// I. Podlubny, *Fractional Differential Equations*, Academic Press, 1999, chapter 7; the crate ``fracdiff``.
///
/// Examples
/// --------
/// >>> import numpy as np
/// >>> from fractional_haptics.operators import Operator
/// >>> half = Operator(0.5, 1e-3, "grunwald:1000")
/// >>> half.step(1.0)  # doctest: +ELLIPSIS
/// 31.62...
/// >>> half.process(np.ones(3)).shape
/// (3,)
#[pyclass(name = "Operator", module = "fractional_haptics.operators")]
#[derive(Debug)]
pub(crate) struct PyOperator {
    axis: Axis,
    order: Order,
    sample_time: Seconds,
    scheme: Scheme,
    horizon: f64,
}

/// The arguments that make an operator.
type Recipe = (f64, f64, String, f64);

/// State for pickling beside the arguments: the history as bytes, and the reference.
type State<'py> = (Bound<'py, PyBytes>, f64);

/// Samples in, outputs in their place, until it is to stop.
fn run_unless(conduct: &Conduct, axis: &mut Axis, samples: &mut [f64]) {
    for block in samples.chunks_mut(1 << 12) {
        if conduct.stops() {
            return;
        }
        axis.process(block);
    }
}

impl PyOperator {
    /// Approximate time for `samples` samples: 1 ns for each sample of memory, up to where sums go by FFT; 50 ns for a recursion.
    fn time_of(&self, samples: usize) -> Duration {
        use fracdiff::Differintegrator as _;
        let memory = self.axis.operator().memory_length().unwrap_or(50);
        Duration::from_nanos((samples as u64).saturating_mul(memory.clamp(10, 4000) as u64))
    }
}

#[pymethods]
impl PyOperator {
    #[new]
    #[pyo3(signature = (order, sample_time, scheme = "full", horizon = 3600.0))]
    pub(super) fn new(
        py: Python<'_>,
        order: f64,
        sample_time: f64,
        scheme: &str,
        horizon: f64,
    ) -> PyResult<Self> {
        let (order, sample_time) = (Order::new(order).or_refused()?, Seconds(sample_time));
        let scheme = scheme_of(scheme)?;
        sample_time.rate_to_the(order).or_refused()?;
        positive("horizon", horizon, "s").or_refused()?;
        let axis = heard(py, Duration::MAX, move |_| {
            let operator = scheme.build(order, sample_time, horizon / sample_time.0);
            Ok(Channel::new(operator.or_refused()?))
        })?;
        Ok(Self {
            axis,
            order,
            sample_time,
            scheme,
            horizon,
        })
    }

    /// The output for the sample x, which is then taken into the history.
    ///
    /// Parameters
    /// ----------
    /// x : float
    ///     The newest sample.
    ///
    /// Returns
    /// -------
    /// float
    ///     y in the unit of x, times s^(-order).
    #[pyo3(signature = (x, /))]
    fn step(&mut self, x: f64) -> f64 {
        self.axis.step(x)
    }

    /// The output for the newest sample; the history stays as it is.
    ///
    /// Parameters
    /// ----------
    /// x : float
    ///     The newest sample.
    ///
    /// Returns
    /// -------
    /// float
    ///     y in the unit of x, times s^(-order).
    #[pyo3(signature = (x, /))]
    fn output(&self, x: f64) -> f64 {
        self.axis.output(x)
    }

    /// Takes the newest sample into the history.
    ///
    /// Parameters
    /// ----------
    /// x : float
    ///     The newest sample.
    #[pyo3(signature = (x, /))]
    fn advance(&mut self, x: f64) {
        self.axis.advance(x);
    }

    /// The outputs for a block of samples, the next of the stream. Releases the interpreter.
    ///
    /// Parameters
    /// ----------
    /// block : array_like, shape (n,)
    ///     Samples; integers are converted.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (n,)
    ///     What `step` would give for each, to the bit.
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     Not one dimension, or not real numbers.
    #[pyo3(signature = (block, /))]
    fn process<'py>(&mut self, py: Python<'py>, block: &Bound<'py, PyAny>) -> PyResult<Array<f64>> {
        let mut samples = vector("block", block)?;
        let about = self.time_of(samples.len());
        if about <= LONG {
            let axis = &mut self.axis;
            py.detach(|| axis.process(&mut samples));
            return Ok(Array::of(samples));
        }
        // An interruption leaves the operator as it was.
        let mut axis = self.axis.clone();
        let (axis, samples) = heard(py, about, move |conduct| {
            run_unless(conduct, &mut axis, &mut samples);
            Ok((axis, samples))
        })?;
        self.axis = axis;
        Ok(Array::of(samples))
    }

    /// Forgets the past.
    ///
    /// Parameters
    /// ----------
    /// reference : float, default 0
    ///     From now on the operator acts on x - reference, as if the signal had stood there for ever (Caputo).
    #[pyo3(signature = (reference = 0.0))]
    fn reset(&mut self, reference: f64) {
        self.axis.reset_to(reference);
    }

    /// The first weights of the operator as it is made: its response to a single sample of 1.
    ///
    /// Parameters
    /// ----------
    /// count : int
    ///     Number of weights.
    ///
    /// Returns
    /// -------
    /// ndarray, shape (count,)
    ///     T^(-order) w_j in s^(-order), newest sample first: ``np.convolve`` with them is `process` from rest.
    fn weights<'py>(&self, py: Python<'py>, count: Whole) -> PyResult<Array<f64>> {
        let count = count.with_room("count", 1)?;
        let mut axis = Channel::new(self.axis.operator().clone());
        let weights = heard(py, self.time_of(count), move |conduct| {
            let mut weights = room("count", count, 1)?;
            weights.resize(count, 0.0);
            if let Some(first) = weights.first_mut() {
                *first = 1.0;
            }
            run_unless(conduct, &mut axis, &mut weights);
            Ok(weights)
        });
        Ok(Array::of(weights?))
    }

    /// The frequency response of the operator as it is made.
    ///
    /// Parameters
    /// ----------
    /// omega : array_like
    ///     Frequencies in rad/s, 0 to pi/T, of any shape.
    ///
    /// Returns
    /// -------
    /// ndarray of complex, same shape
    ///     T^(-order) P(exp(-j omega T)) in s^(-order).
    ///
    /// Raises
    /// ------
    /// ValueError
    ///     A frequency above half the sample rate, with its index.
    pub(super) fn frequency_response<'py>(
        &self,
        omega: &Bound<'py, PyAny>,
    ) -> PyResult<Array<Complex64>> {
        let operator = self.axis.operator().clone();
        let rate = self.sample_time.rate_to_the(self.order).or_refused()?;
        response(omega, self.sample_time.0, move |theta| {
            operator.response(theta) * rate
        })
    }

    /// The operator as numbers: form, differences (> 0) or sums (< 0) around, values; None for a scheme without such a list.
    fn _list(&self) -> Option<(&'static str, i8, Array<f64>)> {
        use fracdiff::portable::Form;
        let list = self.axis.operator().list()?;
        let form = match list.form {
            Form::Taps => "taps",
            Form::Modes => "modes",
            Form::Recursion => "recursion",
        };
        Some((form, list.integer, Array::of(list.values)))
    }

    /// The order of the operator, as it was given.
    #[getter]
    fn order(&self) -> f64 {
        self.order.get()
    }

    /// Time between samples in s.
    #[getter]
    fn sample_time(&self) -> f64 {
        self.sample_time.0
    }

    /// The scheme with all of its parameters.
    #[getter]
    fn scheme(&self) -> String {
        self.scheme.to_string()
    }

    /// Longest duration of the stream in s.
    #[getter]
    fn horizon(&self) -> f64 {
        self.horizon
    }

    /// The value that the operator takes from each sample.
    #[getter]
    fn reference(&self) -> f64 {
        self.axis.state().1
    }

    /// Number of samples that reach an output; None if all do.
    #[getter]
    fn memory_length(&self) -> Option<usize> {
        use fracdiff::Differintegrator as _;
        self.axis.operator().memory_length()
    }

    fn __repr__(&self) -> String {
        format!(
            "Operator(order={}, sample_time={}, scheme='{}', horizon={})",
            self.order, self.sample_time.0, self.scheme, self.horizon
        )
    }

    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> PyResult<(Bound<'py, PyAny>, Recipe, State<'py>)> {
        let operator = slf.try_borrow()?;
        let arguments = (
            operator.order(),
            operator.sample_time(),
            operator.scheme(),
            operator.horizon(),
        );
        let (history, reference) = operator.axis.state();
        let bytes = postcard::to_stdvec(history).or_refused()?;
        let state = (PyBytes::new(slf.py(), &bytes), reference);
        Ok((slf.get_type().into_any(), arguments, state))
    }

    fn __setstate__(&mut self, state: State<'_>) -> PyResult<()> {
        let (bytes, reference) = state;
        let history: OperatorHistory<f64> = postcard::from_bytes(bytes.as_bytes())
            .map_err(|error| refused(format_args!("not the history of an operator: {error}")))?;
        let at_rest = self.axis.state().0;
        if std::mem::discriminant(&history) != std::mem::discriminant(at_rest) {
            return Err(refused("the history of another scheme"));
        }
        self.axis.resume(history, reference);
        Ok(())
    }
}

/// T^(−μ)·P(e^(−jωT)) of any scheme, `exact` too.
#[pyfunction]
pub(crate) fn frequency_response<'py>(
    omega: &Bound<'py, PyAny>,
    order: f64,
    sample_time: f64,
    scheme: &str,
    horizon: f64,
) -> PyResult<Array<Complex64>> {
    if scheme_of(scheme)? != Scheme::Exact {
        let operator = PyOperator::new(omega.py(), order, sample_time, scheme, horizon)?;
        return operator.frequency_response(omega);
    }
    let order = Order::new(order).or_refused()?;
    let rate = Seconds(sample_time).rate_to_the(order).or_refused()?;
    let exact = ExactDifference(order);
    response(omega, sample_time, move |theta| {
        exact.response(theta) * rate
    })
}

/// A response at each of some frequencies in rad/s, which must be up to half the sample rate.
fn response<'py>(
    omega: &Bound<'py, PyAny>,
    sample_time: f64,
    at: impl Fn(f64) -> Complex64 + Send + 'static,
) -> PyResult<Array<Complex64>> {
    let py = omega.py();
    let (omega, shape) = frequencies(omega, sample_time, true)?;
    let values: Vec<Complex64> = heard(py, Duration::MAX, move |conduct| {
        Ok(conduct.each(&omega, |omega| at(omega * sample_time)))
    })?;
    Ok(Array::shaped(values, shape))
}
