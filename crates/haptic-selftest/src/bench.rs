//! The device under test: limited before anything else, put to rest between its trials.

use super::fall::Bounds;
use super::promise::{Attendant, EmergencyStop, Notice, Promise, SelfTest};
use haptic_document::Failure;
use haptic_link::{
    Configuration, Limits, LoopMode, Refusal, Scope, Simulation, SimulationKind, Start, State,
};
use haptic_loop::Fault;
use haptic_loop::realtime::Moment;
use haptic_remote::LinkError;
use haptic_remote::serial::{SerialError, SerialLink, TroubleCause};
use haptic_run::{at_port, lost_board};
use std::sync::atomic::Ordering;
use std::time::Duration;

/// Ticks in which the limit of the rate lets the force rise from zero to its limit.
const RISE_TICKS: f32 = 10.0;
/// Watchdog of trials in which nobody is silent on purpose, ms: as long as a host that is killed may leave a force anywhere.
pub(super) const LONG_WATCHDOG_MS: u16 = LoopMode::Device.watchdog_ms();
/// Ticks after which a run ends by itself, even without the host.
const TICKS_MOST: u32 = 100_000;

#[derive(Debug)]
pub(super) enum Broken {
    Link(SerialError),
    /// A fault after which nobody but a person arms the device again, in words.
    Fault(String),
    Interrupted,
}

impl From<SerialError> for Broken {
    fn from(error: SerialError) -> Self {
        Self::Link(error)
    }
}

pub(super) struct Bench<'a> {
    link: Option<SerialLink>,
    pub(super) test: SelfTest,
    attendant: Attendant<'a>,
    /// Configuration that was set to last before the test, with its coefficients.
    pub(super) set: (Configuration, Vec<f32>),
    pub(super) limited: Configuration,
    /// The axis that a trial drives; the others get no force.
    pub(super) axis: usize,
    run: u32,
    /// Why the device let go of an attempt at a promise: this machine was silent or late.
    pub(super) late: Option<String>,
    /// The limit of the device that ended a trial of an attempt.
    pub(super) left: Option<String>,
    /// Faults of the device before the test.
    faults: u16,
}

impl<'a> Bench<'a> {
    /// Reads what is set, and limits the device.
    pub(super) fn new(
        link: SerialLink,
        test: SelfTest,
        attendant: Attendant<'a>,
    ) -> Result<Self, Failure> {
        let set = (link.configuration()).map_err(|error| at_port(link.path(), &error))?;
        let limited = limited(&link, &test, &set.0);
        let path = link.path().to_owned();
        let faults = link.status().faults;
        let mut bench = Self {
            link: Some(link),
            test,
            attendant,
            set,
            limited,
            axis: 0,
            run: 0,
            late: None,
            left: None,
            faults,
        };
        let taken = bench.limit(LONG_WATCHDOG_MS);
        taken.map_err(|error| at_port(&path, &error))?;
        Ok(bench)
    }

    pub(super) fn bounds(&self) -> Bounds {
        Bounds {
            limits: self.limited.limits,
            period_s: f64::from(self.limited.tick_period_us) * 1e-6,
        }
    }

    pub(super) fn trying(&self, promise: Promise) -> Result<(), Broken> {
        self.notice(Notice::Trying(promise));
        self.goes_on()
    }

    pub(super) fn notice(&self, notice: Notice) {
        (self.attendant.notice)(notice);
    }

    pub(super) fn goes_on(&self) -> Result<(), Broken> {
        if self.attendant.stop.load(Ordering::Relaxed) {
            return Err(Broken::Interrupted);
        }
        Ok(())
    }

    /// Says that the device is silent, and asks on.
    pub(super) fn answers_on(&self) -> Result<bool, Broken> {
        self.goes_on()?;
        self.notice(Notice::Silent);
        let answers = self.link()?.answers_again();
        self.goes_on()?;
        Ok(answers)
    }

    pub(super) fn has_emergency_stop(&self) -> Result<bool, SerialError> {
        Ok(match self.test.emergency_stop {
            EmergencyStop::AsTheDevice => !self.link()?.capabilities().simulated,
            EmergencyStop::Absent => false,
            EmergencyStop::Pressed => true,
        })
    }

    pub(super) fn link(&self) -> Result<&SerialLink, SerialError> {
        self.link.as_ref().ok_or(LinkError::Gone.into())
    }

    pub(super) fn link_mut(&mut self) -> Result<&mut SerialLink, SerialError> {
        self.link.as_mut().ok_or(LinkError::Gone.into())
    }

    /// Closes the link and connects anew, for 10 s at most; the error of the last attempt.
    pub(super) fn reconnect(&mut self) -> Result<Result<Duration, Failure>, Broken> {
        const PATIENCE: Duration = Duration::from_secs(10);
        self.link = None;
        let began = Moment::now();
        loop {
            self.goes_on()?;
            match (self.attendant.connect)() {
                Ok(link) => {
                    self.link = Some(link);
                    return Ok(Ok(began.elapsed()));
                }
                Err(error) if began.elapsed() > PATIENCE => return Ok(Err(error)),
                Err(_) => std::thread::sleep(Duration::from_millis(50)),
            }
        }
    }

    /// Words of a board from which nothing comes any more, and what is to be feared of it.
    pub(super) fn lost_board(&self) -> Option<String> {
        lost_board(self.link.as_ref()?)
    }

    /// Puts the limits of the test in force, with this watchdog.
    pub(super) fn limit(&mut self, watchdog_ms: u16) -> Result<(), SerialError> {
        self.limited.limits.watchdog_ms = watchdog_ms;
        let limited = self.limited;
        self.link_mut()?.set_for(limited, &[0.0], Scope::Run)
    }

    /// The refusal of a run with more force than is set on the device; `None` if it was taken.
    pub(super) fn loosen(&mut self) -> Result<Option<String>, SerialError> {
        let mut looser = self.limited;
        looser.limits.force_n = 2.0 * self.set.0.limits.force_n;
        let taken = self.link_mut()?.set_for(looser, &[0.0], Scope::Run);
        let refused = refusal(taken)?;
        let watchdog_ms = self.limited.limits.watchdog_ms;
        self.limit(watchdog_ms)?;
        Ok(refused.map(|_| format!("{} N refused", looser.limits.force_n)))
    }

    pub(super) fn start(&mut self) -> Result<Option<LinkError>, SerialError> {
        self.run += 1;
        let start = Start {
            run: self.run,
            ticks: TICKS_MOST,
            every: 1,
            batch: 1,
        };
        refusal(self.link_mut()?.start(start))
    }

    /// Arms the device, and waits until it says so. Keep-alives ask for it, fast at first: an answer counts only if it
    /// comes before the next one is asked for.
    pub(super) fn arm(&self) -> Result<(), SerialError> {
        let link = self.link()?;
        let most_ms = u64::from(self.limited.limits.watchdog_ms) / 4;
        for (interval_ms, times) in [(20, 10), (50, 20), (100, 20)] {
            let interval_ms = most_ms.clamp(1, interval_ms);
            // An armed device stays armed.
            link.arm(Duration::from_millis(4 * interval_ms))?;
            for _ in 0..times {
                if link.status().state == State::Armed || link.is_stopped() {
                    return Ok(());
                }
                std::thread::sleep(Duration::from_millis(interval_ms));
            }
        }
        Ok(())
    }

    pub(super) fn calm(&self) -> Result<(), SerialError> {
        let link = self.link()?;
        link.disarm()?;
        link.wait_for_rest();
        Ok(())
    }

    /// Fails once a fault has ended the test.
    pub(super) fn is_well(&self) -> Result<(), Broken> {
        let link = self.link()?;
        let status = link.status();
        let latched = status.state == State::Fault && status.faults != self.faults;
        match self.ends(status.fault).filter(|_| latched) {
            None => Ok(()),
            Some(fault) => {
                let of_board = link.trouble().map(|trouble| trouble.words);
                let of_program = || status.reason.some().map(|reason| reason.to_string());
                let words = of_board
                    .or_else(of_program)
                    .map(|words| format!(": {words}"));
                let (code, words) = (fault.code(), words.unwrap_or_default());
                Err(Broken::Fault(format!("fault {code}, {fault}{words}")))
            }
        }
    }

    /// The fault of this code, if it ends the test. A board that said nothing may have been asked too late, or be lost: that is judged
    /// elsewhere.
    fn ends(&self, code: u8) -> Option<Fault> {
        let fault = Fault::from_code(code).filter(|fault| ends_the_test(*fault))?;
        let trouble = self.link().ok()?.trouble();
        let by_itself = fault != Fault::BoardFailed
            || trouble.is_none_or(|trouble| trouble.cause == TroubleCause::Board);
        by_itself.then_some(fault)
    }

    pub(super) fn arm_for_trial(&self) -> Result<(), Broken> {
        self.is_well()?;
        let Err(error) = self.arm() else {
            return Ok(());
        };
        if let SerialError::Link(LinkError::Refused { refusal, .. }) = &error {
            if let Refusal::FaultPersists(code) = refusal
                && self.ends(*code).is_some()
            {
                return Err(Broken::Fault(error.to_string()));
            }
            if *refusal == Refusal::UnknownFault {
                // The news of which one it is are on their way here.
                for _ in 0..50 {
                    self.is_well()?;
                    self.goes_on()?;
                    std::thread::sleep(Duration::from_millis(20));
                }
            }
        }
        Err(error.into())
    }
}

/// True for a fault after which nobody but a person arms the device again: its emergency stop, or a fault of its electronics.
pub(super) const fn ends_the_test(fault: Fault) -> bool {
    matches!(
        fault,
        Fault::EmergencyStop
            | Fault::CurrentMismatch
            | Fault::Reset
            | Fault::PositionStuck
            | Fault::PositionJump
            | Fault::BoardFailed
            | Fault::EncoderWire
            | Fault::ForceSensor
            | Fault::HandForce
            | Fault::Following
            | Fault::HandEnergy
    )
}

/// The refusal of a request, also by a fault that has latched before it; any other error is passed on.
pub(super) fn refusal(asked: Result<(), SerialError>) -> Result<Option<LinkError>, SerialError> {
    match asked {
        Ok(()) => Ok(None),
        Err(SerialError::Link(refused @ (LinkError::Refused { .. } | LinkError::Faulted(_)))) => {
            Ok(Some(refused))
        }
        Err(error) => Err(error),
    }
}

/// A loop on the host without an environment, with the limits of the test or those that are set where these are tighter.
fn limited(link: &SerialLink, test: &SelfTest, set: &Configuration) -> Configuration {
    let can = link.capabilities();
    let most = can.tick_period_max_us;
    let period_us = test.period_us.max(can.tick_period_min_us).min(most);
    let force_n = (test.force_limit_n as f32).min(can.force_max_n);
    let rate = force_n / (RISE_TICKS * period_us as f32 * 1e-6);
    let asked = Configuration {
        loop_mode: LoopMode::Host,
        tick_period_us: period_us,
        limits: Limits {
            force_n,
            force_rate_n_per_s: rate.min(can.force_rate_max_n_per_s),
            watchdog_ms: LONG_WATCHDOG_MS,
            // A machine or line that is slow breaks no promise of the device.
            late_ticks: 0,
            max_age_ticks: Limits::MAX_AGE_TICKS,
            rise_time_s: 0.0,
            brake_force_n: 0.0,
            ..Limits::DEFAULT
        },
        simulation: match (can.simulated, set.simulation.kind) {
            // A plant to move, as a real device has one.
            (true, SimulationKind::Real) => Simulation::TESTBED,
            _ => set.simulation,
        },
        ..Configuration::PASSIVE
    };
    let (limits, _) = asked.tightened(set);
    Configuration { limits, ..asked }
}
