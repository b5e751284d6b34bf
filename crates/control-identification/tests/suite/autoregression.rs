//! The filter that makes noise white, against covariances in closed form.

use crate::fixture::normal;
use control_identification::autoregression::Autoregression;
use nalgebra::{DMatrix, DVector};
use testkit::{Random, assert_close};

/// Covariance of `x_n = a·x_(n−1) + b·x_(n−2) + e_n` with var e = 1, by its closed form.
fn covariance(a: f64, b: f64, samples: usize) -> DMatrix<f64> {
    let first = a / (1.0 - b);
    let variance = 1.0 / (1.0 - a * first - b * (a * first + b));
    let mut row = vec![variance, first * variance];
    for n in 2..samples {
        row.push(a * row[n - 1] + b * row[n - 2]);
    }
    DMatrix::from_fn(samples, samples, |i, j| row[i.abs_diff(j)])
}

fn noise(a: f64, b: f64, samples: usize, random: &mut Random) -> Vec<f64> {
    let mut last = [0.0; 2];
    let mut all = Vec::new();
    for _ in 0..samples + 500 {
        let normal = normal(random);
        last = [a * last[0] + b * last[1] + normal, last[0]];
        all.push(last[0]);
    }
    all.split_off(500)
}

/// W·C·Wᵀ = 1 from the first sample on, and the likelihood is that of the whole covariance.
#[test]
fn the_filter_is_the_inverse_root_of_the_covariance() {
    for (a, b) in [
        (0.0, 0.0),
        (0.8, 0.0),
        (-0.5, 0.0),
        (1.6, -0.68),
        (0.98, 0.0),
    ] {
        let model = Autoregression::of_partial_correlations([a / (1.0 - b), b, 0.0, 0.0, 0.0, 0.0]);
        let want = covariance(a, b, 8);
        let unit = |n: usize| (0..8).map(|k| f64::from(u8::from(k == n))).collect();
        let columns: Vec<DVector<f64>> = (0..8)
            .map(|n| DVector::from_vec(model.whitened(&Vec::<f64>::from_iter::<Vec<f64>>(unit(n)))))
            .collect();
        let filter = DMatrix::from_columns(&columns);
        let off = (&filter * &want * filter.transpose() - DMatrix::identity(8, 8)).amax();
        assert!(off < 1e-10, "{a}, {b}: {off}");
        let x = [1.0, -0.3, 0.4, 2.0, 0.1, -1.0, 0.7, 0.2];
        let vector = DVector::from_column_slice(&x);
        let inverse = want.clone().try_inverse().expect("of full rank");
        let form = vector.dot(&(inverse * &vector));
        let likelihood = 8.0 * (form / 8.0).ln() + want.determinant().ln();
        assert_close("deviance", model.deviance(&[&x], 0.0), likelihood, 1e-9);
    }
}

/// Within four standard errors of the closed form, √((1 − b²)/n); white noise has order 0 in nineteen of twenty records, an order that is there is
/// found in all.
#[test]
fn correlations_and_order_are_those_of_the_noise() {
    let (mut white, mut pairs) = (0, 0);
    for seed in 0..40 {
        let mut random = Random(seed);
        white +=
            usize::from(Autoregression::of(&[&noise(0.0, 0.0, 300, &mut random)]).order() == 0);
        let alike = noise(1.2, -0.5, 1000, &mut random);
        let model = Autoregression::of(&[&alike]);
        pairs += usize::from(model.order() == 2);
        assert!(model.order() >= 2, "{seed}: {model:?}");
        // Of a = 1.2, b = −0.5 the filter takes x_n − 1.2·x_(n−1) + 0.5·x_(n−2).
        let mut impulse = vec![0.0; 9];
        impulse[6] = 1.0;
        let answer = model.whitened(&impulse);
        let error = 4.0 * (0.75f64 / 1000.0).sqrt() * (1.0 + (model.order() - 2) as f64);
        assert_close("a", answer[7], -1.2, error);
        assert_close("b", answer[8], 0.5, error);
    }
    assert!(white >= 36 && pairs >= 34, "{white}, {pairs} of 40");
}

/// A slow disturbance on a slope: the errors of generalized least squares hold the truth as often as they say, those of least squares do not.
#[test]
fn filtered_columns_give_honest_errors() {
    let line: Vec<f64> = (0..200).map(|n| f64::from(n) / 200.0).collect();
    let power = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
    let inside = |model: &Autoregression, wanted: &[f64]| {
        let (column, wanted) = (model.whitened(&line), model.whitened(wanted));
        let slope = power(&column, &wanted) / power(&column, &column);
        let left: f64 = column
            .iter()
            .zip(&wanted)
            .map(|(x, y)| (y - slope * x).powi(2))
            .sum();
        slope.abs() < 1.96 * (left / 199.0 / power(&column, &column)).sqrt()
    };
    let (mut plain, mut filtered) = (0, 0);
    for seed in 100..300 {
        let wanted = noise(0.9, 0.0, 200, &mut Random(seed));
        plain += usize::from(inside(&Autoregression::default(), &wanted));
        filtered += usize::from(inside(&Autoregression::of(&[&wanted]), &wanted));
    }
    assert!(
        filtered >= 180 && plain <= 110,
        "{filtered} and {plain} of 200"
    );
}

/// Samples of two segments that happen to stand beside each other are no neighbours; what has no noise is white.
#[test]
fn segments_know_nothing_of_each_other() {
    let (mut one, mut other) = (
        noise(0.9, 0.0, 400, &mut Random(1)),
        noise(0.9, 0.0, 400, &mut Random(2)),
    );
    let model = Autoregression::of(&[&one, &other]);
    assert_eq!(model.order(), 1, "{model:?}");
    let apart = model.deviance(&[&one, &other], 0.0);
    let joined = [one.clone(), other.clone()].concat();
    assert!((model.deviance(&[&joined], 0.0) - apart).abs() > 1e-3);
    for segments in [
        &[&[][..]][..],
        &[&[0.0; 50]],
        &[&[f64::NAN; 50]],
        &[&[1.0; 3]],
    ] {
        assert_eq!(Autoregression::of(segments), Autoregression::default());
    }
    // What the last digits of a tenth of the unit lose changes nothing of the order.
    for x in one.iter_mut().chain(&mut other) {
        *x = (10.0 * *x).round() / 10.0;
    }
    assert_eq!(Autoregression::of(&[&one, &other]).order(), 1);
}
