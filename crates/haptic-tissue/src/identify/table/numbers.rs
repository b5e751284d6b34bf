//! Columns of numbers in SI units from the blocks of a table.

use super::super::error::IdentifyError;
use super::above::Heading;
use super::assemble::Columns;
use super::column::{Choice, Column};
use super::find::{Block, is_gap};
use super::header::{Meaning, Unit, remedy, split, understand};
use super::lines::{brief, passed, rows_named, wrong};
use super::segments::{between, changes, jumps, restarts, values};
use super::text::{TextTable, too_many};
use super::unit::celsius;
use crate::identify::keys::{COLUMNS, SEGMENT, SEGMENTS, UNITS};
use haptic_quantity::{DecimalSign, number_with};
use std::ops::Range;

/// The user's instructions for a table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reader {
    /// Columns by place or name. If there are a clock and another among them, no other column is looked at.
    pub columns: Vec<(Column, Choice)>,
    /// Units that headers omit or get wrong.
    pub units: Vec<(Column, String)>,
    /// First time (or angular frequency).
    pub from: Option<f64>,
    /// Last time (or angular frequency).
    pub to: Option<f64>,
    /// Segments by number from 1, by name or by a part of it; `all` of them.
    pub segments: Vec<String>,
}

/// A part of a table that is a record of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Segment {
    /// From 1, in the order of the file.
    pub number: usize,
    /// The name of its step, set or interval, or its lines.
    pub name: String,
    /// First and last line.
    pub lines: [u64; 2],
    /// How many rows it has.
    pub rows: usize,
    /// Time or angular frequency, with its least and its largest value.
    pub clock: Option<(Column, [f64; 2])>,
    /// Mean temperature, °C, if a column or the name says it.
    pub temperature_c: Option<f64>,
    /// Headers of the columns that are read.
    pub columns: Vec<String>,
}

struct Found {
    column: Column,
    place: usize,
    name: String,
    /// SI units per unit; `None` until known.
    factor: Option<f64>,
}

/// A block under its heading, and the columns of a record in it.
struct Part<'a> {
    block: &'a Block,
    heading: Heading,
    found: Vec<Found>,
    unclear: Vec<(Column, String)>,
    temperature: Option<Found>,
    sign: DecimalSign,
}

/// A segment of a part.
struct Piece<'a> {
    part: &'a Part<'a>,
    rows: Range<usize>,
    name: String,
    temperature_c: Option<f64>,
}

fn is_clock(column: Column) -> bool {
    matches!(column, Column::Time | Column::Omega)
}

impl Reader {
    /// The one segment of a table as columns with quantities of a record.
    ///
    /// # Errors
    /// As [`read_all`](Self::read_all), and if it would read more than one.
    pub fn read(&self, table: TextTable) -> Result<Columns, IdentifyError> {
        let mut all = self.read_all(&table)?;
        match (all.pop(), all.len()) {
            (Some(one), 0) => Ok(one),
            (_, others) => Err(IdentifyError::Record(format!(
                "{} segments are more than one record: give {SEGMENT} one of them",
                others + 1
            ))),
        }
    }

    /// The chosen segments of a table, in the order of the file; of a table with one, that.
    ///
    /// # Errors
    /// Several segments without a choice, a choice of none, a wrong unit, a cell that is not a number, with line and column.
    pub fn read_all(&self, table: &TextTable) -> Result<Vec<Columns>, IdentifyError> {
        let parts = self.parts(table)?;
        let pieces = pieces(&parts);
        let chosen = self.chosen(&pieces)?;
        let columns = chosen.into_iter().map(|n| {
            let piece = &pieces[n];
            table.check(piece.part.block, &piece.part.heading)?;
            let mut columns = self.columns(piece)?;
            columns.segment = (pieces.len() > 1).then(|| piece.name.clone());
            columns.notes.extend(preamble(piece.part));
            columns.notes.extend(unread(table, &parts));
            Ok(columns)
        });
        columns.collect()
    }

    /// What there is to choose from.
    ///
    /// # Errors
    /// A table without a column that is known, a wrong unit.
    pub fn segments(&self, table: &TextTable) -> Result<Vec<Segment>, IdentifyError> {
        let parts = self.parts(table)?;
        let segments = pieces(&parts).into_iter().enumerate().map(|(n, piece)| {
            let clock = piece.part.clock().map(|clock| {
                let values = values(piece.part.block, clock.place, piece.part.sign);
                let values = values[piece.rows.clone()]
                    .iter()
                    .filter(|value| value.is_finite());
                let ends = values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
                    [low.min(*value), high.max(*value)]
                });
                (
                    clock.column,
                    ends.map(|end| end * clock.factor.unwrap_or(1.0)),
                )
            });
            Segment {
                number: n + 1,
                lines: piece.lines(),
                rows: piece.rows.len(),
                clock,
                temperature_c: piece.temperature_c,
                columns: piece
                    .part
                    .found
                    .iter()
                    .map(|found| found.name.clone())
                    .collect(),
                name: piece.name,
            }
        });
        Ok(segments.collect())
    }

    /// Blocks that may be records, each with its heading and columns.
    fn parts<'a>(&self, table: &'a TextTable) -> Result<Vec<Part<'a>>, IdentifyError> {
        let mut parts: Vec<Part<'a>> = Vec::new();
        let mut refused = None;
        let mut blocks: Vec<&Block> = table.blocks.iter().collect();
        for block in &table.blocks {
            match self.heading(block, parts.last()) {
                Ok(heading) => parts.push(self.part(block, heading)?),
                Err(error) => refused = refused.or(Some(error)),
            }
        }
        let is_whole = |part: &Part| {
            let others = part.found.iter().any(|found| !is_clock(found.column));
            part.clock().is_some() && others
        };
        if parts.iter().any(is_whole) {
            parts.retain(is_whole);
        }
        if !parts.is_empty() {
            return Ok(parts);
        }
        // Nothing is known: the largest block says what was found.
        blocks.sort_by_key(|block| std::cmp::Reverse(block.rows.len()));
        let largest = blocks.first().and_then(|block| {
            let heading = block.headings().into_iter().next()?;
            Some((*block, heading))
        });
        match (largest, refused) {
            (Some((block, heading)), _) if self.columns.is_empty() => {
                Ok(vec![self.part(block, heading)?])
            }
            (_, Some(error)) => Err(error),
            (_, None) => Err(wrong(
                1,
                "there is no table: give a header and rows of numbers below it",
            )),
        }
    }

    /// The names above a block: those that the user's choice, or any known quantity, is found in.
    fn heading(&self, block: &Block, before: Option<&Part>) -> Result<Heading, IdentifyError> {
        let mut headings = block.headings();
        if headings.is_empty() {
            match before.filter(|before| before.block.width() == block.width()) {
                Some(before) => headings.push(before.heading.clone()),
                None if self
                    .columns
                    .iter()
                    .any(|choice| matches!(choice.1, Choice::Number(_))) =>
                {
                    headings.push(block.numbered());
                }
                None => {
                    return Err(wrong(
                        block.lines()[0],
                        &format!(
                            "there is no header: add one, or give {COLUMNS}, as in time=1,modulus=2"
                        ),
                    ));
                }
            }
        }
        let mut refused = None;
        for heading in headings {
            let mut places = self
                .columns
                .iter()
                .map(|(_, choice)| place(&heading, choice));
            if let Some(error) = places.find_map(Result::err) {
                refused = refused.or(Some(error));
                continue;
            }
            let mut names = heading.names.iter().enumerate();
            let is_known =
                |(place, name): (usize, &String)| understand(name, heading.unit(place)).is_some();
            if !self.columns.is_empty() || names.any(is_known) {
                return Ok(heading);
            }
        }
        let unknown = || {
            wrong(
                block.lines()[0],
                &format!("no column above is known: give {COLUMNS}, as in time=1,modulus=2"),
            )
        };
        Err(refused.unwrap_or_else(unknown))
    }

    fn part<'a>(&self, block: &'a Block, heading: Heading) -> Result<Part<'a>, IdentifyError> {
        let mut found = self.named(&heading)?;
        let mut unclear = Vec::new();
        let names = |is_it: fn(Column) -> bool| found.iter().any(|found| is_it(found.column));
        let is_told = names(is_clock) && names(|column| !is_clock(column));
        let sign = {
            let places: Vec<usize> = found.iter().map(|found| found.place).collect();
            // A comma in a column that is found by its header is looked at below.
            block.decimal_sign(&places)?
        };
        if !is_told {
            self.known(block, &heading, &mut found, &mut unclear);
        }
        let temperature = found
            .iter()
            .position(|found| found.column == Column::Temperature);
        let temperature = temperature.map(|at| found.remove(at));
        if self.columns.is_empty() {
            keep_sweep(&mut found);
        }
        let places: Vec<usize> = found.iter().map(|found| found.place).collect();
        block.decimal_sign(&places)?;
        Ok(Part {
            block,
            heading,
            found,
            unclear,
            temperature,
            sign,
        })
    }

    /// Columns that a user named.
    fn named(&self, heading: &Heading) -> Result<Vec<Found>, IdentifyError> {
        let named = self.columns.iter().map(|(column, choice)| {
            let place = place(heading, choice)?;
            let name = heading.names[place].clone();
            let unit = match heading.unit(place) {
                "" => split(&name)
                    .1
                    .and_then(|unit| column.dimension().factor(&unit)),
                unit => column.dimension().factor(unit),
            };
            let factor = unit.or_else(|| {
                let meaning = understand(&name, heading.unit(place))?;
                match meaning.unit {
                    Unit::Factor(factor) if meaning.column == *column => Some(factor),
                    Unit::Factor(_) | Unit::Untold | Unit::Either | Unit::Foreign(_) => None,
                }
            });
            Ok(Found {
                column: *column,
                place,
                name,
                factor,
            })
        });
        named.collect()
    }

    /// Columns with a known name. Of several of one quantity the best counts; as good ones are asked for.
    fn known(
        &self,
        block: &Block,
        heading: &Heading,
        found: &mut Vec<Found>,
        unclear: &mut Vec<(Column, String)>,
    ) {
        let names = heading.names.iter().enumerate();
        let names = names.filter(|(place, _)| !block.is_blank(*place));
        let mut meanings: Vec<(usize, &String, Meaning)> = names
            .filter_map(|(place, name)| Some((place, name, understand(name, heading.unit(place))?)))
            .collect();
        let is_foreign = |meaning: &Meaning| matches!(meaning.unit, Unit::Foreign(_));
        meanings.sort_by_key(|(place, _, meaning)| (is_foreign(meaning), meaning.rank, *place));
        for column in Column::ALL {
            let mut alike = meanings.iter().filter(|of| {
                of.2.column == column && !found.iter().any(|found| found.place == of.0)
            });
            let Some((place, name, meaning)) = alike.next() else {
                continue;
            };
            if found.iter().any(|found| found.column == column) {
                continue;
            }
            let rivals: Vec<_> = alike.filter(|of| !is_foreign(&of.2)).collect();
            let rival = rivals.iter().find(|of| of.2.rank == meaning.rank);
            let is_same = |other: usize| same_numbers(block, *place, meaning, other, &rivals);
            if let Some((other, name_of_other, _)) =
                rival.filter(|of| !is_same(of.0)).map(|of| (of.0, of.1, ()))
            {
                let _ = other;
                unclear.push((
                    column,
                    format!(
                        "line {}: the columns {name} and {name_of_other} both look like {}: give {COLUMNS} {}=NAME",
                        heading.line,
                        column.name(),
                        column.name()
                    ),
                ));
            }
            let factor = match &meaning.unit {
                Unit::Factor(factor) => Some(*factor),
                Unit::Untold => None,
                Unit::Either | Unit::Foreign(_) if self.unit_of(column).is_some() => None,
                Unit::Either => {
                    unclear.push((
                        column,
                        format!(
                            "line {}, column {name}: its unit may be Hz or rad/s: give {UNITS} omega=Hz or omega=rad/s",
                            heading.line
                        ),
                    ));
                    None
                }
                Unit::Foreign(unit) => {
                    unclear.push((
                        column,
                        format!(
                            "line {}, column {name}: unit {:?} is not a unit of {}: {}",
                            heading.line,
                            brief(unit),
                            column.name(),
                            remedy(column.dimension(), column)
                        ),
                    ));
                    None
                }
            };
            found.push(Found {
                column,
                place: *place,
                name: (*name).clone(),
                factor,
            });
        }
        found.sort_by_key(|found| {
            (
                !self.columns.iter().any(|choice| choice.0 == found.column),
                found.place,
            )
        });
    }

    fn unit_of(&self, column: Column) -> Option<&str> {
        let unit = self.units.iter().find(|unit| unit.0 == column);
        unit.map(|unit| unit.1.as_str())
    }

    /// Numbers of the chosen segments, by place in the list.
    fn chosen(&self, pieces: &[Piece]) -> Result<Vec<usize>, IdentifyError> {
        if self.segments.is_empty() {
            return match pieces.len() {
                1 => Ok(vec![0]),
                count => Err(IdentifyError::Record(format!(
                    "{count} segments could be meant, {}: give {SEGMENT} one or several of them, or {SEGMENTS} to list all",
                    listed(pieces)
                ))),
            };
        }
        let mut chosen = Vec::new();
        for wanted in &self.segments {
            let wanted = wanted.trim();
            let lower = wanted.to_lowercase();
            let named = |is_it: &dyn Fn(&str) -> bool| -> Vec<usize> {
                (0..pieces.len())
                    .filter(|&n| is_it(&pieces[n].name.to_lowercase()))
                    .collect()
            };
            let mut found = match wanted.parse::<usize>() {
                Ok(number) => (1..=pieces.len())
                    .contains(&number)
                    .then(|| number - 1)
                    .into_iter()
                    .collect(),
                Err(_) if lower == "all" => (0..pieces.len()).collect(),
                Err(_) => named(&|name| name == lower),
            };
            if found.is_empty() {
                found = named(&|name| name.contains(&lower));
                if found.len() > 1 {
                    found.clear();
                }
            }
            if found.is_empty() {
                return Err(IdentifyError::Record(format!(
                    "there is no one segment {wanted:?}: give {SEGMENT} a number from 1 to {}, or a name, of {}",
                    pieces.len(),
                    listed(pieces)
                )));
            }
            chosen.append(&mut found);
        }
        chosen.sort_unstable();
        chosen.dedup();
        Ok(chosen)
    }

    /// A segment in SI units.
    fn columns(&self, piece: &Piece) -> Result<Columns, IdentifyError> {
        let part = piece.part;
        let mut notes = Vec::new();
        let factors = self.factors(part, &mut notes)?;
        let mut columns = Columns {
            values: part
                .found
                .iter()
                .map(|f| (f.column, f.name.clone(), Vec::new()))
                .collect(),
            chosen: self.columns.iter().map(|(column, _)| *column).collect(),
            unclear: part.unclear.clone(),
            temperature_c: piece.temperature_c,
            ..Columns::default()
        };
        let (mut empty, mut outside) = (Vec::new(), Vec::new());
        let clock = part.found.iter().position(|found| is_clock(found.column));
        for (line, row) in &part.block.rows[piece.rows.clone()] {
            let Some(values) = part.row(*line, row, &factors)? else {
                empty.push(*line);
                continue;
            };
            let at = clock.map_or(0.0, |column| values[column]);
            if self.from.is_some_and(|from| at < from) || self.to.is_some_and(|to| at > to) {
                outside.push(*line);
                continue;
            }
            columns.lines.push(*line);
            for (column, value) in columns.values.iter_mut().zip(values) {
                column.2.push(value);
            }
        }
        notes.extend(passed(&empty, "a cell without a number"));
        notes.extend(passed(&outside, "outside the range asked for"));
        if columns.lines.is_empty() {
            return Err(IdentifyError::Record(
                "no row with numbers is left: give at least one more than the model has parameters"
                    .to_owned(),
            ));
        }
        columns.notes = notes;
        Ok(columns)
    }

    /// SI units per unit of each column: the user's, the header's, else SI with a note.
    fn factors(&self, part: &Part, notes: &mut Vec<String>) -> Result<Vec<f64>, IdentifyError> {
        let factors = part.found.iter().map(|f| {
            let Some(unit) = self.unit_of(f.column) else {
                if f.factor.is_none() && !matches!(f.column, Column::Strain | Column::LossTangent) {
                    notes.push(format!(
                        "column {} names no unit: taken as {}",
                        f.name,
                        f.column.dimension().si()
                    ));
                }
                return Ok(f.factor.unwrap_or(1.0));
            };
            let given = f.column.dimension().factor(unit).ok_or_else(|| {
                IdentifyError::Record(format!(
                    "unit {unit:?} is not a unit of {}: {}",
                    f.column.name(),
                    remedy(f.column.dimension(), f.column)
                ))
            })?;
            if f.factor
                .is_some_and(|told| (told / given - 1.0).abs() > 1e-9)
            {
                return Err(IdentifyError::Record(format!(
                    "column {} names its own unit: omit {}={unit} of {UNITS}",
                    f.name,
                    f.column.name()
                )));
            }
            Ok(given)
        });
        factors.collect()
    }
}

/// A complete sweep has no use for the clock and the amplitudes beside it, nor for its moduli in other words.
fn keep_sweep(found: &mut Vec<Found>) {
    let has = |column: Column| found.iter().any(|found| found.column == column);
    let moduli = [
        Column::Storage,
        Column::Loss,
        Column::Complex,
        Column::Phase,
        Column::LossTangent,
    ];
    let kept: Vec<Column> = match has(Column::Storage) && has(Column::Loss) {
        true => vec![Column::Storage, Column::Loss],
        false => moduli
            .into_iter()
            .filter(|column| has(*column))
            .take(2)
            .collect(),
    };
    if has(Column::Omega) && kept.len() == 2 {
        found.retain(|found| found.column == Column::Omega || kept.contains(&found.column));
    }
}

/// True if another column has the same numbers in its own unit, over rows enough: frequencies in Hz and in rad/s.
fn same_numbers(
    block: &Block,
    place: usize,
    meaning: &Meaning,
    other: usize,
    rivals: &[&(usize, &String, Meaning)],
) -> bool {
    const ROWS: usize = 3;
    let factor = |unit: &Unit| match unit {
        Unit::Factor(factor) => Some(*factor),
        Unit::Untold => Some(1.0),
        Unit::Either | Unit::Foreign(_) => None,
    };
    let of_other = rivals
        .iter()
        .find(|of| of.0 == other)
        .and_then(|of| factor(&of.2.unit));
    let (Some(one), Some(two), Ok(sign)) = (
        factor(&meaning.unit),
        of_other,
        block.decimal_sign(&[place, other]),
    ) else {
        return false;
    };
    let (ours, theirs) = (values(block, place, sign), values(block, other, sign));
    let mut pairs = ours
        .iter()
        .zip(&theirs)
        .filter(|pair| pair.0.is_finite() && pair.1.is_finite());
    // Both are printed with a few digits.
    pairs.clone().count() >= ROWS
        && pairs.all(|(a, b)| (a * one - b * two).abs() <= 1e-3 * (a * one).abs())
}

impl Part<'_> {
    fn clock(&self) -> Option<&Found> {
        let of = |column: Column| self.found.iter().find(|found| found.column == column);
        of(Column::Omega).or_else(|| of(Column::Time))
    }

    /// The numbers of a row in SI; `None` if a cell is empty.
    fn row(
        &self,
        line: u64,
        row: &csv::StringRecord,
        factors: &[f64],
    ) -> Result<Option<Vec<f64>>, IdentifyError> {
        let mut values = Vec::with_capacity(self.found.len());
        let width = self.heading.names.len();
        if row.iter().skip(width).any(|cell| !cell.is_empty()) {
            return Err(wrong(line, &too_many(row, width)));
        }
        for (f, factor) in self.found.iter().zip(factors) {
            let cell = row.get(f.place).unwrap_or("");
            if is_gap(cell) {
                return Ok(None);
            }
            let value = number_with(cell, self.sign).ok_or_else(|| IdentifyError::Line {
                line,
                column: Some(f.name.clone()),
                reason: format!(
                    "{:?} is not a finite number: correct it, or omit the row",
                    brief(cell)
                ),
            })?;
            values.push(value * factor);
        }
        Ok(Some(values))
    }

    /// Columns that say which step, set or specimen a row is of.
    fn labels(&self) -> impl Iterator<Item = usize> {
        const WORDS: [&str; 16] = [
            "step",
            "segment",
            "set",
            "interval",
            "cycle",
            "specimen",
            "sample",
            "curve",
            "sweep",
            "repeat",
            "replicate",
            "intervall",
            "abschnitt",
            "zyklus",
            "probe",
            "schritt",
        ];
        let names = self.heading.names.iter().enumerate();
        names.filter_map(|(place, name)| {
            let is_read = self.found.iter().any(|found| found.place == place);
            let lower = name.to_lowercase();
            let mut words = lower.split(|c: char| !c.is_alphanumeric());
            let is_label = !is_read
                && words.any(|word| WORDS.contains(&word))
                && understand(name, self.heading.unit(place)).is_none();
            is_label.then_some(place)
        })
    }

    fn pieces(&self) -> Vec<Piece<'_>> {
        let rows = self.block.rows.len();
        let column = |place: usize| values(self.block, place, self.sign);
        let mut cuts = self
            .clock()
            .map_or_else(Vec::new, |clock| restarts(&column(clock.place)));
        let has = |columns: [Column; 2]| {
            self.found
                .iter()
                .any(|found| columns.contains(&found.column))
        };
        let moves = has([Column::Strain, Column::Position]) && has([Column::Stress, Column::Force]);
        let labels: Vec<usize> = self.labels().collect();
        // A motion goes on over its steps.
        if !moves {
            cuts.extend(labels.iter().flat_map(|place| changes(self.block, *place)));
        }
        let temperature = self.temperature.as_ref().map(|found| {
            let unit = self.heading.unit(found.place);
            let told = split(&found.name).1.unwrap_or_default();
            let unit = if unit.is_empty() { told.as_str() } else { unit };
            let numbers = column(found.place);
            numbers
                .into_iter()
                .map(|value| celsius(value, unit))
                .collect::<Vec<f64>>()
        });
        cuts.extend(temperature.iter().flat_map(|numbers| jumps(numbers)));
        let ranges = between(cuts, rows);
        let name = self.block.name(&self.heading);
        let count = ranges.len();
        let pieces = ranges.into_iter().enumerate().map(|(n, rows)| {
            let temperature_c = temperature.as_ref().and_then(|numbers| {
                let numbers = numbers[rows.clone()]
                    .iter()
                    .filter(|number| number.is_finite());
                let (sum, count) = numbers.fold((0.0, 0.0), |(sum, count), number| {
                    (sum + number, count + 1.0)
                });
                (count > 0.0).then_some(sum / count)
            });
            let label = labels.iter().map(|place| {
                let cell = self.block.rows[rows.start].1.get(*place).unwrap_or("");
                format!("{} {cell}", split(&self.heading.names[*place]).0)
            });
            let mut words: Vec<String> = name.iter().cloned().collect();
            if count > 1 {
                words.extend(label);
                words.extend(temperature_c.map(|t| format!("{:.1} °C", t)));
                if words.len() == usize::from(name.is_some()) {
                    words.push(format!("run {}", n + 1));
                }
            }
            let in_name = name.as_deref().and_then(degrees);
            let mut piece = Piece {
                part: self,
                rows,
                name: words.join(", "),
                temperature_c: temperature_c.or(in_name),
            };
            if piece.name.is_empty() {
                let [first, last] = piece.lines();
                piece.name = format!("lines {first} to {last}");
            }
            piece
        });
        pieces.collect()
    }
}

/// The temperature that a name says: 150 of `Frequency sweep (150.0 °C)`.
fn degrees(name: &str) -> Option<f64> {
    let before = name.split_once('°')?.0.trim_end();
    let digits = before.rfind(|c: char| !(c.is_ascii_digit() || "+-−.,".contains(c)));
    let from = digits.map_or(0, |at| {
        at + before[at..].chars().next().map_or(1, char::len_utf8)
    });
    haptic_quantity::number(&before[from..])
}

impl Piece<'_> {
    fn lines(&self) -> [u64; 2] {
        let line = |row: usize| self.part.block.rows[row].0;
        [line(self.rows.start), line(self.rows.end - 1)]
    }
}

fn pieces<'a>(parts: &'a [Part<'a>]) -> Vec<Piece<'a>> {
    parts.iter().flat_map(Part::pieces).collect()
}

/// The first few segments, for a message.
fn listed(pieces: &[Piece]) -> String {
    const FIRST: usize = 3;
    let named = pieces.iter().enumerate().take(FIRST).map(|(n, piece)| {
        let [first, last] = piece.lines();
        let name = brief(&piece.name);
        format!("{} {name:?} (lines {first} to {last})", n + 1)
    });
    let mut named: Vec<String> = named.collect();
    if pieces.len() > FIRST {
        named.push("…".to_owned());
    }
    named.join(", ")
}

/// What stands above the table and was not read, for the user to know.
fn preamble(part: &Part) -> Option<String> {
    const LETTERS: usize = 100;
    let lines =
        part.block.above.iter().filter(|(line, row)| {
            *line < part.heading.line && row.iter().any(|cell| !cell.is_empty())
        });
    let lines: Vec<_> = lines.collect();
    let ((first, _), (last, _)) = (lines.first()?, lines.last()?);
    let texts = lines.iter().map(|(_, row)| {
        let cells: Vec<&str> = row.iter().filter(|cell| !cell.is_empty()).collect();
        cells.join(" ").replace(char::is_control, " ")
    });
    let text = texts.collect::<Vec<_>>().join("; ");
    let mut short: String = text.chars().take(LETTERS).collect();
    if short.len() < text.len() {
        short.push('…');
    }
    let lines = match first == last {
        true => format!("line {first}"),
        false => format!("lines {first} to {last}"),
    };
    Some(format!(
        "{lines} above the header are no part of the table: {short}"
    ))
}

/// Rows of blocks in which nothing is known.
fn unread(table: &TextTable, parts: &[Part]) -> Option<String> {
    let is_read = |block: &Block| parts.iter().any(|part| std::ptr::eq(part.block, block));
    let blocks = table.blocks.iter().filter(|block| !is_read(block));
    let lines: Vec<u64> = blocks
        .flat_map(|block| block.rows.iter().map(|row| row.0))
        .collect();
    rows_named(&lines)
        .map(|rows| format!("{rows} of another table left out: no record is in its columns"))
}

/// Names that a message lists, at most.
const NAMED: usize = 20;

fn place(heading: &Heading, choice: &Choice) -> Result<usize, IdentifyError> {
    let found = match choice {
        Choice::Number(n) => (1..=heading.names.len()).contains(n).then(|| n - 1),
        Choice::Name(name) => {
            let name = &brief(name);
            let exact = heading.names.iter().position(|header| header == name);
            let same = |header: &String| {
                split(header).0.eq_ignore_ascii_case(name) || header.eq_ignore_ascii_case(name)
            };
            exact.or_else(|| heading.names.iter().position(same))
        }
    };
    found.ok_or_else(|| {
        let wanted = match choice {
            Choice::Number(n) => n.to_string(),
            Choice::Name(name) => format!("\"{name}\""),
        };
        let names = heading.names.iter().filter(|name| !name.is_empty());
        wrong(
            heading.line,
            &format!(
                "there is no column {wanted}: give {COLUMNS} one of 1 to {} or of {}",
                heading.names.len(),
                names
                    .take(NAMED)
                    .map(|name| brief(name))
                    .collect::<Vec<_>>()
                    .join(", ")
            ),
        )
    })
}
