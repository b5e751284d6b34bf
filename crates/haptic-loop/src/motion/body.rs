//! The virtual body between hand and virtual world.

use crate::error::{Checks, LoopParameterError};
use crate::units::{NewtonSecondsPerMetre, Seconds};
use core::array;
use fracdiff::num_complex::Complex;
use fracdiff::{Differintegrator, FrequencyResponse, Real};
use nalgebra::SVector;

/// A virtual body, the same on each axis.
///
/// ```text
/// m·D^α v + b·v = f        v_k = (f_k − m·h_k)/(m·c₀ + b)
/// ```
/// - *Symbols*: v velocity m/s; f = `f_m` + `f_e`, force of the hand and of the law, N; m ≥ 0 in N·s^(1+α)/m, kg at α = 1; b ≥ 0 N·s/m;
///   c₀ the newest weight of the operator, h what the past contributes ([`Differintegrator::past`]).
/// - *Orders*: α = 1 is a mass, 0 a damper, between them a fractional inertance. With [`LaggedRate`] a mass that lags.
/// - *No wind-up*: [`advance`](Self::advance) takes the velocity that was commanded, after every limit, not the wanted one.
/// - *Not finite*: a force that is not finite makes a velocity that is not finite, which the motion chain turns into a fault.
/// - *Cost*: `velocity` two multiply-adds an axis, `advance` the operator's.
///
/// Source: Y. Aydin, O. Tokatli, V. Patoglu, C. Basdogan, "Stable physical human-robot interaction using fractional order admittance
/// control", IEEE Transactions on Haptics 11(3), 2018, for the idea; its abstract alone was read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VirtualBody<F, O> {
    operator: O,
    inertia: F,
    damping: F,
    /// 1/(m·c₀ + b).
    mobility: F,
}

impl<F: Real, O: Differintegrator<F>> VirtualBody<F, O> {
    /// m, a plain number, because its unit depends on the order of the operator; and b.
    ///
    /// # Errors
    /// Both must be finite and at least 0, in the precision of the loop too, and m·c₀ + b above 0.
    pub fn new(
        inertia: f64,
        damping: NewtonSecondsPerMetre,
        operator: O,
    ) -> Result<Self, LoopParameterError> {
        let mut checks = Checks::default();
        checks.not_negative("inertia of the virtual body", inertia, "N·s^(1+α)/m");
        checks.not_negative("damping of the virtual body", damping.0, "N·s/m");
        let impedance = inertia * operator.direct_gain().to_f64() + damping.0;
        let (what, unit) = ("newest weight of the virtual body, m·c₀ + b", "N·s/m");
        let allowed = "above 0 {}: give it inertia or damping";
        checks.range(what, impedance, impedance > 0.0, allowed, unit);
        let body = Self {
            operator,
            inertia: checks.rounded("inertia of the virtual body", inertia, "N·s^(1+α)/m"),
            damping: checks.rounded("damping of the virtual body", damping.0, "N·s/m"),
            mobility: checks.rounded(what, 1.0 / impedance, "m/(N·s)"),
        };
        checks.done().map(|()| body)
    }

    /// The operator D^α.
    pub const fn operator(&self) -> &O {
        &self.operator
    }

    /// m, N·s^(1+α)/m.
    pub const fn inertia(&self) -> F {
        self.inertia
    }

    /// b, N·s/m.
    pub const fn damping_n_s_per_m(&self) -> F {
        self.damping
    }

    /// The history of a body that always rested.
    pub fn at_rest<const D: usize>(&self) -> [O::History; D] {
        array::from_fn(|_| self.operator.at_rest())
    }

    /// v, m/s, under this force, N. Leaves the history alone.
    #[inline]
    pub fn velocity<const D: usize>(
        &self,
        history: &[O::History; D],
        force_n: &SVector<F, D>,
    ) -> SVector<F, D> {
        SVector::from(array::from_fn(|axis| {
            let past = self.operator.past(&history[axis]);
            // v = (f − m·h)/(m·c₀ + b)
            (force_n[axis] - self.inertia * past) * self.mobility
        }))
    }

    /// Takes the velocity that was commanded, m/s, into the history.
    #[inline]
    pub fn advance<const D: usize>(
        &self,
        history: &mut [O::History; D],
        velocity_m_per_s: &SVector<F, D>,
    ) {
        let v = array::from_fn(|axis| velocity_m_per_s[axis]);
        self.operator.advance_many(history.each_mut(), v);
    }
}

/// The rate of change behind a lag, s/(1 + τ·s): it makes a [`VirtualBody`] a mass that lags, b + m·s/(1 + τ·s).
///
/// ```text
/// s → (1 − w)/T:   y\[n\] = (x\[n\] − x\[n−1\] + τ·y\[n−1\])/(T + τ)        order 1, T and τ s
/// ```
/// Backward difference, as Grünwald's operator of order 1, which it is at τ = 0. Its gain at high frequency is 1/τ, not 2/T.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaggedRate<F> {
    /// 1/(T + τ).
    gain: F,
    /// τ/(T + τ).
    kept: F,
    sample_time: f64,
}

/// History of a [`LaggedRate`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaggedRateHistory<F> {
    last: F,
    /// τ·y/(T + τ) of the last output.
    kept: F,
}

impl<F: Real> LaggedRate<F> {
    /// τ ≥ 0 and T > 0.
    ///
    /// # Errors
    /// One of them is outside its range, also in the precision of the loop.
    pub fn new(lag: Seconds, sample_time: Seconds) -> Result<Self, LoopParameterError> {
        let mut checks = Checks::default();
        let lag = checks.not_negative("lag of the virtual mass", lag.0, "s");
        let sample_time = checks.positive("sample time", sample_time.0, "s");
        let rate = Self {
            gain: checks.rounded("rate of the lagged mass", 1.0 / (sample_time + lag), "s⁻¹"),
            kept: checks.rounded("lag of the virtual mass", lag / (sample_time + lag), ""),
            sample_time,
        };
        checks.done().map(|()| rate)
    }
}

impl<F: Real> Differintegrator<F> for LaggedRate<F> {
    type History = LaggedRateHistory<F>;

    fn at_rest(&self) -> LaggedRateHistory<F> {
        LaggedRateHistory {
            last: F::ZERO,
            kept: F::ZERO,
        }
    }

    fn settled(&self, x: F) -> Option<LaggedRateHistory<F>> {
        Some(LaggedRateHistory {
            last: x,
            kept: F::ZERO,
        })
    }

    #[inline]
    fn direct_gain(&self) -> F {
        self.gain
    }

    #[inline]
    fn past(&self, history: &LaggedRateHistory<F>) -> F {
        history.kept - self.gain * history.last
    }

    #[inline]
    fn advance(&self, history: &mut LaggedRateHistory<F>, x: F) {
        let output = self.output(history, x);
        let kept = self.kept * output;
        // A state that has decayed must not become subnormal.
        history.kept = if kept.abs() < F::NEGLIGIBLE {
            F::ZERO
        } else {
            kept
        };
        history.last = x;
    }

    #[inline]
    fn output(&self, history: &LaggedRateHistory<F>, x: F) -> F {
        self.gain * (x - history.last) + history.kept
    }

    fn memory_length(&self) -> Option<usize> {
        None
    }
}

impl<F: Real> FrequencyResponse for LaggedRate<F> {
    fn response(&self, theta: f64) -> Complex<f64> {
        let half = libm::sin(0.5 * theta);
        let difference = Complex::new(2.0 * half * half, libm::sin(theta));
        // P = T·g·(1 − w)/(1 − τ·w/(T + τ)), and w = 1 − (1 − w)
        let kept = self.kept.to_f64();
        let denominator = (difference - 1.0) * kept + 1.0;
        difference * (self.gain.to_f64() * self.sample_time) / denominator
    }
}
