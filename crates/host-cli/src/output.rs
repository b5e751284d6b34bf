//! Printing: results on standard output, everything else on standard error.

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use haptic_experiment::Failure;
use haptic_experiment::document::FileError;
use haptic_experiment::document::without_bulk;
use serde::Serialize;
use std::borrow::Cow;
use std::io::{self, BufWriter, Write};

/// The amount and form of what is printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Output {
    /// The report as one JSON object on standard output, and nothing else there.
    pub json: bool,
    /// Neither progress nor summary.
    pub quiet: bool,
}

impl Output {
    /// Prints a result: as JSON, or as the text that `text` writes.
    ///
    /// # Errors
    /// If standard output cannot be written; a reader that went away counts as success.
    pub fn print<T: Serialize>(
        self,
        value: &T,
        text: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        let mut out = Visible(BufWriter::new(io::stdout().lock()));
        let printed = if self.json {
            // JSON escapes them itself, but for those behind the ASCII ones, which stand in strings alone.
            serde_json::to_writer(&mut out, value)
                .map_err(io::Error::from)
                .and_then(|()| writeln!(out))
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

    /// Prints a summary for a person, or the same as JSON; nothing for a quiet person.
    ///
    /// # Errors
    /// As [`print`](Self::print).
    pub fn summary<T: Serialize>(
        self,
        value: &T,
        text: impl FnOnce(&mut dyn Write) -> io::Result<()>,
    ) -> Result<(), Failure> {
        self.print(value, |out| if self.quiet { Ok(()) } else { text(out) })
    }
}

/// What comes from a log, a device or a file may hold control characters, which a terminal obeys. They leave this program as JSON writes
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
        match is_hidden(c) {
            true => shown.push_str(&format!("\\u{:04x}", u32::from(c))),
            false => shown.push(c),
        }
    }
    shown.into()
}

/// Text of a log or a device that stands in a line: it ends none.
#[must_use]
pub fn in_line(text: &str) -> String {
    visible(text).replace('\n', "\\n")
}

/// Says something on standard error, long echoes of the arguments cut short; a closed standard error is nobody's loss.
pub fn note(kind: &str, text: impl std::fmt::Display) {
    let arguments = std::env::args_os().skip(1);
    let arguments = arguments.map(|argument| argument.to_string_lossy().into_owned());
    let text = without_bulk(&text.to_string(), arguments);
    let _ = writeln!(io::stderr().lock(), "{kind}: {}", visible(&text));
}

/// Says why a command did not succeed, and shows the line of a file that is the reason.
pub fn refused(failure: &Failure) {
    note("error", failure);
    let Failure::Input(error) = failure else {
        return;
    };
    let excerpt = error.downcast_ref().and_then(FileError::excerpt);
    if let Some(excerpt) = excerpt.filter(|excerpt| is_readable(&excerpt.text)) {
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

/// Says a warning.
pub fn warn(text: &str) {
    note("warning", text);
}

/// A number in as few digits as it takes; with an exponent where it would have many.
#[must_use]
pub fn short(value: f64) -> String {
    if value == 0.0 || (1e-6..1e15).contains(&value.abs()) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

/// A number with so many decimals; with an exponent where it would have many digits before the point.
#[must_use]
pub fn fixed(value: f64, decimals: usize) -> String {
    if value.abs() < 1e15 {
        format!("{value:.decimals$}")
    } else {
        format!("{value:.decimals$e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn a_number_with_many_digits_has_an_exponent() {
        for (value, few, six) in [
            (0.0, "0", "0.000000"),
            (0.25, "0.25", "0.250000"),
            (-1e300, "-1e300", "-1.000000e300"),
            (3.5e-300, "3.5e-300", "0.000000"),
            (f64::INFINITY, "inf", "inf"),
        ] {
            assert_eq!(
                (short(value).as_str(), fixed(value, 6).as_str()),
                (few, six)
            );
        }
    }
}
