//! Ports that are none, that are in use, or that have something else behind them than a device.

use super::Emulated;
use crate::process::Place;
use haptic_link::FRAME_MAX;
use serialport::SerialPort as _;
use serialport::TTYPort;
use std::io::Read as _;
use std::io::Write as _;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

#[test]
fn a_port_that_is_in_use_is_refused() {
    let device = Emulated::at_terminal("device", "");
    let path = device.place.path("device");
    let port = serialport::new(path.to_string_lossy(), 460_800).open_native();
    let _held = port.expect("opens");
    device
        .place
        .run("device info --device serial:device")
        .refused(3, &["device", "in use by another program"]);
}

#[test]
fn ports_that_are_none_are_refused() {
    let place = Place::new();
    for (line, code, words) in [
        ("relax --device serial:/dev/null", 3, "no serial port"),
        (
            "device info --device serial:nowhere",
            3,
            "there is no port nowhere",
        ),
        ("relax --device serial:x@fast", 2, "baud"),
        ("device info --device sim", 2, "serial:PATH"),
    ] {
        place.run(line).refused(code, &[words]);
    }
    assert!(place.files().is_empty(), "{:?}", place.files());
}

/// A port with something else behind it than a device, until dropped.
struct Impostor {
    path: PathBuf,
    over: Arc<AtomicBool>,
    thread: Option<std::thread::JoinHandle<()>>,
    _slave: TTYPort,
}

impl Impostor {
    /// `answer` is given each piece of bytes that comes, and what it returns is sent.
    fn new(mut answer: impl FnMut(&[u8]) -> Vec<u8> + Send + 'static) -> Self {
        let (mut master, slave) = TTYPort::pair().expect("a pseudo-terminal");
        master
            .set_timeout(Duration::from_millis(20))
            .expect("takes it");
        let path = PathBuf::from(slave.name().expect("has a name"));
        let over = Arc::new(AtomicBool::new(false));
        let flag = Arc::clone(&over);
        let thread = std::thread::spawn(move || {
            let mut bytes = [0; 1024];
            while !flag.load(Ordering::Relaxed) {
                if let Ok(count) = master.read(&mut bytes) {
                    // Nobody may listen any more.
                    let _ = master.write_all(&answer(&bytes[..count]));
                }
            }
        });
        Self {
            path,
            over,
            thread: Some(thread),
            _slave: slave,
        }
    }

    fn ask(&mut self, line: &str) -> crate::process::Ended {
        let line = format!("{line} --device serial:{}", self.path.display());
        Place::new().run(&line)
    }

    fn refused(&self, words: &[&str]) {
        let place = Place::new();
        let line = format!("device info --device serial:{}", self.path.display());
        place.run(&line).refused(3, words);
    }
}

impl Drop for Impostor {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
        let thread = self.thread.take().expect("runs");
        thread.join().expect("ends");
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_port_with_something_else_behind_it_is_told_apart() {
    // Each is waited for in vain, so all at once.
    std::thread::scope(|scope| {
        scope.spawn(|| {
            Impostor::new(|_| Vec::new()).refused(&["no answer", "nothing came", "switched on"]);
        });
        scope.spawn(|| {
            Impostor::new(<[u8]>::to_vec).refused(&["echoes what it is sent"]);
        });
        scope.spawn(|| {
            let garbage = |_: &[u8]| b"AT+OK\r\n\0garbage\0".to_vec();
            Impostor::new(garbage).refused(&["garbage", "baud rate"]);
        });
        // A socket lets in one program at a time.
        scope.spawn(|| {
            let device = Emulated::new("");
            let path = device.place.path("device");
            let _held = std::os::unix::net::UnixStream::connect(path).expect("lets the first in");
            let words = ["socket", "one program in at a time", "close another one"];
            (device.place.run("device info --device serial:device")).refused(3, &words);
        });
        // Version 3 of the protocol, otherwise whole.
        scope.spawn(|| {
            let words = ["protocol version 3", "this program 2", "flash"];
            Impostor::new(|_| of_version(3)).refused(&words);
        });
    });
}

/// A whole frame of a device that speaks this version.
fn of_version(version: u8) -> Vec<u8> {
    let mut content = vec![0x80 | version, 0, 0, 0];
    let crc = crc32(&content);
    content.extend_from_slice(&crc.to_le_bytes());
    let mut line = vec![0; FRAME_MAX];
    let length = cobs::encode(&content, &mut line);
    line.truncate(length);
    line.push(0);
    line
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_port_that_answers_after_a_second_is_waited_for() {
    let device = Emulated::at_terminal("device", "");
    let path = device.place.path("device");
    // As QEMU does it: what is said in the first second is lost.
    let port = serialport::new(path.to_string_lossy(), 460_800);
    let mut port = port
        .timeout(Duration::from_millis(20))
        .open_native()
        .expect("opens");
    let began = Instant::now();
    let mut slow = Impostor::new(move |bytes| {
        if began.elapsed() < Duration::from_millis(1200) {
            return Vec::new();
        }
        port.write_all(bytes).expect("writes");
        let mut answer = vec![0; 4096];
        // Longer than the emulated device takes.
        std::thread::sleep(Duration::from_millis(5));
        let count = port.read(&mut answer).unwrap_or(0);
        answer.truncate(count);
        answer
    });
    let ended = slow.ask("device get --json");
    assert_eq!(ended.code, Some(0), "{ended}");
}

fn crc32(bytes: &[u8]) -> u32 {
    crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(bytes)
}

#[cfg(target_os = "linux")]
#[test]
fn whoever_waits_for_a_device_in_vain_may_stop_and_is_told() {
    let place = Place::new();
    for device in ["serial:nowhere", "haply:nowhere"] {
        let line = format!("device info --device {device} --wait 60s");
        let ended = crate::interrupted::interrupt_when_it_listens(&place, &line);
        ended.refused(1, &["interrupted", "nowhere", "in vain"]);
    }
}
