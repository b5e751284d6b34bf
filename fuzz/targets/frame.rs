//! Any bytes at all, to both receivers: no panic, every frame counted once, and what is taken for a message
//! frames to the same bytes again.
#![no_main]
#![forbid(unsafe_code)]

use fractional_haptics_fuzz as _;
use haptic_link::{
    DeviceReport, Direction, FRAME_MAX, LineCounters, Receiver, Request, RequestTracker,
    SequenceTracker, encode,
};
use libfuzzer_sys::fuzz_target;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt::Debug;

fn receive<M: Serialize + DeserializeOwned + Debug>(bytes: &[u8], direction: Direction) {
    let mut receiver = Receiver::<M>::new(direction);
    let (mut reports, mut requests) = (SequenceTracker::NEW, RequestTracker::NEW);
    let mut piece = Vec::new();
    for &byte in bytes {
        piece.push(byte);
        let got = receiver.push(byte);
        if let Some((header, message)) = got {
            reports.is_new(header.sequence as u16);
            requests.is_new(header.sequence);
            let mut line = [0; FRAME_MAX];
            let length = encode(&message, header, &mut line).expect("it came in a frame");
            assert_eq!(line[..length], piece, "{header:?} {message:?}");
        }
        if byte == 0 {
            piece.clear();
        }
    }
    let LineCounters {
        received,
        corrupt,
        oversize,
        foreign,
        ..
    } = receiver.counters();
    let frames = bytes.split_inclusive(|&byte| byte == 0);
    let frames = frames.filter(|frame| frame.len() > 1 && frame.ends_with(&[0]));
    let counted = received + corrupt + oversize + foreign;
    assert_eq!(counted as usize, frames.count());
}

fuzz_target!(|bytes: &[u8]| {
    receive::<Request>(bytes, Direction::FromHost);
    receive::<DeviceReport>(bytes, Direction::FromDevice);
});
