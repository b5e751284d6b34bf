//! Records at several temperatures, shifted to one: a master curve.
//! ```text
//! relaxation, creep  f_T(t) = f_T₀(t/a_T)        oscillation  M_T(ω) = M_T₀(ω·a_T)
//! of two neighbours in temperature: s = ln a_T₁ − ln a_T₂ at the least mean square distance of their curves where they overlap
//! Williams, Landel, Ferry  log₁₀ a_T = −C₁·(T − T₀)/(C₂ + T − T₀)        Arrhenius  ln a_T = (E/R)·(1/T − 1/T₀)
//! ```
//! A curve is straight between its points in logarithms; the distance is vertical, from each point to the other curve. Of a sweep the
//! storage modulus, the loss modulus or both decide; each alone is known beside it. Records within 0.1 K are of one temperature.
//! Standard errors are those of the curvature, and the half of what storage and loss modulus disagree by:
//! ```text
//! e² = Σ eᵢ² + max(Σ (dᵢ/2)², (Σ dᵢ/2)²)     over the pairs i on the way to the reference, d = s by storage − s by loss
//! ```
//! `a_T` is 1 at the reference temperature, where it lies between its neighbours in proportion; one that is half a degree or less beyond
//! the ends is that of the end. Intervals of the laws are those of least squares over all `a_T`; that of the lower BIC comes first. Where
//! the better one misses the shifts by more than a tenth of their range, and by more than twice their own errors, they are said to be no
//! result: nearly flat curves lie on each other at any shift. The density's own change with temperature, some per cent, is not corrected
//! for.
//!
//! - *Errors*: fewer than two temperatures, other records than of steps or sweeps, curves that do not overlap.
//! - *Cost*: 400 distances for each pair, three times for a sweep.
//! - *Source*: J. D. Ferry, *Viscoelastic Properties of Polymers*, 1980, chapter 11.

use super::error::IdentifyError;
use super::fit::{Estimate, likelihood, student};
use super::record::{Record, RecordKind};
use super::target::EXACT;
use crate::keys::{MASTER_CURVE, SHIFT_BY};
use fracdiff::parameter::Shown;
use nalgebra::{SMatrix, SVector};
use std::ops::Range;

/// Speed of the tissue at one temperature, relative to the reference.
#[derive(Clone, Debug, PartialEq)]
pub struct Shift {
    /// The temperature that the record was measured at, °C.
    pub temperature_c: f64,
    /// `log₁₀ a_T`, below 0 where the tissue is faster than at the reference.
    pub log10: f64,
    /// Standard error of the distance to the reference temperature.
    pub standard_error: f64,
    /// `log₁₀ a_T` of a sweep by its storage modulus alone, and by its loss modulus alone, where these overlap.
    pub alone: Option<[f64; 2]>,
}

/// Two neighbours in temperature, one shifted onto the other.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlap {
    /// The colder one and the warmer one, °C.
    pub temperatures_c: [f64; 2],
    /// Points of either that lie over the other.
    pub points: usize,
    /// Root of the mean square of their distances, in logarithms.
    pub misfit: f64,
    /// Misfit of storage and loss modulus of a sweep, each at its own shift.
    pub alone: Option<[f64; 2]>,
}

fracdiff::enumerated! {
    /// The modulus of a sweep that decides its shift.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum ShiftBy {
        /// The storage modulus.
        Storage "storage" "the storage modulus",
        /// The loss modulus.
        Loss "loss" "the loss modulus",
        /// Both, which count the same.
        #[default]
        Both "both" "both alike",
    }
}

impl ShiftBy {
    /// Columns of the moduli in use, of a curve with `count` of them.
    const fn moduli(self, count: usize) -> Range<usize> {
        match self {
            Self::Storage => 0..1,
            Self::Loss => 1..2,
            Self::Both => 0..count,
        }
    }
}

/// A law of the shifts.
#[derive(Clone, Debug, PartialEq)]
pub struct ShiftLaw {
    /// Its name in a report: `wlf` or `arrhenius`.
    pub name: &'static str,
    /// C₁ and C₂, or E.
    pub parameters: Vec<Estimate>,
    /// Root mean square of the residual of `log₁₀ a_T`.
    pub rms: f64,
    /// n·ln(S/n) + k·ln n of n shifts other than that of the reference, and k numbers with the noise.
    pub bic: f64,
}

/// Several records shifted along time or frequency until they are one.
#[derive(Clone, Debug, PartialEq)]
pub struct MasterCurve {
    /// All samples, at the reference temperature.
    pub record: Record,
    /// The reference temperature, °C: that of an end, where the one that was asked for is a little beyond it.
    pub reference_c: f64,
    /// One for each temperature, in their order.
    pub shifts: Vec<Shift>,
    /// One for each pair of neighbours.
    pub overlaps: Vec<Overlap>,
    /// False where no law fits the shifts, so that they are no result.
    pub is_lawful: bool,
    /// The better one first. A law needs one temperature more than it has numbers, beside that of the reference.
    pub laws: Vec<ShiftLaw>,
}

/// Shifts that are tried of each pair, over the widths of both curves.
const TRIALS: usize = 400;
/// Points in the overlap, at least.
const OVERLAP: usize = 4;
/// Temperatures closer than this, K, are one.
const ALIKE: f64 = 0.1;
/// A reference temperature closer to an end than this, K, is at the end.
const NEAR_END: f64 = 0.5;
/// Shares of the range of the shifts, and multiples of their errors, by which no law may miss them.
const MISSED: f64 = 0.1;
const ERRORS: f64 = 2.0;
/// Decades that storage and loss modulus may disagree by without a word.
const DISAGREE: f64 = 0.3;
/// R of Arrhenius' law, J/(mol·K).
const GAS_CONSTANT: f64 = 8.314_462_618;
const ZERO_CELSIUS: f64 = 273.15;

/// Shifts records, each with its temperature in °C, to a reference temperature.
///
/// # Errors
/// Fewer than two temperatures, a reference beyond them, records of a motion or of different kinds, curves that do not overlap, a modulus
/// to shift by of records with one.
pub fn master_curve(
    mut records: Vec<(f64, Record)>,
    reference_c: f64,
    by: ShiftBy,
) -> Result<MasterCurve, IdentifyError> {
    records.sort_by(|a, b| a.0.total_cmp(&b.0));
    let levels = levels(&records);
    let reference_c = checked(&records, &levels, reference_c, by)?;
    // A sweep goes the other way: a tissue that is faster shows at high frequencies what it shows at short times.
    let is_sweep = records[0].1.kind == RecordKind::Oscillation;
    let way = if is_sweep { -1.0 } else { 1.0 };
    let pairs = levels.windows(2).map(|pair| Pair::of(pair, by));
    let pairs: Vec<Pair> = pairs.collect::<Result<_, _>>()?;
    let upper = levels.partition_point(|level| level.celsius < reference_c);
    let upper = upper.clamp(1, levels.len() - 1);
    let [before, after] = [levels[upper - 1].celsius, levels[upper].celsius];
    let share = (reference_c - before) / (after - before);
    let nearest = if share < 0.5 { upper - 1 } else { upper };
    // From the reference on: sums over the pairs before each temperature.
    let chain = |shift: &dyn Fn(&Pair) -> f64| -> Vec<f64> {
        let mut sums = vec![0.0];
        sums.extend(pairs.iter().scan(0.0, |sum, pair| {
            *sum -= way * shift(pair);
            Some(*sum)
        }));
        let zero = sums[upper - 1] + share * (sums[upper] - sums[upper - 1]);
        sums.iter().map(|sum| sum - zero).collect()
    };
    let shifts_ln = chain(&|pair| pair.shift);
    let known = pairs.iter().all(|pair| pair.alone.is_some());
    let alone = [0, 1].map(|n| chain(&|pair| pair.alone.map_or(0.0, |alone| alone[n].shift)));
    let log10 = |ln: f64| ln / core::f64::consts::LN_10;
    let found = levels.iter().enumerate().map(|(n, level)| Shift {
        temperature_c: level.celsius,
        log10: log10(shifts_ln[n]),
        standard_error: log10(Pair::error(&pairs[n.min(nearest)..n.max(nearest)])),
        alone: known.then(|| [0, 1].map(|k| log10(alone[k][n]))),
    });
    let found: Vec<Shift> = found.collect();
    let at = levels.iter().zip(&shifts_ln).flat_map(|(level, ln)| {
        let records = records[level.records.clone()].iter();
        records.map(move |(_, record)| (libm::exp(-way * ln), record))
    });
    let mut record = joined(at)?;
    let laws = laws(&found, reference_c);
    let errors = pairs.iter().map(|pair| pair.error * pair.error);
    let missed = missed(&found, &laws, log10(libm::sqrt(errors.sum())));
    record.warnings.extend(disagreement(&found, &pairs, by));
    record.warnings.extend(missed.clone());
    Ok(MasterCurve {
        record,
        reference_c,
        is_lawful: missed.is_none(),
        laws,
        overlaps: pairs.into_iter().map(|pair| pair.overlap).collect(),
        shifts: found,
    })
}

/// Records of one kind as one, each with its factor of time or frequency.
fn joined<'a>(records: impl Iterator<Item = (f64, &'a Record)>) -> Result<Record, IdentifyError> {
    let (mut kind, mut samples) = (RecordKind::Relaxation, Vec::new());
    let mut has_errors = true;
    for (factor, record) in records {
        kind = record.kind;
        for (i, x) in record.x.iter().enumerate() {
            let second = record.second.get(i).copied().unwrap_or_default();
            let error = |n: usize| record.errors.get(n).copied().unwrap_or_default();
            let errors = [error(i), error(record.x.len() + i)];
            has_errors &= !record.errors.is_empty();
            samples.push([x * factor, record.first[i], second, errors[0], errors[1]]);
        }
    }
    samples.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let columns = [0, 1, 2, 3, 4].map(|k| samples.iter().map(|sample| sample[k]).collect());
    let [x, first, second, errors, of_loss]: [Vec<f64>; 5] = columns;
    let record = match kind {
        RecordKind::Oscillation => Record::oscillation(x, first, second),
        RecordKind::Creep => Record::creep(x, first),
        RecordKind::Relaxation | RecordKind::History => Record::relaxation(x, first),
    }?;
    if has_errors {
        record.with_errors(&errors, &of_loss)
    } else {
        Ok(record)
    }
}

/// The reference temperature, of records that make a master curve.
fn checked(
    records: &[(f64, Record)],
    levels: &[Level],
    reference_c: f64,
    by: ShiftBy,
) -> Result<f64, IdentifyError> {
    let wrong = |reason: String| Err(IdentifyError::Record(reason));
    let ([first, .., last], [(_, one), ..]) = (levels, records) else {
        let count = if levels.is_empty() { "none" } else { "one" };
        return wrong(format!(
            "{MASTER_CURVE} needs records of two temperatures, and there is {count}: give more"
        ));
    };
    let [low, high] = [first.celsius, last.celsius];
    if !(low - NEAR_END..=high + NEAR_END).contains(&reference_c) {
        return wrong(format!(
            "{MASTER_CURVE} {} degC is not between {} records from {} to {} degC: change it, or give more of them",
            Shown(reference_c),
            records.len(),
            Shown(low),
            Shown(high)
        ));
    }
    if one.kind == RecordKind::History || records.iter().any(|other| other.1.kind != one.kind) {
        return wrong(format!(
            "{MASTER_CURVE} shifts records of one kind: relaxation, creep or oscillation"
        ));
    }
    if by != ShiftBy::Both && one.kind != RecordKind::Oscillation {
        return wrong(format!(
            "{SHIFT_BY} has no effect on records of kind {}, which have one modulus: omit it",
            one.kind.name()
        ));
    }
    Ok(reference_c.clamp(low, high))
}

/// That not even the better law fits the shifts, whose own error is given.
fn missed(shifts: &[Shift], laws: &[ShiftLaw], error: f64) -> Option<String> {
    let law = laws.first()?;
    let ends = shifts.iter().fold([0.0_f64; 2], |[low, high], shift| {
        [low.min(shift.log10), high.max(shift.log10)]
    });
    let range = ends[1] - ends[0];
    (law.rms > (MISSED * range).max(ERRORS * error)).then(|| {
        format!(
            "the shifts are no result: no law fits them, the better one ({}) misses them by {} of {} decades, as where curves are so flat that they lie on each other at any shift; look at the misfit of each overlap, give {SHIFT_BY} the modulus that bends, or fewer temperatures",
            law.name,
            Shown(rounded(law.rms)),
            Shown(rounded(range))
        )
    })
}

/// The temperature at which storage and loss modulus disagree the most, if that is more than their errors and than a word is worth.
fn disagreement(shifts: &[Shift], pairs: &[Pair], by: ShiftBy) -> Option<String> {
    let apart = |shift: &Shift| shift.alone.map_or(0.0, |[storage, loss]| storage - loss);
    let worst = shifts
        .iter()
        .max_by(|a, b| apart(a).abs().total_cmp(&apart(b).abs()))?;
    let [storage, loss] = worst.alone.filter(|_| apart(worst).abs() > DISAGREE)?;
    let misfits = [0, 1].map(|n| {
        let squares = pairs.iter().filter_map(|pair| Some(pair.overlap.alone?[n]));
        libm::sqrt(squares.map(|misfit| misfit * misfit).sum::<f64>() / pairs.len() as f64)
    });
    let better = usize::from(misfits[1] < misfits[0]);
    let remedy = match by {
        ShiftBy::Both => format!(": give {}", SHIFT_BY.set_to(["storage", "loss"][better])),
        ShiftBy::Storage | ShiftBy::Loss => String::new(),
    };
    Some(format!(
        "at {} degC the storage modulus alone is shifted by {} decades, the loss modulus by {}; their overlaps miss each other by {} and {} %, and standard errors are wider by that{remedy}",
        Shown(rounded(worst.temperature_c)),
        Shown(rounded(storage)),
        Shown(rounded(loss)),
        Shown(rounded(100.0 * misfits[0])),
        Shown(rounded(100.0 * misfits[1]))
    ))
}

/// Value to two decimals, for a sentence.
fn rounded(value: f64) -> f64 {
    libm::round(100.0 * value) / 100.0
}

/// Records of one temperature, within 0.1 K.
struct Level {
    /// Mean of their temperatures, °C.
    celsius: f64,
    records: Range<usize>,
    curves: Vec<Curve>,
}

/// Records in the order of their temperatures, as levels.
fn levels(records: &[(f64, Record)]) -> Vec<Level> {
    let mut ends: Vec<usize> = Vec::new();
    let mut start = 0;
    for n in 1..=records.len() {
        if n == records.len() || records[n].0 - records[start].0 >= ALIKE {
            ends.push(n);
            start = n;
        }
    }
    let mut start = 0;
    let levels = ends.into_iter().map(|end| {
        let range = start..end;
        start = end;
        let level = &records[range.clone()];
        Level {
            celsius: level.iter().map(|one| one.0).sum::<f64>() / level.len() as f64,
            records: range,
            curves: level.iter().map(|one| Curve::new(&one.1)).collect(),
        }
    });
    levels.collect()
}

/// One modulus, or both, of two neighbours.
#[derive(Clone, Copy)]
struct Shifted {
    /// Shift to the right that moves the warmer one onto the colder one.
    shift: f64,
    error: f64,
    points: usize,
    misfit: f64,
}

/// Two neighbours in temperature, and the shift between them.
struct Pair {
    shift: f64,
    error: f64,
    /// Shifts by storage and by loss modulus alone.
    alone: Option<[Shifted; 2]>,
    overlap: Overlap,
}

impl Pair {
    fn of(pair: &[Level], by: ShiftBy) -> Result<Self, IdentifyError> {
        let temperatures_c = [0, 1].map(|n| pair[n].celsius);
        let count = pair[0].curves[0].ln_y.len();
        let shifted = |by: ShiftBy| pair[0].shift_to(&pair[1], by.moduli(count));
        let Some(found) = shifted(by) else {
            return Err(IdentifyError::Record(format!(
                "the curves at {} and {} degC do not overlap in {OVERLAP} points: give one in between, or leave one out",
                Shown(temperatures_c[0]),
                Shown(temperatures_c[1])
            )));
        };
        let both = (count == 2).then(|| (shifted(ShiftBy::Storage), shifted(ShiftBy::Loss)));
        let alone = both.and_then(|(storage, loss)| Some([storage?, loss?]));
        Ok(Self {
            shift: found.shift,
            error: found.error,
            overlap: Overlap {
                temperatures_c,
                points: found.points,
                misfit: found.misfit,
                alone: alone.map(|alone| alone.map(|one| one.misfit)),
            },
            alone,
        })
    }

    /// Standard error of the sum of these shifts.
    fn error(pairs: &[Self]) -> f64 {
        let half = |pair: &Self| pair.alone.map_or(0.0, |[a, b]| 0.5 * (a.shift - b.shift));
        let squares: f64 = pairs.iter().map(|pair| pair.error * pair.error).sum();
        let each: f64 = pairs.iter().map(|pair| half(pair) * half(pair)).sum();
        let all: f64 = pairs.iter().map(half).sum();
        // Of no pairs the sums are −0.0, and the sign of a largest zero is the compiler's.
        libm::sqrt(squares + each.max(all * all) + 0.0)
    }
}

/// Logarithms of a record: of time or frequency, and of each modulus.
struct Curve {
    ln_x: Vec<f64>,
    ln_y: Vec<Vec<f64>>,
}

impl Curve {
    fn new(record: &Record) -> Self {
        let ln = |values: &Vec<f64>| values.iter().map(|value| libm::log(*value)).collect();
        let moduli = [&record.first, &record.second];
        let moduli = moduli.into_iter().filter(|values| !values.is_empty());
        Self {
            ln_x: ln(&record.x),
            ln_y: moduli.map(ln).collect(),
        }
    }

    fn ends(&self) -> [f64; 2] {
        [self.ln_x[0], self.ln_x[self.ln_x.len() - 1]]
    }

    /// Value and slope of one of its moduli, if it is known there.
    fn at(&self, modulus: usize, ln_x: f64) -> Option<[f64; 2]> {
        let [low, high] = self.ends();
        if !(low..=high).contains(&ln_x) {
            return None;
        }
        let after = self.ln_x.partition_point(|x| *x < ln_x);
        let after = after.clamp(1, self.ln_x.len() - 1);
        let y = &self.ln_y[modulus][after - 1..=after];
        let x = &self.ln_x[after - 1..=after];
        let slope = (y[1] - y[0]) / (x[1] - x[0]).max(f64::MIN_POSITIVE);
        Some([y[0] + slope * (ln_x - x[0]), slope])
    }

    /// Adds squares of the distances of another curve, moved by s to the right, from this one; how many, and the squares of slopes.
    fn distance(&self, other: &Self, s: f64, moduli: Range<usize>, sums: &mut [f64; 3]) {
        let mut add = |curve: &Self, modulus: usize, x: f64, y: f64| {
            if let Some([value, slope]) = curve.at(modulus, x) {
                sums[0] += (y - value) * (y - value);
                sums[1] += 1.0;
                sums[2] += slope * slope;
            }
        };
        for modulus in moduli {
            for (x, y) in self.ln_x.iter().zip(&self.ln_y[modulus]) {
                add(other, modulus, x - s, *y);
            }
            for (x, y) in other.ln_x.iter().zip(&other.ln_y[modulus]) {
                add(self, modulus, x + s, *y);
            }
        }
    }
}

impl Level {
    fn ends(&self) -> [f64; 2] {
        let ends = self.curves.iter().map(Curve::ends);
        ends.fold([f64::INFINITY, f64::NEG_INFINITY], |all, pair| {
            [all[0].min(pair[0]), all[1].max(pair[1])]
        })
    }

    /// [`Curve::distance`] of each curve from each of the other temperature, if enough points overlap.
    fn distance(&self, other: &Self, s: f64, moduli: &Range<usize>) -> Option<[f64; 3]> {
        let mut sums = [0.0; 3];
        for curve in &self.curves {
            for other in &other.curves {
                curve.distance(other, s, moduli.clone(), &mut sums);
            }
        }
        (sums[1] >= (OVERLAP * moduli.len()) as f64).then_some(sums)
    }

    /// Shift to the right that moves the curves of another temperature onto these, by some of their moduli.
    fn shift_to(&self, other: &Self, moduli: Range<usize>) -> Option<Shifted> {
        let ([low, high], [low_2, high_2]) = (self.ends(), other.ends());
        let mean = |s: f64| {
            self.distance(other, s, &moduli)
                .map_or(f64::INFINITY, |sums| sums[0] / (sums[1] - 1.0))
        };
        let step = (high - low_2 - (low - high_2)) / TRIALS as f64;
        let trials = (0..=TRIALS).map(|n| low - high_2 + n as f64 * step);
        let best = trials.min_by(|a, b| mean(*a).total_cmp(&mean(*b)))?;
        // Between its neighbours, by golden sections.
        let (mut left, mut right) = (best - step, best + step);
        for _ in 0..40 {
            let inner = 0.381_966_011_250_105 * (right - left);
            if mean(left + inner) <= mean(right - inner) {
                right -= inner;
            } else {
                left += inner;
            }
        }
        let shift = 0.5 * (left + right);
        let halfway = self.distance(other, shift, &moduli);
        let [square, count, slopes] = halfway.or_else(|| self.distance(other, best, &moduli))?;
        // Each distance is of two points with noise, and counts from both sides.
        let variance = 2.0 * square / (count - 1.0) / slopes.max(f64::MIN_POSITIVE);
        Some(Shifted {
            shift,
            error: libm::sqrt(variance),
            points: count as usize / moduli.len(),
            misfit: libm::sqrt(square / count),
        })
    }
}

/// Both laws, the better one first. The point at the reference temperature has no weight in either.
fn laws(shifts: &[Shift], reference_c: f64) -> Vec<ShiftLaw> {
    let point = |shift: &Shift| [shift.temperature_c - reference_c, shift.log10];
    let points = shifts.iter().map(point);
    let points: Vec<[f64; 2]> = points.filter(|[x, _]| x.abs() > ALIKE).collect();
    let both = [wlf(&points), arrhenius(&points, reference_c)];
    let mut laws: Vec<ShiftLaw> = both.into_iter().flatten().collect();
    laws.sort_by(|a, b| a.bic.total_cmp(&b.bic));
    laws
}

/// Numbers by least squares of points, a row and what it is to reach of each, and the diagonal of the inverse normal matrix.
fn solved<const N: usize>(
    points: &[[f64; 2]],
    row: impl Fn([f64; 2]) -> ([f64; N], f64),
) -> Option<[SVector<f64, N>; 2]> {
    let (mut normal, mut right) = (SMatrix::<f64, N, N>::zeros(), SVector::zeros());
    for (row, wanted) in points.iter().map(|point| row(*point)) {
        let row = SVector::from(row);
        normal += row * row.transpose();
        right += row * wanted;
    }
    let inverse = normal.try_inverse()?;
    Some([inverse * right, inverse.diagonal()])
}

/// C₁ and C₂ by Gauss–Newton from the linear problem y·(C₂ + x) = −C₁·x; `None` if its pole is among the temperatures.
fn wlf(points: &[[f64; 2]]) -> Option<ShiftLaw> {
    let [mut c, mut spread] = solved(points, |[x, y]| ([-x, -y], x * y))?;
    let left = |c: &SVector<f64, 2>, [x, y]: [f64; 2]| y + c[0] * x / (c[1] + x);
    let sum = |c: &SVector<f64, 2>| {
        let is_below = points.iter().all(|[x, _]| c[1] + x > 0.0);
        let squares = points.iter().map(|point| libm::pow(left(c, *point), 2.0));
        is_below.then(|| squares.sum::<f64>())
    };
    let mut least = sum(&c).filter(|_| points.len() > 2)?;
    for _ in 0..50 {
        let slopes = |x: f64| [-x / (c[1] + x), c[0] * x / ((c[1] + x) * (c[1] + x))];
        let step;
        [step, spread] = solved(points, |[x, y]| (slopes(x), left(&c, [x, y])))?;
        let mut parts = (0..20).map(|n| c + step * libm::exp2(-f64::from(n)));
        let lower = parts.find_map(|c| Some((c, sum(&c).filter(|sum| *sum <= least)?)));
        let Some(lower) = lower else { break };
        (c, least) = lower;
    }
    let named = [("c1", ""), ("c2_k", "K")];
    Some(law("wlf", named, [c, spread], least, points.len()))
}

/// E by linear least squares.
fn arrhenius(points: &[[f64; 2]], reference_c: f64) -> Option<ShiftLaw> {
    let inverse = |celsius: f64| 1.0 / (celsius + ZERO_CELSIUS);
    let scale = 1.0 / (GAS_CONSTANT * core::f64::consts::LN_10);
    let slope = |x: f64| scale * (inverse(reference_c + x) - inverse(reference_c));
    let [energy, spread] = solved(points, |[x, y]| ([slope(x)], y))?;
    let left = points.iter().map(|[x, y]| y - slope(*x) * energy[0]);
    let sum = left.map(|r| r * r).sum();
    let named = [("activation_energy_j_per_mol", "J/mol")];
    let law = law("arrhenius", named, [energy, spread], sum, points.len());
    (points.len() > 1).then_some(law)
}

/// Numbers of these names and units, and the diagonal of their inverse normal matrix.
fn law<const N: usize>(
    name: &'static str,
    named: [(&'static str, &'static str); N],
    [values, spread]: [SVector<f64, N>; 2],
    sum: f64,
    count: usize,
) -> ShiftLaw {
    let freedom = count as f64 - N as f64;
    let parameters = named.into_iter().enumerate().map(|(n, (name, unit))| {
        let error = libm::sqrt(sum / freedom * spread[n]);
        Estimate::of_line(name, unit, values[n], error, student(freedom))
    });
    ShiftLaw {
        name,
        parameters: parameters.collect(),
        rms: libm::sqrt(sum / count as f64),
        bic: likelihood(count, sum, EXACT) + (N + 1) as f64 * libm::log(count as f64),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `tests/golden/meaning/make_golden.py` has them from `SciPy`.
    #[test]
    fn laws_of_shifts_are_those_of_least_squares() {
        let rows = [
            (-10.0, 4.31),
            (0.0, 2.36),
            (10.0, 1.02),
            (25.0, -0.38),
            (30.0, -0.79),
            (40.0, -1.42),
        ];
        let shifts = rows.map(|(temperature_c, log10)| Shift {
            temperature_c,
            log10,
            standard_error: 0.0,
            alone: None,
        });
        let laws = laws(&shifts, 20.0);
        let wanted: [(&str, &[[f64; 2]], f64); 2] = [
            (
                "wlf",
                &[[6.909_704_44, 0.162_377_757], [78.159_551_9, 1.231_300_15]],
                0.017_198_881_4,
            ),
            ("arrhenius", &[[184_428.486, 15_176.811_4]], 0.390_737_634),
        ];
        assert_eq!(laws.len(), 2);
        for (law, (name, values, rms)) in laws.iter().zip(wanted) {
            assert_eq!(law.name, name);
            assert!((law.rms / rms - 1.0).abs() < 1e-6, "{law:?}");
            for (found, [value, error]) in law.parameters.iter().zip(values) {
                let found_error = found.standard_error.expect("one");
                assert!((found.value / value - 1.0).abs() < 1e-6, "{found:?}");
                assert!((found_error / error - 1.0).abs() < 1e-4, "{found:?}");
            }
        }
    }
}
