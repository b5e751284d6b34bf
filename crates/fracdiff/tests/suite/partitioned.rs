//! Partitioned memory: the sums of the short memory, whatever the length.

use crate::oracle::{SAMPLE_TIME, assert_close, grunwald_sum, largest, lively, order, run};
use fracdiff::scheme::SHORT_MOST;
use fracdiff::{
    Differintegrator, FrequencyResponse, Operator, ParameterError, PartitionedMemory, Real, Scheme,
    Seconds, ShortMemoryVec, grunwald_weights,
};
use proptest::prelude::*;

/// Without a level, at the seams of one, with two and with three; most no multiple of any block.
const LENGTHS: [usize; 12] = [1, 2, 63, 64, 65, 100, 511, 1088, 1089, 4096, 8705, 40_000];

fn partitioned<F: Real>(mu: f64, length: usize) -> PartitionedMemory<F> {
    PartitionedMemory::new(order(mu), length, SAMPLE_TIME).expect("valid")
}

fn short<F: Real>(mu: f64, length: usize) -> ShortMemoryVec<F> {
    ShortMemoryVec::new(order(mu), length, SAMPLE_TIME).expect("valid")
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn partitioned_memory_is_short_memory_to_rounding() {
    for length in LENGTHS {
        // Past the end of the memory, through several blocks of the last level.
        let x = lively(length + 9_000);
        for mu in [-1.5, 0.2247, 1.7] {
            let want = run(&short::<f64>(mu, length), &x);
            let have = run(&partitioned::<f64>(mu, length), &x);
            assert_close(&have, &want, 1e-12 * largest(&want));
        }
    }
}

#[test]
fn single_precision_is_as_good_as_direct_sums() {
    let x = lively(50_000);
    let want = run(&short::<f64>(0.2247, 40_000), &x);
    let have = run(&partitioned::<f32>(0.2247, 40_000), &x);
    // Taps, samples, products and sums, half a unit each: 6·2^(−24)·T^(−μ)·Σ|c_j|·max|x|, Σ|c_j| < 2.
    let summed = SAMPLE_TIME.0.powf(-0.2247) * 2.0 * largest(&x);
    assert_close(&have, &want, 6.0 * 2f64.powi(-24) * summed);
}

#[test]
fn a_constant_is_held_to_twelve_digits() {
    let x = vec![1.0; 60_000];
    let want = grunwald_sum(0.2247, SAMPLE_TIME, 5000, &x[..6000]);
    let have = run(&partitioned::<f64>(0.2247, 5000), &x);
    assert_close(&have[..6000], &want, 1e-12 * want[0]);
    // Full since sample 5000: nothing may drift.
    let last = vec![want[5999]; x.len() - 6000];
    assert_close(&have[6000..], &last, 1e-12 * want[0]);
}

#[test]
fn a_nan_is_seen_for_the_memory_and_then_forgotten() {
    let length = 3000;
    let memory = partitioned::<f64>(0.5, length);
    for at in [0, 31, 777] {
        let mut x = vec![1.0; 12_000];
        x[at] = f64::NAN;
        let y = run(&memory, &x);
        let spoilt = y[at..].iter().take_while(|y| y.is_nan()).count();
        // Blocks of the last level are 256 samples long.
        assert!(
            (length..length + 2 * 256).contains(&spoilt),
            "{at}: {spoilt}"
        );
        assert!(y[at + spoilt..].iter().all(|y| y.is_finite()), "{at}");
    }
}

#[test]
fn the_history_of_another_length_gives_nothing_that_looks_like_a_result() {
    let memory = partitioned::<f64>(0.5, 3000);
    for other in [1, 100, 3300, 40_000] {
        let mut history = partitioned::<f64>(0.5, other).at_rest();
        memory.advance(&mut history, 1.0);
        assert!(memory.output(&history, 1.0).is_nan(), "{other}");
    }
}

#[test]
fn it_has_the_response_and_the_refusals_of_short_memory() {
    let (have, want) = (partitioned::<f32>(0.7, 3000), short::<f32>(0.7, 3000));
    for theta in [0.0, 0.01, 1.0, 3.0] {
        assert_eq!(have.response(theta), want.response(theta));
    }
    assert_eq!(have.memory_length(), Some(3000));
    let most = ShortMemoryVec::<f64>::MOST;
    for length in [0, most + 1] {
        let refused = PartitionedMemory::<f64>::new(order(0.5), length, SAMPLE_TIME);
        let want = format!("memory length {length} is not in [1, {most}]");
        assert_eq!(refused.expect_err("no length").to_string(), want);
    }
    let error = PartitionedMemory::<f64>::new(order(0.5), 9, Seconds(0.0)).expect_err("no time");
    assert_eq!(error, ParameterError::SampleTime(Seconds(0.0)));
}

#[test]
fn schemes_take_it_for_long_memories_only() {
    let build = |length| {
        let scheme = Scheme::Grunwald { length };
        scheme
            .build::<f64>(order(0.5), SAMPLE_TIME, 1e3)
            .expect("valid")
    };
    assert!(matches!(build(SHORT_MOST), Operator::ShortMemory(_)));
    assert!(matches!(
        build(SHORT_MOST + 1),
        Operator::PartitionedMemory(_)
    ));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]
    #[test]
    fn any_length_order_and_signal_agree_with_short_memory(
        mu in -2.0..2.0_f64,
        length in 1..2500_usize,
        x in prop::collection::vec(-1.0..1.0_f64, 1..4000),
    ) {
        let want = run(&short::<f64>(mu, length), &x);
        let have = run(&partitioned::<f64>(mu, length), &x);
        // Rounding follows what is summed: T^(−μ)·Σ|c_j|·max|x|.
        let gains: f64 = grunwald_weights(order(mu)).take(length).map(f64::abs).sum();
        let summed = SAMPLE_TIME.0.powf(-mu) * gains * largest(&x);
        assert_close(&have, &want, 1e-14 * summed);
    }
}
