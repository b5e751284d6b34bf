//! `design`: the stiffest wall, the most damping or the closest tissue, and which order does it.

mod coupler;
mod draw;
mod print;

use crate::command::conduct::progress_bar;
use crate::files::{Place, save_picture};
use crate::keys;
use crate::options::Options;
use crate::output::{Output, note};
use clap::Args;
use draw::draw;
use haptic_experiment::document::Document;
use haptic_experiment::question::Question;
use haptic_experiment::question::design::{Design, DesignReport, Requirement};
use haptic_experiment::run::write_text;
use haptic_experiment::{Failure, TrialVerdict};
use print::print;
use std::path::PathBuf;

pub(crate) const LONG_ABOUT: &str = "\
From a device and a wish to a wall: for each order the largest stiffness K and dissipation B, and the \
order that does it best. Nothing is searched by trying: stable walls come from the stability region, \
passive ones from Theorem 1 for the operator that really runs, with delay and current lag of the device. The best \
one is then tried on the simulated device, with its friction and encoder too.

Without --device-model, or one of friction, delay, current_lag, encoder_resolution and sensor_noise, an \
ideal device is assumed, and the trial with what --device-model laboratory has stands beside. The force noise of encoder steps q is \
B.(q/sqrt 12).T^(-mu).sqrt(sum of the squared weights), rms; --force-noise-limit keeps B below it.

Wishes:
  stiffest-wall   the largest K, with the B that allows it
  most-damping    the largest effective damping of the wall at --frequency
  tissue          K, B and order of a specimen of --tissue: does it fit, how much larger may it be, and which \
order of the grid is the closest that fits (equal at --frequency) if it does not
  coupler         the stiffest virtual coupler damper + spring (T/(1-w))^mu as felt at --frequency (default 1 Hz), that Llewellyn's criterion \
passes on this damping and sample time, for every passive hand and object. His device acts half a sample earlier than a real one, so the \
loop that is really sampled (mass, hand, an object of 100 g, 1 N s/m, 500 N/m) must be stable too, also with a coupler twice as large: \
where it is not, both parts are made smaller (share below 1). --require passive asks instead for passivity of the sampled device with \
every hand and object, four times the damping and more. The device is ideal

With --out it writes design.toml, which `host-cli run` takes (exit code 0 only if trial and analysis call the \
wall stable; a coupler must pass Llewellyn's criterion too), design.csv and, but for a coupler, a picture. The default device is as \
heavy and as damped as that of the dissertation's section 4.4: 65 g, 3.5 N.s/m.

Exit code 0 means that there is a best candidate and that it came to rest when it was tried (a passive one may ring on, with a warning). \
Without any, best is null and the exit code is 1, whatever the wish; the report is printed all the same.

JSON: mass_kg, damping_n_s_per_m, hand_stiffness_n_per_m, sample_time_s, wish, require, gain_margin, frequency_hz, scheme, force_noise_limit_n, ideal_device_assumed, \
imperfections{friction_n, delay_s, current_lag_s, encoder_resolution_m, sensor_noise_m, seed}, \
realistic{the same, analysis_stable, margin, force_noise_rms_n, simulated}, candidates[{order, stiffness (N/m), \
dissipation (N.s^mu/m), margin, alpha, beta, passive, required_damping_n_s_per_m, effective_damping_n_s_per_m, \
force_noise_rms_n, largest_scale, reason}], best, tissue, simulated (as in `host-cli run`), experiment, files, notes. Of a coupler: \
the device as above, wish, require (llewellyn or passive), scheme, frequency_hz, candidates[{order, stiffness (the damper, N.s/m), dissipation (the spring, N.s^(1-mu)/m), \
margin, felt_stiffness_n_per_m, share, loop_margin, sampled_damping_n_s_per_m, reason}], best, simulated, experiment, files.";

/// Arguments of `design`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  host-cli design --delay 1ms --out design\n  \
                  host-cli design --device-model laboratory --mass 45g --damping 0.2 --force-limit 3.3N --out mine\n  \
                  host-cli design encoder_resolution=30um friction=0.2N --force-noise-limit 0.05N\n  \
                  host-cli design --wish most-damping --frequency 5Hz --require passive\n  \
                  host-cli design --wish tissue --tissue prostate-cancerous"
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
        let answer = design.answer(&|orders| bar.inc(orders));
        bar.finish_and_clear();
        let mut report = answer?;
        self.write(&design, &mut report, &mut place);
        output.summary(&report, |out| print(out, &report))?;
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
                && design.requirement == Requirement::Passive
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
