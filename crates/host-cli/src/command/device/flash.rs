//! `device flash`: program a board, over a debug probe or through the drive of its boot loader.

mod drive;
mod uf2;

use crate::command::device::port::PortArguments;
use crate::output::{Output, note, warn};
use crate::parse::one_of;
use clap::Args;
use haptic_experiment::Failure;
use haptic_experiment::run::firmware_version;
use serde_json::json;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::Command;

pub(super) const LONG_ABOUT: &str = "\
Builds the firmware, programs a board, and checks that the device then answers with the image's board and version. \
A Raspberry Pi Pico is programmed through the drive that it shows when it is plugged in with BOOTSEL held, others over a \
debug probe with probe-rs (https://probe.rs).";

/// A board of `firmware/`.
#[derive(Debug)]
struct Board {
    /// As the device calls itself.
    name: &'static str,
    /// Folder of its workspace, below that of the firmware.
    folder: &'static str,
    feature: &'static str,
    target: &'static str,
    program: &'static str,
    way: Way,
}

/// How an image gets into a board.
#[derive(Debug)]
enum Way {
    /// As probe-rs calls the chip.
    Probe(&'static str),
    /// As the boot loader calls its board, its family of images, its flash.
    Drive(&'static str, u32, Range<u32>),
}

const BOARDS: &[Board] = &[
    Board {
        name: "nucleo-f446re",
        folder: ".",
        feature: "board-nucleo-f446re",
        target: "thumbv7em-none-eabihf",
        program: "haptic-device",
        way: Way::Probe("STM32F446RETx"),
    },
    Board {
        name: "rp2040",
        folder: "examples/rp2040",
        feature: "rp2040",
        target: "thumbv6m-none-eabi",
        program: "haptic-rp2040",
        way: Way::Drive("RPI-RP2", 0xe48b_ff56, 0x1000_0000..0x1020_0000),
    },
    Board {
        name: "rp2350",
        folder: "examples/rp2040",
        feature: "rp2350",
        target: "thumbv8m.main-none-eabihf",
        program: "haptic-rp2040",
        way: Way::Drive("RP2350", 0xe48b_ff59, 0x1000_0000..0x1040_0000),
    },
];

fn boards() -> Vec<(&'static Board, &'static str, &'static str)> {
    BOARDS.iter().map(|board| (board, board.name, "")).collect()
}

/// Arguments of `device flash`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli device flash --board nucleo-f446re --device serial:/dev/ttyACM0"
)]
pub(crate) struct Arguments {
    /// The board
    #[arg(long, value_parser = one_of(boards()), default_value = BOARDS[0].name)]
    board: &'static Board,
    /// Image to program [default: build it from --source]
    #[arg(long, value_name = "ELF")]
    image: Option<PathBuf>,
    /// Folder of the firmware
    #[arg(long, value_name = "DIR", default_value = "firmware")]
    source: PathBuf,
    #[command(flatten)]
    port: PortArguments,
}

impl Arguments {
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        let programmer = Programmer::ready(self.board)?;
        let image = match &self.image {
            Some(image) => image.clone(),
            None => self.build(output)?,
        };
        if !image.is_file() {
            return Err(Failure::bad_input(format_args!(
                "no image `{}`: change --image, or give --source to build it",
                image.display()
            )));
        }
        let bytes = std::fs::read(&image).map_err(|error| {
            Failure::bad_input(format_args!("cannot read `{}`: {error}", image.display()))
        })?;
        let identity = read_identity(self.board, &image, &bytes)?;
        let doubt = programmer.program(&image, &bytes)?;
        if !output.quiet {
            note("written", image.display());
        }
        // A board that was just reset needs a moment; its port may go and come back.
        let patience = self.port.patience().max(std::time::Duration::from_secs(10));
        let link = self.port.device.connect(None, patience, &warn, None);
        let link = match (link, doubt) {
            (Ok(link), doubt) => {
                doubt.iter().for_each(|doubt| warn(&doubt.to_string()));
                link
            }
            (Err(error), doubt) => return Err(doubt.unwrap_or(error)),
        };
        identity.compare(&Identity {
            board: link.capabilities().board().to_owned(),
            firmware: link.hello().firmware,
        })?;
        output.summary(&json!({
            "board": link.capabilities().board(),
            "image": image.display().to_string(),
            "firmware": firmware_version(link.hello()),
            "device": link.name(),
        }))
    }

    fn build(&self, output: Output) -> Result<PathBuf, Failure> {
        let folder = self.source.join(self.board.folder);
        let manifest = folder.join("Cargo.toml");
        if !manifest.is_file() {
            return Err(Failure::bad_input(format_args!(
                "`{}` does not hold the firmware: give its folder with --source",
                self.source.display()
            )));
        }
        let mut cargo = Command::new("cargo");
        cargo
            .args(["build", "--release", "--no-default-features", "--features"])
            .arg(self.board.feature)
            .args(["--target", self.board.target, "--bin", self.board.program])
            .current_dir(&folder);
        if output.quiet {
            cargo.arg("--quiet");
        }
        run(
            cargo,
            "cargo",
            &format!("install Rust, then rustup target add {}", self.board.target),
        )?;
        let built = ["target", self.board.target, "release", self.board.program];
        Ok(folder.join(built.iter().collect::<PathBuf>()))
    }
}

/// Board and version of an image, which it has in itself, see `IDENTITY` in `firmware/src/main.rs`.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Identity {
    board: String,
    firmware: [u8; 3],
}

impl std::fmt::Display for Identity {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [major, minor, patch] = self.firmware;
        write!(
            f,
            "board {} with firmware {major}.{minor}.{patch}",
            self.board
        )
    }
}

impl Identity {
    /// Mark before the 16 bytes of the board's name and the 3 bytes of the version.
    const MARK: &'static [u8] = b"haptic-device image\0";

    fn find(image: &[u8]) -> Option<Self> {
        let mut marks = image.windows(Self::MARK.len()).enumerate();
        marks.find_map(|(at, window)| {
            let rest = &image[at + window.len()..];
            let (name, firmware) = (rest.get(..16)?, rest.get(16..19)?);
            let length = name
                .iter()
                .position(|&byte| byte == 0)
                .unwrap_or(name.len());
            let board = std::str::from_utf8(&name[..length]).ok()?;
            let is_name = !board.is_empty() && board.chars().all(|c| c.is_ascii_graphic());
            (window == Self::MARK && is_name).then(|| Self {
                board: board.to_owned(),
                firmware: [firmware[0], firmware[1], firmware[2]],
            })
        })
    }

    /// Checks that the device that answers is the one that was programmed.
    fn compare(&self, device: &Self) -> Result<(), Failure> {
        if self == device {
            return Ok(());
        }
        Err(Failure::Device(anyhow::anyhow!(
            "{device} answers, but the image is for {self}: give --device serial:PATH, or replug it"
        )))
    }
}

/// Reads what an image says of itself, and refuses that of another board.
fn read_identity(board: &Board, image: &Path, bytes: &[u8]) -> Result<Identity, Failure> {
    match Identity::find(bytes) {
        Some(identity) if identity.board == board.name => Ok(identity),
        Some(identity) => Err(Failure::bad_input(format_args!(
            "`{}` is for {identity}, not for {}: change or omit --image",
            image.display(),
            board.name
        ))),
        None => Err(Failure::bad_input(format_args!(
            "`{}` does not say for which board it is: build it from --source",
            image.display()
        ))),
    }
}

/// What programs a board, found before anything is built.
enum Programmer {
    /// probe-rs, for this chip.
    Probe(&'static str),
    /// The drive at this place, which takes such a family of images for this flash.
    Drive(PathBuf, u32, &'static Range<u32>),
}

impl Programmer {
    fn ready(board: &'static Board) -> Result<Self, Failure> {
        match &board.way {
            Way::Probe(chip) => match Command::new("probe-rs").arg("--version").output() {
                Ok(_) => Ok(Self::Probe(chip)),
                Err(error) => Err(Failure::Device(anyhow::anyhow!(
                    "probe-rs is not installed ({error}): run `cargo install probe-rs-tools --locked`"
                ))),
            },
            Way::Drive(id, family, flash) => {
                let place = drive::find(&drive::mounted(), id)?;
                Ok(Self::Drive(place, *family, flash))
            }
        }
    }

    /// Programs the board. A failure is what to say if it does not answer afterwards.
    fn program(&self, image: &Path, bytes: &[u8]) -> Result<Option<Failure>, Failure> {
        match self {
            Self::Probe(chip) => {
                let mut probe = Command::new("probe-rs");
                probe
                    .args(["download", "--chip", chip, "--verify"])
                    .arg(image);
                run(
                    probe,
                    "probe-rs",
                    "plug in the debug port; `probe-rs list` shows the probes",
                )?;
                let mut reset = Command::new("probe-rs");
                reset.args(["reset", "--chip", chip]);
                run(reset, "probe-rs", "unplug the board and plug it in again")?;
                Ok(None)
            }
            Self::Drive(place, family, flash) => {
                let contents = uf2::flash_image(bytes, flash).map_err(|why| {
                    Failure::bad_input(format_args!(
                        "`{}` is not an image for this chip ({why}): change --image or --board",
                        image.display()
                    ))
                })?;
                let blocks = uf2::blocks(&contents, flash.start, *family);
                match drive::write(&place.join("haptic.uf2"), &blocks) {
                    Ok(synced) => Ok(synced.err().map(|error| drive::refused(place, &error))),
                    Err(error) => Err(drive::refused(place, &error)),
                }
            }
        }
    }
}

fn run(mut command: Command, name: &str, advice: &str) -> Result<(), Failure> {
    let status = command
        .stdout(std::io::stderr())
        .status()
        .map_err(|error| {
            Failure::Device(anyhow::anyhow!("cannot run {name}: {error}: {advice}"))
        })?;
    if status.success() {
        Ok(())
    } else {
        Err(Failure::Device(anyhow::anyhow!(
            "{name} ended with {status}: {advice}"
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_image_says_what_it_is() {
        let identity = |board: &str, firmware| Identity {
            board: board.to_owned(),
            firmware,
        };
        let mut image = b"\x7fELF haptic-device image haptic-device image\0".to_vec();
        assert_eq!(Identity::find(&image), None, "cut");
        image.extend(b"nucleo-f446re\0\0\0\x01\x02\x03rest");
        let found = Identity::find(&image).expect("is there");
        assert_eq!(found, identity("nucleo-f446re", [1, 2, 3]));
        assert_eq!(Identity::find(b"nothing"), None);
        found
            .compare(&identity("nucleo-f446re", [1, 2, 3]))
            .expect("the same");
        for other in [
            identity("nucleo-f446re", [1, 2, 2]),
            identity("mps2-an386", [1, 2, 3]),
        ] {
            let error = found.compare(&other).expect_err("another").to_string();
            assert!(
                error.contains("board nucleo-f446re with firmware 1.2.3"),
                "{error}"
            );
            assert!(error.contains(&other.to_string()), "{error}");
        }
    }
}
