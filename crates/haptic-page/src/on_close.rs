//! The end of the page that holds the controls.

use haptic_experiment::Named;

/// What happens to a loop or a run when the page that controls it is closed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OnClose {
    /// The force falls to zero and it ends.
    #[default]
    Stop,
    /// It goes on; the next page that takes the controls has it.
    Continue,
}

impl Named for OnClose {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Stop, "stop", "The force falls to zero and it ends"),
        (
            Self::Continue,
            "continue",
            "It goes on; the next page that takes the controls has it",
        ),
    ];
}
