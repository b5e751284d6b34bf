//! Linear plants as matrices, and their exact samples behind a hold, a delay and a lag.

use crate::{
    ControlError, FractionalTransferFunction,
    wide::{self, Generator},
};
use fracdiff::parameter::{RangeError, not_negative, range};
use nalgebra::{
    DMatrix, DVector, RowDVector, SMatrix, SVector, linalg::balancing::balance_parlett_reinsch,
};
use num_complex::Complex;
use std::vec::Vec;

/// ẋ = Ax + Bu, y = Cx, strictly proper; u through an actuator of the time constant τ.
#[derive(Clone, Debug, PartialEq)]
pub struct StateSpace {
    pub(crate) a: DMatrix<f64>,
    pub(crate) b: DVector<f64>,
    pub(crate) c: RowDVector<f64>,
}

/// Numbers of a sampled plant: e^300, of which a loop can be squared.
const LARGEST: f64 = 1e130;
/// Largest size of an entry, as that of the coefficients of a function.
const SIZE_MAX_IN_WORDS: &str = "at most 1e60 in size: give the plant in other units";
const STATES_MAX: f64 = 16.0;

impl StateSpace {
    /// Plant from its matrices.
    ///
    /// # Errors
    /// Sizes that do not fit, no state or more than 16, a number above 1e60 in size.
    pub fn new(a: DMatrix<f64>, b: DVector<f64>, c: RowDVector<f64>) -> Result<Self, ControlError> {
        let states = a.nrows() as f64;
        let fits = a.ncols() == a.nrows() && b.len() == a.nrows() && c.len() == a.nrows();
        let inside = fits && (1.0..=STATES_MAX).contains(&states);
        let allowed = "1 to 16, the same in A, B and C";
        range("number of states", states, inside, allowed, "")?;
        for value in a.iter().chain(b.iter()).chain(c.iter()) {
            let inside = value.abs() <= 1e60;
            range("element of a matrix", *value, inside, SIZE_MAX_IN_WORDS, "")?;
        }
        Ok(Self { a, b, c })
    }

    /// The matrices of a function whose orders are whole and at most 16, and its direct gain, not 0 for equal degrees:
    /// `None` for any other. A gain alone has no states.
    #[must_use]
    pub fn of_function(function: &FractionalTransferFunction) -> Option<(Self, f64)> {
        let (above, below) = (function.numerator(), function.denominator());
        let degree = below.degree();
        if !function.is_whole() || above.degree() > degree || degree > STATES_MAX {
            return None;
        }
        let n = degree as usize;
        let leading = below.terms().first()?.coefficient;
        let highest = above.terms().first()?;
        let direct = if highest.order < degree {
            0.0
        } else {
            highest.coefficient / leading
        };
        // Controllable canonical form: xᵢ is the i-th derivative of the first.
        let mut a = DMatrix::zeros(n, n);
        for row in 1..n {
            a[(row - 1, row)] = 1.0;
        }
        let mut c = RowDVector::zeros(n);
        for term in above.terms().iter().filter(|term| term.order < degree) {
            c[term.order as usize] = term.coefficient / leading;
        }
        for term in below.terms().iter().skip(1) {
            a[(n - 1, term.order as usize)] = -term.coefficient / leading;
            c[term.order as usize] -= direct * (term.coefficient / leading);
        }
        let mut b = DVector::zeros(n);
        b.iter_mut().skip(n.max(1) - 1).for_each(|last| *last = 1.0);
        Some((Self { a, b, c }, direct))
    }

    /// C, by which the states make the output.
    #[must_use]
    pub const fn output(&self) -> &RowDVector<f64> {
        &self.c
    }

    /// The states of Aᵀ without an input: from C on they are C·e^(At), the free motion from each state at once.
    #[must_use]
    pub fn transposed(&self) -> Self {
        Self {
            a: self.a.transpose(),
            b: DVector::zeros(self.c.len()),
            c: self.c.clone(),
        }
    }

    /// Puts the plant behind an actuator, τ·ḟ = u − f, which applies f instead of u. A lag of 0
    /// means no lag.
    ///
    /// # Errors
    /// A negative lag, and one above 0 and below 1e-15 s.
    pub fn behind_lag(self, lag_s: f64) -> Result<Self, ControlError> {
        if not_negative("lag", lag_s, "s")? == 0.0 {
            return Ok(self);
        }
        range("lag", lag_s, lag_s >= 1e-15, "0, or at least 1e-15 {}", "s")?;
        self.fed_by(-1.0 / lag_s, 1.0 / lag_s)
    }

    /// Makes the input one state more, the last: f = its input, f′ = `own`·f + `gain`·u.
    pub(crate) fn fed_by(&self, pole: f64, gain: f64) -> Result<Self, ControlError> {
        let n = self.a.nrows();
        let mut a = DMatrix::zeros(n + 1, n + 1);
        a.view_mut((0, 0), (n, n)).copy_from(&self.a);
        a.view_mut((0, n), (n, 1)).copy_from(&self.b);
        a[(n, n)] = pole;
        let mut b = DVector::zeros(n + 1);
        b[n] = gain;
        let mut c = RowDVector::zeros(n + 1);
        c.view_mut((0, 0), (1, n)).copy_from(&self.c);
        Self::new(a, b, c)
    }

    /// Shows each state from these first ones on, from rest without any, for an input that is held from its sample to the next, or runs in a straight line, and acts by
    /// `fraction` of a sample later: exactly, for the switch inside a sample parts the integral.
    ///
    /// # Errors
    /// A pole that is faster than 30 time constants a sample.
    pub fn run(
        &self,
        sample_time: f64,
        input: &[f64],
        fraction: f64,
        held: bool,
        first: &[f64],
        seen: &mut dyn FnMut(usize, &[f64]),
    ) -> Result<(), ControlError> {
        let from = |begin: DVector<f64>| begun(begin, first);
        if held {
            let sampled = self.sampled(sample_time, fraction)?;
            let begin = from(sampled.at_rest());
            sampled.run(begin, &mut input.iter().copied(), seen);
            return Ok(());
        }
        // The slope of the input feeds the input.
        let sampled = self.fed_by(0.0, 1.0)?.sampled(sample_time, fraction)?;
        let mut begin = from(sampled.at_rest());
        if let (Some(last), Some(first)) = (begin.iter_mut().last(), input.first()) {
            *last = *first;
        }
        let next = input.iter().skip(1).chain(input.last());
        let mut slopes = input
            .iter()
            .zip(next)
            .map(|(now, next)| (next - now) / sample_time);
        sampled.run(begin, &mut slopes, seen);
        Ok(())
    }

    /// The response C(jω − A)⁻¹B at ω, rad/s.
    #[must_use]
    pub fn response(&self, omega: f64) -> Complex<f64> {
        let n = self.a.nrows();
        let matrix = DMatrix::from_fn(n, n, |row, column| {
            let diagonal = if row == column { omega } else { 0.0 };
            Complex::new(-self.a[(row, column)], diagonal)
        });
        let b = self.b.map(|b| Complex::new(b, 0.0));
        let nan = Complex::new(f64::NAN, f64::NAN);
        let states = matrix.lu().solve(&b);
        states.map_or(nan, |x| {
            x.iter().zip(self.c.iter()).map(|(x, c)| x * c).sum()
        })
    }

    /// Number of eigenvalues with Re s > 0, and of unknown ones. An eigenvalue that is 0 within rounding does not count: a free mass has
    /// one at 0.
    #[must_use]
    pub fn unstable_poles(&self) -> usize {
        let rounding = 4.0 * f64::EPSILON * self.a.nrows() as f64 * self.a.norm();
        self.poles_from(rounding.max(f64::MIN_POSITIVE))
    }

    /// Number of eigenvalues that do not decay, or decay more slowly than rounding resolves.
    pub(crate) fn undamped_poles(&self) -> usize {
        let rounding = 1e-12 * self.a.norm();
        self.poles_from(-rounding)
    }

    fn poles_from(&self, edge: f64) -> usize {
        let poles = self.poles();
        let right = |pole: &&Complex<f64>| pole.re.is_nan() || pole.re >= edge;
        poles.iter().filter(right).count()
    }

    pub(crate) fn poles(&self) -> Vec<Complex<f64>> {
        let balanced = self.balanced();
        let a = balanced.as_ref().map_or(&self.a, |scaled| &scaled.a);
        fracdiff::eigenvalues(a.as_slice(), a.nrows())
    }

    /// e^(At) − 1 and ∫₀^t e^(As)B ds.
    pub(crate) fn motion(&self, t: f64) -> (DMatrix<f64>, DVector<f64>) {
        let (state, input) = fracdiff::linear_motion(self.a.as_slice(), self.b.as_slice(), t);
        let n = self.a.nrows();
        (DMatrix::from_vec(n, n, state), input.into())
    }

    /// The samples behind a hold, for a delay of `fraction` of a sample, in 53 bits: for fits, which try thousands, and for poles that are not
    /// faster than 30 time constants a sample. Loops take [`held`](Self::held).
    fn sampled(&self, sample_time: f64, fraction: f64) -> Result<SampledStates, ControlError> {
        let n = self.a.nrows();
        let (moved, whole) = self.motion(sample_time);
        // Nothing happens in so short a part of a sample.
        let (newest, last) = if fraction <= f64::MIN_POSITIVE {
            (whole, DVector::zeros(n))
        } else {
            let (late_moved, newest) = self.motion((1.0 - fraction) * sample_time);
            let (_, early) = self.motion(fraction * sample_time);
            let last = &early + &late_moved * &early;
            (newest, last)
        };
        let transition = &moved + DMatrix::identity(n, n);
        let norm = transition
            .try_inverse()
            .map_or(f64::INFINITY, |inverse| inverse.norm());
        if norm.is_nan() || norm >= 1e13 {
            let allowed = "at most 30 time constants of the fastest pole: leave that pole or lag out, or sample faster";
            return Err(RangeError::new("sample time", sample_time, allowed, "s").into());
        }
        Ok(SampledStates {
            moved,
            newest,
            last,
            c: self.c.clone(),
        })
    }

    /// The samples behind a hold, for a delay of `fraction` of a sample, whatever the speed of the poles, and the same as a function of v.
    /// The states are scaled.
    ///
    /// # Errors
    /// A pole that moves by more than e^(10^8) in a sample, or poles that grow by more than e^300.
    pub(crate) fn held(
        &self,
        sample_time: f64,
        fraction: f64,
    ) -> Result<(SampledStates, StatesInV), ControlError> {
        let refused = || {
            let allowed = "within 1e8 time constants of the fastest pole, 300 of those that grow: leave that pole or lag out, or sample faster";
            RangeError::new("sample time", sample_time, allowed, "s")
        };
        let scaled = self.balanced().ok_or_else(refused)?;
        let n = scaled.a.nrows();
        let generator = Generator::new(&scaled.a, &scaled.b).ok_or_else(refused)?;
        let (late_moved, newest) =
            (generator.motion((1.0 - fraction) * sample_time)).ok_or_else(refused)?;
        let (early_moved, early) =
            (generator.motion(fraction * sample_time)).ok_or_else(refused)?;
        let last = &early + &late_moved * &early;
        let moved = &late_moved + &early_moved + &late_moved * &early_moved;
        let c = wide::row(&scaled.c);
        let transition = &moved + wide::identity(n);
        let pairs = [(c.clone(), newest.clone()), (c, last.clone())];
        let (below, above) = wide::in_v(&transition, &pairs);
        let mut above = above.iter().map(|numerator| wide::rounded(numerator, n));
        let mut next = || above.next().unwrap_or_default();
        let in_v = StatesInV {
            below: wide::rounded(&below, n),
            above: [next(), next()],
        };
        let sampled = SampledStates {
            moved: moved.map(|value| wide::narrow(&value)),
            newest: newest.map(|value| wide::narrow(&value)),
            last: last.map(|value| wide::narrow(&value)),
            c: scaled.c,
        };
        let numbers = in_v.below.iter().chain(in_v.above.iter().flatten());
        let mut numbers = numbers
            .chain(sampled.moved.iter())
            .chain(sampled.newest.iter());
        if numbers.all(|value| value.abs() < LARGEST) {
            Ok((sampled, in_v))
        } else {
            Err(refused().into())
        }
    }

    /// Scales the states by powers of two so that A is as small as possible; `None` if a number is too large for that.
    fn balanced(&self) -> Option<Self> {
        // Squares of these are numbers too.
        let usable = self.a.iter().all(|value| value.abs() < 1e150);
        if !usable {
            return None;
        }
        let mut a = self.a.clone();
        let units = if a.nrows() > 0 {
            balance_parlett_reinsch(&mut a)
        } else {
            DVector::from_element(a.nrows(), 1.0)
        };
        let b = self.b.component_div(&units);
        let c = self.c.component_mul(&units.transpose());
        let finite = b.iter().chain(c.iter()).all(|value| value.is_finite());
        finite.then_some(Self { a, b, c })
    }
}

/// States of which the first ones are these.
pub(crate) fn begun(mut states: DVector<f64>, first: &[f64]) -> DVector<f64> {
    states
        .iter_mut()
        .zip(first)
        .for_each(|(x, first)| *x = *first);
    states
}

/// x\[n+1\] = Φx\[n\] + Γ₀u\[n\] + Γ₁u\[n−1\], y = Cx.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SampledStates {
    /// Φ − 1.
    moved: DMatrix<f64>,
    newest: DVector<f64>,
    last: DVector<f64>,
    c: RowDVector<f64>,
}

/// C(1 − wΦ)⁻¹Γ in powers of v = 1 − w: the denominator, and the numerators of Γ₀ and Γ₁.
pub(crate) struct StatesInV {
    pub below: Vec<f64>,
    pub above: [Vec<f64>; 2],
}

impl SampledStates {
    pub(crate) fn at_rest(&self) -> DVector<f64> {
        DVector::zeros(self.c.len())
    }

    pub(crate) fn output(&self, x: &DVector<f64>) -> f64 {
        (&self.c * x)[0]
    }

    pub(crate) fn advance(&self, x: &mut DVector<f64>, newest: f64, last: f64) {
        let change = &self.moved * &*x + &self.newest * newest + &self.last * last;
        *x += change;
    }

    /// Shows each state from this one on, an input a sample, 0 before the first.
    fn run(
        &self,
        begin: DVector<f64>,
        inputs: &mut dyn Iterator<Item = f64>,
        seen: &mut dyn FnMut(usize, &[f64]),
    ) {
        // Few states of a known number run several times as fast.
        match begin.len() {
            1 => self.run_sized::<1>(&begin, inputs, seen),
            2 => self.run_sized::<2>(&begin, inputs, seen),
            3 => self.run_sized::<3>(&begin, inputs, seen),
            4 => self.run_sized::<4>(&begin, inputs, seen),
            5 => self.run_sized::<5>(&begin, inputs, seen),
            _ => {
                let (mut x, mut before) = (begin, 0.0);
                for (sample, input) in inputs.enumerate() {
                    seen(sample, x.as_slice());
                    self.advance(&mut x, input, before);
                    before = input;
                }
            }
        }
    }

    fn run_sized<const N: usize>(
        &self,
        begin: &DVector<f64>,
        inputs: &mut dyn Iterator<Item = f64>,
        seen: &mut dyn FnMut(usize, &[f64]),
    ) {
        let moved: SMatrix<f64, N, N> = self.moved.fixed_view::<N, N>(0, 0).into_owned();
        let newest: SVector<f64, N> = self.newest.fixed_rows::<N>(0).into_owned();
        let last: SVector<f64, N> = self.last.fixed_rows::<N>(0).into_owned();
        let mut x: SVector<f64, N> = begin.fixed_rows::<N>(0).into_owned();
        let mut before = 0.0;
        for (sample, input) in inputs.enumerate() {
            seen(sample, x.as_slice());
            x += moved * x + newest * input + last * before;
            before = input;
        }
    }
}
