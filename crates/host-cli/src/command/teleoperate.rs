//! `teleoperate`: one side of a teleoperation, the other in another process.

use crate::command::conduct::{both_saved, drawn, lacks, stop_on_interrupt};
use crate::files::RunFiles;
use crate::options::{Options, keys};
use crate::output::{Output, note, warn};
use crate::parse::{WAITS, quantity};
use crate::picture_file::Pictures;
use clap::Args;
use haptic_document::Document;
use haptic_experiment::DocumentOfKind as _;
use haptic_experiment::experiment::{End, FarReport, Terms};
use haptic_experiment::judge::Published;
use haptic_experiment::parameters;
use haptic_experiment::{ExperimentFile, Failure};
use haptic_run::Supervisor;
use haptic_run::read_document;
use std::io::{self, Write};
use std::net::{SocketAddr, ToSocketAddrs};
use std::path::PathBuf;
use std::time::Duration;

/// Run one side of a teleoperation, with the other side in another process
///
/// Each side has a simulated device that runs by the clock, and sends UDP datagrams to the other.
/// The side that listens is the slave, in the remote tissue or wall; the side that connects is the
/// master, in the hand. Both need the same [teleoperation] file; a side with other values is
/// refused.
///
/// Late, repeated and foreign messages are refused and counted. If the other side is silent for
/// `silence_s`, or this machine skips more than --skipped-most of the ticks, the force ramps to
/// zero within `stop_time_s` and the exit code is 1. Ctrl-C does the same and ends the other side
/// too.
///
/// If the sum of `given_j` of both sides is above 0, the line gave energy.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli teleoperate experiments/teleoperation.toml --listen 127.0.0.1:4810\n         \
                  host-cli teleoperate experiments/teleoperation.toml --connect 127.0.0.1:4810"
)]
pub(crate) struct Arguments {
    /// File with a table [teleoperation] [default: its defaults]
    #[arg(value_name = "FILE.toml")]
    file: Option<PathBuf>,
    /// Be the slave and wait for the master at this address and port; port 0 for any free one
    #[arg(long, value_name = "ADDRESS:PORT")]
    listen: Option<String>,
    /// Be the master and connect to the slave at this address and port
    #[arg(long, value_name = "ADDRESS:PORT", conflicts_with = "listen")]
    connect: Option<String>,
    #[command(flatten)]
    options: Options<keys::Teleoperate>,
    /// Run the slave even if the analysis calls it unstable in its remote environment
    #[arg(long)]
    force_unstable: bool,
    /// How long to wait for the other side
    #[arg(long, value_name = "TIME", value_parser = quantity("_s", WAITS), default_value = "60s")]
    patience: f64,
    /// Largest share of the ticks that this machine may skip
    #[arg(long, value_parser = quantity("", parameters::LINE_LOSS.range()), value_name = "SHARE")]
    #[arg(default_value = "10%")]
    skipped_most: f64,
    #[command(flatten)]
    files: RunFiles,
    #[command(flatten)]
    pictures: Pictures,
}

impl Arguments {
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        let document = self.document()?;
        if let Some(changed) = document.changed_since_log() {
            warn(&changed);
        }
        let mut experiment = ExperimentFile::open(&document).map_err(Failure::input)?;
        if self.force_unstable {
            experiment = experiment.though_unstable()?;
        }
        let terms = Terms {
            patience: Duration::from_secs_f64(self.patience),
            skipped_most: self.skipped_most,
        };
        let end = self.end()?;
        let stop = stop_on_interrupt()?;
        let opened = |address| {
            let (what, address) = match end {
                End::Listen(_) => ("listening", address),
                End::Connect(address) => ("connecting", address),
            };
            if output.json {
                note(what, address);
            } else if !output.quiet {
                // A closed standard output is seen at the end.
                let _ = writeln!(io::stdout(), "{what}: {address}");
            }
        };
        let mut request = self.files.folder(&end.side().to_string())?;
        document.keep_in(&mut request.provenance)?;
        let supervisor = Supervisor {
            stop,
            progress: &|_| {},
            live: None,
            warn: &|text| output.warn(text),
        };
        let run = experiment.run_side(end, terms, &opened, &request, supervisor)?;
        let report = shown(run, &self.pictures, output)?;
        report.require()
    }

    fn document(&self) -> Result<Document, Failure> {
        let (defaults, options) = (Document::new("teleoperation"), self.options.clone());
        match &self.file {
            None => options.over(defaults),
            // Without a file the first value stands in its place.
            Some(first) if first.to_string_lossy().contains('=') && !first.exists() => {
                options.and(&first.to_string_lossy()).over(defaults)
            }
            Some(path) => options.over(read_document(path)?),
        }
    }

    fn end(&self) -> Result<End, Failure> {
        let address = |text: &str, option: &str| -> Result<SocketAddr, Failure> {
            let found = text.to_socket_addrs().ok();
            found.and_then(|mut all| all.next()).ok_or_else(|| {
                Failure::bad_input(format_args!(
                    "\"{text}\" is not an address with a port: give {option}, as 127.0.0.1:4810"
                ))
            })
        };
        match (&self.listen, &self.connect) {
            (_, Some(text)) => Ok(End::Connect(address(text, "--connect")?)),
            (Some(text), None) => Ok(End::Listen(address(text, "--listen")?)),
            (None, None) => Err(Failure::bad_input(
                "this side is missing: give --listen ADDRESS:PORT, or --connect ADDRESS:PORT",
            )),
        }
    }
}

/// Draws and prints, and then reports write errors.
fn shown(
    run: Published<FarReport>,
    pictures: &Pictures,
    output: Output,
) -> Result<FarReport, Failure> {
    let Published {
        mut report,
        curves,
        folder,
    } = run;
    let (picture, unsaved) = drawn(curves, &folder, pictures);
    report.figure = picture;
    output.report(&report)?;
    let unwritten = report.unwritten.as_ref();
    let table = unwritten.map(|lost| Failure::data_lost(format_args!("{lost}")));
    both_saved(table, unsaved)?;
    match report.dropped_samples {
        0 => Ok(report),
        dropped => Err(lacks(dropped, &report.log)),
    }
}
