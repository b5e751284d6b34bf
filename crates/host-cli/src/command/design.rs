//! `design`: the stiffest wall, the most damping or the closest tissue, and which order does it.

mod coupler;
mod draw;
mod print;

use crate::command::conduct::progress_bar;
use crate::command::experiment::modelled;
use crate::command::materials::folder::library;
use crate::command::plant::PlantArguments;
use crate::command::words::{parse_scheme, parse_wall_order, wall_order};
use crate::files::{Place, save_picture};
use crate::output::{Output, note};
use crate::parameter::help_with_default;
use crate::whole::whole;
use crate::within::{number_within, within};
use clap::{Args, ValueEnum};
use draw::draw;
use fracdiff::{Order, Scheme};
use haptic_experiment::design::{Design, DesignReport, Device, Requirement, Wish};
use haptic_experiment::failure::Failure;
use haptic_experiment::folder::write_text;
use haptic_experiment::parameters::range;
use haptic_experiment::{TrialVerdict, parameters};
use haptic_loop::Specimen;
use haptic_loop::units::{Metres, SquareMetres};
use haptic_quantity::{Area, Force, Frequency, Length};
use print::print;
use std::path::PathBuf;

pub(crate) const LONG_ABOUT: &str = "\
From a device and a wish to a wall: for each order the largest stiffness K and dissipation B, and the \
order that does it best. Nothing is searched by trying: stable walls come from the stability region, \
passive ones from Theorem 1 for the operator that really runs, with delay and current lag of the device. The best \
one is then tried on the simulated device, with its friction and encoder too.

Without --device-model, or one of --friction, --delay, --current-lag, --encoder-resolution and --sensor-noise, an \
ideal device is assumed, and the trial with what --device-model laboratory has stands beside. The force noise of encoder steps q is \
B.(q/sqrt 12).T^(-mu).sqrt(sum of the squared weights), rms; --force-noise-limit keeps B below it.

Wishes:
  stiffest-wall   the largest K, with the B that allows it
  most-damping    the largest effective damping of the wall at --frequency
  tissue NAME     K, B and order of a specimen: does it fit, how much larger may it be, and which \
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
    after_help = "Examples:\n  host-cli design --wish stiffest-wall --delay-samples 1 --out design\n  \
                  host-cli design --device-model laboratory --mass 45g --damping 0.2 --sample-time 1ms --force-limit 3.3N --out mine\n  \
                  host-cli design --encoder-resolution 30um --friction 0.2N --force-noise-limit 0.05N\n  \
                  host-cli design --wish most-damping --frequency 5Hz --require passive\n  \
                  host-cli design --wish tissue prostate-cancerous"
)]
pub struct Arguments {
    /// What is wanted most: stiffest-wall, most-damping, tissue NAME or coupler
    #[arg(long, num_args = 1..=2, value_name = "WISH", default_value = "stiffest-wall")]
    wish: Vec<String>,
    /// Frequency of most-damping, and where orders are compared for a tissue [default there: 1 Hz]
    #[arg(long, value_parser = within::<Frequency>(range::FREQUENCIES_HZ), allow_hyphen_values = true)]
    frequency: Option<Frequency>,
    /// What the wall must be [default: stable]
    #[arg(long, value_enum)]
    require: Option<Require>,
    #[arg(long, help = help_with_default(&parameters::GAIN_MARGIN), value_parser = number_within(parameters::GAIN_MARGIN.range()), value_name = "FACTOR", allow_hyphen_values = true)]
    gain_margin: Option<f64>,
    #[arg(long, help = parameters::DESIGN_ORDERS.help, value_parser = parse_wall_order, value_delimiter = ',', default_value = parameters::DESIGN_ORDERS.shown, allow_hyphen_values = true)]
    orders: Vec<f64>,
    #[arg(long, help = parameters::SCHEME.help, value_parser = parse_scheme, default_value = parameters::SCHEME.shown)]
    scheme: Scheme,
    #[command(flatten)]
    device: PlantArguments,
    /// Delay from a measurement to the force that answers it, in whole samples instead of --delay
    #[arg(long, value_name = "SAMPLES", value_parser = whole::<u16>(0..=64))]
    #[arg(conflicts_with = "delay", help_heading = "Device")]
    delay_samples: Option<u16>,
    /// Largest noise of the force that encoder steps and sensor noise may make, rms [default: any]
    #[arg(long, value_parser = within::<Force>(range::FORCES_ABOVE_0), value_name = "FORCE", allow_hyphen_values = true)]
    force_noise_limit: Option<Force>,
    #[command(flatten)]
    tissue: TissueArguments,
    /// Folder for design.toml, design.csv and a picture
    #[arg(long, value_name = "DIR", help_heading = "Files")]
    out: Option<PathBuf>,
    /// Replace the files of an earlier design in the folder
    #[arg(long, help_heading = "Files")]
    overwrite: bool,
}

/// What a wall must be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Require {
    /// Passive, for the operator that really runs.
    Passive,
    /// Stable, with a gain margin.
    Stable,
}

/// The specimen of a tissue.
#[derive(Debug, Args)]
#[command(next_help_heading = "Tissue")]
struct TissueArguments {
    /// Folder with more tissue files
    #[arg(long, value_name = "DIR")]
    library: Option<PathBuf>,
    #[arg(long, value_parser = within::<Area>(parameters::AREA.range()), help = help_with_default(&parameters::AREA), allow_hyphen_values = true)]
    area: Option<Area>,
    #[arg(long, value_parser = within::<Length>(parameters::THICKNESS.range()), help = help_with_default(&parameters::THICKNESS), allow_hyphen_values = true)]
    thickness: Option<Length>,
}

impl TissueArguments {
    /// Refuses a specimen where no tissue is wished for.
    fn are_absent(&self) -> Result<(), Failure> {
        let given = [
            (self.library.is_some(), "--library"),
            (self.area.is_some(), "--area"),
            (self.thickness.is_some(), "--thickness"),
        ];
        match given.into_iter().find(|(given, _)| *given) {
            Some((_, option)) => Err(Failure::bad_input(format_args!(
                "{option} has no effect without a tissue: give --wish tissue NAME, or leave it out"
            ))),
            None => Ok(()),
        }
    }
}

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A parameter outside its range; files that cannot be written; a best candidate that is not
    /// stable when it is tried.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let mut place = Place::look(self.out.as_deref(), "design", self.overwrite, &["toml"])?;
        if self.wish.first().is_none_or(|wish| wish != "tissue") {
            self.tissue.are_absent()?;
        }
        if self.wish == ["coupler"] {
            return self.coupler(place, output);
        }
        let design = self.design()?;
        let bar = progress_bar(design.orders_to_try().len() as u64, output);
        let answer = design.answer(&|orders| bar.inc(orders));
        bar.finish_and_clear();
        let mut report = answer?;
        self.write(&design, &mut report, &mut place);
        output.summary(&report, |out| print(out, &report))?;
        place.close(self.judge(&report))
    }

    /// # Errors
    /// A design without a candidate, or one that is not stable when it is tried.
    fn judge(&self, report: &DesignReport) -> Result<(), Failure> {
        match (&report.best, &report.simulated) {
            (Some(best), Some(simulated))
                if simulated.verdict == TrialVerdict::Unstable
                    && self.requirement() == Require::Passive
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
            (Some(best), Some(simulated)) if !simulated.stable => {
                Err(Failure::Run(anyhow::anyhow!(
                    "the best candidate, order {}, is {} when it is tried: {}; ask for more margin with --require \
                     stable --gain-margin, less noise with --force-noise-limit, or take a finer encoder",
                    best.order,
                    simulated.verdict.words(),
                    simulated.reason().unwrap_or_default()
                )))
            }
            (None, _) => Err(nothing_found(
                report
                    .notes
                    .last()
                    .map_or("nothing does it", String::as_str),
            )),
            _ => Ok(()),
        }
    }

    fn requirement(&self) -> Require {
        self.require.unwrap_or(Require::Stable)
    }

    fn design(&self) -> Result<Design, Failure> {
        let requirement = match (self.requirement(), self.gain_margin) {
            (Require::Passive, None) => Requirement::Passive,
            (Require::Passive, Some(_)) => {
                return Err(Failure::bad_input(
                    "--gain-margin belongs to --require stable, not to --require passive: leave it away",
                ));
            }
            (Require::Stable, margin) => Requirement::Stable {
                gain_margin: margin.unwrap_or(parameters::GAIN_MARGIN.default_number()),
            },
        };
        let mut imperfections = self.device.imperfections()?;
        let ideal = self.device.ideal()?;
        if let Some(samples) = self.delay_samples {
            imperfections.delay_s = f64::from(samples) * ideal.sample_time.0;
        }
        Ok(Design {
            device: Device {
                plant: imperfections.on(ideal),
                sensors: imperfections.sensors,
                force_limit_n: self.device.force_limit_n(),
            },
            force_noise_limit_n: self.force_noise_limit.map(|force| force.0),
            scheme: self.scheme,
            orders: self.orders()?,
            requirement,
            wish: self.wish()?,
        })
    }

    fn orders(&self) -> Result<Vec<Order>, Failure> {
        let orders: Result<Vec<Order>, Failure> = (self.orders.iter())
            .map(|&mu| wall_order(mu, "--orders"))
            .collect();
        let mut orders = orders?;
        orders.sort_by(|a, b| a.get().total_cmp(&b.get()));
        orders.dedup();
        Ok(orders)
    }

    fn wish(&self) -> Result<Wish, Failure> {
        let words: Vec<&str> = self.wish.iter().map(String::as_str).collect();
        match words.as_slice() {
            ["stiffest-wall"] if self.frequency.is_some() => Err(Failure::bad_input(
                "--frequency has no meaning for the stiffest wall: leave it away",
            )),
            ["stiffest-wall"] => Ok(Wish::StiffestWall),
            ["most-damping"] => match self.frequency {
                Some(Frequency(frequency_hz)) => Ok(Wish::MostDamping { frequency_hz }),
                None => Err(Failure::bad_input(
                    "--wish most-damping needs a frequency: give --frequency, as in 5Hz",
                )),
            },
            ["tissue", name] => {
                let tissue = &self.tissue;
                let library = library(tissue.library.as_deref())?;
                let area = tissue
                    .area
                    .map_or(parameters::AREA.default_number(), |area| area.0);
                let thickness = tissue.thickness;
                let thickness = thickness.map_or(parameters::THICKNESS.default_number(), |x| x.0);
                let specimen =
                    Specimen::new(SquareMetres(area), Metres(thickness)).map_err(|error| {
                        Failure::input_with_advice(
                            error,
                            "give --area 4cm2 --thickness 20mm, for example",
                        )
                    })?;
                Ok(Wish::Tissue {
                    material: modelled(&library, name)?,
                    specimen,
                    frequency_hz: self
                        .frequency
                        .map_or(parameters::COMPARED_AT_HZ, |frequency| frequency.0),
                })
            }
            ["tissue"] => Err(Failure::bad_input(
                "--wish tissue needs a name: see `host-cli materials list`",
            )),
            _ => Err(Failure::bad_input(format_args!(
                "wish \"{}\" is not one of stiffest-wall, most-damping, tissue NAME, coupler",
                words.join(" ")
            ))),
        }
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

/// A design without a candidate, after its report.
fn nothing_found(why: &str) -> Failure {
    Failure::Run(anyhow::anyhow!(
        "no candidate fulfils the wish: {why}; ask for less, or take other --orders or another device"
    ))
}
