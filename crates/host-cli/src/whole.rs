//! Options that are a whole number in a range.

use clap::builder::TypedValueParser;
use clap::error::ErrorKind;
use clap::{Arg, Command, Error};
use std::ffi::OsStr;
use std::marker::PhantomData;
use std::ops::RangeInclusive;

/// Whole numbers up to this one are exact as an `f64`.
const EXACT: f64 = 9_007_199_254_740_992.0;

/// A parser of a whole number in a range.
#[derive(Debug)]
pub struct Whole<T> {
    least: u64,
    most: u64,
    kind: PhantomData<fn() -> T>,
}

/// A parser of a whole number in a range: `1000`, or `1e3`.
#[must_use]
pub fn whole<T: TryInto<u64>>(range: RangeInclusive<T>) -> Whole<T> {
    let (least, most) = range.into_inner();
    Whole {
        least: least.try_into().unwrap_or(0),
        most: most.try_into().unwrap_or(u64::MAX),
        kind: PhantomData,
    }
}

impl<T> Clone for Whole<T> {
    fn clone(&self) -> Self {
        Self {
            kind: PhantomData,
            ..*self
        }
    }
}

/// A whole number, however it is written.
fn read(text: &str) -> Option<u64> {
    let text = text.trim();
    let written = || {
        let number = text.parse::<f64>().ok();
        number.filter(|number| number.fract() == 0.0 && (0.0..=EXACT).contains(number))
    };
    (text.parse().ok()).or_else(|| written().map(|number| number as u64))
}

impl<T: TryFrom<u64> + Clone + Send + Sync + 'static> TypedValueParser for Whole<T> {
    type Value = T;

    fn parse_ref(&self, _: &Command, argument: Option<&Arg>, value: &OsStr) -> Result<T, Error> {
        let text = value.to_string_lossy();
        let (least, most) = (self.least, self.most);
        let number = read(&text).filter(|number| (least..=most).contains(number));
        let number = number.and_then(|number| T::try_from(number).ok());
        number.ok_or_else(|| {
            let option = argument.and_then(Arg::get_long).unwrap_or_default();
            let name = option.replace('-', " ");
            let refused = format!(
                "{name} {} is not a whole number from {least} to {most}: change --{option}\n",
                if text.is_empty() { "\"\"" } else { &text }
            );
            Error::raw(ErrorKind::ValueValidation, refused)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_whole_number_is_read_however_it_is_written() {
        for (text, want) in [
            ("7", Some(7)),
            (" 1e3 ", Some(1000)),
            ("18446744073709551615", Some(u64::MAX)),
            ("1e16", None),
            ("2.5", None),
            ("-1", None),
            ("", None),
            ("NaN", None),
        ] {
            assert_eq!(read(text), want, "{text}");
        }
    }
}
