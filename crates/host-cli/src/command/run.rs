//! `run`: any experiment, from a file.

use super::experiment::RunArguments;
use crate::keys;
use crate::options::Options;
use crate::output::Output;
use clap::Args;
use haptic_experiment::Failure;
use haptic_experiment::document::Document;
use haptic_experiment::parameters::{
    BENCH, COUPLER, COUPLER_REQUIRED, CREEP, DESIGN, DRIVE, MEASURE, ON_DEVICE, Parameter, RELAX,
    RENDERING, SAFETY, TELEOPERATION, TOUCH, Value, WALL, WALL_REQUIRED, ZWIDTH,
};
use std::fmt::Write as _;
use std::path::PathBuf;

const LONG_ABOUT: &str = "\
Runs the experiment that a TOML file describes. The file has one table: [relax], [creep], [wall], [coupler], \
[teleoperation] or [touch]; [drive] beside [relax] or [creep] names a controller file, whose controller holds the indenter. \
Keys have their SI unit in the name, as in duration_s = 200. Paths in the file start from its folder. Options of the command win \
over keys of the file.

A wall: the device hits it at impact_m_per_s, is pushed into it with a constant force, and is stable if it comes to rest: see \
`host-cli zwidth --help` for the rule. A serial device cannot be thrown. verdict in the summary is stable, held-by-friction (it would not settle without friction), \
unstable, saturated, gone or unfinished; analysis_agrees compares it with the pre-flight. With \
must_be_stable = true the exit code is 1 unless both call the wall stable. On a serial device rate limit, speed limit and rise time \
that are not given stay as they are set there. `host-cli design` writes such a file.

A coupler: the same trial, but between the device and a simulated object (mass, damper, spring to the ground) is a fractional \
virtual coupler damper + spring (T/(1-w))^mu of order 0 to 1, velocity in, force out. At order 1 device and object come to rest where the springs balance the push; below 1 \
the coupler creeps, and the force alone is judged. Before the run the loop that is really sampled must be stable with this device, hand and \
object, and Llewellyn's criterion must be met; on the simulated device a refusal is a warning, a serial one does not start without \
--force-unstable. Llewellyn alone is not enough: his device acts half a sample earlier than a real one, which needs at least four times the \
damping for any hand and object. The CSV has the object's place too. A coupler needs --loop host on a serial device.

A teleoperation: a hand moves a master, and over a line with delay, jitter, loss and duplication a slave moves in a remote tissue or wall; \
devices and line are simulated. A remote place that is unstable for the slave alone is refused without --force-unstable. architecture says how the two are joined; wave and time-domain give no energy at any delay. The summary says what \
the line took or gave, which messages were lost or refused, and frequency by frequency what the hand felt of what the slave touched, beside the \
formula (time-domain has none). verdict is passive, gave-energy, held-forces-gave-energy, saturated, silent or unfinished; with must_be_passive = true the exit code is 1 unless it is passive. \
`host-cli analyze teleoperation` finds the coupler for a delay, `host-cli teleoperate` runs both sides over UDP.

A touch: a hand moves a device of two or three axes over a plane or a ball (a disc, a sphere) of tissue, simulated. The force is along the normal, \
without friction, and follows the history of the depth by one operator. The hand is a spring to a point that goes a circle or way_points, or a force \
that does; mass_kg may be one an axis, box_low_m and box_high_m are the corners of a workspace. The log has a vector in place of each number. The \
summary says how deep it went, what the hand was given, and how far each force is from the full history of the depth; the pre-flight is along the \
normal, with the effective mass of the worst posture. verdict is passive, gave-energy, saturated or unfinished; with must_be_passive = true the exit \
code is 1 unless it is passive. A device of two or three axes, as haply:PATH, takes a touch with --loop host: the hand is then a real one, and the verdict \
rendered in place of passive and gave-energy.

guard = \"observer\" or \"energy-bounding\" keeps a wall from shaking: the one adds damping, the other takes force, and so stiffness, \
that the damping of the device cannot pay for.";

/// Tables of experiment files, as `--help` and the guide show them: heading and keys.
pub const TABLES: &[(&str, &[Parameter])] = &[
    ("[relax]", RELAX),
    ("[creep]", CREEP),
    ("[relax] and [creep]", RENDERING),
    ("[drive], beside [relax] or [creep]", DRIVE),
    ("[wall], to be given", WALL_REQUIRED),
    ("[wall]", WALL),
    ("[coupler], to be given", COUPLER_REQUIRED),
    ("[coupler]", COUPLER),
    ("[teleoperation]", TELEOPERATION),
    ("[touch]", TOUCH),
    ("Every table but [teleoperation], the device", ON_DEVICE),
    ("Every table, the safety chain", SAFETY),
    ("zwidth", ZWIDTH),
    ("design", DESIGN),
    ("zwidth and design, the device", BENCH),
    ("device measure", MEASURE),
];

/// The long help: keys of each table, with defaults and ranges.
pub(crate) fn long_about() -> String {
    let mut text = LONG_ABOUT.to_owned();
    for (heading, parameters) in TABLES {
        let _ = write!(text, "\n\n{heading}:");
        for parameter in *parameters {
            let _ = write!(text, "\n  {}", described(parameter));
        }
    }
    text
}

/// Key, default, range and meaning of a parameter.
fn described(parameter: &Parameter) -> String {
    let Parameter {
        key, value, help, ..
    } = parameter;
    let default = match value {
        Value::Number(Some(default), range) => format!(" = {default}, {range}"),
        Value::Number(None, range) => format!(", {range}"),
        Value::Count(default) => format!(" = {default}"),
        Value::Flag(default) => format!(" = {default}"),
        Value::Text(default) => format!(" = \"{default}\""),
        Value::List(range) => format!(", a list of numbers {range}"),
        _ => String::new(),
    };
    format!("{key}{default}: {help}")
}

/// Arguments of `run`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  host-cli run experiments/wall.toml --out wall\n  \
                  host-cli run experiments/wall.toml stiffness=5kN/m\n  \
                  host-cli run wall/wall.mcap --out again   # the run of a log once more"
)]
pub struct Arguments {
    /// The experiment, or the log of a run that is to be made again
    #[arg(value_name = "FILE")]
    file: PathBuf,
    #[command(flatten)]
    options: Options<keys::Run>,
    #[command(flatten)]
    run: RunArguments,
}

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A file that is wrong; what went wrong in the run, with its exit code.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let file = Document::read(&self.file).map_err(Failure::input)?;
        self.run.run(&self.options.over(file)?, output)
    }
}
