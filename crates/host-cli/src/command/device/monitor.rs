//! `device monitor`: watch a device, whatever happens to its line.

use crate::command::conduct::{LiveArguments, stop_on_interrupt, target};
use crate::command::device::info::fault_in_words;
use crate::command::device::port::PortArguments;
use crate::files::RunFiles;
use crate::output::{Output, note, warn};
use crate::parse::{quantity, whole};
use clap::Args;
use haptic_experiment::{Failure, parameters};
use haptic_link::{BATCH_MAX, FaultReport, Sample};
use haptic_log::record::{RecordError, StartTime};
use haptic_loop::realtime::Moment;
use haptic_message::TickMessage;
use haptic_remote::serial::{DeviceMessage, SerialLink};
use haptic_run::{Recorder, Stopped, trouble};
use haptic_trial::tick::by_device;
use indicatif::ProgressBar;
use serde::Serialize;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, SystemTime};

/// Show position and state, and log every sample
///
/// Does not affect the device. The log is monitor.mcap. When the line breaks, the device reboots or
/// the board fails, the log is closed, and a new one (monitor-2.mcap) starts once the device is
/// back.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli device monitor --device serial:/dev/ttyACM0 --duration 10s"
)]
pub(crate) struct Arguments {
    #[command(flatten)]
    port: PortArguments,
    /// Send and log only every Nth tick
    #[arg(long, default_value_t = 1, value_parser = whole::<u16>(1..=u16::MAX))]
    every: u16,
    /// Stop after this time [default: run until Ctrl-C]
    #[arg(long, value_name = "TIME", value_parser = quantity("_s", parameters::TRIAL_DURATION.range()))]
    duration: Option<f64>,
    #[command(flatten)]
    live: LiveArguments,
    #[command(flatten)]
    files: RunFiles,
}

/// Summary of a session of `device monitor`.
#[derive(Debug, Default, Serialize)]
struct Watched {
    device: String,
    samples: u64,
    samples_lost: u64,
    dropped_samples: u64,
    faults: u64,
    /// Times the session ended and a new one was begun.
    reconnected: u64,
    logs: Vec<String>,
    /// Why it is not there at the end.
    #[serde(skip)]
    gone: Option<String>,
    /// Why a log was not written to its end.
    #[serde(skip)]
    unwritten: Option<Failure>,
}

impl Watched {
    fn report(&self, output: Output) -> Result<(), Failure> {
        let missing = self.samples_lost + self.dropped_samples;
        output.report(self)?;
        let lost = match (&self.unwritten, missing) {
            (None, 0) => String::new(),
            (None, missing) => format!("{missing} samples are missing from the logs"),
            (Some(unwritten), _) => unwritten.to_string(),
        };
        let and = if lost.is_empty() { "" } else { ", and " };
        match &self.gone {
            Some(gone) => Err(Failure::device(format_args!(
                "{}: {gone}; it did not come back{and}{lost}",
                self.device
            ))),
            None if lost.is_empty() => Ok(()),
            None => Err(Failure::data_lost(format_args!("{lost}"))),
        }
    }
}

/// Metadata of the device for each log.
fn metadata(device: &str, link: &SerialLink) -> BTreeMap<String, String> {
    let metadata = [
        ("experiment", "monitor".to_owned()),
        ("device", device.to_owned()),
        ("board", link.capabilities().board().to_owned()),
    ];
    metadata.map(|(key, value)| (key.to_owned(), value)).into()
}

impl Arguments {
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        let stop = stop_on_interrupt()?;
        let live = self.live.open(true, output)?;
        let mut link = self.port.connect()?;
        let folder = self.files.folder("monitor")?.prepare()?;
        let mut watch = Watch {
            every: self.every,
            until: self
                .duration
                .map(|time| Moment::now() + Duration::from_secs_f64(time)),
            stop,
            bar: status_line(output),
            watched: Watched {
                device: link.name(),
                ..Watched::default()
            },
        };
        let mut pause = FIRST_PAUSE;
        loop {
            let began = Moment::now();
            let name = match watch.watched.reconnected {
                0 => folder.file("mcap"),
                before => folder.further_file(&(before + 1).to_string(), "mcap"),
            };
            let metadata = metadata(&watch.watched.device, &link);
            // The streams show the first session; later ones are in their logs.
            let (overwrite, roll_bytes) = (folder.overwrite(), folder.roll_bytes());
            let recorder =
                Recorder::start(&name, metadata, false, overwrite, roll_bytes, live.take());
            let mut log = match (recorder, watch.watched.reconnected) {
                (Err(error), 0) => return Err(error.into()),
                (recorder, _) => SessionLog::new(recorder, &watch.bar),
            };
            let over = watch.session(&mut link, &mut log);
            log.close(&mut watch.watched);
            watch.watched.dropped_samples += link.report().samples_dropped;
            let zeroed = link.trouble().is_some();
            drop(link);
            let Some(reason) = over else {
                break;
            };
            note("link", &reason);
            pause = pause_after(began.elapsed(), pause);
            watch.rest(pause);
            match self.reconnect(&watch) {
                Some(again) => link = again,
                None => {
                    watch.watched.gone = Some(reason);
                    break;
                }
            }
            watch.watched.reconnected += 1;
            // A device of another maker finds its zero when it is opened.
            let back = if !zeroed {
                "the device is back"
            } else {
                "the device is back, reopened: its position now counts as its start"
            };
            note("link", back);
        }
        watch.bar.finish_and_clear();
        watch.watched.report(output)
    }

    /// Tries until the device is back; `None` when the watching is over.
    fn reconnect(&self, watch: &Watch<'_>) -> Option<SerialLink> {
        let mut pause = FIRST_PAUSE;
        while !watch.is_over() {
            if let Ok(link) = self.port.connect_once() {
                return Some(link);
            }
            watch.rest(pause);
            pause = (2 * pause).min(Duration::from_secs(1));
        }
        None
    }
}

/// Pause before the device is opened again, at first.
const FIRST_PAUSE: Duration = Duration::from_millis(50);

/// Pause before a device is opened again whose session lasted so long: one that fails as soon as it is opened is left alone for ever
/// longer, up to half a minute.
fn pause_after(lasted: Duration, before: Duration) -> Duration {
    if lasted < Duration::from_secs(5) {
        (2 * before).min(Duration::from_secs(30))
    } else {
        FIRST_PAUSE
    }
}

/// A line on the terminal that is written over.
fn status_line(output: Output) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(None, target(output));
    // The template is a constant; the default serves if it were wrong.
    if let Ok(style) = indicatif::ProgressStyle::with_template("{msg}") {
        bar.set_style(style);
    }
    bar
}

/// Nothing for so long where samples are due is a silence.
const SILENCE: Duration = Duration::from_secs(2);

struct Watch<'a> {
    every: u16,
    until: Option<Moment>,
    stop: &'a AtomicBool,
    bar: ProgressBar,
    watched: Watched,
}

impl Watch<'_> {
    fn is_over(&self) -> bool {
        self.stop.load(Ordering::Relaxed) || self.until.is_some_and(|until| Moment::now() >= until)
    }

    fn rest(&self, pause: Duration) {
        let until = Moment::now() + pause;
        while !self.is_over() && Moment::now() < until {
            std::thread::sleep(FIRST_PAUSE.min(until.saturating_duration_since(Moment::now())));
        }
    }

    /// Watches until the time is over, or the session: then why.
    fn session(&mut self, link: &mut SerialLink, log: &mut SessionLog) -> Option<String> {
        /// A pause in which the end is looked for.
        const PAUSE: Duration = Duration::from_millis(100);
        // Batches at 1 kHz save half of the line; one at a time below.
        let batch = if self.every == 1 { BATCH_MAX as u8 } else { 1 };
        if let Err(error) = link.stream(self.every, batch) {
            return Some(error.to_string());
        }
        let period_s = link.period_s();
        let mut next_tick = None;
        let silence = SILENCE + Duration::from_secs_f64(2.0 * period_s * f64::from(self.every));
        let mut patience = link.patience(silence);
        let over = loop {
            if self.is_over() {
                break None;
            }
            // Nobody drives a device that this process serves: its board has failed, and samples report from now on its last
            // position. Asked for, as the message of a fault may be lost.
            if let Some(trouble) = trouble(link) {
                let time_s = f64::from(next_tick.unwrap_or_default()) * period_s;
                log.keep(|log| log.event(time_s, "link", trouble.clone()));
                break Some(trouble);
            }
            let heard = link.hear(PAUSE);
            if let Some(DeviceMessage::Sample(_)) = heard {
                patience = link.patience(silence);
            } else if link.is_silent(&mut patience) {
                break Some(link.unheard(silence).to_string());
            }
            match heard {
                Some(DeviceMessage::Sample(sample)) => {
                    self.count(&sample, &mut next_tick, period_s, log);
                    self.take(&sample, period_s, log);
                }
                // The fault of a board that has failed is reported with its trouble, next.
                Some(DeviceMessage::Fault(report)) if trouble(link).is_none() => {
                    self.fault(&report, period_s, log);
                }
                Some(DeviceMessage::Event(event)) => {
                    let time_s = f64::from(event.tick) * period_s;
                    let words = format!("{:?}", event.kind).to_lowercase();
                    log.keep(|log| log.event(time_s, "device", words));
                }
                Some(DeviceMessage::Over(error)) => break Some(error.to_string()),
                Some(DeviceMessage::Fault(_)) | None => {}
            }
            let state = link.status().state;
            self.bar.set_prefix(state.to_string());
        };
        // Best effort: the session may be over.
        let _ = link.stream(0, 1);
        over
    }

    /// Counts what is missing before a sample; dates the log at the first, and again where a run began.
    fn count(
        &mut self,
        sample: &Sample,
        next_tick: &mut Option<u32>,
        period_s: f64,
        log: &mut SessionLog,
    ) {
        let expected = next_tick.replace(sample.tick.wrapping_add(u32::from(self.every)));
        let missing = expected.map_or(0, |tick| sample.tick.wrapping_sub(tick));
        // A tick that went back is a run that began.
        let went_back = missing >= u32::MAX / 2;
        if expected.is_none() || went_back {
            let time_s = f64::from(sample.tick) * period_s;
            let start = StartTime::before(SystemTime::now(), time_s);
            log.keep(|log| log.starts_at(start));
        }
        if !went_back {
            self.watched.samples_lost += u64::from(missing / u32::from(self.every));
        }
    }

    fn fault(&mut self, report: &FaultReport, period_s: f64, log: &mut SessionLog) {
        self.watched.faults += 1;
        let text = fault_in_words(report.status).unwrap_or_default();
        self.bar.suspend(|| note("fault", &text));
        let time_s = f64::from(report.tick) * period_s;
        log.keep(|log| log.event(time_s, "fault", text));
    }

    fn take(&mut self, sample: &Sample, period_s: f64, log: &mut SessionLog) {
        self.watched.samples += 1;
        let Some(first) = sample.axes.first() else {
            return;
        };
        let time_s = f64::from(sample.tick) * period_s;
        let message = by_device(TickMessage::unknown(sample.axes.len()), sample, time_s);
        log.keep(|log| log.tick(&message));
        if self.watched.samples.is_multiple_of(50) {
            self.bar.set_message(format!(
                "{:>9} · tick {:>10} · position {:>12.6} mm · force {:>10.4} N · limiters {:#010b}",
                self.bar.prefix(),
                sample.tick,
                1e3 * first.position_m,
                first.force_n,
                first.limiters
            ));
        }
    }
}

/// A log while it can be written, and then nothing.
struct SessionLog {
    recorder: Option<Recorder>,
    /// Number of entries handed over that the log lacks.
    dropped: u64,
    unwritten: Option<Failure>,
    bar: ProgressBar,
}

impl SessionLog {
    fn new(recorder: Result<Recorder, RecordError>, bar: &ProgressBar) -> Self {
        let mut log = Self {
            recorder: None,
            dropped: 0,
            unwritten: None,
            bar: bar.clone(),
        };
        match recorder {
            Ok(recorder) => log.recorder = Some(recorder),
            Err(error) => log.lose(error),
        }
        log
    }

    /// Hands something over, if somebody writes.
    fn keep(&mut self, hand: impl FnOnce(&mut Recorder) -> Result<(), Stopped>) {
        let Some(mut recorder) = self.recorder.take() else {
            self.dropped += 1;
            return;
        };
        match hand(&mut recorder) {
            Ok(()) => self.recorder = Some(recorder),
            // The writer has ended, and reports why.
            Err(Stopped) => {
                self.dropped += 1 + recorder.dropped();
                if let Err(error) = recorder.finish() {
                    self.lose(error);
                }
            }
        }
    }

    fn lose(&mut self, error: RecordError) {
        let failure = Failure::from(error);
        let words = format!("{failure}; nothing is recorded from here on");
        self.bar.suspend(|| note("warning", words));
        self.unwritten = Some(failure);
    }

    /// Closes the log, and counts what is in it.
    fn close(mut self, watched: &mut Watched) {
        if let Some(recorder) = self.recorder.take() {
            self.dropped += recorder.dropped();
            match recorder.finish() {
                Ok(recorded) => {
                    recorded.warnings.iter().for_each(|warning| warn(warning));
                    let paths = recorded.log.paths.iter();
                    watched
                        .logs
                        .extend(paths.map(|path| path.display().to_string()));
                }
                Err(error) => self.unwritten = Some(error.into()),
            }
        }
        watched.dropped_samples += self.dropped;
        watched.unwritten = watched.unwritten.take().or(self.unwritten);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_device_that_fails_at_once_is_left_alone_for_ever_longer() {
        let at_once = Duration::from_millis(500);
        let pauses = std::iter::successors(Some(FIRST_PAUSE), |&pause| {
            Some(pause_after(at_once, pause))
        });
        let pauses: Vec<u128> = pauses.take(12).map(|pause| pause.as_millis()).collect();
        assert_eq!(pauses[..4], [50, 100, 200, 400]);
        assert_eq!(pauses[11], 30_000);
        let after_a_while = pause_after(Duration::from_secs(60), Duration::from_secs(30));
        assert_eq!(after_a_while, FIRST_PAUSE);
    }
}
