//! `host-cli`: parse, run, map the error to an exit code.

use clap::error::{ContextKind, ErrorKind};
use clap::{Command, CommandFactory as _, Parser as _};
use haptic_experiment::Failure;
use host_cli::cli::Cli;
use host_cli::options;
use host_cli::output::{note, refused};
use std::process::ExitCode;

/// The parser's message in one line, as all our errors are, without its pointer to `--help`.
fn one_line(message: &str) -> String {
    let lines = message.lines().map(str::trim);
    let lines: Vec<&str> = lines
        .filter(|line| !line.is_empty() && !line.starts_with("For more information"))
        // What is no option is no KEY=VALUE either.
        .filter(|line| !line.starts_with("tip: to pass"))
        .collect();
    let joined = lines.join("; ").replace(":; ", ": ");
    joined.strip_prefix("error: ").unwrap_or(&joined).to_owned()
}

/// The command that was asked for.
fn asked() -> Command {
    let mut command = Cli::command();
    command.build();
    for word in std::env::args_os().skip(1) {
        // A file may have any name; `help` is followed by the command.
        if word == "help" {
            continue;
        }
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
    let instead = options::instead_of(&argument, asked().get_name())?;
    Some(format!(
        "{argument} is not an option of this command: write {instead}"
    ))
}

fn main() -> ExitCode {
    options::name_options(asked);
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version go to standard output and are success, all else is bad usage.
            if !error.use_stderr() {
                let is_long = !std::env::args_os().any(|word| word == "-h");
                let printed = match error.kind() {
                    ErrorKind::DisplayHelp if is_long => print_long_help(),
                    _ => error.print(),
                };
                return match printed {
                    Err(lost) if lost.kind() != std::io::ErrorKind::BrokenPipe => {
                        let failure = Failure::writing(lost, "cannot write standard output");
                        note("error", &failure);
                        ExitCode::from(failure.exit_code())
                    }
                    _ => ExitCode::SUCCESS,
                };
            }
            if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
                let _ = error.print();
                return ExitCode::from(2);
            }
            note(
                "error",
                not_an_option(&error).unwrap_or_else(|| one_line(&error.to_string())),
            );
            return ExitCode::from(2);
        }
    };
    match cli.run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            if !matches!(failure, Failure::BrokenPipe) {
                refused(&failure);
            }
            ExitCode::from(failure.exit_code())
        }
    }
}
