//! The tick: alarm 3 of the timer that counts microseconds. Alarm 0 is embassy's.

use embassy_rp::interrupt::{self, InterruptExt as _, Priority};
#[cfg(feature = "rp2040")]
use embassy_rp::interrupt::{TIMER_IRQ_0 as OF_EMBASSY, TIMER_IRQ_3 as OF_TICK};
#[cfg(feature = "rp2350")]
use embassy_rp::interrupt::{TIMER0_IRQ_0 as OF_EMBASSY, TIMER0_IRQ_3 as OF_TICK};
#[cfg(feature = "rp2040")]
use embassy_rp::pac::TIMER;
#[cfg(feature = "rp2350")]
use embassy_rp::pac::TIMER0 as TIMER;
use embassy_time::Instant;
use haptic_board::TickTimer;

const ALARM: usize = 3;
/// An alarm that is set for the past comes only when the counter comes round: 71 minutes. So a late one is set so far
/// ahead, µs.
const SOON_US: u32 = 5;

/// Time since power-up, µs.
pub(crate) fn now_us() -> u64 {
    Instant::now().as_micros()
}

/// Its lower word, µs.
pub(crate) fn counter_us() -> u32 {
    TIMER.timerawl().read()
}

/// Time of a byte of four samples of the encoder, µs. Where a tick's period is a multiple of it, the position is as old at each tick, and a
/// steady speed shows no ripple.
pub(crate) const BYTE_US: u32 = 25;

/// Time until the next tick is due, µs, or since it was, below zero.
pub(crate) fn until_tick_us() -> i32 {
    TIMER.alarm(ALARM).read().wrapping_sub(counter_us()) as i32
}

/// Alarm 3, once a period.
#[derive(Debug)]
pub(crate) struct Alarm {
    /// When the last tick was due, on the timer's lower word.
    last_us: u32,
    period_us: u32,
}

impl Alarm {
    /// Alarm with the highest priority; it stands still until its period is set.
    pub(crate) fn start() -> Self {
        // All others come after it: USB and embassy's own alarm.
        interrupt::USBCTRL_IRQ.set_priority(Priority::P3);
        OF_EMBASSY.set_priority(Priority::P2);
        OF_TICK.set_priority(Priority::P0);
        TIMER
            .inte()
            .modify(|enabled| enabled.set_alarm(ALARM, true));
        #[expect(unsafe_code, reason = "interrupts begin")]
        // SAFETY: the handler looks into a slot that is empty until the ticker is in it.
        unsafe {
            OF_TICK.enable();
        }
        Self {
            last_us: counter_us(),
            period_us: 1000,
        }
    }

    fn arm(&mut self) {
        let mut next_us = self.last_us.wrapping_add(self.period_us);
        // A period that is over is skipped, not made up for; the samples of the encoder keep their distance.
        let late_us = (counter_us().wrapping_add(SOON_US)).wrapping_sub(next_us) as i32;
        if late_us > 0 {
            let late_us = (late_us as u32).next_multiple_of(BYTE_US);
            next_us = next_us.wrapping_add(late_us);
            self.last_us = self.last_us.wrapping_add(late_us);
        }
        TIMER.alarm(ALARM).write_value(next_us);
    }
}

impl TickTimer for Alarm {
    fn acknowledge(&mut self) {
        TIMER.intr().write(|raised| raised.set_alarm(ALARM, true));
        self.last_us = self.last_us.wrapping_add(self.period_us);
        self.arm();
    }

    fn is_pending(&self) -> bool {
        TIMER.intr().read().alarm(ALARM)
    }

    fn set_period_us(&mut self, period_us: u32) {
        self.period_us = period_us;
        self.arm();
    }
}
