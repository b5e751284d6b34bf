//! The result for programs and for people.

use crate::output::short;
use haptic_experiment::question::measurement::{Estimate, Measured, MotionRecord};
use serde::Serialize;
use std::io::{self, Write};

/// Result of `device measure`.
#[derive(Serialize)]
pub(super) struct Report<'a> {
    device: &'a str,
    board: Option<&'a str>,
    #[serde(flatten)]
    found: &'a Measured,
    largest_force_n: f64,
    reach_low_m: f64,
    reach_high_m: f64,
    model: Option<String>,
    figure: Option<String>,
}

impl<'a> Report<'a> {
    pub(super) fn new(
        (device, board): (&'a str, Option<&'a str>),
        record: &MotionRecord,
        found: &'a Measured,
        (model, figure): (Option<String>, Option<String>),
    ) -> Self {
        let (reach_low_m, reach_high_m) = record.reach_m();
        Self {
            device,
            board,
            found,
            largest_force_n: record.largest_force_n(),
            reach_low_m,
            reach_high_m,
            model,
            figure,
        }
    }
}

/// A number with four significant digits.
pub(super) fn digits(value: f64) -> String {
    significant(value, 4)
}

fn significant(value: f64, digits: usize) -> String {
    let decimals = digits - 1;
    short(format!("{value:.decimals$e}").parse().unwrap_or(value))
}

/// Digits that tell the ends of an interval apart: two of its width.
fn telling(estimate: &Estimate) -> usize {
    let share = (estimate.high - estimate.low) / estimate.high.abs().max(estimate.low.abs());
    match share {
        share if share > 0.0 => (3.0 - share.log10()).ceil().clamp(3.0, 8.0) as usize,
        _ => 4,
    }
}

/// The result as a person reads it.
pub(super) fn print(out: &mut dyn Write, report: &Report<'_>) -> io::Result<()> {
    let found = report.found;
    let board = report
        .board
        .map_or(String::new(), |board| format!(" · {board}"));
    writeln!(
        out,
        "{}{board} · {} samples at {} ms, force up to {} N, reach {:.2} to {:.2} mm",
        report.device,
        found.samples,
        digits(1e3 * found.sample_time_s),
        digits(report.largest_force_n),
        1e3 * report.reach_low_m,
        1e3 * report.reach_high_m
    )?;
    let mut line = |name: &str, estimate: &Estimate, scale: f64, unit: &str| {
        let [value, low, high] = [estimate.value, estimate.low, estimate.high]
            .map(|x| significant(scale * x, telling(estimate)));
        writeln!(out, "  {name:<17} {value} {unit}   95 %: {low} to {high}")
    };
    line("mass", &found.mass_kg, 1e3, "g")?;
    line("damping", &found.damping_n_s_per_m, 1.0, "N·s/m")?;
    line("friction", &found.friction_n, 1.0, "N")?;
    if let Some(hand) = &found.hand_stiffness_n_per_m {
        line("hand", hand, 1.0, "N/m")?;
    }
    line("delay", &found.delay_s, 1e3, "ms")?;
    line("current lag", &found.current_lag_s, 1e3, "ms")?;
    line("noise", &found.sensor_noise_m, 1e6, "µm")?;
    line("constant force", &found.bias_n, 1.0, "N")?;
    let step = found.encoder_resolution_m;
    if step > 0.0 {
        writeln!(out, "  encoder           {} µm", digits(1e6 * step))?;
    } else {
        writeln!(out, "  encoder           no steps seen")?;
    }
    if let Some(force) = found.breakaway_n {
        writeln!(out, "  begins to move    at {} N at most", digits(force))?;
    }
    writeln!(
        out,
        "  residual          {} µm rms, of which the sensor explains {} µm",
        digits(1e6 * found.residual_rms_m),
        digits(1e6 * found.expected_residual_rms_m)
    )?;
    for (what, file) in [("device file", &report.model), ("figure", &report.figure)] {
        if let Some(file) = file {
            writeln!(out, "  {what:<17} {file}")?;
        }
    }
    Ok(())
}
