//! Plants whose logs have lines that a serial port has spoilt: such rows are named and left out, and the plant is found as without them.
//!
//! `CAMPAIGN_CASES` sets how many.

use fracdiff::Seconds;
use fractional_control::{HeldPlant, Plant, PowerMemory, Rule, SumOfParts};
use haptic_question::plant::keys::PlantForm;
use haptic_question::plant::{PlantFound, PlantQuestion};
use std::fmt::Write as _;
use std::sync::atomic::AtomicBool;
use testkit::Random;

/// The log of a plant of one or two lags, with the lines of what was spoilt, and its poles.
struct Log {
    text: String,
    spoilt: Vec<usize>,
    poles: usize,
    words: String,
}

impl Log {
    fn drawn(number: u64) -> Self {
        let mut random = Random(number + 7_300_000);
        let rows = random.one_of(&[200, 400]);
        let tau = rows as f64 / random.between(12.0, 25.0);
        let taus = match number % 2 {
            0 => vec![tau],
            _ => vec![tau, tau * random.between(0.25, 0.5)],
        };
        let size = random.log_between(0.1, 1e3);
        let noise = size * random.log_between(3e-4, 5e-3);
        let level = size * random.one_of(&[0.0, 5.0]);
        let below: String = taus.iter().map(|tau| format!("({tau}s+1)")).collect();
        let plant: Plant = format!("{size}/({below})").parse().expect("a plant");
        let memory = PowerMemory::new(Rule::Bdf2, 1e-8, rows as f64).expect("a memory");
        let plant = HeldPlant::new(&plant, memory, Seconds(1.0)).expect("runs");
        let mut state = plant.at_rest();
        let (mut inputs, mut outputs) = (vec![0.0; 20], Vec::with_capacity(rows));
        let mut input = 1.0;
        while inputs.len() < rows {
            inputs.push(input);
            if random.chance(0.03) {
                input = random.one_of(&[0.0, 0.4, 1.0]);
            }
        }
        for input in &inputs {
            let white: f64 = (0..12).map(|_| random.between(-0.5, 0.5)).sum();
            outputs.push(level + plant.step(&mut state, *input) + noise * white);
        }
        let count = random.one_of(&[1, 1, 2, 3]);
        let mut spoilt: Vec<usize> = (0..count)
            .map(|n| 25 + (n * rows / 4) + random.between(0.0, rows as f64 / 5.0) as usize)
            .collect();
        for row in &spoilt {
            outputs[*row] = match number % 4 {
                // A cell is empty.
                0 => f64::NAN,
                // A point that was lost.
                1 => 1e3 * outputs[*row] + size,
                // A sign that was lost.
                2 => -(outputs[*row] + size),
                // A count that ran over.
                _ => 65_535.0 * size,
            };
        }
        let mut text = "time_s,input,output\n".to_owned();
        for (row, (input, output)) in inputs.iter().zip(&outputs).enumerate() {
            let cell = if output.is_nan() {
                String::new()
            } else {
                format!("{output:.6e}")
            };
            writeln!(text, "{row},{input},{cell}").expect("a text");
        }
        // The first line is of names.
        spoilt.iter_mut().for_each(|row| *row += 2);
        Self {
            text,
            poles: taus.len(),
            words: format!("{number}: {taus:?} of {size:.3e}, lines {spoilt:?} spoilt"),
            spoilt,
        }
    }

    /// A sentence, if a spoilt row is not named, another is, or the plant is another.
    fn miss(&self) -> Option<String> {
        let question = PlantQuestion::of(&PlantForm::default()).expect("a question");
        let read = question.data(&question.columns, self.text.as_bytes());
        let data = read.unwrap_or_else(|error| panic!("{}: {error}", self.words));
        let found = question.found(data, None, &AtomicBool::new(false), &|_, _, _| {});
        let PlantFound::Record(found) =
            found.unwrap_or_else(|error| panic!("{}: {error}", self.words))
        else {
            panic!("{}: no record", self.words);
        };
        let lines: Vec<String> = self.spoilt.iter().map(ToString::to_string).collect();
        let lines = lines.join(", ");
        let notes = &found.report.warnings;
        let named = notes.iter().any(|note| {
            note.contains(&format!("{lines})")) || note.contains(&format!("line {lines} "))
        });
        let function = found.function();
        let sum: SumOfParts = function.parse().expect("a function");
        let poles = sum.function().denominator().degree().round() as usize;
        (!named || poles != self.poles).then(|| format!("{}: {function}, {notes:?}", self.words))
    }
}

#[test]
#[ignore = "long: `.ci/run` does it, or --include-ignored"]
fn rows_that_a_serial_port_has_spoilt_are_named_and_the_plant_is_found() {
    let count = testkit::cases(4);
    let misses: Vec<String> = (0..count)
        .filter_map(|number| Log::drawn(number).miss())
        .collect();
    println!(
        "{} of {count} are missed\n{}",
        misses.len(),
        misses.join("\n")
    );
    assert!(10 * misses.len() as u64 <= count, "{misses:?}");
}
