//! The main loop: answers the host, sends what the loop has to say, feeds the watchdog, sleeps.

use crate::{
    device::Shared,
    parts::{HostLine, Watchdog},
};
use haptic_link::FRAME_MAX;
use haptic_remote::{DeviceSession, Exclusive as _, Hardware};

/// The main loop's work, a round at a time.
///
/// - *Watchdog*: fed here and only after another tick, so feeding proves that both this loop and
///   the tick run.
/// - *Nothing waits*: a request is read only when there is room for its answer; until then bytes wait in
///   the line's queue, and if that is full they are counted as lost.
#[derive(Debug)]
pub struct MainLoop<'a, H: Hardware> {
    device: &'a Shared<H>,
    session: &'a mut DeviceSession,
    frame: [u8; FRAME_MAX],
    ticks: u32,
    #[cfg(all(feature = "defmt", target_os = "none"))]
    news: crate::news::News,
}

impl<'a, H: Hardware> MainLoop<'a, H> {
    /// Before the first round.
    pub const fn new(device: &'a Shared<H>, session: &'a mut DeviceSession) -> Self {
        Self {
            device,
            session,
            frame: [0; FRAME_MAX],
            ticks: 0,
            #[cfg(all(feature = "defmt", target_os = "none"))]
            news: crate::news::News::new(),
        }
    }

    /// One round. Returns true if nothing is left to do: then sleep until the next interrupt, at
    /// the latest the tick.
    pub fn round(
        &mut self,
        line: &mut impl HostLine,
        watchdog: &mut impl Watchdog,
        now_us: impl Fn() -> u64,
    ) -> bool {
        let Self {
            device,
            session,
            frame,
            ..
        } = self;
        let mut idle = true;
        while line.room() >= FRAME_MAX
            && let Some(byte) = line.receive()
        {
            idle = false;
            let length = session.receive(byte, now_us(), *device, frame);
            line.send(&frame[..length]);
        }
        session.bytes_lost(line.take_lost());
        if line.room() >= FRAME_MAX {
            let length = session.poll(*device, frame);
            idle &= length == 0;
            line.send(&frame[..length]);
        }
        let ticked = device.with(|device| device.statistics().ticks);
        if ticked != self.ticks {
            self.ticks = ticked;
            watchdog.feed();
            #[cfg(all(feature = "defmt", target_os = "none"))]
            self.news.tell(device.with(|device| device.status()));
        }
        idle
    }
}

/// [`MainLoop::round`] for ever, sleeping while there is nothing to do.
pub fn serve<H: Hardware>(
    device: &Shared<H>,
    session: &mut DeviceSession,
    line: &mut impl HostLine,
    watchdog: &mut impl Watchdog,
    now_us: impl Fn() -> u64,
    mut sleep: impl FnMut(),
) -> ! {
    let mut main_loop = MainLoop::new(device, session);
    loop {
        if main_loop.round(line, watchdog, &now_us) {
            sleep();
        }
    }
}
