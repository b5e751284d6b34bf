//! `materials`: the tissue library.

use crate::output::Output;
use clap::{Args, Subcommand};
use haptic_experiment::failure::Failure;
use haptic_tissue::{Library, Material};
use serde::Serialize;
use std::path::PathBuf;

/// Tasks with the library.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// List all tissues
    #[command(after_help = "Example: host-cli materials list --library my-tissues")]
    List(Folder),
    /// Show one tissue, with its source
    #[command(
        after_help = "Example: host-cli materials show prostate-cancerous > my-tissue.toml\n\
                            A tissue that comes with the program is printed as its file, to start \
                            one of your own from."
    )]
    Show {
        /// A name from the list, or the path of a TOML file
        name: String,
        /// Folder with more tissues
        #[command(flatten)]
        folder: Folder,
    },
}

/// The folder with more tissues.
#[derive(Debug, Args)]
pub struct Folder {
    /// Folder with more tissue files
    #[arg(long, value_name = "DIR")]
    library: Option<PathBuf>,
}

/// The list.
#[derive(Serialize)]
struct List<'a> {
    materials: &'a [Material],
}

impl Command {
    /// Runs the command.
    ///
    /// # Errors
    /// A wrong file or an unknown name.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        match self {
            Self::List(folder) => {
                let library = folder.load()?;
                let materials = library.materials();
                output.print(&List { materials }, |out| {
                    writeln!(
                        out,
                        "{:<22} {:>12} {:>16} {:>8}  {:<9} description",
                        "name", "E0 / Pa", "eta / Pa·s^α", "order α", "checked"
                    )?;
                    for m in materials {
                        writeln!(
                            out,
                            "{:<22} {:>12} {:>16} {:>8}  {:<9} {}",
                            m.name,
                            m.elastic_modulus_pa,
                            m.viscosity_pa_s_alpha,
                            m.order,
                            if m.source.checked { "yes" } else { "no" },
                            m.description
                        )?;
                    }
                    Ok(())
                })
            }
            Self::Show { name, folder } => {
                let material = folder.load()?.find(&name).map_err(Failure::input)?;
                output.print(&material, |out| write!(out, "{}", material.text))
            }
        }
    }
}

impl Folder {
    fn load(&self) -> Result<Library, Failure> {
        Library::load(self.library.as_deref()).map_err(Failure::input)
    }
}
