//! All parameters, of all kinds, the tables of each kind, and the names that a key may take.

pub use crate::experiment::press::keys::*;
pub use crate::experiment::{BESIDE, DRIVE_TABLE, KINDS};
pub use crate::question::QUESTIONS;
pub use crate::question::calibration::{CALIBRATION, keys::*};
pub use haptic_judge::rendering::keys::*;
pub use haptic_trial::robot::ADMITTANCE as ADMITTANCE_TABLE;

pub use haptic_document::parameters::*;
pub use haptic_measurement::MEASUREMENT;
pub use haptic_measurement::keys::*;
pub use haptic_question::analysis;
pub use haptic_question::control_loop::{CONTROL_LOOP, PLANT, REFERENCE};
pub use haptic_question::controller::{CONTROL_DESIGN, CROSSOVER, NOT_FLAT, PHASE_MARGIN};
pub use haptic_question::design::keys::*;
pub use haptic_question::plant::keys::{PLANT_RECORD, VALIDATE};
pub use haptic_question::tissue::RECORD;
pub use haptic_question::zwidth::keys::*;
pub use haptic_trial::keys::teleoperation::*;
pub use haptic_trial::keys::trial::*;
pub use haptic_trial::keys::wall::*;
pub use haptic_trial::safety::keys::*;
/// Questions of a device at hand, which moves.
pub const AT_A_DEVICE: [&str; 2] = [MEASUREMENT, CALIBRATION];

use crate::{
    experiment,
    experiment::{
        press::Protocol,
        teleoperation::PlaceName,
        touch::{GripName, ShapeName},
    },
    question,
};
use haptic_question::choices::{NamedChoice, names};
use haptic_trial::plant_file::calibration::CALIBRATION_KEYS;

/// Tables that this sort of file may have, `controller`, `plant`, or `experiment`, with those of
/// questions: heading and keys.
#[must_use]
pub fn tables(file: &str) -> Vec<KeyTable> {
    match file {
        "controller" => CONTROLLER_TABLES.to_vec(),
        "plant" => PLANT_TABLES.to_vec(),
        _ => [experiment::HEADINGS, QUESTION_TABLES].concat(),
    }
}

const QUESTION_TABLES: &[KeyTable] = &[
    ("device measure", haptic_measurement::MEASURE),
    ("device calibrate", question::calibration::CALIBRATE),
];

const CONTROLLER_TABLES: &[KeyTable] = &[
    ("[pid]", PID),
    ("[tid]", TID),
    ("[crone]", CRONE),
    ("[lead_lag]", LEAD_LAG),
    ("[transfer_function]", TRANSFER_CONTROLLER),
    ("[loop], in every controller file", CONTROLLER_LOOP),
    ("[source], optional", CONTROLLER_SOURCE),
];

const PLANT_TABLES: &[KeyTable] = &[
    ("[transfer_function]", TRANSFER_PLANT),
    ("[device]", DEVICE_PLANT),
    ("[calibration], beside [device]", CALIBRATION_KEYS),
    ("[state_space]", STATE_PLANT),
    ("[measured_response]", MEASURED_PLANT),
    ("[source], optional", PLANT_SOURCE),
];

/// True of a kind whose simulated device is that of its device file.
pub(crate) fn takes_device(name: &str) -> bool {
    match experiment::find(name) {
        Some(kind) => kind.companion.has_device_file(),
        None => QUESTIONS.contains(&name) || name == MEASUREMENT,
    }
}

/// Tables of experiment files, and of questions to a device, by kind: heading and parameters.
#[must_use]
pub fn of_kind(kind: &str) -> Vec<KeyTable> {
    experiment::tables(kind).map_or_else(|| question::tables(kind), <[KeyTable]>::to_vec)
}

/// The names that a parameter accepts, each with a short explanation; empty if it accepts any text.
#[must_use]
pub fn choices(parameter: &Parameter) -> Vec<NamedChoice> {
    match parameter.key {
        "hand" => names::<GripName>(),
        "environment" => names::<PlaceName>(),
        "protocol" => names::<Protocol>(),
        "shape" => names::<ShapeName>(),
        _ => haptic_question::choices::choices(parameter),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use haptic_loop::Limit;
    use haptic_quantity::{parse_for_key, without_unit};
    use std::collections::BTreeSet;

    /// An end that is none of `haptic-quantity` would make `power_limit=50%` half a watt.
    fn has_a_known_unit(key: &str) -> bool {
        const UNITS: &str = "a bar bit bits byte c cd deg degrees f g gf h hz j k kgf l lx m mol n oct ohm pa per percent ppm rad \
                             rev rpm s t turns v w wb";
        let is_unit = |word: &str| UNITS.split(' ').any(|unit| unit == word);
        // With a prefix too: ms, khz, mpa.
        let shortened = |word: &str| {
            word.strip_prefix(['m', 'k', 'u', 'n', 'g', 'c'])
                .map(is_unit)
        };
        let mut words = without_unit(key).split('_').skip(1);
        words.all(|word| !is_unit(word) && shortened(word) != Some(true))
    }

    /// Asserts that a default is shown as a person reads it.
    fn is_shown(key: &str, shown: &str, default: f64) {
        let number = parse_for_key(key, shown).expect("a quantity");
        let close = (number - default).abs() <= 1e-15 * default.abs();
        assert!(close, "{key}: {shown} is {number}, not {default}");
    }

    #[test]
    fn a_table_has_no_unknown_unit_no_key_twice_and_every_default_is_one_that_may_be_given_as_it_is_shown()
     {
        let unknown = [
            "power_limit_w",
            "power_limit_kw",
            "rate_khz",
            "torque_n_m",
            "drift_pa_per_h",
            "tilt_percent",
        ];
        assert!(!unknown.into_iter().any(has_a_known_unit));
        let kinds = KINDS.into_iter().chain(QUESTIONS).chain(AT_A_DEVICE);
        let (mut texts, mut numbers) = (0, 0);
        for kind in kinds {
            let mut keys = BTreeSet::new();
            for parameter in of_kind(kind).iter().flat_map(|(_, table)| *table) {
                let (key, choices) = (parameter.key, choices(parameter));
                assert!(keys.insert(key), "{kind}: {key}");
                // A text is read by whoever wants it.
                let is_text = matches!(parameter.value, Value::Text(_));
                assert!(is_text || has_a_known_unit(key), "{kind}: {key}");
                match parameter.value {
                    Value::Number(Some(default), range) => {
                        assert!(range.contains(default), "{key}: {default}");
                        if !parameter.shown.is_empty() {
                            is_shown(key, parameter.shown, default);
                        }
                        // There is one for all.
                        assert!(key != "sample_time_s" || default.to_bits() == 1e-3_f64.to_bits());
                        numbers += 1;
                    }
                    Value::List(_) if !parameter.shown.is_empty() => {
                        let wanted = parameter.shown.matches(',').count() + 1;
                        assert_eq!(parameter.default_numbers().len(), wanted, "{key}");
                    }
                    Value::Text(default) if !choices.is_empty() => {
                        texts += 1;
                        let is_one = choices.iter().any(|choice| choice.0 == default);
                        assert!(is_one, "{key}: {default}");
                    }
                    Value::Number(None, _)
                    | Value::Count(_)
                    | Value::Flag(_)
                    | Value::Text(_)
                    | Value::List(_) => (),
                }
            }
        }
        assert!(texts > 5 && numbers > 50, "{texts} {numbers}");
        let of_files = ["controller", "plant", "experiment"].map(tables).concat();
        let of_forms = [RECORD, PLANT_RECORD, CONTROL_DESIGN, CONTROL_LOOP].concat();
        for parameter in of_files
            .iter()
            .chain(&of_forms)
            .flat_map(|(_, table)| *table)
        {
            let is_text = matches!(parameter.value, Value::Text(_));
            assert!(
                is_text || has_a_known_unit(parameter.key),
                "{}",
                parameter.key
            );
        }
        for limit in Limit::ALL {
            assert!(has_a_known_unit(limit.key()), "{}", limit.key());
            if let Some((_, shown)) = limit.help().split_once(" [default: ")
                && let Some(shown) = shown.split([' ', ']']).next()
            {
                is_shown(limit.key(), shown, limit.default_number());
            }
        }
    }
}
