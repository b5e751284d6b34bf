//! Operators by reference, boxed, as `dyn`, from lists, and histories that start without a bump.

use crate::oracle::{
    SAMPLE_TIME, SCHEMES, assert_close, build, convolve, full, largest, lively, order, run,
};
use fracdiff::full_memory::Kernel;
use fracdiff::portable::{Form, ListError};
use fracdiff::{
    Channel, Differintegrator, Fir, FirHistory, FrequencyResponse, Operator, PortableOperator,
    Real, ShortMemory,
};

#[test]
fn a_reference_and_a_box_are_the_operator_itself() {
    let x = lively(500);
    for mu in [-1.5, 0.2247, 1.0] {
        let operator = full::<f32>(Kernel::Grunwald, mu, 1e-6);
        let want = run(&operator, &x);
        assert_eq!(run(&&operator, &x), want);
        assert_eq!(run(&Box::new(operator.clone()), &x), want);
        type Any =
            Box<dyn Differintegrator<f32, History = fracdiff::FullMemoryHistory<f32, 16, 64>>>;
        let any: Any = Box::new(operator.clone());
        assert_eq!(run(&any, &x), want);
        assert_eq!(any.memory_length(), operator.memory_length());
        let response: &dyn FrequencyResponse = &Box::new(&operator);
        assert_eq!(response.response(0.3), operator.response(0.3));
        // Three axes at once through a reference keep their bits.
        let mut together = [operator.at_rest(), operator.at_rest(), operator.at_rest()];
        for &x in &x {
            let x = [x as f32, -x as f32, 1.0];
            <&_ as Differintegrator<f32>>::advance_many(&&operator, together.each_mut(), x);
        }
        let mut alone = operator.at_rest();
        x.iter()
            .for_each(|&x| operator.advance(&mut alone, x as f32));
        assert_eq!(together[0], alone);
    }
}

#[test]
fn a_list_of_coefficients_is_a_convolution() {
    let x = lively(300);
    let binomial = Fir::<f64, 3>::from_slice(&[1.0, -2.0, 1.0]).expect("finite");
    assert_eq!(run(&binomial, &x), convolve(&[1.0, -2.0, 1.0], &x));
    let weights: Vec<f64> = (0..40).map(|j| 1.0 / f64::from(1 + j * j)).collect();
    let fir = Fir::<f64, 64>::from_slice(&weights).expect("fits");
    let want = convolve(&weights, &x);
    assert_close(&run(&fir, &x), &want, 1e-14 * largest(&want));
    assert_eq!(
        (fir.coefficients(), fir.memory_length()),
        (&weights[..], Some(40))
    );
    // The same taps as a portable operator have the same bits.
    let portable = PortableOperator::<f64, 64, 8, 1>::new(Form::Taps, 0, &weights);
    assert_eq!(run(&portable.expect("fits"), &x), run(&fir, &x));
    assert!((binomial.response(0.01).norm() - 1e-4).abs() < 1e-8);
}

#[test]
fn a_list_that_is_none_is_refused() {
    let refused = Fir::<f32, 2>::from_slice(&[1.0, f32::NAN]).expect_err("no number");
    assert!(matches!(refused, ListError::Value { index: 1, .. }));
    for count in [0, 3] {
        let refused = Fir::<f64, 2>::from_slice(&vec![1.0; count]).expect_err("no room");
        assert_eq!(
            refused.to_string().split(' ').next(),
            Some(&*count.to_string())
        );
    }
    assert!(Fir::<f64, 2>::from_slice(&[f64::INFINITY]).is_err());
}

/// Output for x at a history that has settled there, and what follows.
fn settled<F: Real, O: Differintegrator<F>>(operator: &O, x: f64) -> Option<Vec<f64>> {
    let mut history = operator.settled(F::from_f64(x))?;
    let constant = (0..5000).map(|_| operator.step(&mut history, F::from_f64(x)).to_f64());
    Some(constant.collect())
}

#[test]
fn a_history_that_has_settled_has_no_transient() {
    for scheme in SCHEMES {
        for mu in [0.0, 0.05, 0.2247, 0.9, 1.0, 1.4, 2.0] {
            let operator = build::<f64>(scheme, mu);
            let y = settled(&operator, 0.7).expect("derivatives settle");
            // The largest coefficient is about T^(−μ)·2, so this is rounding.
            let rounding = 1e-13 * 0.7 * SAMPLE_TIME.0.powf(-mu);
            assert_close(&y, &vec![y[0]; 5000], rounding);
            // A constant from rest ends there, where the memory is short enough to see it.
            if let Some(memory) = operator.memory_length() {
                let long = run(&operator, &vec![0.7; 3 * memory]);
                assert!(
                    (long[3 * memory - 1] - y[0]).abs() <= rounding,
                    "{scheme} {mu}"
                );
            }
            // And what comes after is the response to the change alone.
            let from_zero = run(&operator, &lively(300));
            let mut history = operator.settled(0.7).expect("as above");
            let shifted = lively(300)
                .into_iter()
                .map(|x| operator.step(&mut history, 0.7 + x));
            let change: Vec<f64> = shifted.map(|have| have - y[0]).collect();
            assert_close(&change, &from_zero, 100.0 * rounding);
        }
    }
}

#[test]
fn a_full_memory_that_has_settled_gives_exactly_nothing() {
    for mu in [0.05, 0.2247, 0.9, 1.0, 1.4, 2.0] {
        let operator = full::<f32>(Kernel::Grunwald, mu, 1e-6);
        assert_eq!(settled(&operator, 0.7), Some(vec![0.0; 5000]), "{mu}");
    }
}

#[test]
fn a_whole_order_that_has_settled_gives_exactly_nothing() {
    for scheme in SCHEMES.into_iter().filter(|scheme| *scheme != "muir:3") {
        for mu in [1.0, 2.0] {
            let y = settled(&build::<f32>(scheme, mu), 0.7);
            assert_eq!(y, Some(vec![0.0; 5000]), "{scheme} {mu}");
        }
    }
}

#[test]
fn running_sums_do_not_settle_but_at_rest() {
    let operator: Operator<f64> = build("full", -1.5);
    assert_eq!(operator.settled(1.0), None);
    assert_eq!(operator.settled(0.0), Some(operator.at_rest()));
}

#[test]
fn a_channel_goes_on_from_a_history_that_was_kept() {
    let operator = ShortMemory::<f32, 30>::new(order(0.5), SAMPLE_TIME).expect("valid");
    let mut one = Channel::new(&operator);
    one.reset_to(0.25);
    for x in lively(100) {
        one.step(x as f32);
    }
    let (kept, reference) = one.state();
    let kept: FirHistory<f32, 30> = kept.clone();
    let mut other = Channel::new(&operator);
    other.resume(kept, reference);
    for x in lively(50) {
        assert_eq!(one.step(x as f32), other.step(x as f32));
    }
}
