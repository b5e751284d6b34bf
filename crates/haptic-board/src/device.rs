//! The device's loop, and the work of its tick interrupt.

use crate::parts::TickTimer;
use crate::retained::{Retained, RetainedMemory};
use core::cell::RefCell;
use core::mem::MaybeUninit;
use critical_section::Mutex;
use haptic_link::{Refusal, State};
use haptic_loop::Fault;
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

/// Makes the device in its place: idle, without a force, and in the fault [`Fault::Reset`] if a reset has come in
/// between. On its own, so that what it needs of the stack is free again.
///
/// # Errors
/// As [`TickSide::passive`]: a board that cannot be without a configuration.
#[inline(never)]
pub fn power_up<H: Hardware>(
    place: &'static mut MaybeUninit<Shared<H>>,
    hardware: H,
    retained: Retained,
) -> Result<&'static Shared<H>, Refusal> {
    let passive = TickSide::passive(&hardware)?;
    let device = place.write(Shared::new(TickSide::with(hardware, passive)));
    if retained.was_armed {
        device.with(|device| device.trip(Fault::Reset));
    }
    Ok(device)
}

/// Makes the device's half of the conversation in its place. On its own, as [`power_up`].
#[inline(never)]
pub fn session(
    place: &'static mut MaybeUninit<DeviceSession>,
    firmware: [u8; 3],
    retained: Retained,
) -> &'static mut DeviceSession {
    place.write(DeviceSession::new(firmware, retained.boot))
}

/// The work of the tick interrupt.
#[derive(Debug)]
pub struct Ticker<H: Hardware + 'static, T> {
    device: &'static Shared<H>,
    timer: T,
    retained: &'static RetainedMemory,
    period_us: u32,
}

impl<H: Hardware, T: TickTimer> Ticker<H, T> {
    /// Starts the timer at the period of the device's configuration.
    pub fn new(
        device: &'static Shared<H>,
        mut timer: T,
        retained: &'static RetainedMemory,
    ) -> Self {
        let period_us = device.with(|device| device.configuration().0.tick_period_us);
        timer.set_period_us(period_us);
        Self {
            device,
            timer,
            retained,
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
            self.retained.set_armed(matches!(
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

    /// The timer, for an interrupt that asks it when to come next.
    pub const fn timer(&self) -> &T {
        &self.timer
    }
}

/// A static for the ticker: start-up puts it in, the tick interrupt takes its turn.
#[derive(Debug)]
pub struct TickerSlot<H: Hardware + 'static, T>(Mutex<RefCell<Option<Ticker<H, T>>>>);

impl<H: Hardware, T: TickTimer> TickerSlot<H, T> {
    /// Without a ticker: its interrupt does nothing.
    #[must_use]
    pub const fn empty() -> Self {
        Self(Mutex::new(RefCell::new(None)))
    }

    /// From now on the interrupt ticks.
    pub fn put(&self, ticker: Ticker<H, T>) {
        critical_section::with(|token| {
            self.0.borrow_ref_mut(token).replace(ticker);
        });
    }

    /// To be called by the tick interrupt.
    #[inline]
    pub fn tick(&self, now_us: impl FnOnce() -> u64) {
        critical_section::with(|token| {
            if let Some(ticker) = self.0.borrow_ref_mut(token).as_mut() {
                ticker.tick(now_us());
            }
        });
    }
}
