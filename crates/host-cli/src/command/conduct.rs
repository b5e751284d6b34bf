//! A run with a progress bar, stoppable by Ctrl-C, that is drawn and reported.

use super::stop::stop_on_interrupt;
use crate::files::save_picture;
use crate::output::{Output, note, warn};
use haptic_experiment::Failure;
use haptic_experiment::judge::{Curves, Published, RunReport};
use haptic_experiment::run::OutputFolder;
use haptic_experiment::{Summary, Supervisor};
use haptic_figure::{FigureError, Picture};
use haptic_quantity::written;
use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

/// Runs an experiment with a progress bar, stoppable by Ctrl-C, draws and reports. The report is given back.
///
/// # Errors
/// Those of the experiment; an interrupted one, one with a fault, or with dropped samples.
pub fn conduct<R: Summary>(
    samples: u64,
    output: Output,
    draw: impl FnOnce(&R, &Curves) -> Result<Picture, FigureError>,
    experiment: impl FnOnce(Supervisor<'_>) -> Result<Published<R>, Failure>,
) -> Result<R, Failure> {
    let stop = stop_on_interrupt()?;
    let bar = progress_bar(samples, output);
    let progress = |done| {
        bar.set_position(done);
        if done >= samples {
            // A long run is read again from its log.
            bar.set_message("judging");
        }
    };
    let result = experiment(Supervisor {
        stop,
        progress: &progress,
        live: None,
        warn: &warn,
    });
    bar.finish_and_clear();
    let Published {
        mut report,
        curves,
        folder,
    } = result?;
    let (picture, unsaved) = drawn(curves, &folder, |curves| draw(&report, curves));
    report.run_mut().figure = picture;
    for warning in &report.run().warnings {
        note("warning", warning);
    }
    output.summary(&report)?;
    both_saved(report.run().lost_table(), unsaved)?;
    ended_well(report.run())?;
    Ok(report)
}

/// Draws the curves of a run, if there are any: the picture, and why there is none, which is said after the report.
pub fn drawn(
    curves: Option<Curves>,
    folder: &OutputFolder,
    draw: impl FnOnce(&Curves) -> Result<Picture, FigureError>,
) -> (Option<String>, Option<Failure>) {
    let picture = curves.map(|curves| save_picture(folder, draw(&curves)));
    match picture.transpose() {
        Ok(picture) => (picture, None),
        Err(failure) => (None, Some(failure)),
    }
}

/// # Errors
/// A table or a picture that could not be written.
pub fn both_saved(table: Option<Failure>, picture: Option<Failure>) -> Result<(), Failure> {
    match (table, picture) {
        (Some(table), Some(picture)) => Err(table.and(&picture.to_string())),
        (Some(failure), None) | (None, Some(failure)) => Err(failure),
        (None, None) => Ok(()),
    }
}

/// The failure of a log that lacks samples.
pub fn lacks(dropped: u64, log: &str) -> Failure {
    Failure::DataLost(anyhow::anyhow!(
        "{dropped} samples are missing from the log {log}"
    ))
}

/// # Errors
/// A run that ended early, or whose log lacks samples.
fn ended_well(run: &RunReport) -> Result<(), Failure> {
    let RunReport {
        ended_early,
        let_go,
        device_lost,
        duration_s,
        dropped_samples,
        log,
        ..
    } = run;
    let dropped = *dropped_samples;
    if let (Some(reason), Some(let_go)) = (ended_early, let_go) {
        let error = anyhow::anyhow!(
            "{reason}: the run ended at {}, {}; the log is {log}{}",
            written("duration_s", *duration_s),
            let_go.words(),
            match dropped {
                0 => String::new(),
                lost => format!(", and lacks {lost} samples"),
            }
        );
        return Err(if *device_lost {
            Failure::Device(error)
        } else {
            Failure::Run(error)
        });
    }
    if dropped > 0 {
        return Err(lacks(dropped, log));
    }
    Ok(())
}

/// A bar on a terminal; nothing elsewhere or for a quiet person.
pub fn progress_bar(samples: u64, output: Output) -> ProgressBar {
    let target = if output.quiet {
        ProgressDrawTarget::hidden()
    } else {
        ProgressDrawTarget::stderr()
    };
    let bar = ProgressBar::with_draw_target(Some(samples), target);
    let template = "{bar:40} {percent:>3} %  {human_pos} of {human_len}  {left}  {msg}";
    // The template is a constant; the default serves if it were wrong.
    let style =
        ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    bar.set_style(style.with_key(
        "left",
        |state: &ProgressState, out: &mut dyn std::fmt::Write| {
            // A line that cannot be written to is not a line that somebody reads.
            let _ = out.write_str(&left(state.pos(), state.eta()));
        },
    ));
    // Draws from a thread of its own, not from the loop.
    bar.enable_steady_tick(std::time::Duration::from_millis(100));
    bar
}

/// Time that is left in words; before anything is done nobody knows it.
fn left(done: u64, estimate: std::time::Duration) -> String {
    match done {
        0 => "time left: not known yet".to_owned(),
        _ => format!("{:#} left", HumanDuration(estimate)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn before_anything_is_done_nobody_knows_how_long_it_takes() {
        assert!(!left(0, Duration::ZERO).contains('0'));
        assert_eq!(left(1, Duration::from_secs(42)), "42s left");
    }
}
