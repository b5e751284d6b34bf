//! Options that are one of several names: the names stand with the types of the libraries.

use clap::builder::{PossibleValue, TypedValueParser};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, Command, Error};
use haptic_experiment::Named;
use std::ffi::OsStr;
use std::marker::PhantomData;

/// A parser of one of the names of `T`.
#[derive(Debug)]
pub struct Choice<T>(PhantomData<T>);

/// A parser of one of the names of `T`.
#[must_use]
pub const fn choice<T: Named>() -> Choice<T> {
    Choice(PhantomData)
}

impl<T> Clone for Choice<T> {
    fn clone(&self) -> Self {
        Self(PhantomData)
    }
}

impl<T: Named + Send + Sync> TypedValueParser for Choice<T> {
    type Value = T;

    fn parse_ref(
        &self,
        command: &Command,
        argument: Option<&Arg>,
        value: &OsStr,
    ) -> Result<T, Error> {
        let text = value.to_string_lossy();
        T::named(&text).ok_or_else(|| {
            let mut error = Error::new(ErrorKind::InvalidValue).with_cmd(command);
            let argument = argument.map_or_else(|| "...".to_owned(), ToString::to_string);
            let names = T::CHOICES.iter().map(|choice| choice.1.to_owned());
            error.insert(ContextKind::InvalidArg, ContextValue::String(argument));
            error.insert(
                ContextKind::InvalidValue,
                ContextValue::String(text.into_owned()),
            );
            error.insert(
                ContextKind::ValidValue,
                ContextValue::Strings(names.collect()),
            );
            error
        })
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let values = T::CHOICES.iter();
        Some(Box::new(values.map(|(_, name, help)| {
            PossibleValue::new(*name).help(*help)
        })))
    }
}
