//! Names of devices: `KIND:PATH[,key=value]…`.

use haptic_quantity::{QuantityError, parse_for_key};
use haptic_remote::serial::{SerialError, host_and_port, tcp_address};
use std::ops::RangeInclusive;
use thiserror::Error;

/// A device's name behind its kind: a path, which ends at the first comma, and settings by key, each given at most once.
#[derive(Debug)]
pub(crate) struct Settings<'a> {
    pub path: &'a str,
    pairs: Vec<(&'a str, &'a str)>,
}

/// Why a name does not describe a device.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum NameError {
    /// A kind of device that is not known.
    #[error("\"{kind}\" is not a kind of device: use one of {known}")]
    Kind {
        /// The word before the colon, as it was given.
        kind: String,
        /// Every kind that there is, with commas between.
        known: String,
    },
    /// No path behind the kind.
    #[error("{kind} needs the path of a port, as in {kind}:/dev/ttyACM0")]
    Path {
        /// The kind whose name it is.
        kind: &'static str,
    },
    /// An invalid address after `tcp:`.
    #[error(transparent)]
    Address(#[from] SerialError),
    /// Something behind a comma that is not a `key=value`.
    #[error("\"{text}\" is not a setting: write key=value; the keys of {kind} are {keys}")]
    Setting {
        /// The part between two commas, as it was given.
        text: String,
        /// The kind whose name it is.
        kind: &'static str,
        /// All keys of this kind.
        keys: String,
    },
    /// A key that is there twice.
    #[error("{key} is given twice")]
    Twice {
        /// Key to which the value belongs.
        key: String,
    },
    /// A value outside the choices.
    #[error("{key} = \"{value}\" is not one of {choices}")]
    Choice {
        /// Key to which the value belongs.
        key: &'static str,
        /// The value as it was given.
        value: String,
        /// Every name that the key takes, with commas between.
        choices: String,
    },
    /// A value that is no quantity of its kind.
    #[error("{key}: {error}")]
    Quantity {
        /// Key to which the value belongs.
        key: &'static str,
        /// Its kind and units.
        error: QuantityError,
    },
    /// A value that is no number in its range.
    #[error("{key} = \"{value}\" is not in [{least}, {most}]{unit}")]
    Number {
        /// Key to which the value belongs.
        key: &'static str,
        /// The value as it was given.
        value: String,
        /// The least value that is taken.
        least: f64,
        /// The greatest value that is taken.
        most: f64,
        /// A blank and the unit; nothing for a number without one.
        unit: &'static str,
    },
}

impl<'a> Settings<'a> {
    pub(crate) fn parse(
        kind: &'static str,
        text: &'a str,
        keys: &[&str],
    ) -> Result<Self, NameError> {
        let mut parts = text.split(',');
        let path = parts.next().filter(|path| !path.is_empty());
        let path = path.ok_or(NameError::Path { kind })?;
        tcp_address(path).map(host_and_port).transpose()?;
        let mut pairs: Vec<(&str, &str)> = Vec::new();
        for part in parts {
            let pair = part.split_once('=').filter(|(key, _)| keys.contains(key));
            let (key, value) = pair.ok_or_else(|| NameError::Setting {
                text: part.to_owned(),
                kind,
                keys: keys.join(", "),
            })?;
            if pairs.iter().any(|(known, _)| *known == key) {
                let key = key.to_owned();
                return Err(NameError::Twice { key });
            }
            pairs.push((key, value));
        }
        Ok(Self { path, pairs })
    }

    pub(crate) fn text(&self, key: &str) -> Option<&'a str> {
        let found = self.pairs.iter().find(|(known, _)| *known == key);
        found.map(|(_, value)| *value)
    }

    /// The value of a key, by its name among these; `default` if it is not given.
    pub(crate) fn choice<T: Copy>(
        &self,
        key: &'static str,
        choices: &[(&str, T)],
        default: T,
    ) -> Result<T, NameError> {
        let Some(value) = self.text(key) else {
            return Ok(default);
        };
        let found = choices.iter().find(|(name, _)| *name == value);
        found.map(|(_, chosen)| *chosen).ok_or_else(|| {
            let names: Vec<&str> = choices.iter().map(|(name, _)| *name).collect();
            NameError::Choice {
                key,
                value: value.to_owned(),
                choices: names.join(", "),
            }
        })
    }

    /// A length in m; `default` if it is not given.
    pub(crate) fn metres(
        &self,
        key: &'static str,
        range: RangeInclusive<f64>,
        default: f64,
    ) -> Result<f64, NameError> {
        let Some(value) = self.text(key) else {
            return Ok(default);
        };
        let number = quantity(key, "_m", value)?;
        if range.contains(&number) {
            Ok(number)
        } else {
            Err(NameError::Number {
                key,
                value: value.to_owned(),
                least: *range.start(),
                most: *range.end(),
                unit: " m",
            })
        }
    }
}

/// A number in SI, with a unit of those that this end of a key has.
pub(crate) fn quantity(key: &'static str, end: &str, value: &str) -> Result<f64, NameError> {
    parse_for_key(end, value).map_err(|error| NameError::Quantity { key, error })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_a_path_and_settings() {
        let read = |text| Settings::parse("haply", text, &["version", "radius"]);
        let settings = read("/dev/x,radius=20mm,version=2").expect("good");
        assert_eq!(settings.path, "/dev/x");
        assert_eq!(settings.metres("radius", 0.0..=1.0, 1.0), Ok(0.02));
        assert_eq!(read("COM3").expect("good").text("version"), None);
        for (text, message) in [
            (
                "",
                "haply needs the path of a port, as in haply:/dev/ttyACM0",
            ),
            (
                "x,",
                "\"\" is not a setting: write key=value; the keys of haply are version, radius",
            ),
            (
                "x,id=1",
                "\"id=1\" is not a setting: write key=value; the keys of haply are version, radius",
            ),
            ("x,version=2,version=3", "version is given twice"),
            (
                "tcp:host",
                "\"host\" is not HOST:PORT with a port up to 65535: give both, as in 127.0.0.1:4250, or [::1]:4250 for IPv6",
            ),
        ] {
            assert_eq!(read(text).expect_err("bad").to_string(), message);
        }
        for length in ["2cm", "0.02", "0.02 m", "20000um", "20mm"] {
            let metres = Settings {
                path: "x",
                pairs: vec![("radius", length)],
            }
            .metres("radius", 0.0..=1.0, 1.0);
            assert_eq!(metres, Ok(0.02), "{length}");
        }
        let heavy = read("x,radius=2kg").expect("reads");
        let refusal = heavy.metres("radius", 0.0..=1.0, 1.0).expect_err("a mass");
        assert_eq!(
            refusal.to_string(),
            "radius: \"2kg\" is a mass, not a length: give a finite number, with one of the units m, cm, mm, um, µm, nm or none for SI"
        );
        let far = read("x,radius=2m").expect("reads");
        let refusal = far.metres("radius", 0.0..=1.0, 1.0).expect_err("too far");
        assert_eq!(refusal.to_string(), "radius = \"2m\" is not in [0, 1] m");
        let choice = far.choice("radius", &[("1", 1), ("2", 2)], 1);
        assert_eq!(
            choice.expect_err("none").to_string(),
            "radius = \"2m\" is not one of 1, 2"
        );
    }
}
