//! Printing: results on standard output, everything else on standard error.

use crate::failure::Failure;
use crate::input::without_bulk;
use serde::Serialize;
use std::io::{self, BufWriter, Write};

/// How much to print, and how.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Output {
    /// One JSON object and nothing else on standard output.
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
            Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Err(Failure::BrokenPipe),
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
