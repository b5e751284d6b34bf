//! Lines of a table, for messages.

use super::error::TableError;
use csv::StringRecord;

/// Says which rows were passed over, and why; `None` without any.
#[must_use]
pub fn passed(lines: &[u64], why: &str) -> Option<String> {
    rows_named(lines).map(|rows| format!("{rows} left out, {why}"))
}

/// True of so few bad rows among all that they may be left out: a tenth.
#[must_use]
pub const fn are_few(bad: usize, rows: usize) -> bool {
    bad <= rows.div_ceil(10)
}

/// Number of rows, and the lines of the first few; `None` without any.
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

/// Lines of rows: the reader's own count omits empty lines before a row.
pub(super) struct Lines<'a> {
    bytes: &'a [u8],
    seen: usize,
    breaks: usize,
}

impl<'a> Lines<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        Self {
            bytes,
            seen: 0,
            breaks: 0,
        }
    }

    /// The line, from 1, of the row that ends before this byte.
    pub(super) fn of_row_before(&mut self, end: u64, row: &StringRecord) -> u64 {
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

/// Error at a line of the table.
pub(super) fn wrong(line: u64, reason: &str) -> TableError {
    TableError::Line {
        line,
        column: None,
        reason: reason.to_owned(),
    }
}

/// A cell or a name as a message shows it: whole, unless it is too long to read.
pub(super) fn brief(text: &str) -> String {
    const LETTERS: usize = 60;
    let mut letters = text.chars();
    let mut brief: String = letters.by_ref().take(LETTERS).collect();
    if letters.next().is_some() {
        brief.push('…');
    }
    brief.replace(char::is_control, " ")
}
