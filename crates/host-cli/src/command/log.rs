//! `log`: look into a log, verify it, save what a damaged one holds, cut a part out, turn it into CSV or a picture.

mod plot;
mod source;

use self::source::{Others, Part, log_at, require_complete, target_of};
use crate::mcap::warn_of_order;
use crate::output::{Output, warn};
use clap::{Args, Subcommand};
use haptic_experiment::Failure;
use haptic_log::record::{
    LogSummary, RECOVERED, RecordError, Span, Topic, cut, export_csv, export_csv_to, inspect,
    recover,
};
use serde_json::json;
use std::io;
use std::path::{Path, PathBuf};

/// Tasks with a log.
#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Describe a log, even a damaged one: samples, times, conditions, events
    #[command(after_help = "Example: host-cli log info results/relax-0001/relax.mcap")]
    Info {
        /// The log
        log: PathBuf,
    },
    /// Check a log: exit code 4 if it is damaged, samples are missing or impossible, or over 1 % are stale
    #[command(after_help = "Example: host-cli log check results/relax-0001/relax.mcap")]
    Check {
        /// The log
        log: PathBuf,
    },
    /// Save the contents of a cut or damaged log as a new one; exit code 4 if anything is missing
    #[command(
        after_help = "Example: host-cli log recover relax.mcap.part saved.mcap\n\
                      The damaged log is left as it is."
    )]
    Recover(Copied),
    /// Turn a log into CSV, one row per tick, or per message of a topic that somebody else wrote
    #[command(after_help = "Example: host-cli log export results/relax-0001/relax.mcap ticks.csv")]
    Export {
        #[command(flatten)]
        copy: Copied,
        #[command(flatten)]
        others: Others,
    },
    /// Copy a part of a log into a new one: samples, events, conditions
    #[command(
        after_help = "Example: host-cli log cut results/relax-0001/relax.mcap push.mcap --from 0.5s --to 2s\n\
                      Times and numbers of the samples stay those of the run."
    )]
    Cut {
        #[command(flatten)]
        copy: Copied,
        #[command(flatten)]
        part: Part,
    },
    /// Draw positions and forces of a log, or of several over each other
    #[command(
        after_help = "Examples: host-cli log plot results/relax-0001 --out pictures\n\
                      \x20         host-cli log plot before.mcap after.mcap --label before,after --difference"
    )]
    Plot(plot::Plot),
}

/// A log, and the file that is made of it.
#[derive(Debug, Args)]
pub(crate) struct Copied {
    /// The log
    log: PathBuf,
    /// New file, `-` for a CSV on standard output [default: NAME.recovered.mcap, NAME.cut.mcap or NAME.ticks.csv]
    target: Option<PathBuf>,
    /// Folder for it, if it is not named [default: that of the log]
    #[arg(long, value_name = "DIR", conflicts_with = "target")]
    out: Option<PathBuf>,
    /// Replace an earlier one
    #[arg(long)]
    overwrite: bool,
}

impl Command {
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        match self {
            Self::Info { log } => output.report(&inspect(&log_at(&log)?)?),
            Self::Check { log } => check(&log_at(&log)?, output),
            Self::Recover(copy) => copy.saved("recovered.mcap", None, output),
            Self::Cut { copy, part } => copy.saved("cut.mcap", Some(part), output),
            Self::Plot(plot) => plot.run(output),
            Self::Export { mut copy, others } => {
                copy.log = log_at(&copy.log)?;
                let topic = others.topic(&copy.log)?;
                if copy.target.as_deref() == Some(Path::new("-")) {
                    return export_to_output(&copy.log, topic, copy.overwrite, output);
                }
                let target = target_of(copy.target, copy.out.as_deref(), &copy.log, "ticks.csv")?;
                let done = match topic {
                    Some(topic) => topic.export_csv(&target, copy.overwrite)?,
                    None => export_csv(&copy.log, &target, copy.overwrite)?,
                };
                warn_of_order(&done.condition);
                let complete = done.is_whole();
                let csv = target.display().to_string();
                output.report(&json!({
                    "samples": done.rows,
                    "complete": complete,
                    "csv": csv,
                }))?;
                require_complete(complete, &copy.log, &csv)
            }
        }
    }
}

impl Copied {
    /// All that can be read, or a part of it, in one new log.
    fn saved(self, ending: &str, part: Option<Part>, output: Output) -> Result<(), Failure> {
        let log = log_at(&self.log)?;
        let span = part.map(Part::span);
        if span == Some(Span::WHOLE) {
            return Err(Failure::bad_input("give --from, --to, or both"));
        }
        let target = target_of(self.target, self.out.as_deref(), &log, ending)?;
        let summary = match span {
            Some(span) => cut(&log, &target, span, self.overwrite)?,
            None => recover(&log, &target, self.overwrite)?,
        };
        output.report(&summary)?;
        require_complete(summary.complete, &log, &target.display().to_string())
    }
}

/// The rows on standard output.
fn export_to_output(
    log: &Path,
    topic: Option<Topic>,
    overwrite: bool,
    output: Output,
) -> Result<(), Failure> {
    if overwrite || output.json {
        return Err(Failure::bad_input(
            "`-` puts the CSV on standard output: omit --overwrite and --json",
        ));
    }
    let out = io::BufWriter::new(io::stdout().lock());
    let name = Path::new("standard output");
    let done = match topic {
        Some(topic) => topic.write_csv(out, name),
        None => export_csv_to(log, out, name),
    };
    match done {
        Ok(done) => {
            warn_of_order(&done.condition);
            require_complete(done.is_whole(), log, "-")
        }
        Err(RecordError::Csv { source, .. }) if is_broken_pipe(&source) => Ok(()),
        // Unlike a file, what was written stays.
        Err(RecordError::Csv { source, .. }) => Err(Failure::data_lost(format_args!(
            "writing standard output failed: {source}; the log is untouched: make space and try again"
        ))),
        Err(error) => Err(error.into()),
    }
}

fn is_broken_pipe(error: &csv::Error) -> bool {
    matches!(error.kind(), csv::ErrorKind::Io(error) if error.kind() == io::ErrorKind::BrokenPipe)
}

fn check(log: &Path, output: Output) -> Result<(), Failure> {
    let summary = inspect(log)?;
    if let Some(first) = &summary.continues {
        warn(&format!(
            "this file goes on where another ended, and nothing before it was looked at: check {first} for the whole log"
        ));
    }
    let reasons = summary.reasons();
    output.report(&summary)?;
    if reasons.is_empty() {
        Ok(())
    } else {
        Err(Failure::data_lost(format_args!(
            "`{}` is not whole: {}; {}",
            log.display(),
            reasons.join("; "),
            advice(&summary)
        )))
    }
}

/// Advice for an incomplete log; if its file is undamaged, nothing more can be saved.
fn advice(summary: &LogSummary) -> &'static str {
    let is_recovered = summary
        .metadata
        .iter()
        .any(|record| record.name == RECOVERED);
    match (summary.complete, is_recovered) {
        (false, _) => "`host-cli log recover` saves what is there",
        (true, true) => "it has all that `host-cli log recover` found, and what is missing is lost",
        (true, false) => "its file is undamaged: what is missing never reached it",
    }
}
