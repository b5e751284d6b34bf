//! Functions found again from records of them.

use crate::fixture::{Draw, bdf2, near};
use control_identification::autoregression::Autoregression;
use control_identification::{
    DeadTime, InputOutputRecord, StartState, WholeShape, identify, identify_coefficients,
    whole_guess,
};
use fracdiff::Seconds;
use fractional_control::{FractionalTransferFunction, respond, step_response};
use testkit::{assert_close, assert_refused, assert_relative};

fn function(text: &str) -> FractionalTransferFunction {
    text.parse().expect("valid")
}

/// Numbers of mean 0 and standard deviation 1, the same in every run: sums of twelve evenly spread ones.
fn noise(samples: usize) -> Vec<f64> {
    let mut draw = Draw(7);
    let mut one = || (0..12).map(|_| draw.from(0.0, 1.0)).sum::<f64>() - 6.0;
    (0..samples).map(|_| one()).collect()
}

/// A unit step.
const STEP: &[f64] = &[1.0; 1000];

/// A record without dead time.
fn record<'a>(t: f64, input: &'a [f64], output: &'a [f64]) -> InputOutputRecord<'a> {
    InputOutputRecord {
        sample_time: Seconds(t),
        time_s: &[],
        input,
        output,
        held: true,
        dead_time: DeadTime::NONE,
        start: StartState::Rest,
        noise: Autoregression::WHITE,
    }
}

/// A unit step and what came of it.
fn step_of(t: f64, output: &[f64]) -> InputOutputRecord<'_> {
    record(t, &STEP[..output.len()], output)
}

/// Gain and time constant of k/(τs + 1).
fn lag(found: &FractionalTransferFunction) -> (f64, f64) {
    let (above, below) = (found.numerator(), found.denominator());
    (above.terms()[0].coefficient, below.terms()[0].coefficient)
}

#[test]
fn podlubnys_plant_is_found_from_its_step() {
    let memory = bdf2(1e-9, 40.0);
    // Sampled ten times finer than it is fitted.
    let fine = step_response(
        &function("1/(0.8s^2.2+0.5s^0.9+1)"),
        memory,
        Seconds(0.005),
        6001,
    )
    .expect("runs");
    let y: Vec<f64> = fine.iter().step_by(10).copied().collect();
    let found = identify(&function("2/(s^2+s+1)"), &step_of(0.05, &y)).expect("found");
    let terms = found.function.denominator().terms();
    // The kernel's own error at 50 ms.
    for (have, want) in [
        (terms[0].coefficient, 0.8),
        (terms[0].order, 2.2),
        (terms[1].coefficient, 0.5),
        (terms[1].order, 0.9),
        (found.function.numerator().terms()[0].coefficient, 1.0),
    ] {
        assert_relative("number", have, want, 0.01);
    }
}

#[test]
fn noise_is_answered_with_errors_that_cover_the_truth() {
    let (t, truth) = (Seconds(0.05), function("1.5/(0.7s^1.4+1)"));
    let memory = bdf2(1e-8, 40.0);
    let input: Vec<f64> = (0..600)
        .map(|n| (f64::from(n) * 0.05).sin() + (f64::from(n) * 0.02).cos() - 1.0)
        .collect();
    let mut y = respond(&truth, memory, t, &input).expect("runs");
    let pairs = y.iter_mut().zip(noise(600));
    pairs.for_each(|(y, noise)| *y += 0.02 * noise);
    let record = InputOutputRecord {
        held: false,
        ..record(t.0, &input, &y)
    };
    let found = identify(&function("1/(s+1)"), &record).expect("found");
    assert_close("residual", found.rms_residual, 0.02, 0.002);
    let want = [1.5_f64.ln(), 0.7_f64.ln(), 1.4];
    let below = found.function.denominator().terms();
    let have = [
        found.function.numerator().terms()[0].coefficient.ln(),
        below[0].coefficient.ln(),
        below[0].order,
    ];
    for ((have, want), (number, error)) in have.iter().zip(want).zip(&found.standard_errors) {
        assert_close(&format!("{number:?}"), *have, want, 4.0 * error);
        assert!(*error < 0.05, "{number:?}");
    }
}

#[test]
fn a_record_that_is_none_is_refused() {
    let guess = function("1/(s+1)");
    let refused = |input: &[f64], output: &[f64]| {
        let found = identify(&guess, &record(0.1, input, output));
        found.expect_err("refused").to_string()
    };
    assert!(refused(&[1.0; 20], &[1.0; 19]).starts_with("samples of the output 19 is not as many"));
    assert!(refused(&[1.0; 3], &[1.0; 3]).contains("more than twice"));
    let nothing = refused(&[1.0; 20], &[0.0; 20]);
    assert!(nothing.starts_with("largest output of the record 0 is not above 0"));
    assert!(refused(&[1.0; 20], &[f64::NAN; 20]).contains("NaN is not finite"));
    // Pure noise of an input that does nothing.
    assert!(refused(&[0.0; 400], &noise(400)).contains("was not found"));
}

/// The step of b/(s² − 2rs + r² + w²), b = r² + w².
fn swing(rate: f64, omega: f64) -> impl Fn(f64) -> f64 {
    move |t| 1.0 - f64::exp(rate * t) * ((omega * t).cos() - rate / omega * (omega * t).sin())
}

/// Closed forms of steps, from 3 samples a turn to 1000, growing, decaying, neither; a pole of two samples and one of half of one.
#[test]
fn whole_orders_are_found_whether_they_swing_grow_or_are_fast() {
    type Step = Box<dyn Fn(f64) -> f64>;
    let fall = |rate: f64| -> Step { Box::new(move |t| -f64::exp_m1(-rate * t)) };
    let turn = |rate, omega| -> Step { Box::new(swing(rate, omega)) };
    // Growing; growing fast; swinging long, also of few samples a turn; calm; two samples; half of one; growing alone; slow.
    let cases: [(Step, f64, &[f64]); 9] = [
        (turn(0.2, 3.0), 0.02, &[1.0, -0.4, 9.04]),
        (turn(2.0, 3.0), 0.01, &[1.0, -4.0, 13.0]),
        (turn(-0.01, 3.0), 0.05, &[1.0, 0.02, 9.0001]),
        (turn(-0.01, 3.0), 0.7, &[1.0, 0.02, 9.0001]),
        (turn(-1.0, 1.0), 0.01, &[1.0, 2.0, 2.0]),
        (fall(50.0), 0.01, &[1.0, 50.0]),
        (fall(200.0), 0.01, &[1.0, 200.0]),
        (Box::new(|t| f64::exp_m1(10.0 * t)), 0.002, &[1.0, -10.0]),
        (fall(0.02), 0.01, &[1.0, 0.02]),
    ];
    for (step, t, below) in cases {
        let y: Vec<f64> = (0..1000).map(|n| step(f64::from(n) * t)).collect();
        let record = step_of(t, &y);
        let guess = whole_guess(&record, poles(below.len() - 1)).expect("a guess");
        let found = identify_coefficients(&guess.function, &record).expect("found");
        let terms = found.function.denominator().terms();
        for (term, want) in terms.iter().zip(below) {
            let have = term.coefficient / terms[0].coefficient;
            assert_relative(&found.function.to_string(), have, *want, 1e-5);
        }
        assert_eq!(terms.len(), below.len(), "{}", found.function);
    }
}

fn poles(poles: usize) -> WholeShape {
    WholeShape {
        poles,
        zeros: 0,
        integrators: 0,
    }
}

/// A ramp in straight lines: 2/(3s + 1) answers with 2(t − 3(1 − e^(−t/3))), exactly.
#[test]
fn a_smooth_input_runs_in_straight_lines() {
    let time = || (0..300).map(|n| 0.1 * f64::from(n));
    let input: Vec<f64> = time().collect();
    let y: Vec<f64> = time()
        .map(|t| 2.0 * (t + 3.0 * f64::exp_m1(-t / 3.0)))
        .collect();
    let record = InputOutputRecord {
        held: false,
        ..record(0.1, &input, &y)
    };
    let found = identify_coefficients(&function("1/(s+1)"), &record).expect("found");
    let (gain, pole) = lag(&found.function);
    assert!(
        near(pole, 3.0, 1e-9) && near(gain, 2.0, 1e-9),
        "{}",
        found.function
    );
}

/// 2/(3s + 1) behind a quarter and three quarters of a sample: the command steps and steps back inside a sample. The rule of free orders is of second
/// order in T there, where straight lines between samples would be of the first.
#[test]
fn an_input_that_is_late_by_a_part_of_a_sample_is_run_exactly() {
    let t = 0.1;
    let input: Vec<f64> = (0..300).map(|n| if n < 100 { 1.0 } else { 0.0 }).collect();
    for share in [0.25, 0.75] {
        let late = share * t;
        let step = |since: f64| -2.0 * f64::exp_m1(-since.max(0.0) / 3.0);
        let y: Vec<f64> = (0..300)
            .map(|n| f64::from(n) * t - late)
            .map(|time| step(time) - step(time - 100.0 * t))
            .collect();
        let record = InputOutputRecord {
            dead_time: DeadTime::Known(Seconds(late)),
            ..record(t, &input, &y)
        };
        let found = identify_coefficients(&function("1/(s+1)"), &record).expect("found");
        let (gain, pole) = lag(&found.function);
        assert!(
            near(pole, 3.0, 1e-9) && near(gain, 2.0, 1e-9),
            "{pole} {gain}"
        );
        let ruled = identify(&function("1/(s^0.9+1)"), &record).expect("found");
        let (gain, pole) = lag(&ruled.function);
        assert!(
            near(pole, 3.0, 0.01) && near(gain, 2.0, 2e-3),
            "{pole} {gain}"
        );
        let guess = whole_guess(&record, poles(1)).expect("a guess");
        assert_close("guess", lag(&guess.function).1, 3.0, 1e-3);
    }
    let outside = InputOutputRecord {
        dead_time: DeadTime::Known(Seconds(30.0)),
        ..record(t, &input, &input)
    };
    assert_refused(identify(&function("1/(s+1)"), &outside), "dead time 30 s");
}
