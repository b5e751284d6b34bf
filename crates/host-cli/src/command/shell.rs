//! `completions` and `man`, for the shell, and `licenses`.

use crate::output::Output;
use clap::Args;
use haptic_experiment::Failure;
use haptic_log::record::NewFile;
use serde_json::json;
use std::path::PathBuf;

/// Texts of the licences of all that is inside; `packaging/build` names the file.
#[cfg(packaged)]
const LICENSES: &str = include_str!(env!("HOST_CLI_LICENSES"));
/// Our own, where nobody has collected the others.
#[cfg(not(packaged))]
const LICENSES: &str = concat!(
    "host-cli is licensed under MIT or Apache-2.0, at your choice.\n\n",
    include_str!("../../LICENSE-MIT"),
    "\nThis program was built from sources and carries no texts of the packages inside it; released programs do. \
     `cargo tree -p host-cli --edges normal --prefix none --format \"{p} {l}\"` lists them in the repository.\n",
);

/// Arguments of `completions`.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: host-cli completions bash > ~/.local/share/bash-completion/completions/host-cli"
)]
pub(crate) struct Completions {
    /// Shell that will read the script
    shell: clap_complete::Shell,
}

/// Arguments of `man`.
#[derive(Debug, Args)]
#[command(after_help = "Example: host-cli man man1 && man -l man1/host-cli-relax.1")]
pub(crate) struct Man {
    /// Folder for the pages, created if missing
    directory: PathBuf,
    /// Replace existing pages
    #[arg(long)]
    overwrite: bool,
}

impl Completions {
    /// Runs the command, for the command line as a whole.
    pub(crate) fn run(self, mut whole: clap::Command, output: Output) -> Result<(), Failure> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut whole, "host-cli", &mut script);
        let script = String::from_utf8_lossy(&script);
        let report = json!({"shell": self.shell.to_string(), "script": script});
        output.text(&report, |out| out.write_all(script.as_bytes()))
    }
}

/// Prints the licences of what is inside the program.
pub(crate) fn licenses(output: Output) -> Result<(), Failure> {
    output.text(&json!({"licenses": LICENSES}), |out| {
        out.write_all(LICENSES.as_bytes())
    })
}

impl Man {
    /// Runs the command, for the command line as a whole.
    pub(crate) fn run(self, whole: clap::Command, output: Output) -> Result<(), Failure> {
        let folder = self.directory.display();
        std::fs::create_dir_all(&self.directory)
            .map_err(|error| Failure::writing(error, format_args!("cannot make `{folder}`")))?;
        let mut whole = whole.disable_help_subcommand(true);
        whole.build();
        // All of them, or none.
        let mut files = Vec::new();
        self.fill(&whole, &mut files)?;
        let mut pages = Vec::new();
        for file in files {
            pages.push(file.target().display().to_string());
            file.publish()?;
        }
        pages.sort();
        let shown = if output.quiet { &[][..] } else { &pages };
        output.text(&json!({"pages": pages}), |out| {
            shown.iter().try_for_each(|page| writeln!(out, "{page}"))
        })
    }

    /// Writes the pages of a command and those below it, without giving them their names.
    fn fill(&self, command: &clap::Command, files: &mut Vec<NewFile>) -> Result<(), Failure> {
        for below in command.get_subcommands().filter(|one| !one.is_hide_set()) {
            self.fill(below, files)?;
        }
        let page = clap_mangen::Man::new(command.clone());
        let mut text = Vec::new();
        (page.render(&mut text)).map_err(|error| Failure::writing(error, "cannot make a page"))?;
        let path = self.directory.join(page.get_filename());
        files.push(NewFile::filled(&path, &text, self.overwrite)?);
        Ok(())
    }
}
