//! Stability verdicts: by encirclement, and by eigenvalues found here, independently of the crate.

mod known;
mod operators;

use fracdiff::{Order, Scheme, Seconds};
use haptic_analysis::{LoopOperator, Nondimensional, SampledLoop, SampledPlant};
use nalgebra::{Complex, DMatrix};
use proptest::prelude::*;
use testkit::operator::{operator, wall};
use testkit::{Random, assert_refused};

/// The characteristic polynomial and its roots, with nothing from the crate: (4.1) and (4.2) as
/// printed, with c₃ where the dissertation repeats c₂.
struct Independent {
    moduli: Vec<f64>,
}

impl Independent {
    fn new(parameters: Nondimensional, delay: usize, taps: &[f64]) -> Self {
        let Nondimensional { alpha, beta, .. } = parameters;
        let [n1, n0, sum, product] = Self::plant(parameters.delta, parameters.gamma);
        let mut x = vec![0.0; delay + 2 + taps.len().max(1) + 1];
        x[0] += 1.0;
        x[1] -= sum;
        x[2] += product;
        for (j, tap) in taps.iter().enumerate() {
            let h = beta * tap + if j == 0 { alpha } else { 0.0 };
            x[delay + 1 + j] += n1 * h;
            x[delay + 2 + j] += n0 * h;
        }
        let n = x.len() - 1;
        // Companion with the coefficients in the last column, unlike the crate's.
        let companion = DMatrix::from_fn(n, n, |row, column| {
            if column == n - 1 {
                -x[n - row]
            } else {
                f64::from(u8::from(row == column + 1))
            }
        });
        let moduli = companion.complex_eigenvalues();
        let moduli = moduli.iter().map(|z| z.norm()).collect();
        Self { moduli }
    }

    fn plant(delta: f64, gamma: f64) -> [f64; 4] {
        let e = (-delta).exp();
        if gamma == 0.0 && delta == 0.0 {
            return [0.5, 0.5, 2.0, 1.0];
        } else if gamma == 0.0 {
            let square = delta * delta;
            let n1 = (delta - 1.0 + e) / square;
            return [n1, (1.0 - e - delta * e) / square, 1.0 + e, e];
        }
        let c1 = Complex::new(delta * delta - 4.0 * gamma, 0.0).sqrt();
        let c2 = (-(c1 + delta) / 2.0).exp();
        let c3 = (-(-c1 + delta) / 2.0).exp();
        let n1 = ((-c2 - c3 + 2.0) * c1 + (c2 - c3) * delta) / (c1 * 2.0 * gamma);
        let n0 = ((-c2 - c3 + 2.0 * e) * c1 + (c3 - c2) * delta) / (c1 * 2.0 * gamma);
        [n1.re, n0.re, (c2 + c3).re, e]
    }

    fn unstable(&self) -> usize {
        self.moduli.iter().filter(|&&r| r > 1.0).count()
    }

    fn gap(&self) -> f64 {
        let gaps = self.moduli.iter().map(|r| (r - 1.0).abs());
        gaps.fold(f64::INFINITY, f64::min)
    }

    fn radius(&self) -> f64 {
        self.moduli.iter().copied().fold(0.0, f64::max)
    }
}

fn muir3(order: f64) -> Vec<f64> {
    vec![1.0, -order, order * order / 3.0, -order / 3.0]
}

fn grunwald(order: f64, length: usize) -> Vec<f64> {
    let mut weight = 1.0;
    let mut weights = Vec::new();
    for j in 1..=length {
        weights.push(weight);
        weight *= 1.0 - (order + 1.0) / j as f64;
    }
    weights
}

/// An order, and an operator with its taps.
fn drawn(random: &mut Random, case: usize) -> (f64, &'static str, Vec<f64>) {
    let order = match case % 7 {
        0 => f64::from(random.between(0.0, 5.0).floor() as u8) * 0.5,
        _ => random.between(0.0, 2.0),
    };
    if case.is_multiple_of(2) {
        (order, "muir:3", muir3(order))
    } else {
        (order, "grunwald:20", grunwald(order, 20))
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn no_verdict_is_wrong_in_ten_thousand_random_loops() {
    const CASES: usize = 10_000;
    let mut random = Random(20_241);
    let (mut skipped, mut stable) = (0, 0);
    let mut worst_radius: f64 = 0.0;
    for case in 0..CASES {
        let (order, name, taps) = drawn(&mut random, case);
        let delay = (random.between(0.0, 4.0)) as usize;
        // Stiffness about as large as the delay lets a loop bear, so that both verdicts are common.
        let most = 2.0 / (1.0 + 3.0 * delay as f64);
        let parameters = wall(
            random.between(0.0, most) * random.share(),
            random.between(0.0, most),
            random.or_nothing(2.0),
            random.or_nothing(2.0),
        );
        let want = Independent::new(parameters, delay, &taps);
        if want.gap() < 1e-9 {
            skipped += 1;
            continue;
        }
        let operator = operator(name, order);
        let subject = SampledLoop::new(parameters, &operator, delay).expect("in range");
        let what = format!("case {case}: {name}, μ = {order}, {parameters:?}, d = {delay}");
        let verdict = subject.verdict();
        let outside = want.unstable();
        assert_eq!(verdict.unstable_poles, Some(outside), "{what}");
        assert_eq!(verdict.stable, want.unstable() == 0, "{what}");
        stable += usize::from(verdict.stable);
        let radius = subject.spectral_radius().expect("a polynomial");
        // A zero as good as double is known to the root of a rounding error only.
        worst_radius = worst_radius.max((radius - want.radius()).abs());
        assert_eq!(radius < 1.0, verdict.stable, "{what}, radius {radius}");
    }
    let both = stable > CASES / 5 && stable < 4 * CASES / 5;
    assert!(both, "{stable} stable: a lopsided sample");
    assert!(skipped < 5, "{skipped} skipped");
    assert!(worst_radius < 1e-6, "{worst_radius:e}");
}

#[test]
fn slow_and_nearly_marginal_loops_are_judged_right() {
    let mut random = Random(7);
    let mut checked = 0;
    for case in 0..2000 {
        let mut small = |least: f64| 10_f64.powf(random.between(least, 0.3));
        let parameters = wall(small(-7.0), small(-3.0), small(-3.0), 0.0);
        let order = random.between(0.0, 2.0);
        let want = Independent::new(parameters, case % 3, &muir3(order));
        if want.gap() < 1e-9 {
            continue;
        }
        let operator = operator("muir:3", order);
        let subject = SampledLoop::new(parameters, &operator, case % 3).expect("in range");
        let have = subject.verdict().unstable_poles;
        let what = format!("case {case}: μ = {order}, {parameters:?}");
        assert_eq!(have, Some(want.unstable()), "{what}");
        checked += 1;
    }
    assert!(checked > 1950, "{checked}");
}

/// The largest stable α for a given β, by bisection of verdicts; the region is one interval there.
fn stiffest(operator: &LoopOperator, beta: f64, delta: f64, delay: usize) -> f64 {
    let stable = |alpha| {
        let parameters = wall(alpha, beta, delta, 0.0);
        let subject = SampledLoop::new(parameters, operator, delay);
        subject.expect("in range").is_stable()
    };
    let (mut low, mut high) = (1e-3, 4.0);
    assert!(stable(low) && !stable(high));
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if stable(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

#[test]
fn bad_input_is_refused_in_words() {
    let order = Order::new(-0.5).expect("an order");
    let integral = LoopOperator::new(Scheme::Exact, order, Seconds(1e-3), 1e3);
    assert_refused(integral, "order -0.5 is not from 0 to 2");
    let exact = operator("exact", 0.5);
    const NAN: f64 = f64::NAN;
    const INF: f64 = f64::INFINITY;
    for ([alpha, beta, delta, gamma], delay, want) in [
        ([-1.0, 0.0, 0.0, 0.0], 0, "alpha -1 is not from 0 to 1e12"),
        ([0.0, NAN, 0.0, 0.0], 0, "beta NaN is not from 0 to 1e12"),
        ([0.0, 0.0, -3.0, 0.0], 0, "delta -3 is not from 0 to 1e6"),
        (
            [0.0, 0.0, 0.0, INF],
            0,
            "gamma inf is not finite and from 0 to 1e12",
        ),
        ([1e13, 0.0, 0.0, 0.0], 0, "alpha 1e13 is not from 0 to 1e12"),
        (
            [0.0; 4],
            10_001,
            "delay 10001 samples is not from 0 to 10000 samples",
        ),
    ] {
        let have = SampledLoop::new(wall(alpha, beta, delta, gamma), &exact, delay);
        assert_eq!(have.expect_err("refused").to_string(), want);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn the_characteristic_function_is_the_sum_it_is_made_of(
        mu in 0.0..=2.0_f64, alpha in 0.0..2.0_f64, beta in 0.0..2.0_f64,
        delta in 0.0..3.0_f64, gamma in 0.0..3.0_f64, delay in 0..40_usize, theta in 0.0..3.1_f64,
    ) {
        let operator = operator("exact", mu);
        let have = SampledLoop::new(wall(alpha, beta, delta, gamma), &operator, delay).expect("in range").characteristic(theta);
        let plant = SampledPlant::new(delta, gamma).expect("in range");
        let w = Complex::from_polar(1.0, -theta);
        let p = (-w + 1.0).powf(mu);
        let at = |c: &[f64]| c.iter().rev().fold(Complex::new(0.0, 0.0), |sum, c| sum * w + c);
        let fed_back = w.powu(delay as u32 + 1) * at(plant.numerator()) * (p * beta + alpha);
        let want = at(plant.denominator()) + fed_back;
        prop_assert!((have - want).norm() < 1e-12 * (1.0 + want.norm()), "{} {}", have, want);
    }
}
