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

impl Form {
    /// M of the model from those of its elements; branches of a Prony series are elements too.
    pub(super) fn joined(
        &self,
        element: impl Fn(&SpringPot) -> Complex64,
        branch: impl Fn(&MaxwellBranch) -> Complex64,
    ) -> Complex64 {
        match self {
            Self::SpringPot(one) => element(one),
            Self::FractionalKelvinVoigt { first, second } => element(first) + element(second),
            Self::FractionalMaxwell { first, second } => series(element(first), element(second)),
            Self::FractionalZener {
                first,
                second,
                elastic_modulus_pa,
            } => series(element(first), element(second)) + elastic_modulus_pa,
            Self::FractionalPoyntingThomson {
                first,
                second,
                elastic_modulus_pa,
            } => series(
                element(first) + element(second),
                Complex64::new(*elastic_modulus_pa, 0.0),
            ),
            Self::Prony {
                elastic_modulus_pa,
                branches,
            } => (branches.iter()).fold(Complex64::new(*elastic_modulus_pa, 0.0), |sum, one| {
                sum + branch(one)
            }),
        }
    }

    /// G(∞), Pa.
    pub(super) fn equilibrium_pa(&self) -> f64 {
        let spring = |one: &SpringPot| {
            let is_one = one.is_spring();
            if is_one {
                one.viscosity_pa_s_alpha()
            } else {
                0.0
            }
        };
        match self {
            Form::SpringPot(one) => spring(one),
            Form::FractionalKelvinVoigt { second, .. } => spring(second),
            Form::FractionalMaxwell { .. } => 0.0,
            Form::FractionalPoyntingThomson {
                second,
                elastic_modulus_pa,
                ..
            } => {
                let beside = spring(second);
                elastic_modulus_pa * (beside / (elastic_modulus_pa + beside))
            }
            Form::FractionalZener {
                elastic_modulus_pa, ..
            }
            | Form::Prony {
                elastic_modulus_pa, ..
            } => *elastic_modulus_pa,
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

/// A viscoelastic model, valid.
#[derive(Clone, Debug, PartialEq)]
pub struct Model(Form);

impl Model {
    /// Checks how the elements go together: α > β, springs above 0 Pa, branches with rising relaxation times.
    ///
    /// # Errors
    /// As [`ModelError`] says.
    pub fn new(form: Form) -> Result<Self, ModelError> {
        check(&form)?;
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
        self.0.joined(
            |one| one.modulus(s),
            |branch| {
                let st = s * branch.relaxation_time_s;
                st / (st + 1.0) * branch.elastic_modulus_pa
            },
        )
    }
}

fn check(form: &Form) -> Result<(), ModelError> {
    match form {
        Form::SpringPot(_) => Ok(()),
        Form::FractionalKelvinVoigt { first, second }
        | Form::FractionalMaxwell { first, second } => falling(first, second),
        Form::FractionalZener {
            first,
            second,
            elastic_modulus_pa,
        }
        | Form::FractionalPoyntingThomson {
            first,
            second,
            elastic_modulus_pa,
        } => {
            falling(first, second)?;
            positive("elastic_modulus_pa", *elastic_modulus_pa, "Pa")
        }
        Form::Prony {
            elastic_modulus_pa,
            branches,
        } => series_of_branches(*elastic_modulus_pa, branches),
    }
}

/// α > β.
fn falling(first: &SpringPot, second: &SpringPot) -> Result<(), ModelError> {
    let (order, second_order) = (first.order(), second.order());
    if order > second_order {
        Ok(())
    } else if order < second_order {
        Err(ModelError::OrdersExchanged {
            order,
            second_order,
        })
    } else {
        Err(ModelError::SameOrder(order))
    }
}

fn series_of_branches(
    elastic_modulus_pa: f64,
    branches: &[MaxwellBranch],
) -> Result<(), ModelError> {
    if !(elastic_modulus_pa >= 0.0 && elastic_modulus_pa.is_finite()) {
        return Err(ModelError::Range {
            name: "elastic_modulus_pa",
            value: elastic_modulus_pa,
            allowed: "at least 0 and finite",
            unit: "Pa",
        });
    }
    if elastic_modulus_pa == 0.0 && branches.is_empty() {
        return Err(ModelError::Empty);
    }
    let mut before = 0.0;
    for branch in branches {
        positive("branch_moduli_pa", branch.elastic_modulus_pa, "Pa")?;
        positive("branch_times_s", branch.relaxation_time_s, "s")?;
        if branch.relaxation_time_s <= before {
            return Err(ModelError::Range {
                name: "branch_times_s",
                value: branch.relaxation_time_s,
                allowed: "above the one before it",
                unit: "s",
            });
        }
        before = branch.relaxation_time_s;
    }
    Ok(())
}

fn positive(name: &'static str, value: f64, unit: &'static str) -> Result<(), ModelError> {
    if value > 0.0 && value.is_finite() {
        return Ok(());
    }
    Err(ModelError::Range {
        name,
        value,
        allowed: "above 0 and finite",
        unit,
    })
}
