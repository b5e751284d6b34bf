//! The text of a table: delimiter, header, rows, and what is passed over.

use super::super::error::IdentifyError;
use super::super::record::SAMPLES_MOST;
use super::column::Column;
use super::header::{split, understand};
use super::unit::Dimension;
use csv::StringRecord;
use std::borrow::Cow;

/// Largest size of a table, bytes.
pub const TABLE_MOST: u64 = 1 << 28;

/// Says which rows were passed over, and why.
pub(super) fn passed(lines: &[u64], why: &str) -> Option<String> {
    rows_named(lines).map(|rows| format!("{rows} left out, {why}"))
}

/// How many rows, and the lines of the first few; `None` without any.
#[must_use]
pub fn rows_named(lines: &[u64]) -> Option<String> {
    const NAMED: usize = 5;
    let count = lines.len();
    let named: Vec<String> = lines.iter().take(NAMED).map(ToString::to_string).collect();
    let more = if count > NAMED { ", …" } else { "" };
    let (rows, lines) = match count {
        0 => return None,
        1 => ("row", "line"),
        _ => ("rows", "lines"),
    };
    Some(format!(
        "{count} {rows} ({lines} {}{more})",
        named.join(", ")
    ))
}

/// The cells of a table, not yet numbers, with the line of each row for messages.
#[derive(Clone, Debug, PartialEq)]
pub struct TextTable {
    pub(super) header_line: u64,
    pub(super) header: Vec<String>,
    pub(super) rows: Vec<(u64, StringRecord)>,
    /// The first empty line between rows of numbers.
    blank: Option<u64>,
    /// Spaces separate the cells: an empty one is not seen.
    spaced: bool,
    above: Vec<u64>,
}

/// Reads a table as programs write them: cells apart by tabs, semicolons, commas or spaces, numbers with a point or a decimal comma, in UTF-8,
/// UTF-16 or Windows-1252. Lines that begin with `#`, empty lines, and lines above the header are passed over; the header is the first row
/// with a quantity of a record in it.
///
/// # Errors
/// A file that is not text, is empty or too long; a header with one column.
pub fn read_table(bytes: &[u8]) -> Result<TextTable, IdentifyError> {
    let table = TextTable::new(bytes)?.below(|header| {
        let known = header.iter().any(|name| understand(name).is_some());
        known.then_some(()).ok_or_else(String::new)
    });
    let (table, ()) = table.unwrap_or_else(|refused| (refused.0, ()));
    table.check()?;
    if table.header.len() < 2 {
        return Err(wrong(
            table.header_line,
            "there is only one column: give at least two, separated by tabs, commas or semicolons",
        ));
    }
    Ok(table)
}

/// Rows in which a header is looked for.
const ABOVE: usize = 60;

impl TextTable {
    /// All rows, the first as the header.
    fn new(bytes: &[u8]) -> Result<Self, IdentifyError> {
        if bytes.len() as u64 > TABLE_MOST {
            return Err(IdentifyError::Record(format!(
                "the table is longer than {TABLE_MOST} bytes: cut it into pieces, or omit unneeded columns"
            )));
        }
        let mut text = decoded(bytes)?;
        let delimiter = delimiter(&text)?;
        let spaced = delimiter == b' ';
        let delimiter = match delimiter {
            b' ' => {
                let lines = text.lines().map(|line| {
                    let cells: Vec<&str> = line.split_whitespace().collect();
                    cells.join("\t")
                });
                text = Cow::Owned(lines.collect::<Vec<String>>().join("\n"));
                b'\t'
            }
            delimiter => delimiter,
        };
        let mut rows = Vec::new();
        each_row(text.as_bytes(), delimiter, |line, row| {
            if rows.len() > SAMPLES_MOST + 1 {
                let reason = format!(
                    "more than {SAMPLES_MOST} rows: omit every second one, or cut the record"
                );
                return Err(wrong(line, &reason));
            }
            rows.push((line, row.clone()));
            Ok(())
        })?;
        let blank = blank_row(&text, delimiter);
        let mut table = Self {
            header_line: 1,
            header: Vec::new(),
            rows,
            blank,
            spaced,
            above: Vec::new(),
        };
        table.cut(0);
        Ok(table)
    }

    /// This row is the header, and those above it are none.
    fn cut(&mut self, place: usize) {
        let first = self.header.iter().map(String::as_str).collect();
        let mut above = vec![(self.header_line, first)];
        let mut rows = std::mem::take(&mut self.rows).into_iter();
        above.extend(rows.by_ref().take(place));
        let (line, header) = rows.next().unwrap_or_default();
        // A remark may have a number among its words.
        let is_sample = |row: &StringRecord| {
            let mut filled = row.iter().filter(|cell| !cell.is_empty());
            2 * filled.clone().count() > header.len() && filled.all(|cell| number(cell).is_some())
        };
        let samples = above.iter().filter(|(_, row)| is_sample(row));
        self.above.extend(samples.map(|(line, _)| *line));
        // Messages show names in one line.
        let names = header
            .iter()
            .map(|name| name.replace(char::is_control, " "));
        (self.header_line, self.header) = (line, names.collect());
        self.rows = rows.collect();
        self.blank = self.blank.filter(|blank| *blank > line);
    }

    /// Refuses what would be lost, rows of numbers above the header, and what would be read as another number: cells that have moved to another
    /// column, and commas of thousands.
    fn check(&self) -> Result<(), IdentifyError> {
        if let Some(rows) = rows_named(&self.above) {
            return Err(IdentifyError::Record(format!(
                "{rows} of numbers above the header in line {}: put them below it, or delete them",
                self.header_line
            )));
        }
        let width = self.header.len();
        let other = self.rows.iter().find(|(_, row)| row.len() != width);
        if let Some((line, row)) = other.filter(|_| self.spaced) {
            let reason = format!(
                "{} cells under a header of {width}: separate cells by tabs or semicolons, so that names with spaces and empty cells are seen",
                row.len()
            );
            return Err(wrong(*line, &reason));
        }
        let cells = self
            .rows
            .iter()
            .flat_map(|(line, row)| row.iter().map(move |cell| (*line, cell)));
        let numbers = cells.filter(|(_, cell)| number(cell).is_some());
        let (mut point, mut comma, mut decimal) = (false, None, false);
        for (line, cell) in numbers {
            point |= cell.contains('.');
            if let Some((whole, rest)) = cell.split_once(',') {
                comma = comma.or(Some((line, cell)));
                let whole = whole.trim_start_matches(['+', '-']);
                decimal |= whole.len() > 3 || whole.starts_with('0') || rest.len() != 3;
            }
        }
        match comma {
            Some((line, cell)) if point || !decimal => Err(wrong(
                line,
                &format!(
                    "{cell:?} has a comma that may separate thousands or decimals: write numbers without the former, and all decimals alike"
                ),
            )),
            _ => Ok(()),
        }
    }

    /// The table below the first row that a choice takes for its header; else as it is, with what the choice says of the row that has the most cells.
    fn below<C>(
        mut self,
        mut choose: impl FnMut(&[&str]) -> Result<C, String>,
    ) -> Result<(Self, C), Box<(Self, String)>> {
        let names: Vec<&str> = self.header.iter().map(String::as_str).collect();
        let mut refused = match choose(&names) {
            Ok(choice) => return Ok((self, choice)),
            Err(refused) => refused,
        };
        let filled = |row: &StringRecord| row.iter().filter(|cell| !cell.is_empty()).count();
        let mut best = (
            None,
            self.header.iter().filter(|cell| !cell.is_empty()).count(),
        );
        for (place, (_, row)) in self.rows.iter().take(ABOVE).enumerate() {
            let numbers = row.iter().filter(|cell| number(cell).is_some());
            if numbers.count() * 2 >= filled(row) {
                continue;
            }
            match choose(&row.iter().collect::<Vec<_>>()) {
                Ok(choice) => {
                    self.cut(place);
                    return Ok((self, choice));
                }
                Err(_) if filled(row) <= best.1 => {}
                Err(other) => (best, refused) = ((Some(place), filled(row)), other),
            }
        }
        if let Some(place) = best.0 {
            self.cut(place);
        }
        Err(Box::new((self, refused)))
    }
}

/// The text of a file, without its marks.
fn decoded(bytes: &[u8]) -> Result<Cow<'_, str>, IdentifyError> {
    let wide = |bytes: &[u8], unit: fn([u8; 2]) -> u16| {
        if bytes.len() % 2 == 1 {
            return Err(IdentifyError::Record(
                "this is UTF-16 of an odd number of bytes: its end is missing, save it again"
                    .to_owned(),
            ));
        }
        let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
        let text = char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER));
        Ok(Cow::Owned(text.collect::<String>()))
    };
    let text = match bytes {
        [0xff, 0xfe, rest @ ..] => wide(rest, u16::from_le_bytes)?,
        [0xfe, 0xff, rest @ ..] => wide(rest, u16::from_be_bytes)?,
        // Without a mark: the first letters are of one byte.
        [1..=u8::MAX, 0, 1..=u8::MAX, 0, ..] => wide(bytes, u16::from_le_bytes)?,
        [0, 1..=u8::MAX, 0, 1..=u8::MAX, ..] => wide(bytes, u16::from_be_bytes)?,
        bytes => {
            let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
            match std::str::from_utf8(bytes) {
                Ok(text) => Cow::Borrowed(text),
                // Windows-1252, but for a few signs that no number has.
                Err(_) => Cow::Owned(bytes.iter().map(|byte| char::from(*byte)).collect()),
            }
        }
    };
    let is_sign = |c: &char| c.is_control() && !"\t\r\n\u{b}\u{c}\u{85}".contains(*c);
    let is_text = text.chars().filter(is_sign).count() * 50 <= text.len();
    if !is_text || bytes.starts_with(b"PK\x03\x04") {
        return Err(IdentifyError::Record(
            "this is no text: export the table as CSV".to_owned(),
        ));
    }
    // Lines of an old Mac.
    Ok(match text.contains('\r') && !text.contains('\n') {
        true => Cow::Owned(text.replace('\r', "\n")),
        false => text,
    })
}

/// What separates the cells: tabs or semicolons if half of the lines have them, spaces if they have numbers apart by them, else commas.
fn delimiter(text: &str) -> Result<u8, IdentifyError> {
    let is_data = |line: &&str| !line.trim().is_empty() && !line.trim_start().starts_with('#');
    let lines = || text.lines().filter(is_data).take(4 * ABOVE);
    let count = lines().count();
    if count == 0 {
        return Err(IdentifyError::Record(
            "the table is empty: give a header and rows of numbers below it".to_owned(),
        ));
    }
    let half = |of: &dyn Fn(&str) -> bool| 2 * lines().filter(|line| of(line)).count() >= count;
    let mut marks = [b'\t', b';'].into_iter();
    if let Some(mark) = marks.find(|mark| half(&|line| line.as_bytes().contains(mark))) {
        return Ok(mark);
    }
    // A comma at the end of a cell separates, one inside is of decimals.
    let is_cell = |cell: &str| !cell.ends_with(',') && number(cell).is_some();
    let numbers = |line: &str| {
        line.split_whitespace().nth(1).is_some() && line.split_whitespace().all(is_cell)
    };
    Ok(if half(&numbers) { b' ' } else { b',' })
}

/// True if a line begins with a gap that looks like a remark.
fn has_marked_gap(bytes: &[u8]) -> bool {
    let mut lines = bytes.split(|&byte| byte == b'\n');
    lines.any(|line| {
        (line.trim_ascii_start().get(..4)).is_some_and(|start| start.eq_ignore_ascii_case(b"#n/a"))
    })
}

/// Line and cells of every row that has any, the header too, one after another.
fn each_row(
    bytes: &[u8],
    delimiter: u8,
    mut take: impl FnMut(u64, &StringRecord) -> Result<(), IdentifyError>,
) -> Result<(), IdentifyError> {
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .delimiter(delimiter)
        // A row that begins with the gap `#N/A` is none.
        .comment((!has_marked_gap(bytes)).then_some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(bytes);
    let mut row = StringRecord::new();
    let mut lines = Lines {
        bytes,
        seen: 0,
        breaks: 0,
    };
    while (reader.read_record(&mut row)).map_err(|error| {
        wrong(
            error.position().map_or(1, csv::Position::line),
            &format!("{error}: correct the row"),
        )
    })? {
        let line = lines.of_row_before(reader.position().byte(), &row);
        if row.iter().any(|cell| !cell.is_empty()) {
            take(line, &row)?;
        }
    }
    Ok(())
}

/// A column of numbers by the name that stands above it, and the column of time beside it, in s whatever its unit, if there is one; read as by [`read_table`].
///
/// A name is a header with or without its unit, such as `Zeit` for `Zeit [ms]`; `time_s` means the
/// column of time, whatever its name.
///
/// # Errors
/// As [`read_table`], but one column is enough; no or two columns of the name, two of time; no row; a cell that is not a finite number, with its line; an empty line without a time that would show what is missing.
pub fn read_signal(bytes: &[u8], name: &str) -> Result<Signal, IdentifyError> {
    let mut time = None;
    let (mut table, [place]) = chosen(bytes, |header| {
        time = find(TIME, header, true)?;
        places_of([name], header, false)
    })?;
    let mut factor = 1.0;
    if let Some(time) = time {
        factor = table.time_factor(time)?;
        table.blank = None;
    }
    let found = table.numbers([place, time.unwrap_or(place)], false)?;
    let [x, mut time_s] = found.columns;
    time_s.iter_mut().for_each(|time| *time *= factor);
    let (lines, time_s) = (found.lines, time.map(|_| time_s));
    Ok(Signal { lines, time_s, x })
}

/// A signal in a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Signal {
    /// The line of each row in the file, from 1, for messages.
    pub lines: Vec<u64>,
    /// Its times, if the table has them.
    pub time_s: Option<Vec<f64>>,
    /// As many as there are lines.
    pub x: Vec<f64>,
}

/// Time and signals of a record, found and read as there. What a row lacks is NaN, but of the time; empty lines do not
/// count, as the time shows what is missing. Also the lines of rows that lack something, for a person.
///
/// # Errors
/// As [`read_signal`]; no column of time, or a time that is missing; a unit that is not
/// one of time.
pub fn read_record<const N: usize>(
    bytes: &[u8],
    names: [&str; N],
) -> Result<RecordColumns<N>, IdentifyError> {
    let (mut table, places) = chosen(bytes, |header| places_of(names, header, true))?;
    let factor = table.time_factor(places[0])?;
    table.blank = None;
    let mut found = table.numbers(places, true)?;
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
    /// In the order of the requested names; NaN where a row lacks a signal.
    pub columns: [Vec<f64>; N],
    gaps: Vec<u64>,
}

impl<const N: usize> RecordColumns<N> {
    /// How many rows lack a number, and the lines of the first; `None` if none does.
    #[must_use]
    pub fn gaps(&self) -> Option<String> {
        rows_named(&self.gaps)
    }
}

/// Columns chosen by their positions in the header, and the line of each row.
///
/// # Errors
/// As [`read_signal`]; columns that the choice refuses, with the line of the header.
pub fn read_chosen<const N: usize>(
    bytes: &[u8],
    choose: impl FnMut(&[&str]) -> Result<[usize; N], String>,
) -> Result<(Vec<u64>, [Vec<f64>; N]), IdentifyError> {
    let (table, places) = chosen(bytes, choose)?;
    let found = table.numbers(places, false)?;
    Ok((found.lines, found.columns))
}

fn chosen<const N: usize>(
    bytes: &[u8],
    choose: impl FnMut(&[&str]) -> Result<[usize; N], String>,
) -> Result<(TextTable, [usize; N]), IdentifyError> {
    let found = TextTable::new(bytes)?.below(choose);
    let found = found.map_err(|refused| wrong(refused.0.header_line, &refused.1))?;
    found.0.check()?;
    Ok(found)
}

/// A cell that says that there is no number.
pub(super) fn is_gap(cell: &str) -> bool {
    const GAPS: [&str; 9] = ["", "nan", "na", "n/a", "#n/a", "-", "--", "null", "none"];
    GAPS.iter().any(|gap| cell.eq_ignore_ascii_case(gap))
}

impl TextTable {
    /// Numbers of columns, their lines, and the rows with gaps, which are NaN if there may be any.
    fn numbers<const N: usize>(
        &self,
        places: [usize; N],
        has_gaps: bool,
    ) -> Result<RecordColumns<N>, IdentifyError> {
        if let Some(line) = self.blank {
            return Err(wrong(line, NO_VALUE));
        }
        let (mut lines, mut gaps) = (Vec::new(), Vec::new());
        let mut columns = [const { Vec::new() }; N];
        for (line, row) in &self.rows {
            if row
                .iter()
                .skip(self.header.len())
                .any(|cell| !cell.is_empty())
            {
                return Err(wrong(*line, &too_many(row, self.header.len())));
            }
            lines.push(*line);
            let mut is_whole = true;
            for (column, &place) in columns.iter_mut().zip(&places) {
                let cell = row.get(place).unwrap_or("");
                let value = match has_gaps && is_gap(cell) {
                    true => Some(f64::NAN),
                    false => number(cell),
                };
                is_whole &= value.is_none_or(|value| !value.is_nan());
                column.push(value.ok_or_else(|| IdentifyError::Line {
                    line: *line,
                    column: self.header.get(place).cloned(),
                    reason: match cell {
                        "" => NO_VALUE.to_owned(),
                        cell => format!("{cell:?} is not a finite number"),
                    },
                })?);
            }
            if !is_whole {
                gaps.push(*line);
            }
        }
        match lines.is_empty() {
            true => Err(IdentifyError::Record(
                "no rows below the header: give numbers".to_owned(),
            )),
            false => Ok(RecordColumns {
                lines,
                columns,
                gaps,
            }),
        }
    }

    /// Seconds in the unit of a column of time, which its name or the row below says; that row is none of the record then.
    fn time_factor(&mut self, column: usize) -> Result<f64, IdentifyError> {
        let name = self.header[column].clone();
        let below = self.rows.first().and_then(|(_, row)| row.get(column));
        // A unit begins with no digit: `10:15:00` is no number of a record, and no unit.
        let is_unit =
            |cell: &&str| !is_gap(cell) && !cell.starts_with(|c: char| "+-.0123456789".contains(c));
        let below = below.filter(is_unit);
        let below = below.map(|cell| cell.trim_matches(['[', ']', '(', ')']).trim().to_owned());
        let in_name = split(&name).1;
        let suffix = name.rsplit_once('_');
        let suffix = suffix.and_then(|(_, unit)| Dimension::Time.factor_of_suffix(unit));
        let (Some(unit), line) = (match below {
            Some(unit) => (Some(unit), self.rows.remove(0).0),
            None => (in_name, self.header_line),
        }) else {
            return Ok(suffix.unwrap_or(1.0));
        };
        Dimension::Time.factor(&unit).ok_or_else(|| {
            let names = Dimension::Time.names();
            wrong(
                line,
                &format!("unit {unit:?} is not a unit of time: give one of {names}"),
            )
        })
    }
}

const NO_VALUE: &str = "no value: give a number in every row";

/// The first line without cells between others, the last such below every remark and header: a sample that is missing, which the next must not
/// replace.
fn blank_row(text: &str, delimiter: u8) -> Option<u64> {
    let is_blank = |c: char| c.is_whitespace() || c == char::from(delimiter);
    let is_empty = |line: &str| line.trim_matches(is_blank).is_empty();
    // Lines above the first row that is mostly numbers are none of the samples.
    let is_numbers = |line: &str| {
        let cells = line.split(char::from(delimiter));
        let cells = cells.map(|cell| cell.trim_matches([' ', '\t', '\r', '"']));
        let (numbers, cells) = cells
            .filter(|cell| !cell.is_empty())
            .fold((0, 0), |n, cell| {
                (n.0 + usize::from(number(cell).is_some()), n.1 + 1)
            });
        cells > 0 && 2 * numbers >= cells
    };
    let comment = |line: &str| line.trim_start().starts_with('#');
    let mut lines = (1..).zip(text.lines()).filter(|(_, line)| !comment(line));
    lines.find(|(_, line)| is_numbers(line))?;
    let (missing, _) = lines.find(|(_, line)| is_empty(line))?;
    lines.any(|(_, line)| !is_empty(line)).then_some(missing)
}

/// The places of these names.
fn places_of<const N: usize>(
    names: [&str; N],
    header: &[&str],
    any_time: bool,
) -> Result<[usize; N], String> {
    let mut places = [0; N];
    for (place, name) in places.iter_mut().zip(names) {
        let found = find(name, header, any_time && name == TIME)?;
        *place = found
            .ok_or_else(|| format!("no column {name} in the header {:?}", header.join(",")))?;
    }
    Ok(places)
}

/// The name that stands for the column of time.
const TIME: &str = "time_s";

/// The one column of this name, with its unit or without; or of any time.
fn find(name: &str, header: &[&str], any_time: bool) -> Result<Option<usize>, String> {
    let is_time = |cell: &str| {
        let heading = understand(cell).and_then(Result::ok);
        any_time && heading.is_some_and(|heading| heading.column == Column::Time)
    };
    let exact = |cell: &str| cell == name;
    let unitless = |cell: &str| split(cell).0.eq_ignore_ascii_case(name);
    let ways: [&dyn Fn(&str) -> bool; 3] = [&exact, &unitless, &is_time];
    for is_it in ways {
        let mut places = (0..header.len()).filter(|&place| is_it(header[place]));
        match (places.next(), places.next()) {
            (Some(place), None) => return Ok(Some(place)),
            (None, _) => {}
            (Some(_), Some(_)) => {
                return Err(format!(
                    "more than one column is named {name}: rename all but one"
                ));
            }
        }
    }
    Ok(None)
}

/// Why a row is wider than its header.
pub(super) fn too_many(row: &StringRecord, width: usize) -> String {
    format!(
        "{} cells under a header of {width}: separate cells by semicolons if decimals have commas",
        row.len()
    )
}

/// A finite number, with a point or a decimal comma. Where commas separate cells, a cell with one was in quotes.
pub(super) fn number(cell: &str) -> Option<f64> {
    let value = match cell.parse::<f64>() {
        Ok(value) => Some(value),
        Err(_) if cell.matches(',').count() == 1 => cell.replace(',', ".").parse().ok(),
        Err(_) => None,
    };
    value.filter(|value| value.is_finite())
}

/// Lines of rows: the reader's own count does not know of empty lines before a row.
struct Lines<'a> {
    bytes: &'a [u8],
    seen: usize,
    breaks: usize,
}

impl<'a> Lines<'a> {
    /// The line, from 1, of the row that ends before this byte.
    fn of_row_before(&mut self, end: u64, row: &StringRecord) -> u64 {
        let count = |bytes: &[u8]| bytes.iter().filter(|&&b| b == b'\n').count();
        let end = usize::try_from(end).map_or(self.bytes.len(), |end| end.min(self.bytes.len()));
        let part = &self.bytes[self.seen.min(end)..end];
        let inside: usize = row.iter().map(|cell| count(cell.as_bytes())).sum();
        let line =
            1 + self.breaks + count(part.trim_ascii_end()) - inside.min(self.breaks + count(part));
        self.breaks += count(part);
        self.seen = end;
        line as u64
    }
}

pub(super) fn wrong(line: u64, reason: &str) -> IdentifyError {
    IdentifyError::Line {
        line,
        column: None,
        reason: reason.to_owned(),
    }
}
