//! `completions` and `man`: for the shell.

use crate::output::Output;
use clap::{Args, Command};
use haptic_experiment::failure::Failure;
use serde::Serialize;
use std::path::PathBuf;

/// Arguments of `completions`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli completions bash > ~/.local/share/bash-completion/completions/host-cli"
)]
pub struct Completions {
    /// The shell
    shell: clap_complete::Shell,
}

/// Arguments of `man`.
#[derive(Debug, Args)]
#[command(after_help = "Example: host-cli man man1 && man -l man1/host-cli-relax.1")]
pub struct Man {
    /// Folder for the pages, made if it is not there
    directory: PathBuf,
}

/// A script as JSON.
#[derive(Serialize)]
struct Script {
    shell: String,
    script: String,
}

/// Files as JSON.
#[derive(Serialize)]
struct Pages {
    pages: Vec<String>,
}

impl Completions {
    /// Runs the command.
    ///
    /// # Errors
    /// If standard output cannot be written.
    pub fn run(self, mut command: Command, output: Output) -> Result<(), Failure> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut command, "host-cli", &mut script);
        let script = Script {
            shell: self.shell.to_string(),
            script: String::from_utf8_lossy(&script).into_owned(),
        };
        output.print(&script, |out| out.write_all(script.script.as_bytes()))
    }
}

impl Man {
    /// Runs the command.
    ///
    /// # Errors
    /// If the folder cannot be written.
    pub fn run(self, command: Command, output: Output) -> Result<(), Failure> {
        let fail = |error: std::io::Error| {
            let folder = self.directory.display();
            let what = format_args!("cannot write manual pages into `{folder}`");
            Failure::writing(error, what)
        };
        std::fs::create_dir_all(&self.directory).map_err(fail)?;
        clap_mangen::generate_to(command, &self.directory).map_err(fail)?;
        let mut pages = Vec::new();
        for entry in std::fs::read_dir(&self.directory).map_err(fail)? {
            let path = entry.map_err(fail)?.path();
            if path.extension().is_some_and(|extension| extension == "1") {
                pages.push(path.display().to_string());
            }
        }
        pages.sort();
        let pages = Pages { pages };
        output.summary(&pages, |out| {
            pages
                .pages
                .iter()
                .try_for_each(|page| writeln!(out, "{page}"))
        })
    }
}
