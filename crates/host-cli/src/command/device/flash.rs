//! `device flash`: program a board, over a debug probe or through the drive of its boot loader.

mod board;
mod drive;
mod image;
mod uf2;

use crate::command::device::port::PortArguments;
use crate::output::{Output, joined, note, warn};
use crate::parse::one_of;
use board::{Board, Way, boards};
use clap::Args;
use haptic_experiment::Failure;
use haptic_loop::realtime::Moment;
use haptic_run::{at_port, firmware_digest, firmware_version};
use image::Image;
use serde_json::json;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::Duration;

/// Program a board over a debug probe, or a Pico through its drive
///
/// Builds the firmware, programs the board, and checks that the device then runs exactly that
/// image: it has just started, and answers with the digest of its own flash. A Raspberry Pi Pico is
/// programmed through the drive that it shows when it is plugged in with BOOTSEL held, others over
/// a debug probe with probe-rs (<https://probe.rs>).
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli device flash --board nucleo-f446re --device serial:/dev/ttyACM0"
)]
pub(crate) struct Arguments {
    /// Board to program, which the image must be for [default: the one whose boot drive is mounted, else nucleo-f446re]
    #[arg(long, value_parser = one_of(boards()))]
    board: Option<&'static Board>,
    /// Image to program, ELF or UF2 [default: build it from --source]
    #[arg(long, value_name = "FILE")]
    image: Option<PathBuf>,
    /// Folder of the firmware, if no image is given
    #[arg(long, value_name = "DIR", default_value = "firmware")]
    source: PathBuf,
    #[command(flatten)]
    port: PortArguments,
}

impl Arguments {
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        // Errors in a file are reported before anything has to be plugged in.
        let board = match self.board {
            Some(board) => board,
            None => Board::at(
                &drive::mounted()
                    .iter()
                    .filter_map(|at| drive::board_id(at))
                    .collect::<Vec<_>>(),
            )?,
        };
        let given = self.image.as_deref();
        let given = given.map(|file| Image::read(board, file));
        let given = given.transpose()?;
        let programmer = Programmer::ready(board)?;
        let image = match given {
            Some(image) => image,
            None => Image::read(board, &self.build(board, output)?)?,
        };
        let began = Moment::now();
        let doubt = programmer.program(&image)?;
        if !output.quiet {
            note("written", image.file.display());
        }
        // A board that was just reset needs a moment; its port may go and come back.
        let patience = self.port.patience().max(Duration::from_secs(10));
        let link = self.port.device.connect(None, patience, &warn, None);
        let link = match (link, doubt) {
            (Ok(link), doubt) => {
                doubt.iter().for_each(|doubt| warn(&doubt.to_string()));
                link
            }
            (Err(error), doubt) => return Err(doubt.unwrap_or(error)),
        };
        image.compare(link.hello(), link.capabilities())?;
        let up_time = link.up_time();
        let up_time = up_time.map_err(|error| at_port(link.path(), &error))?;
        if up_time > began.elapsed() {
            return Err(Failure::device(format_args!(
                "{} has been running for {:.0} s, so it is another board, or did not start the new image: unplug all others, then plug \
                 it in again",
                link.name(),
                up_time.as_secs_f64()
            )));
        }
        let written = json!({
            "board": link.capabilities().board(),
            "image": image.file.display().to_string(),
            "firmware": firmware_version(link.hello()),
            "device": link.name(),
        });
        let digest = firmware_digest(link.capabilities());
        let proved = digest.map(|digest| json!({"firmware_digest": digest, "verified": true}));
        output.report(&joined([written, proved.unwrap_or_default()]))
    }

    fn build(&self, board: &Board, output: Output) -> Result<PathBuf, Failure> {
        let folder = self.source.join(board.folder);
        let manifest = folder.join("Cargo.toml");
        if !manifest.is_file() {
            return Err(Failure::bad_input(format_args!(
                "`{}` does not hold the firmware: give its folder with --source",
                self.source.display()
            )));
        }
        let mut cargo = Command::new("cargo");
        cargo
            .arg(format!("image-{}", board.name))
            .args(["--message-format", "json-render-diagnostics"])
            .current_dir(&folder);
        if output.quiet {
            cargo.arg("--quiet");
        }
        let advice = "install Rust, and with rustup the target that it names";
        let printed = run(cargo, "cargo", advice)?;
        // Only cargo knows where it puts an image: a target folder can be set in five places.
        let built = String::from_utf8_lossy(&printed).lines().find_map(|line| {
            let message: serde_json::Value = serde_json::from_str(line).ok()?;
            message["executable"].as_str().map(PathBuf::from)
        });
        built.ok_or_else(|| {
            Failure::device(format_args!("cargo built no image: give one with --image"))
        })
    }
}

/// Programmer of a board, found before anything is built.
enum Programmer {
    /// A debug probe, by probe-rs, which knows the chip by this name.
    Probe(&'static str),
    /// The drive at this place, which accepts this family of images for a flash that begins at this address.
    Drive(PathBuf, u32, u32),
}

impl Programmer {
    fn ready(board: &'static Board) -> Result<Self, Failure> {
        match &board.way {
            Way::Probe(chip) => match Command::new("probe-rs").arg("--version").output() {
                Ok(_) => Ok(Self::Probe(chip)),
                Err(error) => Err(Failure::device(format_args!(
                    "probe-rs, which programs a {}, is not installed ({error}): run `cargo install probe-rs-tools --locked`; for a Pico {}",
                    board.name,
                    drive::REMEDY
                ))),
            },
            Way::Drive(id, family) => {
                let mount = drive::find(&drive::mounted(), id)?;
                Ok(Self::Drive(mount, *family, board.flash.start))
            }
        }
    }

    /// Programs the board. A failure is what to say if it does not answer afterwards.
    fn program(&self, image: &Image) -> Result<Option<Failure>, Failure> {
        match self {
            Self::Probe(chip) => {
                let mut probe = Command::new("probe-rs");
                probe
                    .args(["download", "--chip", chip, "--verify"])
                    .arg(&image.file)
                    .stdout(std::io::stderr());
                let advice = "plug in the debug port; `probe-rs list` shows the probes";
                run(probe, "probe-rs", advice)?;
                let mut reset = Command::new("probe-rs");
                reset
                    .args(["reset", "--chip", chip])
                    .stdout(std::io::stderr());
                run(reset, "probe-rs", "unplug the board and plug it in again")?;
                Ok(None)
            }
            Self::Drive(mount, family, begin) => {
                let blocks = uf2::blocks(&image.contents, *begin, *family);
                match drive::write(mount, &blocks) {
                    Ok(synced) => Ok(synced.err().map(|error| drive::refused(mount, &error))),
                    Err(error) => Err(drive::refused(mount, &error)),
                }
            }
        }
    }
}

/// Runs a program to its end, its errors as they come, and gives what it printed.
fn run(mut command: Command, name: &str, advice: &str) -> Result<Vec<u8>, Failure> {
    let failed = |why| Failure::device(format_args!("{why}: {advice}"));
    let ended = command.stderr(Stdio::inherit()).output();
    let ended = ended.map_err(|error| failed(format!("cannot run {name}: {error}")))?;
    if ended.status.success() {
        Ok(ended.stdout)
    } else {
        Err(failed(format!("{name} ended with {}", ended.status)))
    }
}
