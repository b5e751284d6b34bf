//! The loop that an analysis is asked about, with units or without.

use crate::options::Given;
use crate::options::keys::{
    ANALYSED_DAMPING, ANALYSED_DELAY, ANALYSED_HAND, ANALYSED_LAG, ANALYSED_MASS,
    ANALYSED_SAMPLE_TIME,
};
use crate::output::{Output, joined};
use crate::parse::sample_time_of;
use fracdiff::{Order, Scheme};
use haptic_analysis::{
    Dynamics, Environment, ForcePath, LoopOperator, Nondimensional, SampledLoop, SampledPlant,
};
use haptic_experiment::Failure;
use haptic_experiment::parameters::analysis::{ALPHA, BETA, DELAY_SAMPLES, DELTA, GAMMA};
use haptic_experiment::parameters::{DISSIPATION, Parameter, STIFFNESS};
use haptic_experiment::run::DeviceValues;
use haptic_experiment::run::analysed;
use haptic_quantity::{digits, written};
use serde_json::{Value, json};

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
    pub(super) parameters: Nondimensional,
    pub(super) order: Order,
    pub(super) operator: LoopOperator,
    pub(super) scheme: Scheme,
    pub(super) path: ForcePath,
    /// T, s, if it was given.
    pub(super) sample_time_s: Option<f64>,
    /// m and T, where the loop was given with units.
    pub(super) units: Option<(f64, f64)>,
    /// True if the wall was given, K with B or α with β.
    pub(super) wall_given: bool,
    /// True if δ (or b) was given at all.
    pub(super) delta_given: bool,
    /// The loop with units, as a result repeats it: who took a wrong unit sees it there.
    pub(super) asked: Value,
}

/// The need for α and β (or K and B).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Wall {
    Needed,
    /// The analysis looks for them.
    Sought,
}

pub(super) fn resolve(given: &Given, wall: Wall) -> Result<ResolvedLoop, Failure> {
    let mu = given.order()?;
    let file = given.device()?.map(|file| file.values);
    let without_units = WITHOUT_UNITS.iter().any(|parameter| given.has(parameter));
    let with_units = file.is_some() || WITH_UNITS.iter().any(|parameter| given.has(parameter));
    if without_units && with_units {
        return Err(Failure::bad_input(
            "the loop is given both with and without units: omit --alpha, --beta, --delta and --gamma",
        ));
    }
    let missing = |parameter: &Parameter| {
        Failure::bad_input(format_args!(
            "{parameter} is missing: give --alpha and --beta, or --mass, --sample-time and the wall"
        ))
    };
    let needed = |parameter: &Parameter| match (given.number(parameter), wall) {
        (Some(value), _) => Ok(value),
        (None, Wall::Sought) => Ok(0.0),
        (None, Wall::Needed) => Err(missing(parameter)),
    };
    let or = |parameter: &Parameter, of_file: fn(&DeviceValues) -> f64| {
        given.number(parameter).or(file.as_ref().map(of_file))
    };
    let sample_time_s = given.number(&ANALYSED_SAMPLE_TIME);
    let mass = or(&ANALYSED_MASS, |file| file.mass_kg);
    let damping = or(&ANALYSED_DAMPING, |file| file.damping_n_s_per_m).unwrap_or(0.0);
    let hand = or(&ANALYSED_HAND, |file| file.hand_stiffness_n_per_m).unwrap_or(0.0);
    let asked = json!({
        "mass_kg": mass,
        "damping_n_s_per_m": with_units.then_some(damping),
        "hand_stiffness_n_per_m": with_units.then_some(hand),
        "sample_time_s": sample_time_s,
        "stiffness_n_per_m": given.number(&STIFFNESS),
        "dissipation_n_s_mu_per_m": given.number(&DISSIPATION),
    });
    let (parameters, units) = if with_units {
        let mass = mass.ok_or_else(|| missing(&ANALYSED_MASS))?;
        let t = sample_time_s.ok_or_else(|| missing(&ANALYSED_SAMPLE_TIME))?;
        let device = Dynamics {
            hand_stiffness_n_per_m: hand,
            ..Dynamics::ideal(mass, damping)
        };
        let wall = Environment {
            stiffness_n_per_m: needed(&STIFFNESS)?,
            dissipation_n_s_mu_per_m: needed(&DISSIPATION)?,
            order: mu,
            sample_time_s: t,
        };
        (device.nondimensional(&wall), Some((mass, t)))
    } else {
        let without_units = Nondimensional {
            alpha: needed(&ALPHA)?,
            beta: needed(&BETA)?,
            delta: given.number(&DELTA).unwrap_or(0.0),
            gamma: given.number(&GAMMA).unwrap_or(0.0),
        };
        (without_units.checked(), None)
    };
    let parameters = parameters.map_err(analysed)?;
    let scheme = given.scheme()?;
    let sample_time = sample_time_of(scheme, sample_time_s)?;
    Ok(ResolvedLoop {
        parameters,
        order: mu,
        operator: LoopOperator::new(scheme, mu, sample_time, HORIZON).map_err(Failure::input)?,
        scheme,
        path: path(given, sample_time_s, file.as_ref())?,
        sample_time_s,
        units,
        asked,
        wall_given: [[STIFFNESS, DISSIPATION], [ALPHA, BETA]]
            .iter()
            .any(|both| both.iter().all(|parameter| given.has(parameter))),
        delta_given: given.has(&DELTA) || given.has(&ANALYSED_DAMPING) || file.is_some(),
    })
}

impl ResolvedLoop {
    pub(super) fn plant(&self) -> Result<SampledPlant, Failure> {
        let Nondimensional { delta, gamma, .. } = self.parameters;
        SampledPlant::behind(delta, gamma, self.path).map_err(Failure::input)
    }

    pub(super) fn sampled(&self) -> Result<SampledLoop<'_>, Failure> {
        let Nondimensional { alpha, beta, .. } = self.parameters;
        SampledLoop::with_plant(self.plant()?, alpha, beta, &self.operator).map_err(Failure::input)
    }

    /// Reports the loop, with the wall and device without units and the way of the force, and what was found of it.
    pub(super) fn report(
        &self,
        without_units: Value,
        found: Value,
        output: Output,
    ) -> Result<(), Failure> {
        let loop_ = json!({"order": self.order.get(), "scheme": self.scheme.to_string()});
        let path = path_result(self.path, self.sample_time_s);
        let parts = [loop_, self.asked.clone(), without_units, path, found];
        output.report(&joined(parts))
    }

    /// Stiffness and dissipation of a wall without units: K = αm/T², B = βm/T^(2−μ).
    pub(super) fn with_units(&self, alpha: Option<f64>, beta: Option<f64>) -> [Option<f64>; 2] {
        let Some((m, t)) = self.units else {
            return [None; 2];
        };
        let stiffness = alpha.map(|alpha| alpha * m / (t * t));
        [
            stiffness,
            beta.map(|beta| beta * m / t.powf(2.0 - self.order.get())),
        ]
    }

    /// The loop in words below a picture: operator and, if it is one of them, the wall; device, delay and lag in a second line.
    pub(super) fn words(&self, with_wall: bool) -> String {
        let few = |value: f64| digits(value, 4);
        let Nondimensional {
            alpha,
            beta,
            delta,
            gamma,
        } = self.parameters;
        let mut law = vec![
            format!("order μ = {}", few(self.order.get())),
            format!("scheme {}", self.scheme),
        ];
        let wall = match self.with_units(Some(alpha), Some(beta)) {
            [Some(stiffness), Some(dissipation)] => format!(
                "K = {} · B = {}",
                written("stiffness_n_per_m", stiffness),
                written("dissipation_n_s_mu_per_m", dissipation)
            ),
            _ => format!("α = {} · β = {}", few(alpha), few(beta)),
        };
        law.extend(with_wall.then_some(wall));
        let (mut device, hand) = match self.units {
            Some((mass, t)) => {
                let hand = written("hand_stiffness_n_per_m", gamma * mass / (t * t));
                let device = vec![
                    format!("m = {}", written("mass_kg", mass)),
                    format!("b = {}", written("damping_n_s_per_m", delta * mass / t)),
                    format!("T = {}", written("sample_time_s", t)),
                ];
                (device, format!("hand {hand}"))
            }
            None => (
                vec![format!("δ = {}", few(delta))],
                format!("γ = {}", few(gamma)),
            ),
        };
        device.extend((gamma > 0.0).then_some(hand));
        let time = |samples: f64| match self.sample_time_s {
            Some(t) => written("delay_s", samples * t),
            None => format!("{} samples", few(samples)),
        };
        device.push(format!("delay {}", time(self.path.delay_samples())));
        let lag = self.path.lag_samples();
        device.extend((lag > 0.0).then(|| format!("current lag {}", time(lag))));
        format!("{}\n{}", law.join(" · "), device.join(" · "))
    }
}

/// Delay and lag of a loop in samples; `sample_time_s` is its own, if it was given. What is not given is of the device file.
pub(super) fn path(
    given: &Given,
    sample_time_s: Option<f64>,
    file: Option<&DeviceValues>,
) -> Result<ForcePath, Failure> {
    let in_samples = given.number(&DELAY_SAMPLES);
    if in_samples.is_some() && given.has(&ANALYSED_DELAY) {
        return Err(Failure::bad_input(
            "the delay is given in samples and in seconds: omit --delay-samples or --delay",
        ));
    }
    let samples = |parameter: &Parameter, of_file: fn(&DeviceValues) -> f64| {
        let time_s = given.number(parameter).or(file.map(of_file)).unwrap_or(0.0);
        match sample_time_s {
            Some(t) => Ok(time_s / t),
            None if time_s == 0.0 => Ok(0.0),
            None => Err(Failure::bad_input(format_args!(
                "{parameter} {time_s} s is a time, but the loop has no units: give --sample-time"
            ))),
        }
    };
    let delay = match in_samples {
        Some(samples) => samples,
        None => samples(&ANALYSED_DELAY, |file| file.delay_s)?,
    };
    let lag = samples(&ANALYSED_LAG, |file| file.current_lag_s)?;
    ForcePath::new(delay, lag).map_err(analysed)
}

pub(super) fn path_result(path: ForcePath, sample_time_s: Option<f64>) -> Value {
    json!({
        "delay_samples": path.delay_samples(),
        "delay_s": sample_time_s.map(|t| path.delay_samples() * t),
        "current_lag_samples": path.lag_samples(),
        "current_lag_s": sample_time_s.map(|t| path.lag_samples() * t),
    })
}

pub(crate) fn decibel(magnitude: f64) -> f64 {
    20.0 * magnitude.log10()
}

/// `count` frequencies from `low` to `high`, equal steps of their logarithm.
pub(crate) fn logarithmic(low: f64, high: f64, count: usize) -> impl Iterator<Item = f64> {
    let ratio = (high / low).ln();
    let steps = count.saturating_sub(1).max(1) as f64;
    // The last is exactly `high`.
    (0..count).map(move |i| match i + 1 == count {
        true => high,
        false => low * (ratio * i as f64 / steps).exp(),
    })
}
