//! The duties of every operator: definitions, special orders, linearity, responses.

use crate::oracle::{
    SAMPLE_TIME, SCHEMES, assert_close, build, convolve, full, largest, lively, order, run,
};
use core::f64::consts::PI;
use fracdiff::full_memory::Kernel;
use fracdiff::{
    Band, Channel, Differintegrator, ExactDifference, FrequencyResponse, MuirPolynomial, Operator,
    Oustaloup, PortableOperator, Real, Scheme, Seconds, ShortMemory, ShortMemoryVec, ShortQuotient,
    TustinMuir, grunwald_weights, muir_coefficients,
};
use num_complex::Complex;
use proptest::prelude::*;

#[test]
fn every_kind_of_operator_is_in_the_list() {
    let mut kinds: Vec<_> = SCHEMES
        .iter()
        .map(|scheme| match build::<f64>(scheme, 0.5) {
            Operator::ShortMemory(_) => 0,
            Operator::MuirPolynomial(_) => 1,
            Operator::TustinMuir(_) => 2,
            Operator::Oustaloup(_) => 3,
            Operator::FullMemory(_) => 4,
            Operator::Bdf2Memory(_) => 5,
            Operator::ShortQuotient(_) | _ => {
                panic!("no scheme of one order, or a new kind: add it to SCHEMES")
            }
        })
        .collect();
    kinds.dedup();
    assert_eq!(kinds, [0, 1, 2, 3, 4, 5]);
}

#[test]
fn short_memory_is_its_defining_sum_through_several_wraps() {
    let x = lively(700);
    for mu in [-2.0, -0.5, 0.2247, 1.0, 1.7] {
        let want = crate::oracle::grunwald_sum(mu, SAMPLE_TIME, 100, &x);
        let array = ShortMemory::<f64, 100>::new(order(mu), SAMPLE_TIME).expect("valid");
        assert_close(&run(&array, &x), &want, 1e-13 * largest(&want));
        let heap = ShortMemoryVec::<f64>::new(order(mu), 100, SAMPLE_TIME).expect("valid");
        assert_eq!(run(&heap, &x), run(&array, &x));
        let single = ShortMemory::<f32, 100>::new(order(mu), SAMPLE_TIME).expect("valid");
        // Half a unit in the last place each for sample, tap, product and (several) sums, on all that
        // is summed: 6·2^(−24)·T^(−μ)·Σ|c_j|·max|x|.
        let gains: f64 = grunwald_weights(order(mu)).take(100).map(f64::abs).sum();
        let summed = SAMPLE_TIME.0.powf(-mu) * gains * largest(&x);
        assert_close(&run(&single, &x), &want, 6.0 * 2f64.powi(-24) * summed);
    }
}

/// A fractional Zener element of short memories: Σ of (a + k·d) over (a + d), as its weights give it.
fn zener(alpha: f64, length: usize) -> [Vec<f64>; 2] {
    let weights: Vec<f64> = grunwald_weights(order(alpha)).take(length).collect();
    let below: Vec<f64> = (0..length)
        .map(|j| 3.0 * weights[j] + f64::from(u8::from(j == 0)))
        .collect();
    [weights.iter().map(|c| 2.0 * c).collect(), below]
}

#[test]
fn a_short_quotient_is_its_defining_recursion() {
    let (x, t) = (lively(500), Seconds(1e-3));
    // Over 1 it is the short memory itself.
    let weights: Vec<f64> = grunwald_weights(order(0.4)).take(90).collect();
    let alone = ShortQuotient::<f64>::new(order(0.4), [&weights, &[1.0]], t).expect("valid");
    let short = ShortMemoryVec::<f64>::new(order(0.4), 90, t).expect("valid");
    let want = run(&short, &x);
    assert_close(&run(&alone, &x), &want, 1e-13 * largest(&want));
    for (alpha, length) in [(0.3, 1), (0.3, 2), (0.7, 61), (1.0, 300), (0.05, 120)] {
        let [above, below] = zener(alpha, length);
        let quotient = ShortQuotient::<f64>::new(order(0.0), [&above, &below], t).expect("valid");
        let mut want: Vec<f64> = Vec::new();
        for n in 0..x.len() {
            let heard: f64 = (0..length.min(n + 1)).map(|j| above[j] * x[n - j]).sum();
            let own: f64 = (1..length.min(n + 1)).map(|j| below[j] * want[n - j]).sum();
            want.push((heard - own) / below[0]);
        }
        assert_close(&run(&quotient, &x), &want, 1e-13 * largest(&want));
        // A board runs its list, to the bit.
        let list = Operator::ShortQuotient(quotient.clone())
            .list()
            .expect("a list");
        let board = PortableOperator::<f64, 8, 8, 300>::new(list.form, list.integer, &list.values);
        assert_eq!(run(&board.expect("fits"), &x), run(&quotient, &x));
        // A step that stood for ever stands; and the response is the sum of its own impulse response.
        let mut settled = quotient.settled(1.5).expect("settles");
        let first = quotient.step(&mut settled, 1.5);
        assert!((quotient.step(&mut settled, 1.5) - first).abs() < 1e-13 * first.abs().max(1.0));
        let mut impulse = vec![0.0; 40_000];
        impulse[0] = 1.0;
        let impulse = run(&quotient, &impulse);
        let theta = 0.7;
        let sum: Complex<f64> = (impulse.iter().enumerate())
            .map(|(n, y)| Complex::from_polar(*y, -theta * n as f64))
            .sum();
        assert!(
            (quotient.response(theta) - sum).norm() < 1e-9,
            "{alpha} {length}"
        );
    }
    for [above, below] in [
        [&[1.0, 2.0][..], &[1.0, -1.0][..]],
        [&[1.0], &[f64::NAN]],
        [&[f64::INFINITY], &[1.0]],
        [&[], &[1.0]],
        [&[1.0], &[-2.0, 1.0]],
    ] {
        let refused = ShortQuotient::<f64>::new(order(0.0), [above, below], t);
        assert!(refused.is_err(), "{above:?} over {below:?}");
    }
}

#[test]
fn a_memory_of_one_sample_is_a_gain() {
    let one = ShortMemory::<f64, 1>::new(order(0.5), Seconds(0.25)).expect("valid");
    assert_eq!(run(&one, &[1.0, 3.0, -2.0]), [2.0, 6.0, -4.0]);
}

#[test]
fn muir_polynomial_is_its_defining_sum() {
    let x = lively(200);
    for mu in [-1.0, 0.5, 2.0] {
        let mut a = [0.0; 8];
        muir_coefficients(order(mu), &mut a);
        let rate = SAMPLE_TIME.0.powf(-mu);
        let want: Vec<f64> = convolve(&a, &x).iter().map(|y| rate * y).collect();
        let operator = MuirPolynomial::<f64, 7>::new(order(mu), SAMPLE_TIME).expect("valid");
        assert_close(&run(&operator, &x), &want, 1e-13 * largest(&want));
    }
}

#[test]
fn tustin_muir_solves_its_difference_equation() {
    // Σ a_i y[k−i] = (2/T)^φ Σ b_i (Δⁿx/Tⁿ)[k−i]
    let x = lively(300);
    for (mu, degree) in [-1.7, -1.0, -0.6, 0.0, 0.2247, 0.9, 1.4, 2.0]
        .into_iter()
        .flat_map(|mu| [1, 2, 3, 4, 5, 9, 16].map(|degree| (mu, degree)))
    {
        let (n, phi) = order(mu).split();
        let operator = TustinMuir::<f64, 16>::with_degree(order(mu), degree, SAMPLE_TIME);
        let operator = operator.expect("valid");
        let y = run(&operator, &x);
        let (mut a, mut b) = (vec![0.0; degree + 1], vec![0.0; degree + 1]);
        muir_coefficients(order(-phi), &mut a);
        muir_coefficients(order(phi), &mut b);
        let input = crate::oracle::grunwald_sum(f64::from(n), SAMPLE_TIME, x.len(), &x);
        let gain = (2.0 / SAMPLE_TIME.0).powf(phi);
        let right: Vec<f64> = convolve(&b, &input).iter().map(|y| gain * y).collect();
        assert_close(&convolve(&a, &y), &right, 1e-12 * largest(&right));
        if n == 0 {
            // Held for ever: the ratio of the sums, 1e-13 of the largest term.
            let mut history = operator.settled(0.7).expect("it settles");
            let sum = |c: &[f64]| c.iter().sum::<f64>();
            let want = vec![0.7 * gain * sum(&b) / sum(&a); 300];
            let have: Vec<f64> = (0..300).map(|_| operator.step(&mut history, 0.7)).collect();
            assert_close(&have, &want, 1e-13 * gain);
        }
    }
}

#[test]
fn rounding_in_tustin_muir_stays_below_that_of_free_coefficients() {
    // The root of the mean square against f64, where it is largest: a slow signal, near order 1, for 300 000 samples.
    let x: Vec<f64> = (0..300_000)
        .map(|n| f64::from((0.01 * f64::from(n)).sin() as f32))
        .collect();
    let off = |have: &[f64], want: &[f64]| {
        let squares = have
            .iter()
            .zip(want)
            .map(|(have, want)| (have - want).powi(2));
        (squares.sum::<f64>() / have.len() as f64).sqrt()
    };
    for (mu, degree) in [(0.7, 9), (0.9, 9), (0.9, 15)] {
        let single: Operator<f32> = build(&format!("tustin-muir:{degree}"), mu);
        let list = single.list().expect("a list").values;
        // The recursion that it would be without the symmetry: s_i ← s_{i+1} + (b_i·x − a_i·y).
        fn free<F: Real>(list: &[f32], x: &[f64]) -> Vec<f64> {
            let c: Vec<F> = list.iter().map(|c| F::from_f64((*c).into())).collect();
            let mut s = vec![F::ZERO; c.len() / 2 + 1];
            let step = |x: &f64| {
                let x = F::from_f64(*x);
                let y = c[0] * x + s[0];
                for i in 1..s.len() {
                    s[i - 1] = s[i] + (c[2 * i - 1] * x - c[2 * i] * y);
                }
                y.to_f64()
            };
            x.iter().map(step).collect()
        }
        let want = free::<f64>(&list, &x);
        let (have, before) = (
            off(&run(&single, &x), &want),
            off(&free::<f32>(&list, &x), &want),
        );
        assert!(have <= before, "{mu} {degree}: {have:e}, {before:e}");
        // And it does not grow: the last tenth is as far off as the rest.
        let y = run(&single, &x);
        let end = off(&y[270_000..], &want[270_000..]);
        assert!(end <= 1.2 * have, "{mu} {degree}: {end:e}, {have:e}");
    }
}

#[test]
fn oustaloup_has_its_analogue_response_at_the_bent_frequency() {
    // Tustin: P at θ is the analogue prototype at (2/T)·tan(θ/2).
    let band = Band {
        low_hz: 0.01,
        high_hz: 100.0,
    };
    let (low, high) = (2.0 * PI * band.low_hz, 2.0 * PI * band.high_hz);
    for phi in [-0.5, 0.2247, 0.9] {
        let operator = Oustaloup::<f64, 16>::new(order(phi), 9, band, SAMPLE_TIME).expect("valid");
        for theta in [1e-5, 1e-3, 0.1, 1.0, 3.0] {
            let s = Complex::new(0.0, 2.0 / SAMPLE_TIME.0 * (theta / 2.0_f64).tan());
            let mut want = Complex::new(high.powf(phi), 0.0);
            for i in 1..=9 {
                let corner = |sign: f64| {
                    low * (high / low).powf((2.0 * f64::from(i) - 1.0 + sign * phi) / 18.0)
                };
                want *= (s + corner(-1.0)) / (s + corner(1.0));
            }
            let have = operator.response(theta) * SAMPLE_TIME.0.powf(-phi);
            // A sum of terms as large as the gain beyond the corner where it is largest.
            let largest = high.powf(phi).max(low.powf(phi));
            assert!(
                (have - want).norm() < 1e-14 * largest,
                "{theta}: {have} {want}"
            );
        }
    }
}

#[test]
fn oustaloup_is_a_fractional_power_inside_its_band_as_well_as_it_says() {
    for phi in [0.2, 0.5, 0.95, -0.5] {
        let operator = build::<f64>("oustaloup:8:0.01:100", phi);
        // 3.5 %·|φ| a decade and a half inside, 10 %·|φ| one decade inside.
        for (hz, share) in [
            (0.316, 0.036),
            (1.0, 0.036),
            (3.16, 0.036),
            (0.1, 0.101),
            (10.0, 0.101),
        ] {
            let theta = 2.0 * PI * hz * SAMPLE_TIME.0;
            let want = Complex::from_polar(theta.powf(phi), 0.5 * PI * phi);
            let error = (operator.response(theta) / want - 1.0).norm();
            assert!(error < share * phi.abs(), "φ {phi}, {hz} Hz: {error}");
        }
    }
}

#[test]
fn whole_orders_are_exact_in_every_form_that_approximates_only_the_fraction() {
    // Multiples of 1/16 and T = 1/4: nothing rounds, so equality is meant.
    let x: Vec<f64> = (0..50)
        .map(|n| f64::from(n * 7919 % 64) / 16.0 - 2.0)
        .collect();
    let difference = |x: &[f64]| -> Vec<f64> {
        let before = core::iter::once(&0.0).chain(x);
        x.iter()
            .zip(before)
            .map(|(x, before)| (x - before) / 0.25)
            .collect()
    };
    let sum = |x: &[f64]| -> Vec<f64> {
        let running = x.iter().scan(0.0, |sum, x| {
            *sum += 0.25 * x;
            Some(*sum)
        });
        running.collect()
    };
    for scheme in [
        "tustin-muir:7",
        "oustaloup:5:0.01:1",
        "full:1e-6",
        "piecewise-linear:1e-6",
        "grunwald:50",
    ] {
        let at = |mu: f64| {
            let scheme: Scheme = scheme.parse().expect("valid");
            let operator = scheme.build::<f64>(order(mu), Seconds(0.25), 1e3);
            run(&operator.expect("valid"), &x)
        };
        assert_eq!(at(0.0), x, "{scheme}");
        assert_eq!(at(1.0), difference(&x), "{scheme}");
        assert_eq!(at(2.0), difference(&difference(&x)), "{scheme}");
        if scheme != "piecewise-linear:1e-6" {
            assert_eq!(at(-1.0), sum(&x), "{scheme}");
            assert_eq!(at(-2.0), sum(&sum(&x)), "{scheme}");
        }
    }
}

#[test]
fn an_order_too_close_to_a_whole_one_is_that_one() {
    let operator = build::<f64>("full:1e-6", 1e-310);
    assert_eq!(run(&operator, &[1.0, 2.0, -3.0]), [1.0, 2.0, -3.0]);
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_response_is_that_of_the_impulse_response() {
    // Σ h_j e^(−jθ·j) over enough of it: all of a finite memory, 400 000 samples of a recursive one.
    for scheme in SCHEMES {
        for mu in [0.2247, 0.9] {
            let operator = build::<f64>(scheme, mu);
            let mut impulse = vec![0.0; 400_000];
            impulse[0] = SAMPLE_TIME.0.powf(mu);
            let weights = run(&operator, &impulse);
            for theta in [0.01, 0.5, 2.0, PI] {
                let want: Complex<f64> = weights
                    .iter()
                    .enumerate()
                    .map(|(j, h)| Complex::from_polar(*h, -theta * j as f64))
                    .sum();
                let have = operator.response(theta);
                // What is cut off oscillates: about |h_N|/θ, 1e-5 for the full memory at 0.01.
                let cut = 2.0 * weights[weights.len() - 1].abs() / theta;
                assert!(
                    (have - want).norm() <= 1e-9 + cut,
                    "{scheme} μ {mu} θ {theta}: {have} {want}"
                );
            }
        }
    }
}

#[test]
fn full_memory_has_the_exact_response_down_to_its_horizon() {
    for mu in [-0.5, 0.05, 0.2247, 0.9, 1.5] {
        let operator = full::<f64>(Kernel::Grunwald, mu, 1e-6);
        let exact = ExactDifference(order(mu));
        for theta in [3e-5, 1e-3, 0.1, 1.0, 3.0, PI] {
            let (have, want) = (operator.response(theta), exact.response(theta));
            assert!(
                (have / want - 1.0).norm() < 3e-5,
                "μ {mu} θ {theta}: {have} {want}"
            );
        }
    }
}

#[test]
fn the_exact_response_is_the_power_of_one_minus_w() {
    for mu in [-1.5, 0.0, 0.5, 1.0, 2.0] {
        for theta in [1e-3, 0.7, PI] {
            let w = Complex::from_polar(1.0, -theta);
            let want = (Complex::new(1.0, 0.0) - w).powf(mu);
            let have = ExactDifference(order(mu)).response(theta);
            assert!((have - want).norm() < 1e-9 * want.norm(), "{have} {want}");
        }
    }
}

/// Error at t = 1 s of D^μ t² with step 1/n, against 2 t^(2−μ)/Γ(3 − μ).
fn error_at_one_second(kernel: Kernel, mu: f64, n: u32) -> f64 {
    let t = 1.0 / f64::from(n);
    let design = fracdiff::full_memory::Design::<16, 64>::pruned(kernel, order(mu), 1e-10, 1e4)
        .expect("reachable");
    let operator = fracdiff::FullMemory::<f64, 16, 64>::new(&design, Seconds(t)).expect("valid");
    let x: Vec<f64> = (0..=n).map(|k| (f64::from(k) * t).powi(2)).collect();
    let want = 2.0 / libm::tgamma(3.0 - mu);
    run(&operator, &x)[n as usize] - want
}

#[test]
fn grunwald_converges_with_order_1_and_l1_with_order_2_minus_mu() {
    for mu in [0.2247, 0.5, 0.8] {
        let ratio =
            |kernel| error_at_one_second(kernel, mu, 250) / error_at_one_second(kernel, mu, 500);
        let grunwald = ratio(Kernel::Grunwald).log2();
        assert!((grunwald - 1.0).abs() < 0.02, "μ {mu}: order {grunwald}");
        let l1 = ratio(Kernel::PiecewiseLinear).log2();
        // The next term of the L1 error, O(T²), is close for small μ.
        assert!((l1 - (2.0 - mu)).abs() < 0.12, "μ {mu}: order {l1}");
    }
}

#[test]
fn two_derivatives_are_the_derivative_of_the_sum() {
    let x = lively(2000);
    // The last of them undo each other.
    for (a, b) in [
        (0.3, 0.4),
        (0.7, 0.8),
        (-0.4, 0.9),
        (-0.5, -0.25),
        (0.2247, -0.2247),
        (1.0, -1.0),
        (1.6, -1.6),
    ] {
        let once = run(&full::<f64>(Kernel::Grunwald, a, 1e-9), &x);
        let twice = run(&full::<f64>(Kernel::Grunwald, b, 1e-9), &once);
        let want = run(&full::<f64>(Kernel::Grunwald, a + b, 1e-9), &x);
        assert_close(&twice, &want, 1e-6 * largest(&want));
    }
}

#[test]
fn truncation_never_exceeds_its_bound() {
    const N: usize = 64;
    for mu in [0.05, 0.2247, 0.7, 0.99] {
        let short = ShortMemory::<f64, N>::new(order(mu), Seconds(1.0)).expect("valid");
        let bound: f64 = grunwald_weights(order(mu)).take(N).sum();
        // The worst signal of magnitude 1: opposite signs before and inside the window.
        let x = vec![1.0; 5000];
        let want = crate::oracle::grunwald_sum(mu, Seconds(1.0), x.len(), &x);
        let forgotten = run(&short, &x)[4999] - want[4999];
        assert!(forgotten <= bound, "{forgotten} {bound}");
        assert!(forgotten > 0.5 * bound || mu < 0.3, "{forgotten} {bound}");
        // Σ of the first N weights is the bound itself.
        assert!((run(&short, &x)[4999] - bound).abs() < 1e-14);
    }
}

#[test]
fn a_caputo_derivative_does_not_see_the_value_it_starts_from() {
    for scheme in SCHEMES {
        let mut from_zero = Channel::new(build::<f64>(scheme, 0.5));
        let mut from_two = Channel::new(build::<f64>(scheme, 0.5));
        from_two.reset_to(2.0);
        for n in 0..100 {
            let x = 0.25 * f64::from(n); // exact in binary, so both are the same numbers
            assert_eq!(from_two.step(2.0 + x), from_zero.step(x), "{scheme}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn every_operator_is_linear(
        mu in -2.0..2.0_f64,
        scheme in proptest::sample::select(&SCHEMES[..]),
        p in -3.0..3.0_f64,
        noise in proptest::collection::vec(-1.0..1.0_f64, 300),
    ) {
        let operator = build::<f64>(scheme, mu);
        let wave = lively(300);
        let mixed: Vec<f64> = noise.iter().zip(&wave).map(|(a, b)| p * a + b).collect();
        let (a, b, both) = (run(&operator, &noise), run(&operator, &wave), run(&operator, &mixed));
        let scale = largest(&a).max(largest(&b)).max(largest(&both));
        for n in 0..300 {
            prop_assert!((p * a[n] + b[n] - both[n]).abs() <= 1e-11 * scale, "sample {}", n);
        }
    }
}

#[test]
fn a_block_has_the_bits_of_its_samples_one_by_one() {
    fn check<F: Real, O: Differintegrator<F> + Clone>(operator: &O, name: &str) {
        let samples: Vec<F> = lively(400).into_iter().map(F::from_f64).collect();
        let (mut whole, mut single) = (Channel::new(operator), Channel::new(operator.clone()));
        let reference = F::from_f64(0.3);
        for reset in [false, true] {
            if reset {
                whole.reset_to(reference);
                single.reset_to(reference);
            }
            let mut have = samples.clone();
            for block in have.chunks_mut(150) {
                whole.process(block);
            }
            let want: Vec<F> = samples.iter().map(|&x| single.step(x)).collect();
            assert_eq!(have, want, "{name}, reset {reset}");
        }
    }
    for mu in [-1.6, 0.2247, 1.0, 1.4] {
        for scheme in SCHEMES {
            check(&build::<f32>(scheme, mu), scheme);
            check(&build::<f64>(scheme, mu), scheme);
        }
        check(&full::<f32>(Kernel::Grunwald, mu, 1e-6), "full memory");
    }
    let (full, short) = (build::<f64>("full", 0.5), build::<f64>("grunwald:10", 0.5));
    let mut samples = [1.0; 3];
    full.process(&mut short.at_rest(), &mut samples);
    assert!(samples.iter().all(|y| y.is_nan()), "the history of another");
}

#[test]
fn axes_together_have_the_bits_of_axes_alone() {
    fn check<F: Real, O: Differintegrator<F>, const D: usize>(operator: &O, name: &str) {
        let signals: [Vec<f64>; D] =
            core::array::from_fn(|axis| lively(400 + 50 * axis).split_off(50 * axis));
        let mut together: [O::History; D] = core::array::from_fn(|_| operator.at_rest());
        let mut alone = together.clone();
        // One axis is ahead of the others in its ring.
        for axis in [&mut together[0], &mut alone[0]] {
            operator.advance(axis, F::ONE);
        }
        for n in 0..400 {
            let x = signals.each_ref().map(|signal| F::from_f64(signal[n]));
            operator.advance_many(together.each_mut(), x);
            for (axis, history) in alone.iter_mut().enumerate() {
                operator.advance(history, x[axis]);
                let (have, want) = (operator.past(&together[axis]), operator.past(history));
                assert_eq!(have, want, "{name}, {D} axes, axis {axis}, sample {n}");
            }
        }
    }
    fn check_all<F: Real, O: Differintegrator<F>>(operator: &O, name: &str) {
        check::<F, O, 1>(operator, name);
        check::<F, O, 2>(operator, name);
        check::<F, O, 3>(operator, name);
        check::<F, O, 7>(operator, name);
    }
    for mu in [-1.6, 0.2247, 1.0, 1.4] {
        for scheme in SCHEMES {
            check_all(&build::<f32>(scheme, mu), scheme);
            check_all(&build::<f64>(scheme, mu), scheme);
        }
        let full = full::<f32>(Kernel::Grunwald, mu, 1e-6);
        check_all(&full, "full memory");
        let short = ShortMemory::<f32, 300>::new(order(mu), SAMPLE_TIME).expect("valid");
        check_all(&short, "short memory");
        let short = ShortMemoryVec::<f64>::new(order(mu), 300, SAMPLE_TIME).expect("valid");
        check_all(&short, "short memory");
    }
}
