//! The loop by the clock: the thread that ticks. It reads orders from a ring and puts samples into another; nothing in it
//! waits for anybody, allocates or frees.

use super::fading::Law;
use super::hand::HeldDevice;
use super::law::{FadingFelt, Felt};
use haptic_loop::realtime::{Moment, Periodic, PeriodicConfig, SpinMargin, ThreadConfig};
use haptic_loop::units::Seconds;
use haptic_loop::{Controller, Engaged, Sample};
use rtrb::{Consumer, Producer};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

/// Positions that the loop itself remembers, ticks: the time that a law may take to be made ready.
pub(super) const RECENT: usize = 1 << 14;
/// Positions that a new law hears in a tick until it has heard all.
const CATCH_UP: u64 = 64;

/// Orders to the loop. It ends, the force zero, when no one is left to give any.
#[derive(Debug)]
pub(super) enum LoopOrder {
    /// The pointer, m, and if the hand holds the device.
    Hand(f64, bool),
    /// Another law, as soon as it has heard the rest.
    Change(Box<Law<Felt>>),
    /// After a stop or fault: begin anew with this law, which has heard nothing, unless more stops than these were asked for since.
    Arm(Box<Law<Felt>>, u64),
    Pause(bool),
}

#[derive(Debug)]
pub(super) enum FromLoop {
    Tick(Ticked),
    /// A law that is not needed any more.
    Spent(Box<Law<Felt>>),
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Ticked {
    pub(super) sample: Sample<f64, 1>,
    pub(super) hand_m: f64,
    pub(super) hand_force_n: f64,
    pub(super) stopping: bool,
    /// Time that the tick took, and how late it began, ns.
    pub(super) took_ns: u64,
    pub(super) late_ns: u64,
    /// Periods before it without a tick.
    pub(super) skipped: u64,
    /// The first tick of a tissue that has forgotten.
    pub(super) fresh: bool,
}

/// Counts that others may read at any time, and the wish to stop.
#[derive(Debug, Default)]
pub(super) struct LoopCounts {
    pub(super) made: AtomicU64,
    /// Ticks that found the ring full.
    pub(super) lost: AtomicU64,
    /// The first tick that the tissue remembers.
    pub(super) remembers_from: AtomicU64,
    /// The simulated world stands still.
    pub(super) paused: AtomicBool,
    /// Stops that were asked for: the force falls to zero, the hand lets go.
    pub(super) stops: AtomicU64,
    pub(super) acts: AtomicBool,
    /// A stop or fault has ended the work of the loop, until it is armed.
    pub(super) stopped: AtomicBool,
}

pub(super) struct LoopEnds {
    pub(super) orders: Consumer<LoopOrder>,
    pub(super) out: Producer<FromLoop>,
}

struct Looping<'a> {
    ends: LoopEnds,
    counts: &'a LoopCounts,
    recent: Box<[f64]>,
    pending: Option<Box<Law<Felt>>>,
    /// Laws that found the ring full on their way out.
    spent: Option<Box<Law<Felt>>>,
    next: u64,
    paused: bool,
    ending: bool,
    fresh: bool,
    stopping: bool,
    stops: u64,
}

type Working<'a> =
    Engaged<f64, 1, FadingFelt, &'a mut HeldDevice, &'a mut Controller<f64, 1, FadingFelt>>;

/// Runs the loop until an order ends it or nobody gives orders any more. When it returns, the force is zero.
pub(super) fn run(
    controller: &mut Controller<f64, 1, FadingFelt>,
    device: &mut HeldDevice,
    ends: LoopEnds,
    counts: &LoopCounts,
    thread: ThreadConfig,
    sample_time: Seconds,
) {
    let config = PeriodicConfig {
        thread,
        // A simulated device does not mind some 50 µs, and who watches wants the processor.
        spin_margin: SpinMargin::Fixed(Duration::ZERO),
        ..PeriodicConfig::new(Duration::from_secs_f64(sample_time.0))
    };
    // The period was checked with the device.
    let Ok(mut periodic) = Periodic::new(config) else {
        return;
    };
    let mut looping = Looping {
        ends,
        counts,
        recent: vec![0.0; RECENT].into_boxed_slice(),
        pending: None,
        spent: None,
        next: 0,
        paused: false,
        ending: false,
        fresh: true,
        stopping: false,
        stops: 0,
    };
    let mut engaged = controller.engage(device);
    loop {
        let cycle = periodic.wait();
        looping.obey(&mut engaged);
        if looping.ending && engaged.controller().safety().is_at_rest() {
            break;
        }
        counts.paused.store(looping.paused, Ordering::Relaxed);
        if !looping.paused {
            let late_ns = cycle.lateness.as_nanos() as u64;
            looping.tick(&mut engaged, late_ns, cycle.skipped);
        }
    }
}

impl Looping<'_> {
    /// Reads all orders. A stop comes separately, beside the ring, so that it is never behind anything nor lost.
    fn obey(&mut self, engaged: &mut Working<'_>) {
        let stops = self.counts.stops.load(Ordering::Relaxed);
        if stops != self.stops {
            self.stops = stops;
            self.stop(engaged);
        }
        // Asked before the ring is: what was pushed until then is popped.
        let abandoned = self.ends.orders.is_abandoned();
        self.hand_back();
        while self.spent.is_none()
            && let Ok(order) = self.ends.orders.pop()
        {
            match order {
                LoopOrder::Hand(position_m, held) => {
                    let held = held && !self.stopping;
                    engaged.device_mut().hand(position_m, held);
                }
                LoopOrder::Change(ready) => {
                    // One that waits is overtaken.
                    self.spent = self.pending.replace(ready);
                    self.hand_back();
                }
                LoopOrder::Arm(ready, stops) => self.arm(engaged, ready, stops),
                // A pause that was requested before a stop arrives behind it here.
                LoopOrder::Pause(paused) => self.paused = paused && !self.stopping,
            }
        }
        if abandoned && !self.ending {
            self.stop(engaged);
            self.ending = true;
        }
    }

    /// A world that stands still would never let the force fall.
    fn stop(&mut self, engaged: &mut Working<'_>) {
        engaged.controller_mut().stop();
        engaged.device_mut().hand_lets_go();
        self.paused = false;
        self.stopping = true;
    }

    fn arm(&mut self, engaged: &mut Working<'_>, mut ready: Box<Law<Felt>>, stops: u64) {
        let overtaken = self.ending || stops != self.stops;
        if overtaken || !engaged.controller().safety().is_at_rest() {
            self.spent = Some(ready);
        } else {
            let controller = engaged.controller_mut();
            let (environment, history) = controller.law_mut();
            environment.replace(history, &mut ready);
            controller.clear();
            engaged.device_mut().put_back();
            let counts = self.counts;
            counts.remembers_from.store(self.next, Ordering::Relaxed);
            self.stopping = false;
            self.fresh = true;
            // A change that was made for what went before would remember it.
            self.spent = Some(ready);
            self.hand_back();
            if let Some(pending) = self.pending.take() {
                self.spent = Some(pending);
            }
        }
        self.hand_back();
    }

    /// Gives a law that is spent to somebody who frees it; it waits here while the ring is full.
    fn hand_back(&mut self) {
        if let Some(spent) = self.spent.take()
            && let Err(rtrb::PushError::Full(FromLoop::Spent(spent))) =
                self.ends.out.push(FromLoop::Spent(spent))
        {
            self.spent = Some(spent);
        }
    }

    fn tick(&mut self, engaged: &mut Working<'_>, late_ns: u64, skipped: u64) {
        let hand_m = engaged.device().hand_m();
        let before = Moment::now();
        let Ok(sample) = engaged.tick();
        let took_ns = before.elapsed().as_nanos() as u64;
        let (tick, position_m) = (sample.reading.tick, sample.reading.position_m[0]);
        self.recent[(tick % RECENT as u64) as usize] = position_m;
        self.next = tick + 1;
        let force_n = sample.force.newtons()[0];
        engaged.controller_mut().law_mut().1.sent(force_n);
        self.catch_up(engaged);
        if sample.fault.is_some() && !self.stopping {
            self.stop(engaged);
        }
        let ticked = Ticked {
            sample,
            hand_m,
            hand_force_n: engaged.device().hand_force_n(),
            stopping: self.stopping,
            took_ns,
            late_ns,
            skipped,
            fresh: self.fresh,
        };
        if self.ends.out.push(FromLoop::Tick(ticked)).is_err() {
            self.counts.lost.fetch_add(1, Ordering::Relaxed);
        } else {
            self.fresh = false;
        }
        let at_rest = engaged.controller().safety().is_at_rest();
        self.counts.acts.store(!at_rest, Ordering::Relaxed);
        self.counts.stopped.store(self.stopping, Ordering::Relaxed);
        self.counts.made.store(self.next, Ordering::Relaxed);
    }

    /// A law that waits hears some of the positions that it has missed; when it has heard all, and no other change is in progress, it
    /// begins to be felt.
    fn catch_up(&mut self, engaged: &mut Working<'_>) {
        let Some(ready) = &mut self.pending else {
            return;
        };
        // One that comes too late only hears the rest: the positions before it are no longer kept.
        ready.next = ready.next.max(self.next.saturating_sub(RECENT as u64));
        let until = self.next.min(ready.next + CATCH_UP);
        while ready.next < until {
            ready.hear(self.recent[(ready.next % RECENT as u64) as usize]);
        }
        let (environment, history) = engaged.controller_mut().law_mut();
        if ready.next == self.next && history.is_settled() && self.spent.is_none() {
            environment.change(history, ready);
            self.spent = self.pending.take();
            self.hand_back();
        }
    }
}
