//! `log`: look into a log, verify it, save what a cut one holds, turn it into CSV or a picture.

use crate::output::Output;
use crate::picture_file;
use clap::{Args, Subcommand};
use haptic_experiment::Failure;
use haptic_figure::{FigureError, MotionFigure, MotionRow, Picture, PlaneFigure};
use haptic_log::record::{
    Entry, LogFiles, LogSummary, PerAxis, RECOVERED, RecordError, TickMessage, export_csv,
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
    /// Turn a log into CSV, one row per tick
    #[command(after_help = "Example: host-cli log export results/relax-0001/relax.mcap ticks.csv")]
    Export(Copied),
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
                let summary = inspect(&log)?;
                output.report(&summary)
            }
            Self::Check { log } => check(&log, output),
            Self::Recover(own) => saved(own, "recovered.mcap", output),
            Self::Index(own) => saved(own, "indexed.mcap", output),
            Self::Export(own) => {
                if own.target.as_deref() == Some(Path::new("-")) {
                    return export_to_output(&own.log, own.overwrite, output);
                }
                let target = place(own.target, own.out.as_deref(), &own.log, "ticks.csv")?;
                let done = export_csv(&own.log, &target, own.overwrite)?;
                let complete = done.condition.complete;
                let csv = target.display().to_string();
                output.summary(&json!({
                    "samples": done.rows,
                    "complete": complete,
                    "csv": csv,
                }))?;
                require_complete(complete, &own.log, &csv)
            }
            Self::Plot {
                log,
                out,
                overwrite,
            } => plot(&log, out.as_deref(), overwrite, output),
        }
    }
}

/// All that can be read, in one new log.
fn saved(own: Copied, ending: &str, output: Output) -> Result<(), Failure> {
    let target = place(own.target, own.out.as_deref(), &own.log, ending)?;
    let summary = recover(&own.log, &target, own.overwrite)?;
    output.summary(&summary)?;
    require_complete(summary.complete, &own.log, &target.display().to_string())
}

/// The rows on standard output.
fn export_to_output(log: &Path, overwrite: bool, output: Output) -> Result<(), Failure> {
    if overwrite || output.json {
        return Err(Failure::bad_input(
            "`-` puts the CSV on standard output: omit --overwrite and --json",
        ));
    }
    let out = io::BufWriter::new(io::stdout().lock());
    match export_csv_to(log, out, Path::new("standard output")) {
        Ok(done) => require_complete(done.condition.complete, log, "-"),
        Err(RecordError::Csv { source, .. }) if is_broken_pipe(&source) => Err(Failure::BrokenPipe),
        // Unlike a file, what was written stays.
        Err(RecordError::Csv { source, .. }) => Err(Failure::DataLost(anyhow::anyhow!(
            "writing standard output failed: {source}; the log is untouched: make space and try again"
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

/// The named target, or NAME.ENDING of NAME.mcap or NAME.mcap.part, in the given folder or beside the log.
fn place(
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

/// Exit code 4 for a file made of a cut log: it holds all there is, but not all there was.
fn require_complete(complete: bool, log: &Path, made: &str) -> Result<(), Failure> {
    match complete {
        true => Ok(()),
        false => Err(Failure::DataLost(anyhow::anyhow!(
            "`{}` is not whole; `{made}` has what could be read",
            log.display()
        ))),
    }
}

fn check(log: &Path, output: Output) -> Result<(), Failure> {
    let summary = inspect(log)?;
    let reasons = summary.reasons();
    output.summary(&summary)?;
    match reasons.is_empty() {
        true => Ok(()),
        false => Err(Failure::DataLost(anyhow::anyhow!(
            "`{}` is not whole: {}; {}",
            log.display(),
            reasons.join("; "),
            advice(&summary)
        ))),
    }
}

fn plot(log: &Path, out: Option<&Path>, overwrite: bool, output: Output) -> Result<(), Failure> {
    let mut reader = LogFiles::open(log)?;
    let mut shown = Shown::default();
    let mut conditions = Vec::new();
    for entry in &mut reader {
        match entry? {
            Entry::Tick(tick) => shown.add(tick),
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
    let title = log.file_name().unwrap_or_default().to_string_lossy();
    let figure = picture_file::save(
        draw(&title, &conditions.join("  ·  "), &shown.buckets.concat()),
        &stem,
        overwrite,
    )?;
    output.summary(&json!({
        "samples": shown.samples,
        "complete": complete,
        "figure": figure,
    }))?;
    require_complete(complete, log, &figure)
}

/// Ticks that show a log of any length: of each bucket those where a drawn number is least or largest.
#[derive(Debug, Default)]
struct Shown {
    samples: u64,
    /// Of equally many samples, a power of two.
    buckets: Vec<Vec<TickMessage>>,
    doublings: u32,
}

/// Buckets of a picture: more than it has pixels.
const BUCKETS: usize = 1 << 11;
/// A bucket of fewer ticks is kept as it is; the extremes of five vectors with three axes are fewer.
const BUCKET_FULL: usize = 32;

impl Shown {
    fn add(&mut self, tick: TickMessage) {
        if self.samples & ((1 << self.doublings) - 1) == 0 {
            if self.buckets.len() == BUCKETS {
                self.buckets = self
                    .buckets
                    .chunks(2)
                    .map(|pair| extremes(pair.concat()))
                    .collect();
                self.doublings += 1;
            }
            self.buckets.push(Vec::new());
        }
        self.samples += 1;
        if let Some(bucket) = self.buckets.last_mut() {
            bucket.push(tick);
            if bucket.len() == BUCKET_FULL {
                *bucket = extremes(std::mem::take(bucket));
            }
        }
    }
}

/// Of more ticks than a bucket holds, the first and those with the extremes of what is drawn.
fn extremes(mut ticks: Vec<TickMessage>) -> Vec<TickMessage> {
    if ticks.len() < BUCKET_FULL {
        return ticks;
    }
    let mut keeps = vec![false; ticks.len()];
    keeps[0] = true;
    for numbers in DRAWN {
        for axis in 0..ticks[0].axes() {
            let number = |n: &usize| numbers(&ticks[*n]).get(axis).copied().unwrap_or(f64::NAN);
            let known = || (0..ticks.len()).filter(|n| !number(n).is_nan());
            let by = |a: &usize, b: &usize| number(a).total_cmp(&number(b));
            let ends = [known().min_by(by), known().max_by(by)];
            ends.into_iter().flatten().for_each(|n| keeps[n] = true);
        }
    }
    let mut keeps = keeps.into_iter();
    ticks.retain(|_| keeps.next().unwrap_or(true));
    ticks
}

/// What is drawn of a tick.
const DRAWN: [fn(&TickMessage) -> PerAxis; 5] = [
    |tick| tick.reference_m,
    |tick| tick.indenter_position_m,
    |tick| tick.position_m,
    |tick| tick.commanded_force_n,
    |tick| tick.contact_force_n,
];

/// Positions above, forces below; of several axes the path, places and forces.
fn draw(title: &str, subtitle: &str, ticks: &[TickMessage]) -> Result<Picture, FigureError> {
    let axes = ticks.first().map_or(1, TickMessage::axes);
    let time_s: Vec<f64> = ticks.iter().map(|tick| tick.time_s).collect();
    let of = |axis: usize, field: fn(&TickMessage) -> PerAxis| -> Vec<f64> {
        let numbers = ticks.iter().map(field);
        let numbers = numbers.map(|numbers| numbers.get(axis).copied());
        numbers.map(|number| number.unwrap_or(f64::NAN)).collect()
    };
    if axes == 1 {
        return MotionFigure {
            title,
            subtitle,
            time_s: &time_s,
            rows: &[
                MotionRow {
                    caption: "position",
                    label: "position / mm",
                    scale: 1e3,
                    lines: &[
                        ("reference", &of(0, |tick| tick.reference_m)),
                        ("indenter", &of(0, |tick| tick.indenter_position_m)),
                        ("position", &of(0, |tick| tick.position_m)),
                    ],
                },
                MotionRow {
                    caption: "force",
                    label: "force / N",
                    scale: 1.0,
                    lines: &[
                        ("force", &of(0, |tick| tick.commanded_force_n)),
                        ("contact force", &of(0, |tick| tick.contact_force_n)),
                    ],
                },
            ],
        }
        .draw();
    }
    let [x, y] = [0, 1].map(|axis| of(axis, |tick| tick.position_m));
    let [hand_x, hand_y] = [0, 1].map(|axis| of(axis, |tick| tick.reference_m));
    let forces = (0..axes).map(|axis| of(axis, |tick| tick.commanded_force_n));
    PlaneFigure {
        title,
        subtitle,
        outline_m: &[],
        time_s: &time_s,
        reference_m: [&hand_x, &hand_y],
        position_m: [&x, &y],
        depth_m: None,
        force_n: &forces.collect::<Vec<_>>(),
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
