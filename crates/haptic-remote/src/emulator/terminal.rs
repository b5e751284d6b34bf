//! The pseudo-terminal that stands for the port of a device.

use super::error::EmulatorError;
use crate::serial::Line;
use serialport::{SerialPort, TTYPort};
use std::borrow::ToOwned as _;
use std::boxed::Box;
use std::fmt;
use std::format;
use std::path::{Path, PathBuf};
use std::string::ToString as _;
use std::time::Duration;

/// A pseudo-terminal that a host can open.
#[derive(Debug)]
pub struct Terminal {
    master: TTYPort,
    /// Kept, so that a host may come and go.
    _slave: TTYPort,
    path: PathBuf,
    link: Option<PathBuf>,
}

impl Terminal {
    /// Makes one, with a symbolic link to it if asked for.
    ///
    /// # Errors
    /// If the system gives none, or the link cannot be made.
    pub fn open(link: Option<&Path>) -> Result<Self, EmulatorError> {
        let failed = |what: &str, error: &dyn fmt::Display| {
            EmulatorError::Terminal(format!("{what}: {error}"))
        };
        let (mut master, slave) =
            TTYPort::pair().map_err(|error| failed("no pseudo-terminal to be had", &error))?;
        // So that the reader thread notices the end.
        master
            .set_timeout(Duration::from_millis(20))
            .map_err(|error| failed("the pseudo-terminal does not take a timeout", &error))?;
        let name = slave.name();
        let path = name.ok_or_else(|| failed("the pseudo-terminal", &"it has no name"))?;
        let path = PathBuf::from(path);
        if let Some(link) = link {
            std::os::unix::fs::symlink(&path, link).map_err(|error| EmulatorError::Link {
                link: link.to_owned(),
                error,
            })?;
        }
        Ok(Self {
            master,
            _slave: slave,
            path,
            link: link.map(Path::to_owned),
        })
    }

    /// Path that a host opens.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.link.as_deref().unwrap_or(&self.path)
    }
}

impl Terminal {
    /// Our end, for a device that is emulated elsewhere.
    ///
    /// # Errors
    /// It cannot be shared.
    pub fn line(&self) -> Result<Box<dyn Line>, EmulatorError> {
        let port: Box<dyn SerialPort> = Box::new(self.share()?);
        Ok(Box::new(port))
    }

    /// A second handle on our end.
    pub(super) fn share(&self) -> Result<TTYPort, EmulatorError> {
        let port = self.master.try_clone_native();
        port.map_err(|error| EmulatorError::Terminal(error.to_string()))
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        if let Some(link) = &self.link {
            // It leads nowhere from now on; nothing to be done if it is gone already.
            let _ = std::fs::remove_file(link);
        }
    }
}
