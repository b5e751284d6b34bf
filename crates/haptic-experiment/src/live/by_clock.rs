//! The loop of a simulated device by the clock, endless: it is paused, stopped and armed anew.

use super::ticking::{
    Around, FadingFelt, FeltController, LoopCounts, LoopEnds, LoopOrder, Looping,
};
use haptic_loop::Engaged;
use haptic_loop::realtime::{Moment, Periodic, PeriodicConfig, SpinMargin, ThreadConfig};
use haptic_loop::units::Seconds;
use haptic_trial::in_hand::hand::HeldDevice;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

struct Running {
    looping: Looping,
    paused: bool,
    ending: bool,
    stops: u64,
}

type Working<'a> = Engaged<f64, 1, FadingFelt, &'a mut HeldDevice, &'a mut FeltController>;

/// Runs the loop until an order ends it or nobody gives orders any more. When it returns, the force is zero.
pub fn run(
    controller: &mut FeltController,
    device: &mut HeldDevice,
    ends: LoopEnds,
    counts: &Arc<LoopCounts>,
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
    let mut running = Running {
        looping: Looping::new(ends, Arc::clone(counts)),
        paused: false,
        ending: false,
        stops: 0,
    };
    let mut engaged = controller.engage(device);
    loop {
        let cycle = periodic.wait();
        running.obey(&mut engaged);
        if running.ending && engaged.controller().safety().is_at_rest() {
            break;
        }
        counts.paused.store(running.paused, Ordering::Relaxed);
        if !running.paused {
            let late_ns = cycle.lateness.as_nanos() as u64;
            running.tick(&mut engaged, late_ns, cycle.skipped);
        }
    }
}

impl Running {
    /// Reads all orders. A stop comes separately, beside the ring, so that it is never behind anything nor lost.
    fn obey(&mut self, engaged: &mut Working<'_>) {
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
                    engaged.device_mut().hand(position_m, held);
                }
                LoopOrder::Arm(ready, stops) => {
                    let overtaken = self.ending || stops != self.stops;
                    if (self.looping).arm(engaged.controller_mut(), ready, overtaken) {
                        engaged.device_mut().put_back();
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
    }

    /// A world that stands still would never let the force fall.
    fn stop(&mut self, engaged: &mut Working<'_>) {
        engaged.controller_mut().stop();
        engaged.device_mut().hand_lets_go();
        self.paused = false;
        self.looping.stopping = true;
    }

    fn tick(&mut self, engaged: &mut Working<'_>, late_ns: u64, skipped: u64) {
        let hand_m = engaged.device().hand_m();
        let before = Moment::now();
        let Ok(sample) = engaged.tick();
        let took_ns = before.elapsed().as_nanos() as u64;
        self.looping.heard(engaged.controller_mut(), &sample);
        if sample.fault.is_some() && !self.looping.stopping {
            self.stop(engaged);
        }
        let around = Around {
            hand_m,
            hand_force_n: engaged.device().hand_force_n(),
            took_ns,
            late_ns,
            skipped,
        };
        self.looping.report(engaged.controller(), &sample, around);
    }
}
