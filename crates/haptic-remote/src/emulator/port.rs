//! The two threads at our end of the pseudo-terminal.

use serialport::TTYPort;
use std::io::{ErrorKind, Read as _, Write as _};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::SyncSender;
use std::time::Duration;
use std::vec::Vec;

/// Reads until over.
pub(super) fn read(mut port: TTYPort, arrived: &SyncSender<Vec<u8>>, over: &AtomicBool) {
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
            Err(_) => std::thread::sleep(Duration::from_millis(5)),
        }
    }
}

/// Writes a frame, however long the host takes: one that does not read at all fills the queue before this,
/// and what finds no room there is counted.
pub(super) fn write(port: &mut TTYPort, frame: &[u8], over: &AtomicBool) {
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
