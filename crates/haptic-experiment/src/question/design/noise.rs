//! Noise of the force that encoder steps make.
//!
//! Steps q of the position are noise of q/√12 (standard deviation), white as long as the device moves by
//! more than a step a sample. The operator adds its weights' squares:
//!
//! ```text
//! rms = B·(q/√12)·T^(−μ)·√(Σ c_j²),     exact operator: Σ c_j² = Γ(2μ + 1)/Γ(μ + 1)²
//! ```

use crate::document::failure::Failure;
use crate::judge::modelled_tissue::operator;
use fracdiff::{Order, Scheme, Seconds};
use haptic_analysis::noise_gain;
use haptic_tissue::Model;

/// Memory for which an operator is designed here, samples: twice the weights that are summed.
const HORIZON: f64 = 8192.0;

/// T^(−μ)·√(Σ c²) of the operator that runs, s^(−μ): rms of the output for white noise of 1.
///
/// # Errors
/// A scheme that cannot be made for this order and sample time.
pub(super) fn amplification(
    model: Option<&Model>,
    scheme: Scheme,
    order: Order,
    sample_time: Seconds,
) -> Result<f64, Failure> {
    let operator = operator::<f64>(model, scheme, order, sample_time, HORIZON)?;
    Ok(noise_gain(operator))
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptic_analysis::exact_noise_gain;

    #[test]
    fn it_is_the_closed_form_for_the_exact_operator() {
        let t = Seconds(2e-3);
        for mu in [0.0, 0.3, 0.5, 1.0, 1.5, 2.0] {
            let order = Order::new(mu).expect("in range");
            let scheme = "full".parse().expect("a scheme");
            let have = amplification(None, scheme, order, t).expect("builds");
            let want = exact_noise_gain(order, t).expect("in range");
            assert!((have / want - 1.0).abs() < 1e-5, "{mu}: {have} {want}");
        }
    }

    #[test]
    fn a_polynomial_has_its_own_weights() {
        // A₃ at μ = 1: 1, −1, 1/3, −1/3.
        let order = Order::new(1.0).expect("in range");
        let have =
            amplification(None, Scheme::Muir { degree: 3 }, order, Seconds(1.0)).expect("builds");
        assert!(
            (have - (2.0 + 2.0 / 9.0_f64).sqrt()).abs() < 1e-12,
            "{have}"
        );
    }
}
