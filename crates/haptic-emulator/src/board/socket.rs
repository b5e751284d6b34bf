//! The Unix socket that stands for the port of a device.

use super::error::EmulatorError;
use haptic_remote::serial::{Line, listen_at};
use std::io::{self, ErrorKind};
use std::os::unix::fs::FileTypeExt as _;
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::{Path, PathBuf};

/// A Unix socket that one host at a time can open. Bytes arrive at once; a pseudo-terminal passes
/// them through a system worker, which a busy machine may delay for seconds.
#[derive(Debug)]
pub struct Socket {
    listener: UnixListener,
    path: PathBuf,
}

impl Socket {
    /// Makes a socket. An old socket without a listener is replaced; any other existing file is
    /// kept.
    ///
    /// # Errors
    /// If it cannot be made.
    pub fn open(path: &Path) -> Result<Self, EmulatorError> {
        if is_abandoned(path) {
            // If it does not go, the new one cannot be made, which is told.
            let _ = std::fs::remove_file(path);
        }
        let made = listening(path);
        let path = path.to_owned();
        match made {
            Ok(listener) => Ok(Self { listener, path }),
            Err(error) => Err(EmulatorError::Path {
                kind: "socket",
                path,
                error,
            }),
        }
    }

    /// Path that a host opens.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Our end.
    ///
    /// # Errors
    /// It cannot be shared.
    pub fn line(&self) -> Result<Box<dyn Line>, EmulatorError> {
        let line = self.listener.try_clone().and_then(listen_at);
        line.map_err(|error| EmulatorError::Terminal(error.to_string()))
    }
}

/// True for a socket at which nobody listens.
fn is_abandoned(path: &Path) -> bool {
    let file = std::fs::symlink_metadata(path);
    let refused = |error: io::Error| error.kind() == ErrorKind::ConnectionRefused;
    file.is_ok_and(|file| file.file_type().is_socket())
        && UnixStream::connect(path).is_err_and(refused)
}

/// A socket that gets its name when somebody listens at it, unless something else has the name.
fn listening(path: &Path) -> io::Result<UnixListener> {
    let mut unnamed = path.as_os_str().to_owned();
    unnamed.push(format!(".{}", std::process::id()));
    let listener = UnixListener::bind(&unnamed)?;
    let named = std::fs::hard_link(&unnamed, path);
    std::fs::remove_file(&unnamed)?;
    named?;
    Ok(listener)
}

impl Drop for Socket {
    fn drop(&mut self) {
        // It leads nowhere from now on; nothing to be done if it is gone already.
        let _ = std::fs::remove_file(&self.path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hosts_come_and_go_and_only_an_abandoned_socket_gives_way() {
        let folder = std::env::temp_dir().join(format!("sockets-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        let path = folder.join("device");
        // One at which nobody listens any more.
        drop(UnixListener::bind(&path).expect("a socket"));
        let socket = Socket::open(&path).expect("the abandoned one gives way");
        Socket::open(&path).expect_err("the living one stays");
        let mut device = socket.line().expect("a line");
        let mut bytes = [0; 16];
        assert!(device.write(b"to nobody").is_err());
        for word in [b"first", b"other"] {
            let name = path.to_string_lossy();
            let mut host = haptic_remote::serial::open(&name, 460_800).expect("opens");
            assert!(
                host.read(&mut bytes)
                    .is_err_and(|error| error.kind() == ErrorKind::TimedOut)
            );
            host.write_all(word).expect("writes");
            let mut heard: Vec<u8> = Vec::new();
            while heard.len() < word.len() {
                if let Ok(count) = device.read(&mut bytes) {
                    heard.extend(&bytes[..count]);
                }
            }
            assert_eq!(heard[..], word[..], "nothing of the host before");
            device
                .share()
                .expect("shared")
                .write_all(word)
                .expect("somebody is there");
            host.read_exact(&mut bytes[..word.len()]).expect("comes");
            assert_eq!(&bytes[..word.len()], word);
        }
        drop((device, socket));
        assert!(!path.exists(), "gone with its device");
        std::fs::write(&path, "data").expect("a file");
        Socket::open(&path).expect_err("it is a file");
        assert_eq!(std::fs::read(&path).expect("a file"), b"data");
        std::fs::remove_dir_all(&folder).expect("goes");
    }
}
