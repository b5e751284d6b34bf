//! Fractional operators: of whole records, and of streams.

mod stream;

pub(crate) use stream::{PyOperator, frequency_response};

use crate::arrays::{Array, Whole, room, vector};
use crate::conducted::heard;
use crate::refused::{OrRefused as _, refused};
use fracdiff::{Channel, Operator, Order, Scheme, Seconds};
use pyo3::prelude::*;
use std::time::Duration;

/// The axis of a stream.
type Axis = Channel<f64, Operator<f64>>;

/// A scheme from its words.
pub(crate) fn scheme_of(text: &str) -> PyResult<Scheme> {
    text.parse().or_refused()
}

/// D^μ of the columns of records, each a vector of samples; `first_sample` takes x₀ from the record.
#[pyfunction]
pub(crate) fn differintegrate<'py>(
    py: Python<'py>,
    columns: Vec<Bound<'py, PyAny>>,
    order: f64,
    sample_time: f64,
    scheme: &str,
    reference: Option<f64>,
) -> PyResult<Vec<Array<f64>>> {
    let (order, sample_time) = (Order::new(order).or_refused()?, Seconds(sample_time));
    let scheme = scheme_of(scheme)?;
    let columns = columns.iter().map(|column| vector("x", column));
    let columns: Vec<Vec<f64>> = columns.collect::<PyResult<_>>()?;
    for (channel, x) in columns.iter().enumerate() {
        if let Some(at) = x.iter().position(|x| !x.is_finite()) {
            return Err(refused(format_args!(
                "sample {at} of channel {channel} of x is {}, and must be a finite number: fill the gap, or cut the record before it",
                x[at]
            )));
        }
    }
    let outputs = heard(py, Duration::MAX, move |_| {
        records(&columns, order, sample_time, scheme, reference)
    });
    Ok(outputs?.into_iter().map(Array::of).collect())
}

/// The defining sum where the scheme is one, else the operator run over each record.
fn records(
    columns: &[Vec<f64>],
    order: Order,
    sample_time: Seconds,
    scheme: Scheme,
    reference: Option<f64>,
) -> PyResult<Vec<Vec<f64>>> {
    let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    if let Some(batch) = scheme.batch(order, sample_time).or_refused()? {
        let batch = match reference {
            Some(reference) => batch.relative_to(reference),
            None => batch.caputo(),
        };
        return Ok(batch.channels(&columns));
    }
    let longest = columns.iter().map(|x| x.len()).max().unwrap_or(0);
    let operator = scheme.build(order, sample_time, longest as f64);
    let mut axis: Axis = Channel::new(operator.or_refused()?);
    let each = |x: &&[f64]| {
        let first = x.first().copied().unwrap_or(0.0);
        axis.reset_to(reference.unwrap_or(first));
        x.iter().map(|&x| axis.step(x)).collect()
    };
    Ok(columns.iter().map(each).collect())
}

/// The first weights of (1 − w)^μ.
#[pyfunction]
pub(crate) fn grunwald_weights(py: Python<'_>, order: f64, count: Whole) -> PyResult<Array<f64>> {
    let order = Order::new(order).or_refused()?;
    let count = count.with_room("count", 1)?;
    let about = Duration::from_nanos(10 * count as u64);
    let weights = heard(py, about, move |conduct| {
        let mut weights = room("count", count, 1)?;
        let going = fracdiff::grunwald_weights(order).take_while(|_| !conduct.stops());
        weights.extend(going.take(count));
        Ok(weights)
    });
    Ok(Array::of(weights?))
}
