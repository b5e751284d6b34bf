//! The largest K and B against the theorem itself.

use super::needed;
use super::{T, muir, port};
use haptic_analysis::Largest;
use testkit::assert_relative;
use testkit::operator::exact;

/// Fails unless a hair below `largest` is passive and it and a hair above are not.
fn on_the_boundary(largest: Largest, required: impl Fn(f64) -> f64, delta: f64, what: &str) {
    match largest {
        Largest::Below { value, .. } => {
            // Where no β at all is allowed, the value is 0.
            let (below, above) = (value * (1.0 - 1e-9), value * (1.0 + 1e-9) + 1e-15);
            assert!(
                required(below) < delta,
                "{what}: {value} not passive just below"
            );
            assert!(
                required(above) > delta,
                "{what}: {value} passive just above"
            );
        }
        Largest::Empty => {
            let any = (0..200).map(|i| 1e-9 * 1.2_f64.powi(i)).chain([0.0]);
            for x in any {
                assert!(required(x) >= delta, "{what}: {x} is passive");
            }
        }
        Largest::Any => panic!("{what}: no bound"),
    }
}

#[test]
fn the_largest_stiffness_and_dissipation_are_on_the_boundary() {
    for mu in [0.0, 0.3, 0.5, 1.0, 1.4, 2.0] {
        for d in [0, 1, 3] {
            let (p, q) = (exact(mu), muir(mu));
            let (exact, muir) = (port(&p, mu, d), port(&q, mu, d).with_memory(4));
            for (delta, other) in [(0.1, 0.0), (0.1, 0.01), (0.1, 0.05), (0.1, 0.2), (3.0, 1.0)] {
                let what = format!("μ {mu} d {d} δ {delta} other {other}");
                let required =
                    |alpha, beta| exact.required_delta(alpha, beta).expect("valid").delta;
                let largest = exact.largest_alpha(delta, other).expect("valid");
                on_the_boundary(largest, |alpha| required(alpha, other), delta, &what);
                let largest = exact.largest_beta(delta, other).expect("valid");
                on_the_boundary(largest, |beta| required(other, beta), delta, &what);
                let required =
                    |alpha, beta| needed(muir.required_delta(alpha, beta).expect("valid"));
                let largest = muir.largest_alpha(delta, other).expect("valid");
                on_the_boundary(largest, |alpha| required(alpha, other), delta, &what);
                let largest = muir.largest_beta(delta, other).expect("valid");
                on_the_boundary(largest, |beta| required(other, beta), delta, &what);
            }
        }
    }
}

#[test]
fn with_units_the_largest_are_those_of_the_corollary() {
    // K = (b − B(T/2)^(1−μ))·2/T and B = (b − KT/2)·(T/2)^(μ−1)
    let (b, stiffness, dissipation, mu) = (3.5, 1000.0, 5.0, 0.5);
    let p = exact(mu);
    let port = port(&p, mu, 0);
    let half = 0.5 * T.0;
    let below = |largest: Largest| match largest {
        Largest::Below { value, .. } => value,
        other => panic!("{other:?}"),
    };
    let have = below(port.largest_stiffness(T, b, dissipation).expect("valid"));
    assert_relative("K", have, (b - dissipation * half.sqrt()) / half, 1e-12);
    let have = below(port.largest_dissipation(T, b, stiffness).expect("valid"));
    assert_relative("B", have, (b - stiffness * half) / half.sqrt(), 1e-12);
    let none = port.largest_dissipation(T, b, 7001.0).expect("valid");
    assert_eq!(none, Largest::Empty);
    assert_eq!(
        port.largest_stiffness(T, 0.0, 0.0).expect("valid"),
        Largest::Empty
    );
}
