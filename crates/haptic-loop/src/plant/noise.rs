//! Normal noise whose bits no platform changes.

use core::f64::consts::TAU;
use rand_distr::{Distribution as _, Open01, StandardUniform};
use rand_pcg::Pcg32;

/// A standard normal number: √(−2 ln u)·cos 2πv of two uniform ones (G. E. P. Box and M. E. Muller, *A note on the generation of random normal
/// deviates*, 1958). A ziggurat is faster, but that of `rand_distr` takes its logarithms from the platform.
pub(super) fn normal(generator: &mut Pcg32) -> f64 {
    let radius: f64 = Open01.sample(generator);
    let turn: f64 = StandardUniform.sample(generator);
    libm::sqrt(-2.0 * libm::log(radius)) * libm::cos(TAU * turn)
}
