//! Opening an Inverse3: the service is asked for its version, the device is found, its filters are set, and read back.

use super::hardware::{Inverse3, Socket};
use super::name::Inverse3Name;
use super::trouble::{Inverse3OpenError, Trouble};
use super::wire::{PRESET, opening, position};
use haptic_quantity::short;
use serde_json::Value;
use std::io::{Error, ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs as _};
use std::time::Duration;
use tungstenite::Message;
use tungstenite::protocol::WebSocketConfig;

/// A service on this machine answers in a millisecond; more than this is silence.
const PATIENCE: Duration = Duration::from_secs(5);
/// More than any answer of a service.
const BYTES_MOST: usize = 1 << 20;
/// More than an answer of one device, which is read in a tick.
const READ_AT_ONCE: usize = 4096;
/// Answers in which the settings may come to be what was asked for.
const ATTEMPTS: u32 = 25;

impl Inverse3Name {
    /// Connects to the service, and opens its device with D axes, one or three. What a user should know of it is told to `warn`.
    pub(crate) fn open<const D: usize>(
        &self,
        warn: &dyn Fn(&str),
    ) -> Result<Inverse3<TcpStream, D>, Inverse3OpenError> {
        if D > 1 && self.chooses_line() {
            return Err(Inverse3OpenError::Line);
        }
        let failed = |error| self.no_service(error);
        check_version(&self.ask_version()?)?;
        let stream = self.connect().map_err(failed)?;
        stream.set_nodelay(true).map_err(failed)?;
        let (device, told) = Inverse3::greet(stream, self)?;
        (device.stream().set_nonblocking(true)).map_err(failed)?;
        warn(&told);
        Ok(device)
    }

    fn no_service(&self, error: Error) -> Inverse3OpenError {
        let address = self.address.clone();
        Inverse3OpenError::NoService { address, error }
    }

    fn not_service(&self, said: &str) -> Inverse3OpenError {
        Inverse3OpenError::NotService {
            address: self.address.clone(),
            said: said.chars().take(60).collect(),
        }
    }

    /// Tries all addresses of the host.
    fn connect(&self) -> Result<TcpStream, Error> {
        let mut failed = Error::from(ErrorKind::AddrNotAvailable);
        for address in self.address.to_socket_addrs()? {
            match TcpStream::connect_timeout(&address, PATIENCE) {
                Ok(stream) => {
                    stream.set_read_timeout(Some(PATIENCE))?;
                    return Ok(stream);
                }
                Err(error) => failed = error,
            }
        }
        Err(failed)
    }

    /// The version that the service tells over HTTP.
    fn ask_version(&self) -> Result<String, Inverse3OpenError> {
        let failed = |error| self.no_service(error);
        let mut stream = self.connect().map_err(failed)?;
        let host = &self.address;
        let asked = format!("GET /version HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n");
        stream.write_all(asked.as_bytes()).map_err(failed)?;
        let mut answer = Vec::new();
        // A server that leaves the connection open has said all before.
        let ended = stream.take(BYTES_MOST as u64).read_to_end(&mut answer);
        if let (Err(error), true) = (ended, answer.is_empty()) {
            return Err(failed(error));
        }
        let answer = String::from_utf8_lossy(&answer);
        let first = answer.lines().next().unwrap_or_default();
        // A length in front of it, if it comes in chunks.
        let body = answer.find('{').zip(answer.rfind('}'));
        let body = body.and_then(|(from, to)| answer.get(from..=to));
        let told: Option<Value> = body.and_then(|body| serde_json::from_str(body).ok());
        let version = told
            .as_ref()
            .and_then(|told| told["project_version"].as_str());
        let is_http = first.starts_with("HTTP/1.") && first.contains(" 200 ");
        let version = version.filter(|_| is_http);
        (version.map(str::to_owned)).ok_or_else(|| self.not_service(first))
    }

    /// The device of an inventory: that of the name, or the only one.
    fn chosen<'a>(&self, inventory: &'a Value) -> Result<&'a Value, Inverse3OpenError> {
        let devices = inventory["inverse3"].as_array();
        let devices = devices.ok_or(Trouble::Unreadable)?;
        let known: Vec<&str> = devices.iter().map(id_of).collect();
        let said = match (&self.id, known.as_slice()) {
            (_, []) => return Err(Inverse3OpenError::NoDevice),
            (None, [_]) => return Ok(&devices[0]),
            (None, _) => "which Inverse3 is not said".to_owned(),
            (Some(id), _) => format!("there is no Inverse3 `{id}`"),
        };
        let wanted = self.id.as_deref();
        let mut found = devices.iter().zip(&known);
        let found = found.find(|(_, id)| Some(**id) == wanted);
        found.map(|(device, _)| device).ok_or_else(|| {
            let known = short(&known.join(", ")).into_owned();
            Inverse3OpenError::Which { said, known }
        })
    }
}

fn id_of(device: &Value) -> &str {
    device["device_id"].as_str().unwrap_or_default()
}

/// Refuses a service whose messages are not those of 3.5.
fn check_version(found: &str) -> Result<(), Inverse3OpenError> {
    let mut numbers = found.split('.').map_while(|part| part.parse::<u32>().ok());
    let version = (numbers.next().unwrap_or(0), numbers.next().unwrap_or(0));
    if ((3, 5)..(4, 0)).contains(&version) {
        return Ok(());
    }
    let found = short(found).into_owned();
    Err(Inverse3OpenError::Version { found })
}

fn heard<S: Read + Write>(socket: &mut Socket<S>) -> Result<String, Trouble> {
    for _ in 0..ATTEMPTS {
        match socket.read() {
            Ok(Message::Text(text)) => return Ok(text.as_str().to_owned()),
            Ok(Message::Close(_)) | Err(_) => return Err(Trouble::Gone),
            Ok(_) => {}
        }
    }
    Err(Trouble::Unreadable)
}

impl<S: Read + Write, const D: usize> Inverse3<S, D> {
    /// Opens a device of the service at the other end of a stream, whose reads may wait meanwhile and must not afterwards. There
    /// is no force meanwhile. The words are what a user should know of it.
    ///
    /// # Errors
    /// No service of these messages; no such device, or one that is not ready; settings that it does not take.
    pub fn greet(stream: S, name: &Inverse3Name) -> Result<(Self, String), Inverse3OpenError> {
        let config = WebSocketConfig::default().max_message_size(Some(BYTES_MOST));
        // It clears its buffer at each read.
        let config = config.read_buffer_size(READ_AT_ONCE);
        let url = format!("ws://{}/", name.address);
        let (mut socket, _) = tungstenite::client::client_with_config(url, stream, Some(config))
            .map_err(|error| name.not_service(&error.to_string()))?;
        let parsed = |text: &str| serde_json::from_str(text).map_err(|_| Trouble::Unreadable);
        let inventory: Value = parsed(&heard(&mut socket)?)?;
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
                let id = short(&id).into_owned();
                return Err(Inverse3OpenError::NotReady { id, why });
            }
        }
        let mut attempts = 1;
        loop {
            let sent = socket.send(Message::text(opening(&id)));
            sent.map_err(|_| Trouble::Gone)?;
            let text = heard(&mut socket)?;
            let full: Value = parsed(&text)?;
            let devices = full["inverse3"].as_array().into_iter().flatten();
            let mut devices = devices.filter(|device| id_of(device) == id);
            let config = &devices.next().ok_or(Trouble::Vanished)?["config"];
            match not_taken(config) {
                None => {
                    let told = words_of_gate(&config["filters"]["force_gate"]["gain"]);
                    let place_m = position(&text, &id)?;
                    return Ok((Self::new(socket, &id, name, place_m), told));
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
    let value = short(&value.to_string()).into_owned();
    Some(Inverse3OpenError::NotTaken { setting, value })
}

fn words_of_gate(gain: &Value) -> String {
    let gain = gain.to_string();
    let gain = short(&gain);
    format!(
        "the Inverse Service's force gate has gain {gain}: while it sees an oscillation it lowers the force, which no log shows; \
         this program leaves it, and has set the service's damping to 0"
    )
}
