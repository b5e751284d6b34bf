//! Logs as they are named, and the files that are made of them.

use crate::mcap;
use crate::parse::quantity;
use clap::Args;
use haptic_experiment::Failure;
use haptic_experiment::parameters::Range;
use haptic_log::record::{Span, Topic, first_file};
use std::path::{Path, PathBuf};

/// Times that a log can hold, s.
const TIMES: Range = Range::Within(0.0, 1.8e10);

/// Selection from a log that another program wrote.
#[derive(Debug, Args)]
pub(crate) struct Others {
    /// Of a log of others: a topic or some of its columns, as in /wrench or /wrench.force.x,/wrench.force.y
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    columns: Vec<String>,
}

impl Others {
    /// The topic that was asked for, or the one of a log without ticks.
    pub(super) fn topic(&self, log: &Path) -> Result<Option<Topic>, Failure> {
        let names: Vec<&str> = self.columns.iter().map(String::as_str).collect();
        if names.is_empty() && mcap::is_ours(log)? {
            return Ok(None);
        }
        mcap::chosen(log, &names).map(Some)
    }
}

/// A part of a log.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct Part {
    /// Begin at this time of the log [default: its first sample]
    #[arg(long, value_name = "TIME", value_parser = quantity("from_s", TIMES))]
    from: Option<f64>,
    /// End at this time of the log [default: its last sample]
    #[arg(long, value_name = "TIME", value_parser = quantity("to_s", TIMES))]
    to: Option<f64>,
}

impl Part {
    pub(super) fn span(self) -> Span {
        Span {
            from_s: self.from.unwrap_or(Span::WHOLE.from_s),
            to_s: self.to.unwrap_or(Span::WHOLE.to_s),
        }
    }
}

/// The log that is named, by itself or as the one in a folder: there the finished ones count, or else the unfinished, and
/// the further files of a log are read with its first.
pub(super) fn log_at(path: &Path) -> Result<PathBuf, Failure> {
    let Ok(files) = std::fs::read_dir(path) else {
        if path.exists() {
            return Ok(path.to_owned());
        }
        let (path, here) = (path.display(), std::env::current_dir().unwrap_or_default());
        let here = here.display();
        return Err(Failure::bad_input(format_args!(
            "cannot read `{path}`: No such file in {here}: give the NAME.mcap that a run wrote, or its folder, as results/relax-0001"
        )));
    };
    let files: Vec<PathBuf> = files.filter_map(|file| Some(file.ok()?.path())).collect();
    let with_ending = |ending: &str| {
        let is_one = |file: &&PathBuf| file.extension().is_some_and(|end| end == ending);
        files.iter().filter(is_one).cloned().collect::<Vec<_>>()
    };
    let mut logs = with_ending("mcap");
    if logs.is_empty() {
        logs = with_ending("part");
    }
    let goes_on = |log: &&PathBuf| first_file(log).is_some_and(|first| logs.contains(&first));
    let mut firsts: Vec<&PathBuf> = logs.iter().filter(|log| !goes_on(log)).collect();
    firsts.sort();
    let names = firsts.iter().map(|log| log.display().to_string());
    let remedy = match &firsts[..] {
        [log] => return Ok((*log).clone()),
        [] => "a NAME.mcap, and none is in it".to_owned(),
        _ => names.collect::<Vec<_>>().join(" or "),
    };
    let folder = path.display();
    Err(Failure::bad_input(format_args!(
        "`{folder}` is a folder: give {remedy}"
    )))
}

/// The named target, or NAME.ENDING of NAME.mcap or NAME.mcap.part, in the given folder or beside the log.
pub(super) fn target_of(
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
pub(super) fn require_complete(complete: bool, log: &Path, made: &str) -> Result<(), Failure> {
    if complete {
        Ok(())
    } else {
        Err(Failure::data_lost(format_args!(
            "`{}` is not whole; `{made}` has what could be read",
            log.display()
        )))
    }
}
