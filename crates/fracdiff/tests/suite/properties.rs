//! What the discretisation promises, over random orders and in both precisions.

use crate::oracle::{SAMPLE_TIME, SCHEMES, build, grunwald_sum, largest, order, run};
use fracdiff::full_memory::{Design, Kernel};
use fracdiff::{
    FrequencyResponse, FullMemory, Real, Scheme, Seconds, ShortMemory, grunwald_weights,
};
use num_complex::Complex;
use proptest::prelude::*;

/// Rounding to the precision of the samples: half a unit in the last place of 1.
fn half_unit<F: Real>() -> f64 {
    match size_of::<F>() {
        4 => 2f64.powi(-24),
        _ => 2f64.powi(-53),
    }
}

/// Observed order of convergence of D^μ tᵖ at t = 1 s, from 32 steps to 64.
fn order_of_convergence<F: Real>(scheme: &str, mu: f64, power: i32) -> f64 {
    let error = |steps: u32| {
        let t = 1.0 / f64::from(steps);
        let scheme: Scheme = scheme.parse().expect("a scheme");
        let operator = scheme.build::<F>(order(mu), Seconds(t), 1e3);
        let x: Vec<f64> = (0..=steps)
            .map(|n| (f64::from(n) * t).powi(power))
            .collect();
        let y = run(&operator.expect("builds"), &x)[steps as usize];
        // D^μ tᵖ = Γ(p + 1)/Γ(p + 1 − μ)·t^(p−μ)
        let power = f64::from(power);
        y - libm::tgamma(power + 1.0) / libm::tgamma(power + 1.0 - mu)
    };
    (error(32) / error(64)).log2()
}

fn converges<F: Real>(mu: f64) -> Result<(), TestCaseError> {
    // The next term of each error is still seen at 32 steps; that of L1, O(T²), is close for small μ.
    for (scheme, power, want, within) in [
        ("full:1e-9", 2, 1.0, 0.05),
        ("piecewise-linear:1e-9", 2, 2.0 - mu, 0.2),
        ("full-bdf2:1e-9", 3, 2.0, 0.1),
    ] {
        let have = order_of_convergence::<F>(scheme, mu, power);
        prop_assert!(
            (have - want).abs() < within,
            "{}: {} for {}",
            scheme,
            have,
            want
        );
    }
    Ok(())
}

fn shifts<F: Real>(scheme: &str, mu: f64, by: usize, x: &[f64]) -> Result<(), TestCaseError> {
    let operator = build::<F>(scheme, mu);
    let mut late = vec![0.0; by];
    late.extend_from_slice(x);
    let (late, soon) = (run(&operator, &late), run(&operator, x));
    prop_assert!(late[..by].iter().all(|y| *y == 0.0), "before it begins");
    prop_assert_eq!(&late[by..], &soon[..]);
    Ok(())
}

fn responds<F: Real>(scheme: &str, mu: f64, theta: f64) -> Result<(), TestCaseError> {
    let operator = build::<F>(scheme, mu);
    let mut impulse = vec![0.0; 20_000];
    impulse[0] = 1.0;
    let rate = SAMPLE_TIME.0.powf(mu);
    let weights: Vec<f64> = run(&operator, &impulse).iter().map(|y| rate * y).collect();
    let terms = weights.iter().enumerate();
    let have: Complex<f64> = terms
        .map(|(j, h)| Complex::from_polar(*h, -theta * j as f64))
        .sum();
    let want = operator.response(theta);
    // What is cut off, and the rounding of what is summed: each weight is the sum of up to a hundred modes and taps. A slow tail is
    // |h|/|1 − e^(−iθ)| in all, and |h|/|1 + e^(−iθ)| where it alternates, as it does with a pole near −1.
    let last = weights[weights.len() - 1].abs();
    let cut = last * (2.0 / theta + 1.0 / (2.0 * (0.5 * theta).cos()));
    let size: f64 = weights.iter().map(|h| h.abs()).sum();
    let within = 1e-9 + cut + 100.0 * half_unit::<F>() * size;
    prop_assert!(
        (have - want).norm() <= within,
        "{} {}: {} for {}",
        scheme,
        size,
        have,
        want
    );
    Ok(())
}

fn remembers<F: Real>(mu: f64, x: &[f64]) -> Result<(), TestCaseError> {
    // As the samples are rounded, so that the sum is of the same motion.
    let x: Vec<f64> = x.iter().map(|x| F::from_f64(*x).to_f64()).collect();
    let want = grunwald_sum(mu, SAMPLE_TIME, x.len(), &x);
    // T^(−μ)·Σ c_j·|Δx[n−j]|, with the weights c_j of the integral of order 1 − μ.
    let steps = x.iter().enumerate();
    let steps: Vec<f64> = steps
        .map(|(n, x_n)| (x_n - if n > 0 { x[n - 1] } else { 0.0 }).abs())
        .collect();
    let sizes = grunwald_sum(mu - 1.0, Seconds(1.0), steps.len(), &steps);
    let rate = SAMPLE_TIME.0.powf(-mu);
    let design = Design::<16, 64>::pruned(Kernel::Grunwald, order(mu), 1e-3, 1e4);
    let design = design.expect("reachable");
    let operator = FullMemory::<F, 16, 64>::new(&design, SAMPLE_TIME).expect("valid");
    let have = run(&operator, &x);
    // A memory of 64 samples is wrong by at most its bound times the largest position, as it starts from rest.
    let short = ShortMemory::<F, 64>::new(order(mu), SAMPLE_TIME).expect("valid");
    let kept: f64 = grunwald_weights(order(mu)).take(64).sum();
    let cut = kept * rate * largest(&x);
    let forgetful = run(&short, &x);
    let rounding = 100.0 * half_unit::<F>();
    for n in 0..x.len() {
        let bound = (design.error_bound() + rounding) * rate * sizes[n];
        prop_assert!(
            (have[n] - want[n]).abs() <= bound,
            "sample {}: {} for {}",
            n,
            have[n],
            want[n]
        );
        let lost = (forgetful[n] - want[n]).abs();
        prop_assert!(
            lost <= cut + rounding * rate * 2.0,
            "sample {}: {} beyond {}",
            n,
            lost,
            cut
        );
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn each_kernel_converges_with_its_order(mu in 0.2..0.95_f64) {
        converges::<f64>(mu)?;
        converges::<f32>(mu)?;
    }

    #[test]
    fn an_operator_is_shift_invariant(
        scheme in proptest::sample::select(&SCHEMES[..]),
        mu in -2.0..2.0_f64,
        by in 1..400_usize,
        x in proptest::collection::vec(-1.0..1.0_f64, 1..400),
    ) {
        shifts::<f64>(scheme, mu, by, &x)?;
        shifts::<f32>(scheme, mu, by, &x)?;
    }

    #[test]
    fn the_response_is_that_of_what_runs(
        scheme in proptest::sample::select(&SCHEMES[..]),
        mu in 0.05..1.95_f64,
        theta in 0.1..3.1_f64,
    ) {
        responds::<f64>(scheme, mu, theta)?;
        responds::<f32>(scheme, mu, theta)?;
    }

    #[test]
    fn a_memory_keeps_the_bound_that_it_states(
        mu in 0.05..0.95_f64,
        x in proptest::collection::vec(-1.0..1.0_f64, 1..600),
    ) {
        remembers::<f64>(mu, &x)?;
        remembers::<f32>(mu, &x)?;
    }
}
