//! Arguments and manners that all experiments share.

use super::live::LiveArguments;
use super::preflight::PreflightArguments;
use super::realtime::RealtimeArguments;
use super::remote::RemoteArguments;
use super::safety::SafetyArguments;
use crate::choice::choice;
use crate::files::{folder, overwrite_acts, save_picture};
use crate::output::{Output, note, warn};
use crate::parameter::{help_with_default, seed_for, with_options};
use crate::picture::of_theory;
use crate::quantity::{Area, Bytes, Force, ForceRate, Length, Time};
use clap::Args;
use fracdiff::{Order, Scheme, Seconds};
use haptic_experiment::curves::{Published, TheoryCurves};
use haptic_experiment::failure::Failure;
use haptic_experiment::folder::FolderRequest;
use haptic_experiment::parameters;
use haptic_experiment::report::RunReport;
use haptic_experiment::{
    Contact, ModelledTissue, Precision, Rendering, Report, Safety, Sensors, Summary, Supervisor,
};
use haptic_figure::{FigureError, Picture};
use haptic_link::LoopMode;
use haptic_log::record::ROLL_LEAST;
use haptic_loop::Specimen;
use haptic_loop::units::{Metres, SquareMetres};
use haptic_tissue::Library;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

/// What is rendered, on what, and where the files go.
#[derive(Debug, Args)]
pub struct RenderingArguments {
    #[arg(long, help = parameters::TISSUE.help, value_name = "NAME|FILE.toml", default_value = parameters::TISSUE.shown, help_heading = "Tissue")]
    tissue: String,
    #[arg(long, help = parameters::LIBRARY.help, value_name = "DIR", help_heading = "Tissue")]
    library: Option<PathBuf>,
    #[arg(long, help = parameters::AREA.help, default_value = parameters::AREA.shown, allow_hyphen_values = true, help_heading = "Tissue")]
    area: Area,
    #[arg(long, help = parameters::THICKNESS.help, default_value = parameters::THICKNESS.shown, allow_hyphen_values = true, help_heading = "Tissue")]
    thickness: Length,
    #[arg(long, help = parameters::SCHEME.help, value_parser = parse_scheme, default_value = parameters::SCHEME.shown, help_heading = "Loop")]
    scheme: Scheme,
    #[arg(long, help = help_with_default(&parameters::PRECISION), value_parser = choice::<Precision>(), help_heading = "Loop")]
    precision: Option<Precision>,
    #[arg(long, help = parameters::SAMPLE_TIME.help, default_value = parameters::SAMPLE_TIME.shown, allow_hyphen_values = true, help_heading = "Loop")]
    sample_time: Time,
    #[arg(long, help = parameters::CONTACT.help, value_parser = choice::<Contact>(), default_value = parameters::CONTACT.shown, help_heading = "Rig")]
    contact: Contact,
    #[arg(long, help = parameters::ENCODER_RESOLUTION.help, value_name = "LENGTH", default_value = parameters::ENCODER_RESOLUTION.shown, allow_hyphen_values = true, help_heading = "Rig")]
    encoder_resolution: Length,
    #[arg(long, help = parameters::SENSOR_NOISE.help, value_name = "LENGTH", default_value = parameters::SENSOR_NOISE.shown, allow_hyphen_values = true, help_heading = "Rig")]
    sensor_noise: Length,
    #[arg(long, help = help_with_default(&parameters::SEED), allow_hyphen_values = true, help_heading = "Rig")]
    seed: Option<u64>,
    #[arg(long, help = parameters::FORCE_LIMIT.help, value_name = "FORCE", default_value = parameters::FORCE_LIMIT.shown, allow_hyphen_values = true, help_heading = "Loop")]
    force_limit: Force,
    #[arg(long, help = parameters::FORCE_RATE_LIMIT.help, value_name = "RATE", default_value = parameters::FORCE_RATE_LIMIT.shown, allow_hyphen_values = true, help_heading = "Loop")]
    force_rate_limit: ForceRate,
    #[command(flatten)]
    realtime: RealtimeArguments,
    #[command(flatten)]
    safety: SafetyArguments,
    #[command(flatten)]
    remote: RemoteArguments,
    #[command(flatten)]
    preflight: PreflightArguments,
    #[command(flatten)]
    live: LiveArguments,
    /// Folder for log, CSV and pictures [default: the next free results/NAME-0001]
    #[arg(long, value_name = "DIR", help_heading = "Files")]
    out: Option<PathBuf>,
    /// Replace the files of an earlier run in the folder
    #[arg(long, help_heading = "Files")]
    overwrite: bool,
    /// Size at which the log goes on in another file, as in 1GB [default: one file]
    #[arg(
        long,
        value_name = "SIZE",
        allow_hyphen_values = true,
        help_heading = "Files"
    )]
    roll: Option<Bytes>,
}

/// The size that `--roll` gives, if it does.
///
/// # Errors
/// A size outside its range.
pub fn roll_bytes(size: Option<Bytes>) -> Result<Option<u64>, Failure> {
    /// No disk has more.
    const MOST: f64 = 1e15;
    let least = ROLL_LEAST as f64;
    match size {
        None => Ok(None),
        Some(Bytes(bytes)) if (least..=MOST).contains(&bytes) => Ok(Some(bytes as u64)),
        Some(Bytes(bytes)) => Err(Failure::bad_input(format_args!(
            "size {bytes} bytes is not in [{least:e}, {MOST:e}]: give --roll, as in 1GB"
        ))),
    }
}

/// Checks an order.
///
/// # Errors
/// Outside −2 ≤ μ ≤ 2.
pub fn order(mu: f64) -> Result<Order, Failure> {
    Order::new(mu).map_err(|error| Failure::input_with_advice(error, "give --order within it"))
}

/// Checks an order of a wall or a coupler, which have no integral; `option` is where it was given.
///
/// # Errors
/// Outside 0 ≤ μ ≤ 2.
pub fn wall_order(mu: f64, option: &str) -> Result<Order, Failure> {
    if (0.0..=Order::MAX).contains(&mu) {
        return Order::new(mu).map_err(Failure::input);
    }
    Err(Failure::bad_input(format_args!(
        "order {mu} is not in [0, {}], a wall has no integral: give {option} within it",
        Order::MAX
    )))
}

/// Reads a dissipation: a number, whose unit follows from the order.
///
/// # Errors
/// If it is no number or not finite; a unit is explained.
pub fn parse_dissipation(text: &str) -> Result<f64, String> {
    parse_number(text).map_err(|error| {
        // "1e3Ns/m" begins with a number as well: the unit begins with its first N.
        match text.find('N').map(|unit| &text[..unit]) {
            Some(start) if parse_number(start).is_ok() => format!(
                "its unit, N·s^μ/m, follows from the order μ: give the number alone, {}",
                start.trim()
            ),
            _ => error,
        }
    })
}

/// T^(−μ), if the sample time is in the range that operators take.
///
/// # Errors
/// Outside that range.
pub fn rate(sample_time: Seconds, mu: Order) -> Result<f64, Failure> {
    sample_time
        .rate_to_the(mu)
        .map_err(|error| Failure::input_with_advice(error, "give --sample-time, as in 1ms"))
}

/// Reads a plain number.
///
/// # Errors
/// If it is none, or not finite.
pub fn parse_number(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err("not a finite number".to_owned()),
    }
}

/// Reads an order; its range is checked by [`order`].
///
/// # Errors
/// If it is no number, or not finite.
pub fn parse_order(text: &str) -> Result<f64, String> {
    parse_number(text).map_err(|error| format!("{error} in [{}, {}]", Order::MIN, Order::MAX))
}

/// Reads a SCHEME.
///
/// # Errors
/// In the scheme's own words.
pub fn parse_scheme(text: &str) -> Result<Scheme, String> {
    text.parse()
        .map_err(|error: fracdiff::SchemeError| error.to_string())
}

impl RenderingArguments {
    /// Checks and gathers everything.
    ///
    /// # Errors
    /// An unknown tissue, a bad specimen, a device that is not there.
    pub fn rendering(&self) -> Result<Rendering, Failure> {
        let remote = self.remote.remote(None)?;
        if remote.is_some() && (self.encoder_resolution.0 > 0.0 || self.sensor_noise.0 > 0.0) {
            return Err(Failure::bad_input(
                "--encoder-resolution and --sensor-noise are of the simulated rig: leave them away with a \
                 serial device, which has its own",
            ));
        }
        let there = (remote.as_ref()).is_some_and(|remote| remote.loop_mode == LoopMode::Device);
        if there && self.precision == Some(Precision::F64) {
            return Err(Failure::bad_input(
                "precision f64 has no effect in a loop on the device, which computes in f32: leave --precision out, or \
                 close the loop here with --loop host",
            ));
        }
        if self.scheme == Scheme::Exact {
            return Err(Failure::input(fracdiff::SchemeError::AnalysisOnly));
        }
        let library = Library::load(self.library.as_deref()).map_err(Failure::input)?;
        let material = modelled(&library, &self.tissue)?;
        let specimen = Specimen::new(SquareMetres(self.area.0), Metres(self.thickness.0)).map_err(
            |error| {
                Failure::input_with_advice(error, "give --area 4cm2 --thickness 20mm, for example")
            },
        )?;
        let safety = self.safety.over(Safety::default());
        let preflight = self.preflight.wanted(remote.is_some(), &safety)?;
        Ok(Rendering {
            preflight,
            material,
            specimen,
            scheme: self.scheme,
            precision: self.precision.unwrap_or(Precision::F64),
            sample_time_s: self.sample_time.0,
            contact: self.contact,
            sensors: Sensors {
                encoder_resolution_m: self.encoder_resolution.0,
                noise_m: self.sensor_noise.0,
                seed: seed_for(self.seed, self.sensor_noise.0)?,
            },
            force_limit_n: self.force_limit.0,
            force_rate_limit_n_per_s: self.force_rate_limit.0,
            safety,
            pace: self.realtime.pace(remote.is_some())?,
            remote,
        })
    }

    /// Runs an experiment in its folder with a progress bar, stoppable by Ctrl-C, and reports.
    ///
    /// # Errors
    /// As [`conduct`].
    pub fn conduct(
        &self,
        stem: &'static str,
        samples: u64,
        output: Output,
        experiment: impl FnOnce(
            &FolderRequest,
            Supervisor<'_>,
        ) -> Result<Published<Report, TheoryCurves>, Failure>,
    ) -> Result<(), Failure> {
        overwrite_acts(self.out.as_deref(), self.overwrite)?;
        let roll_bytes = roll_bytes(self.roll)?;
        let request = FolderRequest {
            roll_bytes,
            ..folder(self.out.clone(), stem, self.overwrite)
        };
        let live = self.live.open(
            self.realtime.is_realtime() || self.remote.is_serial(),
            output,
        )?;
        conduct(samples, output, print_summary, of_theory, |supervisor| {
            experiment(&request, supervisor.watched(&live))
        })
    }
}

/// A tissue of the library with its model.
///
/// # Errors
/// A name that is not in it, a file that is wrong.
pub fn modelled(library: &Library, name: &str) -> Result<ModelledTissue, Failure> {
    let material = library.find(name).map_err(Failure::input)?;
    ModelledTissue::new(material).map_err(Failure::input)
}

/// Runs an experiment with a progress bar, stoppable by Ctrl-C, draws and reports.
///
/// # Errors
/// Those of the experiment; an interrupted one, one with a fault, or with dropped samples.
pub fn conduct<R: Summary, C>(
    samples: u64,
    output: Output,
    print: impl FnOnce(&mut dyn Write, &R) -> io::Result<()>,
    draw: impl FnOnce(&C) -> Result<Picture, FigureError>,
    experiment: impl FnOnce(Supervisor<'_>) -> Result<Published<R, C>, Failure>,
) -> Result<(), Failure> {
    let stop = stop_on_interrupt()?;
    let bar = progress_bar(samples, output);
    let progress = |done| bar.set_position(done);
    let result = experiment(Supervisor {
        stop,
        progress: &progress,
        live: None,
        warn: &warn,
    });
    bar.finish_and_clear();
    let Published {
        mut report,
        curves,
        folder,
    } = result?;
    if let Some(curves) = curves {
        report.run_mut().figure = Some(save_picture(&folder, draw(&curves))?);
    }
    if let Some(reason) = &mut report.run_mut().ended_early {
        *reason = with_options(reason);
    }
    for warning in &mut report.run_mut().warnings {
        *warning = with_options(warning);
        note("warning", &*warning);
    }
    output.summary(&report, |out| print(out, &report))?;
    let RunReport {
        ended_early,
        duration_s,
        dropped_samples,
        link_lost,
        log,
        ..
    } = report.run();
    if let (true, Some(reason)) = (*link_lost, ended_early) {
        return Err(Failure::Device(anyhow::anyhow!(
            "{reason}: the run ended at {} s, the device lets go by itself; the log is {log}",
            plain(*duration_s)
        )));
    }
    if let Some(reason) = ended_early {
        return Err(Failure::Run(anyhow::anyhow!(
            "{reason}: the run ended at {} s, the force ramped to zero; the log is {log}",
            plain(*duration_s),
        )));
    }
    if *dropped_samples > 0 {
        return Err(Failure::DataLost(anyhow::anyhow!(
            "{dropped_samples} samples are missing from the log {log}"
        )));
    }
    Ok(())
}

/// The flag that Ctrl-C (or a termination signal) sets. The handler is installed once.
///
/// # Errors
/// If the system does not let a program watch for it.
pub fn stop_on_interrupt() -> Result<&'static AtomicBool, Failure> {
    static STOP: AtomicBool = AtomicBool::new(false);
    static INSTALLED: OnceLock<Result<(), String>> = OnceLock::new();
    let installed = INSTALLED.get_or_init(|| {
        ctrlc::set_handler(|| STOP.store(true, Ordering::Relaxed))
            .map_err(|error| error.to_string())
    });
    match installed {
        Ok(()) => Ok(&STOP),
        Err(error) => Err(Failure::Run(anyhow::anyhow!(
            "cannot watch for Ctrl-C, so a run could not be stopped safely: {error}"
        ))),
    }
}

/// A bar on a terminal; nothing elsewhere or for a quiet person.
pub fn progress_bar(samples: u64, output: Output) -> ProgressBar {
    let target = if output.quiet {
        ProgressDrawTarget::hidden()
    } else {
        ProgressDrawTarget::stderr()
    };
    let bar = ProgressBar::with_draw_target(Some(samples), target);
    let template = "{bar:40} {percent:>3} %  {human_pos} of {human_len}  {eta} left";
    // The template is a constant; the default serves if it were wrong.
    bar.set_style(
        ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    // Draws from a thread of its own, not from the loop.
    bar.enable_steady_tick(std::time::Duration::from_millis(100));
    bar
}

/// The result as a person reads it.
///
/// # Errors
/// Those of `out`.
pub fn print_summary(out: &mut dyn Write, report: &Report) -> io::Result<()> {
    let run = &report.run;
    let quantity = if report.final_strain.is_some() {
        "strain"
    } else {
        "force"
    };
    writeln!(
        out,
        "{} · order {} · scheme {} · {} · device {}",
        report.tissue,
        report.order,
        report.scheme,
        format!("{:?}", report.precision).to_lowercase(),
        run.device
    )?;
    writeln!(
        out,
        "  {} samples, {} s at {} ms",
        run.samples,
        plain(run.duration_s),
        plain(1e3 * run.sample_time_s)
    )?;
    if let Ok(Scheme::Full { tolerance, .. }) = report.scheme.parse() {
        // |error| ≤ ε·T^(−μ)·Σ c_j|Δⁿx|
        writeln!(
            out,
            "  tolerance         {tolerance:e} of the operator's output while x moves one way, of its gross sum otherwise"
        )?;
    }
    writeln!(
        out,
        "  force             peak {:.4e} N, at the end {:.4e} N",
        run.peak_force_n, run.final_force_n
    )?;
    if let Some(strain) = report.final_strain {
        writeln!(out, "  strain            at the end {strain:.4e}")?;
    }
    if let Some(ratio) = report.final_over_theory {
        writeln!(
            out,
            "  {quantity:<17} at the end {ratio:.6} times the closed form"
        )?;
    }
    print_errors(out, report)?;
    print_end(out, run)
}

/// The two errors, each with the samples that it is of.
fn print_errors(out: &mut dyn Write, report: &Report) -> io::Result<()> {
    let number = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |v| format!("{v:.2e}"));
    let window = |from_s: Option<f64>, to_s: Option<f64>| {
        let ends = from_s.zip(to_s);
        ends.map_or_else(String::new, |(from, to)| {
            format!(", from {from} s to {to} s")
        })
    };
    let errors = &report.errors;
    match &errors.max_relative_error_reason {
        Some(reason) => writeln!(out, "  operator          not compared: {reason}")?,
        None => writeln!(
            out,
            "  operator          off by {} at most from the full history of what was recorded{}{}",
            number(errors.max_relative_error),
            window(
                errors.max_relative_error_from_s,
                errors.max_relative_error_to_s
            ),
            report
                .reference_tolerance
                .map_or_else(String::new, |tolerance| {
                    format!(" (by an operator, to {tolerance:.0e})")
                })
        )?,
    }
    match &errors.closed_form_error_reason {
        Some(reason) => writeln!(out, "  closed form       not compared: {reason}"),
        None => writeln!(
            out,
            "  closed form       off by {} at most{} (sampling alone {}, contact and rig alone {})",
            number(errors.closed_form_error),
            window(
                errors.closed_form_error_from_s,
                errors.closed_form_error_to_s
            ),
            number(report.discretisation_error),
            number(report.rig_error)
        ),
    }
}

/// Prints what the summaries of all experiments end with.
///
/// # Errors
/// Those of `out`.
pub fn print_end(out: &mut dyn Write, end: &RunReport) -> io::Result<()> {
    let plant = if end.link.is_some() {
        ""
    } else {
        " and simulated device"
    };
    match end.tick_ns {
        Some(tick) => writeln!(
            out,
            "  tick              {} ns median, {} ns 99 %, {} ns longest (loop{plant}); {} late",
            tick.p50, tick.p99, tick.max, end.missed_deadlines
        )?,
        None => writeln!(
            out,
            "  tick              on the device, {} late",
            end.missed_deadlines
        )?,
    }
    if let Some(realtime) = &end.realtime {
        super::realtime::print(out, realtime)?;
    }
    if let Some(link) = &end.link {
        let [p50, p99, max] = link.round_trip_us;
        writeln!(
            out,
            "  link              board {}, loop on the {}; {} samples lost; frames {} from it, {} to it, {} \
             damaged; round trip {p50} µs median, {p99} µs 99 %, {max} µs longest",
            link.board,
            link.loop_mode,
            link.samples_lost + link.samples_dropped,
            link.from_device.received,
            link.to_device.received,
            link.from_device.corrupt + link.to_device.corrupt
        )?;
    }
    if let Some(verdict) = &end.preflight {
        writeln!(out, "  pre-flight        {}", verdict.line())?;
    }
    writeln!(out, "  log               {}", end.log)?;
    if let [_, .., last] = end.logs.as_slice() {
        writeln!(
            out,
            "                    in {} files, the last is {last}",
            end.logs.len()
        )?;
    }
    if let Some(log) = &end.fault_log {
        writeln!(out, "  fault log         {log}")?;
    }
    if let Some(csv) = &end.csv {
        writeln!(out, "  csv               {csv}")?;
    }
    if let Some(figure) = &end.figure {
        writeln!(
            out,
            "  figure            {figure}{}",
            crate::picture_file::AND_SVG
        )?;
    }
    Ok(())
}

/// Without the digits that a binary fraction adds.
fn plain(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}
