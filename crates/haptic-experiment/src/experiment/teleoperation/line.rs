//! The socket of a side: greetings, datagrams, strangers.

use haptic_document::{
    Failure,
    parameters::{CONNECT, LISTEN},
};
use haptic_link::{FRAME_MAX, HandSide};
use haptic_loop::realtime::Moment;
use haptic_teleoperation::{Introduction, Peer, PeerMessage};
use std::{
    io::ErrorKind,
    net::{SocketAddr, UdpSocket},
    sync::atomic::{AtomicBool, Ordering},
    time::{Duration, SystemTime},
};

/// The end that this process is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Waits for the other; it is the slave.
    Listen(SocketAddr),
    /// Looks for the other; it is the master.
    Connect(SocketAddr),
}

impl End {
    /// The side that it is.
    #[must_use]
    pub const fn side(self) -> HandSide {
        match self {
            Self::Listen(_) => HandSide::Slave,
            Self::Connect(_) => HandSide::Master,
        }
    }
}

/// Time from one greeting to the next.
const GREET: Duration = Duration::from_millis(50);
/// Least time from one answer to a stranger to the next.
const REFUSE: Duration = Duration::from_millis(5);
/// Farewells in a row: one may be lost.
const FAREWELLS: usize = 3;

/// The socket and who may speak on it.
pub(super) struct Line {
    pub socket: UdpSocket,
    pub peer: Option<SocketAddr>,
    pub state: Peer,
    pub buffer: [u8; FRAME_MAX],
    pub strangers: u64,
    /// The last answer to a stranger.
    refused: Option<Moment>,
}

/// An address that cannot be used.
pub(super) fn unusable(end: End, error: &std::io::Error) -> Failure {
    let (address, advice) = match end {
        End::Listen(address) => (address, &format!("{LISTEN}")),
        End::Connect(address) => (address, &format!("{CONNECT}")),
    };
    Failure::device(format_args!(
        "cannot use {address}: {error}: give another address with {advice}, as 127.0.0.1:4810"
    ))
}

impl Line {
    pub(super) fn open(end: End, introduction: Introduction) -> Result<Self, Failure> {
        let socket = match end {
            End::Listen(address) => UdpSocket::bind(address),
            // Any port of the same family.
            End::Connect(SocketAddr::V4(_)) => UdpSocket::bind("0.0.0.0:0"),
            End::Connect(SocketAddr::V6(_)) => UdpSocket::bind("[::]:0"),
        };
        let opened = socket.and_then(|socket| {
            socket.set_nonblocking(true)?;
            Ok(socket)
        });
        let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH);
        // A different one each time, practically at random; also different from that of a parallel process.
        let nonce =
            since.map_or(0, |time| time.subsec_nanos()) ^ std::process::id().rotate_left(16);
        Ok(Self {
            socket: opened.map_err(|error| unusable(end, &error))?,
            peer: match end {
                End::Connect(address) => Some(address),
                End::Listen(_) => None,
            },
            state: Peer::new(introduction, nonce),
            buffer: [0; FRAME_MAX],
            strangers: 0,
            refused: None,
        })
    }

    /// Greets until the other side has heard; `false` if somebody asked to stop.
    pub(super) fn meet(
        &mut self,
        end: End,
        patience: Duration,
        stop: &AtomicBool,
    ) -> Result<bool, Failure> {
        let began = Moment::now();
        let mut greeted: Option<Moment> = None;
        while !self.state.is_connected() {
            if stop.load(Ordering::Relaxed) {
                return Ok(false);
            }
            if began.elapsed() > patience {
                return Err(self.nobody(end, patience));
            }
            if greeted.is_none_or(|last| last.elapsed() >= GREET) {
                self.greet();
                greeted = Some(Moment::now());
            }
            while let Some(heard) = self.next()? {
                if heard == PeerMessage::Hello {
                    self.greet();
                }
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        // The other may not know yet.
        self.greet();
        Ok(true)
    }

    fn nobody(&self, end: End, patience: Duration) -> Failure {
        let counters = self.state.counters();
        let strange = counters.corrupt + counters.oversize;
        let seconds = patience.as_secs_f64();
        let text = match (end, strange) {
            (End::Listen(address), 0) => format!(
                "nobody connected to {address} in {seconds} s: start the other side with {CONNECT}"
            ),
            (End::Connect(address), 0) => format!(
                "nobody answers at {address} after {seconds} s: start the other side with {LISTEN} there"
            ),
            (End::Listen(address) | End::Connect(address), _) => format!(
                "the wrong peer at {address}: {strange} datagrams in {seconds} s were not messages of a teleoperation"
            ),
        };
        Failure::device(format_args!("{text}"))
    }

    /// The content of the next datagram; `None` without one.
    pub(super) fn next(&mut self) -> Result<Option<PeerMessage>, Failure> {
        // One more than a frame has: longer ones are cut there, and refused.
        let mut datagram = [0; FRAME_MAX + 1];
        let (length, from) = match self.socket.recv_from(&mut datagram) {
            Ok(received) => received,
            Err(error) if error.kind() == ErrorKind::WouldBlock => return Ok(None),
            // Caused by an earlier datagram: the peer is absent so far, or gone. The silence ends the run in time.
            Err(_) => return Ok(Some(PeerMessage::Nothing)),
        };
        if self.peer.is_some_and(|peer| peer != from) {
            self.strangers += 1;
            self.refuse(&datagram[..length], from);
            return Ok(Some(PeerMessage::Nothing));
        }
        let heard = match self.state.take(&datagram[..length]) {
            Ok(heard) => heard,
            Err(error) => {
                // The other side is to see it too.
                self.peer = Some(from);
                (0..FAREWELLS).for_each(|_| self.greet());
                return Err(Failure::device(format_args!(
                    "{error} ({from}); no force was applied"
                )));
            }
        };
        if matches!(heard, PeerMessage::Hello | PeerMessage::Met) {
            self.peer = Some(from);
        }
        Ok(Some(heard))
    }

    /// Answers another greeter that this side is at work, seldom enough that nobody can keep it busy with that.
    fn refuse(&mut self, datagram: &[u8], from: SocketAddr) {
        if !self.state.is_connected() || self.refused.is_some_and(|last| last.elapsed() < REFUSE) {
            return;
        }
        let mut answer = [0; FRAME_MAX];
        if let Ok(Some(length)) = self.state.busy(datagram, &mut answer) {
            // An answer that cannot be sent is lost: the other asks again.
            let _ = self.socket.send_to(&answer[..length], from);
            self.refused = Some(Moment::now());
        }
    }

    pub(super) fn greet(&mut self) {
        if let Ok(length) = self.state.hello(&mut self.buffer) {
            self.send(length);
        }
    }

    /// A datagram that cannot be sent is lost, as on the line.
    pub(super) fn send(&self, length: usize) {
        if let Some(peer) = self.peer {
            let _ = self.socket.send_to(&self.buffer[..length], peer);
        }
    }

    pub(super) fn farewell(&mut self) {
        for _ in 0..FAREWELLS {
            if let Ok(length) = self.state.bye(&mut self.buffer) {
                self.send(length);
            }
        }
    }
}
