//! Options of a run that follows the clock.

use crate::whole::whole;
use clap::Args;
use haptic_experiment::Failure;
use haptic_experiment::{Pace, RealtimeOptions, RealtimeSummary};
use haptic_loop::realtime::{PRIORITIES, allowed_cores};
use std::io::{self, Write};

/// Arguments of every experiment that can run by the clock.
#[derive(Clone, Copy, Debug, Args)]
pub struct RealtimeArguments {
    /// Pace the run by the clock instead of as fast as it goes
    #[arg(long, help_heading = "Real time")]
    realtime: bool,
    #[command(flatten)]
    thread: ThreadArguments,
}

/// Options of a thread.
#[derive(Clone, Copy, Debug, Args)]
pub struct ThreadArguments {
    /// Real-time priority of the loop (`SCHED_FIFO`, 1 to 99), its memory locked; `off` for a normal thread
    /// [default: 80 where permitted]
    #[arg(long, value_name = "N|off", value_parser = parse_priority)]
    #[arg(allow_hyphen_values = true, help_heading = "Real time")]
    priority: Option<Priority>,
    /// Run the loop on this core only, from 0
    #[arg(long, value_name = "CORE", value_parser = whole::<usize>(0..=100_000))]
    #[arg(allow_hyphen_values = true, help_heading = "Real time")]
    pin: Option<usize>,
}

/// A priority, or none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Priority {
    Off,
    Fifo(u8),
}

fn parse_priority(text: &str) -> Result<Priority, String> {
    if text == "off" {
        return Ok(Priority::Off);
    }
    match text.parse() {
        Ok(priority) if PRIORITIES.contains(&priority) => Ok(Priority::Fifo(priority)),
        _ => Err("not in 1 to 99, nor off".to_owned()),
    }
}

impl ThreadArguments {
    /// The options as typed; the priority `default` if nothing is said of it.
    ///
    /// # Errors
    /// A core that this process may not use.
    pub fn options(self, default: Option<u8>) -> Result<RealtimeOptions, Failure> {
        let priority = match self.priority {
            Some(Priority::Off) => None,
            Some(Priority::Fifo(priority)) => Some(priority),
            None => default,
        };
        if let Some(core) = self.pin {
            let allowed = allowed_cores();
            // A system that does not say refuses later, as a warning.
            if !allowed.is_empty() && !allowed.contains(&core) {
                let names: Vec<String> = allowed.iter().map(ToString::to_string).collect();
                return Err(Failure::bad_input(format_args!(
                    "core {core} is not one that this program may use: give --pin one of {}",
                    names.join(", ")
                )));
            }
        }
        Ok(RealtimeOptions {
            priority,
            pin: self.pin,
        })
    }
}

impl RealtimeArguments {
    /// The pace of the run. A serial device has its own clock: then a priority is for the threads that speak with it,
    /// and only if it is asked for.
    ///
    /// # Errors
    /// A core that this process may not use; options without a clock.
    pub fn pace(self, on_device: bool) -> Result<Pace, Failure> {
        let ThreadArguments { priority, pin } = self.thread;
        if !self.realtime && !on_device {
            if priority.is_some() || pin.is_some() {
                return Err(Failure::bad_input(
                    "--priority and --pin are for runs by the clock: add --realtime",
                ));
            }
            return Ok(Pace::Virtual);
        }
        let default = self.realtime.then_some(RealtimeOptions::DEFAULT_PRIORITY);
        Ok(Pace::Realtime(self.thread.options(default)?))
    }
}

/// The part of a summary that says where the time went.
///
/// # Errors
/// Those of `out`.
pub fn print(out: &mut dyn Write, realtime: &RealtimeSummary) -> io::Result<()> {
    let thread = match realtime.priority {
        Some(priority) => format!("priority {priority}"),
        None => "normal priority".to_owned(),
    };
    let core = realtime
        .pin
        .map_or_else(String::new, |core| format!(", core {core}"));
    writeln!(
        out,
        "  clock             {thread}{core}, last {} µs spun; {} woken late, {} delayed by the tick before, {} \
         periods skipped",
        realtime.spin_margin_us,
        realtime.late_by_wake_up,
        realtime.late_by_compute,
        realtime.skipped_periods
    )?;
    for (name, us) in [
        ("late", realtime.lateness_us),
        ("compute", realtime.compute_us),
        ("both", realtime.tick_us),
    ] {
        writeln!(
            out,
            "    {name:<15} {:.1} µs median, {:.1} µs 99 %, {:.1} µs 99.9 %, {:.1} µs longest",
            us.p50, us.p99, us.p999, us.max
        )?;
    }
    if let Some(worst) = realtime.worst_cycle {
        writeln!(
            out,
            "    worst           tick {}: {:.1} µs late, {:.1} µs of compute",
            worst.number, worst.lateness_us, worst.compute_us
        )?;
    }
    Ok(())
}
