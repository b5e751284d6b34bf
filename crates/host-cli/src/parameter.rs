//! From the names of the libraries to options: an error of a library names a parameter as an experiment file does,
//! `` `force_limit_n` ``; the command says `--force-limit (force_limit_n in a file)`.

use crate::keys;
use crate::options::option_of;
use haptic_experiment::Failure;
use haptic_experiment::file::FileError;
use haptic_experiment::parameters::Parameter;

/// Parameters that no document has, each with the option that sets it.
const OPTIONS: &[(&str, &str)] = &[
    ("branches", "--prony"),
    ("bootstrap", "--bootstrap"),
    ("columns", "--columns"),
    ("complementary_peak", "--complementary-peak"),
    ("connect", "--connect"),
    ("crossover_rad_s", "--crossover"),
    ("disturbance", "--disturbance"),
    ("force_unstable", "--force-unstable"),
    ("horizon_s", "--horizon"),
    ("kind", "--kind"),
    ("listen", "--listen"),
    ("noise", "--noise"),
    ("out", "--out"),
    ("output_high", "--output-limits"),
    ("output_low", "--output-limits"),
    ("overwrite", "--overwrite"),
    ("patience", "--patience"),
    ("phase_margin_rad", "--phase-margin"),
    ("pin", "--pin"),
    ("port", "--port"),
    ("rate_hz", "--rate"),
    ("realtime", "--realtime"),
    ("sensitivity_peak", "--sensitivity-peak"),
    ("shortest_s", "--shortest"),
    ("skipped_most", "--skipped-most"),
    ("units", "--units"),
];

/// Keys of documents that are set on a device by an option.
const ON_DEVICE: [(&str, &str); 2] = [
    ("speed_limit_m_per_s", "--speed-limit"),
    ("workspace_low_m", "--workspace"),
];

/// A message of a library with options in place of its parameters; `` `loop` = host `` becomes `--loop host`. A key without an option stays: it is
/// given as it is written.
#[must_use]
pub fn with_options(message: &str) -> String {
    let mut text = message.to_owned();
    let replace = |text: &mut String, key: &str, option: &str, shown: &str| {
        let named = format!("`{key}`");
        *text = text.replace(&format!("{named} = "), &format!("{option} "));
        *text = text.replace(&named, shown);
    };
    for (key, option) in OPTIONS {
        replace(&mut text, key, option, option);
    }
    for (key, option) in ON_DEVICE {
        let said = format!("device set `{key}` = ");
        text = text.replace(&said, &format!("device set {option} "));
    }
    for Parameter { key, .. } in keys::of_command() {
        let option = format!("--{}", option_of(key));
        match option.trim_start_matches('-') == *key {
            true => replace(&mut text, key, &option, &option),
            false => replace(
                &mut text,
                key,
                &option,
                &format!("{option} ({key} in a file)"),
            ),
        }
    }
    text
}

/// Text of an error, with options in place of parameters. An error about an experiment file keeps the keys of the file.
#[must_use]
pub fn in_words(failure: &Failure) -> String {
    let about_file = match failure {
        Failure::Input(error) => error.is::<FileError>(),
        _ => false,
    };
    if about_file {
        failure.to_string()
    } else {
        with_options(&failure.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory as _;

    #[test]
    fn a_parameter_becomes_the_option_that_sets_it() {
        assert_eq!(
            with_options("ramp time 0 s is not above 0 s: give `ramp_time_s`"),
            "ramp time 0 s is not above 0 s: give --ramp-time (ramp_time_s in a file)"
        );
        assert_eq!(
            with_options("leave `loop` = host away"),
            "leave --loop host away"
        );
        assert_eq!(
            with_options("`relax.mcap` is taken"),
            "`relax.mcap` is taken"
        );
    }

    #[test]
    fn a_default_is_shown_as_the_number_it_is() {
        use haptic_experiment::parameters::{
            CREEP, DRIVE, MEASURE, RELAX, RENDERING, Value, WALL, WALL_REQUIRED,
        };
        use haptic_quantity::parse_for_key;
        let mut numbers = 0;
        for parameter in [RELAX, CREEP, RENDERING, DRIVE, MEASURE, WALL_REQUIRED, WALL].concat() {
            let (Value::Number(Some(default), _), false) =
                (parameter.value, parameter.shown.is_empty())
            else {
                continue;
            };
            let (shown, key) = (parameter.shown, parameter.key);
            let number = parse_for_key(key, shown).expect("a quantity");
            assert!(
                (number - default).abs() <= 1e-15 * default.abs(),
                "{key}: {shown} is {number}, not {default}"
            );
            numbers += 1;
        }
        assert!(numbers > 15, "{numbers}");
    }

    #[test]
    fn every_option_is_one_of_the_command() {
        fn options(command: &clap::Command, all: &mut Vec<String>) {
            all.extend(
                command
                    .get_arguments()
                    .filter_map(|a| a.get_long().map(|l| format!("--{l}"))),
            );
            for sub in command.get_subcommands() {
                options(sub, all);
            }
        }
        let mut all = Vec::new();
        options(&crate::cli::Cli::command(), &mut all);
        for (key, option) in OPTIONS {
            assert!(all.iter().any(|known| known == option), "{key}: {option}");
        }
    }
}
