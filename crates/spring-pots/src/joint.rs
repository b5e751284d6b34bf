//! Joints of two elements.

use num_complex::Complex64;

/// The most elements of a network.
pub const ELEMENTS: usize = 3;

/// Joint of two elements, and of a spring where the model has one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Joint {
    /// Two elements side by side.
    KelvinVoigt,
    /// Two elements in series.
    Maxwell,
    /// Two elements in series, beside a spring.
    Zener,
    /// Two elements side by side, in series with a spring.
    PoyntingThomson,
}

impl Joint {
    /// The model from its two elements and the spring, by what side by side and in series mean for them: moduli, limits and
    /// the sums of a sampled model all come from this one definition.
    pub fn of<T>(
        self,
        [first, second, spring]: [T; 3],
        parallel: impl Fn(T, T) -> T,
        series: impl Fn(T, T) -> T,
    ) -> T {
        match self {
            Self::KelvinVoigt => parallel(first, second),
            Self::Maxwell => series(first, second),
            Self::Zener => parallel(series(first, second), spring),
            Self::PoyntingThomson => series(parallel(first, second), spring),
        }
    }

    /// M and its derivatives by the moduli of the elements and of the spring. A fit spends most of its time here.
    #[must_use]
    pub fn slopes(self, [first, second, spring]: [Complex64; 3]) -> (Complex64, [Complex64; 3]) {
        let (zero, one) = (Complex64::ZERO, Complex64::ONE);
        // 1/M = 1/a + 1/b, so ∂M/∂a = (b/(a + b))².
        let series = |a: Complex64, b: Complex64| {
            let inverse = (a + b).inv();
            let [by_a, by_b] = [b * inverse, a * inverse];
            (a * by_a, by_a * by_a, by_b * by_b)
        };
        match self {
            Self::KelvinVoigt => (first + second, [one, one, zero]),
            Self::Maxwell => {
                let (modulus, by_first, by_second) = series(first, second);
                (modulus, [by_first, by_second, zero])
            }
            Self::Zener => {
                let (modulus, by_first, by_second) = series(first, second);
                (modulus + spring, [by_first, by_second, one])
            }
            Self::PoyntingThomson => {
                let (modulus, by_both, by_spring) = series(first + second, spring);
                (modulus, [by_both, by_both, by_spring])
            }
        }
    }
}

/// Variables of the elements: a and α of each, a alone of the spring.
#[must_use]
pub const fn variables(joint: Option<Joint>) -> usize {
    match joint {
        None => 2,
        Some(Joint::KelvinVoigt | Joint::Maxwell) => 4,
        Some(Joint::Zener | Joint::PoyntingThomson) => 5,
    }
}

/// M and its derivatives by the moduli of the elements e₁, e₂ and the spring e₃.
#[must_use]
pub fn join(joint: Option<Joint>, e: [Complex64; ELEMENTS]) -> (Complex64, [Complex64; ELEMENTS]) {
    match joint {
        Some(joint) => joint.slopes(e),
        None => (e[0], [Complex64::ONE, Complex64::ZERO, Complex64::ZERO]),
    }
}
