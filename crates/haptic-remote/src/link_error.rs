//! Errors of a host with its device, in one line each.

use crate::Impossible;
use core::fmt;
use haptic_link::{FaultReport, Keys, LineCounters, Refusal};
use haptic_loop::Fault;

/// An error that ends the conversation.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum LinkError {
    /// No answer, after several tries.
    NoAnswer {
        /// Name of the request.
        request: &'static str,
        /// Frames that came instead, from the second try on.
        line: LineCounters,
    },
    /// The device refused.
    Refused {
        /// Name of the request.
        request: &'static str,
        /// Why.
        refusal: Refusal,
    },
    /// The device speaks another version of the protocol.
    OtherVersion {
        /// Its version.
        version: u8,
    },
    /// The port echoes what it is sent.
    Echo,
    /// The device defines a message differently.
    OtherMessages {
        /// Its firmware version.
        firmware: [u8; 3],
        /// Name of the first such message.
        message: &'static str,
    },
    /// A fault latched on the device.
    Faulted(FaultReport),
    /// The device has dropped this connection.
    Rebooted,
    /// Samples and answers stopped for this long.
    NoSamples {
        /// Waited, ms.
        waited_ms: u64,
    },
    /// Samples stopped for this long although the device answers; it was told to let go.
    HeldUp {
        /// Waited, ms.
        waited_ms: u64,
    },
    /// Stopped before any sample came.
    Stopped,
    /// An impossible sample. The device was told to let go.
    Impossible(Impossible),
    /// The device reports an impossible ability.
    Capability {
        /// In words.
        what: &'static str,
        /// The reported value.
        value: f32,
    },
    /// The device runs no controllers.
    NoControllers,
    /// The device renders no shape.
    NoSurfaces,
    /// The line is gone.
    Gone,
}

impl fmt::Display for LinkError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoAnswer { request, line } => {
                write!(f, "no answer to \"{request}\": ")?;
                explain_silence(f, request, line)
            }
            Self::Refused { request, refusal } => {
                write!(f, "the device refused \"{request}\": ")?;
                explain_refusal(f, refusal)
            }
            Self::OtherVersion { version } => write!(
                f,
                "the device speaks protocol version {version}, this program {}: flash its firmware",
                haptic_link::PROTOCOL_VERSION
            ),
            Self::Echo => {
                f.write_str("the port echoes what it is sent: there is no device behind it")
            }
            Self::OtherMessages {
                firmware: [major, minor, patch],
                message,
            } => write!(
                f,
                "the device has firmware {major}.{minor}.{patch}, with another \"{message}\": flash this version"
            ),
            Self::Faulted(report) => match Fault::from_code(report.status.fault) {
                Some(fault) => write!(f, "the device latched a fault at tick {}: {fault}", report.tick),
                None => write!(
                    f,
                    "the device latched fault {}, which this program does not know, at tick {}",
                    report.status.fault, report.tick
                ),
            },
            Self::Rebooted => f.write_str(
                "the device dropped this connection: it was reset, or another program has it; connect again",
            ),
            Self::NoSamples { waited_ms } => write!(
                f,
                "no sample for {waited_ms} ms, and the device does not answer: check its plug and supply, then reset \
                 it"
            ),
            Self::HeldUp { waited_ms } => write!(
                f,
                "no sample for {waited_ms} ms, though the device answers: close other programs on this machine, or \
                 use a better line"
            ),
            Self::Stopped => f.write_str("stopped without a sample: check the device, then start again"),
            Self::Impossible(impossible) => write!(
                f,
                "the device reported the impossible, {impossible}, and was told to let go: check its sensor and firmware"
            ),
            Self::Capability { what, value } => write!(
                f,
                "the device reports an impossible {what} of {value}: flash its firmware again"
            ),
            Self::NoControllers => f.write_str(
                "the device runs no controller by itself: flash a firmware of this version that does, or take another board",
            ),
            Self::NoSurfaces => f.write_str(
                "the device renders no shape by itself: flash a firmware of this version, or close the loop on the host",
            ),
            Self::Gone => f.write_str("the line is gone: check the plug and supply of the device"),
        }
    }
}

impl core::error::Error for LinkError {}

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

fn explain_silence(f: &mut fmt::Formatter<'_>, request: &str, line: &LineCounters) -> fmt::Result {
    match line {
        LineCounters {
            received: 0,
            corrupt,
            oversize,
            ..
        } if corrupt + oversize > 0 => f.write_str(
            "only garbage came; is this the right port and baud rate, and is the device flashed?",
        ),
        LineCounters { received: 0, .. } if request != "hello" => {
            f.write_str("nothing came: check its plug and supply, then reset it")
        }
        LineCounters { received: 0, .. } => f.write_str(
            "nothing came; is this the right port, and is the device switched on and flashed?",
        ),
        _ => f.write_str(
            "other frames came, so the line works: close other programs, or reset the device",
        ),
    }
}

fn explain_refusal(f: &mut fmt::Formatter<'_>, refusal: &Refusal) -> fmt::Result {
    match refusal {
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
                (false, false) if least.0 > -f32::MAX => write!(f, "a number of at least {least}"),
                (false, false) => f.write_str("a finite number"),
            }?;
            f.write_str(" on this device")
        }
        Refusal::Digest => f.write_str("the parameters were damaged on the way; try again"),
        Refusal::Incomplete => f.write_str("some of the parameters did not arrive; try again"),
        Refusal::Unsupported(field) => {
            write!(f, "this board does not support this {field}")
        }
        Refusal::UnknownFault => {
            f.write_str("a fault has latched in the meantime; look at its cause, then arm again")
        }
        Refusal::ForceNotZero => f.write_str("the force has not fallen to zero yet; try again"),
        Refusal::ForceNotSmall {
            wanted_n,
            allowed_n,
        } => write!(
            f,
            "at this position the force would start at {wanted_n} N, above {allowed_n} N: move it out of contact first"
        ),
        Refusal::FaultPersists(code) => match Fault::from_code(*code) {
            Some(fault @ (Fault::PositionJump | Fault::EncoderWire | Fault::Reset)) => write!(
                f,
                "{fault}, and with that the device lost its zero: put it at its zero, then switch it off and on"
            ),
            Some(fault) => write!(f, "{fault}; fix that first"),
            None => write!(f, "the cause of fault {code} is still there"),
        },
        Refusal::Connection => {
            f.write_str("it was reset, or another program has connected or armed it; connect again")
        }
        Refusal::Looser(field) => write!(
            f,
            "{field} is looser than set on the device, and a run may only tighten it: set it there first"
        ),
    }
}

/// Checks that a device of so many axes has every message of this program for it, in the same form.
///
/// # Errors
/// [`LinkError::OtherMessages`].
pub fn check_keys(keys: &Keys, axes: u8, firmware: [u8; 3]) -> Result<(), LinkError> {
    match keys.first_unlike(axes) {
        None => Ok(()),
        Some(message) => Err(LinkError::OtherMessages { firmware, message }),
    }
}
