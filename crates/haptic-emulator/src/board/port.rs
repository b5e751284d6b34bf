//! The two threads at our end of the line.

use crate::at_line::NOBODY;
use haptic_remote::serial::Line;
use std::io::ErrorKind;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender};

/// Reads until over.
pub(super) fn read(mut port: Box<dyn Line>, arrived: &SyncSender<Vec<u8>>, over: &AtomicBool) {
    let mut bytes = [0; 1024];
    while !over.load(Ordering::Relaxed) {
        match port.read(&mut bytes) {
            Ok(count) => {
                if arrived.send(Vec::from(&bytes[..count])).is_err() {
                    return;
                }
            }
            Err(error) if error.kind() == ErrorKind::TimedOut => {}
            // Nobody has it open.
            Err(_) => std::thread::sleep(NOBODY),
        }
    }
}

/// Bytes written at once at most. On a busy machine frames wait, and one call for each of them would let more wait.
const AT_ONCE: usize = 4096;

/// Writes frames until there are no more.
pub(super) fn write_all(mut port: Box<dyn Line>, leaving: &Receiver<Vec<u8>>, over: &AtomicBool) {
    while let Ok(mut bytes) = leaving.recv() {
        while bytes.len() < AT_ONCE
            && let Ok(frame) = leaving.try_recv()
        {
            bytes.extend(frame);
        }
        write(port.as_mut(), &bytes, over);
    }
}

/// Writes frames, however long the host takes: one that does not read at all fills the queue before this,
/// and what finds no room there is counted.
fn write(port: &mut dyn Line, frames: &[u8], over: &AtomicBool) {
    let mut rest = frames;
    while !rest.is_empty() && !over.load(Ordering::Relaxed) {
        match port.write(rest) {
            Ok(count) => rest = &rest[count..],
            Err(error) if matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::Interrupted) => {}
            // Nobody has it open.
            Err(_) => return,
        }
    }
}
