//! What a fault says of the trial that it ended.

use haptic_link::Limits;
use haptic_loop::Fault;

/// What a fault says of the trial that it ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meaning {
    /// The wall moved the device beyond a limit: it is no stable one.
    Answer,
    /// Host, line or tick was late: nothing is known of the wall.
    Unjudged,
    /// Somebody pressed the emergency stop, or a sensor, an actuator or the board failed: nothing is known of the wall, and nobody but
    /// a person arms the device again.
    Ends,
}

impl Meaning {
    /// Of each fault.
    pub(super) const fn of(fault: Fault) -> Self {
        match fault {
            Fault::Workspace | Fault::Velocity => Self::Answer,
            Fault::HostSilent | Fault::TickOverrun | Fault::StaleForce => Self::Unjudged,
            // And what this program does not know.
            _ => Self::Ends,
        }
    }
}

/// What can be done about a limit that ended a trial.
pub(super) fn remedy(fault: Fault, set: &Limits) -> String {
    let Limits {
        workspace_low_m,
        workspace_high_m,
        speed_hard_m_per_s,
        ..
    } = set;
    match fault {
        Fault::Workspace => format!(
            "set more room than {workspace_low_m} m to {workspace_high_m} m on the device (`host-cli device set`), hold it in the \
             middle, or push less"
        ),
        _ => format!(
            "set more than {speed_hard_m_per_s} m/s on the device (`host-cli device set`), or push less"
        ),
    }
}
