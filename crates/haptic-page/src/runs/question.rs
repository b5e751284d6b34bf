//! A question from a form, a Z-width or a design: read as the command reads it, answered into a folder.
//! ```text
//! form ─▶ question ─▶ zwidth-0001/  zwidth.answer.json   what the page shows
//!                                   zwidth.csv           the same as a table
//!                     design-0001/  design.toml          the experiment that tries the proposal
//! ```

use super::form::{document, simulated};
use super::going::{Attendant, Finished, Work};
use super::list::ANSWER;
use crate::folder::next_folder;
use haptic_answer::dropped::of_file;
use haptic_experiment::Failure;
use haptic_experiment::question::Question;
use haptic_run::{OutputFolder, write_text};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

/// A form, to be answered in the next free folder of the runs.
pub(super) fn work(
    kind: &str,
    parameters: &Map<String, Value>,
    runs: &Path,
    provenance: &BTreeMap<String, String>,
) -> Result<Work, Failure> {
    let document = document(kind, parameters)?;
    let question = Question::open(&document)?;
    simulated(question.is_simulated())?;
    let (request, name) = next_folder(runs, kind, provenance)?;
    let (kind, program) = (kind.to_owned(), provenance.get("program").cloned());
    Ok(Work {
        kind: kind.clone(),
        name,
        steps: question.steps(),
        drawn: None,
        run: Box::new(move |attendant| {
            let folder = request.prepare()?;
            let result = written(&question, &kind, program, attendant, &folder);
            result.inspect_err(|_| folder.discard())
        }),
    })
}

/// Answers a question, and writes the answer.
fn written(
    question: &Question,
    kind: &str,
    program: Option<String>,
    attendant: Attendant<'_>,
    folder: &OutputFolder,
) -> Result<Finished, Failure> {
    let done = AtomicU64::new(0);
    let progress = |steps: u64| {
        let before = done.fetch_add(steps, Ordering::Relaxed);
        (attendant.progress)(before + steps);
    };
    let answer = question.answer(&progress, attendant.stop, attendant.warn)?;
    answer.write_table(folder)?;
    let report = json!(answer);
    let verdict = match answer.require(attendant.warn) {
        Ok(()) => answer.verdict(),
        // With the remedy, as the command fails.
        Err(nothing_found) => nothing_found.to_string(),
    };
    let ended_early = report["ended_early"].as_str().map(str::to_owned);
    // The experiment file of a proposal.
    let experiment = match answer.experiment_text() {
        Some(text) => {
            write_text(&folder.file("toml"), text, false)?;
            of_file(text)
        }
        None => Value::Null,
    };
    let shown = json!({
        "kind": kind,
        "verdict": verdict,
        "program": program,
        "report": report,
        "experiment": experiment,
    });
    write_text(&folder.file(ANSWER), &shown.to_string(), false)?;
    Ok(Finished {
        report,
        curves: Value::Null,
        verdict: Some(verdict),
        ended_early,
    })
}
