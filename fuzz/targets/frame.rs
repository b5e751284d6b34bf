//! Any bytes at all, to both receivers: no panic, every frame counted once, and what is taken for a message
//! frames to the same message again.
#![no_main]
#![forbid(unsafe_code)]

use fractional_haptics_fuzz as _;
use haptic_link::{
    Direction, FRAME_MAX, LineCounters, Receiver, Report, Request, SequenceTracker, encode,
};
use libfuzzer_sys::fuzz_target;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt::Debug;

fn receive<M: Serialize + DeserializeOwned + Debug>(bytes: &[u8], direction: Direction) {
    let mut receiver = Receiver::<M>::new(direction);
    let mut tracker = SequenceTracker::NEW;
    for &byte in bytes {
        let Some((sequence, message)) = receiver.push(byte) else {
            continue;
        };
        tracker.arrive(sequence);
        let mut line = [0; FRAME_MAX];
        let length = encode(&message, sequence, direction, &mut line).expect("it came in a frame");
        let mut again = Receiver::<M>::new(direction);
        let got = line[..length].iter().find_map(|&byte| again.push(byte));
        // NaN is not equal to itself, so the printed form is compared.
        let want = Some((sequence, message));
        assert_eq!(format!("{got:?}"), format!("{want:?}"));
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
    receive::<Report>(bytes, Direction::FromDevice);
});
