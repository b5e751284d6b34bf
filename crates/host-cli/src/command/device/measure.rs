//! `device measure`: what a device is made of, by a motion that it makes.

mod draw;
mod print;

use super::number::watchdog_ms;
use super::port::PortArguments;
use crate::choice::choice;
use crate::command::conduct::progress_bar;
use crate::command::plant::SimulatedArguments;
use crate::command::stop::stop_on_interrupt;
use crate::files::PlaceOfFile;
use crate::output::{Output, note, warn};
use crate::parameter::with_options;
use crate::whole::whole;
use crate::within::within;
use clap::Args;
use haptic_experiment::device::LinkedName;
use haptic_experiment::failure::Failure;
use haptic_experiment::measured_device::{
    MeasurePlan, Measured, MotionRecord, SerialMotion, estimate, on_serial, on_simulated,
};
use haptic_experiment::plant_file::DeviceModel;
use haptic_experiment::remote::RemoteDevice;
use haptic_experiment::{Named, parameters};
use haptic_log::record::StartTime;
use haptic_quantity::{Force, Length, Time};
use print::{Report, print};
use std::path::PathBuf;
use std::time::{Duration, SystemTime};

const LONG_ABOUT: &str = "\
Finds mass, damping, Coulomb friction, delay, current lag, encoder step and noise of the device at hand, with intervals, and writes a device \
file that analyze, design, zwidth, relax, run and control take.

Three parts: half a second without force; a force that grows slowly, one way and the other, until the device moves; a multi-sine. Never more than \
a fifth of --force-limit, never further from the start than --box: beyond it the force falls to zero, as it does on Ctrl-C. \
Put the device in the middle of its range, level, and let go of it; or hold it and say --hand on.

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
    port: PortArguments,
    #[arg(long, value_parser = within::<Force>(parameters::MEASURE_FORCE_LIMIT.range()), help = parameters::MEASURE_FORCE_LIMIT.help, default_value = parameters::MEASURE_FORCE_LIMIT.shown, allow_hyphen_values = true)]
    force_limit: Force,
    #[arg(long = "box", value_parser = within::<Length>(parameters::MEASURE_BOX.range()), help = parameters::MEASURE_BOX.help, value_name = "LENGTH", default_value = parameters::MEASURE_BOX.shown, allow_hyphen_values = true)]
    box_m: Length,
    #[arg(long, value_parser = within::<Time>(parameters::MEASURE_DURATION.range()), help = parameters::MEASURE_DURATION.help, default_value = parameters::MEASURE_DURATION.shown, allow_hyphen_values = true)]
    duration: Time,
    #[arg(long, value_parser = within::<Time>(parameters::MEASURE_SAMPLE_TIME.range()), help = parameters::MEASURE_SAMPLE_TIME.help, default_value = parameters::MEASURE_SAMPLE_TIME.shown, allow_hyphen_values = true)]
    sample_time: Time,
    /// A hand that holds the device: its stiffness is found too
    #[arg(long, value_parser = choice::<Hand>(), default_value = "off")]
    hand: Hand,
    #[command(flatten)]
    line: LineArguments,
    #[command(flatten)]
    simulated: SimulatedArguments,
    /// Device file to write; a picture of the same name goes beside it
    #[arg(long, value_name = "FILE.toml", help_heading = "Files")]
    out: Option<PathBuf>,
    /// Replace the files of an earlier measurement
    #[arg(long, help_heading = "Files")]
    overwrite: bool,
}

/// Patience of a serial device with the loop that is closed here.
#[derive(Debug, Args)]
#[command(next_help_heading = "Serial device")]
struct LineArguments {
    /// Silence from this program after which a serial device lets go [default: 20ms]
    #[arg(long, value_parser = within::<Time>(parameters::WATCHDOG.range()), value_name = "TIME", allow_hyphen_values = true)]
    watchdog: Option<Time>,
    #[arg(long, help = parameters::MAX_AGE_TICKS.help, value_name = "COUNT", value_parser = whole::<u16>(1..=1000))]
    max_age_ticks: Option<u16>,
}

impl LineArguments {
    /// The device of this name.
    ///
    /// # Errors
    /// A time outside its range.
    fn remote(&self, name: &LinkedName, patience: Duration) -> Result<RemoteDevice, Failure> {
        let mut remote = RemoteDevice {
            patience,
            watchdog_ms: self.watchdog.map(watchdog_ms).transpose()?,
            ..RemoteDevice::new(name.clone())
        };
        if let Some(ticks) = self.max_age_ticks {
            remote.max_age_ticks = ticks;
        }
        Ok(remote)
    }
}

/// A hand at the device, or none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Hand {
    Off,
    On,
}

impl Named for Hand {
    const CHOICES: &'static [(Self, &'static str, &'static str)] = &[
        (Self::Off, "off", "Nobody touches it"),
        (Self::On, "on", "A hand holds it, as still as it can"),
    ];
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
        let plan = MeasurePlan {
            sample_time_s: self.sample_time.0,
            force_limit_n: self.force_limit.0,
            box_m: self.box_m.0,
            duration_s: self.duration.0,
            hand: self.hand == Hand::On,
        };
        plan.check()?;
        let motion = self.motion(&plan, output)?;
        let mut found = estimate(&motion.record, plan.hand).map_err(Failure::input)?;
        for warning in &mut found.warnings {
            *warning = with_options(warning);
            note("warning", &*warning);
        }
        let files = self.write(&motion, &plan, &found, &mut place);
        let names = (motion.device.as_str(), motion.board.as_deref());
        let report = Report::new(names, &motion.record, &found, files);
        output.summary(&report, |out| print(out, &report))?;
        place.close(Ok(()))
    }

    /// Lets the device move.
    fn motion(&self, plan: &MeasurePlan, output: Output) -> Result<Motion, Failure> {
        let stop = stop_on_interrupt()?;
        let bar = progress_bar(plan.ticks_at_most(), output);
        let progress = |ticks| bar.set_position(ticks);
        let moved = match self.port.linked() {
            Some(_) if self.simulated.is_described() => Err(Failure::bad_input(
                "--device-model, --mass, --damping, --friction and the like are of the simulated device: leave them away with a serial one, which \
                 is measured, or give --device sim",
            )),
            Some(name) => {
                let remote = self.line.remote(name, self.port.patience()?)?;
                let moved = on_serial(plan, &remote, &warn, &progress, stop);
                moved.map(
                    |SerialMotion {
                         record,
                         board,
                         simulated,
                     }| Motion {
                        record,
                        device: name.to_string(),
                        board: Some(if simulated {
                            format!("{board} (simulated)")
                        } else {
                            board
                        }),
                    },
                )
            }
            None => {
                let device = self.simulated.ideal(plan.sample_time_s)?;
                let imperfections = self.simulated.imperfections()?;
                on_simulated(plan, device, &imperfections, &progress, stop).map(|record| Motion {
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
        &self,
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
            self.hand.name(),
            1e6 * found.residual_rms_m
        );
        let program = concat!("host-cli ", env!("CARGO_PKG_VERSION"));
        let text = || DeviceModel::measured(found, program, &words).to_toml();
        place.write(text, || draw::draw(&found.curve, &words))
    }
}
