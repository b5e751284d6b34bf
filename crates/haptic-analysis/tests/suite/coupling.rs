//! The coupled port against 50 digits (`tests/golden/make_coupling_golden.py`), brute force and Corollary 2.

use fracdiff::{FrequencyResponse, MuirPolynomial, Scheme, Seconds};
use haptic_analysis::{Coupler, LeastDamping};
use num_complex::Complex;
use proptest::prelude::*;
use std::f64::consts::PI;
use testkit::operator::order;
use testkit::{assert_close, assert_relative, golden};

const T: f64 = 1e-3;

fn coupler(mu: f64, stiffness: f64, dissipation: f64) -> Coupler<'static> {
    Coupler::exact(order(mu), T, stiffness, dissipation).expect("valid")
}

fn enough(coupler: &Coupler<'_>) -> f64 {
    match coupler.least_damping().expect("valid") {
        LeastDamping::Enough {
            damping_n_s_per_m, ..
        } => damping_n_s_per_m,
        none => panic!("{coupler:?}: {none:?}"),
    }
}

#[test]
fn least_damping_agrees_with_50_digits() {
    for cells in golden::cells("coupling.csv") {
        let number = |i: usize| cells[i].parse::<f64>().expect("a number");
        let [mu, k, b, t, want, theta] = [1, 2, 3, 4, 5, 6].map(number);
        let coupler = Coupler::exact(order(mu), t, k, b).expect("valid");
        let scheme = (cells[0] != "exact").then(|| cells[0].parse::<Scheme>().expect("a scheme"));
        let made = scheme.map(|scheme| scheme.build::<f64>(order(mu), Seconds(t), 1e3));
        let made = made.map(|operator| operator.expect("valid"));
        let coupler = match &made {
            Some(operator) => coupler.with_operator(operator, 20),
            None => coupler,
        };
        let have = coupler.least_damping().expect("valid");
        let LeastDamping::Enough {
            damping_n_s_per_m,
            worst_theta,
        } = have
        else {
            panic!("{cells:?}: {have:?}");
        };
        let tolerance = if made.is_none() { 1e-12 } else { 1e-9 };
        assert_relative(&cells.join(","), damping_n_s_per_m, want, tolerance);
        assert_close(&cells.join(","), worst_theta, theta, 1e-4);
    }
}

/// `1/Z_c` of the exact operator.
fn admittance(mu: f64, k: f64, b: f64, t: f64, theta: f64) -> Complex<f64> {
    let v = 1.0 - Complex::from_polar(1.0, -theta);
    1.0 / ((t / v).powf(mu) * b + k)
}

#[test]
fn corollary_2_is_not_sufficient_by_finding_4() {
    // At μ = 1 without a damper: b_c·T/8 in the limit θ → 0, where the corollary says b_c·T/16.
    for (mu, factor, tolerance) in [(1.0, 2.0, 1e-12), (0.75, 1.30, 0.005), (0.5, 1.13, 0.005)] {
        let spring = coupler(mu, 0.0, 1000.0);
        let corollary = spring.corollary_damping();
        assert_relative("factor", enough(&spring) / corollary, factor, tolerance);
        assert!(!spring.passive(1.0001 * corollary).expect("valid"));
    }
    // Equal only without b_c, for any order.
    for mu in [0.0, 0.5, 1.0, 1.5, 2.0] {
        let damper = coupler(mu, 8.0, 0.0);
        assert_relative("k_c/8", enough(&damper), 1.0, 1e-14);
        assert_relative("k_c/8", damper.corollary_damping(), 1.0, 1e-14);
    }
    // The largest factor of all is 2: at μ = 1, k_c = 0.
    let mut largest: f64 = 0.0;
    for mu in (1..=100).map(|i| f64::from(i) / 100.0) {
        for k in [0.0, 1e-3, 0.01, 0.1, 1.0, 10.0] {
            let coupler = coupler(mu, k * T.powf(mu), 1.0);
            let factor = enough(&coupler) / coupler.corollary_damping();
            assert!(factor > 1.0, "μ {mu} k {k}: {factor}");
            largest = largest.max(factor);
        }
    }
    assert_relative("largest factor", largest, 2.0, 1e-12);
}

#[test]
fn above_order_1_no_damping_is_enough_and_the_result_says_where() {
    for mu in [1.0 + 1e-12, 1.0001, 1.3, 2.0] {
        for k in [0.0, 1.0, 1e6] {
            let coupler = coupler(mu, k, 100.0);
            let LeastDamping::NoneIsEnough { theta } = coupler.least_damping().expect("valid")
            else {
                panic!("μ {mu} k {k}: a bound");
            };
            assert!(theta > 0.0 && theta < PI, "{theta}");
            // Near rest a damping of order μ just above 1 is below rounding.
            let y = admittance(mu, k, 100.0, T, theta);
            assert!(y.re < 1e-12 * y.norm(), "μ {mu} k {k} θ {theta}: {y}");
            assert!(!coupler.passive(1e9).expect("valid"));
        }
        // What Corollary 2 promises here is a finite damping.
        assert!(coupler(mu, 1.0, 100.0).corollary_damping().is_finite());
    }
}

#[test]
fn a_muir_polynomial_above_order_1_is_a_negative_spring_that_a_stiff_coupler_hides() {
    // P(1) = (1−μ)(3−μ)/3 < 0, so Z_c(1) = k_c + b_c·T^μ/P(1): negative unless k_c outweighs it.
    let mu = 1.5;
    let operator = MuirPolynomial::<f64, 3>::new(order(mu), Seconds(T)).expect("valid");
    let rest = (1.0 - mu) * (3.0 - mu) / 3.0;
    let threshold = T.powf(mu) / -rest;
    let soft = coupler(mu, 0.9 * threshold, 1.0).with_operator(&operator, 4);
    let none = soft.least_damping().expect("valid");
    assert!(
        matches!(none, LeastDamping::NoneIsEnough { .. }),
        "{none:?}"
    );
    // 1/Z_c may still meet the left half plane: the verdict is that of the response itself.
    for factor in [1.1, 3.0, 30.0] {
        let stiff = coupler(mu, factor * threshold, 1.0).with_operator(&operator, 4);
        let admittance = |i: i32| {
            let p = operator.response(PI * f64::from(i) / 20_000.0);
            (p / (p * (factor * threshold) + T.powf(mu))).re
        };
        let lowest = (1..=20_000).map(admittance).fold(f64::INFINITY, f64::min);
        match stiff.least_damping().expect("valid") {
            LeastDamping::Enough { .. } => assert!(lowest > 0.0, "{factor}: {lowest}"),
            LeastDamping::NoneIsEnough { .. } => assert!(lowest <= 0.0, "{factor}: {lowest}"),
        }
    }
}

#[test]
fn bad_input_is_refused_in_words() {
    let make = |mu: f64, t: f64, k: f64, b: f64| Coupler::exact(order(mu), t, k, b);
    let words = |coupler: Result<Coupler<'_>, _>| match coupler {
        Ok(coupler) => panic!("{coupler:?}"),
        Err(error) => haptic_analysis::AnalysisError::to_string(&error),
    };
    for (refused, want) in [
        (make(-0.5, T, 1.0, 1.0), "order -0.5 is not in [0, 2]"),
        (make(1.0, 0.0, 1.0, 1.0), "sample time 0 s is not above 0 s"),
        (make(1.0, T, -1.0, 1.0), "coupler damping -1 N·s/m"),
        (make(1.0, T, 1.0, f64::NAN), "coupler spring NaN"),
        (make(1.0, T, 0.0, 0.0), "impedance of the coupler 0 N·s/m"),
    ] {
        let words = words(refused);
        assert!(words.starts_with(want), "{words}");
    }
    assert!(make(1.0, T, 0.9 * f64::MAX, 1.0).is_ok());
    // Their sum overflows.
    assert!(make(0.0, T, f64::MAX, f64::MAX).is_err());
    let coupler = coupler(1.0, 1.0, 1.0);
    assert!(coupler.passive(-1.0).is_err());
    struct Silent;
    impl FrequencyResponse for Silent {
        fn response(&self, _: f64) -> Complex<f64> {
            Complex::new(f64::NAN, 0.0)
        }
    }
    assert!(coupler.with_operator(&Silent, 1).least_damping().is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn the_least_damping_meets_llewellyn_everywhere_and_a_hair_less_does_not(
        mu in 0.0..=1.0_f64, k in 0.0..3.0_f64, b in 0.1..10.0_f64,
        thetas in prop::collection::vec(1e-5..PI, 50),
    ) {
        let coupler = Coupler::exact(order(mu), 1.0, k, b).expect("valid");
        let LeastDamping::Enough { damping_n_s_per_m: least, worst_theta } =
            coupler.least_damping().expect("valid") else { panic!("a bound") };
        prop_assert!(coupler.passive(least).expect("valid"));
        prop_assert!(!coupler.passive(least * (1.0 - 1e-12)).expect("valid"));
        // 2b·Re(1/Z_c) ≥ cos(θ/2)(1 − cos(θ/2)), as a share of the left side.
        let missing = |b_d: f64, theta: f64| {
            let quarter = (0.25 * theta).sin();
            let hold = 2.0 * quarter * quarter * (0.5 * theta).cos();
            hold / (2.0 * b_d * admittance(mu, k, b, 1.0, theta).re) - 1.0
        };
        for theta in thetas {
            prop_assert!(missing(least, theta) <= 1e-8, "θ {theta}");
        }
        prop_assert!(missing(least * (1.0 - 1e-6), worst_theta.max(1e-5)) > 0.0, "θ {worst_theta}");
    }

    #[test]
    fn every_result_is_a_number(
        mu in 0.0..=2.0_f64, k in 0.0..1e9_f64, b in 0.0..1e9_f64, t in 1e-6..1.0_f64,
    ) {
        prop_assume!(k + b > 0.0);
        let coupler = Coupler::exact(order(mu), t, k, b).expect("valid");
        let theta = match coupler.least_damping().expect("valid") {
            LeastDamping::Enough { damping_n_s_per_m, worst_theta } => {
                prop_assert!(damping_n_s_per_m.is_finite());
                worst_theta
            }
            LeastDamping::NoneIsEnough { theta } => theta,
        };
        prop_assert!((0.0..=PI).contains(&theta));
    }
}
