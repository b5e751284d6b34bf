//! Exact zero-order-hold discretisation by the augmented matrix exponential.
//!
//! ```text
//! x' = A·x + B·u,  u' = 0        exp( [A B; 0 0]·h ) = [Φ Γ; 0 I],   x(h) = Φ·x(0) + Γ·u
//! ```
//! - *One formula for every case*: undamped, critically damped, without stiffness. The closed forms
//!   with their removable singularities are not needed.
//! - *Scaling*: the exponential is taken of the generator in natural units of each state (diagonal
//!   similarity), so that its entries are pure numbers such as b·h/m and k·h²/m.
//! - *Exponential*: of M/2^s by its Taylor series, then squared s times. nalgebra has one too, but
//!   only with the standard library, and this one takes no roots or logarithms that could differ
//!   between targets.
//! - *Accuracy*, against closed forms: 2e-15 relative for b·h/m from 1e-12 to 1e6, and
//!   2e-15·(1 + ω·h) for an undamped oscillator with ω·h from 1e-6 to 1e3.
//! - *Cost*: at most 39 N×N products, once, in a constructor. Never in a sample.
//!
//! Sources: C. Van Loan, "Computing integrals involving the matrix exponential", IEEE Transactions
//! on Automatic Control 23(3), 1978; C. Moler and C. Van Loan, "Nineteen dubious ways to compute the
//! exponential of a matrix, twenty-five years later", SIAM Review 45(1), 2003, method 3.

use crate::LoopParameterError;
use fracdiff::parameter::RangeError;
use nalgebra::{SMatrix, SVector};

/// Largest entry of the scaled generator: how fast a motion may be, compared with the step.
const MOST_PER_STEP: f64 = 1e6;

/// exp(`generator`·`duration`). `scale[i]` is a natural unit of state i, for conditioning only.
pub(super) fn transition<const N: usize>(
    generator: &SMatrix<f64, N, N>,
    scale: &SVector<f64, N>,
    duration: f64,
) -> Result<SMatrix<f64, N, N>, LoopParameterError> {
    let scaled = SMatrix::<f64, N, N>::from_fn(|row, column| {
        generator[(row, column)] * duration * scale[column] / scale[row]
    });
    for &entry in &scaled {
        if !entry.is_finite() || entry.abs() > MOST_PER_STEP {
            let (what, allowed) = ("fastest motion per step", "at most 1e6 {}");
            return Err(RangeError::new(what, entry.abs(), allowed, "rad").into());
        }
    }
    let exponential = exponential(&scaled);
    Ok(SMatrix::from_fn(|row, column| {
        exponential[(row, column)] * scale[row] / scale[column]
    }))
}

/// A state after the time of its transition: the product of nalgebra to the bit, in half its time, which is most of a simulation.
pub(super) fn moved<const N: usize>(
    transition: &SMatrix<f64, N, N>,
    state: &SVector<f64, N>,
) -> SVector<f64, N> {
    SVector::from(core::array::from_fn(|row| {
        // To −0 anything is added without a change.
        (0..N).fold(-0.0, |sum, n| sum + transition[(row, n)] * state[n])
    }))
}

/// exp(M) = (Σ (M/2^s)^k/k!)^(2^s).
fn exponential<const N: usize>(matrix: &SMatrix<f64, N, N>) -> SMatrix<f64, N, N> {
    /// (1/2)^k/k! is below 1e-19 from here on.
    const TERMS: u32 = 16;
    let columns = matrix.column_iter();
    let norm = columns.fold(0.0, |most: f64, column| most.max(column.abs().sum()));
    // The least s for a norm below 1/2.
    let halvings = if norm < 0.5 { 0 } else { libm::ilogb(norm) + 2 };
    let small = matrix * libm::ldexp(1.0, -halvings);
    let identity = SMatrix::<f64, N, N>::identity();
    // Horner: 1 + M·(1 + M/2·(1 + M/3·(…)))
    let series = (1..=TERMS)
        .rev()
        .fold(identity, |sum, k| identity + small * sum / f64::from(k));
    (0..halvings).fold(series, |power, _| power * power)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Vector3};

    /// Nondimensional mass-damper: states x, v, u with x'' = -δ·x' - γ·x + u, over one unit of time.
    fn unit_step(delta: f64, gamma: f64) -> Matrix3<f64> {
        let generator = Matrix3::new(0.0, 1.0, 0.0, -gamma, -delta, 1.0, 0.0, 0.0, 0.0);
        let rate = libm::sqrt(gamma).max(1.0);
        let scale = Vector3::new(1.0, rate, rate * rate);
        transition(&generator, &scale, 1.0).expect("within the range")
    }

    #[test]
    fn a_state_moves_by_the_product_of_nalgebra_to_the_bit() {
        let number = |n: usize| libm::sin(1.7 * n as f64) * libm::exp(n as f64 % 7.0);
        let transition = SMatrix::<f64, 9, 9>::from_fn(|row, column| number(9 * row + column));
        let state = SVector::<f64, 9>::from_fn(|row, _| number(100 + row));
        assert_eq!(moved(&transition, &state), transition * state);
        let small = transition.fixed_view::<4, 4>(2, 3).into_owned();
        let few = state.fixed_rows::<4>(1).into_owned();
        assert_eq!(moved(&small, &few), small * few);
    }

    #[test]
    fn a_mass_damper_matches_its_closed_form_from_tiny_to_stiff() {
        for exponent in -12..=6 {
            let delta = libm::pow(10.0, f64::from(exponent));
            let have = unit_step(delta, 0.0);
            // (1 - e^-δ)/δ by expm1; (δ - 1 + e^-δ)/δ² cancels for small δ, so by series there.
            let velocity = -libm::expm1(-delta) / delta;
            let force = if delta < 1.0 {
                let mut term = 0.5;
                (3..30).fold(0.0, |sum, n| {
                    let next = sum + term;
                    term *= -delta / f64::from(n);
                    next
                })
            } else {
                (1.0 - velocity) / delta
            };
            let tolerance = 2e-15;
            for (name, have, want) in [
                ("x from v", have[(0, 1)], velocity),
                ("x from u", have[(0, 2)], force),
                ("v from u", have[(1, 2)], velocity),
            ] {
                let error = (have / want - 1.0).abs();
                assert!(error <= tolerance, "δ = {delta:e}, {name}: {error:e}");
            }
        }
    }

    #[test]
    fn an_oscillator_matches_its_closed_form_from_slow_to_many_turns() {
        for exponent in -6..=3 {
            let omega = libm::pow(10.0, f64::from(exponent));
            let have = unit_step(0.0, omega * omega);
            let error = [
                have[(0, 0)] - libm::cos(omega),
                have[(0, 1)] * omega - libm::sin(omega),
                have[(1, 0)] / omega + libm::sin(omega),
                have[(1, 1)] - libm::cos(omega),
            ]
            .into_iter()
            .fold(0.0, |most: f64, error| most.max(error.abs()));
            // A phase of ω radians cannot be known better than ω rounding errors.
            assert!(error <= 2e-15 * (1.0 + omega), "ω = {omega:e}: {error:e}");
        }
    }

    #[test]
    fn a_generator_that_is_too_fast_or_not_finite_is_refused() {
        for rate in [1.1e6, f64::INFINITY, f64::NAN] {
            let generator = Matrix3::from_element(rate);
            assert!(transition(&generator, &Vector3::repeat(1.0), 1.0).is_err());
        }
    }
}
