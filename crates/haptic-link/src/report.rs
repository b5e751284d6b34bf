//! Messages of a device to its host: what it is, how it is, what happens to it.

#[cfg(feature = "controllers")]
use crate::controller::ControllerCost;
use crate::{
    configuration::{CoefficientBlock, Configuration},
    limits::Field,
    sample::{Flight, Sample, SampleBatch},
    serial_number::SerialNumber,
};
use haptic_loop::enumerated;
use heapless::Vec;
use postcard_schema::{Schema, schema::NamedType};
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error as _};

/// A message from device to host. The number of a variant is its first byte on the wire, from 0.
/// New variants are added at the end.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub enum DeviceReport {
    /// Answers [`Request::Hello`](crate::Request::Hello).
    Hello(Hello),
    /// The device and its abilities.
    Capabilities(Capabilities),
    /// Answers every request without a report of its own, but not forces.
    Ack(Ack),
    /// Answers [`Request::GetConfiguration`](crate::Request::GetConfiguration) with what is in force.
    Configuration {
        /// All of it but the coefficients, which are asked for in blocks.
        configuration: Configuration,
        /// Over both, see [`DigestBuilder`](crate::DigestBuilder).
        #[serde(with = "postcard::fixint::le")]
        digest: u32,
    },
    /// Sixteen coefficients of the configuration in force.
    Coefficients(CoefficientBlock),
    /// One tick, in a frame of its own.
    Sample(Sample),
    /// Several ticks in a row, to save frames.
    Batch(SampleBatch),
    /// The state of the device has changed without a fault.
    Event(Event),
    /// A fault has latched, once for each.
    Fault(FaultReport),
    /// Counters of ticks, frames and bytes since power-up.
    Statistics(Statistics),
    /// Answers [`Request::KeepAlive`](crate::Request::KeepAlive).
    Alive(Alive),
    /// A sample of the flight recorder.
    Flight(Flight),
    /// The keys of all messages that the device knows.
    Keys(Keys),
    /// The time that a controller takes.
    #[cfg(feature = "controllers")]
    ControllerCost(ControllerCost),
}

impl DeviceReport {
    /// Names of the reports, by number.
    pub const NAMES: [&'static str; REPORTS] = [
        "hello",
        "capabilities",
        "ack",
        "configuration",
        "coefficients",
        "sample",
        "batch",
        "event",
        "fault",
        "statistics",
        "alive",
        "flight",
        "keys",
        #[cfg(feature = "controllers")]
        "controller-cost",
    ];
}

/// The first answer of a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Hello {
    /// The number that the request carried, which matches this answer to it.
    #[serde(with = "postcard::fixint::le")]
    pub nonce: u32,
    /// The number of the connection, which every later frame of the host carries; different for
    /// each nonce, never 0.
    #[serde(with = "postcard::fixint::le")]
    pub connection: u32,
    /// Firmware version: major, minor, patch.
    pub firmware: [u8; 3],
    /// A number that changes with each power-up or reset, if the board can detect it.
    #[serde(with = "postcard::fixint::le")]
    pub boot: u32,
    /// State and fault at the moment of the answer.
    pub status: Status,
    /// [`SerialNumber`] of the device, filled up with zeros; zeros alone if it has none.
    pub serial_number: [u8; SerialNumber::MOST],
}

impl Hello {
    /// The device's own serial number.
    #[must_use]
    pub fn serial_number(&self) -> SerialNumber {
        SerialNumber::of_wire(self.serial_number)
    }
}

/// A device and its abilities.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Capabilities {
    /// Name of the board, UTF-8, filled up with zeros.
    pub board: [u8; 16],
    /// Degrees of freedom, 1 to 3.
    pub axes: u8,
    /// True if the plant is simulated on the device, without actuator or sensor.
    pub simulated: bool,
    /// Shortest period of a tick, µs.
    #[serde(with = "postcard::fixint::le")]
    pub tick_period_min_us: u32,
    /// Longest period of a tick, µs.
    #[serde(with = "postcard::fixint::le")]
    pub tick_period_max_us: u32,
    /// Largest force that the actuator can make, N.
    pub force_max_n: f32,
    /// Largest rate of force, N/s.
    pub force_rate_max_n_per_s: f32,
    /// Distance of one count of the sensor, m; 0 without counts.
    pub position_resolution_m: f32,
    /// Largest force that its force sensor shows either way, N; 0 without one.
    pub sensed_force_max_n: f32,
    /// Number of coefficients that an operator may have here.
    #[serde(with = "postcard::fixint::le")]
    pub coefficients_max: u16,
    /// Room for modes of a full memory.
    #[serde(with = "postcard::fixint::le")]
    pub modes_max: u16,
    /// Largest degree of a recursion.
    #[serde(with = "postcard::fixint::le")]
    pub degree_max: u16,
    /// Samples that the flight recorder keeps.
    #[serde(with = "postcard::fixint::le")]
    pub flight_samples: u16,
    /// [`image_digest`](crate::image_digest) of the running image; 0 if the board has none or does
    /// not report it.
    #[serde(with = "postcard::fixint::le")]
    pub image_digest: u32,
    /// Conduct without a further order. The field has the name of its first bit, which firmware from before the second knows.
    pub lets_go_alone: Conduct,
}

/// Conduct of a device without a further order: one byte on the wire, a bit each, so that firmware which only lets go alone says
/// the same as ever, and a host that does not know of motion takes a device that moves for damaged.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Conduct {
    /// The force falls once the program or the host that commands it falls silent: by a watchdog of the device itself. False where a
    /// driver may hold the last force, or command.
    pub lets_go: bool,
    /// It moves instead of pushing: its position is that of a command, and a hand and the force move it through a virtual body.
    pub moves: bool,
    /// It moves, and its loop is not known yet: until it is measured, a force commands [`MEASURING_DAMPING_N_S_PER_M`] of it, and its
    /// position is that of its sensor.
    pub to_measure: bool,
}

/// Newtons for each metre per second of a robot that is measured: what the hand pushes is not in it.
pub const MEASURING_DAMPING_N_S_PER_M: f32 = 100.0;

impl Serialize for Conduct {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let bits = [self.lets_go, self.moves, self.to_measure].map(u8::from);
        serializer.serialize_u8(bits[0] | bits[1] << 1 | bits[2] << 2)
    }
}

impl<'de> Deserialize<'de> for Conduct {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match u8::deserialize(deserializer)? {
            // Nothing but a robot is measured as one.
            bits @ (0..=3 | 6..=7) => Ok(Self {
                lets_go: bits & 1 != 0,
                moves: bits & 2 != 0,
                to_measure: bits & 4 != 0,
            }),
            _ => Err(D::Error::custom("a conduct of bits 0 to 2")),
        }
    }
}

impl Schema for Conduct {
    const SCHEMA: &'static NamedType = bool::SCHEMA;
}

impl Capabilities {
    /// The board's name as text; `?` if it is not valid text.
    #[must_use]
    pub fn board(&self) -> &str {
        let end = self.board.iter().position(|&byte| byte == 0);
        let name = &self.board[..end.unwrap_or(self.board.len())];
        core::str::from_utf8(name).unwrap_or("?")
    }

    /// A name as the field needs it, cut to 16 bytes.
    #[must_use]
    pub const fn board_name(name: &str) -> [u8; 16] {
        let (bytes, mut board, mut i) = (name.as_bytes(), [0; 16], 0);
        while i < bytes.len() && i < board.len() {
            board[i] = bytes[i];
            i += 1;
        }
        board
    }
}

/// The state of a device, which decides which requests it accepts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum State {
    /// Zero force; parameters can be set.
    #[default]
    Idle,
    /// Zero force, ready to run; needs the host to be there.
    Armed,
    /// The loop is closed; needs the host to be there.
    Running,
    /// The force falls to zero within the stop time.
    Stopping,
    /// A fault is latched: the force falls to zero, or is.
    Fault,
}

impl core::fmt::Display for State {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Idle => "idle",
            Self::Armed => "armed",
            Self::Running => "running",
            Self::Stopping => "stopping",
            Self::Fault => "in a fault",
        })
    }
}

/// State and fault of a device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Status {
    /// The state that the device is in.
    pub state: State,
    /// Code of the latched fault; 0 for none.
    pub fault: u8,
    /// Faults since power-up, modulo 2¹⁶.
    #[serde(with = "postcard::fixint::le")]
    pub faults: u16,
    /// The part that the device's own program had in the latched fault.
    pub reason: Reason,
}

/// The part of a device's own program in a fault, where it has one: of a [bridge](Trouble). It displays as one line with the remedy.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Reason {
    /// Kind of the trouble, [`Trouble::Nothing`] for a device without such a program.
    pub trouble: Trouble,
    /// Time between calls as it was measured, µs; 0 where no time is in question.
    #[serde(with = "postcard::fixint::le")]
    pub measured_us: u32,
    /// That time as the program declared or gave it, µs.
    #[serde(with = "postcard::fixint::le")]
    pub told_us: u32,
}

enumerated! {
    /// Trouble with the calls of a program that is a device.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
    pub enum Trouble {
        /// No trouble, or a device without such a program.
        #[default]
        Nothing,
        /// A position that is NaN, infinite, or beyond single precision.
        Position,
        /// A time that is not later than that of the call before.
        Time,
        /// No position was given, or no room for the force.
        Missing,
        /// The library itself failed, which is a defect of it: it does not tick again.
        Library,
        /// Calls are further apart than was declared.
        Slow,
        /// The time that is given passes much more slowly than that of the machine: it is in another unit.
        Unit,
    }
}

impl Reason {
    /// A trouble in which no time is in question.
    #[must_use]
    pub const fn of(trouble: Trouble) -> Self {
        Self {
            trouble,
            measured_us: 0,
            told_us: 0,
        }
    }

    /// Itself, unless there is no trouble.
    #[must_use]
    pub fn some(self) -> Option<Self> {
        (self.trouble != Trouble::Nothing).then_some(self)
    }
}

impl core::fmt::Display for Reason {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self {
            trouble,
            measured_us,
            told_us,
        } = self;
        f.write_str(match trouble {
            Trouble::Nothing => "",
            Trouble::Position => {
                "a position was not a finite number: check the sensor, then arm again"
            }
            Trouble::Time => {
                "the time stood still or went back: give the microseconds of a clock that only goes on"
            }
            Trouble::Missing => {
                "a tick had no position or no room for its force: pass arrays of three numbers"
            }
            Trouble::Library => {
                "the library failed and has let go for good: close it, open it again, and report this"
            }
            Trouble::Slow => {
                return write!(
                    f,
                    "calls of hb_tick were {measured_us} µs apart, and {told_us} µs were declared: call hb_wait before each, or declare the true sample_time_us"
                );
            }
            Trouble::Unit => {
                return write!(
                    f,
                    "the time given to hb_tick went on by {told_us} in {measured_us} µs: give it in microseconds, as hb_wait returns it"
                );
            }
        })
    }
}

/// A change of state, with its moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Event {
    /// Kind of the change.
    pub kind: EventKind,
    /// Number of the tick at which it was detected.
    #[serde(with = "postcard::fixint::le")]
    pub tick: u32,
    /// The device's own time since power-up, µs.
    #[serde(with = "postcard::fixint::le")]
    pub time_us: u64,
}

/// The kind of an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum EventKind {
    /// A configuration took effect, for a run or to last.
    Configured,
    /// The device was armed and waits for a start.
    Armed,
    /// A run began; its ticks count from 0.
    Started,
    /// A run had all its ticks and its force has fallen to zero.
    Finished,
    /// A run was stopped and its force has fallen to zero.
    Stopped,
    /// Disarmed, and the force has fallen to zero.
    Disarmed,
    /// Disarmed by the device's own program, and the force has fallen to zero.
    Withdrawn,
}

/// A fault that has latched, with its moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct FaultReport {
    /// The state, the code of the fault, and how many faults there were.
    pub status: Status,
    /// Number of the tick at which it was seen.
    #[serde(with = "postcard::fixint::le")]
    pub tick: u32,
    /// The device's own time since power-up, µs.
    #[serde(with = "postcard::fixint::le")]
    pub time_us: u64,
}

/// The answer to a keep-alive: the device is there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Alive {
    /// The number that the request carried, so that its answer is known.
    #[serde(with = "postcard::fixint::le")]
    pub token: u32,
    /// The device's own time since power-up, µs.
    #[serde(with = "postcard::fixint::le")]
    pub time_us: u64,
    /// State and fault at the moment of the answer.
    pub status: Status,
    /// Energy that the passivity guard has observed, J: positive if the device gave it to the loop; 0 without
    /// a guard.
    pub observed_energy_j: f32,
}

/// Counters since power-up for everything that the device receives and sends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Statistics {
    /// Ticks that were done; periods that were skipped do not count.
    #[serde(with = "postcard::fixint::le")]
    pub ticks: u32,
    /// Ticks that began a whole period late or took longer than one.
    #[serde(with = "postcard::fixint::le")]
    pub overruns: u32,
    /// Longest tick, processor cycles; 0 without a cycle counter.
    #[serde(with = "postcard::fixint::le")]
    pub tick_cycles_max: u32,
    /// Time of the last tick, processor cycles.
    #[serde(with = "postcard::fixint::le")]
    pub tick_cycles_last: u32,
    /// Ticks of a host loop in which no new force had arrived.
    #[serde(with = "postcard::fixint::le")]
    pub stale_forces: u32,
    /// Samples dropped because the queue was full.
    #[serde(with = "postcard::fixint::le")]
    pub samples_dropped: u32,
    /// Frames that the device has sent.
    #[serde(with = "postcard::fixint::le")]
    pub sent: u32,
    /// Frames received intact.
    #[serde(with = "postcard::fixint::le")]
    pub received: u32,
    /// Frames damaged, cut, of no known kind, or not in their one form.
    #[serde(with = "postcard::fixint::le")]
    pub corrupt: u32,
    /// Frames longer than the buffer.
    #[serde(with = "postcard::fixint::le")]
    pub oversize: u32,
    /// Frames of another protocol version.
    #[serde(with = "postcard::fixint::le")]
    pub foreign: u32,
    /// Numbers missing from the sequence of those received.
    #[serde(with = "postcard::fixint::le")]
    pub lost: u32,
    /// Frames that arrived twice; each was acted on once.
    #[serde(with = "postcard::fixint::le")]
    pub duplicate: u32,
    /// Frames that arrived after a later one.
    #[serde(with = "postcard::fixint::le")]
    pub late: u32,
    /// Bytes that the hardware received but the firmware did not fetch in time.
    #[serde(with = "postcard::fixint::le")]
    pub bytes_overrun: u32,
    /// Frames of a connection that the device does not know.
    #[serde(with = "postcard::fixint::le")]
    pub strangers: u32,
    /// Ticks in which a board connected over a separate line did not answer.
    #[serde(with = "postcard::fixint::le")]
    pub unanswered: u32,
    /// Forces that such a board did not confirm.
    #[serde(with = "postcard::fixint::le")]
    pub forces_not_taken: u32,
    /// Mean period of the ticks over the last 2 s, ns; 0 where it is not measured.
    #[serde(with = "postcard::fixint::le")]
    pub period_ns: u32,
}

impl Statistics {
    /// The counts since `before`. Counters wrap at 2³², so a reset in between gives large numbers,
    /// never a failure. The longest and last tick and the period are taken from `self`.
    #[must_use]
    pub const fn since(&self, before: &Self) -> Self {
        Self {
            ticks: self.ticks.wrapping_sub(before.ticks),
            overruns: self.overruns.wrapping_sub(before.overruns),
            tick_cycles_max: self.tick_cycles_max,
            tick_cycles_last: self.tick_cycles_last,
            stale_forces: self.stale_forces.wrapping_sub(before.stale_forces),
            samples_dropped: self.samples_dropped.wrapping_sub(before.samples_dropped),
            sent: self.sent.wrapping_sub(before.sent),
            received: self.received.wrapping_sub(before.received),
            corrupt: self.corrupt.wrapping_sub(before.corrupt),
            oversize: self.oversize.wrapping_sub(before.oversize),
            foreign: self.foreign.wrapping_sub(before.foreign),
            lost: self.lost.wrapping_sub(before.lost),
            duplicate: self.duplicate.wrapping_sub(before.duplicate),
            late: self.late.wrapping_sub(before.late),
            bytes_overrun: self.bytes_overrun.wrapping_sub(before.bytes_overrun),
            strangers: self.strangers.wrapping_sub(before.strangers),
            unanswered: self.unanswered.wrapping_sub(before.unanswered),
            forces_not_taken: self.forces_not_taken.wrapping_sub(before.forces_not_taken),
            period_ns: self.period_ns,
        }
    }
}

/// Number of reports, the first ones, that every device sends.
pub(crate) const COMMON_REPORTS: usize = 13;
pub(crate) const REPORTS: usize =
    COMMON_REPORTS + if cfg!(feature = "controllers") { 1 } else { 0 };

/// Most messages of one direction that a list of keys can hold.
pub const KEYS_MAX: usize = 24;

/// Hash of a message definition: FNV-1a of 64 bits over its name and the names and types of its fields, as
/// `postcard-schema` defines it; both halves xored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct MessageKey(#[serde(with = "postcard::fixint::le")] pub u32);

/// The keys of all messages, indexed by message number.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct Keys {
    /// Keys of the requests, indexed by message number.
    pub requests: Vec<MessageKey, KEYS_MAX>,
    /// Keys of the reports, indexed by message number.
    pub reports: Vec<MessageKey, KEYS_MAX>,
}

/// The answer to a request.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct Ack {
    /// Lower half of the request's sequence number.
    #[serde(with = "postcard::fixint::le")]
    pub sequence: u16,
    /// First byte of the request.
    pub request: u8,
    /// Acceptance of the request, or the reason for its refusal.
    pub outcome: Outcome,
}

/// Acceptance of a request, or the reason for its refusal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub enum Outcome {
    /// The request was carried out, or was true already.
    Done,
    /// The request was refused, and nothing has changed.
    Refused(Refusal),
}

/// Why a request was refused.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub enum Refusal {
    /// The device takes no such request in this state.
    State(State),
    /// A parameter outside the range of this device.
    Range {
        /// The field whose value was refused.
        field: Field,
        /// The value as it was sent.
        value: f32,
        /// Least value that this device takes.
        least: f32,
        /// Largest value that this device takes.
        most: f32,
    },
    /// The digest is not that of what is staged: something was lost on the way.
    Digest,
    /// Nothing is staged, or not all coefficients.
    Incomplete,
    /// This board cannot do what the field asks for.
    Unsupported(Field),
    /// A fault has latched that the host does not know of yet.
    UnknownFault,
    /// The force has not fallen to zero yet.
    ForceNotZero,
    /// The force at this position would be larger than a start allows.
    ForceNotSmall {
        /// Magnitude of the force that the law wants here, N.
        wanted_n: f32,
        /// Largest allowed at a start, N.
        allowed_n: f32,
    },
    /// The condition of this fault still holds, as an open emergency stop.
    FaultPersists(u8),
    /// The device does not know this connection, or another one has armed it.
    Connection,
    /// A limit of a configuration for a run is looser than what was set to last.
    Looser(Field),
}

impl Refusal {
    /// A refusal of a value outside `least` to `most`.
    #[must_use]
    pub const fn range(field: Field, value: f32, least: f32, most: f32) -> Self {
        Self::Range {
            field,
            value,
            least,
            most,
        }
    }
}
