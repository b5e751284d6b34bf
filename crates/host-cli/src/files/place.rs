//! Places that are looked at before the work and written after it: no hour of work ends at a name that is taken. What cannot
//! be written all the same is told behind the result, as data that was lost.

use super::{folder, overwrite_acts, save_picture};
use crate::picture_file::{self, PictureFileError};
use haptic_experiment::Failure;
use haptic_experiment::run::{FolderRequest, OutputFolder, write_text};
use haptic_figure::{FigureError, Picture};
use haptic_log::record::{Leftover, NewFile, NewFileError};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// What was not written.
#[derive(Debug, Default)]
struct Unwritten(Option<Failure>);

impl Unwritten {
    /// What was written; the first failure is remembered.
    fn take<T>(&mut self, written: Result<T, Failure>) -> Option<T> {
        match written {
            Ok(written) => Some(written),
            Err(failure) => {
                self.0.get_or_insert(match failure {
                    // The place was good before the work: nobody's input is at fault.
                    Failure::Input(error) => Failure::DataLost(error),
                    failure => failure,
                });
                None
            }
        }
    }

    fn behind(self, ended: Result<(), Failure>) -> Result<(), Failure> {
        match (ended, self.0) {
            (ended, None) => ended,
            (Ok(()), Some(unwritten)) => Err(unwritten),
            (Err(failure), Some(unwritten)) => Err(failure.and(&unwritten.to_string())),
        }
    }
}

/// Looks whether a file of this name can be made; another program that writes the same name is not disturbed.
fn look(target: &Path) -> Result<(), NewFileError> {
    let mut name = target.as_os_str().to_owned();
    name.push(format!("-{}", std::process::id()));
    let (trial, _) = NewFile::create(Path::new(&name), Leftover::Discard, false)?;
    trial.discard();
    Ok(())
}

/// The folder of a command that takes its time, or none.
#[derive(Debug)]
pub struct Place {
    request: Option<FolderRequest>,
    folder: Option<OutputFolder>,
    unwritten: Unwritten,
}

impl Place {
    /// Looks at the folder for files of this stem. Nothing is made yet.
    ///
    /// # Errors
    /// A folder that cannot be made or written to, files of this name that may not be replaced, `beside` those of an experiment
    /// the ones with these extensions.
    pub fn look(
        out: Option<&Path>,
        stem: &str,
        overwrite: bool,
        beside: &[&str],
    ) -> Result<Self, Failure> {
        overwrite_acts(out, overwrite)?;
        let request = out.map(|out| folder(Some(out.to_owned()), stem, overwrite));
        if let Some(request) = &request {
            let folder = request.prepare()?;
            let names = beside.iter().map(|extension| folder.file(extension));
            let taken = names
                .into_iter()
                .find(|name| name.symlink_metadata().is_ok());
            let looked = match taken {
                Some(taken) if !overwrite => Err(NewFileError::Exists(taken)),
                _ => look(&folder.stem()),
            };
            folder.discard();
            looked?;
        }
        Ok(Self {
            request,
            folder: None,
            unwritten: Unwritten::default(),
        })
    }

    /// Writes into the folder, if there is one; what was written.
    pub fn write<T>(
        &mut self,
        file: impl FnOnce(&OutputFolder) -> Result<T, Failure>,
    ) -> Option<T> {
        if let (None, Some(request)) = (&self.folder, self.request.take()) {
            self.folder = self.unwritten.take(request.prepare());
        }
        self.unwritten.take(file(self.folder.as_ref()?))
    }

    /// What was written otherwise; a failure is told when the place is closed.
    pub fn remember<T>(&mut self, written: Result<T, Failure>) -> Option<T> {
        self.unwritten.take(written)
    }

    /// Writes a table and a picture, if there is a folder; names what was written.
    pub fn table_and_picture<R: Serialize>(
        &mut self,
        rows: impl Iterator<Item = R>,
        picture: impl FnOnce() -> Result<Picture, FigureError>,
    ) -> Vec<String> {
        let table = self.write(|folder| folder.write_table("csv", rows));
        let picture = self.write(|folder| save_picture(folder, picture()));
        table.into_iter().chain(picture).collect()
    }

    /// Tells what was not written, when all else was said.
    ///
    /// # Errors
    /// How the work `ended`, and behind it what was not written: exit code 4 by itself.
    pub fn close(self, ended: Result<(), Failure>) -> Result<(), Failure> {
        self.unwritten.behind(ended)
    }
}

/// A TOML file with a picture of the same name beside it, or none.
#[derive(Debug)]
pub struct PlaceOfFile {
    path: Option<PathBuf>,
    overwrite: bool,
    unwritten: Unwritten,
}

impl PlaceOfFile {
    /// Looks at the place of a file that is said to be a `kind`. Nothing is made yet.
    ///
    /// # Errors
    /// A name that does not end in .toml, a file or a picture that may not be replaced, a folder that takes none.
    pub fn look(out: Option<&Path>, overwrite: bool, kind: &str) -> Result<Self, Failure> {
        overwrite_acts(out, overwrite)?;
        if let Some(path) = out {
            if path.extension().is_none_or(|extension| extension != "toml") {
                return Err(Failure::bad_input(format_args!(
                    "`{}` is no {kind} file: give --out a name that ends in .toml, as in {kind}.toml",
                    path.display()
                )));
            }
            let pictures = picture_file::names(&path.with_extension(""));
            let names = std::iter::once(path.to_owned()).chain(pictures);
            let taken = names
                .into_iter()
                .find(|name| name.symlink_metadata().is_ok());
            if let (Some(taken), false) = (taken, overwrite) {
                return Err(NewFileError::Exists(taken).into());
            }
            look(path).map_err(|error| of_target(error, path))?;
        }
        Ok(Self {
            path: out.map(Path::to_owned),
            overwrite,
            unwritten: Unwritten::default(),
        })
    }

    /// Writes the file, and then its picture, if there is a place; names what was written.
    pub fn write(
        &mut self,
        text: impl FnOnce() -> String,
        picture: impl FnOnce() -> Result<Picture, FigureError>,
    ) -> (Option<String>, Option<String>) {
        let Some(path) = &self.path else {
            return (None, None);
        };
        let written = write_text(path, &text(), self.overwrite);
        let file = self
            .unwritten
            .take(written.map(|()| path.display().to_string()));
        let saved = picture()
            .map_err(PictureFileError::from)
            .and_then(|picture| {
                picture_file::save(&picture, &path.with_extension(""), self.overwrite)
            });
        let saved = saved.map(|saved| saved.shown().display().to_string());
        (file, self.unwritten.take(saved.map_err(Failure::from)))
    }

    /// As [`Place::close`].
    ///
    /// # Errors
    /// As there.
    pub fn close(self, ended: Result<(), Failure>) -> Result<(), Failure> {
        self.unwritten.behind(ended)
    }
}

/// The error of a trial, with the name that the user knows.
fn of_target(error: NewFileError, target: &Path) -> NewFileError {
    match error {
        NewFileError::Io { source, .. } => NewFileError::io(target, source),
        error => error,
    }
}
