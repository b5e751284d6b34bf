//! Devices of other makers by name, and opening one.

use crate::{
    haply::{HaplyName, HaplyOpenError, HaplyPlane},
    inverse3::{Inverse3Name, Inverse3OpenError},
    moteus::{MoteusName, MoteusOpenError, MoteusTrouble},
    name::NameError,
};
use haptic_remote::serial::{SerialError, SerialLink, ServeError, Served, unless_stopped};
use std::{
    fmt,
    str::FromStr,
    sync::{Arc, atomic::AtomicBool},
};
use thiserror::Error;

/// A device of another maker by name: `KIND:PATH[,key=value]…`.
///
/// *A new kind* takes three things: a module with its name, read by `Settings`; a
/// [`ServedHardware`](haptic_remote::serial::ServedHardware), whose reads and writes are called once a tick and whose force
/// is a [`SafeForce`](haptic_loop::SafeForce) already; and a variant here, with a row in [`KINDS`](Self::KINDS) and an arm in
/// [`open_with`](Self::open_with). The loop, limits, watchdog, flight recorder, log, page and commands come with it.
///
/// ```no_run
/// use haptic_devices::ForeignName;
///
/// let name: ForeignName = "haply:/dev/ttyACM0,version=3".parse()?;
/// let link = name.open_with(1, &|warning| eprintln!("{warning}"), None)?;
/// println!("{}", link.capabilities().board());
/// // The force falls to zero and the board is let go.
/// drop(link);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ForeignName {
    /// `haply:PATH[,version=2|3][,axis=x|y|-x|-y][,zero=LENGTH][,home=now|before]`.
    Haply(HaplyName),
    /// `moteus:PATH[,id=1][,radius=LENGTH][,torque_limit=0.1][,watchdog=TIME][,lost=4]`.
    Moteus(MoteusName),
    /// `inverse3:[HOST[:PORT]][,id=ID][,axis=x|y|z|-x|-y|-z][,lost=20]`.
    Inverse3(Inverse3Name),
}

impl ForeignName {
    /// Each kind with the form of its name.
    pub const KINDS: &'static [(&'static str, &'static str)] = &[
        (HaplyName::KIND, HaplyName::FORM),
        (MoteusName::KIND, MoteusName::FORM),
        (Inverse3Name::KIND, Inverse3Name::FORM),
    ];

    /// True if a name begins with one of these kinds.
    #[must_use]
    pub fn is_kind(text: &str) -> bool {
        let kind = text.split(':').next().unwrap_or_default();
        Self::KINDS.iter().any(|(known, _)| *known == kind)
    }

    /// Opens the device with this number of axes, looks at its first answers, serves it on a thread of this process, and connects to
    /// that. `warn` receives notices for the user. Setting `stop` ends it at once, and later each wait for an answer.
    ///
    /// # Errors
    /// A port that cannot be opened, a device that does not answer or answers what cannot be; more axes than it has; a stop.
    pub fn open_with(
        &self,
        axes: usize,
        warn: &dyn Fn(&str),
        stop: Option<&Arc<AtomicBool>>,
    ) -> Result<SerialLink, OpenError> {
        let name = self.clone();
        let (served, notices) = unless_stopped(stop, move || name.served(axes))??;
        notices.iter().for_each(|notice| warn(notice));
        Ok(SerialLink::to_served(served, &self.to_string())?.stopped_by(stop))
    }

    /// The device behind a thread, and what a user should know of it.
    fn served(&self, axes: usize) -> Result<(Served, Option<String>), OpenError> {
        let mut notice = None;
        let served = match (self, axes) {
            (Self::Haply(name), 1) => Served::start(name.open::<1>()?)?,
            (Self::Haply(name), 2) => Served::start(name.open::<2>()?)?,
            (Self::Moteus(name), 1) => Served::start(name.open()?)?,
            (Self::Inverse3(name), 1) => Served::start(name.open::<1>(&mut notice)?)?,
            (Self::Inverse3(name), 3) => Served::start(name.open::<3>(&mut notice)?)?,
            (Self::Haply(_), _) => return Err(OpenError::Axes { axes, most: 2 }),
            (Self::Inverse3(_), _) => return Err(OpenError::Axes { axes, most: 3 }),
            (Self::Moteus(_), _) => return Err(OpenError::Axes { axes, most: 1 }),
        };
        Ok((served, notice))
    }

    /// True of one that may stand beside others at its port.
    #[must_use]
    pub const fn shares_port(&self) -> bool {
        match self {
            Self::Moteus(_) => true,
            Self::Haply(_) | Self::Inverse3(_) => false,
        }
    }

    /// The plane of a device that moves in a plane; `None` for others.
    #[must_use]
    pub const fn plane(&self) -> Option<HaplyPlane> {
        match self {
            Self::Haply(name) => Some(HaplyPlane::of(name.version.model())),
            Self::Moteus(_) | Self::Inverse3(_) => None,
        }
    }
}

impl FromStr for ForeignName {
    type Err = NameError;

    fn from_str(text: &str) -> Result<Self, NameError> {
        let (kind, rest) = text.split_once(':').unwrap_or((text, ""));
        match kind {
            HaplyName::KIND => HaplyName::parse(rest).map(Self::Haply),
            MoteusName::KIND => MoteusName::parse(rest).map(Self::Moteus),
            Inverse3Name::KIND => Inverse3Name::parse(rest).map(Self::Inverse3),
            _ => {
                let known: Vec<&str> = Self::KINDS.iter().map(|(known, _)| *known).collect();
                Err(NameError::Kind {
                    kind: kind.to_owned(),
                    known: known.join(", "),
                })
            }
        }
    }
}

impl fmt::Display for ForeignName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Haply(name) => name.fmt(f),
            Self::Moteus(name) => name.fmt(f),
            Self::Inverse3(name) => name.fmt(f),
        }
    }
}

/// A device of another maker that cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum OpenError {
    /// The Haply 2DIY.
    #[error(transparent)]
    Haply(#[from] HaplyOpenError),
    /// A moteus servo or its adapter is in trouble.
    #[error(transparent)]
    Moteus(#[from] MoteusOpenError),
    /// The Inverse Service or a device of it.
    #[error(transparent)]
    Inverse3(#[from] Inverse3OpenError),
    /// The device has fewer axes than are needed.
    #[error("it has {most} {}, but {axes} are needed: change `axes`, or use another device", if *most == 1 { "axis" } else { "axes" })]
    Axes {
        /// Number of axes that were asked for.
        axes: usize,
        /// Number of axes that the device has.
        most: usize,
    },
    /// No thread could serve it, or it refuses the first configuration.
    #[error(transparent)]
    Serve(#[from] ServeError),
    /// It does not answer as a device does.
    #[error(transparent)]
    Link(#[from] SerialError),
}

impl OpenError {
    /// True if the name or the number of axes is wrong, whatever is at the port.
    #[must_use]
    pub const fn is_of_the_request(&self) -> bool {
        matches!(
            self,
            Self::Axes { .. }
                | Self::Haply(HaplyOpenError::Line)
                | Self::Moteus(MoteusOpenError::Settings(_))
                | Self::Inverse3(Inverse3OpenError::Line | Inverse3OpenError::Which { .. })
        )
    }

    /// True if another attempt may help: the port or the device is not there yet, or somebody else has it. A device that a busy
    /// machine serves late is as silent as one without power.
    #[must_use]
    pub const fn may_pass(&self) -> bool {
        use SerialError::{InUse, NotFound, Unreachable};
        matches!(
            self,
            Self::Haply(
                HaplyOpenError::Mute { .. }
                    | HaplyOpenError::Port(NotFound { .. } | InUse { .. } | Unreachable { .. })
            ) | Self::Moteus(
                MoteusOpenError::Trouble(MoteusTrouble::Gone | MoteusTrouble::Silent { .. })
                    | MoteusOpenError::Port(NotFound { .. } | InUse { .. } | Unreachable { .. })
            ) | Self::Link(_)
                | Self::Inverse3(
                    Inverse3OpenError::NoService { .. }
                        | Inverse3OpenError::Slow { .. }
                        | Inverse3OpenError::NoDevice
                )
        )
    }
}
