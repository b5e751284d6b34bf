//! What may stand beside a spring, without a spring constant of its own at rest.

use crate::model::SpringPot;
use num_complex::Complex64;

/// Elements that give way to a slow motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Branch {
    /// A spring-pot or dashpot, α > 0.
    Pot(SpringPot),
    /// Two in series, α > β.
    Series {
        /// V, α.
        first: SpringPot,
        /// G, β.
        second: SpringPot,
    },
    /// A spring in series with two side by side, α > β > 0.
    Standing {
        /// The spring, Pa.
        spring_pa: f64,
        /// V, α.
        first: SpringPot,
        /// G, β.
        second: SpringPot,
    },
}

impl Branch {
    pub(super) const fn series(first: SpringPot, second: SpringPot) -> Self {
        Self::Series { first, second }
    }

    /// M(s), Pa, on the principal branch; 0 at s = 0.
    pub(super) fn modulus(&self, s: Complex64) -> Complex64 {
        match self {
            Self::Pot(one) => one.modulus(s),
            Self::Series { first, second } => {
                // a·b/(a + b) = a/(1 + a/b), with a and b 0 at rest
                let (v, g) = (first.viscosity_pa_s_alpha(), second.viscosity_pa_s_alpha());
                let ratio = power(s, first.order() - second.order()) * (v / g);
                first.modulus(s) / (ratio + 1.0)
            }
            Self::Standing {
                spring_pa,
                first,
                second,
            } => {
                let beside = first.modulus(s) + second.modulus(s);
                beside / (beside / *spring_pa + 1.0)
            }
        }
    }

    /// Im M(−r + i0) ≥ 0, Pa, without the pole. All that is added up is positive, but the sum of two elements itself.
    pub(super) fn on_cut(&self, r: f64) -> f64 {
        match self {
            Self::Pot(one) => Cut::of(one, r).value().im,
            Self::Series { first, second } => {
                // Im ab/(a + b) = |a||b|(|a| sin πβ + |b| sin πα)/|a + b|²
                let (a, b) = (Cut::of(first, r), Cut::of(second, r));
                let unit = a.size.max(b.size);
                let (a, b) = (a.over(unit), b.over(unit));
                let above = a.size * b.size * (a.size * b.sin + b.size * a.sin);
                if above == 0.0 {
                    // A spring and a dashpot: a pole, no cut.
                    return 0.0;
                }
                unit * above / (a.value() + b.value()).norm_sqr()
            }
            Self::Standing {
                spring_pa,
                first,
                second,
            } => {
                let beside = Cut::of(first, r).value() + Cut::of(second, r).value();
                let unit = spring_pa.max(beside.norm());
                let (spring, beside) = (spring_pa / unit, beside / unit);
                unit * spring * spring * beside.im / (beside + spring).norm_sqr()
            }
        }
    }

    /// E in Pa and r in 1/s of E·s/(s + r), what a spring and a dashpot in series are.
    pub(super) fn pole(&self) -> Option<(f64, f64)> {
        match self {
            Self::Series { first, second } if first.order() >= 1.0 && second.order() <= 0.0 => {
                let (v, e) = (first.viscosity_pa_s_alpha(), second.viscosity_pa_s_alpha());
                Some((e, e / v))
            }
            _ => None,
        }
    }

    /// The element that carries a slow motion: M(s) → V·s^α for s → 0.
    pub(super) const fn slow(&self) -> SpringPot {
        match self {
            Self::Pot(one)
            | Self::Series { first: one, .. }
            | Self::Standing { second: one, .. } => *one,
        }
    }
}

/// s^p.
fn power(s: Complex64, p: f64) -> Complex64 {
    let (size, angle) = (libm::hypot(s.re, s.im), libm::atan2(s.im, s.re));
    Complex64::from_polar(libm::pow(size, p), p * angle)
}

/// V·(−r + i0)^α = V·r^α·e^(iπα).
#[derive(Clone, Copy, Debug)]
struct Cut {
    size: f64,
    sin: f64,
    cos: f64,
}

impl Cut {
    fn of(pot: &SpringPot, r: f64) -> Self {
        let order = pot.order();
        // sin πα = sin π(1 − α), and 1 − α is exact where α is near 1; exactly 0 at both ends.
        let near = order.min(1.0 - order);
        let (sin, cos) = (
            libm::sin(core::f64::consts::PI * near),
            libm::cos(core::f64::consts::PI * near),
        );
        Self {
            size: pot.viscosity_pa_s_alpha() * libm::pow(r, order),
            sin,
            cos: if order > 0.5 { -cos } else { cos },
        }
    }

    fn over(self, unit: f64) -> Self {
        Self {
            size: self.size / unit,
            ..self
        }
    }

    fn value(self) -> Complex64 {
        Complex64::new(self.size * self.cos, self.size * self.sin)
    }
}
