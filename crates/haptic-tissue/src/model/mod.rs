//! Models of viscoelastic matter: springs, dashpots and spring-pots, side by side and in series.
//! ```text
//! spring-pot                    σ = V·D^α ε             M(s) = V·s^α       a spring is α = 0, a dashpot α = 1
//! side by side: moduli add      M(s) = M₁(s) + M₂(s)
//! in series: compliances add    1/M(s) = 1/M₁(s) + 1/M₂(s)
//! ```
//! Source: A. Bonfanti, J. L. Kaplan, G. Charras, A. Kabla, *Fractional viscoelastic models for power-law materials*,
//! Soft Matter 16, 2020, whose names are used.

mod cut;
mod exponentials;
mod form;
mod joint;
mod kind;
mod record;
mod spring_pot;
mod zeros;

use exponentials::Spectrum;
pub(crate) use form::Form;
pub use form::MaxwellBranch;
use fracdiff::parameter::Shown;
use joint::Two;
pub(crate) use kind::TWO_ELEMENTS;
pub use kind::{ModelKind, ModelParameter, ParameterRange};
use num_complex::Complex64;
use spring_pot::Response;
pub(crate) use spring_pot::SpringPot;
pub(crate) use spring_pots::Joint;

/// A parameter outside its range, or parameters that do not go together.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// A number outside its range; `allowed` goes after "is not".
    #[error("{name} = {}{}{unit} is not {allowed}", Shown(*value), space_before(unit))]
    #[non_exhaustive]
    Range {
        /// The parameter's key in a tissue file.
        name: &'static str,
        /// The value that was given.
        value: f64,
        /// The range in words, which go after "is not".
        allowed: &'static str,
        /// Its unit; empty for a number without one.
        unit: &'static str,
    },
    /// Two elements with the same order: together they are one.
    #[error("both elements have the order {}: together they are one spring-pot", Shown(*.0))]
    SameOrder(f64),
    /// The first element has the lower order: α, β.
    #[error(
        "order = {} is below second_order = {}: exchange the two elements",
        Shown(*.0), Shown(*.1)
    )]
    OrdersExchanged(f64, f64),
    /// Another number of parameters than the model has.
    #[error("{1} parameters do not fit the model {0}, which has {names}", names = names(*.0))]
    Count(ModelKind, usize),
    /// A generalised Maxwell model without a spring and without a branch.
    #[error("the model needs `elastic_modulus_pa` above 0 Pa, or a branch")]
    Empty,
}

const fn space_before(unit: &str) -> &'static str {
    if unit.is_empty() { "" } else { " " }
}

fn names(kind: ModelKind) -> String {
    let names = kind.parameters().iter().map(|one| one.name);
    names.collect::<Vec<_>>().join(", ")
}

/// A model whose parameters are in their ranges and go together, so that nothing it computes can fail.
#[derive(Clone, Debug, PartialEq)]
pub struct Model(Form);

impl Model {
    /// A model by its kind and the values of [`ModelKind::parameters`], in that order.
    /// ```
    /// use haptic_tissue::{Model, ModelKind};
    ///
    /// let muscle = Model::from_parameters(ModelKind::FractionalMaxwell, &[876e3, 0.675, 22.1e3, 0.110])?;
    /// assert_eq!(muscle.kind().name(), "fractional-maxwell");
    /// let error = Model::from_parameters(ModelKind::Maxwell, &[876e3, -1.0]).unwrap_err();
    /// assert_eq!(error.to_string(), "viscosity_pa_s = -1 Pa·s is not above 0 and finite");
    /// # Ok::<(), haptic_tissue::ModelError>(())
    /// ```
    ///
    /// # Errors
    /// Another number of values, a value outside its range, orders that do not fall, times of branches that do not rise.
    pub fn from_parameters(kind: ModelKind, values: &[f64]) -> Result<Self, ModelError> {
        let fits = if kind.parameters().iter().any(|one| one.for_each_branch) {
            values.len() % 2 == 1
        } else {
            values.len() == kind.parameters().len()
        };
        if !fits {
            return Err(ModelError::Count(kind, values.len()));
        }
        for (index, &value) in values.iter().enumerate() {
            if let Some(parameter) = kind.parameter(index)
                && !parameter.range.contains(value)
            {
                return Err(out_of_range(parameter, value, parameter.range.words()));
            }
        }
        let one = |size, order| Form::One(SpringPot::new(size, order));
        let form = match (kind.joint(), values) {
            (None, &[spring_pa, ref rest @ ..]) if kind == ModelKind::Prony => {
                let branch = |&[elastic_modulus_pa, relaxation_time_s]: &[f64; 2]| MaxwellBranch {
                    elastic_modulus_pa,
                    relaxation_time_s,
                };
                let branches = rest.as_chunks().0.iter().map(branch).collect();
                Form::Branches(SpringPot::new(spring_pa, 0.0), branches)
            }
            (None, &[elastic_modulus_pa, viscosity, beside]) if kind == ModelKind::Jeffreys => {
                let branch = MaxwellBranch {
                    elastic_modulus_pa,
                    relaxation_time_s: viscosity / elastic_modulus_pa,
                };
                Form::Branches(SpringPot::new(beside, 1.0), vec![branch])
            }
            (None, &[viscosity]) if kind == ModelKind::Dashpot => one(viscosity, 1.0),
            (None, &[modulus]) => one(modulus, 0.0),
            (None, &[v, alpha]) => one(v, alpha),
            (Some(joint), values) => {
                let (first, second, spring_pa) = match *values {
                    [spring, dashpot] => ((dashpot, 1.0), (spring, 0.0), 0.0),
                    [third, spring, dashpot] => ((dashpot, 1.0), (spring, 0.0), third),
                    [v, alpha, g, beta] => ((v, alpha), (g, beta), 0.0),
                    [v, alpha, g, beta, third] => ((v, alpha), (g, beta), third),
                    _ => return Err(ModelError::Count(kind, values.len())),
                };
                Form::Two(Two {
                    joint,
                    first: SpringPot::new(first.0, first.1),
                    second: SpringPot::new(second.0, second.1),
                    spring_pa,
                })
            }
            (None, _) => return Err(ModelError::Count(kind, values.len())),
        };
        check(&form)?;
        Ok(Self(form))
    }

    /// The kind: the classical name where the orders are exactly 1 and 0.
    #[must_use]
    pub fn kind(&self) -> ModelKind {
        match &self.0 {
            Form::One(one) if one.is_spring() => ModelKind::Spring,
            Form::One(one) if one.is_dashpot() => ModelKind::Dashpot,
            Form::One(_) => ModelKind::SpringPot,
            Form::Two(two) => {
                ModelKind::of_two(two.joint, two.first.is_dashpot() && two.second.is_spring())
            }
            Form::Branches(beside, _) if beside.is_dashpot() => ModelKind::Jeffreys,
            Form::Branches(..) => ModelKind::Prony,
        }
    }

    /// The parameters of [`Model::kind`] with their values.
    #[must_use]
    pub fn parameters(&self) -> Vec<(&'static ModelParameter, f64)> {
        let kind = self.kind();
        let values = match &self.0 {
            Form::One(one) if kind == ModelKind::SpringPot => vec![one.size, one.order],
            Form::One(one) => vec![one.size],
            Form::Two(two) => {
                let (first, second) = (two.first, two.second);
                let classical = vec![two.spring_pa, second.size, first.size];
                match kind.parameters().len() {
                    2 => classical[1..].to_vec(),
                    3 => classical,
                    count => [
                        first.size,
                        first.order,
                        second.size,
                        second.order,
                        two.spring_pa,
                    ][..count]
                        .to_vec(),
                }
            }
            Form::Branches(beside, branches) if kind == ModelKind::Jeffreys => {
                let branches = branches.iter();
                let pairs = branches.flat_map(|one| {
                    let modulus_pa = one.elastic_modulus_pa;
                    [modulus_pa, modulus_pa * one.relaxation_time_s]
                });
                pairs.chain([beside.size]).collect()
            }
            Form::Branches(beside, branches) => {
                let branches = branches.iter();
                let pairs =
                    branches.flat_map(|one| [one.elastic_modulus_pa, one.relaxation_time_s]);
                std::iter::once(beside.size).chain(pairs).collect()
            }
        };
        let values = values.into_iter().enumerate();
        values
            .filter_map(|(index, value)| Some((kind.parameter(index)?, value)))
            .collect()
    }

    /// The numbers of each parameter: one, or one for each branch of a Prony series.
    pub(crate) fn columns(&self) -> impl Iterator<Item = (&'static ModelParameter, Vec<f64>)> {
        let values = self.parameters();
        self.kind().parameters().iter().map(move |parameter| {
            let of_it = values.iter().filter(|(known, _)| *known == parameter);
            (parameter, of_it.map(|(_, value)| *value).collect())
        })
    }

    pub(crate) const fn form(&self) -> &Form {
        &self.0
    }

    /// The model from its elements, each by its size in Pa·s^α and its order, and by what side by side and in series mean for them.
    pub fn joined<T>(
        &self,
        element: impl Fn(f64, f64) -> T,
        parallel: impl Fn(T, T) -> T,
        series: impl Fn(T, T) -> T,
    ) -> T {
        let branch = |one: &MaxwellBranch| {
            let viscosity = one.elastic_modulus_pa * one.relaxation_time_s;
            series(
                element(one.elastic_modulus_pa, 0.0),
                element(viscosity, 1.0),
            )
        };
        self.0.of(
            |one| element(one.size, one.order),
            branch,
            &parallel,
            &series,
        )
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

    /// G(t), Pa: stress over a step of strain, a time after it. 0 for t < 0, [`Model::instantaneous_modulus`] at 0.
    /// [`ModelKind`] has the closed forms. They are summed as exponentials: relative error below 1e-10 for 10⁻⁶ ≤ t/τ ≤ 10⁶,
    /// τ = (V/G)^(1/(α−β)). A dashpot beside the rest has an impulse at t = 0 only.
    /// Cost: 20 µs; many times at once, [`Model::relaxation_moduli`], 0.2 µs each.
    /// ```
    /// use haptic_tissue::{Model, ModelKind};
    ///
    /// let muscle = Model::from_parameters(ModelKind::FractionalMaxwell, &[876e3, 0.675, 22.1e3, 0.110])?;
    /// let (fast, slow) = (muscle.relaxation_moduli(&[0.014])[0], muscle.relaxation_moduli(&[981.0])[0]);
    /// assert!((fast / 33e3 - 1.0).abs() < 0.05 && slow < 4e3);
    /// # Ok::<(), haptic_tissue::ModelError>(())
    /// ```
    #[must_use]
    pub fn relaxation_moduli(&self, time_s: &[f64]) -> Vec<f64> {
        self.responses(Response::Relaxation, time_s)
    }

    /// J(t), 1/Pa: strain over a step of stress, a time after it. 0 for t < 0, 1 over [`Model::instantaneous_modulus`] at 0.
    /// Error and cost as for [`Model::relaxation_moduli`].
    #[must_use]
    pub fn creep_compliances(&self, time_s: &[f64]) -> Vec<f64> {
        self.responses(Response::Creep, time_s)
    }

    fn responses(&self, response: Response, time_s: &[f64]) -> Vec<f64> {
        let at_zero = self.at_zero(response);
        match &self.0 {
            Form::One(one) => each(time_s, at_zero, |t| one.response(response, t)),
            Form::Two(two) if joint::sum(two.joint) == Some(response) => {
                each(time_s, at_zero, |t| {
                    two.first.response(response, t) + two.second.response(response, t)
                })
            }
            form @ (Form::Two(_) | Form::Branches(..)) => by_modes(form, response, time_s, at_zero),
        }
    }

    /// G(0) in Pa, or J(0) in 1/Pa.
    fn at_zero(&self, response: Response) -> f64 {
        match response {
            Response::Relaxation => self.instantaneous_modulus(),
            Response::Creep => 1.0 / self.instantaneous_modulus(),
        }
    }

    /// M(iω), Pa: storage modulus + i·loss modulus, ω ≥ 0 in rad/s.
    #[must_use]
    pub fn complex_modulus(&self, omega_rad_s: f64) -> Complex64 {
        let ln = libm::log(omega_rad_s);
        let branch = |one: &MaxwellBranch| {
            let x = omega_rad_s * one.relaxation_time_s;
            let share = if x > 1.0 {
                let y = 1.0 / x;
                Complex64::new(1.0, y) / (1.0 + y * y)
            } else {
                Complex64::new(x * x, x) / (1.0 + x * x)
            };
            share * one.elastic_modulus_pa
        };
        self.0.joined(|one| one.modulus_at(ln, 0.5), branch)
    }

    /// G(0), Pa: infinite where a sudden strain has no finite stress.
    #[must_use]
    pub fn instantaneous_modulus(&self) -> f64 {
        self.0.instantaneous_pa()
    }

    /// G(∞), Pa: 0 for a fluid and for a spring-pot.
    #[must_use]
    pub fn equilibrium_modulus(&self) -> f64 {
        self.0.equilibrium_pa()
    }
}

/// Orders that fall, branches with rising times and at least one element.
fn check(form: &Form) -> Result<(), ModelError> {
    match form {
        Form::One(_) => {}
        Form::Two(two) => {
            let (order, second_order) = (two.first.order, two.second.order);
            if order < second_order {
                return Err(ModelError::OrdersExchanged(order, second_order));
            }
            if order <= second_order {
                return Err(ModelError::SameOrder(order));
            }
        }
        Form::Branches(beside, branches) => {
            if beside.size == 0.0 && branches.is_empty() {
                return Err(ModelError::Empty);
            }
            for pair in branches.windows(2) {
                let value = pair[1].relaxation_time_s;
                if value <= pair[0].relaxation_time_s {
                    let times = &ModelKind::Prony.parameters()[2];
                    return Err(out_of_range(times, value, "above the one before it"));
                }
            }
        }
    }
    Ok(())
}

pub(crate) const fn out_of_range(
    parameter: &ModelParameter,
    value: f64,
    allowed: &'static str,
) -> ModelError {
    ModelError::Range {
        name: parameter.name,
        value,
        allowed,
        unit: parameter.unit,
    }
}

/// 0 before the step, `at_zero` at it, `value` after it.
fn each(time_s: &[f64], at_zero: f64, mut value: impl FnMut(f64) -> f64) -> Vec<f64> {
    let one = |&t: &f64| {
        if t > 0.0 {
            value(t)
        } else if t == 0.0 {
            at_zero
        } else if t < 0.0 {
            0.0
        } else {
            f64::NAN
        }
    };
    time_s.iter().map(one).collect()
}

fn by_modes(form: &Form, response: Response, time_s: &[f64], at_zero: f64) -> Vec<f64> {
    let real = |t: &&f64| **t > 0.0 && t.is_finite();
    let (shortest, longest) = (time_s.iter().filter(real))
        .fold((f64::INFINITY, 0.0), |(low, high), &t| {
            (f64::min(low, t), f64::max(high, t))
        });
    if shortest > longest {
        return each(time_s, at_zero, |_| f64::NAN);
    }
    let spectrum = Spectrum::new(form, response, shortest, longest);
    each(time_s, at_zero, |t| spectrum.at(t))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn example(kind: ModelKind) -> Vec<f64> {
        if kind == ModelKind::Prony {
            return vec![0.0, 5.0, 0.1, 3.0, 2.0];
        }
        let mut order = 0.9;
        let one = |parameter: &ModelParameter| {
            if parameter.range == ParameterRange::Order {
                order -= 0.3;
                order
            } else {
                7.0
            }
        };
        kind.parameters().iter().map(one).collect()
    }

    #[test]
    fn every_kind_comes_back_from_its_parameters_and_its_name() {
        for kind in ModelKind::ALL {
            let values = example(kind);
            let model = Model::from_parameters(kind, &values).expect("valid");
            assert_eq!(model.kind(), kind);
            assert_eq!(ModelKind::from_name(kind.name()), Some(kind));
            let back: Vec<f64> = model.parameters().iter().map(|(_, value)| *value).collect();
            assert_eq!(back, values, "{kind}");
        }
        assert_eq!(ModelKind::from_name("jelly"), None);
    }

    #[test]
    fn every_value_outside_its_range_is_refused_by_its_name() {
        for kind in ModelKind::ALL {
            let values = example(kind);
            for place in 0..values.len() {
                for wrong in [-1.0, f64::NAN, f64::INFINITY, 1.5] {
                    let name = kind.parameter(place).expect("known");
                    if name.range.contains(wrong) {
                        continue;
                    }
                    let mut values = values.clone();
                    values[place] = wrong;
                    let error = Model::from_parameters(kind, &values).expect_err("refused");
                    let start = format!("{} = ", name.name);
                    assert!(error.to_string().starts_with(&start), "{error}");
                }
            }
            let error = Model::from_parameters(kind, &values[1..]).expect_err("a count");
            assert!(error.to_string().contains(kind.name()), "{error}");
        }
        let error = |values: &[f64]| {
            let model = Model::from_parameters(ModelKind::FractionalMaxwell, values);
            model.expect_err("orders").to_string()
        };
        assert!(error(&[1.0, 0.2, 1.0, 0.5]).ends_with("exchange the two elements"));
        assert!(error(&[1.0, 0.5, 1.0, 0.5]).contains("together they are one spring-pot"));
    }
}
