//! Bad numbers, histories and parameters: never hidden, refused with value and range.

use crate::oracle::{SAMPLE_TIME, SCHEMES, build, order, run};
use fracdiff::{
    Band, Channel, Differintegrator, MuirPolynomial, Oustaloup, ParameterError, Scheme, Seconds,
    ShortMemory, TustinMuir,
};

#[test]
fn a_nan_is_forgotten_after_n_samples_by_a_finite_memory() {
    let operator = ShortMemory::<f32, 20>::new(order(0.5), SAMPLE_TIME).expect("valid");
    let mut x = vec![1.0; 60];
    x[10] = f64::NAN;
    let y = run(&operator, &x);
    for (n, y) in y.iter().enumerate() {
        assert_eq!(y.is_nan(), (10..30).contains(&n), "sample {n}");
    }
}

#[test]
fn a_nan_or_infinity_is_never_hidden_and_a_reset_forgets_it() {
    for scheme in SCHEMES {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut channel = Channel::new(build::<f32>(scheme, 0.5));
            channel.step(1.0);
            assert!(!channel.step(bad as f32).is_finite(), "{scheme} {bad}");
            assert!(!channel.step(1.0).is_finite(), "{scheme} {bad}");
            channel.reset();
            let fresh = Channel::new(build::<f32>(scheme, 0.5)).step(1.0);
            assert_eq!(channel.step(1.0), fresh, "{scheme} {bad}");
        }
    }
}

#[test]
fn a_recursive_form_stays_spoiled_until_reset() {
    for scheme in ["tustin-muir:9", "oustaloup:9:0.01:100", "full:1e-6"] {
        let mut x = vec![1.0; 3000];
        x[0] = f64::NAN;
        let y = run(&build::<f64>(scheme, 0.5), &x);
        assert!(y.iter().all(|y| y.is_nan()), "{scheme}");
    }
}

#[test]
fn histories_of_another_kind_give_nan_not_a_number() {
    let (short, recursive) = (
        build::<f64>("grunwald:9", 0.5),
        build::<f64>("tustin-muir:9", 0.5),
    );
    let mut history = recursive.at_rest();
    short.advance(&mut history, 1.0);
    assert!(short.output(&history, 1.0).is_nan());
    // The same kind, another length.
    let longer = build::<f64>("grunwald:100", 0.5);
    let mut history = short.at_rest();
    longer.advance(&mut history, 1.0);
    assert!(longer.output(&history, 1.0).is_nan());
}

#[test]
fn bad_parameters_are_refused_with_value_and_range() {
    let message = |mu: f64| fracdiff::Order::new(mu).expect_err("refused").to_string();
    assert_eq!(message(2.5), "order 2.5 is not in [-2, 2]");
    assert_eq!(message(f64::NAN), "order NaN is not in [-2, 2]");
    for t in [0.0, -1e-3, f64::NAN, f64::INFINITY, 1e-10] {
        let error = ShortMemory::<f64, 8>::new(order(0.5), Seconds(t)).expect_err("refused");
        assert!(matches!(error, ParameterError::SampleTime(_)), "{error}");
        assert!(
            error.to_string().contains("is not in [1e-9, 1e6] s"),
            "{error}"
        );
    }
    for (low_hz, high_hz) in [(0.0, 1.0), (2.0, 1.0), (1.0, 500.0), (f64::NAN, 1.0)] {
        let error = Oustaloup::<f64, 8>::new(order(0.5), 4, Band { low_hz, high_hz }, SAMPLE_TIME)
            .expect_err("refused");
        assert!(matches!(error, ParameterError::Band { .. }), "{error}");
    }
    assert!(TustinMuir::<f64, 4>::with_degree(order(0.5), 5, SAMPLE_TIME).is_err());
    let band = Band {
        low_hz: 0.1,
        high_hz: 10.0,
    };
    assert!(Oustaloup::<f64, 8>::new(order(0.5), 9, band, SAMPLE_TIME).is_err());
    assert!(MuirPolynomial::<f64, 4>::with_degree(order(0.5), 0, SAMPLE_TIME).is_err());
}

#[test]
fn schemes_read_back_what_they_print_and_refuse_the_rest() {
    for text in SCHEMES.iter().chain(&["exact", "full:1e-3"]) {
        let scheme: Scheme = text.parse().expect("valid");
        assert_eq!(scheme.to_string().parse(), Ok(scheme));
    }
    assert_eq!("full".parse::<Scheme>(), "full:1e-6".parse());
    for bad in [
        "",
        "full:",
        "full:0",
        "full:1e-3:2",
        "grunwald",
        "grunwald:0",
        "grunwald:x",
        "muir:65",
        "grunwald:99999999999",
        "oustaloup:3:1",
        "tustin-muir:-1",
        "exact:1",
        "gl:10",
    ] {
        let error = bad.parse::<Scheme>().expect_err(bad).to_string();
        assert!(
            error.contains('"') || error.contains("is not in"),
            "{bad}: {error}"
        );
    }
    let exact: Scheme = "exact".parse().expect("valid");
    assert!(exact.build::<f64>(order(0.5), SAMPLE_TIME, 1e3).is_err());
}
