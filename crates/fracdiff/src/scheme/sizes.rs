//! Sizes of the operators that schemes make.

/// Longest `grunwald:N` that is summed directly, to the bit like [`ShortMemory`](crate::ShortMemory); from the
/// next on it is a [`PartitionedMemory`](crate::PartitionedMemory), which agrees to rounding and takes a fraction of the time.
pub const SHORT_MOST: usize = 2048;
/// Largest degree or number of sections a scheme accepts.
pub const DEGREE_MAX: usize = 64;
/// Recent samples that a full memory keeps as they are.
pub const FULL_TAPS: usize = 16;
/// Room for modes: enough for a tolerance of 1e-11 over 1e12 samples.
pub const FULL_MODES: usize = 112;
