//! A page without a browser: what it asks, and all that it is told.

use haptic_experiment::RealtimeOptions;
use haptic_page::{OnClose, PageServer, ServerOptions};
use haptic_tissue::Library;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::path::Path;
use std::time::{Duration, Instant};
use tungstenite::client::IntoClientRequest as _;
use tungstenite::{Message, WebSocket};

/// Nothing takes so long, on however busy a machine.
pub(crate) const PATIENCE: Duration = Duration::from_secs(20);

pub(crate) fn server(runs: &Path, on_close: OnClose) -> PageServer {
    PageServer::start(options(runs, on_close, 0)).expect("starts")
}

pub(crate) fn options(runs: &Path, on_close: OnClose, port: u16) -> ServerOptions {
    ServerOptions {
        port,
        runs: runs.to_owned(),
        on_close,
        realtime: RealtimeOptions::NORMAL,
        library: Library::load(None).expect("built in"),
        provenance: BTreeMap::from([("program".to_owned(), "a test".to_owned())]),
    }
}

/// `127.0.0.1:PORT` and `/TOKEN/` of an address.
pub(crate) fn parts(address: &str) -> (&str, &str) {
    let rest = address.strip_prefix("http://").expect("http");
    rest.split_at(rest.find('/').expect("a path"))
}

/// The answer to a plain request: status line, headers and body as text.
pub(crate) fn get(host: &str, path: &str, headers: &str) -> String {
    let mut stream = TcpStream::connect(host).expect("connects");
    write!(stream, "GET {path} HTTP/1.1\r\n{headers}Connection: close\r\n\r\n").expect("writes");
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).expect("reads");
    String::from_utf8_lossy(&answer).into_owned()
}

/// A frame of a view.
#[derive(Clone, Debug)]
pub(crate) struct Frame {
    pub(crate) source: u32,
    pub(crate) channels: usize,
    pub(crate) columns: usize,
    pub(crate) first_tick: f64,
    pub(crate) ticks_per_column: f64,
    pub(crate) sample_time_s: f64,
    numbers: Vec<f32>,
}

impl Frame {
    fn read(bytes: &[u8]) -> Self {
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four"));
        let number = |at: usize| f64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight"));
        assert_eq!(&bytes[..4], b"FHP1");
        let (channels, columns) = (word(8) as usize, word(12) as usize);
        let numbers: Vec<f32> = (bytes[40..].chunks_exact(4))
            .map(|four| f32::from_le_bytes(four.try_into().expect("four")))
            .collect();
        assert_eq!(numbers.len(), 2 * channels * columns);
        Self {
            source: word(4),
            channels,
            columns,
            first_tick: number(16),
            ticks_per_column: number(24),
            sample_time_s: number(32),
            numbers,
        }
    }

    pub(crate) fn least(&self, channel: usize) -> &[f32] {
        &self.numbers[2 * channel * self.columns..][..self.columns]
    }

    pub(crate) fn largest(&self, channel: usize) -> &[f32] {
        &self.numbers[(2 * channel + 1) * self.columns..][..self.columns]
    }
}

/// A page at a socket.
pub(crate) struct Page {
    socket: WebSocket<TcpStream>,
    id: u64,
    /// What came unasked and was not yet looked at.
    pub(crate) told: Vec<Value>,
    pub(crate) frames: Vec<Frame>,
}

impl Page {
    pub(crate) fn open(address: &str) -> Self {
        let origin = address[..address.rfind('/').expect("a path")].rsplit_once('/').expect("a token").0;
        Self::from(address, Some(origin)).expect("opens")
    }

    /// From a page of this origin.
    pub(crate) fn from(address: &str, origin: Option<&str>) -> Result<Self, String> {
        let (host, _) = parts(address);
        let url = format!("{}ws", address.replacen("http", "ws", 1));
        let mut request = url.into_client_request().expect("a request");
        if let Some(origin) = origin {
            let origin = origin.parse().expect("a header");
            request.headers_mut().insert("Origin", origin);
        }
        let stream = TcpStream::connect(host).expect("connects");
        stream.set_read_timeout(Some(PATIENCE)).expect("set");
        stream.set_write_timeout(Some(PATIENCE)).expect("set");
        let (socket, _) = tungstenite::client(request, stream).map_err(|error| error.to_string())?;
        Ok(Self {
            socket,
            id: 0,
            told: Vec::new(),
            frames: Vec::new(),
        })
    }

    /// The next message; the reason, if the socket was closed.
    pub(crate) fn read(&mut self) -> Result<Value, String> {
        loop {
            match self.socket.read() {
                Ok(Message::Text(text)) => {
                    return Ok(serde_json::from_str(&text).expect("JSON"));
                }
                Ok(Message::Binary(bytes)) => {
                    self.frames.push(Frame::read(&bytes));
                    return Ok(Value::Null);
                }
                Ok(Message::Close(frame)) => {
                    let frame = frame.expect("a reason");
                    return Err(format!("{}: {}", u16::from(frame.code), frame.reason));
                }
                Ok(_) => {}
                Err(error) => return Err(error.to_string()),
            }
        }
    }

    pub(crate) fn send(&mut self, text: &str) {
        self.socket.send(Message::text(text)).expect("sends");
    }

    pub(crate) fn post(&mut self, what: &str, mut arguments: Value) -> u64 {
        self.id += 1;
        (arguments["id"], arguments["do"]) = (json!(self.id), json!(what));
        self.send(&arguments.to_string());
        self.id
    }

    /// Asks without reading; an error if the socket is closed.
    pub(crate) fn try_post(&mut self, what: &str, mut arguments: Value) -> Result<(), String> {
        self.id += 1;
        (arguments["id"], arguments["do"]) = (json!(self.id), json!(what));
        let sent = self.socket.send(Message::text(arguments.to_string()));
        sent.map_err(|error| error.to_string())
    }

    /// The answer to a number; what comes before it is kept.
    pub(crate) fn answer(&mut self, id: &Value) -> Value {
        loop {
            let message = self.read().expect("open");
            if message.get("id").is_some_and(|given| given == id) {
                return message;
            }
            if !message.is_null() {
                self.told.push(message);
            }
        }
    }

    /// Asks, and is granted it.
    #[track_caller]
    pub(crate) fn ask(&mut self, what: &str, arguments: Value) -> Value {
        let id = self.post(what, arguments);
        let answer = self.answer(&json!(id));
        assert_eq!(answer["ok"], true, "{what}: {answer}");
        answer
    }

    /// Asks, and is refused with a sentence.
    #[track_caller]
    pub(crate) fn refused(&mut self, what: &str, arguments: Value) -> String {
        let id = self.post(what, arguments);
        let answer = self.answer(&json!(id));
        assert_eq!(answer["ok"], false, "{what}: {answer}");
        answer["error"].as_str().expect("a sentence").to_owned()
    }

    /// The next status for which something holds.
    #[track_caller]
    pub(crate) fn status(&mut self, holds: impl Fn(&Value) -> bool) -> Value {
        self.wait("status", holds)
    }

    /// The next thing told of this kind for which something holds.
    #[track_caller]
    pub(crate) fn wait(&mut self, kind: &str, holds: impl Fn(&Value) -> bool) -> Value {
        let until = Instant::now() + PATIENCE;
        loop {
            let found = self.told.iter().position(|told| told.get(kind).is_some_and(&holds));
            if let Some(found) = found {
                return self.told.remove(found)[kind].take();
            }
            assert!(Instant::now() < until, "no {kind} for which it holds, the last was {:?}", self.told.last());
            self.told.retain(|told| told.get("status").is_none());
            let message = self.read().expect("open");
            if !message.is_null() {
                self.told.push(message);
            }
        }
    }

    /// The next frame for which something holds.
    #[track_caller]
    pub(crate) fn frame(&mut self, holds: impl Fn(&Frame) -> bool) -> Frame {
        let until = Instant::now() + PATIENCE;
        loop {
            if let Some(found) = self.frames.iter().position(&holds) {
                let frame = self.frames.swap_remove(found);
                self.frames.clear();
                return frame;
            }
            self.frames.clear();
            assert!(Instant::now() < until, "no frame");
            let message = self.read().expect("open");
            if !message.is_null() {
                self.told.push(message);
            }
        }
    }

    /// Reads until the socket is closed; the reason.
    pub(crate) fn closed(&mut self) -> String {
        let until = Instant::now() + PATIENCE;
        while Instant::now() < until {
            if let Err(reason) = self.read() {
                return reason;
            }
        }
        panic!("still open")
    }
}
