//! `serve`: the page in a browser.

use crate::command::conduct::{ThreadArguments, stop_on_interrupt};
use crate::command::materials::Folder;
use crate::files::provenance;
use crate::options::DeviceModelArguments;
use crate::output::{Output, note, warn};
use crate::parse::{choice, whole};
use clap::Args;
use haptic_experiment::Failure;
use haptic_page::{DeviceNumbers, OnClose, PageServer, ServerOptions};
use serde_json::json;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::Duration;

/// Port of the address where none is given.
const PORT: u16 = 8765;
/// Time between two looks at Ctrl-C.
const LOOK: Duration = Duration::from_millis(100);

/// Serve a page in the browser: feel a tissue, see what is stable, watch and start runs
///
/// The page has four views. Feel: a virtual tissue under mouse, finger or arrow keys, rendered at 1
/// kHz on a simulated device. Design: which walls are stable and passive. Runs: the logs of a
/// folder, and forms to start new runs. Control: a fractional controller for a plant, beside the
/// best PID.
///
/// The server listens on 127.0.0.1 only, and its address contains a secret token that changes at
/// each start. The page loads nothing from elsewhere. From another computer: ssh -L
/// 8765:127.0.0.1:8765 HOST, then open the same address.
///
/// FILE is felt when the page opens: the wall of an experiment file, such as `design` writes, or of
/// its log, on the device that it names; or a tissue. What is unstable is refused.
///
/// --device-model sets the simulated device, but for the numbers that the page or FILE set. A hand
/// in the file has no effect, because the pointer is the hand.
///
/// One page has the controls, the others watch. The space bar stops: the force falls to zero, then
/// the run ends. Ctrl-C in the terminal does the same and ends the server.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  host-cli serve\n  host-cli serve experiments/wall.toml\n  host-cli serve --port 0 --no-browser --runs my-results"
)]
pub(crate) struct Arguments {
    /// Experiment file with [wall], its log, or a tissue file: felt when the page opens
    #[arg(value_name = "FILE")]
    file: Option<PathBuf>,
    /// Port; 0 for any free one
    #[arg(long, default_value_t = PORT, value_parser = whole::<u16>(0..=u16::MAX))]
    port: u16,
    /// Print the address without opening a browser
    #[arg(long)]
    no_browser: bool,
    /// Folder with runs to show, and for new runs
    #[arg(long, value_name = "DIR", default_value = "results")]
    runs: PathBuf,
    /// What happens to a loop or run when the page with the controls is closed
    #[arg(long, value_parser = choice::<OnClose>(), default_value = "stop")]
    on_close: OnClose,
    #[command(flatten)]
    device: DeviceModelArguments,
    #[command(flatten)]
    tissues: Folder,
    #[command(flatten)]
    thread: ThreadArguments,
}

impl Arguments {
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        if self.runs.is_file() {
            return Err(Failure::bad_input(format_args!(
                "--runs `{}` is a file: give a folder",
                self.runs.display()
            )));
        }
        let stop = stop_on_interrupt()?;
        let mut server = PageServer::start(ServerOptions {
            port: self.port,
            runs: self.runs,
            on_close: self.on_close,
            realtime: self.thread.options(None)?,
            library: self.tissues.load()?,
            device: (self.device.read()?)
                .map_or_else(DeviceNumbers::default, |file| file.values.into()),
            opens: self.file,
            provenance: provenance(),
        })?;
        let address = server.address();
        output.text(&json!({"address": address}), |out| {
            writeln!(out, "{address}\nCtrl-C ends it.")
        })?;
        if !self.no_browser
            && let Err(error) = server.opener().and_then(open::that_detached)
        {
            warn(&format!(
                "no browser was opened ({error}): copy the address into one"
            ));
        }
        while !stop.load(Ordering::Relaxed) {
            if let Some(notice) = server.notice(LOOK) {
                note("note", notice);
            }
        }
        for last in server.stop() {
            note("note", last);
        }
        Ok(())
    }
}
