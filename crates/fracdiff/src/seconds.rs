//! A time with its unit.

/// A duration in seconds. Any number; the constructor that takes it checks the range it needs.
///
/// ```
/// use fracdiff::{Order, Seconds};
///
/// // T^(−1/2) at 10 kHz.
/// assert_eq!(Seconds(1e-4).rate_to_the(Order::new(0.5)?)?, 100.0);
/// # Ok::<(), fracdiff::ParameterError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Seconds(pub f64);

impl Seconds {
    /// Smallest sample time an operator accepts, in seconds.
    pub const MIN_SAMPLE_TIME: f64 = 1e-9;
    /// Largest sample time an operator accepts, in seconds.
    pub const MAX_SAMPLE_TIME: f64 = 1e6;
}

impl core::fmt::Display for Seconds {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        self.0.fmt(f)?;
        f.write_str(" s")
    }
}
