//! `materials export`: a tissue as a Prony series for a finite-element program.

use super::folder::Folder;
use crate::output::Output;
use crate::whole::whole;
use crate::within::within;
use clap::Args;
use haptic_experiment::Failure;
use haptic_experiment::parameters::range;
use haptic_experiment::run::write_text;
use haptic_quantity::Time;
use haptic_tissue::{ExportFormat, MaxwellBranch, PronyFit};
use serde::Serialize;
use std::path::PathBuf;

/// Arguments of `materials export`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli materials export fish-muscle --prony 12 --horizon 1000s --format ansys --out muscle.inp\n\
                  table: modulus / Pa and relaxation time / s. ansys: TB,PRONY with the instantaneous modulus. abaqus: g_i, k_i, \
                  tau_i with MODULI=INSTANTANEOUS. febio: g_i, t_i of viscoelastic, at most six, with the long-term modulus."
)]
pub struct Arguments {
    /// Name from the list, or TOML file
    name: String,
    /// Most branches [default: 12, 6 for febio]
    #[arg(long, value_name = "N", value_parser = whole::<usize>(PronyFit::BRANCHES))]
    prony: Option<usize>,
    /// Longest time at which it holds
    #[arg(long, value_parser = within::<Time>(range::MEMORIES), allow_hyphen_values = true, default_value = "1000s")]
    horizon: Time,
    /// Shortest time at which it holds
    #[arg(long, value_parser = within::<Time>(range::MEMORIES), allow_hyphen_values = true, default_value = "1ms")]
    shortest: Time,
    /// table, ansys, abaqus or febio
    #[arg(long, value_parser = parse_format, default_value = "table")]
    format: ExportFormat,
    /// File to write [default: standard output]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Replace an existing file
    #[arg(long, requires = "out")]
    overwrite: bool,
    #[command(flatten)]
    folder: Folder,
}

/// What was made.
#[derive(Serialize)]
struct Exported<'a> {
    tissue: &'a str,
    model: &'static str,
    format: &'static str,
    shortest_s: f64,
    horizon_s: f64,
    max_relative_error: f64,
    instantaneous_modulus_pa: f64,
    elastic_modulus_pa: f64,
    branch_moduli_pa: Vec<f64>,
    branch_times_s: Vec<f64>,
    file: Option<String>,
}

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// An unknown tissue, a series that there is none of, a file that exists.
    pub(super) fn run(self, output: Output) -> Result<(), Failure> {
        let material = self.folder.load()?.find(&self.name);
        let material = material.map_err(Failure::input)?;
        let branches = self.prony.unwrap_or(self.format.branches());
        let fit = PronyFit::new(&material.model, branches, self.shortest.0, self.horizon.0)
            .map_err(Failure::bad_input)?;
        let kind = material.model.kind();
        let title = format!(
            "{} ({kind}), {}; host-cli {}",
            material.name,
            material.source.citation,
            env!("CARGO_PKG_VERSION")
        );
        let text = fit.text(self.format, &title).map_err(Failure::bad_input)?;
        if let Some(path) = &self.out {
            write_text(path, &text, self.overwrite)?;
        }
        let column = |value: fn(&MaxwellBranch) -> f64| fit.branches.iter().map(value).collect();
        let exported = Exported {
            tissue: &material.name,
            model: kind.name(),
            format: self.format.name(),
            shortest_s: fit.shortest_s,
            horizon_s: fit.horizon_s,
            max_relative_error: fit.max_relative_error,
            instantaneous_modulus_pa: fit.instantaneous_modulus_pa(),
            elastic_modulus_pa: fit.elastic_modulus_pa,
            branch_moduli_pa: column(|one| one.elastic_modulus_pa),
            branch_times_s: column(|one| one.relaxation_time_s),
            file: self.out.as_deref().map(|path| path.display().to_string()),
        };
        if exported.file.is_none() {
            return output.text(&exported, |out| write!(out, "{text}"));
        }
        output.summary(&exported)
    }
}

fn parse_format(name: &str) -> Result<ExportFormat, String> {
    let found = ExportFormat::ALL.into_iter().find(|one| one.name() == name);
    found.ok_or_else(|| {
        let known: Vec<&str> = ExportFormat::ALL.iter().map(|one| one.name()).collect();
        format!("take one of {}", known.join(", "))
    })
}
