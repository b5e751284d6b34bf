//! A tissue from a record that was dropped on the page: the same reading and the same fits as on the command line.

use crate::file_name;
use haptic_experiment::Failure;
use haptic_experiment::question::tissue::{RecordAnswer, RecordForm, RecordQuestion};
use haptic_log::record::StartTime;
use haptic_tissue::identify::{Fit, Provenance};
use serde::Deserialize;
use serde_json::{Map, Value, json};
use std::fmt::Display;
use std::sync::atomic::AtomicBool;
use std::time::SystemTime;

/// Points of a curve that is sent, at most.
const POINTS: usize = 2000;

/// A record, and what its table does not say.
#[derive(Clone, Debug, Deserialize)]
#[serde(try_from = "Map<String, Value>")]
pub(crate) struct IdentifyRequest {
    name: String,
    /// The table: CSV or TSV.
    text: String,
    form: RecordForm,
}

impl TryFrom<Map<String, Value>> for IdentifyRequest {
    type Error = serde_json::Error;

    fn try_from(mut fields: Map<String, Value>) -> Result<Self, Self::Error> {
        let [name, text] = ["name", "text"].map(|key| fields.remove(key));
        Ok(Self {
            name: name.map_or_else(|| Ok(String::new()), file_name)?,
            text: text.map_or_else(|| Ok(String::new()), String::deserialize)?,
            form: serde_json::from_value(Value::Object(fields))?,
        })
    }
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
    let question = RecordQuestion::of(&request.form)?;
    question.check(1)?;
    let records = question.read(0, question.reader.clone(), request.text.as_bytes());
    let records = records.map_err(|error| refused(&error))?;
    let names = vec![name.to_owned(); records.len()];
    let found = question.answer(records, &names, stop, &|_| {});
    let found = found.map_err(|error| refused(&error))?;
    let date = StartTime::at(SystemTime::now()).day();
    let told = Provenance {
        program,
        record: name,
        conditions: None,
        date: &date,
    };
    let name = tissue_name(&request.name);
    let tissue = found.found.tissue(&name, &found.understood, told);
    let mut answer = answer(&found);
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

fn answer(answer: &RecordAnswer) -> Value {
    let RecordAnswer {
        understood,
        found,
        rows,
    } = answer;
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
        "several": rows,
    })
}
