//! A model: how its elements are joined.

use super::error::ModelError;
use super::spring_pot::SpringPot;
use num_complex::Complex64;

/// A branch of a generalised Maxwell model: a spring and a dashpot in series.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MaxwellBranch {
    /// Modulus of the spring, Pa.
    pub elastic_modulus_pa: f64,
    /// Viscosity of the dashpot over it, s.
    pub relaxation_time_s: f64,
}

/// How the elements of a model are joined. Two elements in series or side by side have orders α > β.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Form {
    /// One element.
    SpringPot(SpringPot),
    /// Two elements side by side; with a spring as `second` the tissue of the dissertation.
    FractionalKelvinVoigt {
        /// V, α.
        first: SpringPot,
        /// G, β.
        second: SpringPot,
    },
    /// Two elements in series.
    FractionalMaxwell {
        /// V, α.
        first: SpringPot,
        /// G, β.
        second: SpringPot,
    },
    /// A spring beside a fractional Maxwell model.
    FractionalZener {
        /// V, α of the branch.
        first: SpringPot,
        /// G, β of the branch.
        second: SpringPot,
        /// The spring beside it, Pa.
        elastic_modulus_pa: f64,
    },
    /// A spring in series with a fractional Kelvin–Voigt model.
    FractionalPoyntingThomson {
        /// V, α of the two side by side.
        first: SpringPot,
        /// G, β of the two side by side.
        second: SpringPot,
        /// The spring in series with them, Pa.
        elastic_modulus_pa: f64,
    },
    /// Generalised Maxwell: a spring (0 Pa for none) and branches side by side; a Prony series.
    Prony {
        /// The spring, Pa.
        elastic_modulus_pa: f64,
        /// The branches, fastest first.
        branches: Vec<MaxwellBranch>,
    },
}

/// A viscoelastic model, valid.
#[derive(Clone, Debug, PartialEq)]
pub struct Model(Form);

impl Model {
    /// Checks how the elements go together.
    ///
    /// # Errors
    /// As [`ModelError`] says.
    pub fn new(form: Form) -> Result<Self, ModelError> {
        Ok(Self(form))
    }

    /// How the elements are joined.
    #[must_use]
    pub const fn form(&self) -> &Form {
        &self.0
    }

    /// M(s) = σ/ε at the complex frequency s, Pa. At s = iω the complex modulus; on the negative axis from above.
    #[must_use]
    pub fn modulus(&self, s: Complex64) -> Complex64 {
        let series = |a: Complex64, b: Complex64| a * b / (a + b);
        match &self.0 {
            Form::SpringPot(one) => one.modulus(s),
            Form::FractionalKelvinVoigt { first, second } => first.modulus(s) + second.modulus(s),
            Form::FractionalMaxwell { first, second } => {
                series(first.modulus(s), second.modulus(s))
            }
            Form::FractionalZener {
                first,
                second,
                elastic_modulus_pa,
            } => series(first.modulus(s), second.modulus(s)) + elastic_modulus_pa,
            Form::FractionalPoyntingThomson {
                first,
                second,
                elastic_modulus_pa,
            } => series(
                first.modulus(s) + second.modulus(s),
                Complex64::new(*elastic_modulus_pa, 0.0),
            ),
            Form::Prony {
                elastic_modulus_pa,
                branches,
            } => branches
                .iter()
                .fold(Complex64::new(*elastic_modulus_pa, 0.0), |sum, branch| {
                    let st = s * branch.relaxation_time_s;
                    sum + st / (st + 1.0) * branch.elastic_modulus_pa
                }),
        }
    }
}
