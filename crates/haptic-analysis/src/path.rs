//! Path from a command to the force on the device: delay and current lag.

use crate::AnalysisError;
use certified_count::Place;
use fracdiff::parameter::range;
use num_complex::Complex;

/// Path of a command to the device: held for one sample, delayed by (d + h) samples, and followed
/// by a motor current of time constant τ.
/// ```text
/// τ·f'(t) = u(t − (d + h)T) − f(t),   or f(t) = u(t − (d + h)T) if τ = 0;   0 ≤ h < 1
/// ```
/// - *Units*: both numbers in samples, that is delay/T and τ/T. [`Dynamics`](crate::Dynamics) makes one from seconds.
/// - *Delay*: beside that of the hold, from 0 to 10 000. A delay within 1e-9 of
///   a whole number is that number, so that 3 ms at 1 ms are 3 samples.
/// - *Lag*: from 0 to 1e6. Below 1e-13 it counts as 0: it moves the force by less than a rounding
///   error.
/// ```
/// use haptic_analysis::ForcePath;
///
/// let path = ForcePath::new(2.4, 0.7)?; // 2.4 samples late, a motor that follows within 0.7
/// assert_eq!(path.whole_samples(), 2);
/// assert!((path.fraction() - 0.4).abs() < 1e-12 && !path.is_whole());
/// # Ok::<(), haptic_analysis::AnalysisError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForcePath {
    whole: usize,
    fraction: f64,
    lag: f64,
}

/// The course of the force within a sample after a command, at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Profile {
    /// M, the mean of the force for the command e^(jθn).
    pub(crate) mean: Complex<f64>,
    /// V/|1 − w|², its variance within the sample.
    pub(crate) spread: f64,
}

impl ForcePath {
    /// A device that acts at once, without delay or lag.
    pub const NONE: Self = Self {
        whole: 0,
        fraction: 0.0,
        lag: 0.0,
    };
    /// Longest delay that a path may have, samples.
    pub const DELAY_MAX: f64 = 10_000.0;
    const LAG_MAX: f64 = 1e6;

    /// A path with this delay and lag, both in samples.
    ///
    /// # Errors
    /// Either outside its range.
    pub fn new(delay_samples: f64, lag_samples: f64) -> Result<Self, AnalysisError> {
        let inside = (0.0..=Self::DELAY_MAX).contains(&delay_samples);
        let allowed = "from 0 to 10000 {}";
        range("delay", delay_samples, inside, allowed, "samples")?;
        let inside = (0.0..=Self::LAG_MAX).contains(&lag_samples);
        let allowed = "from 0 to 1e6 {}";
        range("current lag", lag_samples, inside, allowed, "samples")?;
        let nearest = libm::rint(delay_samples);
        let delay = if (delay_samples - nearest).abs() < 1e-9 {
            nearest
        } else {
            delay_samples
        };
        let whole = libm::floor(delay);
        Ok(Self {
            whole: whole as usize,
            fraction: delay - whole,
            lag: if lag_samples < 1e-13 {
                0.0
            } else {
                lag_samples
            },
        })
    }

    /// d + h, the total delay beyond the hold, samples.
    #[must_use]
    pub fn delay_samples(&self) -> f64 {
        self.whole as f64 + self.fraction
    }

    /// d, the number of whole samples in the delay.
    #[must_use]
    pub fn whole_samples(&self) -> usize {
        self.whole
    }

    /// h, the fraction of a sample in the delay, from 0 to below 1.
    #[must_use]
    pub fn fraction(&self) -> f64 {
        self.fraction
    }

    /// τ/T, the time constant of the current in samples; 0 without a lag.
    #[must_use]
    pub fn lag_samples(&self) -> f64 {
        self.lag
    }

    /// True if the force is constant within each sample: no fraction of delay and no lag.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        self.fraction == 0.0 && self.lag == 0.0
    }

    /// Adds whole samples of delay.
    pub(crate) fn later(self, samples: usize) -> Result<Self, AnalysisError> {
        let whole = self.whole.saturating_add(samples);
        Self::new(whole as f64, 0.0)?;
        Ok(Self { whole, ..self })
    }

    /// d + h + τ/T, the mean delay at rest, samples.
    pub(crate) fn mean_delay(&self) -> f64 {
        self.whole as f64 + (self.fraction + self.lag)
    }

    /// The response of the path to a force as a continuous signal, at the angle θ = ωT.
    /// ```text
    /// e^(−jθ(d + h))/(1 + jθτ/T)
    /// ```
    pub(crate) fn continuous(&self, theta: f64) -> Complex<f64> {
        let (sin, cos) = libm::sincos(theta * self.delay_samples());
        let delayed = Complex::new(cos, -sin);
        if self.lag == 0.0 {
            return delayed;
        }
        delayed / Complex::new(1.0, theta * self.lag)
    }

    /// Mean and variance of the force within a sample for the command e^(jθn), 0 ≤ θ ≤ π.
    ///
    /// The force at the time t in the sample is W(t)·e^(jθn), with a·(U − W) = W′, W(1) = W(0)/w, and U
    /// the command that has arrived: w before t = h, 1 after it. With W = w^d·(1 − v·y),
    /// ```text
    /// a = T/τ,  D = 1 − w·e^(−a),  E = e^(−a(1 − h)),  v = 1 − w
    /// y = 1 + (wE/D)·e^(−at)  for t < h,     y = e^(−a(t − h))/D  after it
    /// M = w^d·(1 − v·ȳ),   ȳ = h + (1 − v·E/D)/a,     V/|v|² = mean |y|² − |ȳ|²
    /// ```
    /// For slow lags the variance is that of D·y − 1, all of size a, so that nothing cancels.
    pub(crate) fn profile(&self, theta: f64) -> Profile {
        let h = self.fraction;
        let Place { v, .. } = Place::new(theta);
        let (sin, cos) = libm::sincos(self.whole as f64 * theta);
        let delayed = Complex::new(cos, -sin);
        if self.lag == 0.0 {
            // M = w^d(1 − hv), V = h(1 − h)|v|²
            return Profile {
                mean: delayed * (-v * h + 1.0),
                spread: h * (1.0 - h),
            };
        }
        let a = 1.0 / self.lag;
        let left = libm::exp(-a);
        let entered = libm::exp(-a * (1.0 - h));
        // D = (1 − e^(−a)) + e^(−a)v
        let d = v * left - libm::expm1(-a);
        let mean_y = (-(v * entered / d) + 1.0) * self.lag + h;
        let w = -v + 1.0;
        let spread = if a < 1.0 {
            self.slow_spread(w) / d.norm_sqr()
        } else {
            let early = 2.0 * self.lag * (entered - left) * (w / d).re;
            let late = -0.5 * self.lag * libm::expm1(-2.0 * a) / d.norm_sqr();
            h + early + late - mean_y.norm_sqr()
        };
        Profile {
            mean: delayed * (-v * mean_y + 1.0),
            spread: spread.max(0.0),
        }
    }

    /// The variance of ψ = 1 − D·y: 1 − e^(−a(t − h)) after h, w·e^(−a)(1 − e^(a(h − t))) before it.
    fn slow_spread(&self, w: Complex<f64>) -> f64 {
        let (h, a) = (self.fraction, 1.0 / self.lag);
        let left = libm::exp(-a);
        let (after, after_square) = rise(a, 1.0 - h);
        let (before, before_square) = rise(-a, h);
        let mean = w * (left * before) + after;
        after_square + left * left * before_square - mean.norm_sqr()
    }
}

/// The integrals of 1 − e^(−as) and of its square over 0 ≤ s ≤ x, |a| ≤ 1, without cancellation.
fn rise(a: f64, x: f64) -> (f64, f64) {
    let q = a * x;
    // x·Σ_{k≥1} (−1)^(k+1) q^k/(k + 1)!   and   x·Σ_{k≥2} (−1)^k (2^k − 2) q^k/(k + 1)!
    let (mut first, mut square) = (0.0, 0.0);
    let (mut term, mut power) = (1.0, 1.0);
    for k in 1..=24_u32 {
        term *= -q / f64::from(k + 1);
        power *= 2.0;
        first -= term;
        square += (power - 2.0) * term;
    }
    (x * first, x * square)
}
