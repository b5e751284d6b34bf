//! `identify`: a tissue from a measured record.

mod draw;
mod record;

use crate::command::conduct::progress_bar;
use crate::files::{File, PROGRAM, PlaceOfFile};
use crate::options::{Options, keys};
use crate::output::Output;
use clap::Args;
use haptic_experiment::Failure;
use haptic_log::record::StartTime;
use haptic_question::tissue::{RecordForm, RecordQuestion};
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::time::SystemTime;
use tissue_identification::Provenance;

/// Turn a measured record into a tissue: relaxation, creep, oscillation or any motion
///
/// Fits fractional models, reports how certain each parameter is and which model the record
/// supports, and writes a tissue file for relax --tissue.
///
/// DATA is CSV, TSV or XLSX with a header, or a log (*.mcap); of a log that somebody else wrote --columns
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
    /// CSV, TSV or XLSX with a header, or a log (*.mcap); several motions of one tissue are fitted together
    #[arg(value_name = "DATA", required = true)]
    data: Vec<PathBuf>,
    /// List the segments of the file, and fit nothing
    #[arg(long, conflicts_with_all = ["segment", "out"], help_heading = "Table")]
    segments: bool,
    /// Tell what each column is taken for and what else it could be, and fit nothing
    #[arg(long, conflicts_with_all = ["segments", "out"], help_heading = "Table")]
    explain: bool,
    #[command(flatten)]
    asked: Options<keys::Record>,
    #[command(flatten)]
    file: File,
    /// Specimen, temperature, preparation, for the tissue file
    #[arg(long, value_name = "TEXT", requires = "out", help_heading = "Files")]
    conditions: Option<String>,
}

impl Arguments {
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        let form: RecordForm = self.asked.clone().form()?;
        let question = RecordQuestion::of(&form)?;
        if self.segments {
            return output.report(&record::segments(&question, &self.data)?);
        }
        if self.explain {
            return output.report(&record::explained(&question, &self.data)?);
        }
        let name = self.tissue_name()?;
        let mut place = PlaceOfFile::look(&self.file, "tissue")?;
        question.check(self.data.len())?;
        let (mut all, mut names) = (Vec::new(), Vec::new());
        for (file, data) in self.data.iter().enumerate() {
            let name = data.file_name().unwrap_or(data.as_os_str());
            let read = record::read(&question, file, data)?;
            names.extend(read.iter().map(|_| name.to_string_lossy().into_owned()));
            all.extend(read);
        }
        let bar = progress_bar(form.bootstrap.unwrap_or_default(), output);
        let stop = AtomicBool::new(false);
        let answer = question.answer(all, &names, &stop, &|records| bar.inc(records as u64));
        bar.finish_and_clear();
        let answer = answer.map_err(Failure::input)?;
        let (found, understood) = (&answer.found, &answer.understood);
        names.dedup();
        let source = names.join(", ");
        let (tissue, figure) = match name {
            Some(name) => {
                let date = StartTime::at(SystemTime::now()).day();
                let provenance = Provenance {
                    program: PROGRAM,
                    record: &source,
                    conditions: self.conditions.as_deref(),
                    date: &date,
                };
                let tissue = found.tissue(name, understood, provenance);
                let text = tissue.map_err(Failure::input)?.to_toml();
                let is_asked = question.options.chosen.is_some();
                place.write(
                    || text,
                    || draw::draw(found, is_asked, understood.loading, &source),
                )
            }
            None => (None, None),
        };
        for warning in &found.warnings {
            output.warn(warning);
        }
        output.report(&answer.report(tissue, figure))?;
        place.close(Ok(()))
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
