//! What all experiments share: how a run is conducted, kept and judged.

use super::conduct::conduct;
use super::live::LiveArguments;
use super::realtime::RealtimeArguments;
use super::words::roll_bytes;
use crate::files::{folder, overwrite_acts};
use crate::output::Output;
use crate::picture::{of_teleoperation, of_theory, of_touch, of_trial};
use crate::within::within;
use clap::Args;
use haptic_experiment::document::Document;
use haptic_experiment::experiment::TouchVerdict;
use haptic_experiment::experiment::teleoperation::TeleoperationVerdict;
use haptic_experiment::parameters::range;
use haptic_experiment::run::{FolderRequest, write_text};
use haptic_experiment::{
    CouplerExperiment, CouplerReport, ExperimentFile, Failure, Pace, TeleoperationExperiment,
    TeleoperationReport, TouchExperiment, TouchReport, WallExperiment, WallReport,
};
use haptic_quantity::{Bytes, Time};
use std::fmt;
use std::path::PathBuf;
use std::time::Duration;

/// How a run is conducted and kept.
#[derive(Debug, Args)]
pub struct RunArguments {
    #[command(flatten)]
    realtime: RealtimeArguments,
    /// Run even if the analysis says unstable
    #[arg(long, hide_short_help = true, help_heading = "Run")]
    force_unstable: bool,
    /// Time to wait for a serial device to appear [default: 0s]
    #[arg(long, hide_short_help = true, help_heading = "Run", value_parser = within::<Time>(range::WAITS), value_name = "TIME", allow_hyphen_values = true)]
    wait: Option<Time>,
    #[command(flatten)]
    live: LiveArguments,
    /// Folder for log, CSV and pictures [default: the next free results/NAME-0001]
    #[arg(long, value_name = "DIR", help_heading = "Run")]
    out: Option<PathBuf>,
    /// Replace the files of an earlier run
    #[arg(long, help_heading = "Run")]
    overwrite: bool,
    /// Start another log file at this size, as in 1GB
    #[arg(
        long,
        value_name = "SIZE",
        allow_hyphen_values = true,
        hide_short_help = true,
        help_heading = "Run"
    )]
    roll: Option<Bytes>,
    /// Write the experiment to a file instead of running it
    #[arg(long, value_name = "FILE.toml", conflicts_with_all = ["out", "roll"], hide_short_help = true, help_heading = "Run")]
    write: Option<PathBuf>,
}

impl RunArguments {
    /// Runs an experiment in its folder with a progress bar, stoppable by Ctrl-C, and reports.
    ///
    /// # Errors
    /// A document that is wrong; what went wrong in the run, with its exit code.
    pub fn run(self, document: &Document, output: Output) -> Result<(), Failure> {
        let (experiment, pace) = self.experiment(document)?;
        let samples = experiment.samples()?;
        if let Some(file) = &self.write {
            let text = document.to_toml().map_err(Failure::input)?;
            return write_text(file, &text, self.overwrite);
        }
        overwrite_acts(self.out.as_deref(), self.overwrite)?;
        let stem = document.kind().map_err(Failure::input)?;
        let mut request = FolderRequest {
            roll_bytes: roll_bytes(self.roll)?,
            ..folder(self.out, stem, self.overwrite)
        };
        document
            .keep_in(&mut request.provenance)
            .map_err(Failure::input)?;
        let request = &request;
        let live = &self.live.open(pace != Pace::Virtual, output)?;
        match experiment {
            ExperimentFile::Relax(relaxation) => {
                conduct(samples, output, of_theory, |supervisor| {
                    relaxation.run(request, supervisor.watched(live))
                })?;
                Ok(())
            }
            ExperimentFile::Creep(creep) => {
                conduct(samples, output, of_theory, |supervisor| {
                    creep.run(request, supervisor.watched(live))
                })?;
                Ok(())
            }
            ExperimentFile::Wall(wall) => {
                let report = conduct(
                    samples,
                    output,
                    |report: &WallReport, curves| of_trial(&report.trial, curves),
                    |supervisor| wall.run(request, supervisor.watched(live)),
                )?;
                wall_held(&wall, &report)
            }
            ExperimentFile::Coupler(coupler) => {
                let report = conduct(
                    samples,
                    output,
                    |report: &CouplerReport, curves| of_trial(&report.trial, curves),
                    |supervisor| coupler.run(request, supervisor.watched(live)),
                )?;
                coupler_held(&coupler, &report)
            }
            ExperimentFile::Teleoperation(far) => {
                let report = conduct(samples, output, of_teleoperation, |supervisor| {
                    far.run(request, supervisor.watched(live))
                })?;
                line_was_passive(&far, &report)
            }
            ExperimentFile::Touch(touch) => {
                let report = conduct(samples, output, of_touch, |supervisor| {
                    touch.run(request, supervisor.watched(live))
                })?;
                shape_was_passive(&touch, &report)
            }
        }
    }

    /// The experiment as it is to be conducted, and its pace.
    ///
    /// # Errors
    /// A document that is wrong; options that do not fit it.
    fn experiment(&self, document: &Document) -> Result<(ExperimentFile, Pace), Failure> {
        let mut experiment = ExperimentFile::open(document).map_err(Failure::input)?;
        let real = experiment.remote().is_some();
        if let Some(wait) = self.wait {
            if !real {
                return Err(Failure::bad_input(
                    "--wait has no effect on the simulated device: give --device serial:PATH too, or omit it",
                ));
            }
            experiment = experiment.with_patience(Duration::from_secs_f64(wait.0));
        }
        if self.force_unstable {
            experiment = experiment.though_unstable()?;
        }
        let pace = self.realtime.pace(real)?;
        Ok((experiment.in_pace(pace), pace))
    }
}

/// Refuses a wall that is not stable, if its file wants it to be.
fn wall_held(wall: &WallExperiment, report: &WallReport) -> Result<(), Failure> {
    let trial = &report.trial;
    if !wall.setup.must_be_stable || trial.stable_by_both() {
        return Ok(());
    }
    let words = trial.settling.verdict.words();
    Err(unstable(format_args!(
        "the wall is not stable by both trial ({words}) and analysis"
    )))
}

/// Refuses a coupler that is not stable and passed, if its file wants it to be.
fn coupler_held(coupler: &CouplerExperiment, report: &CouplerReport) -> Result<(), Failure> {
    if !coupler.setup.must_be_stable || report.stable_by_all() {
        return Ok(());
    }
    let words = report.trial.settling.verdict.words();
    Err(unstable(format_args!(
        "the coupler is not stable by trial ({words}) and analysis and passed by Llewellyn's criterion"
    )))
}

fn unstable(what: fmt::Arguments<'_>) -> Failure {
    Failure::Run(anyhow::anyhow!(
        "must_be_stable: {what}: design a weaker one, or take must_be_stable out of the file to run it all the same"
    ))
}

/// Refuses a line that was not passive, if its file wants it to be.
fn line_was_passive(
    far: &TeleoperationExperiment,
    report: &TeleoperationReport,
) -> Result<(), Failure> {
    if !far.must_be_passive || report.verdict == TeleoperationVerdict::Passive {
        return Ok(());
    }
    Err(Failure::Run(anyhow::anyhow!(
        "must_be_passive: {}: take a passive architecture, a softer coupler or a smaller motion, or take \
         must_be_passive out of the file to run it all the same",
        report.verdict.words()
    )))
}

/// Refuses a shape that was not passive, if its file wants it to be.
fn shape_was_passive(touch: &TouchExperiment, report: &TouchReport) -> Result<(), Failure> {
    if !touch.must_be_passive || report.verdict == TouchVerdict::Passive {
        return Ok(());
    }
    Err(Failure::Run(anyhow::anyhow!(
        "must_be_passive: {}: take a softer shape, a shorter sample time or a guard, or take must_be_passive out of the \
         file to run it all the same",
        report.verdict.words()
    )))
}
