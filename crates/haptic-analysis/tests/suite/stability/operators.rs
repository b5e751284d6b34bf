//! Operators as the verdicts see them: responses, variation bounds, polynomials.

use super::muir3;
use fracdiff::{FrequencyResponse, Scheme, Seconds};
use nalgebra::Complex;
use std::f64::consts::PI;
use testkit::assert_close;
use testkit::operator::{operator, order};

#[test]
fn the_running_operators_have_the_response_that_is_analysed() {
    let schemes = "grunwald:20 muir:3 muir:8 tustin-muir:5 oustaloup:6:0.5:200 full:1e-6 piecewise-linear:1e-4 full-bdf2:1e-6";
    for scheme in schemes.split(' ') {
        for mu in [0.0, 0.25, 0.5, 1.0, 1.3, 1.8, 2.0] {
            let running: Scheme = scheme.parse().expect("a scheme");
            let running = running
                .build::<f64>(order(mu), Seconds(1e-3), 1e5)
                .expect("builds");
            let analysed = operator(scheme, mu);
            for theta in [1e-4, 0.01, 0.3, 1.0, 2.5, 3.1] {
                let (have, want) = (analysed.response(theta), running.response(theta));
                let most = 1e-11 * (1.0 + want.norm());
                assert!(
                    (have - want).norm() < most,
                    "{scheme}, μ = {mu}, θ = {theta}"
                );
            }
            // The direct gain is the response averaged over the circle.
            let angle = |k: i32| std::f64::consts::PI * (f64::from(k) + 0.5) / 4096.0;
            let sum: f64 = (0..4096).map(|k| analysed.response(angle(k)).re).sum();
            assert_close(scheme, sum / 4096.0, analysed.direct_gain(), 1e-3);
        }
    }
}

#[test]
fn the_variation_bounds_every_difference_and_tends_to_the_length() {
    for scheme in "exact grunwald:20 muir:3 tustin-muir:5 oustaloup:6:0.5:200 full:1e-6".split(' ')
    {
        for mu in [0.2, 0.7, 1.0, 1.4, 2.0] {
            let operator = operator(scheme, mu);
            for (low, high) in [(0.0, 0.01), (0.0, 3.0), (0.1, 0.2), (1.0, 1.01), (3.0, PI)] {
                let steps = 400;
                let edge = |i: i32| low + (high - low) * f64::from(i) / f64::from(steps);
                let at = |i: i32| operator.response(edge(i));
                let length: f64 = (0..steps).map(|i| (at(i + 1) - at(i)).norm()).sum();
                let bound = operator.variation(low, high);
                let what = format!("{scheme}, μ = {mu}, [{low}, {high}]: {length} {bound}");
                assert!(length <= bound * (1.0 + 1e-9), "{what}");
                let chord = (at(steps) - at(0)).norm();
                assert!(chord <= bound * (1.0 + 1e-12), "{what}");
                // Summed over short pieces it is hardly more than the length.
                let piece = |i: i32| operator.variation(edge(i), edge(i + 1));
                let sum: f64 = (0..steps).map(piece).sum();
                // A full memory has modes far slower than the first of 400 pieces.
                let fine = low > 0.0 || scheme == "exact";
                assert!(!fine || sum < 1.1 * length + 1e-6, "{what}, sum {sum}");
            }
        }
    }
}

#[test]
fn polynomials_are_those_of_the_operator() {
    let muir = operator("muir:3", 0.6);
    let (above, below) = muir.polynomials().expect("a polynomial");
    for (have, want) in above.iter().zip(muir3(0.6)) {
        assert_close("have", *have, want, 1e-15);
    }
    assert_eq!(below, [1.0]);
    let rational = operator("tustin-muir:4", 1.4);
    let (above, below) = rational.polynomials().expect("a rational function");
    for theta in [0.2, 1.0, 3.0] {
        let w = Complex::from_polar(1.0, -theta);
        let at = |c: &[f64]| {
            let powers = c.iter().rev();
            powers.fold(Complex::new(0.0, 0.0), |sum, c| sum * w + c)
        };
        assert!((at(above) / at(below) - rational.response(theta)).norm() < 1e-13);
    }
    assert_eq!(operator("exact", 0.5).polynomials(), None);
    assert_eq!(operator("full", 0.5).polynomials(), None);
}
