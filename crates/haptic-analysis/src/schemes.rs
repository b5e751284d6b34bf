//! The operators that have names.

use crate::functions::{Cascade, Curve, Modes, Polynomial, Power};
use crate::operator::multiply;
use crate::{AnalysisError, LoopOperator, StabilityRegion};
use fracdiff::full_memory::{Design, HORIZON_MIN, Kernel};
use fracdiff::parameter::range;
use fracdiff::scheme::{FULL_MODES, FULL_TAPS};
use fracdiff::{
    Band, FrequencyResponse, Order, Scheme, Seconds, bdf2_short_filter, grunwald_weights,
    muir_coefficients,
};
use num_complex::Complex;
use std::f64::consts::PI;

impl LoopOperator {
    /// From a scheme. `sample_time` matters only to `oustaloup`, whose corners are in Hz; `horizon`, in samples, only to the full memories.
    ///
    /// # Errors
    /// Unless 0 ≤ μ ≤ 2; a parameter of the scheme outside its range.
    pub fn new(
        scheme: Scheme,
        order: Order,
        sample_time: Seconds,
        horizon: f64,
    ) -> Result<Self, AnalysisError> {
        let allowed = "from 0 to 2: in a loop an integral has a pole at rest";
        range("order", order.get(), order.get() >= 0.0, allowed, "")?;
        match scheme {
            Scheme::Exact => Ok(Self::exact(order)),
            Scheme::Grunwald { length } => {
                scheme.build::<f64>(order, sample_time, horizon)?;
                Ok(Self::polynomial(
                    order,
                    grunwald_weights(order).take(length).collect(),
                ))
            }
            Scheme::Muir { degree } => {
                scheme.build::<f64>(order, sample_time, horizon)?;
                let mut coefficients = vec![0.0; degree + 1];
                muir_coefficients(order, &mut coefficients);
                Ok(Self::polynomial(order, coefficients))
            }
            Scheme::TustinMuir { degree } => {
                scheme.build::<f64>(order, sample_time, horizon)?;
                Self::tustin_muir(order, degree)
            }
            Scheme::Full { kernel, tolerance } => {
                Self::full_memory(order, kernel, tolerance, horizon.max(HORIZON_MIN))
            }
            Scheme::FullBdf2 { tolerance } => {
                Self::full_bdf2(order, tolerance, horizon.max(HORIZON_MIN))
            }
            Scheme::Oustaloup { sections, band } => {
                scheme.build::<f64>(order, sample_time, horizon)?;
                Ok(Self::oustaloup(order, sections, band, sample_time))
            }
            // `Scheme` may grow.
            _ => Err(AnalysisError::Operator(fracdiff::SchemeError::Unknown(
                scheme.to_string(),
            ))),
        }
    }

    fn tustin_muir(order: Order, degree: usize) -> Result<Self, AnalysisError> {
        let (integer, fraction) = order.split();
        let mut above = vec![0.0; degree + 1];
        let mut below = above.clone();
        muir_coefficients(Order::new(fraction)?, &mut above);
        muir_coefficients(Order::new(-fraction)?, &mut below);
        let gain = libm::pow(2.0, fraction);
        above.iter_mut().for_each(|b| *b *= gain);
        let mut operator = Self::rational(order, above.clone(), below.clone());
        operator.differences = Power(f64::from(integer));
        for _ in 0..integer {
            above = multiply(&above, &[1.0, -1.0]);
        }
        operator.polynomials = Some((above, below));
        Ok(operator)
    }

    fn full_memory(
        order: Order,
        kernel: Kernel,
        tolerance: f64,
        horizon: f64,
    ) -> Result<Self, AnalysisError> {
        Ok(Self::full(&design(order, kernel, tolerance, horizon)?))
    }

    /// The memory that a design describes.
    pub(crate) fn full<const TAPS: usize, const MODES: usize>(
        design: &Design<TAPS, MODES>,
    ) -> Self {
        let order = design.order();
        let core = Curve::Modes(taps_and_modes(design));
        let (differences, _) = order.split_up();
        Self::irrational(order, f64::from(differences), core)
    }

    fn full_bdf2(order: Order, tolerance: f64, horizon: f64) -> Result<Self, AnalysisError> {
        let memory = taps_and_modes(&design(order, Kernel::Grunwald, tolerance, horizon)?);
        let filter = Polynomial::new(bdf2_short_filter(order).to_vec());
        let (differences, _) = order.split_up();
        let core = Curve::Filtered(memory, filter);
        Ok(Self::irrational(order, f64::from(differences), core))
    }

    fn oustaloup(order: Order, sections: usize, band: Band, sample_time: Seconds) -> Self {
        let (integer, fraction) = order.split();
        // ω = 2πfT, ω'_i and ω_i = ω_l·r^((2i − 1 ∓ φ)/(2m)); halves of them for s/2.
        let rate = 2.0 * core::f64::consts::PI * sample_time.0;
        let (low, high) = (rate * band.low_hz, rate * band.high_hz);
        let corner = |i: usize, sign: f64| {
            let exponent = (2.0 * i as f64 - 1.0 + sign * fraction) / (2.0 * sections as f64);
            0.5 * low * libm::pow(high / low, exponent)
        };
        let cascade = Cascade {
            gain: libm::pow(high, fraction),
            corners: (1..=sections)
                .map(|i| (corner(i, -1.0), corner(i, 1.0)))
                .collect(),
        };
        Self::irrational(order, f64::from(integer), Curve::Cascade(cascade))
    }
}

/// The full memory as it is designed for a scheme.
fn design(
    order: Order,
    kernel: Kernel,
    tolerance: f64,
    horizon: f64,
) -> Result<Design<FULL_TAPS, FULL_MODES>, AnalysisError> {
    let design = Design::pruned(kernel, order, tolerance, horizon);
    Ok(design.map_err(fracdiff::SchemeError::from)?)
}

/// The core of a full memory as it runs.
fn taps_and_modes<const TAPS: usize, const MODES: usize>(design: &Design<TAPS, MODES>) -> Modes {
    let modes = design.modes().iter();
    Modes {
        taps: Polynomial::new(design.corrections().into()),
        modes: modes.map(|mode| (mode.weight, mode.decay())).collect(),
    }
}

impl LoopOperator {
    /// Longest memory that [`from_response`](Self::from_response) can take apart, samples.
    const MEMORY_MAX: usize = 4096;

    /// A recursive filter, P = Σ `b_j` w^j/Σ `a_j` w^j, without its factor T^(−μ).
    ///
    /// - `order` says what the gain B counts in, N·s^μ/m, and so what β is.
    /// - A filter without feedback has the denominator `[1.0]`.
    ///
    /// # Errors
    /// An order below 1e-6 (a constant is a spring: put it into α) or above 2; a coefficient that is not finite; a direct gain `b₀/a₀` not
    /// above 0; a denominator with a zero in |w| ≤ 1, or so close that rounding errors could decide: the filter itself would be unstable.
    pub fn from_polynomials(
        order: Order,
        numerator: &[f64],
        denominator: &[f64],
    ) -> Result<Self, AnalysisError> {
        check(order, numerator)?;
        check(order, denominator)?;
        if !Polynomial::new(denominator.to_vec()).is_stable() {
            return Err(AnalysisError::Unresolved {
                what: "the operator",
                why: "its denominator is not clearly free of zeros in the unit disc of w, so it is no stable filter",
            });
        }
        Self::rational(order, numerator.to_vec(), denominator.to_vec()).with_direct_gain()
    }

    /// A memory of taps and decaying modes on increments, without its factor T^(−μ):
    /// ```text
    /// P = (1 − w)^⌈μ⌉·[Σ_j k_j w^j + Σ_q W_q/(1 − e^(−s_q)·w)]
    /// ```
    /// so a mode, a pair (`s_q` > 0 per sample, `W_q`), begins at lag 0. A tempered or fitted kernel is one.
    ///
    /// # Errors
    /// An order below 1e-6 or above 2; a tap, weight or rate that is not finite; a rate not above 0; a direct gain not above 0.
    pub fn from_modes(
        order: Order,
        taps: &[f64],
        modes: &[(f64, f64)],
    ) -> Result<Self, AnalysisError> {
        check(order, taps)?;
        for &(rate, weight) in modes {
            range("weight of a mode", weight, true, "finite", "")?;
            range(
                "rate of a mode",
                rate,
                rate > 0.0,
                "above 0 {}",
                "per sample",
            )?;
        }
        let (differences, _) = order.split_up();
        let core = Curve::Modes(Modes {
            taps: Polynomial::new(taps.to_vec()),
            modes: (modes.iter())
                .map(|&(rate, weight)| (weight, -libm::expm1(-rate)))
                .collect(),
        });
        Self::irrational(order, f64::from(differences), core).with_direct_gain()
    }

    /// A full memory of one's own, as [`FullMemory`](fracdiff::FullMemory) runs its design: of a tempered kernel, or of
    /// all elements of a tissue at once.
    ///
    /// # Errors
    /// As [`from_modes`](Self::from_modes).
    pub fn from_design<const TAPS: usize, const MODES: usize>(
        design: &Design<TAPS, MODES>,
    ) -> Result<Self, AnalysisError> {
        check(design.order(), &[1.0])?;
        Self::full(design).with_direct_gain()
    }

    /// Anything that has a frequency response and whose memory fades: P is taken apart into its weights,
    /// P = Σ `c_j` w^j, by a discrete Fourier transform.
    /// ```text
    /// c_j = (1/M)·Σ_k P(e^(−2πjk/M))·e^(2πjk/M),   M doubled until all of c from M/2 on is below 1e-12·Σ|c_j|
    /// ```
    /// - *Exact* to some 1e-15 for a finite memory of up to 2048 samples; what a fading one leaves out is 1e-12 of its weights.
    /// - *Not for* weights that fall like a power, as those of (1 − w)^μ: give its [`Scheme`](fracdiff::Scheme) or its
    ///   modes. A pole close to the circle wants [`from_polynomials`](Self::from_polynomials).
    /// - *Cost*: M² multiply-adds.
    ///
    /// # Errors
    /// An order below 1e-6 or above 2; a response that is not finite, as that of an integral at rest; a memory that has
    /// not faded after 2048 samples; a direct gain not above 0.
    pub fn from_response(
        order: Order,
        operator: &(impl FrequencyResponse + ?Sized),
    ) -> Result<Self, AnalysisError> {
        let mut samples = 32;
        while samples <= Self::MEMORY_MAX {
            let mut weights = weights(operator, samples);
            check(order, &weights)?;
            let sum = |weights: &[f64]| weights.iter().map(|c| c.abs()).sum::<f64>();
            let whole = sum(&weights);
            if sum(&weights[samples / 2..]) <= 1e-12 * whole {
                // Rounding errors of the transform, behind a memory that is shorter.
                let last = weights.iter().rposition(|c| c.abs() > 1e-14 * whole);
                weights.truncate(last.unwrap_or(0) + 1);
                return Self::polynomial(order, weights).with_direct_gain();
            }
            samples *= 2;
        }
        Err(AnalysisError::Unresolved {
            what: "the operator from its response",
            why: "its memory has not faded after 2048 samples: give its scheme, its polynomials or its modes",
        })
    }

    /// Itself, if the newest sample counts: what the search for a region begins with.
    fn with_direct_gain(self) -> Result<Self, AnalysisError> {
        let gain = self.direct_gain();
        let allowed = "above 0";
        range("direct gain of the operator", gain, gain > 0.0, allowed, "")?;
        Ok(self)
    }
}

fn check(order: Order, coefficients: &[f64]) -> Result<(), AnalysisError> {
    let value = order.get();
    let varies = value >= StabilityRegion::ORDER_MIN;
    let allowed = "from 1e-6 to 2: a constant is a spring, and an integral has a pole at rest";
    range("order", value, varies, allowed, "")?;
    let count = coefficients.len() as f64;
    let allowed = "at least 1";
    range("number of coefficients", count, count > 0.0, allowed, "")?;
    for &coefficient in coefficients {
        let allowed = "finite";
        range(
            "coefficient of the operator",
            coefficient,
            true,
            allowed,
            "",
        )?;
    }
    Ok(())
}

/// The first weights of an operator, as many as samples of its response on the whole circle; an even number.
fn weights(operator: &(impl FrequencyResponse + ?Sized), samples: usize) -> Vec<f64> {
    let angle = |k: usize| 2.0 * PI * k as f64 / samples as f64;
    let turns: Vec<Complex<f64>> = (0..samples)
        .map(|k| {
            let (sin, cos) = libm::sincos(angle(k));
            Complex::new(cos, sin)
        })
        .collect();
    let half = samples / 2;
    let responses: Vec<Complex<f64>> = (0..=half).map(|k| operator.response(angle(k))).collect();
    (0..samples)
        .map(|j| {
            // P(e^(jθ)) is the conjugate of P(e^(−jθ)): both together are twice the real part.
            let ends = responses[0].re + (responses[half] * turns[half * j % samples]).re;
            let inner: f64 = (1..half)
                .map(|k| (responses[k] * turns[k * j % samples]).re)
                .sum();
            (ends + 2.0 * inner) / samples as f64
        })
        .collect()
}
