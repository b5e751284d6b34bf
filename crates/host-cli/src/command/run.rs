//! `run`: any experiment, from a file.

use super::conduct::conduct;
use super::drive::DriveArguments;
use super::experiment::SharedArguments;
use super::pushed::{print_coupler, print_wall};
use super::realtime::RealtimeArguments;
use super::summary::print_summary;
use super::teleoperation::print_teleoperation;
use super::touch::print_touch;
use super::words::roll_bytes;
use crate::files::{folder, overwrite_acts};
use crate::output::Output;
use crate::picture::{of_coupler, of_teleoperation, of_theory, of_touch, of_wall};
use clap::Args;
use haptic_experiment::failure::Failure;
use haptic_experiment::folder::FolderRequest;
use haptic_experiment::parameters::{
    COUPLER, COUPLER_REQUIRED, CREEP, DRIVE, ON_DEVICE, Parameter, RELAX, RENDERING, SAFETY,
    TELEOPERATION, TOUCH, Value, WALL, WALL_REQUIRED,
};
use haptic_experiment::teleoperation::TeleoperationVerdict;
use haptic_experiment::touch::TouchVerdict;
use haptic_experiment::{
    CouplerExperiment, CouplerReport, ExperimentFile, Pace, TeleoperationExperiment,
    TeleoperationReport, TouchExperiment, TouchReport, WallExperiment, WallReport,
};
use haptic_quantity::Bytes;
use std::fmt::{self, Write as _};
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
#[command(after_help = "Example: host-cli run experiments/wall.toml --out wall")]
pub struct Arguments {
    /// The experiment
    #[arg(value_name = "FILE.toml")]
    file: PathBuf,
    #[command(flatten)]
    realtime: RealtimeArguments,
    #[command(flatten)]
    drive: DriveArguments,
    #[command(flatten)]
    shared: SharedArguments,
    /// Folder for log, CSV and pictures [default: the next free results/KIND-0001]
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Replace the files of an earlier run in the folder
    #[arg(long)]
    overwrite: bool,
    /// Size at which the log goes on in another file, as in 1GB [default: one file]
    #[arg(long, value_name = "SIZE", allow_hyphen_values = true)]
    roll: Option<Bytes>,
}

impl Arguments {
    /// Runs the command.
    ///
    /// # Errors
    /// A file that is wrong; what went wrong in the run, with its exit code.
    pub fn run(self, output: Output) -> Result<(), Failure> {
        let (experiment, pace) = self.experiment()?;
        let samples = experiment.samples()?;
        overwrite_acts(self.out.as_deref(), self.overwrite)?;
        let roll_bytes = roll_bytes(self.roll)?;
        let request = |stem: &str| FolderRequest {
            roll_bytes,
            ..folder(self.out.clone(), stem, self.overwrite)
        };
        let live = self.shared.live.open(pace != Pace::Virtual, output)?;
        match experiment {
            ExperimentFile::Relax(relaxation) => {
                conduct(samples, output, print_summary, of_theory, |supervisor| {
                    relaxation.run(&request("relax"), supervisor.watched(&live))
                })?;
                Ok(())
            }
            ExperimentFile::Creep(creep) => {
                conduct(samples, output, print_summary, of_theory, |supervisor| {
                    creep.run(&request("creep"), supervisor.watched(&live))
                })?;
                Ok(())
            }
            ExperimentFile::Wall(wall) => {
                let report = conduct(samples, output, print_wall, of_wall, |supervisor| {
                    wall.run(&request("wall"), supervisor.watched(&live))
                })?;
                wall_held(&wall, &report)
            }
            ExperimentFile::Coupler(coupler) => {
                let report = conduct(samples, output, print_coupler, of_coupler, |supervisor| {
                    coupler.run(&request("coupler"), supervisor.watched(&live))
                })?;
                coupler_held(&coupler, &report)
            }
            ExperimentFile::Teleoperation(far) => {
                let (print, draw) = (print_teleoperation, of_teleoperation);
                let report = conduct(samples, output, print, draw, |supervisor| {
                    far.run(&request("teleoperation"), supervisor.watched(&live))
                })?;
                line_was_passive(&far, &report)
            }
            ExperimentFile::Touch(touch) => {
                let report = conduct(samples, output, print_touch, of_touch, |supervisor| {
                    touch.run(&request("touch"), supervisor.watched(&live))
                })?;
                shape_was_passive(&touch, &report)
            }
        }
    }
}

impl Arguments {
    /// The experiment of the file with what the options say over it, and its pace.
    ///
    /// # Errors
    /// A file that is wrong; options that do not fit it.
    fn experiment(&self) -> Result<(ExperimentFile, Pace), Failure> {
        let file = ExperimentFile::read(&self.file).map_err(Failure::input)?;
        let remote = &self.shared.remote;
        let of_file = match (file.remote(), remote.named()) {
            (None, Some(name)) => {
                let at = ExperimentFile::remote_at(&self.file, name.clone());
                Some(at.map_err(Failure::input)?)
            }
            (of_file, _) => of_file.cloned(),
        };
        let remote = remote.remote(of_file.as_ref())?;
        let pace = self.realtime.pace(remote.is_some())?;
        let serial = remote.is_some();
        let mut experiment = file.in_pace(pace).on(remote)?;
        let model = self.shared.safety.device_model()?;
        let safety = experiment.safety_mut();
        *safety = self.shared.safety.over(*safety);
        if let Some(model) = &model {
            experiment = experiment.of_device(model)?;
        }
        let safety = *experiment.safety_mut();
        experiment = experiment.driven(|file| self.drive.over(file))?;
        let far = matches!(experiment, ExperimentFile::Teleoperation(_));
        let judged = serial || far || experiment.drive().is_some();
        let wanted = self
            .shared
            .preflight
            .wanted(judged, &safety, model.as_ref())?;
        Ok((experiment.with_preflight(wanted), pace))
    }
}

/// Refuses a wall that is not stable, if its file wants it to be.
fn wall_held(wall: &WallExperiment, report: &WallReport) -> Result<(), Failure> {
    let trial = &report.trial;
    if !wall.setup.must_be_stable || trial.stable_by_both() {
        return Ok(());
    }
    let words = trial.settling.verdict.words();
    Err(unstable(format_args!(
        "the wall is not stable by both trial ({words}) and analysis"
    )))
}

/// Refuses a coupler that is not stable and passed, if its file wants it to be.
fn coupler_held(coupler: &CouplerExperiment, report: &CouplerReport) -> Result<(), Failure> {
    if !coupler.setup.must_be_stable || report.stable_by_all() {
        return Ok(());
    }
    let words = report.trial.settling.verdict.words();
    Err(unstable(format_args!(
        "the coupler is not stable by trial ({words}) and analysis and passed by Llewellyn's criterion"
    )))
}

fn unstable(what: fmt::Arguments<'_>) -> Failure {
    Failure::Run(anyhow::anyhow!(
        "must_be_stable: {what}: design a weaker one, or take must_be_stable out of the file to run it all the same"
    ))
}

/// Refuses a line that was not passive, if its file wants it to be.
fn line_was_passive(
    far: &TeleoperationExperiment,
    report: &TeleoperationReport,
) -> Result<(), Failure> {
    if !far.must_be_passive || report.verdict == TeleoperationVerdict::Passive {
        return Ok(());
    }
    Err(Failure::Run(anyhow::anyhow!(
        "must_be_passive: {}: take a passive architecture, a softer coupler or a smaller motion, or take \
         must_be_passive out of the file to run it all the same",
        report.verdict.words()
    )))
}

/// Refuses a shape that was not passive, if its file wants it to be.
fn shape_was_passive(touch: &TouchExperiment, report: &TouchReport) -> Result<(), Failure> {
    if !touch.must_be_passive || report.verdict == TouchVerdict::Passive {
        return Ok(());
    }
    Err(Failure::Run(anyhow::anyhow!(
        "must_be_passive: {}: take a softer shape, a shorter sample time or a guard, or take must_be_passive out of the \
         file to run it all the same",
        report.verdict.words()
    )))
}
