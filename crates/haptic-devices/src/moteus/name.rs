//! A servo by name, and opening it.

use super::axis::MoteusAxis;
use super::open_error::MoteusOpenError;
use super::settings::MoteusSettings;
use crate::name::{NameError, Settings};
use haptic_remote::serial::{Line, open, ports};
use std::fmt;
use std::path::Path;
use std::time::Duration;

/// Bits per second of a servo on a UART; an adapter on USB has no speed.
const BAUD: u32 = 921_600;
/// USB numbers of the maker's adapters, the old one and the new one. They check what they carry themselves.
const FDCANUSBS: [(u16, u16); 2] = [(0x0483, 0x5740), (0x1209, 0x2323)];

/// A servo by name: `moteus:PATH[,key=value]…`, its keys those of [`MoteusSettings`].
#[derive(Clone, Debug, PartialEq)]
pub struct MoteusName {
    path: String,
    settings: MoteusSettings,
}

impl MoteusName {
    /// First word of the name.
    pub const KIND: &'static str = "moteus";
    /// Form of the name.
    pub const FORM: &'static str =
        "moteus:PATH[,id=1][,radius=20mm][,torque_limit=0.1][,watchdog=100ms][,lost=4]";

    /// A servo at a port.
    #[must_use]
    pub fn new(path: &str, settings: MoteusSettings) -> Self {
        Self {
            path: path.to_owned(),
            settings,
        }
    }

    /// Reads what stands behind `moteus:`.
    ///
    /// # Errors
    /// No path, an unknown key, a value outside its range.
    pub fn parse(text: &str) -> Result<Self, NameError> {
        let keys = ["id", "radius", "torque_limit", "watchdog", "lost"];
        let given = Settings::parse(Self::KIND, text, &keys)?;
        let default = MoteusSettings::DEFAULT;
        let settings = MoteusSettings {
            id: given.whole("id", MoteusSettings::ID, default.id.into())? as u8,
            radius_m: radius_m(&given)?,
            torque_limit_nm: given.number(
                "torque_limit",
                MoteusSettings::TORQUE_LIMIT_NM,
                default.torque_limit_nm,
            )?,
            watchdog_s: given.seconds(
                "watchdog",
                MoteusSettings::WATCHDOG_S,
                default.watchdog_s,
            )?,
            lost_most: given.whole("lost", MoteusSettings::LOST_MOST, default.lost_most)?,
        };
        Ok(Self::new(given.path(), settings))
    }

    /// Opens the port, and the servo behind it.
    ///
    /// # Errors
    /// A port that cannot be opened; a servo that does not answer, or as one that cannot be used.
    pub fn open(&self) -> Result<MoteusAxis<Box<dyn Line>>, MoteusOpenError> {
        let line = open(&self.path, BAUD)?;
        // As the maker's clients: a servo on a UART takes checksums; an adapter may not know them, and is asked.
        let mut axis = MoteusAxis::open(line, self.settings, !is_fdcanusb(&self.path))?;
        let no_wait = axis.stream().set_patience(Duration::ZERO);
        no_wait.map_err(|error| MoteusOpenError::Patience {
            path: self.path.clone(),
            error,
        })?;
        Ok(axis)
    }
}

/// The radius; one next to nothing would make any torque an endless force.
fn radius_m(given: &Settings<'_>) -> Result<f64, NameError> {
    let (range, least) = (MoteusSettings::RADIUS_M, MoteusSettings::RADIUS_LEAST_M);
    let read = given.metres("radius", range.clone(), MoteusSettings::DEFAULT.radius_m);
    match read {
        Ok(radius_m) if radius_m.abs() >= least => Ok(radius_m),
        _ => Err(NameError::Number {
            key: "radius",
            value: given.text("radius").unwrap_or_default().to_owned(),
            least,
            most: *range.end(),
            unit: " m, or the negative of it",
        }),
    }
}

/// True for a port of one of the maker's adapters.
fn is_fdcanusb(path: &str) -> bool {
    // A link such as those of /dev/serial/by-id leads to the port.
    let real = std::fs::canonicalize(path);
    let is_it = |name: &str| {
        real.as_ref()
            .map_or(name == path, |real| Path::new(name) == real)
    };
    let mut known = ports().into_iter().filter(|port| is_it(&port.path));
    known.any(|port| port.usb.is_some_and(|usb| FDCANUSBS.contains(&usb)))
}

impl fmt::Display for MoteusName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let MoteusSettings {
            id,
            radius_m,
            torque_limit_nm,
            watchdog_s,
            lost_most,
        } = self.settings;
        let default = MoteusSettings::DEFAULT;
        write!(f, "{}:{}", Self::KIND, self.path)?;
        if id != default.id {
            write!(f, ",id={id}")?;
        }
        for (key, value, default, unit) in [
            ("radius", radius_m, default.radius_m, "m"),
            ("torque_limit", torque_limit_nm, default.torque_limit_nm, ""),
            ("watchdog", watchdog_s, default.watchdog_s, "s"),
        ] {
            if (value - default).abs() > 0.0 {
                write!(f, ",{key}={value}{unit}")?;
            }
        }
        if lost_most != default.lost_most {
            write!(f, ",lost={lost_most}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_says_port_and_settings() {
        let name = MoteusName::parse("/dev/ttyACM0").expect("good");
        assert_eq!(name.settings, MoteusSettings::DEFAULT);
        assert_eq!(name.to_string(), "moteus:/dev/ttyACM0");
        let text = "/dev/x,id=7,radius=-0.015m,torque_limit=0.5,watchdog=0.05s,lost=9";
        let name = MoteusName::parse(text).expect("good");
        let expected = MoteusSettings {
            id: 7,
            radius_m: -0.015,
            torque_limit_nm: 0.5,
            watchdog_s: 0.05,
            lost_most: 9,
        };
        assert_eq!(name.settings, expected);
        assert_eq!(name.to_string(), format!("moteus:{text}"));
        for bad in [
            "",
            "/dev/x,radius=3m",
            "/dev/x,radius=0",
            "/dev/x,radius=-0.5mm",
            "/dev/x,id=127",
            "/dev/x,id=1.5",
            "/dev/x,servo=1",
        ] {
            MoteusName::parse(bad).expect_err(bad);
        }
    }
}
