//! Opening an Inverse3: the service is asked for its version, the device is found, its filters are set, and read back.

use super::{
    hardware::{Inverse3, Socket},
    in_time::{InTime, PATIENCE},
    name::Inverse3Name,
    trouble::{Inverse3OpenError, Inverse3Trouble},
    wire::{PRESET, opening, position},
};
use haptic_loop::realtime::Moment;
use haptic_quantity::short;
use serde_json::Value;
use std::{
    io::{Error, ErrorKind, Read, Write},
    net::{TcpStream, ToSocketAddrs as _},
    time::Duration,
};
use tungstenite::{Error as Failed, HandshakeError, Message, protocol::WebSocketConfig};

/// Time for which a read waits before the clock is checked again.
const LOOK: Duration = Duration::from_millis(20);
/// More than any answer of a service.
const BYTES_MOST: usize = 1 << 20;
/// More than an answer of one device, which is read in a tick.
const READ_AT_ONCE: usize = 4096;
/// Answers in which the settings may come to be what was asked for.
const ATTEMPTS: u32 = 25;

/// Words of a service, in one line that a terminal can show.
fn cut(reply: &str) -> String {
    short(reply).replace(char::is_control, " ")
}

impl Inverse3Name {
    /// Connects to the service, and opens its device with D axes, one or three. `notice` is what a user should know of it.
    pub(crate) fn open<const D: usize>(
        &self,
        notice: &mut Option<String>,
    ) -> Result<Inverse3<TcpStream, D>, Inverse3OpenError> {
        if D > 1 && self.chooses_line() {
            return Err(Inverse3OpenError::Line);
        }
        let failed = |error| self.no_service(error);
        let began = Moment::now();
        let left = move || PATIENCE.saturating_sub(began.elapsed());
        let stream = self.connect(left).map_err(failed)?;
        self.check_version(InTime::new(stream, move || left().is_zero()))?;
        let stream = self.connect(left).map_err(failed)?;
        stream.set_nodelay(true).map_err(failed)?;
        let (device, greeting) = Inverse3::greet(stream, self, move || left().is_zero())?;
        (device.stream().set_nonblocking(true)).map_err(failed)?;
        *notice = Some(greeting);
        Ok(device)
    }

    /// Says why there is no answer: none came in time, or the system's words.
    fn no_service(&self, error: Error) -> Inverse3OpenError {
        let address = self.address.clone();
        if error.kind() == ErrorKind::TimedOut {
            return Inverse3OpenError::Slow { address };
        }
        Inverse3OpenError::NoService { address, error }
    }

    /// Says why a WebSocket failed: its time was over, or else this.
    fn slow_or(&self, error: &Failed, otherwise: Inverse3OpenError) -> Inverse3OpenError {
        if let Failed::Io(error) = error
            && error.kind() == ErrorKind::TimedOut
        {
            let address = self.address.clone();
            return Inverse3OpenError::Slow { address };
        }
        otherwise
    }

    fn not_service(&self, reply: &str) -> Inverse3OpenError {
        Inverse3OpenError::NotService {
            address: self.address.clone(),
            reply: cut(reply).chars().take(60).collect(),
        }
    }

    /// Tries all addresses of the host in the time that is left.
    fn connect(&self, left: impl Fn() -> Duration) -> Result<TcpStream, Error> {
        let mut failed = Error::from(ErrorKind::AddrNotAvailable);
        for address in self.address.to_socket_addrs()? {
            let left = left();
            if left.is_zero() {
                return Err(ErrorKind::TimedOut.into());
            }
            match TcpStream::connect_timeout(&address, left) {
                Ok(stream) => {
                    stream.set_read_timeout(Some(LOOK))?;
                    return Ok(stream);
                }
                Err(error) => failed = error,
            }
        }
        Err(failed)
    }

    /// Asks over HTTP for the version, and refuses a service whose messages are not those of 3.5.
    ///
    /// # Errors
    /// No service, or one of another version.
    pub fn check_version<S: Read + Write>(
        &self,
        mut stream: InTime<S>,
    ) -> Result<(), Inverse3OpenError> {
        let failed = |error| self.no_service(error);
        let host = &self.address;
        let asked = format!("GET /version HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n");
        stream.write_all(asked.as_bytes()).map_err(failed)?;
        let (mut answer, mut bytes) = (Vec::new(), [0; READ_AT_ONCE]);
        loop {
            let read = match stream.read(&mut bytes) {
                // One that fails after it has said something has ended there.
                Err(error) if answer.is_empty() || error.kind() == ErrorKind::TimedOut => {
                    return Err(failed(error));
                }
                read => &bytes[..read.unwrap_or(0)],
            };
            answer.extend(read);
            // A server may leave the connection open: it has said all once its object is whole.
            if read.contains(&b'}')
                && let Some(version) = version(&answer)
            {
                return is_known(&version);
            }
            if read.is_empty() || answer.len() > BYTES_MOST {
                let answer = String::from_utf8_lossy(&answer);
                return Err(self.not_service(answer.lines().next().unwrap_or_default()));
            }
        }
    }

    /// The device of an inventory: that of the name, or the only one.
    fn chosen<'a>(&self, inventory: &'a Value) -> Result<&'a Value, Inverse3OpenError> {
        let devices = inventory["inverse3"].as_array();
        let devices = devices.ok_or(Inverse3Trouble::Unreadable)?;
        let known: Vec<&str> = devices.iter().map(id_of).collect();
        let reason = match (&self.id, known.as_slice()) {
            (_, []) => return Err(Inverse3OpenError::NoDevice),
            (None, [_]) => return Ok(&devices[0]),
            (None, _) => "which Inverse3 is not said".to_owned(),
            (Some(id), _) => format!("there is no Inverse3 `{id}`"),
        };
        let wanted = self.id.as_deref();
        let mut found = devices.iter().zip(&known);
        let found = found.find(|(_, id)| Some(**id) == wanted);
        found.map(|(device, _)| device).ok_or_else(|| {
            let known = cut(&known.join(", "));
            Inverse3OpenError::Which { reason, known }
        })
    }
}

fn id_of(device: &Value) -> &str {
    device["device_id"].as_str().unwrap_or_default()
}

/// The version in an answer over HTTP.
fn version(answer: &[u8]) -> Option<String> {
    let answer = String::from_utf8_lossy(answer);
    let first = answer.lines().next()?;
    if !(first.starts_with("HTTP/1.") && first.contains(" 200 ")) {
        return None;
    }
    // A length in front of it, if it comes in chunks.
    let body = answer.get(answer.find('{')?..=answer.rfind('}')?)?;
    let body: Value = serde_json::from_str(body).ok()?;
    Some(body["project_version"].as_str()?.to_owned())
}

/// Refuses a version whose messages are not those of 3.5.
fn is_known(found: &str) -> Result<(), Inverse3OpenError> {
    let mut numbers = found.split('.').map_while(|part| part.parse::<u32>().ok());
    let version = (numbers.next().unwrap_or(0), numbers.next().unwrap_or(0));
    if ((3, 5)..(4, 0)).contains(&version) {
        return Ok(());
    }
    let found = cut(found);
    Err(Inverse3OpenError::Version { found })
}

fn heard<S: Read + Write>(
    socket: &mut Socket<S>,
    name: &Inverse3Name,
) -> Result<String, Inverse3OpenError> {
    for _ in 0..ATTEMPTS {
        match socket.read() {
            Ok(Message::Text(text)) => return Ok(text.as_str().to_owned()),
            Ok(Message::Close(_)) => return Err(Inverse3Trouble::Gone.into()),
            Err(error) => return Err(name.slow_or(&error, Inverse3Trouble::Gone.into())),
            Ok(_) => {}
        }
    }
    Err(Inverse3Trouble::Unreadable.into())
}

impl<S: Read + Write, const D: usize> Inverse3<S, D> {
    /// Opens a device of the service at the other end of a stream, whose reads may wait meanwhile and must not afterwards. There
    /// is no force meanwhile. Ends without a device once `is_late` says so. The words are what a user should know of it.
    ///
    /// # Errors
    /// No service of these messages, or one that is too slow; no such device, or one that is not ready; settings that it does not
    /// take.
    pub fn greet(
        stream: S,
        name: &Inverse3Name,
        is_late: impl Fn() -> bool + Send + 'static,
    ) -> Result<(Self, String), Inverse3OpenError> {
        let config = WebSocketConfig::default().max_message_size(Some(BYTES_MOST));
        // It clears its buffer at each read.
        let config = config.read_buffer_size(READ_AT_ONCE);
        let url = format!("ws://{}/", name.address);
        let stream = InTime::new(stream, is_late);
        let (mut socket, _) = tungstenite::client::client_with_config(url, stream, Some(config))
            .map_err(|error| match error {
                HandshakeError::Failure(error) => {
                    name.slow_or(&error, name.not_service(&error.to_string()))
                }
                HandshakeError::Interrupted(_) => name.not_service("nothing"),
            })?;
        let parsed =
            |text: &str| serde_json::from_str(text).map_err(|_| Inverse3Trouble::Unreadable);
        let inventory: Value = parsed(&heard(&mut socket, name)?)?;
        let device = name.chosen(&inventory)?;
        let id = id_of(device).to_owned();
        for (key, why) in [
            (
                "power_supply",
                "has no power for its motors: plug in its supply",
            ),
            (
                "calibrated",
                "is not calibrated: put its cursor where the maker's guide says",
            ),
        ] {
            if device["status"][key] == false {
                return Err(Inverse3OpenError::NotReady { id: cut(&id), why });
            }
        }
        let mut attempts = 1;
        loop {
            let sent = socket.send(Message::text(opening(&id)));
            sent.map_err(|error| name.slow_or(&error, Inverse3Trouble::Gone.into()))?;
            let text = heard(&mut socket, name)?;
            let full: Value = parsed(&text)?;
            let devices = full["inverse3"].as_array().into_iter().flatten();
            let mut devices = devices.filter(|device| id_of(device) == id);
            let config = &devices.next().ok_or(Inverse3Trouble::Vanished)?["config"];
            match not_taken(config) {
                None => {
                    let gate = words_of_gate(&config["filters"]["force_gate"]["gain"]);
                    let place_m = position(&text, &id)?;
                    socket.get_mut().no_longer_limited();
                    return Ok((Self::new(socket, &id, name, place_m), gate));
                }
                Some(error) if attempts == ATTEMPTS => return Err(error),
                Some(_) => attempts += 1,
            }
        }
    }
}

/// The setting that is not what was asked for.
fn not_taken(config: &Value) -> Option<Inverse3OpenError> {
    let damping = &config["filters"]["damping"]["scalar"];
    let (setting, value) = if config["preset"] != PRESET {
        ("preset", &config["preset"])
    } else if damping.as_f64() != Some(0.0) {
        ("damping", damping)
    } else {
        return None;
    };
    let value = cut(&value.to_string());
    Some(Inverse3OpenError::NotTaken { setting, value })
}

fn words_of_gate(gain: &Value) -> String {
    let gain = cut(&gain.to_string());
    format!(
        "the Inverse Service's force gate has gain {gain}: while it sees an oscillation it lowers the force, which no log shows; \
         this program leaves it, and has set the service's damping to 0"
    )
}
