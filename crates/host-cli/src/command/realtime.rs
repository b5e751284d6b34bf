//! Options of a run that follows the clock.

use crate::whole::whole;
use clap::Args;
use haptic_experiment::Failure;
use haptic_experiment::{Pace, RealtimeOptions};
use haptic_loop::realtime::{PRIORITIES, allowed_cores};

/// Arguments of every experiment that can run by the clock.
#[derive(Clone, Copy, Debug, Args)]
pub struct RealtimeArguments {
    /// Pace the run by the clock
    #[arg(long, hide_short_help = true, help_heading = "Run")]
    realtime: bool,
    #[command(flatten)]
    thread: ThreadArguments,
}

/// Options of a thread.
#[derive(Clone, Copy, Debug, Args)]
pub struct ThreadArguments {
    /// Real-time priority of the loop, 1 to 99, or `off` [default: 80 where permitted]
    #[arg(long, value_name = "N|off", value_parser = parse_priority)]
    #[arg(
        allow_hyphen_values = true,
        hide_short_help = true,
        help_heading = "Run"
    )]
    priority: Option<Priority>,
    /// Run the loop on this core, counted from 0
    #[arg(long, value_name = "CORE", value_parser = whole::<usize>(0..=100_000))]
    #[arg(
        allow_hyphen_values = true,
        hide_short_help = true,
        help_heading = "Run"
    )]
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
