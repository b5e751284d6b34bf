//! What the force should have been: the full history, and closed forms.

use fracdiff::full_memory::Kernel;
use fracdiff::{Order, Seconds, batch};
use haptic_loop::Tissue;

/// D^μ of a whole record by its full history, no memory cut: [`batch::full_history`].
///
/// # Errors
/// If the kernel's weights cannot be made, which valid orders and sample times rule out.
pub fn full_history(
    kernel: Kernel,
    order: Order,
    sample_time: Seconds,
    x: &[f64],
) -> anyhow::Result<Vec<f64>> {
    Ok(batch::full_history(kernel, order, sample_time, x)?)
}

/// |have/want − 1|; infinite where nothing was wanted but something came, so never NaN for finite
/// input.
#[must_use]
pub fn relative_error(have: f64, want: f64) -> f64 {
    let difference = (have - want).abs();
    // 0 of 0 is no error.
    if difference > 0.0 || difference.is_nan() {
        difference / want.abs()
    } else {
        0.0
    }
}

/// The largest relative error from a given time on.
#[derive(Clone, Copy, Debug)]
pub struct LargestError {
    from_s: f64,
    most: Option<f64>,
}

impl LargestError {
    /// Of no sample yet; those before `from_s` do not count.
    #[must_use]
    pub const fn new(from_s: f64) -> Self {
        Self { from_s, most: None }
    }

    /// Takes in a sample.
    pub fn add(&mut self, time_s: f64, have: f64, want: f64) {
        // Half a nanosecond: times are multiples of T, rounded.
        if time_s < self.from_s - 0.5e-9 {
            return;
        }
        let error = relative_error(have, want);
        self.most = match self.most {
            Some(most) if !(error > most || error.is_nan()) => Some(most),
            _ => Some(error),
        };
    }

    /// The error; `None` if no sample lay there.
    #[must_use]
    pub const fn get(self) -> Option<f64> {
        self.most
    }
}

/// Strain of a tissue under a step of stress, closed form.
///
/// ```text
/// ε(t) = (σ₀/E₀)·(1 − E_α(−(E₀/η)·t^α)),      E₀ = 0:  ε(t) = (σ₀/η)·t^α/Γ(1 + α)
/// ```
/// `E_α` is the Mittag-Leffler function (R. Gorenflo, F. Mainardi, *Fractional calculus*, 1997); zero
/// for t ≤ 0. η = 0 is a spring, ε = σ₀/E₀.
#[must_use]
pub fn creep_strain(tissue: &Tissue, stress_pa: f64, time_s: f64) -> f64 {
    use mittagleffler::MittagLeffler as _;
    let (modulus, viscosity, alpha) = (
        tissue.elastic_modulus().0,
        tissue.viscosity_pa_s_alpha(),
        tissue.order().get(),
    );
    if time_s <= 0.0 {
        0.0
    } else if viscosity == 0.0 {
        stress_pa / modulus
    } else if modulus == 0.0 {
        stress_pa / viscosity * libm::pow(time_s, alpha) / libm::tgamma(1.0 + alpha)
    } else if alpha == 0.0 {
        // D⁰ is the identity: two springs side by side.
        stress_pa / (modulus + viscosity)
    } else {
        let argument = -(modulus / viscosity) * libm::pow(time_s, alpha);
        // None only for parameters outside 0 < α ≤ 1, which a tissue cannot have.
        let value = argument
            .mittag_leffler(alpha, 1.0)
            .map_or(f64::NAN, |value| value.re);
        stress_pa / modulus * (1.0 - value)
    }
}

#[cfg(test)]
#[expect(clippy::float_cmp, reason = "exact results are compared exactly")]
mod tests {
    use super::*;
    use haptic_loop::units::Pascals;

    fn order(mu: f64) -> Order {
        Order::new(mu).expect("valid")
    }

    #[test]
    fn creep_agrees_with_50_digits() {
        // tests/golden/make_golden.py: E_α(−z). With E₀ = 1, η = 1/z, t = 1 the argument is −z.
        let golden = include_str!("../../../../tests/golden/mittag_leffler.csv");
        for line in golden.lines().skip(1) {
            let cells: Vec<f64> = line
                .split(',')
                .map(|c| c.parse().expect("number"))
                .collect();
            let (alpha, z, value) = (cells[0], cells[1], cells[2]);
            let tissue = Tissue::new(Pascals(1.0), 1.0 / z, order(alpha)).expect("valid");
            let have = creep_strain(&tissue, 1.0, 1.0);
            assert!(
                (have - (1.0 - value)).abs() < 1e-12,
                "α {alpha} z {z}: {have}"
            );
        }
    }

    #[test]
    fn creep_of_a_soft_spring_tends_to_creep_without_one() {
        let with = Tissue::new(Pascals(1e-4), 8650.0, order(0.2247)).expect("valid");
        let without = Tissue::new(Pascals(0.0), 8650.0, order(0.2247)).expect("valid");
        for t in [0.01, 1.0, 200.0] {
            let (a, b) = (
                creep_strain(&with, 100.0, t),
                creep_strain(&without, 100.0, t),
            );
            assert!(relative_error(a, b) < 1e-6, "t {t}: {a} {b}");
        }
    }

    #[test]
    fn the_largest_error_is_looked_for_in_its_window_only() {
        let time = [0.0, 1.0, 2.0, 3.0];
        let (have, want) = ([9.0, 1.0, 2.2, 3.0], [1.0, 1.0, 2.0, 3.0]);
        let largest = |have: [f64; 4], from_s| {
            let mut largest = LargestError::new(from_s);
            (0..4).for_each(|n| largest.add(time[n], have[n], want[n]));
            largest.get()
        };
        let error = largest(have, 1.0).expect("samples");
        assert!((error - 0.1).abs() < 1e-15, "{error}");
        assert_eq!(largest(have, 4.0), None);
        assert_eq!(relative_error(0.0, 0.0), 0.0);
        assert_eq!(relative_error(1.0, 0.0), f64::INFINITY);
        let nan = largest([0.0, f64::NAN, 1.0, 2.0], 0.0);
        assert!(nan.expect("samples").is_nan());
    }
}
