//! `design --wish coupler`: the stiffest coupler of each order.

use super::{Arguments, nothing_found};
use crate::files::Place;
use crate::output::Output;
use haptic_experiment::Failure;
use haptic_experiment::question::design::coupler::{CouplerAnswer, CouplerDesign};
use serde::Serialize;
use std::sync::atomic::AtomicBool;

/// Result of `--wish coupler`.
#[derive(Serialize)]
struct CouplerReport {
    #[serde(flatten)]
    answer: CouplerAnswer,
    /// The experiment that was written.
    experiment: Option<String>,
    files: Vec<String>,
}

impl Arguments {
    /// The stiffest coupler of each order.
    pub(super) fn coupler(
        &self,
        design: &CouplerDesign,
        mut place: Place,
        output: Output,
    ) -> Result<(), Failure> {
        let mut report = CouplerReport {
            answer: design.answer(&AtomicBool::new(false), &|_| {})?,
            experiment: None,
            files: Vec::new(),
        };
        let text = report.answer.experiment_text.as_deref();
        report.experiment = self.write_experiment(&mut place, text);
        let candidates = report.answer.candidates.iter();
        let table = place.write(|folder| folder.write_table("csv", candidates));
        report.files.extend(table);
        output.summary(&report)?;
        place.close(report.ended())
    }
}

impl CouplerReport {
    /// A best coupler that came to rest when it was tried.
    fn ended(&self) -> Result<(), Failure> {
        let CouplerAnswer {
            candidates,
            best,
            simulated,
            ..
        } = &self.answer;
        match (best, simulated) {
            (None, _) => {
                let reasons = candidates.iter().find_map(|c| c.reason.as_deref());
                Err(nothing_found(reasons.unwrap_or("nothing does it")))
            }
            (Some(best), Some(simulated)) if !simulated.stable => {
                Err(Failure::Run(anyhow::anyhow!(
                    "the best candidate, order {}, is {} when it is tried: {}; take a device with more damping, or other --orders",
                    best.order,
                    simulated.verdict.words(),
                    simulated.reason().unwrap_or_default()
                )))
            }
            _ => Ok(()),
        }
    }
}
