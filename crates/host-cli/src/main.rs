//! `host-cli`: parse, run, map the error to an exit code.

use clap::Parser as _;
use host_cli::cli::Cli;
use host_cli::failure::Failure;
use host_cli::output::note;
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version go to standard output and are success, all else is bad usage.
            let bad = error.use_stderr();
            let _ = error.print();
            return ExitCode::from(if bad { 2 } else { 0 });
        }
    };
    match cli.run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            if !matches!(failure, Failure::BrokenPipe) {
                note("error", &failure);
            }
            ExitCode::from(failure.exit_code())
        }
    }
}
