//! `design`: the stiffest wall, the most damping or the closest tissue, and which order does it.

mod coupler;
mod draw;

use crate::command::conduct::progress_bar;
use crate::files::{Place, save_picture};
use crate::keys;
use crate::options::Options;
use crate::output::{Output, note};
use clap::Args;
use draw::draw;
use haptic_experiment::document::Document;
use haptic_experiment::question::Question;
use haptic_experiment::question::design::{Design, DesignReport};
use haptic_experiment::run::write_text;
use haptic_experiment::{Failure, TrialVerdict};
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

pub(crate) const LONG_ABOUT: &str = "\
From a device and a wish to a wall: the largest stiffness K and dissipation B for each order, and the order that does best. \
The analysis finds them, with the device's delay and current lag; the best is then tried on the simulated device, with friction and encoder too.

Wishes:
  stiffest-wall   the largest K
  most-damping    the largest effective damping at --frequency
  tissue          does a specimen of --tissue fit, and how much larger may it be? If it does not, which order comes closest at --frequency?
  coupler         the virtual coupler damper + spring (T/(1-w))^mu that feels stiffest at --frequency, absolutely stable by Llewellyn's criterion and \
with a gain margin of 2 in the sampled loop. --require passive asks for passivity with every hand and object instead

Without a device file or friction, delay, current_lag, encoder_resolution or sensor_noise the device is ideal; the report then also shows the best \
wall on the laboratory device. --force-noise-limit bounds the force noise that encoder and sensor cause.

--out writes design.toml for `host-cli run`, design.csv and a picture. The exit code is 1 if no candidate is found or the best does not come to rest.";

/// Arguments of `design`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  host-cli design --delay 1ms --out design\n  \
                  host-cli design --wish most-damping --frequency 5Hz --require passive\n  \
                  host-cli design --wish tissue --tissue prostate-cancerous encoder_resolution=30um"
)]
pub struct Arguments {
    #[command(flatten)]
    options: Options<keys::Design>,
    /// Folder for design.toml, design.csv and a picture
    #[arg(long, value_name = "DIR", help_heading = "Files")]
    out: Option<PathBuf>,
    /// Replace the files of an earlier design in the folder
    #[arg(long, help_heading = "Files")]
    overwrite: bool,
}

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A parameter outside its range; files that cannot be written; a best candidate that is not
    /// stable when it is tried.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let mut place = Place::look(self.out.as_deref(), "design", self.overwrite, &["toml"])?;
        let document = self.options.clone().over(Document::new("design"))?;
        let design = match Question::open(&document).map_err(Failure::input)? {
            Question::Design(design) => design,
            Question::Coupler(coupler) => return self.coupler(&coupler, place, output),
            Question::ZWidth(_) => return Err(Failure::bad_input("not a design")),
        };
        let bar = progress_bar(design.orders_to_try().len() as u64, output);
        let answer = design.answer(&AtomicBool::new(false), &|orders| bar.inc(orders));
        bar.finish_and_clear();
        let mut report = answer?;
        self.write(&design, &mut report, &mut place);
        if let Some(real) = report.realistic.filter(|real| !real.simulated.stable) {
            note(
                "warning",
                format_args!(
                    "this is for an ideal device; on one with {} the best wall is {}: give --device-model, or the device's own values",
                    real.imperfections.words(),
                    real.simulated.verdict.words()
                ),
            );
        }
        output.summary(&report)?;
        place.close(judge(&design, &report))
    }

    /// Writes experiment, table and picture, if a folder was given.
    fn write(&self, design: &Design, report: &mut DesignReport, place: &mut Place) {
        report.experiment = self.write_experiment(place, report.experiment_text.as_deref());
        let table = place.write(|folder| folder.write_table("csv", report.candidates.iter()));
        report.files.extend(table);
        if report.best.is_some() {
            let picture = place.write(|folder| save_picture(folder, draw(design, report)));
            report.files.extend(picture);
        } else if self.overwrite {
            place.write(|folder| {
                for extension in ["svg", "png"] {
                    let _ = std::fs::remove_file(folder.file(extension));
                }
                Ok(())
            });
        }
    }

    /// Writes the experiment of a design, if there is one, and returns its path.
    fn write_experiment(&self, place: &mut Place, text: Option<&str>) -> Option<String> {
        let written = place.write(|folder| {
            let file = folder.file("toml");
            let Some(text) = text else {
                // An experiment of an earlier design would pass for one of this.
                if self.overwrite {
                    let _ = std::fs::remove_file(&file);
                }
                return Ok(None);
            };
            write_text(&file, text, self.overwrite)?;
            Ok(Some(file.display().to_string()))
        });
        written.flatten()
    }
}

/// # Errors
/// A design without a candidate, or one that is not stable when it is tried.
fn judge(design: &Design, report: &DesignReport) -> Result<(), Failure> {
    match (&report.best, &report.simulated) {
        (Some(best), Some(simulated))
            if simulated.verdict == TrialVerdict::Unstable
                && design.gain_margin.is_none()
                && report.imperfections.sensors.are_ideal() =>
        {
            note(
                "warning",
                format_args!(
                    "the best candidate, order {}, is passive but rings for longer than it was tried: \
                     the device has little damping",
                    best.order
                ),
            );
            Ok(())
        }
        (Some(best), Some(simulated)) if !simulated.stable => Err(Failure::Run(anyhow::anyhow!(
            "the best candidate, order {}, is {} when it is tried: {}; ask for more margin with --gain-margin, \
                 less noise with --force-noise-limit, or take a finer encoder",
            best.order,
            simulated.verdict.words(),
            simulated.reason().unwrap_or_default()
        ))),
        (None, _) => Err(nothing_found(
            report
                .notes
                .last()
                .map_or("nothing does it", String::as_str),
        )),
        _ => Ok(()),
    }
}

/// A design without a candidate, after its report.
fn nothing_found(why: &str) -> Failure {
    Failure::Run(anyhow::anyhow!(
        "no candidate fulfils the wish: {why}; ask for less, or take other --orders or another device"
    ))
}
