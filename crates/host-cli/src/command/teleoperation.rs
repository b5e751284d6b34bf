//! The result of a teleoperation as a person reads it.

use super::summary::{plain, print_end, print_length};
use haptic_experiment::TeleoperationReport;
use haptic_experiment::experiment::teleoperation::{FeltAt, LineCounts};
use std::io::{self, Write};

/// The result.
///
/// # Errors
/// Those of `out`.
pub fn print_teleoperation(out: &mut dyn Write, report: &TeleoperationReport) -> io::Result<()> {
    let run = &report.run;
    writeln!(
        out,
        "teleoperation · {} · {} · line of {} ms",
        report.architecture,
        report.place,
        plain(1e3 * report.line_delay_s)
    )?;
    print_length(out, run)?;
    writeln!(out, "  verdict           {}", report.verdict.words())?;
    writeln!(
        out,
        "  energy            the line took {:.3e} J, and gave {:.3e} J at most; with the forces held {}",
        report.taken_j,
        report.given_most_j,
        if report.beyond_damping_most_j > 0.0 {
            format!(
                "{:.3e} J more than the damping of the devices took",
                report.beyond_damping_most_j
            )
        } else {
            "never more than the damping of the devices took".to_owned()
        }
    )?;
    writeln!(
        out,
        "  force             master {:.4e} N, slave {:.4e} N at most",
        report.master_peak_n, report.slave_peak_n
    )?;
    print_way(out, "forth", &report.forth)?;
    print_way(out, "back", &report.back)?;
    print_any_hand(out, report)?;
    print_felt(out, &report.felt)?;
    print_end(out, run)
}

/// Llewellyn's verdict, where there is one.
fn print_any_hand(out: &mut dyn Write, report: &TeleoperationReport) -> io::Result<()> {
    match (
        report.absolutely_stable,
        report.least_ratio,
        report.worst_hz,
    ) {
        (Some(stable), Some(ratio), Some(worst_hz)) => writeln!(
            out,
            "  any hand          {} by Llewellyn's criterion: ratio {ratio:.3}, at {worst_hz:.3} Hz",
            if stable {
                "stable"
            } else {
                "not stable with every hand and place"
            },
        ),
        _ => writeln!(
            out,
            "  any hand          not told: {} is no linear law, so there is neither Llewellyn's criterion nor a formula",
            report.architecture
        ),
    }
}

fn print_way(out: &mut dyn Write, name: &str, counts: &LineCounts) -> io::Result<()> {
    writeln!(
        out,
        "  {name:<17} {} sent, {} lost, {} came late and {} twice: refused",
        counts.sent, counts.lost, counts.stale, counts.duplicate
    )
}

/// The table of what was felt.
fn print_felt(out: &mut dyn Write, felt: &[FeltAt]) -> io::Result<()> {
    if felt.is_empty() {
        return Ok(());
    }
    writeln!(
        out,
        "  {:>9} {:>16} {:>16} {:>16} {:>11}",
        "f / Hz", "felt / N/m", "formula / N/m", "touched / N/m", "off / dB"
    )?;
    let polar = |size: Option<f64>, degrees: Option<f64>| match (size, degrees) {
        (Some(size), Some(degrees)) => format!("{size:.4} {degrees:>4.0}°"),
        _ => "–".to_owned(),
    };
    for felt in felt {
        writeln!(
            out,
            "  {:>9.3} {:>16} {:>16} {:>16} {:>11}",
            felt.frequency_hz,
            polar(Some(felt.felt_n_per_m), Some(felt.felt_degrees)),
            polar(felt.formula_n_per_m, felt.formula_degrees),
            polar(Some(felt.touched_n_per_m), Some(felt.touched_degrees)),
            (felt.off_formula_db).map_or_else(|| "–".to_owned(), |off| format!("{off:.2}")),
        )?;
    }
    Ok(())
}
