//! Loops and records of plants of fractional order, by the exact response of the plant behind its hold.

use super::fixture::{Draw, bdf2, held};
use crate::fixture::p;
use fracdiff::Seconds;
use fractional_control::autoregression::Autoregression;
use fractional_control::{
    DeadTime, FractionalTransferFunction, InputOutputRecord, Plant, SampledControlLoop, StartState,
    identify,
};
use testkit::assert_close;

const SAMPLES: usize = 2000;

/// A gain around 1/s^α with a dead time, in samples.
#[derive(Clone, Copy, Debug)]
struct Loop {
    order: f64,
    gain: f64,
    delay: f64,
}

impl Loop {
    fn closed(&self, more: f64) -> SampledControlLoop {
        let memory = bdf2(1e-8, 1e4);
        let plant = format!("exp(-{}s)/s^{}", self.delay + more, self.order);
        let plant: Plant = plant.parse().expect("a plant");
        let plant = held(&plant, memory, 1.0);
        let proportional = p(self.gain);
        SampledControlLoop::new(proportional.into(), memory, &plant).expect("a loop")
    }

    /// How much larger the end of the run is than its middle, after a kick.
    ///
    /// ```text
    /// y_n = Σ u_k·(s(n − k − d) − s(n − k − 1 − d)),   s(t) = t^α/Γ(1 + α),   u = −Ky
    /// ```
    fn growth(&self, more: f64) -> f64 {
        let scale = libm::tgamma(1.0 + self.order);
        let step = |t: f64| t.max(0.0).powf(self.order) / scale;
        let late = self.delay + more;
        let answers = (0..=SAMPLES).map(|m| step(m as f64 - late) - step(m as f64 - 1.0 - late));
        let answers: Vec<f64> = answers.collect();
        let (mut commands, mut outputs) = (vec![1.0], vec![0.0_f64]);
        for n in 1..SAMPLES {
            let past = commands.iter().zip(answers[1..=n].iter().rev());
            let output: f64 = past.map(|(u, answer)| u * answer).sum();
            outputs.push(output);
            commands.push(-self.gain * output);
        }
        let most = |part: &[f64]| part.iter().fold(0.0, |most: f64, y| most.max(y.abs()));
        most(&outputs[SAMPLES * 4 / 5..]) / most(&outputs[SAMPLES * 2 / 5..SAMPLES * 3 / 5])
    }
}

/// Just below its delay margin a loop decays, just above it grows; the rule that stands for the plant is off by up to a fifth.
#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn the_delay_margin_is_that_of_the_plant_behind_its_hold() {
    let mut draw = Draw(7);
    let (mut tried, mut apart) = (0, 0);
    while tried < 3 {
        let (order, crossover) = (draw.from(1.1, 1.9), draw.scale(0.1, 0.6));
        let case = Loop {
            order,
            gain: crossover.powf(order),
            delay: draw.from(0.0, 2.0),
        };
        let now = case.closed(0.0);
        if !now.verdict().stable || case.growth(0.0) > 1.0 {
            continue;
        }
        tried += 1;
        let first = now.margins().delay_s;
        let later = |more| Ok::<_, ()>(case.closed(more));
        let found = SampledControlLoop::delay_margin(first, &later).expect("runs");
        let found = found.expect("a crossover").value;
        let (below, above) = (case.growth(0.97 * found), case.growth(1.03 * found));
        assert!(
            below < 1.0 && above > 1.0,
            "{case:?} {found}: {below} {above}"
        );
        let by_rule = first.expect("a crossover").value;
        apart += usize::from((by_rule / found - 1.0).abs() > 0.05);
    }
    assert!(apart > 0, "the rule alone is right");
}

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
