//! The loop of a simulated device by the clock, endless: it is paused, stopped and armed anew.

use haptic_loop::{
    realtime::{Moment, Periodic, PeriodicConfig, SpinMargin, ThreadConfig},
    units::Seconds,
};
use haptic_trial::in_hand::{
    hand::HeldDevice,
    running::Running,
    ticking::{FeltController, LoopCounts, LoopEnds},
};
use std::{sync::Arc, time::Duration};

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
    let mut running = Running::new(ends, Arc::clone(counts));
    let mut engaged = controller.engage(device);
    loop {
        let cycle = periodic.wait();
        if !running.obeys(&mut engaged) {
            break;
        }
        let late_ns = cycle.lateness.as_nanos() as u64;
        let begun = Moment::now();
        let clock = || begun.elapsed().as_nanos() as u64;
        running.tick(&mut engaged, clock, (late_ns, cycle.skipped));
    }
}
