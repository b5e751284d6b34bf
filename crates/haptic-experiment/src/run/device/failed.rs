//! A device that failed, as the failure of a run: with its port, and by whom it is to be mended.

use crate::document::failure::Failure;
use crate::run::ending::LetGo;
use haptic_loop::Fault;
use haptic_remote::LinkError;
use haptic_remote::serial::{BoardTrouble, SerialError, SerialLink, TroubleCause};

/// A serial device that cannot be used, with its port: exit code 3. A fault that latched on it has ended a run: exit code 1.
#[must_use]
pub fn at_port(path: &str, error: &SerialError) -> Failure {
    let text = error.to_string();
    let error_at = if text.contains(path) {
        anyhow::anyhow!("{text}")
    } else {
        anyhow::anyhow!("{path}: {text}")
    };
    match error {
        SerialError::Link(LinkError::Faulted(_) | LinkError::Impossible(_)) => {
            Failure::Run(error_at)
        }
        _ => Failure::Device(error_at),
    }
}

/// What a device refused is bad input, unless it is only because of where it stands or of a fault that persists; else as [`at_port`].
#[must_use]
pub fn refused_at_port(path: &str, error: SerialError) -> Failure {
    match error.is_refusal() && !error.is_of_its_state() {
        true => Failure::bad_input(error),
        false => at_port(path, &error),
    }
}

/// The failure of a device that was connected. Where nothing comes from its board any more, that is what failed, whatever latched or was
/// refused after it: exit code 3.
#[must_use]
pub(crate) fn at_link(link: &SerialLink, failure: Failure) -> Failure {
    match lost_board(link) {
        Some(words) => Failure::Device(anyhow::anyhow!("{}: {words}", link.path())),
        None => failure,
    }
}

/// Words of a board from which nothing comes any more, and what is to be feared of it.
#[must_use]
pub fn lost_board(link: &SerialLink) -> Option<String> {
    link.lost_board().map(|words| feared(&words))
}

/// Words of a board about its last fault; of one that failed with what is to be feared of it.
#[must_use]
pub fn trouble(link: &SerialLink) -> Option<String> {
    let BoardTrouble { words, cause } = link.trouble()?;
    // A fault that nobody has heard of yet is no fault of the status.
    let failed = link.status().fault == Fault::BoardFailed.code() || cause == TroubleCause::Gone;
    Some(match failed {
        true => feared(&words),
        false => words,
    })
}

fn feared(words: &str) -> String {
    format!("{words}; {}", LetGo::Told.words())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_ends_a_run_and_a_silent_port_is_not_usable() {
        let report = crate::run::ending::reported(haptic_loop::Fault::BoardFailed);
        let failure = |error: LinkError| at_port("/dev/x", &error.into());
        let faulted = failure(LinkError::Faulted(report));
        assert_eq!(faulted.exit_code(), 1);
        assert!(faulted.to_string().starts_with("/dev/x: "), "{faulted}");
        assert_eq!(failure(LinkError::Gone).exit_code(), 3);
    }

    #[test]
    fn a_device_that_stands_in_the_wall_is_no_bad_input() {
        use haptic_link::Refusal;
        let code = |refusal| {
            let request = "start";
            let error = LinkError::Refused { request, refusal };
            refused_at_port("/dev/x", error.into()).exit_code()
        };
        let too_deep = Refusal::ForceNotSmall {
            wanted_n: 5.0,
            allowed_n: 1.0,
        };
        assert_eq!(code(too_deep), 3);
        assert_eq!(code(Refusal::FaultPersists(4)), 3);
        assert_eq!(code(Refusal::Incomplete), 2);
    }
}
