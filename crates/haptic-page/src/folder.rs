//! Folders in that of the runs, outside of which the page writes nothing: of a new run, and those with a name of their own.

use haptic_experiment::Failure;
use haptic_run::{FolderRequest, next_free};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

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

/// A folder of this name in that of the runs, made if it is missing. A link of that name may lead anywhere and is refused.
pub(crate) fn folder_of(runs: &Path, name: &str) -> Result<PathBuf, Failure> {
    let folder = runs.join(name);
    let shown = folder.display();
    fs::create_dir_all(runs)
        .and_then(|()| match folder.symlink_metadata() {
            Ok(_) => Ok(()),
            Err(_) => fs::create_dir(&folder),
        })
        .map_err(|error| {
            Failure::writing(error, format_args!("cannot make the folder `{shown}`"))
        })?;
    let is_own = folder.symlink_metadata().is_ok_and(|about| about.is_dir());
    is_own.then(|| folder.clone()).ok_or_else(|| {
        let why = "is a link or a file: the page writes only into the folder of runs, so put a folder in its place";
        Failure::bad_input(format_args!("`{shown}` {why}"))
    })
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_not_written_through_a_link() {
        let (runs, elsewhere) = (tempfile::tempdir(), tempfile::tempdir());
        let (runs, elsewhere) = (runs.expect("a folder"), elsewhere.expect("a folder"));
        for (name, target) in [("relax-0001", "."), ("relax-0002", "missing")] {
            let target = elsewhere.path().join(target);
            std::os::unix::fs::symlink(target, runs.path().join(name)).expect("linked");
        }
        let (request, name) = next_folder(runs.path(), "relax", &BTreeMap::new()).expect("free");
        assert_eq!(name, "relax-0003/relax");
        request.prepare().expect("made");
        assert_eq!(fs::read_dir(elsewhere.path()).expect("read").count(), 0);
    }
}
