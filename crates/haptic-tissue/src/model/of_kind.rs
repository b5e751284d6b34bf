//! Models from the values of their kind's parameters, and back.

use super::error::ModelError;
use super::form::{Form, MaxwellBranch, Model};
use super::kind::ModelKind;
use super::parameter::Parameter;
use super::spring_pot::SpringPot;

impl Model {
    /// A model by its kind and the values of [`ModelKind::parameters`], in that order.
    ///
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
    /// Another number of values, a value outside its range, orders that do not fall.
    pub fn from_parameters(kind: ModelKind, values: &[f64]) -> Result<Self, ModelError> {
        let fits = match kind {
            ModelKind::Prony => values.len() % 2 == 1,
            _ => values.len() == kind.parameters().len(),
        };
        if !fits {
            let names = kind.parameters().iter().map(|one| one.name);
            return Err(ModelError::Count {
                model: kind.name(),
                given: values.len(),
                names: names.collect::<Vec<_>>().join(", "),
            });
        }
        for (place, &value) in values.iter().enumerate() {
            let Some(parameter) = kind.parameter(place) else {
                continue;
            };
            if !parameter.range.contains(value) {
                return Err(ModelError::Range {
                    name: parameter.name,
                    value,
                    allowed: parameter.range.words(),
                    unit: parameter.unit,
                });
            }
        }
        Self::new(form(kind, values)?)
    }

    /// The kind: the classical name where the orders are exactly 1 and 0.
    #[must_use]
    pub fn kind(&self) -> ModelKind {
        let classical =
            |first: &SpringPot, second: &SpringPot| first.is_dashpot() && second.is_spring();
        match self.form() {
            Form::SpringPot(one) if one.is_spring() => ModelKind::Spring,
            Form::SpringPot(one) if one.is_dashpot() => ModelKind::Dashpot,
            Form::SpringPot(_) => ModelKind::SpringPot,
            Form::FractionalKelvinVoigt { first, second } if classical(first, second) => {
                ModelKind::KelvinVoigt
            }
            Form::FractionalKelvinVoigt { .. } => ModelKind::FractionalKelvinVoigt,
            Form::FractionalMaxwell { first, second } if classical(first, second) => {
                ModelKind::Maxwell
            }
            Form::FractionalMaxwell { .. } => ModelKind::FractionalMaxwell,
            Form::FractionalZener { first, second, .. } if classical(first, second) => {
                ModelKind::Zener
            }
            Form::FractionalZener { .. } => ModelKind::FractionalZener,
            Form::FractionalPoyntingThomson { first, second, .. } if classical(first, second) => {
                ModelKind::PoyntingThomson
            }
            Form::FractionalPoyntingThomson { .. } => ModelKind::FractionalPoyntingThomson,
            Form::Prony { .. } => ModelKind::Prony,
        }
    }

    /// The parameters of [`Model::kind`] with their values.
    #[must_use]
    pub fn parameters(&self) -> Vec<(&'static Parameter, f64)> {
        let kind = self.kind();
        let values = values(kind, self.form()).into_iter().enumerate();
        values
            .filter_map(|(place, value)| Some((kind.parameter(place)?, value)))
            .collect()
    }
}

/// The elements of a kind; `values` are as many as it has, and within their ranges.
fn form(kind: ModelKind, values: &[f64]) -> Result<Form, ModelError> {
    Ok(match (kind, values) {
        (ModelKind::Spring, [modulus, ..]) => Form::SpringPot(SpringPot::spring(*modulus)?),
        (ModelKind::Dashpot, [viscosity, ..]) => Form::SpringPot(SpringPot::dashpot(*viscosity)?),
        (ModelKind::SpringPot, [v, order, ..]) => Form::SpringPot(SpringPot::new(*v, *order)?),
        (ModelKind::Prony, [elastic_modulus_pa, rest @ ..]) => Form::Prony {
            elastic_modulus_pa: *elastic_modulus_pa,
            branches: (rest.chunks_exact(2))
                .map(|branch| MaxwellBranch {
                    elastic_modulus_pa: branch[0],
                    relaxation_time_s: branch[1],
                })
                .collect(),
        },
        _ => {
            let (first, second, elastic_modulus_pa) = two_elements(values)?;
            match kind {
                ModelKind::Maxwell | ModelKind::FractionalMaxwell => {
                    Form::FractionalMaxwell { first, second }
                }
                ModelKind::Zener | ModelKind::FractionalZener => Form::FractionalZener {
                    first,
                    second,
                    elastic_modulus_pa,
                },
                ModelKind::PoyntingThomson | ModelKind::FractionalPoyntingThomson => {
                    Form::FractionalPoyntingThomson {
                        first,
                        second,
                        elastic_modulus_pa,
                    }
                }
                _ => Form::FractionalKelvinVoigt { first, second },
            }
        }
    })
}

/// The two elements of a classical (2 or 3 values) or fractional (4 or 5) model, and the spring of those that have a third.
fn two_elements(values: &[f64]) -> Result<(SpringPot, SpringPot, f64), ModelError> {
    let (first, second, third) = match *values {
        [spring, dashpot] => (
            SpringPot::dashpot(dashpot)?,
            SpringPot::spring(spring)?,
            0.0,
        ),
        [third, spring, dashpot] => (
            SpringPot::dashpot(dashpot)?,
            SpringPot::spring(spring)?,
            third,
        ),
        [v, order, g, second_order] => (
            SpringPot::new(v, order)?,
            SpringPot::new(g, second_order)?,
            0.0,
        ),
        [v, order, g, second_order, third] => (
            SpringPot::new(v, order)?,
            SpringPot::new(g, second_order)?,
            third,
        ),
        // The number of values was compared with that of the kind before.
        _ => return Err(ModelError::Empty),
    };
    Ok((first, second, third))
}

/// The values of a model, in the order of its kind's parameters.
fn values(kind: ModelKind, form: &Form) -> Vec<f64> {
    let size = SpringPot::viscosity_pa_s_alpha;
    let single = kind.parameters().len() == 1;
    match form {
        Form::SpringPot(one) if single => vec![size(one)],
        Form::SpringPot(one) => vec![size(one), one.order()],
        Form::FractionalKelvinVoigt { first, second }
        | Form::FractionalMaxwell { first, second } => match kind {
            ModelKind::KelvinVoigt | ModelKind::Maxwell => vec![size(second), size(first)],
            _ => vec![size(first), first.order(), size(second), second.order()],
        },
        Form::FractionalZener {
            first,
            second,
            elastic_modulus_pa: e,
        }
        | Form::FractionalPoyntingThomson {
            first,
            second,
            elastic_modulus_pa: e,
        } => match kind {
            ModelKind::Zener | ModelKind::PoyntingThomson => vec![*e, size(second), size(first)],
            _ => vec![size(first), first.order(), size(second), second.order(), *e],
        },
        Form::Prony {
            elastic_modulus_pa,
            branches,
        } => {
            let branches = branches
                .iter()
                .flat_map(|one| [one.elastic_modulus_pa, one.relaxation_time_s]);
            std::iter::once(*elastic_modulus_pa)
                .chain(branches)
                .collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::ParameterRange;

    fn example(kind: ModelKind) -> Vec<f64> {
        match kind {
            ModelKind::Prony => vec![0.0, 5.0, 0.1, 3.0, 2.0],
            _ => {
                let mut order = 0.9;
                let one = |parameter: &Parameter| {
                    if parameter.range == ParameterRange::Order {
                        order -= 0.3;
                        order
                    } else {
                        7.0
                    }
                };
                kind.parameters().iter().map(one).collect()
            }
        }
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
