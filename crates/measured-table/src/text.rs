//! The text of a table as blocks of numbers, and columns of one block by their names.

use super::column::Column;
use super::error::TableError;
use super::find::{Block, Blocks};
use super::header::{Unit, foreign, plain, split, understand};
use super::heading::{Heading, are_units};
use super::lines::{brief, rows_named, wrong};
use super::text_file::{TABLE_MOST, decoded};
use super::unit::{Dimension, rows};
#[cfg(feature = "workbook")]
use super::workbook::text_of;
use csv::StringRecord;

/// The blocks of numbers of a table with what stands above them, not yet numbers, with lines for messages.
#[derive(Clone, Debug, PartialEq)]
pub struct TextTable {
    pub(super) blocks: Vec<Block>,
    /// Spaces separate the cells: an empty one is not seen.
    spaced: bool,
}

/// Finds the blocks of numbers in a file, as programs write them: cells apart by tabs, semicolons, commas or spaces, numbers with a point or
/// a decimal comma, in UTF-8, UTF-16 or Windows-1252, below whatever preamble.
///
/// # Errors
/// A file that is not text, is empty or too long; one without a row of two numbers.
pub fn read_table(bytes: &[u8]) -> Result<TextTable, TableError> {
    let mut table = TextTable::new(bytes)?;
    table.blocks = Block::side_by_side(table.blocks);
    if table.blocks.iter().all(|block| block.columns() < 2) {
        let first = table.blocks.first();
        let heading = first.and_then(|block| block.headings().pop());
        let line = heading.map_or(1, |heading| heading.line);
        return Err(wrong(
            line,
            "there is only one column: give at least two, separated by tabs, commas or semicolons",
        ));
    }
    Ok(table)
}

impl TextTable {
    fn new(bytes: &[u8]) -> Result<Self, TableError> {
        if bytes.len() as u64 > TABLE_MOST {
            return Err(TableError::Whole(format!(
                "the table is longer than {TABLE_MOST} bytes: cut it into pieces, or omit unneeded columns"
            )));
        }
        let refused = |why: &str| TableError::Whole(format!("{why}: export the table as CSV"));
        #[cfg(feature = "workbook")]
        let workbook = text_of(bytes).transpose().map_err(|why| refused(&why))?;
        #[cfg(not(feature = "workbook"))]
        let workbook = None::<String>;
        let text =
            workbook.map_or_else(|| decoded(bytes).map_err(refused), |text| Ok(text.into()))?;
        if text.trim().is_empty() {
            return Err(TableError::Whole(
                "the table is empty: give a header and rows of numbers below it".to_owned(),
            ));
        }
        let Blocks { blocks, spaced, .. } = Blocks::of(&text)?;
        if blocks.is_empty() {
            return Err(TableError::Whole(format!(
                "no row with numbers in {} lines, so there are no rows of a table: give a header and numbers below it",
                text.lines().count()
            )));
        }
        Ok(Self { blocks, spaced })
    }

    /// Refuses what would be lost, rows of numbers without a header above the one that was chosen, and cells that have moved to another
    /// column.
    pub(super) fn check(&self, block: &Block, heading: &Heading) -> Result<(), TableError> {
        let is_above =
            |other: &&Block| other.lines()[1] < heading.line && other.headings().is_empty();
        let width = heading.names.len();
        // A remark may have a number among its words.
        let is_sample =
            |row: &StringRecord| 2 * row.iter().filter(|cell| !cell.is_empty()).count() > width;
        let blocks = self.blocks.iter().filter(is_above);
        let lost = blocks.flat_map(|block| &block.rows);
        let lost = lost.filter(|row| is_sample(&row.1)).map(|row| row.0);
        let lost: Vec<u64> = lost.collect();
        if let Some(rows) = rows_named(&lost) {
            return Err(TableError::Whole(format!(
                "{rows} of numbers above the header in line {}: put them below it, or delete them",
                heading.line
            )));
        }
        let units = heading.units.len();
        let has_moved = units != width && are_units(heading.units.iter().map(String::as_str));
        if self.spaced && has_moved {
            let reason = format!(
                "{units} units below a header of {width}: separate cells by tabs or semicolons, or put each unit below its name"
            );
            return Err(wrong(heading.line, &reason));
        }
        let other = block.rows.iter().find(|(_, row)| row.len() != width);
        if let Some((line, row)) = other.filter(|_| self.spaced) {
            let reason = format!(
                "{} cells under a header of {width}: separate cells by tabs or semicolons, so that names with spaces and empty cells are seen",
                row.len()
            );
            return Err(wrong(*line, &reason));
        }
        Ok(())
    }
}

/// Columns of numbers by the names that stand above them, the first that of the times, in s whatever its unit; found as by [`read_table`].
///
/// A name is a header with or without its unit, such as `Zeit` for `Zeit [ms]`, or the number of a
/// column, from 1; `time_s` means the column of time, whatever its name, if there is one: of several that which does not stand still, numbers before
/// dates and times of day, whose first is 0. Without a name of it there are no times. What a row lacks is NaN; empty lines do not count, as the time
/// shows what is missing. `input` and `output` mean a column of that name, or else the one whose name says so, as `Stellgröße`.
///
/// # Errors
/// As [`read_table`], but one column is enough; no or two columns of a name, two tables with them; no row; a cell that is not a finite
/// number, with its line; a time that is missing, or a unit that is not one of time; without a time, a row that lacks something.
pub fn read_record<const N: usize>(
    bytes: &[u8],
    names: [&str; N],
) -> Result<RecordColumns<N>, TableError> {
    let (chosen, mut places) =
        Chosen::of(bytes, |block, heading| places_of(names, block, heading))?;
    let signals = names.iter().zip(places).skip(1);
    let by_another = signals.filter_map(|(name, place)| {
        let place = place.filter(|_| matches!(chosen.heading.place(name), Ok(None)))?;
        Some(format!(
            "column {} is taken as the {name}",
            chosen.heading.names[place]
        ))
    });
    let notes = by_another.collect();
    let time = places.first().copied().flatten();
    let since = time.and_then(|time| chosen.block.instants(time));
    if since.is_some() {
        places[0] = None;
    }
    let mut found = RecordColumns {
        notes,
        ..chosen.numbers(places)?
    };
    if let Some(since) = since {
        found.columns[0] = since;
        return Ok(found);
    }
    let Some(time) = time else {
        let lacks = chosen.block.blank.or(found.gaps.first().copied());
        return lacks.map_or(Ok(found), |line| Err(wrong(line, NO_VALUE)));
    };
    let factor = chosen.time_factor(time)?;
    let times = &mut found.columns[0];
    times.iter_mut().for_each(|time| *time *= factor);
    match times.iter().position(|time| !time.is_finite()) {
        Some(row) => Err(wrong(found.lines[row], NO_VALUE)),
        None => Ok(found),
    }
}

/// The columns of a record.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordColumns<const N: usize> {
    /// The line of each row in the file, from 1, for messages.
    pub lines: Vec<u64>,
    /// Columns in the order of the requested names; NaN where a row lacks a signal. The first is empty if there are no times.
    pub columns: [Vec<f64>; N],
    /// One sentence for each column that was taken by another name than the requested one.
    pub notes: Vec<String>,
    gaps: Vec<u64>,
}

impl<const N: usize> RecordColumns<N> {
    /// Number of rows that lack a number, and the lines of the first ones; `None` if all are complete.
    #[must_use]
    pub fn gaps(&self) -> Option<String> {
        rows_named(&self.gaps)
    }
}

/// A block of a table and what was chosen to stand above it.
pub(super) struct Chosen {
    block: Block,
    pub(super) heading: Heading,
}

impl Chosen {
    /// The one block with a line of names that a choice takes; else what the choice says of the line that has the most names.
    pub(super) fn of<T>(
        bytes: &[u8],
        mut choose: impl FnMut(&Block, &Heading) -> Result<T, String>,
    ) -> Result<(Self, T), TableError> {
        let table = TextTable::new(bytes)?;
        let (mut found, mut refused) = (Vec::new(), Vec::new());
        for block in &table.blocks {
            let mut headings = block.headings();
            if headings.is_empty() {
                headings.push(block.numbered());
            }
            match block.headed(headings, |heading| choose(block, heading)) {
                Ok((heading, taken)) => found.push((block, heading, taken)),
                Err(why) => refused.extend(why),
            }
        }
        if let [(_, first, _), (_, second, _), ..] = &found[..] {
            return Err(TableError::Whole(format!(
                "{} tables have these columns, below line {} and below line {}: keep one of them in the file",
                found.len(),
                first.line,
                second.line
            )));
        }
        let Some((block, heading, taken)) = found.pop() else {
            // Of as many names the first.
            let most = refused.into_iter().rev().max_by_key(|(names, _)| *names);
            let nothing = || TableError::Whole("no rows below the header: give numbers".to_owned());
            return Err(most.map_or_else(nothing, |(_, error)| error));
        };
        table.check(block, &heading)?;
        let block = block.clone();
        Ok((Self { block, heading }, taken))
    }

    /// Numbers of columns, empty for a missing one, their lines, and the rows with gaps, which are NaN.
    fn numbers<const N: usize>(
        &self,
        places: [Option<usize>; N],
    ) -> Result<RecordColumns<N>, TableError> {
        let rows = &self.block.rows;
        let known: Vec<usize> = places.iter().copied().flatten().collect();
        let columns = (self.block).numbers(&self.heading, &known, 0..rows.len(), None)?;
        let is_gap = |row: &usize| columns.iter().any(|column| column[*row].is_nan());
        let gaps = (0..rows.len()).filter(is_gap);
        let gaps = gaps.map(|row| rows[row].0).collect();
        if let Some((line, row)) = &self.block.broken {
            let cell = brief(
                known
                    .first()
                    .and_then(|place| row.get(*place))
                    .unwrap_or(""),
            );
            return Err(wrong(
                *line,
                &format!("{cell:?} is not a finite number: correct it, or omit the row"),
            ));
        }
        let mut columns = columns.into_iter();
        let column = |place: Option<usize>| place.and_then(|_| columns.next());
        Ok(RecordColumns {
            lines: rows.iter().map(|row| row.0).collect(),
            columns: places.map(column).map(Option::unwrap_or_default),
            notes: Vec::new(),
            gaps,
        })
    }

    /// Numbers as of [`numbers`](Self::numbers), of which no row may lack one.
    pub(super) fn complete<const N: usize>(
        &self,
        places: [Option<usize>; N],
    ) -> Result<RecordColumns<N>, TableError> {
        let found = self.numbers(places)?;
        match self.block.blank.or(found.gaps.first().copied()) {
            Some(line) => Err(wrong(line, NO_VALUE)),
            None => Ok(found),
        }
    }

    /// Seconds in the unit of a column of time, which its name or the line below says.
    fn time_factor(&self, column: usize) -> Result<f64, TableError> {
        match self.heading.unit_as(Column::Time, column) {
            Unit::Factor(factor) | Unit::Weight(factor) => Ok(factor),
            Unit::Untold | Unit::Either => Ok(1.0),
            Unit::Foreign(unit) => Err(wrong(self.heading.line, &foreign(&unit, Column::Time))),
        }
    }
}

const NO_VALUE: &str = "no value, or NaN: give a number in every row";

/// The places of these names; `None` for a missing time, which is optional.
fn places_of<const N: usize>(
    names: [&str; N],
    block: &Block,
    heading: &Heading,
) -> Result<[Option<usize>; N], String> {
    let mut places = [None; N];
    for (n, name) in names.into_iter().enumerate() {
        if n == 0 && name.is_empty() {
            continue;
        }
        let any_time = n == 0 && name == TIME;
        let is_time = |place: usize| {
            let meaning = understand(&heading.names[place], heading.below(place));
            any_time && meaning.is_some_and(|meaning| meaning.column == Column::Time)
        };
        let is_alike =
            |place: usize| is_time(place) || n > 0 && is_signal(name, &heading.names[place]);
        places[n] = match heading.place(name)? {
            None => {
                let times = (0..heading.names.len()).filter(|place| is_time(*place));
                let times: Vec<usize> = times.collect();
                let runs = |instants: bool| {
                    let times = times.iter().copied();
                    times.filter(move |time| block.runs(*time, instants))
                };
                let [numbers, dates] = [false, true].map(|kind| runs(kind).collect::<Vec<_>>());
                match (&times[..], &numbers[..], &dates[..]) {
                    ([_, _, ..], [one], _) | ([_, _, ..], [], [one]) => Some(*one),
                    _ => heading.one(name, is_alike)?,
                }
            }
            found => found,
        };
        if places[n].is_none() && !any_time {
            let header = heading.names.join(",");
            return Err(format!("no column {name} in the header {header:?}"));
        }
    }
    Ok(places)
}

/// True of a name that is known for a signal.
fn is_signal(signal: &str, name: &str) -> bool {
    let ended = name.rsplit_once('_');
    let bare = ended.filter(|(_, unit)| unit.len() <= 2 || Dimension::knows(unit));
    let name = plain(&bare.map_or_else(|| split(name).0, |(name, _)| name.to_owned()));
    let mut signals = rows(include_str!("signals.txt")).filter_map(|row| row.split_once(" | "));
    signals.any(|(known, names)| known == signal && names.split(", ").any(|one| one == name))
}

/// The name that stands for the column of time.
const TIME: &str = "time_s";
