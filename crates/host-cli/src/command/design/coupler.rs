//! `design --wish coupler`: the stiffest passive coupler of each order.

use super::Arguments;
use crate::files::folder;
use crate::output::Output;
use fracdiff::Seconds;
use haptic_analysis::{AnalysisError, LoopOperator};
use haptic_experiment::design::coupler::{CouplerCandidate, stiffest_coupler};
use haptic_experiment::failure::Failure;
use serde::Serialize;
use std::io::{self, Write};

/// Result of `--wish coupler`.
#[derive(Serialize)]
struct CouplerReport {
    wish: &'static str,
    require: &'static str,
    scheme: String,
    frequency_hz: f64,
    candidates: Vec<CouplerCandidate>,
    best: Option<CouplerCandidate>,
    /// No experiment renders a coupler yet.
    experiment: Option<String>,
    files: Vec<String>,
}

impl Arguments {
    /// The stiffest coupler of each order.
    pub(super) fn coupler(&self, output: Output) -> Result<(), Failure> {
        let frequency_hz = self.frequency.map_or(1.0, |frequency| frequency.0);
        if frequency_hz <= 0.0 {
            return Err(Failure::bad_input(format_args!(
                "frequency {frequency_hz} Hz is not above 0 Hz: give --frequency, as in 1Hz"
            )));
        }
        let delayed = self.delay_samples.is_some_and(|samples| samples > 0);
        let device = self.device.ideal();
        if self.gain_margin.is_some()
            || self.force_noise_limit.is_some()
            || delayed
            || self.device.limits_the_force()
            || self.device.is_less_than_ideal()
        {
            return Err(Failure::bad_input(
                "a coupler is judged passive on an ideal device: leave out --gain-margin, --force-limit, \
                 --force-noise-limit, --delay-samples, --delay, --current-lag, --friction, --encoder-resolution, --sensor-noise and --realistic",
            ));
        }
        let (b, t) = (device.damping.0, device.sample_time.0);
        let candidates = self
            .orders()?
            .into_iter()
            .map(|order| {
                let operator = LoopOperator::new(self.scheme, order, Seconds(t), 1e6)?;
                stiffest_coupler(&operator, b, t, frequency_hz)
            })
            .map(|candidate: Result<_, AnalysisError>| candidate.map_err(Failure::input))
            .collect::<Result<Vec<_>, _>>()?;
        let felt = |c: &CouplerCandidate| c.felt_stiffness_n_per_m.unwrap_or(0.0);
        let best = candidates
            .iter()
            .filter(|c| c.dissipation.is_some())
            .max_by(|a, b| felt(a).total_cmp(&felt(b)))
            .cloned();
        let mut report = CouplerReport {
            wish: "coupler",
            require: "passive",
            scheme: self.scheme.to_string(),
            frequency_hz,
            candidates,
            best,
            experiment: None,
            files: Vec::new(),
        };
        if let Some(out) = &self.out {
            let request = folder(Some(out.clone()), "design", self.overwrite);
            let table = request
                .prepare()?
                .write_table("csv", report.candidates.iter())?;
            report.files.push(table);
        }
        output.summary(&report, |out| print(out, &report))
    }
}

/// The result as a person reads it.
fn print(out: &mut dyn Write, report: &CouplerReport) -> io::Result<()> {
    writeln!(
        out,
        "{:>6} {:>16} {:>20} {:>18}",
        "order", "k_c / N·s/m", "b_c / N·s^(1−μ)/m", "felt / N/m"
    )?;
    for c in &report.candidates {
        match (
            c.stiffness,
            c.dissipation,
            c.felt_stiffness_n_per_m,
            &c.reason,
        ) {
            (Some(k), Some(b), Some(felt), _) => {
                writeln!(out, "{:>6} {k:>16.6} {b:>20.6} {felt:>18.6}", c.order)?;
            }
            (_, _, _, Some(reason)) => writeln!(out, "{:>6} {reason}", c.order)?,
            _ => {}
        }
    }
    match &report.best {
        Some(best) => writeln!(
            out,
            "best: order {}, as felt at {} Hz",
            best.order, report.frequency_hz
        )?,
        None => writeln!(out, "best: none")?,
    }
    writeln!(
        out,
        "passive by Llewellyn's criterion; no experiment renders a coupler yet"
    )?;
    report
        .files
        .iter()
        .try_for_each(|file| writeln!(out, "written: {file}"))
}
