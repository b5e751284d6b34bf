//! The operators that have names.

use crate::functions::{Cascade, Curve, Given, Modes, Polynomial, Power};
use crate::{AnalysisError, LoopOperator, StabilityRegion};
use certified_count::Enclosing;
use fracdiff::full_memory::{Design, HORIZON_MIN, Kernel};
use fracdiff::parameter::range;
use fracdiff::product;
use fracdiff::scheme::{FULL_MODES, FULL_TAPS};
use fracdiff::{
    Band, Order, Scheme, Seconds, bdf2_short_filter, grunwald_weights, muir_coefficients,
};
use std::sync::Arc;

impl LoopOperator {
    /// The operator of a scheme. `sample_time` matters only to `oustaloup`, whose corners are in
    /// Hz; `horizon`, in samples, only to the full memories.
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

    /// The lagged difference of order 1, s/(1 + τs) by backward differences: P = v/(1 + τv/T), v = 1 − w. m times it is a lagged mass.
    ///
    /// # Errors
    /// Unless τ is from 0 to 1e6 samples.
    pub fn lagged_difference(lag_samples: f64) -> Result<Self, AnalysisError> {
        let kept = (0.0..=1e6).contains(&lag_samples);
        range(
            "lag of a difference",
            lag_samples,
            kept,
            "from 0 to 1e6 {}",
            "samples",
        )?;
        let below = vec![1.0 + lag_samples, -lag_samples];
        Ok(Self::rational(Order::new(1.0)?, vec![1.0, -1.0], below))
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
            above = product(&above, &[1.0, -1.0]);
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

/// Refuses coefficients that are not finite, and a newest sample that does not count.
fn check_coefficients(coefficients: &[f64]) -> Result<(), AnalysisError> {
    let first = coefficients.first().copied().unwrap_or(0.0);
    range("first coefficient", first, first > 0.0, "above 0", "")?;
    for &value in coefficients {
        range("coefficient", value, value.is_finite(), "finite", "")?;
    }
    Ok(())
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
    /// The operator P(w) = Σ pₙ·wⁿ, n from 0. Its order μ only sets the unit of the gain B.
    ///
    /// # Errors
    /// A coefficient that is not finite; unless p₀ > 0: the newest sample must count.
    pub fn from_polynomial(order: Order, coefficients: Vec<f64>) -> Result<Self, AnalysisError> {
        check_coefficients(&coefficients)?;
        Ok(Self::polynomial(order, coefficients))
    }

    /// The operator P(w) = Σ bₙ·wⁿ/Σ aₙ·wⁿ, n from 0: a recursion.
    ///
    /// # Errors
    /// A coefficient that is not finite; unless a₀ > Σ |aₙ|, n ≥ 1, for which no recursion grows by itself; unless b₀ > 0.
    pub fn from_quotient(
        order: Order,
        numerator: Vec<f64>,
        denominator: Vec<f64>,
    ) -> Result<Self, AnalysisError> {
        check_coefficients(&numerator)?;
        check_coefficients(&denominator)?;
        let others: f64 = denominator[1..].iter().map(|a| a.abs()).sum();
        let (what, allowed) = (
            "sum of the other coefficients of a recursion",
            "below the newest one",
        );
        range(what, others, others < denominator[0], allowed, "")?;
        Ok(Self::rational(order, numerator, denominator))
    }

    /// The operator of a controller, P(w) = above/below: two functions without a pole in |w| ≤ 1 and without a zero of `below` in
    /// |w| < 1. A zero of `below` at w = 1 is an integral, which no damping makes passive: stability and felt impedance alone are right then.
    ///
    /// Its order only sets the unit of the gain B. `direct_gain` is P at w = 0.
    ///
    /// # Errors
    /// A direct gain that is not finite.
    pub fn from_controller(
        order: Order,
        [above, below]: [Arc<dyn Enclosing>; 2],
        direct_gain: f64,
    ) -> Result<Self, AnalysisError> {
        let what = "direct gain of the controller";
        range(what, direct_gain, direct_gain.is_finite(), "finite", "")?;
        let curve = |function, at_zero| Curve::Given(Given { function, at_zero });
        let [above, below] = [curve(above, direct_gain), curve(below, 1.0)];
        Ok(Self::given(order, above, below))
    }

    /// A custom full memory, as [`FullMemory`](fracdiff::FullMemory) runs its design: of a tempered
    /// kernel, or of all elements of a tissue at once.
    ///
    /// # Errors
    /// An order below 1e-6 (a constant is a spring: put it into α) or above 2; a direct gain not above 0.
    pub fn from_design<const TAPS: usize, const MODES: usize>(
        design: &Design<TAPS, MODES>,
    ) -> Result<Self, AnalysisError> {
        let value = design.order().get();
        let varies = value >= StabilityRegion::ORDER_MIN;
        let allowed = "from 1e-6 to 2: a constant is a spring, and an integral has a pole at rest";
        range("order", value, varies, allowed, "")?;
        let operator = Self::full(design);
        // The search for a region begins with what the newest sample counts.
        let gain = operator.direct_gain();
        range(
            "direct gain of the operator",
            gain,
            gain > 0.0,
            "above 0",
            "",
        )?;
        Ok(operator)
    }
}
