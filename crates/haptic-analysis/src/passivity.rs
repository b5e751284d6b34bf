//! Passivity of the one port: how much device damping a virtual wall asks for, by Theorem 1.

use crate::extremum::{Grid, Maximum};
use crate::largest::At;
use crate::largest::{Largest, largest};
use crate::path::Profile;
use crate::transparency::finite;
use crate::{AnalysisError, ForcePath};
use fracdiff::parameter::{not_negative, positive, range};
use fracdiff::{FrequencyResponse, Order, Seconds};
use num_complex::Complex;
use std::f64::consts::PI;

/// A device under a sampled wall K + B·T^(−μ)·P(w), with the operator P that really runs, behind a delay and a current lag.
///
/// Theorem 1, for all 0 ≤ θ ≤ π and strictly:
/// ```text
/// b > (T/2)/(1 − cos θ) · Re{(1 − w) w^d H(w)},  w = e^(−jθ);   δ > α·u(θ) + β·v(θ),
/// u = sin((2d+1)θ/2)/(2 sin(θ/2)),   v = Re{j e^(−j(2d+1)θ/2) P(e^(−jθ))}/(2 sin(θ/2))
/// ```
/// A fraction of delay and a lag make the force move within a sample. With the mean M and the variance V of
/// that force for a command e^(jθn), over the sample, passive for every motion, inside samples too, is
/// ```text
/// b ≥ (T/(2|1 − w|²))·[R + √(R² + V|H|²|1 − w|²)],   R = Re{(1 − w)·M·H}
/// ```
/// for all θ: Theorem 1 at V = 0. A delay of (d + h)T has M = w^d(1 − h + hw), V = h(1 − h)|1 −
/// w|²; a spring with 0 ≤ h ≤ 1 and d = 0 needs b ≥ (KT/2)(1/2 + h + √(1/4 + 2h)), more than
/// interpolation between whole samples promises. With a lag, M and V come from its periodic
/// response, in closed form.
/// - δ = bT/m, α = KT²/m, β = BT^(2−μ)/m; the mass drops out of the condition with units.
/// - *Orders*: 0 ≤ μ ≤ 2. An integral in position feedback is not passive for any damping.
/// - *The end θ → 0* is a limit: u = (2d+1)/2; of v, the values at θ = 1e-60 and 1e-90 separate a
///   constant from a power of θ. A supremum that is only approached there counts.
/// - *Accuracy*: 1e-10, in practice 1e-13 of the larger term.
/// - *Cost*: 4·(memory + d) + 400 responses for one supremum, on the heap; the largest K or B takes a few suprema.
/// ```
/// use fracdiff::{ExactDifference, MuirPolynomial, Order, Seconds};
/// use haptic_analysis::OnePort;
///
/// let order = Order::new(1.0)?;
/// let promised = OnePort::new(&ExactDifference(order), order)?.required_delta(0.0, 1.0)?;
/// assert!((promised.delta - 1.0).abs() < 1e-12); // Colgate: b > B
/// let muir = MuirPolynomial::<f64, 3>::new(order, Seconds(1.0))?;
/// let really = OnePort::new(&muir, order)?.with_memory(4).required_delta(0.0, 1.0)?;
/// assert!((really.delta - 4.0 / 3.0).abs() < 1e-12); // A₃(−1) = 8/3, halved
/// # Ok::<(), haptic_analysis::AnalysisError>(())
/// ```
/// Source: O. Tokatlı, *Fractional Order Control in Haptics*, eq. 3.14, after J. E. Colgate,
/// G. Schenkel, *Passivity of a class of sampled-data systems*, J. Robotic Systems 14(1), 1997.
#[derive(Clone, Debug)]
pub struct OnePort<'a, P: ?Sized> {
    operator: &'a P,
    order: Order,
    path: ForcePath,
    memory: usize,
    grid: Grid,
    /// v(θ → 0); −∞ where the operator dissipates without bound.
    v_at_rest: f64,
    /// P(θ → 0).
    p_at_rest: f64,
    /// Distance of Re P(1) below 0: the negative spring that the operator leaves at rest.
    deficit: f64,
}

/// A gain at rest above minus this counts as 0: a full memory leaves about its tolerance.
const REST_NOISE: f64 = 1e-4;

impl<'a, P: FrequencyResponse + ?Sized> OnePort<'a, P> {
    /// A port without extra delay. `order` is the operator's order.
    ///
    /// # Errors
    /// μ < 0, where the theorem's condition has no bound, or an operator without a finite response.
    pub fn new(operator: &'a P, order: Order) -> Result<Self, AnalysisError> {
        check_order(order)?;
        let mut port = Self {
            operator,
            order,
            path: ForcePath::NONE,
            memory: 1,
            grid: Grid::new(1),
            v_at_rest: 0.0,
            p_at_rest: 0.0,
            deficit: 0.0,
        };
        // At 1e-90 a power of θ has vanished, and a constant has not.
        let at_rest = finite("response at rest", operator.response(1e-90).re, "")?;
        port.deficit = if at_rest < -REST_NOISE { -at_rest } else { 0.0 };
        port.prepare()?;
        Ok(port)
    }

    /// Adds the delay, whole or not, and the current lag of an actuator.
    ///
    /// # Errors
    /// An operator without a finite response.
    pub fn through(mut self, path: ForcePath) -> Result<Self, AnalysisError> {
        self.path = path;
        self.prepare()?;
        Ok(self)
    }

    /// Sets the operator's memory length in samples, so that its fastest ripple cannot slip through
    /// the search: `Differintegrator::memory_length`. Leave it out for an unlimited memory
    /// (recursive, full, exact), which has no ripple.
    #[must_use]
    pub fn with_memory(mut self, samples: usize) -> Self {
        self.memory = samples.max(1);
        self.grid = self.new_grid();
        self
    }

    /// A fraction of delay turns M·H a little faster than its whole samples do.
    fn new_grid(&self) -> Grid {
        let partly = usize::from(!self.path.is_whole());
        Grid::new(self.memory + self.path.whole_samples() + partly)
    }

    fn prepare(&mut self) -> Result<(), AnalysisError> {
        self.grid = self.new_grid();
        self.v_at_rest = self.limit_of_v()?;
        Ok(())
    }

    /// The right side of Theorem 1 at one frequency, 0 < θ ≤ π: α·u(θ) + β·v(θ) for whole samples of delay.
    ///
    /// # Errors
    /// α, β or θ outside its range.
    pub fn delta_at(&self, alpha: f64, beta: f64, theta: f64) -> Result<f64, AnalysisError> {
        let alpha = not_negative("alpha", alpha, "")?;
        let beta = not_negative("beta", beta, "")?;
        let kept = theta > 0.0 && theta <= PI;
        let allowed = "above 0 and at most π {}";
        range("digital frequency", theta, kept, allowed, "rad/sample")?;
        finite("least delta", self.combine(alpha, beta, theta), "")
    }

    /// The δ that Theorem 1 requires.
    ///
    /// # Errors
    /// α or β below 0, or an operator without a finite response.
    pub fn required_delta(&self, alpha: f64, beta: f64) -> Result<RequiredDelta, AnalysisError> {
        let corollary_delta = corollary_delta(self.order, alpha, beta)?;
        let worst = self.supremum(alpha, beta)?;
        Ok(RequiredDelta {
            delta: worst.value,
            worst_theta: worst.theta,
            corollary_delta,
            negative_at_rest: alpha < beta * self.deficit,
        })
    }

    /// The damping that Theorem 1 requires, N·s/m, for K in N/m and B in N·s^μ/m: the loop is passive above it, and only there. Infinite if a
    /// negative spring at rest lets none be enough, see [`RequiredDelta::negative_at_rest`].
    ///
    /// # Errors
    /// T not above 0, K or B below 0, or an operator without a finite response.
    pub fn required_damping(
        &self,
        sample_time: Seconds,
        stiffness: f64,
        dissipation: f64,
    ) -> Result<f64, AnalysisError> {
        let (t, alpha, beta) = self.for_unit_mass(sample_time, stiffness, dissipation)?;
        let required = self.required_delta(alpha, beta)?;
        if required.negative_at_rest {
            return Ok(f64::INFINITY);
        }
        finite("least damping", required.delta / t, "N·s/m")
    }

    /// The largest α for given δ and β: inf over θ of (δ − β·v)/u where u > 0.
    ///
    /// # Errors
    /// δ or β below 0, or an operator without a finite response.
    pub fn largest_alpha(&self, delta: f64, beta: f64) -> Result<Largest, AnalysisError> {
        let delta = not_negative("delta", delta, "")?;
        let beta = not_negative("beta", beta, "")?;
        let found = largest(
            delta,
            |alpha| self.supremum(alpha, beta),
            self.supremum(1.0, 0.0)?,
            |theta, alpha| {
                let port = self.at(theta);
                port.tangent([(port.u, 1.0.into()), (port.v, port.p)], alpha, beta)
            },
        )?;
        // A wall this soft has a negative spring at rest.
        let is_soft = matches!(found, Largest::Below { value, .. } if value < beta * self.deficit);
        Ok(if is_soft { Largest::Empty } else { found })
    }

    /// The largest β/α that leaves no negative spring at rest: −1/P(1); `None` if any does.
    #[must_use]
    pub fn largest_ratio(&self) -> Option<f64> {
        (self.deficit > 0.0).then(|| 1.0 / self.deficit)
    }

    /// The largest β for given δ and α: inf over θ of (δ − α·u)/v where v > 0.
    ///
    /// # Errors
    /// δ or α below 0, or an operator without a finite response.
    pub fn largest_beta(&self, delta: f64, alpha: f64) -> Result<Largest, AnalysisError> {
        let delta = not_negative("delta", delta, "")?;
        let alpha = not_negative("alpha", alpha, "")?;
        let found = largest(
            delta,
            |beta| self.supremum(alpha, beta),
            self.supremum(0.0, 1.0)?,
            |theta, beta| {
                let port = self.at(theta);
                port.tangent([(port.v, port.p), (port.u, 1.0.into())], beta, alpha)
            },
        )?;
        // Beyond α/|P(1)| the wall has a negative spring at rest.
        let cut = self.largest_ratio().map(|ratio| alpha * ratio);
        Ok(match (found, cut) {
            (Largest::Below { value, .. }, Some(cut)) if value > cut => Largest::Below {
                value: cut,
                worst_theta: 0.0,
            },
            (Largest::Any, Some(cut)) => Largest::Below {
                value: cut,
                worst_theta: 0.0,
            },
            (found, _) => found,
        })
    }

    /// The largest K, N/m, for b in N·s/m and B in N·s^μ/m.
    ///
    /// # Errors
    /// T not above 0, b or B below 0, or an operator without a finite response.
    pub fn largest_stiffness(
        &self,
        sample_time: Seconds,
        damping: f64,
        dissipation: f64,
    ) -> Result<Largest, AnalysisError> {
        let (t, _, beta) = self.for_unit_mass(sample_time, 0.0, dissipation)?;
        let delta = not_negative("damping", damping, "N·s/m")? * t;
        // K = α/T² at m = 1
        self.largest_alpha(delta, beta)?.times(1.0 / (t * t))
    }

    /// The largest B, N·s^μ/m, for b in N·s/m and K in N/m.
    ///
    /// # Errors
    /// T not above 0, b or K below 0, or an operator without a finite response.
    pub fn largest_dissipation(
        &self,
        sample_time: Seconds,
        damping: f64,
        stiffness: f64,
    ) -> Result<Largest, AnalysisError> {
        let (t, alpha, _) = self.for_unit_mass(sample_time, stiffness, 0.0)?;
        let delta = not_negative("damping", damping, "N·s/m")? * t;
        // B = β·T^(μ−2) at m = 1
        let factor = libm::pow(t, self.order.get() - 2.0);
        self.largest_beta(delta, alpha)?.times(factor)
    }

    /// T, α and β for m = 1 kg: the condition with units does not depend on the mass.
    fn for_unit_mass(
        &self,
        Seconds(t): Seconds,
        stiffness: f64,
        dissipation: f64,
    ) -> Result<(f64, f64, f64), AnalysisError> {
        let t = positive("sample time", t, "s")?;
        let stiffness = not_negative("stiffness", stiffness, "N/m")?;
        let dissipation = not_negative("dissipation", dissipation, "N·s^μ/m")?;
        let beta = dissipation * libm::pow(t, 2.0 - self.order.get());
        Ok((t, stiffness * t * t, beta))
    }

    /// Everything at 0 ≤ θ ≤ π, limits at 0.
    fn at(&self, theta: f64) -> At {
        if theta == 0.0 {
            let p = if self.p_at_rest == 0.0 {
                0.0
            } else {
                self.p_at_rest
            };
            return At {
                u: self.path.mean_delay() + 0.5,
                v: self.v_at_rest,
                p: p.into(),
                spread: self.path.profile(0.0).spread,
            };
        }
        let p = self.operator.response(theta);
        // (1 − w)/(2(1 − cos θ)) = j e^(−jθ/2)/(2 sin(θ/2)), and Re{j e^(−jφ)(a + jc)} = a sin φ − c cos φ
        let twice = 2.0 * libm::sin(0.5 * theta);
        if self.path.is_whole() {
            let phase = (self.path.whole_samples() as f64 + 0.5) * theta;
            let (sin, cos) = (libm::sin(phase), libm::cos(phase));
            return At {
                u: sin / twice,
                v: (p.re * sin - p.im * cos) / twice,
                p,
                spread: 0.0,
            };
        }
        let Profile { mean, spread } = self.path.profile(theta);
        let turn = Complex::new(libm::sin(0.5 * theta), libm::cos(0.5 * theta)) * mean;
        At {
            u: turn.re / twice,
            v: (turn * p).re / twice,
            p,
            spread,
        }
    }

    /// The δ that one frequency asks for.
    fn combine(&self, alpha: f64, beta: f64, theta: f64) -> f64 {
        self.at(theta).needed(alpha, beta)
    }

    fn supremum(&self, alpha: f64, beta: f64) -> Result<Maximum, AnalysisError> {
        let at_zero = self.combine(alpha, beta, 0.0);
        let found = (self.grid).maximum(at_zero, &|theta| self.combine(alpha, beta, theta));
        let worst = found.unwrap_or(Maximum {
            theta: 0.0,
            value: f64::NAN,
        });
        finite("least delta", worst.value, "")?;
        Ok(worst)
    }

    /// v(θ → 0) = (1/2 + mean delay)·P(0) − lim Im P/θ.
    fn limit_of_v(&mut self) -> Result<f64, AnalysisError> {
        const NEAR: f64 = 1e-60;
        const NEARER: f64 = 1e-90;
        // The exponent between the two distinguishes a power of θ from a constant.
        let limit = |near: f64, nearer: f64| {
            let exponent = libm::log(libm::fabs(near / nearer)) / libm::log(NEAR / NEARER);
            if near == 0.0 || exponent > 1e-13 {
                0.0
            } else if exponent < -1e-13 {
                nearer * f64::INFINITY
            } else {
                near
            }
        };
        let (near, nearer) = (self.operator.response(NEAR), self.operator.response(NEARER));
        let slope = limit(near.im / NEAR, nearer.im / NEARER);
        let rest = limit(near.re, nearer.re);
        self.p_at_rest = rest;
        let v = (self.path.mean_delay() + 0.5) * rest - slope;
        if v == f64::INFINITY || v.is_nan() {
            // As an integral would.
            finite("least delta", v, "")?;
        }
        Ok(v)
    }
}

/// The damping that Theorem 1 requires, without units, with Corollary 1's for comparison.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct RequiredDelta {
    /// The loop is passive for δ above this, and only then.
    pub delta: f64,
    /// θ that requires it, rad/sample; among several, π comes first, then 0, then the largest.
    pub worst_theta: f64,
    /// The damping that Corollary 1 requires: [`corollary_delta`](crate::corollary_delta).
    pub corollary_delta: f64,
    /// α + βP(1) < 0: a negative spring at rest, which no damping makes passive. Theorem 1 covers
    /// only θ > 0 and misses it. The Muir polynomial A₃ with μ > 1 has one: P(1) = (1−μ)(3−μ)/3.
    pub negative_at_rest: bool,
}

impl RequiredDelta {
    /// True if a loop of this δ is passive. The inequality is strict, as in the theorem; a negative
    /// spring at rest is never passive.
    #[must_use]
    pub fn passive(&self, delta: f64) -> bool {
        delta > self.delta && !self.negative_at_rest
    }
}

/// Corollary 1, nondimensional: δ > α/2 + β·2^(μ−1); with units b > KT/2 + B(T/2)^(1−μ).
///
/// Equal to Theorem 1 for the exact operator (1 − w)^μ without extra delay and 0 ≤ μ ≤ 2 (in fact for every μ ≥ 0; worst at θ = π). It says
/// nothing about another operator: the Muir polynomial of the dissertation's chapter 4 needs up to a third more on the β term. Nor about a delay: d
/// samples make the α term 2d + 1 times as large, and the β term larger where μ < 1 (where μ ≥ 1 it stays sufficient).
///
/// # Errors
/// α or β below 0, or μ < 0.
///
/// Source: O. Tokatlı, *Fractional Order Control in Haptics*, eqs. 5.1, 5.2.
pub fn corollary_delta(order: Order, alpha: f64, beta: f64) -> Result<f64, AnalysisError> {
    check_order(order)?;
    let alpha = not_negative("alpha", alpha, "")?;
    let beta = not_negative("beta", beta, "")?;
    // α/2 + β·2^(μ−1)
    finite(
        "least delta",
        0.5 * alpha + beta * libm::pow(2.0, order.get() - 1.0),
        "",
    )
}

/// Theorem 1 has a bound for derivatives only.
pub(crate) fn check_order(order: Order) -> Result<(), AnalysisError> {
    let value = order.get();
    let allowed = "in [0, 2], where the passivity theorem has a bound";
    range("order", value, value >= 0.0, allowed, "")?;
    Ok(())
}
