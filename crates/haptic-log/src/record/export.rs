//! A log as CSV: one row per tick, columns named as the fields of [`TickMessage`](super::TickMessage) with their units; of several
//! axes a column each, as `position_x_m`.

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use super::new_file::refuse_own_source;
use super::{Condition, Entry, Leftover, LogFiles, NewFile, RecordError, VectorTick};

/// The fields of [`TickMessage`](super::TickMessage) in order.
const COLUMNS: [&str; 12] = [
    "tick",
    "time_s",
    "reference_m",
    "indenter_position_m",
    "position_m",
    "environment_force_n",
    "commanded_force_n",
    "applied_force_n",
    "contact_force_n",
    "limiters",
    "flaws",
    "observed_energy_j",
];

/// Result of an export.
#[derive(Clone, Debug, PartialEq)]
pub struct ExportSummary {
    /// The CSV file.
    pub path: PathBuf,
    /// Rows, without the header.
    pub rows: u64,
    /// Condition of the log. Rows may be missing if it is not complete.
    pub condition: Condition,
}

/// Writes the ticks of the log `source` to the new CSV file `target`.
///
/// Numbers are written with as many digits as it takes to read the same `f64` again. A log without
/// ticks gives a file with the header alone.
///
/// ```
/// # use haptic_log::record::{LogWriter, TickMessage};
/// use haptic_log::record::export_csv;
///
/// # let folder = tempfile::tempdir()?;
/// # let log = folder.path().join("run.mcap");
/// # let table = folder.path().join("run.csv");
/// # let mut writer = LogWriter::create(&log)?;
/// # writer.tick(&TickMessage::default())?;
/// # writer.finish()?;
/// let exported = export_csv(&log, &table, false)?;
/// assert_eq!(exported.rows, 1);
/// assert!(exported.condition.complete);
/// assert!(std::fs::read_to_string(&table)?.starts_with("tick,time_s,reference_m,"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// If the log cannot be read, or the target exists without `overwrite`, cannot be written, or is the log.
pub fn export_csv(
    source: &Path,
    target: &Path,
    overwrite: bool,
) -> Result<ExportSummary, RecordError> {
    refuse_own_source(source, target)?;
    let mut reader = LogFiles::open(source)?;
    let (new_file, file) = NewFile::create(target, Leftover::Discard, overwrite)?;
    let rows = write_rows(&mut reader, BufWriter::new(file), target)?;
    new_file.publish().map_err(RecordError::from)?;
    Ok(ExportSummary {
        path: target.to_owned(),
        rows,
        condition: reader.condition(),
    })
}

/// The same into any sink; `name` is its name in messages.
///
/// # Errors
/// If the log cannot be read, or the sink fails.
pub fn export_csv_to(
    source: &Path,
    sink: impl Write,
    name: &Path,
) -> Result<ExportSummary, RecordError> {
    let mut reader = LogFiles::open(source)?;
    let rows = write_rows(&mut reader, sink, name)?;
    Ok(ExportSummary {
        path: name.to_owned(),
        rows,
        condition: reader.condition(),
    })
}

fn write_rows(reader: &mut LogFiles, sink: impl Write, name: &Path) -> Result<u64, RecordError> {
    let fail = |source| RecordError::Csv {
        path: name.to_owned(),
        source,
    };
    let mut csv = csv::WriterBuilder::new()
        .has_headers(false)
        .from_writer(sink);
    let mut rows = 0;
    let mut axes = None;
    while let Some(entry) = reader.next() {
        let entry = entry?;
        let of_row = match &entry {
            Entry::Tick(_) => 1,
            Entry::Vector(tick) => tick.axes(),
            _ => continue,
        };
        match axes {
            None => write_header(&mut csv, of_row).map_err(fail)?,
            Some(axes) if axes == of_row => {}
            Some(axes) => {
                return Err(RecordError::Axes {
                    path: reader.path().to_owned(),
                    axes: [axes, of_row],
                });
            }
        }
        axes = Some(of_row);
        match entry {
            Entry::Tick(tick) => csv.serialize(tick).map_err(fail)?,
            Entry::Vector(tick) => csv.serialize(tick).map_err(fail)?,
            _ => {}
        }
        rows += 1;
    }
    if axes.is_none() {
        write_header(&mut csv, 1).map_err(fail)?;
    }
    csv.flush().map_err(|error| fail(error.into()))?;
    Ok(rows)
}

/// The names of the columns, for ticks of so many axes.
fn write_header<W: Write>(csv: &mut csv::Writer<W>, axes: usize) -> csv::Result<()> {
    match axes {
        1 => csv.write_record(COLUMNS),
        axes => csv.write_record(VectorTick::columns(axes)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::TickMessage;

    #[test]
    fn the_columns_are_the_fields_of_a_tick() {
        let mut csv = csv::Writer::from_writer(Vec::new());
        csv.serialize(TickMessage::default()).expect("serialises");
        let text = String::from_utf8(csv.into_inner().expect("flushes")).expect("is UTF-8");
        assert_eq!(text.lines().next(), Some(COLUMNS.join(",").as_str()));
    }
}
