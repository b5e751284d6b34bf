//! The operator on increments: the bound of its output, single precision, rest, passivity.

use crate::oracle::{SAMPLE_TIME, order, run};
use fracdiff::full_memory::{Design, FullMemory, Kernel};
use fracdiff::{
    Differintegrator, FrequencyResponse, Operator, Real, Scheme, grunwald_weight, grunwald_weights,
    piecewise_linear_weight,
};

/// Samples of 200 s at 1 kHz.
const SAMPLES: usize = 200_000;

/// 0 to 1 cm in one second, then held, as a sensor of single precision tells it.
fn ramp_and_hold(n: usize) -> f64 {
    f64::from((1e-2 * (n as f64 * 1e-3).min(1.0)) as f32)
}

fn design(kernel: Kernel, mu: f64, horizon: f64) -> Design<16, 48> {
    Design::pruned(kernel, order(mu), 1e-6, horizon).expect("reachable")
}

fn operator<F: Real>(design: &Design<16, 48>) -> FullMemory<F, 16, 48> {
    FullMemory::new(design, SAMPLE_TIME).expect("valid")
}

/// What single precision loses of the bound of the output, as `FullMemory` says.
const SINGLE: f64 = 2e-6;

/// `T^(−μ)·Σ c_j·size[n−j]`, μ > 1: the core of order μ − 2, by giving the operator the double sum.
fn bound_of(design: &Design<16, 48>, sizes: &[f64]) -> Vec<f64> {
    let operator = operator::<f64>(design);
    let mut history = operator.at_rest();
    let (mut slope, mut position) = (0.0, 0.0);
    let step = |size: &f64| {
        slope += size;
        position += slope;
        operator.step(&mut history, position)
    };
    sizes.iter().map(step).collect()
}

/// The outputs in single and in double precision.
fn both(design: &Design<16, 48>, x: &[f64]) -> (Vec<f64>, Vec<f64>) {
    (
        run(&operator::<f32>(design), x),
        run(&operator::<f64>(design), x),
    )
}

/// Δx.
fn differences(x: &[f64]) -> Vec<f64> {
    let before = std::iter::once(&0.0).chain(x);
    x.iter().zip(before).map(|(x, before)| x - before).collect()
}

#[test]
fn single_precision_holds_2e_6_of_the_present_output_for_200_s() {
    for kernel in [Kernel::Grunwald, Kernel::PiecewiseLinear] {
        for mu in [0.05, 0.2247, 0.5, 0.7, 0.9, 0.99] {
            let design = design(kernel, mu, 2.1e5);
            let x: Vec<f64> = (0..SAMPLES).map(ramp_and_hold).collect();
            let (single, double) = both(&design, &x);
            for n in 1..SAMPLES {
                let error = (single[n] / double[n] - 1.0).abs();
                assert!(error <= SINGLE, "{kernel:?} μ {mu} sample {n}: {error:e}");
            }
        }
    }
}

#[test]
fn single_precision_holds_2e_6_of_the_bound_where_the_output_is_a_difference() {
    for kernel in [Kernel::Grunwald, Kernel::PiecewiseLinear] {
        for mu in [1.3, 1.8] {
            let design = design(kernel, mu, 2.1e5);
            let x: Vec<f64> = (0..SAMPLES).map(ramp_and_hold).collect();
            let second = differences(&differences(&x));
            let bound = bound_of(&design, &second.iter().map(|u| u.abs()).collect::<Vec<_>>());
            let (single, double) = both(&design, &x);
            for n in 1..SAMPLES {
                let error = (single[n] - double[n]).abs() / bound[n];
                assert!(error <= SINGLE, "{kernel:?} μ {mu} sample {n}: {error:e}");
            }
        }
    }
}

#[test]
fn single_precision_loses_of_first_differences_what_their_rounding_takes() {
    let mut worst = 0.0_f64;
    for mu in [1.3, 1.8, 1.96, 1.99, 1.999, 2.0] {
        let design = design(Kernel::Grunwald, mu, 2.1e5);
        for hertz in [0.37, 3.3, 31.0] {
            // It passes zero between samples, at ever other phases.
            let angle = |n: usize| core::f64::consts::TAU * hertz * n as f64 * 1e-3;
            let x: Vec<f64> = (0..20_000)
                .map(|n| f64::from((1e-2 * ((angle(n) + 0.3).sin() - 0.3_f64.sin())) as f32))
                .collect();
            let first = differences(&x);
            let second: Vec<f64> = differences(&first).iter().map(|u| u.abs()).collect();
            let before = std::iter::once(&0.0).chain(&first);
            let rounded: Vec<f64> = (first.iter().zip(before))
                .map(|(new, old)| new.abs() + old.abs())
                .collect();
            let (bound, rounding) = (bound_of(&design, &second), bound_of(&design, &rounded));
            let (single, double) = both(&design, &x);
            for n in 1..x.len() {
                let error = (single[n] - double[n]).abs();
                let most = SINGLE * bound[n] + 2_f64.powi(-24) * rounding[n];
                assert!(
                    error <= most,
                    "μ {mu} {hertz} Hz sample {n}: {error:e} {most:e}"
                );
                if mu < 2.0 {
                    worst = worst.max(error / bound[n]);
                }
            }
        }
    }
    // More than without it, and no more than is said.
    assert!((1e-5..1.2e-4).contains(&worst), "{worst:e}");
}

#[test]
fn double_precision_holds_its_tolerance_of_the_present_output_for_200_s() {
    for mu in [0.05, 0.2247, 0.5, 0.7, 0.9, 0.99] {
        let design = design(Kernel::Grunwald, mu, 2.1e5);
        let ramp = |n: usize| (n as f64).min(1000.0);
        let have = run(
            &operator::<f64>(&design),
            &(0..SAMPLES).map(ramp).collect::<Vec<_>>(),
        );
        // The full sum: the core's weights over the increments, which are 1 for the first 1000 samples: positive terms
        // only, so no digits are lost.
        let weights: Vec<f64> = grunwald_weights(order(mu - 1.0)).take(SAMPLES).collect();
        let rate = SAMPLE_TIME.0.powf(-mu);
        let mut window = 0.0;
        for n in 1..SAMPLES {
            // Increments at samples 1 to 1000.
            window += weights[n - 1];
            let want: f64 = if n <= 1000 {
                window
            } else if n % 997 == 0 || n == SAMPLES - 1 {
                weights[n - 1000..n].iter().sum()
            } else {
                continue;
            };
            let error = (have[n] / (rate * want) - 1.0).abs();
            assert!(error <= 1e-6, "μ {mu} sample {n}: {error:e}");
        }
    }
}

/// Chebyshev's alternative: a sum of n exponentials whose error has 2n + 1 equal peaks of changing sign is the best one.
#[test]
fn the_best_modes_of_all_are_taken_and_19_hold_200_s_within_1e_6() {
    for mu in (1..40).filter(|i| i % 20 != 0).map(|i| f64::from(i) * 0.05) {
        let linear = design(Kernel::PiecewiseLinear, mu, 2e5);
        let design = design(Kernel::Grunwald, mu, 2e5);
        let modes = design.modes().len();
        assert!(modes.max(linear.modes().len()) <= 19, "μ {mu}: {modes}");
        let mut peaks: Vec<f64> = vec![];
        let lags = std::iter::successors(Some(16), |lag| Some((lag + 1).max(lag + lag / 500)));
        for lag in lags.take_while(|lag| *lag < 200_000).chain([200_000]) {
            let want = grunwald_weight(order(mu - mu.ceil()), lag);
            let error = design.core_weight(lag) / want - 1.0;
            match peaks.last_mut() {
                Some(peak) if *peak * error > 0.0 => {
                    *peak = peak.abs().max(error.abs()).copysign(error);
                }
                _ => peaks.push(error),
            }
        }
        assert_eq!(peaks.len(), 2 * modes + 1, "μ {mu}: {peaks:?}");
        let sizes = peaks.iter().map(|peak| peak.abs());
        let (low, high) = sizes.fold((1.0_f64, 0.0_f64), |(low, high), size| {
            (low.min(size), high.max(size))
        });
        // Peaks lie between lags, the more so next to both ends.
        assert!(high <= 1.2 * low, "μ {mu}: {peaks:?}");
    }
}

#[test]
fn nothing_is_left_at_rest_to_the_last_bit() {
    for scheme in ["full", "piecewise-linear", "full:1e-3"] {
        let scheme: Scheme = scheme.parse().expect("valid");
        for mu in (1..=40).map(|i| f64::from(i) * 0.05) {
            let operator: Operator<f32> = scheme.build(order(mu), SAMPLE_TIME, 2e5).expect("valid");
            let rest = operator.response(0.0);
            assert_eq!((rest.re, rest.im), (0.0, 0.0), "{scheme} μ {mu}");
        }
    }
}

/// Asserts with the shortest memory, behind which the modes decay soon, that a step is forgotten.
fn forgets<F: Real>(mu: f64) {
    let operator: FullMemory<F, 16, 48> = operator(&design(Kernel::Grunwald, mu, 1e2));
    let mut history = operator.at_rest();
    let x = F::from_f64(0.3);
    let mut before = F::from_f64(f64::INFINITY);
    for n in 0..3_000_000 {
        let y = operator.step(&mut history, x);
        // It fades to zero from above, and never turns round.
        assert!(y >= F::ZERO && y <= before, "μ {mu} sample {n}: {y}");
        before = y;
        if y == F::ZERO {
            // And stays there.
            for _ in 0..1000 {
                assert_eq!(operator.step(&mut history, x), F::ZERO);
            }
            return;
        }
    }
    panic!(
        "μ {mu} is not at rest after 3 million samples: {before:e}",
        before = before.to_f64()
    );
}

#[test]
fn a_constant_is_forgotten_to_exactly_zero_and_never_turns_round() {
    for mu in [0.2247, 0.7, 0.95] {
        forgets::<f32>(mu);
    }
    for mu in [0.7, 0.95] {
        forgets::<f64>(mu);
    }
}

#[test]
fn the_operator_gives_no_energy_at_any_frequency() {
    for scheme in [
        "full:1e-6",
        "full:1e-2",
        "piecewise-linear",
        "piecewise-linear:1e-2",
    ] {
        let scheme: Scheme = scheme.parse().expect("valid");
        for mu in [0.05, 0.2154, 0.35, 0.4, 0.45, 0.5, 0.7, 0.8, 0.9, 0.99, 1.0] {
            let operator: Operator<f32> = scheme.build(order(mu), SAMPLE_TIME, 2e5).expect("valid");
            // From far below the horizon up to half the sample rate.
            for k in 0..=3000 {
                let theta = core::f64::consts::PI * 10f64.powf(-f64::from(k) / 250.0);
                let re = operator.response(theta).re;
                assert!(re >= 0.0, "{scheme} μ {mu} θ {theta:e}: {re:e}");
            }
        }
    }
}

#[test]
fn an_offset_and_a_long_memory_cost_no_digits() {
    // 0.1 m and 1 µm of noise: the output of single precision is that of double precision fed the same positions.
    // CAMPAIGN_SAMPLES=86400000 runs the whole day.
    let samples: u64 = std::env::var("CAMPAIGN_SAMPLES")
        .ok()
        .map_or(2_000_000, |text| text.parse().expect("a number"));
    let mu = 0.7;
    let design = design(Kernel::Grunwald, mu, 86.4e6);
    let (single, double) = (operator::<f32>(&design), operator::<f64>(&design));
    let (mut one, mut other) = (single.at_rest(), double.at_rest());
    let mut seed = 1_u64;
    let mut noise = || {
        // xorshift64*: the same numbers everywhere.
        seed ^= seed >> 12;
        seed ^= seed << 25;
        seed ^= seed >> 27;
        let bits = seed.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 40;
        bits as f64 / f64::from(1 << 23) - 1.0
    };
    // The offset's own response: weight n of order μ − 1.
    let mut worst = 0.0_f64;
    for n in 0..samples {
        let x = (0.1 + 1.7e-6 * noise()) as f32;
        let (have, want) = (
            f64::from(single.step(&mut one, x)),
            double.step(&mut other, f64::from(x)),
        );
        if n % 1009 == 0 || n + 1 == samples {
            let weight =
                0.1 * SAMPLE_TIME.0.powf(-mu) * fracdiff::grunwald_weight(order(mu - 1.0), n);
            let error = (have - want).abs() / weight;
            worst = worst.max(error);
            assert!(error <= 1e-4, "sample {n}: {error:e}");
        }
    }
    println!("worst {worst:e}");
}

/// `T^(−μ)·Σ c_j·x[n−j]`; from order 1 on the straight lines' kernel acts on the difference.
fn defining_sum(kernel: Kernel, mu: f64, x: &[f64]) -> Vec<f64> {
    if kernel == Kernel::Grunwald || mu == 2.0 {
        return crate::oracle::grunwald_sum(mu, SAMPLE_TIME, x.len(), x);
    }
    let differences = (0..x.len()).map(|n| x[n] - if n > 0 { x[n - 1] } else { 0.0 });
    let (mu_lines, input) = if mu < 1.0 {
        (mu, x.to_vec())
    } else {
        (mu - 1.0, differences.collect())
    };
    let weights: Vec<f64> = (0..x.len() as u64)
        .map(|lag| piecewise_linear_weight(order(mu_lines), lag).expect("below 1"))
        .collect();
    let sums = crate::oracle::convolve(&weights, &input);
    sums.iter().map(|y| SAMPLE_TIME.0.powf(-mu) * y).collect()
}

#[test]
fn orders_next_to_whole_ones_are_designed_and_run() {
    let x: Vec<f64> = (0..3000).map(ramp_and_hold).collect();
    for whole in [-1.0, 0.0, 1.0, 2.0] {
        for step in [-1e-3, -1e-9, -1e-15, 1e-300, 1e-17, 1e-12, 1e-6, 1e-3_f64] {
            let mu = whole + step;
            if !(-2.0..=2.0).contains(&mu) {
                continue;
            }
            for kernel in [Kernel::Grunwald, Kernel::PiecewiseLinear] {
                let design = Design::<16, 48>::pruned(kernel, order(mu), 1e-6, 2e5)
                    .unwrap_or_else(|error| panic!("{kernel:?} {mu:e}: {error}"));
                assert!(design.error_bound() <= 1e-6);
                let have = run(&operator::<f64>(&design), &x);
                let want = defining_sum(kernel, mu, &x);
                let largest = crate::oracle::largest(&want);
                crate::oracle::assert_close(&have, &want, 2e-6 * largest);
            }
        }
    }
}

/// Largest |f32 − f64| over the largest output so far, for a constant rate that lasts 200 s.
fn steady(mu: f64, x: impl Fn(usize) -> f64) -> f64 {
    let design = design(Kernel::Grunwald, mu, 2.1e5);
    let (single, double) = (operator::<f32>(&design), operator::<f64>(&design));
    let (mut one, mut other) = (single.at_rest(), double.at_rest());
    let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
    for n in 0..SAMPLES {
        let x = x(n) as f32;
        let have = f64::from(single.step(&mut one, x));
        let want = double.step(&mut other, f64::from(x));
        largest = largest.max(want.abs());
        worst = worst.max((have - want).abs() / largest);
    }
    worst
}

#[test]
fn an_integral_of_a_constant_loses_nothing_in_single_precision() {
    // Without compensation words from 1/64 on, states stand still 1e-5 away from where they belong.
    for mu in [-0.05, -0.5, -0.9, -1.1, -1.5] {
        let error = steady(mu, |_| 0.3);
        assert!(error <= 1e-6, "μ {mu}: {error:e}");
    }
}

#[test]
fn a_ramp_that_lasts_200_s_keeps_5e_6_in_single_precision() {
    // Increments of one size for ever are the worst case of states without compensation words.
    for mu in [0.2247, 0.5, 0.9, 0.95] {
        let error = steady(mu, |n| (n as f64) * 2f64.powi(-24));
        assert!(error <= 5e-6, "μ {mu}: {error:e}");
    }
}
