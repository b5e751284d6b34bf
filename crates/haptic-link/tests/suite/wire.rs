//! The bytes on the line, and damage to them.

mod limits;
mod numbers;
mod one_form;

use crate::{
    frames::{body, header, line},
    messages::{configuration, extreme_batch, reports, requests, sample},
};
use haptic_link::{
    BATCH_MAX, BatchItem, Conduct, DeviceReport, DigestBuilder, Direction, EncodeError, FRAME_MAX,
    Receiver, Request, SENSED_MAX, Sample, encode,
};
use proptest::prelude::*;

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
fn a_sample_of_one_axis_is_a_packed_structure_and_no_sensor_costs_it_a_byte() {
    let item = BatchItem {
        position_m: 1.0,
        environment_force_n: -2.0,
        force_n: 0.5,
        limiters: 3,
        flaws: 1,
    };
    for (sensed, bytes) in [(None, 34), (Some(0.25_f32), 38)] {
        let sample = Sample {
            tick: 0x0403_0201,
            time_us: 0x0807_0605,
            axes: [item].into_iter().collect(),
            sensed_force_n: sensed.into_iter().collect(),
        };
        let line = line(&DeviceReport::Sample(sample), 0x0a09, Direction::FromDevice);
        assert_eq!(line.len(), bytes);
        let mut expected = vec![0x82, 9, 10, 5, 1, 2, 3, 4, 5, 6, 7, 8, 1];
        for value in [1.0_f32, -2.0, 0.5] {
            expected.extend_from_slice(&value.to_le_bytes());
        }
        expected.extend([3, 1, u8::from(sensed.is_some())]);
        expected.extend(sensed.into_iter().flat_map(f32::to_le_bytes));
        let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&expected);
        expected.extend_from_slice(&crc.to_le_bytes());
        assert_eq!(content(&line), expected);
    }
}

#[test]
fn the_first_byte_of_a_message_is_its_place_in_the_list() {
    for (index, request) in requests().iter().enumerate() {
        let bytes = content(&line(request, 0, Direction::FromHost));
        let number = body(&bytes, Direction::FromHost)[0];
        assert_eq!(usize::from(number), index, "{request:?}");
        assert_eq!(usize::from(request.number()), index, "{request:?}");
        assert_eq!(bytes[..9], [2, 0, 0, 0, 0, 0x3d, 0x4c, 0x5b, 0x6a]);
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
    let mut receiver = Receiver::<DeviceReport>::new(Direction::FromDevice);
    let extreme = [DeviceReport::Batch(extreme_batch())];
    for (n, report) in reports().into_iter().chain(extreme).enumerate() {
        let bytes = line(&report, n as u16, Direction::FromDevice);
        assert!(bytes.len() <= FRAME_MAX);
        let got: Vec<_> = bytes.iter().filter_map(|&b| receiver.push(b)).collect();
        let want = [(header(n as u16, Direction::FromDevice), report)];
        assert_eq!(format!("{got:?}"), format!("{want:?}"));
    }
}

#[test]
fn a_message_is_in_postcard_fits_or_is_refused_and_cut_short_is_none() {
    let mut room = [0; FRAME_MAX];
    for request in requests() {
        let whole = line(&request, 1, Direction::FromHost);
        let bytes = postcard::to_slice(&request, &mut room).expect("fits");
        assert_eq!(body(&content(&whole), Direction::FromHost), bytes);
        assert_eq!(postcard::from_bytes::<Request>(bytes), Ok(request.clone()));
        for short in 0..bytes.len() {
            assert!(postcard::from_bytes::<Request>(&bytes[..short]).is_err());
        }
        let header = header(1, Direction::FromHost);
        for short in 0..whole.len() {
            let framed = encode(&request, header, &mut room[..short]);
            assert_eq!(framed, Err(EncodeError::TooLong), "{short}");
        }
        assert_eq!(
            encode(&request, header, &mut room[..whole.len()]),
            Ok(whole.len())
        );
    }
}

#[test]
fn lines_are_as_slow_as_they_may_be() {
    // A quarter to spare of the bits of a line with 10 bits a byte, of one axis.
    // A force sensor takes a third of that reserve.
    for (sensed, most) in [(false, 3.0 / 4.0), (true, 5.0 / 6.0)] {
        let mut sample = sample(1);
        if !sensed {
            sample.sensed_force_n.clear();
        }
        let bytes = line(&DeviceReport::Sample(sample), 0, Direction::FromDevice).len();
        let share = (10 * 1000 * bytes) as f64 / 460_800.0;
        assert!(share <= most, "1 kHz at 460 800 baud: {share}");
    }
    for (report, ticks) in [
        (DeviceReport::Batch(extreme_batch()), BATCH_MAX),
        (reports()[6].clone(), SENSED_MAX),
    ] {
        let batch = line(&report, 0, Direction::FromDevice).len();
        let bits_per_s = 10 * batch * 10_000 / ticks;
        assert!(
            bits_per_s <= 3_000_000 * 3 / 4,
            "10 kHz at 3 Mbaud: {bits_per_s}"
        );
    }
}

#[test]
fn an_echo_and_another_version_are_told_apart_from_damage() {
    let mut receiver = Receiver::<DeviceReport>::new(Direction::FromDevice);
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

proptest! {
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
        which in 0..13_usize,
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
        let mut receiver = Receiver::<DeviceReport>::new(Direction::FromDevice);
        for &byte in frame[..length].iter().chain(&[0]) {
            prop_assert!(receiver.push(byte).is_none());
        }
        prop_assert_eq!(receiver.counters().corrupt, 1);
    }

    #[test]
    fn no_bytes_whatever_panic(bytes in prop::collection::vec(any::<u8>(), 0..2000)) {
        let mut receiver = Receiver::<DeviceReport>::new(Direction::FromDevice);
        for byte in bytes {
            receiver.push(byte);
        }
    }
}

#[test]
fn firmware_that_knows_no_motion_says_the_same_as_ever() {
    for (byte, [lets_go, moves, to_measure]) in [
        (0, [false, false, false]),
        (1, [true, false, false]),
        (2, [false, true, false]),
        (3, [true, true, false]),
        (6, [false, true, true]),
        (7, [true, true, true]),
    ] {
        let conduct = Conduct {
            lets_go,
            moves,
            to_measure,
        };
        assert_eq!(postcard::from_bytes(&[byte]), Ok(conduct));
        let mut room = [9; 1];
        assert_eq!(
            postcard::to_slice(&conduct, &mut room).as_deref(),
            Ok(&[byte][..])
        );
    }
    for unknown in [4, 5, 8] {
        assert!(postcard::from_bytes::<Conduct>(&[unknown]).is_err());
    }
    // A host from before takes a device that moves for damaged.
    assert!(postcard::from_bytes::<bool>(&[2]).is_err());
}
