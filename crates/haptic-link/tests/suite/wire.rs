//! The bytes on the line, damage to them, and the numbers on frames.

mod limits;
mod messages;

use self::messages::{configuration, reports, requests};
use haptic_link::{
    Arrival, BATCH_MAX, DigestBuilder, Direction, FRAME_MAX, Header, Keys, Limits, Receiver,
    Report, Request, RequestTracker, Sample, SequenceTracker, Statistics, encode,
};
use proptest::prelude::*;

/// The connection in all of these frames.
const CONNECTION: u32 = 0x0807_0605;

fn header(sequence: u16, direction: Direction) -> Header {
    match direction {
        Direction::FromHost => Header::from_host(u32::from(sequence), CONNECTION),
        Direction::FromDevice => Header::from_device(sequence),
    }
}

fn line<M: serde::Serialize>(message: &M, sequence: u16, direction: Direction) -> Vec<u8> {
    let mut line = [0; FRAME_MAX];
    let length = encode(message, header(sequence, direction), &mut line).expect("fits");
    line[..length].to_vec()
}

/// The message in a content.
fn body(content: &[u8], direction: Direction) -> &[u8] {
    let start = match direction {
        Direction::FromHost => 9,
        Direction::FromDevice => 3,
    };
    &content[start..content.len() - 4]
}

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

fn content(line: &[u8]) -> Vec<u8> {
    let mut bytes = line[..line.len() - 1].to_vec();
    let length = cobs_decode(&mut bytes);
    bytes[..length].to_vec()
}

/// COBS by its definition, as a second witness: each code byte tells how far the next zero is.
fn cobs_decode(bytes: &mut [u8]) -> usize {
    let mut out = Vec::new();
    let mut i = 0;
    while i < bytes.len() {
        let code = usize::from(bytes[i]);
        assert!(code > 0 && i + code <= bytes.len());
        out.extend_from_slice(&bytes[i + 1..i + code]);
        i += code;
        if code < 255 && i < bytes.len() {
            out.push(0);
        }
    }
    bytes[..out.len()].copy_from_slice(&out);
    out.len()
}

#[test]
fn a_sample_is_a_packed_structure_in_a_frame_of_at_most_32_bytes() {
    let sample = Sample {
        tick: 0x0403_0201,
        time_us: 0x0807_0605,
        position_m: 1.0,
        environment_force_n: -2.0,
        force_n: 0.5,
        limiters: 3,
    };
    let line = line(&Report::Sample(sample), 0x0a09, Direction::FromDevice);
    assert!(line.len() <= 32, "{} bytes", line.len());
    assert_eq!(line.len(), 31);
    let mut expected = vec![0x82, 9, 10, 5, 1, 2, 3, 4, 5, 6, 7, 8];
    for value in [1.0_f32, -2.0, 0.5] {
        expected.extend_from_slice(&value.to_le_bytes());
    }
    expected.push(3);
    let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&expected);
    expected.extend_from_slice(&crc.to_le_bytes());
    assert_eq!(content(&line), expected);
}

#[test]
fn the_first_byte_of_a_message_is_its_place_in_the_list() {
    for (index, request) in requests().iter().enumerate() {
        let bytes = content(&line(request, 0, Direction::FromHost));
        let number = body(&bytes, Direction::FromHost)[0];
        assert_eq!(usize::from(number), index, "{request:?}");
        assert_eq!(usize::from(request.number()), index, "{request:?}");
        assert_eq!(bytes[..9], [2, 0, 0, 0, 0, 5, 6, 7, 8]);
    }
    for (index, report) in reports().iter().enumerate() {
        let bytes = content(&line(report, 0, Direction::FromDevice));
        assert_eq!(usize::from(bytes[3]), index, "{report:?}");
        assert_eq!(bytes[0], 0x82);
    }
}

#[test]
fn every_message_comes_back_as_it_was_sent() {
    // NaN is not equal to itself, so the printed form is compared.
    let mut receiver = Receiver::<Request>::new(Direction::FromHost);
    for (n, request) in requests().into_iter().enumerate() {
        let bytes = line(&request, n as u16, Direction::FromHost);
        let got: Vec<_> = bytes.iter().filter_map(|&b| receiver.push(b)).collect();
        let want = [(header(n as u16, Direction::FromHost), request)];
        assert_eq!(format!("{got:?}"), format!("{want:?}"));
    }
    let mut receiver = Receiver::<Report>::new(Direction::FromDevice);
    for (n, report) in reports().into_iter().enumerate() {
        let bytes = line(&report, n as u16, Direction::FromDevice);
        assert!(bytes.len() <= FRAME_MAX);
        let got: Vec<_> = bytes.iter().filter_map(|&b| receiver.push(b)).collect();
        let want = [(header(n as u16, Direction::FromDevice), report)];
        assert_eq!(format!("{got:?}"), format!("{want:?}"));
    }
}

#[test]
fn counters_that_went_round_or_back_give_a_number() {
    let before = Statistics {
        ticks: u32::MAX,
        lost: 7,
        ..Statistics::default()
    };
    let after = Statistics {
        ticks: 4,
        lost: 9,
        tick_cycles_max: 3,
        ..Statistics::default()
    };
    let since = after.since(&before);
    assert_eq!((since.ticks, since.lost, since.tick_cycles_max), (5, 2, 3));
    // A device that was reset in between.
    assert_eq!(before.since(&before), Statistics::default());
    assert_eq!(
        Statistics::default().since(&before).lost,
        7_u32.wrapping_neg()
    );
}

#[test]
fn lines_are_as_slow_as_they_may_be() {
    // 30 % to spare: 70 % of the bits of a line with 10 bits a byte.
    let sample = line(&reports()[5], 0, Direction::FromDevice).len();
    assert!(
        10 * 1000 * sample <= 460_800 * 7 / 10,
        "1 kHz at 460 800 baud"
    );
    let batch = line(&reports()[6], 0, Direction::FromDevice).len();
    let bits_per_s = 10 * batch * 10_000 / BATCH_MAX;
    assert!(
        bits_per_s <= 3_000_000 * 7 / 10,
        "10 kHz at 3 Mbaud: {bits_per_s}"
    );
}

#[test]
fn an_echo_and_another_version_are_told_apart_from_damage() {
    let mut receiver = Receiver::<Report>::new(Direction::FromDevice);
    for byte in line(&Request::Stop, 0, Direction::FromHost) {
        assert_eq!(receiver.push(byte), None);
    }
    let counters = receiver.counters();
    assert_eq!((counters.foreign, counters.foreign_version), (1, 2));
    assert_eq!((counters.corrupt, counters.received), (0, 0));
}

#[test]
fn a_frame_longer_than_the_buffer_is_counted_and_the_next_one_found() {
    let mut receiver = Receiver::<Request>::new(Direction::FromHost);
    for _ in 0..10 * FRAME_MAX {
        assert_eq!(receiver.push(7), None);
    }
    assert_eq!(receiver.push(0), None);
    assert_eq!(receiver.counters().oversize, 1);
    let good = line(&Request::Stop, 3, Direction::FromHost);
    let got = good.iter().find_map(|&byte| receiver.push(byte));
    assert_eq!(got, Some((header(3, Direction::FromHost), Request::Stop)));
}

#[test]
fn bytes_left_over_behind_a_message_make_it_no_message() {
    // As a newer version with a longer message would send it.
    let mut receiver = Receiver::<Request>::new(Direction::FromHost);
    let longer = (Request::Stop, 1_u8);
    let frame = line(&longer, 0, Direction::FromHost);
    assert!(frame.iter().all(|&byte| receiver.push(byte).is_none()));
    assert_eq!(receiver.counters().corrupt, 1);
}

#[test]
fn the_digest_is_a_crc_32_of_the_bytes_on_the_wire() {
    let values = [1.0_f32, -0.5];
    let configuration = configuration();
    let frame = content(&line(
        &Request::Configure(configuration),
        0,
        Direction::FromHost,
    ));
    let mut bytes = body(&frame, Direction::FromHost)[1..].to_vec();
    for value in values {
        bytes.extend_from_slice(&value.to_le_bytes());
    }
    let want = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&bytes);
    let digest = DigestBuilder::new(&configuration);
    assert_eq!(digest.coefficients(&values).finish(), want);
}

#[test]
fn numbers_tell_lost_duplicate_and_late_frames() {
    let mut tracker = SequenceTracker::default();
    let arrivals = [65_534, 65_535, 65_535, 1, 0, 5].map(|n| tracker.arrive(n));
    let new = |lost| Arrival::New { lost };
    assert_eq!(
        arrivals,
        [
            new(0),
            new(0),
            Arrival::Duplicate,
            new(1),
            Arrival::Late,
            new(3)
        ]
    );
    assert_eq!(
        (tracker.lost(), tracker.duplicate(), tracker.late()),
        (4, 1, 1)
    );
    // One that has started anew is believed after eight frames in a row.
    let mut last = Arrival::Late;
    for n in 0..8 {
        assert_eq!(last, Arrival::Late);
        last = tracker.arrive(60_000 + n);
    }
    assert_eq!(last, new(0));
    tracker.restart();
    assert_eq!(tracker.arrive(0), new(0));
}

#[test]
fn a_device_believes_no_request_that_comes_again() {
    let mut tracker = RequestTracker::default();
    let new = [u32::MAX - 1, u32::MAX, u32::MAX, 1, 0, 5].map(|n| tracker.is_new(n));
    assert_eq!(new, [true, true, false, true, false, true]);
    assert_eq!(
        (tracker.lost(), tracker.duplicate(), tracker.late()),
        (4, 1, 1)
    );
    // A capture of a whole minute at 1 kHz, in order, is late from its first frame to its last.
    assert!(tracker.is_new(70_000));
    assert!(!(5..=70_000).any(|n| tracker.is_new(n)));
    tracker.restart();
    assert!(tracker.is_new(5));
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

/// Every byte below 128 that is written as two, as no number has to be: the first byte is the number of the message,
/// others are enumerations, lengths and parts of numbers.
fn has_one_form<M>(good: &[u8], direction: Direction)
where
    M: serde::Serialize + serde::de::DeserializeOwned,
{
    assert!(received::<M>(good, direction).is_some(), "{good:?}");
    for at in 0..good.len() {
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
    for number in 128..=255 {
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
        has_one_form::<Report>(body(&content, Direction::FromDevice), Direction::FromDevice);
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

#[test]
fn a_host_of_another_version_is_told_apart() {
    let mut line = [0; FRAME_MAX];
    let length = haptic_link::greet_version_1(&mut line).expect("fits");
    let bytes = content(&line[..length]);
    // As version 1 had it: version, number, 0, two keys of eight bytes, CRC.
    assert_eq!((bytes.len(), bytes[0], bytes[3]), (3 + 17 + 4, 1, 0));
    let mut receiver = Receiver::<Request>::new(Direction::FromHost);
    assert!(
        line[..length]
            .iter()
            .all(|&byte| receiver.push(byte).is_none())
    );
    let counters = receiver.counters();
    assert_eq!((counters.foreign, counters.foreign_version), (1, 1));
    assert_eq!(counters.corrupt, 0);
}

#[test]
fn keys_tell_which_message_is_unlike_and_outlive_a_new_one() {
    let mut keys = Keys::current();
    assert_eq!(keys.first_unlike(3), None);
    let distinct: std::collections::BTreeSet<u32> = keys
        .requests
        .iter()
        .chain(&keys.reports)
        .map(|key| key.0)
        .collect();
    assert_eq!(distinct.len(), keys.requests.len() + keys.reports.len());
    keys.requests
        .push(haptic_link::MessageKey(1))
        .expect("there is room");
    keys.reports
        .push(haptic_link::MessageKey(2))
        .expect("there is room");
    assert_eq!(keys.first_unlike(3), None, "a device with more messages");
    // As firmware of one axis tells them: enough for it, and not for a device of several.
    let mut of_one = Keys::current();
    of_one.requests.truncate(17);
    of_one.reports.truncate(13);
    assert_eq!(
        (of_one.first_unlike(1), of_one.first_unlike(2)),
        (None, Some("forces"))
    );
    keys.reports[5].0 ^= 1;
    assert_eq!(keys.first_unlike(1), Some("sample"));
    keys.requests.truncate(11);
    assert_eq!(keys.first_unlike(1), Some("force"));
}

proptest! {
    #[test]
    fn what_was_tightened_is_never_loose(
        a in prop::array::uniform8(-1.0_f32..3.0),
        b in prop::array::uniform8(-1.0_f32..3.0),
    ) {
        let limits = |v: [f32; 8]| Limits {
            force_n: v[0],
            start_force_n: v[1].max(0.0),
            rise_time_s: v[2].max(0.0),
            workspace_low_m: v[3],
            workspace_high_m: v[3] + v[4],
            // As a device accepts them: a soft limit below the hard one, or none.
            speed_soft_m_per_s: if v[6] > 0.1 { v[5].max(0.0) } else { 0.0 },
            speed_hard_m_per_s: if v[6] > 0.1 { v[5].max(0.0) + v[6] } else { 0.0 },
            braking_n_s_per_m: v[7].max(0.0),
            ..Limits::DEFAULT
        };
        let (wanted, set) = (limits(a), limits(b));
        let (tight, _) = wanted.tightened(&set);
        prop_assert_eq!(tight.tightened(&set), (tight, None));
    }

    #[test]
    fn a_good_frame_behind_rubbish_is_found(rubbish in prop::collection::vec(any::<u8>(), 0..600)) {
        let mut receiver = Receiver::<Request>::new(Direction::FromHost);
        for &byte in &rubbish {
            receiver.push(byte);
        }
        receiver.push(0);
        let good = line(&Request::Stop, 3, Direction::FromHost);
        prop_assert_eq!(good.iter().find_map(|&b| receiver.push(b)), Some((header(3, Direction::FromHost), Request::Stop)));
    }

    #[test]
    fn damage_of_up_to_four_bits_of_a_content_is_always_seen(
        which in 0..16_usize,
        flips in prop::collection::btree_set(0..1800_usize, 1..=4),
    ) {
        let content = content(&line(&reports()[which], 1, Direction::FromDevice));
        let mut damaged = content.clone();
        for flip in flips {
            let flip = flip % (8 * content.len());
            damaged[flip / 8] ^= 1 << (flip % 8);
        }
        prop_assume!(damaged != content);
        let mut frame = vec![0; FRAME_MAX];
        let length = cobs::encode(&damaged, &mut frame);
        let mut receiver = Receiver::<Report>::new(Direction::FromDevice);
        for &byte in frame[..length].iter().chain(&[0]) {
            prop_assert!(receiver.push(byte).is_none());
        }
        prop_assert_eq!(receiver.counters().corrupt, 1);
    }

    #[test]
    fn flipped_bits_on_the_line_are_never_taken_for_a_message(
        which in 0..16_usize,
        flips in prop::collection::btree_set(0..2000_usize, 1..=8),
    ) {
        let good = line(&reports()[which], 1, Direction::FromDevice);
        let mut damaged = good.clone();
        for flip in flips {
            let flip = flip % (8 * good.len());
            damaged[flip / 8] ^= 1 << (flip % 8);
        }
        prop_assume!(damaged != good);
        let mut receiver = Receiver::<Report>::new(Direction::FromDevice);
        for byte in damaged {
            prop_assert!(receiver.push(byte).is_none());
        }
    }

    #[test]
    fn no_bytes_whatever_panic(bytes in prop::collection::vec(any::<u8>(), 0..2000)) {
        let mut receiver = Receiver::<Report>::new(Direction::FromDevice);
        for byte in bytes {
            receiver.push(byte);
        }
    }
}
