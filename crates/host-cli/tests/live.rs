//! Live streams as a viewer meets them.

use std::net::{SocketAddr, UdpSocket};
use std::path::Path;
use std::process::Output;
use std::time::Duration;

/// No step of these tests takes a tenth of this, even on a busy machine.
const PATIENCE: Duration = Duration::from_secs(600);

/// Runs `host-cli LINE` in a folder.
fn run(place: &Path, line: &str) -> Output {
    let mut command = assert_cmd::Command::new(assert_cmd::cargo::cargo_bin!("host-cli"));
    let command = command.args(line.split_whitespace()).current_dir(place);
    command.timeout(PATIENCE).output().expect("runs and ends")
}

fn stderr(output: &Output) -> &str {
    std::str::from_utf8(&output.stderr).expect("UTF-8")
}

/// A point of a Teleplot line.
struct Point {
    name: String,
    time_ms: f64,
    value: f64,
    unit: String,
}

/// Reads a datagram by the grammar of Teleplot's README.
fn points(datagram: &str) -> Vec<Point> {
    let mut points = Vec::new();
    for line in datagram.lines() {
        let (name, rest) = line.split_once(':').expect("a name");
        let (values, unit) = rest.split_once('§').unwrap_or((rest, ""));
        for value in values.split(';') {
            let (time_ms, value) = value.split_once(':').expect("a time");
            points.push(Point {
                name: name.to_owned(),
                time_ms: time_ms.parse().expect("a time"),
                value: value.parse().expect("a value"),
                unit: unit.to_owned(),
            });
        }
    }
    points
}

#[test]
fn teleplot_gets_the_samples_of_the_log() {
    let place = tempfile::tempdir().expect("a folder");
    let viewer = UdpSocket::bind("127.0.0.1:0").expect("a port");
    let address = viewer.local_addr().expect("has one");
    let listener = std::thread::spawn(move || {
        let (mut all, mut buffer) = (Vec::new(), [0; 65536]);
        loop {
            let length = viewer.recv(&mut buffer).expect("receives");
            assert!(length <= 1400, "{length} bytes");
            match std::str::from_utf8(&buffer[..length]).expect("UTF-8") {
                "end" => return all,
                datagram => all.extend(points(datagram)),
            }
        }
    });
    let line =
        format!("relax --duration 0.4s --ramp-time 0.1s --realtime --teleplot={address} --out .");
    let ended = run(place.path(), &line);
    assert!(ended.status.success(), "{}", stderr(&ended));
    let note = format!("live stream: Teleplot datagrams to {address}");
    assert!(stderr(&ended).contains(&note), "{}", stderr(&ended));
    let end = UdpSocket::bind("127.0.0.1:0").expect("a port");
    end.send_to(b"end", address).expect("sends");
    let points = listener.join().expect("listens");

    run(place.path(), "log export relax.mcap ticks.csv");
    let mut log = csv::Reader::from_path(place.path().join("ticks.csv")).expect("a table");
    let columns: Vec<String> = log
        .headers()
        .expect("names")
        .iter()
        .map(str::to_owned)
        .collect();
    let rows: Vec<Vec<f64>> = log.deserialize().map(|row| row.expect("numbers")).collect();
    assert!(rows.len() > 400, "{}", rows.len());
    let sent = columns
        .iter()
        .enumerate()
        .filter(|(_, name)| !["tick", "time_s"].contains(&name.as_str()));
    for (column, name) in sent {
        let have: Vec<&Point> = points.iter().filter(|point| point.name == *name).collect();
        // What is not a number, as the energy without a guard, is left out.
        let rows: Vec<&Vec<f64>> = rows.iter().filter(|row| row[column].is_finite()).collect();
        assert_eq!(have.len(), rows.len(), "{name}");
        assert_eq!(rows.is_empty(), name == "observed_energy_j", "{name}");
        let unit = match name.rsplit_once('_') {
            Some((_, "m")) => "m",
            Some((_, "n")) => "N",
            Some((_, "j")) => "J",
            _ => "",
        };
        for (n, point) in have.iter().enumerate() {
            assert_eq!(point.unit, unit, "{name}");
            let want = rows[n][column];
            assert!(
                (point.value - want).abs() <= 1e-6 * want.abs(),
                "{name} {n}: {} {want}",
                point.value
            );
            // To the µs, whatever the ms it began in.
            let (since_ms, time_ms) = (point.time_ms - have[0].time_ms, 1e3 * rows[n][1]);
            assert!(
                (since_ms - time_ms).abs() < 2e-3,
                "{name} {n}: {since_ms} {time_ms}"
            );
        }
    }
}

#[test]
fn a_burst_and_a_missing_viewer_are_warnings_and_no_failure() {
    let place = tempfile::tempdir().expect("a folder");
    let gone: SocketAddr = {
        let viewer = UdpSocket::bind("127.0.0.1:0").expect("a port");
        viewer.local_addr().expect("has one")
    };
    let ended = run(
        place.path(),
        &format!("relax --duration 2s --teleplot={gone} --out ."),
    );
    assert!(ended.status.success(), "{}", stderr(&ended));
    assert!(stderr(&ended).contains("--realtime"), "{}", stderr(&ended));
    #[cfg(target_os = "linux")]
    {
        let lost = format!("2001 of 2001 samples did not reach a Teleplot at {gone}");
        assert!(stderr(&ended).contains(&lost), "{}", stderr(&ended));
    }
}

#[test]
fn a_bad_address_is_refused_before_any_file_is_made() {
    for (arguments, wanted) in [
        ("--teleplot=localhost", "IP:PORT"),
        ("--teleplot=127.0.0.1:0", "port 0"),
        ("--foxglove=8765", "IP:PORT"),
        ("--foxglove=127.0.0.1:65536", "IP:PORT"),
    ] {
        let place = tempfile::tempdir().expect("a folder");
        let ended = run(
            place.path(),
            &format!("relax --duration 2s {arguments} --out run"),
        );
        assert_eq!(
            ended.status.code(),
            Some(2),
            "{arguments}: {}",
            stderr(&ended)
        );
        assert!(
            stderr(&ended).contains(wanted),
            "{arguments}: {}",
            stderr(&ended)
        );
        assert!(!place.path().join("run").exists(), "{arguments}");
    }
}

// `.ci/run` tests with the feature, and asks a command without it the same.
#[cfg(not(feature = "foxglove"))]
#[test]
fn a_build_without_foxglove_says_so() {
    let place = tempfile::tempdir().expect("a folder");
    let ended = run(place.path(), "relax --duration 2s --foxglove --out run");
    assert_eq!(ended.status.code(), Some(2), "{}", stderr(&ended));
    assert!(
        stderr(&ended).contains("--features foxglove"),
        "{}",
        stderr(&ended)
    );
}

#[cfg(feature = "foxglove")]
mod foxglove {
    use super::{PATIENCE, run, stderr};
    use byteorder::LittleEndian;
    use haptic_experiment::recorder::Recorder;
    use haptic_log::live::Foxglove;
    use haptic_log::record::{Entry, LogReader, TickMessage};
    use serde_json::{Value, json};
    use std::collections::BTreeMap;
    use std::net::{SocketAddr, TcpListener, TcpStream};
    use std::time::{Duration, Instant};
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
            match self.0.read().expect("a message") {
                Message::Text(text) => serde_json::from_str(&text).expect("JSON"),
                other => panic!("no text: {other:?}"),
            }
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

    fn tick(n: u32) -> TickMessage {
        TickMessage {
            tick: n.into(),
            time_s: 1e-3 * f64::from(n),
            position_m: 1e-6 * f64::from(n),
            force_n: -f64::from(n),
            limiters: (n % 16) as u8,
            ..TickMessage::default()
        }
    }

    #[test]
    fn a_viewer_gets_the_messages_of_the_log() {
        let place = tempfile::tempdir().expect("a folder");
        let log = place.path().join("log.mcap");
        let (foxglove, address) = open();
        let live: Vec<Box<dyn haptic_log::live::Live>> = vec![Box::new(foxglove)];
        let mut recorder =
            Recorder::start(&log, BTreeMap::new(), true, false, live).expect("starts");
        let mut viewer = Viewer::connect(address);
        viewer.subscribe();
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
            recorder.tick(tick(n)).expect("records");
            n += 1;
            assert!(n < 60_000, "no message in a minute");
        }
        for n in n..n + 2000 {
            recorder.tick(tick(n)).expect("records");
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
                _ => None,
            })
            .collect();
        assert_eq!(ticks.len(), n as usize + 2000);
        assert!(got.len() > 2000, "{}", got.len());
        let logged = &ticks[ticks.len() - got.len()..];
        for (data, want) in got.iter().zip(logged) {
            assert_eq!(data.subscription, 1);
            let fields = data.payload.strip_prefix(&[0, 1, 0, 0]).expect("plain CDR");
            let (have, _) =
                cdr_encoding::from_bytes::<TickMessage, LittleEndian>(fields).expect("CDR");
            assert_eq!(have, *want);
            let since_ns = data.time_ns - got[0].time_ns;
            assert_eq!(since_ns, (want.tick - logged[0].tick) * 1_000_000);
        }
    }

    #[test]
    fn a_viewer_that_never_reads_stalls_nothing_and_is_told_of() {
        /// 40 MB: more than the queue, 8192 messages, and what the sockets hold, some 10 MB.
        const EVENTS: u32 = 20_000;
        let place = tempfile::tempdir().expect("a folder");
        let log = place.path().join("log.mcap");
        let (foxglove, address) = open();
        let live: Vec<Box<dyn haptic_log::live::Live>> = vec![Box::new(foxglove)];
        let mut recorder =
            Recorder::start(&log, BTreeMap::new(), true, false, live).expect("starts");
        let mut viewer = Viewer::connect(address);
        viewer.subscribe();
        // Subscribed, for sure, when one has arrived.
        recorder.tick(tick(0)).expect("records");
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
        let place = tempfile::tempdir().expect("a folder");
        let ended = run(
            place.path(),
            &format!("relax --foxglove={address} --out run"),
        );
        assert_eq!(ended.status.code(), Some(2), "{}", stderr(&ended));
        for part in [&address.to_string(), "in use", "--foxglove=127.0.0.1:0"] {
            assert!(
                stderr(&ended).contains(part),
                "\"{part}\" in {}",
                stderr(&ended)
            );
        }
        assert!(!place.path().join("run").exists());
    }
}
