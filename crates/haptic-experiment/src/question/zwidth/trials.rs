//! Many short runs on one serial device, without log or files, for a search.
//!
//! A trial that does not test its law is repeated, ten times in all: samples were missing or delayed, or a host, line or tick was late. Then
//! no more trials are made; nor after twenty in a row that ended at a limit of the device, nor after any fault that the law does not cause.

use haptic_document::Failure;
use haptic_document::Warn;
use haptic_document::parameters::{LOOP, TRIAL_DURATION};
use haptic_judge::preflight::WallContact;
use haptic_judge::settling::{Judge, Settling};
use haptic_judge::trial::force_and_rate;
use haptic_link::{
    Capabilities, Configuration, EventKind, FaultReport, LoopMode, Refusal, Scope, Start,
    State as DeviceState,
};
use haptic_loop::realtime::Moment;
use haptic_loop::{Fault, SafetyLimits};
use haptic_question::zwidth::rig::{Rig, TRIPS_IN_A_ROW, WallThere};
use haptic_remote::LinkError;
use haptic_remote::serial::{DeviceMessage, SerialError, SerialLink};
use haptic_run::device::{at_link, at_port, refused_at_port, trouble};
use haptic_run::realtime::RealtimeOptions;
use haptic_run::remote::{RemoteDevice, RemoteLaw, held, may_push, portable, within};
use haptic_run::schedule::{Pace, Schedule};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

#[cfg(test)]
mod pushed_tests;
#[cfg(all(test, feature = "bad-lines"))]
mod tests;

/// Attempts at a trial that does not test its law.
const TRIES: usize = 10;
/// The force of a trial before has fallen to zero in this time: the longest of [`Limits`](haptic_link::Limits), and an idle host.
const FALLEN_WITHIN: Duration = Duration::from_secs(5);
/// Whoever pushes the device into the wall has moved it out again in this time.
const OUT_WITHIN: Duration = Duration::from_secs(30);
/// A trial without a sample for so long is held up, or its line is.
const SILENCE: Duration = Duration::from_secs(2);
/// Time from one look for a stop to the next.
const LOOK: Duration = Duration::from_millis(50);
/// Between two questions whether it has.
const PAUSE: Duration = Duration::from_millis(10);

/// A motor holds this share of its largest force for as long as it likes: 4 N of the 8 N of the device that the guide builds.
const HELD_SHARE: f64 = 0.5;
/// Share of the way to the end of the workspace at which a trial of a device that pushes by itself is ended.
const NEAR_END: f64 = 0.8;
/// Longest way of the handle out of the wall, s.
const RETREAT_S: f64 = 5.0;

/// One run, as far as it came.
enum Trial {
    Whole,
    /// Whoever looked on had seen enough.
    Seen,
    /// The law moved the device beyond a limit: this fault.
    Tripped(Fault),
    /// Nothing is known of the law, because of the line or this machine.
    Unjudged(Failure),
}

/// Looks at the tick, position, m, and force, N, of each sample; false ends the run.
type See<'a> = &'a mut dyn FnMut(u64, f64, f64) -> bool;

/// A device that makes one run after another.
trait Bench: Send {
    fn path(&self) -> String;

    fn capabilities(&self) -> Capabilities;

    /// A run of so many ticks, in the device's own loop.
    fn run(
        &mut self,
        configuration: Configuration,
        coefficients: &[f32],
        ticks: u64,
        see: See<'_>,
        warn: Warn<'_>,
    ) -> Result<Trial, Failure>;

    /// Lets it rest, without force.
    fn rest(&mut self, time_s: f64);

    /// A failure with what else is known of the device's line.
    fn at_line(&self, failure: Failure) -> Failure;
}

/// A device that is tried again and again.
pub(super) struct Trials<'a> {
    remote: RemoteDevice,
    /// Settings of the device: no trial loosens them.
    set: Configuration,
    /// Its identity and its lasting limits, on which all that is found depends.
    whose: String,
    /// The way out of a wall into which the device pushes by itself.
    retreat: Option<RemoteLaw>,
    warn: Warn<'a>,
    state: Mutex<State>,
}

struct State {
    bench: Box<dyn Bench>,
    /// Why no more trials can be made.
    failure: Option<Failure>,
    /// True once the user was warned of the device's limits.
    is_asked: bool,
    /// Trials judged, those of them that ended at a limit of the device, the last of them in a row, and the last such fault.
    trials: usize,
    trips: usize,
    in_a_row: usize,
    last: Option<Fault>,
    /// Place of the handle before the first trial, m, and in the newest sample.
    home_m: Option<f64>,
    newest_m: f64,
}

/// A device at the other end of a link.
struct LinkedBench {
    link: SerialLink,
    watchdog: Duration,
    /// True once the user was asked to move the device out of the wall.
    told_too_deep: bool,
    runs: u32,
}

impl<'a> Trials<'a> {
    pub(super) fn new(
        remote: &RemoteDevice,
        retreat: Option<RemoteLaw>,
        warn: Warn<'a>,
        stop: &Arc<AtomicBool>,
    ) -> Result<Self, Failure> {
        if remote.loop_mode == LoopMode::Host {
            return Err(Failure::bad_input(format_args!(
                "a search runs in the device's own loop: omit {}",
                LOOP.set_to("host")
            )));
        }
        let mut link = (remote.name).connect_with(1, remote.patience, warn, Some(stop))?;
        remote.calibrate(&mut link)?;
        if retreat.is_some() {
            may_push(remote, &link)?;
        }
        let lasting = remote.name.remembered(&link).set()?.map(|set| set.limits);
        let whose = format!("{} {lasting:?}", remote.name.identity(&link));
        let set = link.configuration();
        let (set, _) = set.map_err(|error| at_port(link.path(), &error))?;
        let bench = LinkedBench {
            link,
            watchdog: remote.watchdog(),
            told_too_deep: false,
            runs: 0,
        };
        Ok(Self {
            whose,
            ..Self::on(Box::new(bench), remote, set, retreat, warn)
        })
    }

    fn on(
        bench: Box<dyn Bench>,
        remote: &RemoteDevice,
        set: Configuration,
        retreat: Option<RemoteLaw>,
        warn: Warn<'a>,
    ) -> Self {
        Self {
            remote: remote.clone(),
            set,
            whose: String::new(),
            retreat,
            warn,
            state: Mutex::new(State {
                bench,
                failure: None,
                is_asked: false,
                trials: 0,
                trips: 0,
                in_a_row: 0,
                last: None,
                home_m: None,
                newest_m: 0.0,
            }),
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Remedy for a limit that ended a trial.
    fn remedy(&self, fault: Fault) -> String {
        let set = &self.set.limits;
        if fault == Fault::Workspace {
            return format!(
                "set more room than {} m to {} m on the device (`host-cli device set`), hold it in the middle, or push less",
                set.workspace_low_m, set.workspace_high_m
            );
        }
        format!(
            "set more than {} m/s on the device (`host-cli device set`), or push less",
            set.speed_hard_m_per_s
        )
    }

    /// A trial, out of the wall before it where the device pushes by itself.
    fn try_once(
        &self,
        state: &mut State,
        law: &RemoteLaw,
        samples: u64,
        sample_time_s: f64,
        see: See<'_>,
    ) -> Result<Trial, Failure> {
        if let (Some(retreat), Some(home_m)) = (&self.retreat, state.home_m) {
            let mut is_in = |_, position_m, _| position_m > home_m;
            let ticks = (RETREAT_S / sample_time_s).ceil() as u64;
            match self.run(state, retreat, ticks, sample_time_s, &mut is_in)? {
                Trial::Seen => {}
                unjudged @ Trial::Unjudged(_) => return Ok(unjudged),
                Trial::Whole | Trial::Tripped(_) => {
                    return Err(Failure::device(format_args!(
                        "{}: the handle stands at {:.4} m and does not come back to {home_m:.4} m by itself: move it there, and push more or set more room",
                        state.bench.path(),
                        state.newest_m
                    )));
                }
            }
        }
        // A wall of a device that pushes by itself is where the handle stands, any other at the device's zero.
        let mut first_m = self.retreat.is_none().then_some(0.0);
        let ends = match self.retreat {
            Some(_) => [
                self.set.limits.workspace_low_m,
                self.set.limits.workspace_high_m,
            ],
            None => [f32::NEG_INFINITY, f32::INFINITY],
        };
        let mut see = |tick, position_m: f64, force_n| {
            let first_m = *first_m.get_or_insert(position_m);
            // Beyond its end nobody but a person brings it back.
            let [low_m, high_m] = ends.map(|end| first_m + NEAR_END * (f64::from(end) - first_m));
            let has_room = (low_m..=high_m).contains(&position_m);
            has_room && see(tick, position_m - first_m, force_n)
        };
        let trial = self.run(state, law, samples, sample_time_s, &mut see);
        state.home_m = state.home_m.or(first_m);
        trial
    }

    /// A run within the limits of the device, and the rest that its motor needs.
    fn run(
        &self,
        state: &mut State,
        law: &RemoteLaw,
        ticks: u64,
        sample_time_s: f64,
        see: See<'_>,
    ) -> Result<Trial, Failure> {
        let schedule = scheduled(ticks, sample_time_s);
        let can = state.bench.capabilities();
        // A search does not end where the device's limits do.
        let warn = |text: &str| {
            if !state.is_asked {
                (self.warn)(text);
            }
        };
        let configuration = within(&self.remote, law, schedule, &can, &self.set, &warn)?;
        state.is_asked = true;
        let (mut newest_m, mut squares, mut seen) = (state.newest_m, 0.0, 0.0);
        let mut heated = |tick, position_m, force_n: f64| {
            newest_m = position_m;
            squares += force_n * force_n;
            seen += 1.0;
            see(tick, position_m, force_n)
        };
        let coefficients = &law.operator.1;
        let trial = (state.bench).run(configuration, coefficients, ticks, &mut heated, self.warn);
        state.newest_m = newest_m;
        if self.retreat.is_some() {
            let held_n = HELD_SHARE * f64::from(can.force_max_n);
            let heat = squares / (held_n * held_n);
            (state.bench).rest(sample_time_s * (heat - seen).max(0.0));
        }
        trial
    }
}

impl Rig for Trials<'_> {
    fn whose(&self) -> &str {
        &self.whose
    }

    fn encoder_and_force(&self) -> (f64, f64) {
        let state = self.state();
        let can = state.bench.capabilities();
        (
            f64::from(can.position_resolution_m),
            f64::from(can.force_max_n.min(self.set.limits.force_n)),
        )
    }

    fn accepts(&self, wall: &WallThere, samples: u64) -> Result<(), Failure> {
        let can = self.state().bench.capabilities();
        let schedule = scheduled(samples, wall.device.sample_time.0);
        within(
            &self.remote,
            &law_there(wall)?,
            schedule,
            &can,
            &self.set,
            &|_| {},
        )
        .map(|_| ())
    }

    fn judged(&self, wall: &WallThere, samples: u64, judge: Judge) -> Option<Settling> {
        let law = &law_there(wall).ok()?;
        let sample_time_s = wall.device.sample_time.0;
        let mut state = self.state();
        if state.failure.is_some() {
            return None;
        }
        let mut tries = 1;
        let failure = loop {
            let mut judge = judge.clone();
            let mut see = |tick, position_m, force_n| {
                judge.see(tick as f64 * sample_time_s, position_m, force_n)
            };
            match self.try_once(&mut state, law, samples, sample_time_s, &mut see) {
                Ok(Trial::Unjudged(_)) if tries < TRIES => tries += 1,
                Ok(Trial::Unjudged(failure)) | Err(failure) => {
                    break Some(state.bench.at_line(failure));
                }
                Ok(trial @ (Trial::Whole | Trial::Seen)) => {
                    state.trials += 1;
                    state.in_a_row = 0;
                    return Some(judge.settling(matches!(trial, Trial::Whole), None));
                }
                Ok(Trial::Tripped(fault)) => {
                    state.trials += 1;
                    state.trips += 1;
                    state.in_a_row += 1;
                    state.last = Some(fault);
                    break (state.in_a_row >= TRIPS_IN_A_ROW).then(|| {
                        Failure::run(format_args!(
                            "{}: {TRIPS_IN_A_ROW} trials in a row ended at a limit of the device ({fault}), so the search stopped: {}",
                            state.bench.path(),
                            self.remedy(fault)
                        ))
                    });
                }
            }
        };
        state.failure = failure;
        None
    }

    fn rise_time_s(&self, asked_s: f64) -> Option<f64> {
        let set_s = self.set.limits.rise_time_s;
        let is_longer = set_s > asked_s as f32;
        (self.retreat.as_ref()).map(|_| if is_longer { set_s.into() } else { asked_s })
    }

    fn has_failed(&self) -> bool {
        self.state().failure.is_some()
    }

    fn ended(&self, found: bool, stop: &AtomicBool) -> Result<Option<Failure>, Failure> {
        let mut state = self.state();
        match state.failure.take() {
            Some(failure) if !found => Err(failure),
            None if !found && !stop.load(Ordering::Relaxed) => {
                let why = match state.last {
                    Some(fault) => format!(
                        "{} of them ended at a limit of the device ({fault}): {}",
                        state.trips,
                        self.remedy(fault)
                    ),
                    None => {
                        format!("give the trials a longer {TRIAL_DURATION}, or hold the device")
                    }
                };
                Err(Failure::run(format_args!(
                    "{}: no wall came to rest in {} trials; {why}",
                    self.remote.name, state.trials
                )))
            }
            failure => Ok(failure),
        }
    }
}

/// A wall as the device gets it.
fn law_there(wall: &WallThere) -> Result<RemoteLaw, Failure> {
    let (config, plan) = (&wall.device, &wall.plan);
    let limits = SafetyLimits {
        rise_time: wall.rise_time,
        ..force_and_rate(plan.force_limit_n, None, config.sample_time)
    };
    Ok(RemoteLaw {
        stiffness_n_per_m: wall.stiffness_n_per_m,
        dissipation_n_s_mu_per_m: wall.dissipation_n_s_mu_per_m,
        order: wall.order.get(),
        one_sided: wall.contact == WallContact::OneSided,
        operator: portable(&wall.operator)?,
        held_push_n: plan.push_n,
        push: plan.push_of_motor(),
        tap: wall.tap,
        ..RemoteLaw::bare(limits, held(config, plan.push_of_hand_n()))
    })
}

fn scheduled(samples: u64, sample_time_s: f64) -> Schedule {
    Schedule {
        samples,
        sample_time_s,
        pace: Pace::Realtime(RealtimeOptions::default()),
    }
}

impl Bench for LinkedBench {
    fn path(&self) -> String {
        self.link.path().to_owned()
    }

    fn capabilities(&self) -> Capabilities {
        *self.link.capabilities()
    }

    fn rest(&mut self, time_s: f64) {
        std::thread::sleep(Duration::from_secs_f64(time_s));
    }

    fn at_line(&self, failure: Failure) -> Failure {
        at_link(&self.link, failure)
    }

    fn run(
        &mut self,
        configuration: Configuration,
        coefficients: &[f32],
        ticks: u64,
        see: See<'_>,
        warn: Warn<'_>,
    ) -> Result<Trial, Failure> {
        let path = self.link.path().to_owned();
        let problem = |error| refused_at_port(&path, error);
        let asked = Moment::now();
        loop {
            if self.link.is_stopped() {
                return Err(Failure::interrupted());
            }
            // After some faults nobody but a person arms again: arming would clear it.
            if self.runs > 0
                && let Some(latched) = Fault::from_code(self.link.status().fault)
                && ends_search(latched)
            {
                let words = format!("{latched}, between two trials");
                return Err(ended_by(&self.link, &words));
            }
            let begun = self.begin(configuration, coefficients, ticks as u32);
            let Err(error) = begun else {
                break;
            };
            if is_unanswered(&error) {
                return unanswered(&self.link, &path, error, warn);
            }
            // This host was late between arming and start.
            if let SerialError::Link(LinkError::Faulted(report)) = error {
                return faulted(&self.link, report);
            }
            let SerialError::Link(LinkError::Refused { refusal, .. }) = error else {
                return Err(problem(error));
            };
            // In the wall, where a person has to pull it out.
            let too_deep = matches!(refusal, Refusal::ForceNotSmall { .. });
            let patience = if too_deep { OUT_WITHIN } else { FALLEN_WITHIN };
            if !(too_deep || passes(refusal)) || asked.elapsed() > patience {
                return Err(problem(error));
            }
            if too_deep {
                if !core::mem::replace(&mut self.told_too_deep, true) {
                    let within = OUT_WITHIN.as_secs();
                    warn(&format!("{path}: {error}, within {within} s, each time"));
                }
                self.link.disarm().map_err(problem)?;
            }
            std::thread::sleep(PAUSE);
        }
        let trial = followed(&mut self.link, &path, ticks, SILENCE, see)?;
        match self.link.disarm() {
            Err(error) if is_unanswered(&error) => unanswered(&self.link, &path, error, warn),
            disarmed => disarmed.map_err(problem).map(|()| trial),
        }
    }
}

impl LinkedBench {
    /// Sets a law, arms and starts.
    fn begin(
        &mut self,
        configuration: Configuration,
        coefficients: &[f32],
        ticks: u32,
    ) -> Result<(), SerialError> {
        let link = &mut self.link;
        link.set_for(configuration, coefficients, Scope::Run)?;
        link.arm(self.watchdog)?;
        self.runs += 1;
        link.start(Start {
            run: self.runs,
            ticks,
            every: 1,
            batch: 8,
        })
    }
}

/// Follows a run that has begun to its end.
fn followed(
    link: &mut SerialLink,
    path: &str,
    samples: u64,
    patience: Duration,
    see: See<'_>,
) -> Result<Trial, Failure> {
    let (mut next, mut missed, mut newest) = (0, 0, None);
    let mut silence = link.patience(patience);
    loop {
        if link.is_stopped() {
            // Best effort: a device that does not hear it trips its own watchdog.
            let _ = link.disarm();
            return Err(Failure::interrupted());
        }
        match link.hear(silence.left().min(LOOK)) {
            Some(DeviceMessage::Sample(sample)) => {
                let tick = u64::from(sample.tick);
                if newest.replace(tick) < Some(tick) {
                    silence = link.patience(patience);
                }
                if let Some(axis) = sample.axes.first()
                    && (next..samples).contains(&tick)
                {
                    missed += tick - next;
                    next = tick + 1;
                    if !see(tick, f64::from(axis.position_m), f64::from(axis.force_n)) {
                        return Ok(Trial::Seen);
                    }
                }
            }
            Some(DeviceMessage::Event(event)) if event.kind == EventKind::Finished => {
                missed += samples - next;
                if missed == 0 {
                    return Ok(Trial::Whole);
                }
                return Ok(Trial::Unjudged(Failure::data_lost(format_args!(
                    "{path}: samples were missing in {TRIES} trials in a row ({} of {samples} arrived): use a better line",
                    samples - missed
                ))));
            }
            Some(DeviceMessage::Event(_)) | None => {}
            Some(DeviceMessage::Fault(report)) => return faulted(link, report),
            Some(DeviceMessage::Over(error)) => return Err(refused_at_port(path, error.into())),
        }
        if link.is_silent(&mut silence) {
            let error = link.silent(patience);
            if let LinkError::HeldUp { .. } = error {
                return Ok(held_up(path, &error.into()));
            }
            return Err(refused_at_port(path, error.into()));
        }
    }
}

/// Lets go of a device that did not answer. This machine, an emulator on it or a bad line may have been held up: if it answers now, nothing
/// is known of the law.
fn unanswered(
    link: &SerialLink,
    path: &str,
    error: SerialError,
    warn: Warn<'_>,
) -> Result<Trial, Failure> {
    if link.is_stopped() {
        return Err(Failure::interrupted());
    }
    warn(&format!("{path}: {error}; it is asked on for some seconds"));
    if link.answers_again() {
        return Ok(held_up(path, &error));
    }
    Err(refused_at_port(path, error))
}

fn held_up(path: &str, error: &SerialError) -> Trial {
    Trial::Unjudged(Failure::device(format_args!(
        "{path}: {error}; this happened in {TRIES} trials in a row, so none can be judged"
    )))
}

const fn is_unanswered(error: &SerialError) -> bool {
    matches!(error, SerialError::Link(LinkError::NoAnswer { .. }))
}

/// Refused for now: the force of the trial before still falls, or a fault latched that is not known here yet.
const fn passes(refusal: Refusal) -> bool {
    matches!(
        refusal,
        Refusal::ForceNotZero
            | Refusal::UnknownFault
            | Refusal::State(DeviceState::Fault | DeviceState::Stopping)
    )
}

/// Faults that show that the wall is not stable.
const fn is_answer(fault: Fault) -> bool {
    matches!(fault, Fault::Workspace | Fault::Velocity)
}

/// Faults that say nothing of a wall, and after which nobody but a person arms the device again: somebody pressed the emergency stop, or a
/// sensor, an actuator or the board failed. So does any that this program does not know; but not a host, line or tick that was late.
const fn ends_search(fault: Fault) -> bool {
    let late = matches!(
        fault,
        Fault::HostSilent | Fault::TickOverrun | Fault::StaleForce
    );
    !is_answer(fault) && !late
}

/// A trial that a fault has ended.
fn faulted(link: &SerialLink, report: FaultReport) -> Result<Trial, Failure> {
    match Fault::from_code(report.status.fault).filter(|_| link.lost_board().is_none()) {
        Some(fault) if is_answer(fault) => Ok(Trial::Tripped(fault)),
        Some(fault) if !ends_search(fault) => Ok(Trial::Unjudged(Failure::device(format_args!(
            "{}: {fault}, in {TRIES} trials in a row, so none can be judged: run nothing else on this machine, or allow a longer watchdog time",
            link.path()
        )))),
        _ => Err(ended_by(link, &LinkError::Faulted(report).to_string())),
    }
}

/// The end of a search by a fault in these words, and what its board says of it: the device is to be mended first.
fn ended_by(link: &SerialLink, words: &str) -> Failure {
    // A fault of a program that is a device has its words already.
    let board = trouble(link).filter(|trouble| !words.contains(trouble));
    let board = board.map_or_else(String::new, |trouble| format!(": {trouble}"));
    Failure::device(format_args!(
        "{}: {words}, so no more trials are made{board}",
        link.path()
    ))
}
