//! Experiment files: TOML with one table, `[relax]`, `[creep]` or `[wall]`, units in the names of keys.
//!
//! ```toml
//! [wall]
//! mass_kg = 0.065
//! damping_n_s_per_m = 3.5
//! sample_time_s = 0.002
//! order = 0.5
//! stiffness_n_per_m = 3000
//! dissipation_n_s_mu_per_m = 60
//! ```
//! Defaults are those of the commands. Whatever is wrong is refused in one line, `FILE:LINE: reason`;
//! so are keys that are not known. Paths in a file start from the folder of the file.

mod reader;

use super::preflight::PreflightRequest;
use super::pushed::TRIAL_SAMPLES;
use super::remote::RemoteDevice;
use super::rendering::Rendering;
use super::run::SAMPLES;
use super::safety::Safety;
use super::schedule::Pace;
use super::sensed::Sensors;
use super::{Creep, Criterion, CriterionName, Relaxation, TrialPlan, WallExperiment};
use crate::device::{DeviceName, Loop};
use crate::modelled::ModelledTissue;
use crate::parameters::{self, self as p};
use fracdiff::{Order, Scheme, Seconds};
use haptic_link::Limits;
use haptic_loop::Specimen;
use haptic_loop::plant::MassDamperConfig;
use haptic_loop::units::{
    Kilograms, Metres, NewtonSecondsPerMetre, Newtons, NewtonsPerMetre, SquareMetres,
};
use haptic_tissue::Library;
use haptic_tissue::read_text;
pub use reader::FileError;
use reader::{Document, Table};
use std::ops::RangeInclusive;
use std::path::Path;

/// The experiment that a file describes, all of its parameters checked.
#[derive(Clone, Debug)]
pub enum ExperimentFile {
    /// `[relax]`.
    Relax(Relaxation),
    /// `[creep]`.
    Creep(Creep),
    /// `[wall]`.
    Wall(WallExperiment),
}

/// Kinds of experiments.
const KINDS: [&str; 3] = ["relax", "creep", "wall"];

impl ExperimentFile {
    /// Reads and checks a file.
    ///
    /// # Errors
    /// If it cannot be read or is wrong: in one line, with file and line.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let text = read_text(path).map_err(|error| FileError::unreadable(path, &error))?;
        Self::parse(path, &text)
    }

    /// Reads and checks the text of a file; `path` is for messages and for the paths in it.
    ///
    /// # Errors
    /// If it is wrong: in one line, with file and line.
    pub fn parse(path: &Path, text: &str) -> Result<Self, FileError> {
        let document = Document::parse(path, text)?;
        let (kind, table) = document.only_table(&KINDS)?;
        let table = table.with_keys(&parameters::of_kind(kind))?;
        match kind {
            "relax" => relax(&table).map(Self::Relax),
            "creep" => creep(&table).map(Self::Creep),
            _ => wall(&table).map(Self::Wall),
        }
    }

    /// The number of samples.
    ///
    /// # Errors
    /// A parameter outside its range, which reading has ruled out.
    pub fn samples(&self) -> Result<u64, crate::failure::Failure> {
        match self {
            Self::Relax(experiment) => experiment.check(),
            Self::Creep(experiment) => experiment.check(),
            Self::Wall(experiment) => experiment.check(),
        }
    }

    /// The serial device of the file; `None` for the simulated one.
    #[must_use]
    pub fn remote(&self) -> Option<&RemoteDevice> {
        match self {
            Self::Relax(experiment) => experiment.rendering.remote.as_ref(),
            Self::Creep(experiment) => experiment.rendering.remote.as_ref(),
            Self::Wall(experiment) => experiment.remote.as_ref(),
        }
    }

    /// The same, on another device.
    ///
    /// # Errors
    /// What the experiment asks of the simulated device and no other has.
    pub fn on(mut self, remote: Option<RemoteDevice>) -> Result<Self, crate::failure::Failure> {
        let sensors = match &mut self {
            Self::Relax(experiment) => {
                experiment.rendering.remote = remote;
                experiment.rendering.sensors
            }
            Self::Creep(experiment) => {
                experiment.rendering.remote = remote;
                experiment.rendering.sensors
            }
            Self::Wall(experiment) => {
                experiment.remote = remote;
                experiment.sensors
            }
        };
        if self.remote().is_some() && !sensors.are_ideal() {
            return Err(crate::failure::Failure::bad_input(
                "encoder_resolution_m and sensor_noise_m are of the simulated device: leave them away with \
                 a serial one, which has its own",
            ));
        }
        Ok(self)
    }

    /// What it asks of the safety chain.
    pub fn safety_mut(&mut self) -> &mut Safety {
        match self {
            Self::Relax(experiment) => &mut experiment.rendering.safety,
            Self::Creep(experiment) => &mut experiment.rendering.safety,
            Self::Wall(experiment) => &mut experiment.safety,
        }
    }

    /// The same, with this wish for the pre-flight. A wall knows its device; for the others it is told here.
    #[must_use]
    pub fn with_preflight(mut self, wanted: PreflightRequest) -> Self {
        match &mut self {
            Self::Relax(experiment) => experiment.rendering.preflight = wanted,
            Self::Creep(experiment) => experiment.rendering.preflight = wanted,
            Self::Wall(experiment) => experiment.force_unstable = wanted.force_unstable,
        }
        self
    }

    /// The same, in another pace.
    #[must_use]
    pub fn in_pace(mut self, pace: Pace) -> Self {
        match &mut self {
            Self::Relax(experiment) => experiment.rendering.pace = pace,
            Self::Creep(experiment) => experiment.rendering.pace = pace,
            Self::Wall(experiment) => experiment.pace = pace,
        }
        self
    }
}

fn relax(table: &Table<'_>) -> Result<Relaxation, FileError> {
    let duration_s = table.number(&p::RELAX_DURATION)?;
    let ramp_time_s = table.number(&p::RAMP_TIME)?;
    if ramp_time_s >= duration_s {
        let reason = format!("ramp_time_s = {ramp_time_s} is not below duration_s = {duration_s}");
        return Err(table.fail_at("ramp_time_s", reason));
    }
    Ok(Relaxation {
        strain: table.number(&p::STRAIN)?,
        ramp_time_s,
        duration_s,
        rendering: rendering(table, duration_s)?,
    })
}

fn creep(table: &Table<'_>) -> Result<Creep, FileError> {
    let duration_s = table.number(&p::CREEP_DURATION)?;
    Ok(Creep {
        stress_pa: table.number(&p::STRESS)?,
        duration_s,
        rendering: rendering(table, duration_s)?,
    })
}

fn rendering(table: &Table<'_>, duration_s: f64) -> Result<Rendering, FileError> {
    let remote = remote(table)?;
    let sample_time_s = table.number(&p::SAMPLE_TIME)?;
    samples_fit(table, sample_time_s, duration_s, &SAMPLES)?;
    let library = table.text(&p::LIBRARY)?;
    let folder = (!library.is_empty()).then(|| table.beside(library));
    let library = Library::load(folder.as_deref())
        .map_err(|error| table.fail_at("library", error.to_string()))?;
    let name = table.text(&p::TISSUE)?;
    let beside = table.beside(name).to_string_lossy().into_owned();
    let is_path = Path::new(name).extension().is_some_and(|e| e == "toml");
    let material = library
        .find(if is_path { &beside } else { name })
        .map_err(|error| table.fail_at("tissue", error.to_string()))?;
    let material = ModelledTissue::new(material)
        .map_err(|error| table.fail_at("tissue", error.to_string()))?;
    let area = table.number(&p::AREA)?;
    let thickness = table.number(&p::THICKNESS)?;
    let specimen = Specimen::new(SquareMetres(area), Metres(thickness))
        .map_err(|error| table.fail(error.to_string()))?;
    let scheme = scheme(table, material.tissue().order(), sample_time_s, duration_s)?;
    Ok(Rendering {
        preflight: PreflightRequest::default(),
        material,
        specimen,
        scheme,
        precision: table.choice(&p::PRECISION)?,
        sample_time_s,
        contact: table.choice(&p::CONTACT)?,
        sensors: sensors(table)?,
        force_limit_n: table.number(&p::FORCE_LIMIT)?,
        force_rate_limit_n_per_s: table.number(&p::FORCE_RATE_LIMIT)?,
        safety: safety(table)?,
        pace: Pace::Virtual,
        remote,
    })
}

fn wall(table: &Table<'_>) -> Result<WallExperiment, FileError> {
    let remote = remote(table)?;
    let sample_time_s = table.required(&p::WALL_SAMPLE_TIME)?;
    let duration_s = table.number(&p::TRIAL_DURATION)?;
    samples_fit(table, sample_time_s, duration_s, &TRIAL_SAMPLES)?;
    let order = table.required(&p::ORDER)?;
    let order = Order::new(order).map_err(|error| table.fail_at("order", error.to_string()))?;
    let device = MassDamperConfig {
        mass: Kilograms(table.required(&p::MASS)?),
        damping: NewtonSecondsPerMetre(table.required(&p::DAMPING)?),
        stiffness: NewtonsPerMetre(table.number(&p::HAND_STIFFNESS)?),
        sample_time: Seconds(sample_time_s),
        delay: Seconds(table.number(&p::DELAY)?),
        friction: Newtons(table.number(&p::FRICTION)?),
        saturation: None,
        lag: Seconds(table.number(&p::CURRENT_LAG)?),
    };
    let plan = plan(table, duration_s)?;
    let wall = WallExperiment {
        device,
        sensors: sensors(table)?,
        order,
        scheme: scheme(table, order, sample_time_s, duration_s)?,
        stiffness_n_per_m: table.required(&p::STIFFNESS)?,
        dissipation_n_s_mu_per_m: table.required(&p::DISSIPATION)?,
        one_sided: table.flag(&p::ONE_SIDED)?,
        plan,
        must_be_stable: table.flag(&p::MUST_BE_STABLE)?,
        force_rate_limit_n_per_s: table.number_if(&p::TRIAL_FORCE_RATE_LIMIT)?,
        safety: safety(table)?,
        pace: Pace::Virtual,
        remote,
        force_unstable: false,
    };
    wall.check()
        .map_err(|error| table.fail(error.to_string()))?;
    Ok(wall)
}

/// How a wall is tried and judged.
fn plan(table: &Table<'_>, duration_s: f64) -> Result<TrialPlan, FileError> {
    let name = table.choice(&p::CRITERION)?;
    let threshold = table.number_if(&p::THRESHOLD)?;
    let (default, criterion) = match (name, threshold) {
        (CriterionName::Settling, Some(threshold)) => {
            let reason = format!(
                "threshold_m = {threshold} belongs to criterion = \"dissertation\": add that, or leave it out"
            );
            return Err(table.fail_at("threshold_m", reason));
        }
        (CriterionName::Settling, None) => (TrialPlan::DEFAULT, Criterion::Settling),
        (CriterionName::Dissertation, threshold) => {
            let threshold_m = threshold.unwrap_or(Criterion::DISSERTATION_THRESHOLD_M);
            let criterion = Criterion::Dissertation { threshold_m };
            (TrialPlan::DISSERTATION, criterion)
        }
    };
    let plan = TrialPlan {
        criterion,
        impact_m_per_s: table
            .number_if(&p::IMPACT)?
            .unwrap_or(default.impact_m_per_s),
        push_n: table.number(&p::PUSH)?,
        duration_s,
        window_s: table.number(&p::WINDOW)?,
        force_limit_n: table.number(&p::TRIAL_FORCE_LIMIT)?,
    };
    if plan.push_n >= plan.force_limit_n {
        let reason = format!(
            "push_n = {} is not below force_limit_n = {}: no wall could hold it",
            plan.push_n, plan.force_limit_n
        );
        return Err(table.fail_at("push_n", reason));
    }
    Ok(plan)
}

/// As many samples as a run can have.
fn samples_fit(
    table: &Table<'_>,
    sample_time_s: f64,
    duration_s: f64,
    range: &RangeInclusive<f64>,
) -> Result<(), FileError> {
    let samples = (duration_s / sample_time_s).round() + 1.0;
    if range.contains(&samples) {
        return Ok(());
    }
    let reason = format!(
        "duration_s = {duration_s} with sample_time_s = {sample_time_s} is {samples} samples, which is \
         not in [{}, {:e}]",
        range.start(),
        range.end()
    );
    Err(table.fail_at("duration_s", reason))
}

/// The serial device; `None` for the simulated one.
fn remote(table: &Table<'_>) -> Result<Option<RemoteDevice>, FileError> {
    let device = table.text(&p::DEVICE)?.parse::<DeviceName>();
    let device = device.map_err(|reason| table.fail_at("device", reason))?;
    let loop_mode: Loop = table.choice(&p::LOOP)?;
    let watchdog_s = table.number_if(&p::WATCHDOG)?;
    if let Some(time) = watchdog_s.filter(|time| (1e3 * time - (1e3 * time).round()).abs() > 1e-6) {
        let reason = format!(
            "watchdog_s = {time} is not a whole number of milliseconds: write 0.005 for 5 ms"
        );
        return Err(table.fail_at("watchdog_s", reason));
    }
    let late_ticks = table.count(&p::LATE_TICKS)?;
    let late_ticks = u16::try_from(late_ticks).map_err(|_| {
        table.fail_at(
            "late_ticks",
            format!("late_ticks = {late_ticks} is above 65535"),
        )
    })?;
    let default = u64::from(Limits::DEFAULT.max_age_ticks);
    let max_age_ticks = table.count(&p::MAX_AGE_TICKS)?;
    let most = Limits::MAX_AGE_TICKS;
    let max_age_ticks = u16::try_from(max_age_ticks)
        .ok()
        .filter(|ticks| (1..=most).contains(ticks));
    let max_age_ticks = max_age_ticks.ok_or_else(|| {
        let reason = format!("max_age_ticks is not in [1, {most}]: leave it away for {default}");
        table.fail_at("max_age_ticks", reason)
    })?;
    Ok(match device {
        DeviceName::Simulated => None,
        DeviceName::Serial(name) => Some(RemoteDevice {
            loop_mode: loop_mode.into(),
            watchdog_ms: watchdog_s.map(|time| (1e3 * time).round() as u16),
            late_ticks,
            max_age_ticks,
            ..RemoteDevice::new(name)
        }),
    })
}

/// What else the safety chain does; a wall knows mass and damping of its device by other keys too.
fn safety(table: &Table<'_>) -> Result<Safety, FileError> {
    let low = table.number_if(&p::WORKSPACE_LOW)?;
    let high = table.number_if(&p::WORKSPACE_HIGH)?;
    let workspace_m = match (low, high) {
        (None, None) => None,
        (Some(low), Some(high)) if low < high => Some((low, high)),
        (Some(low), Some(high)) => {
            let reason = format!("workspace_high_m = {high} is not above workspace_low_m = {low}");
            return Err(table.fail_at("workspace_high_m", reason));
        }
        (Some(_), None) => {
            let reason = "a workspace has two ends: give workspace_high_m too".to_owned();
            return Err(table.fail_at("workspace_low_m", reason));
        }
        (None, Some(_)) => {
            let reason = "a workspace has two ends: give workspace_low_m too".to_owned();
            return Err(table.fail_at("workspace_high_m", reason));
        }
    };
    let least = table.number_if(&p::DEVICE_DELAY_LEAST)?;
    let most = table.number_if(&p::DEVICE_DELAY_MOST)?;
    let device_delay_s = match (least, most) {
        (None, None) => None,
        (Some(least), Some(most)) if least <= most => Some((least, most)),
        (Some(least), Some(most)) => {
            let reason =
                format!("device_delay_most_s = {most} is below device_delay_least_s = {least}");
            return Err(table.fail_at("device_delay_most_s", reason));
        }
        (Some(_), None) => {
            let reason =
                "a delay has two ends: give device_delay_most_s too, the same if it is known";
            return Err(table.fail_at("device_delay_least_s", reason.to_owned()));
        }
        (None, Some(_)) => {
            let reason =
                "a delay has two ends: give device_delay_least_s too, the same if it is known";
            return Err(table.fail_at("device_delay_most_s", reason.to_owned()));
        }
    };
    Ok(Safety {
        guard: table.choice(&p::GUARD)?,
        workspace_m,
        speed_limit_m_per_s: table.number_if(&p::SPEED_LIMIT)?,
        rise_time_s: table.number_if(&p::RISE_TIME)?,
        braking_n_s_per_m: table.number_if(&p::BRAKING)?,
        stop_time_s: table.number_if(&p::STOP_TIME)?,
        brake_force_n: table.number_if(&p::BRAKE_FORCE)?,
        stuck_force_n: table.number_if(&p::STUCK_FORCE)?,
        stuck_time_s: table.number_if(&p::STUCK_TIME)?,
        jump_m: table.number_if(&p::JUMP)?,
        device_mass_kg: table.number_if(&p::DEVICE_MASS)?,
        device_damping_n_s_per_m: table.number_if(&p::DEVICE_DAMPING)?,
        device_delay_s,
        device_lag_s: table.number_if(&p::DEVICE_LAG)?,
        device_noise_m: table.number_if(&p::DEVICE_NOISE)?,
    })
}

fn sensors(table: &Table<'_>) -> Result<Sensors, FileError> {
    Ok(Sensors {
        encoder_resolution_m: table.number(&p::ENCODER_RESOLUTION)?,
        noise_m: table.number(&p::SENSOR_NOISE)?,
        seed: table.count(&p::SEED)?,
    })
}

/// A scheme that can be made for this order and sample time.
fn scheme(
    table: &Table<'_>,
    order: Order,
    sample_time_s: f64,
    duration_s: f64,
) -> Result<Scheme, FileError> {
    let fail = |error: fracdiff::SchemeError| table.fail_at("scheme", error.to_string());
    let scheme: Scheme = table.text(&p::SCHEME)?.parse().map_err(fail)?;
    let horizon = crate::schedule::horizon((duration_s / sample_time_s) as u64);
    match scheme.build::<f64>(order, Seconds(sample_time_s), horizon) {
        Ok(_) => Ok(scheme),
        Err(error) => Err(fail(error)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WALL: &str = "[wall]\nmass_kg = 0.065\ndamping_n_s_per_m = 3.5\nsample_time_s = 2e-3\n\
                        order = 0.5\nstiffness_n_per_m = 3_000\ndissipation_n_s_mu_per_m = 60.0\n";

    fn read(text: &str) -> Result<ExperimentFile, String> {
        ExperimentFile::parse(Path::new("lab/wall.toml"), text).map_err(|error| error.to_string())
    }

    #[test]
    fn a_wall_has_the_defaults_of_the_dissertation() {
        let Ok(ExperimentFile::Wall(wall)) = read(WALL) else {
            panic!("{:?}", read(WALL));
        };
        let have = [
            wall.stiffness_n_per_m,
            wall.plan.push_n,
            wall.plan.duration_s,
            wall.plan.window_s,
        ];
        assert!(
            have.iter()
                .zip([3000.0, 1.0, 5.0, 0.4])
                .all(|(a, b)| a.to_bits() == f64::to_bits(b))
        );
        assert_eq!(wall.check().expect("valid"), 2501);
    }

    #[test]
    fn empty_tables_are_the_commands_defaults() {
        for text in ["[relax]", "[creep]\n"] {
            let file = read(text).expect("valid");
            assert_eq!(file.samples().expect("valid"), 200_001, "{text}");
        }
    }

    #[test]
    fn what_is_wrong_is_said_in_one_line_with_its_place() {
        for (from, to, want) in [
            (
                "= 0.065",
                "= -1",
                "lab/wall.toml:2: mass_kg = -1 is not above 0",
            ),
            (
                "= 0.065",
                "= nan",
                "lab/wall.toml:2: mass_kg = NaN is not above 0",
            ),
            (
                "= 0.065",
                "= \"x\"",
                "lab/wall.toml:2: mass_kg = \"x\" is a string, not a number",
            ),
            (
                "= 0.065",
                "= 0x41",
                "lab/wall.toml:2: mass_kg is not written as a decimal number",
            ),
            (
                "order = 0.5",
                "order = 2.5",
                "lab/wall.toml:5: order = 2.5 is not in [0, 2]",
            ),
            (
                "order = 0.5\n",
                "",
                "lab/wall.toml:1: missing key `order` in [wall]",
            ),
            (
                "order =",
                "ordre =",
                "lab/wall.toml:5: unknown key `ordre` in [wall]: did you mean `order`?",
            ),
            (
                "[wall]",
                "[wal]",
                "lab/wall.toml:1: unknown table [wal]: an experiment file has one of [relax], [creep], [wall]",
            ),
            (
                "[wall]\n",
                "[wall]\nscheme = \"exact\"\n",
                "lab/wall.toml:2: scheme exact is for analysis only",
            ),
            (
                "[wall]\n",
                "[wall]\nseed = -1\n",
                "lab/wall.toml:2: seed = -1 is not a whole number",
            ),
            (
                "[wall]\n",
                "[wall]\none_sided = 1\n",
                "lab/wall.toml:2: one_sided = 1 is an integer, not true or false",
            ),
            (
                "[wall]\n",
                "[relax]\n[wall]\n",
                "lab/wall.toml:2: a second table [wall]: an experiment file has one of",
            ),
            (
                "[wall]\n",
                "[wall]\npush_n = 200\n",
                "lab/wall.toml:2: push_n = 200 is not below force_limit_n = 100",
            ),
            (
                "[wall]\n",
                "[wall]\nguard = \"on\"\n",
                "lab/wall.toml:2: guard = \"on\" is not one of off, observer, energy-bounding",
            ),
            (
                "damping_n_s_per_m = 3.5\n",
                "damping_n_s_per_m = 0\nguard = \"energy-bounding\"\n",
                "lab/wall.toml:1: damping of the device 0 N·s/m is not above 0",
            ),
            (
                "[wall]\n",
                "[wall]\nduration_s = 0.1\n",
                "lab/wall.toml:1: window 0.4 s is not in [0.02, 0.1] s",
            ),
            (
                "[wall]\n",
                "[wall]\ndelay_s = 1\n",
                "lab/wall.toml:1: force delay 1 s",
            ),
            ("[wall]", "[wall", "lab/wall.toml:1: "),
            (
                WALL,
                "",
                "lab/wall.toml:1: no experiment: an experiment file has one of [relax], [creep], [wall]",
            ),
            (
                WALL,
                "wall = 3",
                "lab/wall.toml:1: `wall` is not a table: write [wall]",
            ),
            (
                WALL,
                "[relax]\nramp_time_s = 300",
                "lab/wall.toml:2: ramp_time_s = 300 is not below duration_s = 200",
            ),
            (
                WALL,
                "[relax]\ncontact = \"soft\"",
                "lab/wall.toml:2: contact = \"soft\" is not one of compliant, rigid",
            ),
            (
                WALL,
                "[creep]\n\ntissue = \"jelly\"",
                "lab/wall.toml:3: tissue \"jelly\" is not in the library",
            ),
            (
                WALL,
                "[creep]\ntissue = \"a.toml\"",
                "lab/wall.toml:2: cannot read the material file `lab/a.toml`",
            ),
            (
                WALL,
                "[relax]\nduration_s = 1e9",
                "lab/wall.toml:2: duration_s = 1000000000 with sample_time_s = 0.001 is 1000000000001 samples",
            ),
        ] {
            assert!(WALL.contains(from), "{from}");
            let have = read(&WALL.replace(from, to)).expect_err(to);
            assert!(have.starts_with(want), "have {have}\nwant {want}");
            assert!(!have.contains('\n'), "{have}");
        }
    }
}
