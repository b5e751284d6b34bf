//! Conducts experiments: options of a run, its progress, its stops, and its picture, report and verdict.

use crate::files::{RunFiles, save_picture};
use crate::options::Options;
use crate::options::keys::Named;
use crate::output::{Output, warn};
use crate::parse::{WAITS, quantity, whole};
use crate::picture::{of_run, rehearsed};
use crate::picture_file::Pictures;
use clap::Args;
use haptic_document::Document;
use haptic_experiment::DocumentOfKind as _;
use haptic_experiment::judge::{Published, RunReport};
use haptic_experiment::question::{Answer, Question};
use haptic_experiment::{ExperimentFile, Failure, Report};
use haptic_judge::curves::Curves;
use haptic_log::live::{Live, LiveStreams};
use haptic_loop::realtime::{PRIORITIES, allowed_cores};
use haptic_quantity::written;
#[cfg(unix)]
use haptic_run::signals::signals;
use haptic_run::{FolderRequest, OutputFolder, write_text};
use haptic_run::{Pace, RealtimeOptions, Supervisor};
use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use std::net::SocketAddr;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, LazyLock, OnceLock};
use std::time::Duration;

/// Options for conducting and keeping a run.
#[derive(Debug, Args)]
pub(crate) struct RunArguments {
    /// Pace the run by the clock
    #[arg(long, hide_short_help = true, help_heading = "Run")]
    realtime: bool,
    #[command(flatten)]
    thread: ThreadArguments,
    /// Run even if the analysis says unstable
    #[arg(long, hide_short_help = true, help_heading = "Run")]
    force_unstable: bool,
    /// Time to wait for a serial device to appear [default: 0s]
    #[arg(long, value_name = "TIME", value_parser = quantity("_s", WAITS), hide_short_help = true, help_heading = "Run")]
    wait: Option<f64>,
    #[command(flatten)]
    live: LiveArguments,
    #[command(flatten)]
    files: RunFiles,
    #[command(flatten)]
    pictures: Pictures,
    /// Write the experiment to a file instead of running it
    #[arg(long, value_name = "FILE.toml", conflicts_with_all = ["out", "roll"], hide_short_help = true, help_heading = "Run")]
    write: Option<PathBuf>,
}

impl RunArguments {
    /// Runs an experiment in its folder with a progress bar, stoppable by Ctrl-C, and reports.
    pub(crate) fn run(self, document: &Document, output: Output) -> Result<(), Failure> {
        let (experiment, pace) = self.experiment(document)?;
        let samples = experiment.samples()?;
        if let Some(file) = &self.write {
            let text = document.to_toml()?;
            return write_text(file, &text, self.files.overwrite);
        }
        let kind = document.kind()?;
        let text = document.to_toml()?;
        self.pictures
            .check(|| rehearsed(kind, &text.parse().unwrap_or_default()))?;
        let request = &mut self.files.folder(kind)?;
        let kept = document.keep_in(&mut request.provenance);
        kept?;
        let live = &self.live.open(pace != Pace::Virtual, output)?;
        let pictures = &self.pictures;
        conduct(&experiment, samples, output, request, live, pictures)?.require()
    }

    /// The experiment as it is to be conducted, and its pace.
    fn experiment(&self, document: &Document) -> Result<(ExperimentFile, Pace), Failure> {
        let mut experiment = ExperimentFile::open(document)?;
        let real = !experiment.is_simulated();
        if let Some(wait) = self.wait {
            if !real {
                return Err(Failure::bad_input(
                    "--wait has no effect on the simulated device: give --device too, or omit it",
                ));
            }
            experiment = experiment.with_patience(Duration::from_secs_f64(wait));
        }
        if self.force_unstable {
            experiment = experiment.though_unstable()?;
        }
        let pace = self.pace(real)?;
        Ok((experiment.in_pace(pace), pace))
    }

    /// The pace of the run. A serial device has its own clock: then a priority is for the threads that speak with it,
    /// and only if it is asked for.
    fn pace(&self, on_device: bool) -> Result<Pace, Failure> {
        let ThreadArguments { priority, pin } = self.thread;
        if self.realtime || on_device {
            let default = self.realtime.then_some(RealtimeOptions::DEFAULT_PRIORITY);
            return Ok(Pace::Realtime(self.thread.options(default)?));
        }
        if priority.is_some() || pin.is_some() {
            return Err(Failure::bad_input(
                "--priority and --pin are for runs by the clock: add --realtime",
            ));
        }
        Ok(Pace::Virtual)
    }
}

/// Runs an experiment with a progress bar, stoppable by Ctrl-C, draws and reports. The report is given back.
fn conduct(
    experiment: &ExperimentFile,
    samples: u64,
    output: Output,
    request: &FolderRequest,
    live: &LiveStreams,
    pictures: &Pictures,
) -> Result<Report, Failure> {
    let stop = stop_on_interrupt()?;
    let bar = progress_bar(samples, output);
    let progress = |done| {
        bar.set_position(done);
        if done >= samples {
            // A long run is read again from its log.
            bar.set_message("judging");
        }
    };
    let supervisor = Supervisor {
        stop,
        progress: &progress,
        live: Some(live),
        warn: &|text| output.warn(text),
    };
    let result = experiment.run(request, supervisor);
    bar.finish_and_clear();
    let Published {
        mut report,
        curves,
        folder,
    } = result?;
    let (picture, unsaved) = drawn(curves, &folder, pictures);
    report.run.figure = picture;
    for warning in &report.run.warnings {
        output.warn(warning);
    }
    output.report(&report)?;
    both_saved(report.run.lost_table(), unsaved)?;
    ended_well(&report.run)?;
    Ok(report)
}

/// Draws the curves of a run, if there are any: the picture, or its error, to be reported after the report.
pub(crate) fn drawn(
    curves: Option<Curves>,
    folder: &OutputFolder,
    pictures: &Pictures,
) -> (Option<String>, Option<Failure>) {
    let picture = curves.map(|curves| save_picture(folder, of_run(&curves), pictures));
    match picture.transpose() {
        Ok(picture) => (picture, None),
        Err(failure) => (None, Some(failure)),
    }
}

pub(crate) fn both_saved(table: Option<Failure>, picture: Option<Failure>) -> Result<(), Failure> {
    match (table, picture) {
        (Some(table), Some(picture)) => Err(table.and(&picture.to_string())),
        (Some(failure), None) | (None, Some(failure)) => Err(failure),
        (None, None) => Ok(()),
    }
}

pub(crate) fn lacks(dropped: u64, log: &str) -> Failure {
    Failure::data_lost(format_args!(
        "{dropped} samples are missing from the log {log}"
    ))
}

fn ended_well(run: &RunReport) -> Result<(), Failure> {
    let dropped = run.dropped_samples;
    if let (Some(reason), Some(let_go)) = (&run.ended_early, &run.let_go) {
        let lacks = match dropped {
            0 => String::new(),
            lost => format!(", and lacks {lost} samples"),
        };
        let error = format!(
            "{reason}: the run ended at {}, {let_go}; the log is {}{lacks}",
            written("duration_s", run.duration_s),
            run.log
        );
        return Err(if run.device_lost {
            Failure::device(error)
        } else {
            Failure::run(error)
        });
    }
    match dropped {
        0 => Ok(()),
        dropped => Err(lacks(dropped, &run.log)),
    }
}

/// The answer to a question of this kind, with a bar for its steps.
pub(crate) fn answered<N: Named>(
    kind: &str,
    options: Options<N>,
    stop: &Arc<AtomicBool>,
    output: Output,
) -> Result<Answer, Failure> {
    let question = Question::open(&options.over(Document::new(kind))?)?;
    let bar = progress_bar(question.steps(), output);
    let answer = question.answer(&|steps| bar.inc(steps), stop, &|text| output.warn(text));
    bar.finish_and_clear();
    answer
}

/// A bar on a terminal; nothing elsewhere or for a quiet person.
pub(crate) fn progress_bar(samples: u64, output: Output) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(samples), target(output));
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
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}

/// Standard error; nothing for a quiet person.
pub(crate) fn target(output: Output) -> ProgressDrawTarget {
    if output.quiet {
        ProgressDrawTarget::hidden()
    } else {
        ProgressDrawTarget::stderr_with_hz(10)
    }
}

/// Time that is left in words; before anything is done nobody knows it.
fn left(done: u64, estimate: Duration) -> String {
    match done {
        0 => "time left: not known yet".to_owned(),
        _ => format!("{:#} left", HumanDuration(estimate)),
    }
}

/// Live viewers of a run.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct LiveArguments {
    /// Stream to Foxglove or PlotJuggler at 127.0.0.1:8765 (feature `foxglove`)
    #[arg(long, hide_short_help = true, help_heading = "Run", value_name = "IP:PORT", value_parser = parse_address)]
    #[arg(num_args = 0..=1, require_equals = true, default_missing_value = "127.0.0.1:8765")]
    foxglove: Option<SocketAddr>,
}

fn parse_address(text: &str) -> Result<SocketAddr, String> {
    text.parse()
        .map_err(|_| "not an address: give IP:PORT, as in 127.0.0.1:8765 or [::1]:8765".to_owned())
}

impl LiveArguments {
    pub(crate) fn open(self, realtime: bool, output: Output) -> Result<LiveStreams, Failure> {
        let foxglove = self.foxglove.map(|address| open_foxglove(address, output));
        let foxglove = foxglove.transpose()?;
        if foxglove.is_some() && !realtime {
            warn(
                "the live stream runs as fast as the run is computed: give --realtime to watch it",
            );
        }
        Ok(LiveStreams::new(foxglove.into_iter().collect()))
    }
}

#[cfg(feature = "foxglove")]
fn open_foxglove(address: SocketAddr, output: Output) -> Result<Box<dyn Live>, Failure> {
    let foxglove = haptic_log::live::Foxglove::open(address).map_err(|error| {
        Failure::input_with_advice(
            error,
            "give another, as in --foxglove=127.0.0.1:0 for a free one",
        )
    })?;
    if !output.quiet {
        crate::output::note(
            "live stream",
            format_args!("ws://{}, for Foxglove or PlotJuggler", foxglove.address()),
        );
    }
    Ok(Box::new(foxglove))
}

#[cfg(not(feature = "foxglove"))]
fn open_foxglove(_: SocketAddr, _: Output) -> Result<Box<dyn Live>, Failure> {
    Err(Failure::bad_input(
        "--foxglove: this build has no Foxglove WebSocket; build it with --features foxglove",
    ))
}

/// Options that raise the thread of a loop above the others of the machine.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct ThreadArguments {
    /// Real-time priority, 1 to 99, or `off` [default: 80 where permitted]
    #[arg(long, value_name = "N|off", value_parser = parse_priority, hide_short_help = true, help_heading = "Run")]
    priority: Option<Priority>,
    /// Run the loop on this core, counted from 0
    #[arg(long, value_name = "CORE", value_parser = whole::<usize>(0..=100_000), hide_short_help = true, help_heading = "Run")]
    pin: Option<usize>,
}

/// `off` is an answer too: it takes the default away.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Priority {
    Off,
    Fifo(u8),
}

fn parse_priority(text: &str) -> Result<Priority, String> {
    if text == "off" {
        return Ok(Priority::Off);
    }
    match text.parse() {
        Ok(priority) if PRIORITIES.contains(&priority) => Ok(Priority::Fifo(priority)),
        _ => Err("neither from 1 to 99 nor off".to_owned()),
    }
}

impl ThreadArguments {
    /// The options as typed; the priority `default` unless given.
    pub(crate) fn options(self, default: Option<u8>) -> Result<RealtimeOptions, Failure> {
        let priority = match self.priority {
            Some(Priority::Off) => None,
            Some(Priority::Fifo(priority)) => Some(priority),
            None => default,
        };
        if let Some(core) = self.pin {
            let allowed = allowed_cores();
            // A system that does not say refuses later, as a warning.
            if !allowed.is_empty() && !allowed.contains(&core) {
                let names: Vec<String> = allowed.iter().map(ToString::to_string).collect();
                return Err(Failure::bad_input(format_args!(
                    "core {core} is not one that this program may use: give --pin one of {}",
                    names.join(", ")
                )));
            }
        }
        Ok(RealtimeOptions {
            priority,
            pin: self.pin,
        })
    }
}

/// The flag that Ctrl-C sets, and every other signal that would end or stop a program and that a program may hear: none of them leaves
/// a force behind. Ctrl-Z ends a run too, as a stopped program takes no force away. The handlers are installed once.
pub(crate) fn stop_on_interrupt() -> Result<&'static Arc<AtomicBool>, Failure> {
    static STOP: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);
    static INSTALLED: OnceLock<Result<(), String>> = OnceLock::new();
    match INSTALLED.get_or_init(|| heard(&STOP)) {
        Ok(()) => Ok(&STOP),
        Err(error) => Err(Failure::run(format_args!(
            "cannot watch for Ctrl-C, so a run could not be stopped safely: {error}"
        ))),
    }
}

/// The events of a console. Closing it, logging off and shutting down end the program when its handler returns: tokio's does not, which
/// leaves the run the seconds that Windows grants to end in order.
#[cfg(windows)]
fn heard(stop: &Arc<AtomicBool>) -> Result<(), String> {
    use tokio::signal::windows::{ctrl_break, ctrl_c, ctrl_close, ctrl_logoff, ctrl_shutdown};
    let text = |error: std::io::Error| error.to_string();
    let runtime = tokio::runtime::Builder::new_current_thread().build();
    let runtime = runtime.map_err(text)?;
    let (mut c, mut pause) = (ctrl_c().map_err(text)?, ctrl_break().map_err(text)?);
    let mut close = ctrl_close().map_err(text)?;
    let mut log_off = ctrl_logoff().map_err(text)?;
    let mut shutdown = ctrl_shutdown().map_err(text)?;
    let flag = Arc::clone(stop);
    let listener = std::thread::Builder::new().spawn(move || {
        runtime.block_on(async {
            loop {
                tokio::select! {
                    _ = c.recv() => {}
                    _ = pause.recv() => {}
                    _ = close.recv() => {}
                    _ = log_off.recv() => {}
                    _ = shutdown.recv() => {}
                }
                flag.store(true, std::sync::atomic::Ordering::Relaxed);
            }
        })
    });
    listener.map(drop).map_err(text)
}

#[cfg(unix)]
fn heard(stop: &Arc<AtomicBool>) -> Result<(), String> {
    let register = |signal| signal_hook::flag::register(signal, Arc::clone(stop)).map(drop);
    let registered = signals().into_iter().try_for_each(register);
    registered.map_err(|error| error.to_string())
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
