//! Device of an experiment: `sim`, `serial:PATH[@BAUD]`, `tcp:HOST:PORT`, or one of another maker, as `haply:PATH`.

use crate::{
    identity::{DeviceIdentity, Told},
    remembered::{Remembered, loosened},
};
use haptic_devices::ForeignName;
use haptic_document::{
    Failure, Warn, bad_input,
    parameters::{DEVICE, SAMPLE_TIME, TOUCH_AXES},
};
use haptic_link::{Capabilities, Configuration, Field, Hello, Refusal};
use haptic_loop::{Fault, realtime::Moment};
use haptic_remote::{
    LinkError,
    serial::{
        BoardTrouble, ConnectOptions, PortInfo, SerialError, SerialLink, TroubleCause,
        host_and_port, latency_file, port_of, ports, tcp_address,
    },
};
use haptic_trial::ending::LetGo;
use std::{
    fmt,
    str::FromStr,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::Duration,
};

/// A device by name.
///
/// `sim` is simulated in this program: no port.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DeviceName(pub Option<LinkedName>);

/// A device at a port by name: one to connect to.
#[derive(Clone, Debug, PartialEq)]
pub enum LinkedName {
    /// `serial:PATH[@BAUD]`, `serial:usb:NUMBER` or `tcp:HOST:PORT`: it speaks the protocol of this program.
    Serial(SerialName),
    /// Device of another maker: this program serves it.
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
            return Ok(Self(None));
        }
        if ForeignName::is_kind(text) {
            let name = text
                .parse::<ForeignName>()
                .map_err(|error| error.to_string())?;
            return Ok(Self(Some(LinkedName::Foreign(name))));
        }
        let named = text.strip_prefix("serial:").filter(|name| !name.is_empty());
        if let Some(address) = tcp_address(text).or_else(|| tcp_address(named?)) {
            host_and_port(address).map_err(|error| error.to_string())?;
            return Ok(Self(Some(LinkedName::Serial(SerialName {
                path: format!("tcp:{address}"),
                baud: None,
            }))));
        }
        let Some(name) = named else {
            // A port as the system calls it.
            let is_port = |start: &&str| text.starts_with(*start);
            if ["/dev/", "COM", "tty"].iter().any(is_port) {
                return Err(format!("device \"{text}\" is a port: write serial:{text}"));
            }
            let foreign = ForeignName::KINDS.iter().map(|(_, form)| *form);
            let foreign: Vec<&str> = foreign.collect();
            return Err(format!(
                "device \"{text}\" is not one of sim, serial:PATH[@BAUD], serial:auto, tcp:HOST:PORT, {}",
                foreign.join(", ")
            ));
        };
        let (path, baud) = match name.rsplit_once('@') {
            Some((path, baud)) => {
                let speed = baud.parse().ok();
                let speed = speed.filter(|speed| (1200..=12_000_000).contains(speed));
                let none = || format!("\"{baud}\" is not a number of baud from 1200 to 12000000");
                (path, Some(speed.ok_or_else(none)?))
            }
            None => (name, None),
        };
        let path = path.to_owned();
        Ok(Self(Some(LinkedName::Serial(SerialName { path, baud }))))
    }
}

impl fmt::Display for DeviceName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            None => f.write_str("sim"),
            Some(name) => name.fmt(f),
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

impl DeviceName {
    /// Identity of the connected device.
    ///
    /// # Errors
    /// The simulated device, which has none.
    pub fn identity(&self, link: &SerialLink) -> Result<DeviceIdentity, Failure> {
        Ok(self.at_port()?.identity(link))
    }

    /// The limits that `device set` gave the connected device from this computer.
    ///
    /// # Errors
    /// The simulated device, which has none.
    pub fn remembered(&self, link: &SerialLink) -> Result<Remembered, Failure> {
        Ok(self.at_port()?.remembered(link))
    }

    fn at_port(&self) -> Result<&LinkedName, Failure> {
        self.0.as_ref().ok_or_else(|| {
            bad_input!(
                "device \"sim\" has no port: give {}, such as that of an emulated device",
                DEVICE.set_to("serial:PATH")
            )
        })
    }

    /// Connects to a device for all of its axes: a board reports their number, and one of another maker is opened with `axes`, by
    /// default with one. It gets the limits back that it has [forgotten](Remembered).
    ///
    /// # Errors
    /// As [`connect`](Self::connect); a device that has not the axes that were asked for.
    pub fn connect_all(
        &self,
        axes: Option<usize>,
        patience: Duration,
        warn: Warn<'_>,
        stop: Option<&Arc<AtomicBool>>,
    ) -> Result<SerialLink, Failure> {
        (self.at_port()?).connect_all(axes, patience, warn, stop)
    }

    /// Connects to a device with this many axes, or with any number, and passes warnings about the
    /// port to `warn`. With a number of axes the device is to be armed: it gets the limits back that it has
    /// [forgotten](Remembered). Setting `stop` ends the wait.
    ///
    /// # Errors
    /// The simulated device, or one with another number of axes; exit code 3: no port, no device, no answer.
    pub fn connect(
        &self,
        axes: Option<usize>,
        patience: Duration,
        warn: Warn<'_>,
        stop: Option<&Arc<AtomicBool>>,
    ) -> Result<SerialLink, Failure> {
        let name = self.at_port()?;
        match axes {
            Some(axes) => name.connect_with(axes, patience, warn, stop),
            None => name.open(1, warn, patience, stop),
        }
    }
}

impl LinkedName {
    /// True if both may be at one port, through whatever links: of which `auto` is any.
    pub fn may_be(&self, other: &Self) -> bool {
        let ports = [self.port(), other.port()];
        let [here, there] =
            (ports.each_ref()).map(|port| port_of(port).unwrap_or_else(|_| port.clone()));
        here == there || ports.iter().any(|port| port == "auto")
    }

    pub(crate) fn port(&self) -> String {
        match self {
            Self::Serial(name) => name.path.clone(),
            // KIND:PATH,KEY=VALUE
            Self::Foreign(name) => {
                let name = name.to_string();
                let path = name.split(',').next().and_then(|name| name.split_once(':'));
                path.map_or_else(String::new, |(_, path)| path.to_owned())
            }
        }
    }

    /// File of limits of the device at the other end of this link.
    pub fn remembered(&self, link: &SerialLink) -> Remembered {
        Remembered::of(self.identity(link))
    }

    /// Sets anew what the device has forgotten.
    fn restore(&self, link: &mut SerialLink, warn: Warn<'_>) -> Result<(), Failure> {
        let remembered = self.remembered(link);
        let problem = |error| at_port(link.path(), &error);
        let (present, values) = link.configuration().map_err(problem)?;
        let Some(limits) = remembered.tightened(&present)? else {
            return Ok(());
        };
        let device = remembered.identity();
        let lost = loosened(&limits, &present.limits).join(", ");
        link.set(Configuration { limits, ..present }, &values).map_err(|error| {
                Failure::device(format_args!(
                    "{device} does not take the limits again that were set on it ({error}): set others with host-cli device set, or \
                     end them with host-cli device forget"
                ))
            })?;
        warn(&remembered.words(&lost)?);
        Ok(())
    }

    /// Identity of the device that is connected by this name.
    pub fn identity(&self, link: &SerialLink) -> DeviceIdentity {
        let path = match self {
            Self::Serial(_) => link.path().to_owned(),
            Self::Foreign(_) => self.port(),
        };
        let told = Told {
            board: link.capabilities().board(),
            number: link.hello().serial_number(),
            simulated: link.capabilities().simulated,
            path: &path,
            shares_port: matches!(self, Self::Foreign(foreign) if foreign.shares_port()),
        };
        DeviceIdentity::of(told, &ports())
    }

    /// Connects for an experiment of `axes` axes, within the limits that were set on the device though it has forgotten them.
    ///
    /// # Errors
    /// If it does not answer, has another number of axes, or another program holds it.
    pub fn connect_with(
        &self,
        axes: usize,
        patience: Duration,
        warn: Warn<'_>,
        stop: Option<&Arc<AtomicBool>>,
    ) -> Result<SerialLink, Failure> {
        let mut link = self.open(axes, warn, patience, stop)?;
        let has = usize::from(link.capabilities().axes);
        match (has, axes) {
            _ if has == axes => {
                self.restore(&mut link, warn)?;
                Ok(link)
            }
            (_, 1) => Err(bad_input!(
                "{self} has {has} axes, but this experiment needs one: so far only a [touch] with {} runs on several; name another {DEVICE}",
                TOUCH_AXES.set_to(has)
            )),
            (1, _) => Err(bad_input!(
                "{self} has one axis and the [touch] has {axes}: name another {DEVICE}, or use [wall] or [relax]"
            )),
            _ => Err(bad_input!(
                "{self} has {has} axes and the [touch] has {axes}: change {TOUCH_AXES}, or name another {DEVICE}"
            )),
        }
    }

    /// Connects to all axes, as [`DeviceName::connect_all`] does.
    ///
    /// # Errors
    /// As [`connect_with`](Self::connect_with).
    pub fn connect_all(
        &self,
        axes: Option<usize>,
        patience: Duration,
        warn: Warn<'_>,
        stop: Option<&Arc<AtomicBool>>,
    ) -> Result<SerialLink, Failure> {
        let mut link = self.open(axes.unwrap_or(1), warn, patience, stop)?;
        let has = usize::from(link.capabilities().axes);
        match axes.filter(|axes| *axes != has) {
            None => {
                self.restore(&mut link, warn)?;
                Ok(link)
            }
            Some(axes) => Err(bad_input!(
                "`axes` = {axes}, but {self} has {has}: omit it, or name another {DEVICE}"
            )),
        }
    }

    /// Connects, not to be armed; a device of another maker is made for `axes` axes.
    fn open(
        &self,
        axes: usize,
        warn: Warn<'_>,
        patience: Duration,
        stop: Option<&Arc<AtomicBool>>,
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
            Self::Foreign(name) => open(name, axes, warn, patience, stop),
        }
    }
}

/// Opens a device of another maker. Tries again while its port is not there or somebody else has it.
fn open(
    name: &ForeignName,
    axes: usize,
    warn: Warn<'_>,
    patience: Duration,
    stop: Option<&Arc<AtomicBool>>,
) -> Result<SerialLink, Failure> {
    const PAUSE: Duration = Duration::from_millis(250);
    let began = Moment::now();
    loop {
        let error = match name.open_with(axes, warn, stop) {
            Ok(link) => return Ok(link),
            Err(error) if is_set(stop) => return Err(interrupted(name, &error)),
            Err(error) => error,
        };
        if !error.may_pass() || began.elapsed() + PAUSE > patience {
            let reason = format!("{name}: {error}");
            return Err(if error.is_of_the_request() {
                Failure::bad_input(reason)
            } else {
                Failure::device(reason)
            });
        }
        std::thread::sleep(PAUSE);
    }
}

fn is_set(stop: Option<&Arc<AtomicBool>>) -> bool {
    stop.is_some_and(|stop| stop.load(Ordering::Relaxed))
}

/// Somebody stopped the waiting for a device.
fn interrupted(name: &dyn fmt::Display, error: &dyn fmt::Display) -> Failure {
    Failure::run(format_args!(
        "interrupted while waiting for {name} ({error})"
    ))
}

impl fmt::Display for SerialName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if tcp_address(&self.path).is_none() {
            f.write_str("serial:")?;
        }
        f.write_str(&self.path)?;
        self.baud.map_or(Ok(()), |baud| write!(f, "@{baud}"))
    }
}

impl SerialName {
    fn connect(&self, options: ConnectOptions<'_>, warn: Warn<'_>) -> Result<SerialLink, Failure> {
        let link = if self.path == "auto" {
            self.find(options, warn)?
        } else {
            let link = SerialLink::connect(&self.path, options);
            link.map_err(|error| {
                if is_set(options.stop) {
                    interrupted(&self.path, &error)
                } else {
                    at_port(&self.path, &error)
                }
            })?
        };
        if let Some(latency_ms) = link.latency_ms().filter(|ms| *ms > 1) {
            warn(&format!(
                "the adapter at {} holds bytes back for {latency_ms} ms, too long for a loop at 1 kHz: as root, echo 1 > {}",
                link.path(),
                latency_file(link.path()).unwrap_or_default()
            ));
        }
        Ok(link)
    }

    /// The only port at which a device answers.
    fn find(&self, options: ConnectOptions<'_>, warn: Warn<'_>) -> Result<SerialLink, Failure> {
        let options = ConnectOptions {
            patience: Duration::ZERO,
            ..options
        };
        let ports = ports();
        let connected = |port: &PortInfo| SerialLink::connect(&port.path, options).ok();
        let mut found = answering(&ports, connected, warn);
        if is_set(options.stop) {
            return Err(interrupted(&"serial:auto", &LinkError::Stopped));
        }
        match (found.pop(), found.as_slice()) {
            (Some(link), []) => Ok(link),
            (None, _) => Err(Failure::device(format_args!(
                "no device answers at any of the {} serial ports: plug it in and flash it, or give its path",
                ports.len()
            ))),
            (Some(last), others) => {
                let names = others.iter().chain([&last]).map(SerialLink::path);
                Err(bad_input!(
                    "devices answer at {}: name one with {}",
                    names.collect::<Vec<_>>().join(", "),
                    DEVICE.set_to("serial:PATH")
                ))
            }
        }
    }
}

/// Answers at the ports with USB numbers of boards; else those at the others, which a warning names before they are opened.
fn answering<L>(
    ports: &[PortInfo],
    connected: impl Fn(&PortInfo) -> Option<L>,
    warn: Warn<'_>,
) -> Vec<L> {
    let (boards, others): (Vec<&PortInfo>, Vec<&PortInfo>) =
        ports.iter().partition(|port| port.is_of_a_board());
    let found: Vec<L> = boards.into_iter().filter_map(&connected).collect();
    if !found.is_empty() || others.is_empty() {
        return found;
    }
    let paths: Vec<&str> = others.iter().map(|port| port.path.as_str()).collect();
    warn(&format!(
        "no device answers at a port with the USB number of a board: now the others are opened, which resets an Arduino and speaks to a \
         modem ({}); {} opens one alone",
        paths.join(", "),
        DEVICE.set_to("serial:PATH")
    ));
    others.into_iter().filter_map(connected).collect()
}

/// The version of a device's firmware, as a person writes it.
#[must_use]
pub fn firmware_version(hello: &Hello) -> String {
    let [major, minor, patch] = hello.firmware;
    format!("{major}.{minor}.{patch}")
}

/// The digest of the image that a device runs, as a person writes it; absent for a device that does
/// not report it.
#[must_use]
pub fn firmware_digest(abilities: &Capabilities) -> Option<String> {
    (abilities.image_digest != 0).then(|| format!("{:08x}", abilities.image_digest))
}

/// A serial device that cannot be used, with its port: exit code 3. A fault that latched on it has ended a run: exit code 1.
#[must_use]
pub fn at_port(path: &str, error: &SerialError) -> Failure {
    let text = error.to_string();
    let error_at = if text.contains(path) {
        text
    } else {
        format!("{path}: {text}")
    };
    if let SerialError::Link(LinkError::Faulted(_) | LinkError::Impossible(_)) = error {
        return Failure::run(error_at);
    }
    Failure::device(error_at)
}

/// A refusal by the device is bad input, unless only its position or a persistent fault causes it; any other error is as in [`at_port`].
#[must_use]
pub fn refused_at_port(path: &str, error: SerialError) -> Failure {
    if !error.is_refusal() || error.is_of_its_state() {
        return at_port(path, &error);
    }
    let SerialError::Link(LinkError::Refused { refusal, .. }) = &error else {
        return Failure::bad_input(error);
    };
    if let Refusal::Range { field, .. } | Refusal::Unsupported(field) = refusal
        && *field == Field::TickPeriod
    {
        return Failure::input_with_advice(error, format_args!("change {SAMPLE_TIME}"));
    }
    Failure::bad_input(error)
}

/// The failure of a device that was connected. Where nothing comes from its board any more, that is what failed, whatever latched or was
/// refused after it: exit code 3.
pub fn at_link(link: &SerialLink, failure: Failure) -> Failure {
    match lost_board(link) {
        Some(words) => Failure::device(format_args!("{}: {words}", link.path())),
        None => failure,
    }
}

/// The message for a board that has fallen silent, with the danger that remains.
#[must_use]
pub fn lost_board(link: &SerialLink) -> Option<String> {
    link.lost_board().map(|words| feared(&words))
}

/// Words of a board, or of a program that is a device, about the last fault; for a board that failed, with the danger that remains.
#[must_use]
pub fn trouble(link: &SerialLink) -> Option<String> {
    let Some(BoardTrouble { words, cause }) = link.trouble() else {
        return (link.status().reason.some()).map(|reason| reason.to_string());
    };
    // A fault that nobody has heard of yet is no fault of the status.
    let failed = link.status().fault == Fault::BoardFailed.code() || cause == TroubleCause::Gone;
    Some(if failed { feared(&words) } else { words })
}

fn feared(words: &str) -> String {
    format!("{words}; {}", LetGo::Commanded.words())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stop_ends_whatever_a_device_is_opened_by() {
        let stop = Arc::new(AtomicBool::new(true));
        // Nobody answers there, for longer than anybody waits.
        let listener = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("an address");
        for name in [
            "serial:auto".to_owned(),
            format!("tcp:{address}"),
            format!("haply:tcp:{address}"),
            format!("moteus:tcp:{address}"),
            format!("inverse3:{address}"),
        ] {
            let device: DeviceName = name.parse().expect("a name");
            let ended = device.connect(Some(1), Duration::from_secs(600), &|_| {}, Some(&stop));
            let error = ended.expect_err("stopped").to_string();
            assert!(
                error.starts_with("interrupted while waiting for"),
                "{name}: {error}"
            );
        }
    }

    #[test]
    fn a_name_says_port_and_speed() {
        let serial = |path: &str, baud| {
            Ok(DeviceName(Some(LinkedName::Serial(SerialName {
                path: path.to_owned(),
                baud,
            }))))
        };
        assert_eq!("sim".parse(), Ok(DeviceName(None)));
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
            "serial:usb:A50285BI",
            "tcp:127.0.0.1:4250",
            "tcp:[::1]:4250",
            "haply:tcp:board.local:4250,version=2",
            "moteus:tcp:127.0.0.1:4250",
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
            "tcp:",
            "tcp:4250",
            "tcp:host:port",
            "tcp:host:4250@115200",
            "tcp:::1:4250",
            "serial:tcp:host",
            "haply:tcp:host",
            "moteus:tcp:host:99999,id=2",
            "haply:/dev/x,colour=red",
        ] {
            assert!(bad.parse::<DeviceName>().is_err(), "{bad}");
        }
    }

    #[test]
    fn a_port_of_a_stranger_is_opened_only_if_no_board_answers_and_not_without_a_word() {
        use std::sync::Mutex;
        let port = |path: &str, usb| PortInfo {
            path: path.to_owned(),
            description: String::new(),
            usb,
            serial_number: None,
            latency_ms: None,
        };
        let ports = [
            port("arduino", Some((0x2341, 0x0043))),
            port("pico", Some((0x1209, 0x0001))),
            port("built-in", None),
            port("nucleo", Some((0x0483, 0x374b))),
        ];
        for (answers, expected) in [
            ("pico", "pico nucleo"),
            (
                "arduino",
                "pico nucleo (arduino, built-in) arduino built-in",
            ),
        ] {
            let heard = Mutex::new(Vec::new());
            let hear = |words: &str| heard.lock().expect("whole").push(words.to_owned());
            let connected = |port: &PortInfo| {
                hear(&port.path);
                (port.path == answers).then(|| port.path.clone())
            };
            let warn = |text: &str| {
                let (_, paths) = text.split_once("modem ").expect("says why");
                hear(paths.split_once(';').expect("and what else").0);
            };
            assert_eq!(answering(&ports, connected, &warn), [answers]);
            assert_eq!(heard.into_inner().expect("whole").join(" "), expected);
        }
    }

    #[test]
    fn a_fault_ends_a_run_and_a_silent_port_is_not_usable() {
        let report = crate::remote::bad_line_tests::reported(haptic_loop::Fault::BoardFailed);
        let failure = |error: LinkError| at_port("/dev/x", &error.into());
        let faulted = failure(LinkError::Faulted(report));
        assert!(matches!(faulted, Failure::Run(_)));
        assert!(faulted.to_string().starts_with("/dev/x: "), "{faulted}");
        assert!(matches!(failure(LinkError::Gone), Failure::Device(_)));
    }

    #[test]
    fn a_device_that_stands_in_the_wall_is_no_bad_input() {
        let failure = |refusal| {
            let request = "start";
            let error = LinkError::Refused { request, refusal };
            refused_at_port("/dev/x", error.into())
        };
        let too_deep = Refusal::ForceNotSmall {
            wanted_n: 5.0,
            allowed_n: 1.0,
        };
        let persists = Refusal::FaultPersists(4);
        assert!(matches!(failure(too_deep), Failure::Device(_)));
        assert!(matches!(failure(persists), Failure::Device(_)));
        assert!(matches!(failure(Refusal::Incomplete), Failure::Input(_)));
    }
}
