//! The work of a call of the program: requests that have come, the tick, reports that are to go.
//!
//! *Between the threads* are two queues of whole messages, bounded and without locks: decoding and encoding, the greater part
//! of the work, is done by the thread of the line. A full queue to the host makes samples wait in the device, where they
//! are counted when they find no room.
//!
//! *Cost*: that of [`TickSide::tick`], some 30 comparisons and stores, and at most [`REQUESTS_MOST`] requests and
//! [`REPORTS_MOST`] reports. No allocation, no lock, no system call.

use crate::{
    clock::{Call, ProgramClock},
    description::{Description, PERIODS_US},
    meter::Meter,
    motion::Motion,
    program::Program,
    status::Handle,
};
use haptic_link::{
    Capabilities, DeviceReport, Header, Reason, Refusal, Request, SerialNumber, State, Trouble,
};
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
    /// One call: the force until the next, N, or the velocity.
    fn call(&mut self, time_us: u64, position_m: Option<&[f64; 3]>) -> [f64; 3];

    /// True if it gives a velocity, m/s, in place of the force.
    fn takes_motion(&self) -> bool;

    /// The force at the sensor, N, for the next tick.
    fn sense(&mut self, force_n: &[f64; 3]);

    /// T, µs; 1000 as long as it is being measured.
    fn period_us(&self) -> u64;
}

#[derive(Debug)]
pub(crate) struct Ticking<const D: usize> {
    device: RefCell<TickSide<Program<D>, D>>,
    session: DeviceSession,
    requests: Consumer<Heard>,
    reports: Producer<DeviceReport>,
    handle: Handle,
    clock: ProgramClock,
    meter: Meter,
    /// The calls by which T is measured, if it was not declared.
    first: Option<First>,
    /// Longest silence that the program allows, µs.
    silence_most_us: u64,
}

/// Calls of the first second.
#[derive(Debug)]
struct First {
    since_us: u64,
    calls: u64,
}

impl<const D: usize> Ticking<D> {
    pub(crate) fn new(
        description: &Description,
        capabilities: Capabilities,
        serial_number: SerialNumber,
        ends: (Consumer<Heard>, Producer<DeviceReport>),
        handle: Handle,
        motion: Option<Box<Motion<D>>>,
    ) -> Result<Self, Refusal> {
        let program = Program::new(description, capabilities, serial_number, motion);
        let device = TickSide::new(program)?;
        let silence_most_us = match description.watchdog_ms {
            0 => u64::MAX,
            watchdog_ms => 1000 * u64::from(watchdog_ms),
        };
        let period_us = match description.sample_time_us {
            0 => 1000,
            period_us => period_us.into(),
        };
        Ok(Self {
            device: RefCell::new(device),
            session: DeviceSession::within_this_process(),
            requests: ends.0,
            reports: ends.1,
            handle,
            clock: ProgramClock::new(period_us),
            meter: Meter::new(period_us),
            first: (description.sample_time_us == 0).then_some(First {
                since_us: u64::MAX,
                calls: 0,
            }),
            silence_most_us,
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
            if let Some(mut report) = report {
                if let DeviceReport::Statistics(statistics) = &mut report {
                    statistics.period_ns = self.meter.mean_ns();
                }
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

    /// Counts a call of the first second; true once T is known, which takes effect with it. A clock that stands still restarts the count.
    fn is_declared(&mut self, time_us: u64) -> bool {
        const LONG_US: u64 = 1_000_000;
        let Some(first) = &mut self.first else {
            return true;
        };
        let passed_us = time_us.saturating_sub(first.since_us);
        if passed_us == 0 {
            (first.since_us, first.calls) = (time_us, 0);
            return false;
        }
        first.calls += 1;
        if passed_us < LONG_US {
            return false;
        }
        let mean_us = (passed_us + first.calls / 2) / first.calls;
        let period_us = mean_us.clamp(PERIODS_US[0].into(), PERIODS_US[1].into());
        let device = self.device.get_mut();
        device.hardware_mut().declare(period_us as u32);
        let Ok(passive) = TickSide::<_, D>::passive(device.hardware()) else {
            return false;
        };
        device.wake(passive, &TickSide::<Program<D>, D>::PASSIVE);
        self.clock = ProgramClock::new(period_us);
        self.meter = Meter::new(period_us);
        self.first = None;
        true
    }

    /// A tick of the device; a thread that is too slow for it is a fault while somebody relies on it.
    fn tick(&mut self, call: &Call) {
        let slow = call.is_tick.then(|| self.meter.tick(call)).flatten();
        let device = self.device.get_mut();
        let closed = matches!(device.status().state, State::Armed | State::Running);
        if let Some(slow) = slow.filter(|_| closed) {
            device.trip_because(Fault::TickOverrun, slow);
        }
        if call.skipped > 0 {
            device.skip(call.skipped);
        }
        device.hardware_mut().goes_on(call.skipped);
        device.tick(call.now_us);
        // One of the run before stays until the next.
        let runs = matches!(device.status().state, State::Running | State::Stopping);
        if let Some(fault) = device.hardware().motion_fault().filter(|_| runs) {
            device.trip(fault);
        }
    }
}

impl<const D: usize> Ticks for Ticking<D> {
    fn call(&mut self, time_us: u64, position_m: Option<&[f64; 3]>) -> [f64; 3] {
        self.handle.called(time_us);
        if !self.is_declared(time_us) {
            return [0.0; 3];
        }
        let call = self.clock.call(time_us);
        let wrong_unit = self.handle.wrong_unit();
        let device = self.device.get_mut();
        let measured = device.hardware_mut().take(position_m);
        let trouble = match position_m {
            None => Some(Reason::of(Trouble::Missing)),
            Some(_) if !measured => Some(Reason::of(Trouble::Position)),
            Some(_) if !call.goes_on => Some(Reason::of(Trouble::Time)),
            Some(_) => wrong_unit,
        };
        if let Some(reason) = trouble {
            device.hardware_mut().forget();
            device.trip_because(Fault::BoardFailed, reason);
        }
        if self.handle.take_stop() {
            device.withdraw();
        }
        let watchdog_ms = u64::from(device.configuration().0.limits.watchdog_ms);
        if call.stood_us > (1000 * watchdog_ms).min(self.silence_most_us) {
            device.stood_still();
        }
        self.hear(call.now_us);
        self.watch(call.now_us);
        // Trouble does not wait until a tick is due, nor does a place beyond a limit. A robot brakes tick by tick.
        let takes_motion = self.takes_motion();
        if call.is_tick || trouble.is_some() && !takes_motion {
            self.tick(&call);
        } else if !takes_motion {
            self.device.get_mut().look();
        }
        let device = self.device.get_mut();
        let output = device.hardware().output();
        self.handle.tell(device.status());
        self.speak();
        output
    }

    fn takes_motion(&self) -> bool {
        self.device.borrow().hardware().takes_motion()
    }

    fn sense(&mut self, force_n: &[f64; 3]) {
        self.device.get_mut().hardware_mut().senses(force_n);
    }

    fn period_us(&self) -> u64 {
        self.clock.period_us
    }
}
