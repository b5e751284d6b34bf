//! The coefficients of an operator: how to read them, and the blocks in which they travel.

use postcard_schema::Schema;
use serde::{Deserialize, Serialize};

/// Coefficients in a [`CoefficientBlock`].
pub const COEFFICIENTS_PER_BLOCK: usize = 16;

/// Blocks that hold this many coefficients.
#[must_use]
pub const fn block_count(coefficients: u16) -> u16 {
    coefficients.div_ceil(COEFFICIENTS_PER_BLOCK as u16)
}

/// The meaning of a list of coefficients.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub enum OperatorForm {
    /// g, k₁, …: weights of the newest sample and of those before.
    #[default]
    Taps,
    /// g, k₁, …, k₁₅, then a pair (d, W) for each decaying mode.
    Modes,
    /// g, then a pair (b, a) for each degree of a recursion.
    Recursion,
    /// gain, g, then three (direct, decay, slow) for each first-order section.
    Sections,
}

/// The key to the coefficients of an operator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, Schema)]
pub struct OperatorShape {
    /// Their meaning.
    pub form: OperatorForm,
    /// Differences (> 0) or sums (< 0) around them, −2 to 2.
    pub integer: i8,
    /// Their number.
    #[serde(with = "postcard::fixint::le")]
    pub count: u16,
}

/// Sixteen coefficients of the operator; the last block is filled up with zeros.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, Schema)]
pub struct CoefficientBlock {
    /// Of the first one, a multiple of 16.
    #[serde(with = "postcard::fixint::le")]
    pub offset: u16,
    /// In the order of [`OperatorForm`](crate::OperatorForm).
    #[serde(deserialize_with = "crate::in_order::array")]
    pub values: [f32; COEFFICIENTS_PER_BLOCK],
}

impl CoefficientBlock {
    /// The block at this offset of a list; what lies behind its end is zero.
    #[must_use]
    pub fn of(values: &[f32], offset: u16) -> Self {
        let rest = values.get(usize::from(offset)..).unwrap_or_default();
        let mut block = [0.0; COEFFICIENTS_PER_BLOCK];
        for (slot, value) in block.iter_mut().zip(rest) {
            *slot = *value;
        }
        Self {
            offset,
            values: block,
        }
    }
}
