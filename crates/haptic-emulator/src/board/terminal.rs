//! The pseudo-terminal that stands for the port of a device.

use super::error::EmulatorError;
use haptic_remote::serial::Line;
use serialport::{SerialPort, TTYPort};
use std::{
    fmt,
    path::{Path, PathBuf},
    time::Duration,
};

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
    /// Opens a pseudo-terminal, with a symbolic link to it if requested. An old link that leads to
    /// no pseudo-terminal is replaced; any other existing file is kept.
    ///
    /// # Errors
    /// If the system gives none, or the link cannot be made.
    pub fn open(link: Option<&Path>) -> Result<Self, EmulatorError> {
        let failed = |what: &str, error: &dyn fmt::Display| {
            EmulatorError::Terminal(format!("{what}: {error}"))
        };
        let (mut master, slave) =
            TTYPort::pair().map_err(|error| failed("no pseudo-terminal to be had", &error))?;
        // A timeout lets the reader thread notice the end.
        master
            .set_timeout(Duration::from_millis(20))
            .map_err(|error| failed("the pseudo-terminal does not take a timeout", &error))?;
        let name = slave.name();
        let path = name.ok_or_else(|| failed("the pseudo-terminal", &"it has no name"))?;
        let path = PathBuf::from(path);
        if let Some(link) = link {
            if is_stale(link, &path) {
                // If it stays, the new one cannot be made, and that error is reported.
                let _ = std::fs::remove_file(link);
            }
            std::os::unix::fs::symlink(&path, link).map_err(|error| EmulatorError::Path {
                path: link.to_owned(),
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

    /// Our end, for the device.
    ///
    /// # Errors
    /// It cannot be shared.
    pub fn line(&self) -> Result<Box<dyn Line>, EmulatorError> {
        let port = self.master.try_clone_native();
        let port = port.map_err(|error| EmulatorError::Terminal(error.to_string()))?;
        let port: Box<dyn SerialPort> = Box::new(port);
        Ok(Box::new(port))
    }
}

/// True for a link to a pseudo-terminal that is gone, or to the new one: then it was that of somebody who had its number before.
fn is_stale(link: &Path, new: &Path) -> bool {
    let Ok(target) = std::fs::read_link(link) else {
        return false;
    };
    target.parent() == new.parent() && (target == new || !target.exists())
}

impl Drop for Terminal {
    fn drop(&mut self) {
        if let Some(link) = &self.link
            && std::fs::read_link(link).is_ok_and(|target| target == self.path)
        {
            // It leads nowhere from now on; nothing to be done if it is gone already.
            let _ = std::fs::remove_file(link);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn a_link_that_leads_nowhere_gives_way_and_nothing_else_does() {
        let folder = std::env::temp_dir().join(format!("terminal-links-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let link = folder.join("device");
        let is_linked = || std::fs::symlink_metadata(&link).is_ok();
        let terminal = Terminal::open(None).expect("a pseudo-terminal");
        let gone = terminal.path().with_file_name("4294967295");
        symlink(&gone, &link).expect("a link");
        {
            let first = Terminal::open(Some(&link)).expect("the dead one gives way");
            assert_eq!(first.path(), link);
            Terminal::open(Some(&link)).expect_err("the living one stays");
            assert!(is_linked());
        }
        assert!(!is_linked(), "gone with its terminal");
        for foreign in [folder.join("nowhere"), folder.clone()] {
            symlink(&foreign, &link).expect("a link");
            Terminal::open(Some(&link)).expect_err("it is somebody else's");
            assert_eq!(std::fs::read_link(&link).expect("a link"), foreign);
            std::fs::remove_file(&link).expect("goes");
        }
        std::fs::write(&link, "data").expect("a file");
        Terminal::open(Some(&link)).expect_err("it is a file");
        assert_eq!(std::fs::read(&link).expect("a file"), b"data");
        std::fs::remove_dir_all(&folder).expect("goes");
    }
}
