//! `rt-check`: is this machine fit for a loop at 1, 4 or 10 kHz?

use super::conduct::progress_bar;
use super::realtime::ThreadArguments;
use super::stop::stop_on_interrupt;
use crate::output::Output;
use crate::whole::whole;
use clap::Args;
use fracdiff::parameter::Shown;
use haptic_experiment::Failure;
use haptic_experiment::RealtimeOptions;
use haptic_experiment::question::{FIT_SHARE, Rate, RtCheck, RtReport};
use haptic_quantity::{Frequency, Time};
use std::io::{self, Write};
use std::time::Duration;

pub(crate) const LONG_ABOUT: &str = "\
Measures how late a loop by the clock starts its ticks on this machine, with the runner of --realtime, and says \
for each rate whether it is safe: no tick a whole period late, and 999 of 1000 within a tenth of the period. \
Then what to change: permissions, kernel, governor, latency timers, throttling.

Do it while the machine does what it will do beside the loop, and for longer than a minute before you trust \
it: what is rare is not seen in seconds.";

/// Arguments of `rt-check`.
#[derive(Debug, Args)]
#[command(after_help = "Example: host-cli rt-check --duration 60s --busy 2")]
pub struct Arguments {
    /// Time to measure each rate for
    #[arg(long, default_value = "5s", allow_hyphen_values = true)]
    duration: Time,
    /// A rate to measure; may be given more than once [default: 1kHz, 4kHz and 10kHz]
    #[arg(long, value_name = "RATE", allow_hyphen_values = true)]
    rate: Vec<Frequency>,
    /// Threads of normal priority that keep processors busy meanwhile
    #[arg(long, value_name = "COUNT", default_value_t = 0, allow_hyphen_values = true, value_parser = whole::<u16>(0..=1024))]
    busy: u16,
    /// Measure a plain loop (`std::thread::sleep`, normal priority) in turns with the runner, to compare with
    #[arg(long)]
    compare: bool,
    #[command(flatten)]
    thread: ThreadArguments,
}

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A duration, rate or core outside its range; interrupted.
    pub fn run(self, output: Output) -> Result<(), Failure> {
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
        output.print(&report, |out| print(out, &report))
    }
}

/// The result as a person reads it.
fn print(out: &mut dyn Write, report: &RtReport) -> io::Result<()> {
    let machine = &report.machine;
    let kernel = match (&machine.kernel, machine.preempt_rt) {
        (Some(kernel), Some(true)) => format!("kernel {kernel}, PREEMPT_RT"),
        (Some(kernel), _) => format!("kernel {kernel}, not PREEMPT_RT"),
        (None, _) => "kernel unknown".to_owned(),
    };
    let thread = match report.priority {
        Some(priority) => format!("priority {priority}"),
        None => "normal priority".to_owned(),
    };
    let busy = match report.busy {
        0 => String::new(),
        busy => format!(" · {busy} busy threads beside"),
    };
    writeln!(
        out,
        "{kernel} · {} cores{} · {thread}{busy} · {} s each",
        machine.cores,
        if machine.virtual_machine {
            ", virtual"
        } else {
            ""
        },
        report.duration_s
    )?;
    writeln!(
        out,
        "{:>9}  {:>30}  {:>9} {:>9} {:>9} {:>9}  {:>8}",
        "rate", "µs late:", "median", "99 %", "99.9 %", "longest", "overruns"
    )?;
    for rate in &report.rates {
        print_rate(out, rate)?;
    }
    for sentence in &report.advice {
        writeln!(out, "- {sentence}")?;
    }
    Ok(())
}

fn print_rate(out: &mut dyn Write, rate: &Rate) -> io::Result<()> {
    let us = rate.lateness_us;
    writeln!(
        out,
        "{:>6} Hz  {:>30}  {:>9.1} {:>9.1} {:>9.1} {:>9.1}  {:>8}",
        rate.hz,
        verdict(rate),
        us.p50,
        us.p99,
        us.p999,
        us.max,
        rate.overruns
    )?;
    if let Some(plain) = rate.plain {
        let us = plain.lateness_us;
        writeln!(
            out,
            "{:>9}  {:>30}  {:>9.1} {:>9.1} {:>9.1} {:>9.1}  {:>8}  99.9 % is {:.1} times",
            "", "plain sleep", us.p50, us.p99, us.p999, us.max, plain.overruns, plain.ratio_p999
        )?;
    }
    Ok(())
}

fn verdict(rate: &Rate) -> &'static str {
    if rate.fit {
        "safe"
    } else if rate.lateness_us.p999 <= FIT_SHARE * 1e6 / rate.hz {
        "good, but for the overruns"
    } else {
        "not safe"
    }
}
