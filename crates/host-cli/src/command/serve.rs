//! `serve`: the page in a browser.

use crate::command::conduct::{ThreadArguments, stop_on_interrupt};
use crate::command::materials::Folder;
use crate::files::provenance;
use crate::options::DeviceModelArguments;
use crate::output::{Output, note, warn};
use crate::parse::{choice, whole};
use clap::Args;
use haptic_experiment::{Failure, Imperfections};
use haptic_page::{DeviceNumbers, OnClose, PageServer, ServerOptions};
use serde_json::json;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::Duration;

/// Port of the address where none is given.
const PORT: u16 = 8765;
/// Time between two looks at Ctrl-C.
const LOOK: Duration = Duration::from_millis(100);

pub(crate) const LONG_ABOUT: &str = "\
Opens a page in the browser, served by this program. Three views: Feel, a virtual tissue under \
mouse, finger or arrow keys, its loop at 1 kHz on a simulated device; Design, what is stable and \
passive; Runs, logs of a folder and new ones.

The address has a token that is new each time: only who has it gets in. Nothing listens but \
127.0.0.1, and the page asks nobody else for anything. For a computer elsewhere: \
ssh -L 8765:127.0.0.1:8765 HOST, then the same address.

--device-model sets the simulated device: its friction, delay, lag, encoder and noise, and mass \
and damping for a page that asks for none by itself. A hand in the file is not used: the hand is \
the pointer.

One page holds the controls, others watch. The space bar stops: force zero first. Ctrl-C here does \
the same, closes the page's socket, and ends.";

/// Arguments of `serve`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  host-cli serve\n  host-cli serve --port 0 --no-browser --runs my-results"
)]
pub(crate) struct Arguments {
    /// Port of the address; 0 for any that is free
    #[arg(long, default_value_t = PORT, value_parser = whole::<u16>(0..=u16::MAX))]
    port: u16,
    /// Only print the address
    #[arg(long)]
    no_browser: bool,
    /// Folder of the runs to show, and for new ones
    #[arg(long, value_name = "DIR", default_value = "results")]
    runs: PathBuf,
    /// What becomes of a loop or run when the page that controls it is closed
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
        let stop = stop_on_interrupt()?;
        let file = self.device.read()?;
        let device = file.as_ref().map(|file| DeviceNumbers {
            mass_kg: file.values.mass_kg,
            damping_n_s_per_m: file.values.damping_n_s_per_m,
        });
        let server = PageServer::start(ServerOptions {
            port: self.port,
            runs: self.runs,
            on_close: self.on_close,
            realtime: self.thread.options(None)?,
            library: self.tissues.load()?,
            device: device.unwrap_or_default(),
            imperfections: file.map_or(Imperfections::NONE, |file| file.imperfections()),
            provenance: provenance(),
        })?;
        let address = server.address();
        output.text(&json!({"address": address}), |out| {
            writeln!(out, "{address}\nCtrl-C ends it.")
        })?;
        if !self.no_browser
            && let Err(error) = open::that_detached(address)
        {
            warn(&format!(
                "no browser was opened ({error}): copy the address into one"
            ));
        }
        while !stop.load(Ordering::Relaxed) {
            if let Some(said) = server.notice(LOOK) {
                note("note", said);
            }
        }
        for said in server.stop() {
            note("note", said);
        }
        Ok(())
    }
}
