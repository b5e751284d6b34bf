//! Many short runs on one serial device, without log or files: what a search is made of.
//!
//! A trial that says nothing about its law is made again, ten times in all: samples missing or held up, a host, line or tick that was
//! late. Then no more trials are made; nor after twenty in a row that ended at a limit of the device, nor after any fault that is none of
//! the law: see `Meaning`.

mod meaning;
#[cfg(test)]
mod tests;

use meaning::{Meaning, remedy};

use crate::document::failure::Failure;
use crate::document::parameters::{LOOP, TRIAL_DURATION};
use crate::run::device::{Warn, at_link, at_port, refused_at_port, trouble};
use crate::run::realtime::RealtimeOptions;
use crate::run::remote::{RemoteDevice, RemoteLaw, configuration, keep_within};
use crate::run::schedule::{Pace, Schedule};
use haptic_link::{Configuration, EventKind, FaultReport, LoopMode, Refusal, Scope, Start, State};
use haptic_loop::Fault;
use haptic_remote::LinkError;
use haptic_remote::serial::{Heard, SerialError, SerialLink};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// How often a trial that says nothing about its law is made.
const TRIES: usize = 10;
/// So many trials in a row that ended at a limit of the device are enough.
pub(crate) const TRIPS_IN_A_ROW: usize = 20;
/// The force of a trial before has fallen to zero in this time: the longest of [`Limits`](haptic_link::Limits), and an idle host.
const FALLEN_WITHIN: Duration = Duration::from_secs(5);
/// A trial without a sample for so long is held up, or its line is.
const SILENCE: Duration = Duration::from_secs(2);
/// Between two questions whether it has.
const PAUSE: Duration = Duration::from_millis(10);

/// One run, as far as it came.
enum Trial {
    /// Position, m, and force, N, of each sample.
    Whole(Vec<(f64, f64)>),
    /// The law moved the device beyond a limit: this fault.
    Tripped(Fault),
    /// Nothing is known of the law, because of the line or this machine.
    Unjudged(Failure),
}

/// Trials that ended at a limit of the device.
#[derive(Debug, Default)]
struct Trips {
    trials: usize,
    all: usize,
    in_a_row: usize,
    last: Option<Fault>,
}

/// A serial device that is tried again and again, by one thread at a time.
pub(crate) struct Trials<'a> {
    remote: RemoteDevice,
    link: Mutex<SerialLink>,
    /// Settings of the device: no trial loosens them.
    set: Configuration,
    told: std::sync::Once,
    warn: Warn<'a>,
    /// Why no more trials can be made.
    failure: Mutex<Option<Failure>>,
    trips: Mutex<Trips>,
    run: AtomicU32,
}

impl<'a> Trials<'a> {
    /// Connects.
    ///
    /// # Errors
    /// A device that cannot be used; a loop on the host, which trials do not do.
    pub(crate) fn new(
        remote: &RemoteDevice,
        warn: Warn<'a>,
        stop: &AtomicBool,
    ) -> Result<Self, Failure> {
        if remote.loop_mode == LoopMode::Host {
            return Err(Failure::bad_input(format_args!(
                "a search runs in the device's own loop: omit {}",
                LOOP.set_to("host")
            )));
        }
        let link = remote
            .name
            .connect_with(1, remote.patience, warn, Some(stop))?;
        let set = link.configuration();
        let (set, _) = set.map_err(|error| at_port(link.path(), &error))?;
        Ok(Self {
            link: Mutex::new(link),
            set,
            told: std::sync::Once::new(),
            warn,
            remote: remote.clone(),
            failure: Mutex::new(None),
            trips: Mutex::default(),
            run: AtomicU32::new(1),
        })
    }

    /// Position, m, and force, N, of each sample of one run; `None` if the law tripped the device, or if no more trials can be made:
    /// the search then tells why.
    pub(crate) fn motion(
        &self,
        law: &RemoteLaw,
        samples: u64,
        sample_time_s: f64,
    ) -> Option<Vec<(f64, f64)>> {
        if self.failed().is_some() {
            return None;
        }
        let mut link = self.link.lock().unwrap_or_else(PoisonError::into_inner);
        for tries in 1.. {
            let failure = match self.try_once(&mut link, law, samples, sample_time_s) {
                Ok(Trial::Whole(motion)) => {
                    self.counted(None, link.path());
                    return Some(motion);
                }
                Ok(Trial::Tripped(fault)) => {
                    if let Some(enough) = self.counted(Some(fault), link.path()) {
                        self.failed().get_or_insert(enough);
                    }
                    return None;
                }
                Ok(Trial::Unjudged(_)) if tries < TRIES => continue,
                Ok(Trial::Unjudged(failure)) | Err(failure) => failure,
            };
            self.failed().get_or_insert(at_link(&link, failure));
            break;
        }
        None
    }

    /// Step of the device's encoder, m, and the largest force that it can do, N.
    pub(crate) fn encoder_and_force(&self) -> (f64, f64) {
        let link = self.link.lock().unwrap_or_else(PoisonError::into_inner);
        let can = link.capabilities();
        (
            f64::from(can.position_resolution_m),
            f64::from(can.force_max_n),
        )
    }

    /// True if no more trials are made.
    pub(crate) fn has_failed(&self) -> bool {
        self.failed().is_some()
    }

    /// Why the search ended before its end, if so; `found` something or not, `stop`ped or not.
    ///
    /// # Errors
    /// The same where nothing was found; that nothing was to be found.
    pub(crate) fn ended(self, found: bool, stop: &AtomicBool) -> Result<Option<Failure>, Failure> {
        let failure = self.failed().take();
        match failure {
            Some(failure) if !found => Err(failure),
            None if !found && !stop.load(Ordering::Relaxed) => Err(self.nothing()),
            failure => Ok(failure),
        }
    }

    fn failed(&self) -> MutexGuard<'_, Option<Failure>> {
        self.failure.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn trips(&self) -> MutexGuard<'_, Trips> {
        self.trips.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Counts a trial that was judged; the failure if it was the last of too many that ended at a limit.
    fn counted(&self, fault: Option<Fault>, path: &str) -> Option<Failure> {
        let mut trips = self.trips();
        trips.trials += 1;
        let Some(fault) = fault else {
            trips.in_a_row = 0;
            return None;
        };
        trips.all += 1;
        trips.in_a_row += 1;
        trips.last = Some(fault);
        (trips.in_a_row >= TRIPS_IN_A_ROW).then(|| {
            Failure::Run(anyhow::anyhow!(
                "{path}: {TRIPS_IN_A_ROW} trials in a row ended at a limit of the device ({fault}), so no more are made: {}",
                remedy(fault, &self.set.limits)
            ))
        })
    }

    /// No law came to rest in any trial.
    fn nothing(&self) -> Failure {
        let Trips {
            trials, all, last, ..
        } = *self.trips();
        let name = &self.remote.name;
        let why = match last {
            Some(fault) => format!(
                "{all} of them ended at a limit of the device ({fault}): {}",
                remedy(fault, &self.set.limits)
            ),
            None => format!("give the trials a longer {TRIAL_DURATION}, or hold the device"),
        };
        Failure::Run(anyhow::anyhow!(
            "{name}: no wall came to rest in {trials} trials; {why}"
        ))
    }

    fn try_once(
        &self,
        link: &mut SerialLink,
        law: &RemoteLaw,
        samples: u64,
        sample_time_s: f64,
    ) -> Result<Trial, Failure> {
        let schedule = Schedule {
            samples,
            sample_time_s,
            pace: Pace::Realtime(RealtimeOptions::NORMAL),
        };
        let can = link.capabilities();
        let mut configuration = configuration(&self.remote, law, schedule, can, &self.set.limits)?;
        // A search does not end where the device's limits do.
        if let Some(text) = keep_within(&mut configuration, &self.set) {
            self.told.call_once(|| (self.warn)(&text));
        }
        let path = link.path().to_owned();
        let problem = |error| refused_at_port(&path, error);
        let asked = Instant::now();
        loop {
            if let Some(fault) = self.forbids(link) {
                return Err(ended_by(link, &format!("{fault}, between two trials")));
            }
            let Err(error) = self.begin(link, configuration, &law.operator.1, samples as u32)
            else {
                break;
            };
            if is_unanswered(&error) {
                return unanswered(link, &path, error);
            }
            if !passes(&error) || asked.elapsed() > FALLEN_WITHIN {
                return Err(problem(error));
            }
            std::thread::sleep(PAUSE);
        }
        let trial = Self::followed(link, &path, samples, SILENCE)?;
        match link.disarm() {
            Err(error) if is_unanswered(&error) => unanswered(link, &path, error),
            disarmed => disarmed.map_err(problem).map(|()| trial),
        }
    }

    /// Follows a run that has begun to its end.
    fn followed(
        link: &mut SerialLink,
        path: &str,
        samples: u64,
        patience: Duration,
    ) -> Result<Trial, Failure> {
        let problem = |error| refused_at_port(path, error);
        let mut motion = Vec::with_capacity(samples as usize);
        loop {
            match link.hear(patience) {
                Some(Heard::Sample(sample)) => {
                    let next = motion.len() as u64;
                    if let Some(axis) = sample.axes.first()
                        && u64::from(sample.tick) == next
                        && next < samples
                    {
                        motion.push((f64::from(axis.position_m), f64::from(axis.force_n)));
                    }
                }
                Some(Heard::Event(event)) if event.kind == EventKind::Finished => {
                    return Ok(match motion.len() as u64 == samples {
                        true => Trial::Whole(motion),
                        false => Trial::Unjudged(lost(path, motion.len(), samples)),
                    });
                }
                Some(Heard::Event(_)) => {}
                Some(Heard::Fault(report)) => {
                    return faulted(link, report);
                }
                Some(Heard::Over(error)) => return Err(problem(error.into())),
                None => match link.silent(patience) {
                    error @ LinkError::HeldUp { .. } => {
                        return Ok(Trial::Unjudged(held_up(path, &error.into())));
                    }
                    error => return Err(problem(error.into())),
                },
            }
        }
    }

    /// A fault after which nobody but a person arms again, since the first trial: arming would clear it.
    fn forbids(&self, link: &SerialLink) -> Option<Fault> {
        let first = self.run.load(Ordering::Relaxed) == 1;
        let latched = Fault::from_code(link.status().fault)?;
        (!first && Meaning::of(latched) == Meaning::Ends).then_some(latched)
    }

    /// Sets a law, arms and starts.
    fn begin(
        &self,
        link: &mut SerialLink,
        configuration: Configuration,
        coefficients: &[f32],
        ticks: u32,
    ) -> Result<(), SerialError> {
        link.set_for(configuration, coefficients, Scope::Run)?;
        link.arm(Duration::from_millis(u64::from(self.remote.watchdog_ms())))?;
        link.start(Start {
            run: self.run.fetch_add(1, Ordering::Relaxed),
            ticks,
            every: 1,
            batch: 8,
        })
    }
}

/// Lets go of a device that did not answer. This machine, an emulator on it or a bad line may have been held up: if it answers now, nothing
/// is known of the law.
///
/// # Errors
/// It is as silent as before.
fn unanswered(link: &SerialLink, path: &str, error: SerialError) -> Result<Trial, Failure> {
    match link.silent(SILENCE) {
        LinkError::HeldUp { .. } => Ok(Trial::Unjudged(held_up(path, &error))),
        _ => Err(refused_at_port(path, error)),
    }
}

const fn is_unanswered(error: &SerialError) -> bool {
    matches!(error, SerialError::Link(LinkError::NoAnswer { .. }))
}

/// Refused for now: the force of the trial before still falls, or a fault latched that is not known here yet.
fn passes(error: &SerialError) -> bool {
    matches!(
        error,
        SerialError::Link(LinkError::Refused {
            refusal: Refusal::ForceNotZero | Refusal::UnknownFault | Refusal::State(State::Fault),
            ..
        })
    )
}

/// A trial that a fault has ended.
///
/// # Errors
/// A fault after which no more trials are made.
fn faulted(link: &SerialLink, report: FaultReport) -> Result<Trial, Failure> {
    let fault = Fault::from_code(report.status.fault).filter(|_| link.lost_board().is_none());
    match fault.map(|fault| (fault, Meaning::of(fault))) {
        Some((fault, Meaning::Answer)) => Ok(Trial::Tripped(fault)),
        Some((fault, Meaning::Unjudged)) => Ok(Trial::Unjudged(late(link.path(), fault))),
        Some((_, Meaning::Ends)) | None => {
            Err(ended_by(link, &LinkError::Faulted(report).to_string()))
        }
    }
}

/// The end of a search by a fault in these words, and what its board says of it: the device is to be mended first.
fn ended_by(link: &SerialLink, words: &str) -> Failure {
    let board = trouble(link).map_or_else(String::new, |trouble| format!(": {trouble}"));
    Failure::Device(anyhow::anyhow!(
        "{}: {words}, so no more trials are made{board}",
        link.path()
    ))
}

fn lost(path: &str, came: usize, samples: u64) -> Failure {
    Failure::DataLost(anyhow::anyhow!(
        "{path}: samples of a trial are missing, {TRIES} times in a row (the last came to number {came} of {samples}), so it cannot be \
         judged: use a faster or better line, or a longer sample time"
    ))
}

fn held_up(path: &str, error: &SerialError) -> Failure {
    Failure::Device(anyhow::anyhow!(
        "{path}: {error}; so it was in {TRIES} trials in a row, and none can be judged"
    ))
}

fn late(path: &str, fault: Fault) -> Failure {
    Failure::Device(anyhow::anyhow!(
        "{path}: {fault}, in {TRIES} trials in a row, so none can be judged: leave this machine to itself, or allow a longer watchdog time"
    ))
}

impl std::fmt::Debug for Trials<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Trials")
            .field("remote", &self.remote)
            .finish_non_exhaustive()
    }
}
