//! Printing: results on standard output, everything else on standard error.

use crate::names::Names;
use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use haptic_document::rows;
use haptic_experiment::{Cause, Failure, ReportLine, ReportTable, Row, lines};
use haptic_quantity::renamed;
use serde::Serialize;
use serde_json::Value;
use std::borrow::Cow;
use std::io::{self, BufWriter, Write};

/// The amount and form of what is printed.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Output {
    /// The report as one JSON object on standard output, and nothing else there.
    pub(crate) json: bool,
    /// Neither progress nor summary is printed; warnings and errors are.
    pub(crate) quiet: bool,
    /// The names of keys in sentences of the libraries.
    pub(crate) names: &'static Names,
}

impl Output {
    /// Prints a report: as JSON, or its lines; without JSON nothing for a quiet person.
    pub(crate) fn report<T: Serialize>(self, report: &T) -> Result<(), Failure> {
        self.report_as(report, report)
    }

    /// Prints JSON of a report, or the lines of `shown`, which has less.
    pub(crate) fn report_as<T: Serialize, S: Serialize>(
        self,
        report: &T,
        shown: &S,
    ) -> Result<(), Failure> {
        if self.quiet && !self.json {
            return Ok(());
        }
        let mut lines = lines(shown);
        lines.iter_mut().for_each(|line| self.rename(line));
        self.text(report, |out| print_lines(out, &lines))
    }

    /// A sentence of a library, with its keys named by the options of the command.
    fn renamed(self, sentence: &str) -> String {
        renamed(sentence, |key| self.names.of_key(key))
    }

    fn rename(self, line: &mut ReportLine) {
        let rename = |text: &mut String| *text = self.renamed(text);
        match line {
            ReportLine::Row(row) => {
                rename(&mut row.value);
                rename(&mut row.reason);
            }
            ReportLine::Table(table) => table.rows.iter_mut().flatten().for_each(rename),
        }
    }

    /// Says a sentence of a library on standard error.
    pub(crate) fn warn(self, sentence: &str) {
        warn(&self.renamed(sentence));
    }

    /// Prints JSON, or the text that `text` writes.
    pub(crate) fn text<T: Serialize>(
        self,
        value: &T,
        text: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        let mut out = Visible(BufWriter::new(io::stdout().lock()));
        let printed = if self.json {
            // JSON escapes them itself, but for those behind the ASCII ones, which stand in strings alone.
            serde_json::to_string(value)
                .map_err(io::Error::from)
                .and_then(|json| writeln!(out, "{json}"))
        } else {
            text(&mut out)
        };
        match printed.and_then(|()| out.flush()) {
            Ok(()) => Ok(()),
            // Whatever the command has still to say, its exit code above all, it says.
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
            Err(error) => Err(Failure::writing(error, "cannot write standard output")),
        }
    }
}

/// A report of these objects, one behind the other.
pub(crate) fn joined(parts: impl IntoIterator<Item = Value>) -> Value {
    Value::Object(rows(parts))
}

/// Widest table that is one.
const WIDEST: usize = 140;

/// Prints lines of a report: labels in a column, tables under theirs.
fn print_lines(out: &mut dyn Write, lines: &[ReportLine]) -> io::Result<()> {
    let indented = |row: &Row| 2 * row.level + row.label.chars().count();
    let long = |line: &ReportLine| match line {
        ReportLine::Row(row) if !row.value.is_empty() => indented(row),
        ReportLine::Row(_) | ReportLine::Table(_) => 0,
    };
    let width = lines.iter().map(long).max().unwrap_or(0);
    for line in lines {
        match line {
            // Warnings were said on standard error.
            ReportLine::Row(row) if row.key == "warnings" => (),
            ReportLine::Row(row) => {
                let indent = "  ".repeat(row.level);
                let space = " ".repeat(width.saturating_sub(indented(row)));
                let reason = match row.reason.as_str() {
                    "" => String::new(),
                    reason => format!("  ({})", in_line(reason)),
                };
                let mut lines = row.value.lines();
                let first = lines.next().unwrap_or_default();
                let label = in_line(&row.label);
                let text = format!("{indent}{label}{space}  {first}{reason}");
                writeln!(out, "{}", text.trim_end())?;
                for line in lines {
                    writeln!(out, "{}  {line}", " ".repeat(width))?;
                }
            }
            ReportLine::Table(table) => print_table(out, table)?,
        }
    }
    Ok(())
}

fn print_table(out: &mut dyn Write, table: &ReportTable) -> io::Result<()> {
    let indent = "  ".repeat(table.level);
    let shown = match table.rows.len() {
        rows if rows < table.length => format!(" ({rows} of {})", table.length),
        _ => String::new(),
    };
    writeln!(out, "{indent}{}{shown}", table.label)?;
    let rows = || std::iter::once(&table.columns).chain(&table.rows);
    let width = |column: usize| {
        let cells = rows().filter_map(|row| row.get(column));
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let is_number = |cell: &str| cell.starts_with(|c: char| c.is_ascii_digit() || "-–".contains(c));
    let of_numbers = |column: usize| table.rows.iter().all(|row| is_number(&row[column]));
    let columns: Vec<(usize, bool)> = (0..table.columns.len())
        .map(|column| (width(column), of_numbers(column)))
        .collect();
    // Wider than any terminal: a row after another.
    if columns.iter().map(|(width, _)| width + 2).sum::<usize>() > WIDEST {
        for row in &table.rows {
            print_block(out, &indent, &table.columns, row)?;
        }
        return Ok(());
    }
    for row in rows() {
        let mut text = indent.clone();
        for (cell, (width, is_number)) in row.iter().zip(&columns) {
            let space = " ".repeat(width - cell.chars().count());
            text += &if *is_number {
                format!("  {space}{}", in_line(cell))
            } else {
                format!("  {}{space}", in_line(cell))
            };
        }
        writeln!(out, "{}", text.trim_end())?;
    }
    Ok(())
}

/// A row of a wide table: what it is of, and below it the rest.
fn print_block(
    out: &mut dyn Write,
    indent: &str,
    columns: &[String],
    row: &[String],
) -> io::Result<()> {
    let mut cells = columns.iter().zip(row);
    if let Some((heading, first)) = cells.next() {
        writeln!(out, "{indent}  {heading} {}", in_line(first))?;
    }
    let width = columns.iter().map(|column| column.chars().count()).max();
    let width = width.unwrap_or(0);
    for (column, cell) in cells {
        let space = " ".repeat(width - column.chars().count());
        writeln!(out, "{indent}    {column}{space}  {}", in_line(cell))?;
    }
    Ok(())
}

/// Text from a log, a device or a file may contain control characters, which a terminal obeys. They leave this program as JSON writes
/// them, `\u001b`; lines and columns stay.
struct Visible<W>(W);

impl<W: Write> Write for Visible<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        // The formatter and JSON hand over whole characters.
        match std::str::from_utf8(bytes) {
            Ok(text) => self.0.write_all(visible(text).as_bytes())?,
            Err(_) => self.0.write_all(bytes)?,
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

/// A text without control characters but for the end of a line and a tabulator.
fn visible(text: &str) -> Cow<'_, str> {
    let is_hidden = |c: char| c.is_control() && !matches!(c, '\n' | '\t');
    if !text.contains(is_hidden) {
        return text.into();
    }
    let mut shown = String::with_capacity(text.len() + 8);
    for c in text.chars() {
        if is_hidden(c) {
            shown += &format!("\\u{:04x}", u32::from(c));
        } else {
            shown.push(c);
        }
    }
    shown.into()
}

/// Text of a log or a device that stands in a line: it ends none.
pub(crate) fn in_line(text: &str) -> String {
    visible(text).replace('\n', "\\n")
}

/// Says something on standard error; a closed standard error is nobody's loss.
pub(crate) fn note(kind: &str, text: impl std::fmt::Display) {
    let text = bounded(text.to_string());
    let _ = writeln!(io::stderr().lock(), "{kind}: {}", visible(&text));
}

/// A message of no more than 2000 characters, whatever it echoes: its beginning, and its end with the remedy.
fn bounded(message: String) -> String {
    let (begin, end) = (1600, 300);
    let length = message.chars().count();
    if length <= 2000 {
        return message;
    }
    let begin = message.chars().take(begin).chain(" … ".chars());
    let kept: String = begin.chain(message.chars().skip(length - end)).collect();
    format!("{kept} ({length} characters)")
}

/// Says why a command did not succeed, and shows the line of a file that is the reason.
pub(crate) fn refused(failure: &Failure, names: &Names) {
    note("error", failure.cause().named(|key| names.of_key(key)));
    if let Cause::Document(error) = failure.cause()
        && let Some(excerpt) = error.excerpt()
        && is_readable(&excerpt.text)
    {
        let line = Snippet::source(&excerpt.text)
            .line_start(excerpt.line)
            .annotation(AnnotationKind::Primary.span(excerpt.at.clone()));
        let shown = Renderer::plain().render(&[Group::with_level(Level::ERROR).element(line)]);
        let _ = writeln!(io::stderr().lock(), "{shown}");
    }
}

/// True of a line that a terminal shows in one.
fn is_readable(line: &str) -> bool {
    /// A long one is cut where it is shown.
    const MOST: usize = 10_000;
    let hidden = |c: char| c.is_control() && c != '\t';
    !line.trim().is_empty() && line.len() <= MOST && !line.contains(hidden)
}

pub(crate) fn warn(text: &str) {
    note("warning", text);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_is_bounded_and_keeps_its_remedy() {
        assert_eq!(bounded("short".to_owned()), "short");
        let long = bounded(format!("{}: change it", "x".repeat(100_000)));
        assert!(long.ends_with(": change it (100011 characters)"), "{long}");
        assert!(long.chars().count() <= 2000, "{long}");
    }

    #[test]
    fn control_characters_are_shown_and_not_obeyed() {
        let text = "a\u{1b}[31mb\u{7}\u{7f}\u{9b}\rc\td\né µ";
        let want = "a\\u001b[31mb\\u0007\\u007f\\u009b\\u000dc\td\né µ";
        let mut out = Visible(Vec::new());
        write!(out, "{text}").expect("written");
        assert_eq!(out.0, want.as_bytes());
        assert_eq!(in_line(text), want.replace('\n', "\\n"));
        // JSON that is read again is the same text.
        let mut out = Visible(Vec::new());
        serde_json::to_writer(&mut out, text).expect("written");
        assert_eq!(
            visible(std::str::from_utf8(&out.0).expect("text")).as_bytes(),
            out.0
        );
        assert_eq!(
            serde_json::from_slice::<String>(&out.0).expect("JSON"),
            text
        );
    }

    #[test]
    fn a_table_wider_than_a_terminal_is_a_row_after_another() {
        let table = |seen: &str| ReportTable {
            level: 0,
            key: "checks".to_owned(),
            label: "checks".to_owned(),
            columns: ["check", "seen"].map(str::to_owned).to_vec(),
            rows: vec![vec!["stop".to_owned(), seen.to_owned()]],
            length: 1,
        };
        let long = "x".repeat(WIDEST);
        for (seen, want) in [
            ("yes", "checks\n  check  seen\n  stop   yes\n".to_owned()),
            (&long, format!("checks\n  check stop\n    seen   {long}\n")),
        ] {
            let mut out = Vec::new();
            print_table(&mut out, &table(seen)).expect("written");
            assert_eq!(String::from_utf8(out).expect("text"), want);
        }
    }
}
