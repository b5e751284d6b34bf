//! A message counts in one form only.

use super::content;
use crate::{
    frames::{body, header, line},
    messages::{reports, requests},
};
use haptic_link::{DeviceReport, Direction, FRAME_MAX, Receiver, Request, encode};

/// Bytes that are a message on their own.
struct Raw<'a>(&'a [u8]);

impl serde::Serialize for Raw<'_> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        use serde::ser::SerializeTuple as _;
        let mut tuple = serializer.serialize_tuple(self.0.len())?;
        for byte in self.0 {
            tuple.serialize_element(byte)?;
        }
        tuple.end()
    }
}

/// The message that a receiver takes from a well-made frame, if it takes one.
fn received<M>(body: &[u8], direction: Direction) -> Option<M>
where
    M: serde::Serialize + serde::de::DeserializeOwned,
{
    let mut receiver = Receiver::<M>::new(direction);
    let mut framed = [0; FRAME_MAX];
    // A body of all 16 items and a byte more does not fit.
    let length = encode(&Raw(body), header(1, direction), &mut framed).ok()?;
    let got = framed[..length]
        .iter()
        .find_map(|&byte| receiver.push(byte));
    got.map(|(_, message)| message)
}

/// Each byte and number of so many is tried: Miri is a thousand times slower.
const EACH: usize = if cfg!(miri) { 64 } else { 1 };

/// Every byte below 128 that is written as two, as no number has to be: the first byte is the number of the message,
/// others are enumerations, lengths and parts of numbers.
fn has_one_form<M>(good: &[u8], direction: Direction)
where
    M: serde::Serialize + serde::de::DeserializeOwned,
{
    assert!(received::<M>(good, direction).is_some(), "{good:?}");
    for at in (0..good.len()).step_by(EACH) {
        for longer in 2..=5 {
            let mut bytes = good[..at].to_vec();
            bytes.push(good[at] | 0x80);
            bytes.extend(vec![0x80; longer - 2]);
            bytes.push(0);
            bytes.extend(&good[at + 1..]);
            let taken = received::<M>(&bytes, direction).is_some();
            assert!(!taken, "byte {at} of {good:?} in {longer} bytes");
        }
    }
    for number in (128..=255).step_by(EACH) {
        let mut bytes = good.to_vec();
        bytes[0] = number;
        assert!(received::<M>(&bytes, direction).is_none(), "{number}");
        bytes.insert(1, 0);
        assert!(received::<M>(&bytes, direction).is_none(), "{number} 0");
        bytes[1] = 1;
        assert!(received::<M>(&bytes, direction).is_none(), "{number} 1");
    }
}

#[test]
fn a_message_counts_in_one_form_only() {
    for request in requests() {
        let content = content(&line(&request, 1, Direction::FromHost));
        has_one_form::<Request>(body(&content, Direction::FromHost), Direction::FromHost);
    }
    for report in reports() {
        let content = content(&line(&report, 1, Direction::FromDevice));
        has_one_form::<DeviceReport>(body(&content, Direction::FromDevice), Direction::FromDevice);
    }
    // What was found: 135 with a zero behind it armed, 137 started.
    assert!(received::<Request>(&[7, 0, 0], Direction::FromHost).is_some());
    assert!(received::<Request>(&[0x87, 0, 0, 0], Direction::FromHost).is_none());
    assert!(
        received::<Request>(
            &[0x89, 0, 1, 0, 0, 0, 0, 0, 0, 0, 1, 0, 1],
            Direction::FromHost
        )
        .is_none()
    );
}
