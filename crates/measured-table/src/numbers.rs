//! Columns of numbers in SI units from the blocks of a table.

use super::column::{Choice, Column};
use super::columns::Columns;
use super::error::TableError;
use super::errors::ErrorColumn;
use super::find::Block;
use super::header::{Meaning, Unit, foreign, logarithm, split, understand};
use super::heading::Heading;
use super::keys::{COLUMNS, FROM, SEGMENT, SEGMENTS, TO, UNITS};
use super::lines::{are_few, brief, passed, rows_named, wrong};
use super::segments::{between, changes, jumps, restarts};
use super::text::TextTable;
use super::unit::celsius;
use fracdiff::parameter::Shown;
use serde::Serialize;
use std::f64::consts::FRAC_PI_2;
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
    /// True to leave out rows that are no sample, a tenth of them at most, and to name them.
    pub skip_bad_rows: bool,
}

/// A part of a table that is a record of its own.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Segment {
    /// Number from 1, in the order of the file.
    #[serde(rename = "segment")]
    pub number: usize,
    /// The name of its step, set or interval, or its lines.
    pub name: String,
    /// Its first and its last line in the file, from 1.
    pub lines: [u64; 2],
    /// Number of rows of the segment.
    pub rows: usize,
    /// Least and largest time, s, or angular frequency, rad/s.
    pub clock: Option<[f64; 2]>,
    /// Mean temperature, °C, if a column or the name says it.
    pub temperature_c: Option<f64>,
    /// Headers of the columns that are read.
    pub columns: Vec<String>,
}

pub(super) struct Found {
    pub(super) column: Column,
    pub(super) place: usize,
    name: String,
    unit: Unit,
    /// Base of the logarithms that its cells are, if they are.
    base: Option<f64>,
    /// True of a distance that falls while the depth grows.
    falls: bool,
}

impl Found {
    fn new(column: Column, place: usize, name: &str, unit: Unit) -> Self {
        let base = logarithm(name).map(|of| of.0);
        let falls = column == Column::Position && name.to_lowercase().contains("separation");
        let name = name.to_owned();
        Self {
            falls,
            column,
            place,
            name,
            unit,
            base,
        }
    }

    /// The number that a cell means, in the column's unit.
    fn number(&self, cell: f64) -> f64 {
        let number = self.base.map_or(cell, |base| libm::pow(base, cell));
        if self.falls { -number } else { number }
    }
}

/// A block under its heading, and the columns of a record in it.
pub(super) struct Part<'a> {
    pub(super) block: &'a Block,
    pub(super) heading: Heading,
    pub(super) found: Vec<Found>,
    pub(super) unclear: Vec<(Column, String)>,
    pub(super) errors: Vec<ErrorColumn>,
    temperature: Option<usize>,
}

/// A segment of a part.
struct Piece<'a> {
    part: &'a Part<'a>,
    rows: Range<usize>,
    name: String,
    temperature_c: Option<f64>,
}

/// A strain above it, without a unit, may be in per cent.
const STRAIN_PLAIN: f64 = 1.0;

/// Largest logarithm that is believed.
const MOST_POWER: f64 = 30.0;

fn is_clock(column: Column) -> bool {
    matches!(column, Column::Time | Column::Omega)
}

impl Reader {
    /// The one segment of a table as columns with quantities of a record.
    ///
    /// # Errors
    /// As [`read_all`](Self::read_all), and if it would read more than one.
    pub fn read(&self, table: TextTable) -> Result<Columns, TableError> {
        let mut all = self.read_all(&table)?;
        match (all.pop(), all.len()) {
            (Some(one), 0) => Ok(one),
            (_, others) => Err(TableError::Whole(format!(
                "{} segments are more than one record: give {SEGMENT} one of them",
                others + 1
            ))),
        }
    }

    /// The chosen segments of a table, in the order of the file; of a table with one, that.
    ///
    /// # Errors
    /// Several segments without a choice, a choice that fits no single segment, a wrong unit, a cell that is not a number, with line and column.
    pub fn read_all(&self, table: &TextTable) -> Result<Vec<Columns>, TableError> {
        let parts = self.parts(table)?;
        let pieces = pieces(&parts);
        let chosen = self.chosen(&pieces)?.into_iter().map(|n| {
            let piece = &pieces[n];
            table.check(piece.part.block, &piece.part.heading)?;
            let mut columns = self.columns(piece)?;
            columns.segment = (pieces.len() > 1).then(|| piece.name.clone());
            columns.notes.extend(preamble(piece.part));
            columns.notes.extend(piece.part.block.drops_names.then(|| "the header has a name fewer than rows have cells: their first cell is taken as their own name, and columns count from the second".to_owned()));
            columns.notes.extend(unread(table, &parts));
            Ok(columns)
        });
        chosen.collect()
    }

    /// Segments from which a user can choose.
    ///
    /// # Errors
    /// A table without a column that is known.
    pub fn segments(&self, table: &TextTable) -> Result<Vec<Segment>, TableError> {
        let parts = self.parts(table)?;
        let segments = pieces(&parts).into_iter().enumerate().map(|(n, piece)| {
            let clock = piece.part.clock().and_then(|clock| {
                let values = piece.part.values(clock.place, piece.rows.clone())?;
                let known = || values.iter().copied().filter(|value| value.is_finite());
                let ends = [
                    known().fold(f64::INFINITY, f64::min),
                    known().fold(f64::NEG_INFINITY, f64::max),
                ];
                let factor = clock.unit.factor().unwrap_or(1.0);
                Some(ends.map(|end| clock.number(end) * factor))
            });
            let found = piece.part.found.iter();
            Segment {
                number: n + 1,
                lines: piece.lines(),
                rows: piece.rows.len(),
                clock,
                temperature_c: piece.temperature_c,
                columns: found.map(|found| found.name.clone()).collect(),
                name: piece.name,
            }
        });
        Ok(segments.collect())
    }

    /// Blocks that may be records, each with its heading and columns: those with a clock and something beside it, if there are any; of
    /// blocks in which nothing is known the largest.
    fn parts<'a>(&self, table: &'a TextTable) -> Result<Vec<Part<'a>>, TableError> {
        let mut parts: Vec<Part<'a>> = Vec::new();
        let mut refused = None;
        for block in &table.blocks {
            match self.heading(block, parts.last()) {
                Ok(heading) => parts.push(self.part(block, heading)?),
                Err(error) => refused = refused.or(Some(error)),
            }
        }
        if parts.iter().any(Part::is_whole) {
            parts.retain(Part::is_whole);
        }
        if let (true, Some(error)) = (parts.is_empty(), refused) {
            return Err(error);
        }
        Ok(parts)
    }

    /// The names above a block: those that the user's choice, or any known quantity, is found in.
    pub(super) fn heading(
        &self,
        block: &Block,
        before: Option<&Part>,
    ) -> Result<Heading, TableError> {
        let mut headings = block.headings();
        let mut choices = self.columns.iter();
        let is_numbered = choices.any(|choice| matches!(choice.1, Choice::Number(_)));
        // A block without names of its own keeps the previous ones, as does one below a lone line between its rows.
        let is_lone = |before: &Part| {
            let [line] = &block.above[..] else {
                return false;
            };
            let [first, last] = [block.lines()[0], before.block.lines()[1]];
            line.0 == last + 1 && line.0 + 1 == first
        };
        let goes_on = |before: &&Part| {
            before.block.numeric == block.numeric && (headings.is_empty() || is_lone(before))
        };
        match before.filter(goes_on) {
            Some(before) => headings.push(before.heading.clone()),
            None if is_numbered => headings.push(block.numbered()),
            None => {}
        }
        let named = block.headed(headings, |heading| {
            for (_, choice) in &self.columns {
                place(heading, choice)?;
            }
            let mut names = heading.names.iter().enumerate();
            let is_known =
                |cell: (usize, &String)| understand(cell.1, heading.below(cell.0)).is_some();
            if !self.columns.is_empty() || names.any(is_known) {
                return Ok(());
            }
            Err(format!(
                "none of the columns {} is known: give {COLUMNS}, as in time=1,modulus=2",
                listed_names(heading)
            ))
        });
        named.map(|(heading, ())| heading).map_err(|refused| {
            let what =
                format!("there is no header: add one, or give {COLUMNS}, as in time=1,modulus=2");
            refused.map_or_else(|| wrong(block.lines()[0], &what), |(_, error)| error)
        })
    }

    pub(super) fn part<'a>(
        &self,
        block: &'a Block,
        heading: Heading,
    ) -> Result<Part<'a>, TableError> {
        let mut part = Part {
            found: self.named(&heading)?,
            ..Part::unknown(block, heading)
        };
        let is_named =
            |is_it: fn(Column) -> bool| part.found.iter().any(|found| is_it(found.column));
        // A clock and another column are a record: no other column is looked at.
        if !(is_named(is_clock) && is_named(|column| !is_clock(column))) {
            self.known(&mut part);
        }
        part.temperature = part.of(Column::Temperature).map(|found| found.place);
        part.found
            .retain(|found| found.column != Column::Temperature);
        if self.columns.is_empty() {
            keep_sweep(&mut part.found);
        }
        // Of what is not read nothing is asked.
        let (found, line) = (&part.found, part.heading.line);
        let is_read = |column: Column| found.iter().any(|found| found.column == column);
        part.unclear.retain(|(column, _)| is_read(*column));
        let doubts = found.iter().filter_map(|found| self.doubt(found, line));
        part.unclear.extend(doubts);
        part.errors = part.errors_beside();
        Ok(part)
    }

    /// Columns that a user named; their units as far as they are known.
    fn named(&self, heading: &Heading) -> Result<Vec<Found>, TableError> {
        let named = self.columns.iter().map(|&(column, ref choice)| {
            let place = place(heading, choice).map_err(|what| wrong(heading.line, &what))?;
            let unit = heading.unit_as(column, place);
            Ok(Found::new(column, place, &heading.names[place], unit))
        });
        named.collect()
    }

    /// Columns with a known name. Of several of one quantity the best counts; as good ones are asked for.
    fn known(&self, part: &mut Part) {
        let (heading, found) = (&part.heading, &mut part.found);
        let named = found.len();
        let names = heading.names.iter().enumerate();
        let meanings = names.filter_map(|(place, name)| {
            let meaning = understand(name, heading.below(place))?;
            let is_new = |other: &Found| other.place != place && other.column != meaning.column;
            let is_open = !part.block.is_blank(place) && found.iter().all(is_new);
            is_open.then_some((place, name, meaning))
        });
        let mut meanings: Vec<(usize, &String, Meaning)> = meanings.collect();
        let rank = |(place, _, meaning): &(usize, &String, Meaning)| {
            let is_foreign = matches!(meaning.unit, Unit::Foreign(_));
            (
                !part.block.numeric.contains(place),
                is_foreign,
                meaning.rank,
            )
        };
        meanings.sort_by_key(|found| (found.2.column as usize, rank(found)));
        for alike in meanings.chunk_by(|a, b| a.2.column == b.2.column) {
            let (place, name, meaning) = alike[0].clone();
            let (column, unit) = (meaning.column, meaning.unit);
            if let Some(rival) = alike[1..]
                .iter()
                .find(|other| rank(other) == rank(&alike[0]))
            {
                let asked = format!(
                    "line {}: the columns {name} and {} both look like {kind}: give {COLUMNS} {kind}={} or {kind}={}",
                    heading.line,
                    rival.1,
                    place + 1,
                    rival.0 + 1,
                    kind = column.name()
                );
                part.unclear.push((column, asked));
            }
            found.push(Found::new(column, place, name, unit));
        }
        found[named..].sort_by_key(|found| found.place);
    }

    /// Question about a unit that could be misread.
    fn doubt(&self, found: &Found, line: u64) -> Option<(Column, String)> {
        let (column, name) = (found.column, &found.name);
        let is_named = self.columns.iter().any(|choice| choice.0 == column);
        let doubt = match &found.unit {
            Unit::Either => {
                format!("its unit may be Hz or rad/s: give {UNITS} omega=Hz or omega=rad/s")
            }
            Unit::Foreign(unit) if !is_named => foreign(unit, column),
            Unit::Foreign(_) | Unit::Factor(_) | Unit::Weight(_) | Unit::Untold => return None,
        };
        let asked = format!("line {line}, column {name}: {doubt}");
        self.unit_of(column).is_none().then_some((column, asked))
    }

    fn unit_of(&self, column: Column) -> Option<&str> {
        let unit = self.units.iter().find(|unit| unit.0 == column);
        unit.map(|unit| unit.1.as_str())
    }

    /// Places of the chosen segments in the list.
    fn chosen(&self, pieces: &[Piece]) -> Result<Vec<usize>, TableError> {
        if self.segments.is_empty() && pieces.len() > 1 {
            return Err(TableError::Whole(format!(
                "{} segments could be meant, {}: give {SEGMENT} one or several of them, or {SEGMENTS} to list all{}",
                pieces.len(),
                listed(pieces),
                if pieces.iter().any(|piece| piece.part.is_whole()) {
                    String::new()
                } else {
                    format!("; and {COLUMNS}, as in time=1,modulus=2")
                }
            )));
        }
        let all: Vec<usize> = (0..pieces.len()).collect();
        if self.segments.is_empty() {
            return Ok(all);
        }
        let mut chosen = Vec::new();
        for wanted in &self.segments {
            let lower = wanted.trim().to_lowercase();
            let one = |is_it: &dyn Fn(&str) -> bool| {
                let is_named = |n: &usize| is_it(&pieces[*n].name.to_lowercase());
                let found: Vec<usize> = all.iter().copied().filter(is_named).collect();
                Some(found).filter(|found| found.len() == 1)
            };
            let found = match lower.parse::<usize>() {
                Ok(number) if (1..=all.len()).contains(&number) => Some(vec![number - 1]),
                // A label may be a number.
                Ok(_) => one(&|name| name.split(", ").next() == Some(lower.as_str())),
                Err(_) if lower == "all" => Some(all.clone()),
                Err(_) => one(&|name| name == lower).or_else(|| one(&|name| name.contains(&lower))),
            };
            chosen.extend(found.ok_or_else(|| {
                TableError::Whole(format!(
                    "there is no one segment {wanted:?}: give {SEGMENT} a number from 1 to {}, or a name, of {}",
                    pieces.len(),
                    listed(pieces)
                ))
            })?);
        }
        chosen.sort_unstable();
        chosen.dedup();
        Ok(chosen)
    }

    /// A segment in SI units.
    fn columns(&self, piece: &Piece) -> Result<Columns, TableError> {
        let part = piece.part;
        let (mut notes, mut empty, mut outside) = (Vec::new(), Vec::new(), Vec::new());
        let places = part.found.iter().map(|found| found.place);
        let places = places.chain(part.errors.iter().map(|errors| errors.place));
        let places: Vec<usize> = places.collect();
        let (block, rows) = (part.block, piece.rows.clone());
        let mut bad = Vec::new();
        let skipped = self.skip_bad_rows.then_some(&mut bad);
        let numbers = block.numbers(&part.heading, &places, rows.clone(), skipped);
        let mut numbers = numbers.map_err(|error| {
            let mut bad = Vec::new();
            let read = block.numbers(&part.heading, &places, rows.clone(), Some(&mut bad));
            bad.dedup();
            if read.is_ok() && are_few(bad.len(), rows.len()) {
                error.or_skip()
            } else {
                error
            }
        })?;
        bad.dedup();
        let (mut unclear, mut factors) = (part.unclear.clone(), Vec::new());
        for (f, column) in part.found.iter().zip(&mut numbers) {
            let reach = |column: &[f64]| column.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            if let Some(base) = f.base {
                let (reach, base) = (reach(column), if base < 10.0 { "e" } else { "10" });
                if reach > MOST_POWER {
                    return Err(TableError::Whole(format!(
                        "column {} has the name of a logarithm, and {base} to the power of {} is no number of a record: change its name if its cells are no logarithms",
                        f.name,
                        Shown(reach)
                    )));
                }
                notes.push(format!(
                    "column {} holds logarithms to the base {base}: its cells are taken to the power; begin its name with ln or log10 if the base is another",
                    f.name
                ));
            }
            if f.falls {
                notes.push(format!(
                    "column {}: the depth is counted against the separation",
                    f.name
                ));
            }
            column.iter_mut().for_each(|cell| *cell = f.number(*cell));
            let reach = reach(column);
            let factor = self.factor(f, reach, &mut notes)?;
            column.iter_mut().for_each(|value| *value *= factor);
            factors.push(factor);
            if f.column == Column::Strain && f.unit == Unit::Untold && reach > STRAIN_PLAIN {
                let asked = format!(
                    "line {}, column {}: its unit may be % or 1, with values up to {}: give {UNITS} strain=% or strain=1",
                    part.heading.line,
                    f.name,
                    Shown(reach)
                );
                // A user who names the column, or its unit, is not asked again.
                let is_named = self.columns.iter().any(|choice| choice.0 == f.column);
                let is_settled = is_named || self.unit_of(f.column).is_some();
                unclear.extend((!is_settled).then_some((f.column, asked)));
            }
        }
        let (values, errors) = numbers.split_at_mut(part.found.len());
        for (one, cells) in part.errors.iter().zip(errors) {
            for (cell, value) in cells.iter_mut().zip(&values[one.of]) {
                *cell = one.size(part.found[one.of].base, *cell, *value, factors[one.of]);
            }
        }
        let is_read = |column| part.found.iter().any(|found| found.column == column);
        if let Some((column, unit)) = self.units.iter().find(|unit| !is_read(unit.0)) {
            return Err(TableError::Whole(format!(
                "{}={unit} of {UNITS} has no effect on this record, of which no such column is read: omit it",
                column.name()
            )));
        }
        let clock = part.found.iter().position(|found| is_clock(found.column));
        let at = |n: usize| clock.map_or(0.0, |column| numbers[column][n]);
        let is_outside =
            |at: f64| self.from.is_some_and(|from| at < from) || self.to.is_some_and(|to| at > to);
        let mut kept = Vec::new();
        for (n, (line, _)) in block.rows[rows.clone()].iter().enumerate() {
            if bad.contains(line) {
                // Named with those that make no sample.
            } else if numbers.iter().any(|column| column[n].is_nan()) {
                empty.push(*line);
            } else if is_outside(at(n)) {
                outside.push(*line);
            } else {
                kept.push(n);
            }
        }
        notes.extend(passed(&empty, "a cell without a number"));
        notes.extend(passed(&outside, "outside the range asked for"));
        if let (Some(from), Some(to)) = (self.from, self.to)
            && from > to
        {
            return Err(TableError::Whole(format!(
                "{FROM} {} is above {TO} {}: exchange them",
                Shown(from),
                Shown(to)
            )));
        }
        if kept.is_empty() {
            return Err(TableError::Whole(
                "no row with numbers is left: give at least one more than the model has parameters"
                    .to_owned(),
            ));
        }
        // A set may be written from its last time to its first.
        if kept.len() > 2 && kept.windows(2).all(|pair| at(pair[0]) > at(pair[1])) {
            kept.reverse();
            notes.push(
                "the rows are read from the last to the first, because their clock falls"
                    .to_owned(),
            );
        }
        let names = part.found.iter().map(|found| (found.column, &found.name));
        let errors = part.errors.iter();
        let names = names.chain(errors.map(|one| (part.found[one.of].column, &one.name)));
        let named = names.zip(&numbers).map(|((column, name), numbers)| {
            let kept = kept.iter().map(|&n| numbers[n]);
            (column, name.clone(), kept.collect())
        });
        let mut named: Vec<_> = named.collect();
        let errors = named.split_off(part.found.len());
        Ok(Columns {
            lines: kept.iter().map(|n| block.rows[rows.start + n].0).collect(),
            values: named,
            errors,
            chosen: self.columns.iter().map(|(column, _)| *column).collect(),
            notes,
            unclear,
            bad: self.skip_bad_rows.then_some(bad),
            temperature_c: piece.temperature_c,
            ..Columns::default()
        })
    }

    /// The first number of a column that is read, in SI units, and its factor.
    pub(super) fn first(&self, part: &Part<'_>, found: &Found) -> Option<[f64; 2]> {
        let all = part.values(found.place, 0..part.block.rows.len())?;
        let mut numbers = all.iter().map(|cell| found.number(*cell));
        let reach = numbers.clone().fold(0.0, |most: f64, x| most.max(x.abs()));
        let first = numbers.find(|number| number.is_finite())?;
        let factor = self.factor(found, reach, &mut Vec::new()).ok()?;
        Some([first * factor, factor])
    }

    /// The first number of a column of errors, in SI units.
    pub(super) fn first_error(&self, part: &Part<'_>, errors: &ErrorColumn) -> Option<f64> {
        let all = part.values(errors.place, 0..part.block.rows.len())?;
        let cell = all.into_iter().find(|cell| cell.is_finite())?;
        let of = &part.found[errors.of];
        let [value, factor] = self.first(part, of)?;
        Some(errors.size(of.base, cell, value, factor))
    }

    /// SI units per unit of a column whose values go up to `reach`: the user's, the header's, else SI with a note.
    fn factor(
        &self,
        found: &Found,
        reach: f64,
        notes: &mut Vec<String>,
    ) -> Result<f64, TableError> {
        let (column, name) = (found.column, &found.name);
        let Some(unit) = self.unit_of(column) else {
            if column == Column::Phase && found.unit == Unit::Untold && reach > FRAC_PI_2 {
                notes.push(format!(
                    "column {name} names no unit: taken as degrees, for {} is above π/2",
                    Shown(reach)
                ));
                return Ok(1.0_f64.to_radians());
            }
            if found.unit.factor().is_none()
                && !matches!(column, Column::Strain | Column::LossTangent)
            {
                let si = column.dimension().si();
                let named = name.strip_prefix("column ").unwrap_or(name);
                notes.push(format!("column {named} names no unit: taken as {si}"));
            }
            if let Unit::Weight(_) = found.unit {
                notes.push(format!(
                    "column {name}: a mass is no force, and is taken as its weight, 9.80665 N for 1 kg: write gf, kgf or lbf in the header to say so, or the right unit"
                ));
            }
            return Ok(found.unit.factor().unwrap_or(1.0));
        };
        let given = column.dimension().size(unit);
        let given = given
            .ok_or_else(|| TableError::Whole(foreign(unit, column)))?
            .si;
        match found.unit.factor() {
            Some(named) if (named / given - 1.0).abs() > 1e-9 => Err(TableError::Whole(format!(
                "column {name} names its own unit: omit {}={unit} of {UNITS}",
                column.name()
            ))),
            _ => Ok(given),
        }
    }
}

/// A complete sweep has no use for the clock and the amplitudes beside it, nor for its moduli in other words.
fn keep_sweep(found: &mut Vec<Found>) {
    let moduli = [
        Column::Storage,
        Column::Loss,
        Column::Phase,
        Column::LossTangent,
        Column::Complex,
    ];
    let has = |column: &Column| found.iter().any(|found| found.column == *column);
    // The phase and its tangent are one number.
    let is_double = |column: &Column| *column == Column::LossTangent && has(&Column::Phase);
    let kept = moduli.into_iter().filter(|one| has(one) && !is_double(one));
    let kept: Vec<Column> = kept.take(2).collect();
    if has(&Column::Omega) && kept.len() == 2 {
        found.retain(|found| found.column == Column::Omega || kept.contains(&found.column));
    }
}

impl<'a> Part<'a> {
    /// Part without any column of a record.
    pub(super) const fn unknown(block: &'a Block, heading: Heading) -> Self {
        Self {
            block,
            heading,
            found: Vec::new(),
            unclear: Vec::new(),
            errors: Vec::new(),
            temperature: None,
        }
    }

    /// True of a column of temperatures, or of labels.
    pub(super) fn tells_apart(&self, place: usize) -> bool {
        self.temperature == Some(place) || self.labels().contains(&place)
    }
}

impl Part<'_> {
    /// The columns of errors, the first of each measured column.
    fn errors_beside(&self) -> Vec<ErrorColumn> {
        let found = self.found.iter();
        let measured = found.map(|found| (found.column, found.place, &found.name[..]));
        let measured: Vec<_> = measured.collect();
        let mut errors: Vec<ErrorColumn> = Vec::new();
        for &place in &self.block.numeric {
            let is_open =
                place < self.heading.names.len() && !measured.iter().any(|found| found.1 == place);
            let named = is_open.then(|| ErrorColumn::named(&self.heading, &measured, place));
            let is_first = |one: &ErrorColumn| errors.iter().all(|other| other.of != one.of);
            errors.extend(named.flatten().filter(is_first));
        }
        errors
    }

    /// True if it has a clock and something beside it.
    pub(super) fn is_whole(&self) -> bool {
        self.clock().is_some() && self.found.iter().any(|found| !is_clock(found.column))
    }

    fn clock(&self) -> Option<&Found> {
        self.of(Column::Omega).or_else(|| self.of(Column::Time))
    }

    fn of(&self, column: Column) -> Option<&Found> {
        self.found.iter().find(|found| found.column == column)
    }

    /// A column of numbers in its own unit, if it is one.
    fn values(&self, place: usize, rows: Range<usize>) -> Option<Vec<f64>> {
        let columns = self.block.numbers(&self.heading, &[place], rows, None);
        columns.ok()?.pop()
    }

    /// Columns that say which step, set or specimen a row is of.
    fn labels(&self) -> Vec<usize> {
        const WORDS: &str = "step, segment, set, interval, cycle, specimen, sample, curve, sweep, repeat, replicate, action, abschnitt, zyklus, probe";
        let is_label = |place: &usize| {
            let name = self.heading.names[*place].to_lowercase();
            let mut words = name.split(|c: char| !c.is_alphanumeric());
            // `2|7` is the seventh row of the second step.
            let is_counted = name.is_empty() && self.block.cell(0, *place).contains('|');
            (is_counted || words.any(|word| WORDS.split(", ").any(|label| label == word)))
                && !self.found.iter().any(|found| found.place == *place)
                && understand(&name, self.heading.below(*place)).is_none()
        };
        (0..self.heading.names.len()).filter(is_label).collect()
    }

    fn pieces(&self) -> Vec<Piece<'_>> {
        let rows = self.block.rows.len();
        let clock = self
            .clock()
            .and_then(|clock| self.values(clock.place, 0..rows));
        let mut cuts = clock.map_or_else(Vec::new, |clock| restarts(&clock));
        let has = |columns: [Column; 2]| columns.iter().any(|column| self.of(*column).is_some());
        let moves = has([Column::Strain, Column::Position]) && has([Column::Stress, Column::Force]);
        let labels = self.labels();
        // A motion continues over its steps.
        if !moves {
            cuts.extend(labels.iter().flat_map(|place| changes(self.block, *place)));
        }
        let temperature = self.temperature.and_then(|place| {
            let unit = self.heading.unit(place).unwrap_or_default();
            let numbers = self.values(place, 0..rows)?.into_iter();
            let celsius = numbers.map(|value| celsius(value, &unit));
            Some(celsius.collect::<Vec<f64>>())
        });
        cuts.extend(temperature.iter().flat_map(|numbers| jumps(numbers)));
        let ranges = between(cuts, rows);
        let name = self.block.name(&self.heading);
        let count = ranges.len();
        let pieces = ranges.into_iter().map(|rows| {
            let temperature_c = temperature.as_ref().and_then(|numbers| {
                let numbers = numbers[rows.clone()].iter();
                let numbers = numbers.filter(|number| number.is_finite());
                let count = numbers.clone().count();
                (count > 0).then(|| numbers.sum::<f64>() / count as f64)
            });
            let mut words: Vec<String> = name.iter().cloned().collect();
            if count > 1 {
                words.extend(labels.iter().map(|place| {
                    let label = self.block.label(rows.start, *place);
                    let named =
                        format!("{} {}", split(&self.heading.names[*place]).0, brief(label));
                    named.trim().to_owned()
                }));
                words.extend(temperature_c.map(|t| format!("{t:.1} °C")));
            }
            let mut piece = Piece {
                part: self,
                rows,
                name: String::new(),
                temperature_c,
            };
            if words.len() == usize::from(name.is_some()) && (count > 1 || words.is_empty()) {
                let [first, last] = piece.lines();
                words.push(format!("lines {first} to {last}"));
            }
            piece.name = words.join(", ");
            piece
        });
        pieces.collect()
    }
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
        format!("{} {:?} (lines {first} to {last})", n + 1, piece.name)
    });
    let named = named.chain((pieces.len() > FIRST).then(|| "…".to_owned()));
    named.collect::<Vec<_>>().join(", ")
}

/// Text above the table that was not read, for the user to know.
fn preamble(part: &Part) -> Option<String> {
    let (mut lines, mut texts) = (Vec::new(), Vec::new());
    for (line, row) in &part.block.above {
        let cells: Vec<&str> = row.iter().filter(|cell| !cell.is_empty()).collect();
        if *line < part.heading.line && !cells.is_empty() {
            lines.push(line);
            texts.push(cells.join(" "));
        }
    }
    let (first, last) = (lines.first()?, lines.last()?);
    Some(format!(
        "lines {first} to {last} above the header are not read: {}",
        brief(&texts.join("; "))
    ))
}

/// Rows of blocks in which nothing is known.
fn unread(table: &TextTable, parts: &[Part]) -> Option<String> {
    let is_read = |block: &Block| parts.iter().any(|part| std::ptr::eq(part.block, block));
    let blocks = table.blocks.iter();
    let (read, other) = blocks.partition::<Vec<_>, _>(|block| is_read(block));
    let names: Vec<u64> = parts.iter().map(|part| part.heading.line).collect();
    let broken = read.iter().filter_map(|block| block.broken.as_ref());
    let broken = broken.map(|row| row.0).filter(|line| !names.contains(line));
    let rows = other.iter().flat_map(|block| &block.rows);
    let lines: Vec<u64> = rows.map(|row| row.0).chain(broken).collect();
    let rows = rows_named(&lines)?;
    Some(format!("{rows} left out, no part of this table"))
}

/// The names of a heading, for a message.
fn listed_names(heading: &Heading) -> String {
    const NAMED: usize = 20;
    let names = heading.names.iter().filter(|name| !name.is_empty());
    names.take(NAMED).cloned().collect::<Vec<_>>().join(", ")
}

fn place(heading: &Heading, choice: &Choice) -> Result<usize, String> {
    let name = match choice {
        Choice::Number(number) => number.to_string(),
        Choice::Name(name) => name.clone(),
    };
    heading.place(&name)?.ok_or_else(|| {
        let shown = match choice {
            Choice::Number(_) => name,
            Choice::Name(_) => format!("\"{}\"", brief(&name)),
        };
        format!(
            "there is no column {shown}: give {COLUMNS} one of 1 to {} or of {}",
            heading.names.len(),
            listed_names(heading)
        )
    })
}
