//! Values of options: numbers in a range, which stands with the parameter, names, which stand with their types, orders, schemes.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::error::ErrorKind;
use clap::{Arg, Command, Error};
use fracdiff::parameter::Shown;
use fracdiff::{Order, Scheme};
use haptic_experiment::Named;
use haptic_experiment::parameters::{Parameter, Range, in_degrees};
use haptic_quantity::{WrittenUnit, doubt, parse_for_key, written};
use std::ffi::OsStr;
use std::ops::RangeInclusive;

/// Times to wait for something that may never come, s: a day.
pub(crate) const WAITS: Range = Range::Within(0.0, 86_400.0);

/// That a value is outside a range, in the units of its key.
pub(crate) fn outside(key: &str, range: Range) -> String {
    let (Range::Within(low, high) | Range::AboveUpTo(low, high) | Range::ZeroOr(low, high)) = range;
    let [low, high] = [low, high].map(|end| match end {
        0.0 => "0".to_owned(),
        end => written(key, end),
    });
    let degrees = in_degrees(key, range);
    match range {
        Range::Within(..) => format!("is not from {low} to {high}{degrees}"),
        Range::AboveUpTo(..) => format!("is not above {low} and at most {high}"),
        Range::ZeroOr(..) => format!("is not 0 or from {low} to {high}"),
    }
}

/// The value of a key, if it is in a range; else value and range, for people.
pub(crate) fn in_range(key: &str, value: f64, range: Range) -> Result<f64, String> {
    if range.contains(value) {
        Ok(value)
    } else {
        let value = format!("{} {}", Shown(value), WrittenUnit::of_key(key, 1.0).symbol);
        Err(format!("{} {}", value.trim_end(), outside(key, range)))
    }
}

/// Reads a value and checks it. A value that cannot be read gets the message of clap; one outside its range, the option to change.
#[derive(Clone, Debug)]
struct Judged<F>(F);

impl<T, E, F> TypedValueParser for Judged<F>
where
    T: Clone + Send + Sync + 'static,
    E: Into<Box<dyn std::error::Error + Send + Sync + 'static>>,
    F: Fn(&str) -> Result<Result<T, String>, E> + Clone + Send + Sync + 'static,
{
    type Value = T;

    fn parse_ref(&self, all: &Command, argument: Option<&Arg>, value: &OsStr) -> Result<T, Error> {
        self.0.parse_ref(all, argument, value)?.map_err(|refused| {
            let option = argument.and_then(Arg::get_long).unwrap_or_default();
            let name = option.replace('-', " ");
            let refused = format!("{name} {refused}: change --{option}\n");
            Error::raw(ErrorKind::ValueValidation, refused)
        })
    }
}

/// A parser of a quantity in a range; the end of a key says its unit.
pub(crate) fn quantity(key: &'static str, range: Range) -> impl TypedValueParser<Value = f64> {
    Judged(move |text: &str| {
        parse_for_key(key, text)
            .map_err(|error| error.to_string())
            .and_then(|value| doubt(key, text).map(|()| in_range(key, value, range)))
    })
}

pub(crate) fn of(parameter: Parameter) -> impl TypedValueParser<Value = f64> {
    quantity(parameter.key, parameter.range())
}

/// A parser of a whole number in a range: `1000`, or `1e3`.
pub(crate) fn whole<T>(range: RangeInclusive<T>) -> impl TypedValueParser<Value = T>
where
    T: TryFrom<u64> + PartialOrd + std::fmt::Display + Clone + Send + Sync + 'static,
{
    Judged(move |text: &str| {
        let number = read_whole(text).and_then(|number| T::try_from(number).ok());
        Ok::<_, String>(number.filter(|n| range.contains(n)).ok_or_else(|| {
            let shown = if text.is_empty() { "\"\"" } else { text };
            let (least, most) = (range.start(), range.end());
            format!("{shown} is not a whole number from {least} to {most}")
        }))
    })
}

/// A whole number, however it is written.
pub(crate) fn read_whole(text: &str) -> Option<u64> {
    /// Whole numbers up to this one are exact as an `f64`.
    const EXACT: f64 = 9_007_199_254_740_992.0;
    let text = text.trim();
    let is_whole = |number: &f64| number.fract() == 0.0 && (0.0..=EXACT).contains(number);
    let written = || text.parse().ok().filter(is_whole).map(|n| n as u64);
    text.parse().ok().or_else(written)
}

/// A parser of one of several names: what it is, its name, and a few words for people.
pub(crate) fn one_of<T: Clone + Send + Sync + 'static>(
    choices: Vec<(T, &'static str, &'static str)>,
) -> impl TypedValueParser<Value = T> {
    let names = choices.iter().map(|(_, name, help)| match *help {
        "" => PossibleValue::new(*name),
        help => PossibleValue::new(*name).help(help),
    });
    PossibleValuesParser::new(names).try_map(move |name| {
        let found = choices.iter().find(|choice| choice.1 == name);
        found
            .map(|choice| choice.0.clone())
            .ok_or("not one of the names")
    })
}

/// A parser of one of the names of `T`.
pub(crate) fn choice<T: Named + Send + Sync>() -> impl TypedValueParser<Value = T> {
    one_of(T::CHOICES.to_vec())
}

/// A parser of an order from −2 to 2.
pub(crate) fn order() -> impl TypedValueParser<Value = Order> {
    Judged(|text: &str| {
        let range = Range::Within(Order::MIN, Order::MAX);
        let number = parse_for_key("", text);
        number.map(|mu| Order::new(in_range("", mu, range)?).map_err(|error| error.to_string()))
    })
}

pub(crate) fn parse_scheme(text: &str) -> Result<Scheme, String> {
    text.parse()
        .map_err(|error: fracdiff::SchemeError| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::parser;
    use std::any::TypeId;
    use std::path::PathBuf;

    /// Every option of a command and of those below it that takes a value, with the words that lead there.
    fn options(command: &Command, way: &[String], all: &mut Vec<(Vec<String>, Arg)>) {
        let takes = command.get_arguments().filter(|argument| {
            argument.get_long().is_some() && argument.get_action().takes_values()
        });
        all.extend(takes.map(|argument| (way.to_vec(), argument.clone())));
        for sub in command.get_subcommands() {
            let way = [way, &[sub.get_name().to_owned()]].concat();
            options(sub, &way, all);
        }
    }

    fn is_of(argument: &Arg, kinds: &[TypeId]) -> bool {
        let kind = argument.get_value_parser().type_id();
        kinds.iter().any(|known| kind == *known)
    }

    /// The words in which the parser itself refuses the value.
    fn refused(all: &mut Command, way: &[String], option: &str, value: &str) -> Option<String> {
        let given = format!("--{option}={value}");
        let words = [&["host-cli".to_owned()], way, &[given]].concat();
        let error = all.try_get_matches_from_mut(words).err()?;
        let is_value =
            [ErrorKind::ValueValidation, ErrorKind::InvalidValue].contains(&error.kind());
        is_value.then(|| error.to_string())
    }

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
            assert_eq!(read_whole(text), want, "{text}");
        }
    }

    #[test]
    fn no_option_takes_a_number_that_nothing_real_has() {
        let (mut command, mut all) = (parser(), Vec::new());
        options(&command, &[], &mut all);
        let texts = [TypeId::of::<String>(), TypeId::of::<PathBuf>()];
        let (mut numbers, mut endless) = (0, Vec::new());
        for (way, argument) in all.iter().filter(|(_, argument)| !is_of(argument, &texts)) {
            let option = argument.get_long().unwrap_or_default();
            let words = format!("{} --{option}", way.join(" "));
            let mut takes = |value| refused(&mut command, way, option, value).is_none();
            numbers += usize::from(takes("1") || takes("0.1"));
            for value in ["1e300", "-1e300", "1e300:1e300", "0:1e300", "inf", "NaN"] {
                if takes(value) {
                    endless.push(format!("{words}={value}"));
                }
            }
        }
        assert!(endless.is_empty(), "{endless:#?}");
        assert!(numbers > 60, "{numbers}");
    }

    #[test]
    fn a_refusal_has_value_range_unit_and_option() {
        let (mut command, mut all) = (parser(), Vec::new());
        options(&command, &[], &mut all);
        let counts = [
            TypeId::of::<u8>(),
            TypeId::of::<u16>(),
            TypeId::of::<u32>(),
            TypeId::of::<u64>(),
            TypeId::of::<usize>(),
        ];
        let counts = all.iter().filter(|(_, argument)| is_of(argument, &counts));
        let mut counted = 0;
        for (way, argument) in counts {
            let option = argument.get_long().unwrap_or_default();
            let error = refused(&mut command, way, option, "1.5").expect(option);
            let asks = error.contains(" 1.5 is not a whole number from ");
            assert!(
                asks && error.contains(&format!("change --{option}")),
                "{error}"
            );
            counted += 1;
        }
        assert!(counted > 10, "{counted}");
        let error = refused(&mut command, &["teleoperate".to_owned()], "patience", "1e9");
        assert_eq!(
            error.expect("too long").trim_end(),
            "error: patience 1e9 s is not from 0 to 86400 s: change --patience"
        );
    }
}
