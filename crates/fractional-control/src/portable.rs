//! A controller as a list of numbers: designed where there is room, run where there is not.
//! ```text
//! form       numbers
//! Parallel   what a sample leaves of a bias, then k, w and the power of each: PI^λD^μ, TID
//! Lead       that too, g, p, q, then the power of each part: CRONE, lead–lag
//! power      the values of Form::Modes, then the coefficients of a filter
//! ```
//! A part of order 0 has no power. The filter is that of [`Rule::Bdf2`](crate::Rule::Bdf2), behind all powers of a list or none.
//! A host designs in `f64` and rounds once ([`ControllerList::portable`](crate::ControllerList::portable)).

use crate::{
    Controller, FractionalPid, LeadController, OnError, OnErrorHistory, ParallelHistory,
    controller::Stage,
    lead::{LeadPower, LeadPowerHistory},
    parallel::{BRANCHES, Branch, Kind, Parallel},
};
use fracdiff::{Bdf2Memory, Differintegrator, FullMemory, Real, portable::ListError};

/// Parts of a controller at most.
pub const CONTROLLER_PARTS: usize = BRANCHES;
/// Whole sections of a lead at most.
const SECTIONS_MAX: u8 = 2;

/// The meaning of a list of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PortableForm {
    /// Powers side by side: 1 to 3 parts.
    Parallel,
    /// A power of a lead of the error: a part for each memory, none if it is whole.
    Lead {
        /// Whole sections (1 − pw)/(1 − qw), 0 to 2.
        sections: u8,
    },
}

/// A part of a list.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PortablePart {
    /// Differences (> 0) or sums (< 0) around its power, −2 to 2.
    pub integer: i8,
    /// Values of its power; 0 without one.
    pub values: usize,
    /// Coefficients of its filter; 0 for another rule than BDF2.
    pub filter: usize,
}

/// A controller from a list of numbers, of MODES modes a power at most, a multiple of 8.
///
/// - *Same bits* as the [`FractionalPid`] or [`LeadController`] that the list is of.
/// - *Checked*: every number finite, every decay in (0, 1], p and q in [0, 1], counts as the form has them. That a good controller
///   comes of it cannot be seen from a list.
/// - *Start, anti-windup, not finite, cost*: as [`Controller`]; neither following nor changes without a bump.
/// ```
/// use fracdiff::Seconds;
/// use fractional_control::{ControllerList, ControllerSetup, PidParameters, PortableController};
///
/// let gains = PidParameters { proportional: 2.0, integral: 1.0, ..PidParameters::NONE };
/// let list = ControllerList::<f32>::new(&ControllerSetup::new(gains, Seconds(1e-3)))?;
/// let (form, parts, values) = list.portable();
/// let controller = PortableController::<f32>::new(form, &parts, &values, [-3.0, 3.0])?;
/// let mut history = controller.at_rest();
/// let command = controller.output(&history, 5.0, 0.0);
/// assert_eq!(command, 3.0);
/// controller.advance(&mut history, 5.0, 0.0, command);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct PortableController<F, const MODES: usize = 48>(Law<F, MODES>);

#[derive(Clone, Debug)]
enum Law<F, const MODES: usize> {
    Parallel(FractionalPid<F, MODES>),
    Lead(LeadController<F, MODES>),
}

/// History of [`PortableController`].
#[derive(Clone, Debug)]
pub struct PortableControllerHistory<F, const MODES: usize = 48>(Past<F, MODES>);

#[derive(Clone, Debug)]
enum Past<F, const MODES: usize> {
    Parallel(ParallelHistory<F, MODES>),
    Lead(OnErrorHistory<F, LeadPowerHistory<F, MODES>>),
}

impl<F: Real, const MODES: usize> PortableController<F, MODES> {
    /// Builds the controller from its list, with the lower and the upper limit of its command.
    ///
    /// # Errors
    /// An invalid list, see [`ListError`].
    #[inline(never)]
    pub fn new(
        form: PortableForm,
        parts: &[PortablePart],
        values: &[F],
        limits: [F; 2],
    ) -> Result<Self, ListError> {
        let mut numbers = Numbers::of(form, parts, values)?;
        let stage = Stage::between(limits, numbers.next());
        Ok(Self(match form {
            PortableForm::Parallel => {
                Law::Parallel(FractionalPid(if parts.iter().any(|part| part.filter > 0) {
                    Kind::Second(Parallel::of_list(
                        parts,
                        &mut numbers,
                        stage,
                        |part, power, filter| Bdf2Memory::from_list(part.integer, power, filter),
                    )?)
                } else {
                    Kind::First(Parallel::of_list(
                        parts,
                        &mut numbers,
                        stage,
                        |part, power, _| FullMemory::from_list(part.integer, power),
                    )?)
                }))
            }
            PortableForm::Lead { sections } => {
                let gain = numbers.next();
                Law::Lead(OnError {
                    operator: LeadPower::of_list(sections, parts, &mut numbers)?,
                    gain,
                    stage,
                })
            }
        }))
    }

    /// The history of a loop that always was at zero.
    #[must_use]
    pub fn at_rest(&self) -> PortableControllerHistory<F, MODES> {
        PortableControllerHistory(match &self.0 {
            Law::Parallel(law) => Past::Parallel(law.at_rest()),
            Law::Lead(law) => Past::Lead(law.at_rest()),
        })
    }

    /// The history of a loop that has stood for ever, as [`Controller::settled`] describes it.
    pub fn settled(
        &self,
        reference: F,
        measured: F,
        command: F,
    ) -> Option<PortableControllerHistory<F, MODES>> {
        Some(PortableControllerHistory(match &self.0 {
            Law::Parallel(law) => Past::Parallel(law.settled(reference, measured, command)?),
            Law::Lead(law) => Past::Lead(law.settled(reference, measured, command)?),
        }))
    }

    /// The command, within its limits; NaN with the history of a controller of another form.
    #[inline]
    pub fn output(
        &self,
        history: &PortableControllerHistory<F, MODES>,
        reference: F,
        measured: F,
    ) -> F {
        match (&self.0, &history.0) {
            (Law::Parallel(law), Past::Parallel(past)) => law.output(past, reference, measured),
            (Law::Lead(law), Past::Lead(past)) => law.output(past, reference, measured),
            _ => F::from_f64(f64::NAN),
        }
    }

    /// Takes the sample into the history, with the command that was applied.
    #[inline]
    pub fn advance(
        &self,
        history: &mut PortableControllerHistory<F, MODES>,
        reference: F,
        measured: F,
        applied: F,
    ) {
        match (&self.0, &mut history.0) {
            (Law::Parallel(law), Past::Parallel(past)) => {
                law.advance(past, reference, measured, applied);
            }
            (Law::Lead(law), Past::Lead(past)) => law.advance(past, reference, measured, applied),
            _ => {}
        }
    }
}

/// Numbers of a list, one after another.
#[derive(Debug)]
struct Numbers<'a, F>(&'a [F]);

impl<'a, F: Real> Numbers<'a, F> {
    /// A list of finite numbers, whose count is that of its parts.
    fn of(form: PortableForm, parts: &[PortablePart], values: &'a [F]) -> Result<Self, ListError> {
        // In front of all parts, and of each.
        let (fits, first, each) = match form {
            PortableForm::Parallel => ((1..=BRANCHES).contains(&parts.len()), 1, 2),
            PortableForm::Lead { sections } => {
                let fits = sections <= SECTIONS_MAX && parts.len() <= 2;
                (fits, 4, 0)
            }
        };
        let sizes = parts.iter().map(|part| each + part.values + part.filter);
        let (count, most) = (values.len(), first + sizes.sum::<usize>());
        if !fits || count != most {
            return Err(ListError::Count { count, most });
        }
        match values.iter().position(|value| !value.is_finite()) {
            None => Ok(Self(values)),
            Some(index) => Err(ListError::Value {
                index,
                value: values[index].to_f64(),
            }),
        }
    }

    fn next(&mut self) -> F {
        self.take(1).first().copied().unwrap_or_default()
    }

    fn take(&mut self, count: usize) -> &'a [F] {
        let (taken, rest) = self.0.split_at_checked(count).unwrap_or((self.0, &[]));
        self.0 = rest;
        taken
    }
}

impl<F: Real, O: Differintegrator<F>> Parallel<F, O> {
    fn of_list(
        parts: &[PortablePart],
        numbers: &mut Numbers<'_, F>,
        stage: Stage<F>,
        make: impl Fn(&PortablePart, &[F], &[F]) -> Result<O, ListError>,
    ) -> Result<Self, ListError> {
        let mut law = Self {
            proportional: None,
            branches: [const { None }; BRANCHES],
            feedback: F::ZERO,
            stage,
            sample_time: 1.0,
        };
        for (slot, part) in law.branches.iter_mut().zip(parts) {
            let (gain, weight) = (numbers.next(), numbers.next());
            let (power, filter) = (numbers.take(part.values), numbers.take(part.filter));
            if power.is_empty() && filter.is_empty() {
                law.proportional = Some([gain, weight]);
                law.feedback += gain;
                continue;
            }
            let power = make(part, power, filter)?;
            law.feedback += gain * power.direct_gain();
            *slot = Some(Branch {
                gain,
                weight,
                order: f64::from(part.integer),
                power,
                // Of a fractional integral it is 0, of a derivative at least 1.
                integrates: part.integer <= 0,
            });
        }
        Ok(law)
    }
}

impl<F: Real, const MODES: usize> LeadPower<F, MODES> {
    fn of_list(
        sections: u8,
        parts: &[PortablePart],
        numbers: &mut Numbers<'_, F>,
    ) -> Result<Self, ListError> {
        let corner = |index: usize, value: F| {
            if F::ZERO <= value && value <= F::ONE {
                Ok(value)
            } else {
                Err(ListError::Decay {
                    index,
                    value: value.to_f64(),
                })
            }
        };
        let (zero, pole) = (corner(2, numbers.next())?, corner(3, numbers.next())?);
        let mut memory = |part: &PortablePart| {
            let (power, filter) = (numbers.take(part.values), numbers.take(part.filter));
            match (power.is_empty(), filter.len()) {
                (true, 0) => Ok(None),
                (false, 0) => FullMemory::from_list(part.integer, power).map(Some),
                (_, count) => Err(ListError::Count { count, most: 0 }),
            }
        };
        Ok(Self {
            sections: usize::from(sections),
            zero,
            pole,
            memories: match parts {
                [] => None,
                [first] => Some([memory(first)?, None]),
                [first, second, ..] => Some([memory(first)?, memory(second)?]),
            },
        })
    }
}
