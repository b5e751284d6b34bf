//! A device that this process serves itself: a board of another maker behind the device's side of the link.

use super::{
    error::BoardTrouble,
    line::{Line as _, Pipe, lock},
};
use crate::{DeviceSession, Exchange, Hardware, TickSide, held_clock::HeldClock};
use core::{cell::RefCell, hint::spin_loop};
use haptic_link::{Capabilities, ControllerCost, FRAME_MAX, Refusal, SerialNumber, State};
use haptic_loop::{Device, Fault, Reading, SafeForce, realtime::Moment};
use std::{
    io::{Read as _, Write as _},
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, AtomicU64, Ordering},
    },
    thread::JoinHandle,
    time::Duration,
};
use thiserror::Error;

/// Shortest tick at which a USB port of full speed, which moves bytes each millisecond, can follow, µs.
pub const USB_PERIOD_US: u32 = 500;

/// Time before a tick at which sleeping ends and spinning begins.
const SPIN: Duration = Duration::from_micros(80);
/// Longer than a force takes to fall, at the end.
const FALL: Duration = Duration::from_secs(2);

/// Hardware that a thread of this process can serve. [`let_go`](haptic_loop::Device::let_go) is called at the end
/// too, after the force has fallen, and when the thread panics.
pub trait ServedHardware<const D: usize = 1>: Hardware<D> + Send + 'static {
    /// Words about the last fault of the hardware, its remedy and cause; `None` if it had none. Not called in a tick.
    fn trouble(&self) -> Option<BoardTrouble>;
}

/// A device of another maker, served by a thread with the loop, limits, watchdog and flight recorder of any device.
/// Dropping it lets the force fall to zero, then lets go of the hardware.
#[derive(Debug)]
pub struct Served {
    line: Pipe,
    stop: Arc<AtomicBool>,
    trouble: Arc<Mutex<Option<BoardTrouble>>>,
    thread: Option<JoinHandle<()>>,
}

impl Served {
    /// Starts serving. A [`SerialLink`](super::SerialLink) [connects](super::SerialLink::to_served) to it.
    ///
    /// # Errors
    /// Hardware that refuses its first configuration, which is a defect of that hardware;
    /// no thread available.
    pub fn start<H: ServedHardware<D>, const D: usize>(hardware: H) -> Result<Self, ServeError> {
        Self::serve(hardware, Moment::now, None)
    }

    /// Serves emulated hardware: its clock follows its ticks and is never more than a period
    /// past the last. On a busy machine the device runs slowly but is never late.
    ///
    /// # Errors
    /// As [`start`](Self::start).
    pub fn in_its_own_time<H: ServedHardware<D>, const D: usize>(
        hardware: H,
        time: DeviceTime,
    ) -> Result<Self, ServeError> {
        Self::serve(hardware, Moment::now, Some(time))
    }

    /// Serves hardware with this clock, or in its own time.
    ///
    /// # Errors
    /// As [`start`](Self::start).
    pub fn serve<H: ServedHardware<D>, const D: usize>(
        hardware: H,
        now: fn() -> Moment,
        own_time: Option<DeviceTime>,
    ) -> Result<Self, ServeError> {
        let clock = HeldClock::new(now, 1.0);
        let device = TickSide::new(Punctual::new(hardware, clock)).map_err(ServeError::Hardware)?;
        let (here, line) = Pipe::pair();
        let stop = Arc::new(AtomicBool::new(false));
        let trouble = Arc::new(Mutex::new(None));
        let mut serving = Serving {
            device: RefCell::new(device),
            session: DeviceSession::within_this_process(),
            line,
            frame: [0; FRAME_MAX],
            clock,
            own_time,
            faults: 0,
            trouble: Arc::clone(&trouble),
        };
        let stopped = Arc::clone(&stop);
        let builder = std::thread::Builder::new().name("served-device".into());
        let thread = builder.spawn(move || serving.run(&stopped));
        Ok(Self {
            line: here,
            stop,
            trouble,
            thread: Some(thread.map_err(ServeError::Thread)?),
        })
    }

    pub(super) fn line(&self) -> Pipe {
        self.line.clone()
    }

    pub(super) const fn thread(&self) -> Option<&JoinHandle<()>> {
        self.thread.as_ref()
    }

    pub(super) fn trouble(&self) -> Option<BoardTrouble> {
        lock(&self.trouble).clone()
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // A panic in there has been printed, and its hardware has been dropped.
            let _ = thread.join();
        }
    }
}

/// Hardware that cannot be served.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ServeError {
    /// It refuses the configuration of a device at power-up.
    #[error("the device refuses its first configuration: {0:?}")]
    Hardware(Refusal),
    /// The system gives no thread.
    #[error("a thread could not be started: {0}")]
    Thread(std::io::Error),
}

struct Serving<H: Hardware<D>, const D: usize> {
    device: RefCell<TickSide<Punctual<H>, D>>,
    session: DeviceSession,
    line: Pipe,
    frame: [u8; FRAME_MAX],
    /// Held back only for a device in its own time.
    clock: HeldClock,
    own_time: Option<DeviceTime>,
    /// Faults whose trouble has been reported.
    faults: u16,
    trouble: Arc<Mutex<Option<BoardTrouble>>>,
}

impl<H: ServedHardware<D>, const D: usize> Serving<H, D> {
    fn run(&mut self, stop: &AtomicBool) {
        while !stop.load(Ordering::Relaxed) {
            self.round();
        }
        self.device.borrow_mut().disarm();
        let ended = Moment::now();
        while !self.is_at_rest() && ended.elapsed() < FALL {
            self.round();
        }
        self.device.borrow_mut().hardware_mut().let_go();
    }

    fn is_at_rest(&self) -> bool {
        // Idle, or in a fault whose force has fallen.
        let device = self.device.borrow();
        device.status().state != State::Stopping && device.may_install().is_ok()
    }

    /// When something is heard: by the clock, or in the time of the ticks, whose watchdog would else see the future.
    fn heard_us(&self) -> u64 {
        match self.own_time {
            None => self.clock.now_us(),
            Some(_) => self.clock.ticked_us,
        }
    }

    /// Waits for bytes or for the next tick, and works on what came.
    fn round(&mut self) {
        let period_us = u64::from(self.device.borrow().configuration().0.tick_period_us);
        let due_us = self.clock.ticked_us + period_us;
        self.hear(due_us);
        if self.clock.now_us() + SPIN.as_micros() as u64 >= due_us {
            while self.clock.now_us() < due_us {
                spin_loop();
            }
            match self.own_time.clone() {
                None => self.tick_by_the_clock(due_us, period_us),
                Some(time) => {
                    time.pass(period_us);
                    self.clock.ticked_us = due_us;
                    self.device.borrow_mut().tick(due_us);
                    self.clock.catch_up(self.clock.ticked_us);
                }
            }
            self.tell_trouble();
        }
        self.speak();
    }

    /// Hands what the host has sent to the session. Waits for it, but not into the time of spinning.
    fn hear(&mut self, due_us: u64) {
        let mut bytes = [0; 1024];
        let left = Duration::from_micros(due_us.saturating_sub(self.clock.now_us()));
        // A pipe takes any patience.
        let _ = self.line.set_patience(left.saturating_sub(SPIN));
        let count = match self.line.read(&mut bytes) {
            Ok(0) => {
                // The host has gone: the watchdog takes over until this thread is stopped.
                std::thread::sleep(left.saturating_sub(SPIN));
                0
            }
            Ok(count) => count,
            Err(_) => 0,
        };
        for &byte in &bytes[..count] {
            let heard_us = self.heard_us();
            let length = (self.session).receive(byte, heard_us, &self.device, &mut self.frame);
            self.send(length);
        }
    }

    fn tick_by_the_clock(&mut self, due_us: u64, period_us: u64) {
        let now_us = self.clock.now_us();
        // Whole periods that had passed before it have no tick.
        let skipped = now_us.saturating_sub(due_us) / period_us;
        let mut device = self.device.borrow_mut();
        device.skip(skipped as u32);
        let watchdog_ms = u64::from(device.configuration().0.limits.watchdog_ms);
        if now_us.saturating_sub(self.clock.ticked_us) > 1000 * watchdog_ms {
            device.stood_still();
        }
        (device.hardware_mut()).at_latest(now_us + 1000 * watchdog_ms);
        device.tick(now_us);
        self.clock.ticked_us = due_us + skipped * period_us;
        // The timer of a board would have fired again.
        if self.clock.now_us() >= self.clock.ticked_us + period_us {
            device.overrun();
        }
    }

    fn tell_trouble(&mut self) {
        let device = self.device.borrow();
        let faults = device.status().faults;
        if core::mem::replace(&mut self.faults, faults) != faults {
            *lock(&self.trouble) = device.hardware().hardware.trouble();
        }
    }

    fn speak(&mut self) {
        loop {
            let length = self.session.poll(&self.device, &mut self.frame);
            if length == 0 {
                return;
            }
            self.send(length);
        }
    }

    fn send(&mut self, length: usize) {
        if length == 0 {
            return;
        }
        // Without a reader the frame is lost, as on a line that is too slow, and missed by its number.
        let _ = self.line.write(&self.frame[..length]);
    }
}

/// Hardware behind a deadline. If this process was stopped in the middle of a tick, its force belongs to a place of
/// then: the tick fails instead, and the hardware lets go.
#[derive(Debug)]
pub(super) struct Punctual<H> {
    pub hardware: H,
    clock: HeldClock,
    /// None for hardware in its own time, which nothing holds up.
    latest_us: Option<u64>,
}

impl<H> Punctual<H> {
    const fn new(hardware: H, clock: HeldClock) -> Self {
        Self {
            hardware,
            clock,
            latest_us: None,
        }
    }

    /// Later than this the force of the next tick does not go out.
    const fn at_latest(&mut self, latest_us: u64) {
        self.latest_us = Some(latest_us);
    }
}

impl<H: Hardware<D>, const D: usize> Device<f32, D> for Punctual<H> {
    type Error = Fault;

    fn read(&mut self) -> Result<Reading<f32, D>, Fault> {
        self.hardware.read()
    }

    fn write(&mut self, force: SafeForce<f32, D>) -> Result<(), Fault> {
        let pushes = force.newtons().iter().any(|&axis| axis != 0.0);
        if pushes
            && self
                .latest_us
                .is_some_and(|latest| self.clock.now_us() > latest)
        {
            return Err(Fault::HostSilent);
        }
        self.hardware.write(force)
    }

    fn let_go(&mut self) {
        self.hardware.let_go();
    }
}

impl<H: Hardware<D>, const D: usize> Hardware<D> for Punctual<H> {
    type Setup = H::Setup;

    fn capabilities(&self) -> Capabilities {
        self.hardware.capabilities()
    }

    fn serial_number(&self) -> SerialNumber {
        self.hardware.serial_number()
    }

    fn controller_cost(&self) -> Option<ControllerCost> {
        self.hardware.controller_cost()
    }

    fn fit(&self, setup: &mut Self::Setup) -> Result<(), Refusal> {
        self.hardware.fit(setup)
    }

    fn install(&mut self, setup: Self::Setup, tick_period_us: u32) {
        self.hardware.install(setup, tick_period_us);
    }

    fn exchange(&mut self) -> Option<&mut Exchange> {
        self.hardware.exchange()
    }

    fn restart(&mut self) {
        self.hardware.restart();
    }

    fn sense(&mut self) -> [f32; D] {
        self.hardware.sense()
    }

    fn idle(&mut self) -> Result<Reading<f32, D>, Fault> {
        self.hardware.idle()
    }

    fn persisting_fault(&self) -> Option<Fault> {
        self.hardware.persisting_fault()
    }

    fn cycles(&self) -> u32 {
        self.hardware.cycles()
    }
}

/// Time of a device that is served [in its own time](super::Served::in_its_own_time), µs; its emulated hardware lives
/// in it.
#[derive(Clone, Debug, Default)]
pub struct DeviceTime(Arc<AtomicU64>);

impl DeviceTime {
    /// The time of the last tick, µs; 0 before the first. It continues where the device is served anew.
    #[must_use]
    pub fn now_us(&self) -> u64 {
        self.0.load(Ordering::Acquire)
    }

    fn pass(&self, passed_us: u64) {
        self.0.fetch_add(passed_us, Ordering::AcqRel);
    }
}
