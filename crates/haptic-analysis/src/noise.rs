//! Noise that an operator makes of a noisy position.

use crate::AnalysisError;
use fracdiff::parameter::{positive, range};
use fracdiff::{Channel, Differintegrator, Order, Seconds};

/// Weights that are summed: the rest of their squares falls like j^(−1−2μ).
const WEIGHTS: usize = 4096;

/// rms of an operator's output for white noise of rms 1 at its input, s^(−μ).
/// ```text
/// T^(−μ)·√(Σ c_j²),     exact operator: Σ c_j² = Γ(2μ + 1)/Γ(μ + 1)²
/// ```
/// The force noise of a wall is B times this times the noise of the position. Steps q of an encoder are noise of
/// q/√12, white as long as the device moves by more than a step a sample.
///
/// - `operator`: the one that runs, so T is in it. A full memory should be designed for 8192 samples at least.
/// - *Range*: the sum converges for μ > −1/2.
/// - *Accuracy*: 4096 weights, 1e-5 for an unlimited memory.
/// - *Cost*: 4096 samples of the operator.
/// ```
/// use fracdiff::{Order, Scheme, Seconds};
/// use haptic_analysis::noise_gain;
///
/// let t = Seconds(1e-3);
/// let velocity = Scheme::Grunwald { length: 2 }.build::<f64>(Order::new(1.0)?, t, 1e4)?;
/// assert!((noise_gain(velocity) - 2f64.sqrt() / 1e-3).abs() < 1e-9); // (x[n] − x[n−1])/T
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[must_use]
pub fn noise_gain(operator: impl Differintegrator<f64>) -> f64 {
    let mut channel = Channel::new(operator);
    let mut input = 1.0;
    let mut squares = 0.0;
    for _ in 0..WEIGHTS {
        let output = channel.step(input);
        squares += output * output;
        input = 0.0;
    }
    squares.sqrt()
}

/// The same of the exact operator, by its closed form.
///
/// - *Range*: μ > −1/2.
///
/// # Errors
/// An order or a sample time outside its range.
pub fn exact_noise_gain(order: Order, sample_time: Seconds) -> Result<f64, AnalysisError> {
    let mu = order.get();
    range("order", mu, mu > -0.5, "above -1/2", "")?;
    let t = positive("sample time", sample_time.0, "s")?;
    // T^(−μ)·√Γ(2μ + 1)/Γ(μ + 1)
    let root = libm::sqrt(libm::tgamma(2.0 * mu + 1.0));
    Ok(libm::pow(t, -mu) * root / libm::tgamma(mu + 1.0))
}
