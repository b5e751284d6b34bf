//! The text of a table: delimiter, header, rows, and what is passed over.

use super::super::error::IdentifyError;
use super::super::record::SAMPLES_MOST;
use csv::StringRecord;

/// No table is longer, bytes.
pub const TABLE_MOST: u64 = 1 << 28;

/// Rows that were passed over: why, how many, and the first few lines.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Passed {
    pub(super) lines: Vec<u64>,
}

impl Passed {
    pub(super) fn note(&self, why: &str) -> Option<String> {
        const NAMED: usize = 5;
        let count = self.lines.len();
        let named: Vec<String> = self
            .lines
            .iter()
            .take(NAMED)
            .map(ToString::to_string)
            .collect();
        let more = if count > NAMED { ", …" } else { "" };
        let (rows, lines) = if count == 1 {
            ("row", "line")
        } else {
            ("rows", "lines")
        };
        (count > 0).then(|| {
            format!(
                "{count} {rows} left out, {why}: {lines} {}{more}",
                named.join(", ")
            )
        })
    }
}

/// A table as text.
#[derive(Clone, Debug, PartialEq)]
pub struct TextTable {
    /// Its cells' separator.
    pub(super) delimiter: u8,
    pub(super) header_line: u64,
    pub(super) header: Vec<String>,
    /// Line and cells.
    pub(super) rows: Vec<(u64, StringRecord)>,
}

/// Reads CSV or TSV: cells apart by tabs, semicolons or commas, as the header has them. Lines that begin with `#` and empty lines are
/// passed over.
///
/// # Errors
/// Text that is not UTF-8, empty or too long; a header with one column.
pub fn read_table(bytes: &[u8]) -> Result<TextTable, IdentifyError> {
    if bytes.len() as u64 > TABLE_MOST {
        return Err(IdentifyError::Record(format!(
            "the table is longer than {TABLE_MOST} bytes: omit unneeded columns, or every second row"
        )));
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let delimiter = delimiter(utf8(bytes)?)?;
    let mut rows = Vec::new();
    each_row(bytes, delimiter, |line, row| {
        if rows.len() > SAMPLES_MOST + 1 {
            let reason =
                format!("more than {SAMPLES_MOST} rows: omit every second one, or cut the record");
            return Err(wrong(line, &reason));
        }
        rows.push((line, row.clone()));
        Ok(())
    })?;
    let mut rows = rows.into_iter();
    let (header_line, header) = rows.next().unwrap_or_default();
    // Messages show names in one line.
    let header: Vec<String> = (header.iter())
        .map(|name| name.replace(char::is_control, " "))
        .collect();
    if header.len() < 2 {
        return Err(wrong(
            header_line,
            "there is only one column: give at least two, separated by tabs, commas or semicolons",
        ));
    }
    Ok(TextTable {
        delimiter,
        header_line,
        header,
        rows: rows.collect(),
    })
}

fn utf8(bytes: &[u8]) -> Result<&str, IdentifyError> {
    std::str::from_utf8(bytes).map_err(|error| {
        let line = 1 + bytes[..error.valid_up_to()]
            .iter()
            .filter(|&&b| b == b'\n')
            .count();
        wrong(
            line as u64,
            "the text is not UTF-8: save the table as UTF-8",
        )
    })
}

/// The separator of the first line with cells, the header.
fn delimiter(text: &str) -> Result<u8, IdentifyError> {
    let is_data = |line: &&str| !line.trim().is_empty() && !line.trim_start().starts_with('#');
    let first = text.lines().find(is_data).ok_or_else(|| {
        IdentifyError::Record(
            "the table is empty: give a header and rows of numbers below it".to_owned(),
        )
    })?;
    let mut marks = [b'\t', b';', b','].into_iter();
    let found = marks.find(|&mark| first.as_bytes().contains(&mark));
    Ok(found.unwrap_or(b','))
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
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(bytes);
    let (mut lines, mut row) = (Lines::new(bytes), StringRecord::new());
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

/// Columns of numbers by the names that stand above them, and the line of each row; cells apart and passed over as by [`read_table`].
///
/// # Errors
/// As [`read_table`], but one column is enough; no or two columns of a name; no row; a cell that is not a finite number, with its line.
pub fn read_columns<const N: usize>(
    bytes: &[u8],
    names: [&str; N],
) -> Result<(Vec<u64>, [Vec<f64>; N]), IdentifyError> {
    read_chosen(bytes, |header| {
        let mut places = [0; N];
        for (place, name) in places.iter_mut().zip(names) {
            *place = place_of(name, header)?;
        }
        Ok(places)
    })
}

/// The same of columns that are chosen by the header: their places in it.
///
/// # Errors
/// As [`read_columns`]; what the choice refuses, with the line of the header.
pub fn read_chosen<const N: usize>(
    bytes: &[u8],
    mut choose: impl FnMut(&[&str]) -> Result<[usize; N], String>,
) -> Result<(Vec<u64>, [Vec<f64>; N]), IdentifyError> {
    if bytes.len() as u64 > TABLE_MOST {
        return Err(IdentifyError::Record(format!(
            "the table is longer than {TABLE_MOST} bytes: cut it into pieces"
        )));
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let text = utf8(bytes)?;
    let delimiter = delimiter(text)?;
    if let Some(line) = missing_row(text, delimiter) {
        return Err(wrong(line, NO_VALUE));
    }
    let (mut lines, mut columns) = (Vec::new(), [const { Vec::new() }; N]);
    let mut chosen = None;
    each_row(bytes, delimiter, |line, row| {
        let Some((header, places)) = &chosen else {
            let names: Vec<&str> = row.iter().collect();
            let places = choose(&names).map_err(|reason| wrong(line, &reason))?;
            chosen = Some((row.clone(), places));
            return Ok(());
        };
        if row.len() > header.len() {
            return Err(wrong(line, &too_many(row, header.len())));
        }
        lines.push(line);
        for (column, &place) in columns.iter_mut().zip(places) {
            let cell = row.get(place).unwrap_or("");
            column.push(number(cell, delimiter).ok_or_else(|| IdentifyError::Line {
                line,
                column: header.get(place).map(str::to_owned),
                reason: match cell {
                    "" => NO_VALUE.to_owned(),
                    cell => format!("{cell:?} is not a finite number"),
                },
            })?);
        }
        Ok(())
    })?;
    match lines.is_empty() {
        true => Err(IdentifyError::Record(
            "no rows below the header: give numbers".to_owned(),
        )),
        false => Ok((lines, columns)),
    }
}

const NO_VALUE: &str = "no value: give a number in every row";

/// The first line without cells between others below the header: a sample that is missing, which the next must not replace.
fn missing_row(text: &str, delimiter: u8) -> Option<u64> {
    let is_blank = |c: char| c.is_whitespace() || c == char::from(delimiter);
    let is_empty = |line: &str| line.trim_matches(is_blank).is_empty();
    let comment = |line: &str| line.trim_start().starts_with('#');
    let mut lines = (1..).zip(text.lines()).filter(|(_, line)| !comment(line));
    lines.find(|(_, line)| !is_empty(line))?;
    let (missing, _) = lines.find(|(_, line)| is_empty(line))?;
    lines.any(|(_, line)| !is_empty(line)).then_some(missing)
}

/// The one column of this name.
fn place_of(name: &str, header: &[&str]) -> Result<usize, String> {
    let mut places = (0..header.len()).filter(|&place| header[place] == name);
    match (places.next(), places.next()) {
        (Some(place), None) => Ok(place),
        (None, _) => Err(format!(
            "no column {name} in the header {:?}",
            header.join(",")
        )),
        (Some(_), Some(_)) => Err(format!(
            "more than one column is named {name}: rename all but one"
        )),
    }
}

/// Why a row is wider than its header.
pub(super) fn too_many(row: &StringRecord, width: usize) -> String {
    format!(
        "{} cells under a header of {width}: separate cells by semicolons beside decimal commas",
        row.len()
    )
}

/// A finite number; decimal commas where commas do not separate cells.
pub(super) fn number(cell: &str, delimiter: u8) -> Option<f64> {
    let value = match cell.parse::<f64>() {
        Ok(value) => Some(value),
        Err(_) if delimiter != b',' && cell.matches(',').count() == 1 => {
            cell.replace(',', ".").parse().ok()
        }
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
    const fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            seen: 0,
            breaks: 0,
        }
    }

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
