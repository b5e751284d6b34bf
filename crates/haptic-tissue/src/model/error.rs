//! Parameters that make no model.

use fracdiff::parameter::Shown;
use std::fmt;

/// A parameter outside its range, or parameters that do not go together.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum ModelError {
    /// A number outside its range.
    #[non_exhaustive]
    Range {
        /// The parameter, as in a tissue file.
        name: &'static str,
        /// The number.
        value: f64,
        /// The range in words.
        allowed: &'static str,
        /// Its unit.
        unit: &'static str,
    },
    /// Two elements with the same order: together they are one.
    SameOrder(f64),
    /// The first element has the lower order.
    #[non_exhaustive]
    OrdersExchanged {
        /// α.
        order: f64,
        /// β.
        second_order: f64,
    },
    /// Another number of parameters than the model has.
    #[non_exhaustive]
    Count {
        /// The name of the model.
        model: &'static str,
        /// The number of them.
        given: usize,
        /// The parameters that it has.
        names: String,
    },
    /// A generalised Maxwell model without a spring and without a branch.
    Empty,
}

impl fmt::Display for ModelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Range {
                name,
                value,
                allowed,
                unit,
            } => {
                let unit = if unit.is_empty() {
                    String::new()
                } else {
                    format!(" {unit}")
                };
                write!(f, "{name} = {value}{unit} is not {allowed}")
            }
            Self::SameOrder(order) => write!(
                f,
                "both elements have the order {order}: together they are one spring-pot; take that model, or two \
                 orders that differ",
                order = Shown(*order)
            ),
            Self::OrdersExchanged {
                order,
                second_order,
            } => write!(
                f,
                "order = {order} is below second_order = {second_order}: exchange the two elements",
                order = Shown(*order),
                second_order = Shown(*second_order)
            ),
            Self::Count {
                model,
                given,
                names,
            } => write!(
                f,
                "{given} parameters are not those of the model {model}, which has {names}"
            ),
            Self::Empty => write!(
                f,
                "a generalised Maxwell model needs `elastic_modulus_pa` above 0 Pa or at least one branch"
            ),
        }
    }
}

impl std::error::Error for ModelError {}
