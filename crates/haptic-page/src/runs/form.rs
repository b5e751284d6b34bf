//! A form as the document that it stands for, and the place of what comes of it.

use super::forms;
use haptic_experiment::Failure;
use haptic_experiment::document::Document;
use haptic_experiment::parameters::FILES;
use haptic_experiment::run::RemoteDevice;
use haptic_experiment::run::{FolderRequest, next_free};
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The document that a form stands for.
///
/// # Errors
/// A kind that there is not; a value that is no number, text or list.
pub(super) fn document(kind: &str, parameters: &Map<String, Value>) -> Result<Document, Failure> {
    if !forms::kinds().any(|known| known == kind) {
        let kinds: Vec<&str> = forms::kinds().collect();
        return Err(Failure::bad_input(format_args!(
            "experiment {kind:?} is none of {}",
            kinds.join(", ")
        )));
    }
    let mut document = Document::new(kind);
    // Null and an empty field of a form are the default.
    let given = parameters
        .iter()
        .filter(|(_, value)| !value.is_null() && **value != "");
    for (key, value) in given {
        if let (true, Some(path)) = (FILES.contains(&key.as_str()), value.as_str()) {
            check_regular(key, Path::new(path))?;
        }
        let value = toml::Value::try_from(value).map_err(|_| {
            Failure::bad_input(format_args!(
                "`{key}` is not a number, a text, a list of numbers, or true or false"
            ))
        })?;
        // The field is in the message.
        document.set(kind, key, value, "").map_err(Failure::input)?;
    }
    Ok(document)
}

/// The one place that looks at a file before what a form names is opened: a pipe would be waited for without an end. What is not there
/// its reader says, or it is the name of a tissue.
///
/// # Errors
/// What is neither a file nor a folder of files.
fn check_regular(key: &str, path: &Path) -> Result<(), Failure> {
    let Ok(about) = fs::metadata(path) else {
        return Ok(());
    };
    let inside = about.is_dir().then(|| fs::read_dir(path));
    let inside = inside.and_then(Result::ok).into_iter().flatten();
    let other = inside
        .filter_map(|entry| Some(entry.ok()?.path()))
        .find(|inside| {
            fs::metadata(inside).is_ok_and(|about| !(about.is_file() || about.is_dir()))
        });
    let itself = (!(about.is_file() || about.is_dir())).then(|| path.to_owned());
    itself.or(other).map_or(Ok(()), |path| {
        Err(Failure::bad_input(format_args!(
            "`{key}`: {} is no regular file: only those are opened for a page",
            path.display()
        )))
    })
}

/// # Errors
/// A device at a port.
pub(super) fn simulated(remote: Option<&RemoteDevice>) -> Result<(), Failure> {
    match remote {
        None => Ok(()),
        Some(_) => Err(Failure::bad_input(
            "the page runs experiments on the simulated device: for a serial one use the command line, as in \
             `run FILE.toml`; its log is shown here",
        )),
    }
}

/// The next free folder of the runs for this kind, and the name of what will be in it.
///
/// # Errors
/// No free folder.
pub(super) fn place(
    runs: &Path,
    kind: &str,
    provenance: &BTreeMap<String, String>,
) -> Result<(FolderRequest, String), Failure> {
    let out: PathBuf = next_free(runs, kind).ok_or_else(|| {
        Failure::bad_input(format_args!(
            "`{}` holds {kind}-0001 to {kind}-9999: move some away",
            runs.display()
        ))
    })?;
    let folder = out.file_name().unwrap_or_default().to_string_lossy();
    let name = format!("{folder}/{kind}");
    let request = FolderRequest {
        out: Some(out),
        stem: kind.to_owned(),
        overwrite: false,
        roll_bytes: None,
        provenance: provenance.clone(),
    };
    Ok((request, name))
}
