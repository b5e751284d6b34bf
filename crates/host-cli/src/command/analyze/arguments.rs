//! Arguments that several analyses share: the loop, with units or without, and the files.

use super::path::{PathResult, path};
use crate::command::words::sample_time_of;
use crate::files::Place;
use crate::options::Given;
use clap::Args;
use fracdiff::{Order, Scheme};
use haptic_analysis::{
    AnalysisError, Dynamics, Environment, ForcePath, LoopOperator, Nondimensional, SampledLoop,
    SampledPlant,
};
use haptic_experiment::Failure;
use haptic_experiment::parameters::analysis::{
    ALPHA, ANALYSED_DAMPING, ANALYSED_HAND, ANALYSED_MASS, ANALYSED_SAMPLE_TIME, BETA, DELTA, GAMMA,
};
use haptic_experiment::parameters::{DISSIPATION, Parameter, STIFFNESS};
use haptic_experiment::run::DeviceValues;
use serde::Serialize;
use std::path::PathBuf;

const WITHOUT_UNITS: [Parameter; 4] = [ALPHA, BETA, DELTA, GAMMA];
const WITH_UNITS: [Parameter; 5] = [
    ANALYSED_MASS,
    ANALYSED_DAMPING,
    ANALYSED_HAND,
    STIFFNESS,
    DISSIPATION,
];

/// Memory for which a full-memory operator is designed, samples: 1000 s at 1 kHz.
pub(super) const HORIZON: f64 = 1e6;

/// A loop that is ready to be analysed.
#[derive(Debug)]
pub(super) struct ResolvedLoop {
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
    /// The loop as it was given with units.
    pub asked: Asked,
}

/// A loop with units, as a result repeats it: who took a wrong unit sees it there. Null for a loop without.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(super) struct Asked {
    mass_kg: Option<f64>,
    damping_n_s_per_m: Option<f64>,
    hand_stiffness_n_per_m: Option<f64>,
    sample_time_s: Option<f64>,
    stiffness_n_per_m: Option<f64>,
    dissipation_n_s_mu_per_m: Option<f64>,
}

/// Parameters, or why they are none.
type Checked = Result<Nondimensional, AnalysisError>;

/// The need for α and β (or K and B).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wall {
    /// Both are needed.
    Needed,
    /// The analysis looks for them.
    Sought,
}

/// Checks and gathers a loop.
///
/// # Errors
/// Units mixed with none, something missing, something outside its range.
pub(super) fn resolve(given: &Given, wall: Wall) -> Result<ResolvedLoop, Failure> {
    let mu = given.order()?;
    let file = given.device()?.map(|file| file.values);
    let without_units = WITHOUT_UNITS.iter().any(|parameter| given.has(parameter));
    let with_units = file.is_some() || WITH_UNITS.iter().any(|parameter| given.has(parameter));
    if without_units && with_units {
        return Err(Failure::bad_input(
            "the loop is given both without units and with them: give either --alpha --beta --delta --gamma, or \
             --mass --damping --hand-stiffness (or --device-model) --sample-time --stiffness --dissipation",
        ));
    }
    let (parameters, asked) = parameters(given, mu, with_units, file.as_ref(), wall)?;
    let parameters = parameters.map_err(|error| refused_parameter(error, with_units))?;
    let (scheme, sample_time_s) = (given.scheme()?, given.number(&ANALYSED_SAMPLE_TIME));
    let sample_time = sample_time_of(scheme, sample_time_s)?;
    Ok(ResolvedLoop {
        parameters,
        order: mu,
        operator: LoopOperator::new(scheme, mu, sample_time, HORIZON).map_err(refused)?,
        scheme,
        path: path(given, sample_time_s, file.as_ref())?,
        sample_time_s,
        units: asked.mass_kg.zip(asked.sample_time_s),
        asked,
        delta_given: given.has(&DELTA) || given.has(&ANALYSED_DAMPING) || file.is_some(),
    })
}

/// The loop without units, checked, and m and T if it was given with units.
fn parameters(
    given: &Given,
    mu: Order,
    with_units: bool,
    file: Option<&DeviceValues>,
    wall: Wall,
) -> Result<(Checked, Asked), Failure> {
    let missing = |parameter: &Parameter| {
        Failure::bad_input(format_args!(
            "{parameter} is missing: give --alpha and --beta, or --mass, --sample-time, --stiffness and --dissipation"
        ))
    };
    let needed = |parameter: &Parameter| match (given.number(parameter), wall) {
        (Some(value), _) => Ok(value),
        (None, Wall::Sought) => Ok(0.0),
        (None, Wall::Needed) => Err(missing(parameter)),
    };
    if !with_units {
        let parameters = Nondimensional {
            alpha: needed(&ALPHA)?,
            beta: needed(&BETA)?,
            delta: given.number(&DELTA).unwrap_or(0.0),
            gamma: given.number(&GAMMA).unwrap_or(0.0),
        };
        let asked = Asked {
            sample_time_s: given.number(&ANALYSED_SAMPLE_TIME),
            ..Asked::default()
        };
        return Ok((parameters.checked(), asked));
    }
    let or = |parameter: &Parameter, of_file: fn(&DeviceValues) -> f64| {
        given.number(parameter).or(file.map(of_file))
    };
    let mass = or(&ANALYSED_MASS, |file| file.mass_kg).ok_or_else(|| missing(&ANALYSED_MASS))?;
    let sample_time = given.number(&ANALYSED_SAMPLE_TIME);
    let sample_time = sample_time.ok_or_else(|| missing(&ANALYSED_SAMPLE_TIME))?;
    let damping = or(&ANALYSED_DAMPING, |file| file.damping_n_s_per_m).unwrap_or(0.0);
    let hand = or(&ANALYSED_HAND, |file| file.hand_stiffness_n_per_m).unwrap_or(0.0);
    let device = Dynamics {
        hand_stiffness_n_per_m: hand,
        ..Dynamics::ideal(mass, damping)
    };
    let wall = Environment {
        stiffness_n_per_m: needed(&STIFFNESS)?,
        dissipation_n_s_mu_per_m: needed(&DISSIPATION)?,
        order: mu,
        sample_time_s: sample_time,
    };
    let asked = Asked {
        mass_kg: Some(mass),
        damping_n_s_per_m: Some(damping),
        hand_stiffness_n_per_m: Some(hand),
        sample_time_s: Some(sample_time),
        stiffness_n_per_m: given.number(&STIFFNESS),
        dissipation_n_s_mu_per_m: given.number(&DISSIPATION),
    };
    Ok((device.nondimensional(&wall), asked))
}

impl ResolvedLoop {
    /// The device as the loop sees it.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub(super) fn plant(&self) -> Result<SampledPlant, Failure> {
        let Nondimensional { delta, gamma, .. } = self.parameters;
        SampledPlant::behind(delta, gamma, self.path).map_err(refused)
    }

    /// The loop.
    ///
    /// # Errors
    /// A parameter outside its range.
    pub(super) fn sampled(&self) -> Result<SampledLoop<'_>, Failure> {
        let Nondimensional { alpha, beta, .. } = self.parameters;
        SampledLoop::with_plant(self.plant()?, alpha, beta, &self.operator).map_err(refused)
    }

    /// Delay and lag, for a result.
    #[must_use]
    pub(super) fn path_result(&self) -> PathResult {
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
