//! Contents of a log: the messages of one axis and of events, their ROS 2 schemas, their CDR bytes.
//!
//! A message on the wire is the 4-byte encapsulation header `00 01 00 00` (plain CDR, little
//! endian, no options) and the fields in order, each aligned to its size counted from the end of
//! that header. The schema text and the struct say the same thing twice; a test compares them.

use byteorder::LittleEndian;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// Plain CDR, little endian, no options.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// One control tick. Lengths in m, forces in N, time in s; forces as the recorder was given them,
/// NaN included.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TickMessage {
    /// Number of the tick, counted by the device from the start of the run.
    pub tick: u64,
    /// Device time, s.
    pub time_s: f64,
    /// Commanded position of the indenter, m.
    pub reference_m: f64,
    /// Position of the indenter, m.
    pub indenter_position_m: f64,
    /// Position of the actuator that renders the environment, m.
    pub position_m: f64,
    /// Force the environment asked for, N.
    pub environment_force_n: f64,
    /// Force that left the safety chain and was commanded, in answer to this position, N.
    pub commanded_force_n: f64,
    /// Force that the device made in this tick, N: in a loop on the host it answers an earlier position.
    pub applied_force_n: f64,
    /// Force between the two actuators, N.
    pub contact_force_n: f64,
    /// Limiters that acted, as bits: 1 magnitude, 2 rate, 4 fault, 8 stopping, 16 start-up, 32 workspace,
    /// 64 velocity, 128 passivity guard.
    pub limiters: u8,
    /// What is wrong with this tick, bits of [`flaw`](super::flaw); 0 for a tick in order.
    pub flaws: u8,
    /// Energy that the passivity guard has observed, J: positive if the device gave it to the loop. NaN
    /// without a guard, and from a device that does not send it.
    pub observed_energy_j: f64,
}

/// Name of a number, and the number.
pub type TickField = (&'static str, fn(&TickMessage) -> f64);

/// Fields of a tick with their names: positions and forces, and those before and after them.
macro_rules! named {
    ($($before:ident),* ; $($after:ident),*) => {
        named![
            $($before,)*
            reference_m, indenter_position_m, position_m, environment_force_n, commanded_force_n, applied_force_n,
            contact_force_n,
            $($after),*
        ]
    };
    ($($field:ident),* $(,)?) => { [$((stringify!($field), |tick| tick.$field)),*] };
}
pub(super) use named;

impl TickMessage {
    /// The numbers in their order.
    pub const NUMBERS: [TickField; 9] = named![time_s; observed_energy_j];
}

/// Something worth a sentence: a phase begins, a fault latches, samples were dropped.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct EventMessage {
    /// Device time, s.
    pub time_s: f64,
    /// Kind of the event: one word, lower case.
    pub kind: String,
    /// The sentence.
    pub text: String,
}

/// A message that is not what its schema promises.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MessageError {
    /// Too short for its header, or a byte order this reader does not know.
    #[error("message does not start with the CDR header 00 01 00 00 (little endian)")]
    Encapsulation,
    /// The fields could not be written or read.
    #[error("message is not valid CDR: {0}")]
    Cdr(#[from] cdr_encoding::Error),
    /// Vectors of another length, or of several.
    #[error(
        "a tick with {axes} axes, or with vectors of several lengths, is not one of 2 or 3 axes"
    )]
    Axes {
        /// Length of its position.
        axes: usize,
    },
}

/// A message type of the log: where it goes and how a reader understands it.
pub(crate) trait LogMessage: Serialize + DeserializeOwned {
    /// MCAP topic.
    const TOPIC: &'static str;
    /// ROS 2 type name.
    const SCHEMA_NAME: &'static str;
    /// ROS 2 message definition.
    const SCHEMA: &'static str;

    /// Appends the CDR bytes of this message to `buffer`, which is cleared first.
    fn encode_into(&self, buffer: &mut Vec<u8>) -> Result<(), MessageError> {
        buffer.clear();
        buffer.extend_from_slice(&ENCAPSULATION);
        // Alignment counts from the end of the header, hence a writer of its own for the fields.
        cdr_encoding::to_writer::<Self, LittleEndian, _>(buffer, self)?;
        Ok(())
    }

    /// Reads a message from its CDR bytes.
    fn decode(bytes: &[u8]) -> Result<Self, MessageError> {
        decode_fields(bytes)
    }
}

/// Reads fields behind the header.
pub(super) fn decode_fields<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, MessageError> {
    let fields = bytes
        .strip_prefix(&ENCAPSULATION)
        .ok_or(MessageError::Encapsulation)?;
    let (message, _) = cdr_encoding::from_bytes::<T, LittleEndian>(fields)?;
    Ok(message)
}

impl LogMessage for TickMessage {
    const TOPIC: &'static str = "/haptics/tick";
    const SCHEMA_NAME: &'static str = "haptics_msgs/msg/Tick";
    const SCHEMA: &'static str = "\
# One control tick of a haptic experiment.
uint64 tick                  # number of the tick, counted by the device from the start of the run
float64 time_s               # device time, s
float64 reference_m          # where the indenter was told to be, m
float64 indenter_position_m  # where the indenter was, m
float64 position_m           # position of the actuator that renders the environment, m
float64 environment_force_n  # force the environment asked for, N
float64 commanded_force_n    # force that left the safety chain, in answer to this position, N
float64 applied_force_n      # force that the device made in this tick, N
float64 contact_force_n      # force between the two actuators, N
uint8 limiters               # limiters that acted, bits: 1 magnitude, 2 rate, 4 fault, 8 stopping, \
16 start-up, 32 workspace, 64 velocity, 128 passivity guard
uint8 flaws                  # bits: 1 the board did not answer, so the position is old, 2 it may not have taken the force \
of the tick before, 4 an older force of the host acted, 8 what the device told cannot be
float64 observed_energy_j    # energy that the passivity guard has observed, J; NaN if there is none
";
}

impl LogMessage for EventMessage {
    const TOPIC: &'static str = "/haptics/event";
    const SCHEMA_NAME: &'static str = "haptics_msgs/msg/Event";
    const SCHEMA: &'static str = "\
# Something worth a sentence during a haptic experiment.
float64 time_s  # device time, s
string kind     # what sort of event, one word
string text     # the sentence
";
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tick() -> TickMessage {
        TickMessage {
            tick: 0x0102_0304_0506_0708,
            time_s: 0.5,
            reference_m: 1.0,
            indenter_position_m: -2.0,
            position_m: 3.0,
            environment_force_n: 4.0,
            commanded_force_n: 5.0,
            applied_force_n: 5.5,
            contact_force_n: -0.0,
            limiters: 9,
            flaws: 3,
            observed_energy_j: -6.0,
        }
    }

    #[test]
    fn a_tick_is_92_bytes_of_little_endian_cdr() {
        let mut bytes = vec![0xff; 3];
        tick().encode_into(&mut bytes).expect("encodes");
        let mut expected = vec![0, 1, 0, 0, 8, 7, 6, 5, 4, 3, 2, 1];
        for field in [0.5, 1.0, -2.0, 3.0, 4.0, 5.0, 5.5, -0.0_f64] {
            expected.extend_from_slice(&field.to_le_bytes());
        }
        // Six bytes bring the next field to a multiple of its size.
        expected.extend([9, 3, 0, 0, 0, 0, 0, 0]);
        expected.extend_from_slice(&(-6.0_f64).to_le_bytes());
        assert_eq!(bytes, expected);
        assert_eq!(bytes.len(), 92);
        assert_eq!(TickMessage::decode(&bytes).expect("decodes"), tick());
    }

    #[test]
    fn an_event_keeps_its_text_whatever_the_script() {
        let event = EventMessage {
            time_s: 1.25,
            kind: "phase".into(),
            text: "Rampe beendet, μ = 0,2247".into(),
        };
        let mut bytes = Vec::new();
        event.encode_into(&mut bytes).expect("encodes");
        assert_eq!(EventMessage::decode(&bytes).expect("decodes"), event);
    }

    #[test]
    fn a_cut_message_or_another_byte_order_is_an_error_and_no_panic() {
        let mut bytes = Vec::new();
        tick().encode_into(&mut bytes).expect("encodes");
        for length in 0..bytes.len() {
            assert!(
                TickMessage::decode(&bytes[..length]).is_err(),
                "{length} bytes"
            );
        }
        bytes[1] = 0;
        assert!(matches!(
            TickMessage::decode(&bytes),
            Err(MessageError::Encapsulation)
        ));
    }

    #[test]
    fn the_schema_names_the_fields_of_the_struct_in_order() {
        // CSV takes its header from the struct, so it is a second witness of the field names.
        let mut csv = csv::Writer::from_writer(Vec::new());
        csv.serialize(tick()).expect("serialises");
        let text = String::from_utf8(csv.into_inner().expect("flushes")).expect("is UTF-8");
        let header = text.lines().next().expect("has a header");
        let fields: Vec<&str> = TickMessage::SCHEMA
            .lines()
            .filter(|line| !line.starts_with('#'))
            .filter_map(|line| line.split_whitespace().nth(1))
            .collect();
        assert_eq!(header, fields.join(","));
    }
}
