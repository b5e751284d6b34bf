//! `design --wish coupler`: the stiffest coupler of each order.

use super::{Arguments, nothing_found};
use crate::files::Place;
use crate::output::Output;
use haptic_experiment::Failure;
use haptic_experiment::question::design::coupler::{
    CouplerAnswer, CouplerCandidate, CouplerDesign,
};
use serde::Serialize;
use std::io::{self, Write};

/// Result of `--wish coupler`.
#[derive(Serialize)]
struct CouplerReport {
    wish: &'static str,
    require: &'static str,
    scheme: String,
    frequency_hz: f64,
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
            wish: "coupler",
            require: design.criterion.name(),
            scheme: design.scheme.to_string(),
            frequency_hz: design.frequency_hz,
            answer: design.answer()?,
            experiment: None,
            files: Vec::new(),
        };
        let text = report.answer.experiment_text.as_deref();
        report.experiment = self.write_experiment(&mut place, text);
        let candidates = report.answer.candidates.iter();
        let table = place.write(|folder| folder.write_table("csv", candidates));
        report.files.extend(table);
        output.summary(&report, |out| report.print(out))?;
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

    /// As a person reads it.
    fn print(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "device: {}", self.answer.asked)?;
        writeln!(
            out,
            "{:>6} {:>16} {:>23} {:>18} {:>8} {:>12}",
            "order", "damper / N·s/m", "spring / N·s^(1−μ)/m", "felt / N/m", "share", "loop margin"
        )?;
        for c in &self.answer.candidates {
            print_candidate(out, c)?;
        }
        match &self.answer.best {
            Some(best) => writeln!(
                out,
                "best: order {}, as felt at {} Hz",
                best.order, self.frequency_hz
            )?,
            None => writeln!(out, "best: none")?,
        }
        match self.require {
            "passive" => writeln!(
                out,
                "passive in the sampled loop with every passive hand and object"
            )?,
            _ => writeln!(
                out,
                "passive by Llewellyn's criterion, whose device acts half a sample earlier than a real one; stable in the sampled loop \
                 with this device and hand"
            )?,
        }
        if let (Some(best), "llewellyn") = (&self.answer.best, self.require)
            && let Some(needed) = best.sampled_damping_n_s_per_m
        {
            writeln!(
                out,
                "for every hand and object the sampled device needs {needed:.4} N·s/m with the best: --require passive"
            )?;
        }
        if let Some(simulated) = &self.answer.simulated {
            writeln!(out, "tried: {}", simulated.verdict.words())?;
        }
        if let Some(experiment) = &self.experiment {
            writeln!(
                out,
                "written: {experiment} (try it: host-cli run {experiment})"
            )?;
        }
        self.files
            .iter()
            .try_for_each(|file| writeln!(out, "written: {file}"))
    }
}

/// Its line of the table.
fn print_candidate(out: &mut dyn Write, c: &CouplerCandidate) -> io::Result<()> {
    let (Some(k), Some(b), Some(felt)) = (c.stiffness, c.dissipation, c.felt_stiffness_n_per_m)
    else {
        let reason = c.reason.as_deref().unwrap_or("–");
        return writeln!(out, "{:>6} {reason}", c.order);
    };
    let margin = c
        .loop_margin
        .map_or_else(|| "any".to_owned(), |margin| format!("{margin:.3}"));
    writeln!(
        out,
        "{:>6} {k:>16.6} {b:>23.6} {felt:>18.6} {:>8.4} {margin:>12}",
        c.order,
        c.share.unwrap_or(f64::NAN)
    )
}
