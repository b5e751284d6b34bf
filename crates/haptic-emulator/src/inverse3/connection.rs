//! A connection to the service: HTTP at first, and a WebSocket if it asks for one.

use super::service::Service;
use crate::AtLine;
use std::{
    collections::VecDeque,
    fmt::Write as _,
    io::{self, ErrorKind, Read, Write},
    sync::{Arc, Mutex, MutexGuard, PoisonError},
};
use tungstenite::{
    Message, WebSocket,
    handshake::derive_accept_key,
    protocol::{Role, WebSocketConfig},
};

/// Longest head of a request, bytes.
const HEAD_MOST: usize = 8192;
/// Bytes of a WebSocket that are taken at once.
const READ_AT_ONCE: usize = 64;

/// Bytes that came, and those that are to go.
#[derive(Debug, Default)]
struct Bytes {
    incoming: VecDeque<u8>,
    outgoing: Vec<u8>,
}

impl Read for Bytes {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if self.incoming.is_empty() {
            return Err(ErrorKind::WouldBlock.into());
        }
        self.incoming.read(into)
    }
}

impl Write for Bytes {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.outgoing.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[derive(Debug)]
enum Stage {
    /// The head of a request so far.
    Head(Vec<u8>),
    /// A session, with its number.
    Session(Box<WebSocket<Bytes>>, u64),
    Over,
}

/// One of the connections to a service that they share.
#[derive(Debug)]
pub struct Connection {
    service: Arc<Mutex<Service>>,
    stage: Stage,
}

impl Connection {
    /// A connection that has just been made.
    #[must_use]
    pub const fn new(service: Arc<Mutex<Service>>) -> Self {
        Self {
            service,
            stage: Stage::Head(Vec::new()),
        }
    }

    /// True once the other side may close it.
    #[must_use]
    pub const fn is_over(&self) -> bool {
        matches!(self.stage, Stage::Over)
    }

    fn service(&self) -> MutexGuard<'_, Service> {
        self.service.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Answers a request; one that asks for a WebSocket begins a session.
    fn answer(&self, head: &str, out: &mut Vec<u8>) -> Stage {
        let mut lines = head.lines();
        let path = lines.next().and_then(|line| line.split(' ').nth(1));
        let mut headers = lines.filter_map(|line| line.split_once(':'));
        let key = headers.find(|(name, _)| name.eq_ignore_ascii_case("Sec-WebSocket-Key"));
        let mut text = String::new();
        let Some((_, key)) = key else {
            let page = self.service().page(path.unwrap_or_default());
            let (status, body) = match page {
                Some(page) => ("200 OK", page.to_string()),
                None => (
                    "404 Not Found",
                    r#"{"ok":false,"error":"no such page"}"#.to_owned(),
                ),
            };
            // A string takes whatever is written to it.
            let _ = write!(
                text,
                "HTTP/1.1 {status}\r\nContent-Type: application/json\r\nConnection: close\r\nContent-Length: {}\r\n\r\n{body}",
                body.len()
            );
            out.extend(text.as_bytes());
            return Stage::Over;
        };
        let _ = write!(
            text,
            "HTTP/1.1 101 Switching Protocols\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Accept: {}\r\n\r\n",
            derive_accept_key(key.trim().as_bytes())
        );
        out.extend(text.as_bytes());
        // It clears its buffer at each read.
        let config = WebSocketConfig::default().read_buffer_size(READ_AT_ONCE);
        let mut socket = WebSocket::from_raw_socket(Bytes::default(), Role::Server, Some(config));
        let mut service = self.service();
        service.counted.sessions += 1;
        let session = service.counted.sessions;
        let inventory = service.state(session, true).to_string();
        // Into memory, which takes it.
        let _ = socket.send(Message::text(inventory));
        out.append(&mut socket.get_mut().outgoing);
        Stage::Session(Box::new(socket), session)
    }

    /// Works on the messages that are whole; false when there are no more to come.
    fn converse(&self, socket: &mut WebSocket<Bytes>, session: u64, now_us: u64) -> bool {
        loop {
            match socket.read() {
                Ok(Message::Text(text)) => {
                    let answer = self.service().take(session, &text, now_us);
                    let _ = socket.send(Message::text(answer.to_string()));
                }
                Ok(_) => {}
                Err(tungstenite::Error::Io(error)) => return error.kind() == ErrorKind::WouldBlock,
                Err(_) => return false,
            }
        }
    }
}

impl AtLine for Connection {
    fn advance(&mut self, now_us: u64) {
        self.service().advance(now_us);
    }

    fn receive(&mut self, byte: u8, now_us: u64, out: &mut Vec<u8>) {
        let mut stage = core::mem::replace(&mut self.stage, Stage::Over);
        match &mut stage {
            Stage::Head(head) => {
                head.push(byte);
                if head.ends_with(b"\r\n\r\n") {
                    stage = self.answer(&String::from_utf8_lossy(head), out);
                } else if head.len() > HEAD_MOST {
                    stage = Stage::Over;
                }
            }
            Stage::Session(socket, session) => {
                socket.get_mut().incoming.push_back(byte);
                let goes_on = self.converse(socket, *session, now_us);
                out.append(&mut socket.get_mut().outgoing);
                if !goes_on {
                    self.service().end_session(*session);
                    stage = Stage::Over;
                }
            }
            Stage::Over => {}
        }
        self.stage = stage;
    }
}

impl Drop for Connection {
    fn drop(&mut self) {
        if let Stage::Session(_, session) = self.stage {
            self.service().end_session(session);
        }
    }
}
