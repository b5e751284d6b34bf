//! Starting points for the fits of a long record: for each number of parameters the function that fits a part of its samples best.

use super::record::{Guess, InputOutput, bic, left, resolved, rounding};
use crate::autoregression::Autoregression;
use crate::largest;
use crate::{DeadTime, Identified, StartState, WholeShape, identify_coefficients, whole_guess};
use fracdiff::Seconds;
use fractional_control::{FractionalTransferFunction, Term};
use rayon::prelude::*;

/// Samples of the part at least; a record of less than twice as many is fitted at once.
const PART: usize = 500;
/// Samples of the part for guesses of whole orders, at least.
const PART_OF_GUESSES: usize = 1000;
/// Factor by which that part is longer, if the first one does not represent the whole record.
const LONGER: usize = 4;
/// Distance from whole samples, in samples, below which a dead time counts as whole.
const WHOLE: f64 = 1e-9;
/// Factor by which the residual of the best guess may be larger on the whole record.
const MORE_OF_GUESSES: f64 = 1.1;
/// Factor by which the residual of the whole record may exceed that of the part.
const MORE: f64 = 2.0;

/// A function to begin from, and the guesses behind it, if it is a fit of the part.
#[derive(Clone, Debug)]
pub(super) struct Begin {
    pub(super) function: FractionalTransferFunction,
    pub(super) dead_time: DeadTime,
    pub(super) numbers: usize,
    of_part: Option<OfPart>,
}

#[derive(Clone, Debug)]
struct OfPart {
    guesses: Vec<(FractionalTransferFunction, DeadTime)>,
    rms_residual: f64,
}

impl Begin {
    fn new(function: FractionalTransferFunction, dead_time: DeadTime) -> Self {
        let (above, below) = (function.numerator().terms(), function.denominator().terms());
        let orders = above.iter().chain(below).filter(|term| term.order > 0.0);
        Self {
            numbers: above.len() + below.len() - 1
                + orders.count()
                + usize::from(dead_time.is_free()),
            function,
            dead_time,
            of_part: None,
        }
    }

    /// Residual of its fit to the part, if it is one.
    pub(super) fn rms_residual(&self) -> Option<f64> {
        self.of_part.as_ref().map(|part| part.rms_residual)
    }

    /// The first guesses again, unless this is one of them.
    pub(super) fn first(&self) -> Vec<Self> {
        let guesses = self.of_part.iter().flat_map(|part| &part.guesses);
        guesses.map(|guess| Self::new(guess.0, guess.1)).collect()
    }

    /// The first guesses again, if the residual of the whole record exceeds that of the part: the part has lost what is fast. Residuals below
    /// `resolved` count as 0.
    pub(super) fn doubted(&self, identified: &Identified, resolved: f64) -> Vec<Self> {
        let expected = self
            .of_part
            .as_ref()
            .map_or(f64::INFINITY, |part| MORE * part.rms_residual.max(resolved));
        if identified.rms_residual > expected {
            return self.first();
        }
        Vec::new()
    }
}

/// Starting points for functions of free orders with fewer than `most` numbers, those with few numbers first. Such functions run for
/// long, so for a long record they are fitted to a part, and for each number of numbers only the best continues.
pub(super) fn starts(
    record: &InputOutput,
    guesses: &[Guess],
    held: bool,
    most: usize,
) -> Vec<Begin> {
    let orders = guesses.iter().filter(|guess| guess.has_free_orders);
    let orders = orders.map(|guess| Begin::new(guess.function, guess.dead_time));
    let mut starts: Vec<Begin> = orders.filter(|start| start.numbers < most).collect();
    starts.sort_by_key(|start| start.numbers);
    let Some(part) = stretch(record, held, PART) else {
        return starts;
    };
    let groups = starts.chunk_by(|a, b| a.numbers == b.numbers);
    groups
        .flat_map(|group| of_part(&part, group, held))
        .collect()
}

/// The best fit to the part; the guesses unchanged, if nothing fits.
fn of_part(part: &InputOutput, group: &[Begin], held: bool) -> Vec<Begin> {
    let fitted = group.par_iter().filter_map(|start| {
        crate::identify(&start.function, &part.as_record(held, start.dead_time)).ok()
    });
    let fitted: Vec<Identified> = fitted.collect();
    let least = |a: &Identified, b: &Identified| a.rms_residual.total_cmp(&b.rms_residual);
    let Some(best) = fitted.into_iter().min_by(least) else {
        return group.to_vec();
    };
    let of_part = OfPart {
        guesses: (group.iter())
            .map(|start| (start.function, start.dead_time))
            .collect(),
        rms_residual: best.rms_residual,
    };
    vec![Begin {
        of_part: Some(of_part),
        ..Begin::new(best.function, best.dead_time)
    }]
}

/// A first guess of whole orders.
#[derive(Clone, Debug)]
pub(super) struct OfShape {
    pub(super) shape: WholeShape,
    pub(super) guess: Guess,
    /// Criterion for the record that it was made from.
    pub(super) bic: f64,
    rms_residual: f64,
}

/// A guess for each shape up to this many poles, two of them integrators, and each dead time; of a long record from a part of it, unless the whole
/// record shows that the part has lost what is fast. One that answers at once is among them if it may be. With `whitens` all are made again through the
/// filter of what the closest leaves, if that is alike from sample to sample.
pub(super) fn whole_orders(
    record: &InputOutput,
    held: bool,
    dead_times: &[DeadTime],
    may_be_prompt: bool,
    poles: usize,
    whitens: bool,
) -> Vec<OfShape> {
    let least = |a: &&OfShape, b: &&OfShape| a.rms_residual.total_cmp(&b.rms_residual);
    let all = |record: &InputOutput| every_shape(record, held, dead_times, may_be_prompt, poles);
    let again = |record: &InputOutput, found: Vec<OfShape>| {
        let best = found.iter().min_by(least).filter(|_| whitens);
        let noise = best.map_or(Autoregression::WHITE, |best| {
            noise_of(record, held, &best.guess)
        });
        match noise.order() {
            0 => found,
            _ => all(&InputOutput {
                noise,
                ..record.clone()
            }),
        }
    };
    if let Some(part) = stretch(record, held, PART_OF_GUESSES) {
        let found = all(&part);
        let best = found.iter().min_by(least);
        let whole = best.and_then(|best| {
            whole_guess(&record.as_record(held, best.guess.dead_time), best.shape)
        });
        let holds = best.zip(whole).is_some_and(|(part, whole)| {
            whole.rms_residual <= MORE_OF_GUESSES * part.rms_residual.max(resolved(record))
        });
        if holds {
            return again(&part, found);
        }
        // No function of a part is one of all: more of it, but not all, which would take minutes.
        if let Some(part) = stretch(record, held, LONGER * PART_OF_GUESSES) {
            return again(&part, all(&part));
        }
    }
    again(record, all(record))
}

/// The noise that a fit from this guess leaves, if that is above what a model resolves.
pub(super) fn noise_of(record: &InputOutput, held: bool, guess: &Guess) -> Autoregression {
    let fit = identify_coefficients(&guess.function, &record.as_record(held, guess.dead_time)).ok();
    let noisy = fit.filter(|fit| fit.rms_residual > resolved(record));
    noisy.map_or(Autoregression::WHITE, |fit| {
        Autoregression::of(&[&left(record, &fit.model)])
    })
}

fn shapes(most: usize) -> impl Iterator<Item = WholeShape> {
    let sizes = (1..=most).flat_map(|poles| (0..=poles).map(move |zeros| (poles, zeros)));
    sizes.flat_map(|(poles, zeros)| {
        (0..=poles.min(2)).map(move |integrators| WholeShape {
            poles,
            zeros,
            integrators,
        })
    })
}

/// Guesses for each shape: that of the best dead time, and that without one.
fn every_shape(
    record: &InputOutput,
    held: bool,
    dead_times: &[DeadTime],
    may_be_prompt: bool,
    poles: usize,
) -> Vec<OfShape> {
    let floor = rounding(record);
    let guess_of = |shape: WholeShape, dead_time: DeadTime| {
        let guess = whole_guess(&record.as_record(held, dead_time), shape)?;
        let numbers = shape.poles + shape.zeros + 1 - shape.integrators;
        let start = record
            .start
            .numbers(shape.poles, shape.integrators > 0, false);
        let is_chosen = !matches!(dead_time, DeadTime::Known(_));
        let numbers = (numbers + start + usize::from(is_chosen)) as f64;
        Some(OfShape {
            shape,
            guess: Guess {
                parts: vec![],
                function: guess.function,
                has_free_orders: false,
                dead_time,
            },
            bic: bic(
                record.output.len() as f64,
                guess.rms_residual,
                numbers,
                floor,
            ),
            rms_residual: guess.rms_residual,
        })
    };
    let least = |a: &OfShape, b: &OfShape| a.bic.total_cmp(&b.bic);
    let at_once = at_once(record.sample_time_s(), dead_times);
    let parted = |dead_times: &[DeadTime]| {
        let dead_times = dead_times.iter().copied();
        dead_times
            .partition::<Vec<DeadTime>, _>(|dead_time| !matches!(dead_time, DeadTime::Known(_)))
    };
    let (free, known) = parted(dead_times);
    let (after, with) = parted(&at_once);
    let best = |shape, among: &[DeadTime]| {
        let guesses = among
            .iter()
            .filter_map(|dead_time| guess_of(shape, *dead_time));
        guesses.min_by(least)
    };
    let shapes = shapes(poles).filter(|shape| may_be_prompt || shape.zeros < shape.poles);
    let shapes: Vec<WholeShape> = shapes.collect();
    let guesses = shapes.into_par_iter();
    let guesses = guesses.flat_map_iter(|shape| {
        if shape.zeros < shape.poles {
            [best(shape, &free), best(shape, &known)]
        } else {
            [best(shape, &after), best(shape, &with)]
        }
    });
    guesses.flatten_iter().collect()
}

/// The dead times of a plant that answers at once, whole samples: with the new input of a row, and just before it.
pub(super) fn at_once(t: f64, dead_times: &[DeadTime]) -> Vec<DeadTime> {
    let mut samples = vec![0.0];
    let mut all = vec![DeadTime::NONE];
    for dead_time in dead_times {
        let late = dead_time.seconds() / t;
        match dead_time {
            // One that ends between two rows has one reading.
            DeadTime::Known(known) if known.0 != 0.0 => {
                let is_whole = (late - libm::round(late)).abs() < WHOLE;
                let after = is_whole.then_some(DeadTime::JustAfter(*known));
                return [*dead_time].into_iter().chain(after).collect();
            }
            DeadTime::Known(_) | DeadTime::JustAfter(_) => {}
            DeadTime::From(_) => {
                samples.extend([-1.0, 0.0, 1.0].map(|more| libm::round(late) + more));
            }
        }
    }
    samples.retain(|late| *late >= 0.0);
    samples.sort_by(f64::total_cmp);
    samples.dedup();
    all.extend(
        samples
            .iter()
            .map(|late| DeadTime::JustAfter(Seconds(late * t))),
    );
    all
}

/// Largest value of `lost` for a thinned part, a share of the output's variance.
const LOST: f64 = 0.5;

/// `samples` samples of a long record: every k-th, and of a held input the mean of k, which is the input that acts; or the beginning, if
/// the motion between samples that far apart would be lost, as all of a swing faster than these resolve.
pub(super) fn part(record: &InputOutput, held: bool, samples: usize) -> Option<InputOutput> {
    let k = record.output.len().min(record.input.len()) / samples;
    if k < 2 {
        return None;
    }
    if lost(&record.output, k) > LOST {
        return Some(beginning(record, samples));
    }
    let mean = |block: &[f64]| {
        if held {
            block.iter().sum::<f64>() / k as f64
        } else {
            block[0]
        }
    };
    let every = |signal: &[f64]| signal.chunks_exact(k).map(|block| block[0]).collect();
    Some(InputOutput {
        time_s: every(&record.time_s),
        input: record.input.chunks_exact(k).map(mean).collect(),
        output: every(&record.output),
        ..*record
    })
}

/// Factor on the variance of the beginning above which a stretch moves more.
const MORE_POWER: f64 = 1.1;

/// Part of a record as [`part`] gives it; of a record that moves more later, as a swing that is driven ever harder, the stretch that moves most:
/// the residual there is no smaller than elsewhere. The plant is already moving where it starts.
pub(super) fn stretch(record: &InputOutput, held: bool, samples: usize) -> Option<InputOutput> {
    let first_part = part(record, held, samples)?;
    let power = |output: &[f64]| {
        let mean = output.iter().sum::<f64>() / output.len() as f64;
        output.iter().map(|y| (y - mean) * (y - mean)).sum::<f64>()
    };
    let is_thinned = first_part.sample_time_s() > 1.5 * record.sample_time_s();
    let stretches = record.output.chunks_exact(samples).map(power).enumerate();
    let most = stretches.max_by(|a, b| a.1.total_cmp(&b.1))?;
    if is_thinned || most.1 <= MORE_POWER * power(&first_part.output) {
        return Some(first_part);
    }
    let place = most.0 * samples..(most.0 + 1) * samples;
    Some(InputOutput {
        time_s: record.time_s[place.clone()].to_vec(),
        input: record.input[place.clone()].to_vec(),
        output: record.output[place].to_vec(),
        start: StartState::Moving,
        ..*record
    })
}

/// The most that D moves within k samples, of what it is where they know nothing of each other:
/// ```text
/// max_h |D(h) − D(1)|/(2·variance),   h ≤ k,   D(h) = mean of (y_(n+h) − y_n)²
/// ```
/// White noise adds as much to each D, and takes nothing from a part that it does not take from the record.
fn lost(output: &[f64], k: usize) -> f64 {
    let mean = output.iter().sum::<f64>() / output.len() as f64;
    let squares = output.iter().map(|y| (y - mean) * (y - mean));
    let variance = squares.sum::<f64>() / output.len() as f64;
    let apart = |h: usize| {
        let pairs = output.iter().zip(&output[h..]);
        pairs.map(|(a, b)| (b - a) * (b - a)).sum::<f64>() / (output.len() - h) as f64
    };
    let next = apart(1);
    let moved = (2..=k).map(|h| (apart(h) - next).abs());
    moved.fold(0.0, f64::max) / (2.0 * variance)
}

/// `samples` samples, from where an input that rests at first begins to move.
fn beginning(record: &InputOutput, samples: usize) -> InputOutput {
    let moves = record.changes().next().filter(|_| record.begins_flat());
    let begin = moves.map_or(0, |row| row - 1);
    let some = |signal: &[f64]| signal[begin..].iter().copied().take(samples).collect();
    InputOutput {
        time_s: some(&record.time_s),
        input: some(&record.input),
        output: some(&record.output),
        ..*record
    }
}

/// One and two powers of s, with the gain and the time constant of the record behind so much dead time, s.
pub(super) fn powers(record: &InputOutput, dead_time_s: f64) -> Vec<FractionalTransferFunction> {
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
    let lag = (lag / input - dead_time_s).abs();
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
/// An output that moves by more than this share of its largest value in a tenth of the record is not at rest, nor is such an input.
const MOVES: f64 = 0.02;

/// True if the output is still on its way at the end, though the input rests: the plant is slow for this record, or it adds up, or grows.
fn moves_on(record: &InputOutput) -> bool {
    let moves = |signal: &[f64]| {
        let tenth = (signal.len() / PARTS).max(1);
        let end = signal.last().zip(signal.iter().rev().nth(tenth));
        end.is_some_and(|(last, before)| (last - before).abs() > MOVES * largest(signal))
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
