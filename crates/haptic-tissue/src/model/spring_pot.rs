//! The spring-pot, the one element that all models are made of.

use core::f64::consts::PI;
use num_complex::Complex64;

/// The two functions of time.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Response {
    /// G, the stress over a step of strain.
    Relaxation,
    /// J, the strain over a step of stress.
    Creep,
}

/// A spring-pot, between a spring (α = 0) and a dashpot (α = 1).
/// ```text
/// σ = V·D^α ε        M(s) = V·s^α,   G(t) = V·t^(−α)/Γ(1−α),   J(t) = t^α/(V·Γ(1+α))
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SpringPot {
    /// V > 0, Pa·s^α.
    pub(crate) size: f64,
    /// 0 ≤ α ≤ 1.
    pub(crate) order: f64,
}

/// 1/z. The relative accuracy of the imaginary part is that of z, however small it is.
pub(super) fn inverse(z: Complex64) -> Complex64 {
    let square = z.norm_sqr();
    Complex64::new(z.re / square, -z.im / square)
}

/// Compliances add; their imaginary parts have one sign, so nothing cancels.
pub(super) fn series(a: Complex64, b: Complex64) -> Complex64 {
    // At rest a dashpot gives way to everything.
    if a.norm_sqr() == 0.0 || b.norm_sqr() == 0.0 {
        return Complex64::ZERO;
    }
    inverse(inverse(a) + inverse(b))
}

impl SpringPot {
    pub(crate) const fn new(size: f64, order: f64) -> Self {
        Self { size, order }
    }

    /// α = 0.
    pub(crate) fn is_spring(&self) -> bool {
        self.order <= 0.0
    }

    /// α = 1.
    pub(crate) fn is_dashpot(&self) -> bool {
        self.order >= 1.0
    }

    /// M(s), Pa, on the principal branch: on the negative axis from above where the imaginary part is +0.
    pub(crate) fn modulus(&self, s: Complex64) -> Complex64 {
        if self.is_spring() {
            return Complex64::new(self.size, 0.0);
        }
        let size = self.size * libm::pow(libm::hypot(s.re, s.im), self.order);
        let angle = self.order * libm::atan2(s.im, s.re);
        Complex64::new(size * libm::cos(angle), size * libm::sin(angle))
    }

    /// M(s) at s = e^(`ln_r`)·e^(iπ·`half_turns`), on any sheet; its imaginary part is exactly 0 where α·`half_turns` is whole.
    pub(super) fn modulus_at(&self, ln_r: f64, half_turns: f64) -> Complex64 {
        self.modulus_along(ln_r, turned(self.order * half_turns))
    }

    /// M(s) as [`Self::modulus_at`], with e^(iπα·`half_turns`) known.
    pub(super) fn modulus_along(&self, ln_r: f64, direction: Complex64) -> Complex64 {
        if self.is_spring() {
            return Complex64::new(self.size, 0.0);
        }
        direction * (self.size * libm::exp(self.order * ln_r))
    }

    /// G(t) in Pa, or J(t) in 1/Pa, for t > 0.
    pub(super) fn response(&self, response: Response, time_s: f64) -> f64 {
        let order = self.order;
        match response {
            Response::Relaxation if self.is_dashpot() => 0.0,
            Response::Relaxation => {
                self.size * libm::pow(time_s, -order) / libm::tgamma(1.0 - order)
            }
            Response::Creep => libm::pow(time_s, order) / (self.size * libm::tgamma(1.0 + order)),
        }
    }
}

/// e^(iπx) for x ≥ 0; its parts are exactly 0 where they should be.
pub(super) fn turned(x: f64) -> Complex64 {
    let half_turns = x - 2.0 * libm::floor(x / 2.0);
    // Angle = quarter turns + rest, |rest| ≤ 1/4 of a half turn; x − whole is exact.
    let quarters = libm::round(2.0 * half_turns);
    let (sin, cos) = libm::sincos(PI * (half_turns - 0.5 * quarters));
    match quarters as u8 % 4 {
        0 => Complex64::new(cos, sin),
        1 => Complex64::new(-sin, cos),
        2 => Complex64::new(-cos, -sin),
        _ => Complex64::new(sin, -cos),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_is_exact_at_quarters_and_close_elsewhere() {
        assert_eq!(turned(1.0), Complex64::new(-1.0, 0.0));
        assert_eq!(turned(0.5), Complex64::new(0.0, 1.0));
        assert_eq!(turned(0.0), Complex64::new(1.0, 0.0));
        for x in [0.01, 0.3, 0.7, 0.999, 1.2, 1.49, 1.9, 2.3] {
            let want = Complex64::from_polar(1.0, PI * x);
            assert!((turned(x) - want).norm() < 1e-15, "{x}");
        }
        // Close to a whole turn nothing cancels: sin(π(1 − δ)) = sin πδ.
        let close = 1.0 - 1e-9;
        let want = libm::sin(PI * (1.0 - close));
        assert!((turned(close).im / want - 1.0).abs() < 1e-15);
    }
}
