//! Devices at TCP addresses.

use super::{Emulator, RELAX, at};
use crate::process::{Ended, Place};
use serde_json::Value;
use testkit::assert_says;

/// An emulated device at a free port of this machine.
struct Listening {
    place: Place,
    emulator: Emulator,
}

impl Listening {
    fn new(options: &str) -> Self {
        let place = Place::new();
        let emulator = Emulator::start(&place, &format!("--listen 127.0.0.1:0 {options}"));
        Self { place, emulator }
    }

    fn name(&self) -> &str {
        self.emulator.name()
    }

    fn json(&self, line: &str) -> Value {
        let ended = self.place.run(&format!("{line} --json"));
        ended.succeeded_with_warnings().json()
    }
}

#[test]
fn a_relaxation_over_tcp_loses_nothing() {
    let device = Listening::new("--speed 4");
    let line = RELAX.replace("serial:device", device.name());
    let report = device.json(&line.replace("--duration 4s", "--duration 1s"));
    for count in [
        "/link/samples_lost",
        "/dropped_samples",
        "/link/from_device/corrupt",
    ] {
        assert_eq!(at(&report, count), 0.0, "{count}: {report}");
    }
    assert_eq!(report["link"]["board"], "emulated");
    // The next host finds it as the first one did, under the same name.
    let info = device.json(&format!("device info --device {}", device.name()));
    assert_eq!(
        info["device"], device.emulator.announced["device"],
        "{info}"
    );
    assert_eq!(info["state"], "idle", "{info}");
}

#[test]
fn boards_that_face_each_other_and_those_of_other_makers_listen_too() {
    let pair = Listening::new("--facing 127.0.0.1:0");
    let second = pair.emulator.announced["facing"]["device"]
        .as_str()
        .expect("a name");
    assert_ne!(second, pair.name());
    for name in [pair.name(), second] {
        let info = pair.json(&format!("device info --device {name}"));
        assert_eq!(info["simulated"], false, "{info}");
    }
    for (kind, board) in [("moteus", "moteus"), ("haply-2diy", "Haply 2DIY v3")] {
        let device = Listening::new(&format!("--kind {kind}"));
        let info = device.json(&format!("device info --device {}", device.name()));
        assert_eq!(info["board"], board, "{info}");
    }
}

#[test]
fn a_device_that_vanishes_in_a_run_over_tcp_ends_it_with_a_whole_log() {
    let mut device = Listening::new("");
    let line = RELAX.replace("serial:device", device.name());
    let line = line.replace("--duration 4s", "--duration 300s");
    let mut run = device.place.start(&line);
    device.place.wait_for("run/relax.mcap.part", &mut run);
    device.emulator.child.kill().expect("can be killed");
    let ended = Ended::new(line, &run.wait_with_output().expect("ends")).failed(3);
    assert_says(ended.error(), "the log is run/relax.mcap");
    assert_eq!(device.json("log info run/relax.mcap")["complete"], true);
}

#[test]
fn an_address_that_other_machines_reach_is_listened_at_with_a_warning() {
    let place = Place::new();
    for (address, warned) in [("0.0.0.0:0", true), ("127.0.0.1:0", false)] {
        let ended = place.run(&format!(
            "device emulate --listen {address} --duration 10ms"
        ));
        assert_eq!(ended.code, Some(0), "{ended}");
        let says_so = ended.stderr.contains("on a trusted network only");
        assert_eq!(says_so, warned, "{ended}");
    }
}

#[test]
fn an_address_that_cannot_be_is_refused_in_a_line() {
    Place::new().refuses(
        "
        device emulate --listen nowhere => nowhere | HOST:PORT
        device emulate --listen 127.0.0.1:65536 => 127.0.0.1:65536 | up to 65535
        device emulate --listen ::1:4250 => [::1]:4250
        device emulate --listen 192.0.2.1:4250 => 192.0.2.1:4250 | port 0
        device emulate --listen 127.0.0.1:0 --link device => --listen | --link
        device emulate --listen 127.0.0.1:0 --facing white => white | HOST:PORT
        relax --device tcp:host => host | HOST:PORT
        relax --device serial:tcp:host => host | HOST:PORT
        relax --device haply:tcp:host => host | HOST:PORT
        relax --device tcp:host:4250@115200 => HOST:PORT
        ",
    );
}
