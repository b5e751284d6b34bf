//! A sum of parts from a frequency response, as an impedance is measured.
//!
//! ```text
//! r = (Σ G_k(jω)·e^(−jωL) − H)/|H|,   Σ|r|² least:   errors in proportion to the size, alike in both parts of H
//! BIC = 2n·ln(Σ|r|²/2n) + numbers·ln 2n
//! ```
//! The search tries a resistance R, one or two arcs r/(τs^α + 1) and a power k/s^α, together and apart. First gains come from non-negative least
//! squares for arcs at some places of the band; from the nearest of them Levenberg and Marquardt's algorithm finds all numbers. An order that is
//! one half or one within twice its error becomes that number, if the criterion agrees.
//!
//! Any stable chain of relaxations obeys Kramers' and Kronig's relations, and nothing else does: [`kramers_kronig`] fits R + sL + 1/(sC) and a positive
//! spectrum of relaxations, ten a decade (B. A. Boukamp, *A linear Kronig–Kramers transform test for immittance data validation*, Journal of the
//! Electrochemical Society 142, 1995; with positive weights). A steady system that relaxes leaves noise; one that drifts leaves a course.

use super::numbers::Numbers;
use super::record::{Free, UNFIT};
use crate::{DeadTime, FreeNumber};
use fracdiff::Seconds;
use fracdiff::full_memory::non_negative_least_squares;
use fracdiff::parameter::{positive, range};
use fractional_control::{ControlError, FractionalTransferFunction, SumOfParts, Term};
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use nalgebra::storage::Owned;
use nalgebra::{DMatrix, DVector, Dyn};
use num_complex::Complex;
use rayon::prelude::*;

/// A sum of parts that was found in a frequency response.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct IdentifiedResponse {
    /// The parts that fit best.
    pub sum: SumOfParts,
    /// The dead time before them; free if it was fitted.
    pub dead_time: DeadTime,
    /// Root mean square of the residual of a part of H, over |H|.
    pub rms_residual: f64,
    /// Bayesian information criterion: less is better.
    pub bic: f64,
    /// Standard errors of the free numbers, each with its part.
    pub standard_errors: Vec<(usize, FreeNumber, f64)>,
    /// Its response at each frequency.
    pub model: Vec<Complex<f64>>,
}

/// A response is not known better than this share of its size.
const EXACT: f64 = 1e-6;

struct ResponseFit<'a> {
    numbers: Numbers,
    parameters: DVector<f64>,
    points: &'a [(f64, Complex<f64>)],
    late_s: f64,
}

/// A residual where there is no model.
const NONE: f64 = 1e3;

impl ResponseFit<'_> {
    fn model(&self, parameters: &DVector<f64>) -> Option<Vec<Complex<f64>>> {
        let parts = self.numbers.parts(parameters).ok()?;
        let late_s = self.numbers.late(parameters).unwrap_or(self.late_s);
        let at = |omega: f64| {
            let sum: Complex<f64> = parts.iter().map(|part| part.response(omega)).sum();
            sum * Complex::from_polar(1.0, -omega * late_s)
        };
        Some(self.points.iter().map(|point| at(point.0)).collect())
    }

    fn left(&self, parameters: &DVector<f64>) -> DVector<f64> {
        let model = self.model(parameters);
        let left = self.points.iter().enumerate().flat_map(|(n, (_, h))| {
            let left = (model.as_ref()).map_or(Complex::new(NONE, NONE), |g| (g[n] - h) / h.norm());
            [left.re, left.im].map(|part| if part.is_finite() { part } else { NONE })
        });
        DVector::from_iterator(2 * self.points.len(), left)
    }

    fn slopes(&self) -> DMatrix<f64> {
        let here = self.left(&self.parameters);
        let slope = |column| {
            let left = |parameters: &DVector<f64>| self.left(parameters);
            self.numbers.slope(column, &self.parameters, &here, left)
        };
        DMatrix::from_columns(&(0..self.numbers.free.len()).map(slope).collect::<Vec<_>>())
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for ResponseFit<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, parameters: &DVector<f64>) {
        self.parameters.copy_from(parameters);
    }

    fn params(&self) -> DVector<f64> {
        self.parameters.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        Some(self.left(&self.parameters))
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        Some(self.slopes())
    }
}

/// Fits the coefficients and orders of a sum of parts to (ω in rad/s, H), and the dead time if it is free. Signs stay, orders of 0 too.
///
/// # Errors
/// Frequencies that are not above 0, a response that is 0 or not finite, fewer of its numbers than free ones; a search that fails.
pub fn identify_response(
    guess: &SumOfParts,
    dead_time: DeadTime,
    points: &[(f64, Complex<f64>)],
) -> Result<IdentifiedResponse, ControlError> {
    fitted(
        Numbers::new(guess.parts(), Free::All, dead_time),
        dead_time,
        points,
    )
}

fn fitted(
    numbers: Numbers,
    dead_time: DeadTime,
    points: &[(f64, Complex<f64>)],
) -> Result<IdentifiedResponse, ControlError> {
    check(points, numbers.free.len())?;
    let late_s = dead_time.seconds();
    let problem = ResponseFit {
        parameters: numbers.begin(late_s),
        numbers,
        points,
        late_s,
    };
    let (problem, report) = LevenbergMarquardt::new().minimize(problem);
    if report.termination.was_usage_issue() {
        return Err(UNFIT);
    }
    let ResponseFit {
        numbers,
        parameters,
        ..
    } = &problem;
    let count = (2 * points.len()) as f64;
    let sum = problem.left(parameters).norm_squared();
    let free = numbers.free.len();
    let scale = sum / (count - free as f64).max(1.0);
    let errors = numbers.covariance(&problem.slopes(), scale, parameters, 1.0);
    let diagonal = errors.diagonal();
    let errors = numbers.free.iter().zip(diagonal.iter());
    let rms_residual = libm::sqrt(sum / count);
    Ok(IdentifiedResponse {
        sum: SumOfParts::new(numbers.parts(parameters)?)?,
        dead_time: match numbers.late(parameters) {
            Some(late) => DeadTime::From(Seconds(late)),
            None => dead_time,
        },
        bic: 2.0 * count * libm::log(rms_residual.max(EXACT)) + free as f64 * libm::log(count),
        standard_errors: errors
            .map(|((part, number), square)| (*part, *number, libm::sqrt(*square)))
            .collect(),
        model: problem.model(parameters).ok_or(UNFIT)?,
        rms_residual,
    })
}

fn check(points: &[(f64, Complex<f64>)], free: usize) -> Result<(), ControlError> {
    let count = points.len() as f64;
    let enough = 2 * points.len() > free + 1 && points.len() > 2;
    let allowed = "at least 3, and more than half the free numbers";
    range("number of frequencies", count, enough, allowed, "")?;
    for (omega, h) in points {
        positive("frequency", *omega, "rad/s")?;
        positive("size of the response", h.norm(), "")?;
    }
    Ok(())
}

/// Arcs, and a resistance and a power beside them.
#[derive(Clone, Copy, Debug)]
struct Shape {
    arcs: usize,
    resistance: bool,
    power: bool,
}

/// Orders that arcs and powers begin from.
const ARC: f64 = 0.85;
const POWERS: [f64; 2] = [0.5, 0.9];
/// Places of arcs in the band, and starts of each shape that are fitted.
const PLACES: usize = 6;
const FITTED: usize = 3;
/// Functions that are kept at most.
const KEPT: usize = 6;
/// A difference of the criterion that says nothing.
const AS_GOOD: f64 = 2.0;

/// The sums of a resistance, arcs and a power that fit a response, the best first: the one of the fewest numbers of those that are as good.
///
/// # Errors
/// As [`identify_response`]; [`ControlError::NotFound`] where nothing fits.
pub fn search_response(
    points: &[(f64, Complex<f64>)],
) -> Result<Vec<IdentifiedResponse>, ControlError> {
    check(points, 0)?;
    let shapes = (0..=2).flat_map(|arcs| {
        let beside = [(false, false), (true, false), (false, true), (true, true)];
        beside.map(|(resistance, power)| Shape {
            arcs,
            resistance,
            power,
        })
    });
    let shapes: Vec<Shape> = shapes
        .filter(|shape| shape.arcs > 0 || shape.power)
        .collect();
    let best = |shape: &Shape| {
        let mut starts = starts(*shape, points);
        starts.sort_by(|a, b| a.0.total_cmp(&b.0));
        let starts = starts.into_iter().take(FITTED);
        let fits = starts.filter_map(|start| {
            let guess = SumOfParts::new(start.1).ok()?;
            identify_response(&guess, DeadTime::NONE, points).ok()
        });
        let best = fits.min_by(|a, b| a.bic.total_cmp(&b.bic))?;
        Some(settled(best, points)).filter(relaxes)
    };
    let mut found: Vec<IdentifiedResponse> = shapes.par_iter().filter_map(best).collect();
    found.sort_by(|a, b| a.bic.total_cmp(&b.bic));
    let least = found.first().ok_or(UNFIT)?.bic;
    let as_good = found.iter().enumerate();
    let as_good = as_good.filter(|(_, one)| one.bic <= least + AS_GOOD);
    let simplest = as_good.min_by_key(|(_, one)| one.standard_errors.len());
    let place = simplest.map_or(0, |(place, _)| place);
    found[..=place].rotate_right(1);
    found.truncate(KEPT);
    Ok(found)
}

/// A number whose error is above this share of it is not determined.
const LOOSE: f64 = 0.5;

/// True of parts that relax, all of whose numbers are determined.
fn relaxes(found: &IdentifiedResponse) -> bool {
    let errors = found.standard_errors.iter();
    let mut parts = found.sum.parts().iter();
    errors.map(|error| error.2).all(|error| error <= LOOSE)
        && parts.all(|part| part.denominator().degree() <= 1.0)
}

/// First parts of a shape, each with the squares that they leave.
fn starts(
    shape: Shape,
    points: &[(f64, Complex<f64>)],
) -> Vec<(f64, Vec<FractionalTransferFunction>)> {
    let ends = points
        .iter()
        .fold([f64::INFINITY, 0.0_f64], |[low, high], point| {
            [low.min(point.0), high.max(point.0)]
        });
    let place = |n: usize| {
        let share = (n as f64 + 0.5) / PLACES as f64;
        libm::pow(ends[0], share) * libm::pow(ends[1], 1.0 - share)
    };
    let places: Vec<Vec<usize>> = match shape.arcs {
        0 => vec![vec![]],
        1 => (0..PLACES).map(|n| vec![n]).collect(),
        _ => (0..PLACES)
            .flat_map(|n| (n + 1..PLACES).map(move |k| vec![n, k]))
            .collect(),
    };
    let one = Term::new(1.0, 0.0);
    let with = |above: Term, below: &[Term]| FractionalTransferFunction::new(&[above], below).ok();
    let sets = places
        .iter()
        .flat_map(|places| POWERS.map(|power| (places, power)));
    let sets = sets.filter_map(|(places, order)| {
        let arcs = places.iter().map(|n| {
            let slow = Term::new(libm::pow(place(*n), -ARC), ARC);
            with(one, &[slow, one])
        });
        let resistance = shape.resistance.then(|| with(one, &[one]));
        let power = shape.power.then(|| with(one, &[Term::new(1.0, order)]));
        let parts = resistance.into_iter().chain(arcs).chain(power);
        parts.collect::<Option<Vec<_>>>()
    });
    let tried = sets.flat_map(|parts| [1.0, -1.0].map(|sign| gains(&parts, points, sign)));
    tried.flatten().collect()
}

/// Parts with the gains of one sign that fit best; `None` if one of them is 0.
fn gains(
    parts: &[FractionalTransferFunction],
    points: &[(f64, Complex<f64>)],
    sign: f64,
) -> Option<(f64, Vec<FractionalTransferFunction>)> {
    let columns = parts
        .iter()
        .map(|part| weighted(points, |omega| part.response(omega)));
    let columns: Vec<Vec<f64>> = columns.collect();
    let (shares, left) = positive_shares(columns, points, sign);
    let left = left.iter().map(|rest| rest * rest).sum();
    let scaled = parts.iter().zip(&shares).map(|(part, share)| {
        let gain = Term::new(sign * share, 0.0);
        FractionalTransferFunction::new(&[gain], part.denominator().terms()).ok()
    });
    Some((left, scaled.collect::<Option<Vec<_>>>()?))
}

/// A response over the sizes of the points, real and imaginary parts in turn.
fn weighted(points: &[(f64, Complex<f64>)], response: impl Fn(f64) -> Complex<f64>) -> Vec<f64> {
    let values = points.iter().flat_map(|(omega, h)| {
        let value = response(*omega) / h.norm();
        [value.re, value.im]
    });
    values.collect()
}

/// Non-negative shares of columns in sign·H, each column brought to one length, and what is left of its rows.
fn positive_shares(
    mut columns: Vec<Vec<f64>>,
    points: &[(f64, Complex<f64>)],
    sign: f64,
) -> (Vec<f64>, Vec<f64>) {
    let target = points.iter().flat_map(|(_, h)| {
        let value = h * (sign / h.norm());
        [value.re, value.im]
    });
    let target: Vec<f64> = target.collect();
    let length = |column: &Vec<f64>| libm::sqrt(column.iter().map(|x| x * x).sum());
    let lengths: Vec<f64> = columns.iter().map(length).collect();
    for (column, length) in columns.iter_mut().zip(&lengths) {
        column.iter_mut().for_each(|x| *x /= length);
    }
    let shares = non_negative_least_squares(columns.clone(), target.clone());
    let left = target.iter().enumerate().map(|(row, wanted)| {
        let sum: f64 = columns
            .iter()
            .zip(&shares)
            .map(|(column, share)| share * column[row])
            .sum();
        wanted - sum
    });
    let left = left.collect();
    (
        shares
            .iter()
            .zip(lengths)
            .map(|(share, length)| share / length)
            .collect(),
        left,
    )
}

/// Sets orders that are one half or one within twice their errors to that number, where the criterion agrees.
fn settled(found: IdentifiedResponse, points: &[(f64, Complex<f64>)]) -> IdentifiedResponse {
    let mut numbers = Numbers::new(found.sum.parts(), Free::All, DeadTime::NONE);
    let mut parts = found.sum.parts().to_vec();
    for (part, number, error) in &found.standard_errors {
        let FreeNumber::DenominatorOrder(0) = number else {
            continue;
        };
        let mut below = parts[*part].denominator().terms().to_vec();
        let half = 0.5 * libm::round(2.0 * below[0].order);
        if half > 0.0 && (below[0].order - half).abs() <= 2.0 * error {
            below[0].order = half;
            let above = parts[*part].numerator().terms();
            if let Ok(function) = FractionalTransferFunction::new(above, &below) {
                parts[*part] = function;
                numbers.free.retain(|free| *free != (*part, *number));
            }
        }
    }
    numbers.guess = parts;
    let simpler = fitted(numbers, DeadTime::NONE, points).ok();
    match simpler.filter(|simpler| simpler.bic <= found.bic) {
        Some(simpler) => simpler,
        None => found,
    }
}

/// A response beside Kramers' and Kronig's relations.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct KramersKronig {
    /// Root mean square of what a positive spectrum of relaxations leaves of a part of H, over |H|.
    pub rms_residual: f64,
    /// Correlation of that from frequency to frequency.
    pub neighbours: f64,
    /// True if that is noise, or next to nothing: the response can be of a linear, steady system that relaxes.
    pub holds: bool,
    /// True if it holds for the response with the other sign of its imaginary part.
    pub is_turned: bool,
}

/// Relaxations a decade, and decades beyond the band on either side.
const A_DECADE: f64 = 10.0;
const BEYOND: f64 = 2.0;
/// Frequencies below which nothing is tested.
const LEAST: usize = 10;
/// A residual that is next to nothing, and standard errors of a correlation by chance.
const LITTLE: f64 = 1e-3;
const BY_CHANCE: f64 = 4.0;

/// Tests whether a response can be of a linear, steady system; `None` below ten frequencies, or where the real part changes its sign, as that of
/// relaxations does not.
#[must_use]
pub fn kramers_kronig(points: &[(f64, Complex<f64>)]) -> Option<KramersKronig> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let sign = sorted.first()?.1.re.signum();
    if sorted.len() < LEAST || sorted.iter().any(|point| point.1.re * sign <= 0.0) {
        return None;
    }
    let tested = tested(&sorted, sign);
    let conjugate: Vec<_> = sorted.iter().map(|(omega, h)| (*omega, h.conj())).collect();
    let is_turned = !tested.holds && self::tested(&conjugate, sign).holds;
    Some(KramersKronig {
        is_turned,
        ..tested
    })
}

fn tested(points: &[(f64, Complex<f64>)], sign: f64) -> KramersKronig {
    let [low, high] = [points[0].0, points[points.len() - 1].0].map(libm::log10);
    let count = libm::ceil((high - low + 2.0 * BEYOND) * A_DECADE) as usize;
    let times = (0..=count).map(|n| libm::pow(10.0, n as f64 / A_DECADE - high - BEYOND));
    let relaxations =
        times.map(|time| weighted(points, |omega| Complex::new(1.0, omega * time).inv()));
    let beside: [fn(f64) -> Complex<f64>; 3] = [
        |_| Complex::new(1.0, 0.0),
        |omega| Complex::new(0.0, omega),
        |omega| Complex::new(0.0, -1.0 / omega),
    ];
    let beside = beside
        .into_iter()
        .map(|response| weighted(points, response));
    let columns: Vec<Vec<f64>> = beside.chain(relaxations).collect();
    let (_, left) = positive_shares(columns, points, sign);
    let sum: f64 = left.iter().map(|rest| rest * rest).sum();
    let left = left.chunks_exact(2);
    let left: Vec<Complex<f64>> = left.map(|at| Complex::new(at[0], at[1])).collect();
    let alike: f64 = left
        .windows(2)
        .map(|pair| (pair[0].conj() * pair[1]).re)
        .sum();
    let neighbours = if sum > 0.0 { alike / sum } else { 0.0 };
    let rows = (2 * points.len()) as f64;
    let rms_residual = libm::sqrt(sum / rows);
    KramersKronig {
        rms_residual,
        neighbours,
        holds: rms_residual <= LITTLE || neighbours * libm::sqrt(rows) <= BY_CHANCE,
        is_turned: false,
    }
}
