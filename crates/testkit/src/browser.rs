//! A page without a browser: its requests, and all messages that it gets. The protocol is `docs/page-protocol.md`.
#![expect(clippy::missing_panics_doc, reason = "a test that panics has failed")]

use serde_json::{Value, json};
use std::io::{Read as _, Write as _};
use std::net::TcpStream;
use std::time::Instant;
use tungstenite::client::IntoClientRequest as _;
use tungstenite::{Message, WebSocket};

/// Nothing takes this long, on however busy a machine.
pub use crate::PATIENCE;

/// `127.0.0.1:PORT` and `/TOKEN/` of an address.
#[must_use]
pub fn parts(address: &str) -> (&str, &str) {
    let rest = address.strip_prefix("http://").expect("http");
    rest.split_at(rest.find('/').expect("a path"))
}

/// The answer to a plain request: status line, headers and body as text.
#[must_use]
pub fn get(host: &str, path: &str, headers: &str) -> String {
    let mut stream = TcpStream::connect(host).expect("connects");
    write!(
        stream,
        "GET {path} HTTP/1.1\r\n{headers}Connection: close\r\n\r\n"
    )
    .expect("writes");
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).expect("reads");
    String::from_utf8_lossy(&answer).into_owned()
}

/// A frame of a view; of a live one the picture that it completes.
#[derive(Clone, Debug)]
pub struct Frame {
    /// The number of the request that it answers.
    pub request: u32,
    /// Its own number, which a page acknowledges; 0 if it is the only one.
    pub number: u32,
    /// Rows of the picture.
    pub channels: usize,
    /// Columns.
    pub columns: usize,
    /// First tick of the first column.
    pub first_tick: f64,
    /// Ticks of a column.
    pub ticks_per_column: f64,
    /// The sample time of the run, s.
    pub sample_time_s: f64,
    picture: f64,
    numbers: Vec<f32>,
}

impl Frame {
    fn read(bytes: &[u8]) -> Self {
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four"));
        let number = |at: usize| f64::from_le_bytes(bytes[at..at + 8].try_into().expect("eight"));
        assert_eq!(&bytes[..4], b"FHP2");
        let (channels, columns) = (word(8) as usize, word(12) as usize);
        let numbers: Vec<f32> = (bytes[52..].chunks_exact(4))
            .map(|four| f32::from_le_bytes(four.try_into().expect("four")))
            .collect();
        assert_eq!(numbers.len(), 2 * channels * columns);
        Self {
            request: word(4),
            number: word(48),
            channels,
            columns,
            first_tick: number(16),
            ticks_per_column: number(24),
            sample_time_s: number(32),
            picture: number(40),
            numbers,
        }
    }

    /// The picture of which this frame is the end, given the picture before.
    fn over(mut self, before: Option<&Self>) -> Self {
        if self.first_tick <= self.picture {
            return self;
        }
        let before = before.expect("a picture to go on from");
        let column = |tick: f64| ((tick - before.first_tick) / before.ticks_per_column) as usize;
        let kept = column(self.picture.max(before.first_tick))..column(self.first_tick);
        let rows = (before.numbers.chunks(before.columns)).zip(self.numbers.chunks(self.columns));
        self.numbers = rows
            .flat_map(|(old, new)| old[kept.clone()].iter().chain(new).copied())
            .collect();
        self.columns += kept.len();
        self.first_tick -= kept.len() as f64 * self.ticks_per_column;
        self
    }

    /// The least of a channel, column by column.
    #[must_use]
    pub fn least(&self, channel: usize) -> &[f32] {
        &self.numbers[2 * channel * self.columns..][..self.columns]
    }

    /// The largest value of each column of a channel.
    #[must_use]
    pub fn largest(&self, channel: usize) -> &[f32] {
        &self.numbers[(2 * channel + 1) * self.columns..][..self.columns]
    }
}

/// A page at a socket.
#[derive(Debug)]
pub struct Page {
    socket: WebSocket<TcpStream>,
    id: u64,
    /// Unasked messages that were not yet looked at.
    pub unasked: Vec<Value>,
    /// Frames that were not yet looked at.
    pub frames: Vec<Frame>,
    picture: Option<Frame>,
    /// True to acknowledge frames of a live view, as a page does.
    pub acknowledges: bool,
}

impl Page {
    /// Opens the socket of an address.
    #[must_use]
    pub fn open(address: &str) -> Self {
        let origin = format!("http://{}", parts(address).0);
        Self::from(address, Some(&origin)).expect("opens")
    }

    /// Opens it from a page of this origin.
    ///
    /// # Errors
    /// What the server answers instead.
    pub fn from(address: &str, origin: Option<&str>) -> Result<Self, String> {
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
        let (socket, _) =
            tungstenite::client(request, stream).map_err(|error| error.to_string())?;
        Ok(Self {
            socket,
            id: 0,
            unasked: Vec::new(),
            frames: Vec::new(),
            picture: None,
            acknowledges: true,
        })
    }

    /// The next message, null for a frame.
    ///
    /// # Errors
    /// The reason with which the socket was closed.
    pub fn read(&mut self) -> Result<Value, String> {
        loop {
            match self.socket.read() {
                Ok(Message::Text(text)) => {
                    return Ok(serde_json::from_str(&text).expect("JSON"));
                }
                Ok(Message::Binary(bytes)) => {
                    let mut frame = Frame::read(&bytes);
                    if frame.number > 0 {
                        frame = frame.over(self.picture.as_ref());
                        self.picture = Some(frame.clone());
                        if self.acknowledges {
                            self.acknowledge(&frame);
                        }
                    }
                    self.frames.push(frame);
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

    /// Says that a frame has come.
    pub fn acknowledge(&mut self, frame: &Frame) {
        let numbers = [frame.request, frame.number].map(u32::to_le_bytes);
        // The server may have closed it meanwhile, as `read` then says.
        let _ = self.socket.send(Message::binary(numbers.concat()));
    }

    /// Sends a text as it is, which need not be a request.
    pub fn send(&mut self, text: &str) {
        self.socket.send(Message::text(text)).expect("sends");
    }

    /// Asks without waiting for the answer; the number of the request.
    pub fn post(&mut self, what: &str, arguments: Value) -> u64 {
        self.try_post(what, arguments).expect("sends");
        self.id
    }

    /// Asks without reading.
    ///
    /// # Errors
    /// If the socket is closed.
    pub fn try_post(&mut self, what: &str, mut arguments: Value) -> Result<(), String> {
        self.id += 1;
        (arguments["id"], arguments["do"]) = (json!(self.id), json!(what));
        let sent = self.socket.send(Message::text(arguments.to_string()));
        sent.map_err(|error| error.to_string())
    }

    /// The answer to a number; what comes before it is kept.
    pub fn answer(&mut self, id: &Value) -> Value {
        let known = |unasked: &Value| unasked.get("id").is_some_and(|given| given == id);
        if let Some(found) = self.unasked.iter().position(known) {
            return self.unasked.remove(found);
        }
        loop {
            let message = self.read().expect("open");
            if known(&message) {
                return message;
            }
            if !message.is_null() {
                self.unasked.push(message);
            }
        }
    }

    /// Asks, and is granted it.
    #[track_caller]
    pub fn ask(&mut self, what: &str, arguments: Value) -> Value {
        self.asked(what, arguments, true)
    }

    /// Asks, and is refused with a sentence.
    #[track_caller]
    pub fn refused(&mut self, what: &str, arguments: Value) -> String {
        let answer = self.asked(what, arguments, false);
        answer["error"].as_str().expect("a sentence").to_owned()
    }

    /// Asks, and is refused in these words.
    #[track_caller]
    pub fn refuses(&mut self, what: &str, arguments: Value, words: &str) {
        let refused = self.refused(what, arguments);
        assert!(refused.contains(words), "{refused}");
    }

    #[track_caller]
    fn asked(&mut self, what: &str, arguments: Value, ok: bool) -> Value {
        let id = self.post(what, arguments);
        let answer = self.answer(&json!(id));
        assert_eq!(answer["ok"], ok, "{what}: {answer}");
        answer
    }

    /// The next status for which something holds.
    #[track_caller]
    pub fn status(&mut self, holds: impl Fn(&Value) -> bool) -> Value {
        self.wait("status", holds)
    }

    /// The next message of this kind for which `holds` is true.
    #[track_caller]
    pub fn wait(&mut self, kind: &str, holds: impl Fn(&Value) -> bool) -> Value {
        let until = Instant::now() + PATIENCE;
        loop {
            let wanted = |unasked: &Value| unasked.get(kind).is_some_and(&holds);
            if let Some(found) = self.unasked.iter().position(wanted) {
                return self.unasked.remove(found)[kind].take();
            }
            assert!(
                Instant::now() < until,
                "no {kind} for which it holds, the last was {:?}",
                self.unasked.last()
            );
            self.unasked
                .retain(|unasked| unasked.get("status").is_none());
            let message = self.read().expect("open");
            if !message.is_null() {
                self.unasked.push(message);
            }
        }
    }

    /// The next frame for which something holds.
    #[track_caller]
    pub fn frame(&mut self, holds: impl Fn(&Frame) -> bool) -> Frame {
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
                self.unasked.push(message);
            }
        }
    }

    /// Reads until the socket is closed; the reason.
    pub fn closed(&mut self) -> String {
        let until = Instant::now() + PATIENCE;
        while Instant::now() < until {
            if let Err(reason) = self.read() {
                return reason;
            }
        }
        panic!("still open")
    }
}
