//! Arguments that several analyses share: the loop, with units or without, and the files.

use super::path::{PathArguments, PathResult};
use crate::command::device_model::DeviceModelArguments;
use crate::command::words::{
    parse_dissipation, parse_order, parse_scheme, sample_time_of, wall_order,
};
use crate::files::Place;
use crate::within::{number_within, read_within, within};
use clap::Args;
use fracdiff::{Order, Scheme};
use haptic_analysis::{
    AnalysisError, ForcePath, Loop, LoopOperator, Nondimensional, SampledLoop, SampledPlant,
};
use haptic_experiment::Failure;
use haptic_experiment::parameters;
use haptic_experiment::parameters::range;
use haptic_experiment::run::DeviceValues;
use haptic_quantity::{Damping, Mass, Stiffness, Time};
use std::path::PathBuf;

/// Memory for which a full-memory operator is designed, samples: 1000 s at 1 kHz.
pub(super) const HORIZON: f64 = 1e6;

/// A loop: nondimensional, or with units.
#[derive(Debug, Args)]
pub struct LoopArguments {
    /// Order mu of the dissipation, 0 to 2
    #[arg(long, value_parser = parse_order, allow_hyphen_values = true)]
    pub order: f64,
    /// Fractional operator, see `host-cli --help`
    #[arg(long, value_parser = parse_scheme, default_value = "exact")]
    pub scheme: Scheme,
    #[command(flatten)]
    path: PathArguments,
    #[command(flatten)]
    file: DeviceModelArguments,
    /// Sample time T; needed with units, for a delay or lag in seconds, and for a scheme with frequencies in Hz
    #[arg(long, value_parser = within::<Time>(range::SAMPLE_TIMES), allow_hyphen_values = true)]
    sample_time: Option<Time>,

    /// Stiffness K T^2/m
    #[arg(long, value_parser = number_within(range::WALL_NUMBERS), allow_hyphen_values = true, help_heading = "Loop without units", hide_short_help = true)]
    alpha: Option<f64>,
    /// Dissipation B T^(2-mu)/m
    #[arg(long, value_parser = number_within(range::WALL_NUMBERS), allow_hyphen_values = true, help_heading = "Loop without units", hide_short_help = true)]
    beta: Option<f64>,
    /// Damping of the device b T/m [default: 0]
    #[arg(long, value_parser = number_within(range::DELTAS), allow_hyphen_values = true, help_heading = "Loop without units", hide_short_help = true)]
    delta: Option<f64>,
    /// Stiffness of the hand k T^2/m [default: 0]
    #[arg(long, value_parser = number_within(range::WALL_NUMBERS), allow_hyphen_values = true, help_heading = "Loop without units", hide_short_help = true)]
    gamma: Option<f64>,

    /// Mass m of the device (and the hand)
    #[arg(long, value_parser = within::<Mass>(parameters::MASS.range()), allow_hyphen_values = true, help_heading = "Loop with units")]
    mass: Option<Mass>,
    /// Viscous damping b of the device (and the hand) [default: 0]
    #[arg(long, value_parser = within::<Damping>(parameters::DAMPING.range()), allow_hyphen_values = true, help_heading = "Loop with units")]
    damping: Option<Damping>,
    /// Stiffness k of the hand [default: 0]
    #[arg(long, value_parser = within::<Stiffness>(parameters::HAND_STIFFNESS.range()), allow_hyphen_values = true, help_heading = "Loop with units")]
    hand_stiffness: Option<Stiffness>,
    /// Virtual stiffness K
    #[arg(long, value_parser = within::<Stiffness>(parameters::STIFFNESS.range()), allow_hyphen_values = true, help_heading = "Loop with units")]
    stiffness: Option<Stiffness>,
    /// Fractional dissipation B, N s^mu/m
    #[arg(long, value_parser = read_within(parse_dissipation, parameters::DISSIPATION.range()), allow_hyphen_values = true, help_heading = "Loop with units")]
    dissipation: Option<f64>,
}

/// A loop that is ready to be analysed.
#[derive(Debug)]
pub struct ResolvedLoop {
    /// Without units.
    pub parameters: Nondimensional,
    /// μ.
    pub order: Order,
    /// P(w).
    pub operator: LoopOperator,
    /// Its name.
    pub scheme: Scheme,
    /// Delay and lag.
    pub path: ForcePath,
    /// T, s, if it was given.
    pub sample_time_s: Option<f64>,
    /// m and T, where the loop was given with units.
    pub units: Option<(f64, f64)>,
    /// True if δ (or b) was given at all.
    pub delta_given: bool,
}

/// Parameters, or why they are none.
type Checked = Result<Nondimensional, AnalysisError>;

/// The need for α and β (or K and B).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wall {
    /// Both are needed.
    Needed,
    /// The analysis looks for them.
    Sought,
}

impl LoopArguments {
    /// Checks and gathers everything.
    ///
    /// # Errors
    /// Units mixed with none, something missing, something outside its range.
    pub fn resolve(&self, wall: Wall) -> Result<ResolvedLoop, Failure> {
        let mu = wall_order(self.order, "--order")?;
        let file = self.file.read()?.map(|file| file.values);
        let without = [self.alpha, self.beta, self.delta, self.gamma];
        let without_units = without.iter().any(Option::is_some);
        let with_units = file.is_some()
            || self.mass.is_some()
            || self.damping.is_some()
            || self.hand_stiffness.is_some()
            || self.stiffness.is_some()
            || self.dissipation.is_some();
        if without_units && with_units {
            return Err(Failure::bad_input(
                "the loop is given both without units and with them: give either --alpha --beta \
                 --delta --gamma, or --mass --damping --hand-stiffness (or --device-model) --sample-time --stiffness \
                 --dissipation",
            ));
        }
        let (parameters, units) = self.parameters(mu, with_units, file.as_ref(), wall)?;
        let parameters = parameters.map_err(|error| refused_parameter(error, with_units))?;
        let sample_time_s = self.sample_time.map(|t| t.0);
        if let Some(t) = sample_time_s.filter(|t| *t <= 0.0 || t.is_nan()) {
            return Err(Failure::bad_input(format_args!(
                "sample time {t} s is not above 0 s: change --sample-time"
            )));
        }
        let sample_time = sample_time_of(self.scheme, sample_time_s)?;
        Ok(ResolvedLoop {
            parameters,
            order: mu,
            operator: LoopOperator::new(self.scheme, mu, sample_time, HORIZON).map_err(refused)?,
            scheme: self.scheme,
            path: self.path.resolve(sample_time_s, file.as_ref())?,
            sample_time_s,
            units,
            delta_given: self.delta.is_some() || self.damping.is_some() || file.is_some(),
        })
    }

    /// The loop without units, checked, and m and T if it was given with units.
    fn parameters(
        &self,
        mu: Order,
        with_units: bool,
        file: Option<&DeviceValues>,
        wall: Wall,
    ) -> Result<(Checked, Option<(f64, f64)>), Failure> {
        let missing = |option: &str| {
            Failure::bad_input(format_args!(
                "{option} is missing: give --alpha and --beta, or --mass, --sample-time, --stiffness \
                 and --dissipation"
            ))
        };
        let needed = |value: Option<f64>, option: &str| match (value, wall) {
            (Some(value), _) => Ok(value),
            (None, Wall::Sought) => Ok(0.0),
            (None, Wall::Needed) => Err(missing(option)),
        };
        Ok(if with_units {
            let or =
                |given: Option<f64>, of_file: fn(&DeviceValues) -> f64| given.or(file.map(of_file));
            let mass = or(self.mass.map(|m| m.0), |file| file.mass_kg);
            let mass = mass.ok_or_else(|| missing("--mass"))?;
            let damping = or(self.damping.map(|b| b.0), |file| file.damping_n_s_per_m);
            let hand = or(self.hand_stiffness.map(|k| k.0), |file| {
                file.hand_stiffness_n_per_m
            });
            let sample_time = self.sample_time.ok_or_else(|| missing("--sample-time"))?.0;
            let parameters = Loop {
                mass_kg: mass,
                damping_n_s_per_m: damping.unwrap_or(0.0),
                hand_stiffness_n_per_m: hand.unwrap_or(0.0),
                sample_time_s: sample_time,
                order: mu,
                stiffness_n_per_m: needed(self.stiffness.map(|k| k.0), "--stiffness")?,
                dissipation_n_s_mu_per_m: needed(self.dissipation, "--dissipation")?,
            };
            (parameters.nondimensional(), Some((mass, sample_time)))
        } else {
            let parameters = Nondimensional {
                alpha: needed(self.alpha, "--alpha")?,
                beta: needed(self.beta, "--beta")?,
                delta: self.delta.unwrap_or(0.0),
                gamma: self.gamma.unwrap_or(0.0),
            };
            (parameters.checked(), None)
        })
    }
}

impl ResolvedLoop {
    /// The device as the loop sees it.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn plant(&self) -> Result<SampledPlant, Failure> {
        let Nondimensional { delta, gamma, .. } = self.parameters;
        SampledPlant::behind(delta, gamma, self.path).map_err(refused)
    }

    /// The loop.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub fn sampled(&self) -> Result<SampledLoop<'_>, Failure> {
        let Nondimensional { alpha, beta, .. } = self.parameters;
        SampledLoop::with_plant(self.plant()?, alpha, beta, &self.operator).map_err(refused)
    }

    /// Delay and lag, for a result.
    #[must_use]
    pub fn path_result(&self) -> PathResult {
        PathResult::new(self.path, self.sample_time_s)
    }
}

/// A question without an answer is bad input.
pub(super) fn refused(error: AnalysisError) -> Failure {
    Failure::input(error)
}

/// The same for a parameter of the loop, with the options that set it.
fn refused_parameter(error: AnalysisError, with_units: bool) -> Failure {
    let AnalysisError::Range(range) = &error else {
        return refused(error);
    };
    let advice = match (range.what, with_units) {
        ("mass", _) => "change --mass",
        ("sample time", _) => "change --sample-time",
        ("damping", _) => "change --damping",
        ("hand stiffness", _) => "change --hand-stiffness",
        ("stiffness", _) => "change --stiffness",
        ("dissipation", _) => "change --dissipation",
        ("alpha", true) => "it is K T^2/m, change --stiffness, --mass or --sample-time",
        ("beta", true) => "it is B T^(2-mu)/m, change --dissipation, --mass or --sample-time",
        ("delta", true) => "it is b T/m, change --damping, --mass or --sample-time",
        ("gamma", true) => "it is k T^2/m, change --hand-stiffness, --mass or --sample-time",
        ("alpha", false) => "change --alpha",
        ("beta", false) => "change --beta",
        ("delta", false) => "change --delta",
        ("gamma", false) => "change --gamma",
        _ => return refused(error),
    };
    Failure::input_with_advice(error, advice)
}

/// The folder of pictures and tables, if they are wanted.
#[derive(Debug, Args)]
#[command(next_help_heading = "Files")]
pub struct Files {
    /// Folder for a picture (PNG and SVG) and a CSV
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Replace the files of an earlier analysis in the folder
    #[arg(long)]
    pub overwrite: bool,
}

impl Files {
    /// Looks at the place of a table and a picture of this name, before anything is computed.
    ///
    /// # Errors
    /// A folder or file that cannot be written.
    pub fn look(&self, stem: &'static str) -> Result<Place, Failure> {
        Place::look(self.out.as_deref(), stem, self.overwrite, &[])
    }
}

/// Amplitude ratio in decibel.
pub(super) fn decibel(magnitude: f64) -> f64 {
    20.0 * magnitude.log10()
}

/// `count` frequencies from `low` to `high`, equal steps of their logarithm.
pub(super) fn logarithmic(low: f64, high: f64, count: usize) -> impl Iterator<Item = f64> {
    let ratio = (high / low).ln();
    let steps = count.saturating_sub(1).max(1) as f64;
    // The last is exactly `high`.
    (0..count).map(move |i| match i + 1 == count {
        true => high,
        false => low * (ratio * i as f64 / steps).exp(),
    })
}
