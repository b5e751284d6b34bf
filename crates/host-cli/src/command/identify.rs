//! `identify`: a tissue from a measured record.

mod draw;
mod record;
mod several;

use self::record::TableArguments;
use self::several::SeveralArguments;
use crate::command::conduct::progress_bar;
use crate::files::{File, PROGRAM, PlaceOfFile};
use crate::output::{Output, joined};
use crate::parse::{choice, of, one_of, whole};
use clap::Args;
use haptic_experiment::question::tissue::{
    RecordAnswer, RecordQuestion, contact_point, estimates, held,
};
use haptic_experiment::{Failure, parameters};
use haptic_log::record::StartTime;
use haptic_loop::{Loading, LoadingKind};
use haptic_tissue::ModelKind;
use haptic_tissue::identify::table::Reading;
use haptic_tissue::identify::{
    Baseline, CANDIDATES, ContactPoint, Fit, Held, Identification, Options, Provenance, RecordKind,
    Weighting,
};
use serde_json::{Value, json};
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::time::SystemTime;

/// The model that was asked for; none for the simplest that the record supports.
type Chosen = Option<ModelKind>;

fn models() -> Vec<(Chosen, &'static str, &'static str)> {
    let auto = (None, "auto", "the simplest that the record supports");
    let one = |kind: ModelKind| (Some(kind), kind.name(), kind.description());
    std::iter::once(auto).chain(CANDIDATES.map(one)).collect()
}

fn weightings() -> Vec<(Weighting, &'static str, &'static str)> {
    let by_spacing = "by spacing in log time or frequency";
    vec![
        (Weighting::Equal, "equal", "all samples count the same"),
        (Weighting::LogSpacing, "log-spacing", by_spacing),
    ]
}

/// Turn a measured record into a tissue: relaxation, creep, oscillation or any motion
///
/// Fits fractional models, reports how certain each parameter is and which model the record
/// supports, and writes a tissue file for relax --tissue.
///
/// DATA is CSV or TSV with a header, or a log (*.mcap); of a log that somebody else wrote --columns
/// names fields, as in force=/topic.field. Known headers: `time_s`,
/// `relaxation_modulus_pa`, `creep_compliance_per_pa`, strain, `stress_pa`, `force_n`,
/// `position_m`, `omega_rad_s`, `storage_modulus_pa`, `loss_modulus_pa`, and those of rheometers
/// and testing machines, such as Time [s], G' (kPa), Storage Modulus, Depth (mm). What stands
/// above the table is passed over; --segments lists what a file with several measurements has.
///
/// Headers with G or shear mean the shear modulus, E means Young's. Where the header says neither,
/// --loading says how the specimen was loaded. --loading with --indenter-radius or --half-angle
/// turns force and depth of a punch, sphere or cone into a modulus.
///
/// The fit is least squares: in the logarithm of modulus or compliance for relaxation, creep and
/// oscillation, in the stress for any other motion.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli identify relaxation.csv --strain 5% --area 4cm2 --out my-tissue.toml"
)]
pub(crate) struct Arguments {
    /// CSV or TSV with a header, or a log (*.mcap); several motions of one tissue are fitted together
    #[arg(value_name = "DATA", required = true)]
    data: Vec<PathBuf>,
    /// Kind of record [default: by its columns]
    #[arg(long, value_parser = one_of(RecordKind::CHOICES.to_vec()))]
    kind: Option<RecordKind>,
    /// Model to fit; auto selects by the record
    #[arg(long, value_parser = one_of(models()), default_value = "auto")]
    model: Chosen,
    #[command(flatten)]
    table: TableArguments,
    #[command(flatten)]
    specimen: SpecimenArguments,
    #[command(flatten)]
    fit: FitArguments,
    #[command(flatten)]
    several: SeveralArguments,
    #[command(flatten)]
    file: File,
    /// Specimen, temperature, preparation, for the tissue file
    #[arg(long, value_name = "TEXT", requires = "out", help_heading = "Files")]
    conditions: Option<String>,
}

/// Options of the specimen: what the table lacks.
#[derive(Debug, Args)]
#[command(next_help_heading = "Specimen")]
struct SpecimenArguments {
    /// Held strain of a relaxation
    #[arg(long, value_parser = of(parameters::STRAIN))]
    strain: Option<f64>,
    /// Held stress of a creep test
    #[arg(long, value_parser = of(parameters::STRESS))]
    stress: Option<f64>,
    /// How it was loaded [default: as the header says]
    #[arg(long, value_parser = choice::<LoadingKind>())]
    loading: Option<LoadingKind>,
    /// Area, to turn force into stress
    #[arg(long, value_parser = of(parameters::AREA))]
    area: Option<f64>,
    /// Thickness, to turn position into strain; of a layer under a sphere
    #[arg(long, value_parser = of(parameters::THICKNESS))]
    thickness: Option<f64>,
    /// Radius of a punch or sphere
    #[arg(long, value_parser = of(parameters::INDENTER_RADIUS))]
    indenter_radius: Option<f64>,
    /// Half angle of a cone, between axis and flank
    #[arg(long, value_parser = of(parameters::HALF_ANGLE))]
    half_angle: Option<f64>,
    /// The slab cannot slide on its plates, or the layer under a sphere cannot slide on its base
    #[arg(long)]
    bonded: bool,
    /// Poisson's ratio [default: 0.5, incompressible]
    #[arg(long, value_parser = of(parameters::POISSON_RATIO))]
    poisson_ratio: Option<f64>,
    /// Depth at which an indenter touches, or fit, to find it [default: 0]
    #[arg(long, value_name = "DEPTH", value_parser = contact_point, allow_hyphen_values = true)]
    contact_point: Option<ContactPoint>,
    /// Time of the ramp to the held strain of a relaxation
    #[arg(long, value_parser = of(parameters::RECORD_RAMP_TIME))]
    ramp_time: Option<f64>,
    /// Time of the record's clock at which this ramp ends, as 0 of one that begins with the hold [default: the ramp begins at 0]
    #[arg(long, value_name = "TIME", value_parser = of(parameters::RECORD_RAMP_ENDS), allow_hyphen_values = true)]
    ramp_ends: Option<f64>,
    /// Subtract the first row of strain and stress: a motion that begins at rest, but not at 0
    #[arg(long)]
    subtract_start: bool,
}

impl SpecimenArguments {
    fn reading(&self, kind: Option<RecordKind>) -> Reading {
        Reading {
            kind,
            strain: self.strain,
            stress_pa: self.stress,
            loading: Loading {
                kind: self.loading.unwrap_or(LoadingKind::Compression),
                area_m2: self.area,
                thickness_m: self.thickness,
                radius_m: self.indenter_radius,
                half_angle_rad: self.half_angle,
                bonded: self.bonded,
            },
            loading_is_told: self.loading.is_some(),
            poisson_ratio: self.poisson_ratio,
            contact: self.contact_point.unwrap_or_default(),
            ramp_time_s: self.ramp_time,
            ramp_ends_s: self.ramp_ends,
            subtract_start: self.subtract_start,
        }
    }
}

/// Fewer records say nothing of the ends of an interval.
const BOOTSTRAP_LEAST: u32 = 40;

/// Options of the fit.
#[derive(Debug, Args)]
#[command(next_help_heading = "Fit")]
struct FitArguments {
    /// Weights of the samples
    #[arg(long, value_parser = one_of(weightings()), default_value = "equal")]
    weights: Weighting,
    /// Starts per model
    #[arg(long, default_value_t = Options::STARTS as u32, value_parser = whole::<u32>(Options::STARTS_ALLOWED))]
    starts: u32,
    /// Find how much the tissue stiffens too, by a motion or by motions to several depths
    #[arg(long)]
    stiffening: bool,
    /// Find the part of the force that is not the tissue's too
    #[arg(long, value_parser = one_of(Baseline::CHOICES.to_vec()))]
    baseline: Option<Baseline>,
    /// Parameters to hold at a value or in a range, as in order=0.2 or order=0.1..0.3
    #[arg(long, value_name = "PARAMETER=VALUE", value_delimiter = ',', value_parser = held)]
    fix: Vec<Held>,
    /// Bootstrap records for the intervals; 0 takes them from profiles of the likelihood
    #[arg(long, default_value_t = 0, value_parser = whole::<u32>(Options::BOOTSTRAP_ALLOWED))]
    bootstrap: u32,
    /// Seed of the bootstrap [default: 1]
    #[arg(long, value_parser = whole::<u64>(0..=u64::MAX), requires = "bootstrap")]
    seed: Option<u64>,
}

impl Arguments {
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        if (1..BOOTSTRAP_LEAST).contains(&self.fit.bootstrap) {
            let records = self.fit.bootstrap;
            return Err(Failure::bad_input(format_args!(
                "{records} records are too few for an interval: give --bootstrap at least {BOOTSTRAP_LEAST}"
            )));
        }
        if let Some(segments) = self.table.listed(&self.data)? {
            return output.summary(&segments);
        }
        let name = self.tissue_name()?;
        let mut place = PlaceOfFile::look(&self.file, "tissue")?;
        let question = self.question()?;
        question.check(self.data.len())?;
        let (mut all, mut names) = (Vec::new(), Vec::new());
        for (file, data) in self.data.iter().enumerate() {
            let name = data.file_name().unwrap_or(data.as_os_str());
            let read = self.table.read(file, data, &question)?;
            names.extend(read.iter().map(|_| name.to_string_lossy().into_owned()));
            all.extend(read);
        }
        let bar = progress_bar(u64::from(self.fit.bootstrap), output);
        let stop = AtomicBool::new(false);
        let answer = question.answer(all, &names, &stop, &|records| bar.inc(records as u64));
        bar.finish_and_clear();
        let RecordAnswer {
            understood,
            found,
            rows,
        } = answer.map_err(Failure::input)?;
        names.dedup();
        let source = names.join(", ");
        let (tissue, figure) = match name {
            Some(name) => {
                let date = StartTime::at(SystemTime::now()).day();
                let told = Provenance {
                    program: PROGRAM,
                    record: &source,
                    conditions: self.conditions.as_deref(),
                    date: &date,
                };
                let tissue = found.tissue(name, &understood, told);
                let text = tissue.map_err(Failure::input)?.to_toml();
                place.write(|| text, || draw::draw(&found, understood.loading, &source))
            }
            None => (None, None),
        };
        for warning in &found.warnings {
            output.warn(warning);
        }
        let fit = &found.fits[0];
        let notes = &understood.notes;
        let warnings: Vec<&String> = notes.iter().chain(&found.warnings).collect();
        let finite = |&x: &f64| Some(x).filter(|x| x.is_finite());
        let correlation = fit.correlation.iter();
        let correlation = correlation.map(|row| row.iter().map(finite).collect::<Vec<_>>());
        let candidates = found.fits.iter().map(|fit| {
            let parameters = json!({"parameters": estimates(&fit.parameters)});
            let model = json!({"model": fit.kind.name()});
            joined([model, quality(&found, fit), parameters])
        });
        let chosen = json!({
            "kind": found.kind.name(),
            "samples": found.samples,
            "loading": understood.loading,
            "model": fit.kind.name(),
            "parameters": estimates(fit.parameters.iter().chain(&found.beside)),
        });
        let beside = json!({
            "candidates": candidates.collect::<Vec<_>>(),
            "correlation": correlation.collect::<Vec<_>>(),
            "tissue": tissue,
            "figure": figure,
            // Notes on the reading of the record; `warnings` has them too.
            "notes": notes,
            "warnings": warnings,
        });
        output.summary(&joined([chosen, rows, quality(&found, fit), beside]))?;
        place.close(Ok(()))
    }

    fn question(&self) -> Result<RecordQuestion, Failure> {
        Ok(RecordQuestion {
            reading: self.specimen.reading(self.kind),
            options: Options {
                weighting: self.fit.weights,
                starts: self.fit.starts as usize,
                bootstrap: self.fit.bootstrap as usize,
                seed: self.fit.seed.unwrap_or(1),
                stiffening: self.fit.stiffening,
                baseline: self.fit.baseline,
                held: self.fit.fix.clone(),
                ..RecordQuestion::choosing(self.model)
            },
            several: self.several.several()?,
            temperatures_c: self.several.temperature.clone(),
            ..RecordQuestion::default()
        })
    }

    /// The name of the tissue, which is that of its file, if one is to be written.
    fn tissue_name(&self) -> Result<Option<&str>, Failure> {
        let Some(path) = self.file.out.as_deref() else {
            return Ok(None);
        };
        let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        let is_toml = path.extension().is_some_and(|end| end == "toml");
        let name = path.file_stem().and_then(|stem| stem.to_str());
        let name = name.filter(|name| is_toml && !name.is_empty() && name.chars().all(plain));
        name.map(Some).ok_or_else(|| {
            Failure::bad_input(format_args!(
                "`{}` cannot name a tissue: give --out lower-case letters and digits, as my-tissue.toml",
                path.display()
            ))
        })
    }
}

fn quality(found: &Identification, fit: &Fit) -> Value {
    let rms = match (found.is_absolute, found.kind) {
        (true, RecordKind::Creep) => json!({"rms_residual_per_pa": fit.rms}),
        (true, _) => json!({"rms_residual_pa": fit.rms}),
        (false, _) => json!({"rms_log_residual": fit.rms}),
    };
    joined([rms, json!({"aic": fit.aic, "bic": fit.bic})])
}
