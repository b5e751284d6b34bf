//! A record, and the numbers of a function that are free when it is fitted to one.

use crate::autoregression::Autoregression;
use fracdiff::Seconds;
use fractional_control::{ControlError, FractionalTransferFunction};
use std::borrow::Cow;

/// No function of these terms comes near the record.
pub(crate) const UNFIT: ControlError = ControlError::NotFound {
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
    /// A known one, and an output that is read just before its row's new input: the limit from above. It matters to a plant that answers at once.
    JustAfter(Seconds),
}

impl DeadTime {
    /// No dead time, which stays so.
    pub const NONE: Self = Self::Known(Seconds(0.0));

    /// The known dead time, or where the search begins, s.
    #[must_use]
    pub const fn seconds(self) -> f64 {
        match self {
            Self::Known(Seconds(s)) | Self::From(Seconds(s)) | Self::JustAfter(Seconds(s)) => s,
        }
    }

    /// True if the dead time is searched for.
    #[must_use]
    pub const fn is_free(self) -> bool {
        matches!(self, Self::From(_))
    }
}

/// State of a plant when its record begins, all of it linear once G is given:
/// ```text
/// y = c + G·(u − u_p) + Σ x_i·r_i(t),   r_i the free motions of G
/// ```
/// *Source*: of their projection, G. H. Golub, V. Pereyra, *Separable nonlinear least squares*, Inverse Problems 19, 2003.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StartState {
    /// Rest, input and output counted from there.
    #[default]
    Rest,
    /// Rest without an input, at an output c that is to be found.
    Offset,
    /// Settled at an input `u_p` that is to be found, as is c.
    Settled,
    /// Motion: c, which with an integrator is among its states, all states, and what acted within the dead time are to be found. A function of
    /// other than whole orders has no finite state, so it counts as settled.
    Moving,
}

impl StartState {
    /// Number of values fitted with a function of whole orders that has `states` states; `late` if its dead time is longer than a sample.
    pub(crate) const fn numbers(self, states: usize, integrates: bool, late: bool) -> usize {
        match self {
            Self::Rest => 0,
            Self::Offset => 1,
            Self::Settled => 2,
            Self::Moving => states + late as usize + !integrates as usize,
        }
    }
}

/// A record: input and output at the same instants.
#[derive(Clone, Copy, Debug)]
pub struct InputOutputRecord<'a> {
    /// T from each sample to the next, or their mean.
    pub sample_time: Seconds,
    /// The time of each sample, s, where they are not evenly spaced; else nothing.
    pub time_s: &'a [f64],
    /// u, one value a sample, in any unit.
    pub input: &'a [f64],
    /// y, one value a sample, read at the times of u.
    pub output: &'a [f64],
    /// True if u is a command that was held from its sample to the next, as in a step; false for a smooth signal that was sampled.
    pub held: bool,
    /// Sets how much later the input acts; it must be shorter than the record.
    pub dead_time: DeadTime,
    /// State of the plant when the record begins.
    pub start: StartState,
    /// The noise that a fit expects in the residual: the sum of squares of the whitened residual is minimised.
    pub noise: Autoregression,
}

/// Distance from whole samples, in samples, below which a dead time counts as whole.
const WHOLE: f64 = 1e-9;

impl InputOutputRecord<'_> {
    /// The dead time, in samples.
    pub(super) fn late(&self) -> f64 {
        self.dead_time.seconds() / self.sample_time.0
    }

    /// Further delay of the input after the dead time, in samples: the smallest number above 0, or 0.
    pub(super) fn after(&self) -> f64 {
        match self.dead_time {
            DeadTime::JustAfter(_) => f64::MIN_POSITIVE,
            DeadTime::Known(_) | DeadTime::From(_) => 0.0,
        }
    }

    /// The input delayed by `late` samples: moved by whole samples, and the remaining part of a sample.
    pub(super) fn acting(&self, late: f64) -> (Cow<'_, [f64]>, f64) {
        let nearest = libm::round(late);
        let is_whole = (late - nearest).abs() < WHOLE;
        let whole = if is_whole { nearest } else { libm::floor(late) };
        let part = if is_whole { self.after() } else { late - whole };
        let samples = self.input.len();
        let whole = (whole as usize).min(samples);
        if whole == 0 {
            return (Cow::Borrowed(self.input), part);
        }
        let early = self.input[..samples - whole].iter();
        let moved = core::iter::repeat_n(&0.0, whole).chain(early);
        (Cow::Owned(moved.copied().collect()), part)
    }

    /// The acting input at each sample.
    pub(crate) fn now(&self) -> Vec<f64> {
        self.now_late(self.late())
    }

    /// The acting input at each sample, delayed by `late` samples.
    pub(super) fn now_late(&self, late: f64) -> Vec<f64> {
        if self.time_s.is_empty() {
            let (input, part) = self.acting(late);
            return now(&input, part, self.held).collect();
        }
        let late_s = late * self.sample_time.0;
        self.time_s.iter().map(|t| self.at(t - late_s)).collect()
    }

    /// The input at any time of a record that is not evenly spaced.
    pub(super) fn at(&self, t: f64) -> f64 {
        let is_after = self.after() > 0.0;
        let acts = |switch: &f64| *switch < t || (*switch <= t && !is_after);
        let next = self.time_s.partition_point(acts);
        let before = next.checked_sub(1).map(|last| self.input[last]);
        match (before, self.input.get(next)) {
            (Some(u), Some(later)) if !self.held => {
                let [from, to] = [self.time_s[next - 1], self.time_s[next]];
                u + (later - u) * (t - from) / (to - from)
            }
            (Some(u), _) => u,
            (None, first) => first.filter(|_| !self.held).copied().unwrap_or(0.0),
        }
    }
}

/// The acting input at each sample: u where it was last held, or on the line between two samples.
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
pub(crate) enum Free {
    /// Coefficients, of which signs stay, and orders that are not 0.
    All,
    Coefficients,
    /// Coefficients above, and the dead time.
    Above,
}

impl Free {
    /// True of a function that runs without a rule throughout the fit.
    pub(super) fn runs_exactly(self, guess: &FractionalTransferFunction) -> bool {
        self != Self::All && guess.is_whole()
    }
}

/// True of a function that answers at once: its highest orders above and below are one.
pub(crate) fn answers_at_once(function: &FractionalTransferFunction) -> bool {
    function.numerator().degree() >= function.denominator().degree()
}

/// All but the last coefficient of the denominator, orders of 0, and the highest above of a function that answers at once.
pub(crate) fn free_numbers(guess: &FractionalTransferFunction, freedom: Free) -> Vec<FreeNumber> {
    let mut free = Vec::new();
    let is_free = |order: f64| order > 0.0 && freedom == Free::All;
    for (n, term) in guess.numerator().terms().iter().enumerate() {
        free.push(FreeNumber::NumeratorCoefficient(n));
        if is_free(term.order) && !(n == 0 && answers_at_once(guess)) {
            free.push(FreeNumber::NumeratorOrder(n));
        }
    }
    let terms = guess.denominator().terms();
    for (n, term) in terms.iter().enumerate() {
        if n + 1 < terms.len() && freedom != Free::Above {
            free.push(FreeNumber::DenominatorCoefficient(n));
        }
        if is_free(term.order) {
            free.push(FreeNumber::DenominatorOrder(n));
        }
    }
    free
}
