//! From the modulus M(s) to functions of time, by quadrature along a contour.
//! ```text
//! f(t) = (1/2πi) ∫ e^(st) F(s) ds ≈ Re Σ_k cₖ F(zₖ/t)/t        s = z/t on a Talbot contour
//! relaxation modulus  F = M(s)/s      creep compliance  F = 1/(s·M(s))      its integral  F = M(s)/s²
//! ```
//! Each F is analytic off the negative axis, for springs and dashpots as for spring-pots, so one contour serves all models and
//! all times: only zₖ^α changes with the model, only t^(−α) with the time. 28 points, half of them by symmetry, give 1e-12 of
//! F(1/t)/t; of a modulus that has fallen far below |M(1/t)|, as beyond a dashpot, correspondingly less.
//!
//! Source: L. N. Trefethen, J. A. C. Weideman, T. Schmelzer, *Talbot quadratures and rational approximations*, BIT 46, 2006,
//! equation of the modified contour.

use super::elements::{Candidate, ELEMENTS, Elements, Slope};
use num_complex::Complex64;

/// Points of the whole contour.
const POINTS: usize = 28;
/// Those above the real axis.
const HALF: usize = POINTS / 2;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quantity {
    Relaxation,
    Creep,
    Integral,
}

/// The contour, and a model on it.
#[derive(Clone, Debug)]
pub(super) struct Contour {
    candidate: Candidate,
    quantity: Quantity,
    elements: Elements,
    /// ln zₖ as size and angle.
    ln_z: [(f64, f64); HALF],
    /// cₖ/zₖ, or cₖ/zₖ² for the integral.
    weight: [Complex64; HALF],
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
        for (i, powers) in contour.power.iter_mut().enumerate() {
            for (power, &(size, angle)) in powers.iter_mut().zip(&contour.ln_z) {
                let (order, grown) = (elements.order[i], libm::exp(elements.order[i] * size));
                *power = Complex64::new(libm::cos(order * angle), libm::sin(order * angle)) * grown;
            }
        }
        contour
    }

    /// The quantity at t = t₀·exp(`ln_time`), and its derivatives by the variables; for the integral in units of t₀.
    pub(super) fn at(&self, ln_time: f64) -> Slope {
        let (candidate, zero) = (self.candidate, Complex64::new(0.0, 0.0));
        let mut size = [0.0; ELEMENTS];
        for (i, size) in size.iter_mut().enumerate() {
            if 2 * i < candidate.variables() {
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
                // ∂M/∂aᵢ = eᵢ·∂M/∂eᵢ,  ∂M/∂αᵢ = eᵢ·ln(s·t₀)·∂M/∂eᵢ.
                let term = outer * derivatives[i] * e[i];
                by_modulus[i] += term.re;
                by_order[i] += (term * ln_s).re;
            }
        }
        let scale = match self.quantity {
            Quantity::Relaxation | Quantity::Creep => 1.0,
            Quantity::Integral => libm::exp(ln_time),
        };
        Slope::of(candidate, scale, value, by_modulus, by_order)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Model, ModelKind};

    /// V, α and G, β: t₀ is 1 s, so aᵢ = ln Vᵢ.
    const ELEMENTS_OF_TEST: [(f64, f64); 3] = [(876e3, 0.675), (22.1e3, 0.11), (900.0, 0.0)];

    fn elements(of: [(f64, f64); 3]) -> Elements {
        Elements {
            ln_modulus: of.map(|e| libm::log(e.0)),
            order: of.map(|e| e.1),
        }
    }

    fn relaxation((v, a): (f64, f64), t: f64) -> f64 {
        v * t.powf(-a) / libm::tgamma(1.0 - a)
    }

    fn compliance((v, a): (f64, f64), t: f64) -> f64 {
        t.powf(a) / (v * libm::tgamma(1.0 + a))
    }

    fn near(have: f64, want: f64) {
        assert!((have / want - 1.0).abs() < 1e-11, "{have} {want}");
    }

    /// What has a closed form without a Mittag-Leffler function, over twelve decades.
    #[test]
    fn sums_of_power_laws_are_met() {
        let of = ELEMENTS_OF_TEST;
        for decade in -6..=6 {
            let t = 10_f64.powi(decade);
            let at = |kind, quantity| {
                let contour = Contour::new(Candidate::of(kind), quantity, elements(of));
                contour.at(t.ln()).value
            };
            let pot = |quantity| at(ModelKind::SpringPot, quantity);
            near(pot(Quantity::Relaxation), relaxation(of[0], t));
            near(pot(Quantity::Creep), compliance(of[0], t));
            let integral = relaxation(of[0], t) * t / (1.0 - of[0].1);
            near(pot(Quantity::Integral), integral);
            let sum = |f: fn((f64, f64), f64) -> f64| f(of[0], t) + f(of[1], t);
            let beside = at(ModelKind::FractionalKelvinVoigt, Quantity::Relaxation);
            near(beside, sum(relaxation));
            let behind = at(ModelKind::FractionalMaxwell, Quantity::Creep);
            near(behind, sum(compliance));
        }
    }

    /// A spring and a dashpot in series: e^(−t/τ), until it is lost in rounding.
    #[test]
    fn a_classical_maxwell_model_decays_exponentially() {
        let of = elements([(100.0, 1.0), (50.0, 0.0), (1.0, 0.0)]);
        let contour = Contour::new(
            Candidate::of(ModelKind::FractionalMaxwell),
            Quantity::Relaxation,
            of,
        );
        for t in [1e-3, 0.1, 1.0, 5.0, 20.0_f64] {
            let error = contour.at(t.ln()).value - 50.0 * (-t / 2.0).exp();
            assert!(error.abs() < 1e-10, "{t}: {error}");
        }
    }

    /// The closed forms of the library, which are held against mpmath, for all models, ten decades around where their elements meet.
    #[test]
    fn the_closed_forms_of_the_library_are_met() {
        let of = [(3e4, 0.7), (2e4, 0.15), (5e3, 0.0)];
        for candidate in Candidate::fractional() {
            let mut parameters = vec![of[0].0, of[0].1, of[1].0, of[1].1, of[2].0];
            parameters.truncate(candidate.parameters());
            let model = Model::from_parameters(candidate.kind(), &parameters).expect("valid");
            for decade in -5..=5 {
                let t = 3.0 * 10_f64.powi(decade);
                let at = |quantity| {
                    Contour::new(candidate, quantity, elements(of))
                        .at(t.ln())
                        .value
                };
                near(at(Quantity::Relaxation), model.relaxation_moduli(&[t])[0]);
                near(at(Quantity::Creep), model.creep_compliances(&[t])[0]);
            }
        }
    }

    #[test]
    fn derivatives_are_those_of_the_values() {
        const STEP: f64 = 1e-5;
        for candidate in Candidate::fractional() {
            for quantity in [Quantity::Relaxation, Quantity::Creep, Quantity::Integral] {
                let values = elements(ELEMENTS_OF_TEST).variables(candidate);
                let at = |values: &[f64], ln_time: f64| {
                    Contour::new(candidate, quantity, Elements::from_variables(values)).at(ln_time)
                };
                for ln_time in [-6.0, 0.3, 5.0] {
                    let slope = at(&values, ln_time);
                    for v in 0..values.len() {
                        let beside = [-STEP, STEP].map(|step| {
                            let mut values = values.clone();
                            values[v] += step;
                            at(&values, ln_time).value
                        });
                        let want = (beside[1] - beside[0]) / (2.0 * STEP);
                        let error = (slope.by[v] - want).abs();
                        assert!(
                            error <= 1e-8 * slope.value.abs(),
                            "{candidate:?} {quantity:?} {v}: {} {want}",
                            slope.by[v]
                        );
                    }
                }
            }
        }
    }
}
