//! The loop of what is felt, whatever device and clock it has. It reads orders from a ring and puts what it did into another; nothing in it
//! waits for anybody, allocates or frees.

use super::{
    fading::{Asked, Fading, Law},
    law::Felt,
};
use haptic_loop::{Controller, Environment as _, LoopSample};
use haptic_message::EventMessage;
use nalgebra::Vector1;
use rtrb::{Consumer, Producer, PushError, RingBuffer};
use std::{
    any::Any,
    mem,
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicU64, Ordering},
    },
};

/// Positions that the loop itself remembers, ticks: the time that a law may take to be made ready.
const RECENT: usize = 1 << 14;
/// Positions that a new law hears in a tick until it has heard all.
const CATCH_UP: u64 = 64;

/// The law that is felt, with the one before it.
pub type FadingFelt = Fading<Felt>;

/// A controller of what is felt.
pub type FeltController = Controller<f64, 1, FadingFelt>;

/// A law to be felt.
#[derive(Debug)]
pub struct Stimulus {
    /// The law, with what it has heard.
    pub law: Law<Felt>,
    /// The law that has heard nothing, of a change that somebody counts: it is felt if the wall before it has been left meanwhile.
    pub untouched: Option<Law<Felt>>,
    /// Its number among all that were to be felt; 0 where nobody counts, and of a law without a force.
    pub number: u64,
    /// Event in the log at its beginning.
    pub event: Option<EventMessage>,
}

impl From<Law<Felt>> for Stimulus {
    fn from(law: Law<Felt>) -> Self {
        Self {
            law,
            untouched: None,
            number: 0,
            event: None,
        }
    }
}

/// Places, m, at times since it began, s, between which a simulated hand moves evenly.
pub type HandPath = Box<[(f64, f64)]>;

/// Orders to the loop. It ends, the force zero, when no one is left to give any.
#[derive(Debug)]
pub enum LoopOrder {
    /// The pointer, m, and if the hand holds the device.
    Hand(f64, bool),
    /// The hand holds the device and goes this way.
    Path(HandPath),
    /// Another law, as soon as it has heard the rest.
    Change(Box<Stimulus>),
    /// A law that has heard nothing, as soon as no force acts and the device is not beyond this place, m.
    Begin(Box<Stimulus>, f64),
    /// After a stop or fault: begin anew with this law, which has heard nothing, unless more stops than these were asked for since.
    Arm(Box<Stimulus>, u64),
    /// The simulated world stands still, or goes on.
    Pause(bool),
    /// An event for the log, whose time is that of the tick.
    Event(EventMessage),
}

/// News of a loop for its keeper.
#[derive(Debug)]
pub enum FromLoop {
    /// A tick that was made, with what surrounds it.
    Tick(Ticked),
    /// Something that is not needed any more.
    Spent(Box<dyn Any + Send>),
}

/// A tick, with what surrounds it.
#[derive(Clone, Copy, Debug)]
pub struct Ticked {
    /// Its number in this loop: none is left out, whatever a line lost.
    pub number: u64,
    /// Readings and forces of the tick, as the loop had them.
    pub sample: LoopSample<f64, 1>,
    /// Hand and timing, which only the runner of the loop knows.
    pub around: Around,
    /// The loop comes to rest, or is there.
    pub stopping: bool,
    /// The first tick of a law that has forgotten.
    pub fresh: bool,
    /// The number of the law that made the force.
    pub stimulus: u64,
    /// Forces before they became the one of the sample; `None` where the law alone is felt, and is whole.
    pub asked: Option<Asked>,
    /// One law alone acts in the next tick: no other fades.
    pub settled: bool,
}

/// Facts of a tick that only the runner of a loop knows.
#[derive(Clone, Copy, Debug)]
pub struct Around {
    /// Position of the simulated hand, m; NaN without one.
    pub hand_m: f64,
    /// Its force on the device, N.
    pub hand_force_n: f64,
    /// Time that the tick took, and how late it began, ns.
    pub took_ns: u64,
    /// See `took_ns`.
    pub late_ns: u64,
    /// Periods before it without a tick.
    pub skipped: u64,
}

impl Around {
    /// Values of a device that somebody else holds.
    pub const UNKNOWN: Self = Self {
        hand_m: f64::NAN,
        hand_force_n: 0.0,
        took_ns: 0,
        late_ns: 0,
        skipped: 0,
    };
}

/// Counts that others may read at any time, and the wish to stop.
#[derive(Debug, Default)]
pub struct LoopCounts {
    /// Ticks that were made, those that were lost included.
    pub made: AtomicU64,
    /// Ticks that found the ring full.
    pub lost: AtomicU64,
    /// The first tick that the law remembers.
    pub remembers_from: AtomicU64,
    /// The simulated world stands still.
    pub paused: AtomicBool,
    /// Stops that were asked for: the force falls to zero, the hand lets go.
    pub stops: AtomicU64,
    /// There is a force, or may be.
    pub acts: AtomicBool,
    /// A stop or fault has ended the work of the loop, until it is armed.
    pub stopped: AtomicBool,
}

/// The ends of both rings that the loop has.
#[derive(Debug)]
pub struct LoopEnds {
    /// Orders from whoever gives them.
    pub orders: Consumer<LoopOrder>,
    /// Ticks for the keeper; one that finds the ring full is counted as lost.
    pub out: Producer<FromLoop>,
}

/// Orders that wait for the loop at most.
const ORDERS: usize = 1024;
/// Samples that wait for the keeper at most: 8 s.
const SAMPLES: usize = 8192;

/// Both rings of a loop: the end that gives orders, those of the loop, and that of its keeper.
#[must_use]
pub fn rings() -> (Producer<LoopOrder>, LoopEnds, Consumer<FromLoop>) {
    let (ring, orders) = RingBuffer::new(ORDERS);
    let (out, from_loop) = RingBuffer::new(SAMPLES);
    (ring, LoopEnds { orders, out }, from_loop)
}

/// A law that is to begin, and the rest of its [order](LoopOrder::Begin).
type Beginning = (Box<Stimulus>, f64);

/// The part of a loop that changes its law and reports its ticks.
#[derive(Debug)]
pub struct Looping {
    ends: LoopEnds,
    /// Counts that others read.
    pub counts: Arc<LoopCounts>,
    recent: Box<[f64]>,
    pending: Option<Box<Stimulus>>,
    beginning: Option<Beginning>,
    /// Something that found the ring full on its way out.
    spent: Option<Box<dyn Any + Send>>,
    next: u64,
    fresh: bool,
    /// The next tick is the first of a law that has forgotten.
    begins: bool,
    /// The number of the law that is felt, and of the one in this tick.
    stimulus: (u64, u64),
    asked: Option<Asked>,
    settled: bool,
    event: Option<EventMessage>,
    /// The loop comes to rest, or is there.
    pub stopping: bool,
}

impl Looping {
    /// The part of a loop with these ends.
    #[must_use]
    pub fn new(ends: LoopEnds, counts: Arc<LoopCounts>) -> Self {
        Self {
            ends,
            counts,
            recent: vec![0.0; RECENT].into_boxed_slice(),
            pending: None,
            beginning: None,
            spent: None,
            next: 0,
            fresh: true,
            begins: false,
            stimulus: (0, 0),
            asked: None,
            settled: true,
            event: None,
            stopping: false,
        }
    }

    /// True if nobody is left to give orders. Asked before the ring is: what was pushed until then is popped.
    pub fn is_abandoned(&self) -> bool {
        self.ends.orders.is_abandoned()
    }

    /// True if besides all orders have been obeyed.
    pub fn is_done(&self) -> bool {
        self.is_abandoned() && self.ends.orders.is_empty() && self.event.is_none()
    }

    /// The number of the tick that comes next.
    pub const fn next(&self) -> u64 {
        self.next
    }

    /// The next order that is not of the law alone, if there is one. None is read while something that is spent, or an event, still waits.
    pub fn order(&mut self) -> Option<LoopOrder> {
        loop {
            self.hand_back();
            if self.spent.is_some() || self.event.is_some() {
                return None;
            }
            match self.ends.orders.pop().ok()? {
                LoopOrder::Change(mut ready) => {
                    self.overtaken();
                    if self.stimulus.0 == 0
                        && let Some(untouched) = &mut ready.untouched
                    {
                        mem::swap(&mut ready.law, untouched);
                        self.beginning = Some((ready, f64::INFINITY));
                    } else {
                        self.pending = Some(ready);
                    }
                }
                LoopOrder::Begin(ready, most_m) => {
                    self.overtaken();
                    self.beginning = Some((ready, most_m));
                }
                LoopOrder::Event(event) => self.event = Some(event),
                order @ (LoopOrder::Hand(..)
                | LoopOrder::Path(_)
                | LoopOrder::Arm(..)
                | LoopOrder::Pause(_)) => return Some(order),
            }
        }
    }

    /// Laws that wait are not wanted any more.
    fn overtaken(&mut self) {
        let beginning = self.beginning.take().map(|(stimulus, _)| stimulus);
        for stimulus in [self.pending.take(), beginning].into_iter().flatten() {
            self.spend(stimulus);
        }
    }

    /// The event of this tick, s, if there is one.
    pub fn event(&mut self, time_s: f64) -> Option<EventMessage> {
        let event = self.event.take()?;
        Some(EventMessage { time_s, ..event })
    }

    /// Begins anew, if nothing has overtaken that; the law that was is spent.
    pub fn arm(
        &mut self,
        controller: &mut FeltController,
        mut ready: Box<Stimulus>,
        overtaken: bool,
    ) -> bool {
        let arms = !overtaken && controller.safety().is_at_rest();
        if arms {
            let (environment, history) = controller.law_mut();
            environment.replace(history, &mut ready.law);
            controller.clear();
            self.forget();
            self.fresh = true;
            self.stopping = false;
        }
        self.spend(ready);
        if arms && let Some(pending) = self.pending.take() {
            // A change that was made for what went before would remember it.
            self.spend(pending);
        }
        arms
    }

    /// The law that is felt has forgotten all before the next tick.
    fn forget(&self) {
        let from = &self.counts.remembers_from;
        from.store(self.next, Ordering::Relaxed);
    }

    /// Gives what is spent to somebody who frees it.
    pub fn spend(&mut self, spent: Box<dyn Any + Send>) {
        self.hand_back();
        self.spent = Some(spent);
        self.hand_back();
    }

    /// Something spent waits here while the ring is full.
    fn hand_back(&mut self) {
        if let Some(spent) = self.spent.take()
            && let Err(PushError::Full(FromLoop::Spent(spent))) =
                self.ends.out.push(FromLoop::Spent(spent))
        {
            self.spent = Some(spent);
        }
    }

    /// Remembers a tick, and changes the law for the next.
    pub fn heard(&mut self, controller: &mut FeltController, sample: &LoopSample<f64, 1>) {
        let position_m = sample.reading.position_m[0];
        self.recent[(self.next % RECENT as u64) as usize] = position_m;
        self.next += 1;
        self.stimulus.1 = self.stimulus.0;
        self.fresh |= mem::take(&mut self.begins);
        self.asked = controller.law_mut().1.asked();
        self.catch_up(controller);
        self.begin(controller, position_m);
        self.settled = controller.law_mut().1.is_settled();
    }

    /// Reports the tick that was heard last.
    pub fn report(
        &mut self,
        controller: &FeltController,
        sample: &LoopSample<f64, 1>,
        around: Around,
    ) {
        let ticked = Ticked {
            number: self.next - 1,
            sample: *sample,
            around,
            stopping: self.stopping,
            fresh: self.fresh,
            stimulus: self.stimulus.1,
            asked: self.asked,
            settled: self.settled,
        };
        if self.ends.out.push(FromLoop::Tick(ticked)).is_err() {
            self.counts.lost.fetch_add(1, Ordering::Relaxed);
        } else {
            self.fresh = false;
        }
        let at_rest = controller.safety().is_at_rest();
        self.counts.acts.store(!at_rest, Ordering::Relaxed);
        self.counts.stopped.store(self.stopping, Ordering::Relaxed);
        self.counts.made.store(self.next, Ordering::Relaxed);
    }

    /// A law that waits hears some of the positions that it has missed; when it has heard all, and no other change is in progress, it
    /// begins to be felt.
    fn catch_up(&mut self, controller: &mut FeltController) {
        let has_room = self.has_room();
        let Some(ready) = &mut self.pending else {
            return;
        };
        let law = &mut ready.law;
        // One that comes too late only hears the rest: the positions before it are no longer kept.
        law.next = law.next.max(self.next.saturating_sub(RECENT as u64));
        let until = self.next.min(law.next + CATCH_UP);
        while law.next < until {
            law.hear(self.recent[(law.next % RECENT as u64) as usize]);
        }
        let (environment, history) = controller.law_mut();
        if law.next == self.next && history.is_settled() && has_room {
            environment.change(history, law);
            self.becomes_felt();
        }
    }

    /// Law and event of a beginning find nothing in their way.
    const fn has_room(&self) -> bool {
        self.spent.is_none() && self.event.is_none()
    }

    /// A law that is to begin does so where the device is free of force, in front of its surface; it fades in around a device that is behind
    /// it already.
    fn begin(&mut self, controller: &mut FeltController, position_m: f64) {
        if self.pending.is_some() || !self.has_room() {
            return;
        }
        let Some((mut ready, most_m)) = self.beginning.take() else {
            return;
        };
        let x = Vector1::new(position_m);
        let (environment, history) = controller.law_mut();
        let is_free = position_m <= most_m && environment.wanted(history, &x) == 0.0;
        if is_free {
            let law = &mut ready.law;
            law.environment.settle(&mut law.history, &x);
            if law.environment.force(&law.history, &x)[0] == 0.0 {
                environment.replace(history, law);
            } else {
                environment.change(history, law);
            }
            self.forget();
            self.begins = true;
            self.pending = Some(ready);
            self.becomes_felt();
        } else {
            self.beginning = Some((ready, most_m));
        }
    }

    /// The law that waited is felt; what it was changed for is spent.
    fn becomes_felt(&mut self) {
        if let Some(mut felt) = self.pending.take() {
            self.stimulus.0 = felt.number;
            self.event = felt.event.take();
            self.spend(felt);
        }
    }
}
