//! The loop of a simulated device that a hand holds, endless: it is paused, stopped and armed anew by whoever has a clock.

use super::{
    hand::HeldDevice,
    ticking::{Around, FadingFelt, FeltController, LoopCounts, LoopEnds, LoopOrder, Looping},
};
use haptic_loop::{Device, Engaged};
use std::{
    borrow::BorrowMut,
    convert::Infallible,
    sync::{Arc, atomic::Ordering},
};

/// A device in a hand, or a way to it.
pub trait Held: Device<f64, 1, Error = Infallible> + BorrowMut<HeldDevice> {}

impl<V: Device<f64, 1, Error = Infallible> + BorrowMut<HeldDevice>> Held for V {}

/// A controller of what is felt, or a way to it.
pub trait Felt: BorrowMut<FeltController> {}

impl<C: BorrowMut<FeltController>> Felt for C {}

/// A loop at work.
pub type Working<V, C> = Engaged<f64, 1, FadingFelt, V, C>;

/// Orders of such a loop, and their effect.
#[derive(Debug)]
pub struct Running {
    looping: Looping,
    paused: bool,
    ending: bool,
    stops: u64,
}

impl Running {
    /// Running of a loop with these ends.
    #[must_use]
    pub fn new(ends: LoopEnds, counts: Arc<LoopCounts>) -> Self {
        Self {
            looping: Looping::new(ends, counts),
            paused: false,
            ending: false,
            stops: 0,
        }
    }

    /// Reads all orders; false if nobody gives any, and the force is zero. A stop comes separately, beside the ring, so that it is never behind anything nor lost.
    pub fn obeys<V: Held, C: Felt>(&mut self, engaged: &mut Working<V, C>) -> bool {
        let stops = self.looping.counts.stops.load(Ordering::Relaxed);
        if stops != self.stops {
            self.stops = stops;
            self.stop(engaged);
        }
        let abandoned = self.looping.is_abandoned();
        while let Some(order) = self.looping.order() {
            match order {
                LoopOrder::Hand(position_m, held) => {
                    let held = held && !self.looping.stopping;
                    engaged.device_mut().borrow_mut().hand(position_m, held);
                }
                LoopOrder::Arm(ready, stops) => {
                    let overtaken = self.ending || stops != self.stops;
                    if (self.looping).arm(engaged.controller_mut(), ready, overtaken) {
                        engaged.device_mut().borrow_mut().put_back();
                    }
                }
                // A pause that was requested before a stop arrives behind it here.
                LoopOrder::Pause(paused) => self.paused = paused && !self.looping.stopping,
                LoopOrder::Path(_)
                | LoopOrder::Change(_)
                | LoopOrder::Begin(..)
                | LoopOrder::Event(_) => {}
            }
        }
        if abandoned && !self.ending {
            self.stop(engaged);
            self.ending = true;
        }
        let counts = &self.looping.counts;
        counts.paused.store(self.paused, Ordering::Relaxed);
        !(self.ending && engaged.controller().safety().is_at_rest())
    }

    /// A world that stands still would never let the force fall.
    fn stop<V: Held, C: Felt>(&mut self, engaged: &mut Working<V, C>) {
        engaged.controller_mut().stop();
        engaged.device_mut().borrow_mut().hand_lets_go();
        self.paused = false;
        self.looping.stopping = true;
    }

    /// Makes a tick unless the world stands still. `clock` gives a time in ns; the tick began so much late, ns, after so many periods without one.
    pub fn tick<V: Held, C: Felt>(
        &mut self,
        engaged: &mut Working<V, C>,
        clock: impl Fn() -> u64,
        (late_ns, skipped): (u64, u64),
    ) {
        if self.paused {
            return;
        }
        let hand_m = engaged.device_mut().borrow_mut().hand_m();
        let before = clock();
        let Ok(sample) = engaged.tick();
        let took_ns = clock() - before;
        self.looping.heard(engaged.controller_mut(), &sample);
        if sample.fault.is_some() && !self.looping.stopping {
            self.stop(engaged);
        }
        let around = Around {
            hand_m,
            hand_force_n: engaged.device_mut().borrow_mut().hand_force_n(),
            took_ns,
            late_ns,
            skipped,
        };
        self.looping.report(engaged.controller(), &sample, around);
    }
}
