//! Records at several temperatures, shifted to one: a master curve.
//! ```text
//! relaxation, creep  f_T(t) = f_T₀(t/a_T)        oscillation  M_T(ω) = M_T₀(ω·a_T)
//! of two neighbours in temperature: s = ln a_T₁ − ln a_T₂ at the least mean square distance of their curves where they overlap
//! Williams, Landel, Ferry  log₁₀ a_T = −C₁·(T − T₀)/(C₂ + T − T₀)        Arrhenius  ln a_T = (E/R)·(1/T − 1/T₀)
//! ```
//! A curve is straight between its points in logarithms; the distance is vertical, from each point to the other curve. Standard errors
//! are those of its curvature, and add up from neighbour to neighbour. `a_T` is 1 at the reference temperature, where it lies between
//! its neighbours in proportion. Intervals of the laws are those of least squares over all `a_T`; that of the lower BIC comes first. The
//! density's own change with temperature, some per cent, is not corrected for.
//!
//! - *Errors*: fewer than two temperatures, two alike, other records than of steps or sweeps, curves that do not overlap.
//! - *Cost*: 400 distances for each pair.
//! - *Source*: J. D. Ferry, *Viscoelastic Properties of Polymers*, 1980, chapter 11.

use super::error::IdentifyError;
use super::fit::{Estimate, likelihood, student};
use super::record::{Record, RecordKind};
use crate::identify::keys::{MASTER_CURVE, SEGMENT};
use fracdiff::parameter::Shown;
use nalgebra::{SMatrix, SVector};

/// How much faster or slower the tissue is at a temperature.
#[derive(Clone, Debug, PartialEq)]
pub struct Shift {
    /// The temperature that the record was measured at, °C.
    pub temperature_c: f64,
    /// `log₁₀ a_T`, below 0 where the tissue is faster than at the reference.
    pub log10: f64,
    /// Standard error of the distance to the reference temperature.
    pub standard_error: f64,
}

/// A law of the shifts.
#[derive(Clone, Debug, PartialEq)]
pub struct ShiftLaw {
    /// Its name in a report: `wlf` or `arrhenius`.
    pub name: &'static str,
    /// C₁ and C₂, or E.
    pub parameters: Vec<Estimate>,
    /// Root of the mean square of what is left of `log₁₀ a_T`.
    pub rms: f64,
    /// n·ln(S/n) + k·ln n of n shifts other than that of the reference, and k numbers with the noise.
    pub bic: f64,
}

/// Several records shifted along time or frequency until they are one.
#[derive(Clone, Debug, PartialEq)]
pub struct MasterCurve {
    /// All samples, at the reference temperature.
    pub record: Record,
    /// One for each record, in order of temperature.
    pub shifts: Vec<Shift>,
    /// The better one first. A law needs one temperature more than it has numbers, beside that of the reference.
    pub laws: Vec<ShiftLaw>,
}

/// Shifts that are tried of each pair, over the widths of both curves.
const TRIALS: usize = 400;
/// Points in the overlap, at least.
const OVERLAP: usize = 4;
/// Temperatures so near, K, are one.
const ALIKE: f64 = 0.1;
/// R of Arrhenius' law, J/(mol·K).
const GAS_CONSTANT: f64 = 8.314_462_618;
const ZERO_CELSIUS: f64 = 273.15;

/// Shifts records, each with its temperature in °C, to a reference temperature.
///
/// # Errors
/// Fewer than two temperatures, two alike, a reference beyond them, records of a motion or of different kinds, curves that do not overlap.
pub fn master_curve(
    mut records: Vec<(f64, Record)>,
    reference_c: f64,
) -> Result<MasterCurve, IdentifyError> {
    let wrong = |reason: String| Err(IdentifyError::Record(reason));
    records.sort_by(|a, b| a.0.total_cmp(&b.0));
    let count = records.len();
    let [Some(first), Some(last)] = [records.first(), records.last()] else {
        return wrong(format!(
            "{MASTER_CURVE} needs records of two temperatures, and there are none: give them"
        ));
    };
    let kind = first.1.kind;
    if count < 2 || !(first.0..=last.0).contains(&reference_c) {
        return wrong(format!(
            "{MASTER_CURVE} {} degC is not between {count} records from {} to {} degC: change it, or give more of them",
            Shown(reference_c),
            Shown(first.0),
            Shown(last.0)
        ));
    }
    if kind == RecordKind::History || records.iter().any(|one| one.1.kind != kind) {
        return wrong(format!(
            "{MASTER_CURVE} shifts records of one kind: relaxation, creep or oscillation"
        ));
    }
    // A sweep goes the other way: a tissue that is faster shows at high frequencies what it shows at short times.
    let is_sweep = kind == RecordKind::Oscillation;
    let way = if is_sweep { -1.0 } else { 1.0 };
    let curves: Vec<Curve> = records.iter().map(|one| Curve::new(&one.1)).collect();
    let (mut shifts, mut errors) = (vec![0.0], vec![0.0]);
    for (n, pair) in curves.windows(2).enumerate() {
        let temperatures = [n, n + 1].map(|n| records[n].0);
        if temperatures[1] - temperatures[0] < ALIKE {
            return wrong(format!(
                "two records are at {} degC: take one with {SEGMENT}",
                Shown(temperatures[0])
            ));
        }
        let Some((shift, error)) = pair[0].shift_to(&pair[1]) else {
            return wrong(format!(
                "the curves at {} and {} degC do not overlap in {OVERLAP} points: give one in between, or leave one out",
                Shown(temperatures[0]),
                Shown(temperatures[1])
            ));
        };
        shifts.push(shifts[n] - way * shift);
        errors.push(error);
    }
    let upper = records.partition_point(|one| one.0 < reference_c).max(1);
    let share = (reference_c - records[upper - 1].0) / (records[upper].0 - records[upper - 1].0);
    let zero = shifts[upper - 1] + share * (shifts[upper] - shifts[upper - 1]);
    let nearest = if share < 0.5 { upper - 1 } else { upper };
    let mut samples: Vec<[f64; 3]> = Vec::new();
    let mut found = Vec::new();
    for (n, (temperature_c, record)) in records.iter().enumerate() {
        let ln = shifts[n] - zero;
        let way_there = errors[n.min(nearest) + 1..=n.max(nearest)].iter();
        let square = way_there.map(|error| error * error).sum::<f64>();
        found.push(Shift {
            temperature_c: *temperature_c,
            log10: ln / core::f64::consts::LN_10,
            standard_error: libm::sqrt(square) / core::f64::consts::LN_10,
        });
        for (i, x) in record.x.iter().enumerate() {
            let second = record.second.get(i).copied().unwrap_or_default();
            samples.push([x * libm::exp(-way * ln), record.first[i], second]);
        }
    }
    samples.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let [x, first, second] = [0, 1, 2].map(|k| samples.iter().map(|sample| sample[k]).collect());
    let record = match kind {
        RecordKind::Oscillation => Record::oscillation(x, first, second),
        RecordKind::Creep => Record::creep(x, first),
        RecordKind::Relaxation | RecordKind::History => Record::relaxation(x, first),
    };
    Ok(MasterCurve {
        record: record?,
        laws: laws(&found, reference_c),
        shifts: found,
    })
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

    /// Squares of the distances of another curve, moved by s to the right, from this one; how many, and the squares of slopes.
    fn distance(&self, other: &Self, s: f64) -> Option<[f64; 3]> {
        let mut sums = [0.0; 3];
        let mut add = |curve: &Self, modulus: usize, x: f64, y: f64| {
            if let Some([value, slope]) = curve.at(modulus, x) {
                sums[0] += (y - value) * (y - value);
                sums[1] += 1.0;
                sums[2] += slope * slope;
            }
        };
        for modulus in 0..self.ln_y.len() {
            for (x, y) in self.ln_x.iter().zip(&self.ln_y[modulus]) {
                add(other, modulus, x - s, *y);
            }
            for (x, y) in other.ln_x.iter().zip(&other.ln_y[modulus]) {
                add(self, modulus, x + s, *y);
            }
        }
        (sums[1] >= (OVERLAP * self.ln_y.len()) as f64).then_some(sums)
    }

    /// How far to the right another curve is to move onto this one, and the standard error.
    fn shift_to(&self, other: &Self) -> Option<(f64, f64)> {
        let ([low, high], [low_2, high_2]) = (self.ends(), other.ends());
        let mean = |s: f64| {
            self.distance(other, s)
                .map_or(f64::INFINITY, |sums| sums[0] / (sums[1] - 1.0))
        };
        let step = (high - low_2 - (low - high_2)) / TRIALS as f64;
        let trials = (0..=TRIALS).map(|n| low - high_2 + n as f64 * step);
        let best = trials.min_by(|a, b| mean(*a).total_cmp(&mean(*b)))?;
        // Between its neighbours, by golden sections.
        let (mut left, mut right) = (best - step, best + step);
        for _ in 0..40 {
            let inner = 0.381_966_011_250_105 * (right - left);
            match mean(left + inner) <= mean(right - inner) {
                true => right -= inner,
                false => left += inner,
            }
        }
        let shift = 0.5 * (left + right);
        let there = self.distance(other, shift);
        let [square, count, slopes] = there.or_else(|| self.distance(other, best))?;
        // Each distance is of two points with noise, and counts from both sides.
        let variance = 2.0 * square / (count - 1.0) / slopes.max(f64::MIN_POSITIVE);
        Some((shift, libm::sqrt(variance)))
    }
}

/// Both laws, the better one first. The reference temperature tells nothing of either.
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

/// C₁ and C₂ by Gauss–Newton from the linear problem y·(C₂ + x) = −C₁·x; none if its pole is among the temperatures.
fn wlf(points: &[[f64; 2]]) -> Option<ShiftLaw> {
    let [mut c, mut spread] = solved(points, |[x, y]| ([-x, -y], x * y))?;
    let left = |c: &SVector<f64, 2>, [x, y]: [f64; 2]| y + c[0] * x / (c[1] + x);
    let sum = |c: &SVector<f64, 2>| {
        let is_below = points.iter().all(|[x, _]| c[1] + x > 0.0);
        let squares = points.iter().map(|point| left(c, *point).powi(2));
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
        bic: likelihood(count, sum) + (N + 1) as f64 * libm::log(count as f64),
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
