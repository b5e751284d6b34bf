//! First sums of parts for a record: a resistance beside a power of s, beside arcs, or beside both.
//!
//! ```text
//! R + k/s^α,   R + r/(τs^α + 1),   R + r/(τs^α + 1) + k/s^β,   R + r₁/(τ₁s^α + 1) + r₂/(τ₂s^β + 1)
//! ```
//! Batteries, supercapacitors and electrodes are such sums, which functions of whole orders imitate by many poles. Each part is run over a part of the
//! record with one gain, some orders and time constants; the gains follow by least squares, and of each shape the closest begins a fit. They are tried
//! where the best function of whole orders answers at once.

use super::record::{Guess, InputOutput, left};
use super::start::{OfShape, part};
use crate::identify::{answers_at_once, projected, run_alone};
use crate::largest;
use crate::{DeadTime, StartState};
use fracdiff::Seconds;
use fractional_control::{FractionalTransferFunction, Term};

/// Samples that the parts are run over.
const SAMPLES: usize = 300;
/// Orders of an arc and of powers to begin from, and time constants of arcs over the length of the record.
const ARC: f64 = 0.85;
const POWERS: [f64; 2] = [0.5, 0.9];
const TIMES: [f64; 4] = [0.3, 0.08, 0.02, 0.005];

/// A part with one gain, and its output.
struct Run {
    part: FractionalTransferFunction,
    output: Vec<f64>,
}

/// The closest sum of each shape behind a known dead time, if one of the best of whole orders answers at once; read with the new input of a row and just before it.
pub(super) fn sums(
    record: &InputOutput,
    held: bool,
    dead_time: Option<Seconds>,
    best: &[OfShape],
) -> Vec<Guess> {
    let mut best = best.iter();
    if !best.any(|guess| answers_at_once(&guess.guess.function)) {
        return vec![];
    }
    let known = dead_time.unwrap_or(Seconds(0.0));
    let dead_times = [DeadTime::Known(known), DeadTime::JustAfter(known)];
    let part = part(record, held, SAMPLES).unwrap_or_else(|| record.clone());
    let guesses = dead_times.into_iter().flat_map(|dead_time| {
        let shapes = shapes(&part, held, dead_time);
        shapes.into_iter().filter_map(move |parts| {
            Some(Guess {
                function: fractional_control::SumOfParts::new(parts.clone())
                    .ok()?
                    .function(),
                parts,
                has_free_orders: true,
                dead_time,
            })
        })
    });
    let mut guesses: Vec<Guess> = guesses.collect();
    guesses.sort_by_key(Guess::numbers);
    guesses
}

fn shapes(
    record: &InputOutput,
    held: bool,
    dead_time: DeadTime,
) -> Vec<Vec<FractionalTransferFunction>> {
    let one = Term::new(1.0, 0.0);
    let run = |below: &[Term]| {
        let part = FractionalTransferFunction::new(&[one], below).ok()?;
        let alone = crate::InputOutputRecord {
            start: StartState::Rest,
            ..record.as_record(held, dead_time)
        };
        let output = run_alone(&[part], &alone)?;
        Some(Run { part, output })
    };
    let length_s = record.length_s();
    let arc = |share: &f64| {
        let slow = Term::new(libm::pow(share * length_s, ARC), ARC);
        run(&[slow, one])
    };
    let Some(resistance) = run(&[one]) else {
        return vec![];
    };
    let arcs: Vec<Run> = TIMES.iter().filter_map(arc).collect();
    let powers = POWERS.map(|order| run(&[Term::new(1.0, order)]));
    let powers: Vec<Run> = powers.into_iter().flatten().collect();
    let resistance = &resistance;
    let shapes: [Vec<Vec<&Run>>; 4] = [
        powers.iter().map(|power| vec![resistance, power]).collect(),
        arcs.iter().map(|arc| vec![resistance, arc]).collect(),
        arcs.iter()
            .flat_map(|arc| powers.iter().map(move |power| vec![resistance, arc, power]))
            .collect(),
        (0..arcs.len())
            .flat_map(|n| (n + 1..arcs.len()).map(move |k| (n, k)))
            .map(|(n, k)| vec![resistance, &arcs[n], &arcs[k]])
            .collect(),
    ];
    let closest = shapes.iter().filter_map(|shape| {
        let tried = shape.iter().filter_map(|runs| with_gains(runs, record));
        tried.min_by(|a, b| a.0.total_cmp(&b.0))
    });
    closest.map(|(_, parts)| parts).collect()
}

/// Parts with their gains, and the squares that are left. All have the sign of the part that moves most: one that has the other has not its order yet.
fn with_gains(
    runs: &[&Run],
    record: &InputOutput,
) -> Option<(f64, Vec<FractionalTransferFunction>)> {
    let ones = vec![1.0; record.output.len()];
    let mut motions: Vec<Vec<f64>> = runs.iter().map(|run| run.output.clone()).collect();
    motions.extend((record.start != StartState::Rest).then_some(ones));
    let shares = projected(&motions, record.output.clone());
    let mut model = vec![0.0; record.output.len()];
    for (motion, share) in motions.iter().zip(&shares) {
        model
            .iter_mut()
            .zip(motion)
            .for_each(|(sum, y)| *sum += share * y);
    }
    let left: f64 = left(record, &model).iter().map(|x| x * x).sum();
    let moved = runs.iter().zip(&shares);
    let moved = moved.max_by(|a, b| {
        let moves = |(run, share): &(&&Run, &f64)| share.abs() * largest(&run.output);
        moves(a).total_cmp(&moves(b))
    });
    let sign = moved.map_or(1.0, |moved| moved.1.signum());
    let parts = runs.iter().zip(&shares).map(|(run, share)| {
        let gain = Term::new(sign * share.abs(), 0.0);
        FractionalTransferFunction::new(&[gain], run.part.denominator().terms()).ok()
    });
    Some((left, parts.collect::<Option<Vec<_>>>()?))
}
