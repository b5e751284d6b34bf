//! Results of loops for programs and for people.

use super::words::{digits, percent};
use fractional_control::{Crossing, Margins, PidParameters, Shape};
use serde::Serialize;
use std::io::{self, Write};

/// Margins and peaks.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct MarginReport {
    pub(super) crossover_rad_s: Option<f64>,
    pub(super) crossovers: usize,
    pub(super) phase_margin_deg: Option<f64>,
    pub(super) gain_up: Option<f64>,
    pub(super) gain_up_rad_s: Option<f64>,
    pub(super) gain_down: Option<f64>,
    pub(super) gain_down_rad_s: Option<f64>,
    pub(super) delay_margin_s: Option<f64>,
    pub(super) sensitivity_peak: f64,
    pub(super) sensitivity_peak_rad_s: f64,
    pub(super) complementary_peak: f64,
    pub(super) complementary_peak_rad_s: f64,
}

impl From<&Margins> for MarginReport {
    fn from(margins: &Margins) -> Self {
        let value = |crossing: Option<Crossing>| crossing.map(|crossing| crossing.value);
        let place = |crossing: Option<Crossing>| crossing.map(|crossing| crossing.omega_rad_s);
        Self {
            crossover_rad_s: place(margins.phase),
            crossovers: margins.crossovers,
            phase_margin_deg: value(margins.phase).map(f64::to_degrees),
            gain_up: value(margins.gain_up),
            gain_up_rad_s: place(margins.gain_up),
            gain_down: value(margins.gain_down),
            gain_down_rad_s: place(margins.gain_down),
            delay_margin_s: value(margins.delay_s),
            sensitivity_peak: margins.sensitivity.value,
            sensitivity_peak_rad_s: margins.sensitivity.omega_rad_s,
            complementary_peak: margins.complementary.value,
            complementary_peak_rad_s: margins.complementary.omega_rad_s,
        }
    }
}

impl MarginReport {
    /// A line for each.
    pub(super) fn print(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut line = |name: &str, value: Option<String>, place: Option<f64>| {
            let value = value.unwrap_or_else(|| "none".to_owned());
            let place =
                place.map_or_else(String::new, |omega| format!("at {} rad/s", digits(omega)));
            writeln!(out, "  {name:<22}{value:<14} {place}")
        };
        let times = |value: Option<f64>| value.map(|value| format!("{} times", digits(value)));
        line(
            "phase margin",
            self.phase_margin_deg.map(|margin| format!("{margin:.2}°")),
            self.crossover_rad_s,
        )?;
        line("gain margin up", times(self.gain_up), self.gain_up_rad_s)?;
        if self.gain_down.is_some() {
            line(
                "gain margin down",
                times(self.gain_down),
                self.gain_down_rad_s,
            )?;
        }
        line(
            "delay margin",
            self.delay_margin_s
                .map(|delay| format!("{} s", digits(delay))),
            None,
        )?;
        line(
            "largest |S|",
            Some(digits(self.sensitivity_peak)),
            Some(self.sensitivity_peak_rad_s),
        )?;
        line(
            "largest |T|",
            Some(digits(self.complementary_peak)),
            Some(self.complementary_peak_rad_s),
        )
    }
}

/// The shape of a step.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct ShapeReport {
    pub(super) overshoot: f64,
    pub(super) rise_time_s: Option<f64>,
    pub(super) settling_time_s: Option<f64>,
    pub(super) final_error: f64,
}

impl ShapeReport {
    pub(super) fn new(shape: &Shape, sample_time_s: f64) -> Self {
        Self {
            overshoot: shape.overshoot,
            rise_time_s: shape.rise.map(|samples| samples * sample_time_s),
            settling_time_s: shape.settled.map(|samples| samples as f64 * sample_time_s),
            final_error: shape.final_error,
        }
    }

    /// Name and value of each.
    pub(super) fn cells(&self) -> [(&'static str, String); 4] {
        let time = |time: Option<f64>| {
            time.map_or_else(|| "never".to_owned(), |time| format!("{} s", digits(time)))
        };
        [
            ("overshoot", percent(self.overshoot)),
            ("rise, 10 to 90 %", time(self.rise_time_s)),
            ("settled within 2 %", time(self.settling_time_s)),
            ("error at the end", percent(self.final_error)),
        ]
    }
}

/// Parameters of a PI^λD^μ.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct PidReport {
    pub(super) proportional_gain: f64,
    pub(super) integral_gain_per_s_lambda: f64,
    pub(super) integral_order: f64,
    pub(super) derivative_gain_s_mu: f64,
    pub(super) derivative_order: f64,
}

impl From<PidParameters> for PidReport {
    fn from(own: PidParameters) -> Self {
        Self {
            proportional_gain: own.proportional,
            integral_gain_per_s_lambda: own.integral,
            integral_order: own.integral_order,
            derivative_gain_s_mu: own.derivative,
            derivative_order: own.derivative_order,
        }
    }
}

/// A table of columns of text under a header, all but the first to the right.
pub(super) fn table(out: &mut dyn Write, rows: &[Vec<String>]) -> io::Result<()> {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        let cells = rows.iter().filter_map(|row| row.get(column));
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    for row in rows {
        let mut line = String::from(" ");
        for (column, cell) in row.iter().enumerate() {
            let space = " ".repeat(widths[column] - cell.chars().count());
            line += &match column {
                0 => format!(" {cell}{space}"),
                _ => format!("   {space}{cell}"),
            };
        }
        writeln!(out, "{}", line.trim_end())?;
    }
    Ok(())
}

/// The names of files that were written.
pub(super) fn written(out: &mut dyn Write, files: &[String]) -> io::Result<()> {
    files
        .iter()
        .try_for_each(|file| writeln!(out, "written: {file}"))
}
