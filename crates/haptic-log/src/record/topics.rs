//! Topics of a log as columns of numbers, whoever wrote them.
//!
//! A column is a path into the message, as `wrench.force.x`, `position[2]` or `poses[0].x`; a truth is 0 or 1, a text is
//! no column, and of an array its first [`ELEMENTS_MOST`] elements are. Seconds and nanoseconds side by side are one column
//! that counts from its first value, `header.stamp_s`, which keeps the digits. `time_s` is when a message was recorded,
//! counted from the first (`log_time_s` if the message has a `time_s` of its own); rows are in that order. Where that would be another
//! order than that of the file, by more than the usual interval, the numbers of the messages decide: if they do not rise with the times,
//! the clock of the recording was set back, and rows stay in the order of the file.
//!
//! | messages | definition |
//! |---|---|
//! | `cdr`, plain and little endian | `ros2msg` |
//! | `ros1`, as in converted bags | `ros1msg` |
//! | `json` | none is needed |
//!
//! - *Errors*: a log without a topic of numbers, or with several of which none is named; the error lists them.
//! - *Cost*: the file is read once; eight bytes of memory for each number.

use haptic_message::{Encoding, Item};
use mcap::records::Record;
use serde_json::Value;
use std::collections::{BTreeMap, HashMap};

/// The layout of a message, with the number of each field.
type Layout = haptic_message::Layout<usize>;

/// Most elements of an array that become columns: a picture or a scan has too many.
const ELEMENTS_MOST: usize = 64;

/// Bytes behind the last field that some writers leave: they fill up to a multiple of four.
const PADDING_MOST: usize = 3;

/// Decoder of the messages of a channel.
#[derive(Debug)]
enum Decoder {
    /// The layout, and the names of its numbers.
    Ros(Layout, Vec<String>),
    Json,
}

impl Decoder {
    /// Decoder by the encoding of the messages, and by that of their definition; else the reason why they are not read.
    fn of(encoding: &str, (language, definition): &(String, String)) -> Result<Self, String> {
        let encoding = match (encoding, language.as_str()) {
            ("json", _) => return Ok(Self::Json),
            ("cdr", "ros2msg") => Encoding::Cdr,
            ("ros1", "ros1msg") => Encoding::Ros1,
            _ => return Err(format!("{encoding:?} defined by {language:?} is not read")),
        };
        let mut names = Vec::new();
        let layout = Layout::encoded(encoding, definition, |name| {
            names.push(name.to_owned());
            Some(names.len() - 1)
        });
        Ok(Self::Ros(layout, names))
    }

    /// The numbers of a message with their names, and true if elements of an array were left out.
    fn numbers(&self, bytes: &[u8]) -> Result<(Vec<(String, f64)>, bool), String> {
        let (mut numbers, mut is_long) = (Vec::new(), false);
        match self {
            Self::Ros(layout, names) => {
                let rest = layout.read_padded(bytes, |slot, places, item| {
                    let Item::Number(number) = item else { return };
                    if places.iter().all(|&place| place < ELEMENTS_MOST) {
                        numbers.push((numbered(&names[slot], places), number.to_f64()));
                    } else {
                        is_long = true;
                    }
                });
                let rest = rest.map_err(|error| error.to_string())?;
                if rest > PADDING_MOST {
                    return Err(format!("{rest} bytes follow the last field of a message"));
                }
            }
            Self::Json => {
                let value = serde_json::from_slice(bytes).map_err(|error| error.to_string())?;
                flatten(String::new(), &value, &mut numbers, &mut is_long);
            }
        }
        Ok((numbers, is_long))
    }
}

/// `poses[].x` with the places of its elements; that of the last array stands behind the name.
fn numbered(path: &str, places: &[usize]) -> String {
    let mut parts = path.split("[]");
    let first = parts.next().unwrap_or_default().to_owned();
    places.iter().fold(first, |name, place| {
        format!("{name}[{place}]{}", parts.next().unwrap_or_default())
    })
}

fn flatten(path: String, value: &Value, numbers: &mut Vec<(String, f64)>, is_long: &mut bool) {
    match value {
        Value::Number(number) => numbers.push((path, number.as_f64().unwrap_or(f64::NAN))),
        Value::Bool(truth) => numbers.push((path, f64::from(u8::from(*truth)))),
        Value::Null | Value::String(_) => {}
        Value::Array(elements) => {
            *is_long |= elements.len() > ELEMENTS_MOST;
            for (place, element) in elements.iter().take(ELEMENTS_MOST).enumerate() {
                flatten(format!("{path}[{place}]"), element, numbers, is_long);
            }
        }
        Value::Object(fields) => {
            let dot = if path.is_empty() { "" } else { "." };
            for (name, field) in fields {
                flatten(format!("{path}{dot}{name}"), field, numbers, is_long);
            }
        }
    }
}

/// All messages of a log, as they come.
#[derive(Debug, Default)]
pub(super) struct Topics {
    /// Language and text of the definitions, by their number.
    schemas: BTreeMap<u16, (String, String)>,
    /// Topic and decoder of the channels, by their number.
    channels: BTreeMap<u16, (String, Result<Decoder, String>)>,
    pub rows: BTreeMap<String, Rows>,
}

impl Topics {
    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "of the records of others, these are the ones that matter here"
    )]
    pub(super) fn take(&mut self, record: &Record<'_>) {
        match record {
            Record::Schema { header, data } => {
                let definition = String::from_utf8_lossy(data).into_owned();
                let schema = (header.encoding.clone(), definition);
                self.schemas.insert(header.id, schema);
            }
            Record::Channel(channel) => {
                let none = (String::new(), String::new());
                let schema = self.schemas.get(&channel.schema_id).unwrap_or(&none);
                let decoder = Decoder::of(&channel.message_encoding, schema);
                let channel_of = (channel.topic.clone(), decoder);
                self.channels.insert(channel.id, channel_of);
            }
            Record::Message { header, data } => {
                if let Some((topic, decoder)) = self.channels.get(&header.channel_id) {
                    let numbers = decoder.as_ref().map_err(String::clone);
                    let numbers = numbers.and_then(|decoder| decoder.numbers(data));
                    let rows = self.rows.entry(topic.clone()).or_default();
                    rows.take(header.log_time, header.sequence, numbers);
                }
            }
            _ => {}
        }
    }
}

/// The messages of a topic.
#[derive(Debug, Default)]
pub(super) struct Rows {
    /// Log time of the first message, read or not: time counts from there.
    first_ns: Option<u64>,
    log_times_ns: Vec<u64>,
    /// Numbers by which the writer of the messages counts them; all 0 where nobody does.
    numbers: Vec<u32>,
    pub columns: Vec<(String, Vec<f64>)>,
    places: HashMap<String, usize>,
    /// Messages that were not read, and why the last was not.
    refused: Option<(u64, String)>,
    /// Elements of an array were left out.
    is_long: bool,
}

impl Rows {
    fn take(
        &mut self,
        log_time_ns: u64,
        number: u32,
        numbers: Result<(Vec<(String, f64)>, bool), String>,
    ) {
        let first_ns = self.first_ns.get_or_insert(log_time_ns);
        *first_ns = log_time_ns.min(*first_ns);
        let row = self.log_times_ns.len();
        let (numbers, is_long) = match numbers {
            Ok(numbers) => numbers,
            Err(why) => {
                let before = self.refused.take().map_or(0, |(count, _)| count);
                self.refused = Some((before + 1, why));
                return;
            }
        };
        self.is_long |= is_long;
        self.log_times_ns.push(log_time_ns);
        self.numbers.push(number);
        for (name, number) in numbers {
            let place = *self.places.entry(name).or_insert_with_key(|name| {
                self.columns.push((name.clone(), Vec::new()));
                self.columns.len() - 1
            });
            let column = &mut self.columns[place].1;
            column.resize(row, f64::NAN);
            column.push(number);
        }
    }

    /// Words for a person who has to choose.
    pub(super) fn describe(&self, topic: &str) -> String {
        const NAMED: usize = 8;
        let columns = self.columns();
        let mut names: Vec<&str> = columns[1..].iter().map(|(name, _)| name.as_str()).collect();
        if names.len() > NAMED {
            names.truncate(NAMED);
            names.push("…");
        }
        let read = format!("{} messages: {}", self.log_times_ns.len(), names.join(", "));
        match &self.refused {
            Some((count, why)) if names.is_empty() => format!("{topic} ({count} messages: {why})"),
            _ if names.is_empty() => format!("{topic} (without numbers)"),
            _ => format!("{topic} ({read})"),
        }
    }

    pub(super) fn notes(&self) -> Vec<String> {
        let refused = self.refused.as_ref();
        let refused = refused.map(|(count, why)| format!("{count} messages omitted: {why}"));
        let long = format!("of arrays their first {ELEMENTS_MOST} elements are taken");
        let notes = [refused, self.is_long.then_some(long), self.order().1];
        notes.into_iter().flatten().collect()
    }

    /// The rows in their order, and where the clock of the recording was set, as far as that can be seen.
    fn order(&self) -> (Vec<usize>, Option<String>) {
        let (times, count) = (&self.log_times_ns, self.log_times_ns.len());
        let step = |pair: &[usize]| times[pair[1]].wrapping_sub(times[pair[0]]).cast_signed();
        let missing = |pair: &[usize]| {
            self.numbers[pair[1]].checked_sub(self.numbers[pair[0]].saturating_add(1))
        };
        let in_file: Vec<usize> = (0..count).collect();
        let mut order = in_file.clone();
        order.sort_by_key(|&row| times[row]);
        let mut steps: Vec<i64> = order.windows(2).map(step).collect();
        steps.sort_unstable();
        let usual_ns = steps.get(steps.len() / 2).map_or(0, |usual| *usual);
        let told = |order: &[usize], sought: i64, what| {
            let at = order.windows(2).position(|pair| step(pair) == sought)?;
            let step_s = sought as f64 / 1e9;
            Some(format!(
                "the clock of the recording steps by {step_s} s behind message {} of {count}: {what}",
                at + 1
            ))
        };
        let least = in_file.windows(2).map(step).min();
        let is_numbered = order.windows(2).all(|pair| missing(pair).is_some());
        if let Some(least) = least.filter(|least| *least < -usual_ns && !is_numbered) {
            let what = "rows are in the order of the file, and only an export has their times";
            let note = told(&in_file, least, what);
            return (in_file, note);
        }
        let note = match steps[..] {
            [.., second, most] if 0 < second && 100 * second < most => {
                let pair = order.windows(2).find(|pair| step(pair) == most);
                let what = "it was set, or the recording paused, as no message is missing there";
                pair.filter(|pair| missing(pair).unwrap_or(0) == 0)
                    .and_then(|_| told(&order, most, what))
            }
            _ => None,
        };
        (order, note)
    }

    /// All of one length, in their order.
    pub(super) fn columns(&self) -> Vec<(String, Vec<f64>)> {
        let (order, _) = self.order();
        let first_ns = self.first_ns.unwrap_or(0);
        // Divided, 5.5 ms has no digits beyond those that it had.
        let time = (order.iter()).map(|&row| (self.log_times_ns[row] - first_ns) as f64 / 1e9);
        let is_stamped = self.places.contains_key("time_s");
        let name = if is_stamped { "log_time_s" } else { "time_s" };
        let mut columns = vec![(name.to_owned(), time.collect())];
        for (name, column) in &self.columns {
            let at = |row: &usize| column.get(*row).copied().unwrap_or(f64::NAN);
            columns.push((name.clone(), order.iter().map(at).collect()));
        }
        join_stamps(&columns)
    }
}

/// Seconds and nanoseconds side by side become one column, counted from its first value: `f64` has no room for both.
fn join_stamps(columns: &[(String, Vec<f64>)]) -> Vec<(String, Vec<f64>)> {
    const SECONDS: [&str; 3] = ["sec", "secs", "seconds"];
    const REST: [&str; 4] = ["nanosec", "nsec", "nsecs", "nanos"];
    let companion = |stamp: &str, parts: &[&str]| {
        let mut names = parts.iter().map(|part| format!("{stamp}.{part}"));
        names.find_map(|name| columns.iter().find(|(other, _)| *other == name))
    };
    let joined = columns.iter().filter_map(|(name, numbers)| {
        let (stamp, part) = name.rsplit_once('.').unwrap_or_default();
        if REST.contains(&part) && companion(stamp, &SECONDS).is_some() {
            return None;
        }
        let rest = companion(stamp, &REST).filter(|_| SECONDS.contains(&part));
        let Some((_, rest)) = rest else {
            return Some((name.clone(), numbers.clone()));
        };
        let pairs = || std::iter::zip(numbers, rest);
        let first = pairs().find(|(s, ns)| (*s + *ns).is_finite());
        let (s0, ns0) = first.unwrap_or((&0.0, &0.0));
        let time = pairs().map(|(s, ns)| (1e9 * (s - s0) + (ns - ns0)) / 1e9);
        Some((format!("{stamp}_s"), time.collect()))
    });
    joined.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ros(definition: &str) -> Decoder {
        let schema = ("ros2msg".to_owned(), definition.to_owned());
        Decoder::of("cdr", &schema).expect("is read")
    }

    #[test]
    fn a_definition_without_end_or_bytes_ends() {
        let rule = "=".repeat(80);
        // A type that holds itself, twice; a thousand million elements of nothing.
        let definitions = [
            format!("A a\n{rule}\nMSG: A\nA b\nA c\n"),
            format!("A[1000000000] a\n{rule}\nMSG: A\nuint8[0] b\n"),
            "uint8[] a".to_owned(),
            "uint8[4000000000] a".to_owned(),
        ];
        for definition in definitions {
            let decoder = ros(&definition);
            let numbers = decoder.numbers(&[0, 1, 0, 0, 255, 255, 255, 255]);
            assert!(
                numbers.is_ok_and(|(numbers, _)| numbers.is_empty())
                    || definition.contains("uint8"),
                "{definition}"
            );
        }
    }

    #[test]
    fn fields_of_every_type_stand_where_cdr_puts_them() {
        let rule = "=".repeat(80);
        let definition = format!(
            "int8 a 5\nuint8 LIMIT=3\nfloat64 b\nstring<=8 c \"a=b\"\nlab/P[] d\nint64 e\nbool f\n{rule}\nMSG: lab/P\nint16 x\n{rule}\nMSG: lab/Q\nint8 y\n"
        );
        let mut bytes = vec![0, 1, 0, 0, 0xfe, 0, 0, 0, 0, 0, 0, 0];
        bytes.extend(1.5_f64.to_le_bytes());
        bytes.extend(b"\x03\0\0\0ab\0\0\x02\0\0\0");
        bytes.extend([0xff, 0xff, 7, 0]);
        bytes.extend((-9_i64).to_le_bytes());
        // Filled up to a multiple of four.
        bytes.extend([1, 0, 0, 0]);
        let (numbers, is_long) = ros(&definition).numbers(&bytes).expect("reads");
        let names = ["a", "b", "d[0].x", "d[1].x", "e", "f"].map(str::to_owned);
        let want = std::iter::zip(names, [-2.0, 1.5, -1.0, 7.0, -9.0, 1.0]);
        assert_eq!(numbers, want.collect::<Vec<_>>());
        assert!(!is_long);
        for length in 0..bytes.len() - 3 {
            assert!(
                ros(&definition).numbers(&bytes[..length]).is_err(),
                "{length}"
            );
        }
        bytes.extend([0; 4]);
        let error = ros(&definition).numbers(&bytes).expect_err("too long");
        assert!(error.contains("7 bytes follow"), "{error}");
    }

    #[test]
    fn messages_of_ros_1_stand_without_gaps() {
        let rule = "=".repeat(80);
        let definition = format!(
            "Header header\nint8 a\nfloat64[] b\nEmpty c\nduration d\n{rule}\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n{rule}\nMSG: std_msgs/Empty\n"
        );
        let schema = ("ros1msg".to_owned(), definition);
        let decoder = Decoder::of("ros1", &schema).expect("is read");
        let mut bytes = [7_u32, 5, 250_000_000, 2].map(u32::to_le_bytes).concat();
        bytes.extend(b"ab\xfe\x01\0\0\0");
        bytes.extend(1.5_f64.to_le_bytes());
        bytes.extend([3_u32, 4].map(u32::to_le_bytes).concat());
        let (numbers, _) = decoder.numbers(&bytes).expect("reads");
        let names = [
            "header.seq",
            "header.stamp.sec",
            "header.stamp.nanosec",
            "a",
            "b[0]",
            "d.sec",
            "d.nanosec",
        ];
        let want = std::iter::zip(names, [7.0, 5.0, 2.5e8, -2.0, 1.5, 3.0, 4.0]);
        let want: Vec<_> = want.map(|(name, value)| (name.to_owned(), value)).collect();
        assert_eq!(numbers, want);
        for length in 0..bytes.len() {
            assert!(decoder.numbers(&bytes[..length]).is_err(), "{length}");
        }
    }

    #[test]
    fn a_clock_that_steps_is_told_and_shuffles_nothing() {
        const MS: u64 = 1_000_000;
        const START: u64 = 1_700_000_000_000 * MS;
        const MANY: u64 = 4000;
        type Row = fn(u64) -> (u64, u32);
        let cases: [(&str, Row, &str); 9] = [
            ("even", |n| (START + n * MS, n as u32), ""),
            (
                "back 1 s",
                |n| (START + n * MS - n / 2000 * 1000 * MS, n as u32),
                "steps by -0.999 s behind message 2000 of 4000",
            ),
            (
                "back 20 ms",
                |n| (START + n * MS - n / 2000 * 20 * MS, 0),
                "steps by -0.019 s behind message 2000",
            ),
            (
                "to 1970",
                |n| (n * MS + (1 - n / 2000) * START, n as u32),
                "steps by -1699999999.999 s",
            ),
            (
                "on 1 h",
                |n| (START + n * MS + n / 2000 * 3_600_000 * MS, n as u32),
                "steps by 3600.001 s behind message 2000",
            ),
            // Half of them stand before the others, and their numbers say so; half a second of them is missing.
            (
                "in another order",
                |n| (START + (n + 2000) % MANY * MS, ((n + 2000) % MANY) as u32),
                "",
            ),
            (
                "lost",
                |n| {
                    (
                        START + (n + n / 2000 * 500) * MS,
                        (n + n / 2000 * 500) as u32,
                    )
                },
                "",
            ),
            // Neighbours change places; the intervals grow with the time.
            ("jitter", |n| (START + n * MS + n % 2 * MS * 3 / 2, 0), ""),
            ("growing", |n| (START + n * n * MS, 0), ""),
        ];
        for (name, row, note) in cases {
            let mut rows = Rows::default();
            for n in 0..MANY {
                let (time, number) = row(n);
                rows.take(time, number, Ok((vec![("n".to_owned(), n as f64)], false)));
            }
            assert_eq!(
                rows.notes().is_empty(),
                note.is_empty(),
                "{name}: {:?}",
                rows.notes()
            );
            assert!(
                rows.notes().concat().contains(note),
                "{name}: {:?}",
                rows.notes()
            );
            let columns = rows.columns();
            let by_file = columns[1].1.is_sorted();
            assert_eq!(
                by_file,
                !["in another order", "jitter"].contains(&name),
                "{name}"
            );
            assert_eq!(columns[0].1.is_sorted(), !note.contains("-"), "{name}");
        }
    }

    #[test]
    fn long_arrays_are_cut_and_that_is_told() {
        let bytes = [&[0, 1, 0, 0, 100, 0, 0, 0][..], &[7; 100]].concat();
        let (numbers, is_long) = ros("uint8[] a").numbers(&bytes).expect("reads");
        assert_eq!((numbers.len(), is_long), (ELEMENTS_MOST, true));
        let (numbers, is_long) = Decoder::Json
            .numbers(b"{\"a\": [[1, 2], true], \"b\": \"3\"}")
            .expect("reads");
        let names: Vec<&str> = numbers.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(
            (&names[..], is_long),
            (&["a[0][0]", "a[0][1]", "a[1]"][..], false)
        );
        assert!(Decoder::Json.numbers(b"{\"a\": ").is_err());
    }
}
