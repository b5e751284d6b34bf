//! Printing: results on standard output, everything else on standard error.

use crate::parameter::with_options;
use haptic_experiment::failure::Failure;
use haptic_experiment::input::without_bulk;
use serde::Serialize;
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
        let mut out = BufWriter::new(io::stdout().lock());
        let printed = if self.json {
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

/// Says something on standard error, long echoes of the arguments cut short; a closed standard error is nobody's loss.
pub fn note(kind: &str, text: impl std::fmt::Display) {
    let arguments = std::env::args_os().skip(1);
    let arguments = arguments.map(|argument| argument.to_string_lossy().into_owned());
    let text = without_bulk(&text.to_string(), arguments);
    let _ = writeln!(io::stderr().lock(), "{kind}: {text}");
}

/// Says a warning of a library, its parameters as options.
pub fn warn(text: &str) {
    note("warning", with_options(text));
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
