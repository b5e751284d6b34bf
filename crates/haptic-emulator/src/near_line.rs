//! A device without hardware in this process, in the time of whoever serves it.

use crate::at_line::AtLine;
use haptic_remote::serial::{DeviceTime, Line};
use std::collections::VecDeque;
use std::fmt;
use std::io::{self, ErrorKind, Read, Write};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// A line to an emulated device of this process. It lives in the time of the thread that
/// [serves](haptic_remote::serial::Served::in_its_own_time) the hardware before it, answers at once and is never late: what a
/// busy machine makes of it is slow, and the same.
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
    said: VecDeque<u8>,
}

impl<D: AtLine> NearLine<D> {
    /// To a device that others may look at meanwhile.
    #[must_use]
    pub const fn new(device: Arc<Mutex<D>>, time: DeviceTime) -> Self {
        Self {
            device,
            time,
            said: VecDeque::new(),
        }
    }

    /// The device; whole between two calls, whoever has panicked with it.
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
        if self.said.is_empty() {
            return Err(ErrorKind::TimedOut.into());
        }
        self.said.read(into)
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
        self.said.extend(answer);
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
