//! Sink of the bytes of a log: counts them, and omits those that a second writer on the same file repeats.

use std::io::{self, Seek, SeekFrom, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// A sink that can be made deaf, and counts what it takes.
pub(super) struct Sink<W> {
    pub(super) inner: W,
    control: Control,
}

/// Reaches a sink that a writer owns.
#[derive(Clone, Debug, Default)]
pub(super) struct Control {
    deaf: Arc<AtomicBool>,
    bytes: Arc<AtomicU64>,
}

impl Control {
    /// Drops the bytes written from now on if `deaf`, or takes them again.
    pub(super) fn set_deaf(&self, deaf: bool) {
        self.deaf.store(deaf, Ordering::Relaxed);
    }

    /// Bytes taken.
    pub(super) fn bytes(&self) -> u64 {
        self.bytes.load(Ordering::Relaxed)
    }
}

impl<W> Sink<W> {
    pub(super) const fn new(inner: W, control: Control) -> Self {
        Self { inner, control }
    }
}

impl<W: Write> Write for Sink<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.control.deaf.load(Ordering::Relaxed) {
            return Ok(bytes.len());
        }
        let taken = self.inner.write(bytes)?;
        (self.control.bytes).fetch_add(taken as u64, Ordering::Relaxed);
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

impl<W: Seek> Seek for Sink<W> {
    fn seek(&mut self, place: SeekFrom) -> io::Result<u64> {
        self.inner.seek(place)
    }
}
