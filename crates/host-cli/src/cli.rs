//! The command line: what may be typed, what it means, and how it ends.

use crate::command;
use crate::command::device::{changes, emulate};
use crate::command::run::Experiment;
use crate::options::{self, WithFiles, keys};
use crate::output::{Output, note, refused};
use clap::error::{ContextKind, ErrorKind};
use clap::{CommandFactory as _, FromArgMatches as _, Parser, Subcommand};
use haptic_experiment::Failure;
use haptic_experiment::parameters::renamed;
use std::any::TypeId;
use std::path::PathBuf;
use std::process::ExitCode;

const LONG_ABOUT: &str = "\
Runs fractional-order haptic experiments, keeps their logs and draws their figures.

Values are SI unless a unit is given: --strain 5%, --duration 200s, --sample-time 1ms.

SCHEME names the fractional operator D^mu:
{schemes}
DEVICE is what an experiment runs on:
  sim                           simulated in this program (default)
  serial:PATH[@BAUD]            a device at a serial port, or an emulated one
  serial:auto                   the only serial device that answers
  haply:PATH[,version=2]        a Haply 2DIY, see docs/guide/src/haply-2diy.md
  moteus:PATH[,id=1,radius=20mm] a moteus servo, see docs/guide/src/moteus.md

Exit codes: 0 done; 1 the run failed, was interrupted or a fault ended it; 2 bad usage or bad
input; 3 device or link not usable, or lost; 4 data was lost, the rest was kept. If several apply, 3
takes precedence over 1, and 1 over 4.";

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
struct Cli {
    /// Print the report as one JSON object
    #[arg(long, global = true, help_heading = "Run")]
    json: bool,
    /// Print errors and warnings only
    #[arg(long, short, global = true, help_heading = "Run")]
    quiet: bool,
    /// The task
    #[command(subcommand)]
    command: Command,
}

/// A command. The line above each is its short help; without its long help beside it, that line would be all of `--help`.
#[derive(Debug, Subcommand)]
enum Command {
    /// Stress relaxation: indent a virtual tissue, hold, record the force
    #[command(long_about = command::run::RELAX_ABOUT, after_help = command::run::RELAX_EXAMPLES)]
    Relax(Experiment<keys::Relax>),
    /// Creep: push a virtual tissue with a constant force, record the strain
    #[command(
        long_about = command::run::CREEP_ABOUT,
        after_help = "Example: host-cli creep --tissue prostate-healthy --stress 50Pa --duration 60s"
    )]
    Creep(Experiment<keys::Creep>),
    /// Judge stability, passivity and transparency, before any hardware
    #[command(subcommand)]
    Analyze(command::analyze::Command),
    /// Fractional controllers: design, simulate, analyze, and identify a plant
    #[command(subcommand)]
    Control(command::control::Command),
    /// Find the stiffest wall, the most damping or the closest tissue for a device
    #[command(long_about = command::design::LONG_ABOUT, after_help = command::design::EXAMPLES)]
    Design(WithFiles<keys::Design>),
    /// Run the experiment that a file describes
    #[command(long_about = command::run::long_about())]
    Run(command::run::Arguments),
    /// Run one side of a teleoperation, with the other side in another process
    #[command(long_about = command::teleoperate::LONG_ABOUT)]
    Teleoperate(command::teleoperate::Arguments),
    /// Find the stiffest wall that a device can render, by trials
    #[command(long_about = command::zwidth::LONG_ABOUT, after_help = command::zwidth::EXAMPLES)]
    Zwidth(WithFiles<keys::ZWidth>),
    /// Measure whether this machine is fit for a loop at 1, 4 and 10 kHz
    #[command(long_about = command::rt_check::LONG_ABOUT)]
    RtCheck(command::rt_check::Arguments),
    /// Compute the figures of the dissertation again and judge its claims
    Reproduce(command::reproduce::Arguments),
    /// Print the impulse response of an operator
    Weights(command::operator::Weights),
    /// Differentiate or integrate a CSV column to a fractional order
    Differintegrate(command::operator::Differintegrate),
    /// Write an operator or a controller as a C99 header, for any microcontroller
    ExportC(command::export_c::Arguments),
    /// Find, inspect, configure, measure, test, emulate and monitor a device
    #[command(subcommand)]
    Device(command::device::Command),
    /// List, show and export tissues
    #[command(subcommand)]
    Materials(command::materials::Command),
    /// Turn a measured record into a tissue: relaxation, creep, oscillation or any motion
    #[command(long_about = command::identify::LONG_ABOUT)]
    Identify(command::identify::Arguments),
    /// Inspect, check, recover, export and draw a log
    #[command(subcommand)]
    Log(command::log::Command),
    /// Serve a page in the browser: feel a tissue, see what is stable, watch and start runs
    #[cfg(feature = "serve")]
    #[command(long_about = command::serve::LONG_ABOUT)]
    Serve(command::serve::Arguments),
    /// Print a completion script for a shell
    Completions(command::shell::Completions),
    /// Write the manual pages
    Man(command::shell::Man),
}

impl Command {
    fn run(self, output: Output) -> Result<(), Failure> {
        match self {
            Self::Relax(experiment) => experiment.run("relax", output),
            Self::Creep(experiment) => experiment.run("creep", output),
            Self::Analyze(command) => command.run(output),
            Self::Control(command) => command.run(output),
            Self::Design(asked) => command::design::run(asked, output),
            Self::Run(arguments) => arguments.run(output),
            Self::Teleoperate(arguments) => arguments.run(output),
            Self::Zwidth(asked) => command::zwidth::run(asked, output),
            Self::RtCheck(arguments) => arguments.run(output),
            Self::Reproduce(arguments) => arguments.run(output),
            Self::Weights(arguments) => arguments.run(output),
            Self::Differintegrate(arguments) => arguments.run(output),
            Self::ExportC(arguments) => arguments.run(output),
            Self::Device(command) => command.run(output),
            Self::Materials(command) => command.run(output),
            Self::Identify(arguments) => arguments.run(output),
            Self::Log(command) => command.run(output),
            #[cfg(feature = "serve")]
            Self::Serve(arguments) => arguments.run(output),
            Self::Completions(arguments) => arguments.run(parser(), output),
            Self::Man(arguments) => arguments.run(parser(), output),
        }
    }
}

/// The parser. Values other than names and paths may begin with a minus.
#[must_use]
pub fn parser() -> clap::Command {
    fn with_values(command: clap::Command) -> clap::Command {
        let below: Vec<String> = (command.get_subcommands())
            .map(|below| below.get_name().to_owned())
            .collect();
        let command = command.mut_args(|argument| {
            let takes = argument.get_long().is_some() && argument.get_action().takes_values();
            let kind = argument.get_value_parser().type_id();
            let is_text = kind == TypeId::of::<String>() || kind == TypeId::of::<PathBuf>();
            match takes && !is_text {
                true => argument.allow_hyphen_values(true),
                false => argument,
            }
        });
        below.into_iter().fold(command, |command, name| {
            command.mut_subcommand(name, with_values)
        })
    }
    with_values(Cli::command())
}

/// The parser's message in one line, as all our errors are, without its pointer to `--help`.
fn one_line(message: &str) -> String {
    let lines = message.lines().map(str::trim);
    // What is not an option is not KEY=VALUE either.
    let useless = ["For more information", "tip: to pass"];
    let lines: Vec<&str> = lines
        .filter(|line| !line.is_empty() && !useless.iter().any(|start| line.starts_with(start)))
        .collect();
    let joined = lines.join("; ").replace(":; ", ": ");
    joined.strip_prefix("error: ").unwrap_or(&joined).to_owned()
}

fn asked() -> clap::Command {
    let mut command = parser();
    command.build();
    // A file may have any name; `help` is followed by the command.
    for word in std::env::args_os().skip(1).filter(|word| word != "help") {
        if let Some(found) = command.find_subcommand(&word) {
            command = found.clone();
        }
    }
    command
}

/// Prints all that a command says of itself, an option a line, as `-h` does.
fn print_long_help() -> std::io::Result<()> {
    let command = asked();
    let about = command.get_long_about().or(command.get_about()).cloned();
    let command = command.mut_args(|argument| argument.hide_short_help(false));
    command.about(about.unwrap_or_default()).print_help()
}

/// What to write in place of an option that is a key without one.
fn not_an_option(error: &clap::Error) -> Option<String> {
    let argument = error.get(ContextKind::InvalidArg)?.to_string();
    if error.kind() != ErrorKind::UnknownArgument {
        return None;
    }
    let (wanted, command) = (argument.trim_start_matches('-'), asked());
    if let Some(now) = renamed(wanted).map(options::option_of)
        && command
            .get_arguments()
            .any(|known| known.get_long() == Some(&now))
    {
        return Some(format!("{argument} is now called --{now}"));
    }
    let of_device = match command.get_name() {
        "set" => changes::key_like(wanted),
        "emulate" => emulate::key_like(wanted),
        _ => None,
    };
    let instead = match of_device {
        Some(key) => format!("{key}=VALUE"),
        None => options::instead_of(&argument, command.get_name())?,
    };
    Some(format!(
        "{argument} is not an option of this command: write {instead}"
    ))
}

/// Says why the words were not understood, or the help that they ask for.
fn not_understood(error: &clap::Error) -> ExitCode {
    // Help and version go to standard output and are success, all else is bad usage.
    if error.use_stderr() {
        match error.kind() {
            ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => {
                let _ = error.print();
            }
            _ => note(
                "error",
                not_an_option(error).unwrap_or_else(|| one_line(&error.to_string())),
            ),
        }
        return ExitCode::from(2);
    }
    let is_long = !std::env::args_os().any(|word| word == "-h");
    let printed = match error.kind() {
        ErrorKind::DisplayHelp if is_long => print_long_help(),
        _ => error.print(),
    };
    match printed {
        Err(lost) if lost.kind() != std::io::ErrorKind::BrokenPipe => {
            ended(Err(Failure::writing(lost, "cannot write standard output")))
        }
        _ => ExitCode::SUCCESS,
    }
}

/// The exit code of a command, whose failure is said.
fn ended(result: Result<(), Failure>) -> ExitCode {
    let Err(failure) = result else {
        return ExitCode::SUCCESS;
    };
    if !matches!(failure, Failure::BrokenPipe) {
        refused(&failure);
    }
    ExitCode::from(failure.exit_code())
}

/// The program.
#[must_use]
pub fn main() -> ExitCode {
    options::name_options(asked);
    // A file that may not grow is told by the write that fails, as a full disk is.
    #[cfg(unix)]
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, std::sync::Arc::default());
    let matches = parser().try_get_matches();
    match matches.and_then(|matches| Cli::from_arg_matches(&matches)) {
        Ok(Cli {
            json,
            quiet,
            command,
        }) => ended(command.run(Output { json, quiet })),
        Err(error) => not_understood(&error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_well_formed() {
        parser().debug_assert();
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
        check(&parser(), "");
    }
}
