//! Device of an experiment: `sim`, `serial:PATH[@BAUD]`, or one of another maker, as `haply:PATH`.

mod failed;

pub(crate) use failed::at_link;
pub use failed::{at_port, lost_board, refused_at_port, trouble};

use crate::document::failure::Failure;
use crate::document::named::Named;
use crate::document::parameters::{DEVICE, TOUCH_AXES};
use haptic_devices::{ForeignName, OpenError};
use haptic_link::{Hello, LoopMode};
use haptic_remote::serial::{ConnectOptions, SerialLink, ports};
use std::fmt;
use std::str::FromStr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Hears what a user should know before a run is over, a sentence each.
pub type Warn<'a> = &'a (dyn Fn(&str) + Sync);

/// A device by name.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum DeviceName {
    /// `sim`: simulated in this program.
    #[default]
    Simulated,
    /// At a port.
    Linked(LinkedName),
}

/// A device at a port by name: one to connect to.
#[derive(Clone, Debug, PartialEq)]
pub enum LinkedName {
    /// `serial:PATH[@BAUD]`: it speaks the protocol of this program.
    Serial(SerialName),
    /// Of another maker: this program serves it.
    Foreign(ForeignName),
}

/// A serial device by name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SerialName {
    /// The port; `auto` for the only one at which a device answers.
    pub path: String,
    /// Bits per second; `None` tries the speeds that boards have.
    pub baud: Option<u32>,
}

impl FromStr for DeviceName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "sim" {
            return Ok(Self::Simulated);
        }
        if ForeignName::is_kind(text) {
            let name = text
                .parse::<ForeignName>()
                .map_err(|error| error.to_string())?;
            return Ok(Self::Linked(LinkedName::Foreign(name)));
        }
        let named = text.strip_prefix("serial:").filter(|name| !name.is_empty());
        let Some(name) = named else {
            let foreign = ForeignName::KINDS.iter().map(|(_, form)| *form);
            let foreign: Vec<&str> = foreign.collect();
            return Err(format!(
                "device \"{text}\" is not one of sim, serial:PATH[@BAUD], serial:auto, {}",
                foreign.join(", ")
            ));
        };
        let (path, baud) = match name.rsplit_once('@') {
            Some((path, baud)) => {
                let parsed = baud
                    .parse()
                    .ok()
                    .filter(|baud| (1200..=12_000_000).contains(baud));
                let baud = parsed.ok_or_else(|| {
                    format!("\"{baud}\" is not a number of baud from 1200 to 12000000")
                })?;
                (path, Some(baud))
            }
            None => (name, None),
        };
        Ok(Self::Linked(LinkedName::Serial(SerialName {
            path: path.to_owned(),
            baud,
        })))
    }
}

impl fmt::Display for DeviceName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Simulated => f.write_str("sim"),
            Self::Linked(name) => name.fmt(f),
        }
    }
}

impl fmt::Display for LinkedName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Serial(name) => name.fmt(f),
            Self::Foreign(name) => name.fmt(f),
        }
    }
}

impl LinkedName {
    /// Connects, and tells `warn` what is worth saying about the port. A set `stop` ends the waiting.
    ///
    /// # Errors
    /// Exit code 3: no port, no device, no answer.
    pub fn connect(
        &self,
        patience: Duration,
        warn: Warn<'_>,
        stop: Option<&AtomicBool>,
    ) -> Result<SerialLink, Failure> {
        self.open(1, warn, (patience, stop))
    }

    /// The same for an experiment of so many axes.
    ///
    /// # Errors
    /// As [`connect`](Self::connect); a device with another number of axes.
    pub fn connect_with(
        &self,
        axes: usize,
        patience: Duration,
        warn: Warn<'_>,
        stop: Option<&AtomicBool>,
    ) -> Result<SerialLink, Failure> {
        let link = self.open(axes, warn, (patience, stop))?;
        let has = usize::from(link.capabilities().axes);
        match (has, axes) {
            _ if has == axes => Ok(link),
            (_, 1) => Err(Failure::bad_input(format_args!(
                "{self} has {has} axes, and this needs one: with several only a [touch] with {} runs so far; name another {DEVICE}",
                TOUCH_AXES.set_to(has)
            ))),
            _ => Err(Failure::bad_input(format_args!(
                "{self} has {} and the [touch] has {axes}: change {TOUCH_AXES}, or name another {DEVICE}{}",
                if has == 1 {
                    "one axis".to_owned()
                } else {
                    format!("{has} axes")
                },
                if has == 1 {
                    "; with one axis take [wall] or [relax]"
                } else {
                    ""
                },
            ))),
        }
    }

    /// Connects; a device of another maker is made for so many axes.
    fn open(
        &self,
        axes: usize,
        warn: Warn<'_>,
        (patience, stop): (Duration, Option<&AtomicBool>),
    ) -> Result<SerialLink, Failure> {
        match self {
            Self::Serial(name) => {
                let options = ConnectOptions {
                    baud: name.baud,
                    patience,
                    stop,
                };
                name.connect(options, warn)
            }
            Self::Foreign(name) => open(name, axes, patience, stop),
        }
    }
}

/// Opens a device of another maker. Tries again while its port is not there or somebody else has it.
fn open(
    name: &ForeignName,
    axes: usize,
    patience: Duration,
    stop: Option<&AtomicBool>,
) -> Result<SerialLink, Failure> {
    /// Between two attempts.
    const PAUSE: Duration = Duration::from_millis(250);
    let began = Instant::now();
    let told = |error: &OpenError| {
        let told = anyhow::anyhow!("{name}: {error}");
        match error.is_of_the_request() {
            true => Failure::Input(told),
            false => Failure::Device(told),
        }
    };
    loop {
        let error = match name.open_with(axes) {
            Ok(link) => return Ok(link),
            Err(error) => error,
        };
        if !error.may_pass() || began.elapsed() + PAUSE > patience {
            return Err(told(&error));
        }
        std::thread::sleep(PAUSE);
        if stop.is_some_and(|stop| stop.load(Ordering::Relaxed)) {
            return Err(Failure::Run(anyhow::anyhow!(
                "interrupted: {name} was waited for in vain ({error})"
            )));
        }
    }
}

impl fmt::Display for SerialName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "serial:{}", self.path)?;
        self.baud.map_or(Ok(()), |baud| write!(f, "@{baud}"))
    }
}

impl SerialName {
    fn connect(&self, options: ConnectOptions<'_>, warn: Warn<'_>) -> Result<SerialLink, Failure> {
        let link = if self.path == "auto" {
            self.find()?
        } else {
            SerialLink::connect(&self.path, options).map_err(|error| {
                if (options.stop).is_some_and(|stop| stop.load(Ordering::Relaxed)) {
                    return Failure::Run(anyhow::anyhow!(
                        "interrupted: {} was waited for in vain ({error})",
                        self.path
                    ));
                }
                at_port(&self.path, &error)
            })?
        };
        if let Some(latency_ms) = link.latency_ms().filter(|ms| *ms > 1) {
            warn(&format!(
                "the adapter at {} holds bytes back for {latency_ms} ms, too long for a loop at 1 kHz: as root, \
                 echo 1 > /sys/bus/usb-serial/devices/{}/latency_timer",
                link.path(),
                link.path().rsplit('/').next().unwrap_or_default()
            ));
        }
        Ok(link)
    }

    /// The only port at which a device answers.
    fn find(&self) -> Result<SerialLink, Failure> {
        let options = ConnectOptions {
            baud: self.baud,
            ..ConnectOptions::default()
        };
        let ports = ports();
        let mut found = Vec::new();
        for port in &ports {
            if let Ok(link) = SerialLink::connect(&port.path, options) {
                found.push(link);
            }
        }
        let names: Vec<&str> = found.iter().map(SerialLink::path).collect();
        match names.as_slice() {
            [] => Err(Failure::Device(anyhow::anyhow!(
                "no device answers at any of the {} serial ports: is it plugged in and flashed? An emulated \
                 one is not found this way, give its path",
                ports.len()
            ))),
            [_] => found
                .pop()
                .ok_or_else(|| Failure::Device(anyhow::anyhow!("the device is gone"))),
            several => Err(Failure::bad_input(format_args!(
                "devices answer at {}: name one with {}",
                several.join(", "),
                DEVICE.set_to("serial:PATH")
            ))),
        }
    }
}

/// The version of a device's firmware, as a person writes it.
#[must_use]
pub fn firmware_version(hello: &Hello) -> String {
    let [major, minor, patch] = hello.firmware;
    format!("{major}.{minor}.{patch}")
}

/// Place where the loop is closed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Loop {
    /// On the device; this program sets parameters and records.
    #[default]
    Device,
    /// Here; the device reports its position and applies the force it is sent.
    Host,
}

impl Named for Loop {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (
            Self::Device,
            "device",
            "On the device; this program sets parameters and records",
        ),
        (
            Self::Host,
            "host",
            "On this computer; the device reports positions and applies forces",
        ),
    ];
}

impl From<Loop> for LoopMode {
    fn from(chosen: Loop) -> Self {
        match chosen {
            Loop::Device => Self::Device,
            Loop::Host => Self::Host,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_says_port_and_speed() {
        let serial = |path: &str, baud| {
            Ok(DeviceName::Linked(LinkedName::Serial(SerialName {
                path: path.to_owned(),
                baud,
            })))
        };
        assert_eq!("sim".parse(), Ok(DeviceName::Simulated));
        assert_eq!("serial:/dev/ttyACM0".parse(), serial("/dev/ttyACM0", None));
        assert_eq!("serial:COM3@115200".parse(), serial("COM3", Some(115_200)));
        assert_eq!(
            "serial:/dev/ttyACM0@3000000".parse(),
            serial("/dev/ttyACM0", Some(3_000_000))
        );
        for name in [
            "sim",
            "serial:/dev/pts/1",
            "serial:/dev/pts/1@115200",
            "haply:/dev/ttyACM0",
            "haply:COM3,version=2,axis=-x,zero=10mm,home=before",
        ] {
            let parsed: DeviceName = name.parse().expect("valid");
            assert_eq!(parsed.to_string(), name);
        }
        for bad in [
            "",
            "serial",
            "serial:",
            "usb:1",
            "serial:/dev/x@fast",
            "serial:/dev/x@1",
            "haply",
            "haply:",
            "haply:/dev/x,version=4",
            "haply:/dev/x,colour=red",
        ] {
            assert!(bad.parse::<DeviceName>().is_err(), "{bad}");
        }
    }
}
