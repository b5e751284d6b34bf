//! First guesses of one and of two powers of s, and of plants that do not come to rest, from the shape of a record.

use super::record::InputOutput;
use crate::{FractionalTransferFunction, Term};
use std::vec;
use std::vec::Vec;

/// One and two powers of s, with the gain and the time constant of the record.
pub(super) fn powers(record: &InputOutput) -> Vec<FractionalTransferFunction> {
    let last = |signal: &[f64]| {
        let tail = &signal[signal.len() - (signal.len() / 20).max(1)..];
        tail.iter().sum::<f64>() / tail.len() as f64
    };
    let (input, output) = (last(&record.input), last(&record.output));
    let gain = output / input;
    let t = record.sample_time_s();
    // The time that the output lacks, of one that would follow at once: ∫(1 − y/y∞) for a step.
    let lag: f64 = record
        .input
        .iter()
        .zip(&record.output)
        .map(|(u, y)| (u - y / gain) * t)
        .sum();
    let length = t * record.time_s.len() as f64;
    let usable = gain.is_finite() && gain != 0.0;
    let gain = if usable { gain } else { 1.0 };
    let lag = (lag / input).abs();
    let lag = if lag.is_finite() {
        lag.min(0.5 * length).max(2.0 * t)
    } else {
        0.1 * length
    };
    let one = Term::new(1.0, 0.0);
    let power = |order: f64, share: f64| Term::new(libm::pow(share * lag, order), order);
    let shapes: [Vec<Term>; 3] = [
        vec![power(0.9, 1.0), one],
        vec![power(1.4, 0.7), power(0.7, 0.7), one],
        vec![power(2.0, 0.5), power(1.0, 1.0), one],
    ];
    let functions = shapes
        .iter()
        .map(|below| FractionalTransferFunction::new(&[Term::new(gain, 0.0)], below));
    let mut functions: Vec<_> = functions.filter_map(Result::ok).collect();
    if moves_on(record) {
        functions.extend(growing(record));
    }
    functions
}

/// Parts of a record that are compared with each other.
const PARTS: usize = 10;
/// An output that goes on by more than this share of its largest value in a tenth of the record is not at rest, nor is such an input.
const MOVES: f64 = 0.02;

/// True if the output is still on its way at the end, though the input rests: the plant is slow for this record, or it adds up, or grows.
fn moves_on(record: &InputOutput) -> bool {
    let moves = |signal: &[f64]| {
        let largest = signal.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let tenth = (signal.len() / PARTS).max(1);
        let end = signal.last().zip(signal.iter().rev().nth(tenth));
        end.is_some_and(|(last, before)| (last - before).abs() > MOVES * largest)
    };
    moves(&record.output) && !moves(&record.input)
}

/// First guesses of plants that do not come to rest: y ≈ k·∫u, the same behind a lag, and a pole that grows as the end of the record does.
fn growing(record: &InputOutput) -> Vec<FractionalTransferFunction> {
    let t = record.sample_time_s();
    let length = t * record.time_s.len() as f64;
    let Some((end, sum)) = record
        .output
        .last()
        .map(|end| (*end, record.input.iter().sum::<f64>() * t))
    else {
        return Vec::new();
    };
    let mut guesses = Vec::new();
    let mut guess = |gain: f64, below: &[Term]| {
        let function = FractionalTransferFunction::new(&[Term::new(gain, 0.0)], below);
        guesses.extend(function.ok());
    };
    let rate = end / sum;
    guess(rate, &[Term::new(1.0, 0.95)]);
    guess(rate, &[Term::new(0.1 * length, 1.95), Term::new(1.0, 0.95)]);
    // e^(rt) grows by e^(rh) from one piece of h to the next.
    let piece = record.output.len() / 4;
    let back = |pieces: usize| record.output.iter().rev().nth(pieces * piece);
    if let (Some(last), Some(middle), Some(first)) = (back(0), back(1), back(2)) {
        let grows = libm::log((last - middle) / (middle - first)) / (piece as f64 * t);
        if grows * length > 0.5 {
            // k·u·(e^(rt) − 1) of a step.
            let gain = grows * end / libm::expm1(grows * length) * length / sum;
            let one = Term::new(-1.0, 0.0);
            guess(gain / grows, &[Term::new(1.0 / grows, 1.0), one]);
            let second = Term::new(0.1 / (grows * grows), 2.0);
            guess(gain / grows, &[second, Term::new(0.9 / grows, 1.0), one]);
        }
    }
    guesses
}
