//! Failures of a command from errors of its log and of its files: by whom they are to be mended.

use super::{NewFileError, RecordError};
use haptic_document::{Cause, Failure, is_full, parameters::OVERWRITE};

impl From<RecordError> for Failure {
    fn from(error: RecordError) -> Self {
        use RecordError::{
            Copy, Csv, File, Lost, Message, NoTicks, NotMcap, Read, Span, Time, Write,
        };
        if let File(error) = error {
            return error.into();
        }
        if let Span(error) = error {
            return Self::bad_input(error);
        }
        let kind = match error {
            Write { .. } | Lost { .. } | Copy { .. } | Csv { .. } => Self::DataLost,
            Message(_) | Time { .. } => Self::Run,
            File(_) | Read { .. } | NotMcap { .. } | NoTicks { .. } | _ => Self::Input,
        };
        kind(Cause::File(Box::new(error)))
    }
}

impl From<NewFileError> for Failure {
    fn from(error: NewFileError) -> Self {
        if let NewFileError::Exists(path) = &error {
            let advice = format!("choose another name, move it away, or give {OVERWRITE}");
            return Self::exists(path, advice);
        }
        let full = matches!(&error, NewFileError::Io { source, .. } if is_full(source));
        let kind = if full { Self::DataLost } else { Self::Input };
        kind(Cause::File(Box::new(error)))
    }
}
