//! `device get` and `device set`.

use super::changes::{self, Changes};
use super::loosened::loosened;
use super::parameters::Parameters;
use super::port::PortArguments;
use crate::output::{Output, note};
use clap::Args;
use haptic_experiment::Failure;
use haptic_experiment::run::device::{at_port, refused_at_port};

/// Arguments of `device get`.
#[derive(Debug, Args)]
#[command(after_help = "Example: host-cli device get --device serial:/dev/ttyACM0 --json")]
pub struct GetArguments {
    #[command(flatten)]
    port: PortArguments,
}

/// Arguments of `device set`.
#[derive(Debug, Args)]
#[command(after_help = format!(
    "Example: host-cli device set --device serial:/dev/ttyACM0 force_limit=0.5N workspace=-10mm:20mm\n\nKeys:{}",
    changes::help()
))]
pub struct SetArguments {
    #[command(flatten)]
    port: PortArguments,
    /// Parameters, with a unit or in SI units, as in `force_limit=0.5N`
    #[arg(value_name = "KEY=VALUE", required = true)]
    values: Vec<String>,
}

impl GetArguments {
    /// Runs the command.
    ///
    /// # Errors
    /// Exit code 3: no port, no device, no answer.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let link = self.port.connect_any()?;
        let configuration = link.configuration();
        let (configuration, values) =
            configuration.map_err(|error| at_port(link.path(), &error))?;
        output.report(&Parameters::new(link.name(), &configuration, &values))
    }
}

impl SetArguments {
    /// Runs the command: reads what is set, changes what was given, sets it, and reads it back.
    ///
    /// # Errors
    /// A parameter beyond the device's limits; exit code 3: no port, no device, no answer.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let changes = Changes::read(&self.values)?;
        let mut link = self.port.connect_any()?;
        let path = link.path().to_owned();
        let problem = |error| at_port(&path, &error);
        let (mut configuration, mut values) = link.configuration().map_err(problem)?;
        let before = configuration.limits;
        changes.apply(&mut configuration, &mut values)?;
        let set = link.set(configuration, &values);
        set.map_err(|error| refused_at_port(&path, error))?;
        let (configuration, values) = link.configuration().map_err(problem)?;
        for limit in loosened(&before, &configuration.limits) {
            note("warning", format_args!("loosened: {limit}"));
        }
        output.summary(&Parameters::new(link.name(), &configuration, &values))
    }
}
