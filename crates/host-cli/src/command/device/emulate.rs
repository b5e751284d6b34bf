//! `device emulate`.

use super::emulate_haply::HaplyArguments;
use super::emulate_moteus::{self, MoteusArguments};
use super::port::duration;
use crate::choice::choice;
use crate::command::device_model::DeviceModelArguments;
use crate::output::{Output, note};
use crate::whole::whole;
use crate::within::{number_within, within};
use clap::Args;
use haptic_devices::haply::HaplyName;
use haptic_devices::moteus::MoteusName;
use haptic_emulator::LineFaults;
use haptic_emulator::board::{Body, Emulated, Emulation, EmulatorError, Socket, Terminal, emulate};
use haptic_experiment::Named;
use haptic_experiment::failure::Failure;
use haptic_experiment::parameters::range;
use haptic_experiment::plant_file::DeviceModel;
use haptic_loop::plant::MassDamperConfig;
use haptic_loop::units::{Kilograms, Metres, NewtonSecondsPerMetre, Seconds};
use haptic_quantity::Time;
use haptic_remote::serial::Line;
use serde::Serialize;
use std::path::{Path, PathBuf};

pub(super) const LONG_ABOUT: &str = "\
Imitates a device: the same state machine as in the firmware, with a simulated plant, behind a \
pseudo-terminal whose path is printed. Any command that takes --device serial:PATH can talk to it.

With --device-model it is the device of that file: its mass, damping, friction, delay, lag and sensors, so that a run can be \
rehearsed on it; the hand is that of the run. Without, it is an ideal mass, as heavy as a run takes it for.

The line can be made as bad as real ones: frames lost, damaged, repeated, out of order, late, held \
up. The same --line-seed gives the same damage for the same frames.

With --kind haply-2diy it is the board of a Haply 2DIY, which the maker's own programs take for a real \
one. With --kind moteus it is a moteus servo behind an adapter for CAN, which the maker's own programs take for \
a real one too. Both live in real time, and the chances of their line are those of single bytes.";

/// A device to imitate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Kind {
    /// The device of this program.
    #[default]
    Own,
    /// The board of a Haply 2DIY.
    Haply2Diy,
    /// A moteus servo.
    Moteus,
}

impl Named for Kind {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Own, "own", "The device of this program"),
        (Self::Haply2Diy, "haply-2diy", "The board of a Haply 2DIY"),
        (Self::Moteus, "moteus", "A moteus servo behind an fdcanusb"),
    ];
}

impl Kind {
    /// Before the path in the name of such a device.
    const fn scheme(self) -> &'static str {
        match self {
            Self::Own => "serial",
            Self::Haply2Diy => HaplyName::KIND,
            Self::Moteus => MoteusName::KIND,
        }
    }
}

/// Arguments of `device emulate`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  host-cli device emulate --link device &\n  host-cli relax --device \
                  serial:device --duration 20s\n  host-cli device emulate --drop 1% --corrupt 1%\n  host-cli device emulate --device-model device.toml --link device &\n  host-cli device \
                  emulate --kind haply-2diy --link 2diy &\n  host-cli relax --device haply:2diy --duration 20s\n  \
                  host-cli device emulate --kind moteus --link servo --turn 1mm:1s &\n  host-cli relax --device \
                  moteus:servo,radius=20mm --duration 20s"
)]
pub struct Arguments {
    /// The device to imitate [default: own]
    #[arg(long, value_parser = choice::<Kind>())]
    kind: Option<Kind>,
    /// Make a symbolic link to the pseudo-terminal, so that its path is known beforehand
    #[arg(long, value_name = "PATH")]
    link: Option<PathBuf>,
    /// Listen at a Unix socket of this path instead of a pseudo-terminal, whose bytes may come late on a busy machine
    #[arg(long, value_name = "PATH", conflicts_with = "link")]
    socket: Option<PathBuf>,
    /// Axes of the device: 2 or 3 take a [touch], for which they are a mass with a hand that pushes along the first
    #[arg(long, value_parser = whole::<u8>(1..=3))]
    axes: Option<u8>,
    #[command(flatten)]
    model: DeviceModelArguments,
    /// Seconds of the device in a second; the host's silence is measured in real time
    #[arg(long, value_parser = number_within(range::SPEED_UPS), default_value_t = 1.0, allow_hyphen_values = true)]
    speed: f64,
    /// End after this time [default: when stopped by Ctrl-C]
    #[arg(long, value_parser = within::<Time>(range::WAITS), value_name = "TIME", allow_hyphen_values = true)]
    duration: Option<Time>,
    #[command(flatten)]
    faults: LineArguments,
    #[command(flatten)]
    haply: HaplyArguments,
    #[command(flatten)]
    moteus: MoteusArguments,
}

/// What the line does to frames.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Bad line")]
pub struct LineArguments {
    /// Chance that a frame is lost, as 1% or 0.01
    #[arg(long, default_value = "0", allow_hyphen_values = true, value_parser = chance)]
    drop: f64,
    /// Chance that bits of a frame are flipped
    #[arg(long, default_value = "0", allow_hyphen_values = true, value_parser = chance)]
    corrupt: f64,
    /// Chance that a frame comes twice
    #[arg(long, default_value = "0", allow_hyphen_values = true, value_parser = chance)]
    duplicate: f64,
    /// Chance that a frame comes after the next one
    #[arg(long, default_value = "0", allow_hyphen_values = true, value_parser = chance)]
    reorder: f64,
    /// Longest delay of a frame
    #[arg(long, value_parser = within::<Time>(range::LINE_TIMES), default_value = "0s", allow_hyphen_values = true)]
    delay: Time,
    /// Chance that the line stands still from a frame on
    #[arg(long, default_value = "0", allow_hyphen_values = true, value_parser = chance)]
    stall: f64,
    /// For how long it stands still then
    #[arg(long, value_parser = within::<Time>(range::LINE_TIMES), default_value = "50ms", allow_hyphen_values = true)]
    stall_time: Time,
    /// Seed of the damage
    #[arg(long = "line-seed", default_value_t = 1, value_parser = whole::<u64>(0..=u64::MAX))]
    seed: u64,
}

impl LineArguments {
    /// Faults of the line, and the seed.
    ///
    /// # Errors
    /// A chance or time outside its range.
    pub fn faults(&self) -> Result<(LineFaults, u64), Failure> {
        let &Self {
            drop,
            corrupt,
            duplicate,
            reorder,
            delay,
            stall,
            stall_time,
            seed,
        } = self;
        let (delay_s, stall_s) = (delay.0, stall_time.0);
        let faults = LineFaults {
            drop,
            corrupt,
            duplicate,
            reorder,
            delay_s,
            stall,
            stall_s,
        };
        faults.check().map_err(Failure::input)?;
        Ok((faults, seed))
    }
}

/// A chance: a number in [0, 1], or per cent.
fn chance(text: &str) -> Result<f64, String> {
    let value = match text.trim().strip_suffix('%') {
        Some(percent) => percent.trim().parse().map(|percent: f64| percent / 100.0),
        None => text.trim().parse(),
    };
    let chance = value.ok().filter(|value| (0.0..=1.0).contains(value));
    chance.ok_or_else(|| format!("\"{text}\" is no chance: give 0 to 1, or 0% to 100%"))
}

/// The device's end of the line.
enum Port {
    Terminal(Terminal),
    Socket(Socket),
}

impl Port {
    fn open(socket: Option<&Path>, link: Option<&Path>) -> Result<Self, EmulatorError> {
        match socket {
            Some(path) => Socket::open(path).map(Self::Socket),
            None => Terminal::open(link).map(Self::Terminal),
        }
    }

    fn path(&self) -> &Path {
        match self {
            Self::Terminal(terminal) => terminal.path(),
            Self::Socket(socket) => socket.path(),
        }
    }

    fn line(&self) -> Result<Box<dyn Line>, EmulatorError> {
        match self {
            Self::Terminal(terminal) => terminal.line(),
            Self::Socket(socket) => socket.line(),
        }
    }
}

#[derive(Serialize)]
struct Started {
    path: String,
    device: String,
}

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A pseudo-terminal that cannot be had; values outside their ranges.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        if !(self.speed > 0.0 && self.speed <= 1000.0) {
            return Err(Failure::bad_input(format_args!(
                "speed {} is not in (0, 1000]: give --speed, as in 10",
                self.speed
            )));
        }
        let kind = self.kind.unwrap_or_default();
        self.check_kind(kind)?;
        let body = self.model.read()?.as_ref().map(body);
        let servo = self.moteus.servo()?;
        let duration = duration(self.duration)?;
        let (faults, seed) = self.faults.faults()?;
        let stop = crate::command::stop::stop_on_interrupt()?;
        let port = Port::open(self.socket.as_deref(), self.link.as_deref()).map_err(failed)?;
        let started = Started {
            path: port.path().display().to_string(),
            device: format!("{}:{}", kind.scheme(), port.path().display()),
        };
        output.print(&started, |out| {
            writeln!(out, "{}", started.path)?;
            writeln!(
                out,
                "an emulated device: use it with --device {}, stop it with Ctrl-C",
                started.device
            )
        })?;
        let line = port.line().map_err(failed)?;
        let damage = (faults, seed);
        if kind == Kind::Haply2Diy {
            return (self.haply).run(line, damage, duration, stop, output.quiet);
        }
        if kind == Kind::Moteus {
            return emulate_moteus::run(line, servo, damage, duration, stop, output.quiet);
        }
        let emulation = Emulation {
            axes: self.axes.unwrap_or(1),
            body,
            speed: self.speed,
            faults,
            seed,
            duration,
        };
        let done = emulate(line, &emulation, stop).map_err(failed)?;
        if !output.quiet {
            note("emulated", in_words(&done));
        }
        Ok(())
    }
}

impl Arguments {
    /// Refuses options of another kind.
    fn check_kind(&self, kind: Kind) -> Result<(), Failure> {
        let refusal = if kind != Kind::Haply2Diy && self.haply.is_given() {
            "--hardware and --hand are those of a 2DIY: add --kind haply-2diy"
        } else if kind != Kind::Moteus && self.moteus.is_given() {
            "--servo-id and --turn are those of a servo: add --kind moteus"
        } else if kind != Kind::Own && self.axes.is_some() {
            "--axes is of the device of this program: a 2DIY has two, and a servo one; leave --axes away"
        } else if kind != Kind::Own && self.model.is_given() {
            "--device-model is of the device of this program: a 2DIY and a servo are what they are; leave --device-model away"
        } else if kind != Kind::Own && (self.speed - 1.0).abs() > 0.0 {
            "an emulated device of another maker lives in real time: leave --speed away"
        } else {
            return Ok(());
        };
        Err(Failure::bad_input(refusal))
    }
}

/// The device of a device file, to be emulated.
fn body(model: &DeviceModel) -> Body {
    let (values, imperfections) = (&model.values, model.imperfections());
    // The tick is that of a run.
    let ideal = MassDamperConfig::ideal(
        Kilograms(values.mass_kg),
        NewtonSecondsPerMetre(values.damping_n_s_per_m),
        Seconds(0.0),
    );
    let sensors = imperfections.sensors;
    Body {
        plant: imperfections.on(ideal),
        encoder_resolution: Metres(sensors.encoder_resolution_m),
        noise: (Metres(sensors.noise_m), sensors.seed),
    }
}

/// A device that could not be emulated, with the option that mends it.
fn failed(error: EmulatorError) -> Failure {
    match error {
        EmulatorError::Link { .. } => Failure::bad_input(format_args!("{error} with --link")),
        EmulatorError::Socket { .. } => Failure::bad_input(format_args!("{error} with --socket")),
        EmulatorError::Terminal(_) => Failure::Device(error.into()),
        EmulatorError::Device(_) => Failure::Run(error.into()),
        _ => Failure::input(error),
    }
}

fn in_words(done: &Emulated) -> String {
    format!(
        "{} ticks, {} frames from the host, {} to it; the line lost {}, damaged {}, repeated {}, put {} out \
         of order, stood still {} times; {} were not fetched",
        done.ticks,
        done.frames_from_host,
        done.frames_to_host,
        done.dropped,
        done.corrupted,
        done.duplicated,
        done.reordered,
        done.stalls,
        done.unread
    )
}
