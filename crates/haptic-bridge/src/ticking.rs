//! The work of a call of the program: requests that have come, the tick, reports that are to go.
//!
//! *Between the threads* are two queues of whole messages, bounded and without locks: decoding and encoding, the greater part
//! of the work, is done by the thread of the line. A full queue to the host makes samples wait in the device, where they
//! are counted when they find no room.
//!
//! *Cost*: that of [`TickSide::tick`], some 30 comparisons and stores, and at most [`REQUESTS_MOST`] requests and
//! [`REPORTS_MOST`] reports. No allocation, no lock, no system call.

use crate::clock::ProgramClock;
use crate::description::Description;
use crate::program::Program;
use crate::status::{Handle, Trouble};
use haptic_link::{Capabilities, Header, Refusal, Report, Request, State};
use haptic_loop::Fault;
use haptic_remote::{DeviceSession, TickSide};
use rtrb::{Consumer, Producer};
use std::cell::RefCell;

/// Requests that a call acts on at most; the others wait.
const REQUESTS_MOST: usize = 4;
/// Samples and notices that a call hands over at most.
const REPORTS_MOST: usize = 2;
/// Room that samples leave for answers.
const ROOM_FOR_ANSWERS: usize = 16;

/// A request as it came over the line.
pub(crate) type Heard = (Header, Request);

/// A device of any number of axes.
pub(crate) trait Ticks: std::fmt::Debug + Send {
    /// One call: the force until the next, N.
    fn call(&mut self, time_us: u64, position_m: Option<&[f64; 3]>) -> [f64; 3];
}

#[derive(Debug)]
pub(crate) struct Ticking<const D: usize> {
    device: RefCell<TickSide<Program<D>, D>>,
    session: DeviceSession,
    requests: Consumer<Heard>,
    reports: Producer<Report>,
    handle: Handle,
    clock: ProgramClock,
    ticked_us: u64,
    /// Longest silence that the program allows, µs.
    silence_most_us: u64,
    trouble: Option<Trouble>,
}

impl<const D: usize> Ticking<D> {
    pub(crate) fn new(
        description: &Description,
        capabilities: Capabilities,
        ends: (Consumer<Heard>, Producer<Report>),
        handle: Handle,
    ) -> Result<Self, Refusal> {
        let device = TickSide::new(Program::new(description, capabilities))?;
        let silence_most_us = match description.watchdog_ms {
            0 => u64::MAX,
            watchdog_ms => 1000 * u64::from(watchdog_ms),
        };
        Ok(Self {
            device: RefCell::new(device),
            session: DeviceSession::within_this_process(),
            requests: ends.0,
            reports: ends.1,
            handle,
            clock: ProgramClock::new(capabilities.tick_period_min_us.into()),
            ticked_us: 0,
            silence_most_us,
            trouble: None,
        })
    }

    /// Acts on requests. Only with room for an answer, so that none is lost.
    fn hear(&mut self, now_us: u64) {
        for _ in 0..REQUESTS_MOST {
            if self.reports.is_full() {
                return;
            }
            let Ok((header, request)) = self.requests.pop() else {
                return;
            };
            let report = (self.session).respond(header, request, now_us, &self.device);
            if let Some(report) = report {
                // There is room.
                let _ = self.reports.push(report);
            }
        }
    }

    fn speak(&mut self) {
        for _ in 0..REPORTS_MOST {
            if self.reports.slots() <= ROOM_FOR_ANSWERS {
                return;
            }
            let Some(report) = self.device.get_mut().next_report() else {
                return;
            };
            // There is room.
            let _ = self.reports.push(report);
        }
    }

    /// Ends a run whose host is silent for longer than the program allows. While the host computes the force, only forces count.
    fn watch(&mut self, now_us: u64) {
        let device = self.device.get_mut();
        let needs_a_host = matches!(device.status().state, State::Armed | State::Running);
        if needs_a_host && now_us - device.heard_us() > self.silence_most_us {
            device.trip(Fault::HostSilent);
        }
    }
}

impl<const D: usize> Ticks for Ticking<D> {
    fn call(&mut self, time_us: u64, position_m: Option<&[f64; 3]>) -> [f64; 3] {
        let call = self.clock.call(time_us);
        let device = self.device.get_mut();
        let measured = device.hardware_mut().take(position_m);
        let trouble = match position_m {
            None => Some(Trouble::Nothing),
            Some(_) if !measured => Some(Trouble::Position),
            Some(_) if !call.goes_on => Some(Trouble::Time),
            Some(_) => None,
        };
        if trouble.is_some() {
            device.hardware_mut().forget();
        }
        if self.handle.take_stop() {
            device.disarm();
        }
        let watchdog_ms = u64::from(device.configuration().0.limits.watchdog_ms);
        let stood_us = call.now_us - self.ticked_us;
        if stood_us > (1000 * watchdog_ms).min(self.silence_most_us) {
            device.stood_still();
        }
        self.hear(call.now_us);
        self.watch(call.now_us);
        let device = self.device.get_mut();
        // Trouble does not wait until a tick is due.
        if call.is_tick || trouble.is_some() {
            if call.skipped > 0 {
                device.skip(call.skipped);
            }
            device.tick(call.now_us);
            self.ticked_us = call.now_us;
        }
        let force_n = device.hardware().force_n();
        let fault = device.status().fault;
        if trouble.is_some() && fault == Fault::BoardFailed.code() {
            self.trouble = self.trouble.or(trouble);
        } else if fault == 0 {
            self.trouble = None;
        }
        self.handle.tell(fault, self.trouble);
        self.speak();
        force_n
    }
}
