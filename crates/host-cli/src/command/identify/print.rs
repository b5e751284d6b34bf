//! The result for programs and for people.

use crate::output::short;
use haptic_tissue::identify::{Fit, Identification, RecordKind};
use serde::Serialize;
use serde::ser::{SerializeMap as _, Serializer};
use std::io::{self, Write};

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
        notes: &[String],
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
            warnings: notes.iter().chain(&found.warnings).cloned().collect(),
        }
    }
}

/// The result as a person reads it.
pub(super) fn print(
    out: &mut dyn Write,
    found: &Identification,
    notes: &[String],
    report: &Report<'_>,
) -> io::Result<()> {
    for said in notes {
        writeln!(out, "{said}")?;
    }
    let in_stress = found.kind == RecordKind::History;
    writeln!(out, "{}: {} samples", found.kind.name(), found.samples)?;
    let rms = if in_stress { "rms / Pa" } else { "rms of ln" };
    writeln!(
        out,
        "  {:<28} {:>10} {:>10} {:>12} {:>12}",
        "model", "parameters", rms, "AIC", "BIC"
    )?;
    for (n, fit) in found.fits.iter().enumerate() {
        writeln!(
            out,
            "{} {:<28} {:>10} {:>10} {:>12.1} {:>12.1}",
            if n == 0 { "*" } else { " " },
            fit.kind.name(),
            fit.parameters.len(),
            digits(fit.rms),
            fit.aic,
            fit.bic
        )?;
    }
    let fit = &found.fits[0];
    writeln!(out, "{}", fit.kind.name())?;
    writeln!(
        out,
        "  {:<28} {:>12} {:<8} {:>12}   95 % interval",
        "parameter", "value", "unit", "std. error"
    )?;
    for p in &fit.parameters {
        let of = |x: Option<f64>| x.map_or_else(|| "–".to_owned(), digits);
        writeln!(
            out,
            "  {:<28} {:>12} {:<8} {:>12}   {} to {}",
            p.name,
            digits(p.value),
            p.unit,
            of(p.standard_error),
            of(p.low_95),
            of(p.high_95)
        )?;
    }
    for file in [&report.tissue, &report.figure].into_iter().flatten() {
        writeln!(out, "written: {file}")?;
    }
    Ok(())
}

/// Five digits, without an exponent where few are needed.
pub(super) fn digits(value: f64) -> String {
    let rounded: f64 = format!("{value:.4e}").parse().unwrap_or(value);
    short(rounded)
}
