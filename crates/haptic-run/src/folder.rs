//! Files of an experiment: one folder, one stem, nothing overwritten unasked.

use haptic_document::{
    Failure, bad_input,
    parameters::{OUT, OVERWRITE},
};
use haptic_log::record::{
    Leftover, NewFile, leftover_at, nth_file, part_of, refuse_taken, remove_earlier,
};
use serde::Serialize;
use std::{
    collections::BTreeMap,
    fs::{self, File},
    io::BufWriter,
    path::{Path, PathBuf},
};

/// The files an experiment makes, by extension, and beside them the log of a fault. A log that was cut off keeps `.mcap.part`.
const EXTENSIONS: [&str; 5] = ["mcap", "csv", "against.csv", "svg", "png"];

/// Folder for results where none is given.
const RESULTS: &str = "results";

/// Request for the folder and the names of an experiment's files. Nothing is made or removed yet.
///
/// ```
/// use haptic_run::FolderRequest;
/// use std::collections::BTreeMap;
///
/// let request = FolderRequest {
///     out: Some(std::env::temp_dir().join(format!("haptic-{}", std::process::id()))),
///     stem: "relax".to_owned(),
///     overwrite: false,
///     roll_bytes: None,
///     provenance: BTreeMap::from([("program".to_owned(), "mine 1.0".to_owned())]),
/// };
/// let folder = request.prepare()?;
/// assert_eq!(folder.file("csv").file_name(), Some("relax.csv".as_ref()));
/// // Nothing was written, so the folder goes too.
/// folder.discard();
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FolderRequest {
    /// The folder, or the next free `results/STEM-0001`.
    pub out: Option<PathBuf>,
    /// The name that all files share.
    pub stem: String,
    /// True if files of an earlier run may be replaced.
    pub overwrite: bool,
    /// Size of a file of the log from which on another one follows, bytes; `None` for one file.
    pub roll_bytes: Option<u64>,
    /// Maker of the log, for its metadata: program, command line.
    pub provenance: BTreeMap<String, String>,
}

/// A folder and the name that all files of an experiment share.
#[derive(Debug)]
pub struct OutputFolder {
    path: PathBuf,
    request: FolderRequest,
    /// Folders that did not exist before, outermost first.
    made: Vec<PathBuf>,
}

/// `STEM-0001` to `STEM-9999` in a folder of results.
fn numbered(results: &Path, stem: &str) -> impl Iterator<Item = PathBuf> {
    (1..=9999).map(move |number| results.join(format!("{stem}-{number:04}")))
}

/// The first `STEM-NNNN` of a folder of results that does not exist, to be passed as
/// [`FolderRequest::out`]; `None` if all 9999 do.
#[must_use]
pub fn next_free(results: &Path, stem: &str) -> Option<PathBuf> {
    // A link that leads nowhere has the name too.
    numbered(results, stem).find(|path| path.symlink_metadata().is_err())
}

impl FolderRequest {
    /// Makes the folder. Old files stay until new ones take their place.
    ///
    /// # Errors
    /// If it cannot be made or written to, or holds files of this name and `overwrite` is not set.
    pub fn prepare(&self) -> Result<OutputFolder, Failure> {
        let mut folder = OutputFolder {
            path: PathBuf::new(),
            request: self.clone(),
            made: Vec::new(),
        };
        let result = match &self.out {
            Some(out) => {
                folder.path.clone_from(out);
                folder.make(out)
            }
            None => folder.make_next_free(),
        };
        let result = result.and_then(|()| folder.check_room());
        match result {
            Ok(()) => Ok(folder),
            Err(error) => {
                folder.discard();
                Err(error)
            }
        }
    }
}

impl OutputFolder {
    /// Makes a folder and all above it that are missing.
    fn make(&mut self, path: &Path) -> Result<(), Failure> {
        let missing = path.ancestors().filter(|path| !path.as_os_str().is_empty());
        let missing: Vec<&Path> = missing.take_while(|path| !path.exists()).collect();
        for path in missing.into_iter().rev() {
            match fs::create_dir(path) {
                Ok(()) => self.made.push(path.to_owned()),
                Err(error) => return Err(cannot_make(path, error)),
            }
        }
        if path.is_dir() {
            Ok(())
        } else {
            Err(cannot_make(path, std::io::ErrorKind::NotADirectory.into()))
        }
    }

    /// Makes the first `results/STEM-NNNN` that does not exist.
    fn make_next_free(&mut self) -> Result<(), Failure> {
        self.make(Path::new(RESULTS))?;
        for path in numbered(Path::new(RESULTS), &self.request.stem) {
            self.path = path;
            match fs::create_dir(&self.path) {
                Ok(()) => {
                    self.made.push(self.path.clone());
                    return Ok(());
                }
                Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(cannot_make(&self.path, error)),
            }
        }
        Err(bad_input!(
            "`{RESULTS}` holds {0}-0001 to {0}-9999: move some away, or give {OUT}",
            self.request.stem
        ))
    }

    /// Refuses files of this name unless they may be replaced, and a log that was cut off always.
    fn check_room(&self) -> Result<(), Failure> {
        // The log of a fault, and the further files of a log in several: each has one before it.
        let log = self.file("mcap");
        let mut others = vec![fault_log_of(&log)];
        let further = (2..).map(|number| nth_file(&log, number));
        others.extend(further.take_while(|file| file.exists() || part_of(file).exists()));
        for file in others.iter().chain([&log]) {
            let cut = part_of(file);
            if cut.exists() {
                return Err(leftover_at(&cut).into());
            }
        }
        let taken = EXTENSIONS.map(|extension| self.file(extension));
        let mut taken = taken.into_iter().chain(others);
        if self.request.overwrite {
            return Ok(taken.try_for_each(|file| refuse_taken(&file, true))?);
        }
        taken.find(|file| file.exists()).map_or(Ok(()), |taken| {
            let advice = format!("choose another folder with {OUT}, or give {OVERWRITE}");
            Err(Failure::exists(&taken, advice))
        })
    }

    /// Takes back what was made, for a run that never began: folders that are still empty.
    pub fn discard(&self) {
        for path in self.made.iter().rev() {
            // Fails on a folder that holds anything, which is what is wanted.
            let _ = fs::remove_dir(path);
        }
    }

    /// Removes CSV and pictures of an earlier run, which would pass for those of a run that made none.
    pub fn remove_stale_results(&self) {
        for extension in &EXTENSIONS[1..] {
            self.remove_stale(extension);
        }
    }

    /// Removes the file with this extension of an earlier run.
    pub fn remove_stale(&self, extension: &str) {
        remove_earlier(&self.file(extension));
    }

    /// Path of the files of a picture, without their extensions.
    #[must_use]
    pub fn stem(&self) -> PathBuf {
        self.path.join(&self.request.stem)
    }

    /// True if files of an earlier run may be replaced.
    #[must_use]
    pub const fn overwrite(&self) -> bool {
        self.request.overwrite
    }

    /// See [`FolderRequest::roll_bytes`].
    #[must_use]
    pub const fn roll_bytes(&self) -> Option<u64> {
        self.request.roll_bytes
    }

    /// The file with this extension.
    #[must_use]
    pub fn file(&self, extension: &str) -> PathBuf {
        self.path.join(format!("{}.{extension}", self.request.stem))
    }

    /// A further file of the experiment: STEM-SUFFIX.EXTENSION.
    #[must_use]
    pub fn further_file(&self, suffix: &str, extension: &str) -> PathBuf {
        self.path
            .join(format!("{}-{suffix}.{extension}", self.request.stem))
    }

    /// Begins a table beside a log: rows, lists or tuples, under these names.
    pub fn named_table_beside_log(&self, extension: &str, names: &[&str]) -> RunTable {
        self.table(extension, names, "the log is whole")
    }

    /// `kept` says what there is if it cannot be written.
    fn table(&self, extension: &str, names: &[&str], kept: &'static str) -> RunTable {
        let made = NewFile::create(
            &self.file(extension),
            Leftover::Discard,
            self.request.overwrite,
        );
        let open = made.map(|(new_file, file)| OpenTable {
            new_file,
            writer: csv::Writer::from_writer(BufWriter::with_capacity(1 << 16, file)),
            kept,
        });
        let mut table = RunTable(open.map_err(Failure::from));
        if !names.is_empty() {
            table.write(|writer| writer.write_record(names));
        }
        table
    }

    /// Writes a whole table, `.csv`, and names it; `names` are column names for rows that carry
    /// none themselves, that is lists or tuples.
    ///
    /// # Errors
    /// If it cannot be written; then no file is left behind.
    pub fn write_table<R: Serialize>(
        &self,
        names: &[&str],
        rows: impl Iterator<Item = R>,
    ) -> Result<String, Failure> {
        let mut table = self.table("csv", names, NOTHING_KEPT);
        rows.for_each(|row| table.row(row));
        table.finish()
    }
}

/// Words for a table that cannot be written, where there is nothing beside it.
const NOTHING_KEPT: &str = "nothing was left behind under that name, make space and try again";

/// A table being written; it appears when complete. Write errors are reported at its end: an experiment continues without the table.
#[derive(Debug)]
pub struct RunTable(Result<OpenTable, Failure>);

#[derive(Debug)]
struct OpenTable {
    new_file: NewFile,
    writer: csv::Writer<BufWriter<File>>,
    kept: &'static str,
}

impl RunTable {
    /// Writes a row, its cells in the order of the columns.
    pub fn row(&mut self, row: impl Serialize) {
        self.write(|writer| writer.serialize(row));
    }

    fn write(
        &mut self,
        add: impl FnOnce(&mut csv::Writer<BufWriter<File>>) -> Result<(), csv::Error>,
    ) {
        if let Ok(open) = &mut self.0
            && let Err(error) = add(&mut open.writer)
        {
            self.0 = Err(open.lost(error));
        }
    }

    /// Gives the table its name, and returns it.
    ///
    /// # Errors
    /// If the disk refused a row or the name: where, and what is lost.
    pub fn finish(self) -> Result<String, Failure> {
        let mut open = self.0?;
        let path = open.new_file.target().to_owned();
        let flushed = open.writer.flush();
        flushed.map_err(|error| open.lost(error.into()))?;
        drop(open.writer);
        open.new_file.publish()?;
        Ok(path.display().to_string())
    }
}

impl OpenTable {
    fn lost(&self, error: csv::Error) -> Failure {
        let path = self.new_file.target().display();
        Failure::data_lost(format_args!(
            "writing `{path}` failed; {}: {error}",
            self.kept
        ))
    }
}

fn cannot_make(path: &Path, error: std::io::Error) -> Failure {
    let what = format!("cannot make the folder `{}`", path.display());
    let advice = format!(": choose a writable place with {OUT}");
    Failure::writing_with_advice(error, what, advice)
}

/// Writes a text file; it appears when it is whole.
///
/// # Errors
/// If it exists and `overwrite` is not set, or the disk does not take it.
pub fn write_text(path: &Path, text: &str, overwrite: bool) -> Result<(), Failure> {
    NewFile::filled(path, text.as_bytes(), overwrite)?.publish()?;
    Ok(())
}

pub(crate) fn fault_log_of(log: &Path) -> PathBuf {
    let stem = log.file_stem().unwrap_or_default().to_string_lossy();
    log.with_file_name(format!("{stem}-fault.mcap"))
}
