//! A tissue or wall that is felt: the loop by the clock, and what surrounds it.
//! ```text
//! pointer ─orders─▶ loop (1 kHz) ─ring─▶ keeper ─▶ pyramid ─▶ views
//!                     │                    ├─ ghosts: the same motion by other operators
//!                     └─ safety chain      └─ log
//! settings ─▶ pre-flight ─▶ new law ─hears the past─▶ loop: from the old force to the new without a bump
//! ```
//! The thread that ticks never waits and never wakes another. Whatever is given up, dropped or lost ends with a zero force.

mod compare;
mod keeper;
mod opened;

pub(crate) use compare::Comparison;
pub(crate) use keeper::{FeelPlace, Kept};
pub(crate) use opened::{Opened, opened};

use haptic_answer::feel::state::POSITION;
use haptic_answer::feel::{DeviceNumbers, FeelSettings, FeelState, FeltThing, JudgedFeel};
use haptic_answer::request::CompareStart;
use haptic_experiment::Failure;
use haptic_experiment::live::{
    HAND_DAMPING, HAND_M, HAND_STIFFNESS, Keeper, LoopOrder, Orders, Stimulus, locked,
    run as run_by_clock,
};
use haptic_experiment::parameters::{
    DISSIPATION, ONE_SIDED, ORDER, SCHEME, STIFFNESS, WALL_CONTACT,
};
use haptic_tissue::Library;
use keeper::{KeeperTask, LOOK, Watching, Work};
use std::collections::BTreeMap;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex};

/// A loop at work. Dropped, it stops: the force is zero before the thread ends.
#[derive(Debug)]
pub(crate) struct Feel {
    place: FeelPlace,
    orders: Orders,
    tasks: Sender<KeeperTask>,
    felt: Mutex<JudgedFeel>,
}

impl Feel {
    /// Starts the loop, the tissue untouched. One that was there ends as soon as nothing can be refused any more.
    pub(crate) fn start(
        place: FeelPlace,
        felt: JudgedFeel,
        old: Option<&Self>,
    ) -> Result<Self, Failure> {
        let t = felt.settings.device.sample_time();
        let (mut controller, mut device, ghosts) = felt.settings.untouched()?;
        let work = Work::new(t);
        if let Some(old) = old {
            old.end();
        }

        let (orders, ends, from_loop) = Orders::new();
        let (tasks, tasks_end) = channel();
        locked(&place.kept.pyramid).clear();
        *locked(&place.kept.state) = FeelState::of(t);
        // The keeper holds the other end.
        let _ = tasks.send(KeeperTask::Ghosts(Box::new(ghosts)));
        let watching = Watching::new(place.clone(), work);
        let (thread, counted) = (place.realtime, Arc::clone(&orders.counts));
        orders.spawn(move || {
            run_by_clock(&mut controller, &mut device, ends, &counted, thread, t);
        });
        orders.spawn(move || Keeper::new(from_loop, tasks_end, LOOK, watching).run());
        Ok(Self {
            place,
            orders,
            tasks,
            felt: Mutex::new(felt),
        })
    }

    pub(crate) fn felt(&self) -> JudgedFeel {
        locked(&self.felt).clone()
    }

    pub(crate) fn is_paused(&self) -> bool {
        self.orders.counts.paused.load(Ordering::Relaxed)
    }

    pub(crate) fn counts(&self) -> (u64, u64) {
        let count = |count: &std::sync::atomic::AtomicU64| count.load(Ordering::Relaxed);
        (
            count(&self.orders.counts.made),
            count(&self.orders.counts.lost),
        )
    }

    /// The pointer; the place that the hand goes to, m: that of the pointer, or the end of the hand's range before it.
    pub(crate) fn hand(&self, position_m: f64, held: bool) -> Result<f64, Failure> {
        let goes_to_m = position_m.clamp(HAND_M.0, HAND_M.1);
        self.orders.give(LoopOrder::Hand(goes_to_m, held))?;
        Ok(goes_to_m)
    }

    pub(crate) fn pause(&self, paused: bool) -> Result<(), Failure> {
        self.orders.give(LoopOrder::Pause(paused))
    }

    /// The force falls to zero, the hand lets go. Nothing can keep it from the loop.
    pub(crate) fn stop(&self) {
        self.orders.stop();
    }

    pub(crate) fn arm(&self) -> Result<(), Failure> {
        let counts = &self.orders.counts;
        if let Some(comparison) = locked(&self.place.kept.comparison).as_mut() {
            comparison.again();
        }
        // A stop while the law is being made wins.
        let stops = counts.stops.load(Ordering::Relaxed);
        if counts.acts.load(Ordering::Relaxed) {
            let stopped = counts.stopped.load(Ordering::Relaxed);
            return Err(Failure::bad_input(if stopped {
                "the force still falls to zero: arm again in a moment"
            } else {
                "a force acts: `stop` first, then `arm`"
            }));
        }
        let law = self.felt().settings.law()?;
        self.orders
            .give(LoopOrder::Arm(Box::new(law.into()), stops))
    }

    /// Makes another law be felt, which hears the past first. What is not stable is refused, and what is felt stays.
    pub(crate) fn change(&self, next: FeelSettings) -> Result<(), Failure> {
        if self.compares() {
            return Err(Failure::bad_input(COMPARES));
        }
        let next = next.judged()?;
        self.felt().settings.proves_change(&next.settings)?;
        let mut past = Vec::new();
        let remembers_from = self.orders.counts.remembers_from.load(Ordering::Relaxed);
        let pyramid = &self.place.kept.pyramid;
        let first = locked(pyramid).samples_from(remembers_from, POSITION, &mut past);
        let (law, ghosts) = next.settings.laws_after(first, &past)?;
        self.orders.give(LoopOrder::Change(Box::new(law.into())))?;
        self.task(KeeperTask::Ghosts(Box::new(ghosts)))?;
        *locked(&self.felt) = next;
        Ok(())
    }

    fn compares(&self) -> bool {
        let comparison = locked(&self.place.kept.comparison);
        comparison.as_ref().is_some_and(Comparison::goes_on)
    }

    /// Begins to compare what is felt with that and a change.
    pub(crate) fn compare(&self, start: CompareStart, library: &Library) -> Result<(), Failure> {
        if self.compares() {
            return Err(Failure::bad_input(COMPARES));
        }
        let a = self.felt().settings;
        let b = a.changed(library, &start.b)?.judged()?.settings;
        let (metadata, place) = (metadata(&a), &self.place);
        let folders = (&*place.runs, &*place.provenance);
        let comparison = Comparison::start(start, [a, b], metadata, folders)?;
        *locked(&place.kept.comparison) = Some(comparison);
        Ok(())
    }

    /// Does something with the comparison that goes on.
    fn with_comparison<T>(
        &self,
        work: impl FnOnce(&mut Comparison) -> Result<T, Failure>,
    ) -> Result<T, Failure> {
        let mut comparison = locked(&self.place.kept.comparison);
        match comparison
            .as_mut()
            .filter(|comparison| comparison.goes_on())
        {
            Some(comparison) => work(comparison),
            None => Err(Failure::bad_input(
                "nothing is being compared: send `compare.start`",
            )),
        }
    }

    /// Makes the next wall of the trial be felt.
    pub(crate) fn compare_next(&self) -> Result<(), Failure> {
        if self.orders.counts.stopped.load(Ordering::Relaxed) {
            return Err(Failure::bad_input("the loop is stopped: `arm` it first"));
        }
        let t = self.felt().settings.device.sample_time();
        // The law is made without the lock that each tick's keeper needs.
        let (settings, number) = self.with_comparison(|comparison| comparison.next(t))?;
        self.begin(&settings, number)
    }

    /// Makes a wall be felt as soon as the handle is in front of it.
    fn begin(&self, settings: &FeelSettings, number: u64) -> Result<(), Failure> {
        let stimulus = Stimulus {
            number,
            ..settings.law()?.into()
        };
        (self.orders).give(LoopOrder::Begin(Box::new(stimulus), 0.0))
    }

    pub(crate) fn compare_rate(&self, rating: f64) -> Result<(), Failure> {
        self.with_comparison(|comparison| comparison.rate(rating))
    }

    pub(crate) fn compare_answer(&self, stiffer: u8) -> Result<(), Failure> {
        if self.with_comparison(|comparison| comparison.answer(stiffer))? {
            self.end_compare()
        } else {
            Ok(())
        }
    }

    /// Ends the comparison; what was felt before it is felt again.
    pub(crate) fn end_compare(&self) -> Result<(), Failure> {
        let ended = self.with_comparison(|comparison| Ok(comparison.end()))?;
        self.begin(&self.felt().settings, 0)?;
        ended.transpose().map(drop)
    }

    fn task(&self, task: KeeperTask) -> Result<(), Failure> {
        self.tasks.send(task).map_err(ended)
    }

    pub(crate) fn mark(&self, text: String) -> Result<(), Failure> {
        self.task(KeeperTask::Mark(text))
    }

    /// Begins a log; its name.
    pub(crate) fn record(&self) -> Result<String, Failure> {
        let (answer, answered) = channel();
        let metadata = metadata(&self.felt().settings);
        self.task(KeeperTask::Record(metadata, answer))?;
        answered.recv().map_err(ended)?
    }

    /// Closes the log; its name, its samples and those that are missing.
    pub(crate) fn end_record(&self) -> Result<(String, u64, u64), Failure> {
        let (answer, answered) = channel();
        self.task(KeeperTask::EndRecord(answer))?;
        let finished = answered.recv().map_err(ended)??;
        Ok((finished.name, finished.samples, finished.missing))
    }

    /// Stops, and waits until the force is zero and all is kept.
    pub(crate) fn end(&self) {
        self.orders.end();
    }
}

const COMPARES: &str = "two walls are being compared: send `compare.end` first";

fn ended<E>(_: E) -> Failure {
    Failure::bad_input("the loop has ended: start again")
}

/// Metadata for a log; of a wall also the experiment file, so that it can be run and felt again.
fn metadata(settings: &FeelSettings) -> BTreeMap<String, String> {
    let thing = match &settings.environment {
        FeltThing::Tissue(name) => name,
        FeltThing::Wall(_) | FeltThing::File(_) | FeltThing::Run(_) => "wall",
    };
    let limits = settings.limits();
    let device = settings.device.values.named();
    let device = device.map(|(parameter, number)| (parameter.key, number));
    let (stiffness, dissipation) = settings.gains();
    let contact = if settings.law.signed {
        "signed"
    } else {
        "depth"
    };
    let words = [
        ("experiment", "feel"),
        ("device", "sim"),
        ("environment", thing),
        ("scheme", &settings.law.scheme),
        ("one_sided", "true"),
        ("contact", contact),
        ("pace", "realtime"),
    ];
    let numbers = [
        ("order", settings.law.order),
        ("stiffness_n_per_m", stiffness),
        ("dissipation_n_s_mu_per_m", dissipation),
        ("scale", settings.scale),
        ("sample_time_s", settings.device.sample_time_s),
        ("hand_stiffness_n_per_m", HAND_STIFFNESS.0),
        ("hand_damping_n_s_per_m", HAND_DAMPING.0),
        ("force_limit_n", limits.force.0),
        ("force_rate_limit_n_per_s", limits.rate.0),
    ];
    let words = words.map(|(key, word)| (key.to_owned(), word.to_owned()));
    // The hand here is behind that of the device.
    let numbers = device.into_iter().chain(numbers);
    let numbers = numbers.map(|(key, number)| (key.to_owned(), number.to_string()));
    let mut metadata: BTreeMap<String, String> = words.into_iter().chain(numbers).collect();
    if thing == "wall" {
        metadata.insert("document".to_owned(), wall_file(&metadata));
    }
    metadata
}
/// The experiment file of a wall with these values.
fn wall_file(values: &BTreeMap<String, String>) -> String {
    let law = [ORDER, STIFFNESS, DISSIPATION].map(|known| known.key);
    let words = [SCHEME, WALL_CONTACT].map(|known| known.key);
    let line = |key: &str, quote| {
        let value = values.get(key).map_or("", String::as_str);
        format!("{key} = {quote}{value}{quote}\n")
    };
    let lines = (law
        .into_iter()
        .chain(DeviceNumbers::names())
        .map(|key| line(key, "")))
    .chain(words.map(|key| line(key, "\"")))
    .chain([line(ONE_SIDED.key, "")]);
    format!("[wall]\n{}", lines.collect::<String>())
}
