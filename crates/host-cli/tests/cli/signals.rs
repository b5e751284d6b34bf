//! Signals, while a run pushes on a device of each kind: no force is left, the log is whole, the exit code is the documented one.
//!
//! `CAMPAIGN_CASES` sets how many; a seed chooses signal and moment.

use crate::devices::Emulator;
use crate::process::{Ended, Place, column, number, signal, until};
use haptic_bridge::{Bridge, BridgeTicker, Description, Takes};
use haptic_devices::haply::TORQUES_BYTES;
use haptic_link::{DeviceReport, Direction, Receiver, Sample};
use haptic_loop::Limiters;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::os::unix::net::UnixListener;
use std::process::Child;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::Duration;
use testkit::{Random, assert_says, cases};

/// Signals that end a run in order. Those of Linux alone come last: PWR, one without a name, the first and the last of real time.
const HEARD: &[&str] = &[
    "INT", "TERM", "HUP", "QUIT", "TSTP", "TTIN", "TTOU", "ALRM", "VTALRM", "PROF", "USR1", "USR2",
    "XCPU", "ABRT", "SYS", "TRAP", "IO", "PWR", "16", "RTMIN", "RTMAX",
];
/// Signals that a run does not mind.
const UNHEARD: &[&str] = &["PIPE", "XFSZ", "CHLD", "URG", "WINCH", "CONT"];
/// Signals that end a program where it stands.
const DEADLY: &[&str] = &["KILL", "FPE", "ILL"];

const LOG: &str = "run/relax.mcap.part";
/// Silence after which the devices of the runs let go, those that can, and time from a fault to zero force: ms, which are ticks.
const WATCHDOG_MS: u32 = 500;
const STOP_MS: u32 = 102;

#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Simulated,
    Serial,
    Tcp,
    Haply,
    Moteus,
    Inverse3,
    Bridge,
}

const KINDS: [Kind; 7] = [
    Kind::Simulated,
    Kind::Serial,
    Kind::Tcp,
    Kind::Haply,
    Kind::Moteus,
    Kind::Inverse3,
    Kind::Bridge,
];

/// Bytes of a line: to the device, and from it.
type Kept = Arc<Mutex<[Vec<u8>; 2]>>;

/// A device of a kind, and the place of the run on it.
struct Rig {
    kind: Kind,
    place: Place,
    device: String,
    kept: Kept,
    emulator: Option<Emulator>,
    /// Ends the thread of a bridge.
    ended: Arc<AtomicBool>,
}

impl Drop for Rig {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
    }
}

impl Rig {
    fn new(kind: Kind) -> Self {
        let mut rig = Self {
            kind,
            place: Place::new(),
            device: "sim".to_owned(),
            kept: Kept::default(),
            emulator: None,
            ended: Arc::default(),
        };
        rig.device = match kind {
            Kind::Simulated => return rig,
            Kind::Serial => {
                let listener = UnixListener::bind(rig.place.path("line")).expect("a socket");
                let device = rig.emulated("own --listen 127.0.0.1:0");
                let kept = Arc::clone(&rig.kept);
                std::thread::spawn(move || {
                    let (host, _) = listener.accept().expect("a host");
                    carries((host.try_clone().expect("a handle"), host), &device, &kept);
                });
                "serial:line".to_owned()
            }
            Kind::Tcp => {
                let device = rig.emulated("own --listen 127.0.0.1:0");
                rig.tapped(device)
            }
            Kind::Haply => {
                let device = rig.emulated("haply-2diy --listen 127.0.0.1:0");
                format!("haply:{}", rig.tapped(device))
            }
            Kind::Moteus => {
                let device = rig.emulated("moteus turn=2mm:0.5s --listen 127.0.0.1:0");
                format!("moteus:tcp:{device},radius=20mm,watchdog=500ms,lost=1000")
            }
            Kind::Inverse3 => format!(
                "inverse3:{},lost=1000",
                rig.emulated("inverse3 service_port=0")
            ),
            Kind::Bridge => {
                let port = bridged(Takes::Force, 0.0, Arc::clone(&rig.ended), pressed);
                rig.tapped(format!("127.0.0.1:{port}"))
            }
        };
        rig
    }

    /// An emulated device; its address.
    fn emulated(&mut self, options: &str) -> String {
        let emulator = Emulator::start(&self.place, &format!("--kind {options}"));
        self.emulator.insert(emulator).address().to_owned()
    }

    /// The name of another address, from which all is carried to a device.
    fn tapped(&self, device: String) -> String {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("an address");
        let kept = Arc::clone(&self.kept);
        std::thread::spawn(move || {
            let (host, _) = listener.accept().expect("a host");
            host.set_nodelay(true).expect("a socket");
            carries((host.try_clone().expect("a handle"), host), &device, &kept);
        });
        format!("tcp:{address}")
    }

    /// What an emulator says at its end: the numbers behind these words.
    fn numbers_after(&mut self, before: &str, count: usize) -> Vec<f64> {
        let message = self.emulator.as_mut().expect("an emulator").ends();
        crate::devices::numbers_after(&message, before, count)
    }

    /// A relaxation that a hand keeps up, as an option of `relax` or in a file.
    fn line(&self, in_file: bool) -> String {
        let what = if in_file { "run x.toml" } else { "relax" };
        let of_kind = match self.kind {
            Kind::Simulated => "--realtime",
            Kind::Serial | Kind::Tcp | Kind::Bridge => "",
            Kind::Haply => "sample_time=10ms max_age_ticks=200",
            Kind::Moteus => "sample_time=2ms force_limit=4N max_age_ticks=200",
            Kind::Inverse3 => "max_age_ticks=1000",
        };
        let on_device = if self.kind == Kind::Simulated {
            String::new()
        } else {
            format!(
                "--device {} watchdog={WATCHDOG_MS}ms late_ticks=0",
                self.device
            )
        };
        self.place.write("x.toml", "[relax]\n");
        format!(
            "{what} {on_device} {of_kind} force_rate_limit=2N/s contact=rigid duration=300s --out run --quiet"
        )
    }

    /// Samples that a board of ours has told, also those for which nobody listened.
    fn samples(&self) -> Vec<Sample> {
        let mut receiver = Receiver::<DeviceReport>::new(Direction::FromDevice);
        let kept = self.kept.lock().expect("nobody panicked");
        let reports = kept[1].iter().filter_map(|&byte| receiver.push(byte));
        let samples = reports.filter_map(|(_, report)| {
            if let DeviceReport::Sample(sample) = report {
                Some(sample)
            } else {
                None
            }
        });
        samples.collect()
    }

    /// True if the last torques that a 2DIY was sent are not zero.
    fn has_torque(&self) -> bool {
        let kept = self.kept.lock().expect("nobody panicked");
        let last = kept[0].last_chunk::<TORQUES_BYTES>();
        last.is_some_and(|frame| frame[..2] == [2, 5] && frame[2..] != [0; TORQUES_BYTES - 2])
    }

    /// No force is left, and it did not grow on its way there. Whoever was killed has told the device nothing.
    fn lets_go(&mut self, by_itself: bool) {
        let silence_ms = if by_itself { 2 * WATCHDOG_MS } else { 100 };
        std::thread::sleep(Duration::from_millis(silence_ms.into()));
        match self.kind {
            Kind::Simulated => {}
            Kind::Serial | Kind::Tcp | Kind::Bridge => self.falls(by_itself),
            // Its board has no watchdog, as the guide says.
            Kind::Haply => assert!(by_itself || !self.has_torque()),
            Kind::Moteus => {
                let mode = self.numbers_after("mode ", 1)[0];
                // That of its own watchdog where nobody has stopped it.
                assert!(mode == 0.0 || by_itself && mode == 11.0, "mode {mode}");
            }
            Kind::Inverse3 => assert_eq!(self.numbers_after("force ", 3), [0.0; 3]),
        }
    }

    fn falls(&self, by_itself: bool) {
        let samples = until("the force to be zero", || {
            let samples = self.samples();
            let rows: Vec<_> = samples
                .iter()
                .map(|sample| (sample.axes[0].limiters, sample.axes[0].force_n.into()))
                .collect();
            let ticks = falls(&rows)?.map(|at| samples.get(at).map_or(0, |sample| sample.tick));
            assert!(ticks[1] - ticks[0] <= STOP_MS, "{ticks:?} ms");
            Some(samples)
        });
        let faulted = |sample: &Sample| sample.axes[0].limiters & Limiters::FAULT.bits() != 0;
        let faulted = samples.iter().any(faulted);
        // Before it pushes it may not have been told to begin.
        let pushed = samples.iter().any(|sample| sample.axes[0].force_n != 0.0);
        assert!(faulted == by_itself || !pushed, "a fault: {faulted}");
    }
}

/// Ticks at which the force began to fall and from which it is zero for good, by limiters and force at each tick; `None` as long as it is not.
fn falls(rows: &[(u8, f64)]) -> Option<[usize; 2]> {
    let ends = Limiters::STOPPING.bits() | Limiters::FAULT.bits();
    // It was not told to begin.
    if rows.iter().all(|(_, force_n)| *force_n == 0.0) {
        return Some([0, 0]);
    }
    let stop = rows.iter().position(|(limiters, _)| limiters & ends != 0)?;
    let zero = rows
        .iter()
        .rposition(|(_, force_n)| *force_n != 0.0)
        .map_or(0, |last| last + 1);
    (zero < rows.len()).then_some(())?;
    let way: Vec<f64> = rows[stop.saturating_sub(1)..]
        .iter()
        .map(|(_, force_n)| force_n.abs())
        .collect();
    assert!(
        way.is_sorted_by(|before, after| before >= after),
        "{way:?} N"
    );
    Some([stop, zero.max(stop)])
}

/// Carries what both ends say, to the end of the device: whoever is gone does not hear it.
fn carries((host, to_host): (impl Read + Send + 'static, impl Write), device: &str, kept: &Kept) {
    let device = TcpStream::connect(device).expect("a device");
    device.set_nodelay(true).expect("a socket");
    let (to_device, keeps) = (device.try_clone().expect("a handle"), Arc::clone(kept));
    std::thread::spawn(move || carry(host, to_device, &keeps, 0));
    carry(device, to_host, kept, 1);
}

fn carry(mut from: impl Read, mut to: impl Write, kept: &Kept, side: usize) {
    let mut bytes = [0; 4096];
    while let Ok(count @ 1..) = from.read(&mut bytes) {
        let bytes = &bytes[..count];
        kept.lock().expect("nobody panicked")[side].extend(bytes);
        let _ = to.write_all(bytes);
    }
}

/// A program with a haptic thread that takes this, and does so with each tick, at its time, µs; its port.
pub(crate) fn bridged(
    takes: Takes,
    sensed_force_max_n: f64,
    ended: Arc<AtomicBool>,
    mut tick: impl FnMut(&mut BridgeTicker, u64) + Send + 'static,
) -> u16 {
    let description = Description {
        name: "program".to_owned(),
        axes: 1,
        sample_time_us: 1000,
        force_max_n: 3.0,
        force_rate_max_n_per_s: 1000.0,
        position_resolution_m: 1e-5,
        sensed_force_max_n,
        workspace_low_m: [-0.1; 3],
        workspace_high_m: [0.1; 3],
        watchdog_ms: 0,
        serial_number: String::new(),
        takes,
    };
    let bridge = Bridge::open(&description, "127.0.0.1:0").expect("a device");
    let port = bridge.port();
    std::thread::spawn(move || {
        let mut bridge = bridge;
        // In the time of its ticks: a busy machine makes it slow and never late.
        let mut time_us = 0;
        while !ended.load(Ordering::Relaxed) {
            time_us += 1000;
            tick(&mut bridge.ticker, time_us);
        }
    });
    port
}

/// A hand that presses a device and lets go again.
fn pressed(ticker: &mut BridgeTicker, time_us: u64) {
    ticker.wait();
    let hand_m = 4e-4 * (1.0 - (2e-6 * time_us as f64).cos());
    ticker.tick(time_us, Some(&[hand_m, 0.0, 0.0]));
}

/// A run on a device of this kind that a signal meets after some time of its log. False if a busy machine has ended it before.
fn meets(kind: Kind, name: &str, ms: f64, in_file: bool) -> bool {
    let mut rig = Rig::new(kind);
    let line = rig.line(in_file);
    let mut run = rig.place.start(&line);
    // Some 80 bytes a sample behind the head of the log. The hands of others wait before they press, and ours while the force may rise.
    let (rate, wait) = match kind {
        Kind::Haply => (0.1, 100.0),
        Kind::Moteus => (0.5, 700.0),
        Kind::Serial | Kind::Tcp => (1.0, 500.0),
        Kind::Simulated | Kind::Inverse3 | Kind::Bridge => (1.0, 0.0),
    };
    let bytes = |ms: f64| 80 * (100.0 + wait + rate * ms) as u64;
    let grows = |run: &mut Child, bytes| rig.place.grows(LOG, bytes, run);
    let is_deadly = DEADLY.contains(&name);
    let is_early = is_deadly && ms < 200.0;
    if is_early {
        std::thread::sleep(Duration::from_millis(ms as u64));
    }
    let mut is_there = is_early || grows(&mut run, bytes(ms));
    if is_there && UNHEARD.contains(&name) {
        signal(&run, name);
        is_there = grows(&mut run, bytes(ms + 300.0));
    }
    // By the clock of a busy machine a 2DIY misses three answers, and a hand is too deep for a start.
    let is_lost = |message: &str| {
        let words = ["no complete answer", "move it out of contact"];
        words.iter().any(|words| message.contains(words))
    };
    if !is_there {
        let output = run.wait_with_output().expect("ends");
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(
            is_lost(&message),
            "{kind:?} {name}: ended before the signal: {message}"
        );
        return false;
    }
    signal(&run, if UNHEARD.contains(&name) { "INT" } else { name });
    if name == "STOP" {
        std::thread::sleep(Duration::from_millis(2 * u64::from(WATCHDOG_MS)));
        signal(&run, "CONT");
        std::thread::sleep(Duration::from_millis(200));
        // Nothing heard the silence of a simulated device, of a 2DIY and of an Inverse3.
        let _ = run
            .try_wait()
            .expect("can be asked")
            .is_none()
            .then(|| signal(&run, "INT"));
    }
    let output = run.wait_with_output().expect("ends");
    let ended = Ended::new(format!("{kind:?}: {line} & kill -{name}"), &output);
    if name != "STOP" && is_lost(&ended.stderr) {
        return false;
    }
    rig.lets_go(is_deadly || name == "STOP");
    if is_deadly {
        if !is_early || rig.place.path(LOG).exists() {
            recovers(&rig.place);
        }
        return true;
    }
    // A device that heard nothing has a fault; one of another maker may be lost.
    let (most, words) = match (name, kind) {
        ("STOP", Kind::Serial | Kind::Tcp | Kind::Bridge) => (1, "heard nothing from the host"),
        ("STOP", _) => (3, "error: "),
        _ => (1, "interrupted: the run ended at"),
    };
    assert!(
        matches!(ended.code, Some(code @ (1 | 3)) if code <= most),
        "{ended}"
    );
    assert_says(ended.error(), words);
    assert!(!rig.place.path(LOG).exists(), "{ended}");
    let table = rig.place.run("log export run/relax.mcap -").stdout;
    let rows = ["limiters", "commanded_force_n"].map(|name| column(&table, name));
    let rows = rows[0].iter().zip(&rows[1]);
    let rows: Vec<_> = rows
        .map(|(limiters, force_n)| (*limiters as u8, *force_n))
        .collect();
    // A device that is served by the host was stopped with it, and no sample tells of its way to zero.
    if name != "STOP" {
        let [stop, _] = falls(&rows).unwrap_or_else(|| panic!("a force at the end: {ended}"));
        let before_n = rows[stop.saturating_sub(1)].1;
        assert!(before_n != 0.0 || ms < 100.0, "no force: {ended}");
    }
    let check = rig.place.run("log check run/relax.mcap --json");
    // A machine that is busy may miss what others say by the clock.
    let is_late = name == "STOP" || matches!(kind, Kind::Haply | Kind::Moteus | Kind::Inverse3);
    assert!(
        check.code == Some(0) || is_late && check.code == Some(4),
        "{check}"
    );
    true
}

/// The log of a run that was killed is whole up to there.
fn recovers(place: &Place) {
    let recovery = place.run(&format!("log recover {LOG} saved.mcap --json"));
    assert!(matches!(recovery.code, Some(0 | 4)), "{recovery}");
    let recovered = recovery.json();
    let check = place.run("log check saved.mcap --json").json();
    let samples = number(&check, "samples");
    assert_eq!(number(&recovered, "samples"), samples, "{check}");
    if samples > 0.0 && check["missing_samples"] == 0 {
        // From the first tick on, without a gap.
        assert_eq!(check["gaps"], serde_json::json!([]), "{check}");
        assert_eq!(number(&check, "first_s"), 0.0, "{check}");
        assert_eq!(number(&recovered, "last_tick"), samples - 1.0);
        let missing = recovered["missing"].to_string();
        assert_says(&missing, "whatever came after tick");
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn no_signal_leaves_a_force_on_a_device_of_any_kind() {
    let mut random = Random(65);
    let signals: Vec<&str> = [HEARD, UNHEARD, DEADLY, &["STOP"]].concat();
    let mut drawn = || (random.between(0.0, 1000.0), random.chance(0.5));
    let runs: Vec<_> = (0..cases(28))
        .map(|case| {
            let (ms, in_file) = drawn();
            // 7 and 31 have no common divisor: each signal comes to each kind.
            (
                KINDS[case % KINDS.len()],
                signals[case % signals.len()],
                ms,
                in_file,
            )
        })
        .collect();
    for some in runs.chunks(3) {
        std::thread::scope(|scope| {
            for &(kind, name, ms, in_file) in some {
                scope.spawn(move || {
                    if !(0..3).any(|_| meets(kind, name, ms, in_file)) {
                        testkit::skip_for_load(&format!("{kind:?} {name}: lost before the signal"));
                    }
                });
            }
        });
    }
}

#[test]
fn a_terminal_is_left_as_it_was_and_the_last_line_is_whole() {
    for name in ["INT", "TERM", "HUP", "QUIT", "TSTP", "ABRT"] {
        let place = Place::new();
        place.write(
            "inside",
            "stty -a >before; sh begins & wait $!; echo $? >code; stty -a >after",
        );
        let line = "relax --realtime contact=rigid duration=300s --out run";
        place.write(
            "begins",
            format!("echo $$ >process; exec \"$HOST_CLI\" {line}"),
        );
        let script = format!(
            "export HOST_CLI=\"$0\"; script -qec 'sh inside' typescript >/dev/null & \
             while ! [ -s {LOG} ]; do sleep 0.05; done; kill -{name} $(cat process); wait $!"
        );
        let ended = place.shell(&script);
        assert_eq!(place.text("code").trim(), "1", "{name}: {ended}");
        assert_eq!(place.text("after"), place.text("before"), "{name}");
        let shown = place.text("typescript");
        let [hidden, visible] =
            ["\u{1b}[?25l", "\u{1b}[?25h"].map(|sequence| shown.rfind(sequence));
        assert!(hidden <= visible, "{name}: the cursor is hidden: {shown:?}");
        assert_says(&shown, "interrupted: the run ended at");
    }
}
