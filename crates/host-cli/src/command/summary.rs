//! The report of a run as a person reads it.

use fracdiff::Scheme;
use haptic_experiment::Report;
use haptic_experiment::experiment::DriveReport;
use haptic_experiment::judge::{Errors, RunReport};
use std::io::{self, Write};

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
    print_length(out, run)?;
    if let Ok(Scheme::Full { tolerance, .. }) = report.scheme.parse() {
        // |error| ≤ ε·T^(−μ)·Σ c_j|Δⁿx|
        writeln!(
            out,
            "  tolerance         {tolerance:e} of the operator's output while x moves one way, of its gross sum otherwise"
        )?;
    }
    print_force(out, run)?;
    if let Some(strain) = report.final_strain {
        writeln!(out, "  strain            at the end {strain:.4e}")?;
    }
    if let Some(ratio) = report.final_over_theory {
        writeln!(
            out,
            "  {quantity:<17} at the end {ratio:.6} times the closed form"
        )?;
    }
    if let Some(drive) = &report.drive {
        print_drive(out, drive)?;
    }
    print_errors(out, report)?;
    print_end(out, run)
}

/// Number, time and period of the samples of a run.
///
/// # Errors
/// Those of `out`.
pub fn print_length(out: &mut dyn Write, run: &RunReport) -> io::Result<()> {
    writeln!(
        out,
        "  {} samples, {} s at {} ms",
        run.samples,
        plain(run.duration_s),
        plain(1e3 * run.sample_time_s)
    )
}

/// Prints the largest force, and the last before it fell to zero.
///
/// # Errors
/// Those of `out`.
pub fn print_force(out: &mut dyn Write, run: &RunReport) -> io::Result<()> {
    writeln!(
        out,
        "  force             peak {:.4e} N, {} {:.4e} N",
        run.peak_force_n,
        match run.ended_early {
            None => "at the end",
            Some(_) => "before it fell",
        },
        // −0 is 0.
        0.0 + run.final_force_n
    )
}

/// The work of the controller that held the indenter.
fn print_drive(out: &mut dyn Write, drive: &DriveReport) -> io::Result<()> {
    let unit = if drive.quantity == "position" {
        "m"
    } else {
        "N"
    };
    writeln!(
        out,
        "  drive             {}: {} off by {:.2e} {unit} at most, {:.2e} {unit} rms, {:.2e} {unit} at the end",
        drive.controller,
        drive.quantity,
        drive.tracking_error_max,
        drive.tracking_error_rms,
        drive.tracking_error_final
    )?;
    writeln!(
        out,
        "                    force {:.4e} N at most of {} N, {} samples at the limit",
        drive.drive_force_peak_n, drive.drive_force_limit_n, drive.saturated_samples
    )?;
    writeln!(out, "  drive pre-flight  {}", drive.preflight.line())
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
            "  operator          off by {} at most from the full history of what was recorded{}{}{}",
            number(errors.max_relative_error),
            window(
                errors.max_relative_error_from_s,
                errors.max_relative_error_to_s
            ),
            report
                .reference_tolerance
                .map_or_else(String::new, |tolerance| {
                    format!(" (by an operator, to {tolerance:.0e})")
                }),
            match report.run.limited_samples {
                0 => String::new(),
                limited => format!(
                    "; the force of {limited} samples of the run was limited, see the warning"
                ),
            }
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

/// Prints the error of the commanded force against the full history, as a share of the largest force.
///
/// # Errors
/// Those of `out`.
pub fn print_operator(out: &mut dyn Write, errors: &Errors) -> io::Result<()> {
    match errors.max_relative_error {
        Some(error) => writeln!(
            out,
            "  operator          off by {error:.2e} of the largest force at most from the full history, from {} s to {} s",
            errors.max_relative_error_from_s.unwrap_or_default(),
            errors.max_relative_error_to_s.unwrap_or_default()
        )?,
        None => writeln!(
            out,
            "  operator          not compared: {}",
            errors.max_relative_error_reason.as_deref().unwrap_or("–")
        )?,
    }
    Ok(())
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
        crate::command::realtime::print(out, realtime)?;
    }
    if let Some(link) = &end.link {
        writeln!(
            out,
            "  link              board {}, loop on the {}; {} samples lost; frames {} from it, {}, {} damaged; round trip {}",
            link.board,
            link.loop_mode,
            link.samples_lost + link.samples_dropped,
            link.from_device.received,
            link.arrived(),
            link.from_device.corrupt + link.to_device.corrupt,
            link.round_trip()
        )?;
    }
    if let Some(verdict) = &end.preflight {
        writeln!(out, "  pre-flight        {}", verdict.line())?;
    }
    print_files(out, &end.logs, [&end.fault_log, &end.csv, &end.figure])
}

/// Prints the paths of the files of a log, of the log of a fault, of table and picture.
///
/// # Errors
/// Those of `out`.
pub fn print_files(
    out: &mut dyn Write,
    logs: &[String],
    [fault_log, csv, figure]: [&Option<String>; 3],
) -> io::Result<()> {
    if let Some(log) = logs.first() {
        writeln!(out, "  log               {log}")?;
    }
    if let [_, .., last] = logs {
        writeln!(
            out,
            "                    in {} files, the last is {last}",
            logs.len()
        )?;
    }
    if let Some(log) = fault_log {
        writeln!(out, "  fault log         {log}")?;
    }
    if let Some(csv) = csv {
        writeln!(out, "  csv               {csv}")?;
    }
    if let Some(figure) = figure {
        writeln!(
            out,
            "  figure            {figure}{}",
            crate::picture_file::AND_SVG
        )?;
    }
    Ok(())
}

/// Without the digits that a binary fraction adds.
pub fn plain(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}
