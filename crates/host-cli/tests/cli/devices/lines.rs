//! Bad lines, plugs that are pulled, and hosts that are killed.

use super::{Emulated, RELAX, at};
use crate::process::{Place, holds};
use haptic_link::{FRAME_MAX, Header, Request, encode};
use serde_json::Value;
use serialport::{SerialPort as _, TTYPort};
use std::io::{Read as _, Write as _};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn a_bad_line_is_counted_and_survived() {
    let device = Emulated::new("drop=1% corrupt=1% duplicate=1% reorder=1% line_seed=3");
    device.loosen();
    let ended = device.place.run(&format!("{RELAX} --json"));
    // Samples are missing: exit code 4, everything else is there.
    assert_eq!(ended.code, Some(4), "{ended}");
    let report: Value = serde_json::from_str(&ended.stdout).expect("JSON");
    let lost = at(&report, "/link/samples_lost");
    assert!(lost > 20.0 && lost < 400.0, "{report}");
    holds(at(&report, "/link/from_device/corrupt") > 5.0, &report);
    holds(at(&report, "/link/from_device/duplicate") > 5.0, &report);
    assert!(at(&report, "/link/from_device/late") > 5.0, "{report}");
    assert_eq!(at(&report, "/dropped_samples"), lost);
    let check = device.place.run("log check run/relax.mcap --json");
    let check: Value = serde_json::from_str(&check.stdout).expect("JSON");
    let gaps = check["gaps"].as_array().expect("gaps");
    let missing: f64 = gaps.iter().map(|gap| at(gap, "/missing")).sum();
    let at_the_ends = at(&check, "/missing_at_start") + at(&check, "/missing_at_end");
    assert_eq!(missing + at_the_ends, lost, "{check}");
    assert_eq!(at(&check, "/missing_samples"), lost, "{check}");
    // What came is right: the force was computed on the device from the true position. What it is held against is
    // interpolated where samples are missing; at the corner of a ramp of 500 ticks a gap of 1, 2, 3 ticks is
    // 0.85e-3, 1.35e-3, 1.7e-3 off, by the sum of the Grünwald weights.
    let gap = |gap: &Value| at(gap, "/missing");
    let longest = gaps.iter().map(gap).fold(1.0, f64::max);
    let error = at(&report, "/max_relative_error");
    assert!(error < 0.9e-3 * longest, "{longest} in a row: {report}");
}

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
        // A socket of ours lets in one program at a time, as long as it speaks.
        scope.spawn(|| {
            let device = Emulated::new("");
            let path = device.place.path("device");
            let mut held = UnixStream::connect(path).expect("lets the first in");
            let mut hello = [0; FRAME_MAX];
            let request = Request::Hello { nonce: 1 };
            let length = encode(&request, Header::from_host(0, 0), &mut hello).expect("fits");
            held.write_all(&hello[..length]).expect("listens");
            std::thread::scope(|scope| {
                let words = [
                    "device answers \"busy: ",
                    "it serves 127.0.0.1:",
                    "close the other program",
                ];
                let info = || device.place.run("device info --device serial:device");
                let info = scope.spawn(move || info().refused(3, &words));
                while !info.is_finished() {
                    held.write_all(b"x").expect("listens");
                    std::thread::sleep(Duration::from_millis(50));
                }
            });
        });
        // That of another emulator lets one in, whatever it does.
        scope.spawn(|| {
            let place = Place::new();
            let _full = UnixListener::bind(place.path("device")).expect("a socket");
            let words = ["socket", "one program at a time", "close the other one"];
            (place.run("device info --device serial:device")).refused(3, &words);
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
        ended.refused(1, &["interrupted", "nowhere", "while waiting"]);
    }
}
