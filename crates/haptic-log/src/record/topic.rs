//! One topic of a log, as a table.

use super::{
    Condition, ExportSummary, Leftover, LogFiles, NewFile, RecordError,
    topics::{Rows, Topics},
};
use haptic_message::{LogMessage as _, TickMessage};
use std::{
    io::{BufWriter, Write},
    path::Path,
};

/// A topic as columns of numbers, all of one length.
#[derive(Clone, Debug, PartialEq)]
pub struct Topic {
    /// The name of the topic.
    pub name: String,
    /// Columns by their names, that of the recording first; NaN where a message has no such field.
    pub columns: Vec<(String, Vec<f64>)>,
    /// One sentence for each thing that was left out.
    pub notes: Vec<String>,
    /// Condition of the log, as the columns may be only a part of it.
    pub condition: Condition,
}

impl Topic {
    /// The topic of these columns, which are named as `/topic.field`; without a topic among the names, our ticks, or the
    /// one topic that has numbers.
    ///
    /// # Errors
    /// If the log cannot be read, has no such topic, or has several and none is named.
    pub fn read(path: &Path, names: &[&str]) -> Result<Self, RecordError> {
        let mut log = LogFiles::open(path)?;
        log.reader.topics = Some(Topics::default());
        log.by_ref().try_for_each(|entry| entry.map(drop))?;
        let mut rows = log.reader.topics.take().unwrap_or_default().rows;
        let is_named = |topic: &str| {
            let rest = names.iter().filter_map(|name| name.strip_prefix(topic));
            rest.into_iter()
                .any(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        let asks = names.iter().any(|name| name.starts_with('/'));
        let is_wanted = |(topic, rows): &(&String, &Rows)| {
            if asks {
                is_named(topic)
            } else {
                !rows.columns.is_empty()
            }
        };
        let mut wanted: Vec<&String> = rows
            .iter()
            .filter(is_wanted)
            .map(|(name, _)| name)
            .collect();
        if !asks {
            // If our topic is there, it is the one that is meant.
            let ticks = wanted.iter().position(|name| *name == TickMessage::TOPIC);
            wanted = ticks.map_or(wanted.clone(), |ticks| vec![wanted[ticks]]);
        }
        let why = match (&wanted[..], asks) {
            ([name], _) if !rows[*name].columns.is_empty() => "",
            ([], false) => "has no topic of numbers",
            ([], true) => "has no topic of that name",
            ([_], _) => "has no numbers in that topic",
            (_, false) => "has several topics",
            (_, true) => "has times of its own in each topic, and the columns are of several",
        };
        if !why.is_empty() {
            return Err(RecordError::Topics {
                path: path.to_owned(),
                why,
                topics: rows
                    .iter()
                    .map(|(name, rows)| rows.describe(name))
                    .collect(),
            });
        }
        let name = wanted[0].clone();
        let condition = log.condition();
        let rows = rows.remove(&name).unwrap_or_default();
        Ok(Self {
            notes: rows.notes(),
            columns: rows.columns(),
            name,
            condition,
        })
    }

    fn rows(&self) -> usize {
        self.columns.first().map_or(0, |(_, column)| column.len())
    }

    /// A header, and a line for each message; NaN is an empty cell. `name` is that of the sink in messages.
    ///
    /// # Errors
    /// If the sink fails.
    pub fn write_csv(&self, sink: impl Write, name: &Path) -> Result<ExportSummary, RecordError> {
        let write = || -> csv::Result<()> {
            let mut csv = csv::Writer::from_writer(sink);
            csv.write_record(self.columns.iter().map(|(name, _)| name))?;
            for row in 0..self.rows() {
                let cells = self.columns.iter().map(|(_, column)| column[row]);
                let shown = |cell: f64| (!cell.is_nan()).then(|| cell.to_string());
                csv.write_record(cells.map(|cell| shown(cell).unwrap_or_default()))?;
            }
            Ok(csv.flush()?)
        };
        write().map_err(|source| RecordError::Csv {
            path: name.to_owned(),
            source,
        })?;
        Ok(ExportSummary {
            rows: self.rows() as u64,
            condition: self.condition.clone(),
            missing: 0,
        })
    }

    /// Writes rows as [`write_csv`](Self::write_csv) does, into the new file `target`.
    ///
    /// # Errors
    /// If the target exists without `overwrite` or cannot be written.
    pub fn export_csv(&self, target: &Path, overwrite: bool) -> Result<ExportSummary, RecordError> {
        let (new_file, file) = NewFile::create(target, Leftover::Discard, overwrite)?;
        let summary = self.write_csv(BufWriter::new(file), target)?;
        new_file.publish()?;
        Ok(summary)
    }
}
