//! A tissue or a plant from records that were dropped on the page, read and fitted as on the command line.

use crate::form::Asker;
use crate::words::{TextFile, file_name, form};
use haptic_document::{Failure, lines};
use haptic_question::plant::keys::PlantForm;
use haptic_question::plant::{PlantFound, PlantQuestion};
use haptic_question::tissue::{RecordAnswer, RecordQuestion};
use serde::Deserialize;
use serde_json::{Map, Value, json};
use std::fmt::Display;
use tissue_identification::Provenance;

/// Points of a curve that is sent, at most.
const POINTS: usize = 2000;

/// Records, and keys for what their tables do not say.
#[derive(Clone, Debug, Deserialize)]
pub struct RecordRequest {
    #[serde(default = "unnamed", deserialize_with = "file_name")]
    name: String,
    #[serde(default)]
    text: String,
    #[serde(default)]
    more: Vec<TextFile>,
    #[serde(flatten)]
    form: Map<String, Value>,
}

fn unnamed() -> String {
    "the record".to_owned()
}

impl RecordRequest {
    /// The records of each file, which is read with its number, and the name of the file.
    fn read<T, E: Display>(
        &self,
        mut read: impl FnMut(usize, &[u8]) -> Result<T, E>,
    ) -> Result<Vec<(T, &str)>, Failure> {
        let first = (&self.name, &self.text);
        let files =
            std::iter::once(first).chain(self.more.iter().map(|one| (&one.name, &one.text)));
        let records = files.enumerate().map(|(n, (name, text))| {
            let record = read(n, text.as_bytes()).map(|record| (record, name.as_str()));
            record.map_err(|error| Failure::bad_input(format_args!("{name}: {error}")))
        });
        records.collect()
    }
}

/// The answer to records; a tissue that is made of them says that the program of the asker did.
///
/// # Errors
/// Tables or keys that are wrong; nothing that fits.
pub fn identified(request: &RecordRequest, asker: &Asker<'_>) -> Result<Value, Failure> {
    let question = RecordQuestion::of(&form(&request.form)?)?;
    question.check(1 + request.more.len())?;
    let read = |n, bytes: &[u8]| question.read(n, question.reader.clone(), bytes);
    let (mut records, mut names) = (Vec::new(), Vec::new());
    for (all, name) in request.read(read)? {
        names.extend(all.iter().map(|_| name.to_owned()));
        records.extend(all);
    }
    let found = question.answer(records, &names, asker.given_up, &|_| {});
    names.dedup();
    let source = names.join(", ");
    let found = found.map_err(|error| Failure::bad_input(format_args!("{source}: {error}")))?;
    let provenance = Provenance {
        program: asker.program,
        record: &source,
        conditions: None,
        date: &asker.day,
    };
    let name = tissue_name(&request.name);
    let tissue = found.found.tissue(&name, &found.understood, provenance);
    let mut answer = answer(&found);
    answer["tissue_reason"] = json!(tissue.as_ref().err().map(ToString::to_string));
    answer["tissue"] = json!(
        tissue
            .ok()
            .map(|record| json!({"name": record.name, "text": record.text}))
    );
    Ok(answer)
}

/// The columns of tables as they are read, in lines, whether or not they make a record.
///
/// # Errors
/// Keys that are wrong.
pub fn explained(request: &RecordRequest) -> Result<Value, Failure> {
    let question = RecordQuestion::of(&form(&request.form)?)?;
    let read = request.read(|n, bytes| question.explained(n, &question.reader, bytes))?;
    let read = read
        .into_iter()
        .map(|(rows, name)| json!({"name": name, "lines": lines(&rows)}));
    Ok(json!({"read": read.collect::<Vec<_>>()}))
}

/// The plant in a record, tried on a second one; its file says that the program of the asker made it.
///
/// # Errors
/// Tables or keys that are wrong; nothing that fits.
pub fn plant(request: &RecordRequest, asker: &Asker<'_>) -> Result<Value, Failure> {
    let form: PlantForm = form(&request.form)?;
    let question = PlantQuestion::of(&form)?;
    let read = |_, bytes: &[u8]| question.data(&question.columns, bytes);
    let records = request.read(read)?.into_iter();
    let mut records = records.map(|(record, _)| record);
    let (Some(record), other, None, "") = (
        records.next(),
        records.next(),
        records.next(),
        &*form.validate,
    ) else {
        return Err(Failure::bad_input("give one record to try the function on"));
    };
    let found = question.found(record, other, asker.given_up, &|_, _, _| {})?;
    let mut answer = json!(found.report());
    let curves = match &found {
        PlantFound::Record(found) => {
            [&found.record.time_s, &found.record.output, found.model()].map(<[f64]>::to_vec)
        }
        PlantFound::Response(found) => {
            let sizes = found.points.iter().map(|point| point.1.norm());
            let omegas = found.points.iter().map(|point| point.0);
            let model = found.model().iter().map(|g| g.norm());
            [omegas.collect(), sizes.collect(), model.collect()]
        }
    };
    for (key, curve) in ["x", "measured", "predicted"].into_iter().zip(curves) {
        answer[key] = json!(thinned(&curve, curve.len()));
    }
    answer["file"] =
        json!({"name": "plant.toml", "text": found.to_toml(asker.program, &request.name)});
    Ok(answer)
}

/// One in so many of the numbers, evenly: a curve of the page has no more pixels.
fn thinned(numbers: &[f64], count: usize) -> Vec<f64> {
    let every = count.div_ceil(POINTS).max(1);
    numbers.iter().copied().step_by(every).collect()
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
    let found = &answer.found;
    let thinned = |numbers: &[f64]| thinned(numbers, found.x.len());
    let predicted = found.fits.iter().map(|fit| thinned(&fit.predicted));
    let report = answer.report(None, None);
    json!({
        "lines": lines(&report),
        "report": report,
        // Of each candidate.
        "predicted": predicted.collect::<Vec<_>>(),
        "x": thinned(&found.x),
        "measured": thinned(&found.measured),
    })
}
