//! Many short runs on one serial device, without log or files: what a search is made of.

use super::realtime::RealtimeOptions;
use super::remote::{RemoteDevice, RemoteLaw, configuration};
use super::run::{Pace, Schedule};
use crate::device::at_port;
use crate::failure::Failure;
use haptic_link::{EventKind, LoopMode, Start};
use haptic_loop::remote::LinkError;
use haptic_loop::remote::serial::{Heard, SerialError, SerialLink};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// A serial device that is tried again and again, by one thread at a time.
#[derive(Debug)]
pub struct Trials {
    remote: RemoteDevice,
    link: Mutex<SerialLink>,
    /// Why no more trials can be made.
    failure: Mutex<Option<Failure>>,
    run: std::sync::atomic::AtomicU32,
}

impl Trials {
    /// Connects.
    ///
    /// # Errors
    /// A device that cannot be used; a loop on the host, which trials do not do.
    pub fn new(remote: &RemoteDevice) -> Result<Self, Failure> {
        if remote.loop_mode == LoopMode::Host {
            return Err(Failure::bad_input(
                "a search runs in the device's own loop: leave --loop host away",
            ));
        }
        Ok(Self {
            link: Mutex::new(remote.name.connect(remote.patience)?),
            remote: remote.clone(),
            failure: Mutex::new(None),
            run: std::sync::atomic::AtomicU32::new(1),
        })
    }

    /// The positions of one run, m; `None` if it did not reach its end, samples were lost, or the device
    /// cannot be used any more, see [`failure`](Self::failure).
    pub fn positions(&self, law: &RemoteLaw, samples: u64, sample_time_s: f64) -> Option<Vec<f64>> {
        if self.failed().is_some() {
            return None;
        }
        let mut link = self.link.lock().unwrap_or_else(PoisonError::into_inner);
        match self.try_once(&mut link, law, samples, sample_time_s) {
            Ok(positions) => positions,
            Err(failure) => {
                self.failed().get_or_insert(failure);
                None
            }
        }
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
    ) -> Result<Option<Vec<f64>>, Failure> {
        let schedule = Schedule {
            samples,
            sample_time_s,
            pace: Pace::Realtime(RealtimeOptions::NORMAL),
        };
        // A search does not end where the device's limits do, so it keeps none of them.
        let present = haptic_link::Limits::DEFAULT;
        let mut configuration =
            configuration(&self.remote, law, schedule, link.capabilities(), &present)?;
        let (limits, can) = (&mut configuration.limits, link.capabilities());
        limits.force_n = limits.force_n.min(can.force_max_n);
        limits.force_rate_n_per_s = limits.force_rate_n_per_s.min(can.force_rate_max_n_per_s);
        let path = link.path().to_owned();
        let problem = |error: SerialError| {
            if error.is_refusal() {
                Failure::bad_input(error)
            } else {
                at_port(&path, &error)
            }
        };
        link.set(configuration, &law.operator.1).map_err(problem)?;
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
        let mut positions = Vec::with_capacity(samples as usize);
        let whole = loop {
            match link.hear(Duration::from_secs(2)) {
                Some(Heard::Sample(sample)) => {
                    if u64::from(sample.tick) == positions.len() as u64
                        && (positions.len() as u64) < samples
                    {
                        positions.push(f64::from(sample.position_m));
                    }
                }
                Some(Heard::Event(event)) if event.kind == EventKind::Finished => {
                    break positions.len() as u64 == samples;
                }
                Some(Heard::Event(_)) => {}
                // A wall that trips the device is no stable one.
                Some(Heard::Fault(_)) => break false,
                Some(Heard::Over(error)) => return Err(problem(error.into())),
                None => return Err(problem(LinkError::NoSamples { waited_ms: 2000 }.into())),
            }
        };
        link.disarm().map_err(problem)?;
        Ok(whole.then_some(positions))
    }
}
