//! Where an experiment puts its files: one folder, one stem, nothing overwritten unasked.

use crate::failure::Failure;
use crate::figure::Picture;
use crate::record::{Leftover, NewFile};
use anyhow::Context as _;
use serde::Serialize;
use std::fs;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

/// The files an experiment makes, by extension. A log that was cut off keeps `.mcap.part`.
const EXTENSIONS: [&str; 4] = ["mcap", "csv", "svg", "png"];

/// Folder for results where none is given.
const RESULTS: &str = "results";

/// A folder and the name that all files of an experiment share.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutputFolder {
    path: PathBuf,
    stem: &'static str,
    overwrite: bool,
}

impl OutputFolder {
    /// Makes the folder: the given one, or the next free `results/STEM-0001`.
    ///
    /// # Errors
    /// If it cannot be made or written to, or holds files of this name and `overwrite` is not set.
    pub fn prepare(
        given: Option<&Path>,
        stem: &'static str,
        overwrite: bool,
    ) -> Result<Self, Failure> {
        let path = match given {
            Some(path) => {
                fs::create_dir_all(path)
                    .with_context(|| {
                        format!(
                            "cannot make the folder `{}`: choose a writable place with --out",
                            path.display()
                        )
                    })
                    .map_err(Failure::Input)?;
                path.to_owned()
            }
            None => next_free(stem)?,
        };
        let folder = Self {
            path,
            stem,
            overwrite,
        };
        folder.make_room()?;
        Ok(folder)
    }

    /// Refuses files of this name, or removes an old log.
    fn make_room(&self) -> Result<(), Failure> {
        let taken = EXTENSIONS
            .map(|e| self.file(e))
            .into_iter()
            .find(|f| f.exists());
        if let (Some(taken), false) = (taken, self.overwrite) {
            return Err(Failure::bad_input(format_args!(
                "`{}` already exists: choose another folder with --out, or give --overwrite",
                taken.display()
            )));
        }
        // A log is written under its own name from the start; the others replace the old at the end.
        let log = self.file("mcap");
        if log.exists() {
            fs::remove_file(&log)
                .with_context(|| format!("cannot replace `{}`", log.display()))
                .map_err(Failure::Input)?;
        }
        Ok(())
    }

    /// Removes the folder again if nothing was put into it.
    pub fn discard_if_empty(&self) {
        // Fails on a folder that holds anything, which is what is wanted.
        let _ = fs::remove_dir(&self.path);
    }

    /// The file with this extension.
    #[must_use]
    pub fn file(&self, extension: &str) -> PathBuf {
        self.path.join(format!("{}.{extension}", self.stem))
    }

    /// Writes rows under a header made of their fields' names; the file appears when it is whole.
    ///
    /// # Errors
    /// If the disk does not take it; nothing is left behind then.
    pub fn write_table<R: Serialize>(
        &self,
        extension: &str,
        rows: impl Iterator<Item = R>,
    ) -> Result<String, Failure> {
        let path = self.file(extension);
        let lost = |error: csv::Error| {
            let message = format!("writing `{}` failed; the log is whole", path.display());
            Failure::DataLost(anyhow::Error::new(error).context(message))
        };
        let (new_file, file) = NewFile::create(&path, Leftover::Discard, self.overwrite)?;
        let mut table = csv::Writer::from_writer(BufWriter::with_capacity(1 << 16, file));
        for row in rows {
            table.serialize(row).map_err(lost)?;
        }
        table.flush().map_err(|error| lost(error.into()))?;
        drop(table);
        new_file.publish()?;
        Ok(path.display().to_string())
    }

    /// Saves a picture as SVG and PNG, and names the PNG.
    ///
    /// # Errors
    /// If it cannot be rendered or the disk does not take it.
    pub fn save_picture(&self, picture: &Picture) -> Result<String, Failure> {
        let saved = picture.save(&self.path.join(self.stem), self.overwrite)?;
        Ok(saved.png.display().to_string())
    }
}

/// Makes the first `results/STEM-NNNN` that does not exist.
fn next_free(stem: &str) -> Result<PathBuf, Failure> {
    let fail = |error: std::io::Error, path: &Path| {
        Failure::Input(anyhow::Error::new(error).context(format!(
            "cannot make the folder `{}`: run where you may write, or give --out",
            path.display()
        )))
    };
    let results = Path::new(RESULTS);
    fs::create_dir_all(results).map_err(|error| fail(error, results))?;
    for number in 1..=9999 {
        let path = results.join(format!("{stem}-{number:04}"));
        match fs::create_dir(&path) {
            Ok(()) => return Ok(path),
            Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {}
            Err(error) => return Err(fail(error, &path)),
        }
    }
    Err(Failure::bad_input(format_args!(
        "`{RESULTS}` holds {stem}-0001 to {stem}-9999: move some away, or give --out"
    )))
}
