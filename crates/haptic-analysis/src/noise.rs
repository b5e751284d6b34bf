//! Noise that an operator makes of a noisy position.

use crate::AnalysisError;
use fracdiff::parameter::{positive, range};
use fracdiff::{Channel, Differintegrator, Order, Seconds};

/// Weights that are summed: the rest of their squares falls like j^(−1−2μ).
const WEIGHTS: usize = 4096;

/// Output noise of an operator for white noise of rms 1 at its input.
/// ```text
/// rms of the operator alone    T^(−μ)·√(Σ c_j²)                        exact: Σ c_j² = Γ(2μ + 1)/Γ(μ + 1)²
/// rms of a wall's force        √(K² + 2·K·B·T^(−μ)·c_0 + B²·T^(−2μ)·Σ c_j²)        per metre of noise
/// ```
/// Steps q of an encoder are noise of q/√12, white as long as the device moves by more than a step a sample.
/// ```
/// use fracdiff::{Order, Scheme, Seconds};
/// use haptic_analysis::NoiseGain;
///
/// let t = Seconds(1e-3);
/// let velocity = Scheme::Grunwald { length: 2 }.build::<f64>(Order::new(1.0)?, t, 1e4)?;
/// // K·x[n] + B·(x[n] − x[n−1])/T
/// let noise_n = 1e-6 * NoiseGain::of(velocity).of_wall(1000.0, 2.0);
/// assert!((noise_n - 1e-6 * 3000_f64.hypot(2000.0)).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseGain {
    /// `T^(−μ)·c_0`, s^(−μ).
    first: f64,
    /// T^(−μ)·√(Σ `c_j²`), s^(−μ).
    all: f64,
}

impl NoiseGain {
    /// - `operator`: the one that runs, so T is in it. A full memory should be designed for 8192 samples at least.
    /// - *Range*: the sum converges for μ > −1/2.
    /// - *Accuracy*: 4096 weights, 1e-5 for an unlimited memory.
    /// - *Cost*: 4096 samples of the operator.
    #[must_use]
    pub fn of(operator: impl Differintegrator<f64>) -> Self {
        let mut channel = Channel::new(operator);
        let first = channel.step(1.0);
        let others = (1..WEIGHTS).map(|_| channel.step(0.0));
        Self::of_weights(core::iter::once(first).chain(others))
    }

    /// Noise gain of the weights of an operator with T in them, the newest sample's first.
    #[must_use]
    pub fn of_weights(weights: impl IntoIterator<Item = f64>) -> Self {
        let mut weights = weights.into_iter();
        let first = weights.next().unwrap_or(0.0);
        let squares = weights.fold(first * first, |sum, weight| sum + weight * weight);
        Self {
            first,
            all: squares.sqrt(),
        }
    }

    /// The noise of the exact operator, by its closed form.
    ///
    /// - *Range*: μ > −1/2.
    ///
    /// # Errors
    /// An order or a sample time outside its range.
    pub fn exact(order: Order, sample_time: Seconds) -> Result<Self, AnalysisError> {
        let mu = order.get();
        range("order", mu, mu > -0.5, "above -1/2", "")?;
        let t = positive("sample time", sample_time.0, "s")?;
        let first = libm::pow(t, -mu);
        // T^(−μ)·√Γ(2μ + 1)/Γ(μ + 1)
        let root = libm::sqrt(libm::tgamma(2.0 * mu + 1.0));
        let all = first * root / libm::tgamma(mu + 1.0);
        Ok(Self { first, all })
    }

    /// rms of the force of a wall, N per metre of noise. K in N/m, B in N·s^μ/m.
    #[must_use]
    pub fn of_wall(&self, stiffness_n_per_m: f64, dissipation_n_s_mu_per_m: f64) -> f64 {
        let (k, b) = (stiffness_n_per_m, dissipation_n_s_mu_per_m);
        let share = b * self.all;
        libm::sqrt(k * k + 2.0 * k * b * self.first + share * share)
    }
}
