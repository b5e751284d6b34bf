//! TCP as a line: addresses by name, connecting to one, and listening at one.
//!
//! The frames are those of a serial port. Nothing is encrypted and nobody is asked for a password: whoever reaches the address can move the
//! device, so that it belongs on the loopback or a trusted network.

use super::{
    error::SerialError,
    line::Line,
    listening::{Door, Greeting, Listening},
    socket::{Socket, prompt},
};
use std::{
    boxed::Box,
    format, io,
    net::{SocketAddr, TcpListener, TcpStream, ToSocketAddrs as _},
    string::{String, ToString as _},
    sync::Arc,
    time::Duration,
    vec::Vec,
};

/// Before the address in the path of a line.
const SCHEME: &str = "tcp:";
/// Time for one address of a name to answer.
const CONNECT: Duration = Duration::from_secs(2);

/// The address in a path `tcp:HOST:PORT`; `None` for any other path.
#[must_use]
pub fn tcp_address(path: &str) -> Option<&str> {
    path.strip_prefix(SCHEME)
}

/// Host and port of `HOST:PORT`; an IPv6 address stands in brackets.
///
/// # Errors
/// [`SerialError::Address`].
pub fn host_and_port(address: &str) -> Result<(&str, u16), SerialError> {
    let parsed = address.rsplit_once(':').and_then(|(host, port)| {
        let inner = host
            .strip_prefix('[')
            .and_then(|rest| rest.strip_suffix(']'));
        let is_name = |name: &str| !name.is_empty() && !name.contains(['[', ']', '/', ' ', '@']);
        let host = match inner {
            Some(numbers) => Some(numbers).filter(|numbers| numbers.contains(':')),
            None => Some(host).filter(|name| !name.contains(':')),
        };
        Some((host.filter(|host| is_name(host))?, port.parse().ok()?))
    });
    let address = address.to_string();
    parsed.ok_or(SerialError::Address { address })
}

/// The addresses of a name, of which there may be several.
fn addresses(host: &str, port: u16) -> Result<Vec<SocketAddr>, String> {
    match (host, port).to_socket_addrs() {
        Ok(found) => Ok(found.collect()),
        Err(error) => Err(format!("the name {host} has no address ({error})")),
    }
}

/// Connects to the first address that answers.
pub(super) fn connect(
    path: &str,
    address: &str,
    patience: Duration,
) -> Result<Socket<TcpStream>, SerialError> {
    let (host, port) = host_and_port(address)?;
    let unreachable = |why| SerialError::Unreachable {
        path: path.to_string(),
        why,
    };
    let mut tried = Vec::new();
    for address in addresses(host, port).map_err(unreachable)? {
        let stream = TcpStream::connect_timeout(&address, CONNECT);
        match stream.and_then(|stream| Socket::new(prompt(stream)?, patience)) {
            Ok(socket) => return Ok(socket),
            Err(error) => tried.push(format!("{address}: {error}")),
        }
    }
    Err(unreachable(tried.join(", ")))
}

/// The listening side of a TCP line, for a device. Who greets first is served; see [`line`](Self::line).
///
/// ```
/// use haptic_remote::serial::TcpListening;
/// use std::io::{Read as _, Write as _};
///
/// // A protocol of another maker, whose greeting is any byte.
/// let listening = TcpListening::for_any_protocol("127.0.0.1:0")?;
/// let mut device = listening.line();
/// let mut host = haptic_remote::serial::open(&listening.path(), 460_800)?;
/// host.write_all(b"hello")?;
/// let (mut bytes, mut heard) = ([0; 16], Vec::new());
/// while heard.len() < 5 {
///     // Fails with TimedOut after 20 ms without a byte, and while nobody is there.
///     if let Ok(count) = device.read(&mut bytes) {
///         heard.extend_from_slice(&bytes[..count]);
///     }
/// }
/// assert_eq!(heard, b"hello");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct TcpListening {
    door: Arc<Door>,
    address: SocketAddr,
}

impl TcpListening {
    /// Listens at `HOST:PORT`; with port 0 at a free one. A host greets with `hello`.
    ///
    /// # Errors
    /// [`SerialError::Address`], [`SerialError::Listen`].
    pub fn open(address: &str) -> Result<Self, SerialError> {
        Self::with(address, Greeting::Hello)
    }

    /// Listens for hosts of a protocol that it does not know, who greet with any byte.
    ///
    /// # Errors
    /// As [`open`](Self::open).
    pub fn for_any_protocol(address: &str) -> Result<Self, SerialError> {
        Self::with(address, Greeting::Anything)
    }

    fn with(address: &str, greeting: Greeting) -> Result<Self, SerialError> {
        let (host, port) = host_and_port(address)?;
        let refused = |reason| SerialError::Listen {
            address: address.to_string(),
            reason,
        };
        let addresses = addresses(host, port).map_err(refused)?;
        let listened = |error: io::Error| refused(error.to_string());
        let listener = TcpListener::bind(&addresses[..]).map_err(listened)?;
        listener.set_nonblocking(true).map_err(listened)?;
        Ok(Self {
            address: listener.local_addr().map_err(listened)?,
            door: Arc::new(Door::new(listener, greeting)),
        })
    }

    /// The address, with the port that was free.
    #[must_use]
    pub const fn address(&self) -> SocketAddr {
        self.address
    }

    /// The path by which a host of this machine [opens](super::open) it.
    #[must_use]
    pub fn path(&self) -> String {
        format!("{SCHEME}{}", self.address)
    }

    /// The device's end. It serves one host at a time, who may come and go:
    ///
    /// - *A stranger*, who has not greeted, does not block others, even among a hundred: the first to greet is served.
    /// - *A second one* gets a notice that the device is busy and with whom, then is disconnected. If the first has said nothing for
    ///   2 s, it has vanished, as our own hosts speak several times a second; then the second takes its place.
    /// - *Nobody there*: a read fails with [`TimedOut`](io::ErrorKind::TimedOut) within 5 ms, a write with
    ///   [`NotConnected`](io::ErrorKind::NotConnected).
    #[must_use]
    pub fn line(&self) -> Box<dyn Line> {
        Box::new(Listening::new(&self.door))
    }
}
