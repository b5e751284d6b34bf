//! Places of results: folders with their provenance, files, and pictures beside them.
//!
//! The output path is checked before the work starts, so that an hour of work is not lost to an existing file. A file that still cannot be
//! written is reported after the result, as lost data.

use crate::parse::quantity;
use crate::picture_file::Pictures;
use clap::Args;
use haptic_experiment::Failure;
use haptic_experiment::parameters::Range;
use haptic_figure::{FigureError, Picture};
use haptic_log::record::{
    Leftover, NewFile, NewFileError, ROLL_LEAST, refuse_taken, remove_earlier,
};
use haptic_run::{FolderRequest, OutputFolder, write_text};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// This program, as files name who made them.
pub(crate) const PROGRAM: &str = concat!("host-cli ", env!("CARGO_PKG_VERSION"));

/// The folder of what a command answers, if it is to be kept.
#[derive(Debug, Args)]
#[command(next_help_heading = "Files")]
pub(crate) struct Files {
    /// Folder for tables, pictures and experiment files
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace the files of an earlier answer in the folder
    #[arg(long)]
    overwrite: bool,
    #[command(flatten)]
    pub(crate) pictures: Pictures,
}

impl Files {
    /// Looks at the place of files of this name, before anything is computed. `beside` names extensions that are there beside
    /// table and picture.
    pub(crate) fn look(&self, stem: &str, endings: &[&str]) -> Result<Place, Failure> {
        let mut place = Place::look(self.out.as_deref(), stem, self.overwrite, endings)?;
        place.pictures = self.pictures.clone();
        Ok(place)
    }
}

/// The folder of a run, which is always kept.
#[derive(Debug, Args)]
pub(crate) struct RunFiles {
    /// Folder for log, CSV and pictures [default: results/NAME-0001]
    #[arg(long, value_name = "DIR", help_heading = "Run")]
    out: Option<PathBuf>,
    /// Replace the files of an earlier run
    #[arg(long, help_heading = "Run")]
    pub(crate) overwrite: bool,
    /// Start another log file at this size, as in 1GB
    #[arg(long, value_name = "SIZE", value_parser = quantity("_bytes", ROLLS), hide_short_help = true, help_heading = "Run")]
    roll: Option<f64>,
}

/// Sizes at which another log file begins, bytes; no disk has more.
const ROLLS: Range = Range::Within(ROLL_LEAST as f64, 1e15);

impl RunFiles {
    /// A folder for files of this stem, whose logs say what made them.
    pub(crate) fn folder(&self, stem: &str) -> Result<FolderRequest, Failure> {
        overwrite_acts(self.out.as_deref(), self.overwrite)?;
        Ok(FolderRequest {
            roll_bytes: self.roll.map(|size| size as u64),
            ..folder(self.out.clone(), stem, self.overwrite)
        })
    }
}

/// A file for a text.
#[derive(Debug, Args)]
pub(crate) struct TextFile {
    /// File to write [default: standard output]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Replace an existing file
    #[arg(long, requires = "out")]
    overwrite: bool,
}

impl TextFile {
    /// Writes the text, if a file is named; its name.
    pub(crate) fn write(&self, text: &str) -> Result<Option<String>, Failure> {
        let Some(path) = &self.out else {
            return Ok(None);
        };
        write_text(path, text, self.overwrite)?;
        Ok(Some(path.display().to_string()))
    }
}

/// A TOML file for what was found.
#[derive(Debug, Args)]
#[command(next_help_heading = "Files")]
pub(crate) struct File {
    /// TOML file to write, with a picture beside it
    #[arg(long, value_name = "FILE.toml")]
    pub(crate) out: Option<PathBuf>,
    /// Replace existing files
    #[arg(long)]
    overwrite: bool,
    #[command(flatten)]
    pictures: Pictures,
}

/// A folder for files of this stem, whose logs say what made them.
pub(crate) fn folder(out: Option<PathBuf>, stem: &str, overwrite: bool) -> FolderRequest {
    FolderRequest {
        out,
        stem: stem.to_owned(),
        overwrite,
        roll_bytes: None,
        provenance: provenance(),
    }
}

/// Refuses to overwrite where no folder is named: nothing is there yet.
fn overwrite_acts(out: Option<&Path>, overwrite: bool) -> Result<(), Failure> {
    if overwrite && out.is_none() {
        return Err(Failure::bad_input(
            "overwriting has no effect without --out: give it too, or omit --overwrite",
        ));
    }
    Ok(())
}

pub(crate) fn provenance() -> BTreeMap<String, String> {
    let arguments: Vec<String> = std::env::args_os()
        .map(|argument| argument.to_string_lossy().into_owned())
        .collect();
    BTreeMap::from([
        ("program".to_owned(), PROGRAM.to_owned()),
        ("command_line".to_owned(), arguments.join(" ")),
    ])
}

/// Saves a picture under the folder's own stem, and names the file to look at.
pub(crate) fn save_picture(
    folder: &OutputFolder,
    picture: Result<Picture, FigureError>,
    pictures: &Pictures,
) -> Result<String, Failure> {
    pictures.save(picture, &folder.stem(), folder.overwrite())
}

#[derive(Debug, Default)]
struct Unwritten(Option<Failure>);

impl Unwritten {
    /// The result of a write, if it succeeded; the first failure is remembered.
    fn take<T>(&mut self, written: Result<T, Failure>) -> Option<T> {
        match written {
            Ok(written) => Some(written),
            Err(failure) => {
                // The place was good before the work: nobody's input is at fault.
                self.0
                    .get_or_insert(if let Failure::Input(cause) = failure {
                        Failure::DataLost(cause)
                    } else {
                        failure
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

/// Looks whether files of these names can be made; another program that writes the same names is not disturbed.
fn look(names: &[PathBuf], target: &Path, overwrite: bool) -> Result<(), NewFileError> {
    (names.iter()).try_for_each(|name| refuse_taken(name, overwrite))?;
    let mut name = target.as_os_str().to_owned();
    name.push(format!("-{}", std::process::id()));
    match NewFile::create(Path::new(&name), Leftover::Discard, false) {
        Ok((trial, _)) => trial.discard(),
        // With the name that the user knows.
        Err(NewFileError::Io { source, .. }) => return Err(NewFileError::io(target, source)),
        Err(error) => return Err(error),
    }
    Ok(())
}

/// The folder of a command that takes its time, or none.
#[derive(Debug)]
pub(crate) struct Place {
    request: Option<FolderRequest>,
    folder: Option<OutputFolder>,
    unwritten: Unwritten,
    pictures: Pictures,
}

impl Place {
    /// Looks at the folder for files of this stem. Nothing is made yet.
    pub(crate) fn look(
        out: Option<&Path>,
        stem: &str,
        overwrite: bool,
        endings: &[&str],
    ) -> Result<Self, Failure> {
        overwrite_acts(out, overwrite)?;
        let request = out.map(|out| folder(Some(out.to_owned()), stem, overwrite));
        if let Some(request) = &request {
            let folder = request.prepare()?;
            let names = endings.iter().map(|extension| folder.file(extension));
            let looked = look(&names.collect::<Vec<_>>(), &folder.stem(), overwrite);
            folder.discard();
            looked?;
        }
        Ok(Self {
            request,
            folder: None,
            unwritten: Unwritten::default(),
            pictures: Pictures::default(),
        })
    }

    /// Writes into the folder, if there is one; what was written.
    pub(crate) fn write<T>(
        &mut self,
        file: impl FnOnce(&OutputFolder) -> Result<T, Failure>,
    ) -> Option<T> {
        if let (None, Some(request)) = (&self.folder, self.request.take()) {
            self.folder = self.unwritten.take(request.prepare());
        }
        self.unwritten.take(file(self.folder.as_ref()?))
    }

    /// Writes a text under the folder's own stem; the name of the file.
    pub(crate) fn text(&mut self, extension: &str, text: &str) -> Option<String> {
        self.write(|folder| {
            let file = folder.file(extension);
            write_text(&file, text, folder.overwrite())?;
            Ok(file.display().to_string())
        })
    }

    /// Takes files of an earlier answer away, which would pass for parts of this one.
    pub(crate) fn without(&mut self, extensions: &[&str]) {
        self.write(|folder| {
            for extension in extensions.iter().filter(|_| folder.overwrite()) {
                remove_earlier(&folder.file(extension));
            }
            Ok(())
        });
    }

    /// The result of another write; a failure is reported when the place is closed.
    pub(crate) fn remember<T>(&mut self, written: Result<T, Failure>) -> Option<T> {
        self.unwritten.take(written)
    }

    /// Writes a picture, if there is a folder; the name of the file to look at.
    pub(crate) fn picture(
        &mut self,
        picture: impl FnOnce() -> Result<Picture, FigureError>,
    ) -> Option<String> {
        let pictures = self.pictures.clone();
        self.write(|folder| save_picture(folder, picture(), &pictures))
    }

    /// Writes a table and a picture, if there is a folder; names what was written. `names` are those of columns whose rows have none.
    pub(crate) fn table_and_picture<R: Serialize>(
        &mut self,
        names: &[&str],
        rows: impl Iterator<Item = R>,
        picture: impl FnOnce() -> Result<Picture, FigureError>,
    ) -> Vec<String> {
        let table = self.write(|folder| folder.write_table(names, rows));
        let picture = self.picture(picture);
        table.into_iter().chain(picture).collect()
    }

    /// Reports a failed write, after everything else.
    pub(crate) fn close(self, ended: Result<(), Failure>) -> Result<(), Failure> {
        self.unwritten.behind(ended)
    }
}

/// Refuses a name with another extension than this one has.
fn is_called(path: &Path, format: &str, as_in: &str) -> Result<(), Failure> {
    if path.extension() == Path::new(as_in).extension() {
        return Ok(());
    }
    Err(Failure::bad_input(format_args!(
        "`{}` is not a {format} file: give --out another name, as {as_in}",
        path.display()
    )))
}

/// A TOML file with a picture of the same name beside it, a form, or none.
#[derive(Debug)]
pub(crate) struct PlaceOfFile {
    path: Option<PathBuf>,
    overwrite: bool,
    unwritten: Unwritten,
    pictures: Pictures,
}

impl PlaceOfFile {
    /// Checks the place of a file of this kind. Nothing is made yet.
    pub(crate) fn look(file: &File, kind: &str) -> Result<Self, Failure> {
        Self::next_to(file, kind, &[])
    }

    /// Looks at the place of a file with files of these extensions beside it.
    pub(crate) fn next_to(file: &File, kind: &str, others: &[&str]) -> Result<Self, Failure> {
        let File {
            out,
            overwrite,
            pictures,
        } = file;
        overwrite_acts(out.as_deref(), *overwrite)?;
        if let Some(path) = out {
            is_called(path, "TOML", &format!("{kind}.toml"))?;
            let pictures = pictures.names(&path.with_extension(""));
            let others = others
                .iter()
                .map(|extension| path.with_extension(extension));
            let names = std::iter::once(path.clone()).chain(pictures).chain(others);
            look(&names.collect::<Vec<PathBuf>>(), path, *overwrite)?;
        }
        Ok(Self {
            path: out.clone(),
            overwrite: *overwrite,
            unwritten: Unwritten::default(),
            pictures: pictures.clone(),
        })
    }

    /// Looks at the place of a form in Markdown. It never replaces a file: somebody may have written into it.
    pub(crate) fn of_form(out: Option<&PathBuf>) -> Result<Self, Failure> {
        if let Some(path) = out {
            is_called(path, "Markdown", "form.md")?;
            if path.symlink_metadata().is_ok() {
                return Err(Failure::bad_input(format_args!(
                    "`{}` already exists, and a form may hold what somebody wrote: give --out another name",
                    path.display()
                )));
            }
            look(&[], path, false)?;
        }
        Ok(Self {
            path: out.cloned(),
            overwrite: false,
            unwritten: Unwritten::default(),
            pictures: Pictures::default(),
        })
    }

    /// Writes the file, and then its picture, if there is a place; names what was written.
    pub(crate) fn write(
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
        let stem = path.with_extension("");
        let saved = self.pictures.save(picture(), &stem, self.overwrite);
        (file, self.unwritten.take(saved))
    }

    /// Writes a text beside it; the name of the file. Without one, an earlier file is taken away: it would pass for part of this answer.
    pub(crate) fn write_beside(&mut self, extension: &str, text: Option<String>) -> Option<String> {
        let path = self.path.as_ref()?.with_extension(extension);
        let Some(text) = text else {
            if self.overwrite {
                remove_earlier(&path);
            }
            return None;
        };
        let written = write_text(&path, &text, self.overwrite);
        self.unwritten
            .take(written.map(|()| path.display().to_string()))
    }

    /// Closes as [`Place::close`] does.
    pub(crate) fn close(self, ended: Result<(), Failure>) -> Result<(), Failure> {
        self.unwritten.behind(ended)
    }
}
