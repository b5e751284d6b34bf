//! From the names of the libraries to options: an error of a library names a parameter as an experiment file does,
//! `` `force_limit_n` ``; the command says `--force-limit (force_limit_n in a file)`.

use haptic_experiment::file::FileError;
use haptic_experiment::parameters::{Parameter, is_key};
use haptic_experiment::{Failure, Imperfections};

/// Keys of the libraries' parameters, each with the option that sets it.
const OPTIONS: &[(&str, &str)] = &[
    ("area_m2", "--area"),
    ("box_m", "--box"),
    ("branches", "--prony"),
    ("brake_force_n", "--brake-force"),
    ("bootstrap", "--bootstrap"),
    ("braking_n_s_per_m", "--braking"),
    ("columns", "--columns"),
    ("complementary_peak", "--complementary-peak"),
    ("connect", "--connect"),
    ("contact", "--contact"),
    ("controller", "--drive"),
    ("crossover_rad_s", "--crossover"),
    ("current_lag_s", "--current-lag"),
    ("damping_n_s_per_m", "--damping"),
    ("delay_s", "--delay"),
    ("device", "--device"),
    ("device_damping_n_s_per_m", "--device-damping"),
    ("device_delay_least_s", "--device-delay"),
    ("device_delay_most_s", "--device-delay"),
    ("device_lag_s", "--device-lag"),
    ("device_mass_kg", "--device-mass"),
    ("device_model", "--device-model"),
    ("device_noise_m", "--device-noise"),
    ("disturbance", "--disturbance"),
    ("drive_force_limit_n", "--drive-force-limit"),
    ("duration_s", "--duration"),
    ("encoder_resolution_m", "--encoder-resolution"),
    ("force_limit_n", "--force-limit"),
    ("force_rate_limit_n_per_s", "--force-rate-limit"),
    ("force_unstable", "--force-unstable"),
    ("frequency_hz", "--frequency"),
    ("friction_n", "--friction"),
    ("gain_margin", "--gain-margin"),
    ("guard", "--guard"),
    ("hand", "--hand"),
    ("hand_stiffness_n_per_m", "--hand-stiffness"),
    ("horizon_s", "--horizon"),
    ("jump_m", "--jump"),
    ("kind", "--kind"),
    ("listen", "--listen"),
    ("loop", "--loop"),
    ("mass_kg", "--mass"),
    ("max_age_ticks", "--max-age-ticks"),
    ("noise", "--noise"),
    ("orders", "--orders"),
    ("out", "--out"),
    ("output_high", "--output-limits"),
    ("output_low", "--output-limits"),
    ("overwrite", "--overwrite"),
    ("patience", "--patience"),
    ("phase_margin_rad", "--phase-margin"),
    ("pin", "--pin"),
    ("port", "--port"),
    ("ramp_time_s", "--ramp-time"),
    ("rate_hz", "--rate"),
    ("realtime", "--realtime"),
    ("rise_time_s", "--rise-time"),
    ("sample_time_s", "--sample-time"),
    ("scheme", "--scheme"),
    ("sensitivity_peak", "--sensitivity-peak"),
    ("sensor_noise_m", "--sensor-noise"),
    ("shortest_s", "--shortest"),
    ("skipped_most", "--skipped-most"),
    ("speed_limit_m_per_s", "--speed-limit"),
    ("stop_time_s", "--stop-time"),
    ("strain", "--strain"),
    ("stress_pa", "--stress"),
    ("stuck_force_n", "--stuck-force"),
    ("stuck_time_s", "--stuck-time"),
    ("thickness_m", "--thickness"),
    ("tissue", "--tissue"),
    ("units", "--units"),
    ("watchdog_s", "--watchdog"),
    ("window_s", "--window"),
    ("workspace_high_m", "--workspace"),
    ("workspace_low_m", "--workspace"),
];

/// A message of a library with options in place of its parameters; `` `loop` = host `` becomes `--loop host`.
#[must_use]
pub fn with_options(message: &str) -> String {
    let mut text = message.to_owned();
    for (key, option) in OPTIONS {
        let named = format!("`{key}`");
        if !text.contains(&named) {
            continue;
        }
        text = text.replace(&format!("{named} = "), &format!("{option} "));
        let shown = if is_key(key) && option.trim_start_matches('-') != *key {
            format!("{option} ({key} in a file)")
        } else {
            (*option).to_owned()
        };
        text = text.replace(&named, &shown);
    }
    text
}

/// The help of an option whose default stands in the library, for those that have to know whether they were given.
#[must_use]
pub fn help_with_default(parameter: &Parameter) -> String {
    format!("{} [default: {}]", parameter.help, parameter.shown)
}

/// The seed, if there is noise that it is for.
///
/// # Errors
/// A seed without noise.
pub fn seed_for(seed: Option<u64>, noise_m: f64) -> Result<u64, Failure> {
    match seed {
        Some(seed) if noise_m == 0.0 => Err(Failure::bad_input(format_args!(
            "seed {seed} has no effect without noise: give --sensor-noise too, as in 1um, or leave --seed out"
        ))),
        Some(seed) => Ok(seed),
        None => Ok(Imperfections::NONE.sensors.seed),
    }
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
        use haptic_quantity::{
            Area, Damping, Force, ForceRate, Length, Mass, Stiffness, Strain, Stress, Time,
        };
        let mut numbers = 0;
        for parameter in [RELAX, CREEP, RENDERING, DRIVE, MEASURE, WALL_REQUIRED, WALL].concat() {
            let (Value::Number(Some(default), _), false) =
                (parameter.value, parameter.shown.is_empty())
            else {
                continue;
            };
            let (shown, key) = (parameter.shown, parameter.key);
            let number = match key {
                "strain" => shown.parse::<Strain>().map(|x| x.0),
                key if key.ends_with("_n_per_s") => shown.parse::<ForceRate>().map(|x| x.0),
                key if key.ends_with("_n_s_per_m") => shown.parse::<Damping>().map(|x| x.0),
                key if key.ends_with("_n_per_m") => shown.parse::<Stiffness>().map(|x| x.0),
                key if key.ends_with("_pa") => shown.parse::<Stress>().map(|x| x.0),
                key if key.ends_with("_kg") => shown.parse::<Mass>().map(|x| x.0),
                key if key.ends_with("_m2") => shown.parse::<Area>().map(|x| x.0),
                key if key.ends_with("_n") => shown.parse::<Force>().map(|x| x.0),
                key if key.ends_with("_s") => shown.parse::<Time>().map(|x| x.0),
                _ => shown.parse::<Length>().map(|x| x.0),
            };
            let number = number.expect("a quantity");
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
