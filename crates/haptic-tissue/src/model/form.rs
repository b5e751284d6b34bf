//! The elements of models, and how they are joined.

use super::kind::Joint;
use core::f64::consts::PI;
use num_complex::Complex64;

/// A spring-pot, between a spring (α = 0) and a dashpot (α = 1): the one element that all models are made of.
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

/// A branch of a generalised Maxwell model: a spring and a dashpot in series.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaxwellBranch {
    /// Modulus of the spring, Pa.
    pub elastic_modulus_pa: f64,
    /// Viscosity of the dashpot over it, s.
    pub relaxation_time_s: f64,
}

/// The elements of a model.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Form {
    One(SpringPot),
    Two(Two),
    /// A Prony series: a spring in Pa, 0 for none, and branches, fastest first.
    Branches(f64, Vec<MaxwellBranch>),
}

/// Two elements, orders α > β.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Two {
    pub(crate) joint: Joint,
    /// V, α.
    pub(crate) first: SpringPot,
    /// G, β.
    pub(crate) second: SpringPot,
    /// E of the spring that Zener and Poynting–Thomson models have, Pa; else 0.
    pub(crate) spring_pa: f64,
}

impl Form {
    /// M of the model from those of its elements; branches of a Prony series are elements too.
    pub(super) fn joined(
        &self,
        element: impl Fn(&SpringPot) -> Complex64,
        branch: impl Fn(&MaxwellBranch) -> Complex64,
    ) -> Complex64 {
        match self {
            Self::One(one) => element(one),
            Self::Two(two) => {
                let (first, second) = (element(&two.first), element(&two.second));
                match two.joint {
                    Joint::Maxwell => series(first, second),
                    Joint::Zener => series(first, second) + two.spring_pa,
                    Joint::PoyntingThomson => {
                        series(first + second, Complex64::new(two.spring_pa, 0.0))
                    }
                    Joint::None | Joint::KelvinVoigt | Joint::Branches => first + second,
                }
            }
            Self::Branches(spring_pa, branches) => {
                let spring = Complex64::new(*spring_pa, 0.0);
                branches.iter().fold(spring, |sum, one| sum + branch(one))
            }
        }
    }

    /// G(0), Pa: infinite where a sudden strain has no finite stress.
    pub(super) fn instantaneous_pa(&self) -> f64 {
        let stiff = |one: &SpringPot| {
            if one.is_spring() {
                one.size
            } else {
                f64::INFINITY
            }
        };
        match self {
            Self::One(one) => stiff(one),
            Self::Two(two) => match two.joint {
                Joint::Maxwell => stiff(&two.second),
                Joint::Zener => stiff(&two.second) + two.spring_pa,
                Joint::PoyntingThomson => two.spring_pa,
                Joint::None | Joint::KelvinVoigt | Joint::Branches => f64::INFINITY,
            },
            Self::Branches(spring_pa, branches) => branches
                .iter()
                .fold(*spring_pa, |sum, one| sum + one.elastic_modulus_pa),
        }
    }

    pub(super) fn equilibrium_pa(&self) -> f64 {
        let left = |one: &SpringPot| if one.is_spring() { one.size } else { 0.0 };
        match self {
            Self::One(one) => left(one),
            Self::Two(two) => match two.joint {
                Joint::Maxwell => 0.0,
                Joint::Zener => two.spring_pa,
                Joint::PoyntingThomson => {
                    let beside = left(&two.second);
                    two.spring_pa * (beside / (two.spring_pa + beside))
                }
                Joint::None | Joint::KelvinVoigt | Joint::Branches => left(&two.second),
            },
            Self::Branches(spring_pa, _) => *spring_pa,
        }
    }
}

#[cfg(feature = "identify")]
impl Joint {
    /// M and its derivatives by the moduli of the elements e₁, e₂ and the spring e₃.
    pub(crate) fn join(self, e: [Complex64; 3]) -> (Complex64, [Complex64; 3]) {
        let (one, zero) = (Complex64::new(1.0, 0.0), Complex64::new(0.0, 0.0));
        match self {
            Self::KelvinVoigt => (e[0] + e[1], [one, one, zero]),
            joint @ (Self::Maxwell | Self::Zener) => {
                // 1/M = 1/e₁ + 1/e₂, so ∂M/∂e₁ = (e₂/(e₁ + e₂))².
                let inverse = (e[0] + e[1]).inv();
                let (first, second) = (e[1] * inverse, e[0] * inverse);
                let series = e[0] * first;
                let (modulus, spring) = if joint == Self::Zener {
                    (series + e[2], one)
                } else {
                    (series, zero)
                };
                (modulus, [first * first, second * second, spring])
            }
            Self::PoyntingThomson => {
                let side_by_side = e[0] + e[1];
                let inverse = (side_by_side + e[2]).inv();
                let (soft, spring) = (e[2] * inverse, side_by_side * inverse);
                (
                    side_by_side * soft,
                    [soft * soft, soft * soft, spring * spring],
                )
            }
            Self::None | Self::Branches => (e[0], [one, zero, zero]),
        }
    }
}

/// 1/z. The relative accuracy of the imaginary part is that of z, however small it is.
pub(super) fn inverse(z: Complex64) -> Complex64 {
    let square = z.norm_sqr();
    Complex64::new(z.re / square, -z.im / square)
}

/// Compliances add; their imaginary parts have one sign, so nothing cancels.
fn series(a: Complex64, b: Complex64) -> Complex64 {
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

    /// The same with e^(iπα·`half_turns`) known.
    pub(super) fn modulus_along(&self, ln_r: f64, direction: Complex64) -> Complex64 {
        direction * (self.size * libm::exp(self.order * ln_r))
    }

    /// G(t), Pa, for t > 0.
    pub(super) fn relaxation(&self, time_s: f64) -> f64 {
        if self.is_dashpot() {
            return 0.0;
        }
        self.size * libm::pow(time_s, -self.order) / libm::tgamma(1.0 - self.order)
    }

    /// J(t), 1/Pa, for t > 0.
    pub(super) fn creep(&self, time_s: f64) -> f64 {
        libm::pow(time_s, self.order) / (self.size * libm::tgamma(1.0 + self.order))
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
