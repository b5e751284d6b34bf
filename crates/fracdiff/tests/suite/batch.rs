//! Whole records by FFT: the defining sums.

use crate::oracle::{
    SAMPLE_TIME, assert_close, convolve, grunwald_sum, largest, lively, order, run,
};
use fracdiff::full_memory::Kernel;
use fracdiff::{
    ParameterError, Seconds, ShortMemoryVec, batch, grunwald_weights, piecewise_linear_weight,
};

#[test]
fn the_full_history_is_the_defining_sum() {
    for length in [0, 1, 2, 700] {
        let x = lively(length);
        for mu in [-1.5, 0.0, 0.4, 1.0, 1.6] {
            let have = batch::full_history(Kernel::Grunwald, order(mu), SAMPLE_TIME, &x);
            let want = grunwald_sum(mu, SAMPLE_TIME, length.max(1), &x);
            assert_close(&have.expect("valid"), &want, 1e-12 * largest(&want));
        }
        let lags = 0..length.max(1) as u64;
        let weights = lags.map(|lag| piecewise_linear_weight(order(0.4), lag).expect("below 1"));
        let want = convolve(&weights.collect::<Vec<_>>(), &x);
        let have = batch::full_history(Kernel::PiecewiseLinear, order(0.4), Seconds(1.0), &x);
        assert_close(
            &have.expect("valid"),
            &want,
            1e-12 * largest(&want).max(1.0),
        );
    }
}

#[test]
fn a_million_samples_are_within_1e_12_of_direct_sums() {
    let x = lively(1_000_000);
    let weights: Vec<f64> = grunwald_weights(order(0.2247)).take(x.len()).collect();
    let have = batch::full_history(Kernel::Grunwald, order(0.2247), SAMPLE_TIME, &x);
    let have = have.expect("valid");
    for n in [0, 1, 31_999, 500_000, 765_432, 999_999] {
        // Small terms first.
        let sum: f64 = (0..=n).rev().map(|j| weights[j] * x[n - j]).sum();
        let want = SAMPLE_TIME.0.powf(-0.2247) * sum;
        assert!(
            (have[n] - want).abs() <= 1e-12 * largest(&have),
            "sample {n}: have {:e}, want {want:e}",
            have[n]
        );
    }
}

#[test]
fn a_short_memory_of_a_record_is_the_operator_run_over_it() {
    // One block, several, and one that ends inside the last.
    for (length, samples) in [(1, 50), (100, 300), (100, 5000), (333, 2664), (900, 500)] {
        let x = lively(samples);
        for mu in [-0.5, 0.2247, 1.0] {
            let operator = ShortMemoryVec::<f64>::new(order(mu), length, SAMPLE_TIME);
            let want = run(&operator.expect("valid"), &x);
            let have = batch::short_memory(order(mu), length, SAMPLE_TIME, &x).expect("valid");
            assert_close(&have, &want, 1e-12 * largest(&want));
        }
    }
}

#[test]
fn bad_parameters_are_refused() {
    let error = batch::full_history(Kernel::Grunwald, order(0.5), Seconds(f64::NAN), &[1.0]);
    assert!(matches!(error, Err(ParameterError::SampleTime(_))));
    let error = batch::short_memory(order(0.5), 0, SAMPLE_TIME, &[1.0]);
    assert!(matches!(error, Err(ParameterError::Length { .. })));
}
