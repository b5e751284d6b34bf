//! A record, and the numbers of a function that are free when it is fitted to one.

use crate::{ControlError, FractionalTransferFunction};
use fracdiff::Seconds;
use std::borrow::Cow;
use std::vec::Vec;

/// No function of these terms comes near the record.
pub(super) const UNFIT: ControlError = ControlError::NotFound {
    what: "a function that fits the record",
    why: "begin from another guess, nearer in gain and time constant, or with other terms",
};

/// The dead time: how much later an input acts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DeadTime {
    /// A dead time that is known and stays.
    Known(Seconds),
    /// It is to be found, from here on.
    From(Seconds),
}

impl DeadTime {
    /// No dead time, which stays so.
    pub const NONE: Self = Self::Known(Seconds(0.0));

    /// The known dead time, or where the search begins, s.
    #[must_use]
    pub const fn seconds(self) -> f64 {
        match self {
            Self::Known(Seconds(s)) | Self::From(Seconds(s)) => s,
        }
    }

    /// True if the dead time is searched for.
    #[must_use]
    pub const fn is_free(self) -> bool {
        matches!(self, Self::From(_))
    }
}

/// What is known of a plant when its record begins: y = c + G·(u − `u_p`), and c and `u_p` are linear once G is given.
///
/// *Source*: of their projection, G. H. Golub, V. Pereyra, *Separable nonlinear least squares*, Inverse Problems 19, 2003.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Start {
    /// At rest, input and output counted from there.
    #[default]
    Rest,
    /// At rest without an input, at an output c that is to be found.
    Offset,
    /// Settled at an input `u_p` that is to be found, as is c.
    Settled,
}

impl Start {
    /// How many numbers are found with those of the function.
    pub(crate) const fn numbers(self) -> usize {
        self as usize
    }
}

/// A record: input and output at the same instants, T apart.
#[derive(Clone, Copy, Debug)]
pub struct Record<'a> {
    /// T, the same from each sample to the next.
    pub sample_time: Seconds,
    /// u, one a sample.
    pub input: &'a [f64],
    /// y, one a sample.
    pub output: &'a [f64],
    /// True if u is a command that was held from its sample to the next, as in a step; false for a smooth signal that was sampled.
    pub held: bool,
    /// Sets how much later the input acts; it must be shorter than the record.
    pub dead_time: DeadTime,
    /// Where the plant is when it begins.
    pub start: Start,
}

/// A dead time so near to whole samples, in samples, is that many.
const WHOLE: f64 = 1e-9;

impl Record<'_> {
    /// The dead time, in samples.
    pub(super) fn late(&self) -> f64 {
        self.dead_time.seconds() / self.sample_time.0
    }

    /// The input as it acts so many samples later: moved by whole samples, and the part of a sample that is left.
    pub(super) fn acting(&self, late: f64) -> (Cow<'_, [f64]>, f64) {
        let nearest = libm::round(late);
        let is_whole = (late - nearest).abs() < WHOLE;
        let whole = if is_whole { nearest } else { libm::floor(late) };
        let part = if is_whole { 0.0 } else { late - whole };
        let samples = self.input.len();
        let whole = (whole as usize).min(samples);
        if whole == 0 {
            return (Cow::Borrowed(self.input), part);
        }
        let early = self.input[..samples - whole].iter();
        let moved = core::iter::repeat_n(&0.0, whole).chain(early);
        (Cow::Owned(moved.copied().collect()), part)
    }

    /// What acts at each sample.
    pub(crate) fn now(&self) -> Vec<f64> {
        let (input, part) = self.acting(self.late());
        now(&input, part, self.held).collect()
    }
}

/// What acts at each sample: u where it was last held, or on the line between two samples.
pub(super) fn now(input: &[f64], part: f64, held: bool) -> impl Iterator<Item = f64> {
    // Half-way into a sample the one before is still held.
    let part = if held && part > 0.0 { 1.0 } else { part };
    let before = input.first().filter(|_| !held).unwrap_or(&0.0);
    let before = core::iter::once(before).chain(input);
    let pairs = input.iter().zip(before);
    pairs.map(move |(now, before)| (1.0 - part) * now + part * before)
}

/// A number of the function that was free.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FreeNumber {
    /// Coefficient of the n-th term of the numerator, highest order first; the error is relative.
    NumeratorCoefficient(usize),
    /// Order of the n-th term of the numerator; the error is absolute.
    NumeratorOrder(usize),
    /// Coefficient of the n-th term of the denominator; the error is relative.
    DenominatorCoefficient(usize),
    /// Order of the n-th term of the denominator; the error is absolute.
    DenominatorOrder(usize),
    /// The dead time; the error is in s.
    DeadTime,
}

/// The numbers of a function that a fit may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Free {
    /// Coefficients, of which signs stay, and orders that are not 0.
    All,
    Coefficients,
}

impl Free {
    /// True of a function that runs without a rule, and goes on to.
    pub(super) fn runs_exactly(self, guess: &FractionalTransferFunction) -> bool {
        self == Self::Coefficients && guess.is_whole()
    }
}

/// All but the last coefficient of the denominator, and orders of 0; the dead time last.
pub(super) fn free_numbers(
    guess: &FractionalTransferFunction,
    freedom: Free,
    dead_time: DeadTime,
) -> Vec<FreeNumber> {
    let mut free = Vec::new();
    let is_free = |order: f64| order > 0.0 && freedom == Free::All;
    for (n, term) in guess.numerator().terms().iter().enumerate() {
        free.push(FreeNumber::NumeratorCoefficient(n));
        if is_free(term.order) {
            free.push(FreeNumber::NumeratorOrder(n));
        }
    }
    let terms = guess.denominator().terms();
    for (n, term) in terms.iter().enumerate() {
        if n + 1 < terms.len() {
            free.push(FreeNumber::DenominatorCoefficient(n));
        }
        if is_free(term.order) {
            free.push(FreeNumber::DenominatorOrder(n));
        }
    }
    if dead_time.is_free() {
        free.push(FreeNumber::DeadTime);
    }
    free
}
