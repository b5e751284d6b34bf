//! A device without hardware: its side of the link behind a pseudo-terminal.
//!
//! ```text
//! serial port of a host ─▶ reader thread ─▶ faulty line ─▶ Session, TickSide ─▶ faulty line ─▶ writer thread
//! ```
//! The same state machine as in the firmware, ticked by the clock, or by a faster or slower one. When this
//! machine is too busy to tick in time the device's clock waits, as if everything on it had been slower:
//! an emulated device never reports faults that it would not have.

use crate::failure::Failure;
use haptic_link::FRAME_MAX;
use haptic_loop::remote::{FaultyLine, LineDamage, LineFaults, Session, SimulatedPlant, TickSide};
use serialport::{SerialPort as _, TTYPort};
use std::cell::RefCell;
use std::collections::hash_map::RandomState;
use std::hash::{BuildHasher as _, Hasher as _};
use std::io::{ErrorKind, Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::time::{Duration, Instant};

/// How far behind the clock the device may be before its own clock waits.
const BEHIND_MOST: Duration = Duration::from_millis(5);
/// Pieces of bytes that wait between the threads at most.
const WAITING_MOST: usize = 4096;

/// How a device is emulated.
#[derive(Clone, Debug, PartialEq)]
pub struct Emulation {
    /// Device seconds in a second.
    pub speed: f64,
    /// What the line does to frames, both ways.
    pub faults: LineFaults,
    /// Of the faults.
    pub seed: u64,
    /// A name for the pseudo-terminal: a symbolic link, gone at the end.
    pub link: Option<PathBuf>,
    /// For how long; `None` until stopped.
    pub duration: Option<Duration>,
}

/// What an emulated device did.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Emulated {
    /// Ticks of the device.
    pub ticks: u64,
    /// Frames from the host.
    pub frames_from_host: u64,
    /// Frames to the host.
    pub frames_to_host: u64,
    /// Frames that the line lost, both ways.
    pub dropped: u64,
    /// Frames that it damaged.
    pub corrupted: u64,
    /// Frames that it repeated.
    pub duplicated: u64,
    /// Frames that it held back.
    pub reordered: u64,
    /// Times it stood still.
    pub stalls: u64,
    /// Frames that nobody fetched.
    pub unread: u64,
}

/// A pseudo-terminal that a host can open.
#[derive(Debug)]
pub struct Terminal {
    master: TTYPort,
    /// Kept, so that a host may come and go.
    _slave: TTYPort,
    path: PathBuf,
    link: Option<PathBuf>,
}

impl Terminal {
    /// Makes one, with a symbolic link to it if asked for.
    ///
    /// # Errors
    /// If the system gives none, or the link cannot be made.
    pub fn open(link: Option<&Path>) -> Result<Self, Failure> {
        let failed = |what: &str, error: &dyn std::fmt::Display| {
            Failure::Device(anyhow::anyhow!("{what}: {error}"))
        };
        let (mut master, slave) =
            TTYPort::pair().map_err(|error| failed("no pseudo-terminal to be had", &error))?;
        // So that the reader thread notices the end.
        master
            .set_timeout(Duration::from_millis(20))
            .map_err(|error| failed("the pseudo-terminal does not take a timeout", &error))?;
        let name = slave.name();
        let path = name.ok_or_else(|| failed("the pseudo-terminal", &"it has no name"))?;
        let path = PathBuf::from(path);
        if let Some(link) = link {
            std::os::unix::fs::symlink(&path, link).map_err(|error| {
                Failure::bad_input(format_args!(
                    "cannot make the link `{}`: {error}; choose another with --link",
                    link.display()
                ))
            })?;
        }
        Ok(Self {
            master,
            _slave: slave,
            path,
            link: link.map(Path::to_owned),
        })
    }

    /// What a host opens.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.link.as_deref().unwrap_or(&self.path)
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        if let Some(link) = &self.link {
            // It leads nowhere from now on; nothing to be done if it is gone already.
            let _ = std::fs::remove_file(link);
        }
    }
}

/// Runs the device until it is stopped or its time is over.
///
/// # Errors
/// Faults outside their range; a pseudo-terminal that cannot be shared.
pub fn emulate(
    terminal: &Terminal,
    emulation: &Emulation,
    stop: &AtomicBool,
) -> Result<Emulated, Failure> {
    let mut from_host =
        FaultyLine::new(emulation.faults, emulation.seed).map_err(Failure::input)?;
    let mut to_host = FaultyLine::new(emulation.faults, emulation.seed.wrapping_add(1))
        .map_err(Failure::input)?;
    let clone = || {
        let port = terminal.master.try_clone_native();
        port.map_err(|error| Failure::Device(error.into()))
    };
    let (reading, writing) = (clone()?, clone()?);
    let over = AtomicBool::new(false);
    let plant = SimulatedPlant::new("emulated", || 0);
    let device = TickSide::new(plant)
        .map_err(|refusal| Failure::Run(anyhow::anyhow!("the emulated device: {refusal:?}")))?;
    let device = RefCell::new(device);
    // Another number for each emulated device, even of one process.
    let boot = RandomState::new().build_hasher().finish() as u32;
    let mut session = Session::new(firmware_version(), boot);

    let mut unread = 0;
    let mut ticks = 0;
    std::thread::scope(|scope| {
        let (arrived, arriving) = sync_channel::<Vec<u8>>(WAITING_MOST);
        let (leave, leaving) = sync_channel::<Vec<u8>>(WAITING_MOST);
        let over = &over;
        scope.spawn(move || read(reading, &arrived, over));
        scope.spawn(move || {
            let mut port = writing;
            while let Ok(frame) = leaving.recv() {
                write(&mut port, &frame, over);
            }
        });
        let mut clock = Clock::new(emulation.speed);
        let mut heard = Instant::now();
        let mut frame = Vec::new();
        let mut line = [0; FRAME_MAX];
        let mut send = |frame: Vec<u8>| {
            if let Err(TrySendError::Full(_)) = leave.try_send(frame) {
                unread += 1;
            }
        };
        while !stop.load(Ordering::Relaxed)
            && emulation
                .duration
                .is_none_or(|most| clock.began.elapsed() < most)
        {
            let period_us = u64::from(device.borrow().configuration().0.tick_period_us);
            let next_us = clock.ticked_us + period_us;
            let bytes = match arriving.recv_timeout(clock.until(next_us)) {
                Ok(bytes) => bytes,
                Err(RecvTimeoutError::Timeout) => Vec::new(),
                Err(RecvTimeoutError::Disconnected) => break,
            };
            let now_us = clock.now_us();
            for byte in bytes.into_iter().chain(arriving.try_iter().flatten()) {
                frame.push(byte);
                if byte == 0 || frame.len() > 4 * FRAME_MAX {
                    from_host.send(&frame, now_us);
                    frame.clear();
                }
            }
            while let Some(frame) = from_host.receive(now_us) {
                let fed = session.fed();
                for byte in frame {
                    // The device's time is that of its ticks, or its watchdog would see the future.
                    let length = session.receive(byte, clock.ticked_us, &device, &mut line);
                    if length > 0 {
                        to_host.send(&line[..length], now_us);
                    }
                }
                if session.fed() != fed {
                    heard = Instant::now();
                }
            }
            if now_us >= next_us {
                clock.ticked_us = next_us;
                let mut device = device.borrow_mut();
                // A host lives in real time, so that is what its silence is measured in.
                let watchdog_ms = device.configuration().0.limits.watchdog_ms;
                let silent = heard.elapsed() > Duration::from_millis(u64::from(watchdog_ms));
                if emulation.speed > 1.0 && !silent {
                    device.heard(next_us, true);
                }
                device.tick(next_us);
                ticks += 1;
                clock.catch_up(now_us);
            }
            loop {
                let length = session.poll(&device, &mut line);
                if length == 0 {
                    break;
                }
                to_host.send(&line[..length], now_us);
            }
            while let Some(frame) = to_host.receive(now_us) {
                send(frame);
            }
        }
        over.store(true, Ordering::Relaxed);
        drop(leave);
    });
    let (from, to) = (from_host.damage(), to_host.damage());
    let both = |count: fn(&LineDamage) -> u64| count(&from) + count(&to);
    Ok(Emulated {
        ticks,
        frames_from_host: from.sent,
        frames_to_host: to.sent,
        dropped: both(|damage| damage.dropped),
        corrupted: both(|damage| damage.corrupted),
        duplicated: both(|damage| damage.duplicated),
        reordered: both(|damage| damage.reordered),
        stalls: both(|damage| damage.stalls),
        unread,
    })
}

/// This program's version stands for that of a firmware.
fn firmware_version() -> [u8; 3] {
    let part = |text: &str| text.parse().unwrap_or(0);
    [
        part(env!("CARGO_PKG_VERSION_MAJOR")),
        part(env!("CARGO_PKG_VERSION_MINOR")),
        part(env!("CARGO_PKG_VERSION_PATCH")),
    ]
}

fn read(mut port: TTYPort, arrived: &SyncSender<Vec<u8>>, over: &AtomicBool) {
    let mut bytes = [0; 1024];
    while !over.load(Ordering::Relaxed) {
        match port.read(&mut bytes) {
            Ok(count) => {
                if arrived.send(bytes[..count].to_vec()).is_err() {
                    return;
                }
            }
            Err(error) if error.kind() == ErrorKind::TimedOut => {}
            // Nobody has it open.
            Err(_) => std::thread::sleep(Duration::from_millis(5)),
        }
    }
}

/// Writes a frame, however long the host takes: one that does not read at all fills the queue before this,
/// and what finds no room there is counted.
fn write(port: &mut TTYPort, frame: &[u8], over: &AtomicBool) {
    let mut rest = frame;
    while !rest.is_empty() && !over.load(Ordering::Relaxed) {
        match port.write(rest) {
            Ok(count) => rest = &rest[count..],
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => {}
            // Nobody has it open.
            Err(_) => return,
        }
    }
}

/// The device's clock: real time, scaled, and held back when the machine is busy.
struct Clock {
    began: Instant,
    speed: f64,
    /// Device time that was held back, µs.
    held_us: u64,
    /// Device time of the last tick, µs.
    ticked_us: u64,
}

impl Clock {
    fn new(speed: f64) -> Self {
        Self {
            began: Instant::now(),
            speed,
            held_us: 0,
            ticked_us: 0,
        }
    }

    fn now_us(&self) -> u64 {
        let scaled = self.began.elapsed().as_secs_f64() * 1e6 * self.speed;
        (scaled as u64).saturating_sub(self.held_us)
    }

    /// Real time until a device time.
    fn until(&self, device_us: u64) -> Duration {
        let ahead = device_us.saturating_sub(self.now_us());
        Duration::from_secs_f64(ahead as f64 * 1e-6 / self.speed)
    }

    fn catch_up(&mut self, now_us: u64) {
        let most = (BEHIND_MOST.as_micros() as f64 * self.speed) as u64;
        let behind = now_us.saturating_sub(self.ticked_us);
        self.held_us += behind.saturating_sub(most);
    }
}
