//! An operator as a list of numbers: designed where there is room, run where there is not.
//! ```text
//! form        values                                        made by
//! Taps        g, k₁, …, k_{n−1}                             ShortMemory, MuirPolynomial
//! Modes       g, k₁, …, k₁₅, d₁, W₁, d₂, W₂, …              FullMemory of 16 taps, Oustaloup; fastest mode first
//! Recursion   g, b₁, a₁, b₂, a₂, …                          TustinMuir
//! ```
//! A recursion in which each `b_i` is (−1)^i·g·`a_i` to the last bit, as in those of `TustinMuir`, takes half the
//! multiplications.
//! A host designs D^μ in `f64`, rounds it once ([`Operator::list`](crate::Operator::list)) and sends the
//! list; the device runs it with [`PortableOperator`], bit for bit like the host.

use crate::differintegrator::{forward_differintegrator, one_of};
use crate::fir::FirHistory;
use crate::full_memory::{Bank, BankHistory, PORTABLE_TAPS};
use crate::integer_part::{IntegerHistory, WithIntegerPart};
pub use crate::list::{Form, ListError};
use crate::list::{check_finite, check_integer};
use crate::tustin_muir::{Recursion, RecursionHistory};
use crate::{Differintegrator, Fir, Real};

/// An operator from a list of values, of any [`Form`] within its capacity: TAPS taps, MODES modes (a
/// multiple of 8), DEGREE degrees of a recursion.
///
/// - *Same bits* as the operator from which the list was made.
/// - *Checked*: every value finite, every decay in (0, 1], counts within the capacity. A list does
///   not show whether the response is D^μ.
/// - *Start-up, not finite, cost*: as the operator from which the list was made. The history of
///   another form gives NaN, and never panics.
/// ```
/// use fracdiff::portable::{Form, PortableOperator};
/// use fracdiff::Differintegrator;
///
/// // As it came over a line: y[n] = 2·x[n] − x[n−1].
/// let received = [2.0, -1.0];
/// let operator = PortableOperator::<f32, 256, 48, 16>::new(Form::Taps, 0, &received)?;
/// let mut history = operator.at_rest();
/// operator.advance(&mut history, 1.0);
/// assert_eq!(operator.output(&history, 3.0), 5.0);
/// # Ok::<(), fracdiff::portable::ListError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct PortableOperator<F, const TAPS: usize, const MODES: usize, const DEGREE: usize>(
    Core<F, TAPS, MODES, DEGREE>,
);

/// History of [`PortableOperator`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound = "F: Real"))]
#[non_exhaustive]
pub enum PortableHistory<F, const TAPS: usize, const MODES: usize, const DEGREE: usize> {
    /// History of [`Form::Taps`].
    Taps(FirHistory<F, TAPS>),
    /// History of [`Form::Modes`].
    Modes(IntegerHistory<F, BankHistory<F, PORTABLE_TAPS, MODES>>),
    /// History of [`Form::Recursion`].
    Recursion(IntegerHistory<F, RecursionHistory<F, DEGREE>>),
}

#[derive(Clone, Debug, PartialEq)]
enum Core<F, const TAPS: usize, const MODES: usize, const DEGREE: usize> {
    Taps(Fir<F, TAPS>),
    Modes(WithIntegerPart<Bank<F, PORTABLE_TAPS, MODES>>),
    Recursion(WithIntegerPart<Recursion<F, DEGREE>>),
}

impl<F: Real, const TAPS: usize, const MODES: usize, const DEGREE: usize>
    PortableOperator<F, TAPS, MODES, DEGREE>
{
    /// Builds the operator from its list.
    ///
    /// # Errors
    /// An invalid list, see [`ListError`].
    pub fn new(form: Form, integer: i8, values: &[F]) -> Result<Self, ListError> {
        let mut operator = Self::SILENT;
        operator.replace(form, integer, values)?;
        Ok(operator)
    }

    /// An operator whose output is zero, to be filled by [`replace`](Self::replace).
    pub const SILENT: Self = Self(Core::Taps(Fir::SILENT));

    /// Checks the same as [`new`](Self::new), but builds nothing.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn check(form: Form, integer: i8, values: &[F]) -> Result<(), ListError> {
        if form == Form::Taps && integer != 0 {
            return Err(ListError::IntegerPart(integer));
        }
        check_integer(integer)?;
        check_finite(values)?;
        match form {
            Form::Taps => Fir::<F, TAPS>::check(values),
            Form::Modes => Bank::<F, PORTABLE_TAPS, MODES>::parts(values).map(|_| ()),
            Form::Recursion => Recursion::<F, DEGREE>::check(values),
        }
    }

    /// Becomes the operator of this list, in its place: the same as [`new`](Self::new), on a stack without room for another
    /// one. A history of the operator before must be made anew, by [`rest`](Differintegrator::rest).
    ///
    /// # Errors
    /// As [`new`](Self::new); the operator is then unchanged.
    pub fn replace(&mut self, form: Form, integer: i8, values: &[F]) -> Result<(), ListError> {
        Self::check(form, integer, values)?;
        let integer = i32::from(integer);
        match form {
            Form::Taps => self.replace_taps(values),
            Form::Modes => self.replace_modes(values, integer),
            Form::Recursion => self.replace_recursion(values, integer),
        }
        Ok(())
    }

    // Each form on its own: a stack of a microcontroller has no room for the parts of all three at once.

    #[inline(never)]
    fn replace_taps(&mut self, values: &[F]) {
        if !matches!(self.0, Core::Taps(_)) {
            *self = Self::SILENT;
        }
        if let Core::Taps(core) = &mut self.0 {
            // It was checked.
            let _ = core.replace(values);
        }
    }

    #[inline(never)]
    fn replace_modes(&mut self, values: &[F], integer: i32) {
        if !matches!(self.0, Core::Modes(_)) {
            let core = Bank::SILENT;
            self.0 = Core::Modes(WithIntegerPart { integer: 0, core });
        }
        if let Core::Modes(core) = &mut self.0 {
            core.integer = integer;
            // It was checked.
            let _ = core.core.replace(values, integer);
        }
    }

    #[inline(never)]
    fn replace_recursion(&mut self, values: &[F], integer: i32) {
        let core = Recursion::SILENT;
        self.0 = Core::Recursion(WithIntegerPart { integer, core });
        if let Core::Recursion(core) = &mut self.0 {
            // It was checked.
            core.core.fill(values);
        }
    }

    /// Value `index` of the list; `None` past its end.
    #[must_use]
    pub fn value(&self, index: usize) -> Option<F> {
        match &self.0 {
            Core::Taps(core) => core.coefficients().get(index).copied(),
            Core::Modes(core) => core.core.value(index),
            Core::Recursion(core) => core.core.value(index),
        }
    }
}

// Each form of history on its own, as above.

#[inline(never)]
fn rest_as_taps<F: Real, const TAPS: usize, const MODES: usize, const DEGREE: usize>(
    history: &mut PortableHistory<F, TAPS, MODES, DEGREE>,
) {
    *history = const { PortableHistory::Taps(FirHistory::AT_REST) };
}

#[inline(never)]
fn rest_as_modes<F: Real, const TAPS: usize, const MODES: usize, const DEGREE: usize>(
    history: &mut PortableHistory<F, TAPS, MODES, DEGREE>,
) {
    let at_rest = IntegerHistory::at_rest(BankHistory::AT_REST);
    *history = PortableHistory::Modes(at_rest);
}

#[inline(never)]
fn rest_as<F: Real, C: Differintegrator<F>, H>(
    core: &C,
    form: impl FnOnce(C::History) -> H,
    history: &mut H,
) {
    *history = form(core.at_rest());
}

/// A step of one form. Not inlined: LLVM otherwise prepares for all forms before it looks which it is.
#[inline(never)]
fn advance_apart<F: Real, C: Differintegrator<F>>(core: &C, history: &mut C::History, x: F) {
    core.advance(history, x);
}

impl<F: Real, const TAPS: usize, const MODES: usize, const DEGREE: usize> Differintegrator<F>
    for Core<F, TAPS, MODES, DEGREE>
{
    type History = PortableHistory<F, TAPS, MODES, DEGREE>;

    fn rest(&self, history: &mut Self::History) {
        match (self, history) {
            (Self::Taps(_), PortableHistory::Taps(past)) => past.rest(),
            (Self::Taps(_), other) => rest_as_taps(other),
            (Self::Modes(core), PortableHistory::Modes(past)) => core.rest(past),
            (Self::Modes(_), other) => rest_as_modes(other),
            (Self::Recursion(core), other) => rest_as(core, PortableHistory::Recursion, other),
        }
    }

    one_of!(PortableHistory, advance_apart: Taps Modes Recursion);
}

impl<F: Real, const TAPS: usize, const MODES: usize, const DEGREE: usize> Differintegrator<F>
    for PortableOperator<F, TAPS, MODES, DEGREE>
{
    forward_differintegrator!(PortableHistory<F, TAPS, MODES, DEGREE>, self => self.0);

    fn rest(&self, history: &mut Self::History) {
        self.0.rest(history);
    }
}
