//! The device's loop, and the work of its tick interrupt.

use crate::{
    parts::TickTimer,
    retained::{Retained, RetainedMemory},
};
use core::{cell::RefCell, mem::MaybeUninit};
use critical_section::Mutex;
use haptic_link::{Refusal, State};
use haptic_loop::{Fault, SafetyChain};
use haptic_remote::{DeviceSession, Exclusive, Hardware, Records, TickSide};

/// The device's loop, with its records elsewhere.
type Loop<H> = TickSide<H, 1, &'static mut Records>;

/// The device's loop, lent to one user at a time by a critical section.
#[derive(Debug)]
pub struct Shared<H: Hardware>(Mutex<RefCell<Loop<H>>>);

impl<H: Hardware> Exclusive for Shared<H> {
    type Value = Loop<H>;

    fn with<R>(&self, user: impl FnOnce(&mut Loop<H>) -> R) -> R {
        critical_section::with(|token| user(&mut self.0.borrow_ref_mut(token)))
    }
}

/// Memory for a device, for a static: everything large is built here and not on the stack.
#[derive(Debug)]
pub struct DeviceMemory<H: Hardware> {
    device: MaybeUninit<Shared<H>>,
    records: Records,
    session: MaybeUninit<DeviceSession>,
}

impl<H: Hardware> DeviceMemory<H> {
    /// Nothing is made yet, so that a static costs no image: `power_up` fills it.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            device: MaybeUninit::uninit(),
            records: Records::new(),
            session: MaybeUninit::uninit(),
        }
    }
}

impl<H: Hardware> Default for DeviceMemory<H> {
    fn default() -> Self {
        Self::new()
    }
}

/// Makes the device and its half of the conversation. It is idle, without a force, and in the fault
/// [`Fault::Reset`] if a reset has come while it was armed or in a fault. `firmware` is the
/// version: major, minor, patch.
///
/// # Errors
/// As [`TickSide::passive`]: a board that refuses its first configuration.
pub fn power_up<H: Hardware>(
    place: &'static mut DeviceMemory<H>,
    hardware: H,
    firmware: [u8; 3],
    retained: Retained,
) -> Result<(&'static Shared<H>, &'static mut DeviceSession), Refusal> {
    let device = device(&mut place.device, &mut place.records, hardware)?;
    if retained.was_armed {
        device.with(|device| device.trip(Fault::Reset));
    }
    let session = session(&mut place.session, firmware, retained.boot);
    Ok((device, session))
}

// Each on its own, so that what it needs of the stack is free again.

#[inline(never)]
fn device<H: Hardware>(
    place: &'static mut MaybeUninit<Shared<H>>,
    records: &'static mut Records,
    hardware: H,
) -> Result<&'static Shared<H>, Refusal> {
    let passive = TickSide::passive(&hardware)?;
    let device = asleep(place, records, hardware, passive.chain());
    device.with(|device| device.wake(passive, &TickSide::<H>::PASSIVE));
    Ok(device)
}

#[inline(never)]
fn asleep<H: Hardware>(
    place: &'static mut MaybeUninit<Shared<H>>,
    records: &'static mut Records,
    hardware: H,
    chain: SafetyChain<f32>,
) -> &'static Shared<H> {
    let device = TickSide::asleep(hardware, chain, records);
    place.write(Shared(Mutex::new(RefCell::new(device))))
}

#[inline(never)]
fn session(
    place: &'static mut MaybeUninit<DeviceSession>,
    firmware: [u8; 3],
    boot: u32,
) -> &'static mut DeviceSession {
    place.write(DeviceSession::new(firmware, boot))
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
                State::Armed | State::Running | State::Stopping | State::Fault
            ));
            device.configuration().0.tick_period_us
        });
        if period_us != self.period_us {
            self.period_us = period_us;
            self.timer.set_period_us(period_us);
        }
    }

    /// The timer, for an interrupt that asks it for the next tick's time.
    pub const fn timer(&self) -> &T {
        &self.timer
    }
}

/// A static for the ticker: start-up stores it, the tick interrupt runs it.
#[derive(Debug)]
pub struct TickerSlot<H: Hardware + 'static, T>(Mutex<RefCell<Option<Ticker<H, T>>>>);

impl<H: Hardware, T: TickTimer> TickerSlot<H, T> {
    /// Slot without a ticker: its interrupt does nothing.
    #[must_use]
    pub const fn empty() -> Self {
        Self(Mutex::new(RefCell::new(None)))
    }

    /// Puts the ticker in: from now on the interrupt ticks.
    pub fn put(&self, ticker: Ticker<H, T>) {
        critical_section::with(|token| {
            self.0.borrow_ref_mut(token).replace(ticker);
        });
    }

    /// Ticks; to be called by the tick interrupt.
    #[inline]
    pub fn tick(&self, now_us: impl FnOnce() -> u64) {
        critical_section::with(|token| {
            if let Some(ticker) = self.0.borrow_ref_mut(token).as_mut() {
                ticker.tick(now_us());
            }
        });
    }
}
