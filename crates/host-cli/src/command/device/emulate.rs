//! `device emulate`.

mod inverse3;
mod robot;
mod specimen;

use super::key_value::{count, in_range, key_and_value, keys_help, refused};
use crate::command::conduct::stop_on_interrupt;
use crate::options::DeviceModelArguments;
use crate::output::{Output, note, warn};
use crate::parse::{WAITS, choice, quantity, whole};
use clap::Args;
use haptic_devices::haply::{HaplyModel, HaplyName, Version};
use haptic_devices::inverse3::Inverse3Name;
use haptic_devices::moteus::{MoteusName, MoteusSettings};
use haptic_document::short;
use haptic_emulator::board::{
    self, AtHandle, BoardPort, Body, Emulated, EmulatedRobot, Emulation, EmulatorError, HandScript,
    PortKind,
};
use haptic_emulator::{DuplexDamage, LineFaults, emulate, haply, moteus};
use haptic_experiment::parameters::{self, Range};
use haptic_experiment::{Failure, named};
use haptic_loop::plant::{FacingContact, ForceSensor, ForceSensorConfig};
use haptic_loop::units::{Metres, Newtons, Seconds};
use haptic_quantity::{is_meant, without_unit};
use haptic_remote::serial::tcp_address;
use haptic_trial::DeviceModel;
use serde_json::json;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Seconds of an emulated device in a second.
const SPEED_UPS: Range = Range::Within(1e-3, 1e3);

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Kind {
    /// The device of this program.
    #[default]
    Own,
    /// The board of a Haply 2DIY.
    Haply2Diy,
    Moteus,
    Inverse3,
}

named! { Kind:
    Own = "own", "The device of this program";
    Haply2Diy = "haply-2diy", "The board of a Haply 2DIY";
    Moteus = "moteus", "A moteus servo behind an fdcanusb";
    Inverse3 = "inverse3", "The service of a Haply Inverse3";
}

impl Kind {
    /// Before the path in the name of such a device.
    const fn scheme(self) -> &'static str {
        match self {
            Self::Own => "serial",
            Self::Haply2Diy => HaplyName::KIND,
            Self::Moteus => MoteusName::KIND,
            Self::Inverse3 => Inverse3Name::KIND,
        }
    }
}

/// Emulate a device behind a pseudo-terminal
///
/// The emulated device is the firmware's state machine with a simulated plant. The command prints
/// the path of the terminal; any other command can use that with --device serial:PATH. With --listen it is at a TCP address instead, for
/// --device tcp:HOST:PORT; only programs of this machine reach it unless another address is given. With
/// --device-model the plant has the mass, damping, friction, delay, lag and sensors of that file,
/// to rehearse a run; otherwise it is an ideal mass, with the values that the run states.
///
/// Keys make the line bad: it loses, damages, repeats, reorders, delays or stalls frames, in the
/// same way for the same `line_seed`.
///
/// With `specimen` a piece of tissue hangs at the handle, to be measured with press: a physical force, integrated apart from every law of
/// this program. It begins where the handle does, and each run finds it unpressed. A run that brings a hand or an indenter has that instead.
///
/// With `hand=press:3mm/2s,withdraw` a hand holds it from the start of a run on, to rehearse an experiment with people: it goes 3 mm behind
/// 0 for 2 s, 5 mm in front of it for 1 s, and so on. Each step has LENGTH/TIME or without; a spring of 300 N/m is between hand and handle.
///
/// With the file of a robot, one with [admittance], it moves, in the largest hand of that file, which a run pushes; `sample_time` is its
/// own. With measured=false its program does not know its bandwidth and dead time, and device measure finds them.
///
/// With `sensed_range` the board has a force sensor too, which shows the force of the hand or of the other board on it, and its log
/// `sensed_force_n`.
///
/// --facing adds a second board whose mass meets that of the first, to rehearse a run with two devices. The first renders: its position is
/// the depth of the indentation, and its force is below 0 where it resists. The second pushes along its own positive axis into it. Both
/// axes point the same way, and they touch where the second has gone the gap further. Each has its own sample time, both one clock; a run
/// begins with both masses at 0 unless the other board makes a force. facing_ before a key of the line or of a force sensor is that of the
/// second board.
///
/// --kind haply-2diy is the board of a Haply 2DIY, --kind moteus a servo behind a CAN adapter; both
/// also work with the makers' own programs. They run in real time, and drop and corrupt then apply
/// to single bytes.
///
/// --kind inverse3 is the Inverse Service with one device behind it, at a TCP port of this machine.
/// It works with the maker's own programs too.
#[derive(Debug, Args)]
#[command(
    after_help = format!("Examples:\n  host-cli device emulate --link device\n  host-cli relax --device \
                  serial:device --duration 20s\n  host-cli device emulate --kind haply-2diy --link 2diy\n  \
                  host-cli relax --device haply:2diy --duration 20s\n  \
                  host-cli device emulate --link blue --facing white gap=1mm facing_drop=1%\n  \
                  host-cli device emulate --link bench specimen=fish-muscle area=2cm2 sensed_range=20N\n\nKeys:{}",
                  keys_help(all_keys()))
)]
pub(crate) struct Arguments {
    /// Device to emulate [default: own]
    #[arg(long, value_parser = choice::<Kind>())]
    kind: Option<Kind>,
    /// Symbolic link to the pseudo-terminal
    #[arg(long, value_name = "PATH")]
    link: Option<PathBuf>,
    /// TCP address instead of a pseudo-terminal, which may be late on a busy machine; port 0 takes a free one [default on Windows:
    /// 127.0.0.1:4250]
    #[arg(long, value_name = "HOST:PORT", conflicts_with = "link")]
    listen: Option<PathBuf>,
    /// A second board, whose mass meets that of the first, at a path or address of the same kind
    #[arg(long, value_name = "PATH")]
    facing: Option<PathBuf>,
    /// Axes; 2 or 3 for a [touch], with a hand that pushes along the first
    #[arg(long, value_parser = whole::<u8>(1..=3))]
    axes: Option<u8>,
    #[command(flatten)]
    model: DeviceModelArguments,
    /// Device seconds per second; the watchdog stays in real time
    #[arg(long, value_parser = quantity("", SPEED_UPS), default_value_t = 1.0)]
    speed: f64,
    /// Stop after this time [default: run until Ctrl-C]
    #[arg(long, value_name = "TIME", value_parser = quantity("_s", WAITS))]
    duration: Option<f64>,
    /// The line and the hand, as in drop=1%; the keys are below
    #[arg(value_name = "KEY=VALUE")]
    values: Vec<String>,
}

/// Keys of a line, of the first board or, with facing_ before it, of the second.
const LINE_KEYS: [(&str, &str); 8] = [
    ("drop", "Chance of a lost frame, as 1%"),
    ("corrupt", "Chance of flipped bits in a frame"),
    ("duplicate", "Chance of a repeated frame"),
    ("reorder", "Chance that a frame arrives after the next one"),
    ("delay_s", "Longest delay of a frame"),
    ("stall", "Chance that the line stalls at a frame"),
    ("stall_time_s", "Length of a stall [default: 50ms]"),
    ("line_seed", "Seed of these faults [default: 1]"),
];

/// Keys of the motor of the first board.
const MOTOR_KEYS: [(&str, &str); 1] = [(
    "motor_gain",
    "Force for each newton commanded, below 0 with its leads swapped [default: 1]",
)];

/// Keys of a force sensor, of the first board or, with facing_ before it, of the second.
const SENSOR_KEYS: [(&str, &str); 5] = {
    let [range, noise, lag, offset, seed] = [
        parameters::SENSED_RANGE,
        parameters::SENSED_NOISE,
        parameters::SENSED_LAG,
        parameters::SENSED_OFFSET,
        parameters::SENSED_SEED,
    ];
    [
        (range.key, range.help),
        (noise.key, noise.help),
        (lag.key, lag.help),
        (offset.key, offset.help),
        (seed.key, seed.help),
    ]
};

/// The key of the hand, of a 2DIY or of a board of one's own.
const HAND: &str = "hand";

/// Keys of a 2DIY.
const HAPLY_KEYS: [(&str, &str); 2] = [
    ("hardware", "2DIY: hardware version, 2 or 3 [default: 3]"),
    (
        HAND,
        "2DIY: strokes (along y, the default), free, at:X:Y, or fixed:X:Y; own: places over and over, as press:3mm/2s,withdraw",
    ),
];

/// Keys of a servo; `turn` is of the hand that holds it.
const MOTEUS_KEYS: [(&str, &str); 2] = [
    ("servo_id", "Servo: number on its bus [default: 1]"),
    (
        "turn",
        "Servo: from command 600 on a hand turns the lever at 20 mm and holds it, as 2mm:0.5s",
    ),
];

/// Keys of two boards that face each other.
const FACING_KEYS: [(&str, &str); 5] = [
    ("facing_model", "Facing: device file of the second board"),
    ("contact_stiffness_n_per_m", "Facing [default: 100kN/m]"),
    ("contact_damping_n_s_per_m", "Facing [default: 80N·s/m]"),
    (
        "contact_friction_n",
        "Facing: between the tips [default: 0N]",
    ),
    ("gap_m", "Facing: way until they touch [default: 0m]"),
];

fn all_keys() -> impl Iterator<Item = (&'static str, &'static str)> {
    let of_kinds = HAPLY_KEYS.into_iter().chain(MOTEUS_KEYS);
    let of_kinds = of_kinds.chain(inverse3::KEYS);
    let of_board = LINE_KEYS.into_iter().chain(MOTOR_KEYS).chain(SENSOR_KEYS);
    let of_board = of_board.chain(robot::KEYS).chain(specimen::keys());
    of_board.chain(of_kinds).chain(FACING_KEYS)
}

/// Before a key of the line or the force sensor: that of the second board.
const FACING: &str = "facing_";

/// The names of all keys, without their units.
pub(crate) fn names() -> Vec<&'static str> {
    all_keys().map(|row| without_unit(row.0)).collect()
}

/// Advice for a key of a device file.
pub(crate) fn of_device(written: &str) -> Option<String> {
    let written = written.trim_start_matches('-');
    let mut keys = parameters::DEVICE_PLANT.iter();
    let is_one = keys.any(|parameter| is_meant(parameter.key, written));
    is_one.then(|| "it is of the device: give --device-model FILE.toml, or laboratory".to_owned())
}

#[derive(Debug, Default)]
struct Details {
    /// The keys that were given, those of the second board's line apart.
    given: [BTreeSet<&'static str>; 2],
    faults: [LineFaults; 2],
    seeds: [u64; 2],
    /// Range, noise, lag and offset of the force sensors; `None` where they are not given.
    sensors: [[Option<f64>; 4]; 2],
    sensor_seeds: [u64; 2],
    motor_gain: Option<f64>,
    robot: robot::Words,
    hardware: Version,
    /// The hand of a 2DIY; `None` strokes.
    hand: Option<haply::Hand>,
    script: Option<HandScript>,
    servo_id: Option<u8>,
    turn: Option<moteus::Hand>,
    service_port: Option<u16>,
    cursor: haptic_emulator::inverse3::Hand,
    facing_model: Option<PathBuf>,
    contact: FacingContact,
    specimen: specimen::Words,
}

impl Details {
    fn read(words: &[String]) -> Result<Self, Failure> {
        let mut details = Self {
            // A line takes two, one each way.
            seeds: [1, 3],
            sensor_seeds: [1, 2],
            ..Self::default()
        };
        for faults in &mut details.faults {
            faults.stall_s = 0.05;
        }
        let of_board = LINE_KEYS.into_iter().chain(SENSOR_KEYS);
        let of_board = of_board.map(|(key, _)| key);
        for word in words {
            let facing = (word.strip_prefix(FACING))
                .and_then(|rest| key_and_value(rest, of_board.clone()).ok());
            let side = usize::from(facing.is_some());
            let all = all_keys().map(|(key, _)| key);
            let of_device = word.split_once('=').and_then(|(key, _)| of_device(key));
            let known = |failure| match of_device {
                Some(advice) => refused(word, &format!(": {advice}")),
                None => failure,
            };
            let (key, text) = facing.map_or_else(|| key_and_value(word, all).map_err(known), Ok)?;
            if !details.given[side].insert(key) {
                return Err(refused(word, "is given twice: keep one"));
            }
            if let Some(parameter) = specimen::parameter(key) {
                (details.specimen).push((parameter, text.to_owned(), short(word).into_owned()));
                continue;
            }
            let set = details.set(side, key, text);
            set.map_err(|why| refused(word, &why))?;
        }
        for faults in details.faults {
            faults.check().map_err(Failure::input)?;
        }
        Ok(details)
    }

    /// A key, of the line of the first board or the second.
    fn set(&mut self, side: usize, key: &str, text: &str) -> Result<(), String> {
        let (faults, contact) = (&mut self.faults[side], &mut self.contact);
        let number = |range| in_range(key, range, text);
        match key {
            "drop" => faults.drop = number(CHANCES)?,
            "corrupt" => faults.corrupt = number(CHANCES)?,
            "duplicate" => faults.duplicate = number(CHANCES)?,
            "reorder" => faults.reorder = number(CHANCES)?,
            "delay_s" => faults.delay_s = number(parameters::LINE_DELAY.range())?,
            "stall" => faults.stall = number(CHANCES)?,
            "stall_time_s" => faults.stall_s = number(parameters::LINE_DELAY.range())?,
            "line_seed" => self.seeds[side] = count(text, 0, u64::MAX)?,
            "motor_gain" => self.motor_gain = Some(number(MOTOR_GAINS)?),
            "sensed_range_n" | "sensed_noise_n" | "sensed_lag_s" | "sensed_offset_n" => {
                let n = SENSOR_KEYS.iter().position(|(known, _)| *known == key);
                let n = n.unwrap_or_default();
                self.sensors[side][n] = Some(number(parameters::FORCE_SENSOR[n].range())?);
            }
            "sensed_seed" => self.sensor_seeds[side] = count(text, 0, u64::MAX)?,
            "sample_time_s" => self.robot.sample_time_s = number(robot::SAMPLE_TIMES)?,
            "encoder_resolution_m" => self.robot.encoder_resolution_m = number(ENCODERS)?,
            "noise_m" => self.robot.noise_m = number(ENCODERS)?,
            "measured" => self.robot.is_to_measure = robot::is_to_measure(text)?,
            "hardware" => {
                let mut all = Version::ALL.into_iter();
                let found = all.find(|version| version.number().to_string() == text);
                self.hardware = found.ok_or("is not a version of a 2DIY: give 2 or 3")?;
            }
            HAND => match script(text)? {
                None => self.hand = hand(text)?,
                script => self.script = script,
            },
            "servo_id" => self.servo_id = Some(count(text, 0, u8::MAX)?),
            "turn" => self.turn = Some(turn(text)?),
            "service_port" => self.service_port = Some(count(text, 0, u16::MAX)?),
            "cursor" => self.cursor = inverse3::hand(text)?,
            "facing_model" => self.facing_model = Some(PathBuf::from(text)),
            "contact_stiffness_n_per_m" => contact.stiffness.0 = number(CONTACT_STIFFNESSES)?,
            "contact_damping_n_s_per_m" => contact.damping.0 = number(CONTACT_DAMPINGS)?,
            "contact_friction_n" => contact.friction.0 = number(CONTACT_FRICTIONS)?,
            _ => contact.gap.0 = number(GAPS)?,
        }
        Ok(())
    }

    /// The force sensor of a board; `None` without a range.
    fn sensor(&self, side: usize) -> Result<Option<ForceSensorConfig>, Failure> {
        let given = self.sensors[side];
        let of = |n: usize| given[n].unwrap_or(parameters::FORCE_SENSOR[n].default_number());
        let config = ForceSensorConfig {
            range: Newtons(of(0)),
            noise: Newtons(of(1)),
            lag: Seconds(of(2)),
            offset: Newtons(of(3)),
            seed: self.sensor_seeds[side],
        };
        match given {
            [None, None, None, None] => Ok(None),
            [None, ..] => Err(Failure::bad_input(
                "sensed_noise, sensed_lag and sensed_offset apply only to a force sensor: give sensed_range too, as sensed_range=20N",
            )),
            [Some(_), ..] => ForceSensor::new(config, Seconds(1e-3))
                .map(|_| Some(config))
                .map_err(Failure::input),
        }
    }

    fn has(&self, keys: &[(&str, &str)]) -> bool {
        keys.iter().any(|(key, _)| self.given[0].contains(key))
    }

    /// True if something of them is of a second board.
    fn of_two(&self) -> bool {
        self.has(&FACING_KEYS) || !self.given[1].is_empty()
    }
}

/// Ranges of the contact of two boards: N/m, N·s/m, N, m.
const CONTACT_STIFFNESSES: Range = Range::AboveUpTo(0.0, 1e7);
const CONTACT_DAMPINGS: Range = Range::Within(0.0, 1e5);
const CONTACT_FRICTIONS: Range = Range::Within(0.0, 1e3);
const GAPS: Range = Range::Within(0.0, 1.0);
/// Step and noise of an encoder, m.
const ENCODERS: Range = Range::Within(0.0, 1e-2);
/// Newtons of a motor for each that is commanded.
const MOTOR_GAINS: Range = Range::Within(-20.0, 20.0);
/// That the line spoils a frame.
const CHANCES: Range = Range::Within(0.0, 1.0);

impl Arguments {
    pub(super) fn run(self, output: Output) -> Result<(), Failure> {
        let kind = self.kind.unwrap_or_default();
        let details = Details::read(&self.values)?;
        self.check_kind(kind, &details)?;
        let robot = self.robot(kind, &details)?;
        let own = match &robot {
            Some(_) => None,
            None => self.model.read()?,
        };
        let bodies = [
            own,
            (details.facing_model.as_deref().map(DeviceModel::find)).transpose()?,
        ];
        let mut bodies = bodies.map(|model| model.as_ref().map(body));
        if let (Some(body), Some(gain)) = (&mut bodies[0], details.motor_gain) {
            body.plant.gain = gain;
        }
        let sensors = [details.sensor(0)?, details.sensor(1)?];
        let servo = servo(details.servo_id, details.turn)?;
        let specimen = specimen::read(details.specimen)?;
        let at_handle = (specimen.map(AtHandle::Specimen)).or(details.script.map(AtHandle::Hand));
        let duration = self.duration.map(Duration::from_secs_f64);
        let (faults, seed) = (details.faults[0], details.seeds[0]);
        let stop = stop_on_interrupt()?;
        if kind == Kind::Inverse3 {
            let (port, hand) = (details.service_port, details.cursor);
            return inverse3::run(port, hand, duration, output, stop);
        }
        let failed = |error| self.failed(error);
        let (kind_of_port, first) = self.first();
        // Only our own protocol begins with a greeting.
        let kind_of_port = if kind_of_port == PortKind::Address && kind != Kind::Own {
            PortKind::ForeignAddress
        } else {
            kind_of_port
        };
        let port = BoardPort::open(kind_of_port, first).map_err(failed)?;
        let facing = self.facing.as_deref();
        let facing = facing.map(|path| BoardPort::open(kind_of_port, Some(path)));
        let facing = facing.transpose().map_err(failed)?;
        let public = [Some(&port), facing.as_ref()].into_iter().flatten();
        if let Some(address) = public.filter_map(BoardPort::public_address).next() {
            warn(&format!(
                "whoever reaches {address} can move this device, as nothing is encrypted and no password is asked: \
                 listen there on a trusted network only"
            ));
        }
        let port_report = |port: &BoardPort| {
            let path = port.path();
            let is_named = kind == Kind::Own && tcp_address(&path).is_some();
            let device = if is_named {
                path.clone()
            } else {
                format!("{}:{path}", kind.scheme())
            };
            json!({"path": path, "device": device})
        };
        let mut report = port_report(&port);
        // Chances of the line, and its seed; none of a good one.
        report["line"] = json!(self.values);
        if let Some(facing) = &facing {
            report["facing"] = port_report(facing);
        }
        output.report(&report)?;
        let line = port.line().map_err(failed)?;
        let done = match kind {
            Kind::Own => {
                let emulations = [0, 1].map(|side| Emulation {
                    axes: self.axes.unwrap_or(1),
                    body: bodies[side],
                    sensor: sensors[side],
                    at_handle: at_handle.clone(),
                    robot: robot.clone(),
                    speed: self.speed,
                    faults: details.faults[side],
                    seed: details.seeds[side],
                    duration,
                });
                match &facing {
                    None => {
                        let done = board::emulate(line, &emulations[0], stop);
                        words_of_own(&done.map_err(failed)?)
                    }
                    Some(facing) => {
                        let lines = [line, facing.line().map_err(failed)?];
                        let done = board::emulate_facing(lines, &emulations, details.contact, stop);
                        done.map_err(failed)?
                            .map(|done| words_of_own(&done))
                            .join("; facing: ")
                    }
                }
            }
            Kind::Haply2Diy => {
                let model = details.hardware.model();
                let hand = details.hand.unwrap_or_else(|| strokes(&model));
                let mut board = haply::Board::new(model, haply::Body::at_home(&model, hand));
                let damage = emulate(line, &mut board, (faults, seed), duration, stop);
                words_of_haply(&board, &damage.map_err(Failure::input)?)
            }
            Kind::Moteus => {
                let mut adapter = moteus::EmulatedAdapter::new(servo);
                let damage = emulate(line, &mut adapter, (faults, seed), duration, stop);
                words_of_moteus(&adapter, &damage.map_err(Failure::input)?)
            }
            // It has a port of its own, above.
            Kind::Inverse3 => String::new(),
        };
        if !output.quiet {
            note("emulated", done);
        }
        Ok(())
    }

    fn check_kind(&self, kind: Kind, details: &Details) -> Result<(), Failure> {
        let (kind_of_port, first) = self.first();
        let listens = kind_of_port == PortKind::Address;
        let has_specimen = !details.specimen.is_empty();
        let has_script = details.script.is_some();
        let at_handle = has_specimen || has_script;
        let refusal = if kind != Kind::Haply2Diy && details.has(&HAPLY_KEYS) && !has_script {
            "hardware and this hand apply only to a 2DIY: add --kind haply-2diy"
        } else if kind != Kind::Moteus && details.has(&MOTEUS_KEYS) {
            "servo_id and turn apply only to a servo: add --kind moteus"
        } else if kind != Kind::Inverse3 && details.has(&inverse3::KEYS) {
            "service_port and cursor apply only to an Inverse Service: add --kind inverse3"
        } else if kind == Kind::Inverse3 && (details.has(&LINE_KEYS) || first.is_some()) {
            "an Inverse Service is at a TCP port, which loses nothing: omit keys of the line, --link and --listen"
        } else if kind != Kind::Own && details.has(&SENSOR_KEYS) {
            "a force sensor is of --kind own: omit sensed_…"
        } else if kind != Kind::Own && at_handle {
            "a specimen or a hand with a script is of --kind own: omit its keys"
        } else if self.axes.unwrap_or(1) != 1 && at_handle {
            "a specimen or a hand with a script has one axis: omit --axes, or its keys"
        } else if self.facing.is_some() && at_handle {
            "boards that face each other have neither specimen nor hand: omit --facing, or its keys"
        } else if has_specimen && has_script {
            "a specimen is in the place of a hand: omit hand, or the keys of the specimen"
        } else if details.motor_gain.is_some() && !self.model.is_given() {
            "motor_gain is of a board with a device file: add --device-model laboratory"
        } else if kind != Kind::Own && self.axes.is_some() {
            "--axes applies only to --kind own: omit it"
        } else if kind != Kind::Own && self.model.is_given() {
            "--device-model applies only to --kind own: omit it"
        } else if kind != Kind::Own && self.facing.is_some() {
            "--facing applies only to --kind own: omit it"
        } else if self.facing.is_some() && self.axes.is_some() {
            "boards that face each other have one axis: omit --axes"
        } else if self.facing.is_none() && details.of_two() {
            "facing_…, contact_… and gap apply only to two boards: add --facing, as in --facing white"
        } else if self.facing.is_some() && first.is_none() && !listens {
            "--facing needs a path of the first board too: give --link or --listen"
        } else if self.facing.is_some() && self.facing.as_deref() == first && !listens {
            "--facing is the path of the first board too: give another"
        } else if kind != Kind::Own && (self.speed - 1.0).abs() > 0.0 {
            "an emulated device of another maker runs in real time: omit --speed"
        } else {
            return Ok(());
        };
        Err(Failure::bad_input(refusal))
    }
}

impl Arguments {
    /// The robot of the device file, if it is one.
    fn robot(&self, kind: Kind, details: &Details) -> Result<Option<EmulatedRobot>, Failure> {
        let Some((path, text)) = self.model.robot()? else {
            return if details.has(&robot::KEYS) {
                let reason = "sample_time, encoder_resolution, noise and measured apply only to a robot: give --device-model with the file of one";
                Err(Failure::bad_input(reason))
            } else {
                Ok(None)
            };
        };
        let is_alone = kind == Kind::Own && self.axes.unwrap_or(1) == 1 && self.facing.is_none();
        if !is_alone
            || details.has(&SENSOR_KEYS)
            || details.has(&MOTOR_KEYS)
            || !details.specimen.is_empty()
        {
            let reason = "a robot has one axis, its own force sensor and no motor, and nothing but a hand touches it: omit --kind, --axes, --facing, sensed_…, motor_gain and a specimen";
            return Err(Failure::bad_input(reason));
        }
        details.robot.emulated(path, &text).map(Some)
    }
}

fn body(model: &DeviceModel) -> Body {
    let sensors = model.values.sensors();
    Body {
        // The tick is that of a run.
        plant: model.values.free(Seconds(0.0)),
        encoder_resolution: Metres(sensors.encoder_resolution_m),
        noise: (Metres(sensors.noise_m), sensors.seed),
    }
}

impl Arguments {
    /// The kind of all ports, and the name of the first.
    fn first(&self) -> (PortKind, Option<&Path>) {
        match &self.listen {
            None if cfg!(unix) || self.link.is_some() => (PortKind::Terminal, self.link.as_deref()),
            address => (PortKind::Address, address.as_deref()),
        }
    }

    /// A device that could not be emulated, with the option that mends it.
    fn failed(&self, error: EmulatorError) -> Failure {
        if let EmulatorError::Path { path, .. } = &error {
            let of_second = self.facing.as_ref() == Some(path);
            let option = if of_second { "facing" } else { "link" };
            Failure::bad_input(format_args!("{error} with --{option}"))
        } else if matches!(error, EmulatorError::Terminal(_)) {
            Failure::device(error)
        } else if matches!(error, EmulatorError::Device(_)) {
            Failure::run(error)
        } else {
            Failure::input(error)
        }
    }
}

fn words_of_own(done: &Emulated) -> String {
    let (from, to) = (done.damage.to_device, done.damage.to_host);
    format!(
        "{} ticks, {} frames from the host, {} to it; {} lost, {} damaged, {} repeated, {} out of \
         order, {} stalls; {} not fetched",
        done.ticks,
        from.sent,
        to.sent,
        from.dropped + to.dropped,
        from.corrupted + to.corrupted,
        from.duplicated + to.duplicated,
        from.reordered + to.reordered,
        from.stalls + to.stalls,
        done.unread
    )
}

/// Motion of a stroking hand: start, distance and period.
const STROKES: (f64, f64, f64) = (0.085, 0.015, 4.0);

fn hand(text: &str) -> Result<Option<haply::Hand>, String> {
    const KNOWN: &str =
        "is not a hand: give strokes, free, at:X:Y or fixed:X:Y, as in fixed:19mm:90mm";
    let point = |text: &str| -> Result<[f64; 2], String> {
        let end = |text| in_range("place_m", parameters::PRESS.range(), text);
        let (x, y) = text.split_once(':').ok_or(KNOWN)?;
        Ok([end(x)?, end(y)?])
    };
    match text.split_once(':').unwrap_or((text, "")) {
        ("strokes", "") => Ok(None),
        ("free", "") => Ok(Some(haply::Hand::Free)),
        ("at", rest) => Ok(Some(haply::Hand::At(point(rest)?))),
        ("fixed", rest) => Ok(Some(haply::Hand::Fixed(point(rest)?))),
        _ => Err(KNOWN.to_owned()),
    }
}

/// Places of a scripted hand, m, and its times there, s, where they are not given.
const PRESSED: (f64, f64) = (3e-3, 2.0);
const WITHDRAWN: (f64, f64) = (5e-3, 1.0);

/// The script of a hand; `None` if it is another hand.
fn script(text: &str) -> Result<Option<HandScript>, String> {
    if !text.starts_with("press") && !text.starts_with("withdraw") {
        return Ok(None);
    }
    let moves = text.split(',').map(|step| {
        let (word, rest) = step.split_once(':').unwrap_or((step, ""));
        let (length, time) = rest.split_once('/').unwrap_or((rest, ""));
        let (sign, (length_m, time_s)) = match word.trim() {
            "press" => (1.0, PRESSED),
            "withdraw" => (-1.0, WITHDRAWN),
            _ => return Err("is not a script: give press and withdraw, each with LENGTH/TIME or without, as in press:3mm/2s,withdraw".to_owned()),
        };
        let number = |key, range, text: &str, default| match text {
            "" => Ok(default),
            text => in_range(key, range, text),
        };
        let place_m = number("place_m", parameters::PRESS.range(), length, length_m)?;
        let time_s = number("time_s", parameters::TRIAL_DURATION.range(), time, time_s)?;
        Ok((Metres(sign * place_m), Seconds(time_s)))
    });
    let moves = moves.collect::<Result<Vec<_>, String>>()?;
    HandScript::new(moves)
        .map(Some)
        .map_err(|error| error.to_string())
}

/// A hand that strokes along y, in the middle of the workspace of this hardware.
fn strokes(model: &HaplyModel) -> haply::Hand {
    let (from_m, depth_m, time_s) = STROKES;
    haply::Hand::Strokes {
        from: [0.5 * model.pantograph.base_m, from_m],
        depth_m,
        time_s,
    }
}

fn words_of_haply(board: &haply::Board, damage: &DuplexDamage) -> String {
    let place_m = board.body().place_m();
    let [first, second] = board.torques_nm();
    let counted = board.counted();
    format!(
        "{} configurations, {} frames of torques, {} resets, {} bytes skipped; handle at {:.3} mm, \
         {:.3} mm; torques {first:.6} N·m, {second:.6} N·m, largest {:.6} N·m; {}",
        counted.configured,
        counted.torques,
        counted.resets,
        counted.skipped,
        1e3 * place_m.x,
        1e3 * place_m.y,
        counted.largest_nm,
        words_of_line(damage)
    )
}

fn words_of_line(DuplexDamage { to_device, to_host }: &DuplexDamage) -> String {
    let lost = to_device.dropped + to_host.dropped;
    let damaged = to_device.corrupted + to_host.corrupted;
    format!("{lost} bytes lost, {damaged} damaged")
}

/// Ticks: longer than a force takes to rise to its full size at 1 kHz.
const WAIT_COMMANDS: u32 = 600;

/// A hand that turns the shaft: `LENGTH:TIME`.
fn turn(text: &str) -> Result<moteus::Hand, String> {
    let (length, time) = text
        .split_once(':')
        .ok_or("is not LENGTH:TIME, as in 2mm:0.5s")?;
    Ok(moteus::Hand {
        wait_commands: WAIT_COMMANDS,
        turn_rev: in_range("turn_m", parameters::PRESS.range(), length)?
            / MoteusSettings::DEFAULT.metres_per_revolution(),
        ramp_time_s: in_range("turn_s", parameters::TRIAL_DURATION.range(), time)?,
    })
}

/// A servo with this number on its bus, and this hand.
fn servo(id: Option<u8>, hand: Option<moteus::Hand>) -> Result<moteus::EmulatedServo, Failure> {
    let shaft = moteus::Shaft {
        hand,
        ..moteus::Shaft::LEVER
    };
    let id = id.unwrap_or(MoteusSettings::DEFAULT.id);
    moteus::EmulatedServo::new(id, shaft).map_err(Failure::input)
}

fn words_of_moteus(adapter: &moteus::EmulatedAdapter, damage: &DuplexDamage) -> String {
    let (served, servo) = (adapter.served(), &adapter.servo);
    format!(
        "{} frames, {} answers, {} lines refused; mode {} at the end, shaft at {:.6} revolutions, \
         torque {:.6} N·m, largest {:.6} N·m; {}",
        served.frames,
        served.answers,
        served.refused,
        u8::from(servo.mode()),
        servo.position_rev(),
        servo.torque_nm(),
        servo.torque_peak_nm(),
        words_of_line(damage)
    )
}
