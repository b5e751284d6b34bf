//! `device measure`: what a device is made of, by a motion that it makes.

use crate::command::conduct::{progress_bar, stop_on_interrupt};
use crate::files::{File, PROGRAM, PlaceOfFile};
use crate::options::{Options, keys};
use crate::output::{Output, warn};
use crate::page::{Panel, linear, page};
use crate::parse::within;
use clap::Args;
use haptic_experiment::Failure;
use haptic_experiment::document::Document;
use haptic_experiment::parameters::{MEASUREMENT, range};
use haptic_experiment::question::measurement::{
    MeasurePlan, Measured, Measurement, MotionRecord, SerialMotion, estimate, on_serial,
    on_simulated,
};
use haptic_experiment::run::DeviceModel;
use haptic_figure::{FigureError, Look, Picture};
use haptic_log::record::StartTime;
use haptic_quantity::{Time, digits, written};
use serde::Serialize;
use std::time::{Duration, SystemTime};

pub(super) const LONG_ABOUT: &str = "\
Finds mass, damping, Coulomb friction, delay, current lag, encoder step and noise of a device, with 95 % intervals, and \
writes a device file that analyze, design, zwidth, relax, run and control take.

The device moves by itself: half a second without force, then a slowly growing force each way until it moves, then a \
multi-sine. The force never exceeds a fifth of --force-limit. If the device leaves --box, and on Ctrl-C, the \
force falls to zero. Put the device level, in the middle of its range, and let go; or hold it and give --held.

The intervals assume a mass with these properties and nothing else; the lower half of the picture shows what the model does \
not explain. The delay of a serial device does not include the line.";

/// Arguments of `device measure`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  host-cli device measure --device serial:/dev/ttyACM0 --force-limit 3.3N --out device.toml\n  \
                  host-cli zwidth --device-model device.toml --sample-time 1ms\n  host-cli device measure --device sim --device-model laboratory --mass 80g   \
                  # how accurate would it be for this one?"
)]
pub(crate) struct Arguments {
    #[command(flatten)]
    options: Options<keys::Measure>,
    /// Keep trying for this long if the device is absent [default: 0s]
    #[arg(long, value_parser = within::<Time>(range::WAITS))]
    wait: Option<Time>,
    #[command(flatten)]
    file: File,
}

/// The result.
#[derive(Serialize)]
struct Report<'a> {
    device: &'a str,
    board: Option<&'a str>,
    #[serde(flatten)]
    found: &'a Measured,
    encoder_resolution_reason: Option<&'static str>,
    largest_force_n: f64,
    reach_low_m: f64,
    reach_high_m: f64,
    model: Option<String>,
    figure: Option<String>,
}

/// A motion and whose it is.
struct Motion {
    record: MotionRecord,
    device: String,
    board: Option<String>,
}

impl Arguments {
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        let mut place = PlaceOfFile::look(&self.file, "device")?;
        let document = self.options.over(Document::new(MEASUREMENT))?;
        let mut asked = Measurement::open(&document).map_err(Failure::input)?;
        if let (Some(remote), Some(wait)) = (&mut asked.remote, self.wait) {
            remote.patience = Duration::from_secs_f64(wait.0);
        }
        let plan = asked.plan;
        let motion = motion(&asked, output)?;
        let found = estimate(&motion.record, plan.hand).map_err(Failure::input)?;
        for warning in &found.warnings {
            warn(warning);
        }
        let (model, figure) = write(&motion, &plan, &found, &mut place);
        let (reach_low_m, reach_high_m) = motion.record.reach_m();
        output.summary(&Report {
            device: &motion.device,
            board: motion.board.as_deref(),
            encoder_resolution_reason: (found.encoder_resolution_m == 0.0)
                .then_some("no steps seen"),
            found: &found,
            largest_force_n: motion.record.largest_force_n(),
            reach_low_m,
            reach_high_m,
            model,
            figure,
        })?;
        place.close(Ok(()))
    }
}

/// Lets the device move.
fn motion(asked: &Measurement, output: Output) -> Result<Motion, Failure> {
    let stop = stop_on_interrupt()?;
    let bar = progress_bar(asked.plan.ticks_at_most(), output);
    let progress = |ticks| bar.set_position(ticks);
    let plan = &asked.plan;
    let moved = match &asked.remote {
        Some(remote) => {
            let moved = on_serial(plan, remote, &warn, &progress, stop);
            moved.map(
                |SerialMotion {
                     record,
                     board,
                     simulated,
                 }| Motion {
                    record,
                    device: remote.name.to_string(),
                    board: Some(if simulated {
                        format!("{board} (simulated)")
                    } else {
                        board
                    }),
                },
            )
        }
        None => {
            let device = (asked.device, asked.sensors);
            on_simulated(plan, device, &progress, stop).map(|record| Motion {
                record,
                device: "sim".to_owned(),
                board: None,
            })
        }
    };
    bar.finish_and_clear();
    moved
}

/// Writes the device file and its picture; their names.
fn write(
    motion: &Motion,
    plan: &MeasurePlan,
    found: &Measured,
    place: &mut PlaceOfFile,
) -> (Option<String>, Option<String>) {
    let date = StartTime::at(SystemTime::now()).rfc3339();
    let board = motion
        .board
        .as_ref()
        .map_or(String::new(), |board| format!(", {board}"));
    let words = format!(
        "{}{board}, {}, {} of multi-sine at {}, up to {} N in a box of {}, hand {}, model off by {} rms",
        motion.device,
        date.split('T').next().unwrap_or_default(),
        written("duration_s", plan.duration_s),
        written("sample_time_s", plan.sample_time_s),
        digits(plan.force_n(), 4),
        written("box_m", plan.box_m),
        if plan.hand { "on" } else { "off" },
        written("residual_m", found.residual_rms_m)
    );
    let text = || DeviceModel::measured(found, PROGRAM, &words).to_toml();
    place.write(text, || draw(&found.curve, &words))
}

/// The motion over the model, s and m, and below it what the model does not explain.
fn draw(curve: &[[f64; 3]], words: &str) -> Result<Picture, FigureError> {
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
    let left = Panel::new("model less position read", time, linear("residual / µm")).with(
        "residual",
        Look::Line,
        0,
        left,
    );
    page("A device, measured", words, 1, &[motion, left])
}
