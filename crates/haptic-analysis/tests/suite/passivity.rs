//! Theorem 1 against brute force, closed forms and Corollary 1; the largest K and B against the theorem itself.

use fracdiff::{FrequencyResponse, MuirPolynomial, Scheme, Seconds, TustinMuir};
use haptic_analysis::{AnalysisError, Largest, OnePort, corollary_delta};
use num_complex::Complex;
use proptest::prelude::*;
use std::f64::consts::PI;
use testkit::operator::{exact, order, path, wall};
use testkit::{assert_close, assert_relative};

const T: Seconds = Seconds(1e-3);

fn muir(mu: f64) -> MuirPolynomial<f64, 3> {
    MuirPolynomial::new(order(mu), T).expect("valid")
}

fn operator(scheme: Scheme, mu: f64) -> fracdiff::Operator<f64> {
    scheme.build(order(mu), T, 1e5).expect("valid")
}

fn port<P: FrequencyResponse>(operator: &P, mu: f64, delay: usize) -> OnePort<'_, P> {
    let port = OnePort::new(operator, order(mu)).expect("valid order");
    port.through(path(delay as f64, 0.0)).expect("short delay")
}

/// Theorem 1 as printed, with complex arithmetic: (1/2)/(1 − cos θ)·Re{(1 − w)w^d(α + βP)}.
fn theorem(p: &impl FrequencyResponse, d: usize, alpha: f64, beta: f64, theta: f64) -> f64 {
    let w = Complex::from_polar(1.0, -theta);
    let h = p.response(theta) * beta + alpha;
    let port = (1.0 - w) * w.powu(u32::try_from(d).expect("short")) * h;
    0.5 * port.re / (1.0 - theta.cos())
}

/// The largest of it on `count` equal steps of (0, π].
fn brute_force(p: &impl FrequencyResponse, d: usize, alpha: f64, beta: f64, count: u32) -> f64 {
    let theta = |i: u32| PI * f64::from(i) / f64::from(count);
    let values = (count / 4000..=count).map(|i| theorem(p, d, alpha, beta, theta(i)));
    values.fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn corollary_1_is_theorem_1_for_the_exact_operator_without_delay() {
    for step in 0..=80 {
        let mu = f64::from(step) / 40.0;
        let p = exact(mu);
        for (alpha, beta) in [(0.0, 1.0), (1.0, 0.0), (0.3, 0.7), (1e-6, 2.0), (5.0, 1e-6)] {
            let have = port(&p, mu, 0).required_delta(alpha, beta).expect("valid");
            let want = 0.5 * alpha + beta * 0.5_f64.powf(1.0 - mu);
            let what = format!("μ {mu} α {alpha} β {beta}");
            assert_relative(&what, have.delta, want, 1e-12);
            assert_relative("corollary", have.corollary_delta, want, 1e-15);
            assert_eq!(have.worst_theta.to_bits(), PI.to_bits(), "μ {mu}");
        }
    }
}

#[test]
fn the_dissertations_muir_polynomial_needs_more_than_the_corollary_by_finding_3() {
    let printed = [
        (0.25, 1.14),
        (0.5, 1.24),
        (0.75, 1.30),
        (1.0, 1.33),
        (1.5, 1.33),
        (2.0, 1.25),
    ];
    for (mu, factor) in printed {
        let p = muir(mu);
        let required = port(&p, mu, 0).with_memory(4).required_delta(0.0, 1.0);
        let required = required.expect("valid");
        let excess = required.delta / required.corollary_delta;
        assert!((excess - factor).abs() <= 0.005, "μ {mu}: {excess}");
        let oracle = brute_force(&p, 0, 0.0, 1.0, 400_000);
        assert_relative(&format!("μ {mu}"), required.delta, oracle, 1e-9);
        // Certified with (5.1), run with A₃: not passive.
        assert!(!required.passive(required.corollary_delta * 1.001));
        // Above order 1 the β term alone is a negative spring at rest.
        let just_above = required.passive(required.delta * (1.0 + 1e-12));
        assert_eq!(just_above, mu <= 1.0, "μ {mu}");
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_search_agrees_with_brute_force_for_every_operator_and_delay() {
    // Brute force starts at θ = 8e-4 (its 1 − cos θ cancels below) and has steps of the same size, so it
    // may stay below a supremum by their square times the curvature, but never above it.
    let check = |have: f64, brute: f64, what: &str| {
        let missed = (have - brute) / brute.abs();
        assert!(
            (-1e-9..1e-5).contains(&missed),
            "{what}: {have:e}, brute {brute:e}"
        );
    };
    for mu in [0.2, 0.5, 0.9, 1.0, 1.3, 1.9] {
        let difference = exact(mu);
        let grunwald = operator(Scheme::Grunwald { length: 60 }, mu);
        let tustin = TustinMuir::<f64, 5>::new(order(mu), T).expect("valid");
        for d in [0, 1, 4] {
            let (p, r) = (port(&difference, mu, d), port(&tustin, mu, d));
            let q = port(&grunwald, mu, d).with_memory(60);
            for (alpha, beta) in [(0.0, 1.0), (1.0, 1.0), (1.0, 0.05)] {
                let what = |name: &str| format!("{name} μ {mu} d {d} α {alpha} β {beta}");
                // α(2d+1)/2, which the exact operator only approaches at rest for μ > 1.
                let rest = if mu > 1.0 {
                    alpha * (d as f64 + 0.5)
                } else {
                    f64::NEG_INFINITY
                };
                let have = p.required_delta(alpha, beta).expect("valid").delta;
                let brute = brute_force(&difference, d, alpha, beta, 40_000).max(rest);
                check(have, brute, &what("exact"));
                let have = q.required_delta(alpha, beta).expect("valid").delta;
                check(
                    have,
                    brute_force(&grunwald, d, alpha, beta, 40_000),
                    &what("grunwald"),
                );
                let have = r.required_delta(alpha, beta).expect("valid").delta;
                check(
                    have,
                    brute_force(&tustin, d, alpha, beta, 40_000),
                    &what("tustin"),
                );
            }
        }
    }
}

#[test]
fn the_limit_at_rest_is_the_analytic_one() {
    // A spring alone under d samples of delay: u(0) = (2d+1)/2, the largest of a Dirichlet kernel.
    for d in [1, 2, 9] {
        let p = exact(0.5);
        let have = port(&p, 0.5, d).required_delta(2.0, 0.0).expect("valid");
        assert_relative("spring", have.delta, 2.0 * d as f64 + 1.0, 1e-14);
        assert!(have.worst_theta <= 0.0, "{have:?}");
    }
    // Just above μ = 1 the term of β vanishes at rest, though only like θ^(μ−1); at μ = 1 it is −β.
    for mu in [1.0 + 1e-9, 1.0001, 1.5] {
        let p = exact(mu);
        let have = port(&p, mu, 3).required_delta(1.0, 0.1).expect("valid");
        assert_relative(&format!("μ {mu}"), have.delta, 3.5, 1e-14);
    }
    let p = exact(1.0);
    let have = port(&p, 1.0, 3).required_delta(1.0, 0.1).expect("valid");
    assert_relative("μ 1", have.delta, 3.4, 1e-12);
    // A polynomial: Σ p_k·D_{d+k}(0) = Σ p_k (2(d+k)+1)/2. A₃ at μ = 2: 1, −2, 4/3, −2/3.
    let p = muir(2.0);
    let want = 10.0 * 3.5 + 0.5 * (3.5 - 2.0 * 4.5 + 4.0 / 3.0 * 5.5 - 2.0 / 3.0 * 6.5);
    let have = port(&p, 2.0, 3).required_delta(10.0, 0.5).expect("valid");
    assert!(have.worst_theta <= 0.0, "{have:?}");
    assert_relative("A₃", have.delta, want, 1e-13);
}

/// δ that makes the wall passive; infinite if none does.
fn needed(required: haptic_analysis::RequiredDelta) -> f64 {
    if required.negative_at_rest {
        f64::INFINITY
    } else {
        required.delta
    }
}

#[test]
fn bad_input_is_refused_in_words() {
    let p = exact(1.0);
    let port = port(&p, 1.0, 0);
    let words = |error: AnalysisError| error.to_string();
    for (refused, want) in [
        (
            port.required_delta(-1.0, 0.0).map(drop),
            "alpha -1 is not at least 0",
        ),
        (
            port.required_damping(Seconds(0.0), 1.0, 0.0).map(drop),
            "sample time 0 s is not above 0 s",
        ),
        (
            port.largest_stiffness(T, -2.0, 0.0).map(drop),
            "damping -2 N·s/m is not at least 0 N·s/m",
        ),
    ] {
        assert_eq!(words(refused.expect_err(want)), want);
    }
    assert!(port.largest_beta(f64::NAN, 0.0).is_err());
    assert!(port.delta_at(1.0, 1.0, 0.0).is_err());
    assert!(port.delta_at(1.0, 1.0, 3.15).is_err());
    let integral = exact(-0.5);
    let error = OnePort::new(&integral, order(-0.5)).expect_err("an integral");
    assert!(words(error).contains("order -0.5 is not in [0, 2]"));
    // An integral that claims to be a derivative has no bound either.
    assert!(OnePort::new(&integral, order(0.5)).is_err());
    struct Silent;
    impl FrequencyResponse for Silent {
        fn response(&self, _: f64) -> Complex<f64> {
            Complex::new(f64::NAN, 0.0)
        }
    }
    assert!(OnePort::new(&Silent, order(0.5)).is_err());
    assert!(corollary_delta(order(1.0), f64::MAX, f64::MAX).is_err());
}

/// Fails unless a hair below both largest is passive, and a hair above is not.
fn are_on_the_boundary<P: FrequencyResponse>(port: &OnePort<'_, P>, delta: f64, other: f64) {
    let needs = |alpha, beta| needed(port.required_delta(alpha, beta).expect("valid"));
    let [alpha, beta] = [
        port.largest_alpha(delta, other),
        port.largest_beta(delta, other),
    ];
    let both: [(_, &dyn Fn(f64) -> f64); 2] = [
        (alpha, &|alpha| needs(alpha, other)),
        (beta, &|beta| needs(other, beta)),
    ];
    for (largest, needs) in both {
        let largest = largest.expect("valid");
        if let Largest::Below { value, .. } = largest {
            // Where nothing at all is allowed, the value is 0.
            let (below, above) = (value * (1.0 - 1e-9), value * (1.0 + 1e-9) + 1e-15);
            assert!(needs(below) < delta && needs(above) > delta, "{largest:?}");
        } else {
            assert_eq!(largest, Largest::Empty);
            assert!(needs(0.0) >= delta);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn no_frequency_asks_for_more_than_the_supremum(
        mu in 0.0..=2.0_f64, alpha in 0.0..3.0_f64, beta in 0.0..3.0_f64, d in 0..6_usize,
        theta in 1e-6..PI,
    ) {
        let (p, q) = (exact(mu), muir(mu));
        let most = port(&p, mu, d);
        let here = most.delta_at(alpha, beta, theta).expect("valid");
        let delta = most.required_delta(alpha, beta).expect("valid").delta;
        prop_assert!(here <= delta + 1e-12 * (1.0 + delta.abs()));
        let most = port(&q, mu, d).with_memory(4);
        let here = most.delta_at(alpha, beta, theta).expect("valid");
        let delta = most.required_delta(alpha, beta).expect("valid").delta;
        prop_assert!(here <= delta + 1e-12 * (1.0 + delta.abs()));
        let printed = theorem(&q, d, alpha, beta, theta.max(1e-3));
        let stable = most.delta_at(alpha, beta, theta.max(1e-3)).expect("valid");
        prop_assert!((printed - stable).abs() < 1e-7 * (1.0 + printed.abs()));
    }

    #[test]
    fn the_largest_are_on_the_boundary_for_any_loop(
        mu in 0.0..=2.0_f64, delta in 0.0..2.0_f64, other in 0.0..3.0_f64, d in 0..4_usize,
    ) {
        let (p, q) = (exact(mu), muir(mu));
        are_on_the_boundary(&port(&p, mu, d), delta, other);
        are_on_the_boundary(&port(&q, mu, d).with_memory(4), delta, other);
    }

    #[test]
    fn every_result_is_a_number_however_far_apart_the_parameters(
        mu in 0.0..=2.0_f64, d in 0..3_usize, powers in prop::array::uniform3(-150.0..150.0_f64),
    ) {
        let [alpha, beta, delta] = powers.map(|power| 10.0_f64.powf(power));
        let p = exact(mu);
        let port = port(&p, mu, d);
        let required = port.required_delta(alpha, beta).expect("valid");
        prop_assert!(required.delta.is_finite() && (0.0..=PI).contains(&required.worst_theta));
        for largest in [port.largest_alpha(delta, beta), port.largest_beta(delta, alpha)] {
            if let Largest::Below { value, worst_theta } = largest.expect("valid") {
                prop_assert!(value.is_finite() && (0.0..=PI).contains(&worst_theta));
            }
        }
    }
}

#[test]
fn a_negative_spring_at_rest_is_never_passive_whatever_the_damping() {
    // A₃ at μ = 1.5: P(1) = (1 − 1.5)(3 − 1.5)/3 = −1/4.
    let order = order(1.5);
    let operator =
        haptic_analysis::LoopOperator::new(Scheme::Muir { degree: 3 }, order, Seconds(1.0), 1e3);
    let operator = operator.expect("valid");
    let port = OnePort::new(&operator, order).expect("valid");
    assert_close("value", port.largest_ratio().expect("negative"), 4.0, 1e-9);
    for (alpha, beta, sound) in [(0.01, 0.08, false), (0.03, 0.08, true), (0.0, 0.1, false)] {
        let required = port.required_delta(alpha, beta).expect("finite");
        assert_eq!(required.passive(1e6), sound, "α {alpha} β {beta}");
        // A passive wall on a damped device is stable; the negative spring is not.
        let wall = wall(alpha, beta, required.delta.max(0.0) + 0.1, 0.0);
        let sampled = haptic_analysis::SampledLoop::new(wall, &operator, 0).expect("valid");
        assert_eq!(sampled.is_stable(), sound, "α {alpha} β {beta}");
    }
    let none = Largest::Below {
        value: 0.04,
        worst_theta: 0.0,
    };
    assert_eq!(port.largest_beta(1e3, 0.01).expect("finite"), none);
    let empty = port.largest_alpha(0.01, 0.2).expect("finite");
    assert_eq!(empty, Largest::Empty);
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
        Largest::Any | Largest::Empty => panic!("{largest:?}"),
    };
    let have = below(port.largest_stiffness(T, b, dissipation).expect("valid"));
    assert_relative("K", have, (b - dissipation * half.sqrt()) / half, 1e-12);
    let have = below(port.largest_dissipation(T, b, stiffness).expect("valid"));
    assert_relative("B", have, (b - stiffness * half) / half.sqrt(), 1e-12);
    let none = port.largest_dissipation(T, b, 7001.0).expect("valid");
    assert_eq!(none, Largest::Empty);
    let none = port.largest_stiffness(T, 0.0, 0.0).expect("valid");
    assert_eq!(none, Largest::Empty);
}
