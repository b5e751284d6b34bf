//! `log`: look into a log, verify it, save what a cut one holds, turn it into CSV or a picture.

mod words;

use self::words::{advice, reasons};
use crate::log_plot::LogFigure;
use crate::output::Output;
use crate::picture_file::{self, PictureFileError};
use clap::Subcommand;
use haptic_experiment::Failure;
use haptic_log::record::{
    Entry, LogFiles, RecordError, export_csv, export_csv_to, inspect, recover,
};
use serde::Serialize;
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
    Recover {
        /// The cut or damaged log
        log: PathBuf,
        /// The new log [default: NAME.recovered.mcap beside it]
        target: Option<PathBuf>,
        /// Folder for the new log, if it is not named
        #[arg(long, value_name = "DIR", conflicts_with = "target")]
        out: Option<PathBuf>,
        /// Replace an earlier recovered log
        #[arg(long)]
        overwrite: bool,
    },
    /// Turn a log into CSV, one row per tick
    #[command(after_help = "Example: host-cli log export results/relax-0001/relax.mcap ticks.csv")]
    Export {
        /// The log
        log: PathBuf,
        /// The CSV file, or `-` for standard output [default: NAME.ticks.csv beside it]
        target: Option<PathBuf>,
        /// Folder for the CSV file, if it is not named
        #[arg(long, value_name = "DIR", conflicts_with = "target")]
        out: Option<PathBuf>,
        /// Replace an earlier CSV file
        #[arg(long)]
        overwrite: bool,
    },
    /// Draw positions and forces of a log against time
    #[command(
        after_help = "Example: host-cli log plot results/relax-0001/relax.mcap --out pictures"
    )]
    Plot {
        /// The log
        log: PathBuf,
        /// Folder for NAME.log.svg and NAME.log.png [default: beside the log]
        #[arg(long, value_name = "DIR")]
        out: Option<PathBuf>,
        /// Replace earlier pictures
        #[arg(long)]
        overwrite: bool,
    },
}

/// Result of `log export` and `log plot`.
#[derive(Serialize)]
struct Made {
    samples: u64,
    complete: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    csv: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    figure: Option<String>,
}

impl Command {
    /// Runs the command.
    ///
    /// # Errors
    /// A file that cannot be read or written; for `check` and `recover` a log that is not whole.
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        match self {
            Self::Info { log } => {
                let summary = inspect(&log)?;
                output.report(&summary)
            }
            Self::Check { log } => check(&log, output),
            Self::Recover {
                log,
                target,
                out,
                overwrite,
            } => {
                let target = place(target, out.as_deref(), &log, "recovered.mcap")?;
                save(&log, &target, overwrite, output)
            }
            Self::Export {
                log,
                target,
                out,
                overwrite,
            } => {
                if target.as_deref() == Some(Path::new("-")) {
                    return export_to_output(&log, overwrite, output);
                }
                let target = place(target, out.as_deref(), &log, "ticks.csv")?;
                let done = export_csv(&log, &target, overwrite)?;
                let made = Made {
                    samples: done.rows,
                    complete: done.condition.complete,
                    csv: Some(target.display().to_string()),
                    figure: None,
                };
                output.summary(&made)?;
                require_complete(done.condition.complete, &log, &target)
            }
            Self::Plot {
                log,
                out,
                overwrite,
            } => plot(&log, out.as_deref(), overwrite, output),
        }
    }
}

/// The rows on standard output.
fn export_to_output(log: &Path, overwrite: bool, output: Output) -> Result<(), Failure> {
    if overwrite || output.json {
        return Err(Failure::bad_input(
            "`-` puts the CSV on standard output: leave --overwrite and --json out, they have no effect there",
        ));
    }
    let out = io::BufWriter::new(io::stdout().lock());
    match export_csv_to(log, out, Path::new("standard output")) {
        Ok(done) if done.condition.complete => Ok(()),
        Ok(_) => Err(Failure::DataLost(anyhow::anyhow!(
            "`{}` is not whole; standard output has what could be read",
            log.display()
        ))),
        Err(RecordError::Csv { source, .. }) if is_broken_pipe(&source) => Err(Failure::BrokenPipe),
        // Unlike a file, what was written stays.
        Err(RecordError::Csv { source, .. }) => Err(Failure::DataLost(anyhow::anyhow!(
            "writing standard output failed: {source}; the rows written so far stay, the log is untouched: make \
             space, or export to a file"
        ))),
        Err(error) => Err(error.into()),
    }
}

fn is_broken_pipe(error: &csv::Error) -> bool {
    match error.kind() {
        csv::ErrorKind::Io(error) => error.kind() == io::ErrorKind::BrokenPipe,
        _ => false,
    }
}

/// NAME of NAME.mcap or NAME.mcap.part, with another ending, in the same folder.
fn beside(log: &Path, ending: &str) -> PathBuf {
    let name = log
        .file_name()
        .map(|name| name.to_string_lossy().into_owned());
    let name = name.unwrap_or_default();
    let stem = name.strip_suffix(".part").unwrap_or(&name);
    let stem = stem.strip_suffix(".mcap").unwrap_or(stem);
    log.with_file_name(format!("{stem}.{ending}"))
}

/// The named target, or its default name in the given folder or beside the log.
fn place(
    target: Option<PathBuf>,
    out: Option<&Path>,
    log: &Path,
    ending: &str,
) -> Result<PathBuf, Failure> {
    let default = beside(log, ending);
    match (target, out, default.file_name()) {
        (Some(target), _, _) => Ok(target),
        (None, Some(folder), Some(name)) => {
            std::fs::create_dir_all(folder).map_err(|error| {
                let what = format!(
                    "cannot make the folder `{}`: choose another with --out",
                    folder.display()
                );
                Failure::writing(error, what)
            })?;
            Ok(folder.join(name))
        }
        _ => Ok(default),
    }
}

/// Exit code 4 for a file made of a cut log: it holds all there is, but not all there was.
fn require_complete(complete: bool, log: &Path, made: &Path) -> Result<(), Failure> {
    if complete {
        Ok(())
    } else {
        Err(Failure::DataLost(anyhow::anyhow!(
            "`{}` is not whole; `{}` has what could be read",
            log.display(),
            made.display()
        )))
    }
}

fn check(log: &Path, output: Output) -> Result<(), Failure> {
    let summary = inspect(log)?;
    let reasons = reasons(&summary);
    output.summary(&summary)?;
    if reasons.is_empty() {
        Ok(())
    } else {
        Err(Failure::DataLost(anyhow::anyhow!(
            "`{}` is not whole: {}; {}",
            log.display(),
            reasons.join("; "),
            advice(&summary)
        )))
    }
}

fn save(log: &Path, target: &Path, overwrite: bool, output: Output) -> Result<(), Failure> {
    let summary = recover(log, target, overwrite)?;
    output.summary(&summary)?;
    if !summary.complete {
        Err(Failure::DataLost(anyhow::anyhow!(
            "`{}` was not whole; what it held is in `{}`",
            log.display(),
            target.display()
        )))
    } else {
        Ok(())
    }
}

fn plot(log: &Path, out: Option<&Path>, overwrite: bool, output: Output) -> Result<(), Failure> {
    let mut reader = LogFiles::open(log)?;
    let mut ticks = Vec::new();
    let mut conditions = Vec::new();
    for entry in &mut reader {
        match entry? {
            Entry::Tick(tick) => ticks.push(tick),
            Entry::Metadata(record) if record.name == "experiment" => {
                let named = ["device", "scheme"].into_iter();
                conditions = named
                    .filter_map(|key| Some(format!("{key} {}", record.values.get(key)?)))
                    .collect();
            }
            _ => {}
        }
    }
    let complete = reader.condition().complete;
    if !complete {
        conditions.push("cut off or damaged: what could be read".to_owned());
    }
    let stem = place(None, out, log, "log")?;
    let title = log
        .file_name()
        .map(|name| name.to_string_lossy().into_owned());
    let picture = LogFigure {
        title: title.as_deref().unwrap_or("log"),
        subtitle: &conditions.join("  ·  "),
        ticks: &ticks,
    }
    .draw()
    .map_err(PictureFileError::from)?;
    let saved = picture_file::save(&picture, &stem, overwrite)?;
    let made = Made {
        samples: ticks.len() as u64,
        complete,
        csv: None,
        figure: Some(saved.shown().display().to_string()),
    };
    output.summary(&made)?;
    require_complete(complete, log, saved.shown())
}
