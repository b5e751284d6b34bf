//! The result of a wall or a coupler as a person reads it.

use super::summary::{print_end, print_force, print_length, print_operator};
use haptic_experiment::judge::RunReport;
use haptic_experiment::{CouplerReport, Settling, WallReport};
use std::io::{self, Write};

fn micrometres(x: Option<f64>) -> String {
    match x {
        Some(x) => format!("{:.4} µm", 1e6 * x),
        None => "–".to_owned(),
    }
}

/// The result of a wall as a person reads it.
///
/// # Errors
/// Those of `out`.
pub fn print_wall(out: &mut dyn Write, report: &WallReport) -> io::Result<()> {
    let trial = &report.trial;
    let (run, settling) = (&trial.run, &trial.settling);
    writeln!(
        out,
        "wall of order {} · scheme {} · K = {:.6} N/m · B = {:.6} N·s^μ/m · device {}",
        trial.order,
        trial.scheme,
        report.stiffness_n_per_m,
        report.dissipation_n_s_mu_per_m,
        run.device
    )?;
    print_trial(out, run, settling)?;
    writeln!(
        out,
        "  deflection        {}, at rest {} by push/(K + k)",
        micrometres(settling.deflection_m),
        micrometres(settling.expected_deflection_m)
    )?;
    print_force(out, run)?;
    print_operator(out, &trial.errors)?;
    print_end(out, run)
}

/// The result of a coupler as a person reads it.
///
/// # Errors
/// Those of `out`.
pub fn print_coupler(out: &mut dyn Write, report: &CouplerReport) -> io::Result<()> {
    let trial = &report.trial;
    let (run, settling) = (&trial.run, &trial.settling);
    writeln!(
        out,
        "coupler of order {} · scheme {} · damper {:.6} N·s/m · spring {:.6} N·s^(1−μ)/m · device {}",
        trial.order,
        trial.scheme,
        report.coupler_stiffness_n_s_per_m,
        report.coupler_dissipation_n_s_1_minus_mu_per_m,
        run.device
    )?;
    writeln!(
        out,
        "  object            {} kg, {} N·s/m, {} N/m to the ground",
        report.object_mass_kg, report.object_damping_n_s_per_m, report.object_stiffness_n_per_m
    )?;
    print_trial(out, run, settling)?;
    writeln!(
        out,
        "  deflection        {}, at rest {} by the springs; object at the end {}",
        micrometres(settling.deflection_m),
        micrometres(settling.expected_deflection_m),
        micrometres(report.object_position_m)
    )?;
    print_force(out, run)?;
    print_operator(out, &trial.errors)?;
    print_end(out, run)
}

/// Length of a trial, and its verdict.
fn print_trial(out: &mut dyn Write, run: &RunReport, settling: &Settling) -> io::Result<()> {
    print_length(out, run)?;
    writeln!(
        out,
        "  trial             {}: position varies by {} at the end, force by {} (standard deviations)",
        settling.verdict.words(),
        micrometres(settling.position_std_m),
        settling
            .force_std_n
            .map_or_else(|| "–".to_owned(), |f| format!("{f:.3e} N")),
    )?;
    Ok(())
}
