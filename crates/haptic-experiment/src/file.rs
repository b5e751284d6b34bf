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
use super::rendering::{Contact, Precision, Rendering};
use super::run::{Pace, SAMPLES};
use super::safety::{GuardChoice, Safety};
use super::sensed::Sensors;
use super::{Creep, Criterion, CriterionName, Relaxation, TrialPlan, Wall};
use crate::device::{DeviceName, Loop};
use crate::modelled::ModelledTissue;
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
use reader::{Document, Range, Table};
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
    Wall(Wall),
}

/// Kinds of experiments.
const KINDS: [&str; 3] = ["relax", "creep", "wall"];

/// Keys of what is rendered and how.
const RENDERING: [&str; 18] = [
    "tissue",
    "library",
    "area_m2",
    "thickness_m",
    "scheme",
    "precision",
    "sample_time_s",
    "device",
    "loop",
    "watchdog_s",
    "late_ticks",
    "max_age_ticks",
    "contact",
    "encoder_resolution_m",
    "sensor_noise_m",
    "seed",
    "force_limit_n",
    "force_rate_limit_n_per_s",
];

/// Keys of `[wall]`.
const WALL: [&str; 29] = [
    "device",
    "loop",
    "watchdog_s",
    "late_ticks",
    "max_age_ticks",
    "mass_kg",
    "damping_n_s_per_m",
    "hand_stiffness_n_per_m",
    "sample_time_s",
    "delay_s",
    "friction_n",
    "current_lag_s",
    "encoder_resolution_m",
    "sensor_noise_m",
    "seed",
    "force_limit_n",
    "force_rate_limit_n_per_s",
    "order",
    "scheme",
    "stiffness_n_per_m",
    "dissipation_n_s_mu_per_m",
    "one_sided",
    "criterion",
    "impact_m_per_s",
    "push_n",
    "duration_s",
    "window_s",
    "threshold_m",
    "must_be_stable",
];

/// Keys of the safety chain, for every experiment.
const SAFETY: [&str; 17] = [
    "guard",
    "workspace_low_m",
    "workspace_high_m",
    "speed_limit_m_per_s",
    "rise_time_s",
    "braking_n_s_per_m",
    "stop_time_s",
    "brake_force_n",
    "stuck_force_n",
    "stuck_time_s",
    "jump_m",
    "device_mass_kg",
    "device_damping_n_s_per_m",
    "device_delay_least_s",
    "device_delay_most_s",
    "device_lag_s",
    "device_noise_m",
];

const SAMPLE_TIME: Range = Range::Within(Seconds::MIN_SAMPLE_TIME, Seconds::MAX_SAMPLE_TIME);

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
        match kind {
            "relax" => {
                let own = ["strain", "ramp_time_s", "duration_s"];
                relax(&table.with_keys(&[&own, &RENDERING, &SAFETY])?).map(Self::Relax)
            }
            "creep" => {
                let own = ["stress_pa", "duration_s"];
                creep(&table.with_keys(&[&own, &RENDERING, &SAFETY])?).map(Self::Creep)
            }
            _ => wall(&table.with_keys(&[&WALL, &SAFETY])?).map(Self::Wall),
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
    let duration_s = table.number("duration_s", Some(200.0), Range::Above(0.0))?;
    let ramp_time_s = table.number("ramp_time_s", Some(1.0), Range::Above(0.0))?;
    if ramp_time_s >= duration_s {
        let reason = format!("ramp_time_s = {ramp_time_s} is not below duration_s = {duration_s}");
        return Err(table.fail_at("ramp_time_s", reason));
    }
    Ok(Relaxation {
        strain: table.number("strain", Some(0.05), Range::AboveUpTo(0.0, 1.0))?,
        ramp_time_s,
        duration_s,
        rendering: rendering(table, duration_s)?,
    })
}

fn creep(table: &Table<'_>) -> Result<Creep, FileError> {
    let duration_s = table.number("duration_s", Some(200.0), Range::Above(0.0))?;
    Ok(Creep {
        stress_pa: table.number("stress_pa", Some(100.0), Range::AboveUpTo(0.0, 1e9))?,
        duration_s,
        rendering: rendering(table, duration_s)?,
    })
}

fn rendering(table: &Table<'_>, duration_s: f64) -> Result<Rendering, FileError> {
    let remote = remote(table)?;
    let sample_time_s = table.number("sample_time_s", Some(1e-3), SAMPLE_TIME)?;
    samples_fit(table, sample_time_s, duration_s, &SAMPLES)?;
    let library = table.text("library", "")?;
    let folder = (!library.is_empty()).then(|| table.beside(library));
    let library = Library::load(folder.as_deref())
        .map_err(|error| table.fail_at("library", error.to_string()))?;
    let name = table.text("tissue", "prostate-cancerous")?;
    let beside = table.beside(name).to_string_lossy().into_owned();
    let is_path = Path::new(name).extension().is_some_and(|e| e == "toml");
    let material = library
        .find(if is_path { &beside } else { name })
        .map_err(|error| table.fail_at("tissue", error.to_string()))?;
    let material = ModelledTissue::new(material)
        .map_err(|error| table.fail_at("tissue", error.to_string()))?;
    let area = table.number("area_m2", Some(4e-4), Range::Above(0.0))?;
    let thickness = table.number("thickness_m", Some(0.02), Range::Above(0.0))?;
    let specimen = Specimen::new(SquareMetres(area), Metres(thickness))
        .map_err(|error| table.fail(error.to_string()))?;
    let scheme = scheme(table, material.tissue().order(), sample_time_s, duration_s)?;
    Ok(Rendering {
        preflight: PreflightRequest::default(),
        material,
        specimen,
        scheme,
        precision: table.choice("precision", Precision::F64)?,
        sample_time_s,
        contact: table.choice("contact", Contact::Compliant)?,
        sensors: sensors(table)?,
        force_limit_n: table.number("force_limit_n", Some(10.0), Range::Above(0.0))?,
        force_rate_limit_n_per_s: table.number(
            "force_rate_limit_n_per_s",
            Some(1000.0),
            Range::Above(0.0),
        )?,
        safety: safety(table)?,
        pace: Pace::Virtual,
        remote,
    })
}

fn wall(table: &Table<'_>) -> Result<Wall, FileError> {
    let remote = remote(table)?;
    let at_least_0 = Range::AtLeast(0.0);
    let sample_time_s = table.number("sample_time_s", None, SAMPLE_TIME)?;
    let duration = Some(TrialPlan::DEFAULT.duration_s);
    let duration_s = table.number("duration_s", duration, Range::Above(0.0))?;
    samples_fit(table, sample_time_s, duration_s, &TRIAL_SAMPLES)?;
    let order = table.number("order", None, Range::Within(0.0, 2.0))?;
    let order = Order::new(order).map_err(|error| table.fail_at("order", error.to_string()))?;
    let device = MassDamperConfig {
        mass: Kilograms(table.number("mass_kg", None, Range::Above(0.0))?),
        damping: NewtonSecondsPerMetre(table.number("damping_n_s_per_m", None, at_least_0)?),
        stiffness: NewtonsPerMetre(table.number(
            "hand_stiffness_n_per_m",
            Some(0.0),
            at_least_0,
        )?),
        sample_time: Seconds(sample_time_s),
        delay: Seconds(table.number("delay_s", Some(0.0), at_least_0)?),
        friction: Newtons(table.number("friction_n", Some(0.0), at_least_0)?),
        saturation: None,
        lag: Seconds(table.number("current_lag_s", Some(0.0), at_least_0)?),
    };
    let plan = plan(table, duration_s)?;
    let wall = Wall {
        device,
        sensors: sensors(table)?,
        order,
        scheme: scheme(table, order, sample_time_s, duration_s)?,
        stiffness_n_per_m: table.number("stiffness_n_per_m", None, at_least_0)?,
        dissipation_n_s_mu_per_m: table.number("dissipation_n_s_mu_per_m", None, at_least_0)?,
        one_sided: table.flag("one_sided", false)?,
        plan,
        must_be_stable: table.flag("must_be_stable", false)?,
        force_rate_limit_n_per_s: table.number_if("force_rate_limit_n_per_s", Range::Above(0.0))?,
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
    let name = table.choice("criterion", CriterionName::Settling)?;
    let threshold = table.number_if("threshold_m", Range::Above(0.0))?;
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
    let above_0 = Range::Above(0.0);
    let number = |key, value| table.number(key, Some(value), above_0);
    let plan = TrialPlan {
        criterion,
        impact_m_per_s: table.number(
            "impact_m_per_s",
            Some(default.impact_m_per_s),
            Range::AtLeast(0.0),
        )?,
        push_n: number("push_n", default.push_n)?,
        duration_s,
        window_s: number("window_s", default.window_s)?,
        force_limit_n: number("force_limit_n", default.force_limit_n)?,
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
    let device = table.text("device", "sim")?.parse::<DeviceName>();
    let device = device.map_err(|reason| table.fail_at("device", reason))?;
    let loop_mode: Loop = table.choice("loop", Loop::Device)?;
    let (least, most) = (Limits::WATCHDOG_MIN_MS, Limits::WATCHDOG_MAX_MS);
    let range = Range::Within(1e-3 * f64::from(least), 1e-3 * f64::from(most));
    let watchdog_s = table.number_if("watchdog_s", range)?;
    if let Some(time) = watchdog_s.filter(|time| (1e3 * time - (1e3 * time).round()).abs() > 1e-6) {
        let reason = format!(
            "watchdog_s = {time} is not a whole number of milliseconds: write 0.005 for 5 ms"
        );
        return Err(table.fail_at("watchdog_s", reason));
    }
    let late_ticks = table.count("late_ticks", u64::from(Limits::DEFAULT.late_ticks))?;
    let late_ticks = u16::try_from(late_ticks).map_err(|_| {
        table.fail_at(
            "late_ticks",
            format!("late_ticks = {late_ticks} is above 65535"),
        )
    })?;
    let default = u64::from(Limits::DEFAULT.max_age_ticks);
    let max_age_ticks = table.count("max_age_ticks", default)?;
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
    let finite = Range::Within(-1e3, 1e3);
    let above_0 = Range::Above(0.0);
    let [shortest, longest] = haptic_loop::Limits::STOP_TIME_S;
    let stop_time = Range::Within(shortest, longest);
    let brake_force = Range::Within(0.0, haptic_loop::Limits::BRAKE_FORCE_MAX_N);
    let low = table.number_if("workspace_low_m", finite)?;
    let high = table.number_if("workspace_high_m", finite)?;
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
    let at_least_0 = Range::AtLeast(0.0);
    let least = table.number_if("device_delay_least_s", at_least_0)?;
    let most = table.number_if("device_delay_most_s", at_least_0)?;
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
        guard: table.choice("guard", GuardChoice::Off)?,
        workspace_m,
        speed_limit_m_per_s: table.number_if("speed_limit_m_per_s", above_0)?,
        rise_time_s: table.number_if("rise_time_s", above_0)?,
        braking_n_s_per_m: table.number_if("braking_n_s_per_m", above_0)?,
        stop_time_s: table.number_if("stop_time_s", stop_time)?,
        brake_force_n: table.number_if("brake_force_n", brake_force)?,
        stuck_force_n: table.number_if("stuck_force_n", Range::AtLeast(0.0))?,
        stuck_time_s: table.number_if("stuck_time_s", Range::Within(1e-3, 10.0))?,
        jump_m: table.number_if("jump_m", Range::AtLeast(0.0))?,
        device_mass_kg: table.number_if("device_mass_kg", above_0)?,
        device_damping_n_s_per_m: table.number_if("device_damping_n_s_per_m", above_0)?,
        device_delay_s,
        device_lag_s: table.number_if("device_lag_s", at_least_0)?,
        device_noise_m: table.number_if("device_noise_m", at_least_0)?,
    })
}

fn sensors(table: &Table<'_>) -> Result<Sensors, FileError> {
    Ok(Sensors {
        encoder_resolution_m: table.number(
            "encoder_resolution_m",
            Some(0.0),
            Range::AtLeast(0.0),
        )?,
        noise_m: table.number("sensor_noise_m", Some(0.0), Range::AtLeast(0.0))?,
        seed: table.count("seed", 1)?,
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
    let scheme: Scheme = table.text("scheme", "full")?.parse().map_err(fail)?;
    let horizon = 1.05 * (duration_s / sample_time_s);
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
