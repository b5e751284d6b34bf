//! First guesses of whole orders: poles by linear least squares, zeros by linear least squares after them.

use super::record::{InputOutputRecord, StartState, now};
use crate::autoregression::Autoregression;
use fracdiff::{Seconds, roots};
use fractional_control::{FractionalTransferFunction, StateSpace, Term};
use nalgebra::{DMatrix, DVector, RowDVector};
use num_complex::Complex;
use std::borrow::Cow;

/// Poles, zeros and integrators of a function of whole orders: at most 4, no more than the poles, and among the poles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WholeShape {
    /// Poles, those at s = 0 included.
    pub poles: usize,
    /// Zeros, at most the number of poles; a plant with that number answers at once.
    pub zeros: usize,
    /// Poles at s = 0.
    pub integrators: usize,
}

/// A first guess, and the residual that it leaves.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct WholeGuess {
    /// The function, a start for a search.
    pub function: FractionalTransferFunction,
    /// Root mean square of the residual, filtered as its noise asks for, in the unit of y.
    pub rms_residual: f64,
}

/// Factor from one filter's rate to the next.
const FASTER: f64 = 4.0;
/// Times the filter is replaced by the poles that were found with it.
const ROUNDS: usize = 4;
/// Poles that leave as much as those before them, but for this share, are the last of their row.
const SETTLED: f64 = 1e-3;

/// A function of whole orders that comes near a record, for [`identify_coefficients`](super::identify_coefficients) to begin from; `None`
/// where the record gives none.
/// ```text
/// A(s)·y/F(s) = B(s)·u/F(s):   linear in the coefficients of A and B, for any filter 1/F;   F = (s + λ)^n, then F = A, four times
/// ```
/// Several λ are tried, from the length of the record to its samples, and the poles of the samples themselves; the guess is what leaves
/// least when it is run. So poles that swing long, grow, or are as fast as the samples are found. Where the plant began is linear too: C(s)/F of its
/// states, and A(0)c/(sF) of an offset.
///
/// - *Cost*: some ten passes over the record. *Source*: of the rounds, K. Steiglitz and L. E. `McBride`, *A technique for the identification of
///   linear systems*, IEEE Trans. Automatic Control 10(4), 1965; of filters in continuous time, P. C. Young, *Recursive estimation and
///   time-series analysis*, 2011.
#[must_use]
pub fn whole_guess(record: &InputOutputRecord<'_>, shape: WholeShape) -> Option<WholeGuess> {
    let record = acts(record, shape)?;
    let t = record.sample_time.0;
    let mut best: Option<Guess> = None;
    let mut rate = 2.0 / (record.input.len() as f64 * t);
    while rate * t < 0.5 {
        let filter = binomial(shape.poles);
        tried(&record, shape, rate, filter, &mut best);
        rate *= FASTER;
    }
    if let Some(poles) = of_samples(&record, shape) {
        tried(&record, shape, 1.0 / t, poles, &mut best);
    }
    best?.whole(&record)
}

/// Guess like that of `whole_guess`, but only through the poles of `last`, a guess of the same shape for this record a little earlier or later.
pub(crate) fn next_guess(
    record: &InputOutputRecord<'_>,
    shape: WholeShape,
    last: &WholeGuess,
) -> Option<WholeGuess> {
    let record = acts(record, shape)?;
    let rate = 1.0 / record.sample_time.0;
    let below = last.function.denominator();
    let leading = below.terms().first()?;
    let mut poles = vec![0.0; shape.poles + 1];
    for term in below.terms() {
        let power = libm::pow(rate, term.order - leading.order);
        *poles.get_mut(term.order as usize)? = term.coefficient / leading.coefficient * power;
    }
    let mut best = None;
    tried(&record, shape, rate, poles, &mut best);
    best?.whole(&record)
}

/// A record and its input as it acts.
struct Acting<'a> {
    sample_time: Seconds,
    input: Cow<'a, [f64]>,
    /// The part of a sample by which that is later still.
    part: f64,
    output: &'a [f64],
    held: bool,
    start: StartState,
    noise: Autoregression,
}

impl Acting<'_> {
    /// Least squares of columns and of what is wanted, both filtered: what was found, and the squares that are left.
    fn solved(
        &self,
        mut columns: DMatrix<f64>,
        mut wanted: DVector<f64>,
    ) -> Option<(DVector<f64>, f64)> {
        if self.noise.order() > 0 {
            let white = |column: &[f64]| DVector::from_vec(self.noise.whitened(column));
            wanted = white(wanted.as_slice());
            for k in 0..columns.ncols() {
                let column = white(columns.column(k).into_owned().as_slice());
                columns.set_column(k, &column);
            }
        }
        let found = solved(columns.clone(), wanted.clone())?;
        let left = (columns * &found - wanted).norm_squared();
        Some((found, left))
    }
}

/// `None` of a record that is too short for the shape, or of no such shape.
fn acts<'a>(record: &'a InputOutputRecord<'_>, shape: WholeShape) -> Option<Acting<'a>> {
    let WholeShape {
        poles,
        zeros,
        integrators,
    } = shape;
    let samples = record.output.len();
    let fits = (1..=4).contains(&poles) && zeros <= poles && integrators <= poles;
    if !fits
        || samples < 4 * (poles + zeros + 1 + record.start.numbers(poles, integrators > 0, false))
        || samples != record.input.len()
    {
        return None;
    }
    let (input, part) = record.acting(record.late());
    Some(Acting {
        sample_time: record.sample_time,
        input,
        part,
        output: record.output,
        held: record.held,
        start: record.start,
        noise: record.noise,
    })
}

/// A function in units of time 1/rate, coefficients of s⁰ first; that of the highest power below is 1.
struct Guess {
    rate: f64,
    below: Vec<f64>,
    above: Vec<f64>,
    /// Σ of squares that it leaves.
    left: f64,
}

impl Guess {
    fn whole(&self, record: &Acting<'_>) -> Option<WholeGuess> {
        Some(WholeGuess {
            function: self.function()?,
            rms_residual: libm::sqrt(self.left / record.output.len() as f64),
        })
    }

    fn function(&self) -> Option<FractionalTransferFunction> {
        let lowest = self.below.iter().position(|a| *a != 0.0)?;
        let unit = self.below[lowest].abs() * libm::pow(self.rate, -(lowest as f64));
        let terms = |coefficients: &[f64]| -> Vec<Term> {
            let terms = coefficients.iter().enumerate().filter(|(_, c)| **c != 0.0);
            terms
                .map(|(k, c)| Term::new(c * libm::pow(self.rate, -(k as f64)) / unit, k as f64))
                .collect()
        };
        FractionalTransferFunction::new(&terms(&self.above), &terms(&self.below)).ok()
    }
}

/// (s + 1)^n.
fn binomial(n: usize) -> Vec<f64> {
    let mut row = vec![1.0];
    for _ in 0..n {
        let shifted = core::iter::once(&0.0).chain(&row);
        let kept = row.iter().chain(core::iter::once(&0.0));
        row = shifted.zip(kept).map(|(a, b)| a + b).collect();
    }
    row
}

/// Replaces the poles by those that are found through them, and keeps what leaves least.
fn tried(
    record: &Acting<'_>,
    shape: WholeShape,
    rate: f64,
    mut below: Vec<f64>,
    best: &mut Option<Guess>,
) {
    let t = rate * record.sample_time.0;
    let mut last = f64::INFINITY;
    for round in 0..=ROUNDS {
        let Some(input) = filtered(&below, t, &record.input, record.part, record.held) else {
            return;
        };
        // The first filter does not count as a guess, unless it comes from the samples.
        let guess = run(record, shape, rate, &below, &input);
        let left = guess.as_ref().map_or(f64::INFINITY, |guess| guess.left);
        if let Some(guess) = guess
            && best.as_ref().is_none_or(|best| guess.left < best.left)
        {
            *best = Some(guess);
        }
        if round == ROUNDS || (left - last).abs() < SETTLED * last {
            return;
        }
        last = left;
        match regressed(record, shape, t, &below, &input) {
            Some(next) => below = next,
            None => return,
        }
    }
}

/// The zeros for these poles, and the residual.
fn run(
    record: &Acting<'_>,
    shape: WholeShape,
    rate: f64,
    below: &[f64],
    input: &DMatrix<f64>,
) -> Option<Guess> {
    let inputs = input.columns(0, shape.zeros + 1);
    let free = free_motions(record, below, rate * record.sample_time.0, false)?;
    let columns = DMatrix::from_fn(
        input.nrows(),
        shape.zeros + 1 + free.ncols(),
        |row, column| match column.checked_sub(shape.zeros + 1) {
            None => inputs[(row, column)],
            Some(k) => free[(row, k)],
        },
    );
    let output = DVector::from_column_slice(record.output);
    let (above, left) = record.solved(columns, output)?;
    left.is_finite().then(|| Guess {
        rate,
        below: below.to_vec(),
        above: above.iter().take(shape.zeros + 1).copied().collect(),
        left,
    })
}

/// The poles that make A·y/F nearest to B·u/F, from u/F; `t` in the unit of F.
fn regressed(
    record: &Acting<'_>,
    shape: WholeShape,
    t: f64,
    filter: &[f64],
    input: &DMatrix<f64>,
) -> Option<Vec<f64>> {
    let WholeShape {
        poles,
        zeros,
        integrators,
    } = shape;
    let output = filtered(filter, t, record.output, 0.0, false)?;
    let free = poles - integrators;
    // An integrator takes the offset away.
    let begun = free_motions(record, filter, t, true)?;
    let begun = begun.columns(
        0,
        begun.ncols().saturating_sub(usize::from(integrators > 0)),
    );
    let matrix = DMatrix::from_fn(
        record.output.len(),
        free + zeros + 1 + begun.ncols(),
        |row, column| match (
            column.checked_sub(free),
            column.checked_sub(free + zeros + 1),
        ) {
            (_, Some(k)) => begun[(row, k)],
            (Some(k), None) => input[(row, k)],
            (None, None) => -output[(row, integrators + column)],
        },
    );
    let (found, _) = record.solved(matrix, output.column(poles).into_owned())?;
    let mut below = vec![0.0; poles + 1];
    below[integrators..poles].copy_from_slice(&found.as_slice()[..free]);
    below[poles] = 1.0;
    Some(below)
}

/// A real pole of the samples that is less is 0, but for noise: what it stands for rests within a sample. So little of it is left then.
const AT_ONCE: [f64; 2] = [0.1, 1e-13];

/// The poles of y\[k\] + `Σ α_j y[k−j]` = `Σ β_j u[k−j]`, in units of the sample time; `None` if a pole has no continuous counterpart.
fn of_samples(record: &Acting<'_>, shape: WholeShape) -> Option<Vec<f64>> {
    let (n, rows) = (shape.poles, record.output.len() - shape.poles);
    let at_once = usize::from(shape.zeros == n);
    let inputs = 2 * n + at_once;
    let columns = inputs + usize::from(record.start != StartState::Rest);
    let matrix = DMatrix::from_fn(rows, columns, |row, column| match column.checked_sub(n) {
        None => -record.output[row + n - 1 - column],
        Some(_) if column == inputs => 1.0,
        Some(lag) => record.input[row + n - 1 + at_once - lag],
    });
    let found = solved(matrix, DVector::from_column_slice(&record.output[n..]))?;
    // z^n + α₁z^(n−1) + …, of z⁰ first.
    let mut in_z: Vec<f64> = found.iter().take(n).rev().copied().collect();
    in_z.push(1.0);
    let mut below = vec![Complex::new(1.0, 0.0)];
    for z in roots(&in_z) {
        let is_at_once = z.im == 0.0 && z.re.abs() < AT_ONCE[0];
        let z = if is_at_once {
            z.re.abs().max(AT_ONCE[1]).into()
        } else {
            z
        };
        let is_power = z.im != 0.0 || z.re > 0.0;
        let s = is_power.then(|| z.ln())?;
        let zero = Complex::new(0.0, 0.0);
        let shifted = core::iter::once(&zero).chain(&below);
        let kept = below.iter().chain(core::iter::once(&zero));
        below = shifted.zip(kept).map(|(a, b)| a - b * s).collect();
    }
    let mut below: Vec<f64> = below.iter().map(|c| c.re).collect();
    below[..shape.integrators].fill(0.0);
    below.iter().all(|c| c.is_finite()).then_some(below)
}

/// Contribution of a start, one row a sample: s^k/F for k = 0 to n − 1 of its states, and of its offset 1/(sF), or 1 in a run; empty at rest.
fn free_motions(
    record: &Acting<'_>,
    below: &[f64],
    t: f64,
    is_filtered: bool,
) -> Option<DMatrix<f64>> {
    let (samples, states) = (record.output.len(), below.len() - 1);
    let count = match record.start {
        StartState::Rest => return Some(DMatrix::zeros(samples, 0)),
        StartState::Offset => 0,
        StartState::Settled | StartState::Moving => states,
    };
    let ones = vec![1.0; samples];
    let offset = if is_filtered {
        filtered(below, t, &ones, 0.0, true)?.column(0).into_owned()
    } else {
        DVector::from_vec(ones)
    };
    let mut all = DMatrix::zeros(samples, count + 1);
    if count > 0 {
        let mut first = vec![0.0; states];
        first[states - 1] = 1.0;
        filter(below)?
            .run(t, &vec![0.0; samples], 0.0, true, &first, &mut |row, x| {
                (0..count).for_each(|k| all[(row, k)] = x[k]);
            })
            .ok()?;
    }
    // The last integrator runs as an offset does.
    let has_offset = is_filtered || below[0] != 0.0;
    all.set_column(count, &offset);
    let columns = if has_offset { count + 1 } else { count };
    let all = all.columns(0, columns).into_owned();
    all.iter().all(|value| value.is_finite()).then_some(all)
}

/// 1/F in controllable canonical form, whose states are the derivatives of the first.
fn filter(below: &[f64]) -> Option<StateSpace> {
    let n = below.len() - 1;
    let mut a = DMatrix::zeros(n, n);
    for row in 1..n {
        a[(row - 1, row)] = 1.0;
    }
    for (column, coefficient) in below[..n].iter().enumerate() {
        a[(n - 1, column)] = -coefficient;
    }
    let mut b = DVector::zeros(n);
    b[n - 1] = 1.0;
    StateSpace::new(a, b, RowDVector::zeros(n)).ok()
}

/// s^k/F of a signal for k = 0 to n, one row a sample: held between samples, or in straight lines, and `fraction` samples late.
fn filtered(
    below: &[f64],
    t: f64,
    signal: &[f64],
    fraction: f64,
    held: bool,
) -> Option<DMatrix<f64>> {
    let n = below.len() - 1;
    let filter = filter(below)?;
    let mut all = DMatrix::zeros(signal.len(), n + 1);
    // Input of the filter.
    let mut acting = now(signal, fraction, held);
    let ran = filter.run(t, signal, fraction, held, &[], &mut |row, x| {
        let mut highest = acting.next().unwrap_or(0.0);
        for (k, coefficient) in below[..n].iter().enumerate() {
            all[(row, k)] = x[k];
            highest -= coefficient * x[k];
        }
        all[(row, n)] = highest;
    });
    ran.ok()?;
    all.iter().all(|value| value.is_finite()).then_some(all)
}

/// Least squares, the columns brought to one length.
pub(crate) fn solved(mut matrix: DMatrix<f64>, mut wanted: DVector<f64>) -> Option<DVector<f64>> {
    let count = matrix.ncols();
    let mut lengths = Vec::with_capacity(count);
    for mut column in matrix.column_iter_mut() {
        let length = column.norm();
        if length == 0.0 || !length.is_finite() {
            return None;
        }
        column /= length;
        lengths.push(length);
    }
    let qr = matrix.qr();
    qr.q_tr_mul(&mut wanted);
    let mut found = wanted.rows(0, count).into_owned();
    if !qr.unpack_r().solve_upper_triangular_mut(&mut found) {
        return None;
    }
    found
        .iter_mut()
        .zip(lengths)
        .for_each(|(x, length)| *x /= length);
    found.iter().all(|x| x.is_finite()).then_some(found)
}

/// A motion is in those before it if no more than this share of it is left without them.
const WITHIN: f64 = 1e-9;

/// The shares of motions that come nearest to what is wanted, in the sense of least squares; 0 of a motion that those before it can replace.
/// Each is freed of those before it, twice (J. W. Daniel, W. B. Gragg, L. Kaufman, G. W. Stewart, 1976).
pub(crate) fn projected(motions: &[Vec<f64>], mut wanted: Vec<f64>) -> Vec<f64> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let add = |to: &mut [f64], times: f64, from: &[f64]| {
        to.iter_mut()
            .zip(from)
            .for_each(|(to, from)| *to += times * from);
    };
    let mut free: Vec<Vec<f64>> = Vec::with_capacity(motions.len());
    let mut upper = DMatrix::zeros(motions.len(), motions.len());
    for (n, motion) in motions.iter().enumerate() {
        let mut rest = motion.clone();
        for _ in 0..2 {
            for (k, before) in free.iter().enumerate() {
                let share = dot(before, &rest);
                upper[(k, n)] += share;
                add(&mut rest, -share, before);
            }
        }
        let length = libm::sqrt(dot(&rest, &rest));
        let is_new = length > WITHIN * libm::sqrt(dot(motion, motion));
        upper[(n, n)] = if is_new { length } else { f64::INFINITY };
        rest.iter_mut().for_each(|x| *x /= upper[(n, n)]);
        free.push(rest);
    }
    let mut shares: Vec<f64> = Vec::with_capacity(motions.len());
    for before in &free {
        let share = dot(before, &wanted);
        add(&mut wanted, -share, before);
        shares.push(share);
    }
    for n in (0..shares.len()).rev() {
        let known: f64 = (n + 1..shares.len())
            .map(|k| upper[(n, k)] * shares[k])
            .sum();
        shares[n] = (shares[n] - known) / upper[(n, n)];
    }
    shares
}
