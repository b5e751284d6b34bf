//! Tissue files that cannot be used.

use std::fmt;
use std::path::PathBuf;

/// A material that cannot be used.
#[derive(Debug)]
pub enum MaterialError {
    /// A file that is wrong: file, line, reason.
    File {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The mistake in it.
        reason: String,
    },
    /// A file or folder that cannot be read.
    Unreadable(PathBuf, std::io::Error),
    /// A folder of tissue files that cannot be read.
    Folder(PathBuf, std::io::Error),
    /// A name that is not in the library.
    Unknown {
        /// The name.
        name: String,
        /// All there are.
        known: Vec<String>,
    },
    /// A name that is not made of lower-case letters, digits and hyphens.
    Name(String),
    /// Two files with the same name for a material.
    Twice(String, PathBuf),
}

impl fmt::Display for MaterialError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File { path, line, reason } => {
                write!(f, "{}:{line}: {reason}", path.display())
            }
            Self::Unreadable(path, error) => write!(
                f,
                "cannot read the material file `{}`: {error}; give the name of a material or a path \
                 to its TOML file",
                path.display()
            ),
            Self::Folder(path, error) => write!(
                f,
                "cannot read the library folder `{}`: {error}; give a folder of tissue files (*.toml)",
                path.display()
            ),
            Self::Unknown { name, known } => write!(
                f,
                "tissue \"{}\" is not in the library: take one of {}, or give the path of a TOML \
                 file (`host-cli materials show {}` prints one to start from)",
                name,
                known.join(", "),
                known.first().map_or("NAME", String::as_str),
            ),
            Self::Name(name) => write!(
                f,
                "name \"{name}\" is not made of lower-case letters, digits and hyphens"
            ),
            Self::Twice(name, path) => write!(
                f,
                "{}: the library has a material \"{name}\" already; choose another name",
                path.display()
            ),
        }
    }
}

impl std::error::Error for MaterialError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            Self::Unreadable(_, error) | Self::Folder(_, error) => Some(error),
            _ => None,
        }
    }
}
