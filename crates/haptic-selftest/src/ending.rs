//! Faults that end a trial or the whole test, and say nothing of a promise.

use super::bench::{Bench, Broken};
use super::followed::Followed;
use super::promise::Check;
use haptic_experiment::parameters::FORCE_LIMIT;
use haptic_link::{Refusal, State};
use haptic_loop::Fault;
use haptic_remote::LinkError;
use haptic_remote::serial::{SerialError, TroubleCause};
use std::time::Duration;

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
    )
}

/// Rows of a trial that a limit of the device ended, in these words: what looks broken is not judged.
pub(super) fn within_limits(rows: Vec<Check>, left: Option<String>) -> Vec<Check> {
    let Some(why) = left.filter(|_| rows.iter().all(|check| !check.certain)) else {
        return rows;
    };
    let judged = |check: Check| match check.ok {
        Some(false) => check.spoiled(&why),
        _ => check,
    };
    rows.into_iter().map(judged).collect()
}

impl Followed {
    /// The limit of the device that ended it, in words; `None` if none did.
    pub(super) fn left_limits(&self) -> Option<String> {
        let fault = Fault::from_code(self.fault?.status.fault)?;
        let advice = match fault {
            Fault::Workspace => "set a wider workspace (`host-cli device set`)",
            Fault::Velocity => "set a higher speed limit (`host-cli device set`)",
            _ => return None,
        };
        Some(format!(
            "a limit of the device ended the trial ({fault}): {advice}, or test with a smaller {FORCE_LIMIT}"
        ))
    }
}

impl Bench<'_> {
    /// Goes on only while no fault has ended the test, since it began.
    ///
    /// # Errors
    /// One has.
    pub(super) fn is_well(&self) -> Result<(), Broken> {
        let link = self.link()?;
        let status = link.status();
        let latched = status.state == State::Fault && status.faults != self.faults_before();
        match self.ends(status.fault).filter(|_| latched) {
            None => Ok(()),
            Some(fault) => {
                let words = link
                    .trouble()
                    .map_or_else(String::new, |trouble| format!(": {}", trouble.words));
                let code = fault.code();
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

    /// Arms for a trial.
    ///
    /// # Errors
    /// A fault has ended the test, or its cause is still there.
    pub(super) fn arm_for_trial(&self) -> Result<(), Broken> {
        self.is_well()?;
        let Err(error) = self.arm() else {
            return Ok(());
        };
        let SerialError::Link(LinkError::Refused { refusal, .. }) = &error else {
            return Err(error.into());
        };
        match refusal {
            Refusal::FaultPersists(code) if self.ends(*code).is_some() => {
                return Err(Broken::Fault(error.to_string()));
            }
            // Which one is on its way here.
            Refusal::UnknownFault => {
                for _ in 0..50 {
                    self.is_well()?;
                    std::thread::sleep(Duration::from_millis(20));
                }
            }
            _ => {}
        }
        Err(error.into())
    }
}
