//! A log as CSV: one row per tick, the [columns](TickMessage::columns) of a tick.

use std::{
    io::{BufWriter, Write},
    path::Path,
};

use super::{
    Condition, Entry, Leftover, LogFiles, NewFile, RecordError, new_file::refuse_own_source,
    summary::TickCount,
};
use haptic_message::TickMessage;

/// Rows of an export, and the condition of its log.
#[derive(Clone, Debug, PartialEq)]
pub struct ExportSummary {
    /// Rows of data; the header does not count.
    pub rows: u64,
    /// Condition of the log. Rows may be missing if it is not complete.
    pub condition: Condition,
    /// Ticks that are missing between others, and at the ends as far as the log says how its run ended.
    pub missing: u64,
}

impl ExportSummary {
    /// True if the table has all ticks of the log's run, in their order.
    #[must_use]
    pub const fn is_whole(&self) -> bool {
        self.condition.complete && self.condition.out_of_order == 0 && self.missing == 0
    }
}

/// Writes the ticks of the log `source` to the new CSV file `target`.
///
/// Numbers are written with as many digits as it takes to read the same `f64` again. A log without
/// messages gives a file with the header alone.
///
/// ```
/// # use haptic_log::record::LogWriter;
/// # use haptic_message::TickMessage;
/// use haptic_log::record::export_csv;
///
/// # let folder = tempfile::tempdir()?;
/// # let log = folder.path().join("run.mcap");
/// # let table = folder.path().join("run.csv");
/// # let mut writer = LogWriter::create(&log)?;
/// # writer.tick(&TickMessage::at_rest(1))?;
/// # writer.finish()?;
/// let exported = export_csv(&log, &table, false)?;
/// assert_eq!(exported.rows, 1);
/// assert!(exported.condition.complete);
/// assert!(std::fs::read_to_string(&table)?.starts_with("tick,time_s,reference_m,"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the log cannot be read or has other messages than ours alone, or the target exists without `overwrite`, cannot be written,
/// or is the log.
pub fn export_csv(
    source: &Path,
    target: &Path,
    overwrite: bool,
) -> Result<ExportSummary, RecordError> {
    refuse_own_source(source, target)?;
    let mut reader = LogFiles::open(source)?;
    let (new_file, file) = NewFile::create(target, Leftover::Discard, overwrite)?;
    let summary = write_rows(&mut reader, BufWriter::new(file), target)?;
    // Nor may it replace one of the log's later files.
    (reader.read.iter()).try_for_each(|file| refuse_own_source(file, target))?;
    new_file.publish()?;
    Ok(summary)
}

/// Exports as [`export_csv`] does, into any sink; `name` is its name in messages.
///
/// # Errors
/// If the log cannot be read, or the sink fails.
pub fn export_csv_to(
    source: &Path,
    sink: impl Write,
    name: &Path,
) -> Result<ExportSummary, RecordError> {
    write_rows(&mut LogFiles::open(source)?, sink, name)
}

fn write_rows(
    reader: &mut LogFiles,
    sink: impl Write,
    name: &Path,
) -> Result<ExportSummary, RecordError> {
    let fail = |source| RecordError::Csv {
        path: name.to_owned(),
        source,
    };
    let mut csv = csv::WriterBuilder::new()
        .has_headers(false)
        .from_writer(sink);
    let mut count = TickCount::default();
    let mut columns = Vec::new();
    for entry in reader.by_ref() {
        let tick = match entry? {
            Entry::Tick(tick) => tick,
            Entry::Metadata(record) => {
                count.note(&record);
                continue;
            }
            Entry::Drive(_) | Entry::Event(_) => continue,
        };
        count.add(&tick);
        if columns.is_empty() {
            columns = TickMessage::columns(tick.axes());
            csv.write_record(columns.iter().map(|column| &column.name))
                .map_err(fail)?;
        }
        let row: Vec<_> = columns.iter().map(|column| column.value(&tick)).collect();
        csv.serialize(row).map_err(fail)?;
    }
    let condition = reader.condition();
    if columns.is_empty() {
        if !condition.foreign_topics.is_empty() {
            return Err(RecordError::NoTicks {
                path: reader.path.clone(),
                topics: condition.foreign_topics.into_keys().collect(),
            });
        }
        let columns = TickMessage::columns(1).into_iter();
        csv.write_record(columns.map(|column| column.name))
            .map_err(fail)?;
    }
    csv.flush().map_err(|error| fail(error.into()))?;
    Ok(ExportSummary {
        rows: count.samples,
        condition,
        missing: count.missing(),
    })
}
