//! Commands on serial devices: an emulated one behind a pseudo-terminal, and ports that are none.

use crate::process::{PATIENCE, Place, binary};
use haptic_link::{FRAME_MAX, Header, Request, encode};
use serde_json::Value;
use serialport::{SerialPort as _, TTYPort};
use std::io::{Read as _, Write as _};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// An emulated device in a place, as `device`; gone when dropped.
pub(crate) struct Emulated {
    place: Place,
    child: Child,
}

impl Emulated {
    pub(crate) fn new(options: &str) -> Self {
        let place = Place::new();
        let mut device = Self {
            child: spawn(&place, options),
            place,
        };
        device.wait_for_link();
        device
    }

    pub(crate) fn place(&self) -> &Place {
        &self.place
    }

    fn wait_for_link(&mut self) {
        let began = Instant::now();
        while !self.place.path("device").exists() {
            assert!(began.elapsed() < PATIENCE, "no emulated device");
            std::thread::sleep(Duration::from_millis(5));
        }
    }

    /// Pulls the plug.
    fn kill(&mut self) {
        self.child.kill().expect("can be killed");
        self.child.wait().expect("ends");
    }

    /// Limits that no experiment here reaches.
    fn loosen(&self) {
        self.json(
            "device set --device serial:device --force-limit 100N --force-rate-limit 200kN/s --rise-time 0s \
             --start-force 0N --speed-limit 0m/s",
        );
    }

    pub(crate) fn json(&self, line: &str) -> Value {
        let ended = self.place.run(&format!("{line} --json"));
        let ended = ended.succeeded_with_warnings();
        serde_json::from_str(&ended.stdout).unwrap_or_else(|error| panic!("{error}: {ended}"))
    }
}

fn spawn(place: &Place, options: &str) -> Child {
    Command::new(binary())
        .args(["device", "emulate", "--link"])
        .arg(place.path("device"))
        .args(options.split_whitespace())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("runs")
}

impl Drop for Emulated {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

const RELAX: &str = "relax --device serial:device --watchdog 1s --contact rigid --duration 4s --ramp-time \
                     0.5s --out run --quiet";

fn number(value: &Value, path: &str) -> f64 {
    let found = value.pointer(path).and_then(Value::as_f64);
    found.unwrap_or_else(|| panic!("no number {path} in {value}"))
}

#[test]
fn a_relaxation_in_the_devices_loop_loses_nothing_and_follows_theory() {
    let device = Emulated::new("--speed 4");
    device.loosen();
    let report = device.json(RELAX);
    assert_eq!(number(&report, "/link/samples_lost"), 0.0);
    assert_eq!(number(&report, "/dropped_samples"), 0.0);
    assert!(number(&report, "/samples") >= 4001.0);
    assert!(number(&report, "/max_relative_error") < 1e-4, "{report}");
    assert!(number(&report, "/closed_form_error") < 2e-4, "{report}");
    assert_eq!(report["precision"], "f32");
    assert_eq!(report["tick_ns"], Value::Null);
    assert_eq!(report["link"]["board"], "emulated");
    // An emulated device simulates its rig, so nothing is called rendered.
    assert_eq!(report["link"]["simulated"], true);
    assert!(
        device
            .place
            .text("run/relax.csv")
            .contains(",simulated_force_n,")
    );
    // The log says the same.
    let info = device.json("log info run/relax.mcap");
    assert_eq!(info["complete"], true);
    assert_eq!(number(&info, "/samples"), number(&report, "/samples"));
}

#[test]
fn elements_in_series_follow_theory_on_a_device() {
    let device = Emulated::new("--speed 4");
    device.loosen();
    let report = device.json(&format!("{RELAX} --tissue fish-muscle"));
    assert_eq!(number(&report, "/link/samples_lost"), 0.0);
    assert!(number(&report, "/max_relative_error") < 1e-4, "{report}");
    assert!(number(&report, "/closed_form_error") < 2e-4, "{report}");
    assert_eq!(report["precision"], "f32");
}

#[test]
fn a_relaxation_in_the_hosts_loop_loses_nothing_and_follows_theory() {
    let device = Emulated::new("");
    device.loosen();
    // A machine that is busy answers late.
    let report = device.json(&format!("{RELAX} --loop host --max-age-ticks 1000"));
    assert_eq!(number(&report, "/link/samples_lost"), 0.0);
    assert!(number(&report, "/max_relative_error") < 1e-6, "{report}");
    assert!(number(&report, "/closed_form_error") < 2e-4, "{report}");
    assert_eq!(report["precision"], "f64");
    assert_eq!(report["link"]["loop"], "host");
}

#[test]
fn a_wall_and_a_creep_test_run_on_a_device() {
    let device = Emulated::new("--speed 10");
    device.loosen();
    device.place.write(
        "wall.toml",
        "[wall]\ndevice = \"serial:device\"\nwatchdog_s = 1\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\n\
         sample_time_s = 2e-3\norder = 0.5\nstiffness_n_per_m = 3000\ndissipation_n_s_mu_per_m = 100\n",
    );
    let wall = device.json("run wall.toml --out wall --quiet");
    assert_eq!(wall["stable"], true);
    assert!(number(&wall, "/max_relative_error") < 1e-5, "{wall}");
    // The same wall on the simulated device comes to rest at the same place.
    let simulated = device.json("run wall.toml --device sim --out simulated --quiet");
    let (here, there) = (
        number(&simulated, "/deflection_m"),
        number(&wall, "/deflection_m"),
    );
    assert!((here / there - 1.0).abs() < 1e-5, "{here} {there}");
    let creep = device.json(
        "creep --device serial:device --watchdog 1s --contact rigid --duration 3s --out creep --quiet",
    );
    assert!(number(&creep, "/closed_form_error") < 0.1, "{creep}");
}

#[test]
fn a_z_width_can_be_found_on_a_device() {
    let device = Emulated::new("--speed 200");
    device.loosen();
    let line = "zwidth --orders 1 --points 2 --duration 1s --quiet";
    // A device on a line cannot be thrown.
    let here = device.json(&format!("{line} --impact 0"));
    let there = device.json(&format!("{line} --device serial:device --watchdog 1s"));
    let stiffness = |report: &Value, point| {
        number(report, &format!("/orders/0/boundary/{point}/stiffness_max"))
    };
    // With the largest dissipation next to no stiffness is left, so the scale is that of the first point.
    let scale = stiffness(&here, 0);
    for point in [0, 1] {
        let (here, there) = (stiffness(&here, point), stiffness(&there, point));
        assert!(
            (here - there).abs() < 0.02 * scale,
            "point {point}: {here} {there}"
        );
    }
}

#[test]
fn the_log_of_a_host_loop_shows_no_force_beyond_what_the_device_makes() {
    let device = Emulated::new("");
    let place = &device.place;
    device.json("device set --device serial:device --force-limit 2N --rise-time 0s");
    // The tissue asks for 50 times as much. A machine that is too busy for the loop ends it: what was logged until then counts.
    let line = "relax --device serial:device --loop host --contact rigid --area 100cm2 --thickness 5cm --strain 50% \
                --duration 3s --watchdog 1s --max-age-ticks 1000 --out run --json";
    let ended = place.run(line);
    // A run that ended early keeps its log too.
    let export = place.run("log export run/relax.mcap run.csv").succeeded();
    let mut rows = csv::Reader::from_path(place.path("run.csv")).expect("a table");
    let header = rows.headers().expect("a header").clone();
    let column = header.iter().position(|name| name == "force_n");
    let column = column.unwrap_or_else(|| panic!("{header:?} {export}"));
    let forces = rows.records().map(|row| {
        let row = row.expect("a row");
        row[column].parse::<f64>().expect("a number").abs()
    });
    let most = forces.fold(0.0, f64::max);
    assert!((1.0..=2.0 + 1e-6).contains(&most), "{most} N: {ended}");
}

#[test]
fn parameters_are_set_as_a_whole_and_read_back() {
    let device = Emulated::new("");
    let on = "--device serial:device";
    let set =
        format!("device set {on} --stiffness 2N/mm --order 0.5 --dissipation 20 --watchdog 50ms");
    let after = device.json(&set);
    assert_eq!(number(&after, "/stiffness_n_per_m"), 2000.0);
    assert_eq!(number(&after, "/watchdog_s"), 0.05);
    assert_eq!(after["operator"]["form"], "modes");
    assert_eq!(device.json(&format!("device get {on}")), after);
    for (change, words) in [
        ("--force-limit 5kN", ["force limit", "5000", "100"]),
        ("--watchdog 1ms", ["watchdog", "5 ms", "1000 ms"]),
        ("--sample-time 2ms", ["--order", "sample time", "operator"]),
        ("--stiffness -1", ["stiffness", "-1", "at least 0"]),
        (
            "--order 0.5 --scheme grunwald:5000",
            ["coefficients", "5000", "256"],
        ),
        (
            "--order 0.5 --sample-time 1s",
            ["tick period", "1000000", "10000"],
        ),
    ] {
        let refused = device.place.run(&format!("device set {on} {change}"));
        let complaint = refused.complaint(2, &words);
        assert_eq!(complaint, None, "{change}");
    }
    assert_eq!(device.json(&format!("device get {on}")), after);
}

#[test]
fn a_run_leaves_the_device_as_it_was_and_loosens_nothing() {
    let device = Emulated::new("");
    let get = "device get --device serial:device";
    device.place.write(
        "wall.toml",
        "[wall]\ndevice = \"serial:device\"\nwatchdog_s = 1\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\n\
         sample_time_s = 1e-3\norder = 1\nstiffness_n_per_m = 500\ndissipation_n_s_mu_per_m = 1\n\
         duration_s = 1\n",
    );
    let set = device.place.run(
        "device set --device serial:device --stiffness 123N/m --order 0.5 --dissipation 2 --rise-time 0.2s",
    );
    // What was loosened, and by how much.
    assert!(
        set.stderr
            .contains("warning: loosened: rise time from 0.5 s to 0.2 s"),
        "{set}"
    );
    assert_eq!(set.stderr.matches("loosened").count(), 1, "{set}");
    let before = device.json(get);
    let run = device.place.run("run wall.toml --out wall --quiet --json");
    for words in [
        "the limits set on the device",
        "10 N, 1000 N/s",
        "0.2 s",
        "1.5 m/s",
        "device set",
    ] {
        assert!(run.stderr.contains(words), "{run}");
    }
    assert_eq!(device.json(get), before);
    let info = device.place.run("log info wall/wall.mcap --json");
    assert!(
        info.stdout.contains("\"device_force_limit_n\":\"10\""),
        "{info}"
    );
    // A host that is killed in the middle of a run leaves no more.
    let mut run = Command::new(binary());
    let line = RELAX.replace("--watchdog 1s", "--watchdog 300ms");
    run.args(line.split_whitespace())
        .current_dir(device.place.path(""));
    let run = run.stderr(Stdio::null()).stdout(Stdio::null());
    let mut run = run.spawn().expect("runs");
    let began = Instant::now();
    while !device.place.path("run/relax.mcap.part").exists() {
        assert!(began.elapsed() < PATIENCE, "no log");
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(Duration::from_millis(300));
    run.kill().expect("can be killed");
    run.wait().expect("ends");
    assert_eq!(device.json(get), before);
}

#[test]
fn an_image_of_another_board_is_not_programmed() {
    let place = Place::new();
    place.write("probe-rs", "#!/bin/sh\nexit 0\n");
    let probe = place.path("probe-rs");
    let mode = std::os::unix::fs::PermissionsExt::from_mode(0o755);
    std::fs::set_permissions(&probe, mode).expect("can be set");
    let flash = |image: &str, device: &str| {
        let mut command = Command::new(binary());
        command
            .args(["device", "flash", "--image", image, "--device", device])
            .env("PATH", place.path(""))
            .current_dir(place.path(""));
        let output = command.output().expect("runs");
        (
            output.status.code(),
            String::from_utf8_lossy(&output.stderr).into_owned(),
        )
    };
    place.write(
        "mps2",
        "haptic-device image\0mps2-an386\0\0\0\0\0\0\0\x01\x00",
    );
    let (code, error) = flash("mps2", "serial:nowhere");
    assert_eq!(code, Some(2), "{error}");
    assert!(
        error.contains("board mps2-an386 with firmware 0.1.0"),
        "{error}"
    );
    assert!(error.contains("nucleo-f446re"), "{error}");
    // The right image, but what answers is another board.
    place.write(
        "nucleo",
        "haptic-device image\0nucleo-f446re\0\0\0\0\x01\x00",
    );
    let device = Emulated::new("");
    let port = format!("serial:{}", device.place.path("device").display());
    let (code, error) = flash("nucleo", &port);
    assert_eq!(code, Some(3), "{error}");
    assert!(error.contains("what answers is board emulated"), "{error}");
}

#[test]
fn a_bad_line_is_counted_and_survived() {
    let device = Emulated::new("--drop 1% --corrupt 1% --duplicate 1% --reorder 1% --line-seed 3");
    device.loosen();
    let ended = device.place.run(&format!("{RELAX} --json"));
    // Samples are missing: exit code 4, everything else is there.
    assert_eq!(ended.code, Some(4), "{ended}");
    let report: Value = serde_json::from_str(&ended.stdout).expect("JSON");
    let lost = number(&report, "/link/samples_lost");
    assert!(lost > 20.0 && lost < 400.0, "{report}");
    assert!(
        number(&report, "/link/from_device/corrupt") > 5.0,
        "{report}"
    );
    assert!(
        number(&report, "/link/from_device/duplicate") > 5.0,
        "{report}"
    );
    assert!(number(&report, "/link/from_device/late") > 5.0, "{report}");
    assert_eq!(number(&report, "/dropped_samples"), lost);
    let check = device.place.run("log check run/relax.mcap --json");
    let check: Value = serde_json::from_str(&check.stdout).expect("JSON");
    let gaps = check["gaps"].as_array().expect("gaps");
    let missing: f64 = gaps.iter().map(|gap| number(gap, "/missing")).sum();
    let at_the_ends = number(&check, "/missing_at_start") + number(&check, "/missing_at_end");
    assert_eq!(missing + at_the_ends, lost, "{check}");
    assert_eq!(number(&check, "/missing_samples"), lost, "{check}");
    // What came is right: the force was computed on the device from the true position. What it is held against is
    // interpolated where samples are missing; at the corner of a ramp of 500 ticks a gap of 1, 2, 3 ticks is
    // 0.85e-3, 1.35e-3, 1.7e-3 off, by the sum of the Grünwald weights.
    let gap = |gap: &Value| number(gap, "/missing");
    let longest = gaps.iter().map(gap).fold(1.0, f64::max);
    let error = number(&report, "/max_relative_error");
    assert!(error < 0.9e-3 * longest, "{longest} in a row: {report}");
}

#[test]
fn a_run_and_the_check_of_its_log_count_the_same_samples_missing() {
    // The first of these lines loses the first samples; another only if a retry on a busy machine shifts it.
    let mut lost_first = false;
    for seed in 100..120 {
        let device = Emulated::new(&format!("--drop 40% --line-seed {seed} --speed 4"));
        let line = RELAX.replace("--duration 4s", "--duration 1s");
        let ended = device.place.run(&format!("{line} --json"));
        // A line as bad as this may end the run, or let none begin.
        let Ok(report) = serde_json::from_str::<Value>(&ended.stdout) else {
            continue;
        };
        let check = device.place.run("log check run/relax.mcap --json");
        let check = check.failed(4).json();
        assert_eq!(
            check["missing_samples"], report["dropped_samples"],
            "seed {seed}: {report} {check}"
        );
        assert_eq!(check["end"]["dropped_samples"], report["dropped_samples"]);
        assert_eq!(number(&check, "/end/planned_samples"), 1001.0);
        lost_first = number(&check, "/missing_at_start") > 0.0;
        if lost_first {
            break;
        }
    }
    assert!(lost_first, "no line lost the first sample");
}

#[test]
fn a_device_that_is_pulled_out_ends_the_run_with_a_whole_log() {
    let mut device = Emulated::new("");
    let mut run = Command::new(binary());
    let line = RELAX.replace("--duration 4s", "--duration 60s");
    run.args(line.split_whitespace())
        .current_dir(device.place.path(""));
    let run = run
        .stderr(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .expect("runs");
    let began = Instant::now();
    while !device.place.path("run/relax.mcap.part").exists() {
        assert!(began.elapsed() < PATIENCE, "no log");
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(Duration::from_millis(500));
    device.kill();
    let ended = run.wait_with_output().expect("ends");
    let error = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert_eq!(ended.status.code(), Some(3), "{error}");
    assert!(error.contains("the line is gone"), "{error}");
    let info = device.json("log info run/relax.mcap");
    assert_eq!(info["complete"], true);
    assert!(number(&info, "/samples") > 50.0, "{info}");
    // Nobody knows how many samples the device still made.
    let check = device.place.run("log check run/relax.mcap").failed(4);
    assert!(check.error().contains("the link was lost"), "{check}");
    let words = ["ended early: the line is gone", " of 60001 planned samples"];
    assert!(
        words.iter().all(|part| check.stdout.contains(part)),
        "{check}"
    );
}

#[test]
fn a_host_that_is_killed_leaves_a_device_without_force() {
    let device = Emulated::new("");
    let mut run = Command::new(binary());
    let line = RELAX.replace("--watchdog 1s", "--watchdog 300ms");
    run.args(line.split_whitespace())
        .current_dir(device.place.path(""));
    let mut run = run
        .stderr(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .expect("runs");
    let began = Instant::now();
    while !device.place.path("run/relax.mcap.part").exists() {
        assert!(began.elapsed() < PATIENCE, "no log");
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(Duration::from_millis(500));
    run.kill().expect("can be killed");
    run.wait().expect("ends");
    std::thread::sleep(Duration::from_millis(600));
    let info = device.json("device info --device serial:device");
    assert_eq!(info["state"], "in a fault", "{info}");
    let fault = info["fault"].as_str().expect("a fault");
    assert!(fault.contains("heard nothing from the host"), "{fault}");
    // What it left of its log can be saved.
    let saved = device
        .place
        .run("log recover run/relax.mcap.part saved.mcap --json");
    assert!(matches!(saved.code, Some(0 | 4)), "{saved}");
}

#[test]
fn a_port_that_is_in_use_is_refused() {
    let device = Emulated::new("");
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
    for (line, words) in [
        (
            "relax --device serial:/dev/null",
            ["/dev/null", "no serial port"],
        ),
        (
            "creep --device serial:nowhere",
            ["there is no port nowhere", "there "],
        ),
        (
            "device info --device serial:nowhere",
            ["there is no port nowhere", "there "],
        ),
    ] {
        assert_eq!(place.run(line).complaint(3, &words), None);
    }
    for (line, words) in [
        ("relax --device haptic", ["haptic", "sim"]),
        ("relax --device serial:x@fast", ["fast", "baud"]),
        ("relax --loop host", ["--loop", "--device"]),
        (
            "relax --device serial:x --sensor-noise 1um",
            ["--sensor-noise", "serial"],
        ),
        (
            "relax --device serial:x --watchdog 2s",
            ["watchdog", "1000 ms"],
        ),
        ("device info --device sim", ["sim", "serial:PATH"]),
        ("device emulate --drop 2", ["2", "100%"]),
        ("device emulate --speed 0", ["speed 0", "1000"]),
    ] {
        assert_eq!(place.run(line).complaint(2, &words), None);
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
fn a_port_with_something_else_behind_it_is_told_apart() {
    Impostor::new(|_| Vec::new()).refused(&["no answer", "nothing came", "switched on"]);
    Impostor::new(<[u8]>::to_vec).refused(&["sends back what it is sent", "echo"]);
    Impostor::new(|_| b"AT+OK\r\n\0garbage\0".to_vec()).refused(&["garbage", "baud rate"]);
    // Version 3 of the protocol, otherwise whole.
    Impostor::new(|_| of_version(3)).refused(&["protocol version 3", "this program 2", "flash"]);
    // A device of version 1 answers nobody but a host of version 1.
    Impostor::new(|bytes| {
        let greeted = bytes
            .windows(10)
            .any(|w| w == [2, 1, 1, 1, 1, 1, 1, 1, 1, 1]);
        if greeted { of_version(1) } else { Vec::new() }
    })
    .refused(&["protocol version 1", "this program 2", "flash"]);
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
fn a_port_that_answers_after_a_second_is_waited_for() {
    let device = Emulated::new("");
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

#[test]
fn a_flood_and_a_frame_without_end_do_not_stop_a_device() {
    let device = Emulated::new("");
    let path = device.place.path("device");
    {
        let port = serialport::new(path.to_string_lossy(), 460_800);
        let mut port = port.timeout(PATIENCE).open_native().expect("opens");
        // No zero for 20 kB, then noise with zeros, then a good frame cut in two.
        port.write_all(&[7; 20_000]).expect("writes");
        let noise: Vec<u8> = (0..100_000_u32)
            .map(|n| (n.wrapping_mul(n) >> 7) as u8)
            .collect();
        port.write_all(&noise).expect("writes");
        let mut line = [0; FRAME_MAX];
        let header = Header::from_host(0, 0);
        let length = encode(&Request::Stop, header, &mut line).expect("fits");
        port.write_all(&line[..length / 2]).expect("writes");
    }
    let info = device.json("device info --device serial:device");
    assert_eq!(info["state"], "idle");
    assert!(
        number(&info, "/statistics/frames_oversize") >= 1.0,
        "{info}"
    );
    assert!(number(&info, "/statistics/frames_corrupt") > 10.0, "{info}");
}

#[test]
fn flashing_without_probe_rs_says_how_to_get_it() {
    let place = Place::new();
    let mut command = Command::new(binary());
    // A path without anything in it.
    command
        .args(["device", "flash"])
        .env("PATH", place.path(""))
        .current_dir(place.path(""));
    let output = command.output().expect("runs");
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(3), "{error}");
    assert!(error.contains("cargo install probe-rs-tools"), "{error}");
}

#[test]
fn a_monitor_goes_on_when_the_device_comes_back() {
    let mut device = Emulated::new("");
    let mut monitor = Command::new(binary());
    monitor
        .args("device monitor --device serial:device --out watch --duration 8s --json".split(' '));
    let monitor = monitor
        .current_dir(device.place.path(""))
        .stderr(Stdio::piped());
    let monitor = monitor.stdout(Stdio::piped()).spawn().expect("runs");
    let began = Instant::now();
    while !device.place.path("watch/monitor.mcap.part").exists() {
        assert!(began.elapsed() < PATIENCE, "no log");
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(Duration::from_millis(300));
    device.kill();
    std::fs::remove_file(device.place.path("device")).expect("a killed device leaves its link");
    device.child = spawn(&device.place, "");
    device.wait_for_link();
    let ended = monitor.wait_with_output().expect("ends");
    let error = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert!(error.contains("the line is gone"), "{error}");
    assert!(error.contains("the device is there again"), "{error}");
    let watched: Value = serde_json::from_slice(&ended.stdout).expect("JSON");
    assert_eq!(number(&watched, "/reconnected"), 1.0, "{watched}");
    assert_eq!(ended.status.code(), Some(0), "{error}");
    for name in ["watch/monitor.mcap", "watch/monitor-2.mcap"] {
        let info = device.json(&format!("log info {name}"));
        assert_eq!(info["complete"], true, "{name}");
        assert!(number(&info, "/samples") > 50.0, "{info}");
    }
}

/// A line that loses the frame that tells the end: what the device answers to keep-alives tells it too.
#[test]
fn an_end_whose_frame_was_lost_is_learned_from_what_the_device_answers() {
    for (seed, workspace, code) in [(201, "--workspace=-10mm:0.5mm", 1), (4, "", 4)] {
        let device = Emulated::new(&format!("--drop 8% --line-seed {seed}"));
        let line = "relax --device serial:device --contact rigid --duration 2s --ramp-time 0.5s --watchdog 1s --out \
                    run --quiet";
        let ended = device.place.run(&format!("{line} {workspace}"));
        assert_eq!(ended.code, Some(code), "{ended}");
        assert!(!ended.stderr.contains("is stuck"), "{ended}");
    }
}
