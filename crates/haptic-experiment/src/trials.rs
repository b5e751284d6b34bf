//! Many short runs on one serial device, without log or files: what a search is made of.

use super::realtime::RealtimeOptions;
use super::remote::{RemoteDevice, RemoteLaw, configuration, keep_within};
use super::schedule::{Pace, Schedule};
use crate::device::{Warn, at_link, at_port, refused_at_port};
use crate::failure::Failure;
use haptic_link::{Configuration, EventKind, LoopMode, Scope, Start};
use haptic_remote::LinkError;
use haptic_remote::serial::{Heard, SerialLink};
use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

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
    run: std::sync::atomic::AtomicU32,
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
            run: std::sync::atomic::AtomicU32::new(1),
        })
    }

    /// Position, m, and force, N, of each sample of one run; `None` if it did not reach its end, samples were
    /// lost, or the device cannot be used any more, see [`failure`](Self::failure).
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
        match self.try_once(&mut link, law, samples, sample_time_s) {
            Ok(motion) => motion,
            Err(failure) => {
                self.failed().get_or_insert(at_link(&link, failure));
                None
            }
        }
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
    ) -> Result<Option<Vec<(f64, f64)>>, Failure> {
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
        link.set_for(configuration, &law.operator.1, Scope::Run)
            .map_err(problem)?;
        let watchdog = Duration::from_millis(u64::from(self.remote.watchdog_ms()));
        link.arm(watchdog).map_err(problem)?;
        let run = self.run.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        let start = Start {
            run,
            ticks: samples as u32,
            every: 1,
            batch: 8,
        };
        link.start(start).map_err(problem)?;
        let mut motion = Vec::with_capacity(samples as usize);
        let whole = loop {
            match link.hear(Duration::from_secs(2)) {
                Some(Heard::Sample(sample)) => {
                    let next = motion.len() as u64;
                    if u64::from(sample.tick) == next && next < samples {
                        motion.push((f64::from(sample.position_m), f64::from(sample.force_n)));
                    }
                }
                Some(Heard::Event(event)) if event.kind == EventKind::Finished => {
                    break motion.len() as u64 == samples;
                }
                Some(Heard::Vector(_) | Heard::Event(_)) => {}
                Some(Heard::Fault(report)) if link.lost_board().is_some() => {
                    return Err(problem(LinkError::Faulted(report).into()));
                }
                // A wall that trips the device is no stable one.
                Some(Heard::Fault(_)) => break false,
                Some(Heard::Over(error)) => return Err(problem(error.into())),
                None => return Err(problem(LinkError::NoSamples { waited_ms: 2000 }.into())),
            }
        };
        link.disarm().map_err(problem)?;
        Ok(whole.then_some(motion))
    }
}

impl std::fmt::Debug for Trials<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Trials")
            .field("remote", &self.remote)
            .finish_non_exhaustive()
    }
}
