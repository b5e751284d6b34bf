//! Transfer functions sample by sample, against numerical inversion of the Laplace transform.

use crate::fixture::{Golden, bdf2, of_impulse_response, podlubny, randoms};
use core::f64::consts::PI;
use fracdiff::{Differintegrator, FrequencyResponse, Seconds};
use fractional_control::{
    FractionalTransferFunction, PowerMemory, Rule, SampledTransferFunction, StateSpace,
    impulse_response, num_complex::Complex, step_response,
};
use nalgebra::{DMatrix, DVector, RowDVector};
use testkit::{Tested, assert_close};

fn memory(rule: Rule, tolerance: f64) -> PowerMemory {
    PowerMemory::new(rule, tolerance, 12.0)
        .expect("valid")
        .fewest_modes()
}

/// Largest error at the golden times, over the largest of their values.
fn error(golden: &Golden, rule: Rule, t: f64, tolerance: f64) -> f64 {
    let last = golden.points.last().expect("points").0;
    let samples = (last / t).round() as usize + 1;
    let memory = memory(rule, tolerance);
    let y = step_response(&golden.function, memory, Seconds(t), samples);
    let y = y.unwrap_or_else(|error| panic!("{}: {error}", golden.function));
    let largest = golden.points.iter().map(|p| p.1.abs()).fold(0.0, f64::max);
    let errors = golden.points.iter();
    let errors = errors.map(|&(time, want)| (y[(time / t).round() as usize] - want).abs());
    errors.fold(0.0, f64::max) / largest
}

#[test]
fn podlubnys_plant_and_loop_agree_with_the_inverse_transform() {
    for golden in &podlubny() {
        let error_of = |rule, t| error(golden, rule, t, 1e-9);
        let (first, second) = (error_of(Rule::Grunwald, 1e-3), error_of(Rule::Bdf2, 1e-3));
        assert!(first < 3e-3, "{first}");
        assert!(second < 1e-5, "{second}");
        for (rule, t, want) in [(Rule::Grunwald, 4e-3, 1.0), (Rule::Bdf2, 1e-2, 2.0)] {
            let order = (error_of(rule, t) / error_of(rule, 0.5 * t)).log2();
            assert_close("order", order, want, 0.1);
        }
    }
}

/// The order of convergence: the sample time is halved until it is this one within 0.15. Before, terms of other orders count too.
fn order_near(golden: &Golden, rule: Rule, want: f64) -> f64 {
    let (mut t, mut coarse) = (0.02, error(golden, rule, 0.02, 1e-10));
    loop {
        t *= 0.5;
        let fine = error(golden, rule, t, 1e-10);
        let order = (coarse / fine).log2();
        if (order - want).abs() < 0.15 || t < 1e-3 {
            return order;
        }
        coarse = fine;
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn random_functions_converge_with_orders_one_and_two() {
    let all = randoms();
    assert_eq!(all.len(), 200);
    // All where it is set.
    let is_campaign = std::env::var_os("CAMPAIGN_CASES").is_some();
    let every = if is_campaign { 1 } else { 4 };
    for (rule, want) in [(Rule::Grunwald, 1.0), (Rule::Bdf2, 2.0)] {
        for golden in all.iter().step_by(every) {
            let order = order_near(golden, rule, want);
            assert_close(&golden.function.to_string(), order, want, 0.15);
        }
    }
}

#[test]
fn the_sampled_response_is_that_of_the_impulse_response() {
    let memory = bdf2(1e-9, 100.0);
    for text in [
        "1/(s^1.5+2s+1)",
        "(s^0.5+2)/(0.3s^2.2+s^1.7+1)",
        "(s+3)/(s+1)",
    ] {
        let function: FractionalTransferFunction = text.parse().expect("valid");
        let t = Seconds(0.02);
        let running =
            SampledTransferFunction::<f64, 112>::new(&function, memory, t).expect("valid");
        let mut history = running.at_rest();
        let mut weights = vec![running.step(&mut history, 1.0)];
        weights.extend((0..40_000).map(|_| running.step(&mut history, 0.0)));
        for theta in [0.02, 0.3, 1.0, PI] {
            let want = of_impulse_response(&weights, theta);
            let have = running.response(theta);
            // What is cut off, a power law that oscillates.
            let cut = 2.0 * weights[40_000].abs() / theta;
            assert!(
                (have - want).norm() < 1e-9 + cut,
                "{text} {theta}: {have} {want}"
            );
        }
        // And near rest it is the function itself.
        let omega = 0.05 / t.0;
        let (have, want) = (running.response(0.05), function.response(omega));
        assert!((have - want).norm() < 4e-3 * want.norm(), "{have} {want}");
    }
}

#[test]
fn single_precision_neither_drifts_nor_cancels() -> Tested {
    let memory = bdf2(1e-6, 200.0);
    for text in [
        "1/(0.8s^2.2+0.5s^0.9+1)",
        "1/(s^3+2s^2+2s+1)",
        "(s^0.5+1)/(s^1.5+s+0.5)",
    ] {
        let function: FractionalTransferFunction = text.parse()?;
        let t = Seconds(1e-3);
        let double = SampledTransferFunction::<f64>::new(&function, memory, t)?;
        let single = SampledTransferFunction::<f32>::new(&function, memory, t)?;
        let (mut d, mut s) = (double.at_rest(), single.at_rest());
        let mut worst = 0.0_f64;
        for _ in 0..200_000 {
            let (want, have) = (double.step(&mut d, 1.0), single.step(&mut s, 1.0));
            worst = worst.max((want - f64::from(have)).abs());
        }
        assert!(worst < 2e-5, "{text}: {worst:e}");
    }
    Ok(())
}

#[test]
fn orders_of_one_fraction_share_a_memory_and_agree_with_those_that_do_not() {
    // 1/((s^0.5 + 1)(s^0.5 + 2)) = 1/(s + 3s^0.5 + 2): partial fractions 1/(s^0.5 + 1) − 1/(s^0.5 + 2).
    let memory = memory(Rule::Bdf2, 1e-10);
    let run = |text: &str| {
        let function: FractionalTransferFunction = text.parse().expect("valid");
        step_response(&function, memory, Seconds(1e-2), 1000).expect("valid")
    };
    let [whole, a, b] = ["1/(s+3s^0.5+2)", "1/(s^0.5+1)", "1/(s^0.5+2)"].map(run);
    for n in 0..1000 {
        // ε of the memories.
        assert_close("whole[n]", whole[n], a[n] - b[n], 1e-8);
    }
}

#[test]
fn the_impulse_response_is_the_slope_of_the_step_response() -> Tested {
    let function: FractionalTransferFunction = "1/(s^1.5+s+1)".parse()?;
    let (memory, t) = (memory(Rule::Bdf2, 1e-9), 1e-2);
    let step = step_response(&function, memory, Seconds(t), 501)?;
    let impulse = impulse_response(&function, memory, Seconds(t), 501)?;
    for n in [100, 200, 400] {
        let slope = (step[n + 1] - step[n - 1]) / (2.0 * t);
        // Two formulas of second order.
        assert_close("impulse", impulse[n], slope, 1e-4);
    }
    Ok(())
}

/// λ⁴ = −1 and its like: QR leaves their companion matrices as they are.
#[test]
fn poles_of_cyclic_functions_are_found() {
    let poles = |text: &str| {
        let function: FractionalTransferFunction = text.parse().expect("valid");
        function.commensurate().expect("commensurate").poles()
    };
    for n in 101..=200 {
        // s^a = −1 at the angles ±π/a; with a > 3 no other on the principal branch.
        let a = 0.02 * f64::from(n);
        let found = poles(&format!("1/(s^{a}+1)"));
        let off = |pole: &Complex<f64>| {
            let turn = (pole.arg().abs() - PI / a).abs();
            (pole.norm() - 1.0).abs().max(turn)
        };
        if a > 3.0 && a < 4.0 {
            assert!(
                found.iter().any(|pole| off(pole) <= 1e-10),
                "{a}: {found:?}"
            );
        }
        for pole in found {
            let turns = (pole.arg().abs() * a / PI - 1.0) / 2.0;
            let apart = (turns - turns.round()).abs().max((pole.norm() - 1.0).abs());
            assert!(apart < 1e-10, "{a}: {pole}");
        }
    }
    let double = poles("1/(s^2+1)^2");
    assert_eq!(double.len(), 4);
    let far = double
        .iter()
        .any(|pole| (pole * pole + 1.0).norm() >= 1e-14);
    assert!(!far, "{double:?}");
    // The same as matrices.
    for n in 2..=16_usize {
        let mut a = DMatrix::zeros(n, n);
        a[(0, n - 1)] = -1.0;
        (1..n).for_each(|row| a[(row, row - 1)] = 1.0);
        let (mut b, mut c) = (DVector::zeros(n), RowDVector::zeros(n));
        (b[0], c[n - 1]) = (1.0, 1.0);
        let plant = StateSpace::new(a, b, c).expect("valid");
        let growing = (0..n)
            .filter(|k| (PI * (2 * k + 1) as f64 / n as f64).cos() > 1e-9)
            .count();
        assert!(
            (growing..=growing + 2).contains(&plant.unstable_poles()),
            "{n}"
        );
    }
}

#[test]
fn poles_and_stability_of_commensurate_functions() {
    let parsed = |text: &str| -> FractionalTransferFunction { text.parse().expect("valid") };
    for (text, stable) in [
        ("1/(s+1)", true),
        ("1/(s-1)", false),
        ("1/(s+0.4s^0.5+1)", true),
        // λ² − 2cos(φ)·λ + 1, roots at ±φ: stable for φ > π/4.
        ("1/(s-1.4s^0.5+1)", true),
        ("1/(s-1.42s^0.5+1)", false),
        ("1/(0.8s^2.2+0.5s^0.9+1)", true),
        ("1/(s^3+s^2+s+0.99)", true),
        ("1/(s^3+s^2+s+1.01)", false),
        ("1/(s^0.5-1)", false),
    ] {
        let function = parsed(text);
        let commensurate = function.commensurate().expect("commensurate");
        let decays = commensurate.poles().iter().all(|pole| pole.re < 0.0);
        assert_eq!(decays, stable, "{text}");
        // Both criteria, by roots and by the turn of the denominator, agree.
        assert_eq!(function.unstable_poles() == Some(0), stable, "{text}");
        for pole in commensurate.poles() {
            let residue = function.denominator().at(pole).norm();
            assert!(residue < 1e-6, "{text}: {pole} {residue:e}");
        }
        assert_eq!(function.stable_by_itself().is_ok(), stable, "{text}");
    }
    let poles = parsed("1/(s^1.5-2)")
        .commensurate()
        .expect("commensurate")
        .poles();
    let wanted = 2f64.powf(2.0 / 3.0);
    assert!(
        poles.iter().any(|s| (s - wanted).norm() < 1e-12),
        "{poles:?}"
    );
    let irrational = parsed("1/(s^1.4142135623+s^0.577215664+1)").commensurate();
    assert!(irrational.unwrap_err().to_string().contains("above 200"));
    // An integrator neither decays nor grows: on the edge.
    assert_eq!(parsed("1/(s^1.5+s)").unstable_poles(), None);
}
