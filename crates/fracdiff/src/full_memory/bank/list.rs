//! A bank as a list of numbers, and back: what a microcontroller is given.

use super::{Bank, FullMemory};
use crate::Real;
use crate::integer_part::WithIntegerPart;
use crate::list::{ListError, check_decay, check_finite, check_integer};

/// Taps of a bank that is given as a list of values.
pub(crate) const PORTABLE_TAPS: usize = 16;

/// The modes of a portable list in blocks that need no compensation.
#[cfg(feature = "std")]
pub(crate) fn plain_modes<F: Real>(values: &[F], integer: i32) -> usize {
    use super::fast_blocks;
    use crate::full_memory::sweep::LANES;

    let modes = values.get(PORTABLE_TAPS..).unwrap_or_default();
    let decays: std::vec::Vec<F> = modes.iter().step_by(2).copied().collect();
    LANES * fast_blocks(&decays, integer)
}

impl<F: Real, const TAPS: usize, const MODES: usize> Bank<F, TAPS, MODES> {
    /// From g, `k_1`, …, `k_{TAPS−1}`, then d and W of each mode, all finite. The response is not to be
    /// asked for: the rate is not in the list.
    pub(crate) fn from_list(values: &[F], integer: i32) -> Result<Self, ListError> {
        let mut bank = Self::SILENT;
        bank.replace(values, integer)?;
        Ok(bank)
    }

    /// Taps, and d and W of each mode, of a list that is one.
    pub(crate) fn parts(values: &[F]) -> Result<(&[F], &[[F; 2]]), ListError> {
        let (count, most) = (values.len(), TAPS + 2 * MODES);
        let wrong = ListError::Count { count, most };
        let (taps, modes) = values.split_at_checked(TAPS).ok_or(wrong)?;
        let (pairs, rest) = modes.as_chunks::<2>();
        if !rest.is_empty() || pairs.len() > MODES {
            return Err(wrong);
        }
        for (q, &[decay, _]) in pairs.iter().enumerate() {
            check_decay(decay, TAPS + 2 * q)?;
        }
        Ok((taps, pairs))
    }

    /// Becomes the bank of a list, in its place; a list that is none leaves it as it is.
    pub(crate) fn replace(&mut self, values: &[F], integer: i32) -> Result<(), ListError> {
        let (taps, pairs) = Self::parts(values)?;
        self.rate = 1.0;
        self.direct = taps[0];
        self.corrections[..TAPS - 1].copy_from_slice(&taps[1..]);
        self.corrections[TAPS - 1] = F::ZERO;
        // A decay of zero is no mode.
        self.decays.fill(F::ZERO);
        self.weights.fill(F::ZERO);
        for (q, &[decay, weight]) in pairs.iter().enumerate() {
            self.decays[q] = decay;
            self.weights[q] = weight;
        }
        self.use_modes(pairs.len(), integer);
        Ok(())
    }

    /// Value `index` of the list that [`from_list`](Self::from_list) takes.
    pub(crate) fn value(&self, index: usize) -> Option<F> {
        if index < TAPS {
            return Some(if index == 0 {
                self.direct
            } else {
                self.corrections[index - 1]
            });
        }
        let (mode, second) = ((index - TAPS) / 2, (index - TAPS) % 2 == 1);
        // A decay of zero is no mode.
        let decay = *self.decays.get(mode).filter(|decay| **decay > F::ZERO)?;
        Some(if second { self.weights[mode] } else { decay })
    }
}

impl<F: Real, const MODES: usize> FullMemory<F, PORTABLE_TAPS, MODES> {
    /// From the integer part and the values of [`Form::Modes`](crate::portable::Form::Modes), as
    /// [`Operator::list`](crate::Operator::list) gives them: the same bits as the operator that the list is of, without
    /// its design, so that a microcontroller needs no elementary functions.
    ///
    /// # Errors
    /// A list that is none, see [`ListError`]. The response is not to be asked for: the rate is not in the list.
    pub fn from_list(integer: i8, values: &[F]) -> Result<Self, ListError> {
        let integer = check_integer(integer)?;
        check_finite(values)?;
        let core = Bank::from_list(values, integer)?;
        Ok(Self(WithIntegerPart { integer, core }))
    }

    /// Integer part, and the values of [`Form::Modes`](crate::portable::Form::Modes).
    #[cfg(feature = "std")]
    pub(crate) fn list(&self) -> (i32, std::vec::Vec<F>) {
        self.0.list(Bank::value)
    }
}
