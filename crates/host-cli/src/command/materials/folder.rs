//! The folder with more tissues.

use crate::output::warn;
use clap::Args;
use haptic_experiment::Failure;
use haptic_tissue::Library;
use std::path::{Path, PathBuf};

/// The folder with more tissues.
#[derive(Debug, Args)]
pub struct Folder {
    /// Folder with more tissue files
    #[arg(long, value_name = "DIR")]
    library: Option<PathBuf>,
}

impl Folder {
    /// All tissues: the program's own and those of the folder.
    ///
    /// # Errors
    /// As [`library`].
    pub(crate) fn load(&self) -> Result<Library, Failure> {
        library(self.library.as_deref())
    }
}

/// The program's own tissues and those of a folder; says which of its files are no tissues.
///
/// # Errors
/// A folder that cannot be read; a name that is there twice.
pub(crate) fn library(folder: Option<&Path>) -> Result<Library, Failure> {
    let library = Library::load(folder).map_err(Failure::input)?;
    library.skipped().for_each(|file| warn(&file));
    Ok(library)
}
