//! From the names of the libraries to options: an error of a library names a parameter as an experiment file does,
//! `` `force_limit_n` ``; the command says `--force-limit (force_limit_n in a file)`.

use haptic_experiment::Failure;
use haptic_experiment::file::FileError;

/// A parameter of the libraries: its key, the option that sets it, and whether experiment files have the key.
type Parameter = (&'static str, &'static str, bool);

const PARAMETERS: &[Parameter] = &[
    ("area_m2", "--area", true),
    ("brake_force_n", "--brake-force", true),
    ("braking_n_s_per_m", "--braking", true),
    ("contact", "--contact", true),
    ("current_lag_s", "--current-lag", true),
    ("damping_n_s_per_m", "--damping", true),
    ("delay_s", "--delay", true),
    ("device", "--device", true),
    ("device_damping_n_s_per_m", "--device-damping", true),
    ("device_delay_least_s", "--device-delay", true),
    ("device_delay_most_s", "--device-delay", true),
    ("device_lag_s", "--device-lag", true),
    ("device_mass_kg", "--device-mass", true),
    ("device_noise_m", "--device-noise", true),
    ("duration_s", "--duration", true),
    ("encoder_resolution_m", "--encoder-resolution", true),
    ("force_limit_n", "--force-limit", true),
    ("force_rate_limit_n_per_s", "--force-rate-limit", true),
    ("force_unstable", "--force-unstable", false),
    ("frequency_hz", "--frequency", false),
    ("friction_n", "--friction", true),
    ("gain_margin", "--gain-margin", false),
    ("hand_stiffness_n_per_m", "--hand-stiffness", true),
    ("jump_m", "--jump", true),
    ("loop", "--loop", true),
    ("mass_kg", "--mass", true),
    ("orders", "--orders", false),
    ("out", "--out", false),
    ("overwrite", "--overwrite", false),
    ("pin", "--pin", false),
    ("ramp_time_s", "--ramp-time", true),
    ("rate_hz", "--rate", false),
    ("realtime", "--realtime", false),
    ("rise_time_s", "--rise-time", true),
    ("sample_time_s", "--sample-time", true),
    ("scheme", "--scheme", true),
    ("sensor_noise_m", "--sensor-noise", true),
    ("speed_limit_m_per_s", "--speed-limit", true),
    ("stop_time_s", "--stop-time", true),
    ("strain", "--strain", true),
    ("stress_pa", "--stress", true),
    ("stuck_force_n", "--stuck-force", true),
    ("stuck_time_s", "--stuck-time", true),
    ("thickness_m", "--thickness", true),
    ("tissue", "--tissue", true),
    ("watchdog_s", "--watchdog", true),
    ("workspace_high_m", "--workspace", true),
    ("workspace_low_m", "--workspace", true),
];

/// A message of a library with options in place of its parameters; `` `loop` = host `` becomes `--loop host`.
#[must_use]
pub fn with_options(message: &str) -> String {
    let mut text = message.to_owned();
    for (key, option, in_file) in PARAMETERS {
        let named = format!("`{key}`");
        if !text.contains(&named) {
            continue;
        }
        text = text.replace(&format!("{named} = "), &format!("{option} "));
        let shown = if *in_file && option.trim_start_matches('-') != *key {
            format!("{option} ({key} in a file)")
        } else {
            (*option).to_owned()
        };
        text = text.replace(&named, &shown);
    }
    text
}

/// What went wrong, with options in place of parameters. An error about an experiment file keeps the keys of the file.
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
        assert_eq!(with_options("`/tmp/x` is taken"), "`/tmp/x` is taken");
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
        for (key, option, _) in PARAMETERS {
            assert!(all.iter().any(|known| known == option), "{key}: {option}");
        }
    }
}
