//! `reproduce`: every figure of the dissertation, and the verdict on each claim.

use super::conduct::{progress_bar, stop_on_interrupt};
use crate::files::{Place, folder, save_picture};
use crate::output::Output;
use crate::picture_file::{Pictures, undrawn};
use clap::Args;
use haptic_experiment::Failure;
use haptic_log::record::NewFileError;
use reproduce::claims::{COUNT, judge_all};
use reproduce::figure::Figure;
use reproduce::figures::FIGURES;
use reproduce::report::{ReportFigure, html, markdown};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

/// Compute the figures of the dissertation again and judge its claims
///
/// Writes figure-N.N.csv, .svg and .png, report.md and report.html. Ctrl-C keeps what is done,
/// writes the report of it and exits with 1.
#[derive(Debug, Args)]
#[command(after_help = "Example: host-cli reproduce --out reproduction")]
pub(crate) struct Arguments {
    /// Folder for figures and report
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Replace the files of an earlier reproduction in the folder
    #[arg(long)]
    overwrite: bool,
    #[command(flatten)]
    pictures: Pictures,
}

impl Arguments {
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        let mut outputs = Place::look(Some(&self.out), "report", self.overwrite, &["html", "md"])?;
        self.check_figures()?;
        let bar = progress_bar((FIGURES.len() + COUNT) as u64, output);
        let mut figures = Vec::new();
        let mut shown = Vec::new();
        let stop = stop_on_interrupt()?;
        let stopped = || stop.load(Ordering::Relaxed);
        for make in FIGURES {
            let figure = make(stop)?;
            // One that was cut short is not what it says.
            if stopped() {
                break;
            }
            // The others, and what the claims are worth, are wanted all the same.
            if let Some((made, in_report)) = outputs.remember(self.save(&figure)) {
                figures.push(made);
                shown.push(in_report);
            }
            bar.inc(1);
        }
        let go_on = || {
            bar.inc(1);
            !stopped()
        };
        let claims = if stopped() {
            Vec::new()
        } else {
            judge_all(&go_on).map_err(Failure::run)?
        };
        bar.finish_and_clear();
        outputs.text("md", &markdown(&claims, &shown));
        // The one to look at; null if it could not be written.
        let report = outputs.text("html", &html(&claims, &shown));
        // Files that exist are complete.
        let ended_early = stopped().then_some("interrupted");
        let (drawn, judged) = (figures.len(), claims.len());
        output.report(&json!({
            "figures": figures,
            "claims": claims,
            "report": report,
            "ended_early": ended_early,
        }))?;
        outputs.close(match ended_early {
            Some(reason) => Err(Failure::run(format_args!(
                "{reason}: {drawn} of {} figures and {judged} of {COUNT} claims are done and kept",
                FIGURES.len()
            ))),
            None => Ok(()),
        })
    }

    /// Refuses figures of an earlier reproduction before hours of work.
    fn check_figures(&self) -> Result<(), Failure> {
        let is_figure = |name: &Path| {
            let extension = name.extension().unwrap_or_default();
            name.to_string_lossy().starts_with("figure-")
                && ["csv", "svg", "png", "pdf"]
                    .iter()
                    .any(|known| extension == *known)
        };
        // A folder that is not there yet has none.
        let entries = std::fs::read_dir(&self.out).into_iter().flatten().flatten();
        let mut names = entries.map(|entry| PathBuf::from(entry.file_name()));
        match names.find(|name| is_figure(name)) {
            Some(taken) if !self.overwrite => {
                Err(NewFileError::Exists(self.out.join(taken)).into())
            }
            _ => Ok(()),
        }
    }

    /// Data and picture of a figure, and what the report shows of it.
    fn save(&self, figure: &Figure) -> Result<(Value, ReportFigure), Failure> {
        let picture = figure.draw().map_err(undrawn)?;
        let stem = format!("figure-{}", figure.id);
        let folder = folder(Some(self.out.clone()), &stem, self.overwrite).prepare()?;
        let data = folder.write_table(&figure.columns(), figure.rows())?;
        let svg = picture.svg().to_owned();
        let saved = save_picture(&folder, Ok(picture), &self.pictures)?;
        let in_report = ReportFigure {
            id: figure.id,
            title: figure.title,
            conditions: figure.conditions.clone(),
            picture: file_name(&saved),
            data: file_name(&data),
            svg,
        };
        let made = json!({"id": figure.id, "picture": saved, "data": data});
        Ok((made, in_report))
    }
}

fn file_name(path: &str) -> String {
    let name = Path::new(path).file_name();
    name.map_or_else(
        || path.to_owned(),
        |name| name.to_string_lossy().into_owned(),
    )
}
