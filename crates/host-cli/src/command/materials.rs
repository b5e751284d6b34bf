//! `materials`: the tissue library.

mod export;
pub(super) mod folder;

use crate::output::{Output, short};
use clap::Subcommand;
use folder::Folder;
use haptic_experiment::Failure;
use haptic_tissue::{Material, ValidRange};
use serde::Serialize;
use std::io::{self, Write};

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
    /// Turn a tissue into a Prony series for ANSYS, Abaqus or FEBio
    Export(export::Arguments),
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
                    print_row(
                        out,
                        [
                            "name",
                            "model",
                            "valid for",
                            "checked",
                            "description [source]",
                        ],
                    )?;
                    for m in materials {
                        let what = format!("{} [{}]", m.description, m.source.citation);
                        let checked = if m.source.checked { "yes" } else { "no" };
                        let model = m.model.kind().name();
                        print_row(out, [&m.name, model, &valid_for(&m.range), checked, &what])?;
                    }
                    Ok(())
                })
            }
            Self::Show { name, folder } => {
                let material = folder.load()?.find(&name).map_err(Failure::input)?;
                output.print(&material, |out| write!(out, "{}", material.text))
            }
            Self::Export(arguments) => arguments.run(output),
        }
    }
}

fn print_row(out: &mut dyn Write, row: [&str; 5]) -> io::Result<()> {
    let [name, model, range, checked, what] = row;
    writeln!(
        out,
        "{name:<20} {model:<27} {range:<22} {checked:<7} {what}"
    )
}

/// The times, frequencies and strains of the measurement, as far as they are known.
fn valid_for(range: &ValidRange) -> String {
    let span = |from: Option<f64>, to: Option<f64>, unit: &str| match (from, to) {
        (Some(from), Some(to)) => Some(format!("{} to {} {unit}", short(from), short(to))),
        (None, Some(to)) => Some(format!("up to {} {unit}", short(to))),
        (Some(from), None) => Some(format!("from {} {unit}", short(from))),
        (None, None) => None,
    };
    let strain = range.strain_to;
    let known = [
        span(range.time_from_s, range.time_to_s, "s"),
        span(range.omega_from_rad_s, range.omega_to_rad_s, "rad/s"),
        strain.map(|strain| format!("strain up to {}", short(strain))),
    ];
    let known: Vec<String> = known.into_iter().flatten().collect();
    if known.is_empty() {
        "not stated".to_owned()
    } else {
        known.join(", ")
    }
}
