//! `rt-check`: is this machine fit for a loop at 1, 4 or 10 kHz?

use crate::command::conduct::{ThreadArguments, progress_bar, stop_on_interrupt};
use crate::output::Output;
use crate::parse::{quantity, whole};
use clap::Args;
use haptic_experiment::Failure;
use haptic_experiment::parameters::Range;
use haptic_experiment::question::RtCheck;
use haptic_run::RealtimeOptions;
use std::time::Duration;

/// Ten cycles of the slowest rate at least; a day at most, s.
const DURATIONS: Range = Range::Within(0.01, 86_400.0);
/// Rates that can be asked for, Hz.
const RATES: Range = Range::Within(1.0, 100e3);

/// Measure whether this machine is fit for a loop at 1, 4 and 10 kHz
///
/// A rate fits if no tick starts a whole period late, and 999 of 1000 start within a tenth of the
/// period. At the end it says what to change.
///
/// Run it while the machine does its usual work, for more than a minute: rare delays do not show in
/// seconds.
#[derive(Debug, Args)]
#[command(after_help = "Example: host-cli rt-check --duration 60s --busy 2")]
pub(crate) struct Arguments {
    /// Time to measure each rate for
    #[arg(long, value_name = "TIME", value_parser = quantity("_s", DURATIONS), default_value = "5s")]
    duration: f64,
    /// A rate to measure; may be given more than once [default: 1kHz, 4kHz and 10kHz]
    #[arg(long, value_name = "RATE", value_parser = quantity("_hz", RATES))]
    rate: Vec<f64>,
    /// Threads of normal priority that keep processors busy meanwhile
    #[arg(long, value_name = "COUNT", default_value_t = 0, value_parser = whole::<u16>(0..=1024))]
    busy: u16,
    #[command(flatten)]
    thread: ThreadArguments,
}

impl Arguments {
    pub(crate) fn run(self, output: Output) -> Result<(), Failure> {
        let rates_hz = match &self.rate[..] {
            [] => vec![1e3, 4e3, 10e3],
            rates => rates.to_vec(),
        };
        let default = Some(RealtimeOptions::DEFAULT_PRIORITY);
        let check = RtCheck {
            duration: Duration::from_secs_f64(self.duration),
            rates_hz,
            thread: self.thread.options(default)?,
            busy: usize::from(self.busy),
        };
        let stop = stop_on_interrupt()?;
        let bar = progress_bar(1000, output);
        let measured = check.run(stop, &|share| bar.set_position((1e3 * share) as u64));
        bar.finish_and_clear();
        output.report(&measured?)
    }
}
