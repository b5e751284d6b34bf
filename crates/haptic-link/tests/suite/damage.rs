//! A line that flips bits, cuts frames and joins them: nothing that was not sent is taken for a message, and
//! what came whole is found.
//!
//! - *Good*: what stands between two zeros is, byte for byte, a frame that was sent there. A frame behind one whose
//!   zero was lost is not: it stands behind the rest of the other. The one after it is.
//! - *Odds*: what is not good passes a CRC of 32 bits once in 4.3·10⁹, if its damage is of the kind that the CRC
//!   does not find for certain; and then it still has to be a message. 10⁷ tries let one pass with a chance of
//!   0.2 %, so none may.
//!
//! `DAMAGED_FRAMES` sets how many are tried: 10 000 000 take some seconds with `--release`.

use crate::messages::{reports, requests};
use haptic_link::{Direction, FRAME_MAX, Header, Receiver, encode};
use serde::{Serialize, de::DeserializeOwned};
use std::fmt::Debug;

/// `SplitMix64` (G. Steele, D. Lea, C. Flood, *Fast splittable pseudorandom number generators*, 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Below `end`.
    fn below(&mut self, end: usize) -> usize {
        (self.next() % end as u64) as usize
    }

    fn of<M: Clone>(&mut self, list: &[M]) -> M {
        list[self.below(list.len())].clone()
    }
}

/// Damages a frame, its zero included.
fn damage(frame: &mut Vec<u8>, other: &[u8], random: &mut Random) {
    let length = frame.len();
    match random.below(4) {
        // 1 to 8 bits.
        0 | 1 => {
            let count = 1 + random.below(8);
            let mut bits: Vec<usize> = (0..count).map(|_| random.below(8 * length)).collect();
            bits.sort_unstable();
            bits.dedup();
            for bit in bits {
                frame[bit / 8] ^= 1 << (bit % 8);
            }
        }
        // Some bytes are missing: from the beginning, in the middle, or at the end, which joins it to the next.
        2 => {
            let from = random.below(length);
            let to = from + 1 + random.below(length - from);
            let (from, to) = match random.below(4) {
                0 => (0, to),
                1 => (from, length),
                _ => (from, to),
            };
            frame.drain(from..to);
        }
        // The beginning of another frame in its middle.
        _ => {
            let taken = 1 + random.below(other.len().max(2) - 1);
            let at = random.below(length);
            let taken = other.iter().take(taken).copied();
            frame.splice(at..at, taken.filter(|&byte| byte != 0));
        }
    }
}

/// The fate of the frames on one line.
#[derive(Debug, Default)]
struct Tally {
    sent: u32,
    damaged: u32,
    good: u32,
    /// Pieces between zeros that are not what was sent there.
    bad: u32,
    wrong: u32,
    missed: u32,
}

fn try_line<M: Serialize + DeserializeOwned + PartialEq + Clone + Debug>(
    direction: Direction,
    messages: &[M],
    tries: u32,
    seed: u64,
) -> Tally {
    let mut random = Random(seed);
    let mut receiver = Receiver::<M>::new(direction);
    let mut tally = Tally::default();
    let (mut piece, mut before) = (Vec::new(), Vec::new());
    // Frames of which something may be in the piece.
    let mut under_way: Vec<(Vec<u8>, (Header, M))> = Vec::new();
    while tally.damaged < tries {
        let message = random.of(messages);
        let header = match direction {
            Direction::FromHost => Header::from_host(tally.sent, 0x00ff_0100),
            Direction::FromDevice => Header::from_device(tally.sent as u16),
        };
        let mut line = [0; FRAME_MAX];
        let length = encode(&message, header, &mut line).expect("fits");
        let sent = line[..length].to_vec();
        let mut frame = sent.clone();
        if random.below(2) == 0 {
            damage(&mut frame, &before, &mut random);
            tally.damaged += 1;
        }
        before.clone_from(&sent);
        under_way.push((sent, (header, message)));
        for byte in frame {
            let got = receiver.push(byte);
            piece.push(byte);
            if byte != 0 {
                assert_eq!(got, None);
                continue;
            }
            let good = under_way.iter().find(|(sent, _)| *sent == piece);
            let is_right = got.as_ref() == good.map(|(_, message)| message);
            tally.good += u32::from(good.is_some());
            tally.bad += u32::from(good.is_none() && piece.len() > 1);
            tally.missed += u32::from(good.is_some() && got.is_none());
            tally.wrong += u32::from(got.is_some() && !is_right);
            piece.clear();
            under_way.drain(..under_way.len() - 1);
        }
        tally.sent += 1;
    }
    let counters = receiver.counters();
    assert_eq!(counters.received, tally.good + tally.wrong);
    let refused = counters.corrupt + counters.oversize + counters.foreign;
    assert_eq!(refused, tally.bad - tally.wrong);
    tally
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn damaged_frames_are_never_taken_for_messages_and_whole_ones_always_are() {
    // Miri is a thousand times slower.
    let default = if cfg!(miri) { 40 } else { 200_000 };
    let tries = std::env::var("DAMAGED_FRAMES").map_or(default, |n| n.parse().expect("a number"));
    let requests = try_line(Direction::FromHost, &requests(), tries / 2, 1);
    let reports = try_line(Direction::FromDevice, &reports(), tries - tries / 2, 2);
    for tally in [requests, reports] {
        println!("{tally:?}");
        assert_eq!((tally.wrong, tally.missed), (0, 0), "{tally:?}");
        // Most of the others came whole, and most of the damage made something that is not.
        assert!(tally.good > tally.sent / 4 && tally.bad > tally.damaged / 2);
    }
}
