//! Parameters of the experiments: key, default, range and a line for people, once. Experiment files, options with their help,
//! and the reference of keys are made from these tables.
//!
//! Keys carry the SI unit of the value. `shown` is the default as a person writes it, and its value is the same (a test
//! holds each against the number).

mod controller;
mod coupler;
mod device;
mod experiment;
mod kind;
mod measure;
mod question;
pub mod range;
mod safety;
mod teleoperation;
mod touch;
mod wall;

pub use controller::*;
pub use coupler::*;
pub use device::*;
pub use experiment::*;
pub use kind::{Parameter, Value};
pub use measure::*;
pub use question::*;
pub use range::Range;
pub use safety::*;
pub use teleoperation::*;
pub use touch::*;
pub use wall::*;

use haptic_quantity::Key;
use std::path::Path;

/// Runs although the analysis says no.
pub(crate) const FORCE_UNSTABLE: Key = Key("force_unstable");
/// Folder of a run.
pub(crate) const OUT: Key = Key("out");
/// Leave to write over a file or into a folder that is there.
pub(crate) const OVERWRITE: Key = Key("overwrite");
/// By the clock.
pub(crate) const REALTIME: Key = Key("realtime");
/// Time to wait for a device or another side.
pub(crate) const PATIENCE: Key = Key("patience");
/// Share of the ticks that may be skipped.
pub(crate) const SKIPPED_SHARE: Key = Key("skipped_most");
/// Port at which one side of a teleoperation waits.
pub(crate) const LISTEN: Key = Key("listen");
/// Address of its other side.
pub(crate) const CONNECT: Key = Key("connect");
/// Core of the loop.
pub(crate) const PIN: Key = Key("pin");
/// Port of the page.
pub const PORT: Key = Key("port");
/// Rate of a loop, Hz.
pub(crate) const RATE: Key = Key("rate_hz");

/// Kinds of experiments, the names of their tables in files.
pub const KINDS: [&str; 6] = [
    "relax",
    "creep",
    "wall",
    "coupler",
    "teleoperation",
    "touch",
];

/// Questions to a device, the names of their tables.
pub const QUESTIONS: [&str; 2] = ["zwidth", "design"];

/// The question that lets a device move.
pub const MEASUREMENT: &str = "measure";

/// The table beside an experiment that a controller drives.
pub const DRIVE_TABLE: &str = "drive";

/// True of a kind whose simulated device is that of its device file.
#[must_use]
pub(crate) fn takes_device(kind: &str) -> bool {
    ["wall", "coupler", "zwidth", "design", MEASUREMENT].contains(&kind)
}

/// Tables of experiment files, and of questions to a device, by kind: heading and parameters.
#[must_use]
pub fn of_kind(kind: &str) -> Vec<(&'static str, &'static [Parameter])> {
    let common = match kind {
        // On simulated devices alone.
        "teleoperation" => vec![("safety", SAFETY)],
        "zwidth" => vec![("bench", BENCH), ("device", ON_DEVICE)],
        "design" => vec![("bench", BENCH)],
        MEASUREMENT => vec![("simulated", SIMULATED), ("device", MEASURED)],
        _ => vec![("device", ON_DEVICE), ("safety", SAFETY)],
    };
    let own: &[(&str, &[Parameter])] = match kind {
        "relax" => &[("relaxation", RELAX), ("rendering", RENDERING)],
        "creep" => &[("creep", CREEP), ("rendering", RENDERING)],
        "coupler" => &[("required", COUPLER_REQUIRED), ("coupler", COUPLER)],
        "teleoperation" => &[("teleoperation", TELEOPERATION)],
        "touch" => &[("touch", TOUCH)],
        "zwidth" => &[("Z-width", ZWIDTH)],
        "design" => &[("design", DESIGN)],
        MEASUREMENT => &[(MEASUREMENT, MEASURE)],
        _ => &[("required", WALL_REQUIRED), ("wall", WALL)],
    };
    own.iter().copied().chain(common).collect()
}

/// Parameters that name a file or a folder of files, some of them also by a name that is no path.
pub const FILES: [&str; 5] = [
    TISSUE.key,
    LIBRARY.key,
    CONTROLLER.key,
    DEVICE_MODEL.key,
    RESPONSE_FILE.key,
];

/// True if this text of a parameter is the path of a file or of a folder of files.
#[must_use]
pub fn is_path(parameter: &Parameter, text: &str) -> bool {
    FILES.contains(&parameter.key)
        && match parameter.key {
            key if key == TISSUE.key => Path::new(text).extension().is_some_and(|e| e == "toml"),
            key if key == DEVICE_MODEL.key && text == LABORATORY => false,
            _ => !text.is_empty(),
        }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_one_default_sample_time() {
        let kinds = KINDS.into_iter().chain(QUESTIONS).chain([MEASUREMENT]);
        let all = kinds.flat_map(of_kind).flat_map(|(_, table)| table.iter());
        let own = all.filter(|parameter| parameter.key == "sample_time_s");
        let defaults: Vec<f64> = own.map(Parameter::default_number).collect();
        assert!(
            defaults.len() > 6 && defaults.iter().all(|&t| t.to_bits() == 1e-3_f64.to_bits()),
            "{defaults:?}"
        );
    }

    #[test]
    fn a_table_has_no_key_twice_and_every_default_is_in_its_range() {
        for kind in KINDS.into_iter().chain(QUESTIONS).chain([MEASUREMENT]) {
            let all: Vec<Parameter> = of_kind(kind)
                .iter()
                .flat_map(|(_, table)| *table)
                .copied()
                .collect();
            for (n, parameter) in all.iter().enumerate() {
                assert!(
                    all[..n].iter().all(|other| other.key != parameter.key),
                    "{}",
                    parameter.key
                );
                if let Value::Number(Some(default), range) = parameter.value {
                    assert!(range.contains(default), "{}: {default}", parameter.key);
                }
                if let (Value::List(_), false) = (parameter.value, parameter.shown.is_empty()) {
                    let wanted = parameter.shown.matches(',').count() + 1;
                    assert_eq!(
                        parameter.default_numbers().len(),
                        wanted,
                        "{}",
                        parameter.key
                    );
                }
            }
        }
    }

    #[test]
    fn a_default_is_shown_as_the_number_it_is() {
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
}
