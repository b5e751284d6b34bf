//! The report.

use haptic_tissue::identify::{Fit, Identification, RecordKind};
use serde::Serialize;
use serde::ser::{SerializeMap as _, Serializer};

/// Result of `identify`.
#[derive(Serialize)]
pub(super) struct Report<'a> {
    kind: &'static str,
    samples: usize,
    model: &'static str,
    parameters: Parameters<'a>,
    #[serde(flatten)]
    quality: Quality,
    candidates: Vec<CandidateReport<'a>>,
    correlation: Vec<Vec<Option<f64>>>,
    pub(super) tissue: Option<String>,
    pub(super) figure: Option<String>,
    /// How the record was read; `warnings` has it too.
    notes: &'a [String],
    warnings: Vec<String>,
}

#[derive(Serialize)]
struct CandidateReport<'a> {
    model: &'static str,
    #[serde(flatten)]
    quality: Quality,
    parameters: Parameters<'a>,
}

/// How well a model fits.
#[derive(Serialize)]
struct Quality {
    #[serde(skip_serializing_if = "Option::is_none")]
    rms_log_residual: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rms_residual_pa: Option<f64>,
    aic: f64,
    bic: f64,
}

impl Quality {
    fn of(kind: RecordKind, fit: &Fit) -> Self {
        let in_stress = kind == RecordKind::History;
        Self {
            rms_log_residual: (!in_stress).then_some(fit.rms),
            rms_residual_pa: in_stress.then_some(fit.rms),
            aic: fit.aic,
            bic: fit.bic,
        }
    }
}

/// Parameters by name.
struct Parameters<'a>(&'a Fit);

#[derive(Serialize)]
struct Parameter {
    value: f64,
    unit: &'static str,
    standard_error: Option<f64>,
    low_95: Option<f64>,
    high_95: Option<f64>,
}

impl Serialize for Parameters<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.parameters.len()))?;
        for estimate in &self.0.parameters {
            let parameter = Parameter {
                value: estimate.value,
                unit: if estimate.unit.is_empty() {
                    "1"
                } else {
                    estimate.unit
                },
                standard_error: estimate.standard_error,
                low_95: estimate.low_95,
                high_95: estimate.high_95,
            };
            map.serialize_entry(estimate.name, &parameter)?;
        }
        map.end()
    }
}

impl<'a> Report<'a> {
    pub(super) fn new(
        found: &'a Identification,
        notes: &'a [String],
        (tissue, figure): (Option<String>, Option<String>),
    ) -> Self {
        let fit = &found.fits[0];
        let finite = |row: &Vec<f64>| {
            row.iter()
                .map(|&x| Some(x).filter(|x| x.is_finite()))
                .collect()
        };
        let candidates = found.fits.iter().map(|fit| CandidateReport {
            model: fit.kind.name(),
            quality: Quality::of(found.kind, fit),
            parameters: Parameters(fit),
        });
        Self {
            kind: found.kind.name(),
            samples: found.samples,
            model: fit.kind.name(),
            parameters: Parameters(fit),
            quality: Quality::of(found.kind, fit),
            candidates: candidates.collect(),
            correlation: fit.correlation.iter().map(finite).collect(),
            tissue,
            figure,
            notes,
            warnings: notes.iter().chain(&found.warnings).cloned().collect(),
        }
    }
}
