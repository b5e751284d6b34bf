//! The `[parameters]` of a tissue file.

use super::parts::KelvinVoigt;
use crate::model::{Form, Model, ModelError, ModelKind, Parameter, SpringPot};
use fracdiff::parameter::Shown;
use serde::Deserialize;
use serde::de::{SeqAccess, Visitor};
use std::collections::BTreeMap;
use std::fmt;
use toml::Spanned;

/// Where in the file, if it is one of the numbers, and why.
type Wrong = (Option<usize>, String);

/// A file without `model`: a spring beside a spring-pot, each of which may be missing.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TwoElements {
    elastic_modulus_pa: Spanned<f64>,
    viscosity_pa_s_alpha: Spanned<f64>,
    order: Spanned<f64>,
}

impl TwoElements {
    /// E₀, η and α within their ranges, and the model that they are.
    pub(super) fn model(&self) -> Result<(KelvinVoigt, Model), Wrong> {
        let at_least_zero = |value: &Spanned<f64>, name: &str, unit: &str| {
            let number = *value.get_ref();
            if number >= 0.0 && number.is_finite() {
                return Ok(number);
            }
            let reason = format!("{name} = {number} {unit} is not a finite number of at least 0");
            Err((Some(value.span().start), reason))
        };
        let modulus = at_least_zero(&self.elastic_modulus_pa, "elastic_modulus_pa", "Pa")?;
        let viscosity =
            at_least_zero(&self.viscosity_pa_s_alpha, "viscosity_pa_s_alpha", "Pa·s^α")?;
        let alpha = *self.order.get_ref();
        if !(0.0..=1.0).contains(&alpha) {
            let reason = format!("order = {alpha} is not in [0, 1]", alpha = Shown(alpha));
            return Err((Some(self.order.span().start), reason));
        }
        if modulus == 0.0 && viscosity == 0.0 {
            let reason =
                "viscosity of a tissue without elastic modulus 0 Pa·s^α is not above 0 Pa·s^α";
            return Err((None, reason.to_owned()));
        }
        let model = elements(modulus, viscosity, alpha).map_err(|error| (None, error.to_string()));
        Ok((KelvinVoigt::new(modulus, viscosity, alpha), model?))
    }
}

fn elements(modulus: f64, viscosity: f64, alpha: f64) -> Result<Model, ModelError> {
    Model::new(if viscosity == 0.0 {
        Form::SpringPot(SpringPot::spring(modulus)?)
    } else if modulus == 0.0 {
        Form::SpringPot(SpringPot::new(viscosity, alpha)?)
    } else if alpha == 0.0 {
        // D⁰ is the identity: two springs side by side.
        Form::SpringPot(SpringPot::spring(modulus + viscosity)?)
    } else {
        Form::FractionalKelvinVoigt {
            first: SpringPot::new(viscosity, alpha)?,
            second: SpringPot::spring(modulus)?,
        }
    })
}

/// A file with `model`: the parameters of that model by name.
#[derive(Deserialize)]
#[serde(transparent)]
pub(super) struct Named(BTreeMap<String, Spanned<Numbers>>);

impl Named {
    /// The model of a kind.
    pub(super) fn model(&self, kind: ModelKind) -> Result<Model, Wrong> {
        let known = kind.parameters();
        let names = || known.iter().map(|one| one.name).collect::<Vec<_>>();
        for (name, value) in &self.0 {
            if !names().contains(&name.as_str()) {
                let reason = format!(
                    "{name} is no parameter of the model {kind}, which has {}",
                    names().join(", ")
                );
                return Err((Some(value.span().start), reason));
            }
        }
        let columns = known.iter().map(|one| self.numbers(kind, one));
        let columns = columns.collect::<Result<Vec<_>, _>>()?;
        let mut values = Vec::new();
        let mut branches = Vec::new();
        for (parameter, column) in known.iter().zip(columns) {
            if parameter.for_each_branch {
                branches.push((parameter.name, column));
            } else {
                values.extend(column);
            }
        }
        if let [(first, moduli), (second, times)] = &branches[..] {
            if moduli.len() != times.len() {
                let reason = format!(
                    "{first} has {} numbers and {second} {}: each branch has one of each",
                    moduli.len(),
                    times.len()
                );
                return Err((None, reason));
            }
            let pairs = moduli.iter().zip(times);
            values.extend(pairs.flat_map(|(modulus, time)| [*modulus, *time]));
        }
        Model::from_parameters(kind, &values).map_err(|error| (None, error.to_string()))
    }

    /// The numbers of a parameter, each within its range: one, or one for each branch.
    fn numbers(&self, kind: ModelKind, parameter: &Parameter) -> Result<Vec<f64>, Wrong> {
        let name = parameter.name;
        let Some(value) = self.0.get(name) else {
            return Err((None, format!("missing field `{name}` of the model {kind}")));
        };
        let place = Some(value.span().start);
        let numbers = match value.get_ref() {
            Numbers::One(number) if !parameter.for_each_branch => vec![*number],
            Numbers::Many(numbers) if parameter.for_each_branch => numbers.clone(),
            Numbers::One(_) => {
                let reason = format!("{name} is not a list: give one number for each branch");
                return Err((place, reason));
            }
            Numbers::Many(_) => {
                return Err((place, format!("{name} is a list: give one number")));
            }
        };
        for number in &numbers {
            if !parameter.range.contains(*number) {
                let unit = if parameter.unit.is_empty() {
                    String::new()
                } else {
                    format!(" {}", parameter.unit)
                };
                let words = parameter.range.words();
                return Err((place, format!("{name} = {number}{unit} is not {words}")));
            }
        }
        Ok(numbers)
    }
}

/// A number or a list of them.
enum Numbers {
    One(f64),
    Many(Vec<f64>),
}

impl<'de> Deserialize<'de> for Numbers {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(NumbersVisitor)
    }
}

struct NumbersVisitor;

impl<'de> Visitor<'de> for NumbersVisitor {
    type Value = Numbers;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number or a list of numbers")
    }

    fn visit_f64<E>(self, value: f64) -> Result<Numbers, E> {
        Ok(Numbers::One(value))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Numbers, E> {
        Ok(Numbers::One(value as f64))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Numbers, A::Error> {
        let mut numbers = Vec::new();
        while let Some(number) = list.next_element()? {
            numbers.push(number);
        }
        Ok(Numbers::Many(numbers))
    }
}
