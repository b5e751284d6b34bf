//! Tick interrupt and main loop, the same on every board.

use crate::chip;
use crate::parts::{Line as _, TickTimer, Watchdog as _};
use crate::retained::Retained;
use core::cell::RefCell;
use critical_section::Mutex;
use haptic_link::{FRAME_MAX, State};
use haptic_remote::{DeviceSession, Exclusive, Hardware, TickSide};

/// The device's loop, lent to one user at a time by a critical section.
#[derive(Debug)]
pub struct Shared<H: Hardware>(Mutex<RefCell<TickSide<H>>>);

impl<H: Hardware> Shared<H> {
    /// To be shared.
    pub const fn new(device: TickSide<H>) -> Self {
        Self(Mutex::new(RefCell::new(device)))
    }
}

impl<H: Hardware> Exclusive<TickSide<H>> for Shared<H> {
    fn with<R>(&self, user: impl FnOnce(&mut TickSide<H>) -> R) -> R {
        critical_section::with(|token| user(&mut self.0.borrow_ref_mut(token)))
    }
}

/// The work of the tick interrupt.
#[derive(Debug)]
pub struct Ticker<H: Hardware + 'static, T> {
    device: &'static Shared<H>,
    timer: T,
    period_us: u32,
}

impl<H: Hardware, T: TickTimer> Ticker<H, T> {
    /// Starts the timer at the period of the device's configuration.
    pub fn new(device: &'static Shared<H>, mut timer: T) -> Self {
        let period_us = device.with(|device| device.configuration().0.tick_period_us);
        timer.set_period_us(period_us);
        Self {
            device,
            timer,
            period_us,
        }
    }

    /// One tick. A tick that is not done when the next comes due is an overrun.
    pub fn tick(&mut self, now_us: u64) {
        self.timer.acknowledge();
        let period_us = self.device.with(|device| {
            device.tick(now_us);
            if self.timer.is_pending() {
                device.overrun();
            }
            Retained::set_armed(matches!(
                device.status().state,
                State::Armed | State::Running | State::Stopping
            ));
            device.configuration().0.tick_period_us
        });
        if period_us != self.period_us {
            self.period_us = period_us;
            self.timer.set_period_us(period_us);
        }
    }
}

/// The main loop: answers the host, sends what the loop has to say, feeds the watchdog, sleeps.
///
/// - *Watchdog*: fed here, so this loop runs, and only after a further tick, so that one runs too.
/// - *Nothing waits*: a request is read only when there is room for its answer; until then bytes wait in
///   the line's queue, and if that is full they are counted as lost.
#[inline(never)]
pub fn serve(
    device: &Shared<chip::Board>,
    session: &mut DeviceSession,
    line: &mut chip::Uart,
    watchdog: &mut chip::Watchdog,
) -> ! {
    let mut frame = [0; FRAME_MAX];
    let mut ticks = 0;
    loop {
        let mut idle = true;
        while line.room() >= FRAME_MAX
            && let Some(byte) = line.receive()
        {
            idle = false;
            let length = session.receive(byte, chip::now_us(), device, &mut frame);
            line.send(&frame[..length]);
        }
        session.bytes_lost(line.take_lost());
        if line.room() >= FRAME_MAX {
            let length = session.poll(device, &mut frame);
            idle &= length == 0;
            line.send(&frame[..length]);
        }
        let ticked = device.with(|device| device.statistics().ticks);
        if ticked != ticks {
            ticks = ticked;
            watchdog.feed();
        }
        if idle {
            // The tick, at the latest, wakes it.
            cortex_m::asm::wfi();
        }
    }
}
