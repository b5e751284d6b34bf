//! Errors of a host with its device, in one line each.

use crate::Impossible;
use core::fmt;
use haptic_link::{Conduct, FaultReport, Keys, LineCounters, Refusal};
use haptic_loop::Fault;
use thiserror::Error;

/// An error that ends the conversation.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum LinkError {
    /// No answer, after several tries.
    #[error("no answer to \"{request}\": {}", silence(request, line))]
    NoAnswer {
        /// Name of the request, as in the protocol.
        request: &'static str,
        /// Frames that came instead, from the second try on.
        line: LineCounters,
    },
    /// The device refused a request and gave its reason.
    #[error("the device refused \"{request}\": {}", Explained(refusal))]
    Refused {
        /// Name of the request, as in the protocol.
        request: &'static str,
        /// Reason that the device gave for it.
        refusal: Refusal,
    },
    /// The device speaks another version of the protocol.
    #[error(
        "the device speaks protocol version {version}, this program {}: flash its firmware",
        haptic_link::PROTOCOL_VERSION
    )]
    OtherVersion {
        /// Version of the protocol that the device speaks.
        version: u8,
    },
    /// The port echoes what it is sent.
    #[error("the port echoes what it is sent: there is no device behind it")]
    Echo,
    /// The device defines a message differently.
    #[error(
        "the device has firmware {}.{}.{}, whose \"{message}\" differs: flash this version",
        firmware[0], firmware[1], firmware[2]
    )]
    OtherMessages {
        /// Version of its firmware: major, minor, patch.
        firmware: [u8; 3],
        /// Name of the first such message.
        message: &'static str,
    },
    /// A fault latched on the device.
    #[error("the device latched {}", Latched(.0))]
    Faulted(FaultReport),
    /// The device has dropped this connection.
    #[error(
        "the device dropped this connection: it was reset, or another program has it; connect again"
    )]
    Rebooted,
    /// Samples and answers stopped for this long.
    #[error(
        "no sample for {waited_ms} ms, and the device does not answer: check its plug and supply, then reset it"
    )]
    NoSamples {
        /// Time waited without success, ms.
        waited_ms: u64,
    },
    /// Samples stopped for this long although the device answers; it was ordered to let go.
    #[error(
        "no sample for {waited_ms} ms, though the device answers: close other programs on this machine, or use a better line"
    )]
    HeldUp {
        /// Time waited without success, ms.
        waited_ms: u64,
    },
    /// The device's own program ended the run: it called `hb_stop`.
    #[error("stopped by the program of the device")]
    Withdrawn,
    /// Somebody else ended the run.
    #[error("another program stopped the device")]
    Disarmed,
    /// Stopped before any sample came.
    #[error("stopped without a sample: check the device, then start again")]
    Stopped,
    /// An impossible sample. The device was ordered to let go.
    #[error(
        "the device reported something impossible, {0}, and was ordered to let go: {remedy}",
        remedy = .0.remedy()
    )]
    Impossible(Impossible),
    /// The device reports an impossible ability.
    #[error("the device reports an impossible {what} of {value}: flash its firmware again")]
    Capability {
        /// Ability in words, with its unit.
        what: &'static str,
        /// Value as the device has reported it.
        value: f32,
    },
    /// The device runs no controllers.
    #[error(
        "the device cannot run a controller on its own: flash firmware of this version that can, or use another board"
    )]
    NoControllers,
    /// The device renders no shape.
    #[error(
        "the device cannot render a shape on its own: flash firmware of this version, or close the loop on the host"
    )]
    NoSurfaces,
    /// The device moves, and nobody has judged its motion.
    #[error(
        "the device moves instead of pushing, and nothing is known of its motion: give device_model=robot.toml, a file with [admittance], its bandwidth_hz and dead_time_s"
    )]
    UnknownRobot,
    /// The device moves, and its own loop is not known.
    #[error(
        "the robot's bandwidth_hz and dead_time_s are not known: find them with host-cli device measure, and give its program a file that has them"
    )]
    UnmeasuredRobot,
    /// The port or its other end is gone.
    #[error("the connection is gone: check the device's power supply, and its plug or network")]
    Gone,
}

impl LinkError {
    /// The refusal of a device that moves, by a host that knows nothing of its motion.
    #[must_use]
    pub const fn of_robot(conduct: Conduct) -> Self {
        if conduct.to_measure {
            Self::UnmeasuredRobot
        } else {
            Self::UnknownRobot
        }
    }
}

/// A number in single precision with few digits, as `fracdiff::parameter::Shown` has one in double.
struct Short(f32);

impl fmt::Display for Short {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0.abs() {
            size if size == 0.0 || !size.is_finite() || (1e-6..1e6).contains(&size) => {
                self.0.fmt(f)
            }
            _ => fmt::LowerExp::fmt(&self.0, f),
        }
    }
}

const fn silence(request: &str, line: &LineCounters) -> &'static str {
    if line.received > 0 {
        "other frames came, so the line works: close other programs, or reset the device"
    } else if line.corrupt > 0 || line.oversize > 0 {
        "only garbage came; is this the right port and baud rate, and is the device flashed?"
    } else if matches!(request.as_bytes(), b"hello") {
        "nothing came; is this the right port, and is the device switched on and flashed?"
    } else {
        "nothing came: check its plug and supply, then reset it"
    }
}

/// A fault as a device has reported it, and its tick.
struct Latched<'a>(&'a FaultReport);

impl fmt::Display for Latched<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let FaultReport { status, tick, .. } = self.0;
        match Fault::from_code(status.fault) {
            Some(fault) => write!(f, "a fault at tick {tick}: {fault}")?,
            None => write!(
                f,
                "fault {}, which this program does not know, at tick {tick}",
                status.fault
            )?,
        }
        match status.reason.some() {
            Some(reason) => write!(f, "; {reason}"),
            None => Ok(()),
        }
    }
}

/// A refusal in words, with its remedy.
struct Explained<'a>(&'a Refusal);

impl fmt::Display for Explained<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Refusal::State(state) => write!(f, "not while it is {state}"),
            Refusal::Range {
                field,
                value,
                least,
                most,
            } => {
                let open = *least > 0.0 && *least <= f32::MIN_POSITIVE;
                let bounded = *most < f32::MAX;
                let [value, least, most] = [*value, *least, *most].map(|x| Short(field.shown(x)));
                write!(f, "{field} {value} is not ")?;
                match (open, bounded) {
                    (true, true) => write!(f, "in (0, {most}]"),
                    (false, true) => write!(f, "in [{least}, {most}]"),
                    (true, false) => f.write_str("above 0"),
                    (false, false) if least.0 > -f32::MAX => {
                        write!(f, "a number of at least {least}")
                    }
                    (false, false) => f.write_str("a finite number"),
                }?;
                f.write_str(" on this device: change it")
            }
            Refusal::Digest => f.write_str("the parameters were damaged on the way; try again"),
            Refusal::Incomplete => f.write_str("some of the parameters did not arrive; try again"),
            Refusal::Unsupported(field) => {
                write!(f, "this board does not support this {field}")
            }
            Refusal::UnknownFault => f.write_str(
                "a fault has latched in the meantime; look at its cause, then arm again",
            ),
            Refusal::ForceNotZero => f.write_str("the force has not fallen to zero yet; try again"),
            Refusal::ForceNotSmall {
                wanted_n,
                allowed_n,
            } => write!(
                f,
                "at this position the force would start at {wanted_n} N, above {allowed_n} N: move it out of contact first, or to 0 m where the law has no outside"
            ),
            Refusal::FaultPersists(code) => match Fault::from_code(*code) {
                Some(fault @ (Fault::PositionJump | Fault::EncoderWire | Fault::Reset)) => write!(
                    f,
                    "{fault}, and with that the device lost its zero: put it at its zero, then switch it off and on"
                ),
                Some(fault) => write!(f, "{fault}; fix that first"),
                None => write!(f, "the cause of fault {code} is still there"),
            },
            Refusal::Connection => f.write_str(
                "it was reset, or another program has connected or armed it; connect again",
            ),
            Refusal::Looser(field) => write!(
                f,
                "{field} is looser than set on the device, and a run may only tighten it: set it there first"
            ),
        }
    }
}

/// Checks that a device with this many axes has the same definition of every message that this
/// program sends it.
///
/// # Errors
/// [`LinkError::OtherMessages`].
pub fn check_keys(keys: &Keys, axes: u8, firmware: [u8; 3]) -> Result<(), LinkError> {
    match keys.first_unlike(axes) {
        None => Ok(()),
        Some(message) => Err(LinkError::OtherMessages { firmware, message }),
    }
}
