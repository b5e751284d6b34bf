//! Records of plants whose function is known: a dead time, growth, swings, powers of s, and the example of others.

use crate::fixture::{Draw, bdf2, normal};
use control_identification::autoregression::Autoregression;
use control_identification::{
    DeadTime, InputOutputRecord, StartState, identify, identify_coefficients,
};
use fracdiff::Seconds;
use fractional_control::{FractionalTransferFunction, respond};
use testkit::{assert_close, assert_relative};

/// A held input that jumps at random, and the output by the exact step response: the function is found, whatever the rule makes of so few samples.
#[test]
fn a_record_of_a_plant_gives_its_function() {
    // 1/(s^0.5 + 1): 1 − e^t·erfc(√t);   2/s^0.7: 2t^0.7/Γ(1.7)
    let half: fn(f64) -> f64 = |t| 1.0 - t.exp() * libm::erfc(t.sqrt());
    let power: fn(f64) -> f64 = |t| 2.0 * t.powf(0.7) / libm::tgamma(1.7);
    for (step, truth, guess) in [
        (half, "1/(s^0.5+1)", "1.5/(0.7s^0.8+1)"),
        (power, "2/s^0.7", "1/s^0.9"),
    ] {
        let mut draw = Draw(3);
        let t = 0.05;
        let levels: Vec<f64> = (0..20).map(|_| draw.from(-1.0, 1.0)).collect();
        let input: Vec<f64> = (0..400).map(|n| levels[n / 20]).collect();
        let output = (0..400).map(|n| {
            let jumps = (0..=n).map(|k| input[k] - k.checked_sub(1).map_or(0.0, |k| input[k]));
            let answers = jumps
                .enumerate()
                .map(|(k, jump)| jump * step(t * (n - k) as f64));
            answers.sum()
        });
        let output: Vec<f64> = output.collect();
        let record = InputOutputRecord {
            sample_time: Seconds(t),
            time_s: &[],
            input: &input,
            output: &output,
            held: true,
            dead_time: DeadTime::NONE,
            start: StartState::Rest,
            noise: Autoregression::WHITE,
        };
        let guess: FractionalTransferFunction = guess.parse().expect("valid");
        let truth: FractionalTransferFunction = truth.parse().expect("valid");
        let found = identify(&guess, &record).expect("found");
        let numbers = |function: &FractionalTransferFunction| -> Vec<f64> {
            let (above, below) = (function.numerator(), function.denominator());
            let terms = above.terms().iter().chain(below.terms());
            terms
                .flat_map(|term| [term.coefficient, term.order])
                .collect()
        };
        for (found, true_number) in numbers(&found.function).iter().zip(numbers(&truth)) {
            assert_close("found", *found, true_number, 1e-3);
        }
    }
}

/// The record of the CRONE toolbox' `SID_demo2`, 0.5/(0.5s^3 + 1.5s^1.5 + 1) in steps between 0 and −1 with noise of 0.2: its coefficients come back
/// within four standard errors. The demo prints none.
#[test]
fn the_example_of_the_crone_toolbox_gives_its_coefficients_back() {
    const FINER: usize = 5;
    let function = |text: &str| text.parse::<FractionalTransferFunction>().expect("valid");
    let parts = [(100, 0.0), (200, -1.0), (500, 0.0), (800, -1.0)];
    let input = |each: usize| -> Vec<f64> {
        let levels = parts.iter();
        levels
            .flat_map(|(count, level)| vec![*level; count * each])
            .collect()
    };
    let memory = bdf2(1e-8, 100.0);
    let fine = respond(
        &function("0.5/(0.5s^3+1.5s^1.5+1)"),
        memory,
        Seconds(0.01 / FINER as f64),
        &input(FINER),
    );
    let mut random = testkit::Random(35);
    let mut noise = || normal(&mut random);
    let output = fine.expect("runs").into_iter().step_by(FINER);
    let output: Vec<f64> = output.map(|y| y + 0.2 * noise()).collect();
    let record = InputOutputRecord {
        sample_time: Seconds(0.01),
        time_s: &[],
        input: &input(1),
        output: &output,
        held: true,
        dead_time: DeadTime::NONE,
        start: StartState::Rest,
        noise: Autoregression::WHITE,
    };
    let found = identify_coefficients(&function("1/(s^3+s^1.5+1)"), &record).expect("found");
    assert_close("noise", found.rms_residual, 0.2, 0.02);
    let below = found.function.denominator().terms();
    let have = [
        found.function.numerator().terms()[0].coefficient,
        below[0].coefficient,
        below[1].coefficient,
    ];
    for ((have, want), (number, error)) in
        have.iter().zip([0.5, 0.5, 1.5]).zip(&found.standard_errors)
    {
        assert_relative(&format!("{number:?}"), *have, want, 4.0 * error);
        assert!(*error < 0.3, "{number:?} {error}");
    }
}
