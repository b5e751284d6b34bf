//! `rt-check`: is this machine fit for a loop at 1, 4 or 10 kHz?

use crate::command::conduct::{ThreadArguments, progress_bar, stop_on_interrupt};
use crate::output::Output;
use crate::parse::whole;
use clap::Args;
use fracdiff::parameter::Shown;
use haptic_experiment::question::RtCheck;
use haptic_experiment::{Failure, RealtimeOptions};
use haptic_quantity::{Frequency, Time};
use std::time::Duration;

pub(crate) const LONG_ABOUT: &str = "\
Measures how late this machine starts the ticks of a loop, and says for each rate whether it is fit: no tick a whole period late, and 999 of 1000 \
within a tenth of the period. Then it says what to change.

Run it while the machine does its usual work, for more than a minute: rare delays do not show in seconds.";

/// Arguments of `rt-check`.
#[derive(Debug, Args)]
#[command(after_help = "Example: host-cli rt-check --duration 60s --busy 2")]
pub(crate) struct Arguments {
    /// Time to measure each rate for
    #[arg(long, default_value = "5s")]
    duration: Time,
    /// A rate to measure; may be given more than once [default: 1kHz, 4kHz and 10kHz]
    #[arg(long, value_name = "RATE")]
    rate: Vec<Frequency>,
    /// Threads of normal priority that keep processors busy meanwhile
    #[arg(long, value_name = "COUNT", default_value_t = 0, value_parser = whole::<u16>(0..=1024))]
    busy: u16,
    /// Measure a plain loop (`std::thread::sleep`, normal priority) in turns with the runner, to compare with
    #[arg(long)]
    compare: bool,
    #[command(flatten)]
    thread: ThreadArguments,
}

impl Arguments {
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        /// Ten cycles of the slowest rate at least; a day at most.
        const DURATIONS_S: std::ops::RangeInclusive<f64> = 0.01..=86_400.0;
        if !DURATIONS_S.contains(&self.duration.0) {
            return Err(Failure::bad_input(format_args!(
                "duration {} s is not in [0.01, 86400] s: give --duration, as in 10s",
                Shown(self.duration.0)
            )));
        }
        let rates_hz: Vec<f64> = if self.rate.is_empty() {
            vec![1e3, 4e3, 10e3]
        } else {
            self.rate.iter().map(|rate| rate.0).collect()
        };
        if let Some(hz) = rates_hz.iter().find(|hz| !(1.0..=100e3).contains(*hz)) {
            return Err(Failure::bad_input(format_args!(
                "rate {hz} Hz is not in [1, 100000] Hz: give --rate, as in 1kHz",
                hz = Shown(*hz)
            )));
        }
        let check = RtCheck {
            duration: Duration::try_from_secs_f64(self.duration.0).map_err(Failure::input)?,
            rates_hz,
            thread: self
                .thread
                .options(Some(RealtimeOptions::DEFAULT_PRIORITY))?,
            busy: usize::from(self.busy),
            compare: self.compare,
        };
        let stop = stop_on_interrupt()?;
        let bar = progress_bar(1000, output);
        let measured = check.run(stop, &|share| bar.set_position((1e3 * share) as u64));
        bar.finish_and_clear();
        let report = measured?;
        output.report(&report)
    }
}
