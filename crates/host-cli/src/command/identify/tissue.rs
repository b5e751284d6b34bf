//! The tissue file, and its picture beside it.

use super::draw::draw;
use crate::files::{PlaceOfFile, overwrite_acts};
use clap::Args;
use haptic_experiment::Failure;
use haptic_log::record::StartTime;
use haptic_quantity::digits;
use haptic_tissue::identify::{Identification, RecordKind};
use haptic_tissue::{Material, Source, ValidRange};
use std::path::PathBuf;
use std::time::SystemTime;

/// Options of the tissue file.
#[derive(Debug, Args)]
#[command(next_help_heading = "Files")]
pub(super) struct TissueArguments {
    /// Tissue file to write, with a picture beside it
    #[arg(long, value_name = "FILE.toml")]
    out: Option<PathBuf>,
    /// Replace existing files
    #[arg(long)]
    overwrite: bool,
    /// Specimen, temperature, preparation, for the tissue file
    #[arg(long, value_name = "TEXT", requires = "out")]
    conditions: Option<String>,
}

/// A tissue file that is to be written.
pub(super) struct Planned<'a> {
    arguments: &'a TissueArguments,
    name: String,
    place: PlaceOfFile,
}

impl TissueArguments {
    /// Checks the name of the file before anything is fitted.
    ///
    /// # Errors
    /// A name that is no tissue's, a file that is there.
    pub(super) fn plan(&self) -> Result<Option<Planned<'_>>, Failure> {
        let Some(path) = self.out.as_deref() else {
            overwrite_acts(None, self.overwrite)?;
            return Ok(None);
        };
        let name = path
            .file_stem()
            .and_then(|stem| stem.to_str())
            .unwrap_or("");
        let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        let is_toml = path
            .extension()
            .is_some_and(|extension| extension == "toml");
        if !is_toml || name.is_empty() || !name.chars().all(plain) {
            return Err(Failure::bad_input(format_args!(
                "`{}` cannot name a tissue: give --out lower-case letters, digits and hyphens with .toml, as in my-tissue.toml",
                path.display()
            )));
        }
        Ok(Some(Planned {
            arguments: self,
            name: name.to_owned(),
            place: PlaceOfFile::look(self.out.as_deref(), self.overwrite, "tissue")?,
        }))
    }
}

impl Planned<'_> {
    /// Writes tissue and picture; names what was written.
    ///
    /// # Errors
    /// A fit that is no tissue.
    pub(super) fn write(
        &mut self,
        found: &Identification,
        source: &str,
    ) -> Result<(Option<String>, Option<String>), Failure> {
        let text = self.text(found, source)?;
        Ok(self.place.write(|| text, || draw(found, source)))
    }

    /// Tells what was not written, when all else was said.
    ///
    /// # Errors
    /// Data that was lost.
    pub(super) fn close(self) -> Result<(), Failure> {
        self.place.close(Ok(()))
    }

    /// The tissue file, with what it was made of.
    fn text(&self, found: &Identification, record: &str) -> Result<String, Failure> {
        let fit = &found.fits[0];
        if !fit.is_settled() {
            return Err(Failure::bad_input(format_args!(
                "the record does not determine the parameters of {}: give another --model or a longer record",
                fit.kind
            )));
        }
        let model = fit.to_model().map_err(|error| {
            Failure::input_with_advice(
                format_args!("the fit of {} is not a tissue: {error}", fit.kind),
                "give another --model",
            )
        })?;
        let (unit, of) = match found.kind {
            RecordKind::History => (" Pa", "stress"),
            RecordKind::Creep => ("", "log compliance"),
            _ => ("", "log modulus"),
        };
        let date = StartTime::at(SystemTime::now()).rfc3339();
        let source = Source {
            citation: format!(
                "fit by {} to the {} record {record}",
                concat!("host-cli ", env!("CARGO_PKG_VERSION")),
                found.kind.name()
            ),
            conditions: (self.arguments.conditions.clone())
                .unwrap_or_else(|| "not given".to_owned()),
            checked: false,
            date: date.split('T').next().unwrap_or_default().to_owned(),
            residual: format!(
                "rms {}{unit} in {of}, {} samples",
                digits(fit.rms, 4),
                found.samples
            ),
            ..Source::default()
        };
        let description = format!("identified from {record}");
        let material =
            Material::new(&self.name, &description, model, source).map_err(Failure::input)?;
        Ok(material.with_range(range(found)).to_toml())
    }
}

/// Where the record had samples.
fn range(found: &Identification) -> ValidRange {
    let ends = |values: &[f64]| {
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        (Some(low), Some(values.iter().copied().fold(low, f64::max)))
    };
    let (from, to) = ends(&found.x);
    let mut range = ValidRange::default();
    match found.kind {
        RecordKind::Oscillation => (range.omega_from_rad_s, range.omega_to_rad_s) = (from, to),
        // A motion begins somewhere on its clock; its length is what counts.
        RecordKind::History => range.time_to_s = to.zip(from).map(|(to, from)| to - from),
        _ => (range.time_from_s, range.time_to_s) = (from, to),
    }
    range
}
