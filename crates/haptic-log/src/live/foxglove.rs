//! Foxglove WebSocket (`foxglove.sdk.v1`): the topics, schemas and bytes of the log, as they come. CDR with `ros2msg`
//! is what both Foxglove and PlotJuggler's bridge read. Viewers only listen; whoever reaches the port may watch.

use super::{Live, LiveError};
use foxglove::{
    Context, FoxgloveError, PartialMetadata, RawChannel, Schema, WebSocketServer,
    WebSocketServerHandle,
};
use haptic_message::{EventMessage, LogMessage, TickMessage};
use std::{
    net::SocketAddr,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
        mpsc,
    },
    time::{Duration, SystemTime, UNIX_EPOCH},
};
use tracing::{Dispatch, Metadata, span};

/// Messages that wait for a slow viewer before the oldest are dropped: at 1 kHz, 8 s.
const BACKLOG: usize = 8192;

/// Time for viewers to take the last messages; the library does not report that they have.
const DRAIN: Duration = Duration::from_millis(250);

/// Time for viewers to say goodbye.
const GOODBYE: Duration = Duration::from_millis(250);

/// Serves samples and events to any number of viewers.
#[derive(Debug)]
pub struct Foxglove {
    /// `None` only after `finish`.
    server: Option<WebSocketServerHandle>,
    address: SocketAddr,
    /// The channels live as long as this.
    context: Arc<Context>,
    ticks: Arc<RawChannel>,
    /// Axes of the ticks: one until the first says more.
    axes: usize,
    events: Arc<RawChannel>,
    stamp: TimeOfDay,
    buffer: Vec<u8>,
    /// True if a viewer was too slow.
    overflowed: Arc<AtomicBool>,
    watch: Dispatch,
}

impl Foxglove {
    /// Starts the server; port 0 takes a free one.
    ///
    /// # Errors
    /// If the address is taken or does not belong to this machine.
    pub fn open(address: SocketAddr) -> Result<Self, LiveError> {
        let failed = |error: FoxgloveError| {
            let reason = error.to_string();
            if let FoxgloveError::Bind(source) = error {
                return LiveError::Open { address, source };
            }
            LiveError::Server { address, reason }
        };
        let context = Context::new();
        let ticks = channel(&context, &TickMessage::unknown(1)).map_err(failed)?;
        let events = channel(&context, &EventMessage::default()).map_err(failed)?;
        let host = match address {
            SocketAddr::V4(address) => address.ip().to_string(),
            SocketAddr::V6(address) => format!("[{}]", address.ip()),
        };
        let server = WebSocketServer::new()
            .name("host-cli")
            .context(&context)
            .message_backlog_size(BACKLOG)
            .bind(host, address.port())
            .start_blocking()
            .map_err(failed)?;
        let overflowed = Arc::new(AtomicBool::new(false));
        Ok(Self {
            address: SocketAddr::new(address.ip(), server.port()),
            server: Some(server),
            context,
            ticks,
            axes: 1,
            events,
            stamp: TimeOfDay::default(),
            buffer: Vec::new(),
            watch: Dispatch::new(Overflow(Arc::clone(&overflowed))),
            overflowed,
        })
    }

    /// Address to which viewers connect.
    #[must_use]
    pub const fn address(&self) -> SocketAddr {
        self.address
    }
}

fn channel<M: LogMessage>(
    context: &Arc<Context>,
    message: &M,
) -> Result<Arc<RawChannel>, FoxgloveError> {
    let (name, text) = message.schema();
    context
        .channel_builder(M::TOPIC)
        .message_encoding("cdr")
        .schema(Schema::new(name, "ros2msg", text.into_bytes()))
        .build_raw()
}

fn log<M: LogMessage>(
    channel: &RawChannel,
    message: &M,
    log_time: u64,
    buffer: &mut Vec<u8>,
    watch: &Dispatch,
) {
    // A message that cannot be encoded ends the run by way of the log.
    if channel.has_sinks() && message.encode_into(buffer).is_ok() {
        let meta = PartialMetadata::with_log_time(log_time);
        tracing::dispatcher::with_default(watch, || channel.log_with_meta(buffer, meta));
    }
}

impl Live for Foxglove {
    fn tick(&mut self, message: &TickMessage) {
        if self.axes != message.axes() {
            self.axes = message.axes();
            self.ticks.close();
            // Only a topic that is taken is refused, and this one is free again.
            if let Ok(channel) = channel(&self.context, message) {
                self.ticks = channel;
            }
        }
        let time = self.stamp.nanoseconds(message.time_s);
        log(&self.ticks, message, time, &mut self.buffer, &self.watch);
    }

    fn event(&mut self, message: &EventMessage) {
        let time = self.stamp.nanoseconds(message.time_s);
        log(&self.events, message, time, &mut self.buffer, &self.watch);
    }

    fn finish(mut self: Box<Self>) -> Option<String> {
        if let Some(server) = self.server.take() {
            if self.ticks.has_sinks() || self.events.has_sinks() {
                std::thread::sleep(DRAIN);
            }
            let viewers = server.stop();
            let (gone, all_gone) = mpsc::channel();
            // A viewer that has stopped reading never goes: its thread ends with the process.
            std::thread::spawn(move || {
                viewers.wait_blocking();
                let _ = gone.send(());
            });
            let _ = all_gone.recv_timeout(GOODBYE);
        }
        self.overflowed.load(Ordering::Relaxed).then(|| {
            format!(
                "a viewer of ws://{} was too slow and missed samples; the log has them",
                self.address
            )
        })
    }
}

impl Drop for Foxglove {
    /// A server whose handle is dropped would continue.
    fn drop(&mut self) {
        if let Some(server) = self.server.take() {
            drop(server.stop());
        }
    }
}

/// Listens for the library's one sign of a full queue: a log entry, at most one in 30 s, hence no count.
#[derive(Debug)]
struct Overflow(Arc<AtomicBool>);

impl tracing::Subscriber for Overflow {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        // The module logs nothing else.
        metadata.target().ends_with("::send_lossy")
    }

    fn event(&self, _: &tracing::Event<'_>) {
        self.0.store(true, Ordering::Relaxed);
    }

    fn new_span(&self, _: &span::Attributes<'_>) -> span::Id {
        span::Id::from_u64(1)
    }

    fn record(&self, _: &span::Id, _: &span::Record<'_>) {}

    fn record_follows_from(&self, _: &span::Id, _: &span::Id) {}

    fn enter(&self, _: &span::Id) {}

    fn exit(&self, _: &span::Id) {}
}

#[derive(Clone, Copy, Debug, Default)]
struct TimeOfDay {
    /// Time of day at device time 0, ns since 1970.
    start_ns: Option<u64>,
}

impl TimeOfDay {
    fn nanoseconds(&mut self, time_s: f64) -> u64 {
        // The sum would lose digits in f64. Casts saturate.
        let time_ns = (1e9 * time_s).round() as u64;
        let start_ns = *self.start_ns.get_or_insert_with(|| {
            let now = SystemTime::now().duration_since(UNIX_EPOCH);
            (now.unwrap_or(Duration::ZERO).as_nanos() as u64).saturating_sub(time_ns)
        });
        start_ns.saturating_add(time_ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_are_the_time_of_day_with_the_spacing_of_the_device() {
        let mut stamp = TimeOfDay::default();
        let now = SystemTime::now().duration_since(UNIX_EPOCH);
        let first = stamp.nanoseconds(100.0);
        let late_ns = i128::from(first) - now.expect("after 1970").as_nanos() as i128;
        assert!(late_ns.abs() < 10_000_000_000, "{late_ns}");
        assert_eq!(stamp.nanoseconds(101.000_000_001) - first, 1_000_000_001);
    }
}
