//! Logs of runs, whole or cut.

use crate::conducted::{Interrupted, conduct};
use crate::json::to_python;
use crate::refused::unread;
use haptic_log::record::{
    AXES, Condition, Entry, EventMessage, LogFiles, MetadataRecord, RecordError, TickMessage,
    VectorTick, column as column_of,
};
use numpy::PyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};

/// All that a log holds.
struct Log {
    columns: Vec<(String, Column)>,
    events: Vec<EventMessage>,
    metadata: Vec<MetadataRecord>,
    condition: Condition,
    started: Option<String>,
}

/// The values of a column.
enum Column {
    Numbers(Vec<f64>),
    Counts(Vec<u64>),
    Bits(Vec<u8>),
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
        columns: match vectors.first() {
            Some(first) if ticks.is_empty() => vector_columns(&vectors, first.axes()),
            _ => columns(&ticks),
        },
        events,
        metadata,
        condition: files.condition(),
        started: files.started().map(|start| start.rfc3339()),
    })
}

/// The columns of a log, its metadata, its events and its condition.
#[pyfunction]
pub(crate) fn read_log(py: Python<'_>, path: PathBuf) -> PyResult<Bound<'_, PyDict>> {
    let log = conduct(py, None, Interrupted::Forgotten, move |conduct| {
        read(&path, || conduct.stops()).map_err(|error| unread(&error))
    })?;
    let result = PyDict::new(py);
    let columns = PyDict::new(py);
    for (name, values) in log.columns {
        match values {
            Column::Numbers(values) => columns.set_item(name, PyArray1::from_vec(py, values)),
            Column::Counts(values) => columns.set_item(name, PyArray1::from_vec(py, values)),
            Column::Bits(values) => columns.set_item(name, PyArray1::from_vec(py, values)),
        }?;
    }
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
fn columns(ticks: &[TickMessage]) -> Vec<(String, Column)> {
    let number = |(name, field): &(&str, fn(&TickMessage) -> f64)| {
        let values = ticks.iter().map(field).collect();
        ((*name).to_owned(), Column::Numbers(values))
    };
    let tick = Column::Counts(ticks.iter().map(|tick| tick.tick).collect());
    let limiters = Column::Bits(ticks.iter().map(|tick| tick.limiters).collect());
    let flaws = Column::Bits(ticks.iter().map(|tick| tick.flaws).collect());
    let first = std::iter::once(("tick".to_owned(), tick));
    let numbers = TickMessage::NUMBERS.iter().map(number);
    first
        .chain(numbers)
        .chain([
            ("limiters".to_owned(), limiters),
            ("flaws".to_owned(), flaws),
        ])
        .collect()
}

/// A column for each axis of each vector, and for the other fields, in their order.
fn vector_columns(ticks: &[VectorTick], axes: usize) -> Vec<(String, Column)> {
    let number = |field: fn(&VectorTick) -> f64| Column::Numbers(ticks.iter().map(field).collect());
    let tick = Column::Counts(ticks.iter().map(|tick| tick.tick).collect());
    let limiters = Column::Bits(ticks.iter().map(|tick| tick.limiters).collect());
    let flaws = Column::Bits(ticks.iter().map(|tick| tick.flaws).collect());
    let mut columns = vec![("tick".to_owned(), tick)];
    columns.push(("time_s".to_owned(), number(|tick| tick.time_s)));
    for (name, field) in VectorTick::VECTORS {
        for (axis, letter) in AXES.iter().enumerate().take(axes) {
            let values = ticks.iter().map(|tick| {
                let vector = field(tick);
                vector.as_slice().get(axis).copied().unwrap_or(f64::NAN)
            });
            let values = Column::Numbers(values.collect());
            columns.push((column_of(name, letter), values));
        }
    }
    let energy = number(|tick| tick.observed_energy_j);
    columns.push(("observed_energy_j".to_owned(), energy));
    columns.push(("limiters".to_owned(), limiters));
    columns.push(("flaws".to_owned(), flaws));
    columns
}
