//! A tissue from a record that was dropped on the page: the same reading and the same fits as on the command line.

use crate::file_name;
use haptic_experiment::Failure;
use haptic_experiment::document::short;
use haptic_log::record::StartTime;
use haptic_loop::{Loading, LoadingKind};
use haptic_tissue::identify::table::{Column, Reader, Reading, Understood, read_table};
use haptic_tissue::identify::{
    CANDIDATES, Fit, Identification, Options, Provenance, identify_unless,
};
use serde::Deserialize;
use serde_json::{Value, json};
use std::fmt::Display;
use std::sync::atomic::AtomicBool;
use std::time::SystemTime;

/// Points of a curve that is sent, at most.
const POINTS: usize = 2000;

/// A record, and what a table does not say.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct IdentifyRequest {
    #[serde(deserialize_with = "file_name")]
    name: String,
    /// The table: CSV or TSV.
    text: String,
    /// As `--columns` and `--units`: `time=1,modulus=3`.
    columns: String,
    units: String,
    strain: Option<f64>,
    stress_pa: Option<f64>,
    area_m2: Option<f64>,
    thickness_m: Option<f64>,
    loading: Option<String>,
    indenter_radius_m: Option<f64>,
    half_angle_rad: Option<f64>,
    bonded: bool,
    poisson_ratio: Option<f64>,
    stiffening: bool,
    model: Option<String>,
}

/// The parts of a list such as `time=1,modulus=3`.
fn parts<T>(key: &str, text: &str, read: fn(&str) -> Result<T, String>) -> Result<Vec<T>, Failure> {
    let parts = text
        .split(',')
        .map(str::trim)
        .filter(|part| !part.is_empty());
    let refused =
        |part: &str, why| Failure::bad_input(format_args!("`{key}`: \"{}\" {why}", short(part)));
    parts
        .map(|part| read(part).map_err(|why| refused(part, why)))
        .collect()
}

/// The answer to a record; a tissue that is made of it says that `program` did.
pub(crate) fn identified(
    request: &IdentifyRequest,
    program: &str,
    stop: &AtomicBool,
) -> Result<Value, Failure> {
    let name = match request.name.as_str() {
        "" => "the record",
        name => name,
    };
    let refused = |error: &dyn Display| Failure::bad_input(format_args!("{name}: {error}"));
    let loading = named("loading", request.loading.as_ref(), &LoadingKind::ALL)?;
    let models = CANDIDATES.map(|kind| (kind, kind.name()));
    let chosen = named("model", request.model.as_ref(), &models)?;
    let reading = Reading {
        strain: request.strain,
        stress_pa: request.stress_pa,
        loading: Loading {
            kind: loading.unwrap_or(LoadingKind::Compression),
            area_m2: request.area_m2,
            thickness_m: request.thickness_m,
            radius_m: request.indenter_radius_m,
            half_angle_rad: request.half_angle_rad,
            bonded: request.bonded,
        },
        loading_is_told: loading.is_some(),
        poisson_ratio: request.poisson_ratio,
        ..Reading::default()
    };
    let reader = Reader {
        columns: parts("columns", &request.columns, Column::chosen)?,
        units: parts("units", &request.units, Column::with_unit)?,
        ..Reader::default()
    };
    let table = read_table(request.text.as_bytes());
    let understood = table
        .and_then(|table| reader.read(table)?.record(&reading))
        .map_err(|error| refused(&error))?;
    let options = Options {
        candidates: chosen.map_or_else(|| CANDIDATES.to_vec(), |kind| vec![kind]),
        chosen,
        stiffening: request.stiffening,
        ..Options::default()
    };
    let found = identify_unless(&understood.record, &options, stop, &|_| {});
    let found = found.map_err(|error| refused(&error))?;
    let date = StartTime::at(SystemTime::now()).day();
    let told = Provenance {
        program,
        record: name,
        conditions: None,
        date: &date,
    };
    let tissue = found.tissue(&tissue_name(&request.name), &understood, told);
    let mut answer = answer(&found, &understood);
    answer["tissue_reason"] = json!(tissue.as_ref().err().map(ToString::to_string));
    answer["tissue"] = json!(
        tissue
            .ok()
            .map(|of| json!({"name": of.name, "text": of.text}))
    );
    Ok(answer)
}

/// A name for the tissue of a file: lower-case letters, digits and hyphens.
fn tissue_name(file: &str) -> String {
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
    let name: String = stem.to_lowercase().chars().map(plain).collect();
    let name = name.trim_matches('-');
    if name.is_empty() { "tissue" } else { name }.to_owned()
}

fn named<T: Copy>(
    key: &str,
    wanted: Option<&String>,
    known: &[(T, &str)],
) -> Result<Option<T>, Failure> {
    let Some(wanted) = wanted else {
        return Ok(None);
    };
    let found = known.iter().find(|one| one.1 == wanted);
    found.map(|one| Some(one.0)).ok_or_else(|| {
        let names: Vec<&str> = known.iter().map(|one| one.1).collect();
        let names = names.join(", ");
        Failure::bad_input(format_args!("`{key}` {wanted:?} is not one of {names}"))
    })
}

fn answer(found: &Identification, understood: &Understood) -> Value {
    // Evenly thinned: a curve of the page has no more pixels.
    let every = found.x.len().div_ceil(POINTS).max(1);
    let thinned =
        |numbers: &[f64]| -> Vec<f64> { numbers.iter().copied().step_by(every).collect() };
    let model = |fit: &Fit| {
        json!({
            "model": fit.kind.name(),
            "parameters": fit.parameters,
            "rms": fit.rms,
            "aic": fit.aic,
            "bic": fit.bic,
            "predicted": thinned(&fit.predicted),
        })
    };
    json!({
        "kind": found.kind.name(),
        "samples": found.samples,
        "best": found.fits.first().map(|fit| fit.kind.name()),
        "models": found.fits.iter().map(model).collect::<Vec<_>>(),
        "x": thinned(&found.x),
        "measured": thinned(&found.measured),
        "loading": understood.loading,
        "notes": understood.notes,
        "warnings": found.warnings,
    })
}
