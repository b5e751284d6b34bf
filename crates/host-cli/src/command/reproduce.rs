//! `reproduce`: every figure of the dissertation, and the verdict on each claim.

use super::experiment::progress_bar;
use crate::failure::Failure;
use crate::folder::{FolderRequest, write_text};
use crate::output::Output;
use crate::reproduce::claims::{COUNT, judge_all};
use crate::reproduce::figures::FIGURES;
use crate::reproduce::report::{ReportFigure, html, markdown};
use crate::reproduce::{Claim, Formulas};
use clap::Args;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Arguments of `reproduce`.
#[derive(Debug, Args)]
#[command(after_help = "Example: host-cli reproduce --out reproduction\n\
                        Writes figure-N.N.csv, .svg and .png, report.md and report.html.")]
pub struct Arguments {
    /// Folder for figures and report
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Replace the files of an earlier reproduction in the folder
    #[arg(long)]
    overwrite: bool,
}

/// The result.
#[derive(Serialize)]
struct Reproduction {
    figures: Vec<Made>,
    claims: Vec<Claim>,
    report: String,
}

#[derive(Serialize)]
struct Made {
    id: &'static str,
    picture: String,
    data: String,
}

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// Files that cannot be written.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let request = |stem: String| FolderRequest {
            out: Some(self.out.clone()),
            stem,
            overwrite: self.overwrite,
            roll_bytes: None,
        };
        let report = self.out.join("report.html");
        if report.exists() && !self.overwrite {
            return Err(Failure::bad_input(format_args!(
                "`{}` already exists: choose another folder with --out, or give --overwrite",
                report.display()
            )));
        }
        let bar = progress_bar((FIGURES.len() + COUNT) as u64, output);
        let mut figures = Vec::new();
        let mut shown = Vec::new();
        for make in FIGURES {
            let figure = make()?;
            let picture = figure.draw()?;
            let folder = request(format!("figure-{}", figure.id)).prepare()?;
            let data = folder.write_table("csv", figure.rows())?;
            let saved = folder.save_picture(&picture)?;
            shown.push(ReportFigure {
                id: figure.id,
                title: figure.title,
                conditions: figure.conditions,
                picture: file_name(&saved),
                data: file_name(&data),
                svg: picture.svg().to_owned(),
            });
            figures.push(Made {
                id: figure.id,
                picture: saved,
                data,
            });
            bar.inc(1);
        }
        let claims = judge_all(&Formulas::default(), &|| bar.inc(1))
            .map_err(|error| Failure::Run(error.into()))?;
        bar.finish_and_clear();
        write_text(
            &self.out.join("report.md"),
            &markdown(&claims, &shown),
            self.overwrite,
        )?;
        write_text(&report, &html(&claims, &shown), self.overwrite)?;
        let result = Reproduction {
            figures,
            claims,
            report: report.display().to_string(),
        };
        output.summary(&result, |out| {
            for claim in &result.claims {
                writeln!(out, "{:<4} {}", claim.id, claim.verdict.words())?;
                writeln!(out, "     A₃     {}", claim.muir.numbers)?;
                writeln!(out, "     exact  {}", claim.exact.numbers)?;
            }
            for figure in &result.figures {
                writeln!(out, "figure {}: {}", figure.id, figure.picture)?;
            }
            writeln!(out, "report: {}", result.report)
        })
    }
}

fn file_name(path: &str) -> String {
    let name = Path::new(path).file_name();
    name.map_or_else(
        || path.to_owned(),
        |name| name.to_string_lossy().into_owned(),
    )
}
