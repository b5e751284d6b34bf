//! Weights against 50-digit values (`tests/golden/make_golden.py` of the repository) and their own definitions.

use crate::oracle::order;
use fracdiff::full_memory::{Design, Kernel};
use fracdiff::{grunwald_weight, grunwald_weights, muir_coefficients, piecewise_linear_weight};

const GOLDEN: &str = include_str!("../golden/weights.csv");

/// (kernel, μ, j, weight)
fn golden() -> impl Iterator<Item = (&'static str, f64, u64, f64)> {
    GOLDEN.lines().skip(1).map(|line| {
        let mut cells = line.split(',');
        let mut next = || cells.next().expect("four columns");
        let (kernel, mu, lag, weight) = (next(), next(), next(), next());
        let number = |cell: &str| cell.parse().expect("a number");
        (
            kernel,
            number(mu),
            lag.parse().expect("a lag"),
            number(weight),
        )
    })
}

/// A weight is what it is to be, but for this share of it.
fn assert_weight(mu: f64, lag: u64, [have, want]: [f64; 2], tolerance: f64) {
    let error = (have / want - 1.0).abs();
    assert!(
        error < tolerance,
        "μ {mu} lag {lag}: have {have:e} want {want:e}"
    );
}

#[test]
fn closed_form_grunwald_weights_agree_with_50_digits_for_24_hours_of_lags() {
    for (_, mu, lag, want) in golden().filter(|row| row.0 == "grunwald") {
        assert_weight(mu, lag, [grunwald_weight(order(mu), lag), want], 1e-13);
    }
}

#[test]
fn recurrence_agrees_with_50_digits_up_to_200_000_lags() {
    for (_, mu, lag, want) in golden().filter(|row| row.0 == "grunwald" && row.2 <= 200_000) {
        let have = grunwald_weights(order(mu))
            .nth(lag as usize)
            .expect("endless");
        assert_weight(mu, lag, [have, want], 1e-12);
    }
}

#[test]
fn exact_taps_of_a_piecewise_linear_design_agree_with_50_digits() {
    // Lags below TAPS are exact in a design; the core meets increments for μ > 0, and is summed up for μ in (−2, −1).
    for (_, mu, lag, want) in golden().filter(|row| row.0 == "piecewise-linear" && row.2 <= 1000) {
        let design = Design::<1024, 64>::closed_form(Kernel::PiecewiseLinear, order(mu), 1e-3, 1e5)
            .expect("reachable");
        let core = |j| design.core_weight(j);
        let have: f64 = if mu > 0.0 {
            core(lag) - lag.checked_sub(1).map_or(0.0, core)
        } else if mu > -1.0 {
            core(lag)
        } else {
            (0..=lag).map(core).sum()
        };
        // First differences of the core lose as many digits as the lag has.
        assert_weight(mu, lag, [have, want], 1e-11);
    }
}

#[test]
fn next_to_whole_orders_no_digit_is_lost() {
    // Γ(j − μ)/(Γ(−μ)·Γ(j + 1)) with the factors multiplied out in integer steps of 2^(−k), where μ = n ± 2^(−k): each
    // difference j − 1 − μ is exact.
    for whole in [0.0, 1.0, 2.0, -1.0] {
        for exponent in [10, 20, 30, 45] {
            for sign in [1.0, -1.0] {
                let mu: f64 = whole + sign * 2f64.powi(-exponent);
                if mu > 2.0 {
                    continue;
                }
                let mut want = 1.0;
                for (j, have) in grunwald_weights(order(mu)).enumerate().take(200) {
                    if j > 0 {
                        want *= (j as f64 - 1.0 - mu) / j as f64;
                    }
                    let closed = grunwald_weight(order(mu), j as u64);
                    for (have, allowed) in [(have, 1e-14), (closed, 1e-13)] {
                        let error = (have / want - 1.0).abs();
                        assert!(error < allowed, "μ {mu} lag {j}: {have:e} {want:e}");
                    }
                }
            }
        }
    }
}

#[test]
fn whole_orders_have_exact_weights() {
    let first = |mu: f64| grunwald_weights(order(mu)).take(6).collect::<Vec<_>>();
    assert_eq!(first(0.0), [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(first(1.0), [1.0, -1.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(first(2.0), [1.0, -2.0, 1.0, 0.0, 0.0, 0.0]);
    assert_eq!(first(-1.0), [1.0; 6]);
    assert_eq!(first(-2.0), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert_eq!(grunwald_weight(order(1.0), 1_000_000), 0.0);
    assert_eq!(grunwald_weight(order(-1.0), 1_000_000), 1.0);
}

#[test]
fn a_straight_line_has_no_derivative_of_order_1_at_its_corners() {
    for mu in [1.0, 1.5] {
        assert_eq!(piecewise_linear_weight(order(mu), 3), None, "μ {mu}");
    }
    assert!(piecewise_linear_weight(order(1.0f64.next_down()), 3).is_some());
}

#[test]
fn muir_polynomial_of_degree_3_is_the_dissertations() {
    // (4.2): 1 − μw + (μ²/3)w² − (μ/3)w³
    for mu in [-1.3, -0.5, 0.0, 0.2247, 1.0, 2.0] {
        let mut a = [0.0; 4];
        muir_coefficients(order(mu), &mut a);
        let want = [1.0, -mu, mu * mu / 3.0, -mu / 3.0];
        crate::oracle::assert_close(&a, &want, 1e-15);
    }
}

#[test]
fn muir_polynomials_solve_their_defining_recursion() {
    // A_n(w) = A_{n−1}(w) − c_n·wⁿ·A_{n−1}(1/w), from vectors kept apart.
    let mu = 0.6;
    let mut want = vec![1.0];
    for n in 1..=21_usize {
        let c = if n % 2 == 1 { mu / n as f64 } else { 0.0 };
        want.push(0.0);
        let before = want.clone();
        for i in 0..=n {
            want[i] = before[i] - c * before[n - i];
        }
        let mut have = vec![0.0; n + 1];
        muir_coefficients(order(mu), &mut have);
        crate::oracle::assert_close(&have, &want, 1e-14);
    }
}
