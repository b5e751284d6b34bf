//! The tissue of a record: the best fit, the range in which it was measured, and where it comes from.

use super::assemble::Understood;
use super::candidates::Identification;
use super::error::IdentifyError;
use super::keys::MODEL;
use super::record::RecordKind;
use haptic_quantity::digits;
use haptic_tissue::{Material, Source, ValidRange};

/// Origin of a fitted tissue, for its file.
#[derive(Clone, Copy, Debug)]
pub struct Provenance<'a> {
    /// The program that fits, with its version.
    pub program: &'a str,
    /// The name of the record.
    pub record: &'a str,
    /// Specimen, temperature and preparation; `None` if not given.
    pub conditions: Option<&'a str>,
    /// The day of the fit, as 2026-11-26.
    pub date: &'a str,
}

impl Identification {
    /// The tissue of the chosen fit, under this name.
    ///
    /// # Errors
    /// A fit whose parameters the record does not determine, or that is no model; a name that is not made of lower-case
    /// letters, digits and hyphens.
    pub fn tissue(
        &self,
        name: &str,
        understood: &Understood,
        provenance: Provenance<'_>,
    ) -> Result<Material, IdentifyError> {
        let fit = &self.fits[0];
        if !fit.is_settled() {
            return Err(IdentifyError::Record(format!(
                "the record does not determine the parameters of {}: give another {MODEL}",
                fit.kind
            )));
        }
        let model = fit.to_model().map_err(|error| {
            IdentifyError::Record(format!(
                "the fit of {} is not a tissue: {error}: give another {MODEL}",
                fit.kind
            ))
        })?;
        let (what, unit, of) = match self.kind {
            RecordKind::History => ("motion", " Pa", "stress"),
            RecordKind::Creep if self.is_absolute => (self.kind.name(), " 1/Pa", "compliance"),
            RecordKind::Creep => (self.kind.name(), "", "log compliance"),
            RecordKind::Relaxation | RecordKind::Oscillation => {
                (self.kind.name(), "", "log modulus")
            }
        };
        let source = Source {
            citation: format!(
                "fit by {} to the {what} of {}",
                provenance.program, provenance.record
            ),
            conditions: provenance.conditions.unwrap_or("not given").to_owned(),
            checked: false,
            date: provenance.date.to_owned(),
            residual: format!(
                "rms {}{unit} in {of}, {} samples",
                digits(fit.rms, 4),
                self.samples
            ),
            ..Source::default()
        };
        let description = format!("the tissue of {}", provenance.record);
        let material = Material::new(name, &description, model, source)
            .map_err(|error| IdentifyError::Record(error.to_string()))?;
        let range = ValidRange {
            strain_to: understood.record.strain_to(),
            ..self.range()
        };
        let stiffening = fit.stiffening().map_or(0.0, |b| b.value);
        Ok(material
            .with_loading(understood.loading, stiffening)
            .with_range(range))
    }

    fn range(&self) -> ValidRange {
        let low = self.x.iter().copied().fold(f64::INFINITY, f64::min);
        let high = self.x.iter().copied().fold(low, f64::max);
        let (from, to) = (Some(low), Some(high));
        let mut range = ValidRange::default();
        match self.kind {
            RecordKind::Oscillation => (range.omega_from_rad_s, range.omega_to_rad_s) = (from, to),
            // A motion begins somewhere on its clock; its first step and its length are what it shows.
            RecordKind::History if self.is_timed => {
                let mut steps = self.x.windows(2).map(|pair| pair[1] - pair[0]);
                range.time_from_s = steps.find(|step| *step > 0.0);
                range.time_to_s = Some(high - low);
            }
            RecordKind::History => {}
            RecordKind::Relaxation | RecordKind::Creep => {
                (range.time_from_s, range.time_to_s) = (from, to);
            }
        }
        range
    }
}
