//! Operators of one's own, judged as those that have names.

use fracdiff::full_memory::{Design, Kernel};
use fracdiff::{
    ExactDifference, FrequencyResponse, FullMemory, MuirPolynomial, Seconds, ShortMemory,
    TustinMuir,
};
use haptic_analysis::num_complex::Complex;
use haptic_analysis::{
    AnalysisError, LoopOperator, Nondimensional, OnePort, SampledLoop, SampledPlant,
    StabilityRegion,
};
use proptest::prelude::*;
use testkit::assert_close;
use testkit::operator::{operator, order};

const T: Seconds = Seconds(1e-3);

fn assert_same_response(a: &LoopOperator, b: &LoopOperator, tolerance: f64) {
    for k in 0..=200_u32 {
        let theta = std::f64::consts::PI * f64::from(k) / 200.0;
        let (a, b) = (a.response(theta), b.response(theta));
        assert!((a - b).norm() <= tolerance, "{theta}: {a} {b}");
    }
}

#[test]
fn a_finite_memory_is_found_again_from_its_response() {
    for mu in [0.3, 1.0, 1.7] {
        let short = ShortMemory::<f64, 20>::new(order(mu), T).expect("in range");
        let found = LoopOperator::from_response(order(mu), &short).expect("fades");
        let (have, below) = found.polynomials().expect("a polynomial");
        let named = operator("grunwald:20", mu);
        let (want, _) = named.polynomials().expect("a polynomial");
        assert_eq!(below, [1.0]);
        // At a whole order the weights are zero beyond.
        assert!(have.len() <= want.len(), "{mu}");
        for (j, want) in want.iter().enumerate() {
            let have = have.get(j).copied().unwrap_or(0.0);
            assert_close(&format!("μ = {mu}, lag {j}"), have, *want, 1e-14);
        }
        let muir = MuirPolynomial::<f64, 3>::new(order(mu), T).expect("in range");
        let found = LoopOperator::from_response(order(mu), &muir).expect("fades");
        assert_same_response(&found, &operator("muir:3", mu), 1e-14);
    }
}

#[test]
fn a_recursion_that_fades_is_judged_as_its_polynomials_are() {
    // (1 − w)/(1 − 0.6w), a velocity behind a low-pass.
    let filtered = LoopOperator::from_polynomials(order(1.0), &[1.0, -1.0], &[1.0, -0.6]);
    let filtered = filtered.expect("stable");
    let found = LoopOperator::from_response(order(1.0), &filtered).expect("fades");
    assert_same_response(&filtered, &found, 1e-11);
    let plant = SampledPlant::new(0.05, 0.0).expect("in range");
    let area = |operator: &LoopOperator| {
        let region = StabilityRegion::new(plant, operator, 0, 400).expect("a region");
        region.bounded().expect("not empty").clone()
    };
    let (a, b) = (area(&filtered), area(&found));
    assert_close("area", a.area, b.area, 1e-8);
    assert_close("α", a.alpha_max, b.alpha_max, 1e-8);
    assert_close("β", a.beta_max, b.beta_max, 1e-8);
}

#[test]
fn taps_and_modes_of_ones_own_are_their_sum() {
    // Two modes and a tap, tempered: by hand as a rational function.
    let modes = [(0.7, 0.4), (0.05, 0.2)];
    let mine = LoopOperator::from_modes(order(0.5), &[0.6, 0.1], &modes).expect("in range");
    let [r, s] = modes.map(|(rate, _)| f64::exp(-rate));
    // (1 − w)·[(0.6 + 0.1w)(1 − rw)(1 − sw) + 0.4(1 − sw) + 0.2(1 − rw)]/((1 − rw)(1 − sw))
    let below = [1.0, -(r + s), r * s];
    let tapped = [0.6, 0.1 - 0.6 * (r + s), 0.6 * r * s - 0.1 * (r + s)];
    let core = [
        tapped[0] + 0.4 + 0.2,
        tapped[1] - 0.4 * s - 0.2 * r,
        tapped[2],
        0.1 * r * s,
    ];
    let above: Vec<f64> = (0..5)
        .map(|k| core.get(k).unwrap_or(&0.0) - if k > 0 { core[k - 1] } else { 0.0 })
        .collect();
    let multiplied = LoopOperator::from_polynomials(order(0.5), &above, &below).expect("stable");
    assert_same_response(&mine, &multiplied, 1e-13);
    assert!((mine.direct_gain() - 1.2).abs() < 1e-15);
    // Passivity needs no more than the response.
    let delta = |operator| {
        let port = OnePort::new(operator, order(0.5)).expect("finite");
        port.required_delta(0.1, 0.3).expect("finite").delta
    };
    assert!((delta(&mine) - delta(&multiplied)).abs() < 1e-12);
}

#[test]
fn a_tustin_muir_filter_is_the_same_by_name_and_by_response() {
    let running = TustinMuir::<f64, 5>::new(order(0.5), T).expect("in range");
    let found = LoopOperator::from_response(order(0.5), &running).expect("fades");
    assert_same_response(&found, &operator("tustin-muir:5", 0.5), 1e-10);
}

struct Constant(Complex<f64>);

impl FrequencyResponse for Constant {
    fn response(&self, _: f64) -> Complex<f64> {
        self.0
    }
}

#[test]
fn what_cannot_be_judged_is_refused_and_says_why() {
    let text =
        |result: Result<LoopOperator, AnalysisError>| result.expect_err("refused").to_string();
    let half = order(0.5);
    let long = text(LoopOperator::from_response(half, &ExactDifference(half)));
    assert!(long.contains("not faded after 2048 samples"), "{long}");
    let integral = ExactDifference(order(-0.5));
    assert!(text(LoopOperator::from_response(half, &integral)).contains("is not finite"));
    let constant = Constant(Complex::new(-1.0, 0.0));
    let zero = text(LoopOperator::from_response(half, &constant));
    assert!(
        zero.contains("direct gain of the operator -1 is not above 0"),
        "{zero}"
    );
    for mu in [0.0, -1.0] {
        let refused = text(LoopOperator::from_polynomials(order(mu), &[1.0], &[1.0]));
        assert!(refused.contains("a constant is a spring"), "{refused}");
    }
    for below in [[1.0, -1.0], [1.0, -1.5], [0.0, 1.0]] {
        let refused = text(LoopOperator::from_polynomials(half, &[1.0, -1.0], &below));
        assert!(refused.contains("no stable filter"), "{refused}");
    }
    assert!(text(LoopOperator::from_polynomials(half, &[], &[1.0])).contains("at least 1"));
    assert!(text(LoopOperator::from_polynomials(half, &[f64::NAN], &[1.0])).contains("finite"));
    let mode = |rate, weight| LoopOperator::from_modes(half, &[1.0], &[(rate, weight)]);
    assert!(text(mode(0.0, 1.0)).contains("rate of a mode 0 per sample is not above 0"));
    assert!(text(mode(1.0, f64::INFINITY)).contains("weight of a mode inf is not finite"));
    assert!(text(mode(1.0, -2.0)).contains("direct gain"));
}

proptest! {
    /// A verdict does not depend on the way in which an operator is given.
    #[test]
    fn verdicts_agree_whichever_way_an_operator_is_given(
        mu in 0.05..2.0_f64,
        alpha in 0.0..2.0_f64,
        beta in 0.0..2.0_f64,
        delta in 0.0..0.5_f64,
        delay in 0_usize..3,
    ) {
        let named = operator("grunwald:12", mu);
        let short = ShortMemory::<f64, 12>::new(order(mu), T).expect("in range");
        let found = LoopOperator::from_response(order(mu), &short).expect("fades");
        let (above, below) = named.polynomials().expect("a polynomial");
        let given = LoopOperator::from_polynomials(order(mu), above, below).expect("stable");
        let wall = Nondimensional { alpha, beta, delta, gamma: 0.0 };
        let verdict = |operator| SampledLoop::new(wall, operator, delay).expect("in range").verdict();
        let (a, b, c) = (verdict(&named), verdict(&found), verdict(&given));
        prop_assert_eq!(a.unstable_poles, c.unstable_poles);
        if a.distance > 1e-6 {
            prop_assert_eq!(a.unstable_poles, b.unstable_poles);
        }
    }
}

#[test]
fn a_design_of_ones_own_is_judged_as_the_operator_that_runs_it() {
    for mu in [0.2247, 0.9, 1.5] {
        let design = Design::<16, 48>::pruned(Kernel::Grunwald, order(mu), 1e-6, 1e5);
        let design = design.expect("modes");
        let judged = LoopOperator::from_design(&design).expect("in range");
        let runs = FullMemory::<f64, 16, 48>::new(&design, T).expect("in range");
        for k in 0..=200_u32 {
            let theta = std::f64::consts::PI * f64::from(k) / 200.0;
            let (have, want) = (judged.response(theta), runs.response(theta));
            assert!((have - want).norm() <= 1e-13, "{theta}: {have} {want}");
        }
        assert_same_response(&judged, &operator("full:1e-6", mu), 1e-5);
    }
    let integral = Design::<16, 48>::closed_form(Kernel::Grunwald, order(-0.5), 1e-6, 1e5);
    let error = LoopOperator::from_design(&integral.expect("modes")).expect_err("a pole at rest");
    let range = |error: &AnalysisError| matches!(error, AnalysisError::Range(range) if range.what == "order");
    assert!(range(&error), "{error}");
}
