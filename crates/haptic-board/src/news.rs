//! Log for a developer with a probe: changes of state and faults, written by the main loop.

use haptic_link::{Reason, State, Status, Trouble};
use haptic_loop::Fault;

#[derive(Debug)]
pub(crate) struct News {
    known: Status,
}

impl News {
    pub(crate) const fn new() -> Self {
        Self {
            known: Status {
                state: State::Idle,
                fault: 0,
                faults: 0,
                reason: Reason::of(Trouble::Nothing),
            },
        }
    }

    pub(crate) fn tell(&mut self, status: Status) {
        let known = core::mem::replace(&mut self.known, status);
        if status.faults != known.faults {
            match Fault::from_code(status.fault) {
                Some(fault) => {
                    defmt::error!(
                        "fault {=u8}: {}",
                        status.fault,
                        defmt::Display2Format(&fault)
                    );
                }
                None => defmt::error!("{=u16} faults, cleared already", status.faults),
            }
        }
        if status.state != known.state {
            defmt::info!("now {}", defmt::Display2Format(&status.state));
        }
    }
}
