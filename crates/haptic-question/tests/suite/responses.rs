//! Frequency responses as a person gives them: a model with brackets, columns that are not there.

use haptic_question::plant::keys::PlantForm;
use haptic_question::plant::{PlantFound, PlantQuestion};
use num_complex::Complex;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::sync::atomic::AtomicBool;
use testkit::Random;

fn question(columns: &str, model: &str) -> PlantQuestion {
    let form = serde_json::json!({"columns": columns, "model": model});
    let form: PlantForm = serde_json::from_value(form).expect("its keys");
    PlantQuestion::of(&form).expect("a form")
}

#[test]
fn a_bracketed_sum_stays_a_sum_whose_numbers_are_determined() {
    let mut random = Random(8_400_000);
    let mut table = "frequency_hz,real,imaginary\n".to_owned();
    for n in 0..61 {
        let frequency = 10_f64.powf(-2.0 + f64::from(n) / 15.0);
        let s = Complex::i() * TAU * frequency;
        let arc = 0.03 / (1.0 + 0.46 * s.powf(0.85));
        let z = 2.0 * (0.02 + 1.0 / (30.0 * s.powf(0.7)) + arc);
        let noise = Complex::new(random.between(-5e-3, 5e-3), random.between(-5e-3, 5e-3));
        let z = z * (1.0 + noise);
        writeln!(table, "{frequency},{},{}", z.re, z.im).expect("text");
    }
    let question = question("", "2(0.02+1/(30s^0.8)+0.02/(1+0.5s^0.9))");
    let data = question.data(&question.columns, table.as_bytes());
    let found = question.found(
        data.expect("a response"),
        None,
        &AtomicBool::new(false),
        &|_, _, _| {},
    );
    let PlantFound::Response(answer) = found.expect("a function") else {
        panic!("a record of time");
    };
    let numbers = &answer.report.numbers;
    let truth = [0.04, 2.0, 0.7, 0.06, 0.46, 0.85];
    assert_eq!(numbers.len(), truth.len(), "{numbers:?}");
    for (number, truth) in std::iter::zip(numbers, truth) {
        let off = (number.value - truth).abs() / truth;
        assert!(number.determined && off < 0.05, "{number:?} for {truth}");
    }
}

#[test]
fn a_column_that_is_not_there_is_named() {
    let question = question("frequency=1,real=5,imaginary=6", "");
    let table = b"0.1,2,-1\n1,1,-0.5\n10,0.5,-0.1\n";
    let refused = question
        .data(&question.columns, table)
        .expect_err("two columns");
    assert!(refused.contains("no column 5"), "{refused}");
}
