//! `top`: the live figures of a run on a terminal.

use super::stop::stop_on_interrupt;
use crate::output::Output;
use crate::top::follow::Run;
use crate::top::screen::show;
use clap::Args;
use haptic_experiment::failure::Failure;
use serde::Serialize;
use std::path::PathBuf;

pub(crate) const LONG_ABOUT: &str = "\
Shows a run of another process while it goes, on a terminal, over ssh too: position and force, tick, limiters, what is \
lost, faults. It reads the log that the run writes, so what it shows is 0.1 s old, and the run is not touched.

Without a run it takes the newest that goes on under results/, and waits for one if there is none. q ends the view, and \
the run goes on. With --json it prints the figures of the moment and ends.";

/// Arguments of `top`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  host-cli relax --out run --realtime &\n  host-cli top --attach run\n  host-cli top --json --attach run/relax.mcap"
)]
pub struct Arguments {
    /// Folder of a run, or its log, whole or not [default: the newest that goes on under results]
    #[arg(value_name = "RUN", conflicts_with = "attach")]
    run: Option<PathBuf>,
    /// The same by name
    #[arg(long, value_name = "RUN")]
    attach: Option<PathBuf>,
}

/// Figures as JSON.
#[derive(Serialize)]
struct Snapshot<'a> {
    log: String,
    state: String,
    running: bool,
    deleted: bool,
    #[serde(flatten)]
    figures: &'a crate::top::figures::Figures,
}

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// No such run, a file that is no log; no terminal.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let stop = stop_on_interrupt()?;
        let run = match self.run.as_ref().or(self.attach.as_ref()) {
            Some(path) => Some(Run::attach(path)?),
            None => Run::newest()?,
        };
        if !output.json {
            return show(run, stop);
        }
        let mut run = run.ok_or_else(|| {
            Failure::bad_input("no run goes on under `results`: give the folder of one, host-cli top FOLDER --json")
        })?;
        while run.read()? {}
        let (state, _) = run.state();
        let snapshot = Snapshot {
            log: run.path().display().to_string(),
            state,
            running: run.goes_on(),
            deleted: run.is_deleted(),
            figures: &run.figures,
        };
        output.print(&snapshot, |_| Ok(()))
    }
}
