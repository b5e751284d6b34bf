//! The operator a [`Scheme`](super::Scheme) makes.

use super::sizes::{DEGREE_MAX, FULL_MODES, FULL_TAPS};
use crate::list::Form;
use crate::{
    Differintegrator, FrequencyResponse, FullMemory, FullMemoryHistory, MuirHistory,
    MuirPolynomial, Oustaloup, OustaloupHistory, PartitionedHistory, PartitionedMemory, Real,
    ShortHistoryVec, ShortMemoryVec, TustinMuir, TustinMuirHistory,
};
use num_complex::Complex;
use std::boxed::Box;
use std::vec::Vec;

/// Any operator, chosen at run time; on the heap.
///
/// A history belongs to the operator that made it. Given the history of another kind, `output` is
/// NaN and `advance` does nothing: no panic in a sample path, and nothing that looks like a result.
///
/// ```
/// use fracdiff::{Differintegrator, Operator, Order, Scheme, Seconds};
///
/// let scheme: Scheme = "grunwald:100".parse()?;
/// let operator: Operator<f64> = scheme.build(Order::new(1.0)?, Seconds(0.5), 1e3)?;
/// let mut history = operator.at_rest();
/// operator.advance(&mut history, 1.0);
/// assert_eq!(operator.output(&history, 2.0), 2.0); // (2 − 1)/0.5 s
/// # Ok::<(), fracdiff::SchemeError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Operator<F> {
    /// `grunwald:N`, N up to [`SHORT_MOST`](super::sizes::SHORT_MOST).
    ShortMemory(ShortMemoryVec<F>),
    /// `grunwald:N`, N beyond.
    PartitionedMemory(PartitionedMemory<F>),
    /// `muir:N`.
    MuirPolynomial(Box<MuirPolynomial<F, DEGREE_MAX>>),
    /// `tustin-muir:N`.
    TustinMuir(Box<TustinMuir<F, DEGREE_MAX>>),
    /// `oustaloup:N:LOW_HZ:HIGH_HZ`.
    Oustaloup(Box<Oustaloup<F, DEGREE_MAX>>),
    /// `full` and `piecewise-linear`.
    FullMemory(Box<FullMemory<F, FULL_TAPS, FULL_MODES>>),
}

/// History of [`Operator`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = "F: Real"))]
#[non_exhaustive]
pub enum OperatorHistory<F> {
    /// Of `grunwald:N`, short.
    ShortMemory(ShortHistoryVec<F>),
    /// Of `grunwald:N`, long.
    PartitionedMemory(PartitionedHistory<F>),
    /// Of `muir:N`.
    MuirPolynomial(Box<MuirHistory<F, DEGREE_MAX>>),
    /// Of `tustin-muir:N`.
    TustinMuir(Box<TustinMuirHistory<F, DEGREE_MAX>>),
    /// Of `oustaloup:N:LOW_HZ:HIGH_HZ`.
    Oustaloup(Box<OustaloupHistory<F, DEGREE_MAX>>),
    /// Of `full` and `piecewise-linear`.
    FullMemory(Box<FullMemoryHistory<F, FULL_TAPS, FULL_MODES>>),
}

/// Evaluates one expression for whichever operator it is.
macro_rules! each {
    ($self:expr, $operator:ident => $value:expr) => {
        match $self {
            Operator::ShortMemory($operator) => $value,
            Operator::PartitionedMemory($operator) => $value,
            Operator::MuirPolynomial($operator) => $value,
            Operator::TustinMuir($operator) => $value,
            Operator::Oustaloup($operator) => $value,
            Operator::FullMemory($operator) => $value,
        }
    };
}

/// The same for an operator with its own history; `$otherwise` for the history of another kind.
macro_rules! each_with_history {
    ($self:expr, $history:expr, ($operator:ident, $own:ident) => $value:expr, $otherwise:expr) => {
        match ($self, $history) {
            (Operator::ShortMemory($operator), OperatorHistory::ShortMemory($own)) => $value,
            (Operator::PartitionedMemory($operator), OperatorHistory::PartitionedMemory($own)) => {
                $value
            }
            (Operator::MuirPolynomial($operator), OperatorHistory::MuirPolynomial($own)) => $value,
            (Operator::TustinMuir($operator), OperatorHistory::TustinMuir($own)) => $value,
            (Operator::Oustaloup($operator), OperatorHistory::Oustaloup($own)) => $value,
            (Operator::FullMemory($operator), OperatorHistory::FullMemory($own)) => $value,
            _ => $otherwise,
        }
    };
}

/// An operator as numbers, see [`portable`](crate::portable).
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct OperatorList<F> {
    /// The meaning of the values.
    pub form: Form,
    /// Differences (> 0) or sums (< 0) around them.
    pub integer: i8,
    /// The values.
    pub values: Vec<F>,
}

impl<F: Real> OperatorList<F> {
    /// Number of modes, fastest first, that are run without a compensation word, padding included; 0 for other forms.
    /// Whoever runs a list with other code needs it for the same bits.
    #[must_use]
    pub fn plain_modes(&self) -> usize {
        match self.form {
            Form::Modes => crate::full_memory::plain_modes(&self.values, self.integer.into()),
            _ => 0,
        }
    }
}

impl<F: Real> Operator<F> {
    /// The operator as numbers, for [`PortableOperator`](crate::PortableOperator).
    #[must_use]
    pub fn list(&self) -> OperatorList<F> {
        let (form, (integer, values)) = match self {
            Self::ShortMemory(o) => (Form::Taps, (0, o.list())),
            Self::PartitionedMemory(o) => (Form::Taps, (0, o.list())),
            Self::MuirPolynomial(o) => (Form::Taps, (0, o.list())),
            Self::TustinMuir(o) => (Form::Recursion, o.list()),
            Self::Oustaloup(o) => (Form::Sections, o.list()),
            Self::FullMemory(o) => (Form::Modes, o.list()),
        };
        OperatorList {
            form,
            // −2 to 2, as orders are.
            integer: integer as i8,
            values,
        }
    }
}

impl<F: Real> Differintegrator<F> for Operator<F> {
    type History = OperatorHistory<F>;

    fn at_rest(&self) -> OperatorHistory<F> {
        match self {
            Self::ShortMemory(o) => OperatorHistory::ShortMemory(o.at_rest()),
            Self::PartitionedMemory(o) => OperatorHistory::PartitionedMemory(o.at_rest()),
            Self::MuirPolynomial(o) => OperatorHistory::MuirPolynomial(Box::new(o.at_rest())),
            Self::TustinMuir(o) => OperatorHistory::TustinMuir(Box::new(o.at_rest())),
            Self::Oustaloup(o) => OperatorHistory::Oustaloup(Box::new(o.at_rest())),
            Self::FullMemory(o) => OperatorHistory::FullMemory(Box::new(o.at_rest())),
        }
    }

    fn settled(&self, x: F) -> Option<OperatorHistory<F>> {
        Some(match self {
            Self::ShortMemory(o) => OperatorHistory::ShortMemory(o.settled(x)?),
            Self::PartitionedMemory(o) => OperatorHistory::PartitionedMemory(o.settled(x)?),
            Self::MuirPolynomial(o) => OperatorHistory::MuirPolynomial(Box::new(o.settled(x)?)),
            Self::TustinMuir(o) => OperatorHistory::TustinMuir(Box::new(o.settled(x)?)),
            Self::Oustaloup(o) => OperatorHistory::Oustaloup(Box::new(o.settled(x)?)),
            Self::FullMemory(o) => OperatorHistory::FullMemory(Box::new(o.settled(x)?)),
        })
    }

    #[inline]
    fn direct_gain(&self) -> F {
        each!(self, operator => operator.direct_gain())
    }

    #[inline]
    fn past(&self, history: &OperatorHistory<F>) -> F {
        each_with_history!(
            self, history,
            (operator, own) => operator.past(own),
            F::from_f64(f64::NAN)
        )
    }

    #[inline]
    fn output(&self, history: &OperatorHistory<F>, x: F) -> F {
        each_with_history!(
            self, history,
            (operator, own) => operator.output(own, x),
            F::from_f64(f64::NAN)
        )
    }

    #[inline]
    fn advance(&self, history: &mut OperatorHistory<F>, x: F) {
        each_with_history!(self, history, (operator, own) => operator.advance(own, x), ());
    }

    fn memory_length(&self) -> Option<usize> {
        each!(self, operator => operator.memory_length())
    }
}

impl<F: Real> FrequencyResponse for Operator<F> {
    fn response(&self, theta: f64) -> Complex<f64> {
        each!(self, operator => operator.response(theta))
    }
}
