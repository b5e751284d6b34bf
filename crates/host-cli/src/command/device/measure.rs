//! `device measure`: what a device is made of, by a motion that it makes.

use crate::command::conduct::{progress_bar, stop_on_interrupt};
use crate::files::{File, PROGRAM, PlaceOfFile};
use crate::options::{Options, keys};
use crate::output::{Output, warn};
use crate::parse::{WAITS, quantity};
use crate::picture::{Panel, linear, logarithmic, page};
use clap::Args;
use haptic_document::Document;
use haptic_experiment::Failure;
use haptic_experiment::parameters::MEASUREMENT;
use haptic_experiment::question::{MeasureReport, Measurement};
use haptic_figure::{FigureError, Look, Picture};
use std::time::Duration;

/// Measure mass, damping, friction, delay, lag and sensor with small, safe forces
///
/// Finds mass, damping, Coulomb friction, delay, current lag, encoder step and noise of a device,
/// with 95 % intervals, and writes a device file that analyze, design, zwidth, relax, run and
/// control take. The frequency response at the lines of the multi-sine, with its coherence, goes
/// into FILE.csv beside it, if the multi-sine lasts 7s or more; control design takes it as --plant.
///
/// The device moves on its own: half a second without force, then a slowly growing force each way
/// until it moves, then a multi-sine. The force never exceeds a fifth of --force-limit. If the
/// device leaves --box, and on Ctrl-C, the force falls to zero. Put the device level, in the middle
/// of its range, and let go; or hold it and give --held.
///
/// A robot that takes a velocity, and whose program has a file without bandwidth and dead time, is measured by small steps of
/// it, at `speed` at most, with nobody at its handle: these two and its damping ratio, for [admittance].
///
/// The intervals assume a mass with these properties and nothing else; the lower half of the
/// picture shows what the model does not explain. The delay of a serial device does not include the
/// line.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  host-cli device measure --device serial:/dev/ttyACM0 --force-limit 3.3N --out device.toml\n  \
                  host-cli zwidth --device-model device.toml --sample-time 1ms\n  host-cli device measure --device sim --device-model laboratory --mass 80g"
)]
pub(crate) struct Arguments {
    #[command(flatten)]
    options: Options<keys::Measure>,
    /// Keep trying for this long if the device is absent [default: 0s]
    #[arg(long, value_name = "TIME", value_parser = quantity("_s", WAITS))]
    wait: Option<f64>,
    #[command(flatten)]
    file: File,
}

impl Arguments {
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        let mut outputs = PlaceOfFile::next_to(&self.file, "device", &["csv"])?;
        let document = self.options.over(Document::new(MEASUREMENT))?;
        let mut asked = Measurement::open(&document)?;
        if let Some(wait) = self.wait {
            asked = asked.with_patience(Duration::from_secs_f64(wait));
        }
        let stop = stop_on_interrupt()?;
        let bar = progress_bar(asked.steps(), output);
        let measured = asked.run(&|ticks| bar.set_position(ticks), stop, &|text| {
            output.warn(text);
        });
        bar.finish_and_clear();
        let mut report = measured?;
        for warning in report.warnings() {
            output.warn(warning);
        }
        let text = || report.device_file(PROGRAM);
        let draw = || draw(&report);
        (report.model, report.figure) = outputs.write(text, draw);
        let table = report.response_table();
        if self.file.out.is_some() && table.is_none() && !report.is_robot() {
            warn(
                "no frequency response: give 8 s of multi-sine, and a larger force limit where friction hides the motion",
            );
        }
        report.frequency_response = outputs.write_beside("csv", table);
        output.report(&report)?;
        outputs.close(Ok(()))
    }
}

/// The motion over the model, below it what the model does not explain, and the frequency response.
fn draw(report: &MeasureReport) -> Result<Picture, FigureError> {
    let curve = report.curve();
    let over_time = |scale: f64, value: fn(&[f64; 3]) -> f64| {
        let points = curve.iter();
        points.map(move |point| (point[0], scale * value(point)))
    };
    let time = match (curve.first(), curve.last()) {
        (Some(first), Some(last)) => linear("time / s").between(first[0], last[0]),
        _ => linear("time / s"),
    };
    let motion = Panel::new(
        "position read, and of the model",
        time,
        linear("position / mm"),
    )
    .with("read", Look::Broad, 6, over_time(1e3, |point| point[1]))
    .with("model", Look::Dashed, 1, over_time(1e3, |point| point[2]));
    let left = over_time(1e6, |point| point[2] - point[1]);
    let residual = Panel::new("model less position read", time, linear("residual / µm"));
    let mut panels = vec![motion, residual.with("residual", Look::Line, 0, left)];
    if report.response().next().is_some() {
        let column = |part: usize| report.response().map(move |line| (line[0], line[part]));
        let omega = || logarithmic("ω / (rad/s)");
        let gain = Panel::new("frequency response", omega(), logarithmic("|G| / (m/N)"));
        let coherence = Panel::new("coherence", omega(), linear("γ²").between(0.0, 1.0));
        panels.push(gain.with("measured", Look::Markers, 0, column(1)));
        panels.push(coherence.with("coherence", Look::Markers, 0, column(2)));
    }
    page("A device, measured", &report.conditions, 1, &panels)
}
