//! From the modulus M(s) to functions of time, by quadrature along a contour.
//!
//! ```text
//! f(t) = (1/2πi) ∫ e^(st) F(s) ds ≈ Re Σ_k c_k F(z_k/t)/t        s = z/t on a Talbot contour
//! relaxation modulus  F = M(s)/s      creep compliance  F = 1/(s·M(s))      its integral  F = M(s)/s²
//! ```
//! Each F is analytic off the negative axis, for springs and dashpots as for spring-pots, so one contour serves all models and
//! all times: only z_k^α changes with the model, only t^(−α) with the time. 28 points, half of them by symmetry, give 1e-12 of
//! F(1/t)/t; of a modulus that has fallen far below |M(1/t)|, as beyond a dashpot, correspondingly less.
//!
//! Source: L. N. Trefethen, J. A. C. Weideman, T. Schmelzer, *Talbot quadratures and rational approximations*, BIT 46, 2006,
//! equation of the modified contour.

use super::candidate::{Candidate, ELEMENTS, VARIABLES};
use super::elements::{Elements, Slope};
use num_complex::Complex64;

/// Points of the whole contour.
const POINTS: usize = 28;
/// Those above the real axis.
const HALF: usize = POINTS / 2;

/// A function of time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quantity {
    /// G(t).
    Relaxation,
    /// J(t).
    Creep,
    /// ∫₀ᵗ G.
    Integral,
}

/// The contour, and a model on it.
#[derive(Clone, Debug)]
pub(super) struct Contour {
    candidate: Candidate,
    quantity: Quantity,
    elements: Elements,
    /// ln z_k as size and angle.
    ln_z: [(f64, f64); HALF],
    /// c_k/z_k, or c_k/z_k² for the integral.
    weight: [Complex64; HALF],
    /// z_k^α_i.
    power: [[Complex64; HALF]; ELEMENTS],
}

impl Contour {
    pub(super) fn new(candidate: Candidate, quantity: Quantity, elements: Elements) -> Self {
        // z(θ) = N(0.5017 θ cot 0.6407θ − 0.6122 + 0.2645iθ), θ_k = (2k + 1)π/N.
        const N: f64 = POINTS as f64;
        let mut contour = Self {
            candidate,
            quantity,
            elements,
            ln_z: [(0.0, 0.0); HALF],
            weight: [Complex64::new(0.0, 0.0); HALF],
            power: [[Complex64::new(0.0, 0.0); HALF]; ELEMENTS],
        };
        for k in 0..HALF {
            let theta = (2 * k + 1) as f64 * core::f64::consts::PI / N;
            let turn = 0.6407 * theta;
            let cotangent = libm::cos(turn) / libm::sin(turn);
            let slope = 0.5017 * (cotangent - turn * (1.0 + cotangent * cotangent));
            let z = Complex64::new(0.5017 * theta * cotangent - 0.6122, 0.2645 * theta) * N;
            let dz = Complex64::new(slope, 0.2645) * N;
            // f(t) = Re Σ 2e^z z'/(iN) F(z/t)/t over the upper half.
            let growth = libm::exp(z.re);
            let exponential = Complex64::new(growth * libm::cos(z.im), growth * libm::sin(z.im));
            let c = exponential * dz / Complex64::new(0.0, 0.5 * N);
            contour.weight[k] = match quantity {
                Quantity::Relaxation | Quantity::Creep => c / z,
                Quantity::Integral => c / (z * z),
            };
            contour.ln_z[k] = (libm::log(libm::hypot(z.re, z.im)), libm::atan2(z.im, z.re));
        }
        contour.turn_to(elements);
        contour
    }

    /// The same with other elements.
    pub(super) fn turn_to(&mut self, elements: Elements) {
        self.elements = elements;
        for (i, powers) in self.power.iter_mut().enumerate() {
            for (power, &(size, angle)) in powers.iter_mut().zip(&self.ln_z) {
                let (order, grown) = (elements.order[i], libm::exp(elements.order[i] * size));
                *power = Complex64::new(libm::cos(order * angle), libm::sin(order * angle)) * grown;
            }
        }
    }

    /// The quantity at t = t₀·e^(ln_time), and its derivatives by the variables; for the integral in units of t₀.
    pub(super) fn at(&self, ln_time: f64) -> Slope {
        let (candidate, zero) = (self.candidate, Complex64::new(0.0, 0.0));
        let mut size = [0.0; ELEMENTS];
        for (i, size) in size.iter_mut().enumerate() {
            if self.elements.is_used(candidate, i) {
                *size = libm::exp(self.elements.ln_modulus[i] - self.elements.order[i] * ln_time);
            }
        }
        let mut value = 0.0;
        let (mut by_modulus, mut by_order) = ([0.0; ELEMENTS], [0.0; ELEMENTS]);
        for k in 0..HALF {
            let mut e = [zero; ELEMENTS];
            for i in 0..ELEMENTS {
                e[i] = self.power[i][k] * size[i];
            }
            let (modulus, derivatives) = candidate.join(e);
            let weight = self.weight[k];
            let outer = match self.quantity {
                Quantity::Creep => {
                    let compliance = modulus.inv();
                    value += (weight * compliance).re;
                    -weight * compliance * compliance
                }
                Quantity::Relaxation | Quantity::Integral => {
                    value += (weight * modulus).re;
                    weight
                }
            };
            let ln_s = Complex64::new(self.ln_z[k].0 - ln_time, self.ln_z[k].1);
            for i in 0..ELEMENTS {
                // ∂M/∂a_i = e_i·∂M/∂e_i,  ∂M/∂α_i = e_i·ln(s·t₀)·∂M/∂e_i.
                let term = outer * derivatives[i] * e[i];
                by_modulus[i] += term.re;
                by_order[i] += (term * ln_s).re;
            }
        }
        let scale = match self.quantity {
            Quantity::Relaxation | Quantity::Creep => 1.0,
            Quantity::Integral => libm::exp(ln_time),
        };
        gathered(candidate, scale, value, by_modulus, by_order)
    }
}

/// A value and its derivatives in the order of the variables.
pub(super) fn gathered(
    candidate: Candidate,
    scale: f64,
    value: f64,
    by_modulus: [f64; ELEMENTS],
    by_order: [f64; ELEMENTS],
) -> Slope {
    let mut by = [0.0; VARIABLES];
    for i in 0..candidate.pots() {
        by[2 * i] = scale * by_modulus[i];
        by[2 * i + 1] = scale * by_order[i];
    }
    if candidate.has_spring() {
        by[2 * candidate.pots()] = scale * by_modulus[ELEMENTS - 1];
    }
    Slope {
        value: scale * value,
        by,
    }
}
