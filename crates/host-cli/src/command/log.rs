//! `log`: look into a log, verify it, save what a cut one holds, turn it into CSV or a picture.

use crate::mcap;
use crate::output::{Output, warn};
use crate::picture_file::Pictures;
use clap::{Args, Subcommand};
use haptic_experiment::Failure;
use haptic_experiment::judge::Decimated;
use haptic_figure::{FigureError, MotionFigure, MotionRow, Picture, PlaneFigure};
use haptic_log::record::{
    Entry, LogFiles, LogSummary, PerAxis, RECOVERED, RecordError, TickMessage, Topic, export_csv,
    export_csv_to, inspect, recover,
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
    /// Copy a log of an earlier version, which has no index beyond 1.8 h, into one with an index
    #[command(after_help = "Example: host-cli log index day.mcap day-indexed.mcap")]
    Index(Copied),
    /// Turn a log into CSV, one row per tick, or per message of a topic that somebody else wrote
    #[command(after_help = "Example: host-cli log export results/relax-0001/relax.mcap ticks.csv")]
    Export {
        #[command(flatten)]
        copy: Copied,
        #[command(flatten)]
        others: Others,
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
        #[command(flatten)]
        pictures: Pictures,
        #[command(flatten)]
        others: Others,
    },
}

/// What is taken of a log that somebody else wrote.
#[derive(Debug, Args)]
pub(crate) struct Others {
    /// Of a log of others: a topic or some of its columns, as in /wrench or /wrench.force.x,/wrench.force.y
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    columns: Vec<String>,
}

/// A log, and the file that is made of it.
#[derive(Debug, Args)]
pub(crate) struct Copied {
    /// The log
    log: PathBuf,
    /// New file, `-` for a CSV on standard output [default: NAME.recovered.mcap, NAME.indexed.mcap or NAME.ticks.csv]
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
            Self::Info { log } => {
                no_folder(&log)?;
                let summary = inspect(&log)?;
                output.report(&summary)
            }
            Self::Check { log } => check(&log, output),
            Self::Recover(copy) => saved(copy, "recovered.mcap", output),
            Self::Index(copy) => saved(copy, "indexed.mcap", output),
            Self::Export { copy, others } => {
                let topic = others.topic(&copy.log)?;
                if copy.target.as_deref() == Some(Path::new("-")) {
                    return export_to_output(&copy.log, topic, copy.overwrite, output);
                }
                let target = target_of(copy.target, copy.out.as_deref(), &copy.log, "ticks.csv")?;
                let done = match topic {
                    Some(topic) => topic.export_csv(&target, copy.overwrite)?,
                    None => export_csv(&copy.log, &target, copy.overwrite)?,
                };
                let complete = done.condition.complete;
                let csv = target.display().to_string();
                output.summary(&json!({
                    "samples": done.rows,
                    "complete": complete,
                    "csv": csv,
                }))?;
                require_complete(complete, &copy.log, &csv)
            }
            Self::Plot {
                log,
                out,
                overwrite,
                pictures,
                others,
            } => {
                let stem = target_of(None, out.as_deref(), &log, "log")?;
                let save = |picture| pictures.save(picture, &stem, overwrite);
                plot(&log, save, others.topic(&log)?, output)
            }
        }
    }
}

/// Refuses a folder, and names the logs in it.
fn no_folder(path: &Path) -> Result<(), Failure> {
    let Ok(files) = std::fs::read_dir(path) else {
        return Ok(());
    };
    let files = files.filter_map(|file| Some(file.ok()?.path()));
    let logs = files.filter(|file| file.extension().is_some_and(|end| end == "mcap"));
    let mut logs: Vec<String> = logs.map(|log| log.display().to_string()).collect();
    logs.sort();
    let remedy = match logs.is_empty() {
        true => "a NAME.mcap, and none is in it".to_owned(),
        false => logs.join(" or "),
    };
    Err(Failure::bad_input(format_args!(
        "`{}` is a folder: give {remedy}",
        path.display()
    )))
}

/// All that can be read, in one new log.
fn saved(copy: Copied, ending: &str, output: Output) -> Result<(), Failure> {
    let target = target_of(copy.target, copy.out.as_deref(), &copy.log, ending)?;
    let summary = recover(&copy.log, &target, copy.overwrite)?;
    output.summary(&summary)?;
    require_complete(summary.complete, &copy.log, &target.display().to_string())
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
        Ok(done) => require_complete(done.condition.complete, log, "-"),
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

/// The named target, or NAME.ENDING of NAME.mcap or NAME.mcap.part, in the given folder or beside the log.
fn target_of(
    target: Option<PathBuf>,
    out: Option<&Path>,
    log: &Path,
    ending: &str,
) -> Result<PathBuf, Failure> {
    if let Some(target) = target {
        return Ok(target);
    }
    let name = log.file_name().unwrap_or_default().to_string_lossy();
    let stem = name.strip_suffix(".part").unwrap_or(&name);
    let stem = stem.strip_suffix(".mcap").unwrap_or(stem);
    let default = log.with_file_name(format!("{stem}.{ending}"));
    let (Some(folder), Some(name)) = (out, default.file_name()) else {
        return Ok(default);
    };
    std::fs::create_dir_all(folder).map_err(|error| {
        let shown = folder.display();
        let what = format!("cannot make the folder `{shown}`: choose another with --out");
        Failure::writing(error, what)
    })?;
    Ok(folder.join(name))
}

impl Others {
    /// The topic that was asked for, or the one of a log without ticks.
    fn topic(&self, log: &Path) -> Result<Option<Topic>, Failure> {
        let names: Vec<&str> = self.columns.iter().map(String::as_str).collect();
        if names.is_empty() && mcap::is_ours(log)? {
            return Ok(None);
        }
        mcap::chosen(log, &names).map(Some)
    }
}

/// Columns of a topic that one picture holds.
const PANELS: usize = 6;

/// Each column of a topic in a panel of its own.
fn draw_topic(title: &str, topic: &Topic) -> Result<Drawn, Failure> {
    let (time, columns) = topic.columns.split_at(1);
    if columns.len() > PANELS {
        let (name, count) = (&topic.name, columns.len());
        let some = format!("give --columns some of them, as in {name}.{}", columns[0].0);
        return Err(Failure::bad_input(format_args!(
            "{name} has {count} columns, and a picture has room for {PANELS}: {some}"
        )));
    }
    let mut shown = Decimated::<PANELS>::new(DENSE);
    for (row, &time_s) in time[0].1.iter().enumerate() {
        let at = |n: usize| columns.get(n).map_or(f64::NAN, |(_, column)| column[row]);
        shown.add(time_s, std::array::from_fn(at));
    }
    let (samples, time_s, curves) = shown.curves();
    let lines: Vec<_> = curves
        .iter()
        .map(|curve| [("", curve.as_slice())])
        .collect();
    let rows = std::iter::zip(columns, &lines).map(|((caption, _), lines)| MotionRow {
        caption,
        label: "",
        scale: 1.0,
        lines,
    });
    let figure = MotionFigure {
        title,
        subtitle: &topic.name,
        time_s: &time_s,
        rows: &rows.collect::<Vec<_>>(),
    };
    Ok((samples, topic.condition.complete, figure.draw()))
}

/// Exit code 4 for a file made of a cut log: it holds all there is, but not all there was.
fn require_complete(complete: bool, log: &Path, made: &str) -> Result<(), Failure> {
    match complete {
        true => Ok(()),
        false => Err(Failure::data_lost(format_args!(
            "`{}` is not whole; `{made}` has what could be read",
            log.display()
        ))),
    }
}

fn check(log: &Path, output: Output) -> Result<(), Failure> {
    no_folder(log)?;
    let summary = inspect(log)?;
    if let Some(first) = &summary.continues {
        warn(&format!(
            "this file goes on where another ended, and nothing before it was looked at: check {first} for the whole log"
        ));
    }
    let reasons = summary.reasons();
    output.summary(&summary)?;
    match reasons.is_empty() {
        true => Ok(()),
        false => Err(Failure::data_lost(format_args!(
            "`{}` is not whole: {}; {}",
            log.display(),
            reasons.join("; "),
            advice(&summary)
        ))),
    }
}

fn plot(
    log: &Path,
    save: impl FnOnce(Result<Picture, FigureError>) -> Result<String, Failure>,
    topic: Option<Topic>,
    output: Output,
) -> Result<(), Failure> {
    let title = log.file_name().unwrap_or_default().to_string_lossy();
    let (samples, complete, picture) = match topic {
        Some(topic) => draw_topic(&title, &topic)?,
        None => draw_ticks(&title, log)?,
    };
    let figure = save(picture)?;
    output.summary(&json!({
        "samples": samples,
        "complete": complete,
        "figure": figure,
    }))?;
    require_complete(complete, log, &figure)
}

/// Samples, whether they are all, and their picture.
type Drawn = (u64, bool, Result<Picture, FigureError>);

fn draw_ticks(title: &str, log: &Path) -> Result<Drawn, Failure> {
    let mut reader = LogFiles::open(log)?;
    let (mut shown, mut axes) = (Decimated::new(DENSE), 1);
    let mut conditions = Vec::new();
    for entry in &mut reader {
        let entry = entry?;
        if let Entry::Tick(tick) = &entry {
            axes = tick.axes();
            shown.add(tick.time_s, drawn(tick));
        } else if let Entry::Metadata(record) = &entry
            && record.name == "experiment"
        {
            let named = ["device", "scheme"].into_iter();
            conditions = named
                .filter_map(|key| Some(format!("{key} {}", record.values.get(key)?)))
                .collect();
        }
    }
    let complete = reader.condition().complete;
    if !complete {
        conditions.push("cut off or damaged: what could be read".to_owned());
    }
    let (samples, time_s, curves) = shown.curves();
    let picture = draw(title, &conditions.join("  ·  "), axes, &time_s, &curves);
    Ok((samples, complete, picture))
}

/// Samples of which each is drawn; of more the extremes.
const DENSE: u64 = 100_000;

/// What is drawn of a tick: reference, indenter and position on the first axis, reference and position on the second, the
/// force on all three, and the contact force.
fn drawn(tick: &TickMessage) -> [f64; 9] {
    let on = |numbers: PerAxis, axis: usize| numbers.get(axis).copied().unwrap_or(f64::NAN);
    let along = [tick.reference_m, tick.indenter_position_m, tick.position_m];
    std::array::from_fn(|n| match n {
        0..=2 => on(along[n], 0),
        3..=4 => on([tick.reference_m, tick.position_m][n - 3], 1),
        5..=7 => on(tick.commanded_force_n, n - 5),
        _ => on(tick.contact_force_n, 0),
    })
}

/// Positions above, forces below; of several axes the path, places and forces.
fn draw(
    title: &str,
    subtitle: &str,
    axes: usize,
    time_s: &[f64],
    curves: &[Vec<f64>; 9],
) -> Result<Picture, FigureError> {
    let [reference, indenter, position] = [0, 1, 2].map(|n| curves[n].as_slice());
    let forces = &curves[5..8];
    if axes == 1 {
        let felt: Vec<f64> = forces[0].iter().map(|force| 0.0 - force).collect();
        return MotionFigure {
            title,
            subtitle,
            time_s,
            rows: &[
                MotionRow {
                    caption: "position",
                    label: "position / mm",
                    scale: 1e3,
                    lines: &[
                        ("reference", reference),
                        ("indenter", indenter),
                        ("position", position),
                    ],
                },
                MotionRow {
                    // A log has the force on the device along the position; a picture what pushes back.
                    caption: "force on the hand",
                    label: "force on the hand / N",
                    scale: 1.0,
                    lines: &[("force", &felt), ("contact force", &curves[8])],
                },
            ],
        }
        .draw();
    }
    PlaneFigure {
        title,
        subtitle,
        outline_m: &[],
        time_s,
        reference_m: [reference, &curves[3]],
        position_m: [position, &curves[4]],
        depth_m: None,
        force_n: &forces[..axes],
    }
    .draw()
}

/// What helps a log that is not whole: nothing, where its file is undamaged.
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
