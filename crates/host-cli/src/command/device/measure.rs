//! `device measure`: what a device is made of, by a motion that it makes.

mod draw;
mod print;

use crate::command::conduct::progress_bar;
use crate::command::stop::stop_on_interrupt;
use crate::files::PlaceOfFile;
use crate::keys;
use crate::options::Options;
use crate::output::{Output, note, warn};
use crate::within::within;
use clap::Args;
use haptic_experiment::Failure;
use haptic_experiment::document::Document;
use haptic_experiment::parameters::{MEASUREMENT, range};
use haptic_experiment::question::measurement::Measurement;
use haptic_experiment::question::measurement::{
    MeasurePlan, Measured, MotionRecord, SerialMotion, estimate, on_serial, on_simulated,
};
use haptic_experiment::run::DeviceModel;
use haptic_log::record::StartTime;
use haptic_quantity::Time;
use print::{Report, print};
use std::path::PathBuf;
use std::time::{Duration, SystemTime};

const LONG_ABOUT: &str = "\
Finds mass, damping, Coulomb friction, delay, current lag, encoder step and noise of the device at hand, with intervals, and writes a device \
file that analyze, design, zwidth, relax, run and control take.

Three parts: half a second without force; a force that grows slowly, one way and the other, until the device moves; a multi-sine. Never more than \
a fifth of --force-limit, never further from the start than --box: beyond it the force falls to zero, as it does on Ctrl-C. \
Put the device in the middle of its range, level, and let go of it; or hold it and say --held.

The interval of a value has the true one in it in 95 of 100 measurements, if the device is a mass with these things and nothing else. \
The lower half of the picture shows what the model does not explain. The delay of a serial device is its own, without the line.

JSON: device, board, mass_kg, damping_n_s_per_m, friction_n, hand_stiffness_n_per_m, delay_s, current_lag_s, sensor_noise_m, bias_n (each \
{value, low, high}), encoder_resolution_m, breakaway_n, residual_rms_m, expected_residual_rms_m, delay_lag_correlation, sample_time_s, samples, \
lost_samples, largest_force_n, reach_low_m, reach_high_m, model, figure, warnings.";

/// Arguments of `device measure`.
#[derive(Debug, Args)]
#[command(
    long_about = LONG_ABOUT,
    after_help = "Examples:\n  host-cli device measure --device serial:/dev/ttyACM0 --force-limit 3.3N --out device.toml\n  \
                  host-cli zwidth --device-model device.toml --sample-time 1ms\n  host-cli device measure --device sim --device-model laboratory --mass 80g   \
                  # how well would it find this one?"
)]
pub struct Arguments {
    #[command(flatten)]
    options: Options<keys::Measure>,
    /// Wait so long for a device that is not there yet [default: 0s]
    #[arg(long, value_parser = within::<Time>(range::WAITS), value_name = "TIME", allow_hyphen_values = true)]
    wait: Option<Time>,
    /// Device file to write; a picture of the same name goes beside it
    #[arg(long, value_name = "FILE.toml", help_heading = "Files")]
    out: Option<PathBuf>,
    /// Replace the files of an earlier measurement
    #[arg(long, help_heading = "Files")]
    overwrite: bool,
}

/// A motion and whose it is.
struct Motion {
    record: MotionRecord,
    device: String,
    board: Option<String>,
}

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A device that cannot be used or measured, files that cannot be written.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let mut place = PlaceOfFile::look(self.out.as_deref(), self.overwrite, "device")?;
        let document = self.options.over(Document::new(MEASUREMENT))?;
        let mut asked = Measurement::open(&document).map_err(Failure::input)?;
        if let (Some(remote), Some(wait)) = (&mut asked.remote, self.wait) {
            remote.patience = Duration::from_secs_f64(wait.0);
        }
        let plan = asked.plan;
        let motion = motion(&asked, output)?;
        let found = estimate(&motion.record, plan.hand).map_err(Failure::input)?;
        for warning in &found.warnings {
            note("warning", warning);
        }
        let files = write(&motion, &plan, &found, &mut place);
        let names = (motion.device.as_str(), motion.board.as_deref());
        let report = Report::new(names, &motion.record, &found, files);
        output.summary(&report, |out| print(out, &report))?;
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
        "{}{board}, {}, {} s of multi-sine at {} ms, up to {} N in a box of {} mm, hand {}, model off by {:.2} µm rms",
        motion.device,
        date.split('T').next().unwrap_or_default(),
        plan.duration_s,
        1e3 * plan.sample_time_s,
        print::digits(plan.force_n()),
        1e3 * plan.box_m,
        if plan.hand { "on" } else { "off" },
        1e6 * found.residual_rms_m
    );
    let program = concat!("host-cli ", env!("CARGO_PKG_VERSION"));
    let text = || DeviceModel::measured(found, program, &words).to_toml();
    place.write(text, || draw::draw(&found.curve, &words))
}
