//! Whole records by FFT: the defining sums.

use crate::oracle::{
    SAMPLE_TIME, assert_close, convolve, grunwald_sum, largest, lively, order, run,
};
use fracdiff::batch::{Batch, uneven};
use fracdiff::full_memory::Kernel;
use fracdiff::{
    Channel, ParameterError, Seconds, ShortMemoryVec, grunwald_weights, piecewise_linear_weight,
};

#[test]
fn the_full_history_is_the_defining_sum() {
    for length in [0, 1, 2, 700] {
        let x = lively(length);
        for mu in [-1.5, 0.0, 0.4, 1.0, 1.6] {
            let have = Batch::full_history(Kernel::Grunwald, order(mu), SAMPLE_TIME)
                .map(|sum| sum.run(&x));
            let want = grunwald_sum(mu, SAMPLE_TIME, length.max(1), &x);
            assert_close(&have.expect("valid"), &want, 1e-12 * largest(&want));
        }
        let lags = 0..length.max(1) as u64;
        let weights = lags.map(|lag| piecewise_linear_weight(order(0.4), lag).expect("below 1"));
        let want = convolve(&weights.collect::<Vec<_>>(), &x);
        let have = Batch::full_history(Kernel::PiecewiseLinear, order(0.4), Seconds(1.0))
            .map(|sum| sum.run(&x));
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
    let have =
        Batch::full_history(Kernel::Grunwald, order(0.2247), SAMPLE_TIME).map(|sum| sum.run(&x));
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
            let have = Batch::short_memory(order(mu), length, SAMPLE_TIME)
                .map(|sum| sum.run(&x))
                .expect("valid");
            assert_close(&have, &want, 1e-12 * largest(&want));
        }
    }
}

#[test]
fn bad_parameters_are_refused() {
    let error = Batch::full_history(Kernel::Grunwald, order(0.5), Seconds(f64::NAN))
        .map(|sum| sum.run(&[1.0]));
    assert!(matches!(error, Err(ParameterError::SampleTime(_))));
    let error = Batch::short_memory(order(0.5), 0, SAMPLE_TIME).map(|sum| sum.run(&[1.0]));
    assert!(matches!(error, Err(ParameterError::Length { .. })));
}

#[test]
fn the_samples_that_are_not_finite_spoil_what_they_reach_and_nothing_else() {
    let clean = lively(2000);
    let mut x = clean.clone();
    (x[700], x[1500]) = (f64::NAN, f64::NEG_INFINITY);
    let half = order(0.5);
    let full = Batch::full_history(Kernel::Grunwald, half, SAMPLE_TIME).expect("valid");
    let short = Batch::short_memory(half, 100, SAMPLE_TIME).expect("valid");
    // A whole order reaches no further than its difference.
    let second = Batch::full_history(Kernel::Grunwald, order(2.0), SAMPLE_TIME).expect("valid");
    for (batch, memory) in [(full, 2000), (short, 100), (second, 3)] {
        let reaches = |bad: usize, n: usize| (bad..bad + memory).contains(&n);
        let want = batch.run(&clean);
        let (have, mask) = (batch.run(&x), batch.mask(&x));
        for n in 0..2000 {
            let spoiled = reaches(700, n) || reaches(1500, n);
            assert_eq!(
                (mask[n], have[n].is_nan()),
                (spoiled, spoiled),
                "{memory} {n}"
            );
            // What a transform rounds, it rounds everywhere; and behind the gap of the full history all is spoiled.
            let rounding = 1e-12 * largest(&want);
            let close = (have[n] - want[n]).abs() <= rounding;
            assert!(spoiled || close, "{memory} {n}: {} {}", have[n], want[n]);
        }
    }
}

#[test]
fn a_reference_is_where_the_signal_stood_before() {
    let x = lively(600);
    let batch = Batch::full_history(Kernel::Grunwald, order(0.5), SAMPLE_TIME).expect("valid");
    let operator = ShortMemoryVec::<f64>::new(order(0.5), 600, SAMPLE_TIME).expect("valid");
    for (batch, reference) in [
        (batch.clone().caputo(), x[0]),
        (batch.relative_to(-3.0), -3.0),
    ] {
        let mut channel = Channel::new(operator.clone());
        channel.reset_to(reference);
        let want: Vec<f64> = x.iter().map(|&x| channel.step(x)).collect();
        assert_close(&batch.run(&x), &want, 1e-12 * largest(&want));
    }
}

#[test]
fn channels_together_are_channels_alone() {
    let x = lively(900);
    let channels = [&x[..], &x[200..], &x[..0], &x[5..6]];
    let batch = Batch::short_memory(order(-0.5), 40, SAMPLE_TIME)
        .expect("valid")
        .caputo();
    let together = batch.channels(&channels);
    assert_eq!(together.len(), 4);
    for (x, have) in channels.iter().zip(&together) {
        let want = batch.run(x);
        assert_close(have, &want, 1e-13 * largest(&want));
    }
    assert!(batch.channels(&[]).is_empty());
}

/// Times whose steps differ by a factor of ten, from a time that is not 0.
fn uneven_times(count: usize) -> Vec<f64> {
    let step = |n: usize| 1e-3 * (1.0 + 9.0 * ((n * 7919) % 101) as f64 / 100.0);
    (0..count)
        .scan(0.3, |t, n| {
            let now = *t;
            *t += step(n);
            Some(now)
        })
        .collect()
}

#[test]
fn uneven_times_give_the_closed_form_of_a_ramp_and_of_a_line_that_bends() {
    let t = uneven_times(200);
    let bend = t[80];
    for mu in [-2.0, -1.3, -0.5, -1e-9, 0.0, 0.2154, 0.5, 0.9, 1.0 - 1e-9] {
        // 5 + 3·(t − t₀) − 7·(t − bend)⁺, whose derivatives are those of powers.
        let x: Vec<f64> = t
            .iter()
            .map(|t| 5.0 + 3.0 * (t - t_first()) - 7.0 * (t - bend).max(0.0))
            .collect();
        let power = |age: f64, p: f64| if age > 0.0 { age.powf(p - mu) } else { 0.0 };
        let ramp = |age: f64| power(age, 1.0) / libm::tgamma(2.0 - mu);
        for reference in [0.0, 5.0] {
            let have = uneven(order(mu), &t, &x, reference).expect("valid");
            // At the first time itself the jump is infinite for μ > 0.
            for (n, &t) in t.iter().enumerate().skip(1) {
                let age = t - t_first();
                let jump = (5.0 - reference) * power(age, 0.0) / libm::tgamma(1.0 - mu);
                let want = 3.0 * ramp(age) - 7.0 * ramp(t - bend) + jump;
                let scale = want.abs().max(3.0 * ramp(age)).max(1e-3);
                assert!(
                    (have[n] - want).abs() < 1e-11 * scale,
                    "{mu} {n}: {} {want}",
                    have[n]
                );
            }
        }
    }
}

fn t_first() -> f64 {
    uneven_times(1)[0]
}

#[test]
fn orders_from_1_on_and_times_that_do_not_rise_are_refused() {
    let refused = |mu, times: &[f64]| uneven(order(mu), times, &[1.0, 2.0, 3.0], 0.0).unwrap_err();
    let beyond = refused(1.0, &[0.0, 1.0, 3.0]);
    assert_eq!(beyond.to_string(), "order of uneven times 1 is not below 1");
    let falls = refused(0.5, &[0.0, 3.0, 1.0]);
    assert_eq!(falls.to_string(), "step of time -2 s is not above 0 s");
    assert!(
        uneven(order(0.5), &[], &[], 0.0)
            .expect("nothing")
            .is_empty()
    );
}
