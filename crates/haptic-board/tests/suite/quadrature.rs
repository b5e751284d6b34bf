//! Counting an encoder from samples, against a shaft that turns.

use haptic_board::Quadrature;
use haptic_board::haptic_loop::Fault;

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
}

#[test]
fn more_samples_than_a_word_holds_are_not_invented() {
    let mut encoder = Quadrature::new();
    encoder.take(0, 99).expect("no motion");
    assert_eq!(encoder.count(), 0);
}
