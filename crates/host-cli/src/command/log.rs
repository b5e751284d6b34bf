//! `log`: look into a log, verify it, save what a cut one holds, turn it into CSV or a picture.

use crate::output::Output;
use crate::picture_file;
use clap::{Args, Subcommand};
use haptic_experiment::Failure;
use haptic_figure::{FigureError, MotionFigure, Picture, PlaneFigure};
use haptic_log::record::{
    EndKind, Entry, LogFiles, LogSummary, PerAxis, RECOVERED, RecordError, TickMessage, export_csv,
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
    /// New file, `-` for a CSV on standard output [default: NAME.recovered.mcap or NAME.ticks.csv]
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
            Self::Recover(own) => {
                let target = place(own.target, own.out.as_deref(), &own.log, "recovered.mcap")?;
                let summary = recover(&own.log, &target, own.overwrite)?;
                output.summary(&summary)?;
                require_complete(summary.complete, &own.log, &target.display().to_string())
            }
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
    let reasons = reasons(&summary);
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
    let title = log.file_name().unwrap_or_default().to_string_lossy();
    let figure = picture_file::save(
        draw(&title, &conditions.join("  ·  "), &ticks),
        &stem,
        overwrite,
    )?;
    output.summary(&json!({
        "samples": ticks.len(),
        "complete": complete,
        "figure": figure,
    }))?;
    require_complete(complete, log, &figure)
}

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
            reference_m: &of(0, |tick| tick.reference_m),
            indenter_position_m: &of(0, |tick| tick.indenter_position_m),
            position_m: &of(0, |tick| tick.position_m),
            force_n: &of(0, |tick| tick.commanded_force_n),
            contact_force_n: &of(0, |tick| tick.contact_force_n),
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

/// Why a log is not whole, a few words each; none if it is.
fn reasons(summary: &LogSummary) -> Vec<String> {
    let mut reasons = summary.damage.clone();
    let between: u64 = summary.gaps.iter().map(|gap| gap.missing).sum();
    for (missing, place) in [
        (summary.missing_at_start, "before the first one".to_owned()),
        (between, format!("in {} gaps", summary.gaps.len())),
        (summary.missing_at_end, "after the last one".to_owned()),
    ] {
        if missing > 0 {
            reasons.push(format!("{missing} ticks missing {place}"));
        }
    }
    let flaws = &summary.flaws;
    if flaws.impossible > 0 {
        reasons.push(format!(
            "of {} ticks the device told what cannot be",
            flaws.impossible
        ));
    }
    if flaws.is_stale(summary.samples) {
        reasons.push(stale(summary));
    }
    if summary.out_of_order > 0 {
        reasons.push(format!("{} ticks out of order", summary.out_of_order));
    }
    if !summary.complete && summary.damage.is_empty() {
        reasons.push("it was not finished".to_owned());
    }
    if let Some(end) = &summary.end {
        // A file of a rolled log, and what was saved of a damaged one, do not show all that the run counted.
        let counted = end.dropped_samples > summary.missing_samples && summary.continues.is_none();
        if counted {
            reasons.push(format!(
                "the run counted {} samples and events missing, the log shows {}",
                end.dropped_samples, summary.missing_samples
            ));
        }
        if end.ended == EndKind::Link && end.made_samples < end.planned_samples {
            reasons.push("the link was lost, and what the device still made with it".to_owned());
        }
    }
    reasons
}

/// Ticks that tell of an earlier one, in words.
fn stale(summary: &LogSummary) -> String {
    let flaws = &summary.flaws;
    let parts = [
        (flaws.unanswered, "the board did not answer"),
        (
            flaws.forces_not_taken,
            "it may not have taken the force before",
        ),
        (flaws.late_forces, "an older force of the host acted"),
    ];
    let parts = parts.into_iter().filter(|(count, _)| *count > 0);
    let parts: Vec<String> = parts
        .map(|(count, words)| format!("in {count} {words}"))
        .collect();
    format!(
        "{} of {} ticks are stale: {}",
        flaws.stale,
        summary.samples,
        parts.join(", ")
    )
}

/// What helps a log that is not whole: nothing, where its file is undamaged.
fn advice(summary: &LogSummary) -> &'static str {
    let is_recovered = summary
        .metadata
        .iter()
        .any(|record| record.name == RECOVERED);
    match (summary.complete, is_recovered) {
        (false, _) => "`host-cli log recover` saves what is there",
        (true, true) => "it has all that `host-cli log recover` found, the rest is lost",
        (true, false) => "its file is undamaged: what is missing never reached it",
    }
}
