//! Logs of runs, whole or cut.

use crate::arrays::Array;
use crate::conducted::{Interrupted, conduct};
use crate::json::{dict, to_python};
use crate::refused::unread;
use haptic_log::record::{Condition, Entry, LogFiles, RecordError};
use haptic_message::{ColumnValue, EventMessage, MetadataRecord, TickMessage};
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
    let mut ticks = Vec::new();
    let (mut events, mut metadata) = (Vec::new(), Vec::new());
    for entry in files.by_ref() {
        match entry? {
            Entry::Tick(tick) => ticks.push(tick),
            Entry::Event(event) => events.push(event),
            Entry::Metadata(record) => metadata.push(record),
            _ => {}
        }
        if stops() {
            break;
        }
    }
    Ok(Log {
        columns: columns(&ticks),
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
    let columns = PyDict::new(py);
    for (name, values) in log.columns {
        match values {
            Column::Numbers(values) => columns.set_item(name, Array::of(values)),
            Column::Counts(values) => columns.set_item(name, Array::of(values)),
            Column::Bits(values) => columns.set_item(name, Array::of(values)),
        }?;
    }
    let metadata = PyDict::new(py);
    for record in &log.metadata {
        metadata.set_item(&record.name, to_python(py, &record.values)?)?;
    }
    let events = log.events.iter();
    let events = events.map(|event| (event.time_s, event.kind.as_str(), event.text.as_str()));
    let damage = log.condition.damage.iter().map(ToString::to_string);
    Ok(dict! {py;
        "columns": columns,
        "metadata": metadata,
        "events": events.collect::<Vec<_>>(),
        "complete": log.condition.complete,
        "damage": damage.collect::<Vec<String>>(),
        "started": log.started,
    })
}

/// The columns of the ticks, in their order.
fn columns(ticks: &[TickMessage]) -> Vec<(String, Column)> {
    let first = ticks.first().copied();
    // A log without a tick has its columns too.
    let first = first.unwrap_or(TickMessage::unknown(1));
    let columns = TickMessage::columns(first.axes()).into_iter();
    let values = columns.map(|column| {
        let all = ticks.iter().map(|tick| column.value(tick));
        let values = match column.value(&first) {
            ColumnValue::Number(_) => Column::Numbers(all.map(ColumnValue::to_f64).collect()),
            ColumnValue::Count(_) => Column::Counts(all.map(ColumnValue::to_u64).collect()),
            ColumnValue::Bits(_) => Column::Bits(all.map(|bits| bits.to_u64() as u8).collect()),
        };
        (column.name, values)
    });
    values.collect()
}
