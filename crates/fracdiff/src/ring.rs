//! The newest samples of one signal, as many as are asked for, on the heap.

use crate::Real;
use alloc::vec;
use alloc::vec::Vec;

/// Each sample twice, so that the newest lie in one piece, see [`crate::fir`].
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(from = "Vec<F>", into = "Vec<F>", bound = "F: Real")
)]
pub(crate) struct Ring<F> {
    twice: Vec<F>,
    newest: usize,
}

impl<F: Real> Ring<F> {
    /// So many samples of one value.
    pub(crate) fn of(x: F, length: usize) -> Self {
        Self {
            twice: vec![x; 2 * length],
            newest: 0,
        }
    }

    /// Number of samples.
    #[inline]
    pub(crate) fn length(&self) -> usize {
        self.twice.len() / 2
    }

    /// As [`crate::fir::advance`].
    #[inline]
    pub(crate) fn advance(&mut self, taps: &[F], x: F) -> F {
        crate::fir::advance(&mut self.twice, &mut self.newest, taps, x)
    }

    /// The samples twice, and where the newest is.
    #[inline]
    pub(crate) fn parts(&mut self) -> (&mut [F], &mut usize) {
        (&mut self.twice, &mut self.newest)
    }
}

/// As data each sample stands once, newest first.
#[cfg(feature = "serde")]
impl<F: Real> From<Ring<F>> for Vec<F> {
    fn from(ring: Ring<F>) -> Self {
        let length = ring.length();
        ring.twice
            .into_iter()
            .skip(ring.newest)
            .take(length)
            .collect()
    }
}

#[cfg(feature = "serde")]
impl<F: Real> From<Vec<F>> for Ring<F> {
    fn from(samples: Vec<F>) -> Self {
        Self {
            twice: samples.repeat(2),
            newest: 0,
        }
    }
}
