//! `device flash`: program a board through probe-rs.

use super::PortArguments;
use crate::device::firmware_version;
use crate::failure::Failure;
use crate::output::{Output, note};
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::Command;

const LONG_ABOUT: &str = "\
Builds the firmware for a board and programs it over a debug probe with probe-rs, then greets the \
device and reads back its version. probe-rs is a program of its own: https://probe.rs.";

/// A board of `firmware/`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Board {
    /// NUCLEO-F446RE.
    NucleoF446re,
}

impl Board {
    const fn feature(self) -> &'static str {
        match self {
            Self::NucleoF446re => "board-nucleo-f446re",
        }
    }

    const fn chip(self) -> &'static str {
        match self {
            Self::NucleoF446re => "STM32F446RETx",
        }
    }
}

/// Arguments of `device flash`.
#[derive(Debug, Args)]
#[command(
    long_about = LONG_ABOUT,
    after_help = "Example: host-cli device flash --board nucleo-f446re --device serial:/dev/ttyACM0"
)]
pub struct Arguments {
    /// The board
    #[arg(long, value_enum, default_value = "nucleo-f446re")]
    board: Board,
    /// An image that is built already [default: build it from --source]
    #[arg(long, value_name = "ELF")]
    image: Option<PathBuf>,
    /// Folder of the firmware's sources
    #[arg(long, value_name = "DIR", default_value = "firmware")]
    source: PathBuf,
    #[command(flatten)]
    port: PortArguments,
}

#[derive(Serialize)]
struct Flashed {
    board: String,
    image: String,
    firmware: String,
    device: String,
}

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// Exit code 3: no probe-rs, no probe, a build or programming that failed, no device afterwards.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        require_probe_rs()?;
        let image = match &self.image {
            Some(image) => image.clone(),
            None => self.build(output)?,
        };
        if !image.is_file() {
            return Err(Failure::bad_input(format_args!(
                "there is no image `{}`: give --image, or --source for the folder to build it from",
                image.display()
            )));
        }
        program(self.board, &image, output)?;
        // A board that was just reset needs a moment; its port may go and come back.
        let patience = self
            .port
            .patience()?
            .max(std::time::Duration::from_secs(10));
        let link = self.port.name()?.connect(patience)?;
        let flashed = Flashed {
            board: link.capabilities().board().to_owned(),
            image: image.display().to_string(),
            firmware: firmware_version(link.hello()),
            device: format!("serial:{}", link.path()),
        };
        output.summary(&flashed, |out| {
            writeln!(
                out,
                "board {} at {} runs firmware {}",
                flashed.board, flashed.device, flashed.firmware
            )
        })
    }

    fn build(&self, output: Output) -> Result<PathBuf, Failure> {
        let manifest = self.source.join("Cargo.toml");
        if !manifest.is_file() {
            return Err(Failure::bad_input(format_args!(
                "`{}` does not hold the firmware: run this in the project's folder, or give --source",
                self.source.display()
            )));
        }
        let mut cargo = Command::new("cargo");
        cargo
            .args(["build", "--release", "--no-default-features", "--features"])
            .arg(self.board.feature())
            .args(["--target", TARGET, "--bin", BINARY])
            .current_dir(&self.source);
        if output.quiet {
            cargo.arg("--quiet");
        }
        run(
            cargo,
            "cargo",
            "install Rust from https://rustup.rs and the target with rustup target add thumbv7em-none-eabihf",
        )?;
        Ok(self
            .source
            .join("target")
            .join(TARGET)
            .join("release")
            .join(BINARY))
    }
}

/// What the firmware is built for.
const TARGET: &str = "thumbv7em-none-eabihf";
/// Its program.
const BINARY: &str = "haptic-device";

fn require_probe_rs() -> Result<(), Failure> {
    match Command::new("probe-rs").arg("--version").output() {
        Ok(_) => Ok(()),
        Err(error) => Err(Failure::Device(anyhow::anyhow!(
            "probe-rs, which programs boards, is not installed ({error}): get it with \
             `cargo install probe-rs-tools --locked` or from https://probe.rs, plug the board in by its \
             debug port, and try again"
        ))),
    }
}

fn program(board: Board, image: &Path, output: Output) -> Result<(), Failure> {
    let mut probe = Command::new("probe-rs");
    probe
        .args(["download", "--chip", board.chip(), "--verify"])
        .arg(image);
    run(
        probe,
        "probe-rs",
        "is the board plugged in by its debug port? `probe-rs list` shows the probes",
    )?;
    let mut reset = Command::new("probe-rs");
    reset.args(["reset", "--chip", board.chip()]);
    run(reset, "probe-rs", "unplug the board and plug it in again")?;
    if !output.quiet {
        note("flashed", image.display());
    }
    Ok(())
}

/// Runs a program to its end; its output goes to standard error.
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
