//! Options whose number lies in the range of a parameter: the range stands with the parameter.

use clap::builder::TypedValueParser;
use clap::error::ErrorKind;
use clap::{Arg, Command, Error};
use fracdiff::parameter::Shown;
use haptic_experiment::parameters::Range;
use haptic_quantity::{Quantity, QuantityError, parse_number};
use std::ffi::OsStr;
use std::str::FromStr;

/// What was read, if it is in a range.
///
/// # Errors
/// Value and range, for people.
pub fn in_range<Q: Quantity>(quantity: Q, range: Range) -> Result<Q, String> {
    if range.contains(quantity.si()) {
        return Ok(quantity);
    }
    let space = if Q::UNIT.is_empty() { "" } else { " " };
    let (value, unit) = (Shown(quantity.si()), Q::UNIT);
    Err(format!("{value}{space}{unit} is not {range}{space}{unit}"))
}

/// A parser of a quantity in a range.
#[derive(Clone, Debug)]
pub struct Within<P> {
    parse: P,
    range: Range,
}

/// A parser of a quantity in a range.
#[must_use]
pub fn within<Q: Quantity + FromStr<Err = QuantityError>>(
    range: Range,
) -> Within<impl Fn(&str) -> Result<Q, QuantityError> + Clone + Send + Sync + 'static> {
    read_within(str::parse::<Q>, range)
}

/// A parser of a plain number in a range.
#[must_use]
pub fn number_within(
    range: Range,
) -> Within<impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + 'static> {
    read_within(parse_number, range)
}

/// What `parse` reads, in a range.
#[must_use]
pub const fn read_within<P>(parse: P, range: Range) -> Within<P> {
    Within { parse, range }
}

impl<P, Q, E> TypedValueParser for Within<P>
where
    P: Fn(&str) -> Result<Q, E> + Clone + Send + Sync + 'static,
    Q: Quantity,
    E: Into<Box<dyn std::error::Error + Send + Sync + 'static>>,
{
    type Value = Q;

    fn parse_ref(
        &self,
        command: &Command,
        argument: Option<&Arg>,
        value: &OsStr,
    ) -> Result<Q, Error> {
        let quantity = self.parse.parse_ref(command, argument, value)?;
        in_range(quantity, self.range).map_err(|refused| {
            let option = argument.and_then(Arg::get_long).unwrap_or_default();
            let name = option.replace('-', " ");
            let refused = format!("{name} {refused}: change --{option}\n");
            Error::raw(ErrorKind::ValueValidation, refused)
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::cli::Cli;
    use clap::error::ErrorKind;
    use clap::{Arg, Command, CommandFactory as _};
    use std::any::TypeId;
    use std::path::PathBuf;

    /// Options whose number is judged elsewhere, in words of its own: orders by what has an order, an angle in degrees, rates and
    /// durations of `rt-check` and sizes of files by what they are for.
    const ELSEWHERE: [&str; 6] = [
        "order",
        "orders",
        "phase-margin",
        "rate",
        "roll",
        "rt-check --duration",
    ];

    /// Every option of a command and of those below it, with the words that lead there.
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

    fn is_text(argument: &Arg) -> bool {
        let kind = argument.get_value_parser().type_id();
        [TypeId::of::<String>(), TypeId::of::<PathBuf>()]
            .iter()
            .any(|text| kind == *text)
    }

    /// True if the parser itself refuses the value.
    fn refuses(command: &mut Command, way: &[String], option: &str, value: &str) -> bool {
        let words = [
            &["host-cli".to_owned()],
            way,
            &[format!("--{option}={value}")],
        ]
        .concat();
        let parsed = command.try_get_matches_from_mut(words);
        let kind = parsed.map_err(|error| error.kind());
        matches!(
            kind,
            Err(ErrorKind::ValueValidation | ErrorKind::InvalidValue)
        )
    }

    #[test]
    fn no_option_takes_a_number_that_nothing_real_has() {
        let (mut command, mut all) = (Cli::command(), Vec::new());
        options(&command, &[], &mut all);
        let mut refuses =
            |way: &[String], option: &str, value: &str| refuses(&mut command, way, option, value);
        let (mut numbers, mut endless) = (0, Vec::new());
        for (way, argument) in all.iter().filter(|(_, argument)| !is_text(argument)) {
            let option = argument.get_long().unwrap_or_default();
            let words = format!("{} --{option}", way.join(" "));
            if ELSEWHERE.contains(&option) || ELSEWHERE.contains(&words.as_str()) {
                continue;
            }
            numbers += usize::from(!refuses(way, option, "1") || !refuses(way, option, "0.1"));
            for value in ["1e300", "-1e300", "1e300:1e300", "0:1e300", "inf", "NaN"] {
                if !refuses(way, option, value) {
                    endless.push(format!("{words}={value}"));
                }
            }
        }
        assert!(endless.is_empty(), "{endless:#?}");
        assert!(numbers > 60, "{numbers}");
    }

    #[test]
    fn an_option_that_counts_says_its_range() {
        let mut all = Vec::new();
        options(&Cli::command(), &[], &mut all);
        let counts = [
            TypeId::of::<u8>(),
            TypeId::of::<u16>(),
            TypeId::of::<u32>(),
            TypeId::of::<u64>(),
            TypeId::of::<usize>(),
        ];
        let is_count = |argument: &Arg| {
            let kind = argument.get_value_parser().type_id();
            counts.iter().any(|count| kind == *count)
        };
        let mut counted = 0;
        for (way, argument) in all.iter().filter(|(_, argument)| is_count(argument)) {
            let option = argument.get_long().unwrap_or_default();
            let given = format!("--{option}=1.5");
            let words = [&["host-cli".to_owned()], way.as_slice(), &[given]].concat();
            let refused = Cli::command().try_get_matches_from(words);
            let said = refused.expect_err(option).to_string();
            let asks = said.contains(" 1.5 is not a whole number from ");
            assert!(
                asks && said.contains(&format!("change --{option}")),
                "{said}"
            );
            counted += 1;
        }
        assert!(counted > 10, "{counted}");
    }

    #[test]
    fn two_numbers_in_one_value_have_ranges_too() {
        for (line, value) in [
            ("control design --noise", "1e300rad/s:-20dB"),
            ("control design --disturbance", "1rad/s:1e300"),
            ("control design --output-limits", "-1e300:1"),
        ] {
            let (way, option) = line.rsplit_once(" --").expect("an option");
            let way: Vec<String> = way.split(' ').map(str::to_owned).collect();
            let refused = refuses(&mut Cli::command(), &way, option, value);
            assert!(refused, "{line}={value}");
        }
    }

    #[test]
    fn a_refusal_has_value_range_unit_and_option() {
        let words = ["host-cli", "teleoperate", "--patience", "1e9"];
        let refused = Cli::command().try_get_matches_from(words);
        let refused = refused.expect_err("too long").to_string();
        assert_eq!(
            refused.trim_end(),
            "error: patience 1e9 s is not from 0 to 86400 s: change --patience"
        );
    }
}
