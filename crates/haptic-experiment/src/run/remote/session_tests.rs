//! Whole runs on an emulated board behind a line that loses or changes what the board reports: what record and logs hold afterwards.

use super::partner::Side;
use super::session::{Steered, Steers};
use super::{PairRun, RemoteDevice, RemoteLaw, RemoteRun, blank, host_limits, push};
use crate::document::failure::Failure;
use crate::document::named::Named as _;
use crate::run::device::{DeviceName, LinkedName};
use crate::run::ending::{Ending, LetGo};
use crate::run::fault_recorder::AFTER;
use crate::run::record::Record;
use crate::run::schedule::{Pace, Schedule};
use crate::run::{FolderRequest, Ran, Supervisor};
use fracdiff::{Operator, Order, Scheme, Seconds};
use haptic_emulator::LineFaults;
use haptic_emulator::board::{BoardPort, Emulation, PortKind, emulate, emulate_facing};
use haptic_link::{
    DeviceReport, Direction, Event, EventKind, FRAME_MAX, Limits, LoopMode, Receiver, Simulation,
    encode,
};
use haptic_log::record::{DRIVE_END, END, Entry, EventMessage, LogReader, TickMessage};
use haptic_loop::plant::FacingContact;
use haptic_loop::units::{Metres, Newtons, NewtonsPerSecond};
use haptic_loop::{Controller, LoopSample, SafetyChain, SafetyLimits, Wall, Workspace};
use haptic_remote::LinkError;
use haptic_remote::serial::Line;
use std::collections::BTreeMap;
use std::io::{Read, Result as IoResult, Write};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;
use testkit::Folder;

const T: f64 = 1e-3;
type Spring = Wall<f64, Operator<f64>>;

/// What becomes of a report on its way.
enum Fate {
    Passes,
    Lost,
    /// The board is gone, and its end of the line.
    Gone,
}

/// May change a report, and decides its fate.
type Tap = Box<dyn FnMut(&mut DeviceReport) -> Fate + Send>;

/// The board's end of a line.
struct Tapped {
    line: Box<dyn Line>,
    reports: Receiver<DeviceReport>,
    tap: Tap,
    over: Arc<AtomicBool>,
}

impl Read for Tapped {
    fn read(&mut self, into: &mut [u8]) -> IoResult<usize> {
        self.line.read(into)
    }
}

impl Write for Tapped {
    fn write(&mut self, bytes: &[u8]) -> IoResult<usize> {
        for &byte in bytes {
            let Some((header, mut report)) = self.reports.push(byte) else {
                continue;
            };
            match (self.tap)(&mut report) {
                Fate::Passes => {
                    let mut frame = [0; FRAME_MAX];
                    let length = encode(&report, header, &mut frame).expect("it fits");
                    self.line.write_all(&frame[..length])?;
                }
                Fate::Lost => {}
                Fate::Gone => self.over.store(true, Ordering::Relaxed),
            }
        }
        Ok(bytes.len())
    }

    fn flush(&mut self) -> IoResult<()> {
        self.line.flush()
    }
}

impl Line for Tapped {
    /// For reading alone.
    fn share(&self) -> IoResult<Box<dyn Line>> {
        self.line.share()
    }

    fn set_baud_rate(&mut self, _: u32) {}

    fn set_patience(&mut self, patience: Duration) -> IoResult<()> {
        self.line.set_patience(patience)
    }
}

/// A run of a spring of 100 N/m on the board's 65 g, which a hand pushes by 0.5 N: to 5 mm.
struct Bench {
    loop_mode: LoopMode,
    samples: u64,
    /// The end of its workspace, m.
    high_m: f64,
    /// Stopped from here after so many samples.
    stops_at: u64,
    /// The last tick of the run, in a loop here.
    last_tick: u64,
}

impl Bench {
    const WHOLE: Self = Self {
        loop_mode: LoopMode::Device,
        samples: 200,
        high_m: 0.1,
        stops_at: u64::MAX,
        last_tick: u64::MAX,
    };

    /// It leaves its workspace.
    const FAULT: Self = Self {
        high_m: 2e-3,
        ..Self::WHOLE
    };

    fn ran(&self, tap: impl FnMut(&mut DeviceReport) -> Fate + Send + 'static) -> Seen {
        let folder = Folder::empty();
        let emulated = |[line]: [Box<dyn Line>; 1], over: &AtomicBool| {
            emulate(line, &emulation(), over).expect("an emulation");
        };
        Seen::of(on_boards([Box::new(tap)], emulated, |[name]| {
            let (remote, request) = (self.remote(name), request(&folder));
            let stop = AtomicBool::new(false);
            let supervisor = Supervisor {
                stop: &stop,
                progress: &|counted| stop.store(counted >= self.stops_at, Ordering::Relaxed),
                live: None,
                warn: &|_| (),
            };
            let blank = |_: f64| blank(0.0);
            let law = self.law(push(0.5));
            let run = RemoteRun::new(&remote, law, self.schedule(), &blank, &request);
            let mut steers = Until(self.last_tick);
            let connected = |_: &_, _| Ok(());
            run.steered(&mut self.controller(), &mut steers, connected, supervisor)
        }))
    }

    fn remote(&self, name: LinkedName) -> RemoteDevice {
        RemoteDevice {
            loop_mode: self.loop_mode,
            // Of a busy machine.
            max_age_ticks: Limits::MAX_AGE_TICKS,
            ..RemoteDevice::new(name)
        }
    }

    fn limits(&self) -> SafetyLimits {
        SafetyLimits {
            rise_time: Some(Seconds(T)),
            workspace: Some(Workspace {
                low: Metres(-0.1),
                high: Metres(self.high_m),
                soft: Metres(0.0),
            }),
            start_force: Some(Newtons(1.0)),
            ..SafetyLimits::bare(Newtons(5.0), NewtonsPerSecond(1e3))
        }
    }

    fn law(&self, simulation: Simulation) -> RemoteLaw {
        RemoteLaw {
            stiffness_n_per_m: 100.0,
            ..RemoteLaw::bare(self.limits(), simulation)
        }
    }

    const fn schedule(&self) -> Schedule {
        Schedule {
            samples: self.samples,
            sample_time_s: T,
            pace: Pace::Virtual,
        }
    }

    /// Of a loop here.
    fn controller(&self) -> Controller<f64, 1, Spring> {
        let (order, one) = (Order::new(0.0), Scheme::Grunwald { length: 1 });
        let operator = one.build(order.expect("none"), Seconds(T), 1.0);
        let spring = Wall::new(100.0, 0.0, operator.expect("one"), None);
        let chain = SafetyChain::from_limits(&host_limits(&self.limits()), Seconds(T));
        Controller::new(spring.expect("one"), chain.expect("limits"))
    }
}

fn emulation() -> Emulation {
    Emulation {
        axes: 1,
        body: None,
        sensor: None,
        specimen: None,
        speed: 4.0,
        faults: LineFaults::default(),
        seed: 1,
        duration: None,
    }
}

fn request(folder: &Path) -> FolderRequest {
    FolderRequest {
        out: Some(folder.to_owned()),
        stem: "run".to_owned(),
        overwrite: false,
        roll_bytes: None,
        provenance: BTreeMap::new(),
    }
}

/// Runs on boards that are emulated meanwhile, each behind its tap.
fn on_boards<const N: usize>(
    taps: [Tap; N],
    emulated: impl FnOnce([Box<dyn Line>; N], &AtomicBool) + Send + 'static,
    run: impl FnOnce([LinkedName; N]) -> Result<Ran, Failure>,
) -> Ran {
    let over = Arc::new(AtomicBool::new(false));
    let ports = [(); N].map(|()| {
        let port = BoardPort::open(PortKind::Address, Some(Path::new("127.0.0.1:0")));
        port.expect("a free port")
    });
    let names = ports.each_ref().map(|port| {
        let DeviceName(name) = port.path().parse().expect("a name");
        name.expect("a port")
    });
    let mut taps = taps.into_iter();
    let lines = ports.each_ref().map(|port| -> Box<dyn Line> {
        Box::new(Tapped {
            line: port.line().expect("its end"),
            reports: Receiver::new(Direction::FromDevice),
            tap: taps.next().expect("one each"),
            over: Arc::clone(&over),
        })
    });
    let is_over = Arc::clone(&over);
    std::thread::spawn(move || {
        emulated(lines, &is_over);
        drop(ports);
    });
    let ran = run(names);
    over.store(true, Ordering::Relaxed);
    ran.expect("runs")
}

/// Ends a run with this tick, and says so in the log one tick before.
struct Until(u64);

impl Steers<f64, Spring, 1> for Until {
    fn steer(&mut self, _: &mut Controller<f64, 1, Spring>, tick: &LoopSample<f64, 1>) -> Steered {
        if tick.reading.tick >= self.0 {
            return Steered::Over;
        }
        Steered::On((tick.reading.tick + 1 == self.0).then(|| EventMessage {
            time_s: tick.reading.time_s,
            kind: "last".to_owned(),
            text: String::new(),
        }))
    }
}

/// A run, and what is in its logs.
struct Seen {
    ran: Ran,
    metadata: BTreeMap<String, BTreeMap<String, String>>,
    ticks: Vec<TickMessage>,
    drive_ticks: Vec<TickMessage>,
    /// Kinds and times, s.
    events: Vec<(String, f64)>,
    /// In the log of the fault.
    fault_ticks: Vec<u64>,
}

impl Seen {
    fn of(ran: Ran) -> Self {
        let entries = |path: &Path| {
            LogReader::open(path)
                .expect("a log")
                .map(|entry| entry.expect("whole"))
        };
        let (mut ticks, mut drive_ticks) = (Vec::new(), Vec::new());
        let (mut events, mut metadata) = (Vec::new(), BTreeMap::new());
        for entry in entries(&ran.folder.file("mcap")) {
            match entry {
                Entry::Tick(tick) => ticks.push(tick),
                Entry::Drive(tick) => drive_ticks.push(tick),
                Entry::Event(event) => events.push((event.kind, event.time_s)),
                Entry::Metadata(record) => drop(metadata.insert(record.name, record.values)),
                other => panic!("{other:?}"),
            }
        }
        let fault_log = ran.fault_log.as_deref().into_iter().flat_map(entries);
        let mut fault_ticks = Vec::new();
        for entry in fault_log {
            if let Entry::Tick(tick) = entry {
                fault_ticks.push(tick.tick);
            }
        }
        Self {
            metadata,
            ticks,
            drive_ticks,
            events,
            fault_ticks,
            ran,
        }
    }

    fn ticks(&self) -> Vec<u64> {
        self.ticks.iter().map(|tick| tick.tick).collect()
    }

    /// Samples that count, planned and made ones, and those that the line lost.
    fn samples(&self) -> [u64; 4] {
        self.samples_of(&self.ran.record, [END, "link"])
    }

    fn samples_of(&self, record: &Record, [end, link]: [&str; 2]) -> [u64; 4] {
        let number = |of: &str, key: &str| self.metadata[of][key].parse().expect(key);
        let [planned, made] = ["planned_samples", "made_samples"].map(|key| number(end, key));
        [record.samples, planned, made, number(link, "samples_lost")]
    }
}

/// The tick of a report that is a sample.
const fn tick(report: &DeviceReport) -> Option<u32> {
    let DeviceReport::Sample(sample) = report else {
        return None;
    };
    Some(sample.tick)
}

/// Loses these samples.
fn losing(
    lost: impl Fn(u32) -> bool + Send + 'static,
) -> impl FnMut(&mut DeviceReport) -> Fate + Send {
    move |report| match tick(report).is_some_and(&lost) {
        true => Fate::Lost,
        false => Fate::Passes,
    }
}

#[test]
fn a_run_that_ends_by_itself_has_all_of_its_samples_and_the_log_the_fall_too() {
    for loop_mode in [LoopMode::Device, LoopMode::Host] {
        let seen = Bench {
            loop_mode,
            ..Bench::WHOLE
        }
        .ran(losing(|_| false));
        let record = &seen.ran.record;
        assert_eq!((record.ended, record.let_go()), (None, None));
        let [samples, planned, made, lost] = seen.samples();
        assert_eq!((samples, planned, lost), (200, 200, 0));
        assert_eq!(seen.ticks(), (0..made).collect::<Vec<_>>());
        // The last one has no force any more, the last that counts has it.
        let force_n = |tick: usize| seen.ticks[tick].applied_force_n[0];
        assert!(
            force_n(199) < -0.4 && force_n(made as usize - 1) == 0.0,
            "{loop_mode:?}"
        );
        assert!(record.has_fallen() && made > 200);
        assert_eq!((seen.events.len(), record.dropped), (0, 0));
        for (key, value) in [
            ("loop", loop_mode.name()),
            ("device_answered", "true"),
            ("retries", "0"),
        ] {
            assert_eq!(seen.metadata["link"][key], value);
        }
        let counted = |key: &str| -> u64 { seen.metadata["link"][key].parse().expect(key) };
        // The first tick of a loop here had no answer yet.
        let (overruns, stale) = (counted("overruns"), counted("stale_forces"));
        assert_eq!(record.missed_deadlines, overruns + stale);
        assert_eq!(stale > 0, loop_mode == LoopMode::Host);
        // The ticks of the device since it was asked.
        let ticks = counted("ticks");
        assert!(
            ticks >= made
                && record.tick_ns.len() == if loop_mode == LoopMode::Host { made } else { 0 }
        );
    }
}

#[test]
fn from_a_fault_of_the_device_on_nothing_counts_and_the_next_hundred_ticks_are_kept() {
    let frame_lost = |report: &mut DeviceReport| match matches!(report, DeviceReport::Fault(_)) {
        true => Fate::Lost,
        false => Fate::Passes,
    };
    let heard = Bench::FAULT.ran(losing(|_| false));
    for seen in [&heard, &Bench::FAULT.ran(frame_lost)] {
        let Some(Ending::DeviceFault(report)) = seen.ran.record.ended else {
            panic!("{:?}", seen.ran.record.ended);
        };
        let fault = u64::from(report.tick);
        let all = fault + AFTER + 1;
        assert_eq!(seen.samples(), [fault, 200, all, 0]);
        assert_eq!(seen.ran.record.last.map(|last| last.tick), Some(fault - 1));
        assert_eq!(seen.ticks(), (0..all).collect::<Vec<_>>());
        assert_eq!(seen.fault_ticks, seen.ticks());
        assert_eq!(seen.ran.record.let_go(), Some(LetGo::InOneSample));
        assert_eq!(seen.metadata[END]["ended"], "fault");
    }
    // As soon as it was heard of.
    let (kind, time_s) = &heard.events[0];
    assert!(kind == "fault" && *time_s < 0.1, "{kind} {time_s}");
}

#[test]
fn samples_that_the_line_lost_are_counted_where_they_belong() {
    let seen = Bench::WHOLE.ran(losing(|tick| (50..60).contains(&tick) || tick >= 195));
    assert_eq!(seen.samples(), [185, 200, 200, 15]);
    assert_eq!(seen.ran.record.dropped, 15);
    let kinds = ["lost", "lost"].map(str::to_owned);
    assert_eq!(
        seen.events,
        kinds.into_iter().zip([0.06, 0.2]).collect::<Vec<_>>()
    );
    // That of the fault, those behind it, and some that the device remembers.
    let seen = Bench::FAULT.ran(losing(|tick| (10..14).contains(&tick) || tick >= 29));
    assert_eq!(seen.samples(), [25, 200, 30, 5]);
    assert_eq!(seen.fault_ticks, (0..54).collect::<Vec<_>>());
    assert_eq!(seen.ran.record.let_go(), Some(LetGo::Unseen));
}

#[test]
fn a_run_that_is_stopped_ends_there() {
    for loop_mode in [LoopMode::Device, LoopMode::Host] {
        let bench = Bench {
            loop_mode,
            stops_at: 80,
            samples: 5000,
            ..Bench::WHOLE
        };
        let seen = bench.ran(losing(|_| false));
        assert_eq!(seen.ran.record.ended, Some(Ending::Interrupted));
        let [samples, planned, made, lost] = seen.samples();
        assert!(
            (80..1000).contains(&samples) && samples <= made,
            "{samples} {made}"
        );
        assert_eq!((planned, lost), (5000, 0));
        assert!(seen.ran.record.has_fallen() && !seen.ran.record.stop_unheard);
        let (kind, time_s) = &seen.events[0];
        assert!(kind == "interrupted" && *time_s >= 0.08, "{kind} {time_s}");
    }
}

#[test]
fn whoever_steers_a_loop_here_ends_it_with_a_tick() {
    let bench = Bench {
        loop_mode: LoopMode::Host,
        last_tick: 60,
        ..Bench::WHOLE
    };
    let seen = bench.ran(losing(|_| false));
    let [samples, planned, made, _] = seen.samples();
    assert!(seen.ran.record.ended.is_none() && made > 61);
    assert_eq!([samples, planned], [61, 61]);
    assert_eq!(seen.events, [("last".to_owned(), 59.0 * T)]);
}

#[test]
fn a_loop_here_starts_with_no_large_force() {
    let bench = Bench {
        loop_mode: LoopMode::Host,
        ..Bench::WHOLE
    };
    let seen = bench.ran(|report| {
        if let DeviceReport::Sample(sample) = report
            && sample.tick == 0
        {
            sample.axes[0].position_m = 0.02;
        }
        Fate::Passes
    });
    let Some(Ending::LinkLost(LinkError::Refused { request, .. })) = seen.ran.record.ended else {
        panic!("{:?}", seen.ran.record.ended);
    };
    assert_eq!((request, seen.samples()[0]), ("start", 0));
    assert_eq!(seen.ran.record.let_go(), Some(LetGo::NeverBegan));
}

#[test]
fn a_sample_that_cannot_be_ends_the_run_and_is_no_part_of_it() {
    for loop_mode in [LoopMode::Device, LoopMode::Host] {
        let seen = Bench {
            loop_mode,
            ..Bench::WHOLE
        }
        .ran(|report| {
            if let DeviceReport::Sample(sample) = report
                && sample.tick == 50
            {
                sample.axes[0].position_m = f32::NAN;
            }
            Fate::Passes
        });
        let Some(Ending::Impossible(what)) = seen.ran.record.ended else {
            panic!("{:?}", seen.ran.record.ended);
        };
        assert_eq!((what.tick(), seen.samples()[0]), (50, 50));
        assert_eq!(seen.ticks[50].flaws, haptic_log::record::flaw::IMPOSSIBLE);
        assert!(seen.ran.record.has_fallen() && seen.fault_ticks.contains(&50));
        assert_eq!(
            (seen.events[0].0.as_str(), &*seen.metadata[END]["ended"]),
            ("fault", "fault")
        );
    }
}

#[test]
fn a_device_that_somebody_else_stops_or_that_is_gone_ends_the_run() {
    let stopped = |kind| {
        move |report: &mut DeviceReport| {
            if tick(report) == Some(50) {
                *report = DeviceReport::Event(Event {
                    kind,
                    tick: 50,
                    time_us: 0,
                });
            }
            Fate::Passes
        }
    };
    let gone = |report: &mut DeviceReport| match tick(report) {
        Some(50..) => Fate::Gone,
        _ => Fate::Passes,
    };
    for (seen, ended) in [
        (
            Bench::WHOLE.ran(stopped(EventKind::Disarmed)),
            Ending::Stopped(LinkError::Disarmed),
        ),
        (
            Bench::WHOLE.ran(stopped(EventKind::Withdrawn)),
            Ending::Stopped(LinkError::Withdrawn),
        ),
        (Bench::WHOLE.ran(gone), Ending::LinkLost(LinkError::Gone)),
    ] {
        assert_eq!(seen.ran.record.ended, Some(ended));
        assert_eq!(seen.samples(), [50, 200, 50, 0]);
        let is_lost = matches!(ended, Ending::LinkLost(_));
        assert_eq!(
            seen.metadata["link"]["device_answered"],
            (!is_lost).to_string()
        );
        assert_eq!(seen.ran.record.device_lost(), is_lost);
        assert!(seen.fault_ticks.is_empty());
    }
}

/// A pair whose tissue opposes 0.3 N, as its samples report.
fn ran_pair(bench: &Bench, taps: [Tap; 2]) -> (Seen, f64) {
    let folder = Folder::empty();
    let emulated = |lines: [Box<dyn Line>; 2], over: &AtomicBool| {
        let emulations = [(); 2].map(|()| emulation());
        emulate_facing(lines, &emulations, FacingContact::COMPLIANT, over).expect("an emulation");
    };
    let opposed_n = Arc::<AtomicU64>::default();
    let ran = on_boards(taps, emulated, |names| {
        let [first, second] = names.map(|name| RemoteDevice {
            // A busy machine is silent too.
            watchdog_ms: Some(Limits::WATCHDOG_MAX_MS),
            ..bench.remote(name)
        });
        let (request, blank) = (request(&folder), |_: f64| blank(0.0));
        let stop = AtomicBool::new(false);
        let supervisor = Supervisor {
            stop: &stop,
            progress: &|counted| stop.store(counted >= bench.stops_at, Ordering::Relaxed),
            live: None,
            warn: &|_| (),
        };
        let run = |device| {
            let law = bench.law(Simulation::REAL);
            RemoteRun::new(device, law, bench.schedule(), &blank, &request)
        };
        let pair = PairRun {
            tissue: run(&first),
            drive: run(&second),
            judged: None,
            opposed_n: Arc::clone(&opposed_n),
            may_rise_s: 0.0,
        };
        pair.run(&mut bench.controller(), &mut bench.controller(), supervisor)
    });
    let opposed_n = f64::from_bits(opposed_n.load(Ordering::Relaxed));
    (Seen::of(ran), opposed_n)
}

/// Lets all pass; the samples of the tissue show a force.
fn taps() -> [Tap; 2] {
    let opposes = |report: &mut DeviceReport| {
        if let DeviceReport::Sample(sample) = report {
            sample.axes[0].force_n = -0.3;
        }
        Fate::Passes
    };
    [Box::new(opposes), Box::new(losing(|_| false))]
}

#[test]
fn a_drive_lets_go_first_at_what_it_made_and_the_tissue_after_it() {
    for loop_mode in [LoopMode::Device, LoopMode::Host] {
        let bench = Bench {
            loop_mode,
            ..Bench::WHOLE
        };
        let (seen, opposed_n) = ran_pair(&bench, taps());
        let (record, drive) = (&seen.ran.record, seen.ran.second.as_ref().expect("a drive"));
        assert!(
            seen.ran.is_whole(),
            "{:?} {:?}",
            record.ended,
            drive.record.ended
        );
        assert!((opposed_n - 0.3).abs() < 1e-6, "{opposed_n}");
        // The tissue counts from the drive's first tick on, which came when its force had risen.
        let start = record.start.tick;
        assert!(
            start > 11 && record.approach.len() as u64 == start,
            "{start}"
        );
        let [samples, planned, made, lost] = seen.samples();
        assert_eq!([samples, planned, lost], [200, start + 200, 0]);
        assert_eq!(seen.ticks.len() as u64, made);
        // The drive made at least as many, and then nothing of it counts any more.
        let [samples, planned, made, lost] =
            seen.samples_of(&drive.record, [DRIVE_END, "drive.link"]);
        assert!(
            samples >= 190 && planned == samples && lost == 0,
            "{samples} {planned} {lost}"
        );
        assert!(
            made >= samples && seen.drive_ticks.len() as u64 == made,
            "{made}"
        );
        // In the time of the tissue, as far as their clocks, which are one, tell.
        let aligned = drive.aligned.expect("both clocks are known");
        let truth_s = aligned.drive_tick_0_s - aligned.tissue_tick_0_s;
        assert!(
            (aligned.offset_s - truth_s).abs() <= aligned.residual_s,
            "{aligned:?}"
        );
        let [begun_s, within_s] = [record.start.begun_s(), drive.within_s(record.start)];
        assert!(
            (begun_s - truth_s).abs() <= within_s && within_s < 0.1,
            "{begun_s} {within_s}"
        );
        let drive_s = seen.drive_ticks.iter().zip(0_u32..);
        for (tick, n) in drive_s {
            let off_s = tick.time_s - truth_s - f64::from(n) * T;
            assert!(off_s.abs() < 0.1, "{n}: {off_s}");
        }
        assert!(seen.events.is_empty());
    }
}

#[test]
fn whoever_of_a_pair_ends_early_ends_the_other() {
    for side in [Side::Tissue, Side::Drive] {
        let mut taps = taps();
        taps[side as usize] = Box::new(|report| {
            if tick(report) == Some(60) {
                *report = DeviceReport::Event(Event {
                    kind: EventKind::Disarmed,
                    tick: 60,
                    time_us: 0,
                });
            }
            Fate::Passes
        });
        let (seen, _) = ran_pair(
            &Bench {
                samples: 5000,
                ..Bench::WHOLE
            },
            taps,
        );
        let drive = seen.ran.second.as_ref().expect("a drive");
        let mut ended = [seen.ran.record.ended, drive.record.ended];
        let ends = [
            seen.samples()[1],
            seen.samples_of(&drive.record, [DRIVE_END, "drive.link"])[1],
        ];
        if side == Side::Drive {
            ended.reverse();
        }
        assert_eq!(
            ended,
            [
                Some(Ending::Stopped(LinkError::Disarmed)),
                Some(Ending::OtherLeft)
            ]
        );
        assert!(ends[1] == 5000, "{ends:?}");
    }
}

#[test]
fn a_pair_that_is_stopped_ends_on_both_sides() {
    for loop_mode in [LoopMode::Device, LoopMode::Host] {
        let bench = Bench {
            loop_mode,
            samples: 5000,
            stops_at: 80,
            ..Bench::WHOLE
        };
        let (seen, _) = ran_pair(&bench, taps());
        let drive = seen.ran.second.as_ref().expect("a drive");
        for ended in [seen.ran.record.ended, drive.record.ended] {
            assert!(
                matches!(ended, Some(Ending::Interrupted | Ending::OtherLeft)),
                "{ended:?}"
            );
        }
        assert!(
            (80..1000).contains(&drive.record.samples),
            "{}",
            drive.record.samples
        );
    }
}
