//! `materials`: the tissue library.

mod export;
pub(super) mod folder;

use crate::output::Output;
use clap::Subcommand;
use folder::Folder;
use haptic_experiment::Failure;
use haptic_quantity::written;
use haptic_tissue::{Material, ValidRange};
use serde::Serialize;

/// Tasks with the library.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// List all tissues
    #[command(after_help = "Example: host-cli materials list --library my-tissues")]
    List(Folder),
    /// Show a tissue with its source
    #[command(
        after_help = "Example: host-cli materials show prostate-cancerous > my-tissue.toml\n\
                            Prints its file, to start your own from."
    )]
    Show {
        /// Name from the list, or TOML file
        name: String,
        /// Folder with more tissues
        #[command(flatten)]
        folder: Folder,
    },
    /// Export a Prony series for ANSYS, Abaqus or FEBio
    Export(export::Arguments),
}

/// The list.
#[derive(Serialize)]
struct List<'a> {
    materials: &'a [Material],
}

/// What of the list is shown without `--json`.
#[derive(Serialize)]
struct ShownList<'a> {
    materials: Vec<Shown<'a>>,
}

#[derive(Serialize)]
struct Shown<'a> {
    name: &'a str,
    model: &'static str,
    valid_for: String,
    checked: bool,
    description: &'a str,
    source: &'a str,
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
                let shown = materials.iter().map(Shown::of).collect();
                output.report_as(&List { materials }, &ShownList { materials: shown })
            }
            Self::Show { name, folder } => {
                let material = folder.load()?.find(&name).map_err(Failure::input)?;
                output.text(&material, |out| write!(out, "{}", material.text))
            }
            Self::Export(arguments) => arguments.run(output),
        }
    }
}

impl<'a> Shown<'a> {
    fn of(material: &'a Material) -> Self {
        Self {
            name: &material.name,
            model: material.model.kind().name(),
            valid_for: valid_for(&material.range),
            checked: material.source.checked,
            description: &material.description,
            source: &material.source.citation,
        }
    }
}

/// The times, frequencies and strains of the measurement, as far as they are known.
fn valid_for(range: &ValidRange) -> String {
    let span = |key: &str, from: Option<f64>, to: Option<f64>| {
        let [from, to] = [from, to].map(|end| end.map(|end| written(key, end)));
        match (from, to) {
            (Some(from), Some(to)) => Some(format!("{from} to {to}")),
            (None, Some(to)) => Some(format!("up to {to}")),
            (Some(from), None) => Some(format!("from {from}")),
            (None, None) => None,
        }
    };
    let known = [
        span("time_s", range.time_from_s, range.time_to_s),
        span("omega_rad_s", range.omega_from_rad_s, range.omega_to_rad_s),
        span("strain", None, range.strain_to).map(|strain| format!("strain {strain}")),
    ];
    let known: Vec<String> = known.into_iter().flatten().collect();
    match known.is_empty() {
        true => "not stated".to_owned(),
        false => known.join(", "),
    }
}
