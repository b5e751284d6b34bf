//! Many short runs on one serial device, without log or files: what a search is made of.
//!
//! A trial that says nothing about its law is made again, ten times in all: samples missing or held up, a host, line or tick that was
//! late. Then, and at once where the emergency stop opens, the device is reset or its board fails, no more trials are made.

use super::realtime::RealtimeOptions;
use super::remote::{RemoteDevice, RemoteLaw, configuration, keep_within};
use super::schedule::{Pace, Schedule};
use crate::device::{Warn, at_link, at_port, refused_at_port};
use crate::failure::Failure;
use haptic_link::{Configuration, EventKind, LoopMode, Refusal, Scope, Start, State};
use haptic_loop::Fault;
use haptic_remote::LinkError;
use haptic_remote::serial::{Heard, SerialError, SerialLink};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How often a trial that says nothing about its law is made.
const TRIES: usize = 10;
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
    /// The law moved the device beyond a limit.
    Tripped,
    /// Nothing is known of the law, because of the line or this machine.
    Unjudged(Failure),
}

/// A serial device that is tried again and again, by one thread at a time.
pub struct Trials<'a> {
    remote: RemoteDevice,
    link: Mutex<SerialLink>,
    /// Settings of the device: no trial loosens them.
    set: Configuration,
    told: std::sync::Once,
    warn: Warn<'a>,
    /// Why no more trials can be made.
    failure: Mutex<Option<Failure>>,
    run: AtomicU32,
}

impl<'a> Trials<'a> {
    /// Connects.
    ///
    /// # Errors
    /// A device that cannot be used; a loop on the host, which trials do not do.
    pub fn new(remote: &RemoteDevice, warn: Warn<'a>, stop: &AtomicBool) -> Result<Self, Failure> {
        if remote.loop_mode == LoopMode::Host {
            return Err(Failure::bad_input(
                "a search runs in the device's own loop: leave `loop` = host away",
            ));
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
            run: AtomicU32::new(1),
        })
    }

    /// Position, m, and force, N, of each sample of one run; `None` if the law tripped the device, or if no more trials can be made,
    /// see [`failure`](Self::failure).
    pub fn motion(
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
                Ok(Trial::Whole(motion)) => return Some(motion),
                Ok(Trial::Tripped) => return None,
                Ok(Trial::Unjudged(_)) if tries < TRIES => continue,
                Ok(Trial::Unjudged(failure)) | Err(failure) => failure,
            };
            self.failed().get_or_insert(at_link(&link, failure));
            break;
        }
        None
    }

    /// Step of the device's encoder, m, and the largest force that it can do, N.
    pub fn encoder_and_force(&self) -> (f64, f64) {
        let link = self.link.lock().unwrap_or_else(PoisonError::into_inner);
        let can = link.capabilities();
        (
            f64::from(can.position_resolution_m),
            f64::from(can.force_max_n),
        )
    }

    /// Why the device cannot be used any more, if so.
    pub fn failure(self) -> Option<Failure> {
        self.failure
            .into_inner()
            .unwrap_or_else(PoisonError::into_inner)
    }

    fn failed(&self) -> std::sync::MutexGuard<'_, Option<Failure>> {
        self.failure.lock().unwrap_or_else(PoisonError::into_inner)
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
                return Err(Failure::Run(anyhow::anyhow!(
                    "{path}: {fault}, between two trials: no more are made"
                )));
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
                    if u64::from(sample.tick) == next && next < samples {
                        motion.push((f64::from(sample.position_m), f64::from(sample.force_n)));
                    }
                }
                Some(Heard::Event(event)) if event.kind == EventKind::Finished => {
                    return Ok(match motion.len() as u64 == samples {
                        true => Trial::Whole(motion),
                        false => Trial::Unjudged(lost(path, motion.len(), samples)),
                    });
                }
                Some(Heard::Vector(_) | Heard::Event(_)) => {}
                Some(Heard::Fault(report)) => {
                    let fault = Fault::from_code(report.status.fault);
                    match fault.filter(|_| link.lost_board().is_none()) {
                        Some(fault) if is_of_the_law(fault) => return Ok(Trial::Tripped),
                        Some(fault) if is_of_the_clock(fault) => {
                            return Ok(Trial::Unjudged(late(path, fault)));
                        }
                        _ => return Err(problem(LinkError::Faulted(report).into())),
                    }
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
        (!first && !is_of_the_law(latched) && !is_of_the_clock(latched)).then_some(latched)
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

/// A law that moves the device so is no stable one.
fn is_of_the_law(fault: Fault) -> bool {
    matches!(
        fault,
        Fault::NonFiniteForce
            | Fault::CurrentMismatch
            | Fault::Workspace
            | Fault::Velocity
            | Fault::PositionStuck
            | Fault::PositionJump
    )
}

/// Host, line or tick was late: nothing is known of the law.
fn is_of_the_clock(fault: Fault) -> bool {
    matches!(
        fault,
        Fault::HostSilent | Fault::TickOverrun | Fault::StaleForce
    )
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

#[cfg(test)]
mod tests {
    use super::*;
    use haptic_devices::NearLine;
    use haptic_devices::moteus::emulated::{EmulatedAdapter, EmulatedServo, Shaft};
    use haptic_devices::moteus::{MoteusAxis, MoteusSettings};
    use haptic_remote::serial::{DeviceTime, Served};
    use std::sync::Arc;

    /// An emulated servo in its own time, which runs and tells no sample; and its adapter.
    fn running_without_samples() -> (SerialLink, Arc<Mutex<EmulatedAdapter>>) {
        let servo = EmulatedServo::new(1, Shaft::LEVER).expect("a good servo");
        let adapter = Arc::new(Mutex::new(EmulatedAdapter::new(servo)));
        let time = DeviceTime::default();
        let line = NearLine::new(Arc::clone(&adapter), time.clone());
        let axis = MoteusAxis::open(line, MoteusSettings::DEFAULT, true).expect("answers");
        let served = Served::in_its_own_time(axis, time).expect("serves");
        let mut link = SerialLink::to_served(served, "moteus:emulated").expect("answers");
        link.arm(Duration::from_secs(1)).expect("arms");
        let rarely = Start {
            every: u16::MAX,
            ..Start::ENDLESS
        };
        link.start(rarely).expect("starts");
        (link, adapter)
    }

    #[test]
    fn a_silence_of_a_device_that_answers_is_no_end_of_the_search() {
        let (mut link, _adapter) = running_without_samples();
        let patience = Duration::from_millis(20);
        let trial = Trials::followed(&mut link, "here", 1000, patience);
        let Ok(Trial::Unjudged(failure)) = trial else {
            panic!("it is to be made again");
        };
        assert_eq!(failure.exit_code(), 3, "{failure}");
        // It was let go before anything else.
        assert!(link.wait_for_rest());
    }

    #[test]
    fn a_device_that_does_not_answer_ends_it_with_what_to_look_at() {
        let (mut link, adapter) = running_without_samples();
        let stuck = adapter.lock().expect("nobody panicked with it");
        let patience = Duration::from_millis(20);
        let Err(failure) = Trials::followed(&mut link, "here", 1000, patience) else {
            panic!("nothing more can be tried");
        };
        let said = failure.to_string();
        assert!(said.contains("look at its plug and supply"), "{said}");
        assert_eq!(failure.exit_code(), 3, "{said}");
        drop(stuck);
    }

    #[test]
    fn a_fault_is_of_the_law_or_of_the_clock_or_ends_the_search() {
        for fault in Fault::ALL {
            let ends = matches!(
                fault,
                Fault::EmergencyStop | Fault::Reset | Fault::BoardFailed
            );
            let kinds = [ends, is_of_the_law(fault), is_of_the_clock(fault)];
            assert_eq!(kinds.map(u8::from).iter().sum::<u8>(), 1, "{fault}");
        }
    }
}
