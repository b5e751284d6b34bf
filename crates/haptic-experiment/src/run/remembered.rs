//! Limits that `device set` gave a device, kept on this computer: a board forgets them when it is switched off, a device that
//! is served from here with every command. Before it is armed it gets those that are tighter than what it has.
//!
//! *Identity*: the serial number of its USB port, else the name of its board and its port. *Place*: a file for each device in
//! `limits` below the folder of [`Remembered::VARIABLE`], else below `fractional-haptics` in the user's folder of states. A
//! file is replaced as a whole, so the last of two writers counts. *Errors*: a file that is there and cannot be read keeps
//! the device from being armed.

use crate::document::failure::Failure;
use haptic_link::{Configuration, GuardKind, Limits};
use haptic_log::record::NewFile;
use haptic_loop::Limit;
use haptic_quantity::{digits, label, written};
use serde::Serialize;
use serde_json::Value;
use std::env::{home_dir, var_os};
use std::fmt::Display;
use std::fs;
use std::io::ErrorKind;
use std::path::PathBuf;

/// The place where the limits of a device are remembered.
#[derive(Debug)]
pub struct Remembered {
    device: String,
    /// `None` where nothing is to be remembered.
    file: Option<PathBuf>,
}

/// The content of a file.
#[derive(Serialize)]
struct Kept<'a> {
    device: &'a str,
    tick_period_us: u32,
    limits: Limits,
}

impl Remembered {
    /// Names the folder in which limits are remembered; empty, nothing is.
    pub const VARIABLE: &'static str = "FRACTIONAL_HAPTICS_STATE";

    /// The place of a device, which is known by its USB port's serial number, or by its board's name and its port.
    pub(crate) fn of(device: String) -> Self {
        let name = file_name(&device);
        let file = folder().map(|folder| folder.join("limits").join(name));
        Self { device, file }
    }

    /// The limits of a configuration, each replaced by a tighter one that is remembered; `None` if none is.
    ///
    /// # Errors
    /// A file that cannot be read, or is not one of these.
    pub fn tightened(&self, present: &Configuration) -> Result<Option<Limits>, Failure> {
        let set = self.set()?;
        let tightened = set.map(|set| present.tightened(&set));
        Ok(tightened.and_then(|(limits, looser)| looser.map(|_| limits)))
    }

    /// The limits that are remembered, with the tick for which they were set; `None` if none are.
    ///
    /// # Errors
    /// As [`tightened`](Self::tightened).
    pub(crate) fn set(&self) -> Result<Option<Configuration>, Failure> {
        let Some(file) = &self.file else {
            return Ok(None);
        };
        let text = match file.symlink_metadata() {
            Ok(found) if found.is_file() => fs::read_to_string(file),
            Ok(_) => Err(ErrorKind::InvalidInput.into()),
            // No limit was ever remembered under a name that is too long.
            Err(error)
                if matches!(
                    error.kind(),
                    ErrorKind::NotFound | ErrorKind::InvalidFilename
                ) =>
            {
                return Ok(None);
            }
            Err(error) => Err(error),
        };
        let text = text.map_err(|error| self.unreadable(&error))?;
        (self.read(&text).map(Some)).map_err(|error| self.unreadable(&error))
    }

    fn text(&self, set: &Configuration) -> Result<String, serde_json::Error> {
        serde_json::to_string_pretty(&Kept {
            device: &self.device,
            tick_period_us: set.tick_period_us,
            limits: set.limits,
        })
    }

    /// The limits of a file, with the tick for which they were set.
    fn read(&self, text: &str) -> Result<Configuration, serde_json::Error> {
        let kept: Value = serde_json::from_str(text)?;
        let set = Configuration {
            tick_period_us: serde_json::from_value(kept["tick_period_us"].clone())?,
            limits: serde_json::from_value(in_order(&kept["limits"]))?,
            ..Configuration::PASSIVE
        };
        // Of another order, version or spelling a number could be that of another limit.
        let again: Value = serde_json::from_str(&self.text(&set)?)?;
        match again == kept {
            true => Ok(set),
            false => Err(serde::de::Error::custom(
                "other limits than this program has",
            )),
        }
    }

    fn unreadable(&self, why: &dyn Display) -> Failure {
        Failure::device(format_args!(
            "the limits that were set on {} cannot be read from `{}` ({why}): end them with host-cli device forget, then set them anew",
            self.device,
            self.file.as_deref().unwrap_or("".as_ref()).display()
        ))
    }

    /// Remembers what was set; false if nothing is to be remembered.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn keep(&self, set: &Configuration) -> Result<bool, Failure> {
        let Some(file) = &self.file else {
            return Ok(false);
        };
        let text = self.text(set).map_err(Failure::input)?;
        file.parent()
            .map_or(Ok(()), fs::create_dir_all)
            .map_err(|error| self.unwritten(&error))?;
        let written = NewFile::filled(file, text.as_bytes(), true).and_then(NewFile::publish);
        written.map_err(|error| self.unwritten(&error))?;
        Ok(true)
    }

    fn unwritten(&self, why: &dyn Display) -> Failure {
        Failure::device(format_args!(
            "the limits hold until {} is switched off, and cannot be remembered ({why}): set {} to another folder",
            self.device,
            Self::VARIABLE
        ))
    }

    /// Device on which the limits were set, for a sentence.
    pub(crate) fn device(&self) -> &str {
        &self.device
    }

    /// Ends what is remembered; false if nothing is.
    ///
    /// # Errors
    /// A file that cannot be removed.
    pub fn forget(&self) -> Result<bool, Failure> {
        match self.file.as_ref().map(fs::remove_file) {
            None => Ok(false),
            Some(Ok(())) => Ok(true),
            Some(Err(error)) if error.kind() == ErrorKind::NotFound => Ok(false),
            Some(Err(error)) => Err(Failure::device(format_args!(
                "the limits that were set on {} cannot be forgotten ({error}): remove `{}`",
                self.device,
                self.file.as_deref().unwrap_or("".as_ref()).display()
            ))),
        }
    }
}

/// The name of a device's file. Two devices have two files, even on a file system that ignores case.
fn file_name(device: &str) -> String {
    let encoded = device.chars().map(|c| match c {
        'a'..='z' | '0'..='9' | '.' => c.to_string(),
        c => format!("-{:x}-", u32::from(c)),
    });
    format!("{}.json", encoded.collect::<String>())
}

/// The folder for states of this program, if there is one.
fn folder() -> Option<PathBuf> {
    if let Some(given) = var_os(Remembered::VARIABLE) {
        return Some(PathBuf::from(given)).filter(|given| !given.as_os_str().is_empty());
    }
    let states = if cfg!(windows) {
        PathBuf::from(var_os("LOCALAPPDATA")?)
    } else if cfg!(target_os = "macos") {
        home_dir()?.join("Library/Application Support")
    } else {
        let given = var_os("XDG_STATE_HOME").map(PathBuf::from);
        // A path that is not absolute is to be ignored.
        match given.filter(|given| given.is_absolute()) {
            Some(given) => given,
            None => home_dir()?.join(".local/state"),
        }
    };
    Some(states.join("fractional-haptics"))
}

/// The values of objects without their names: limits are read in order only.
fn in_order(value: &Value) -> Value {
    let Some(fields) = value.as_object() else {
        return value.clone();
    };
    fields.values().map(in_order).collect()
}

/// The limits that are looser than before, a sentence each.
#[must_use]
pub fn loosened(before: &Limits, after: &Limits) -> Vec<String> {
    let (mut then, mut now) = (*before, *after);
    let numbers = Limit::ALL.into_iter().filter_map(|limit| {
        let (before, after) = (*then.number(limit).0, *now.number(limit).0);
        let shown = |value| {
            if limit.is_off(value) {
                f32::INFINITY
            } else {
                value
            }
        };
        (!limit.is_tight(after, before)).then(|| (limit.key(), shown(before), shown(after)))
    });
    let of_run = |limits: &Limits| -> [(&str, f32); 3] {
        // 0 is no limit.
        let late_ticks = match limits.late_ticks {
            0 => f32::INFINITY,
            ticks => ticks.into(),
        };
        [
            ("watchdog_ms", limits.watchdog_ms.into()),
            ("late_ticks", late_ticks),
            ("max_age_ticks", limits.max_age_ticks.into()),
        ]
    };
    let of_run = of_run(before).into_iter().zip(of_run(after));
    let of_run = of_run.map(|((key, before), (_, after))| (key, before, after));
    let of_run = of_run.filter(|(_, before, after)| after > before);
    let in_words = |key, value: f32| match value {
        value if value.is_infinite() => "none".to_owned(),
        value => written(key, value.into()),
    };
    let mut words: Vec<String> = numbers
        .chain(of_run)
        .map(|(key, before, after)| {
            let (before, after) = (in_words(key, before), in_words(key, after));
            format!("{} from {before} to {after}", label(key))
        })
        .collect();
    let (low, high) = (after.workspace_low_m, after.workspace_high_m);
    let had = before.workspace_low_m < before.workspace_high_m;
    if had && (low >= high || low < before.workspace_low_m || high > before.workspace_high_m) {
        let ends = |low: f32, high: f32| match low < high {
            true => format!(
                "{}:{} mm",
                digits(1e3 * f64::from(low), 4),
                digits(1e3 * f64::from(high), 4)
            ),
            false => "none".to_owned(),
        };
        let before = ends(before.workspace_low_m, before.workspace_high_m);
        words.push(format!("workspace from {before} to {}", ends(low, high)));
    }
    if before.guard.kind != GuardKind::Off && after.guard != before.guard {
        words.push(match after.guard.kind {
            GuardKind::Off => "the passivity guard is off".to_owned(),
            GuardKind::Observer | GuardKind::EnergyBounding => {
                "the passivity guard is another one".to_owned()
            }
        });
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;
    use testkit::Random;

    #[test]
    fn whatever_was_set_is_read_again_bit_for_bit_and_nothing_else_is() {
        let place = Remembered {
            device: "a \"board\"".to_owned(),
            file: None,
        };
        let mut random = Random(84);
        for _ in 0..500 {
            let mut set = Configuration {
                tick_period_us: 250,
                ..Configuration::PASSIVE
            };
            for limit in Limit::ALL {
                *set.limits.number(limit).0 = random.log_between(1e-37, 1e37) as f32;
            }
            let text = place.text(&set).expect("text");
            assert_eq!(place.read(&text).expect("reads"), set);
            // Two limits in each other's place, in a text that is well formed.
            let swapped = text
                .replace("\"force_n", "\"x")
                .replace("rise_time_s", "force_n");
            for broken in ["null", &swapped.replace("\"x", "\"rise_time_s")] {
                place.read(broken).expect_err(broken);
            }
        }
    }

    #[test]
    fn two_devices_are_two_files() {
        let devices = [
            "board at /dev/ttyACM0",
            "board at /dev/ttyACM1",
            "Board at /dev/ttyACM0",
            "board at /dev/ttyacm0",
            "board at -2f-dev-2f-ttyacm0",
            "board-20-at /dev/ttyacm0",
            "board20at /dev/ttyacm0",
            "board at COM3",
            "moteus at /dev/ttyACM0, 1",
            "moteus at /dev/ttyACM0, 2",
        ];
        let mut names = devices.map(|device| file_name(device).to_lowercase());
        names.sort();
        assert!(names.windows(2).all(|pair| pair[0] != pair[1]), "{names:?}");
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "-.".contains(c);
        assert!(
            names.iter().all(|name| name.chars().all(is_plain)),
            "{names:?}"
        );
    }
}
