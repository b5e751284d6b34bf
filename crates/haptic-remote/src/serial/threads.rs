//! The two threads of a link.

use super::line::Line;
use super::shared::{Command, Heard, Shared, lock};
use crate::{Incoming, LinkError};
use haptic_link::{FRAME_MAX, Report};
use std::boxed::Box;
use std::io::ErrorKind;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError};
use std::time::{Duration, Instant};

/// The thread that listens.
pub(super) struct Reader {
    pub(super) shared: Arc<Shared>,
    pub(super) answers: SyncSender<Result<Report, LinkError>>,
    pub(super) heard: SyncSender<Heard>,
}

impl Reader {
    pub(super) fn run(self, mut port: Box<dyn Line>) {
        let mut bytes = [0; 1024];
        while !self.shared.over.load(Ordering::Relaxed) {
            let count = match port.read(&mut bytes) {
                Ok(0) => return self.end(LinkError::Gone),
                Ok(count) => count,
                Err(error)
                    if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) =>
                {
                    continue;
                }
                Err(_) => return self.end(LinkError::Gone),
            };
            let now_us = self.shared.now_us();
            for &byte in &bytes[..count] {
                let incoming = self.shared.conversation().receive(byte, now_us);
                if let Some(incoming) = incoming {
                    self.pass_on(incoming);
                }
            }
        }
    }

    fn pass_on(&self, incoming: Incoming) {
        match incoming {
            // Nobody waits when the queue is full.
            Incoming::Answer(report) => {
                let _ = self.answers.try_send(Ok(report));
            }
            Incoming::Refused { request, refusal } => {
                let refused = LinkError::Refused { request, refusal };
                let _ = self.answers.try_send(Err(refused));
            }
            Incoming::Alive {
                round_trip_us,
                newest,
                status,
                observed_energy_j,
            } => {
                lock(&self.shared.round_trip_us).saturating_record(round_trip_us.max(1));
                if !newest {
                    return;
                }
                let bits = observed_energy_j.to_bits();
                self.shared.energy_bits.store(bits, Ordering::Relaxed);
                *lock(&self.shared.status) = status;
                self.shared.alives.fetch_add(1, Ordering::Release);
            }
            Incoming::Rebooted => self.end(LinkError::Rebooted),
            Incoming::Begun(report) => {
                self.pass_on(Incoming::Told(report.clone()));
                let _ = self.answers.try_send(Ok(report));
            }
            Incoming::Told(Report::Sample(sample)) => self.hear(Heard::Sample(sample)),
            Incoming::Told(Report::Batch(batch)) => {
                for sample in batch.samples(self.shared.period_us.load(Ordering::Relaxed)) {
                    self.hear(Heard::Sample(sample));
                }
            }
            Incoming::Told(Report::Event(event)) => self.hear(Heard::Event(event)),
            Incoming::Told(Report::Fault(report)) => {
                *lock(&self.shared.status) = report.status;
                self.hear(Heard::Fault(report));
            }
            // Late answers to requests that were given up.
            Incoming::Told(_) => {}
        }
    }

    fn hear(&self, heard: Heard) {
        if let Err(TrySendError::Full(_)) = self.heard.try_send(heard) {
            self.shared.samples_dropped.fetch_add(1, Ordering::Relaxed);
        }
    }

    fn end(&self, error: LinkError) {
        end(&self.shared, &self.answers, &self.heard, error);
    }
}

/// The thread that speaks.
pub(super) struct Writer {
    pub(super) shared: Arc<Shared>,
    pub(super) answers: SyncSender<Result<Report, LinkError>>,
    pub(super) heard: SyncSender<Heard>,
}

impl Writer {
    pub(super) fn run(self, mut port: Box<dyn Line>, commands: &Receiver<Command>) {
        /// Time to wait when nothing is due.
        const IDLE: Duration = Duration::from_millis(50);
        let mut line = [0; FRAME_MAX];
        let mut broken = false;
        while !broken {
            let due = self.shared.conversation().next_due_us();
            let wait = due.map_or(IDLE, |due| {
                Duration::from_micros(due.saturating_sub(self.shared.now_us()))
            });
            let command = commands.recv_timeout(wait.min(IDLE));
            let now_us = self.shared.now_us();
            let length = match command {
                Ok(Command::Ask(request)) => {
                    self.shared.conversation().ask(request, now_us, &mut line)
                }
                Ok(Command::Tell(request)) => self.shared.conversation().tell(&request, &mut line),
                Err(RecvTimeoutError::Timeout) => 0,
                Err(RecvTimeoutError::Disconnected) => return,
            };
            broken = length > 0 && !write(port.as_mut(), &line[..length]);
            if broken || self.shared.over.load(Ordering::Relaxed) {
                break;
            }
            let due = self.shared.conversation().due(now_us, &mut line);
            match due {
                Ok(0) => {}
                Ok(length) => broken = !write(port.as_mut(), &line[..length]),
                Err(error) => {
                    let _ = self.answers.try_send(Err(error));
                }
            }
        }
        end(&self.shared, &self.answers, &self.heard, LinkError::Gone);
        // The last request may have been taken but not sent.
        let _ = self.answers.try_send(Err(LinkError::Gone));
        // Whoever asks from now on must hear that nobody listens.
        while let Ok(command) = commands.recv() {
            if let Command::Ask(_) = command {
                let _ = self.answers.try_send(Err(LinkError::Gone));
            }
        }
    }
}

/// Writes it all, and says whether the line took it. A line that is slower than what is sent, as an emulated
/// one may be, is waited for; one that takes nothing for a second is gone.
pub(super) fn write(port: &mut dyn Line, mut bytes: &[u8]) -> bool {
    let mut moved = Instant::now();
    while !bytes.is_empty() {
        match port.write(bytes) {
            Ok(0) => return false,
            Ok(count) => {
                bytes = &bytes[count..];
                moved = Instant::now();
            }
            Err(error) => {
                let busy = matches!(
                    error.kind(),
                    ErrorKind::TimedOut | ErrorKind::Interrupted | ErrorKind::WouldBlock
                );
                if !busy || moved.elapsed() > Duration::from_secs(1) {
                    return false;
                }
            }
        }
    }
    true
}

/// Tells everybody that the session is over; the first reason counts.
fn end(
    shared: &Shared,
    answers: &SyncSender<Result<Report, LinkError>>,
    heard: &SyncSender<Heard>,
    error: LinkError,
) {
    if !shared.over.swap(true, Ordering::Relaxed) {
        let _ = heard.try_send(Heard::Over(error));
        let _ = answers.try_send(Err(error));
    }
}
