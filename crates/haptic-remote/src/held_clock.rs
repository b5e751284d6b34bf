//! Time of a device that waits for this machine: real time, held back while it is busy.

use haptic_loop::realtime::Moment;
use std::time::Duration;

/// Largest lag of the device behind the clock. With more lag, its own clock waits.
const BEHIND_MOST: Duration = Duration::from_millis(5);

/// The device's clock: real time, scaled, and held back when the machine is busy.
#[derive(Clone, Copy, Debug)]
pub struct HeldClock {
    now: fn() -> Moment,
    began: Moment,
    speed: f64,
    /// Device time that was held back, µs.
    held_us: u64,
    /// Device time of the last tick, µs.
    pub ticked_us: u64,
}

impl HeldClock {
    /// Starts at device time 0, by this clock.
    pub fn new(now: fn() -> Moment, speed: f64) -> Self {
        Self {
            now,
            began: now(),
            speed,
            held_us: 0,
            ticked_us: 0,
        }
    }

    /// Real time for which it has gone.
    pub fn elapsed(&self) -> Duration {
        (self.now)().saturating_duration_since(self.began)
    }

    /// Time of the device now, µs: real time less what was held back.
    pub fn now_us(&self) -> u64 {
        let scaled = self.elapsed().as_secs_f64() * 1e6 * self.speed;
        (scaled as u64).saturating_sub(self.held_us)
    }

    /// Real time until a device time.
    pub fn until(&self, device_us: u64) -> Duration {
        let ahead = device_us.saturating_sub(self.now_us());
        Duration::from_secs_f64(ahead as f64 * 1e-6 / self.speed)
    }

    /// Holds the clock back to a few milliseconds after this device time, at which the device was due.
    pub fn catch_up(&mut self, due_us: u64) {
        let most = (BEHIND_MOST.as_micros() as f64 * self.speed) as u64;
        let behind = self.now_us().saturating_sub(due_us);
        self.held_us += behind.saturating_sub(most);
    }
}
