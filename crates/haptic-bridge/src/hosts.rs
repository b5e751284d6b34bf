//! One host at a time over TCP, as a line that does not wait.

use std::io::{self, ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};

#[derive(Debug)]
pub(crate) struct Hosts {
    listener: TcpListener,
    host: Option<TcpStream>,
}

impl Hosts {
    pub(crate) fn listen(address: &str) -> io::Result<Self> {
        let listener = TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        Ok(Self {
            listener,
            host: None,
        })
    }

    pub(crate) fn address(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// The next one that waits to be let in.
    fn admit(&mut self) -> io::Result<&mut TcpStream> {
        let (host, _) = self.listener.accept()?;
        host.set_nonblocking(true)?;
        // A sample is worth more now than with the next.
        host.set_nodelay(true)?;
        Ok(self.host.insert(host))
    }
}

impl Read for Hosts {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let host = match &mut self.host {
            Some(host) => host,
            None => self.admit()?,
        };
        match host.read(into) {
            Err(error) if error.kind() == ErrorKind::WouldBlock => Err(error),
            Err(error) if error.kind() == ErrorKind::Interrupted => Err(error),
            Ok(0) | Err(_) => {
                // It has gone; the next may come.
                self.host = None;
                Err(ErrorKind::NotConnected.into())
            }
            Ok(count) => Ok(count),
        }
    }
}

impl Write for Hosts {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let host = self.host.as_mut().ok_or(ErrorKind::NotConnected)?;
        host.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
