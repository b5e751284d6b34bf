//! The folder with more tissues.

use clap::Args;
use haptic_experiment::failure::Failure;
use haptic_tissue::Library;
use std::path::PathBuf;

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
    /// A wrong file.
    pub(crate) fn load(&self) -> Result<Library, Failure> {
        Library::load(self.library.as_deref()).map_err(Failure::input)
    }
}
