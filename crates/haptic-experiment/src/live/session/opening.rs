//! The beginning of a session, and its end: documents, the claim on a device, and the work of the thread of its loop.

use crate::{
    experiment::{kind::Experiment as _, trial::law_of, wall::WallExperiment},
    live::{
        orders::locked,
        runner::{HeldWorld, Steering},
        ticking::{FadingFelt, Looping},
        waiting::Gate,
    },
    open::{DocumentOfKind as _, ExperimentFile},
};
use haptic_document::{
    Document, Failure, IN_LOG, bad_input,
    parameters::{DAMPING, DEVICE, DEVICE_MODEL, LOOP, MASS, SAMPLE_TIME, SCHEME},
};
use haptic_loop::{Controller, plant::MassDamperConfig, units::NewtonsPerMetre};
use haptic_quantity::written;
use haptic_remote::serial::SerialLink;
use haptic_run::{
    Ran, Supervisor,
    device::LinkedName,
    folder::FolderRequest,
    realtime::RealtimeOptions,
    remote::{RemoteDevice, RemoteRun, blank, delay_of},
    run_logged,
    schedule::Schedule,
};
use haptic_trial::{
    in_hand::hand::HeldDevice,
    keys::{
        trial::{PUSH, TRIAL_FORCE_LIMIT},
        wall::{DISSIPATION, ONE_SIDED, ORDER, STIFFNESS, WALL_CONTACT, WALL_LAW},
    },
};
use serde::Serialize;
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::{Arc, Mutex, PoisonError, atomic::AtomicBool, mpsc::Sender},
};

/// Name of a session in its log.
const KIND: &str = "session";
/// Its table in a document: keys of a wall, its device, its safety chain.
const TABLE: &str = "wall";
/// Keys of a law that is to be felt; all others are the session's.
pub(super) fn law_keys() -> impl Iterator<Item = &'static str> {
    let others = [&SCHEME, &WALL_CONTACT];
    WALL_LAW.iter().chain(others).map(|parameter| parameter.key)
}

/// Ticks of a session at most: eleven days at 1 kHz.
const TICKS: u64 = 1_000_000_000;

/// Push of an emulated device's hand if nobody asks for one, N: next to none.
const NO_PUSH_N: f64 = 1e-6;

/// Devices of open sessions: a device is in one session at a time.
static OPEN: Mutex<Vec<LinkedName>> = Mutex::new(Vec::new());

/// A device that this session alone has, until it has let go.
pub(super) struct Claim(LinkedName);

impl Claim {
    pub(super) fn of(name: &LinkedName) -> Result<Self, Failure> {
        let mut open = locked(&OPEN);
        if open.iter().any(|other| other.may_be(name)) {
            return Err(bad_input!(
                "a session on {name} is open already: close it first"
            ));
        }
        open.push(name.clone());
        Ok(Self(name.clone()))
    }
}

impl Drop for Claim {
    fn drop(&mut self) {
        let mut open = locked(&OPEN);
        if let Some(at) = open.iter().position(|other| *other == self.0) {
            open.swap_remove(at);
        }
    }
}

/// Device, log and pace of a session.
#[derive(Clone, Debug)]
pub struct SessionOptions {
    /// Keys of a `[wall]` but those of the law: the device and its loop, and the safety chain.
    pub document: Document,
    /// The log, which must not be there yet.
    pub log: PathBuf,
    /// Maker of the log, for its metadata.
    pub provenance: BTreeMap<String, String>,
    /// Settings of the thread of a loop by the clock; `None` for virtual time, which a device at a port does not have.
    pub realtime: Option<RealtimeOptions>,
}

/// Report of a session that has ended.
#[derive(Clone, Debug, Serialize)]
pub struct SessionReport {
    /// Samples in the log, those that were dropped left out.
    pub samples: u64,
    /// Samples and events that are not in it.
    pub dropped_samples: u64,
    /// Time from the first sample to the last, s.
    pub duration_s: f64,
    /// Why it ended before it was closed; null if it did not.
    pub ended_early: Option<String>,
    /// The log of a fault; null without one.
    pub fault_log: Option<String>,
    /// Sentences for the user.
    pub warnings: Vec<String>,
}

/// The end of the loop.
#[derive(Debug)]
pub(super) struct Ended {
    /// The failure, for the first who asks.
    pub failure: Option<Failure>,
    pub words: String,
    pub report: Option<SessionReport>,
}

/// Facts of the device before it is armed.
pub(super) struct Connected {
    /// Samples by which the loop here is later than one on it.
    pub line: usize,
    pub rise_ticks: u64,
}

/// The document with what a session decides.
pub(super) fn prepared(options: &SessionOptions) -> Result<Document, Failure> {
    let mut document = options.document.clone();
    let given: Vec<String> = document.given().map(str::to_owned).collect();
    let has = |key: &str| given.iter().any(|given| given == key);
    if let Some(key) = law_keys().find(|key| has(key)) {
        return Err(bad_input!(
            "{key} is of a wall, not of the session: give it in a wall to allow"
        ));
    }
    if !has(TRIAL_FORCE_LIMIT.key) {
        return Err(bad_input!(
            "{TRIAL_FORCE_LIMIT} is missing: give the largest force on a person"
        ));
    }
    let mut set = |key: &str, value: toml::Value| document.set(TABLE, key, value, "");
    set(ONE_SIDED.key, true.into())?;
    let usual = [(PUSH, NO_PUSH_N)].into_iter();
    let of_device = [MASS, DAMPING].map(|known| (known, known.default_number()));
    let of_device = of_device.into_iter().filter(|_| !has(DEVICE_MODEL.key));
    let sample_time = [(SAMPLE_TIME, SAMPLE_TIME.default_number())];
    for (known, number) in usual.chain(of_device).chain(sample_time) {
        if !has(known.key) {
            set(known.key, number.into())?;
        }
    }
    if has(DEVICE.key) && !has(LOOP.key) {
        set(LOOP.key, "host".into())?;
    }
    Ok(document)
}

/// The law of no force.
pub(super) fn no_law() -> Result<Document, Failure> {
    let mut document = Document::new(TABLE);
    for law in [ORDER, STIFFNESS, DISSIPATION] {
        document.set(TABLE, law.key, 0.0, "")?;
    }
    Ok(document)
}

/// The wall of a document.
pub(super) fn wall(document: &Document) -> Result<WallExperiment, Failure> {
    let experiment = ExperimentFile::open(document)?;
    let wall: Option<&WallExperiment> = experiment.of();
    wall.filter(|wall| wall.trial.setup.second.is_none())
        .cloned()
        .ok_or_else(|| Failure::bad_input("a session feels walls alone, without [drive]"))
}

/// The folder and stem of a log.
pub(super) fn request(
    log: &Path,
    provenance: BTreeMap<String, String>,
) -> Result<FolderRequest, Failure> {
    let stem = log
        .file_stem()
        .map(|stem| stem.to_string_lossy().into_owned());
    let is_log = log.extension().is_some_and(|ending| ending == "mcap");
    let Some(stem) = stem.filter(|_| is_log) else {
        return Err(bad_input!(
            "log = \"{}\" is not the name of a log: write it as p07.mcap",
            log.display()
        ));
    };
    if log.exists() {
        return Err(Failure::exists(
            log,
            "choose another log, or move it away".to_owned(),
        ));
    }
    let folder = log.parent().filter(|folder| !folder.as_os_str().is_empty());
    Ok(FolderRequest {
        out: Some(folder.unwrap_or(Path::new(".")).to_owned()),
        stem,
        overwrite: false,
        roll_bytes: None,
        provenance,
    })
}

/// All that the thread of the loop owns.
pub(super) struct Work {
    pub wall: WallExperiment,
    pub controller: Controller<f64, 1, FadingFelt>,
    pub looping: Looping,
    pub request: FolderRequest,
    pub metadata: BTreeMap<String, String>,
    pub gate: Option<Arc<Gate>>,
    pub stop: Arc<AtomicBool>,
    pub connected: Sender<Connected>,
    /// Mass and damping are given.
    pub is_known: bool,
}

impl Work {
    /// Runs to the end of the session; the warnings besides.
    pub(super) fn run(self) -> (Result<Ran, Failure>, Vec<String>) {
        let heard = Mutex::new(Vec::new());
        let warn = |text: &str| locked(&heard).push(text.to_owned());
        let stop = Arc::clone(&self.stop);
        let supervisor = Supervisor {
            stop: &stop,
            progress: &|_| (),
            live: None,
            warn: &warn,
        };
        let schedule = self.wall.schedule(TICKS);
        let ran = match self.wall.conduct.remote.clone() {
            None => self.simulated(schedule, supervisor),
            Some(device) => self.steered(&device, schedule, supervisor),
        };
        (
            ran,
            heard.into_inner().unwrap_or_else(PoisonError::into_inner),
        )
    }

    fn steered(
        mut self,
        device: &RemoteDevice,
        schedule: Schedule,
        supervisor: Supervisor<'_>,
    ) -> Result<Ran, Failure> {
        let law = law_of(&self.wall.trial.setup);
        let run = RemoteRun {
            metadata: self.metadata,
            ..RemoteRun::new(device, law, schedule, &|_| blank(0.0), &self.request)
        };
        let connected = |link: &SerialLink, rise_ticks| {
            let simulated = link.capabilities().simulated;
            if !(simulated || self.is_known) {
                return Err(bad_input!(
                    "the device is unknown, so no wall can be judged: give {DEVICE_MODEL}, or {MASS} and {DAMPING}"
                ));
            }
            // Whoever opens may have given up.
            let _ = self.connected.send(Connected {
                line: delay_of(link, device, schedule),
                rise_ticks,
            });
            Ok(())
        };
        let mut steering = Steering(self.looping);
        run.steered(&mut self.controller, &mut steering, connected, supervisor)
    }

    fn simulated(mut self, schedule: Schedule, supervisor: Supervisor<'_>) -> Result<Ran, Failure> {
        let setup = &self.wall.trial.setup;
        let free = MassDamperConfig {
            stiffness: NewtonsPerMetre(0.0),
            ..setup.device
        };
        let mut device = HeldDevice::new(free, setup.sensors)?;
        let _ = self.connected.send(Connected {
            line: 0,
            rise_ticks: 0,
        });
        let mut world = HeldWorld::new(
            &mut self.controller,
            &mut device,
            self.looping,
            self.gate,
            supervisor.stop,
        );
        run_logged(
            &mut world,
            schedule,
            (&self.request, self.metadata),
            supervisor,
        )
    }
}

impl Ended {
    pub(super) fn of(ran: Result<Ran, Failure>, mut warnings: Vec<String>, log: &Path) -> Self {
        let ran = match ran {
            Ok(ran) => ran,
            Err(failure) => {
                return Self {
                    words: format!("the session has ended: {failure}"),
                    failure: Some(failure),
                    report: None,
                };
            }
        };
        let record = &ran.record;
        let early = record.reason().map(|reason| {
            let let_go = record.let_go().map(|let_go| let_go.words());
            let let_go = let_go.map_or(String::new(), |words| format!("; {words}"));
            format!(
                "{reason}{let_go}; the session ended at {}, its log {} is kept",
                written("time_s", record.duration_s()),
                log.display()
            )
        });
        warnings.extend(ran.live_warnings);
        let failure = early.as_ref().map(|words| {
            if record.device_lost() {
                Failure::device(words)
            } else {
                Failure::run(words)
            }
        });
        let dropped = record.dropped;
        let lost = (dropped > 0).then(|| format!("{dropped} samples or events are not in the log"));
        warnings.extend(lost);
        Self {
            words: early
                .clone()
                .unwrap_or_else(|| "the session is closed".to_owned()),
            failure,
            report: Some(SessionReport {
                samples: ran.log.samples,
                dropped_samples: dropped,
                duration_s: record.duration_s(),
                ended_early: early,
                fault_log: ran.fault_log.map(|path| path.display().to_string()),
                warnings,
            }),
        }
    }
}

/// All keys of a session for its log.
pub(super) fn provenance(
    base: &Document,
    mut provenance: BTreeMap<String, String>,
) -> Result<BTreeMap<String, String>, Failure> {
    base.keep_in(&mut provenance)?;
    // It is no wall that could be run again.
    let not_of_it = [IN_LOG.1, ORDER.key, STIFFNESS.key, DISSIPATION.key];
    provenance.retain(|key, _| !not_of_it.contains(&key.as_str()));
    Ok(provenance)
}

pub(super) fn metadata(wall: &WallExperiment) -> BTreeMap<String, String> {
    let mut metadata = wall.metadata();
    metadata.insert("experiment".to_owned(), KIND.to_owned());
    metadata
}
