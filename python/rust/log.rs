//! Logs of runs, whole or cut.

use crate::conducted::conduct;
use crate::json::to_python;
use crate::refused::OrRefused as _;
use haptic_log::record::{
    AXES, Condition, Entry, EventMessage, LogFiles, MetadataRecord, RecordError, TickMessage,
    VectorTick, column as column_of,
};
use numpy::{Element, PyArray1};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};

/// All that a log holds.
struct Log {
    ticks: Vec<TickMessage>,
    vectors: Vec<VectorTick>,
    events: Vec<EventMessage>,
    metadata: Vec<MetadataRecord>,
    condition: Condition,
    started: Option<String>,
}

fn read(path: &Path, stops: impl Fn() -> bool) -> Result<Log, RecordError> {
    let mut files = LogFiles::open(path)?;
    let (mut ticks, mut vectors) = (Vec::new(), Vec::new());
    let (mut events, mut metadata) = (Vec::new(), Vec::new());
    for entry in files.by_ref() {
        match entry? {
            Entry::Tick(tick) => ticks.push(tick),
            Entry::Vector(tick) => vectors.push(tick),
            Entry::Event(event) => events.push(event),
            Entry::Metadata(record) => metadata.push(record),
            _ => {}
        }
        if stops() {
            break;
        }
    }
    Ok(Log {
        ticks,
        vectors,
        events,
        metadata,
        condition: files.condition(),
        started: files.started().map(|start| start.rfc3339()),
    })
}

/// The columns of a log, its metadata, its events and its condition.
#[pyfunction]
pub(crate) fn read_log(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyDict>> {
    let log = conduct(py, None, true, move |conduct| {
        read(&path, || conduct.stops())
    })?
    .or_refused()?;
    let result = PyDict::new(py);
    let columns = match log.vectors.first() {
        Some(first) if log.ticks.is_empty() => vector_columns(py, &log.vectors, first.axes())?,
        _ => columns(py, &log.ticks)?,
    };
    result.set_item("columns", columns)?;
    let metadata = PyDict::new(py);
    for record in &log.metadata {
        metadata.set_item(&record.name, to_python(py, &record.values)?)?;
    }
    result.set_item("metadata", metadata)?;
    let events = log.events.iter();
    let events = events.map(|event| (event.time_s, event.kind.as_str(), event.text.as_str()));
    result.set_item("events", events.collect::<Vec<_>>())?;
    result.set_item("complete", log.condition.complete)?;
    let damage: Vec<String> = log
        .condition
        .damage
        .iter()
        .map(ToString::to_string)
        .collect();
    result.set_item("damage", damage)?;
    result.set_item("started", log.started)?;
    Ok(result)
}

/// A column for each field of a tick, in their order.
fn columns<'py>(py: Python<'py>, ticks: &[TickMessage]) -> PyResult<Bound<'py, PyDict>> {
    fn column<'py, T: Element>(
        py: Python<'py>,
        ticks: &[TickMessage],
        field: impl Fn(&TickMessage) -> T,
    ) -> Bound<'py, PyArray1<T>> {
        PyArray1::from_iter(py, ticks.iter().map(field))
    }
    let columns = PyDict::new(py);
    columns.set_item("tick", column(py, ticks, |tick| tick.tick))?;
    for (name, field) in TickMessage::NUMBERS {
        columns.set_item(name, column(py, ticks, field))?;
    }
    columns.set_item("limiters", column(py, ticks, |tick| tick.limiters))?;
    columns.set_item("flaws", column(py, ticks, |tick| tick.flaws))?;
    Ok(columns)
}

/// A column for each axis of each vector, and for the other fields, in their order.
fn vector_columns<'py>(
    py: Python<'py>,
    ticks: &[VectorTick],
    axes: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let columns = PyDict::new(py);
    let number = |field: fn(&VectorTick) -> f64| PyArray1::from_iter(py, ticks.iter().map(field));
    columns.set_item(
        "tick",
        PyArray1::from_iter(py, ticks.iter().map(|tick| tick.tick)),
    )?;
    columns.set_item("time_s", number(|tick| tick.time_s))?;
    for (name, field) in VectorTick::VECTORS {
        for (axis, letter) in AXES.iter().enumerate().take(axes) {
            let values = ticks.iter().map(|tick| {
                let vector = field(tick);
                vector.as_slice().get(axis).copied().unwrap_or(f64::NAN)
            });
            columns.set_item(column_of(name, letter), PyArray1::from_iter(py, values))?;
        }
    }
    columns.set_item("observed_energy_j", number(|tick| tick.observed_energy_j))?;
    columns.set_item(
        "limiters",
        PyArray1::from_iter(py, ticks.iter().map(|tick| tick.limiters)),
    )?;
    columns.set_item(
        "flaws",
        PyArray1::from_iter(py, ticks.iter().map(|tick| tick.flaws)),
    )?;
    Ok(columns)
}
