//! `materials`: the tissue library, and a tissue as a Prony series for a finite-element program.

use crate::files::{PROGRAM, TextFile};
use crate::output::{Output, warn};
use crate::parse::{one_of, quantity, whole};
use clap::{Args, Subcommand};
use haptic_experiment::{Failure, parameters};
use haptic_quantity::written;
use haptic_tissue::{
    Card, ExportFormat, Library, Material, MaxwellBranch, MeasuredLoading, PronyFit, ValidRange,
};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Tasks with the library.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
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
    Export(Export),
}

impl Command {
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        match self {
            Self::List(folder) => {
                let library = folder.load()?;
                let materials = library.materials();
                let shown: Vec<Value> = materials.iter().map(shown).collect();
                output.report_as(
                    &json!({"materials": materials}),
                    &json!({"materials": shown}),
                )
            }
            Self::Show { name, folder } => {
                let material = folder.load()?.find(&name).map_err(Failure::input)?;
                output.text(&material, |out| write!(out, "{}", material.text))
            }
            Self::Export(export) => export.run(output),
        }
    }
}

/// Facts of a tissue for the list without `--json`.
fn shown(material: &Material) -> Value {
    json!({
        "name": material.name,
        "model": material.model.kind().name(),
        "valid_for": valid_for(&material.range),
        "modulus": modulus(&material.loading),
        "checked": material.source.checked,
        "description": material.description,
        "source": material.source.citation,
    })
}

/// The modulus that the numbers describe, and the way it was measured.
fn modulus(loading: &MeasuredLoading) -> String {
    let how = loading
        .kind
        .map_or(String::new(), |kind| format!(", by {}", kind.name()));
    if loading.is_known() {
        format!("{}{how}", loading.modulus().name())
    } else {
        "not stated".to_owned()
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
    if known.is_empty() {
        "not stated".to_owned()
    } else {
        known.join(", ")
    }
}

/// The band of an export where the tissue's range is not known, s.
const SHORTEST_S: f64 = 1e-3;
const HORIZON_S: f64 = 1000.0;

/// Arguments of `materials export`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli materials export fish-muscle --prony 12 --horizon 1000s \
                  --format ansys --out muscle.inp\n\
                  table: modulus / Pa and relaxation time / s. ansys: TB,PRONY of shear and bulk with the \
                  instantaneous modulus. abaqus: g_i = k_i and tau_i with MODULI=INSTANTANEOUS. febio: g_i, \
                  t_i of viscoelastic, at most six, with the long-term modulus."
)]
pub(crate) struct Export {
    /// Name from the list, or TOML file
    name: String,
    /// Most branches [default: 12, 6 for febio]
    #[arg(long, value_name = "N", value_parser = whole::<usize>(PronyFit::BRANCHES))]
    prony: Option<usize>,
    /// Longest time at which it holds [default: the end of the tissue's record, or 1000s]
    #[arg(long, value_name = "TIME", value_parser = quantity("_s", parameters::MEMORY.range()))]
    horizon: Option<f64>,
    /// Shortest time at which it holds [default: the start of the tissue's record, or 1ms]
    #[arg(long, value_name = "TIME", value_parser = quantity("_s", parameters::MEMORY.range()))]
    shortest: Option<f64>,
    /// table, ansys, abaqus or febio
    #[arg(long, value_parser = one_of(ExportFormat::ALL.map(|one| (one, one.name(), "")).to_vec()), default_value = "table")]
    format: ExportFormat,
    /// How much of the material is written
    #[arg(long, value_parser = one_of(Card::CHOICES.to_vec()), default_value = "series")]
    card: Card,
    #[command(flatten)]
    file: TextFile,
    #[command(flatten)]
    folder: Folder,
}

impl Export {
    fn run(self, output: Output) -> Result<(), Failure> {
        let material = self.folder.load()?.find(&self.name);
        let material = material.map_err(Failure::input)?;
        let branches = self.prony.unwrap_or(self.format.branches());
        let [first_s, last_s] = material.range.times_s();
        let shortest_s = self.shortest.or(first_s).unwrap_or(SHORTEST_S);
        let horizon_s = self.horizon.or(last_s).unwrap_or(HORIZON_S);
        let fit = PronyFit::new(&material.model, branches, shortest_s, horizon_s)
            .map_err(Failure::bad_input)?;
        if let Some(sentence) = material.beyond((shortest_s, horizon_s)) {
            output.warn(&sentence);
        }
        if material.stiffening > 0.0 {
            let b = material.stiffening;
            warn(&format!(
                "{} stiffens by b = {b}, which no Prony series can represent",
                self.name
            ));
        }
        let kind = material.model.kind();
        let citation = &material.source.citation;
        let title = format!("{} ({kind}), {citation}; {PROGRAM}", material.name);
        let text = fit
            .text(self.format, self.card, &title, &material.loading)
            .map_err(Failure::bad_input)?;
        let file = self.file.write(&text)?;
        let in_file = file.is_some();
        let column = |value: fn(&MaxwellBranch) -> f64| -> Vec<f64> {
            fit.branches.iter().map(value).collect()
        };
        let exported = json!({
            "tissue": material.name,
            "model": kind.name(),
            "format": self.format.name(),
            "shortest_s": fit.shortest_s,
            "horizon_s": fit.horizon_s,
            "max_relative_error": fit.max_relative_error,
            "instantaneous_modulus_pa": fit.instantaneous_modulus_pa(),
            "elastic_modulus_pa": fit.elastic_modulus_pa,
            "branch_moduli_pa": column(|one| one.elastic_modulus_pa),
            "branch_times_s": column(|one| one.relaxation_time_s),
            "file": file,
        });
        if in_file {
            output.report(&exported)
        } else {
            output.text(&exported, |out| write!(out, "{text}"))
        }
    }
}

/// The folder with more tissues.
#[derive(Debug, Args)]
pub(crate) struct Folder {
    /// Folder with more tissue files
    #[arg(long, value_name = "DIR")]
    library: Option<PathBuf>,
}

impl Folder {
    /// All tissues: the program's own and those of the folder.
    pub(crate) fn load(&self) -> Result<Library, Failure> {
        library(self.library.as_deref())
    }
}

/// The program's own tissues and those of a folder; says which of its files are not tissues.
pub(crate) fn library(folder: Option<&Path>) -> Result<Library, Failure> {
    let library = Library::load(folder).map_err(Failure::input)?;
    library.skipped().for_each(|file| warn(&file));
    Ok(library)
}
