//! A line between a program and an emulated device that loses or changes what a test wants.

use super::Emulated;
use haptic_link::{DeviceReport, Direction, FRAME_MAX, Receiver, encode};
use std::io::{Read, Write};
use std::net::Shutdown;
use std::os::unix::net::{UnixListener, UnixStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::channel;
use std::sync::{Arc, Mutex};

type Passes = Arc<Mutex<dyn FnMut(DeviceReport) -> Option<DeviceReport> + Send>>;

/// The line: at the socket `line`, before the device at the socket `device`.
pub(super) struct Middle {
    deaf: Arc<AtomicBool>,
    floods: Floods,
}

/// What comes instead of the device's messages.
type Floods = Arc<Mutex<Option<&'static [u8]>>>;

impl Middle {
    /// Loses the messages of the device for which this is true.
    pub(super) fn before(
        device: &Emulated,
        mut loses: impl FnMut(&DeviceReport) -> bool + Send + 'static,
    ) -> Self {
        Self::changing(device, move |report| (!loses(&report)).then_some(report))
    }

    /// Passes on what this makes of the messages of the device.
    pub(super) fn changing(
        device: &Emulated,
        passes: impl FnMut(DeviceReport) -> Option<DeviceReport> + Send + 'static,
    ) -> Self {
        let path = device.place.path("device");
        let listener = UnixListener::bind(device.place.path("line")).expect("a socket");
        let deaf = Arc::new(AtomicBool::new(false));
        let heard = Arc::clone(&deaf);
        let passes: Passes = Arc::new(Mutex::new(passes));
        let floods = Floods::default();
        let flooded = Arc::clone(&floods);
        std::thread::spawn(move || {
            while let Ok((host, _)) = listener.accept() {
                let device = UnixStream::connect(&path).expect("an emulator");
                let ends = (clone(&host), clone(&device));
                let heard = Arc::clone(&heard);
                std::thread::spawn(move || to_device(ends.0, ends.1, &heard));
                let (passes, floods) = (Arc::clone(&passes), Arc::clone(&flooded));
                std::thread::spawn(move || to_host(device, host, &passes, floods));
            }
        });
        Self { deaf, floods }
    }

    /// Lets the host hear this alone from now on, over and over without a pause, or nothing.
    pub(super) fn floods(&self, words: &'static [u8]) {
        *self.floods.lock().expect("nobody panicked") = Some(words);
    }

    /// Nothing reaches the device any more.
    pub(super) fn deafen(&self) {
        self.deaf.store(true, Ordering::Relaxed);
    }
}

fn clone(stream: &UnixStream) -> UnixStream {
    stream.try_clone().expect("another handle")
}

/// What comes from a stream, until its end, or until nobody takes it; then both are over.
fn each(
    mut from: UnixStream,
    mut to: UnixStream,
    mut pass: impl FnMut(&[u8], &mut UnixStream) -> bool,
) {
    let mut bytes = [0; 4096];
    while let Ok(count @ 1..) = from.read(&mut bytes)
        && pass(&bytes[..count], &mut to)
    {}
    // Whoever has gone already has nothing to be told.
    let _ = from.shutdown(Shutdown::Both);
    let _ = to.shutdown(Shutdown::Both);
}

fn to_device(host: UnixStream, device: UnixStream, deaf: &AtomicBool) {
    each(host, device, |bytes, device| {
        deaf.load(Ordering::Relaxed) || device.write_all(bytes).is_ok()
    });
}

/// A host that stands still keeps nothing of this end waiting.
fn to_host(device: UnixStream, mut host: UnixStream, passes: &Passes, floods: Floods) {
    let mut receiver = Receiver::<DeviceReport>::new(Direction::FromDevice);
    let mut frame = Vec::new();
    let (queue, frames) = channel::<Vec<u8>>();
    let end = clone(&host);
    std::thread::spawn(move || {
        frames.iter().all(|frame| {
            let words = *floods.lock().expect("nobody panicked");
            let Some(words) = words else {
                return host.write_all(&frame).is_ok();
            };
            while !words.is_empty() && host.write_all(words).is_ok() {}
            words.is_empty()
        })
    });
    each(device, end, |bytes, _| {
        bytes.iter().all(|&byte| {
            frame.push(byte);
            let report = receiver.push(byte);
            if byte != 0 {
                return true;
            }
            let whole = std::mem::take(&mut frame);
            let Some((header, report)) = report else {
                return queue.send(whole).is_ok();
            };
            let mut passes = passes.lock().expect("nobody panicked");
            let Some(report) = (*passes)(report) else {
                return true;
            };
            let mut line = [0; FRAME_MAX];
            let length = encode(&report, header, &mut line).expect("fits");
            queue.send(line[..length].to_vec()).is_ok()
        })
    });
}
