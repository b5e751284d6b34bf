//! One decaying exponential.

/// A decaying mode: it adds weight·e^(−j·rate) to the weight of lag j.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Mode {
    /// `s_q` > 0, per sample.
    pub rate: f64,
    /// `w_q` > 0, dimensionless.
    pub weight: f64,
}
