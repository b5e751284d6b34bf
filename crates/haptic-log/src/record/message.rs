//! What a log holds: messages as plain CDR, and metadata.
//!
//! A message on the wire is the 4-byte encapsulation header `00 01 00 00` (plain CDR, little
//! endian, no options) and the fields in order, each aligned to its size counted from the end of
//! that header.

use serde::Serialize;
use std::collections::BTreeMap;

/// Plain CDR, little endian, no options.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// Something worth a sentence: a phase begins, a fault latches, samples were dropped.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct EventMessage {
    /// Device time, s.
    pub time_s: f64,
    /// Kind of the event: one word, lower case.
    pub kind: String,
    /// The sentence.
    pub text: String,
}

/// A named set of strings: parameters, versions, statistics.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct MetadataRecord {
    /// Subject of the strings.
    pub name: String,
    /// The strings by key.
    pub values: BTreeMap<String, String>,
}

/// A message that is not what its schema promises.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MessageError {
    /// Too short for its header, or a byte order this reader does not know.
    #[error("message does not start with the CDR header 00 01 00 00 (little endian)")]
    Encapsulation,
    /// Fields that end too early or too late, or text that is not UTF-8.
    #[error("message does not have the fields of its schema")]
    Fields,
    /// Vectors of several lengths, in a tick or in a log.
    #[error("all ticks of a log have the same number of axes, in each of their vectors")]
    Axes,
}

/// A message type of the log: where it goes and how a reader understands it.
pub(crate) trait LogMessage: Sized {
    /// MCAP topic.
    const TOPIC: &'static str;

    /// ROS 2 type name and message definition.
    fn schema(&self) -> (String, String);

    /// Device time, s.
    fn time_s(&self) -> f64;

    /// Puts the CDR bytes of this message into `buffer`, which is cleared first.
    fn encode_into(&self, buffer: &mut Vec<u8>) -> Result<(), MessageError>;

    /// Reads a message from its CDR bytes.
    fn decode(bytes: &[u8]) -> Result<Self, MessageError>;
}

pub(super) fn begin(buffer: &mut Vec<u8>) {
    buffer.clear();
    buffer.extend(ENCAPSULATION);
}

/// Puts in the bytes of a number, at a multiple of their count.
pub(super) fn put<const N: usize>(buffer: &mut Vec<u8>, bytes: [u8; N]) {
    let behind_header = buffer.len() - ENCAPSULATION.len();
    buffer.resize(ENCAPSULATION.len() + behind_header.next_multiple_of(N), 0);
    buffer.extend(bytes);
}

/// Reads fields behind the header.
#[derive(Clone, Copy)]
pub(super) struct Cdr<'a> {
    fields: &'a [u8],
    at: usize,
}

impl<'a> Cdr<'a> {
    pub(super) fn of(message: &'a [u8]) -> Result<Self, MessageError> {
        let fields = message.strip_prefix(&ENCAPSULATION);
        let fields = fields.ok_or(MessageError::Encapsulation)?;
        Ok(Self { fields, at: 0 })
    }

    pub(super) fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let start = self.at.next_multiple_of(N);
        self.at = start + N;
        self.fields.get(start..self.at)?.try_into().ok()
    }

    pub(super) fn number(&mut self) -> Option<f64> {
        self.take().map(f64::from_le_bytes)
    }

    /// A text: its length with the zero at its end, its bytes, and that.
    fn text(&mut self) -> Option<String> {
        let length = u32::from_le_bytes(self.take()?) as usize;
        let bytes = self.fields[self.at..].get(..length)?;
        self.at += length;
        String::from_utf8(bytes.strip_suffix(&[0])?.to_vec()).ok()
    }

    pub(super) const fn is_at_end(&self) -> bool {
        self.at == self.fields.len()
    }
}

impl EventMessage {
    fn of(mut fields: Cdr<'_>) -> Option<Self> {
        Some(Self {
            time_s: fields.number()?,
            kind: fields.text()?,
            text: fields.text()?,
        })
    }
}

impl LogMessage for EventMessage {
    const TOPIC: &'static str = "/haptics/event";

    fn schema(&self) -> (String, String) {
        let text = "\
# Something worth a sentence during a haptic experiment.
float64 time_s  # device time, s
string kind     # what sort of event, one word
string text     # the sentence
";
        ("haptics_msgs/msg/Event".to_owned(), text.to_owned())
    }

    fn time_s(&self) -> f64 {
        self.time_s
    }

    fn encode_into(&self, buffer: &mut Vec<u8>) -> Result<(), MessageError> {
        begin(buffer);
        put(buffer, self.time_s.to_le_bytes());
        for text in [&self.kind, &self.text] {
            let length = u32::try_from(text.len() + 1).map_err(|_| MessageError::Fields)?;
            put(buffer, length.to_le_bytes());
            buffer.extend_from_slice(text.as_bytes());
            buffer.push(0);
        }
        Ok(())
    }

    fn decode(bytes: &[u8]) -> Result<Self, MessageError> {
        Self::of(Cdr::of(bytes)?).ok_or(MessageError::Fields)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_event_keeps_its_text_whatever_the_script() {
        let event = EventMessage {
            time_s: 1.25,
            kind: "phase".into(),
            text: "μ = 0,2".into(),
        };
        let mut bytes = Vec::new();
        event.encode_into(&mut bytes).expect("encodes");
        let mut expected = vec![0, 1, 0, 0];
        expected.extend(1.25_f64.to_le_bytes());
        // Each text with its length, and padded to that of the next.
        expected.extend(b"\x06\0\0\0phase\0\0\0\x09\0\0\0\xce\xbc = 0,2\0");
        assert_eq!(bytes, expected);
        assert_eq!(EventMessage::decode(&bytes).expect("decodes"), event);
        for length in 0..bytes.len() {
            assert!(EventMessage::decode(&bytes[..length]).is_err(), "{length}");
        }
        bytes[12..16].copy_from_slice(&[0xff; 4]);
        assert!(EventMessage::decode(&bytes).is_err());
    }
}
