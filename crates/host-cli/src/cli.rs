//! The command line: what may be typed, and what it means.

use crate::command;
use crate::output::Output;
use clap::{CommandFactory as _, Parser, Subcommand};
use haptic_experiment::Failure;

const LONG_ABOUT: &str = "\
Runs fractional-order haptic experiments, keeps their logs and draws their figures.

Values are SI unless a unit is given: --strain 5%, --duration 200s, --sample-time 1ms.

SCHEME names the fractional operator D^mu:
{schemes}
DEVICE is what an experiment runs on:
  sim                           simulated in this program (default)
  serial:PATH[@BAUD]            a device at a serial port, or an emulated one
  serial:auto                   the only one that answers
  haply:PATH[,version=2]        a Haply 2DIY, see docs/guide/src/haply-2diy.md
  moteus:PATH[,id=1,radius=20mm] a moteus servo, see docs/guide/src/moteus.md

Exit codes: 0 done; 1 the run failed, was interrupted or a fault ended it; 2 bad usage or bad
input; 3 device or link not usable, or lost; 4 data was lost, what could be kept was kept. 3 goes
before 1, and 1 before 4.";

/// Fractional-order haptics: experiments, logs, figures.
#[derive(Debug, Parser)]
#[command(
    name = "host-cli",
    version,
    about,
    long_about = LONG_ABOUT.replace("{schemes}", &fracdiff::Scheme::help()),
    max_term_width = 100,
    after_help = "Example: host-cli relax --duration 200s --out relaxation"
)]
pub struct Cli {
    /// Print the report as one JSON object
    #[arg(long, global = true, help_heading = "Run")]
    pub json: bool,
    /// Print errors and warnings only
    #[arg(long, short, global = true, help_heading = "Run")]
    pub quiet: bool,
    /// The task
    #[command(subcommand)]
    pub command: Command,
}

/// A command. The line above each is its short help; without its long help beside it, that line would be all of `--help`.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Stress relaxation: indent a virtual tissue, hold, record the force
    #[command(long_about = command::relax::LONG_ABOUT)]
    Relax(command::relax::Arguments),
    /// Creep: push a virtual tissue with a constant force, record the strain
    #[command(long_about = command::creep::LONG_ABOUT)]
    Creep(command::creep::Arguments),
    /// Judge stability, passivity and transparency, before any hardware
    #[command(subcommand)]
    Analyze(command::analyze::Command),
    /// Fractional controllers: design, simulate, analyze, and identify a plant
    #[command(subcommand)]
    Control(command::control::Command),
    /// The stiffest wall, the most damping or the closest tissue for a device, and its order
    #[command(long_about = command::design::LONG_ABOUT)]
    Design(command::design::Arguments),
    /// Run the experiment that a file describes
    #[command(long_about = command::run::long_about())]
    Run(command::run::Arguments),
    /// One side of a teleoperation; the other in another process, UDP between them
    #[command(long_about = command::teleoperate::LONG_ABOUT)]
    Teleoperate(command::teleoperate::Arguments),
    /// Find the stiffest wall a device can render, by trying
    #[command(long_about = command::zwidth::LONG_ABOUT)]
    Zwidth(command::zwidth::Arguments),
    /// Measure whether this machine is fit for a loop at 1, 4 and 10 kHz, and what to change
    #[command(long_about = command::rt_check::LONG_ABOUT)]
    RtCheck(command::rt_check::Arguments),
    /// Make every figure of the dissertation again and judge its claims
    Reproduce(command::reproduce::Arguments),
    /// Print the impulse response of an operator
    Weights(command::weights::Arguments),
    /// Differentiate or integrate a CSV column to a fractional order
    Differintegrate(command::differintegrate::Arguments),
    /// Write an operator as a header in C99, for any microcontroller
    ExportC(command::export_c::Arguments),
    /// Find, inspect, configure, imitate, program and watch a device
    #[command(subcommand)]
    Device(command::device::Command),
    /// The tissue library
    #[command(subcommand)]
    Materials(command::materials::Command),
    /// A tissue from a measured record: relaxation, creep, oscillation or any motion
    #[command(long_about = command::identify::LONG_ABOUT)]
    Identify(command::identify::Arguments),
    /// Look into a log, verify it, save what a cut file still holds, turn it into CSV or a picture
    #[command(subcommand)]
    Log(command::log::Command),
    /// A page in the browser: feel a tissue, see what is stable, watch and start runs
    #[cfg(feature = "serve")]
    #[command(long_about = command::serve::LONG_ABOUT)]
    Serve(command::serve::Arguments),
    /// Print a completion script for a shell
    Completions(command::shell::Completions),
    /// Write the manual pages
    Man(command::shell::Man),
}

impl Cli {
    /// Does what was asked.
    ///
    /// # Errors
    /// Any failure, with its exit code.
    pub fn run(self) -> Result<(), Failure> {
        let output = Output {
            json: self.json,
            quiet: self.quiet,
        };
        match self.command {
            Command::Relax(arguments) => arguments.run(output),
            Command::Creep(arguments) => arguments.run(output),
            Command::Analyze(command) => command.run(output),
            Command::Control(command) => command.run(output),
            Command::Design(arguments) => arguments.run(output),
            Command::Run(arguments) => arguments.run(output),
            Command::Teleoperate(arguments) => arguments.run(output),
            Command::Zwidth(arguments) => arguments.run(output),
            Command::RtCheck(arguments) => arguments.run(output),
            Command::Reproduce(arguments) => arguments.run(output),
            Command::Weights(arguments) => arguments.run(output),
            Command::Differintegrate(arguments) => arguments.run(output),
            Command::ExportC(arguments) => arguments.run(output),
            Command::Device(command) => command.run(output),
            Command::Materials(command) => command.run(output),
            Command::Identify(arguments) => arguments.run(output),
            Command::Log(command) => command.run(output),
            #[cfg(feature = "serve")]
            Command::Serve(arguments) => arguments.run(output),
            Command::Completions(arguments) => arguments.run(Self::command(), output),
            Command::Man(arguments) => arguments.run(Self::command(), output),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_well_formed() {
        Cli::command().debug_assert();
    }

    #[test]
    fn every_command_shows_an_example() {
        fn check(command: &clap::Command, path: &str) {
            let name = format!("{path} {}", command.get_name());
            if command.get_subcommands().next().is_none() {
                let help = command.get_after_help().map(ToString::to_string);
                assert!(help.is_some_and(|help| help.contains("Example")), "{name}");
            }
            for inner in command.get_subcommands() {
                check(inner, &name);
            }
        }
        check(&Cli::command(), "");
    }
}
