//! Interface to a board: the parts of its chip that a device needs.

/// The timer whose interrupt is the tick.
pub trait TickTimer {
    /// The tick has begun: a further one that comes due from here on is [`pending`](Self::is_pending).
    fn acknowledge(&mut self);

    /// True if the next tick is due already.
    fn is_pending(&self) -> bool;

    /// Ticks come at this period from now on, 100 µs to 10 ms.
    fn set_period_us(&mut self, period_us: u32);
}

/// The line to the host. Nothing here waits.
pub trait HostLine {
    /// The next byte that came.
    fn receive(&mut self) -> Option<u8>;

    /// Bytes lost since the last call because they were not fetched in time.
    fn take_lost(&mut self) -> u32;

    /// Bytes that can be sent now: a frame's length, [`FRAME_MAX`](haptic_link::FRAME_MAX), when the line is idle.
    fn room(&self) -> usize;

    /// Sends as many of these bytes as there is [`room`](Self::room) for.
    fn send(&mut self, bytes: &[u8]);
}

/// A watchdog, which resets the chip unless it is fed.
pub trait Watchdog {
    /// Puts the reset off for another watchdog time.
    fn feed(&mut self);
}

/// No watchdog: only where nothing can move, as in an emulator.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoWatchdog;

impl Watchdog for NoWatchdog {
    fn feed(&mut self) {}
}

/// A board at power-up, with everything on it that the device uses.
#[derive(Debug)]
pub struct Parts<H, T, L, W> {
    /// Sensor and actuator, or a simulation of them.
    pub hardware: H,
    /// The timer that makes the ticks; it stands still until its period is set.
    pub timer: T,
    /// Carries the frames to the host and back.
    pub line: L,
    /// The watchdog that watches tick and main loop.
    pub watchdog: W,
}
