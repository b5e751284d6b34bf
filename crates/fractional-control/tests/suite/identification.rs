//! Functions found again from records of them.

use crate::fixture::states;
use fracdiff::Seconds;
use fractional_control::{
    FractionalTransferFunction, Memory, Plant, Record, Rule, SampledPlant, WholeShape, identify,
    identify_coefficients, respond, step_response, whole_guess,
};

fn of(text: &str) -> FractionalTransferFunction {
    text.parse().expect("valid")
}

/// Numbers of mean 0 and standard deviation 1, the same in every run.
fn noise(samples: usize) -> Vec<f64> {
    let mut state = 7_u64;
    let mut next = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    // The sum of twelve evenly spread numbers.
    (0..samples)
        .map(|_| (0..12).map(|_| next()).sum::<f64>() - 6.0)
        .collect()
}

/// A unit step.
const STEP: &[f64] = &[1.0; 1000];

/// A unit step and what came of it.
fn step_of(t: f64, output: &[f64]) -> Record<'_> {
    Record {
        sample_time: Seconds(t),
        input: &STEP[..output.len()],
        output,
        held: true,
        late: Seconds(0.0),
    }
}

#[test]
fn podlubnys_plant_is_found_from_its_step() {
    let t = Seconds(0.05);
    let memory = Memory::new(Rule::Bdf2, 1e-9, 40.0).expect("valid");
    // Sampled ten times finer than it is fitted.
    let fine =
        step_response(&of("1/(0.8s^2.2+0.5s^0.9+1)"), memory, Seconds(0.005), 6001).expect("runs");
    let y: Vec<f64> = fine.iter().step_by(10).copied().collect();
    let record = Record {
        sample_time: t,
        input: &vec![1.0; y.len()],
        output: &y,
        held: true,
        late: Seconds(0.0),
    };
    let found = identify(&of("2/(s^2+s+1)"), &record).expect("found");
    println!("{} rms {:.1e}", found.function, found.rms_residual);
    let terms = found.function.denominator().terms();
    // The kernel's own error at 50 ms.
    for (have, want) in [
        (terms[0].coefficient, 0.8),
        (terms[0].order, 2.2),
        (terms[1].coefficient, 0.5),
        (terms[1].order, 0.9),
        (found.function.numerator().terms()[0].coefficient, 1.0),
    ] {
        assert!((have / want - 1.0).abs() < 0.01, "{have} {want}");
    }
}

#[test]
fn noise_is_answered_with_errors_that_cover_the_truth() {
    let (t, truth) = (Seconds(0.05), of("1.5/(0.7s^1.4+1)"));
    let memory = Memory::new(Rule::Bdf2, 1e-8, 40.0).expect("valid");
    let input: Vec<f64> = (0..600)
        .map(|n| (f64::from(n) * 0.05).sin() + (f64::from(n) * 0.02).cos() - 1.0)
        .collect();
    let mut y = respond(&truth, memory, t, &input).expect("runs");
    y.iter_mut()
        .zip(noise(600))
        .for_each(|(y, noise)| *y += 0.02 * noise);
    let record = Record {
        sample_time: t,
        input: &input,
        output: &y,
        held: false,
        late: Seconds(0.0),
    };
    let found = identify(&of("1/(s+1)"), &record).expect("found");
    assert!(
        (found.rms_residual - 0.02).abs() < 0.002,
        "{}",
        found.rms_residual
    );
    let want = [1.5_f64.ln(), 0.7_f64.ln(), 1.4];
    let below = found.function.denominator().terms();
    let have = [
        found.function.numerator().terms()[0].coefficient.ln(),
        below[0].coefficient.ln(),
        below[0].order,
    ];
    for ((have, want), (number, error)) in have.iter().zip(want).zip(&found.standard_errors) {
        println!("{number:?}: {have:.4} ± {error:.4}, true {want:.4}");
        assert!(
            (have - want).abs() < 4.0 * error && *error < 0.05,
            "{number:?}"
        );
    }
}

#[test]
fn a_record_of_a_held_command_needs_no_correction_by_hand() {
    let states = states([[-0.5]], [1.5], [1.0]);
    let t = Seconds(0.1);
    let memory = Memory::new(Rule::Bdf2, 1e-8, 40.0).expect("valid");
    let plant = Plant::state_space(states, 0.0).expect("valid");
    let plant = SampledPlant::new(&plant, memory, t).expect("valid");
    let input: Vec<f64> = (0..300)
        .map(|n| if (n / 37) % 2 == 0 { 1.0 } else { -0.5 })
        .collect();
    let mut state = plant.at_rest();
    let y: Vec<f64> = input.iter().map(|u| plant.step(&mut state, *u)).collect();
    let record = Record {
        sample_time: t,
        input: &input,
        output: &y,
        held: true,
        late: Seconds(0.0),
    };
    let found = identify(&of("1/(s^0.8+1)"), &record).expect("found");
    println!("{}", found.function);
    // 1.5/(s + 0.5) = 3/(2s + 1)
    let term = found.function.denominator().terms()[0];
    assert!((term.order - 1.0).abs() < 2e-3 && (term.coefficient - 2.0).abs() < 0.01);
}

#[test]
fn a_record_that_is_none_is_refused() {
    let guess = of("1/(s+1)");
    let refused = |input: &[f64], output: &[f64]| {
        let record = Record {
            sample_time: Seconds(0.1),
            input,
            output,
            held: true,
            late: Seconds(0.0),
        };
        identify(&guess, &record).expect_err("refused").to_string()
    };
    assert!(refused(&[1.0; 20], &[1.0; 19]).starts_with("samples of the output 19 is not as many"));
    assert!(refused(&[1.0; 3], &[1.0; 3]).contains("more than twice"));
    assert!(
        refused(&[1.0; 20], &[0.0; 20])
            .starts_with("largest output of the record 0 is not above 0")
    );
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
    let cases: [(&str, Step, f64, &[f64]); 9] = [
        ("grows", Box::new(swing(0.2, 3.0)), 0.02, &[1.0, -0.4, 9.04]),
        (
            "grows fast",
            Box::new(swing(2.0, 3.0)),
            0.01,
            &[1.0, -4.0, 13.0],
        ),
        (
            "swings long",
            Box::new(swing(-0.01, 3.0)),
            0.05,
            &[1.0, 0.02, 9.0001],
        ),
        (
            "swings long, coarse",
            Box::new(swing(-0.01, 3.0)),
            0.7,
            &[1.0, 0.02, 9.0001],
        ),
        ("calm", Box::new(swing(-1.0, 1.0)), 0.01, &[1.0, 2.0, 2.0]),
        (
            "two samples",
            Box::new(|t| -f64::exp_m1(-50.0 * t)),
            0.01,
            &[1.0, 50.0],
        ),
        (
            "half a sample",
            Box::new(|t| -f64::exp_m1(-200.0 * t)),
            0.01,
            &[1.0, 200.0],
        ),
        (
            "grows alone",
            Box::new(|t| f64::exp_m1(10.0 * t)),
            0.002,
            &[1.0, -10.0],
        ),
        (
            "slow",
            Box::new(|t| -f64::exp_m1(-0.02 * t)),
            0.01,
            &[1.0, 0.02],
        ),
    ];
    for (name, step, t, below) in cases {
        let y: Vec<f64> = (0..1000).map(|n| step(f64::from(n) * t)).collect();
        let record = step_of(t, &y);
        let shape = WholeShape {
            poles: below.len() - 1,
            zeros: 0,
            integrators: 0,
        };
        let guess = whole_guess(&record, shape).expect(name);
        let found = identify_coefficients(&guess.function, &record).expect(name);
        println!("{name}: {} then {}", guess.function, found.function);
        let terms = found.function.denominator().terms();
        for (term, want) in terms.iter().zip(below) {
            let have = term.coefficient / terms[0].coefficient;
            assert!(
                (have - want).abs() < 1e-5 * want.abs(),
                "{name}: {}",
                found.function
            );
        }
        assert_eq!(terms.len(), below.len(), "{name}");
    }
}

/// Noise of a tenth of the step: numbers within four standard errors of the truth, a swing of many turns among them.
#[test]
fn whole_orders_are_found_in_noise() {
    let t = 0.05;
    let step = swing(-0.05, 3.0);
    let y: Vec<f64> = (0..1000)
        .zip(noise(1000))
        .map(|(n, noise)| step(f64::from(n) * t) + 0.1 * noise)
        .collect();
    let record = step_of(t, &y);
    let shape = WholeShape {
        poles: 2,
        zeros: 0,
        integrators: 0,
    };
    let guess = whole_guess(&record, shape).expect("a guess");
    let found = identify_coefficients(&guess.function, &record).expect("found");
    println!(
        "{} then {} {:?}",
        guess.function, found.function, found.standard_errors
    );
    assert!((found.rms_residual - 0.1).abs() < 0.01);
    let b = 9.0025;
    let terms = found.function.denominator().terms();
    let have = [
        found.function.numerator().terms()[0].coefficient,
        terms[0].coefficient,
        terms[1].coefficient,
    ];
    for ((have, want), (_, error)) in have
        .iter()
        .zip([1.0, 1.0 / b, 0.1 / b])
        .zip(&found.standard_errors)
    {
        assert!(
            (have / want - 1.0).abs() < 4.0 * error && *error < 0.05,
            "{have} {want} {error}"
        );
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
    let record = Record {
        sample_time: Seconds(0.1),
        input: &input,
        output: &y,
        held: false,
        late: Seconds(0.0),
    };
    let found = identify_coefficients(&of("1/(s+1)"), &record).expect("found");
    let pole = found.function.denominator().terms()[0].coefficient;
    let gain = found.function.numerator().terms()[0].coefficient;
    assert!(
        (pole - 3.0).abs() < 1e-9 && (gain - 2.0).abs() < 1e-9,
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
        let record = Record {
            sample_time: Seconds(t),
            input: &input,
            output: &y,
            held: true,
            late: Seconds(late),
        };
        let found = identify_coefficients(&of("1/(s+1)"), &record).expect("found");
        let numbers = |found: &FractionalTransferFunction| {
            (
                found.numerator().terms()[0].coefficient,
                found.denominator().terms()[0].coefficient,
            )
        };
        let (gain, pole) = numbers(&found.function);
        assert!(
            (pole - 3.0).abs() < 1e-9 && (gain - 2.0).abs() < 1e-9,
            "{pole} {gain}"
        );
        let ruled = identify(&of("1/(s^0.9+1)"), &record).expect("found");
        let (gain, pole) = numbers(&ruled.function);
        println!("{share}: {}", ruled.function);
        assert!(
            (pole - 3.0).abs() < 0.01 && (gain - 2.0).abs() < 2e-3,
            "{pole} {gain}"
        );
        let shape = WholeShape {
            poles: 1,
            zeros: 0,
            integrators: 0,
        };
        let guess = whole_guess(&record, shape).expect("a guess");
        assert!(
            (numbers(&guess.function).1 - 3.0).abs() < 1e-3,
            "{}",
            guess.function
        );
    }
    let outside = Record {
        sample_time: Seconds(t),
        input: &input,
        output: &input,
        held: true,
        late: Seconds(0.2),
    };
    let said = identify(&of("1/(s+1)"), &outside)
        .expect_err("refused")
        .to_string();
    assert!(said.contains("lateness of the input 0.2 s"), "{said}");
}
