//! The result of a touch as a person reads it.

use super::summary::{print_end, print_force, print_length, print_operator};
use haptic_experiment::TouchReport;
use std::io::{self, Write};

/// The result.
///
/// # Errors
/// Those of `out`.
pub fn print_touch(out: &mut dyn Write, report: &TouchReport) -> io::Result<()> {
    let run = &report.run;
    writeln!(
        out,
        "touch of a {} · {} · order {} · scheme {} · {} axes",
        report.shape, report.matter, report.order, report.scheme, report.axes
    )?;
    print_length(out, run)?;
    writeln!(out, "  verdict           {}", report.verdict.words())?;
    writeln!(
        out,
        "  depth             {:.4} mm at most",
        1e3 * report.largest_depth_m
    )?;
    print_force(out, run)?;
    if let (Some(given_j), Some(most_j)) = (report.given_j, report.given_most_j) {
        writeln!(
            out,
            "  energy            the hand gave {:.3e} J, and was given {most_j:.3e} J more than it gave at most",
            0.0 - given_j
        )?;
    }
    print_operator(out, &report.errors)?;
    let posture = &report.posture;
    let (least, most) = (
        posture.effective_mass_least_kg,
        posture.effective_mass_most_kg,
    );
    let judged = posture.judged_mass_kg;
    writeln!(
        out,
        "  along the normal  {least:.4} to {most:.4} kg; the pre-flight is of {judged:.4} kg"
    )?;
    print_end(out, run)
}
