//! `identify`: a tissue from a measured record.

mod choices;
mod draw;
mod read;
mod report;
mod tissue;

use self::choices::{KindChoice, ModelChoice, WeightChoice};
use crate::choice::choice;
use crate::command::conduct::progress_bar;
use crate::output::{Output, warn};
use crate::whole::whole;
use crate::within::within;
use clap::Args;
use haptic_experiment::Failure;
use haptic_experiment::parameters;
use haptic_quantity::{Area, Length, Strain, Stress};
use haptic_tissue::identify::table::Loading;
use haptic_tissue::identify::{Options, identify};
use std::path::PathBuf;

pub(crate) const LONG_ABOUT: &str = "\
Fits fractional models to a measured record, tells how sure each parameter is and which model the record supports, and writes \
a tissue file for relax --tissue.

DATA is CSV or TSV with a header, or a log (*.mcap). Known headers: time_s, relaxation_modulus_pa, creep_compliance_per_pa, \
strain, stress_pa, force_n, position_m, omega_rad_s, storage_modulus_pa, loss_modulus_pa, and those of rheometers and testing \
machines, as Time [s], G' (kPa), Storage Modulus. Lines that begin with # are skipped.

The fit is least squares: in the logarithm of modulus or compliance for relaxation, creep and oscillation, in the stress for \
any other motion, with its strain as it was.";

/// Arguments of `identify`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli identify relaxation.csv --strain 5% --area 4cm2 --out my-tissue.toml"
)]
pub struct Arguments {
    /// CSV or TSV with a header, or a log (*.mcap)
    #[arg(value_name = "DATA")]
    data: PathBuf,
    /// Kind of record [default: by its columns]
    #[arg(long, value_parser = choice::<KindChoice>())]
    kind: Option<KindChoice>,
    /// Model to fit; auto selects by the record
    #[arg(long, value_parser = choice::<ModelChoice>(), default_value = "auto")]
    model: ModelChoice,
    #[command(flatten)]
    table: read::TableArguments,
    /// Held strain of a relaxation
    #[arg(long, value_parser = within::<Strain>(parameters::STRAIN.range()), allow_hyphen_values = true, help_heading = "Specimen")]
    strain: Option<Strain>,
    /// Held stress of a creep test
    #[arg(long, value_parser = within::<Stress>(parameters::STRESS.range()), allow_hyphen_values = true, help_heading = "Specimen")]
    stress: Option<Stress>,
    /// Area of the specimen, to turn force into stress
    #[arg(long, value_parser = within::<Area>(parameters::AREA.range()), allow_hyphen_values = true, help_heading = "Specimen")]
    area: Option<Area>,
    /// Thickness of the specimen, to turn position into strain
    #[arg(long, value_parser = within::<Length>(parameters::THICKNESS.range()), allow_hyphen_values = true, help_heading = "Specimen")]
    thickness: Option<Length>,
    #[command(flatten)]
    fit: FitArguments,
    #[command(flatten)]
    tissue: tissue::TissueArguments,
}

/// Fewer records say nothing of the ends of an interval.
const BOOTSTRAP_LEAST: u32 = 40;

/// Options of the fit.
#[derive(Debug, Args)]
#[command(next_help_heading = "Fit")]
struct FitArguments {
    /// Weights of the samples
    #[arg(long, value_parser = choice::<WeightChoice>(), default_value = "equal")]
    weights: WeightChoice,
    /// Starts per model
    #[arg(long, default_value_t = Options::STARTS as u32, value_parser = whole::<u32>(Options::STARTS_ALLOWED))]
    starts: u32,
    /// Bootstrap records for the intervals; 0 uses the standard errors
    #[arg(long, default_value_t = 0, value_parser = whole::<u32>(Options::BOOTSTRAP_ALLOWED))]
    bootstrap: u32,
    /// Seed of the bootstrap [default: 1]
    #[arg(long, value_parser = whole::<u64>(0..=u64::MAX), requires = "bootstrap")]
    seed: Option<u64>,
}

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A record that cannot be read or fitted, files that cannot be written.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        if (1..BOOTSTRAP_LEAST).contains(&self.fit.bootstrap) {
            return Err(Failure::bad_input(format_args!(
                "{} records give no interval: give --bootstrap at least {BOOTSTRAP_LEAST}, as in 500, or omit it",
                self.fit.bootstrap
            )));
        }
        let mut planned = self.tissue.plan()?;
        let loading = Loading {
            strain: self.strain.map(|x| x.0),
            stress_pa: self.stress.map(|x| x.0),
            area_m2: self.area.map(|x| x.0),
            thickness_m: self.thickness.map(|x| x.0),
        };
        let kind = self.kind.map(|kind| kind.0);
        let understood = self.table.read(&self.data, kind, loading)?;
        let options = Options {
            candidates: self.model.candidates(),
            chosen: self.model.only(),
            weighting: self.fit.weights.0,
            starts: self.fit.starts as usize,
            bootstrap: self.fit.bootstrap as usize,
            seed: self.fit.seed.unwrap_or(1),
        };
        let bar = progress_bar(u64::from(self.fit.bootstrap), output);
        let found = identify(&understood.record, &options, &|records| {
            bar.inc(records as u64);
        });
        bar.finish_and_clear();
        let found = found.map_err(Failure::input)?;
        let name = self.data.file_name().unwrap_or(self.data.as_os_str());
        let place = name.to_string_lossy();
        let written = match &mut planned {
            Some(planned) => planned.write(&found, &place)?,
            None => (None, None),
        };
        for warning in &found.warnings {
            warn(warning);
        }
        output.summary(&report::Report::new(&found, &understood.notes, written))?;
        planned.map_or(Ok(()), tissue::Planned::close)
    }
}
