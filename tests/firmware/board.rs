//! The device under QEMU, spoken to through a socket: its bytes come at once, however busy the machine is.

use super::image::Qemu;
use haptic_link::{EventKind, Sample};
use haptic_remote::serial::{ConnectOptions, DeviceMessage, SerialError, SerialLink};
use std::io::Write as _;
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use testkit::Folder;

/// Longest wait for anything; an emulator on a busy machine may stand still for a while.
const PATIENCE: Duration = testkit::PATIENCE;
/// Where the stack ends.
const STACK_END: u32 = 0x2000_0000;
/// What the start-up code paints an unused stack with.
const PAINT: [u8; 4] = 0xCCCC_CCCC_u32.to_le_bytes();

/// QEMU with the device in it, and its line, which nobody has open.
#[derive(Debug)]
pub(crate) struct Emulator {
    qemu: Qemu,
    path: String,
    /// Folder of the socket.
    _folder: Folder,
}

impl Emulator {
    pub(crate) fn start(image: &Path) -> Self {
        let folder = Folder::empty();
        let path = folder.join("line").display().to_string();
        let line = format!("socket,id=line,path={path},server=on,wait=off");
        let mut child = Command::new("qemu-system-arm")
            .args(["-M", "mps2-an386", "-display", "none", "-monitor", "stdio"])
            .args(["-chardev", &line, "-serial", "chardev:line", "-kernel"])
            .arg(image)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .spawn()
            .expect("QEMU starts");
        while UnixStream::connect(&path).is_err() {
            let ended = child.try_wait().expect("a child");
            assert_eq!(ended, None, "QEMU ended at once");
            std::thread::sleep(Duration::from_millis(5));
        }
        let qemu = Qemu(child);
        Self {
            qemu,
            path,
            _folder: folder,
        }
    }

    /// What a host opens.
    pub(crate) fn path(&self) -> &str {
        &self.path
    }

    /// The device as a host has it.
    pub(crate) fn connected(&self) -> Result<SerialLink, SerialError> {
        let options = ConnectOptions {
            patience: PATIENCE,
            ..ConnectOptions::default()
        };
        SerialLink::connect(&self.path, options)
    }

    /// Bytes of the stack that were ever used, by its paint.
    pub(crate) fn stack_used(&mut self, stack: u32) -> u32 {
        let folder = Folder::empty();
        let dump = folder.join("stack");
        let order = format!("pmemsave {STACK_END} {} \"{}\"\n", stack, dump.display());
        let monitor = self.qemu.0.stdin.as_mut().expect("piped");
        monitor.write_all(order.as_bytes()).expect("QEMU listens");
        let deadline = Instant::now() + PATIENCE;
        loop {
            let bytes = std::fs::read(&dump).unwrap_or_default();
            if bytes.len() == stack as usize {
                let painted = bytes.chunks(4).take_while(|word| **word == PAINT).count();
                return stack - u32::try_from(4 * painted).expect("small");
            }
            assert!(Instant::now() < deadline, "no dump of the stack");
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

/// Samples of a run until its end is told.
pub(crate) fn samples(link: &mut SerialLink) -> Vec<Sample> {
    let mut samples: Vec<Sample> = Vec::new();
    loop {
        match link.hear(PATIENCE) {
            Some(DeviceMessage::Sample(sample)) => samples.push(sample),
            Some(DeviceMessage::Event(event)) if event.kind == EventKind::Finished => {
                return samples;
            }
            Some(DeviceMessage::Event(_)) => {}
            other => panic!("after {} samples: {other:?}", samples.len()),
        }
    }
}
