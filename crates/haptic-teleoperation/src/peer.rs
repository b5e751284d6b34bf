//! The peer at the other end: greeting, frames, and those that do not belong to this connection.

use haptic_link::{
    Architecture, Direction, EncodeError, HandHello, HandMessage, HandSample, HandSide, Header,
    LineCounters, PROTOCOL_VERSION, Receiver, encode,
};

/// Description of this side, for the other to agree with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Introduction {
    /// The hand of this side: the two must differ.
    pub side: HandSide,
    /// The law of the line, which is the same on both sides.
    pub architecture: Architecture,
    /// T, s: the same on both sides, to the bit.
    pub sample_time_s: f64,
    /// b of waves, N·s/m; 0 for other architectures.
    pub wave_impedance_n_s_per_m: f64,
    /// Digest of the coupler, its order and its scheme ([`hand_digest`](haptic_link::hand_digest)); 0 for waves.
    pub coupler_digest: u32,
}

/// Why two sides do not fit each other: one line, with the remedy.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum PeerError {
    /// It speaks another version of the protocol.
    OtherVersion {
        /// The version that the other side speaks.
        version: u8,
    },
    /// It was built with other definitions of the messages.
    OtherMessages,
    /// It is on the same side.
    SameSide(HandSide),
    /// It is of another architecture.
    OtherArchitecture {
        /// Architecture of the other side.
        theirs: Architecture,
        /// Architecture of this one.
        ours: Architecture,
    },
    /// It has another sample time.
    OtherSampleTime {
        /// Sample time of the other side, s.
        theirs_s: f64,
        /// Sample time of this one, s.
        ours_s: f64,
    },
    /// Its coupler has other gains, another order or another scheme.
    OtherCoupler,
    /// It is at work with somebody else.
    Busy,
    /// It has another wave impedance.
    OtherImpedance {
        /// Impedance of the other side, N·s/m.
        theirs: f64,
        /// Impedance of this one, N·s/m.
        ours: f64,
    },
}

impl core::fmt::Display for PeerError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::OtherVersion { version } => write!(
                f,
                "the other side speaks version {version} of the protocol, this one {PROTOCOL_VERSION}: run the same version on \
                 both sides"
            ),
            Self::OtherMessages => f.write_str(
                "the other side was built with other messages: run the same version on both sides",
            ),
            Self::SameSide(side) => write!(
                f,
                "both sides are the {side}: one has to listen and the other to connect"
            ),
            Self::OtherArchitecture { theirs, ours } => write!(
                f,
                "the other side has the architecture {theirs}, this one {ours}: give both the same `architecture`"
            ),
            Self::OtherSampleTime { theirs_s, ours_s } => write!(
                f,
                "the other side has a sample time of {theirs_s} s, this one of {ours_s} s: give both the same `sample_time_s`"
            ),
            Self::OtherCoupler => f.write_str(
                "the other side has another coupler: give both the same `coupler_stiffness_n_per_m`, \
                 `coupler_dissipation_n_s_mu_per_m`, `order` and `scheme`, best the same file",
            ),
            Self::Busy => f.write_str(
                "the other side is busy: it is at work with somebody else; wait until that has ended, or use another port",
            ),
            Self::OtherImpedance { theirs, ours } => write!(
                f,
                "the other side has a wave impedance of {theirs} N·s/m, this one of {ours} N·s/m: give both the same \
                 `wave_impedance_n_s_per_m`"
            ),
        }
    }
}

impl core::error::Error for PeerError {}

/// The part of a datagram that concerns this connection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PeerMessage {
    /// Nothing that belongs to this connection.
    Nothing,
    /// The other side has introduced itself, and wants an answer.
    Hello,
    /// The other side has heard this one: no answer.
    Met,
    /// A tick of the other side.
    Sample(HandSample),
    /// The other side has gone.
    Bye,
}

/// The conversation with the other side, without a socket.
///
/// ```text
/// each side   hello(own number, number heard) ─▶   until it has heard its own number back, or a sample
/// then        samples, each under both numbers ─▶   and a bye at the end
/// ```
/// *Another connection*: samples and byes carry the xor of both numbers; others are counted, not acted on.
#[derive(Clone, Debug)]
pub struct Peer {
    /// The greeting: it says whom this side has heard.
    hello: HandHello,
    theirs: Option<u32>,
    connected: bool,
    sequence: u32,
    receiver: Receiver<HandMessage>,
    other_connections: u32,
}

impl Peer {
    /// A peer before its connection. `nonce` is any number that differs each time; 0 is treated as
    /// 1.
    #[must_use]
    pub fn new(introduction: Introduction, nonce: u32) -> Self {
        Self {
            hello: HandHello {
                key: HandHello::KEY,
                nonce: nonce.max(1),
                heard: 0,
                side: introduction.side,
                architecture: introduction.architecture,
                sample_time_s: introduction.sample_time_s,
                wave_impedance_n_s_per_m: introduction.wave_impedance_n_s_per_m,
                coupler_digest: introduction.coupler_digest,
            },
            theirs: None,
            connected: false,
            sequence: 0,
            receiver: Receiver::new(Direction::FromHost),
            other_connections: 0,
        }
    }

    /// Takes a datagram, which is one frame.
    ///
    /// # Errors
    /// A side that does not fit this one.
    pub fn take(&mut self, datagram: &[u8]) -> Result<PeerMessage, PeerError> {
        self.receiver.forget();
        let foreign = self.receiver.counters().foreign;
        let mut arrived = None;
        for &byte in datagram {
            arrived = arrived.or(self.receiver.push(byte));
        }
        let counters = self.receiver.counters();
        if counters.foreign != foreign && self.theirs.is_none() {
            // The high bit says who speaks.
            let version = counters.foreign_version & 0x7f;
            return Err(PeerError::OtherVersion { version });
        }
        let Some((header, message)) = arrived else {
            return Ok(PeerMessage::Nothing);
        };
        match message {
            HandMessage::Hello(hello) => return self.greeted(&hello),
            HandMessage::Busy { heard } if heard == self.hello.nonce && !self.connected => {
                return Err(PeerError::Busy);
            }
            HandMessage::Sample(_) | HandMessage::Bye | HandMessage::Busy { .. } => {}
        }
        if self.connection() != Some(header.connection) {
            self.other_connections = self.other_connections.wrapping_add(1);
            return Ok(PeerMessage::Nothing);
        }
        self.connected = true;
        Ok(match message {
            HandMessage::Sample(sample) => PeerMessage::Sample(sample),
            HandMessage::Bye => PeerMessage::Bye,
            HandMessage::Hello(_) | HandMessage::Busy { .. } => PeerMessage::Nothing,
        })
    }

    /// Writes an answer to a stranger's datagram, which says that this side is busy with another
    /// peer, and returns its length; `None` for a datagram that needs no answer.
    ///
    /// # Errors
    /// As [`hello`](Self::hello).
    pub fn busy(&mut self, datagram: &[u8], line: &mut [u8]) -> Result<Option<usize>, EncodeError> {
        // Apart from the frames of this conversation.
        let mut receiver = Receiver::<HandMessage>::new(Direction::FromHost);
        let arrived = datagram.iter().find_map(|&byte| receiver.push(byte));
        let Some((_, HandMessage::Hello(hello))) = arrived else {
            return Ok(None);
        };
        let heard = hello.nonce;
        self.write(HandMessage::Busy { heard }, 0, line).map(Some)
    }

    fn greeted(&mut self, hello: &HandHello) -> Result<PeerMessage, PeerError> {
        if self.theirs.is_some_and(|theirs| theirs != hello.nonce) {
            // Another peer, or this one restarted: this conversation continues or falls silent.
            self.other_connections = self.other_connections.wrapping_add(1);
            return Ok(PeerMessage::Nothing);
        }
        self.agree(hello)?;
        self.theirs = Some(hello.nonce);
        self.hello.heard = hello.nonce;
        if hello.heard == self.hello.nonce {
            // It has heard this side: an answer would be answered in turn, for ever.
            self.connected = true;
            return Ok(PeerMessage::Met);
        }
        Ok(PeerMessage::Hello)
    }

    fn agree(&self, hello: &HandHello) -> Result<(), PeerError> {
        let ours = &self.hello;
        if hello.key != HandHello::KEY {
            return Err(PeerError::OtherMessages);
        }
        if hello.side == ours.side {
            return Err(PeerError::SameSide(ours.side));
        }
        if hello.architecture != ours.architecture {
            return Err(PeerError::OtherArchitecture {
                theirs: hello.architecture,
                ours: ours.architecture,
            });
        }
        if hello.coupler_digest != ours.coupler_digest {
            return Err(PeerError::OtherCoupler);
        }
        let differ = |a: f64, b: f64| a.to_bits() != b.to_bits();
        if differ(hello.sample_time_s, ours.sample_time_s) {
            return Err(PeerError::OtherSampleTime {
                theirs_s: hello.sample_time_s,
                ours_s: ours.sample_time_s,
            });
        }
        let impedances = [hello, ours].map(|hello| hello.wave_impedance_n_s_per_m);
        let [theirs, ours] = impedances;
        if differ(theirs, ours) {
            return Err(PeerError::OtherImpedance { theirs, ours });
        }
        Ok(())
    }

    /// The side that it is.
    #[must_use]
    pub const fn side(&self) -> HandSide {
        self.hello.side
    }

    /// Both numbers, once both are known.
    fn connection(&self) -> Option<u32> {
        self.theirs.map(|theirs| theirs ^ self.hello.nonce)
    }

    /// True once the other side is known to have heard this one.
    #[must_use]
    pub const fn is_connected(&self) -> bool {
        self.connected
    }

    /// Writes the greeting and returns its length.
    ///
    /// # Errors
    /// A buffer that is too short: [`FRAME_MAX`](haptic_link::FRAME_MAX) bytes are enough.
    pub fn hello(&mut self, line: &mut [u8]) -> Result<usize, EncodeError> {
        self.write(HandMessage::Hello(self.hello), 0, line)
    }

    /// Writes a tick; its length.
    ///
    /// # Errors
    /// As [`hello`](Self::hello).
    pub fn sample(&mut self, sample: HandSample, line: &mut [u8]) -> Result<usize, EncodeError> {
        let connection = self.connection().unwrap_or(0);
        self.write(HandMessage::Sample(sample), connection, line)
    }

    /// Writes a farewell; its length.
    ///
    /// # Errors
    /// As [`hello`](Self::hello).
    pub fn bye(&mut self, line: &mut [u8]) -> Result<usize, EncodeError> {
        let connection = self.connection().unwrap_or(0);
        self.write(HandMessage::Bye, connection, line)
    }

    fn write(
        &mut self,
        message: HandMessage,
        connection: u32,
        line: &mut [u8],
    ) -> Result<usize, EncodeError> {
        self.sequence = self.sequence.wrapping_add(1);
        encode(&message, Header::from_host(self.sequence, connection), line)
    }

    /// Frames so far, by kind.
    #[must_use]
    pub const fn counters(&self) -> LineCounters {
        self.receiver.counters()
    }

    /// Messages of other connections, or of somebody else, that were not acted on.
    #[must_use]
    pub const fn other_connections(&self) -> u32 {
        self.other_connections
    }
}
