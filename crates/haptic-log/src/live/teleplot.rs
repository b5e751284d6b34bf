//! Teleplot: lines of text in UDP datagrams, `name:time_ms:value;time_ms:value§unit`.

use super::{Live, LiveError, TimeOfDay};
use crate::record::{AXES, EventMessage, TickMessage, VectorTick, column};
use std::fmt::Write as _;
use std::io;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};

/// No datagram is longer, so that none is cut into fragments on the way.
pub const DATAGRAM_BYTES: usize = 1400;

/// A datagram is sent when its first sample is this old, s of device time.
const INTERVAL_S: f64 = 0.05;

/// A value adds at most so many bytes to a datagram: 18 for the time, 14 for itself and 2 separators.
const VALUE_BYTES: usize = 34;

/// Name, unit and value of what is sent.
type Field = (&'static str, &'static str, fn(&TickMessage) -> f64);

/// Fields of a sample that are sent.
const FIELDS: [Field; 10] = [
    ("reference_m", "m", |tick| tick.reference_m),
    ("indenter_position_m", "m", |tick| tick.indenter_position_m),
    ("position_m", "m", |tick| tick.position_m),
    ("environment_force_n", "N", |tick| tick.environment_force_n),
    ("commanded_force_n", "N", |tick| tick.commanded_force_n),
    ("applied_force_n", "N", |tick| tick.applied_force_n),
    ("contact_force_n", "N", |tick| tick.contact_force_n),
    ("limiters", "", |tick| f64::from(tick.limiters)),
    ("flaws", "", |tick| f64::from(tick.flaws)),
    ("observed_energy_j", "J", |tick| tick.observed_energy_j),
];

/// A field, its unit, and the points of it that wait, each followed by a semicolon.
#[derive(Clone, Debug)]
struct Line {
    name: String,
    unit: &'static str,
    points: String,
}

impl Line {
    fn new(name: impl Into<String>, unit: &'static str) -> Self {
        Self {
            name: name.into(),
            unit,
            points: String::new(),
        }
    }

    /// Bytes of a datagram that are no points: the name, the colon, the sign of two bytes, the unit, the end of the line.
    fn frame_bytes(&self) -> usize {
        self.name.len() + self.unit.len() + 4
    }
}

/// Lines of a sample of so many axes.
fn lines(axes: usize) -> Vec<Line> {
    if axes == 1 {
        let fields = FIELDS.iter();
        return fields
            .map(|(name, unit, _)| Line::new(*name, unit))
            .collect();
    }
    let vectors = VectorTick::VECTORS.iter().flat_map(|(field, _)| {
        let unit = if field.ends_with("_n") { "N" } else { "m" };
        let axes = AXES.iter().take(axes);
        axes.map(move |axis| Line::new(column(field, axis), unit))
    });
    let rest = [
        Line::new("limiters", ""),
        Line::new("flaws", ""),
        Line::new("observed_energy_j", "J"),
    ];
    vectors.chain(rest).collect()
}

/// Sends samples to a Teleplot server, several in a datagram, values to seven digits. A value that
/// is not finite is left out; an event becomes a line of Teleplot's log.
///
/// Counted as lost is what this machine could not send or a closed port refused. What is lost beyond,
/// on the way or in a server that is too slow, UDP does not tell.
#[derive(Debug)]
pub struct Teleplot {
    socket: UdpSocket,
    address: SocketAddr,
    stamp: TimeOfDay,
    /// Of the samples that came.
    lines: Vec<Line>,
    /// Samples in `lines`.
    waiting: u64,
    /// Device time of the first of them, s.
    since_s: f64,
    /// Samples in the datagram sent last, which may yet turn out to have been refused.
    sent_last: u64,
    samples: u64,
    lost: u64,
    datagram: String,
}

impl Teleplot {
    /// Opens a socket towards `address`. Whether anybody listens there is not known before the
    /// first datagrams, if ever.
    ///
    /// # Errors
    /// If there is no way to the address.
    pub fn open(address: SocketAddr) -> Result<Self, LiveError> {
        let from: SocketAddr = if address.is_ipv4() {
            (Ipv4Addr::UNSPECIFIED, 0).into()
        } else {
            (Ipv6Addr::UNSPECIFIED, 0).into()
        };
        let socket = UdpSocket::bind(from).and_then(|socket| {
            socket.connect(address)?;
            socket.set_nonblocking(true)?;
            Ok(socket)
        });
        let socket = socket.map_err(|source| LiveError::Open { address, source })?;
        Ok(Self {
            socket,
            address,
            stamp: TimeOfDay::default(),
            lines: Vec::new(),
            waiting: 0,
            since_s: 0.0,
            sent_last: 0,
            samples: 0,
            lost: 0,
            datagram: String::new(),
        })
    }

    /// Takes the values of a sample, in the order of its [`lines`].
    fn sample(&mut self, axes: usize, time_s: f64, values: impl Iterator<Item = f64>) {
        if self.lines.is_empty() {
            self.lines = lines(axes);
        }
        let time_ms = self.stamp.milliseconds(time_s);
        for (value, Line { points, .. }) in values.zip(&mut self.lines) {
            if value.is_finite() {
                let _ = write!(points, "{time_ms}:{value:.6e};");
            }
        }
        if self.waiting == 0 {
            self.since_s = time_s;
        }
        self.waiting += 1;
        self.samples += 1;
        let lines = self.lines.iter();
        let bytes: usize = lines
            .map(|line| line.frame_bytes() + line.points.len())
            .sum();
        let next = self.lines.len() * VALUE_BYTES;
        if bytes + next > DATAGRAM_BYTES || time_s - self.since_s >= INTERVAL_S {
            self.flush();
        }
    }

    /// Sends the samples that wait.
    fn flush(&mut self) {
        let mut datagram = std::mem::take(&mut self.datagram);
        datagram.clear();
        for Line { name, unit, points } in &mut self.lines {
            if let Some(points) = points.strip_suffix(';') {
                let separator = if unit.is_empty() { "" } else { "§" };
                // Writing to a string does not fail.
                let _ = writeln!(datagram, "{name}:{points}{separator}{unit}");
            }
            points.clear();
        }
        let samples = std::mem::take(&mut self.waiting);
        if !datagram.is_empty() {
            self.send(&datagram, samples);
        }
        self.datagram = datagram;
    }

    /// Sends a datagram that holds so many samples, now or never.
    fn send(&mut self, datagram: &str, samples: u64) {
        let mut sent = self.socket.send(datagram.as_bytes());
        if matches!(&sent, Err(error) if error.kind() == io::ErrorKind::ConnectionRefused) {
            // Is said of the datagram before; this one was not tried.
            self.lost += std::mem::take(&mut self.sent_last);
            sent = self.socket.send(datagram.as_bytes());
        }
        if sent.is_ok() {
            self.sent_last = samples;
        } else {
            self.lost += samples;
            self.sent_last = 0;
        }
    }
}

impl Live for Teleplot {
    fn tick(&mut self, message: &TickMessage) {
        let values = FIELDS.iter().map(|(_, _, value)| value(message));
        self.sample(1, message.time_s, values);
    }

    fn vector_tick(&mut self, message: &VectorTick) {
        let vectors = VectorTick::VECTORS.map(|(_, field)| field(message));
        let values = vectors.iter().flat_map(|vector| vector.as_slice());
        let bits = [message.limiters, message.flaws].map(f64::from);
        let rest = bits.into_iter().chain([message.observed_energy_j]);
        self.sample(message.axes(), message.time_s, values.copied().chain(rest));
    }

    fn event(&mut self, message: &EventMessage) {
        self.flush();
        let time_ms = self.stamp.milliseconds(message.time_s);
        let text = format!("{}: {}", message.kind, message.text).replace('\n', " ");
        let mut line = format!(">{time_ms}:{text}");
        while line.len() > DATAGRAM_BYTES {
            line.pop();
        }
        self.send(&line, 0);
    }

    fn finish(mut self: Box<Self>) -> Option<String> {
        self.flush();
        if matches!(self.socket.take_error(), Ok(Some(_))) {
            self.lost += self.sent_last;
        }
        (self.lost > 0).then(|| {
            format!(
                "at least {} of {} samples did not reach a Teleplot at {}; the log has them",
                self.lost, self.samples, self.address
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    fn listen() -> (UdpSocket, Teleplot) {
        let viewer = UdpSocket::bind("127.0.0.1:0").expect("a port");
        viewer
            .set_read_timeout(Some(Duration::from_secs(10)))
            .expect("sets");
        let address = viewer.local_addr().expect("has one");
        (viewer, Teleplot::open(address).expect("opens"))
    }

    fn receive(viewer: &UdpSocket) -> String {
        let mut buffer = [0; 2 * DATAGRAM_BYTES];
        let length = viewer.recv(&mut buffer).expect("a datagram");
        assert!(length <= DATAGRAM_BYTES, "{length} bytes");
        String::from_utf8(buffer[..length].to_vec()).expect("UTF-8")
    }

    #[test]
    fn a_sample_is_a_line_per_value_with_its_unit() {
        let (viewer, mut teleplot) = listen();
        teleplot.stamp.start_ms = Some(1_700_000_000_000.0);
        teleplot.tick(&TickMessage {
            time_s: 0.0005,
            position_m: 1e-3,
            commanded_force_n: -0.25,
            environment_force_n: f64::NAN,
            limiters: 9,
            observed_energy_j: f64::NAN,
            ..TickMessage::default()
        });
        assert_eq!(Box::new(teleplot).finish(), None);
        assert_eq!(
            receive(&viewer),
            "reference_m:1700000000000.5:0.000000e0§m\n\
             indenter_position_m:1700000000000.5:0.000000e0§m\n\
             position_m:1700000000000.5:1.000000e-3§m\n\
             commanded_force_n:1700000000000.5:-2.500000e-1§N\n\
             applied_force_n:1700000000000.5:0.000000e0§N\n\
             contact_force_n:1700000000000.5:0.000000e0§N\n\
             limiters:1700000000000.5:9.000000e0\n\
             flaws:1700000000000.5:0.000000e0\n"
        );
    }

    #[test]
    fn a_sample_of_three_axes_is_a_line_for_each_and_fits() {
        let (viewer, mut teleplot) = listen();
        teleplot.stamp.start_ms = Some(1_700_000_000_000.0);
        let long = [-f64::MIN_POSITIVE; 3].into();
        let tick = VectorTick {
            time_s: 0.001_001,
            reference_m: long,
            indenter_position_m: long,
            position_m: long,
            environment_force_n: long,
            commanded_force_n: [0.5, -0.25, 1.0].into(),
            applied_force_n: long,
            contact_force_n: long,
            observed_energy_j: -f64::MIN_POSITIVE,
            ..VectorTick::at_rest(3)
        };
        teleplot.vector_tick(&tick);
        assert_eq!(Box::new(teleplot).finish(), None);
        let datagram = receive(&viewer);
        assert_eq!(datagram.lines().count(), 24);
        assert!(
            datagram.contains("\ncommanded_force_y_n:1700000000001.001:-2.500000e-1§N\n"),
            "{datagram}"
        );
    }

    #[test]
    fn the_longest_samples_fit_and_none_waits_longer_than_the_interval() {
        let (viewer, mut teleplot) = listen();
        let long = -f64::MIN_POSITIVE;
        for tick in 0..40 {
            teleplot.tick(&TickMessage {
                tick,
                time_s: 0.001_001 * tick as f64,
                reference_m: long,
                indenter_position_m: long,
                position_m: long,
                environment_force_n: long,
                commanded_force_n: long,
                applied_force_n: long,
                contact_force_n: long,
                limiters: 15,
                flaws: 15,
                observed_energy_j: long,
            });
        }
        teleplot.event(&EventMessage {
            time_s: 1.0,
            kind: "phase".to_owned(),
            text: "µ\n".repeat(DATAGRAM_BYTES),
        });
        let mut points = 0;
        loop {
            let datagram = receive(&viewer);
            if datagram.starts_with('>') {
                break;
            }
            points += datagram.matches(['§']).count() + datagram.matches(';').count();
        }
        // Nine values of each of the 40 samples; limiters and flaws have no unit.
        assert!(points > 8 * 40, "{points}");

        // One sample, then another that closes the interval.
        for time_s in [2.0, 2.001 + INTERVAL_S] {
            teleplot.tick(&TickMessage {
                time_s,
                ..TickMessage::default()
            });
        }
        assert_eq!(receive(&viewer).matches(';').count(), FIELDS.len());
    }

    #[test]
    fn what_nobody_listens_to_is_counted() {
        let (viewer, mut teleplot) = listen();
        drop(viewer);
        for tick in 0..100 {
            teleplot.tick(&TickMessage {
                time_s: f64::from(tick) * INTERVAL_S,
                ..TickMessage::default()
            });
        }
        let warning = Box::new(teleplot).finish().expect("a warning");
        assert!(warning.contains("of 100 samples"), "{warning}");
        // Not every system tells who sent to a closed port.
        #[cfg(target_os = "linux")]
        assert!(warning.contains("least 100 of 100"), "{warning}");
    }
}
