//! Counting an encoder from samples, against a shaft that turns.

use haptic_board::{Quadrature, haptic_loop::Fault};
use std::sync::atomic::{AtomicU8, Ordering};

/// Channels at a count: A is bit 0, B bit 1, A leads.
fn pins(count: i64) -> u32 {
    [0b00, 0b01, 0b11, 0b10][count.rem_euclid(4) as usize]
}

/// Samples of a shaft as words of `number`.
fn words(counts: &[i64], number: usize) -> impl Iterator<Item = (u32, u32)> {
    counts.chunks(number).map(|chunk| {
        let word = chunk
            .iter()
            .enumerate()
            .fold(0, |word, (index, &count)| word | pins(count) << (2 * index));
        (word, chunk.len() as u32)
    })
}

#[test]
fn a_shaft_that_turns_to_and_fro_is_counted_exactly() {
    // One count a sample at most, wherever it begins.
    for begin in 0..4 {
        let counts: Vec<i64> = (0..4000)
            .map(|sample| begin + (1000.0 * (f64::from(sample) * 1e-3).sin()) as i64)
            .collect();
        for number in [1, 5, 16] {
            let mut encoder = Quadrature::new();
            for (word, samples) in words(&counts, number) {
                encoder.take(word, samples).expect("slow enough");
            }
            let turned = counts[counts.len() - 1] - counts[0];
            assert_eq!(i64::from(encoder.count()), turned);
        }
    }
}

#[test]
fn two_counts_between_samples_are_a_fault_once() {
    let mut encoder = Quadrature::new();
    for (word, samples) in words(&[0, 1, 3, 4], 16) {
        assert_eq!(encoder.take(word, samples), Err(Fault::PositionJump));
    }
    assert_eq!(encoder.count(), 2, "what was seen");
    assert_eq!(encoder.take(pins(5), 1), Ok(()));
    assert_eq!(encoder.count(), 3);
    // What is counted from here on is right, but from the wrong place.
    assert_eq!(encoder.lost(), Some(Fault::PositionJump));
}

#[test]
fn more_samples_than_a_word_holds_are_not_invented() {
    let mut encoder = Quadrature::new();
    encoder.take(0, 99).expect("no motion");
    assert_eq!(encoder.count(), 0);
}

#[test]
fn at_a_constant_speed_every_tick_counts_the_same_whatever_its_period() {
    // 128 samples a millisecond, four a byte, in a ring that comes round every 2 ms, as a chip's DMA writes it.
    const SAMPLES_PER_S: f64 = 128e3;
    let ring: [AtomicU8; 64] = std::array::from_fn(|_| AtomicU8::new(0));
    for period_s in [1e-3, 1.1e-3, 1.333e-3, 1.9e-3] {
        let mut encoder = Quadrature::new();
        let counts_a_tick = 10.0;
        let count_at = |time_s: f64| (counts_a_tick * time_s / period_s) as i64;
        let (mut written, mut before) = (0_usize, 0);
        for tick in 1..=3000 {
            let time_s = f64::from(tick) * period_s;
            // What is full at the time of the tick.
            let full = (time_s * SAMPLES_PER_S / 4.0) as usize;
            for byte in written..full {
                let sample = |index| count_at((4 * byte + index) as f64 / SAMPLES_PER_S);
                let samples =
                    (0..4).fold(0, |byte, index| byte | pins(sample(index)) << (2 * index));
                ring[byte % ring.len()].store(samples as u8, Ordering::Relaxed);
            }
            written = full;
            let end = written % ring.len();
            encoder.take_ring(&ring, end).expect("slow enough");
            let count = encoder.count();
            // A byte is 31 µs, a third of a count here.
            let behind = counts_a_tick * f64::from(tick) - f64::from(count);
            assert!(
                (0.0..1.5).contains(&behind),
                "{period_s}: {behind} at {tick}"
            );
            assert!(
                tick < 2 || (9..=11).contains(&(count - before)),
                "{period_s}: {}",
                count - before
            );
            before = count;
        }
    }
}

#[test]
fn a_shaft_that_rests_at_first_loses_no_count_of_a_ring() {
    // The first count comes between two bytes.
    let ring = [0x00, 0x00, 0x55, 0x55, 0xff].map(AtomicU8::new);
    let mut encoder = Quadrature::new();
    for end in [2, 4, 0] {
        encoder.take_ring(&ring, end).expect("slow enough");
    }
    assert_eq!(encoder.count(), 2);
    // Both channels high, as an empty ring says nothing of.
    let ring = [0xff, 0xff, 0xaa].map(AtomicU8::new);
    let mut encoder = Quadrature::new();
    for end in [0, 2, 0] {
        encoder.take_ring(&ring, end).expect("slow enough");
    }
    assert_eq!(encoder.count(), 1);
}

/// The first fault of a shaft, its place in counts given for each of 128 samples a tick, with A or B off, and its tick.
fn fault_of(off: Option<u32>, ticks: u32, count_at: impl Fn(f64) -> f64) -> Option<(u32, Fault)> {
    let ring: [AtomicU8; 64] = std::array::from_fn(|_| AtomicU8::new(0));
    let mut encoder = Quadrature::new();
    for tick in 0..ticks {
        for byte in 0..32 {
            let sample = |index: u32| {
                let time_ms = f64::from(tick) + f64::from(4 * byte + index) / 128.0;
                // The pull-up of a wire that is off.
                pins(count_at(time_ms).floor() as i64) | off.map_or(0, |channel| 1 << channel)
            };
            let samples = (0..4).fold(0, |byte, index| byte | sample(index) << (2 * index));
            ring[(32 * tick + byte) as usize % 64].store(samples as u8, Ordering::Relaxed);
        }
        let end = (32 * (tick + 1)) as usize % 64;
        if let Err(fault) = encoder.take_ring(&ring, end) {
            assert_eq!(encoder.lost(), Some(fault));
            return Some((tick, fault));
        }
        assert_eq!(encoder.lost(), None);
    }
    None
}

#[test]
fn a_wire_that_is_off_is_a_fault_once_the_shaft_turns() {
    for off in [0, 1] {
        for direction in [1.0, -1.0] {
            // 50 mm/s at counts of 16 µm: within 30 ms.
            let steady = fault_of(Some(off), 100, |t| direction * 3.2 * t);
            assert!(
                matches!(steady, Some((..=30, Fault::EncoderWire))),
                "{steady:?}"
            );
            // 65 g under 5 N from rest: within 8 ms, as soon as it has moved 2.5 mm.
            let pushed = fault_of(Some(off), 100, |t| direction * 2.4 * t * t);
            assert!(
                matches!(pushed, Some((..=8, Fault::EncoderWire))),
                "{pushed:?}"
            );
        }
    }
}

#[test]
fn no_motion_of_a_whole_encoder_is_taken_for_a_wire_that_is_off() {
    let tau = std::f64::consts::TAU;
    // Slow and fast, a tremor across one edge, and a loop that shakes that edge as fast as it can: every second tick.
    for speed in [0.003, 0.1, 0.6, 1.7, 20.0, 100.0] {
        assert_eq!(fault_of(None, 20_000, |t| speed * t), None, "{speed}");
    }
    // Creep across an edge whose comparator chatters.
    let noise = |t: f64| (1e4 * (127.1 * t).sin()).fract();
    for speed in [0.01, 0.03] {
        let fault = fault_of(None, 20_000, |t| speed * t + 0.01 * noise(t));
        assert_eq!(fault, None, "{speed} with noise");
    }
    for (amplitude, period) in [(0.4, 100.0), (30.0, 100.0), (0.4, 2.0), (0.9, 2.1)] {
        for edge in 0..4 {
            let shaken = |t: f64| f64::from(edge) + amplitude * (tau * t / period + 0.3).sin();
            let fault = fault_of(None, 20_000, shaken);
            assert_eq!(fault, None, "{amplitude} counts, {period} ms");
        }
    }
}
