//! The second-order kernel: its weights, its error, its order of convergence, and that it gives no energy.

use crate::oracle::{SAMPLE_TIME, assert_close, largest, lively, order, run};
use core::f64::consts::PI;
use fracdiff::full_memory::{Design, Kernel};
use fracdiff::{
    BDF2_TAPS, Bdf2Memory, Differintegrator, ExactDifference, FrequencyResponse, FullMemory,
    Operator, OperatorList, Scheme, Seconds, batch::Batch, bdf2_short_filter, grunwald_weights,
    num_complex::Complex,
};

/// Weights of (3/2 − 2w + w²/2)^μ by J. C. P. Miller's recurrence for the power of a polynomial.
fn defining_series(mu: f64, count: usize) -> Vec<f64> {
    let a = [1.5, -2.0, 0.5];
    let mut c = vec![1.5_f64.powf(mu)];
    for n in 1..count {
        let nf = n as f64;
        let sum: f64 = (1..=n.min(2))
            .map(|k| (mu * k as f64 - (nf - k as f64)) * a[k] * c[n - k])
            .sum();
        c.push(sum / (nf * a[0]));
    }
    c
}

fn memory(mu: f64, t: Seconds) -> Bdf2Memory<f64, 16, 64> {
    let design = Design::pruned(Kernel::Grunwald, order(mu), 1e-9, 1e5).expect("reachable");
    Bdf2Memory::new(&design, t).expect("valid")
}

#[test]
fn the_weights_are_those_of_the_defining_series() {
    for mu in [-2.0, -1.3, -0.5, 0.2247, 0.5, 0.9, 1.0, 1.5, 2.0] {
        let want = defining_series(mu, 400);
        let mut impulse = vec![0.0; 400];
        impulse[0] = SAMPLE_TIME.0.powf(mu);
        let have = run(&memory(mu, SAMPLE_TIME), &impulse);
        // ε = 1e-9 of each weight of a difference of the design, a few of them together.
        assert_close(&have, &want, 1e-8 * largest(&want));
        let whole = Batch::full_bdf2(order(mu), SAMPLE_TIME)
            .expect("valid")
            .run(&impulse);
        // The taps left off, and 400 steps of a recurrence.
        assert_close(&whole, &want, 3e-12 * largest(&want));
    }
}

#[test]
fn the_short_filter_leaves_off_a_millionth_of_a_millionth() {
    for mu in [-2.0, -1.0, -0.5, 0.5, 1.0, 1.7, 2.0] {
        // ((3 − w)/2)^μ is 1 at w = 1 and 2^μ at w = −1.
        let filter = bdf2_short_filter(order(mu));
        let sum: f64 = filter.iter().sum();
        let turns = filter.iter().enumerate();
        let alternating: f64 = turns.map(|(j, f)| if j % 2 == 0 { *f } else { -f }).sum();
        assert!((sum - 1.0).abs() < 2e-12, "{mu}: {sum}");
        assert!((alternating / 2f64.powf(mu) - 1.0).abs() < 2e-12, "{mu}");
        // c_j(μ) with the sign of an alternating series: at most 2·1.5^μ − 1 of the bound for 0 ≤ μ ≤ 1.
        let size: f64 = filter.iter().map(|f| f.abs()).sum();
        if (0.0..=1.0).contains(&mu) {
            assert!(size <= 2.0 * 1.5_f64.powf(mu) - 1.0 + 1e-12);
        }
    }
}

#[test]
fn it_gives_no_energy_up_to_order_one() {
    for mu in [0.05, 0.2247, 0.5, 0.9, 1.0] {
        let held: Operator<f64> = "full-bdf2:1e-6"
            .parse::<Scheme>()
            .and_then(|scheme| scheme.build(order(mu), SAMPLE_TIME, 1e5))
            .expect("valid");
        for k in 0..=20_000_u32 {
            let theta = PI * f64::from(k) / 20_000.0;
            // Rounding of 1 − w at the ends.
            let w = Complex::from_polar(1.0, -theta);
            let exact = ExactDifference(order(mu)).response(theta) * ((3.0 - w) * 0.5).powf(mu);
            assert!(exact.re >= -1e-15, "{mu} at {theta}");
            let p = held.response(theta);
            assert!(p.re >= -1e-6 * p.norm(), "{mu} at {theta}: {p}");
        }
    }
}

#[test]
fn it_is_the_full_memory_behind_the_short_filter() {
    let x = lively(3000);
    let (mu, t) = (order(0.4), SAMPLE_TIME);
    let design = Design::<16, 64>::closed_form(Kernel::Grunwald, mu, 1e-8, 1e5).expect("reachable");
    let plain = run(
        &FullMemory::<f64, 16, 64>::new(&design, t).expect("valid"),
        &x,
    );
    let want = crate::oracle::convolve(&bdf2_short_filter(mu), &plain);
    let both = Bdf2Memory::<f64, 16, 64>::new(&design, t).expect("valid");
    assert_close(&run(&both, &x), &want, 1e-13 * largest(&want));
    // S[n] + g·x is the output, and in single precision it is the same to its rounding.
    let mut history = both.at_rest();
    for &x in &x {
        let whole = both.output(&history, x);
        let parts = both.past(&history) + both.direct_gain() * x;
        assert!((whole - parts).abs() < 1e-12 * largest(&want));
        both.advance(&mut history, x);
    }
    let single = Bdf2Memory::<f32, 16, 64>::new(&design, t).expect("valid");
    assert_close(&run(&single, &x), &want, 3e-6 * largest(&want));
    assert_eq!(grunwald_weights(mu).next(), Some(1.0));
}

#[test]
fn from_its_list_it_is_the_same_and_a_list_that_is_none_is_refused() {
    for mu in [-1.4, -0.8, 0.6, 1.0, 1.5] {
        let design = Design::<16, 48>::pruned(Kernel::Grunwald, order(mu), 1e-6, 2e5);
        let made = Bdf2Memory::<f32, 16, 48>::new(&design.expect("reachable"), SAMPLE_TIME);
        let made = made.expect("valid");
        let list = OperatorList::from(&made);
        let again = |values: &[f32], filter: &[f32]| {
            Bdf2Memory::<f32, 16, 48>::from_list(list.integer, values, filter)
        };
        let listed = again(&list.values, &list.filter).expect("a list");
        let mut histories = [made.at_rest(), listed.at_rest()];
        for x in lively(2000) {
            let [want, have] = &mut histories;
            let outputs = [made.step(want, x as f32), listed.step(have, x as f32)];
            assert_eq!(outputs[0].to_bits(), outputs[1].to_bits(), "{mu}");
        }
        let long = [1.0; BDF2_TAPS + 1];
        for filter in [&[][..], &[f32::NAN], &long] {
            assert!(again(&list.values, filter).is_err(), "{filter:?}");
        }
        assert!(again(&[1.0; 15], &list.filter).is_err());
    }
}
