//! A session with a person: walls that are judged before they are felt, each on the device as long as somebody wants, one log.
//!
//! ```text
//! open ─▶ allow ─▶ feel ─▶ rest ─▶ mark ─▶ feel ─▶ … ─▶ close        armed once, without a force between two walls
//! ```
//! - *The device* is opened, configured and logged as for a run of a `[wall]` with the loop here. When [`Session::open`] returns, the device
//!   has raised its force, so the first wall is felt whole from the first tick on.
//! - *A wall begins* with an empty memory where no force acts, in front of its surface; from there to [`Session::rest`] each other wall that
//!   takes its place has heard the same positions.
//! - *An end* that nobody asked for, by a fault or a lost device, ends the session: the log is kept, and every call says so.

mod laws;
mod opening;

pub use opening::{SessionOptions, SessionReport};

use super::{
    keeper::Keeper,
    orders::{Orders, locked},
    ticking::{LoopOrder, Looping, Stimulus},
    waiting::{Gate, Kept, LOOK, Shared, Watching},
};
use fracdiff::{Operator, Seconds, parameter::Shown};
use haptic_analysis::Dynamics;
use haptic_document::{
    Document, Failure, bad_input,
    parameters::{DAMPING, DEVICE_MODEL, LOOP, MASS},
};
use haptic_judge::{
    felt::{Certificate, Certifying, FeltSummary, Tally},
    law_region::LawRegion,
    trial::no_wall,
    wall::WallTrial,
};
use haptic_link::LoopMode;
use haptic_loop::{Controller, Pushing, Wall};
use haptic_message::EventMessage;
use haptic_quantity::written;
use haptic_run::{realtime::RealtimeOptions, schedule::Pace};
use haptic_trial::{
    in_hand::{
        fading::Law,
        hand::HAND_M,
        law::{fading, ticks},
        place::Placed,
    },
    safety::keys::WORKSPACE_HIGH as WORKSPACE_ENDS,
};
use opening::{
    Claim, Connected, Ended, Work, metadata, no_law, prepared, provenance, request, wall,
};
use serde::Serialize;
use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
        mpsc::{Receiver, RecvTimeoutError, channel},
    },
    time::Duration,
};

/// Ticks of virtual time at once, fewer than the ring to the keeper holds.
const CHUNK: u64 = 2048;
/// Ticks after which a wall that may begin has begun in virtual time.
const AT_ONCE: u64 = 2;
/// Ticks of virtual time from one look for a handle to the next.
const REST_CHUNK: u64 = 20;
/// Distance of a handle from the surface of a wall that is to begin, m: one that was just switched on stands at 0, whatever holds it.
const CLEAR_M: f64 = 1e-5;
/// The mark that answers what was felt.
const ANSWER: &str = "answer";
/// Event at the end of a wall.
const CERTIFICATE: &str = "certificate";
const NOT_ALLOWED: &str =
    "this wall was not allowed, nor is it between two that were: allow it first";

/// A law that may be felt.
#[derive(Clone, Debug)]
struct Allowed {
    law: Pushing<Wall<f64, Operator<f64>>>,
    trial: WallTrial,
    words: String,
}

#[derive(Debug, Default)]
struct Course {
    allowed: Vec<Allowed>,
    regions: Vec<LawRegion>,
    /// Pairs of laws whose mixes are proved.
    mixes: BTreeSet<[usize; 2]>,
    /// The law of each stimulus, whose numbers begin at 1.
    stimuli: Vec<usize>,
    /// The surface of the wall that is felt, m.
    surface_m: f64,
    /// A wall was felt since the last answer.
    may_answer: bool,
    /// The newest stimulus whose certificate is in the log.
    certified: u64,
    /// Walls whose force the energy of a touch reduced.
    reduced: u64,
}

/// A wall as it was felt, and as it was asked for.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct FeltWall {
    /// The handle was behind the surface; if it was not, this was no trial.
    pub touched: bool,
    /// Numbers of what was done and felt.
    #[serde(flatten)]
    pub felt: FeltSummary,
    /// Share of that which was the wall that was asked for.
    #[serde(flatten)]
    pub certificate: Certificate,
}

/// An open session. Dropped, it is closed.
#[derive(Debug)]
pub struct Session {
    base: Document,
    log: PathBuf,
    t: Seconds,
    dynamics: Dynamics,
    line: usize,
    /// The device is not simulated here.
    at_port: bool,
    nothing: Pushing<Wall<f64, Operator<f64>>>,
    course: Mutex<Course>,
    orders: Orders,
    shared: Arc<Shared>,
    gate: Option<Arc<Gate>>,
    stop: Arc<AtomicBool>,
    ended: Arc<Mutex<Option<Ended>>>,
}

/// Asked while somebody waits: true if the session is to stop.
type Stops<'a> = &'a dyn Fn() -> bool;

impl Session {
    /// Opens the device and arms it; returns when its force may be whole. `guard` is kept until the device has let go; setting `stop` ends
    /// the session, the force zero, the log closed.
    ///
    /// # Errors
    /// Parameters that are wrong, a log that exists, a device that is unknown, in use or not usable: before there is any force.
    pub fn open(
        options: SessionOptions,
        stop: &Arc<AtomicBool>,
        guard: impl Send + 'static,
        stops: Stops<'_>,
    ) -> Result<Self, Failure> {
        let base = prepared(&options)?;
        let without_force = base.with(&no_law()?)?;
        let mut wall = wall(&without_force)?;
        let remote = wall.conduct.remote.clone();
        if let Some(remote) = remote
            .as_ref()
            .filter(|remote| remote.loop_mode == LoopMode::Device)
        {
            return Err(bad_input!(
                "the loop of a session is on this computer: omit {LOOP} for {}",
                remote.name
            ));
        }
        let claim = remote.as_ref().map(|remote| Claim::of(&remote.name));
        let claim = claim.transpose()?;
        wall.conduct.pace = match (options.realtime, &remote) {
            (Some(thread), _) => Pace::Realtime(thread),
            (None, Some(_)) => Pace::Realtime(RealtimeOptions::default()),
            (None, None) => Pace::Virtual,
        };
        let t = wall.trial.setup.device.sample_time;
        let nothing = Pushing::new(no_wall(t)?, false);
        let law = Placed::new(nothing.clone(), 0.0);
        let controller = Controller::new(fading(&law, t), wall.trial.setup.chain()?);
        let (orders, ends, from_loop) = Orders::new();
        let shared = Arc::new(Shared::default());
        let virtual_time = wall.conduct.pace == Pace::Virtual;
        let gate = virtual_time.then(|| Arc::new(Gate::default()));
        let (connected, connects) = channel();
        let given: Vec<&str> = options.document.given().collect();
        let work = Work {
            controller,
            looping: Looping::new(ends, Arc::clone(&orders.counts)),
            request: request(
                &options.log,
                provenance(&without_force, options.provenance)?,
            )?,
            metadata: metadata(&wall),
            gate: gate.clone(),
            stop: Arc::clone(stop),
            connected,
            is_known: given.contains(&DEVICE_MODEL.key)
                || [MASS, DAMPING]
                    .iter()
                    .all(|known| given.contains(&known.key)),
            wall: wall.clone(),
        };
        let (ended, log) = (Arc::new(Mutex::new(None)), options.log.clone());
        let (result, watched) = (Arc::clone(&ended), Arc::clone(&shared));
        orders.spawn(move || {
            let (ran, warnings) = work.run();
            *locked(&result) = Some(Ended::of(ran, warnings, &log));
            drop(claim);
            drop(guard);
            watched.moved.notify_all();
        });
        let watching = Watching {
            shared: Arc::clone(&shared),
            batch: Vec::new(),
        };
        // In virtual time somebody waits for each look.
        let pause = Duration::from_micros(if virtual_time { 50 } else { 1000 });
        let (_, no_tasks) = channel();
        orders.spawn(move || Keeper::new(from_loop, no_tasks, pause, watching).run());
        let mut session = Self {
            base,
            log: options.log,
            t,
            dynamics: wall.trial.setup.dynamics(),
            line: 0,
            at_port: remote.is_some(),
            nothing,
            course: Mutex::default(),
            orders,
            shared,
            gate,
            stop: Arc::clone(stop),
            ended,
        };
        let Connected { line, rise_ticks } = session.connected(&connects, stops)?;
        session.line = line;
        // With its first tick there is a log too.
        let risen = rise_ticks.max(1);
        session.wait(1, stops, |kept| (kept.made >= risen).then_some(()))?;
        Ok(session)
    }

    fn connected(
        &self,
        connects: &Receiver<Connected>,
        stops: Stops<'_>,
    ) -> Result<Connected, Failure> {
        loop {
            match connects.recv_timeout(LOOK) {
                Ok(connected) => return Ok(connected),
                Err(RecvTimeoutError::Timeout) if stops() => return Err(self.interrupted()),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Err(self.over()),
            }
        }
    }

    /// Why nothing goes on, once the loop has ended.
    fn over(&self) -> Failure {
        self.orders.join();
        match locked(&self.ended).as_mut() {
            Some(Ended { failure, words, .. }) => {
                failure.take().unwrap_or_else(|| Failure::run(&words))
            }
            None => Failure::run("the loop of the session panicked: please report it"),
        }
    }

    /// Refuses what comes after the end.
    fn goes_on(&self) -> Result<(), Failure> {
        let is_over = locked(&self.shared.kept).is_over;
        if is_over { Err(self.over()) } else { Ok(()) }
    }

    /// Stops the session, and waits until it has ended.
    fn interrupted(&self) -> Failure {
        self.stop.store(true, Ordering::Relaxed);
        self.over()
    }

    /// Waits until `done` finds what it looks for; virtual time goes on by so many ticks from one look to the next.
    fn wait<T>(
        &self,
        ticks: u64,
        stops: Stops<'_>,
        mut done: impl FnMut(&Kept) -> Option<T>,
    ) -> Result<T, Failure> {
        let mut kept = locked(&self.shared.kept);
        let mut until = kept.made;
        loop {
            if let Some(found) = done(&kept).filter(|_| self.gate.is_none() || kept.made >= until) {
                return Ok(found);
            }
            let is_over = kept.is_over;
            if is_over || stops() {
                drop(kept);
                return Err(if is_over {
                    self.over()
                } else {
                    self.interrupted()
                });
            }
            if let Some(gate) = self.gate.as_ref().filter(|_| kept.made >= until) {
                until += ticks;
                gate.open(until);
            }
            let waited = self.shared.moved.wait_timeout(kept, LOOK);
            kept = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// T of the loop, s.
    #[must_use]
    pub const fn sample_time_s(&self) -> f64 {
        self.t.0
    }

    fn ticks_of(&self, time_s: f64) -> u64 {
        ticks(time_s, self.t) as u64
    }

    /// Makes a wall be felt behind a surface, m, and begins to sum what is felt, over so many ticks at most. Where a wall is felt already,
    /// this one takes its place without a bump, held or not, once no other fades any more. The first waits until the handle is in front of
    /// it; false if that takes longer than the patience, s, and the wall does not come any more.
    ///
    /// # Errors
    /// A wall that was not allowed; one between which and the one that is felt not all is proved stable; a session that has ended.
    pub fn feel(
        &self,
        wall: usize,
        surface_m: f64,
        ticks: Option<u64>,
        patience_s: f64,
        stops: Stops<'_>,
    ) -> Result<bool, Failure> {
        self.goes_on()?;
        if !WORKSPACE_ENDS.range().contains(surface_m) {
            return Err(bad_input!(
                "surface = {} is not {} m: change it",
                Shown(surface_m),
                WORKSPACE_ENDS.range()
            ));
        }
        let mut course = locked(&self.course);
        let allowed = course.allowed.get(wall).cloned();
        let allowed = allowed.ok_or_else(|| Failure::bad_input(NOT_ALLOWED))?;
        let felt = locked(&self.shared.kept).stimulus;
        self.prove_change(&mut course, felt, wall)?;
        self.settled(stops)?;
        self.certify(&mut course)?;
        let number = course.stimuli.len() as u64 + 1;
        let event = event(
            "feel",
            format!("wall {wall}: {}, surface {surface_m} m", allowed.words),
        );
        let environment = Placed::new(allowed.law, surface_m);
        let (made, order) = {
            let mut kept = locked(&self.shared.kept);
            kept.tally = Tally::of(number, surface_m, ticks, self.t);
            kept.certifying = Certifying::default();
            let stimulus = |law, untouched| {
                Box::new(Stimulus {
                    law,
                    untouched,
                    number,
                    event: Some(event),
                })
            };
            let order = if kept.stimulus == 0 {
                let stimulus = stimulus(Law::untouched(environment), None);
                LoopOrder::Begin(stimulus, surface_m - CLEAR_M)
            } else {
                let untouched = Law::untouched(environment.clone());
                let mut law = Law::standing(environment, kept.start_m);
                law.hear_from(kept.past_from, kept.past_m.iter().copied());
                LoopOrder::Change(stimulus(law, Some(untouched)))
            };
            (kept.made, order)
        };
        let waits = matches!(order, LoopOrder::Begin(..));
        let patience = if waits {
            self.ticks_of(patience_s)
        } else {
            u64::MAX
        };
        self.orders.give(order)?;
        course.stimuli.push(wall);
        if !self.came(number, made, patience, stops)? {
            course.certified = number;
            (self.orders).give(LoopOrder::Change(self.nothing(made, None)))?;
            return Ok(false);
        }
        (course.surface_m, course.may_answer) = (surface_m, true);
        Ok(true)
    }

    /// Waits until one law alone acts: each change is one of two laws, and its certificate has all of its fade.
    fn settled(&self, stops: Stops<'_>) -> Result<(), Failure> {
        self.wait(1, stops, |kept| kept.settled.then_some(()))
    }

    /// Waits for the first tick of a stimulus, so many ticks after this one at most; false if it did not come.
    fn came(
        &self,
        number: u64,
        made: u64,
        patience: u64,
        stops: Stops<'_>,
    ) -> Result<bool, Failure> {
        let came = |kept: &Kept, most: u64| {
            let came = (kept.stimulus == number).then_some(true);
            came.or_else(|| (kept.made - made > most).then_some(false))
        };
        // Virtual time stands still at the first tick, unless the handle has to move first.
        let at_once = self.wait(1, stops, |kept| came(kept, patience.min(AT_ONCE)))?;
        Ok(at_once || self.wait(REST_CHUNK, stops, |kept| came(kept, patience))?)
    }

    /// Goes on until this many ticks of the wall were felt.
    ///
    /// # Errors
    /// A session that has ended, or ends meanwhile.
    pub fn go_on(
        &self,
        ticks: u64,
        stops: Stops<'_>,
        progress: &dyn Fn(u64),
    ) -> Result<(), Failure> {
        loop {
            let felt = locked(&self.shared.kept).tally.ticks;
            if felt >= ticks {
                return Ok(());
            }
            // Virtual time stands still at the last of them.
            let until = ticks.min(felt + CHUNK);
            self.wait(until - felt, stops, |kept| {
                progress(kept.tally.ticks);
                (kept.tally.ticks >= until).then_some(())
            })?;
        }
    }

    /// Numbers of what was felt of the newest wall so far.
    #[must_use]
    pub fn felt(&self) -> FeltWall {
        let kept = locked(&self.shared.kept);
        let felt = kept.tally.summary();
        FeltWall {
            touched: felt.contacts > 0,
            felt,
            certificate: kept.certifying.certificate(),
        }
    }

    /// Puts the certificate of the wall that ends into the log.
    fn certify(&self, course: &mut Course) -> Result<(), Failure> {
        let newest = course.stimuli.len() as u64;
        if course.certified == newest {
            return Ok(());
        }
        course.certified = newest;
        let Certificate {
            exact_share,
            fade_ticks,
            energy_ticks,
            limit_ticks,
            least_factor,
            largest_step_n,
        } = self.felt().certificate;
        course.reduced += u64::from(energy_ticks > 0);
        let exact = exact_share.map_or_else(
            || "no force".to_owned(),
            |share| format!("exact {:.2} %", (1e4 * share).floor() / 100.0),
        );
        let text = format!(
            "{exact}; ticks reduced by fade {fade_ticks}, by energy {energy_ticks} (least factor {least_factor:.3}), by limits \
             {limit_ticks}; largest step {}",
            written("largest_step_n", largest_step_n)
        );
        self.orders.give(LoopOrder::Event(event(CERTIFICATE, text)))
    }

    /// Waits until the handle has left the wall, which then goes; false if that takes longer than the patience, s. The wall goes then as
    /// soon as the handle leaves, unless another is felt before.
    ///
    /// # Errors
    /// A session that has ended, or ends meanwhile.
    pub fn rest(&self, patience_s: f64, stops: Stops<'_>) -> Result<bool, Failure> {
        let surface_m = locked(&self.course).surface_m;
        self.without_wall(
            "rest",
            stops,
            |stimulus| LoopOrder::Begin(stimulus, surface_m),
            Some(patience_s),
        )
    }

    /// Takes the wall away, held or not: its force fades.
    ///
    /// # Errors
    /// A session that has ended, or ends meanwhile.
    pub fn pause(&self, stops: Stops<'_>) -> Result<(), Failure> {
        self.without_wall("pause", stops, LoopOrder::Change, None)
            .map(drop)
    }

    /// The law of no force, which remembers nothing, whatever it has heard until this tick.
    fn nothing(&self, made: u64, event: Option<EventMessage>) -> Box<Stimulus> {
        let mut law = Law::untouched(Placed::new(self.nothing.clone(), 0.0));
        law.next = made;
        Box::new(Stimulus {
            law,
            untouched: None,
            number: 0,
            event,
        })
    }

    fn without_wall(
        &self,
        kind: &str,
        stops: Stops<'_>,
        order: impl FnOnce(Box<Stimulus>) -> LoopOrder,
        patience_s: Option<f64>,
    ) -> Result<bool, Failure> {
        self.goes_on()?;
        let (made, felt) = {
            let kept = locked(&self.shared.kept);
            (kept.made, kept.stimulus)
        };
        if felt == 0 {
            return Ok(true);
        }
        self.certify(&mut locked(&self.course))?;
        let event = Some(event(kind, String::new()));
        self.orders.give(order(self.nothing(made, event)))?;
        let patience = patience_s.map_or(u64::MAX, |patience_s| self.ticks_of(patience_s));
        self.wait(REST_CHUNK, stops, |kept| match kept.stimulus {
            0 => Some(true),
            _ => (kept.made - made > patience).then_some(false),
        })
    }

    /// The simulated hand goes this way from now on: places, m, at times, s.
    ///
    /// # Errors
    /// A device that is not simulated here; times that do not grow, places beyond those of a hand.
    pub fn hand(&self, path: Vec<(f64, f64)>) -> Result<(), Failure> {
        self.goes_on()?;
        if self.at_port {
            return Err(Failure::bad_input(
                "the hand on a device is not this program's: only that on the simulated device is moved",
            ));
        }
        let (low, high) = HAND_M;
        let grows = path.windows(2).all(|pair| pair[0].0 < pair[1].0);
        let is_within = |&(time_s, place_m): &(f64, f64)| {
            time_s >= 0.0 && time_s.is_finite() && (low..=high).contains(&place_m)
        };
        if path.is_empty() || !grows || !path.iter().all(is_within) {
            return Err(bad_input!(
                "the path of the hand needs times that grow from 0 s on, and places in [{low}, {high}] m: change it"
            ));
        }
        self.orders.give(LoopOrder::Path(path.into()))
    }

    /// Puts a mark into the log, with its time: an answer or whatever happened.
    ///
    /// # Errors
    /// A kind without letters or of several lines; an answer though nothing was felt since the last.
    pub fn mark(&self, kind: &str, text: &str) -> Result<(), Failure> {
        if kind.trim().is_empty() || kind.chars().any(char::is_control) {
            return Err(Failure::bad_input(
                "the kind of a mark is empty or has several lines: name it in a word, as answer",
            ));
        }
        self.goes_on()?;
        let mut course = locked(&self.course);
        if kind == ANSWER && !std::mem::take(&mut course.may_answer) {
            return Err(Failure::bad_input(
                "an answer, but nothing was felt since the last one: feel a wall first",
            ));
        }
        self.orders
            .give(LoopOrder::Event(event(kind, text.to_owned())))
    }

    /// Path of the log, which is closed when the session ends.
    #[must_use]
    pub fn log(&self) -> &Path {
        &self.log
    }

    /// Ends the session: the force falls to zero, the device lets go, the log is closed. Its report.
    ///
    /// # Errors
    /// An end before, which nobody has heard of.
    pub fn close(&self) -> Result<SessionReport, Failure> {
        let reduced = {
            let mut course = locked(&self.course);
            // A loop that has ended reads no orders, and says so below.
            let _ = self.certify(&mut course);
            course.reduced
        };
        self.orders.leave();
        self.gate.iter().for_each(|gate| gate.open(u64::MAX));
        self.orders.join();
        let mut ended = locked(&self.ended);
        match ended
            .as_mut()
            .map(|ended| (ended.failure.take(), &ended.report))
        {
            Some((None, Some(report))) => {
                let mut report = report.clone();
                report.warnings.extend((reduced > 0).then(|| {
                    format!("{reduced} walls were changed in the hand to more than the energy of their touch could pay for: see the events `{CERTIFICATE}` in the log")
                }));
                Ok(report)
            }
            Some((Some(failure), _)) => Err(failure),
            _ => Err(Failure::run("the session has ended")),
        }
    }

    /// Has the session end now: its force falls to zero, its log is closed as one that was interrupted.
    pub fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        // Whoever drops it has heard of an early end, or does not ask.
        let _ = self.close();
    }
}

fn event(kind: &str, text: String) -> EventMessage {
    EventMessage {
        time_s: 0.0,
        kind: kind.to_owned(),
        text,
    }
}
