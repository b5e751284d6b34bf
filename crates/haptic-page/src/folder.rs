//! The folder of a new run, of an experiment, a question or a recording.

use haptic_experiment::Failure;
use haptic_experiment::run::{FolderRequest, next_free};
use std::collections::BTreeMap;
use std::path::Path;

/// The next free folder of the runs for this kind, and the name of what will be in it, as the list of runs has it.
pub(crate) fn next_folder(
    runs: &Path,
    kind: &str,
    provenance: &BTreeMap<String, String>,
) -> Result<(FolderRequest, String), Failure> {
    let out = next_free(runs, kind).ok_or_else(|| {
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
