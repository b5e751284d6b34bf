//! The reasons for which the safety chain gives up.

/// Why the chain holds the force at zero. The numbers are those of the wire and of the log.
///
/// The chain itself latches [`NonFiniteForce`](Self::NonFiniteForce), [`Workspace`](Self::Workspace),
/// [`Velocity`](Self::Velocity), [`PositionStuck`](Self::PositionStuck) and [`PositionJump`](Self::PositionJump);
/// the others are found elsewhere and handed to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
#[repr(u8)]
pub enum Fault {
    /// The wanted force was NaN or infinite, or so was a position that a limit or guard needs.
    NonFiniteForce = 1,
    /// A device whose force depends on the host heard nothing from it for the watchdog time.
    HostSilent = 2,
    /// A tick took longer than its period, or began a whole period late.
    TickOverrun = 3,
    /// The emergency stop is open.
    EmergencyStop = 4,
    /// The measured current does not follow the commanded one.
    CurrentMismatch = 5,
    /// The device left its workspace: a position beyond [`Workspace::low`](crate::Workspace::low) or
    /// [`high`](crate::Workspace::high) on some axis.
    Workspace = 6,
    /// The device moved too fast: an estimated speed above [`Limits::speed`](crate::Limits::speed) on some
    /// axis. A position that jumps is a speed too.
    Velocity = 7,
    /// The hardware watchdog reset the device while it was armed.
    Reset = 8,
    /// The position stands still while the force on the device grows: see [`Stuck`](crate::Stuck).
    PositionStuck = 9,
    /// The position moved in a tick by more than [`Limits::jump`](crate::Limits::jump) beyond what the speed limit
    /// allows.
    PositionJump = 10,
    /// The host of a host loop sent a force that answers a sample too many ticks ago.
    StaleForce = 11,
    /// The device failed to measure or to apply: a board of another maker did not answer in time, answered what cannot be, or reports a
    /// fault of its own; a [`Device`](crate::Device) gave an error.
    BoardFailed = 12,
}

impl Fault {
    /// Every fault, in the order of the codes.
    pub const ALL: [Self; 12] = [
        Self::NonFiniteForce,
        Self::HostSilent,
        Self::TickOverrun,
        Self::EmergencyStop,
        Self::CurrentMismatch,
        Self::Workspace,
        Self::Velocity,
        Self::Reset,
        Self::PositionStuck,
        Self::PositionJump,
        Self::StaleForce,
        Self::BoardFailed,
    ];

    /// True if a damper can still oppose the motion: it needs its sensor and its actuator.
    pub(crate) const fn leaves_braking(self) -> bool {
        !matches!(
            self,
            Self::CurrentMismatch | Self::PositionStuck | Self::PositionJump | Self::BoardFailed
        )
    }

    /// The code on the wire and in the log, from 1.
    #[must_use]
    pub const fn code(self) -> u8 {
        self as u8
    }

    /// The fault with this code.
    #[must_use]
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|fault| fault.code() == code)
    }
}

impl core::fmt::Display for Fault {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::NonFiniteForce => "the wanted force was not a finite number",
            Self::HostSilent => "the device heard nothing from the host for the watchdog time",
            Self::TickOverrun => "a tick of the loop was a whole period late",
            Self::EmergencyStop => "the emergency stop is open",
            Self::CurrentMismatch => "the measured current does not follow the commanded one",
            Self::Workspace => "the device left its workspace",
            Self::Velocity => "the device moved faster than its limit",
            Self::Reset => "the device was reset by its hardware watchdog",
            Self::PositionStuck => "the position stands still while the force on the device grows",
            Self::PositionJump => "the position jumped by more than the speed limit allows",
            Self::StaleForce => "the host sent a force for a sample too many ticks ago",
            Self::BoardFailed => "the board was silent, implausible or in a fault of its own",
        })
    }
}
