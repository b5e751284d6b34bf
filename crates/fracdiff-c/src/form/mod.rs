//! The core of each form of operator in C: its tables, its part of the struct, its step.
//!
//! In all of them `u` is the input of the core, and the core leaves its part of the next output in `past`. `@` stands
//! for the name, `real` for the number type; both are put in at the end.

mod modes;
mod parts;
mod recursion;
mod sections;
mod taps;

use crate::error::HeaderError;
use crate::number::CNumber;
use fracdiff::OperatorList;
use fracdiff::portable::Form;
pub(crate) use parts::{Core, Field};

/// The core of a list that an operator made.
pub(crate) fn core<F: CNumber>(list: &OperatorList<F>) -> Result<Core, HeaderError> {
    let values = &list.values;
    if let Some(index) = values.iter().position(|value| !value.is_finite()) {
        let value = values[index].to_f64();
        return Err(HeaderError::Value { index, value });
    }
    let core = match list.form {
        Form::Taps if list.integer == 0 => taps::core(values),
        Form::Modes => modes::core(list),
        Form::Recursion => recursion::core(values),
        Form::Sections => sections::core(values),
        Form::Taps => None,
    };
    let integer = list.integer;
    core.filter(|_| (-2..=2).contains(&integer))
        .ok_or(HeaderError::List {
            count: values.len(),
            integer,
        })
}
