//! Messages of a log as plain CDR, and its metadata. A message is the header `00 01 00 00` (plain CDR, little
//! endian, no options) and its fields in order, each aligned to its size counted from the end of that header.

use serde::Serialize;
use std::{cell::Cell, collections::BTreeMap};

/// Plain CDR, little endian, no options.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// Something worth a sentence: a phase begins, a fault latches, samples were dropped.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct EventMessage {
    /// Time on the clock of the device, s, from its first tick.
    pub time_s: f64,
    /// Kind of the event: one word, lower case.
    pub kind: String,
    /// A sentence for people; any script.
    pub text: String,
}

/// A named set of strings: parameters, versions, statistics.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct MetadataRecord {
    /// Subject of the strings, as `experiment`; a name may occur more than once.
    pub name: String,
    /// The strings by key, in the order of the keys.
    pub values: BTreeMap<String, String>,
}

/// A number in a column.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum ColumnValue {
    /// A number that counts, such as that of the tick.
    Count(u64),
    /// A number with a unit.
    Number(f64),
    /// A set of bits, each a flag.
    Bits(u8),
}

impl ColumnValue {
    /// Value as a number; counts above 2⁵³ are rounded.
    #[must_use]
    pub fn to_f64(self) -> f64 {
        match self {
            Self::Count(count) => count as f64,
            Self::Number(number) => number,
            Self::Bits(bits) => bits.into(),
        }
    }

    /// The value as a count; a number loses its fraction.
    #[must_use]
    pub const fn to_u64(self) -> u64 {
        match self {
            Self::Count(count) => count,
            Self::Number(number) => number as u64,
            Self::Bits(bits) => bits as u64,
        }
    }
}

/// A message that does not match its schema.
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
pub trait LogMessage: Sized {
    /// Topic of such messages in a log.
    const TOPIC: &'static str;

    /// ROS 2 type name and message definition.
    fn schema(&self) -> (String, String);

    /// Time on the clock of the device, s.
    fn time_s(&self) -> f64;

    /// Puts the CDR bytes of this message into `buffer`, which is cleared first.
    ///
    /// # Errors
    /// For numbers of axes that differ, and texts too long for CDR.
    fn encode_into(&self, buffer: &mut Vec<u8>) -> Result<(), MessageError>;

    /// Destination of a field of a schema.
    type Slot: Copy;

    /// The slot of a field by its name; `None` for one that is not ours.
    fn slot(name: &str) -> Option<Self::Slot>;

    /// Reads a message from its CDR bytes, as the schema of its log says.
    ///
    /// # Errors
    /// If the bytes are not those of such a message.
    fn decode(layout: &Layout<Self::Slot>, bytes: &[u8]) -> Result<Self, MessageError>;
}

/// The fields of a message in the order of its log's schema, and the slot of each.
#[derive(Clone, Debug)]
pub struct Layout<S> {
    fields: Vec<Field<S>>,
    /// False if fields of an undefined type follow, whose length is unknown.
    is_whole: bool,
    encoding: Encoding,
}

/// Layout of the fields in the bytes of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// ROS 2: behind a header of four bytes, numbers at multiples of their size, texts with a zero at their end.
    Cdr,
    /// ROS 1: nothing between them.
    Ros1,
}

#[derive(Clone, Debug)]
struct Field<S> {
    kind: Kind<S>,
    /// Elements; `None` for a sequence, which begins with their number.
    count: Option<usize>,
    /// `None` for a field that is passed over.
    slot: Option<S>,
}

/// Type of an element; a number with its size in bytes.
#[derive(Clone, Debug)]
enum Kind<S> {
    Unsigned(usize),
    Signed(usize),
    Float(usize),
    Text,
    Message(Vec<Field<S>>),
}

/// An element of a field.
#[derive(Clone, Copy, Debug)]
pub enum Item<'a> {
    /// A number of any type.
    Number(ColumnValue),
    /// The bytes of a text.
    Text(&'a [u8]),
}

/// Definitions that stand in one schema: the message's own, without a name, and those of other types.
struct Definitions<'a> {
    parts: Vec<(&'a str, Vec<&'a str>)>,
    /// Fields that may still be made: a type that holds itself would never end.
    left: Cell<usize>,
    encoding: Encoding,
}

/// Fields of a message with those of the messages in it.
const FIELDS_MOST: usize = 10_000;
/// Messages within messages: definitions that nest deeper are not followed.
const DEPTH_MOST: usize = 32;

impl<'a> Definitions<'a> {
    /// The definitions of other types stand behind a line of `=` and one with their name.
    fn of(schema: &'a str, encoding: Encoding) -> Self {
        let mut parts = vec![("", Vec::new())];
        for line in schema.lines() {
            let Some(part) = parts.last_mut().filter(|_| !line.starts_with("===")) else {
                parts.push(("", Vec::new()));
                continue;
            };
            match line.strip_prefix("MSG:") {
                Some(name) => part.0 = name.trim(),
                None => part.1.push(line),
            }
        }
        let left = Cell::new(FIELDS_MOST);
        Self {
            parts,
            left,
            encoding,
        }
    }

    fn lines(&self, kind: &str) -> Option<&[&'a str]> {
        const TIME: [&str; 2] = ["int32 sec", "uint32 nanosec"];
        const ROS1: [&str; 2] = ["time", "duration"];
        // Written in full, `std_msgs/msg/Header`, in short, or without its package.
        let short = kind.replace("/msg/", "/");
        let is_it = |name: &str| {
            let name = name.replace("/msg/", "/");
            !short.is_empty() && (name == short || name.ends_with(&format!("/{short}")))
        };
        let found = self.parts.iter().find(|(name, _)| is_it(name));
        let times = ["builtin_interfaces/Time", "builtin_interfaces/Duration"];
        let is_ros1 = self.encoding == Encoding::Ros1 && ROS1.contains(&kind);
        let is_time = is_ros1 || times.contains(&short.as_str());
        let known = is_time.then_some(&TIME[..]);
        found.map(|(_, lines)| lines.as_slice()).or(known)
    }

    /// The fields that these lines define, `TYPE NAME  # comment` each, and whether they are all.
    fn fields<S>(
        &self,
        lines: &[&str],
        at: &[&str],
        slot: &mut dyn FnMut(&str) -> Option<S>,
    ) -> (Vec<Field<S>>, bool) {
        let mut fields = Vec::new();
        for line in lines {
            let code = line.split('#').next().unwrap_or_default();
            let mut words = code.split_whitespace();
            let (Some(kind), Some(name)) = (words.next(), words.next()) else {
                continue;
            };
            // A constant is no part of a message.
            if name.contains('=') || words.next().is_some_and(|word| word.starts_with('=')) {
                continue;
            }
            let (kind, count) = counted(kind);
            let marked = format!("{name}{}", if count == Some(1) { "" } else { "[]" });
            let inside = [at, &[marked.as_str()]].concat();
            let (kind, slot) = match (element(kind), self.lines(kind)) {
                (Some(kind), _) => (kind, slot(&[at, &[name]].concat().join("."))),
                (None, Some(lines)) if at.len() < DEPTH_MOST && self.left.get() > 0 => {
                    let (fields, true) = self.fields(lines, &inside, slot) else {
                        return (fields, false);
                    };
                    (Kind::Message(fields), None)
                }
                (None, _) => return (fields, false),
            };
            fields.push(Field { kind, count, slot });
            self.left.set(self.left.get().saturating_sub(1));
        }
        if fields.is_empty() && !at.is_empty() && self.encoding == Encoding::Cdr {
            // A message without fields takes one byte.
            let (kind, count, slot) = (Kind::Unsigned(1), Some(1), None);
            fields.push(Field { kind, count, slot });
        }
        (fields, true)
    }
}

impl<S: Copy> Layout<S> {
    /// The layout by a definition in the words of ROS 2, whose messages are CDR.
    pub fn of(definition: &str, slot: impl FnMut(&str) -> Option<S>) -> Self {
        Self::encoded(Encoding::Cdr, definition, slot)
    }

    /// The layout by a definition in the words of ROS. Fields of a message in a field are named as `header.stamp.sec`, or
    /// `poses[].position.x` where there may be several.
    pub fn encoded(
        encoding: Encoding,
        definition: &str,
        mut slot: impl FnMut(&str) -> Option<S>,
    ) -> Self {
        let definitions = Definitions::of(definition, encoding);
        let (fields, is_whole) = definitions.fields(&definitions.parts[0].1, &[], &mut slot);
        Self {
            fields,
            is_whole,
            encoding,
        }
    }

    /// Hands over the elements that have a place, with the number of each in its field and in those around it.
    /// # Errors
    /// If the bytes are not those of such a message.
    pub fn read(
        &self,
        message: &[u8],
        take: impl FnMut(S, &[usize], Item<'_>),
    ) -> Result<(), MessageError> {
        match self.read_padded(message, take)? {
            0 => Ok(()),
            _ => Err(MessageError::Fields),
        }
    }

    /// Reads as [`read`](Self::read) does; returns the number of bytes behind the last field, 0 where it is not known.
    ///
    /// # Errors
    /// If the bytes end before the last field.
    pub fn read_padded(
        &self,
        message: &[u8],
        mut take: impl FnMut(S, &[usize], Item<'_>),
    ) -> Result<usize, MessageError> {
        let encoding = self.encoding;
        let fields = match encoding {
            Encoding::Cdr => message.strip_prefix(&ENCAPSULATION),
            Encoding::Ros1 => Some(message),
        };
        let fields = fields.ok_or(MessageError::Encapsulation)?;
        let mut bytes = Fields {
            fields,
            at: 0,
            encoding,
        };
        bytes
            .fields(&self.fields, &mut Vec::new(), &mut take)
            .ok_or(MessageError::Fields)?;
        Ok(if self.is_whole {
            fields.len() - bytes.at
        } else {
            0
        })
    }
}

/// The type of an element of `float64[3]`, and their number; `None` for any.
fn counted(kind: &str) -> (&str, Option<usize>) {
    match kind.strip_suffix(']').and_then(|kind| kind.split_once('[')) {
        None => (kind, Some(1)),
        Some((name, count)) => (name, count.parse().ok()),
    }
}

/// A type that is defined nowhere.
fn element<S>(name: &str) -> Option<Kind<S>> {
    // A text may have a bound: `string<=8`.
    let name = name.split("<=").next()?;
    let family = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let size = name[family.len()..]
        .parse()
        .map_or(1, |bits: usize| bits / 8);
    let kind = match family {
        "bool" | "byte" | "char" | "uint" => Kind::Unsigned(size),
        "int" => Kind::Signed(size),
        "float" => Kind::Float(size),
        "string" => Kind::Text,
        _ => return None,
    };
    [1, 2, 4, 8].contains(&size).then_some(kind)
}

pub(crate) fn begin(buffer: &mut Vec<u8>) {
    buffer.clear();
    buffer.extend(ENCAPSULATION);
}

/// Puts in the bytes of a number, at a multiple of their count.
pub(crate) fn put<const N: usize>(buffer: &mut Vec<u8>, bytes: [u8; N]) {
    let behind_header = buffer.len() - ENCAPSULATION.len();
    buffer.resize(ENCAPSULATION.len() + behind_header.next_multiple_of(N), 0);
    buffer.extend(bytes);
}

/// Reads the fields of a message.
struct Fields<'a> {
    fields: &'a [u8],
    at: usize,
    encoding: Encoding,
}

impl<'a> Fields<'a> {
    fn number(&mut self, size: usize) -> Option<u64> {
        let start = match self.encoding {
            Encoding::Cdr => self.at.next_multiple_of(size),
            Encoding::Ros1 => self.at,
        };
        self.at = start + size;
        let mut bytes = [0; 8];
        bytes[..size].copy_from_slice(self.fields.get(start..self.at)?);
        Some(u64::from_le_bytes(bytes))
    }

    /// The number of elements of a sequence, or of the bytes of a text.
    fn count(&mut self) -> Option<usize> {
        usize::try_from(self.number(4)?).ok()
    }

    /// An element without a byte is refused, so that a wrong number of them ends with the message.
    fn fields<S: Copy>(
        &mut self,
        fields: &[Field<S>],
        places: &mut Vec<usize>,
        take: &mut dyn FnMut(S, &[usize], Item<'_>),
    ) -> Option<()> {
        for field in fields {
            let count = field.count.or_else(|| self.count())?;
            let depth = places.len();
            for index in 0..count {
                if field.count != Some(1) {
                    places.truncate(depth);
                    places.push(index);
                }
                let before = self.at;
                let item = match &field.kind {
                    Kind::Message(fields) => {
                        self.fields(fields, places, take)?;
                        (self.at > before || field.count == Some(1)).then_some(())?;
                        continue;
                    }
                    Kind::Unsigned(size) => Item::Number(ColumnValue::Count(self.number(*size)?)),
                    Kind::Signed(size) => {
                        let unused = 64 - 8 * *size as u32;
                        let signed = (self.number(*size)? << unused).cast_signed() >> unused;
                        Item::Number(ColumnValue::Number(signed as f64))
                    }
                    Kind::Float(4) => {
                        let number = f32::from_bits(self.number(4)? as u32);
                        Item::Number(ColumnValue::Number(number.into()))
                    }
                    Kind::Float(size) => {
                        Item::Number(ColumnValue::Number(f64::from_bits(self.number(*size)?)))
                    }
                    Kind::Text => Item::Text(self.text()?),
                };
                if let Some(slot) = field.slot {
                    take(slot, places, item);
                }
            }
            places.truncate(depth);
        }
        Some(())
    }

    /// Its length and its bytes; in CDR the zero at its end counts.
    fn text(&mut self) -> Option<&'a [u8]> {
        let length = self.count()?;
        let bytes = self.fields.get(self.at..)?.get(..length)?;
        self.at += length;
        match self.encoding {
            Encoding::Cdr => bytes.strip_suffix(&[0]),
            Encoding::Ros1 => Some(bytes),
        }
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

    type Slot = usize;

    /// Place in the order of the schema above.
    fn slot(name: &str) -> Option<usize> {
        ["time_s", "kind", "text"]
            .iter()
            .position(|field| *field == name)
    }

    fn decode(layout: &Layout<usize>, bytes: &[u8]) -> Result<Self, MessageError> {
        let (mut time_s, mut texts) = (f64::NAN, [const { Vec::new() }; 3]);
        layout.read(bytes, |slot, _, item| match item {
            Item::Number(number) => time_s = number.to_f64(),
            Item::Text(text) => texts[slot] = text.to_vec(),
        })?;
        let [_, kind, text] = texts.map(String::from_utf8);
        let (kind, text) = kind.ok().zip(text.ok()).ok_or(MessageError::Fields)?;
        Ok(Self { time_s, kind, text })
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
        let layout = Layout::of(&event.schema().1, EventMessage::slot);
        assert_eq!(
            EventMessage::decode(&layout, &bytes).expect("decodes"),
            event
        );
        for length in 0..bytes.len() {
            assert!(
                EventMessage::decode(&layout, &bytes[..length]).is_err(),
                "{length}"
            );
        }
        bytes[12..16].copy_from_slice(&[0xff; 4]);
        assert!(EventMessage::decode(&layout, &bytes).is_err());
    }
}
