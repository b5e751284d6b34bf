//! The bytes on the line, damage to them, and the numbers on frames.

use haptic_link::{
    Ack, Alive, Arrival, BATCH_MAX, Batch, BatchItem, Capabilities, CoefficientBlock,
    Configuration, DigestBuilder, Direction, Event, EventKind, FRAME_MAX, FaultReport, Field,
    Flight, Hello, Keys, Limits, LoopMode, OperatorForm, OperatorShape, Outcome, Receiver, Refusal,
    Report, Request, Sample, SequenceTracker, Simulation, SimulationKind, Start, State, Statistics,
    Status, encode,
};
use proptest::prelude::*;

fn line<M: serde::Serialize>(message: &M, sequence: u16, direction: Direction) -> Vec<u8> {
    let mut line = [0; FRAME_MAX];
    let length = encode(message, sequence, direction, &mut line).expect("fits");
    line[..length].to_vec()
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

fn configuration() -> Configuration {
    Configuration {
        loop_mode: LoopMode::Host,
        tick_period_us: 500,
        stiffness_n_per_m: 1.5,
        dissipation_n_s_mu_per_m: 2.5,
        order: 0.2247,
        one_sided: true,
        surface_m: -0.5,
        operator: OperatorShape {
            form: OperatorForm::Modes,
            integer: -1,
            count: 66,
        },
        limits: Limits::DEFAULT,
        simulation: Simulation {
            kind: SimulationKind::RigidIndentation,
            depth_m: 1e-3,
            ramp_time_s: 1.0,
            ..Simulation::TESTBED
        },
    }
}

fn status() -> Status {
    Status {
        state: State::Fault,
        fault: 2,
        faults: 0x0102,
    }
}

fn batch(count: usize) -> Batch {
    let item = |n: usize| BatchItem {
        position_m: n as f32,
        environment_force_n: -1.0,
        force_n: f32::NAN,
        limiters: 255,
    };
    Batch {
        tick: u32::MAX,
        time_us: u32::MAX,
        every: u16::MAX,
        items: (0..count).map(item).collect(),
    }
}

fn requests() -> Vec<Request> {
    vec![
        Request::Hello(Keys::CURRENT),
        Request::GetCapabilities,
        Request::Configure(configuration()),
        Request::Coefficients(CoefficientBlock::of(&[1.0, 2.0], 0)),
        Request::Commit {
            digest: 0x0403_0201,
        },
        Request::GetConfiguration,
        Request::GetCoefficients { offset: 16 },
        Request::Arm { faults: 1 },
        Request::Disarm,
        Request::Start(Start {
            run: 7,
            ticks: 20_001,
            every: 1,
            batch: 1,
        }),
        Request::Stop,
        Request::Force {
            tick: 9,
            force_n: -0.5,
        },
        Request::KeepAlive { token: 5 },
        Request::GetStatistics,
        Request::ReadFlight { index: 3 },
        Request::Stream {
            every: 1,
            batch: 16,
        },
    ]
}

fn reports() -> Vec<Report> {
    let sample = Sample {
        tick: 1,
        time_us: 2,
        position_m: 3.0,
        environment_force_n: 4.0,
        force_n: 5.0,
        limiters: 6,
    };
    vec![
        Report::Hello(Hello {
            keys: Keys::CURRENT,
            firmware: [0, 1, 0],
            boot: 77,
            status: status(),
        }),
        Report::Capabilities(Capabilities {
            board: Capabilities::board_name("mps2"),
            axes: 1,
            simulated: true,
            tick_period_min_us: 100,
            tick_period_max_us: 10_000,
            force_max_n: 20.0,
            force_rate_max_n_per_s: 1e4,
            position_resolution_m: 0.0,
            coefficients_max: 256,
            modes_max: 48,
            degree_max: 16,
            flight_samples: 128,
        }),
        Report::Ack(Ack {
            sequence: 0x1234,
            request: 4,
            outcome: Outcome::Refused(Refusal::Range {
                field: Field::ForceLimit,
                value: 50.0,
                least: 0.0,
                most: 20.0,
            }),
        }),
        Report::Configuration {
            configuration: configuration(),
            digest: 1,
        },
        Report::Coefficients(CoefficientBlock::of(&[0.0; 16], 32)),
        Report::Sample(sample),
        Report::Batch(batch(BATCH_MAX)),
        Report::Event(Event {
            kind: EventKind::Finished,
            tick: 1,
            time_us: 2,
        }),
        Report::Fault(FaultReport {
            status: status(),
            tick: 1,
            time_us: 2,
        }),
        Report::Statistics(Statistics::default()),
        Report::Alive(Alive {
            token: 5,
            time_us: 6,
            status: status(),
            observed_energy_j: -0.5,
        }),
        Report::Flight(Flight {
            index: 1,
            count: 2,
            sample,
        }),
    ]
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
    let mut expected = vec![0x81, 9, 10, 5, 1, 2, 3, 4, 5, 6, 7, 8];
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
        assert_eq!(usize::from(bytes[3]), index, "{request:?}");
        assert_eq!(usize::from(request.number()), index, "{request:?}");
        assert_eq!(bytes[0], 1);
    }
    for (index, report) in reports().iter().enumerate() {
        let bytes = content(&line(report, 0, Direction::FromDevice));
        assert_eq!(usize::from(bytes[3]), index, "{report:?}");
        assert_eq!(bytes[0], 0x81);
    }
}

#[test]
fn every_message_comes_back_as_it_was_sent() {
    // NaN is not equal to itself, so the printed form is compared.
    let mut receiver = Receiver::<Request>::new(Direction::FromHost);
    for (n, request) in requests().into_iter().enumerate() {
        let bytes = line(&request, n as u16, Direction::FromHost);
        let got: Vec<_> = bytes.iter().filter_map(|&b| receiver.push(b)).collect();
        assert_eq!(format!("{got:?}"), format!("{:?}", [(n as u16, request)]));
    }
    let mut receiver = Receiver::<Report>::new(Direction::FromDevice);
    for (n, report) in reports().into_iter().enumerate() {
        let bytes = line(&report, n as u16, Direction::FromDevice);
        assert!(bytes.len() <= FRAME_MAX);
        let got: Vec<_> = bytes.iter().filter_map(|&b| receiver.push(b)).collect();
        assert_eq!(format!("{got:?}"), format!("{:?}", [(n as u16, report)]));
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
    assert_eq!((counters.foreign, counters.foreign_version), (1, 1));
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
    assert_eq!(got, Some((3, Request::Stop)));
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
    let mut bytes = frame[4..frame.len() - 4].to_vec();
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

proptest! {
    #[test]
    fn a_good_frame_behind_rubbish_is_found(rubbish in prop::collection::vec(any::<u8>(), 0..600)) {
        let mut receiver = Receiver::<Request>::new(Direction::FromHost);
        for &byte in &rubbish {
            receiver.push(byte);
        }
        receiver.push(0);
        let good = line(&Request::Stop, 3, Direction::FromHost);
        prop_assert_eq!(good.iter().find_map(|&b| receiver.push(b)), Some((3, Request::Stop)));
    }

    #[test]
    fn damage_of_up_to_four_bits_of_a_content_is_always_seen(
        which in 0..12_usize,
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
        which in 0..12_usize,
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
