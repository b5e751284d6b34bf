//! Linear plants behind a hold in numbers of some hundred bits, so that poles of any speed against the sample keep their digits.
//! ```text
//! a pole p is 1 − w·e^(pT) of the denominator: in 53 bits e^(−1e3) is lost beside e^(−1e−3), or the other beside its inverse
//! ```

use crate::records::largest;
use dashu_float::{FBig, round::mode::HalfEven};
use nalgebra::{DMatrix, DVector, RowDVector};
use std::{vec, vec::Vec};

pub(crate) type Wide = FBig<HalfEven, 2>;

/// Bits of a number: for each state 24, for poles of 1e-6 a sample, beside those of the doublings and of the result.
const BITS: usize = 200;
const BITS_A_STATE: usize = 24;
/// Bits of them that rounding may have touched.
const TOUCHED: usize = 100;
/// A matrix is halved until it is smaller than 2^−this.
const SMALL: i32 = 16;
/// Doublings at most: those of a fastest pole of 1e8 a sample.
const DOUBLINGS_MAX: i32 = 27 + SMALL;

fn bits(states: usize) -> usize {
    BITS + BITS_A_STATE * states
}

fn wide(value: f64, states: usize) -> Wide {
    let exact = Wide::try_from(value).unwrap_or(Wide::ZERO);
    exact.with_precision(bits(states)).value()
}

pub(crate) fn narrow(value: &Wide) -> f64 {
    value.to_f64().value()
}

pub(crate) fn identity(states: usize) -> DMatrix<Wide> {
    DMatrix::from_diagonal_element(states, states, wide(1.0, states))
}

/// Converts to [`Wide`] numbers.
pub(crate) fn matrix(matrix: &DMatrix<f64>) -> DMatrix<Wide> {
    let states = matrix.nrows();
    matrix.map(|value| wide(value, states))
}

pub(crate) fn row(row: &RowDVector<f64>) -> RowDVector<Wide> {
    row.map(|value| wide(value, row.len()))
}

pub(crate) fn column(column: &DVector<f64>) -> DVector<Wide> {
    column.map(|value| wide(value, column.len()))
}

/// [A, B; 0, 0], of which e^(Gt) is [e^(At), ∫₀^t e^(As)B ds; 0, 1].
pub(crate) struct Generator {
    states: usize,
    matrix: DMatrix<Wide>,
    /// log₂ of the largest sum of a column, for A alone.
    size: i32,
}

impl Generator {
    /// `None` of numbers that are too large.
    pub(crate) fn new(a: &DMatrix<f64>, b: &DVector<f64>) -> Option<Self> {
        let n = a.nrows();
        let columns = a.column_iter();
        let sums = columns.map(|column| column.iter().map(|x| x.abs()).sum::<f64>());
        let size = sums.fold(0.0, f64::max);
        let mut all = DMatrix::from_element(n + 1, n + 1, Wide::ZERO);
        all.view_mut((0, 0), (n, n)).copy_from(&matrix(a));
        let input = column(b);
        all.view_mut((0, n), (n, 1)).copy_from(&input);
        let usable = size.is_finite() && b.iter().all(|value| value.is_finite());
        usable.then_some(Self {
            states: n,
            matrix: all,
            size: if size > 0.0 {
                libm::ilogb(size) + 1
            } else {
                -1000
            },
        })
    }

    /// e^(At) − 1 and ∫₀^t e^(As)B ds; `None` where t is too long for the fastest pole.
    ///
    /// A series of what was halved often enough, doubled by E ← 2E + E².
    pub(crate) fn motion(&self, t: f64) -> Option<(DMatrix<Wide>, DVector<Wide>)> {
        let n = self.states;
        if t <= 0.0 {
            let nothing = DMatrix::from_element(n + 1, n + 1, Wide::ZERO);
            return Some(parted(&nothing, n));
        }
        let doublings = (self.size + libm::ilogb(t) + 1 + SMALL).max(0);
        if doublings > DOUBLINGS_MAX {
            return None;
        }
        let step = wide(t, n) * wide(libm::ldexp(1.0, -doublings), n);
        let small = self.matrix.map(|value| value * &step);
        let one = || wide(1.0, n);
        let identity = DMatrix::from_diagonal_element(n + 1, n + 1, one());
        // Terms until 2^(−16k)/k! is below the last bit.
        let terms = bits(n) as u32 / SMALL as u32;
        let inner = (2..=terms).rev().fold(identity.clone(), |sum, k| {
            let share = one() / wide(f64::from(k), n);
            &identity + (&small * sum).map(|value| value * &share)
        });
        let mut moved = small * inner;
        for _ in 0..doublings {
            let square = &moved * &moved;
            moved = &moved + &moved + square;
        }
        Some(parted(&moved, n))
    }
}

fn parted(moved: &DMatrix<Wide>, n: usize) -> (DMatrix<Wide>, DVector<Wide>) {
    (
        moved.view((0, 0), (n, n)).into_owned(),
        moved.view((0, n), (n, 1)).column(0).into_owned(),
    )
}

/// Denominator of C(1 − wΦ)⁻¹Γ in powers of v = 1 − w, and the numerator of each pair C, Γ; from Φ.
/// ```text
/// det(1 − wΦ) = Σ a_k w^k,   adj(1 − wΦ) = Σ R_k w^k,   R₀ = 1, a_k = −tr(ΦR_{k−1})/k, R_k = ΦR_{k−1} + a_k     (Faddeev–Le Verrier)
/// ```
pub(crate) fn in_v(
    transition: &DMatrix<Wide>,
    pairs: &[(RowDVector<Wide>, DVector<Wide>)],
) -> (Vec<Wide>, Vec<Vec<Wide>>) {
    let n = transition.nrows();
    let sum = |terms: &mut dyn Iterator<Item = Wide>| terms.fold(Wide::ZERO, |sum, x| sum + x);
    let one = || wide(1.0, n);
    let mut denominator = vec![one()];
    let mut numerators = vec![Vec::new(); pairs.len()];
    let mut adjoint = DMatrix::from_diagonal_element(n, n, one());
    for step in 1..=n {
        for (numerator, (c, input)) in numerators.iter_mut().zip(pairs) {
            let at_input = &adjoint * input;
            numerator.push(sum(&mut c.iter().zip(at_input.iter()).map(|(c, x)| c * x)));
        }
        let product = transition * &adjoint;
        let trace = sum(&mut product.diagonal().iter().cloned());
        let coefficient = -trace / wide(step as f64, n);
        adjoint = product + DMatrix::from_diagonal_element(n, n, coefficient.clone());
        denominator.push(coefficient);
    }
    let numerators = numerators.iter().map(|numerator| shifted(numerator));
    (shifted(&denominator), numerators.collect())
}

/// `Σ c_k w^k` in powers of v = 1 − w, by Horner's scheme: p ← (1 − v)p + c.
fn shifted(coefficients: &[Wide]) -> Vec<Wide> {
    let mut in_v = vec![Wide::ZERO; coefficients.len()];
    for coefficient in coefficients.iter().rev() {
        for power in (1..in_v.len()).rev() {
            let lower = in_v[power - 1].clone();
            in_v[power] -= lower;
        }
        if let Some(first) = in_v.first_mut() {
            *first += coefficient;
        }
    }
    in_v
}

/// Values in 53 bits, without what only rounding made: it is to the largest as the last bits are.
pub(crate) fn rounded(values: &[Wide], states: usize) -> Vec<f64> {
    let values: Vec<f64> = values.iter().map(narrow).collect();
    let least = largest(&values) * libm::ldexp(1.0, TOUCHED as i32 - bits(states) as i32);
    let kept = |value: f64| if value.abs() < least { 0.0 } else { value };
    values.into_iter().map(kept).collect()
}
