//! Record that a file holds.

use crate::mcap::{self, warn_of_order};
use crate::table;
use haptic_experiment::{ExperimentFile, Failure};
use haptic_log::record::{Entry, LogFiles};
use haptic_loop::Loading;
use haptic_message::TickMessage;
use haptic_question::tissue::RecordQuestion;
use haptic_run::read_document;
use measured_table::{Choice, Column, Columns, Reader, read_table};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use tissue_identification::{SAMPLES_MOST, TableDetails, Understood};

/// The segments that tables have to choose from.
pub(super) fn segments(question: &RecordQuestion, paths: &[PathBuf]) -> Result<Value, Failure> {
    let mut listed = Vec::new();
    for path in paths {
        if is_ours(&question.reader, path)? {
            return Err(Failure::bad_input(format_args!(
                "{} is a log, which has no segments: omit --segments",
                path.display()
            )));
        }
        let (reader, bytes) = opened(&question.reader, path)?;
        let segments = read_table(&bytes).and_then(|table| reader.segments(&table));
        listed.extend(segments.map_err(|error| table::wrong(path, error))?);
    }
    Ok(json!({"segments": listed}))
}

/// The columns of tables as they are read.
pub(super) fn explained(question: &RecordQuestion, paths: &[PathBuf]) -> Result<Value, Failure> {
    let mut read = Vec::new();
    for (file, path) in paths.iter().enumerate() {
        if is_ours(&question.reader, path)? {
            return Err(Failure::bad_input(format_args!(
                "{} is a log of ours, whose columns are known: host-cli log info tells what is in it; omit --explain",
                path.display()
            )));
        }
        let (reader, bytes) = opened(&question.reader, path)?;
        let rows = question.explained(file, &reader, &bytes);
        read.push((path, rows.map_err(|error| table::wrong(path, error))?));
    }
    Ok(match &read[..] {
        [(_, one)] => json!(one),
        all => all
            .iter()
            .map(|(path, rows)| (path.display().to_string(), json!(rows)))
            .collect(),
    })
}

/// The bytes of a table, or of a log that is read as one, and how to read them.
fn opened(reader: &Reader, path: &Path) -> Result<(Reader, Vec<u8>), Failure> {
    let mut reader = reader.clone();
    let names = reader.columns.iter_mut();
    let names = names.filter_map(|(_, choice)| match choice {
        Choice::Name(name) => Some(name),
        Choice::Number(_) => None,
    });
    let bytes = table::bytes_with(path, names.collect())?;
    Ok((reader, bytes))
}

/// True of a log of ours whose columns are not named: its ticks are the record.
fn is_ours(reader: &Reader, path: &Path) -> Result<bool, Failure> {
    let is_log = path.extension().is_some_and(|end| end == "mcap");
    let is_topic = |choice: &Choice| matches!(choice, Choice::Name(name) if name.starts_with('/'));
    let asks = reader.columns.iter().any(|(_, choice)| is_topic(choice));
    Ok(is_log && !asks && mcap::is_ours(path)?)
}

/// The records in the file of this number: one, or the segments that were chosen, or all.
pub(super) fn read(
    question: &RecordQuestion,
    file: usize,
    path: &Path,
) -> Result<Vec<Understood>, Failure> {
    if path.to_string_lossy().ends_with(".mcap.part") {
        return Err(Failure::bad_input(format_args!(
            "{} is the log of an interrupted run: give what host-cli log recover saves of it",
            path.display()
        )));
    }
    let understood = if is_ours(&question.reader, path)? {
        let mut reading = question.reading;
        let experiment = read_document(path).and_then(|document| ExperimentFile::open(&document));
        let experiment = experiment.ok();
        let loading = (experiment.as_ref()).and_then(|one| loading_of(one, &mut reading));
        let read = log(&question.reader, path, &reading.loading)?;
        let press = (experiment.as_ref()).and_then(|one| one.press_record(&read.ticks));
        reading.position_was_commanded = press.is_some();
        let made = |mut columns: Columns| {
            columns.notes.extend(loading.clone());
            let understood = reading.record(columns)?;
            let record = understood.record.of_own_log();
            Ok(Understood {
                record,
                ..understood
            })
        };
        match press {
            None => made(read.columns()).map(|one| vec![one]),
            Some(press) => {
                (press.check_zero())
                    .map_err(|why| Failure::bad_input(format_args!("{}: {why}", path.display())))?;
                made(press.columns()).map(|one| {
                    let record = press.with_doubts(one.record);
                    vec![Understood { record, ..one }]
                })
            }
        }
    } else {
        let (reader, bytes) = opened(&question.reader, path)?;
        question.read(file, reader, &bytes)
    };
    understood.map_err(|error| table::wrong(path, error))
}

/// Time, position and reaction force of a log; the force on the device is the other way round.
fn log(reader: &Reader, path: &Path, loading: &Loading) -> Result<LogRecord, Failure> {
    if !(reader.columns.is_empty() && reader.units.is_empty() && reader.segments.is_empty()) {
        return Err(Failure::bad_input(
            "--columns, --units and --segment apply only to tables: omit them for a log",
        ));
    }
    let sized = loading.area_m2.is_some() && loading.thickness_m.is_some();
    if loading.kind.is_slab() && !sized {
        return Err(Failure::bad_input(
            "a log has positions and forces: give --area and --thickness, as in 4cm2 and 20mm, or --loading",
        ));
    }
    let (from, to) = (reader.from, reader.to);
    let mut read = LogRecord::default();
    let mut log = LogFiles::open(path)?;
    for entry in &mut log {
        let Entry::Tick(tick) = entry? else { continue };
        let early = from.is_some_and(|from| tick.time_s < from);
        if early || to.is_some_and(|to| tick.time_s > to) {
            read.outside += 1;
        } else if !read.take(&tick) {
            return Err(Failure::bad_input(format_args!(
                "{}: more than {SAMPLES_MOST} samples: give --from and --to",
                path.display()
            )));
        }
    }
    let condition = log.condition();
    warn_of_order(&condition);
    read.incomplete = !condition.complete || condition.out_of_order > 0;
    Ok(read)
}

/// Takes how the tissue was pressed from the document in the log, unless options say anything of it; what was taken, for people.
fn loading_of(experiment: &ExperimentFile, reading: &mut TableDetails) -> Option<String> {
    let unsaid = TableDetails {
        kind: reading.kind,
        subtract_start: reading.subtract_start,
        strain: reading.strain,
        stress_pa: reading.stress_pa,
        ..TableDetails::default()
    };
    if *reading != unsaid {
        return None;
    }
    let piece = experiment.piece()?;
    reading.loading = *piece.specimen.loading();
    reading.loading_is_told = true;
    reading.poisson_ratio = Some(piece.material.loading.poisson_ratio());
    let kind = reading.loading.kind.name();
    Some(format!(
        "loading {kind} and sizes of the specimen, as the log says"
    ))
}

/// A log as it is read.
#[derive(Debug, Default)]
struct LogRecord {
    ticks: Vec<TickMessage>,
    /// Samples that were left out.
    outside: u64,
    incomplete: bool,
}

impl LogRecord {
    /// `false` if there is no room for it.
    fn take(&mut self, tick: &TickMessage) -> bool {
        if self.ticks.len() == SAMPLES_MOST {
            return false;
        }
        self.ticks.push(*tick);
        true
    }

    /// Time, position and the force against the motion.
    fn columns(self) -> Columns {
        let Self { outside, ticks, .. } = self;
        // The force of the safety chain, not of the tissue; at rest it is both.
        let (mut kept, mut limited) = (Vec::new(), 0);
        for tick in &ticks {
            let is_rest = kept.is_empty() && tick.commanded_force_n[0] == 0.0;
            if tick.limiters == 0 || is_rest {
                kept.push(tick);
            } else {
                limited += 1;
            }
        }
        let column = |of: fn(&TickMessage) -> f64| kept.iter().map(|tick| of(tick)).collect();
        let mut notes =
            vec!["stress is the force against the motion, −commanded_force_n".to_owned()];
        if outside > 0 {
            notes.push(format!("{outside} samples outside the given range omitted"));
        }
        if limited > 0 {
            notes.push(format!(
                "{limited} samples omitted, limited by the safety chain"
            ));
        }
        if self.incomplete {
            notes.push("the log is not whole: the record is what could be read".to_owned());
        }
        Columns {
            lines: Vec::new(),
            values: vec![
                (
                    Column::Time,
                    "time_s".to_owned(),
                    column(|tick| tick.time_s),
                ),
                (
                    Column::Position,
                    "position_m".to_owned(),
                    column(|tick| tick.position_m[0]),
                ),
                (
                    Column::Force,
                    "commanded_force_n".to_owned(),
                    column(|tick| -tick.commanded_force_n[0]),
                ),
            ],
            notes,
            ..Columns::default()
        }
    }
}
