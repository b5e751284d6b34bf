//! The command line: what may be typed, what it means, and how it ends.

use crate::command;
use crate::command::device::{changes, emulate};
use crate::command::run::Experiment;
use crate::command::run_each;
use crate::names::{Names, option_of};
use crate::options::{self, WithFiles, keys};
use crate::output::{Output, note, refused};
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{CommandFactory as _, FromArgMatches as _, Parser, Subcommand};
use haptic_experiment::Failure;
use haptic_quantity::{is_bare, is_unit, nearest};
use haptic_run::DeviceName;
use std::any::TypeId;
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::str::FromStr as _;

const LONG_ABOUT: &str = "\
Runs fractional-order haptic experiments, keeps their logs and draws their figures.

Values are SI unless a unit is given: --strain 5%, --duration 200s, --sample-time 1ms. A number
that no device has in SI, such as --mass 65, needs its unit.

SCHEME names the fractional operator D^mu:
{schemes}
DEVICE is what an experiment runs on:
  sim                           simulated in this program (default)
  serial:PATH[@BAUD]            a device at a serial port, or an emulated one
  serial:auto                   the only serial device that answers
  serial:usb:NUMBER             the port whose USB device has this serial number
  tcp:HOST:PORT                 a device that listens there, as an emulated one
  haply:PATH[,version=2]        a Haply 2DIY
  moteus:PATH[,id=1,radius=20mm] a moteus servo
  inverse3:[HOST[:PORT]][,id=ID] a Haply Inverse3
Each has its page in the guide: {guide}

Exit codes: 0 done; 1 the run failed, was interrupted or a fault ended it; 2 bad usage or bad
input; 3 device or link not usable, or lost; 4 data was lost, the rest was kept. If several apply, 3
takes precedence over 1, and 1 over 4.";

/// The guide, where the package says that the project is: a program may have come without its files.
const GUIDE: &str = concat!(env!("CARGO_PKG_REPOSITORY"), "/tree/HEAD/docs/guide/src");

/// Fractional-order haptics: experiments, logs, figures.
#[derive(Debug, Parser)]
#[command(
    name = "host-cli",
    version,
    about,
    long_about = LONG_ABOUT.replace("{schemes}", fracdiff::Scheme::help()).replace("{guide}", GUIDE),
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
    #[command(subcommand)]
    command: Command,
}

/// A command. Its help, here or at its arguments, begins with the line that the list of commands shows.
#[derive(Debug, Subcommand)]
enum Command {
    /// Stress relaxation: indent a virtual tissue, hold, record the force
    ///
    /// Draws the force beside its closed form. Reaction forces are positive, but negative in the log.
    #[command(after_help = command::run::RELAX_EXAMPLES)]
    Relax(Experiment<keys::Relax>),
    /// Creep: push a virtual tissue with a constant force, record the strain
    ///
    /// Draws the strain beside its closed form (a Mittag-Leffler function, or a power law without
    /// elastic modulus), and writes creep.mcap, creep.csv, creep.svg and creep.png. Nothing has a mass, unless --contact
    /// or a device gives it one: then the report says from which time on the curve shows the tissue and not the rig.
    #[command(
        after_help = "Example: host-cli creep --tissue prostate-healthy --stress 50Pa --duration 60s"
    )]
    Creep(Experiment<keys::Creep>),
    /// Measure a real specimen: the device's own position loop presses it and records the force
    ///
    /// The force is that of the device's sensor, or the motor's less friction, inertia and damping of its device file.
    /// The position loop is made from the device's mass and damping, unless --controller gives one.
    /// `host-cli identify press.mcap` turns the log into a tissue, with the loading that the log states. On the simulated device
    /// --tissue names the specimen.
    #[command(
        after_help = "Example: host-cli press --tissue prostate-healthy --depth 2mm --hold-time 10s --out p"
    )]
    Press(Experiment<keys::Press>),
    /// Judge stability, passivity and transparency, before any hardware
    #[command(subcommand)]
    Analyze(command::analyze::Command),
    /// Fractional controllers: design, simulate, analyze, and identify a plant
    #[command(subcommand)]
    Control(command::control::Command),
    /// Find the stiffest wall, the most damping or the closest tissue for a device
    ///
    /// For each order the analysis finds stiffness K and dissipation B, with the device's delay and
    /// current lag. The best wall is then tried on the simulated device, with friction and encoder too.
    ///
    /// Wishes:
    ///   stiffest-wall   the largest K
    ///   most-damping    the largest effective damping at --frequency
    ///   tissue          does a specimen of --tissue fit, and how much larger may it be? If it does not,
    ///                   which order comes closest at --frequency?
    ///   coupler         the virtual coupler damper + spring (T/(1-w))^mu that feels stiffest at
    ///                   --frequency, meets Llewellyn's criterion and has a gain margin of 2 in the
    ///                   sampled loop; w is a delay of one sample. --require passive asks for passivity
    ///                   with every hand and object instead
    ///
    /// The device is ideal unless a device file, friction, delay, `current_lag`, `encoder_resolution` or
    /// `sensor_noise` is given; the report then also shows the best wall on the laboratory device.
    /// --force-noise-limit bounds the force noise that encoder and sensor cause.
    ///
    /// The wall pulls as well as pushes, as the analysis assumes. --one-sided takes the best wall that never
    /// pulls and settles after each of six hits, up to 1 m/s; --contact signed takes one whose proof
    /// covers it.
    ///
    /// --out writes design.toml for `host-cli run`, design.csv and a picture. The exit code is 1 if no
    /// candidate is found, or if the best does not come to rest or is too noisy in its trial.
    #[command(verbatim_doc_comment, after_help = command::design::EXAMPLES)]
    Design(command::design::Arguments),
    Run(command::run::Arguments),
    Teleoperate(command::teleoperate::Arguments),
    /// Find the stiffest wall that a device can render, by trials
    ///
    /// Finds the Z-width: for each order and dissipation the stiffest wall at which a device comes
    /// to rest. In each trial a simulated device hits the wall at 0.1 m/s and is then pushed into
    /// it; a serial device is only pushed. With --one-sided it is hit at six speeds, 0 to 1 m/s,
    /// and must come to rest after each. The default device has 65 g and 3.5 N.s/m;
    /// --device-model laboratory adds friction, delay, lag and encoder steps.
    ///
    /// At rest means: over the last 0.4 s of 5 s the standard deviation of the position is at most
    /// 2 encoder steps or 1 % of push/K, whichever is larger, and that of the force at most 5 % of
    /// the push or, if larger, the force that one encoder step causes (but at most 25 % of the
    /// push). The largest and the smallest force differ by at most the push. A wall whose force is
    /// at its limit for more than 50 ms is not stable, nor is one at which only
    /// friction keeps the device at rest.
    ///
    /// criterion=dissertation judges only the position: pushed from rest, its standard deviation
    /// is at most threshold=0.1mm.
    ///
    /// Each point also shows the largest stiffness by the analysis. Ctrl-C keeps the points found
    /// so far.
    #[command(after_help = command::zwidth::EXAMPLES)]
    Zwidth(WithFiles<keys::ZWidth>),
    RtCheck(command::rt_check::Arguments),
    Reproduce(command::reproduce::Arguments),
    Weights(command::operator::Weights),
    Differintegrate(command::operator::Differintegrate),
    ExportC(command::export_c::Arguments),
    /// Find, inspect, configure, measure, test, emulate and monitor a device
    #[command(subcommand)]
    Device(command::device::Command),
    /// List, show and export tissues
    #[command(subcommand)]
    Materials(command::materials::Command),
    Identify(command::identify::Arguments),
    /// Inspect, check, recover, export and draw a log
    #[command(subcommand)]
    Log(command::log::Command),
    #[cfg(feature = "serve")]
    Serve(command::serve::Arguments),
    /// Print a completion script for a shell
    Completions(command::shell::Completions),
    /// Write the manual pages to a folder
    Man(command::shell::Man),
    /// Print the licences of what is inside this program
    #[command(after_help = "Example: host-cli licenses > LICENSES.txt")]
    Licenses,
}

impl Command {
    fn run(self, output: Output) -> Result<(), Failure> {
        run_each!(self, output,
            [Analyze Control Run Teleoperate RtCheck Reproduce Weights Differintegrate ExportC Device Materials Identify Log]
            Self::Relax(experiment) => experiment.run("relax", output),
            Self::Creep(experiment) => experiment.run("creep", output),
            Self::Press(experiment) => experiment.run("press", output),
            Self::Design(asked) => command::design::run(asked, output),
            Self::Zwidth(asked) => command::zwidth::run(asked, output),
            #[cfg(feature = "serve")]
            Self::Serve(arguments) => arguments.run(output),
            Self::Completions(arguments) => arguments.run(parser(), output),
            Self::Man(arguments) => arguments.run(parser(), output),
            Self::Licenses => command::shell::licenses(output),
        )
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
            if takes && !is_text {
                argument.allow_hyphen_values(true)
            } else {
                argument
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
    // An unknown option is not KEY=VALUE either; the parser's guesses may be far off, so `meant` makes them.
    let useless = ["For more information", "tip: "];
    let lines: Vec<&str> = lines
        .filter(|line| !line.is_empty() && !useless.iter().any(|start| line.starts_with(start)))
        .collect();
    let joined = lines.join("; ").replace(":; ", ": ");
    joined.strip_prefix("error: ").unwrap_or(&joined).to_owned()
}

/// The command that was typed, and the other words.
fn asked() -> (clap::Command, BTreeSet<OsString>) {
    let mut command = parser();
    command.build();
    let mut others = BTreeSet::new();
    // A file may have any name; `help` is followed by the command.
    for word in std::env::args_os().skip(1).filter(|word| word != "help") {
        if let Some(found) = command.find_subcommand(&word) {
            command = found.clone();
        } else {
            others.insert(word);
        }
    }
    (command, others)
}

fn options_of_asked() -> BTreeSet<String> {
    let (command, others) = asked();
    // A file or a column may have the name of a key: typed words are printed as typed.
    let typed: BTreeSet<String> = others
        .iter()
        .filter_map(|word| word.to_str())
        .map(option_of)
        .collect();
    let options = command.get_arguments().filter_map(clap::Arg::get_long);
    // A person names the columns of a record.
    options
        .filter(|option| !["input", "output"].contains(option) && !typed.contains(*option))
        .map(str::to_owned)
        .collect()
}

/// Prints all that a command says of itself, an option a line, as `-h` does.
fn print_long_help() -> std::io::Result<()> {
    let (command, _) = asked();
    let about = command.get_long_about().or(command.get_about()).cloned();
    let after = command.get_after_long_help().or(command.get_after_help());
    let after = after.cloned().unwrap_or_default();
    let command = command.mut_args(|argument| argument.hide_short_help(false));
    let command = command.about(about.unwrap_or_default());
    command.after_help(after).print_help()
}

/// Suggestion for an unknown option, command or name: an existing one, or a key.
fn meant(error: &clap::Error) -> Option<String> {
    if error.kind() == ErrorKind::MissingRequiredArgument {
        return example();
    }
    if let Some(ContextValue::Strings(names)) = error.get(ContextKind::ValidValue) {
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let typed = error.get(ContextKind::InvalidValue)?.to_string();
        return Some(format!("did you mean `{}`?", nearest(&typed, &names)?));
    }
    let kind = if error.kind() == ErrorKind::UnknownArgument {
        ContextKind::InvalidArg
    } else {
        ContextKind::InvalidSubcommand
    };
    let typed = error.get(kind)?.to_string();
    if let Err(error) = DeviceName::from_str(&typed)
        && error.contains("is a port")
    {
        return Some(error);
    }
    let (command, words) = asked();
    // Of -tissue the parser reads -t alone.
    let mut words = words.iter().filter_map(|word| word.to_str());
    let is_whole = |word: &&str| !word.starts_with("--") && word.starts_with(&typed);
    let wanted = words.find(is_whole).unwrap_or(&typed);
    let options = command.get_arguments().filter_map(clap::Arg::get_long);
    let options: Vec<String> = options.map(|option| format!("--{option}")).collect();
    let keys = match command.get_name() {
        "set" => changes::names(),
        "emulate" => emulate::names(),
        name => options::names(name),
    };
    let name = clap::Command::get_name;
    let below = command
        .get_subcommands()
        .map(|below| name(below).to_owned());
    // `stability` is below `analyze`.
    let deeper = command.get_subcommands().flat_map(|below| {
        let deeper = below.get_subcommands().map(name);
        deeper.map(move |deeper| format!("{} {deeper}", name(below)))
    });
    let below = below.chain(deeper);
    let keys = keys.into_iter().map(|key| format!("{key}=VALUE"));
    let known: Vec<String> = options.into_iter().chain(below).chain(keys).collect();
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    let said = match (command.get_name(), wanted) {
        ("emulate", "--port" | "--device") => "give its place with --link, or --listen for TCP",
        ("serve", "--device") => "the page runs simulated devices: omit it, or `run` a file",
        ("reproduce", _) if nearest(wanted, &known).is_none() => {
            "all figures are made, 3.3 to 7.2: omit it"
        }
        _ => "",
    };
    match nearest(wanted, &known) {
        _ if !said.is_empty() => Some(said.to_owned()),
        Some(name) => Some(format!("did you mean `{name}`?")),
        None if command.get_name() == "emulate" => emulate::of_device(wanted),
        None => None,
    }
    .or_else(|| {
        Some(format!(
            "`{} --help` lists what it takes",
            path_of(&command)
        ))
    })
}

/// A command with those that it is below, as it is typed: `host-cli log plot`.
fn path_of(command: &clap::Command) -> &str {
    command.get_bin_name().unwrap_or("host-cli")
}

/// The first example of the command that was typed, for somebody who gave no file or name.
fn example() -> Option<String> {
    let help = asked().0.get_after_help()?.to_string();
    let (_, example) = help.split_once("host-cli ")?;
    Some(format!(
        "write one, as in `host-cli {}`",
        example.lines().next()?
    ))
}

/// Advice for a word that other shells read themselves: `#`, `'quoted'`, `\` at the end of a line.
fn handed_on(words: &[String]) -> Option<String> {
    let quotes = ['\'', '‘', '’', '“', '”', '„'];
    words.iter().find_map(|word| match word.as_str() {
        "#" => Some("this shell hands `#` on: leave it out, and the comment behind it".to_owned()),
        "\\" => Some("this shell hands `\\` on: write the command in one line".to_owned()),
        word if word.starts_with(quotes) => Some(format!(
            "this shell hands the quotes of {word} on: write \"{}\"",
            word.trim_matches(quotes)
        )),
        _ => None,
    })
}

/// The path of a file that blanks have torn apart.
fn torn_path(words: &[String]) -> Option<String> {
    let starts = 1..words.len();
    let all = starts.flat_map(|start| (start + 2..=words.len()).map(move |end| start..end));
    let mut paths = all.filter_map(|some| Some(words.get(some)?.join(" ")));
    paths.find(|path| Path::new(path).is_file())
}

/// Advice for words that a blank has torn apart: `60 s`, `mass = 65g`, `0.5 1` behind an option; and for those that no shell has read.
fn torn() -> Option<String> {
    let words: Vec<String> = std::env::args_os()
        .map(|word| word.to_string_lossy().into_owned())
        .collect();
    if let Some(path) = torn_path(&words) {
        return Some(format!("write \"{path}\", with the quotes"));
    }
    handed_on(&words).or_else(|| {
        words.windows(3).find_map(|words| {
            let [before, word, next] = words else {
                return None;
            };
            let number = word
                .rsplit_once('=')
                .map_or(word.as_str(), |(_, text)| text);
            let is_option = before.starts_with("--") && !before.contains('=');
            let written = if word == "=" {
                format!("{before}={next}")
            } else if is_bare(number) && is_unit(next) {
                format!("{word}{next}")
            } else if is_option && is_bare(word) && is_bare(next) {
                return Some(format!("write {word},{next}, if both are of {before}"));
            } else {
                return None;
            };
            Some(format!("write {written}, without a blank"))
        })
    })
}

/// Says why the words were not understood, or the help that they ask for.
fn not_understood(error: &clap::Error, names: &Names) -> ExitCode {
    // Help and version go to standard output and are success, all else is bad usage.
    if error.use_stderr() {
        if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
            let _ = error.print();
        } else {
            let message = one_line(&error.to_string());
            let message = match (torn(), meant(error)) {
                (Some(torn), _) => torn,
                (None, Some(meant)) => {
                    let message = message.split("; Usage").next().unwrap_or(&message);
                    format!("{message}; {meant}")
                }
                (None, None) => message,
            };
            note("error", format_args!("{message}"));
        }
        return ExitCode::from(2);
    }
    let is_long = !std::env::args_os().any(|word| word == "-h");
    let printed = if is_long && error.kind() == ErrorKind::DisplayHelp {
        print_long_help()
    } else {
        error.print()
    };
    match printed {
        Err(lost) if lost.kind() != std::io::ErrorKind::BrokenPipe => {
            let lost = Failure::writing(lost, "cannot write standard output");
            ended(Err(lost), names)
        }
        _ => ExitCode::SUCCESS,
    }
}

/// Prints the failure of a command, and returns its exit code: scripts rely on it, see [`LONG_ABOUT`].
fn ended(result: Result<(), Failure>, names: &Names) -> ExitCode {
    let Err(mut failure) = result else {
        return ExitCode::SUCCESS;
    };
    if let (Failure::Input(_), Some(meant)) = (&failure, torn()) {
        failure = Failure::bad_input(format_args!("{meant}"));
    }
    refused(&failure, names);
    ExitCode::from(match failure {
        Failure::Run(_) => 1,
        Failure::Input(_) => 2,
        Failure::Device(_) => 3,
        Failure::DataLost(_) => 4,
    })
}

/// Parses the command line, runs the command, and returns its exit code.
#[must_use]
pub fn main() -> ExitCode {
    // Threads that end after this function may still report something.
    let names: &'static Names = Box::leak(Box::new(Names::of(options_of_asked)));
    // A file at its size limit is reported by the write that fails, as a full disk is.
    #[cfg(unix)]
    let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, std::sync::Arc::default());
    let matches = parser().try_get_matches();
    match matches.and_then(|matches| Cli::from_arg_matches(&matches)) {
        Ok(Cli {
            json,
            quiet,
            command,
        }) => {
            let output = Output { json, quiet, names };
            ended(command.run(output), names)
        }
        Err(error) => not_understood(&error, names),
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
