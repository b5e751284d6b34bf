//! A Foxglove viewer.

use super::{PATIENCE, run, stderr};
use haptic_log::live::Foxglove;
use haptic_log::record::{Entry, LogReader};
use haptic_message::{ColumnValue as Logged, TickMessage};
use haptic_run::Recorder;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::path::Path;
use std::time::{Duration, Instant};
use testkit::Folder;
use tungstenite::client::IntoClientRequest as _;
use tungstenite::{Message, WebSocket};

/// A message of a channel: opcode, subscription, log time, payload.
struct Data {
    subscription: u32,
    time_ns: u64,
    payload: Vec<u8>,
}

struct Viewer(WebSocket<TcpStream>);

impl Viewer {
    /// Connects as Foxglove and PlotJuggler do.
    fn connect(address: SocketAddr) -> Self {
        let mut request = format!("ws://{address}")
            .into_client_request()
            .expect("a URL");
        let protocol = "foxglove.sdk.v1".parse().expect("a value");
        request
            .headers_mut()
            .insert("sec-websocket-protocol", protocol);
        let stream = TcpStream::connect(address).expect("connects");
        stream.set_read_timeout(Some(PATIENCE)).expect("sets");
        let (socket, _) = tungstenite::client(request, stream).expect("shakes hands");
        Self(socket)
    }

    fn json(&mut self) -> Value {
        let message = self.0.read().expect("a message");
        let Message::Text(text) = message else {
            panic!("no text: {message:?}");
        };
        serde_json::from_str(&text).expect("JSON")
    }

    /// Reads greeting and channels, and subscribes to all: ticks as 1, events as 2.
    fn subscribe(&mut self) {
        let info = self.json();
        assert_eq!(info["op"], "serverInfo");
        assert_eq!(info["capabilities"], json!([]), "viewers only listen");
        let mut channels = Vec::new();
        while channels.len() < 2 {
            let advertise = self.json();
            assert_eq!(advertise["op"], "advertise");
            channels.extend(advertise["channels"].as_array().expect("a list").clone());
        }
        let mut subscriptions = Vec::new();
        for (id, topic, name, field) in [
            (
                1,
                "/haptics/tick",
                "haptics_msgs/msg/Tick",
                "float64 position_m ",
            ),
            (
                2,
                "/haptics/event",
                "haptics_msgs/msg/Event",
                "string text ",
            ),
        ] {
            let channel = channels.iter().find(|channel| channel["topic"] == topic);
            let channel = channel.unwrap_or_else(|| panic!("{topic} in {channels:?}"));
            assert_eq!(channel["encoding"], "cdr");
            assert_eq!(channel["schemaEncoding"], "ros2msg");
            assert_eq!(channel["schemaName"], name);
            assert!(channel["schema"].as_str().expect("text").contains(field));
            subscriptions.push(json!({"id": id, "channelId": channel["id"]}));
        }
        let subscribe = json!({"op": "subscribe", "subscriptions": subscriptions});
        self.0
            .send(Message::text(subscribe.to_string()))
            .expect("sends");
    }

    /// The next message, or none when the server has said goodbye.
    fn data(&mut self) -> Option<Data> {
        match self.0.read() {
            Ok(Message::Binary(bytes)) => {
                assert_eq!(bytes[0], 1, "the opcode of message data");
                Some(Data {
                    subscription: u32::from_le_bytes(bytes[1..5].try_into().expect("four")),
                    time_ns: u64::from_le_bytes(bytes[5..13].try_into().expect("eight")),
                    payload: bytes[13..].to_vec(),
                })
            }
            Ok(Message::Close(_)) => None,
            other => panic!("neither data nor a goodbye: {other:?}"),
        }
    }
}

fn open() -> (Foxglove, SocketAddr) {
    let any = "127.0.0.1:0".parse().expect("an address");
    let foxglove = Foxglove::open(any).expect("opens");
    let address = foxglove.address();
    assert_ne!(address.port(), 0);
    (foxglove, address)
}

/// A recorder with a stream, and a viewer that wants all of it.
fn recorded_and_viewed(log: &Path) -> (Recorder, Viewer) {
    let (foxglove, address) = open();
    let live: Vec<Box<dyn haptic_log::live::Live>> = vec![Box::new(foxglove)];
    let recorder = Recorder::start(log, BTreeMap::new(), true, false, None, live).expect("starts");
    let mut viewer = Viewer::connect(address);
    viewer.subscribe();
    (recorder, viewer)
}

fn tick(n: u32) -> TickMessage {
    TickMessage {
        tick: n.into(),
        time_s: 1e-3 * f64::from(n),
        position_m: (1e-6 * f64::from(n)).into(),
        commanded_force_n: (-f64::from(n)).into(),
        limiters: (n % 16) as u8,
        ..TickMessage::at_rest(1)
    }
}

/// The message as plain CDR: numbers in little endian, each at a multiple of its size behind the header.
fn cdr(tick: &TickMessage) -> Vec<u8> {
    let mut bytes = Vec::new();
    for column in TickMessage::columns(1) {
        let number = match column.value(tick) {
            Logged::Count(count) => count.to_le_bytes().to_vec(),
            Logged::Number(number) => number.to_le_bytes().to_vec(),
            Logged::Bits(bits) => vec![bits],
        };
        bytes.resize(bytes.len().next_multiple_of(number.len()), 0);
        bytes.extend(number);
    }
    [&[0, 1, 0, 0], bytes.as_slice()].concat()
}

#[test]
fn a_viewer_gets_the_messages_of_the_log() {
    let place = Folder::empty();
    let log = place.join("log.mcap");
    let (mut recorder, mut viewer) = recorded_and_viewed(&log);
    // The server subscribes in its own time: samples until one arrives.
    let (arrived, first) = std::sync::mpsc::channel();
    let listener = std::thread::spawn(move || {
        let mut all = Vec::new();
        while let Some(data) = viewer.data() {
            all.push(data);
            let _ = arrived.send(());
        }
        all
    });
    let mut n = 0;
    while first.recv_timeout(Duration::from_millis(1)).is_err() {
        recorder.tick(&tick(n)).expect("records");
        n += 1;
        assert!(n < 60_000, "no message in a minute");
    }
    for n in n..n + 2000 {
        recorder.tick(&tick(n)).expect("records");
    }
    recorder
        .event(1e-3 * f64::from(n + 2000), "phase", "µ".to_owned())
        .expect("records");
    let recorded = recorder.finish().expect("finishes");
    assert_eq!(recorded.warnings, [""; 0]);
    let mut got = listener.join().expect("listens");

    let event = got.pop().expect("the event");
    assert_eq!(event.subscription, 2);
    // Header, time_s, "phase" and "µ", each with its length and a zero.
    assert!(
        event.payload.ends_with("\u{3}\0\0\0µ\0".as_bytes()),
        "{:?}",
        event.payload
    );
    let ticks: Vec<TickMessage> = LogReader::open(&log)
        .expect("opens")
        .filter_map(|entry| match entry.expect("whole") {
            Entry::Tick(tick) => Some(tick),
            Entry::Event(_) | Entry::Metadata(_) => None,
            Entry::Drive(_) | _ => panic!("another device"),
        })
        .collect();
    assert_eq!(ticks.len(), n as usize + 2000);
    assert!(got.len() > 2000, "{}", got.len());
    let logged = &ticks[ticks.len() - got.len()..];
    for (data, want) in got.iter().zip(logged) {
        assert_eq!(data.subscription, 1);
        assert_eq!(data.payload, cdr(want));
        let since_ns = data.time_ns - got[0].time_ns;
        assert_eq!(since_ns, (want.tick - logged[0].tick) * 1_000_000);
    }
}

#[test]
fn a_viewer_that_never_reads_stalls_nothing_and_is_told_of() {
    /// 40 MB: more than the queue, 8192 messages, and what the sockets hold, some 10 MB.
    const EVENTS: u32 = 20_000;
    let place = Folder::empty();
    let log = place.join("log.mcap");
    let (mut recorder, _viewer) = recorded_and_viewed(&log);
    // Subscribed, for sure, when one has arrived.
    recorder.tick(&tick(0)).expect("records");
    std::thread::sleep(Duration::from_secs(1));
    let start = Instant::now();
    for n in 0..EVENTS {
        let time_s = 1e-3 * f64::from(n);
        recorder
            .event(time_s, "phase", "x".repeat(2000))
            .expect("records");
    }
    let recorded = recorder.finish().expect("finishes");
    assert!(start.elapsed() < PATIENCE / 2, "{:?}", start.elapsed());
    assert_eq!(recorded.warnings.len(), 1, "{:?}", recorded.warnings);
    assert!(
        recorded.warnings[0].contains("too slow"),
        "{:?}",
        recorded.warnings
    );
    let events = LogReader::open(&log)
        .expect("opens")
        .filter(|entry| matches!(entry, Ok(Entry::Event(_))));
    assert_eq!(events.count(), EVENTS as usize);
}

#[test]
fn a_port_in_use_is_refused_before_any_file_is_made() {
    let taken = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = taken.local_addr().expect("has one");
    let place = Folder::empty();
    let ended = run(&place, &format!("relax --foxglove={address} --out run"));
    assert_eq!(ended.status.code(), Some(2), "{}", stderr(&ended));
    for part in [&address.to_string(), "in use", "--foxglove=127.0.0.1:0"] {
        assert!(
            stderr(&ended).contains(part),
            "\"{part}\" in {}",
            stderr(&ended)
        );
    }
    assert!(!place.join("run").exists());
}
