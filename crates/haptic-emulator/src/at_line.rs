//! A device without hardware at the other end of a line: by the clock, or in the time of whoever serves it.

use crate::{FaultyLine, LineDamage, LineFaults};
use haptic_loop::{LoopParameterError, realtime::Moment};
use haptic_remote::serial::{DeviceTime, Line};
use std::{
    collections::VecDeque,
    fmt,
    io::{self, ErrorKind, Read, Write},
    sync::{
        Arc, Mutex, MutexGuard, PoisonError,
        atomic::{AtomicBool, Ordering},
    },
    time::Duration,
};

/// Longest wait of a read: the device advances at least once in this time.
const PATIENCE: Duration = Duration::from_millis(1);
/// Pause while no host has the port open.
pub(crate) const NOBODY: Duration = Duration::from_millis(5);

/// A device without hardware that takes bytes and answers in bytes. Time is an argument, µs.
pub trait AtLine {
    /// Lets time pass up to this moment.
    fn advance(&mut self, now_us: u64);

    /// Takes a byte, and appends what there is to say.
    fn receive(&mut self, byte: u8, now_us: u64, out: &mut Vec<u8>);
}

/// Damage that a line did to the bytes of both directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DuplexDamage {
    /// Damage to requests; the device answers only those that arrive intact.
    pub to_device: LineDamage,
    /// Damage to answers; the host waits for a lost one until it times out.
    pub to_host: LineDamage,
}

/// Runs a device at this end of a line until it is stopped or its time is over. Each fault concerns
/// a single byte.
///
/// # Errors
/// Faults outside their range.
pub fn emulate(
    mut line: Box<dyn Line>,
    device: &mut impl AtLine,
    (faults, seed): (LineFaults, u64),
    duration: Option<Duration>,
    stop: &AtomicBool,
) -> Result<DuplexDamage, LoopParameterError> {
    let [mut to_device, mut to_host] = FaultyLine::both_ways(faults, seed)?;
    // As it was before, if the line has no patience.
    let _ = line.set_patience(PATIENCE);
    let began = Moment::now();
    let mut bytes = [0; 1024];
    let mut answer = Vec::new();
    while !stop.load(Ordering::Relaxed) && duration.is_none_or(|most| began.elapsed() < most) {
        let count = match line.read(&mut bytes) {
            Ok(count) => count,
            Err(error) if error.kind() == ErrorKind::TimedOut => 0,
            Err(_) => {
                std::thread::sleep(NOBODY);
                0
            }
        };
        let now_us = began.elapsed().as_micros() as u64;
        device.advance(now_us);
        for byte in carried(&mut to_device, &bytes[..count], now_us) {
            device.receive(byte, now_us, &mut answer);
        }
        // Whoever does not read has lost them.
        let _ = line.write_all(&carried(&mut to_host, &answer, now_us));
        answer.clear();
    }
    Ok(DuplexDamage {
        to_device: to_device.damage(),
        to_host: to_host.damage(),
    })
}

/// Puts bytes on a bad line, and takes off what has arrived.
fn carried(line: &mut FaultyLine, bytes: &[u8], now_us: u64) -> Vec<u8> {
    // A line without faults carries thousands of bytes a second more cheaply.
    if line.is_ideal() {
        return bytes.to_vec();
    }
    for byte in bytes {
        line.send(core::slice::from_ref(byte), now_us);
    }
    let mut through = Vec::new();
    while let Some(byte) = line.receive(now_us) {
        through.extend(byte);
    }
    through
}

/// A line to an emulated device of this process. Its clock is that of the thread that
/// [serves](haptic_remote::serial::Served::in_its_own_time) the hardware before it, answers at once
/// and never late: on a busy machine it runs slowly, but with the same results.
///
/// ```
/// use haptic_emulator::NearLine;
/// use haptic_emulator::moteus::{EmulatedAdapter, EmulatedServo, Shaft};
/// use haptic_devices::moteus::{MoteusAxis, MoteusSettings};
/// use haptic_remote::serial::{DeviceTime, SerialLink, Served};
/// use std::sync::{Arc, Mutex};
///
/// let servo = EmulatedServo::new(1, Shaft::LEVER)?;
/// let adapter = Arc::new(Mutex::new(EmulatedAdapter::new(servo)));
/// let time = DeviceTime::default();
/// let line = NearLine::new(adapter, time.clone());
/// let axis = MoteusAxis::open(line, MoteusSettings::DEFAULT, true)?;
/// let link = SerialLink::to_served(Served::in_its_own_time(axis, time)?, "moteus:emulated")?;
/// assert_eq!(link.capabilities().board(), "moteus");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct NearLine<D> {
    device: Arc<Mutex<D>>,
    time: DeviceTime,
    answers: VecDeque<u8>,
}

impl<D: AtLine> NearLine<D> {
    /// A connection to a device that others may inspect meanwhile.
    #[must_use]
    pub const fn new(device: Arc<Mutex<D>>, time: DeviceTime) -> Self {
        Self {
            device,
            time,
            answers: VecDeque::new(),
        }
    }

    fn device(&self) -> MutexGuard<'_, D> {
        self.device.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<D> fmt::Debug for NearLine<D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("NearLine").finish_non_exhaustive()
    }
}

impl<D: AtLine> Read for NearLine<D> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if self.answers.is_empty() {
            return Err(ErrorKind::TimedOut.into());
        }
        self.answers.read(into)
    }
}

impl<D: AtLine> Write for NearLine<D> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let now_us = self.time.now_us();
        let mut answer = Vec::new();
        let mut device = self.device();
        device.advance(now_us);
        for byte in bytes {
            device.receive(*byte, now_us, &mut answer);
        }
        drop(device);
        self.answers.extend(answer);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl<D: AtLine + Send> Line for NearLine<D> {
    fn share(&self) -> io::Result<Box<dyn Line>> {
        Err(ErrorKind::Unsupported.into())
    }

    fn set_baud_rate(&mut self, _: u32) {}

    fn set_patience(&mut self, _: Duration) -> io::Result<()> {
        Ok(())
    }
}
