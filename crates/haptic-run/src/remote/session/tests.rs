//! A session that is handed its samples one by one, and two that share a contact.

use super::*;
use crate::{
    FolderRequest, recorder,
    remote::{
        bad_line_tests::{ready, remote, reported},
        partner::{Both, Clock},
    },
};
use haptic_link::{BatchItem, Capabilities, Configuration, Limits};
use haptic_log::record::{Entry, LogReader};
use haptic_loop::{
    Fault, Limiters, SafetyChain,
    units::{Newtons, NewtonsPerSecond, Seconds},
};
use haptic_message::flaw;
use haptic_remote::{
    Hardware, Impossible, abilities,
    serial::{BoardTrouble, DeviceTime, Served, ServedHardware},
};
use haptic_trial::ending::LetGo;
use std::sync::{Arc, LazyLock, atomic::AtomicBool};
use testkit::Folder;

type Session<'a> = HostSession<'a, TickMessage, 1>;

#[test]
fn flaws_have_the_same_bits_on_the_wire_and_in_a_log() {
    let wire = [
        haptic_link::UNANSWERED,
        haptic_link::NOT_TAKEN,
        haptic_link::IMPOSSIBLE,
    ];
    let log = [flaw::UNANSWERED, flaw::NOT_TAKEN, flaw::IMPOSSIBLE];
    assert_eq!(wire, log);
    assert!(!wire.contains(&flaw::LATE_FORCE));
}

pub(super) fn quiet() -> Supervisor<'static> {
    static GOES_ON: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);
    Supervisor {
        stop: &GOES_ON,
        progress: &|_| (),
        live: None,
        warn: &|_| (),
    }
}

/// Record of a finished session, and its log.
pub(super) struct Left {
    pub record: RunRecord,
    ticks: Vec<TickMessage>,
    /// Kinds and times, s.
    events: Vec<(String, f64)>,
    metadata: Vec<String>,
    /// Number of samples, as the log has it.
    planned: String,
}

/// Looks at sessions of 200 samples, one for each partner.
pub(super) fn look<const N: usize>(
    partners: [Option<Partner<'_>>; N],
    push: Option<MotorPush>,
    look: impl FnOnce([&mut Session<'_>; N]),
) -> [Left; N] {
    let (folder, remote) = (Folder::empty(), remote());
    let mut folders = Vec::new();
    let mut sessions = partners.map(|partner| {
        let request = FolderRequest {
            out: Some(folder.join(folders.len().to_string())),
            stem: "run".to_owned(),
            overwrite: false,
            roll_bytes: None,
            provenance: BTreeMap::new(),
        };
        let made = request.prepare().expect("a folder");
        let log = recorder(&request, &made, BTreeMap::new(), true, quiet());
        let mut ready = ready(&remote, 200, &blank);
        ready.push = push;
        let session: Result<Session<'_>, _> = ready.session(log.expect("a log"), partner);
        folders.push(made);
        session.expect("a session")
    });
    look(sessions.each_mut());
    let mut folders = folders.into_iter();
    sessions.map(|session| {
        let ran = session
            .finish(folders.next().expect("one each"))
            .expect("a log");
        let log = LogReader::open(&ran.folder.file("mcap")).expect("a log");
        let (mut ticks, mut events, mut metadata) = (Vec::new(), Vec::new(), Vec::new());
        let mut planned = String::new();
        for entry in log {
            match entry.expect("whole") {
                Entry::Tick(tick) => ticks.push(tick),
                Entry::Event(event) => events.push((event.kind, event.time_s)),
                Entry::Metadata(about) => {
                    let number = about.values.get("planned_samples");
                    planned = number.cloned().unwrap_or(planned);
                    metadata.push(about.name);
                }
                other @ (Entry::Drive(_) | _) => panic!("{other:?}"),
            }
        }
        let record = ran.record;
        Left {
            record,
            ticks,
            events,
            metadata,
            planned,
        }
    })
}

fn event(kind: &str, time_s: f64) -> (String, f64) {
    (kind.to_owned(), time_s)
}

fn sample(tick: u32, force_n: f32) -> Sample {
    let mut sample = Sample {
        tick,
        ..Sample::default()
    };
    let axis = BatchItem {
        force_n,
        ..BatchItem::default()
    };
    sample.axes.push(axis).expect("one");
    sample
}

/// The session after these ticks, in each of which there was a force of 0.2 N, and a fault in tick 7.
fn faulted(session: &mut Session<'_>, ticks: std::ops::Range<u32>) {
    for tick in ticks {
        assert!(session.take_sample(&sample(tick, -0.2)));
    }
    session.ends(Ending::DeviceFault(reported(Fault::Workspace)));
}

#[test]
fn after_a_fault_a_hundred_ticks_are_awaited_and_the_end_of_the_force() {
    look([None], None, |[session]| {
        faulted(session, 0..7);
        for tick in 7..107 {
            assert!(session.take_sample(&sample(tick, 0.0)));
            assert!(!session.has_all_after_fault(), "{tick}");
        }
        assert!(session.take_sample(&sample(107, 0.0)) && session.has_all_after_fault());
        // The next one leaves no gap; others come only because somebody asked for them.
        assert!(session.take_sample(&sample(108, 0.0)));
        assert!(!session.take_sample(&sample(110, 0.0)));
        assert_eq!((session.record.samples, session.samples_lost), (7, 0));
    });
    // Samples of the fall are waited for, whatever is missing.
    look([None], None, |[session]| {
        faulted(session, 0..7);
        assert!((7..108).all(|tick| session.take_sample(&sample(tick, -0.1))));
        assert!(!session.has_all_after_fault());
        assert!(session.take_sample(&sample(120, -0.1)) && session.samples_lost == 12);
        assert!(session.take_sample(&sample(121, 0.0)) && session.has_all_after_fault());
        assert!(!session.take_sample(&sample(123, -0.1)) && session.samples_lost == 12);
        assert_eq!(
            session.record.let_go(),
            Some(LetGo::Ramped { until_s: 0.12 })
        );
    });
    // Those that a device sends unasked are lost if they do not come.
    look([None], None, |[session]| {
        faulted(session, 0..7);
        assert!(session.take_sample(&sample(7, 0.0)));
        assert!(!session.take_sample(&sample(150, 0.0)));
        assert_eq!((session.samples_lost, session.next_tick), (99, 107));
    });
}

#[test]
fn a_fault_affects_its_tick_and_all_later_ones() {
    let affected = [6, 7, 8].map(|tick| has_faulted(Some(7), tick));
    assert_eq!(affected, [false, true, true]);
    assert!(!has_faulted(None, 7));
}

#[test]
fn what_is_missing_and_how_it_ended_stand_in_the_log_at_their_times() {
    let [left] = look([None], None, |[session]| {
        assert!((0..5).all(|tick| session.take_sample(&sample(tick, -0.2))));
        assert!(session.take_sample(&sample(10, -0.2)));
        session.count_missing_end();
        assert_eq!(session.samples_lost, 5 + 189);
    });
    assert_eq!(left.events, [event("lost", 0.01), event("lost", 0.2)]);
    // A tick that a fault affected did not come, nor any after it.
    let [left] = look([None], None, |[session]| faulted(session, 0..5));
    assert_eq!(left.events, [event("fault", 0.005), event("lost", 0.008)]);
}

#[test]
fn the_last_tick_counts_and_those_behind_it_only_show_the_fall() {
    look([None], None, |[session]| {
        assert!((0..199).all(|tick| session.take_sample(&sample(tick, -0.2))));
        let mut other = sample(199, -0.2);
        other.axes.push(BatchItem::default()).expect("room");
        // Of another number of axes.
        assert!(session.take_sample(&other) && session.next_tick == 199);
        assert!(session.take_sample(&sample(199, -0.2)) && !session.record.has_fallen());
        assert!(session.take_sample(&sample(200, 0.0)) && session.record.has_fallen());
        assert_eq!((session.record.samples, session.counted()), (200, 201));
        session.count_missing_end();
        assert_eq!((session.samples_lost, session.lets_go()), (0, false));
    });
}

#[test]
fn a_law_that_swings_is_not_fit_to_go_on() {
    look([None], Some(MotorPush::Own(0.1)), |[session]| {
        session.take_sample(&sample(0, 0.1));
        assert_eq!(session.unfit_to_go_on(), None);
        session.take_sample(&sample(1, 0.5));
        session.take_sample(&sample(2, 0.1));
        assert_eq!(session.unfit_to_go_on(), Some(Ending::Swing));
    });
}

#[test]
fn a_line_that_is_lost_before_a_stop_was_heard_is_what_ended_the_run() {
    let gone = SerialError::Link(LinkError::Gone);
    for (asked, over, ticks, unheard) in [
        (Ending::Interrupted, false, 7, true),
        (Ending::OtherLeft, false, 7, false),
        (Ending::Swing, false, 7, false),
        (Ending::Interrupted, true, 7, false),
        (Ending::Interrupted, false, 0, true),
    ] {
        look([None], None, |[session]| {
            assert!((0..ticks).all(|tick| session.take_sample(&sample(tick, -0.2))));
            session.ends(asked);
            session.over = over;
            assert_eq!(session.may_run_on(), !over && ticks > 0);
            session.give_up(&gone);
            let ended = if over {
                asked
            } else {
                Ending::LinkLost(LinkError::Gone)
            };
            assert_eq!(
                (session.record.ended, session.record.stop_unheard),
                (Some(ended), unheard)
            );
        });
    }
    look([None], None, |[session]| {
        session.take_sample(&sample(0, -0.2));
        assert!(session.may_run_on() && !session.deaf);
        session.ends(Ending::DeviceFault(reported(Fault::Workspace)));
        assert!(!session.may_run_on());
        let request = "stop";
        let line = Default::default();
        session.give_up(&LinkError::NoAnswer { request, line }.into());
        session.give_up(&gone);
        assert!(session.deaf && session.record.ended.is_some_and(Ending::is_fault));
    });
}

/// Partner in a pair whose clocks are not known, and of which 100 samples count.
fn partner(both: &Both, side: Side) -> Partner<'_> {
    let none: Clock = Arc::new(|| None);
    let clocks = [Arc::clone(&none), none];
    let mut partner = Partner::new(both, side, clocks, FALLEN, Arc::default());
    partner.samples = 100;
    partner
}

#[test]
fn a_drive_may_let_go_once_the_tissue_is_whole_and_the_tissue_after_it() {
    let both = Both::default();
    let sides = [Side::Tissue, Side::Drive].map(|side| Some(partner(&both, side)));
    let left = look(sides, None, |[tissue, drive]| {
        tissue.ready.schedule.samples = 150;
        (tissue.next_tick, drive.next_tick) = (149, 80);
        assert!(tissue.is_pushed() && !drive.is_pushed());
        assert!(!tissue.lets_go() && !drive.lets_go());
        tissue.next_tick = 150;
        assert!(!tissue.lets_go() && drive.lets_go());
        // What it has made is what counts of it.
        assert_eq!(drive.ready.schedule.samples, 80);
        drive.partner.iter().for_each(Partner::done);
        drive.next_tick = 90;
        assert!(!drive.lets_go() && drive.ready.schedule.samples == 80);
        tissue.next_tick = 151;
        assert!(tissue.lets_go() && tissue.ready.schedule.samples == 150);
        tissue.ends(Ending::Interrupted);
        assert!(!tissue.lets_go());
    });
    assert_eq!(left.map(|left| left.planned), ["150", "80"]);
}

#[test]
fn a_drive_whose_tissue_has_left_does_not_start() {
    let both = Both::default();
    let sides = [Side::Tissue, Side::Drive].map(|side| Some(partner(&both, side)));
    let left = look(sides, None, |[tissue, drive]| {
        tissue.ends(Ending::Interrupted);
        connects(drive, SOUND, LoopMode::Device);
        assert!(!drive.start(0, quiet()).expect("no error"));
        assert_eq!(drive.record.ended, Some(Ending::OtherLeft));
    });
    // Nobody knows when the run would have begun.
    assert_eq!(left.map(|left| left.planned), ["100", "100"]);
}

#[test]
fn a_drive_has_the_time_of_its_tissue_and_its_law_that_of_the_run() {
    let both = Both::default();
    let mut partner = partner(&both, Side::Drive);
    partner.shift_s = 0.5;
    let [left] = look([Some(partner)], None, |[session]| {
        session.record.start = haptic_trial::samples::RunStart::from(0.004, 1e-3);
        assert!(session.take_sample(&sample(4, -0.2)));
        let message = session.message(&sample(7, -0.2)).expect("one axis");
        assert_eq!((message.time_s, message.reference_m), (0.507, 0.003.into()));
        session.ends(Ending::Interrupted);
    });
    assert_eq!(
        left.events,
        [event("lost", 0.504), event("interrupted", 0.505)]
    );
}

/// Ticks of a run before a board's end.
const TICKS: u32 = 20;

/// A board that stands still; its force sensor shows 0.25 N.
struct Board {
    read: u32,
    /// It fails after these.
    fails: bool,
    /// Its sensor is at the end of its range then.
    saturates: bool,
}

impl Device<f32, 1> for Board {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, 1>, Fault> {
        self.read += 1;
        if self.fails && self.read > TICKS {
            return Err(Fault::BoardFailed);
        }
        self.idle()
    }

    fn write(&mut self, _: SafeForce<f32, 1>) -> Result<(), Fault> {
        Ok(())
    }

    fn let_go(&mut self) {}
}

impl Hardware for Board {
    type Setup = ();

    fn capabilities(&self) -> Capabilities {
        Capabilities {
            force_max_n: 10.0,
            force_rate_max_n_per_s: 1e6,
            sensed_force_max_n: 5.0,
            ..abilities("still", 1)
        }
    }

    fn install(&mut self, (): (), _: u32) {}

    fn restart(&mut self) {
        self.read = 0;
    }

    fn idle(&mut self) -> Result<Reading<f32, 1>, Fault> {
        Ok(Reading {
            tick: 0,
            time_s: 0.0,
            position_m: [1.0 / 1024.0].into(),
        })
    }

    fn sense(&mut self) -> [f32; 1] {
        [if self.saturates && self.read > TICKS {
            5.0
        } else {
            0.25
        }]
    }
}

impl ServedHardware for Board {
    fn trouble(&self) -> Option<BoardTrouble> {
        None
    }
}

/// Gives the session this board, which runs in its own time.
fn connects(session: &mut Session<'_>, board: Board, loop_mode: LoopMode) {
    let served = Served::in_its_own_time(board, DeviceTime::default()).expect("serves");
    let mut link = SerialLink::to_served(served, "still:one").expect("answers");
    let configuration = Configuration {
        loop_mode,
        limits: Limits {
            // A busy machine is late.
            max_age_ticks: 1000,
            ..Limits::bare(10.0, 1e5)
        },
        ..Configuration::PASSIVE
    };
    link.set(configuration, &[0.0]).expect("good");
    session.ready.link = link;
}

/// The session of a run on this board, of which the first sample has come.
fn begins(session: &mut Session<'_>, board: Board, ticks: u32) {
    connects(session, board, LoopMode::Device);
    assert!(session.start(ticks, quiet()).expect("starts"));
    loop {
        match session.ready.link.hear(FALLEN) {
            Some(DeviceMessage::Sample(sample)) => break assert!(session.take_sample(&sample)),
            Some(DeviceMessage::Event(_)) => {}
            Some(DeviceMessage::Fault(_) | DeviceMessage::Over(_)) | None => panic!("no sample"),
        }
    }
}

const SOUND: Board = Board {
    read: 0,
    fails: false,
    saturates: false,
};

#[test]
fn what_a_device_still_says_after_its_line_failed_is_heard_if_its_end_is_unknown() {
    let request = "stop";
    let line = Default::default();
    let deaf = SerialError::Link(LinkError::NoAnswer { request, line });
    look([None], None, |[session]| {
        let fails = true;
        begins(session, Board { fails, ..SOUND }, 0);
        session.give_up(&deaf);
        let Some(Ending::DeviceFault(report)) = session.record.ended else {
            panic!("{:?}", session.record.ended)
        };
        assert_eq!((report.tick, session.record.samples), (TICKS, TICKS.into()));
    });
    look([None], None, |[session]| {
        begins(session, SOUND, TICKS);
        session.give_up(&deaf);
        let ended = (session.record.ended, session.record.samples);
        assert_eq!(ended, (None, TICKS.into()));
    });
    // It answers: what it has to say of the run is not its end.
    let error = LinkError::HeldUp { waited_ms: 2000 };
    look([None], None, |[session]| {
        begins(session, SOUND, TICKS);
        session.give_up(&error.into());
        let ended = (session.record.ended, session.record.samples);
        assert_eq!(ended, (Some(Ending::LinkLost(error)), 1));
    });
}

#[test]
fn a_sample_that_cannot_be_is_in_the_log_and_no_part_of_the_result() {
    look([None], None, |[session]| {
        let saturates = true;
        connects(session, Board { saturates, ..SOUND }, LoopMode::Device);
        let error = session.listen(quiet()).expect_err("a saturated sensor");
        session.give_up(&error);
        let Some(Ending::Impossible(what)) = session.record.ended else {
            panic!("{:?}", session.record.ended)
        };
        assert!(
            matches!(what, Impossible::Saturated { tick: TICKS, .. }),
            "{what}"
        );
        assert_eq!(
            (session.record.samples, session.samples_lost),
            (TICKS.into(), 0)
        );
        assert!(session.next_tick > u64::from(TICKS));
    });
}

#[test]
fn a_device_that_holds_its_handle_shows_the_offset_of_its_sensor_before() {
    for (tares, offset) in [(true, Some([0.25, 0.0, 0.0])), (false, None)] {
        look([None], None, |[session]| {
            session.ready.tares = tares;
            begins(session, SOUND, 1);
            let known = match session.record.sensor.offset {
                SensorOffset::Known(offset) => Some(offset),
                SensorOffset::Measuring | SensorOffset::Touched { .. } => None,
            };
            assert_eq!(known, offset);
        });
    }
}

/// A law of 128 N/m.
pub(super) struct Spring;

impl Environment<f64, 1> for Spring {
    type History = ();

    fn at_rest(&self) {}

    fn force(&self, (): &(), position_m: &SVector<f64, 1>) -> SVector<f64, 1> {
        -128.0 * position_m
    }

    fn advance(&self, (): &mut (), _: &SVector<f64, 1>) {}
}

/// Rendered at a rise of 20 N/s: a tick's force rises for seven ticks.
pub(super) fn rendered() -> Controller<f64, 1, Spring> {
    let chain = SafetyChain::new(Newtons(10.0), NewtonsPerSecond(20.0), Seconds(1e-3));
    Controller::new(Spring, chain.expect("good"))
}

#[test]
fn a_run_that_the_device_renders_is_whole_and_counted() {
    let [left] = look([None], None, |[session]| {
        connects(session, SOUND, LoopMode::Device);
        let before = &mut session.ready.before;
        (before.overruns, before.stale_forces) = (u32::MAX, u32::MAX - 1);
        session.conduct(&mut rendered(), &mut (), quiet());
        assert_eq!((session.record.ended, session.samples_lost), (None, 0));
        session.note("noted", &BTreeMap::from([("key", 1)]));
        session.samples_lost = 3;
    });
    let record = &left.record;
    let counted = (record.samples, record.missed_deadlines, record.dropped);
    assert_eq!(counted, (200, 3, 3));
    let link = record.link.as_ref().expect("one");
    assert_eq!((link.samples_lost, link.device_answered), (3, true));
    assert!(left.metadata.contains(&"noted".to_owned()));
    // Of one that does not answer nothing is asked.
    let [left] = look([None], None, |[session]| session.deaf = true);
    let link = left.record.link.expect("one");
    assert!(!link.device_answered);
}

#[test]
fn a_run_that_is_stopped_lets_go() {
    for mode in [LoopMode::Device, LoopMode::Host] {
        let stop = Arc::new(AtomicBool::new(true));
        let supervisor = Supervisor {
            stop: &stop,
            ..quiet()
        };
        look([None], None, |[session]| {
            connects(session, SOUND, mode);
            let done = match mode {
                LoopMode::Device => session.listen(supervisor),
                LoopMode::Host => session.control(&mut rendered(), &mut (), supervisor),
            };
            assert!(done.is_ok(), "{done:?}");
            assert_eq!(session.record.ended, Some(Ending::Interrupted));
            assert!(session.over);
        });
    }
}

#[test]
fn a_loop_here_logs_what_the_device_makes_of_its_forces() {
    let [left] = look([None], None, |[session]| {
        session.ready.tares = true;
        connects(session, SOUND, LoopMode::Host);
        let done = session.control(&mut rendered(), &mut (), quiet());
        assert!(done.is_ok() && session.over, "{done:?}");
    });
    assert_eq!((left.record.ended, left.record.samples), (None, 200));
    let rising = Limiters::RATE.bits();
    for (tick, commanded_n, applied_n) in [(0, -0.02, 0.0), (199, -0.125, -0.125)] {
        let tick = &left.ticks[tick];
        assert_eq!(tick.commanded_force_n, commanded_n.into());
        assert_eq!(tick.applied_force_n, applied_n.into());
        assert_eq!(tick.sensed_force_n, Some(0.0.into()));
    }
    assert_eq!(left.ticks[2].limiters & rising, rising);
}
